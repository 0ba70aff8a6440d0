"""Accelerations that balances between steps go by, of motions that are known; and which balls they speak of."""

from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin.kinds.bearing.companion import accelerations, balance
from bearing_twin.kinds.bearing.companion.deviations import Part
from bearing_twin.kinds.bearing.forces.cage import Pockets, bump
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    COLUMNS,
    HEIGHT,
    ORBIT_ANGLE,
    SPIN,
    VELOCITY,
)

FIRST = 4  # of three numbers in a state


def states_of(numbers):
    """States (T, 1, COLUMNS) whose three numbers are these (T, 3)."""
    states = np.zeros((len(numbers), 1, COLUMNS))
    states[:, 0, FIRST : FIRST + 3] = numbers
    return states


def test_changes_are_exact_for_parabolas_however_outputs_lie():
    times = np.array([0.0, 0.3, 0.4])
    states = states_of(np.stack([times**2, 3.0 * times, 1.0 - 2.0 * times**2], axis=1))[:, 0]
    found = accelerations.changes(*states, FIRST, times[1] - times[0], times[2] - times[1])
    assert found == pytest.approx((0.6, 3.0, -1.2))
    last = accelerations.changes(*states, FIRST, 0.3, 0.0)  # nothing follows: of first order, from the output before
    assert last == pytest.approx((0.3, 3.0, -0.6))


def test_what_fourth_order_adds_makes_quartics_exact():
    step, now = 0.1, 2
    times = 1.0 + step * np.arange(-2, 3)
    states = states_of(np.stack([times**3, times**4, times], axis=1))
    change = accelerations.changes(states[1, 0], states[2, 0], states[3, 0], FIRST, step, step)
    more = accelerations.better(states, now, 0, FIRST, change, step)
    assert abs(more[0]) > 5e-3
    assert np.add(change, more) == pytest.approx([3.0, 4.0, 1.0])


