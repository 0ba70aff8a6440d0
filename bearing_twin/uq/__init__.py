"""Studies: what is uncertain about a scene, and what follows from it.

* `study`: `load_study`, `parse_study`, `study_names`, the dataclasses `Study` and `Settings`, the stop rule; `schema`:
  the JSON Schema of scenes and studies.
* `run`: `run_study`, its `Progress`, the memory that a study needs; `result`: `StudyResult`; `picture`: `plot_study`.
* `inputs`: numbers of a scene as distributions (`Input`, `Joint`); `distributions`: the table of those; `entropy`: the
  distribution of greatest entropy for what is known; `sampling`: points of the unit cube by the table SAMPLERS.
* `propagation`: tails and moments that exist, change of variable, interpolants, polynomial chaos.
* `realisations`: quantities and histories at given inputs; `workers`: many at once, in processes or on a Dask cluster.
* `statistics`: estimates with intervals, densities, Sobol indices; `modality`: number of modes; `histories`: statistics
  over time and the instant of least spread; `summary`: all of these as plain data, with the check of one from a log.
"""
