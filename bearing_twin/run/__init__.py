"""Scenes in, samples and reports out.

* `scene`: `load_scene`, `parse_scene`, `Scene`; `choose`: elastic law and stepper of a scene.
* `simulation`: `simulate` gives a `Run`; `Simulation` is advanced by hand and takes commands; `cost_of`: its size.
* `second_run`: a finer run beside the first, whose difference is the error estimate of the method.
* `report`: `report_of` a log, `ReportBuilder` of blocks, errors in words; `plot`: the picture of a run.
* `failure`: numbers that no motion can have, what a failed run leaves in a file, and going on from it.
* `verify`: a log against a fresh simulation; `dataset`: a run or a log as an `xarray.Dataset`.
"""
