"""Orders of the bearing's methods, and the derivatives that they need, against differences."""

import math

import numpy as np
import pytest
from bearings import asking, motion
from ring_systems import AXIAL_PRELOAD, BALL, CASES, FREE, System, disturbed, with_gross_work

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.names import law_names
from bearing_twin.kinds.bearing.forces.equations import RingDrive
from bearing_twin.kinds.bearing.forces.jacobian import rates_and_jacobian
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BORDER,
    DRIVE_WORK,
    JACOBIAN,
    JACOBIAN_END,
    LINEARISED,
    MANY,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    POWER_SIGN,
    RING_SPEED,
    SPOTS,
    TANGENTIAL_VELOCITY,
    VELOCITY,
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
from bearing_twin.numerics.steppers import STEPPER_FACTS

SPAN = 4.8e-5
ACCELERATED = (
    "drive.acceleration=1e6", "contact.friction_regularisation=0.3", "drive.offset=[2.0e-6, -1.0e-6, 5.0e-6]",
)  # fmt: skip
# Thirteen balls that fill the circle, pressed so far outwards and inwards that each touches both neighbours for good.
FULL = (
    "geometry.balls=13", f"geometry.pitch_diameter={6.746e-3 / math.sin(math.pi / 13) * (1.0 + 1e-9)!r}",
    "geometry.radial_clearance=-40e-6",
)  # fmt: skip


def after(start, overrides, stepper, step):
    """Outputs after SPAN by equal steps [s] from a state and orientation, the ring speeding up all the while."""
    moving = motion(*ACCELERATED, *overrides, stepper=stepper)
    moving.state[:], moving.orientation[:] = start
    moving.goal_speed = 1e4
    moving.scales, moving.step = np.full_like(moving.scales, np.inf), step
    moving.advance(np.array([]), 1e-9)  # where the acceleration begins, steppers begin with a short step
    steps = round(SPAN / step)
    for _ in range(steps):
        moving.steps[:] = 1.0
        out = moving.advance(np.array([step]), step)
    assert moving.costs()["ball_steps"] == (steps + 1) * len(moving.state)
    assert moving.costs()["ball_rejections"] == 0
    return {name: getattr(out, name)[0] for name in ("velocity", "slip", "raceway_torque", "normal_load")}


def errors(start, overrides, stepper, step, exact):
    """Error of velocity, slip, friction torque and normal load, each over its greatest value."""
    found = after(start, overrides, stepper, step)
    return np.array([np.abs(found[name] - exact[name]).max() / np.abs(exact[name]).max() for name in exact])


def settled(overrides, seconds, kick=0.0):
    """A state in rolling contact, its contacts set ringing by a `kick` [m/s] or not, and the outputs SPAN later."""
    moving = motion(*ACCELERATED, *overrides)
    moving.advance(np.array([]), seconds)
    balls = np.arange(len(moving.state))
    moving.state[:, VELOCITY] += kick * np.cos(2.4 * balls)
    moving.state[:, VELOCITY + 2] += kick * np.cos(1.1 * balls)
    start = moving.state.copy(), moving.orientation.copy()
    return start, after(start, overrides, "rk4", 2e-8)


@pytest.fixture(scope="module")
def rolling():
    """Eight balls apart, at ease and ringing."""
    return settled((), 5e-3), settled((), 5e-3, 0.03)


@pytest.fixture(scope="module")
def pressed():
    """Thirteen balls, each touching both neighbours, at ease and ringing."""
    return settled(FULL, 3e-3), settled(FULL, 2e-3, 0.03)


def orders(case, overrides, stepper, step):
    """Observed order of velocity, slip, friction torque and normal load between `step` [s] and half of it."""
    start, exact = case
    coarse, fine = (errors(start, overrides, stepper, h, exact) for h in (step, 0.5 * step))
    assert np.all(coarse < 1e-3)
    return np.log2(coarse / fine)


