"""Bearing runs for tests: short names for a scene with overrides, its motion, and its energies."""

import os
import pickle
import subprocess
import sys

import numpy as np
from made_up_run import a_choice

from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.run.scene import load_scene

TURNED_REST = ("initial.motion=rest", "drive.offset=[0.0, -1.0e-6, 5.0e-6]")
"""A start from rest under a radial and axial offset: sliding, spin and ringing all at once."""


def motion(*overrides, scene="bearing_6203", law="hertz", stepper="rodas4"):
    """The motion of a scene with overrides."""
    return BearingMotion(load_scene(scene, overrides).parameters, a_choice(law, stepper))


def asking(law):
    """Overrides that ask for a law; a linear spring with about the stiffness of the others."""
    return (f"contact.normal={law}", *(("contact.stiffness=2e7",) if law == "linear" else ()))


def stored_energy(out):
    """Kinetic, elastic and potential energy [J] of each output."""
    return out.kinetic_energy + out.elastic_energy + out.potential_energy


def run(*overrides, count=40, period=5e-5, **names):
    """Outputs of one chunk of `count` instants `period` [s] apart, with the motion they came from."""
    moving = motion(*overrides, **names)
    times = period * np.arange(1, count + 1)
    return moving, moving.advance(times, times[-1])


def flat(out):
    """All numbers of an `Outputs` in one array."""
    return np.concatenate([np.asarray(array).ravel() for array in out])


def without_compiling(module, function, cases):
    """{case: `function`(*case)} of a test module, by a process in which nothing is compiled."""
    script = (
        f"import pickle, sys\nfrom {module} import {function}\n"
        f"pickle.dump({{case: {function}(*case) for case in {cases!r}}}, sys.stdout.buffer)"
    )
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", script], env=environment, stdout=subprocess.PIPE, check=True)
    return pickle.loads(done.stdout)
