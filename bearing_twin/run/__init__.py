"""Scenes in, samples and reports out.

* `scene`: scenes as they are found, read, changed and checked, and the choice of their models.
* `simulation`: `simulate` gives a `Run`; a `Simulation` is advanced by hand and takes commands; `cost_of` a run.
* `equilibrium`: the equilibrium of a bearing, or of many.
* `second_run`: a finer run beside the first (`has_second_run`), whose `Differences`, at outputs the `difference`, are
  the error estimate of the method.
* `report`: the report on a run from its blocks, its errors in words, and its picture.
* `failure`: numbers that no motion can have, what a failed run leaves in a file, and going on from it.
* `verify`: a log against a fresh simulation: `verify`.
* `dataset`: a run or a log as an `xarray.Dataset`.
"""
