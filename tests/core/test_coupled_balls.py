"""The compiled core's system of balls, ring, cage and shaft: derivatives, frequencies, balances of its elements."""

import math

import numpy as np
import pytest
from bearings import AXIAL_PRELOAD, FREE, motion
from ring_systems import (
    BODY_NUMBERS,
    OF_BALL,
    OF_BODIES,
    System,
    disturbed,
    indices_in_state,
    system_jacobian,
    system_rates,
)

from bearing_twin.kinds.bearing.integrate import MEETING_GAP, mark_met
from bearing_twin.kinds.bearing.system import (
    AXIS_DISTANCE,
    BODY_COLUMNS,
    COLUMNS,
    COORDINATES,
    GROSS_WORK,
    HOUSING_POSITION,
    HOUSING_SPEED,
    MOTION,
    ORBIT_ANGLE,
    POSITIONS,
    SPIN,
    TANGENTIAL_VELOCITY,
    RingDrive,
)

# Scene, overrides, instant [s], whether balls are pushed onto each other.
COUPLED = (
    ("bearing_6203_loose", (), 0.005, False),
    ("bearing_6203_tilted", ("geometry.balls=7",), 0.002, False),
    ("bearing_6203_rig_400N", ("geometry.balls=11",), 0.005, False),
    ("bearing_6203_step_load", ("contact.friction_coefficient=0.1",), 0.0102, False),
    ("bearing_6203_run_up", ("rings.inner.free=all", "rings.inner.unbalance=5e-5"), 0.005, False),
    ("bearing_6203_rig_400N", ("cage.kind=pockets",), 0.02, False),
    ("bearing_6203_rig_400N", ("sensor.on=housing", "sensor.direction=1,2,-1"), 0.005, False),
    ("bearing_6203_run_up", ("rings.inner.free=all", "cage.kind=pockets", "sensor.on=housing"), 0.005, False),
    (
        "bearing_6203_guided_cage",
        ("cage.guidance=inner", "geometry.balls=13", "cage.pocket_clearance=1e-4"),
        0.01,
        False,
    ),
    ("bearing_6203_run_up", ("cage.kind=none", "geometry.balls=13"), 0.005, True),
)


def differences(*system):
    """Columns that matter of a system (`linear_answers`), and derivatives of all rates by them.

    By central differences of the rates, and by the Jacobian.
    """
    bearing, drive, bodies, near, state, body_state = system
    balls = len(state)

    def rates(column, change):
        ball_state, body_changed = state.copy(), body_state.copy()
        ball, number = divmod(column, MOTION)
        if ball >= balls:
            body_changed[indices_in_state(bool(bodies.land))[column - balls * MOTION]] += change
        else:
            orbit = ball_state[ball, TANGENTIAL_VELOCITY] / ball_state[ball, AXIS_DISTANCE]
            ball_state[ball, number] += change * (number != TANGENTIAL_VELOCITY)
            orbit += change * (number == TANGENTIAL_VELOCITY)
            ball_state[ball, TANGENTIAL_VELOCITY] = orbit * ball_state[ball, AXIS_DISTANCE]
        return system_rates(bearing, drive, bodies, near, ball_state, body_changed)

    jacobian = system_jacobian(*system)
    assert jacobian.shape == (balls * COLUMNS + BODY_NUMBERS, balls * MOTION + 2 * COORDINATES)
    changes = np.array([*OF_BALL * balls, *OF_BODIES])
    columns = np.flatnonzero(np.abs(jacobian).sum(axis=0))  # of an even cage balls have no orbit of their own
    result = np.column_stack([rates(c, changes[c]) - rates(c, -changes[c]) for c in columns]) / 2.0
    return columns, result, jacobian[:, columns] * changes[columns]


def test_derivatives_of_every_element_are_those_of_the_rates():
    patch = motion("contact.friction=spot").bearing.patch
    for scene, overrides, instant, touching in COUPLED:
        moving = motion(*overrides, scene=scene)
        moving.advance(np.array([instant]), instant)
        bodies, balls = moving.bodies, len(moving.state)
        state, body_state, near = moving.state.copy(), moving.body_state.copy(), np.full(balls, touching)
        if bodies.ring:
            body_state[POSITIONS : POSITIONS + 3] += (1e-3, -2e-3, 5e-4)
        if bodies.housing:
            body_state[[HOUSING_POSITION, HOUSING_SPEED]] += (2e-7, 1e-3)
        if touching:
            pitch = 2.0 * np.arcsin(moving.bearing.ball_radius / state[:, AXIS_DISTANCE].mean())
            for k in (1, 2, 6):
                state[k, ORBIT_ANGLE] = state[k - 1, ORBIT_ANGLE] + pitch - 2e-5
        for bearing in (moving.bearing, moving.bearing._replace(patch=patch, raceway_friction=0.0)):
            _, result, expected = differences(bearing, moving.drive, bodies, near, state, body_state)
            rows = np.flatnonzero(np.abs(expected).sum(axis=1))
            rows = rows[(rows >= balls * COLUMNS) | (rows % COLUMNS != GROSS_WORK)]  # which has a bend at no power
            size = np.abs(expected[rows]).max(axis=1, keepdims=True)
            errors = np.abs(result[rows] - expected[rows]) / (size + 1e-9 * size.max())
            assert errors.max() < 1e-3, (scene, overrides, *np.unravel_index(errors.argmax(), errors.shape))


