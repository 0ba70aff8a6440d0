"""The exact Jacobian of the raceways' answer against differences, and the block solver against a dense one."""

import numpy as np
import pytest
from bearings import asking, motion

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.names import law_names
from bearing_twin.kinds.bearing.jacobian import lane_jacobian
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    COLUMNS,
    JACOBIAN,
    JACOBIAN_END,
    LANE_RATES,
    LANES,
    MOTION,
    RING_SPEED,
    into_lane,
    put,
)
from bearing_twin.kinds.bearing.parameters import GIVES
from bearing_twin.kinds.bearing.rates import lane_rates
from bearing_twin.numerics.block_solve import Linear, factorise_body, solve_body

TILTED = ("drive.offset=[4.0e-6, -9.0e-6, 5.0e-6]", "gravity=[3.0, -9.8, 1.0]", "contact.damping=0.3")
UNITS = np.array([1e-6, 1e-4, 1e-6, *(1e-2,) * 3, *(3.0,) * 3])


def lanes_of(moving, seed):
    """Eight balls in lanes, each sliding, spinning, orbiting and pressed somewhat differently."""
    rng = np.random.default_rng(seed)
    lanes = np.zeros(JACOBIAN_END * LANES)
    for k in range(LANES):
        row = moving.state[k].copy()
        row[:MOTION] += UNITS * rng.uniform(-1.0, 1.0, MOTION)
        into_lane(row[:MOTION], lanes, AXIS_DISTANCE, k)
        put(lanes, RING_SPEED, k, rng.uniform(-200.0, 200.0))
    return lanes


def rates(bearing, lanes, column, nudge):
    moved = lanes.copy()
    moved[column * LANES : (column + 1) * LANES] += nudge
    lane_rates(bearing, moved)
    return moved[LANE_RATES * LANES : (LANE_RATES + COLUMNS) * LANES].reshape(COLUMNS, LANES).copy()


CASES = [
    *((law, "point") for law in law_names("point", GIVES)),
    *(("hertz", row) for row in FRICTIONS if row != "point"),
]


@pytest.mark.parametrize(("law", "friction"), CASES)
@pytest.mark.parametrize("scene", ["bearing_6203", "bearing_6203_loose"])
def test_every_entry_is_the_derivative(scene, law, friction):
    """Against central differences; the loose scene has balls out of contact. With spots the entries are differences."""
    moving = motion(*TILTED, f"contact.friction={friction}", *asking(law), scene=scene, law=law)
    check_entries(moving.bearing, lanes_of(moving, 4), 3e-6 if friction == "point" else 3e-5)


@pytest.mark.parametrize("power", [1.2, 2.0])
def test_a_law_of_any_power_has_its_derivative(power):
    """No shipped row has one: the load over the approach is handed to the lanes at each evaluation."""
    moving = motion(*TILTED, scene="bearing_6203_loose", law="hertz_exact")
    lanes, raceways = lanes_of(moving, 4), []
    for raceway in (moving.bearing.inner, moving.bearing.outer):
        law = raceway.law._replace(power=power, modulus=raceway.law.modulus * 1e-6 ** (1.5 - power))
        raceways.append(raceway._replace(law=law))
    check_entries(moving.bearing._replace(inner=raceways[0], outer=raceways[1]), lanes, 3e-6)


def check_entries(bearing, lanes, close):
    """The Jacobian of the lanes against central differences of the rates."""
    lane_rates(bearing, lanes)
    lane_jacobian(bearing.spot, bearing, lanes)
    found = lanes[JACOBIAN * LANES :].reshape(COLUMNS, MOTION, LANES)
    for column in range(MOTION):

        def slope(step, column=column):
            nudge = step * UNITS[column]
            ahead, behind = (rates(bearing, lanes, column, sign * nudge) for sign in (1.0, -1.0))
            return (ahead - behind) / (2.0 * nudge)

        # The size of a row's answers to whatever column, each in its unit: what an entry can matter against.
        size = np.abs(found * UNITS[None, :, None]).max(axis=1) / UNITS[column]
        assert np.all(np.abs(slope(1e-4) - found[:, column]) <= close * size)


def test_the_block_solver_agrees_with_a_dense_one():
    rng = np.random.default_rng(3)
    for g in (1e-3, 0.1, 3.0):
        blocks = {name: tuple(map(tuple, rng.normal(size=(3, 3)))) for name in ("vp", "vs", "sp", "sv")}
        resisting = {name: tuple(map(tuple, rng.normal(size=(3, 3)) - 8.0 * np.eye(3))) for name in ("vv", "ss")}
        linear = Linear(angle_by_radius=0.7, angle_by_velocity=-0.4, **blocks, **resisting)
        jacobian = np.zeros((9, 9))
        jacobian[0, 3] = jacobian[2, 5] = 1.0
        jacobian[1, 0], jacobian[1, 4] = 0.7, -0.4
        for row, letter in ((3, "v"), (6, "s")):
            for column, other in ((0, "p"), (3, "v"), (6, "s")):
                jacobian[row : row + 3, column : column + 3] = getattr(linear, letter + other)
        right = rng.normal(size=9)
        expected = np.linalg.solve(np.eye(9) / g - jacobian, right)
        parts = [tuple(right[i : i + 3]) for i in (0, 3, 6)]
        assert np.ravel(solve_body(linear, factorise_body(linear, g), g, *parts)) == pytest.approx(expected, rel=1e-10)
