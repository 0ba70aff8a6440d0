"""An ellipsoid on a plane as the core takes it (`core/bodies/ellipsoid.cpp`): numbers in, motion and outputs back."""

import numpy as np

from bearing_twin.contact.patch_friction import patch_by
from bearing_twin.core import REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bouncing import CoreBodies, advancing, giving_outputs

COLUMNS = 18
"""Of the state, EllipsoidState of the core."""

CLOCK = 5
IN_CONTACT, DRIFT = 2, 3
"""Of EllipsoidClock, beside those of `bouncing`: whether in contact, greatest drift of the quaternion's norm."""

FIXED = 2
"""Of EllipsoidPlan: the step of rk4 in contact [s], else 0."""

RECORD = 20
BEGAN = 1
RECORDED = (0, 1, 2, 3, 4, 5, 6, 10, 11, 13, 14, 12, 16)
"""Of ContactRecord: begin of the contact [s]; what is given out of one that has ended, as in `figures.CONTACT`."""
EARLIER = (1, 0, 2, 3, 4, 5, 6, 10, 11, 13, 14, 12, 16, 17, 18, 19)
"""Where the numbers stand that earlier snapshots have of a contact."""

_start = Function("core_ellipsoid_start", None, (REALS, REALS, REAL, REALS_OUT))
advance = advancing("core_ellipsoid_advance")
write_outputs = giving_outputs("core_ellipsoid_outputs")


def ellipsoid_numbers(semi_axes, mass: float, inertia, gravity: float, law, contact, friction: str) -> CoreBodies:
    """An ellipsoid with an elastic law and what `bouncing.contact_numbers` gives of the contact; SI."""
    patch, points = patch_by(friction, contact["friction"])
    numbers = [
        *(mass, *inertia, *semi_axes, gravity, contact["sink"], *law),
        *(*contact["damping"], contact["regularisation"], *patch),
    ]
    return CoreBodies(np.array(numbers, float), points)


def plan_numbers(rk4: bool, tolerance: float, fixed: float, semi_axes, floor: float) -> np.ndarray:
    """The numbers of an EllipsoidPlan: fixed step of rk4 in contact and shortest step in s."""
    low, high = min(semi_axes), max(semi_axes)
    spread, lean = high * high / low - low * low / high, (high * high - low * low) / (2.0 * low)
    return np.array([rk4, tolerance, fixed, spread, lean, floor], float)


def record_of(numbers: np.ndarray) -> np.ndarray:
    """The record of a contact from those of a snapshot, this version's or an earlier one's."""
    if len(numbers) != len(EARLIER):
        return numbers
    record = np.zeros(RECORD)
    record[list(EARLIER)] = numbers
    record[15] = record[12]  # both hold the vertical speed at the touch
    return record


def start_state(body: CoreBodies, height: float, orientation, velocity, angular_velocity) -> np.ndarray:
    """The state (COLUMNS,) of an ellipsoid whose lowest point is `height` [m] above the plane; SI, fixed axes."""
    state = np.zeros(COLUMNS)
    state[3:7], state[7:10], state[10:13] = orientation, velocity, angular_velocity
    _start(*body, height, state)
    return state
