"""Balls that bounce and balls that meet: what a bearing run is off there, how it comes to know, and its horizon."""

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest
from bearings import motion

from bearing_twin.charts.bearing_cells import errors
from bearing_twin.charts.companion_cost import at_length
from bearing_twin.kinds.bearing.companion import beside
from bearing_twin.kinds.bearing.companion.beside import all_beside, some_beside
from bearing_twin.kinds.bearing.companion.companion import Companion
from bearing_twin.kinds.bearing.companion.departures import (
    SETTLING,
    bouncing,
    followed_as,
    taking_off,
    to_the_end,
    together,
)
from bearing_twin.kinds.bearing.companion.deviations import Found, Part, deviations, drive_later, left_over
from bearing_twin.kinds.bearing.companion.growth import Growth
from bearing_twin.kinds.bearing.companion.meetings import Drift, as_met, meetings, pairs_in, stretches_from, until_met
from bearing_twin.kinds.bearing.companion.redoing import BEYOND
from bearing_twin.kinds.bearing.companion.windows import ALL, APART, PLACE, UNKNOWN, WINDOW, Window
from bearing_twin.kinds.bearing.forces.equations import RingDrive, approaches
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BORDER,
    CARRIED_COLUMNS,
    DISSIPATED,
    DRIVE_WORK,
    MOTION,
    ORBIT_ANGLE,
    RADIAL_VELOCITY,
    TANGENTIAL_VELOCITY,
)
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.kinds.bearing.stepping.pointing import POINTED, STEPS_IN
from bearing_twin.kinds.bearing.watched import WatchedMotion
from bearing_twin.numerics.lanes import COLUMNS
from bearing_twin.numerics.statuses import STALLED, STEPS
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

# Radius, angle, height, velocity and spin of a ball that nears the inner raceway of a 6203 after its ring has jumped.
FLIGHT = (0.0142466784, 2.28171953, 4.90065269e-6, -0.00583756855, 1.08232378, -0.002066549)
FLIGHT += (12.0023973, -0.561827872, -320.491593, 0.0, 0.0, 0.0)
JUMP = ("run.duration=0.033", "drive.change.offset=[2e-6,-5e-6,1e-6]")  # balls 7 and 0 meet at 31.1 ms


def ran(*overrides):
    """A run of the jump to its end, its outputs but the first, and the windows of its companion."""
    run = simulate(load_scene("bearing_6203_sudden", (*JUMP, *overrides)))
    blocks = list(run.blocks())
    rows = [block.records["companion"] for block in blocks if "companion" in block.records]
    found = Rows(blocks[0].values.layout, np.concatenate([block.matrix() for block in blocks])[1:])
    return run, found, np.concatenate(rows) if rows else None


@pytest.fixture(scope="module")
def exact():
    return ran("wanted.tolerance=1e-8", "solver.companion=off")[1]


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_what_becomes_of_errors_where_balls_meet_is_known_and_said(tolerance, exact):
    run, found, rows = ran(f"wanted.tolerance={tolerance}")
    error = max(errors(BearingMotion(run.scene.parameters, run.choice), found, exact))
    apart = rows[rows[:, PLACE["ball"]] == APART]
    before, after = apart[0, PLACE["friction"]], apart[1:, PLACE["friction"]].max()
    assert apart[0, 0] < 0.0311 < apart[1, 0]
    assert before < tolerance
    assert error / 10.0 < after < 10.0 * error
    told = run.report.errors["wanted_errors"]["friction"]
    if error > tolerance:
        assert run.report.status in ("doubtful: friction", "doubtful: loads, friction")  # loads: as rounding has it
        assert told["error"] == after
        assert "a copy that starts apart" in told["where"]
        assert any("a copy that starts apart" in flag for flag in run.report.flags)


def test_a_run_in_which_no_balls_meet_has_no_copy():
    run = simulate(load_scene("bearing_6203_loose", ("run.duration=0.1",)))
    rows = np.concatenate([block.records["companion"] for block in run.blocks() if "companion" in block.records])
    assert not np.isin(rows[:, PLACE["ball"]], (ALL, APART)).any()
    assert run.report.status == "done"


