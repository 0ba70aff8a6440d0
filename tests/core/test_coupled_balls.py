"""The compiled core's system of balls, ring, cage and shaft: its derivatives."""

import numpy as np
from bearings import motion
from ring_systems import places_in_border

from bearing_twin.kinds.bearing.compiled_coupled import BODY_NUMBERS, COORDINATES, rates_and_jacobian
from bearing_twin.kinds.bearing.system import (
    AXIS_DISTANCE,
    COLUMNS,
    GROSS_WORK,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    TANGENTIAL_VELOCITY,
)

# Scene, overrides, instant [s], whether balls are pushed onto each other.
COUPLED = (
    ("bearing_6203_loose", (), 0.005, False),
    ("bearing_6203_tilted", ("geometry.balls=7",), 0.002, False),
    ("bearing_6203_rig_400N", ("geometry.balls=11",), 0.005, False),
    ("bearing_6203_step_load", ("contact.friction_coefficient=0.1",), 0.0102, False),
    ("bearing_6203_run_up", ("rings.inner.free=all", "rings.inner.unbalance=5e-5"), 0.005, False),
    ("bearing_6203_rig_400N", ("cage.kind=pockets",), 0.02, False),
    (
        "bearing_6203_guided_cage",
        ("cage.guidance=inner", "geometry.balls=13", "cage.pocket_clearance=1e-4"),
        0.01,
        False,
    ),
    ("bearing_6203_run_up", ("cage.kind=none", "geometry.balls=13"), 0.005, True),
)
# Changes that are small beside what contacts and friction follow from: of a ball's motion, and of the bodies'.
OF_BALL = (1e-10, 1e-9, 1e-10, 1e-5, 1e-3, 1e-5, 3e-3, 3e-3, 3e-3)
OF_BODIES = (
    *(1e-10,) * 3,
    *(1e-9,) * 2,
    *(1e-10,) * 2,
    1e-9,
    1e-7,
    *(1e-6,) * 3,
    *(1e-4,) * 2,
    *(1e-6,) * 2,
    1e-4,
    1e-3,
)


def test_derivatives_of_every_element_are_those_of_the_rates():
    patch = motion("contact.friction=spot").bearing.spot
    for scene, overrides, instant, touching in COUPLED:
        moving = motion(*overrides, scene=scene)
        drive = moving.drive
        moving.advance(np.array([instant]), instant)
        partners, balls = moving.partners, len(moving.state)
        state, border, near = moving.state.copy(), moving.border.copy(), np.full(balls, touching)
        if partners.ring:
            border[PLACES : PLACES + 3] += (1e-3, -2e-3, 5e-4)
        if touching:
            pitch = 2.0 * np.arcsin(moving.bearing.ball_radius / state[:, AXIS_DISTANCE].mean())
            for k in (1, 2, 6):
                state[k, ORBIT_ANGLE] = state[k - 1, ORBIT_ANGLE] + pitch - 2e-5
        for bearing in (moving.bearing, moving.bearing._replace(spot=patch, raceway_friction=0.0)):

            def rates(
                column, change, drive=drive, bearing=bearing, partners=partners, state=state, border=border, near=near
            ):
                there, bodies = state.copy(), border.copy()
                ball, of = divmod(column, MOTION)
                if ball >= len(state):
                    bodies[places_in_border(bool(partners.land))[column - len(state) * MOTION]] += change
                else:
                    orbit = there[ball, TANGENTIAL_VELOCITY] / there[ball, AXIS_DISTANCE]
                    there[ball, of] += change * (of != TANGENTIAL_VELOCITY)
                    orbit += change * (of == TANGENTIAL_VELOCITY)
                    there[ball, TANGENTIAL_VELOCITY] = orbit * there[ball, AXIS_DISTANCE]
                return rates_and_jacobian(bearing, drive, partners, near, there, bodies)

            jacobian = rates(0, 0.0)[1]
            changes = np.array([*OF_BALL * balls, *OF_BODIES])
            columns = np.flatnonzero(np.abs(jacobian).sum(axis=0))  # of an even cage balls have no orbit of their own
            found = np.column_stack([rates(c, changes[c])[0] - rates(c, -changes[c])[0] for c in columns]) / 2.0
            expected = jacobian[:, columns] * changes[columns]
            rows = np.flatnonzero(np.abs(jacobian).sum(axis=1))
            rows = rows[(rows >= balls * COLUMNS) | (rows % COLUMNS != GROSS_WORK)]  # which has a bend at no power
            size = np.abs(expected[rows]).max(axis=1, keepdims=True)
            errors = np.abs(found[rows] - expected[rows]) / (size + 1e-9 * size.max())
            assert errors.max() < 1e-3, (scene, overrides, *np.unravel_index(errors.argmax(), errors.shape))
            assert jacobian.shape == (balls * COLUMNS + BODY_NUMBERS, balls * MOTION + 2 * COORDINATES)