def test_derivatives_know_that_friction_falls_as_films_grow():
    """Of spins by the balls' distances from the axis, where a film carries a part of the load."""
    moving = motion("lubricant={kind: oil, name: VG32}", "drive.speed=20", scene="bearing_6203_loose")
    moving.advance(np.array([0.005]), 0.005)
    near = np.zeros(len(moving.state), np.bool_)
    columns, result, expected = differences(
        moving.bearing, moving.drive, moving.bodies, near, moving.state, moving.body_state
    )
    spins = np.add.outer(COLUMNS * np.arange(len(near)), np.arange(SPIN, SPIN + 3)).ravel()
    radii = (columns < len(near) * MOTION) & (columns % MOTION == AXIS_DISTANCE)
    size = np.abs(expected[spins]).max(axis=1, keepdims=True)
    assert (size > 0.0).sum() > 10
    assert (np.abs(result - expected)[np.ix_(spins, radii)] <= 0.02 * size).all()


def test_a_ball_rings_across_the_grooves_and_along_the_load():
    """3778 Hz and 42.9 kHz of a ball between rings that are held, 10 um of axial preload, without friction."""
    moving = motion(
        *FREE, "rings.inner.inertia=[1.0e-4,0]", "gravity=[0,0,0]", "contact.friction_coefficient=0.0",
        "drive.speed=0", f"rings.inner.load=[0,0,{AXIAL_PRELOAD}]",
    )  # fmt: skip
    system = System(moving, moving.state, np.zeros(BODY_COLUMNS) + moving.body_state)
    system.drive = RingDrive(0.0, 0.0, 0.0)
    result = np.linalg.eigvals(system.jacobian()[:MOTION, :MOTION])
    frequencies = np.sort(np.abs(result[result.imag > 1e3])) / (2.0 * np.pi)
    assert frequencies == pytest.approx([3778.0, 42.9e3], rel=2e-3)


def test_pockets_exchange_angular_momentum():
    """What they take from the balls' orbits and spins is what they give to the cage."""
    system = disturbed()
    result, body_state = system.rates(system.state, system.body_state)
    bearing = system.bearing
    system.bearing = bearing._replace(pockets=())
    without, _ = system.rates(system.state, system.body_state)
    change = result - without
    balls = bearing.ball_mass * system.state[:, AXIS_DISTANCE] * change[:, TANGENTIAL_VELOCITY]
    balls += bearing.ball_inertia * change[:, SPIN + 2]
    cage = body_state[11] * system.bodies.mass[5]
    assert np.abs(change).max() > 0.0
    assert cage == pytest.approx(-balls.sum(), rel=1e-12)


def test_balls_that_met_and_parted_between_the_ends_of_a_chunk_are_found():
    moving = motion("gravity=[0,0,0]", "cage.kind=none", "geometry.radial_clearance=40e-6", "drive.speed=0.0")
    bearing, states = moving.bearing, np.repeat(moving.state[None], 3, axis=0)
    apart = 2.0 * math.asin((bearing.ball_radius + 2e-5) / states[0, 0, AXIS_DISTANCE])
    assert MEETING_GAP * bearing.ball_radius > 4e-5
    for nearest in (apart, -0.5):  # closer than that, or past the other
        near = np.zeros(bearing.balls, bool)
        states[1, 3, ORBIT_ANGLE] = states[1, 4, ORBIT_ANGLE] - nearest
        assert mark_met(bearing.ball_radius, moving.state, states, near)
        assert near.tolist() == [k == 3 for k in range(bearing.balls)]
        assert not mark_met(bearing.ball_radius, states[1], states[:0], near)


def test_a_ring_rings_with_its_housing_as_two_masses_on_springs():
    """Axially, 10 um of preload, without friction: the stiffness of the bearing is that at which a held ring rings."""
    overrides = (
        *FREE, "rings.inner.inertia=[1.0e-4,0]", "gravity=[0,0,0]", "contact.friction_coefficient=0.0",
        "drive.speed=0", f"rings.inner.load=[0,0,{AXIAL_PRELOAD}]",
        "sensor.on=housing", "sensor.direction=0,0,-1", "housing={mass: 0.8, stiffness: 3e6, damping: 0}",
    )  # fmt: skip
    moving = motion(*overrides)
    system = System(moving, moving.state, np.zeros(BODY_COLUMNS) + moving.body_state)
    system.drive = RingDrive(0.0, 0.0, 0.0)
    stiffness, housing_stiffness, mass = 0.5 * (2.0 * np.pi * 289.77) ** 2, 3e6, 0.8
    matrix = np.array(
        [[stiffness / 0.5, -stiffness / 0.5], [-stiffness / mass, (stiffness + housing_stiffness) / mass]]
    )
    result = np.linalg.eigvals(system.jacobian()).imag / (2.0 * np.pi)
    for line in np.sqrt(np.linalg.eigvals(matrix)) / (2.0 * np.pi):
        assert np.abs(result / line - 1.0).min() < 1e-2, (line, result)
    assert np.abs(result / 289.77 - 1.0).min() > 2e-2