def test_no_step_passes_over_a_bounce():
    """One step of 0.3 ms has no stage in the contact; cut, the ball leaves as by steps of a nanosecond's error."""
    moving = motion("geometry.balls=1", "drive.offset=[2e-6,-5e-6,1.1e-5]", "drive.speed=274.89")
    scales, duration = moving.scales, 3e-4

    def after(share):
        moving.reset()
        moving.state[0], moving.steps[:], moving.scales = FLIGHT, duration, share * scales
        assert max(approaches(moving.bearing, moving.state[0])) < -1e-7
        moving.advance(np.array([duration]), duration)
        return moving.state[0].copy()

    fine, cut = after(1e-5), after(1.0)
    assert moving.counts[STEPS] >= 4
    assert abs(cut - fine)[RADIAL_VELOCITY] < 1e-4
    assert abs(cut - fine)[AXIS_DISTANCE] < 1e-8


def test_a_contact_begins_at_any_tolerance():
    """The load of damping grows like the root of time: the first steps in contact are far below 1e-12 s."""
    moving = motion("geometry.balls=1", "wanted.tolerance=1e-8", scene="bearing_6203_loose")
    moving.state[0, RADIAL_VELOCITY] = 2.0
    moving.state[0, AXIS_DISTANCE] -= approaches(moving.bearing, moving.state[0])[1] + 2e-10
    moving.advance(np.array([1e-6]), 1e-6)
    assert approaches(moving.bearing, moving.state[0])[1] > 1e-6


def a_part(**what):
    """A part of 4 outputs a millisecond apart, of three balls, with what a test needs."""
    times, states = 1e-3 * np.arange(1, 5), np.zeros((5, 3, COLUMNS))
    states[..., AXIS_DISTANCE], states[..., ORBIT_ANGLE] = 0.014, [0.0, 2.0, 4.0]
    given = {
        "near": np.ones(3, bool),
        "partners": SimpleNamespace(active=False),
        "times": times,
        "duration": 4e-3,
        "elapsed": 1.0,
        "bearing": SimpleNamespace(ball_radius=0.003),
        "out": {"normal_load": np.ones((4, 3, 2))},
        "pointer": np.zeros((3, 4, POINTED)),
        "states": states,
    } | what
    states = given.pop("states")
    given |= {"begun": [states[0]], "filled": (states[1:],), "drive": None, "taken": 0}
    return Part(**given)


def test_balls_meet_where_they_come_together_before_the_next_output():
    still = a_part()
    assert not meetings(still).any()
    states = np.concatenate([still.begun[0][None], still.filled[0]])
    touch = 2.0 * np.arcsin(0.003 / 0.014)
    states[2:, 1, ORBIT_ANGLE] = touch * 1.01  # ball 1 comes up to ball 0 ...
    states[1:3, 1, TANGENTIAL_VELOCITY] = -0.5  # ... and is quick enough until the second output
    met = meetings(a_part(states=states))
    assert met.tolist() == [[False] * 3, [True, False, False], [True, False, False], [False] * 3]
    assert not meetings(a_part(states=states, near=np.zeros(3, bool))).any()
    # Windows of balls 0 and 1 over that are of all balls, those before it and of ball 2 are not.
    assert [as_met(Window(ball, -1, 4), met).ball for ball in range(3)] == [ALL, ALL, 2]
    assert as_met(Window(0, -1, 1), met).ball == 0
    assert until_met(Window(1, -1, 4), met) == Window(1, -1, 1)
    assert until_met(Window(2, -1, 4), met) == Window(2, -1, 4)
    assert list(stretches_from(met)) == [Window(APART, -1, 1), Window(APART, 0, 3)]
    assert pairs_in(Window(ALL, 0, 1), met).tolist() == [True, False, False]


