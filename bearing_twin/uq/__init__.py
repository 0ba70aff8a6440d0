"""Studies: uncertain numbers of a scene, and what follows from them.

* `study`: studies as they are found, read and checked.
* `run`: `run_study` with its `Progress`; `memory_needed`, and `refuse_too_large`, before it runs.
* `result`: the result of a study, its table, and sentences on it.
* `inputs`: `numeric_keys` of scenes, of which `value_at` reads one and `put` changes one; `quantities_of` a kind.
* `distributions`: the table of distributions, and that of greatest entropy.
* `sampling`: the table of `SAMPLERS`.
* `propagation`: a distribution by change of variable, `Derived`.
* `realisations`: what is realised (`task_of` a study), and `exact_distributions` of its quantities.
* `statistics`: `histogram`, `kernel_density` and `modality` of a sample.

Private is `workers`: realisations by processes or Dask.
"""
