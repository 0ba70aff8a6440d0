"""Scenes in, samples and reports out.

* `scene`: scenes as they are found, read, changed and checked, and the choice of their models.
* `simulation`: runs, simulations that are advanced by hand and take commands, and their cost.
* `equilibrium`: the equilibrium of a bearing, or of many.
* `second_run`: a finer run beside the first, whose difference is the error estimate of the method.
* `report`: the report on a run from its blocks, its errors in words, and its picture.
* `failure`: numbers that no motion can have, what a failed run leaves in a file, and going on from it.
* `verify`: a log against a fresh simulation.
* `dataset`: a run or a log as an `xarray.Dataset`.
"""