def test_a_drift_grows_while_a_ball_coasts_and_is_forgotten_where_it_is_driven():
    load = np.ones((4, 3, 2))
    load[:, 1, 0] = 0.0  # ball 1 is carried by the outer raceway alone
    load[:, 2] = 0.0  # ball 2 is loose
    part, drift = a_part(out={"normal_load": load}), Drift(3)
    exact = part.filled[0][:1].copy()
    exact[0, :, ORBIT_ANGLE] += 1e-6
    exact[0, :, TANGENTIAL_VELOCITY] += 0.014 * 1e-3
    for ball in (0, 1):
        drift.see(part, Window(ball, 0, 1), SimpleNamespace(states=exact[:, ball : ball + 1]), 1.0)
    drift.go_on(part, set())
    assert drift.angle == pytest.approx([1e-6, 1e-6 + 1e-3 * 2e-3, 0.0])
    assert drift.speed == pytest.approx([0.0, 1e-3, 0.0])
    assert drift.lost.tolist() == [False, False, True]
    other = Drift(3)
    other.remember(drift.memory())
    state = np.zeros((3, COLUMNS))
    state[:, AXIS_DISTANCE] = 0.014
    other.set_apart(state, 1.005, 1e-3)
    # Ball 2 was lost: the greatest of all stands for it; neighbours start off the other way.
    most = 1e-6 + 1e-3 * 3e-3
    assert state[:, ORBIT_ANGLE] == pytest.approx([-1e-6, most, -most])
    assert state[:, TANGENTIAL_VELOCITY] == pytest.approx([0.0, 0.014e-3, -0.014e-3])


def in_flight():
    """A part in which ball 1 touches neither raceway at two outputs, ball 0 at one; with 10 and 20 steps a cell."""
    load, pointer = np.ones((9, 3, 2)), np.zeros((3, 9, POINTED))
    load[2, 0] = load[2:4, 1] = 0.0
    pointer[:, :, STEPS_IN] = np.array([[20.0], [10.0], [1.0]])
    return {"times": 1e-3 * np.arange(1, 10), "out": {"normal_load": load}, "pointer": pointer}


def test_balls_that_bounce_are_followed_side_by_side_from_the_beginning_of_their_part_until_the_last_rests():
    """What bounces most comes first; where a part begins, alone, a ball's own state is known."""
    part, met = in_flight(), np.zeros((9, 3), bool)
    both = [Window(1, -1, 4 + SETTLING), Window(0, -1, 4 + SETTLING)]
    assert bouncing(a_part(**part), met, set(), 1e9) == both
    assert bouncing(a_part(**part), met, {1}, 1e9) == [Window(0, -1, 3 + SETTLING)]
    assert bouncing(a_part(**part), met, set(), 209.0) == both[:1]  # 30 steps a cell, in seven of them
    assert bouncing(a_part(**part), met, set(), 60.0) == []
    met[5, 2] = True  # ball 2 meets ball 0, the next ahead
    assert bouncing(a_part(**part), met, set(), 1e9) == both[:1]
    part["out"]["normal_load"][8, 1] = 0.0  # at the end: as far as the part goes
    assert bouncing(a_part(**part), met, set(), 1e9)[0].length == 9
    assert not bouncing(a_part(), met[:4], set(), 1e9)


def test_a_ball_that_nobody_follows_is_looked_at_where_it_takes_off():
    part, met = in_flight(), np.zeros((9, 3), bool)
    found = taking_off(a_part(**part), met, set(), 1e9)
    assert [(one.ball, one.begin + one.length) for one in found] == [(1, 2), (0, 2)]  # up to the output in flight
    assert taking_off(a_part(**part), met, {1}, 1e9) == found[1:]
    assert taking_off(a_part(**part), met, set(), 20.0) == found[:1]
    met[2, 0] = True
    assert taking_off(a_part(**part), met, set(), 1e9) == []
    assert not taking_off(a_part(), met[:4], set(), 1e9)


GROWTH = [(1e-6, 2e-3, True), (1e-7, 5e-5, True), (1e-7, 3e-5, False), (1e-6, 5e-5, False)]


@pytest.mark.parametrize(("first", "reached", "named"), GROWTH)
def test_a_copy_that_grows_away_names_the_horizon_where_balls_met(first, reached, named):
    """A hundred times, and beyond a third of what is wanted: as near as one copy tells it."""
    growth = Growth(1e-4)
    for end, error in ((0.031, first), (0.032, reached)):
        row = np.zeros(len(WINDOW.columns))
        row[0], row[PLACE["begin"]], row[PLACE["ball"]], row[PLACE["friction"]] = end, 0.0308, APART, error
        growth.add(row, 50.0)
    assert ("horizon" in growth.notes) == named
    if named:
        assert "times since balls met: beyond 0.031 s" in growth.notes["horizon"]