@pytest.mark.parametrize(
    ("stepper", "step"),
    [("rodas4", 4e-6), ("rodas4_landing", 4e-6), ("rodas3", 2e-6), ("rk4", 1e-6), ("dopri5", 1e-6), ("imex", 1e-6)],
)
def test_ringing_balls_have_the_order_of_their_method(rolling, stepper, step):
    assert orders(rolling[1], (), stepper, step) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


@pytest.mark.parametrize(("stepper", "step"), [("rodas4", 4e-6), ("rodas3", 2e-6)])
def test_balls_at_ease_follow_the_ring_with_the_order_of_their_method(rolling, stepper, step):
    """What is left of the errors, down to 1e-9, comes from the ring's speed: from the explicit time term above all."""
    assert orders(rolling[0], (), stepper, step) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


@pytest.mark.parametrize(
    ("stepper", "step"), [("rodas4", 4e-6), ("rodas3", 2e-6), ("rk4", 1e-6), ("dopri5", 1e-6), ("imex", 1e-6)]
)
def test_touching_balls_have_the_order_of_their_method(pressed, stepper, step):
    assert orders(pressed[1], FULL, stepper, step) == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.5)


@pytest.mark.parametrize(("stepper", "step", "halvings"), [("rodas4", 8e-6, 3), ("rodas3", 4e-6, 2)])
def test_touching_balls_at_ease_follow_the_ring_with_the_order_of_their_method(pressed, stepper, step, halvings):
    """Over so many halvings, as errors of slip and torque change sign on the way.

    No further: a start that differs by 1e-13 changes the torque's error, when rodas3 takes steps of 0.5 us, by half.
    """
    start, exact = pressed[0]
    coarse, fine = (errors(start, FULL, stepper, h, exact) for h in (step, step / 2**halvings))
    assert np.log2(coarse / fine) / halvings == pytest.approx(STEPPER_FACTS[stepper].order, abs=0.7)


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


LAWS_AND_FRICTIONS = [
    *((law, "point") for law in law_names("point", GIVES)),
    *(("hertz", row) for row in FRICTIONS if row != "point"),
    *((law, "spot") for law in law_names("point", GIVES) if law != "hertz"),
]


@pytest.mark.parametrize(("law", "friction"), LAWS_AND_FRICTIONS)
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


@pytest.mark.parametrize("name", CASES)
def test_every_entry_is_the_derivative_of_a_ring_too(name):
    """Against central differences; of an even cage along what it leaves free."""
    system = disturbed(name)
    state, border, even = system.state, system.border, system.partners.even
    by_ball, by_border, reacting, corner = system.jacobian()
    slaves = (ORBIT_ANGLE, TANGENTIAL_VELOCITY)
    kept = [i for i in range(COLUMNS) if not (even and i in slaves)]
    wanted = [i for i in range(VELOCITY, COLUMNS) if not (even and i in slaves)]
    size_of_ball = np.maximum(
        np.abs(by_ball * BALL).max(axis=(0, 2)), np.r_[np.zeros(3), np.abs(by_border * system.ring).max(axis=(0, 2))]
    )
    size_of_border = (
        np.maximum(np.abs(reacting * BALL).max(axis=(0, 2)), np.abs(corner * system.ring).max(axis=1)) + 1e-300
    )
    step = 1e-4

    def slope(ball, column, unit):
        found = []
        for sign in (1.0, -1.0):
            moved, shifted = state.copy(), border.copy()
            if ball is None:
                shifted[column] += sign * step * unit
            else:
                moved[ball, column] += sign * step * unit
            found.append(system.rates(moved, shifted))
        return [(one - other) / (2.0 * step) for one, other in zip(*found, strict=True)]

    for ball in (0, 3, 6):
        for column in range(MOTION):
            if even and column in slaves:
                continue
            balls, own = slope(ball, column, BALL[column])
            off = np.abs(balls[ball] - by_ball[ball, :, column] * BALL[column])
            assert np.all(off[kept] <= 1e-5 * size_of_ball[kept]), (ball, column)
            off = np.abs(own[PLACES : 2 * PLACES] - reacting[ball, :, column] * BALL[column])
            assert np.all(off <= 1e-5 * size_of_border), (ball, column)
    for column in np.flatnonzero(np.tile(system.partners.free, 2)):
        balls, own = slope(None, column, system.ring[column])
        off = np.abs(balls[:, wanted] - by_border[:, np.array(wanted) - VELOCITY, column] * system.ring[column])
        assert np.all(off <= 1e-5 * size_of_ball[wanted]), column
        off = np.abs(own[PLACES : 2 * PLACES] - corner[:, column] * system.ring[column])
        assert np.all(off <= 1e-5 * size_of_border), column


