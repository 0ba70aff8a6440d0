"""Studies: uncertain numbers of a scene, and what follows from them.

Others import

* `study`: `load_study`, `parse_study`, `study_names`; the dataclasses `Study` and `Settings`.
* `run`: `run_study` with its `Progress`; `memory_needed` and `refuse_too_large`, the memory of a study before it runs.
* `result`: `StudyResult` with its table, what is shown of a summary (`warnings_of`, `refusals`, `shares_of`,
  `SweepDescription`, `model_error_sentences`).
* `inputs`: `numeric_keys` and `quantities_of` a kind of scene; inputs as distributions (`read_input`, `Joint`).
* `propagation`, `realisations`: distributions by change of variable, for pictures (`derive`, `exact_distributions`).
* `statistics`: `histogram`, `kernel_density`, `modality` of a sample.

Inside the room: `distributions` with maximum entropy, `sampling` (points of the unit cube), `workers` (processes,
Dask).
"""