@pytest.mark.parametrize(("error", "until", "place"), [(5e-5, 0.031, "0.031 s, where a copy"), (3e-5, 0.05, "0.05 s")])
@pytest.mark.parametrize("copy_first", [True, False])
def test_a_horizon_is_no_later_than_where_a_copy_was_off_by_a_third_of_what_is_wanted(error, until, place, copy_first):
    """However little that copy grew: another may show three times as much, and up to a horizon a run is as wanted."""
    growth, rows = Growth(1e-4), []
    for ball, begin, end, friction in (
        (APART, 0.0308, 0.031, 2e-5),
        (APART, 0.0308, 0.032, error),
        (UNKNOWN, 0.05, 0.07, 2.0),
    ):
        rows.append(row := np.zeros(len(WINDOW.columns)))
        row[0], row[PLACE["begin"]], row[PLACE["ball"]], row[PLACE["friction"]] = end, begin, ball, friction
    for row in rows[:2]:
        growth.add(row, 50.0)
    assert growth.horizon is None  # alone, it says that the run is off, not that errors grow
    assert not growth.notes
    growth = Growth(1e-4)
    for row in rows if copy_first else [rows[2], *rows[:2]]:
        growth.add(row, 50.0)
    assert growth.horizon == until
    assert place in growth.notes["horizon"]
    assert "only statistics" in growth.notes["horizon"]


@pytest.mark.parametrize(("reached", "known"), [(1e-7, True), (1e-5, False)])
def test_meetings_that_no_copy_looks_at_do_to_errors_what_was_seen(reached, known):
    """A copy was made 40 times as far off: once more, and it is within the tolerance or not."""
    scene = load_scene("bearing_6203_loose", ("wanted.tolerance=1e-4",))
    companion, met = WatchedMotion(scene.parameters, choose(scene)).companion, np.zeros((4, 3), bool)
    companion.grew, companion.reached, companion.met = 40.0, reached, 2
    assert companion._parted(a_part(), None, 1e-4, met) == []
    assert not companion.adrift  # none met
    met[2, 0] = True
    assert companion._parted(a_part(), None, 1e-4, met) == []
    assert companion.adrift != known


def test_beyond_a_horizon_nobody_is_followed_and_no_copy_sets_out():
    """There nothing is promised; a part that is done again from before it is looked at as ever."""
    scene = load_scene("bearing_6203_loose", ("wanted.tolerance=1e-4",))
    companion, met = WatchedMotion(scene.parameters, choose(scene)).companion, np.zeros((9, 3), bool)
    part = a_part(**in_flight())
    met[5:, 0] = True
    companion.parts = 1
    assert companion._copied(part, met) == 3
    assert companion._goes_beside(part)
    for until, beyond in ((part.elapsed + 1e-6, False), (part.elapsed, True)):
        companion.growth = Growth(1e-4)
        rows = np.zeros((2, len(WINDOW.columns)))
        rows[:, PLACE["ball"]], rows[:, PLACE["begin"]] = APART, until - 1e-3
        rows[:, 0], rows[:, PLACE["friction"]] = (until, until + 1e-3), (1e-6, 1e-3)
        companion.stands([rows[::-1]])
        assert companion.horizon == until
        assert companion._beyond(part) == beyond
        assert (companion._copied(part, met) is None) == beyond
    assert not companion._goes_beside(part)
    assert companion._throws(part, None, 1e-4, met[:1]) == ([], [])
    kept = companion.memory()
    companion.reset()
    assert not companion._beyond(part)
    companion.remember(kept)
    assert companion._beyond(part)


def test_beyond_a_horizon_no_copy_sets_out_and_steps_are_for_statistics(monkeypatch):
    """A loose bearing that starts from rest: later copies told nothing more, and short steps took ten times as many."""
    made, part = [], BearingMotion._part

    def noted(motion, times, duration, out, first):
        if len(times):
            made.append((motion.elapsed, motion.setting, motion.companion.horizon))
        part(motion, times, duration, out, first)

    monkeypatch.setattr(BearingMotion, "_part", noted)
    overrides = "initial.motion=rest", "run.duration=0.3", "wanted.tolerance=1e-3"
    run = simulate(load_scene("bearing_6203_loose", overrides))
    rows = np.concatenate([block.records["companion"] for block in run.blocks() if "companion" in block.records])
    apart = rows[rows[:, PLACE["ball"]] == APART]
    assert run.report.errors["horizon_s"] < 0.1
    assert apart[:, PLACE["begin"]].max() < 0.05  # one set out in the part that begins at 157 ms
    beyond, within = ([one[1] for one in made if (one[0] >= one[2]) == far] for far in (True, False))
    assert len(beyond) >= 5
    assert set(beyond) == {BEYOND}
    assert max(within) <= 1.0
    assert run.simulation._motion.setting <= 1.0
    assert run.simulation._motion.companion.horizon >= run.report.errors["horizon_s"]


