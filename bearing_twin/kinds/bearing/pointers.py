"""What points to the errors of a bearing run, ball by ball and output by output."""

from collections.abc import Mapping

import numpy as np

from bearing_twin.kinds.bearing.deviations import Part
from bearing_twin.kinds.bearing.pointing import OF_FORCE, OF_TORQUE, STEPS_IN
from bearing_twin.kinds.bearing.windows import LEAST_STEPS

POINTERS, SLIDING = 3, 2  # error of force, error of torque, friction over load; place of the last, which is no error


def pointers(part: Part, least: float) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """What points to errors, of force [N], torque over N, friction over N, and steps; each (balls or 1, outputs).

    Over no less than the `least` load [N]; balls that are coupled have one row.
    """
    inner, outer = np.moveaxis(part.out["normal_load"], -1, 0)
    if len(part.pointer):
        force, torque, steps = (part.pointer[:, :, place] for place in (OF_FORCE, OF_TORQUE, STEPS_IN))
    else:
        force, torque, steps = bends(part.out)
    torque = torque / np.maximum(inner + outer, least).T
    sliding = lengths(part.out["friction_force"]) / np.maximum(part.out["normal_load"], least)
    grids = force, torque, np.maximum(sliding[..., 0], sliding[..., 1]).T
    if part.partners.active:
        grids, steps = tuple(one.max(axis=0)[None] for one in grids), steps.max(axis=0)[None]
    return grids, steps


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (..., 3), to the bit those of `np.linalg.norm`, in a third of its time."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.sqrt(x * x + y * y + z * z)


def bends(out: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How much force and torque on each ball bend at each output, and steps there: what a method without errors has.

    Each (balls, outputs); a bend is the greater of the changes at both ends, LEAST_STEPS the steps.
    """
    found = []
    for array in (out["raceway_force"], out["raceway_torque"]):
        change = lengths(np.diff(array, axis=0, prepend=array[:1], append=array[-1:]))
        found.append(np.maximum(change[1:], change[:-1]).T)
    return *found, np.full(found[0].shape, float(LEAST_STEPS))
