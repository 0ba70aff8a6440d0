"""Exact Jacobians, of raceways' answers and of balls that touch, against differences; linear systems against dense."""

import numpy as np
import pytest
from bearings import asking, motion
from ring_systems import with_gross_work

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.names import law_names
from bearing_twin.kinds.bearing.forces.jacobian import rates_and_jacobian
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    DRIVE_WORK,
    JACOBIAN,
    JACOBIAN_END,
    LINEARISED,
    MANY,
    MOTION,
    POWER_SIGN,
    RING_SPEED,
    SPOTS,
)
from bearing_twin.kinds.bearing.forces.rates import lane_rates
from bearing_twin.kinds.bearing.parameters import GIVES
from bearing_twin.numerics.lanes import (
    COLUMNS,
    LANE_RATES,
    LANES,
    into_lane,
    put,
)

TILTED = ("drive.offset=[4.0e-6, -9.0e-6, 5.0e-6]", "gravity=[3.0, -9.8, 1.0]", "contact.damping=0.3")
UNITS = np.array([1e-6, 1e-4, 1e-6, *(1e-2,) * 3, *(3.0,) * 3])


def lanes_of(moving, seed, first=0):
    """Balls from `first` on in lanes, each sliding, spinning, orbiting and pressed somewhat differently."""
    rng = np.random.default_rng(seed)
    lanes = np.zeros(JACOBIAN_END * LANES)
    for k in range(LANES):
        row = moving.state[first + k].copy()
        row[:MOTION] += UNITS * rng.uniform(-1.0, 1.0, MOTION)
        into_lane(row[:MOTION], lanes, AXIS_DISTANCE, k)
        put(lanes, RING_SPEED, k, rng.uniform(-200.0, 200.0))
    return lanes


def rates(bearing, lanes, column, nudge):
    moved = lanes.copy()
    moved[column * LANES : (column + 1) * LANES] += nudge
    lane_rates(bearing, moved)
    return moved[LANE_RATES * LANES : (LANE_RATES + COLUMNS) * LANES].reshape(COLUMNS, LANES).copy()


def jacobian_in(lanes):
    """The Jacobians (COLUMNS, MOTION, LANES) that stand in lanes."""
    rows = lanes[JACOBIAN * LANES :][: LINEARISED * MOTION * LANES].reshape(LINEARISED, MOTION, LANES)
    found = with_gross_work(np.moveaxis(rows, -1, 0), lanes[POWER_SIGN * LANES :][:LANES, None, None], DRIVE_WORK)
    return np.moveaxis(found, 0, -1)


CASES = [
    *((law, "point") for law in law_names("point", GIVES)),
    *(("hertz", row) for row in FRICTIONS if row != "point"),
    *((law, "spot") for law in law_names("point", GIVES) if law != "hertz"),
]


@pytest.mark.parametrize(("law", "friction"), CASES)
@pytest.mark.parametrize("scene", ["bearing_6203", "bearing_6203_loose"])
def test_every_entry_is_the_derivative(scene, law, friction):
    """Against central differences; the loose scene has balls out of contact. Spots take few points, many, and both."""
    moving = motion(*TILTED, f"contact.friction={friction}", *asking(law), scene=scene, law=law)
    rng, many = np.random.default_rng(4), []
    for first in range(0, len(moving.state), LANES):
        lanes = lanes_of(moving, rng, first)
        check_entries(moving.bearing, lanes, 3e-6)
        many.extend(lanes[MANY * LANES :][:SPOTS])
    if friction == "spot":
        many = np.array(many)
        assert many.min() == 0.0
        assert np.any((many > 0.0) & (many < 1.0))
        assert many.max() == 1.0 or scene == "bearing_6203_loose"


def check_entries(bearing, lanes, close):
    """The Jacobian of the lanes against central differences of the rates."""
    rates_and_jacobian(bearing.spot, bearing, lanes)
    found = jacobian_in(lanes)
    together, alone = lanes[LANE_RATES * LANES :][: COLUMNS * LANES], rates(bearing, lanes, 0, 0.0).ravel()
    assert np.all(np.abs(together - alone) <= 1e-12 * np.abs(alone).max())  # both write the same rates
    for column in range(MOTION):

        def slope(step, column=column):
            nudge = step * UNITS[column]
            ahead, behind = (rates(bearing, lanes, column, sign * nudge) for sign in (1.0, -1.0))
            return (ahead - behind) / (2.0 * nudge)

        # The size of a row's answers to whatever column, each in its unit: what an entry can matter against.
        size = np.abs(found * UNITS[None, :, None]).max(axis=1) / UNITS[column]
        assert np.all(np.abs(slope(1e-4) - found[:, column]) <= close * size)