def whole(system):
    """The Jacobian of all motions in one matrix, balls first, then places and velocities of the border."""
    by_ball, by_border, reacting, corner = system.jacobian()
    count = len(system.state)
    size = count * MOTION
    matrix = np.zeros((size + 2 * PLACES, size + 2 * PLACES))
    for k in range(count):
        at = slice(k * MOTION, (k + 1) * MOTION)
        matrix[at, at] = by_ball[k, :MOTION]
        matrix[k * MOTION + VELOCITY : (k + 1) * MOTION, size:] = by_border[k, : MOTION - VELOCITY]
        matrix[size + PLACES :, at] = reacting[k]
    matrix[size : size + PLACES, size + PLACES :] = np.eye(PLACES)
    matrix[size + PLACES :, size:] = corner
    return matrix


@pytest.mark.parametrize(
    ("polar", "speed", "wanted"),
    [
        (0.0, 0.0, (192.83, 192.83, 289.77, 2150.4, 2150.4)),
        (1e-4, 183.26, (178.85, 207.90, 289.77)),
    ],
)
def test_a_shaft_on_a_preloaded_bearing_rings_where_it_should(polar, speed, wanted):
    """Frequencies [Hz] of a shaft of 0.5 kg and 1e-4 kg m^2, balls without friction; 10 um of axial preload."""
    moving = motion(
        *FREE, f"rings.inner.inertia=[1.0e-4,{polar}]", "gravity=[0,0,0]", "contact.friction_coefficient=0.0",
        "drive.speed=0", f"rings.inner.load=[0,0,{AXIAL_PRELOAD}]",
    )  # fmt: skip
    assert moving.border[2] == pytest.approx(1e-5, rel=1e-5)
    system = System(moving, moving.state, np.zeros(BORDER) + moving.border)
    system.drive = RingDrive(0.0, speed, 0.0)
    found = np.linalg.eigvals(whole(system))
    lines = np.sort(found.imag[(found.imag > 2.0 * np.pi * 100.0) & (found.imag < 2.0 * np.pi * 3000.0)]) / (2 * np.pi)
    for line in wanted:
        assert np.abs(lines / line - 1.0).min() < 5e-3, (line, lines)


def test_a_ball_rings_across_the_grooves_and_along_the_load():
    """3778 Hz and 42.9 kHz of a ball between rings that are held, 10 um of axial preload, without friction."""
    moving = motion(
        *FREE, "rings.inner.inertia=[1.0e-4,0]", "gravity=[0,0,0]", "contact.friction_coefficient=0.0",
        "drive.speed=0", f"rings.inner.load=[0,0,{AXIAL_PRELOAD}]",
    )  # fmt: skip
    system = System(moving, moving.state, np.zeros(BORDER) + moving.border)
    system.drive = RingDrive(0.0, 0.0, 0.0)
    found = np.linalg.eigvals(whole(system)[:MOTION, :MOTION])
    frequencies = np.sort(np.abs(found[found.imag > 1e3])) / (2.0 * np.pi)
    assert frequencies == pytest.approx([3778.0, 42.9e3], rel=2e-3)
