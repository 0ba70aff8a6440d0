"""Exact Jacobians, of raceways' answers and of balls that touch, against differences; linear systems against dense."""

import numpy as np
import pytest
from bearings import asking, motion
from ring_systems import with_gross_work

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.names import law_names
from bearing_twin.kinds.bearing.forces.equations import RingDrive
from bearing_twin.kinds.bearing.forces.jacobian import rates_and_jacobian
from bearing_twin.kinds.bearing.forces.layout import (
    AHEAD_BY_OWN,
    AXIS_DISTANCE,
    BORDER,
    DISSIPATED,
    DRIVE_WORK,
    JACOBIAN,
    JACOBIAN_END,
    LINEARISED,
    MANY,
    MOTION,
    OWN_BY_AHEAD,
    POWER_SIGN,
    RING_SPEED,
    ROSENBROCK_ROWS,
    SPOTS,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.pairs import add_answers, add_pairs
from bearing_twin.kinds.bearing.forces.rates import bearing_rates, lane_rates
from bearing_twin.kinds.bearing.parameters import GIVES
from bearing_twin.kinds.bearing.stepping.linear_system import factorise_together, new_coupling, solve_together
from bearing_twin.numerics.lanes import (
    COLUMNS,
    GAIN,
    LANE_RATES,
    LANES,
    RIGHT,
    SOLUTION,
    from_blocks,
    into_blocks,
    into_lane,
    new_blocks,
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


def touching(count, closed):
    """Balls that touch their neighbours, sliding and spinning, all around the circle or in a row; and who may touch."""
    pitch = float(6.746e-3 / np.sin(np.pi / count) * (1.0 + 1e-9))
    moving = motion(*TILTED, f"geometry.balls={count}", f"geometry.pitch_diameter={pitch!r}")
    rng = np.random.default_rng(8)
    state = moving.state.copy()
    state[:, AXIS_DISTANCE] = 0.5 * pitch - 4e-6
    state[:, :MOTION] += UNITS * rng.uniform(-0.3, 0.3, (count, MOTION))
    near = np.full(count, True)
    near[count - 1] = closed
    return moving.bearing, state, near


def coupled(bearing, state, near, drive):
    """Balls in blocks of lanes with their rates and Jacobians, coupled."""
    balls, partners = np.arange(len(state)), motion()._partners()  # of a bearing without cage, its ring held
    coupling, blocks = new_coupling(near, balls, partners, np.zeros(BORDER)), new_blocks(len(state), ROSENBROCK_ROWS)
    into_blocks(state, blocks, AXIS_DISTANCE)
    for lanes in blocks:
        for k in range(LANES):
            put(lanes, RING_SPEED, k, drive.speed)
        rates_and_jacobian(bearing.spot, bearing, lanes)
    add_pairs(bearing, coupling.pairs, blocks, blocks, LANE_RATES)
    add_answers(bearing, coupling.pairs, blocks)
    return coupling, blocks


def whole(coupling, blocks, count):
    """The Jacobian of all rates by all motions, (balls, COLUMNS, balls, MOTION)."""

    def matrix(array, row, rows):
        return array[row * LANES : (row + rows * MOTION) * LANES].reshape(rows, MOTION, LANES)

    jacobian = np.zeros((count, COLUMNS, count, MOTION))
    for i in range(count):
        lanes, pair, k, j = blocks[i // LANES], coupling.pairs.blocks[i // LANES], i % LANES, (i + 1) % count
        jacobian[i, :, i] += jacobian_in(lanes)[..., k]
        jacobian[i, VELOCITY : DISSIPATED + 1, j] += matrix(pair, OWN_BY_AHEAD, 8)[..., k]
        jacobian[j, VELOCITY:MOTION, i] += matrix(pair, AHEAD_BY_OWN, 6)[..., k]
    return jacobian


@pytest.mark.parametrize(("count", "closed"), [(13, True), (8, True), (13, False), (9, False)])
def test_what_touching_balls_answer_is_the_derivative_and_solved_as_a_dense_system(count, closed):
    """Every entry against central differences of the rates of all balls, and (1/g - J) x = right against LU factors."""
    bearing, state, near = touching(count, closed)
    drive = RingDrive(0.0, 300.0, 0.0)
    coupling, blocks = coupled(bearing, state, near, drive)
    found = whole(coupling, blocks, count)
    apart = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    neighbours = (apart == 1) | (closed & (apart == count - 1))
    assert np.array_equal(np.abs(found).max(axis=(1, 3)) > 0.0, neighbours | (apart == 0))
    size = np.abs(found * UNITS).max(axis=(2, 3))  # of a row's answers, each in its unit
    for ball in range(count):
        for column in range(MOTION):
            rates = []
            for sign in (1.0, -1.0):
                moved, out = state.copy(), np.zeros_like(state)
                moved[ball, column] += sign * 1e-4 * UNITS[column]
                bearing_rates(bearing, drive, near, 0.0, moved, out)
                rates.append(out)
            slope = (rates[0] - rates[1]) / 2e-4
            assert np.all(np.abs(slope - found[:, :, ball, column] * UNITS[column]) <= 3e-6 * size), (ball, column)

    rng, g = np.random.default_rng(2), 2e-6
    right = rng.uniform(-1.0, 1.0, (count, COLUMNS)) * np.array([*UNITS, 1.0, 1.0, 1.0])
    into_blocks(right, blocks, RIGHT)
    for lanes in blocks:
        lanes[GAIN * LANES : (GAIN + 1) * LANES] = g
    factorise_together(coupling, blocks)
    solve_together(drive, 0.0, coupling, blocks)
    solved = np.zeros((count, COLUMNS))
    from_blocks(blocks, SOLUTION, solved)
    size, wanted = count * MOTION, right[:, :MOTION].ravel()
    matrix = np.eye(size) / g - found[:, :MOTION].reshape(size, size)
    expected = np.linalg.solve(matrix, wanted)
    for _ in range(3):  # the units differ so much that a dense solution wants residuals of more digits
        expected += np.linalg.solve(matrix, (wanted - matrix.astype(np.longdouble) @ expected).astype(float))
    expected = expected.reshape(count, MOTION)
    off = np.abs(solved[:, :MOTION] - expected).max(axis=0)
    assert np.all(off < 1e-11 * np.abs(expected).max(axis=0))
    listening = g * (right[:, MOTION:] + np.einsum("irjc,jc->ir", found[:, MOTION:], expected))
    assert solved[:, MOTION:] == pytest.approx(listening, rel=1e-6)