def test_steps_beyond_a_horizon_give_the_statistics_that_shorter_ones_give():
    """Means over 0.8 s in ten blocks: of loads and their spread, contacts without one, roll rates, and the spacing."""
    found = []
    for tolerance in (1e-1, 1e-4):
        scene, differs = at_length("eleven balls, loose")
        run = simulate(load_scene(scene, (*differs, f"wanted.tolerance={tolerance}")))
        blocks = list(run.blocks())
        assert run.report.errors["horizon_s"] < 0.2
        load, roll, angle = (
            np.concatenate([one.values[name] for one in blocks])[200:]
            for name in ("normal_load", "roll_rate", "orbit_angle")
        )
        inner = load[..., 0]
        series = inner.mean(1), inner.std(1), (inner == 0.0).mean(1), roll.mean(1), angle.std(1)
        means = np.array([[part.mean() for part in np.array_split(one, 10)] for one in series])
        found.append((means.mean(1), means.std(1, ddof=1) / np.sqrt(10.0)))
    (one, spread), (other, also) = found
    assert np.all(np.abs(one - other) < 3.0 * np.hypot(spread, also))
    assert np.all(np.hypot(spread, also) < 0.2 * np.abs(other))  # else they would agree whatever they were


def test_what_growth_knows_is_plain_data_and_known_again():
    growth = Growth(1e-4)
    for ball, end, friction in ((APART, 0.031, 1e-6), (3, 0.04, 1e-5), (UNKNOWN, 0.07, 2.0), (APART, 0.032, 2e-3)):
        row = np.zeros(len(WINDOW.columns))
        row[0], row[PLACE["begin"]], row[PLACE["ball"]], row[PLACE["friction"]] = end, 0.0308, ball, friction
        growth.add(row, 50.0)
    other = Growth(1e-4)
    other.remember(json.loads(json.dumps(growth.memory())))
    assert vars(other) == vars(growth)
    assert (other.horizon, other.horizon_seen) == (0.0308, 0.0308)
    with pytest.raises(KeyError):
        other.remember({})


def test_a_part_is_read_once_for_all_that_is_asked_of_its_outputs(monkeypatch):
    """Of balls that hop, for whom most is asked."""
    scene, reads = load_scene("bearing_6203_loose"), []
    moving = WatchedMotion(scene.parameters, choose(scene))

    class Counted(Rows):
        def __getitem__(self, name):
            reads[-1].append(name)
            return super().__getitem__(name)

    def look(part):
        reads.append([])
        part.out = Counted(part.out.layout, part.out.numbers)
        WatchedMotion._look(moving, part)

    monkeypatch.setattr(moving, "_look", look)
    for _ in range(3):
        moving.advance(1e-3 * np.arange(1, 21), 0.02)
    assert len(reads) >= 3
    balance = ["approach", "contact_angle", "raceway_force", "raceway_torque"]
    assert all(sorted(part) == sorted(["friction_force", "normal_load", *balance]) for part in reads)


