"""Balls that nothing keeps apart step in common only while they are close, and meet as if they always did."""

from types import SimpleNamespace

import numpy as np
import pytest
from bearings import motion

from bearing_twin.kinds.bearing.companion.windows import APART, PLACE, UNKNOWN, WINDOW
from bearing_twin.kinds.bearing.forces.equations import meeting
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, ORBIT_ANGLE, TANGENTIAL_VELOCITY
from bearing_twin.kinds.bearing.meeting_parts import MET, SOON, PartBalls, integrate_alone
from bearing_twin.numerics.lanes import COLUMNS
from bearing_twin.numerics.statuses import EVALUATIONS
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

RADIUS, PITCH, COUNT, MEETS_AT = 3e-3, 14e-3, 8, 0.0123
DURATION = 0.02


def _orbiting(pointing):
    """Balls on even places of which ball 2 comes within MET of the next at MEETS_AT [s], and a record of stretches."""
    state = np.zeros((COUNT, COLUMNS))
    state[:, AXIS_DISTANCE], state[:, ORBIT_ANGLE] = PITCH, 2.0 * np.pi / COUNT * np.arange(COUNT)
    closest = 2.0 * np.arcsin((1.0 + 0.5 * MET) * RADIUS / PITCH)
    rate = (2.0 * np.pi / COUNT - closest) / MEETS_AT
    asked = []

    def integrate(near, begin, times, duration, filled):
        # Ball 2 speeds up evenly, so that nothing at the start foretells when it comes.
        for row, time in enumerate([*times, duration]):
            now = state.copy()
            now[2, ORBIT_ANGLE] = 2.0 * np.pi / COUNT * 2 + rate * (begin + time) ** 2 / MEETS_AT
            now[2, TANGENTIAL_VELOCITY] = 2.0 * PITCH * rate * (begin + time) / MEETS_AT
            if row < len(times):
                filled[0][row] = now
        state[:] = now
        asked.append((near.copy(), begin, duration))
        return np.full((COUNT, len(times), 1), float(len(asked)))[:, : len(times) if pointing else 0]

    return state, integrate, asked


@pytest.mark.parametrize("pointing", [True, False])
def test_balls_are_near_only_while_they_are_close(pointing):
    """Of two that meet at an instant that nothing foretells; all outputs are of the stretches that were kept."""
    state, integrate, asked = _orbiting(pointing)
    near, times = np.zeros(COUNT, bool), np.linspace(2e-4, DURATION, 100)
    until = 1.02 * MEETS_AT  # before they are through each other, as these do not push
    times = times[times <= until]
    filled = (np.full((len(times), COUNT, COLUMNS), np.nan),)
    pointer = integrate_alone(integrate, PartBalls(RADIUS, near, [state]), times, until, filled)
    assert near.tolist() == [k == 2 for k in range(COUNT)]
    assert np.isfinite(filled[0]).all()
    assert pointer.shape == ((COUNT, len(times), 1) if pointing else (COUNT, 0, 1))
    kept = [one for one, after in zip(asked, [*asked[1:], (None, until, 0.0)], strict=True) if after[1] > one[1]]
    assert sum(duration for _, _, duration in kept) == pytest.approx(until, rel=1e-12)
    assert kept[0][1] == 0.0
    together = [(begin, duration) for close, begin, duration in kept if close[2]]
    assert all(duration <= SOON for _, duration in together)
    assert MEETS_AT - 4.0 * SOON < together[0][0] < MEETS_AT
    assert len(asked) < 20
    for row, state_then in enumerate(filled[0]):
        if meeting(RADIUS, state_then, 2)[0] < MET * RADIUS:
            assert times[row] > together[0][0]


@pytest.mark.parametrize("longer", [0.0, 1e-15, -1e-15])
def test_a_last_stretch_that_is_longer_by_rounding_is_no_long_one(longer):
    """It was taken for a long one, made shorter and tried again for ever: a run of a bearing at 20 000 rpm hung."""
    asked = []

    def integrate(near, begin, times, duration, filled):
        asked.append(near.tolist())
        assert len(asked) < 10
        return np.zeros((0, 0, 1))

    def mark_met(states, near):
        """Two that were not near meet in whatever is integrated."""
        new, near[1] = not near[1], True
        return new

    def mark_near(reach, ahead, near):
        near[0] = True

    balls = SimpleNamespace(radius=RADIUS, near=np.zeros(2, bool), moving=[], put_back=lambda before: None)
    balls.mark_near, balls.mark_met = mark_near, mark_met
    integrate_alone(integrate, balls, np.zeros(0), SOON * (1.0 + longer), (np.zeros((0, 2, COLUMNS)),))
    assert asked == [[True, False], [True, True]]


def _moved(common, duration, tolerance, rate):
    """A start from rest, in which two balls meet first at 6.65 ms: by parts, or with steps in common from the start."""
    moving = motion("initial.motion=rest", f"wanted.tolerance={tolerance}", scene="bearing_6203_loose")
    times = np.arange(1, round(duration * rate) + 1) / rate
    if not common:
        return moving, moving.advance(times, duration).neighbour_load
    filled = moving._instants.empty(len(times), moving.bearing.balls)
    near = np.ones(moving.bearing.balls, bool)
    moving._integrate(moving._partners(), moving.drive, near, 0.0, times, duration, filled)
    return moving, None


def test_meetings_are_those_of_balls_that_always_step_in_common():
    (parts, pushes), (common, _) = (_moved(one, 7e-3, 1e-8, 2e4) for one in (False, True))
    assert pushes.max() > 5.0  # N
    assert np.abs(parts.state - common.state)[:, :3].max() < 1e-8


def test_a_meeting_costs_what_those_who_meet_cost():
    """All in common, as every part was in which any met, takes twice the evaluations."""
    parts, common = (_moved(one, 0.02, 1e-2, 2e3)[0].counts[EVALUATIONS] for one in (False, True))
    assert parts < 0.6 * common


def test_meetings_are_unknown_only_from_where_a_copy_ended():
    """Of a part that a copy went through until it had its share of steps: horizons were the begin of the part."""
    overrides = "initial.motion=rest", "wanted.tolerance=1e-3", "run.output_rate=2000", "run.duration=0.02"
    run = simulate(load_scene("bearing_6203_loose", overrides))
    blocks = list(run.blocks())
    rows = np.concatenate([one.records[WINDOW.name] for one in blocks if WINDOW.name in one.records])
    ball, begins = rows[:, PLACE["ball"]], rows[:, PLACE["begin"]]
    (unseen,), copied = rows[ball == UNKNOWN], rows[ball == APART]
    assert len(copied) > 1
    assert unseen[PLACE["begin"]] >= copied[:, 0].max() > begins[ball == APART].min() > 0.0
    assert run.report.errors["horizon_s"] == pytest.approx(unseen[PLACE["begin"]], rel=1e-9)