def straight(times, spin):
    """States of a ball that flies straight on past the axis, its spin at rest in space, seen in its own frame."""
    place, speed = np.array([0.014, -0.003, 0.001]), np.array([-0.3, 2.0, 0.1])
    states = np.zeros((len(times), 1, COLUMNS))
    for row, time in zip(states[:, 0], times, strict=True):
        x, y, z = place + time * speed
        angle = np.arctan2(y, x)
        turn = np.array([[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
        row[AXIS_DISTANCE], row[ORBIT_ANGLE], row[HEIGHT] = np.hypot(x, y), angle, z
        row[VELOCITY : VELOCITY + 3], row[SPIN : SPIN + 3] = turn @ speed, turn @ spin
    return states


@pytest.mark.parametrize("spacing", ["even", "uneven"])
def test_nothing_is_left_over_of_a_ball_on_which_nothing_acts(spacing):
    """Force and torque are 0, and so are acceleration and what turns its spin, in a frame that turns with it."""
    times = 1e-5 * np.arange(1, 12)
    if spacing == "uneven":
        times[4:] += 0.7e-5
    spin = np.array([300.0, -200.0, -900.0])
    states, begun = straight(times, spin), straight(np.zeros(1), spin)[0]
    rows, nothing = np.arange(3, 8), np.zeros((5, 1, 3))
    given = balance._Given(1e-3, 5e-9, 3e-3, 1.5, 1.5, (0.0, 0.0, 0.0), 0.1, 1e12, 0.1)
    load, approach, angle = np.full((5, 1, 2), 20.0), np.full((5, 1, 2), 1e-6), np.full((5, 1, 2), 0.2)
    bears, counts = np.ones((5, 1), bool), np.full((1, len(times)), 1e-3)
    off = np.zeros((5, 1, balance.ERRORS))
    given_too = (load, approach, angle, nothing, nothing), np.zeros((5, 1)), np.zeros(len(times))
    balance._left_over(given, False, times, rows, bears, *given_too, states, begun, counts, off)
    orbit = 2.0 / 0.014
    assert off[..., 0].max() < 1e-3 * given.mass * 2.0 * orbit
    # What leaving out a term of the frame that turns would leave.
    pushed, turned = given.mass * 0.3 * orbit, given.inertia * orbit * 200.0
    assert off[..., 1].max() < 1e-2 * pushed / (0.1 * 20.0)
    assert off[..., 2].max() < 1e-2 * turned
    moved = states.copy()
    moved[..., VELOCITY + 1] += 500.0 * times[:, None]  # what would take a force along the orbit
    if spacing == "even":
        balance._left_over(given, False, times, rows, bears, *given_too, moved, begun, counts, off)
        assert off[..., 1].min() > 0.9 * given.mass * 500.0 / (2.0 * 0.1 * 20.0)
        # Slip that outlasts a step goes on by itself: nothing is known of friction then.
        off[:] = 0.0
        lasting = given._replace(relaxing=0.99 * balance.SWING * 1e-3 / (40.0 * 1e-5))
        balance._left_over(lasting, False, times, rows, bears, *given_too, moved, begun, counts, off)
        assert not off[..., 1:].any()
        lasting = given._replace(relaxing=1.01 * balance.SWING * 1e-3 / (40.0 * 1e-5))
        balance._left_over(lasting, False, times, rows, bears, *given_too, moved, begun, counts, off)
        assert off[..., 1].all()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_the_pocket_of_a_cage_rubs_is_not_left_over(side):
    """Raceways hold against it what it does, so that the ball flies on; without it, it were an error."""
    times, spin, turns = 1e-5 * np.arange(1, 12), np.array([300.0, -200.0, -900.0]), 150.0
    states, begun = straight(times, spin), straight(np.zeros(1), spin)[0]
    pockets = Pockets(0.0142, 1e-4, 1e6, 3e-5, 0.05)
    given = balance._Given(1e-3, 5e-9, 3e-3, 1.5, 1.5, (0.0, 0.0, 0.0), 0.1, 1e12, 0.1, 0.01, 0.0142, 0.05)
    ball, rows = SimpleNamespace(ball_radius=3e-3, friction_regularisation=0.01), np.arange(3, 8)
    force, torque, pushes = np.zeros((5, 1, 3)), np.zeros((5, 1, 3)), np.zeros((5, 1))
    for row, now in enumerate(rows):
        state = states[now, 0]
        motion = state[VELOCITY : VELOCITY + 3], state[SPIN : SPIN + 3]
        found = bump.py_func(pockets, ball, state[AXIS_DISTANCE], side * 0.0075, *motion, turns)
        radial, axial = found.friction
        cosine, sine, lever = np.cos(state[ORBIT_ANGLE]), np.sin(state[ORBIT_ANGLE]), side * 3e-3
        fixed = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        force[row, 0], pushes[row, 0] = fixed @ (-radial, -found.along, -axial), found.along
        torque[row, 0] = -fixed @ np.cross([0.0, lever, 0.0], [radial, 0.0, axial])
    load, approach, angle = np.full((5, 1, 2), 20.0), np.full((5, 1, 2), 1e-6), np.full((5, 1, 2), 0.2)
    channels, counts = (load, approach, angle, force, torque), np.full((1, len(times)), 1e-3)
    moving = np.full(len(times), turns), states, begun, counts
    told = {}
    for rubs in (0.05, 0.0):
        off = told[rubs] = np.zeros((5, 1, balance.ERRORS))
        known = given._replace(pocket_friction=rubs)
        balance._left_over(known, True, times, rows, np.ones((5, 1), bool), channels, pushes, *moving, off)
    assert (told[0.05] < 0.05 * told[0.0]).all()


def bearing_balls(monkeypatch, carried, near, touching):
    """Balls (outputs, balls) of which it is asked what is left over, where these bear, and these touch the next."""
    outputs, balls = carried.shape
    seen = []
    monkeypatch.setattr(balance, "_left_over", lambda *given: seen.append(given[4]))
    monkeypatch.setattr(balance, "_given", lambda *_: None)
    load = np.where(carried, 20.0, 0.0)[..., None] * np.ones(2)
    names = "approach", "contact_angle", "raceway_force", "raceway_torque"
    out = {name: np.zeros((outputs, balls, 3)) for name in names}
    out |= {"normal_load": load, "neighbour_load": np.where(touching, 1.0, 0.0)}
    part = dict.fromkeys(("drive", "taken", "elapsed")) | {"pointer": np.ones((balls, outputs, 9)), "duration": 1.0}
    held = SimpleNamespace(active=False)
    whole = Part(
        bearing=None, out=out, filled=(None,), begun=(None,), near=near, partners=held, times=np.ones(outputs), **part
    )
    balance.off_balance(whole, False, np.arange(outputs), 100.0)
    return seen[0]


def test_a_ball_that_meets_a_neighbour_is_not_spoken_of_nor_is_the_next_ahead(monkeypatch):
    carried, touching = np.ones((3, 5), bool), np.zeros((3, 5), bool)
    touching[1, 3] = True  # balls 3 and 4
    bears = bearing_balls(monkeypatch, carried, np.ones(5, bool), touching)
    assert bears.tolist() == [[True, True, True, False, False]] * 3
    touching[:] = False
    touching[1, 4] = True  # the last and the first
    bears = bearing_balls(monkeypatch, carried, np.ones(5, bool), touching)
    assert bears.tolist() == [[False, True, True, True, False]] * 3


def test_a_ball_is_spoken_of_where_it_bears_at_the_outputs_before_and_behind_as_well(monkeypatch):
    carried = np.ones((6, 2), bool)
    carried[2, 0] = False
    bears = bearing_balls(monkeypatch, carried, np.zeros(2, bool), np.zeros((6, 2), bool))
    assert bears[:, 0].tolist() == [True, False, False, False, True, True]
    assert bears[:, 1].all()