@pytest.mark.parametrize("acceleration", [0.0, 1e3])
def test_windows_of_a_part_take_one_call_and_give_the_same_bits_as_each_by_itself(acceleration, monkeypatch):
    """Of other balls, lengths and beginnings; where the drive accelerates, those that begin together."""
    scene, parts = load_scene("bearing_6203_loose"), []
    moving = WatchedMotion(scene.parameters, choose(scene))
    monkeypatch.setattr(moving, "_look", parts.append)
    moving.advance(1e-3 * np.arange(1, 21), 0.02)
    part = parts[0]
    part.drive = part.drive._replace(acceleration=acceleration)
    windows = [Window(0, -1, 4), Window(5, 2, 9), Window(5, -1, 2), Window(ALL, 3, 2)]
    groups = together(part, windows)
    assert sorted(map(len, groups)) == ([1, 1, 2] if acceleration else [1, 3])
    calls, stepped = [], beside.rosenbrock_chunk

    def counted(task, coupling, balls, *rest):
        calls.append(len(balls))
        return stepped(task, coupling, balls, *rest)

    monkeypatch.setattr(beside, "rosenbrock_chunk", counted)
    for group in groups:
        if group[0].ball == ALL:
            continue
        calls.clear()
        found = some_beside(part, group, moving.scales)
        assert calls == [len(group)]
        for window, one in zip(group, found, strict=True):
            (by_itself,) = some_beside(part, [window], moving.scales)
            assert len(one.states) == window.length
            assert one.steps == by_itself.steps > 0
            assert (one.states == by_itself.states).all()
            assert np.array_equal(one.out["normal_load"], by_itself.out["normal_load"])
            assert all((mine == his).all() for mine, his in zip(one.last, by_itself.last, strict=True))
    monkeypatch.setattr(
        beside, "rosenbrock_chunk", lambda task, *rest: STALLED if len(task.times) > 4 else counted(task, *rest)
    )
    assert [one is None for one in some_beside(part, windows[:3], moving.scales)] == [False, True, False]


def test_a_drive_later_on_is_the_same_in_one_go_and_in_two():
    drive = RingDrive(0.3, 20.0, 500.0)
    twice = drive_later(drive_later(drive, 0.01), 0.02)
    assert twice == pytest.approx(drive_later(drive, 0.03), rel=1e-12)
    assert twice == pytest.approx((0.3 + 0.03 * 0.5 * (20.0 + 35.0), 35.0, 500.0), rel=1e-12)


@pytest.fixture(scope="module")
def part():
    """A part of a run with an even cage, of 15 outputs within 15 ms in which the ring turns by 3 rad."""
    return part_of(load_scene("bearing_6203", ("drive.speed=200", "cage.kind=even")), 15)[1]


WHOLE, INSIDE = Window(ALL, 3, 10), slice(4, 14)
ERRORS = [column.name for column in WINDOW.columns[PLACE["load"] :]]


def told_of(part, states=None, **off):
    """What `deviations` tells that is not 0, by its name, of a companion with these states and changed channels."""
    out = type(part.out)(part.out.layout, part.out.rows(INSIDE).numbers.copy())
    for name, (place, amount) in off.items():
        out[name][place] -= amount
    found = Found(out, part.filled[0][INSIDE] if states is None else states, (), 0)
    told = dict(zip(ERRORS, deviations(part, WHOLE, found, 1.0), strict=True))
    return {name: value for name, value in told.items() if value}


def part_of(scene, count):
    """The motion of a scene, and the first part of it that its companion looked at, of so many outputs 1 ms apart."""
    parts, look = [], Companion.look
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Companion, "look", lambda self, part, *rest: parts.append(part) or look(self, part, *rest))
        moving = WatchedMotion(scene.parameters, choose(scene))
        moving.advance(1e-3 * np.arange(1, count + 1), 1e-3 * count)
    return moving, parts[0]


def test_a_window_within_a_load_that_grows_begins_under_what_acts_then():
    """A free ring under 20 N more each millisecond, from the tenth on."""
    grows = "rings.inner.change={time: 0}", "rings.inner.table=[[0,0,0,0,0,0],[1,0,-20000,0,0,0]]"
    scene = load_scene("bearing_6203_step_load", grows)
    moving, part = part_of(scene, 15)
    found = all_beside(scene.parameters, part, Window(ALL, 9, 5), moving.scales)
    assert np.abs(found.out["normal_load"] - part.load[10:15]).max() < 1e-4 * part.load.max()


def test_a_companion_is_tighter_for_the_ring_as_well_which_alone_rings():
    """Else it takes the steps of the run, and finds what the run found."""
    scene = load_scene("bearing_6203_step_load", ("rings.inner.change={time: 5e-4, load: [0,-20,0]}",))
    moving, part = part_of(scene, 15)
    each = []
    for share in (1.0, 1e-3):
        partners = part.partners._replace(scales=share * part.partners.scales)
        finer = dataclasses.replace(part, partners=partners)
        each.append(all_beside(scene.parameters, finer, Window(ALL, 4, 10), share * moving.scales).out["normal_load"])
    run, companion = (np.abs(one - each[1]).max() for one in (part.load[5:15], each[0]))
    assert 0.0 < companion < 0.5 * run


