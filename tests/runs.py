"""Whole runs for tests: their reports."""

from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate


def reported(scene, *overrides):
    """The report of a whole run."""
    run = simulate(load_scene(scene, overrides))
    for _ in run.blocks():
        pass
    return run.report
