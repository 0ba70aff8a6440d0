"""The ground floor: what every room may use.

* `errors`: exceptions of the package, optional packages, words of error messages.
* `units`: SI units and those that people read.
* `parameters`: keys of scenes as dataclass fields.
* `sample`: channels, blocks and samples of solver outputs.
* `report`: the report on a run, and JSON.
* `paths`: shared files and files written whole.
* `yaml_files`: YAML read strictly.
* `process`: standard streams, processors, signals as exceptions.
* `stopping`: ending computations.
"""