def test_a_loose_ball_is_followed_from_the_beginning_of_its_part_which_its_row_says():
    load = np.ones((10, 3, 2))
    load[6, 2] = 0.0
    part = SimpleNamespace(all_bear=False, load=load, times=np.arange(1.0, 11.0), elapsed=100.0)
    assert to_the_end(part, Window(2, 4, 2), 104.0) == (Window(2, -1, 10), 100.0)
    assert to_the_end(part, Window(1, 4, 2), 104.0) == (Window(1, 4, 5), 104.0)


def test_errors_of_a_window_are_those_of_its_channels_each_in_its_own_unit(part):
    """Of a ball at one output; the sign of a mean over all outputs is kept."""
    for channel, place, column in (
        ("normal_load", (3, 2, 0), "load"),
        ("contact_angle", (3, 2, 1), "contact_angle"),
        ("roll_rate", (3, 2), "roll_rate"),
        ("inner_ring_offset", (3, 1), "ring_displacement"),
        ("inner_ring_force", (3, 1), "ring_force"),
    ):
        assert told_of(part, **{channel: (place, -1e-3)}) == {column: pytest.approx(1e-3, rel=1e-6)}
    told = told_of(part, raceway_torque=((3, 2, 0), 1e-6))
    run, exact = (np.linalg.norm(part.out["raceway_torque"][7, 2] - [one, 0.0, 0.0]) for one in (0.0, 1e-6))
    assert told["torque"] == pytest.approx(1e-6, rel=1e-6)
    assert told["mean_torque"] == pytest.approx((run - exact) / 10.0, rel=1e-6)
    # over what friction can give: mu N of a contact, mu N R of a ball
    bearing, load = part.bearing, part.load[7, 2]
    assert told["friction"] == pytest.approx(
        1e-6 / (bearing.friction_coefficient * load.sum() * bearing.ball_radius), rel=1e-6
    )
    told = told_of(part, friction_force=((3, 2, 1, 0), 1e-3))
    assert told == {"friction": pytest.approx(1e-3 / (bearing.friction_coefficient * load[1]), rel=1e-6)}


def test_errors_of_power_and_of_the_drive_are_over_the_time_and_the_angle_of_their_window(part):
    """Each ball loses 2 uJ and is given 3 uJ too much within 10 ms, in which the ring turns by 2 rad."""
    states = part.filled[0][INSIDE].copy()
    states[-1, :, DISSIPATED] -= 2e-6
    states[-1, :, DRIVE_WORK] -= 3e-6
    told = told_of(part, states)
    assert told == pytest.approx({"drive_torque": 3e-6 / 2.0, "loss": 2e-6 / 0.01}, rel=1e-6)


def test_how_far_a_ball_has_gone_round_is_no_error_that_comes_back(part):
    allowed, moved = np.full(MOTION, 1e-9), part.filled[0][INSIDE].copy()
    moved[-1, 2, ORBIT_ANGLE] += 1e-3
    assert left_over(part, WHOLE, Found(part.out, moved, (), 0), allowed) == 0.0
    assert told_of(part, moved) == {"orbit_angle": pytest.approx(1e-3, rel=1e-6)}
    moved[-1, 2, AXIS_DISTANCE] += 2e-9
    assert left_over(part, WHOLE, Found(part.out, moved, (), 0), allowed) == pytest.approx(2.0, rel=1e-6)


@pytest.mark.parametrize("ball", [3, ALL])
def test_who_is_followed_is_known_again_and_what_none_tells_is_refused(ball):
    rows = 8 if ball == ALL else 1
    last = [np.ones(shape).tolist() for shape in ((rows, COLUMNS), (rows, 4), rows, (rows, CARRIED_COLUMNS), BORDER)]
    found = followed_as([ball, 0.5, last, 2.0], 8)
    assert (found.ball, found.begin, found.left) == (ball, 0.5, 2.0)
    assert [array.tolist() for array in found.last] == last
    for told in ([8, 0.5, last, 2.0], [-2, 0.5, last, 2.0], [ball, 0.5, last[:4], 2.0], [ball, 0.5, last[::-1], 2.0]):
        with pytest.raises(ValueError, match="followed"):
            followed_as(told, 8)
