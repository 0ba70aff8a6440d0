"""Outputs of a bearing by the compiled core (`core/bearing/outputs.cpp`): rows of all channels."""

import numpy as np

from bearing_twin.core import INTEGER, INTEGERS, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.compiled_balls import numbers_of
from bearing_twin.kinds.bearing.compiled_coupled import numbers_of_bodies

NOTHING = np.zeros(0)
_outputs = Function(
    "core_outputs",
    None,
    (
        *(REALS, REALS, REALS, INTEGER, INTEGER, REALS, REALS, REALS),
        *(INTEGER, REALS, REALS, REALS, REALS, REAL, INTEGERS, REALS_OUT),
    ),
)


def write_rows(bearing, partners, drive, rolling, times, states, orientations, borders, places, out) -> None:
    """Fills rows of all channels with the motion at `times` (count,) [s], which count from the drive's instant.

    `states` (count, N, COLUMNS) and orientations (count, N, 4) are the balls', `borders` (count, BORDER) those of ring,
    cage and shaft, the `partners`; `rolling` is the speed of balls that roll, over the ring's. `places` are the numbers
    of RowPlaces, `out` is (count, columns).
    """
    coupled = bool(partners.active or bearing.ring)
    bodies = numbers_of_bodies(bearing, partners) if coupled else NOTHING
    _outputs(
        *(*numbers_of(bearing), np.array(drive, float), *states.shape[:2], times, states, orientations),
        *(coupled, bodies, partners.load, partners.load_rate, borders, rolling, places, out),
    )
