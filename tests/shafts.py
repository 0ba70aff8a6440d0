"""Shafts on two bearings, for tests: their motions, outputs and books."""

import numpy as np

from bearing_twin.kinds import KINDS
from bearing_twin.run.scene import choose, load_scene


def parameters_of(*changes, scene="shaft_two_6203"):
    return load_scene(scene, changes).parameters


def motion_of(*changes, scene="shaft_two_6203", share=1.0):
    loaded = load_scene(scene, (*changes, "solver.check=none"))
    tolerance = f"wanted.tolerance={share * loaded.parameters.wanted.tolerance}"
    return KINDS["shaft"].motion(load_scene(loaded.resolved(), (tolerance,)).parameters, choose(loaded))


def outputs_of(motion, duration, count):
    """The outputs at even times up to `duration` [s], with the first."""
    first = {name: np.array(values) for name, values in motion.first_outputs().items()}
    times = duration * np.arange(1, count + 1) / count
    later = motion.advance(times, duration)
    return np.append(0.0, times), {name: np.concatenate([first[name], later[name]]) for name in first}


def energy(out):
    """What the shaft has, less what it was given, plus what it gave (n,), and the size of all that."""
    names = ("kinetic_energy", "potential_energy", "bearing_work", "dissipated")
    return sum(out[name] for name in names) - out["load_work"], out["gross_work"][-1]
