"""Bearing runs for tests: short names for a scene with overrides, its motion, and its energies."""

import numpy as np
from runs import a_choice

from bearing_twin.charts.scenes import last_overrides
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.run.scene import load_scene

TURNED_REST = ("initial.motion=rest", "drive.offset=[0.0, -1.0e-6, 5.0e-6]")
"""A start from rest under a radial and axial offset: sliding, spin and ringing all at once."""

AXIAL_PRELOAD = 14.2229392  # N that press the inner ring 10 um along the axis
FREE = ("model.dimension=free", "rings.inner.mass=0.5", "rings.inner.free=all", "rings.inner.load=[0,0,17.07]")


def motion(*overrides, scene="bearing_6203", law="hertz", stepper="rodas4"):
    """The motion of a scene with overrides, of those of one key the last."""
    return BearingMotion(load_scene(scene, last_overrides(overrides)).parameters, a_choice(law, stepper))


def law_keys(law):
    """Overrides for a law; a linear spring with about the stiffness of the others."""
    return (f"contact.normal={law}", *(("contact.stiffness=2e7",) if law == "linear" else ()))


def stored_energy(out):
    """Kinetic, elastic and potential energy [J] of each output."""
    return out.kinetic_energy + out.elastic_energy + out.potential_energy


def run(*overrides, count=40, period=5e-5, **names):
    """Outputs of one chunk of `count` instants `period` [s] apart, with the motion they came from."""
    moving = motion(*overrides, **names)
    return moving, advanced(moving, period, count)


def advanced(moving, period, count):
    """Outputs of the next `count` instants `period` [s] apart."""
    times = period * np.arange(1, count + 1)
    return moving.advance(times, times[-1])


def errors(moving, actual, exact):
    """Greatest errors of load, over the greatest, and of friction, over mu N of a contact or mu N R of a ball."""
    coefficient, radius = moving.parameters.contact.friction_coefficient, moving.bearing.ball_radius
    greatest = exact.normal_load.max()
    load = np.abs(actual.normal_load - exact.normal_load).max() / greatest
    force = np.linalg.norm(actual.friction_force - exact.friction_force, axis=-1)
    torque = np.linalg.norm(actual.raceway_torque - exact.raceway_torque, axis=-1) / radius
    friction = max(
        (force / np.maximum(exact.normal_load, 0.01 * greatest)).max(),
        (torque / np.maximum(exact.normal_load.sum(axis=-1), 0.01 * greatest)).max(),
    )
    return float(load), float(friction) / coefficient
