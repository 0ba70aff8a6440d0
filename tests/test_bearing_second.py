"""What goes beside a run whose balls bump into a cage: all that the run is off, and up to when that is known."""

import json
from itertools import pairwise

import numpy as np
import pytest

from bearing_twin.charts.bearing_cells import errors
from bearing_twin.charts.bearing_variants import UNSEEN
from bearing_twin.charts.tolerance import METHOD, ToleranceRow, beside_truth, up_to
from bearing_twin.kinds.bearing.companion import companion, second
from bearing_twin.kinds.bearing.companion.growth import BUMPED, Growth
from bearing_twin.kinds.bearing.companion.second import STRETCHES, Second, stretches
from bearing_twin.kinds.bearing.companion.windows import ALL, APART, BESIDE, PLACE, WINDOW, Window
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, LAND_WORK, LOST, MOTION, SHAFT_WORK, WORK_DONE
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.kinds.bearing.watched import WatchedMotion
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

PRESSED = ("cage.kind=pockets", "drive.offset=[0,0,2e-5]", "run.duration=0.05")  # thrust carries all balls


def ran(scene, *overrides):
    """A run to its end, its outputs but the first, and the windows of its companion."""
    run = simulate(load_scene(scene, overrides))
    blocks = list(run.blocks())
    rows = [block.records["companion"] for block in blocks if "companion" in block.records]
    found = Rows(blocks[0].values.layout, np.concatenate([block.matrix() for block in blocks])[1:])
    return run, found, np.concatenate(rows) if rows else None


def beside(rows):
    return rows[rows[:, PLACE["ball"]] == BESIDE]


@pytest.mark.parametrize(
    ("case", "seconds", "tolerance"), [("ring, pockets", 0.03, 1e-3), ("pockets, off centre", 0.1, 1e-2)]
)
def test_a_run_whose_balls_bump_is_within_its_tolerance_up_to_the_horizon_and_not_beyond(case, seconds, tolerance):
    """What it says of the stretches up to there and behind is what it is off, against a run that is far more exact."""
    scene, differs = UNSEEN[case]
    what = *differs, f"run.duration={seconds}"
    run, found, rows = ran(scene, *what, f"wanted.tolerance={tolerance}")
    exact = ran(scene, *what, "wanted.tolerance=1e-8", "solver.companion=off")[1]
    motion, rate = BearingMotion(run.scene.parameters, run.choice), run.scene.parameters.run.output_rate
    horizon, greatest = run.report.errors["horizon_s"], float(exact.normal_load.max())
    first = [up_to(one, round(horizon * rate)) for one in (found, exact)]
    assert 0.1 * seconds < horizon < 0.9 * seconds
    assert max(errors(motion, *first, greatest)) <= tolerance
    assert max(errors(motion, found, exact)) > 3.0 * tolerance
    assert run.report.status.startswith("doubtful")
    assert "times since steps made them" in run.report.errors["errors_unknown"]["horizon"]
    for row in beside(rows)[:4]:
        here = slice(round(row[PLACE["begin"]] * rate), round(row[0] * rate))
        one, other = (Rows(rows_of.layout, rows_of.numbers[here]) for rows_of in (found, exact))
        true = errors(motion, one, other, greatest)[1]
        assert true / 3.0 < row[PLACE["friction"]] < 3.0 * true


def test_nothing_goes_beside_a_run_whose_balls_do_not_bump():
    run, _, rows = ran("bearing_6203", *PRESSED)
    assert run.report.status == "done"
    assert not len(beside(rows))
    assert "horizon_s" not in run.report.errors


@pytest.mark.parametrize(
    ("scene", "tolerance", "differs"),
    [
        (
            "bearing_6203_start",
            1e-3,
            ("drive.offset=[-5.65e-6, -1.66e-7, 1.07e-5]", "geometry.radial_clearance=1.27e-5"),
        ),
        ("bearing_6203_loose", 1e-1, ("initial.motion=rest", "gravity=[0, -9.81, 0]", "run.duration=0.04")),
        # At 246 rad/s runs at 1e-7 and 1e-8 are 0.24 of mu N apart: what is true is not known there.
        ("bearing_6203_fast", 1e-2, ("initial.motion=rest", "geometry.radial_clearance=2.05e-5", "drive.speed=246.2")),
    ],
)
def test_balls_of_an_even_cage_that_bounce_are_followed_and_keep_their_tolerance_or_say_so(scene, tolerance, differs):
    """Windows of all balls, which begin on the run's own states, show 0.13 to 0.001 of what these are off."""
    row = ToleranceRow(scene, METHOD, tolerance)
    row = beside_truth(row, (scene, *differs, "cage.kind=even", "model.dimension=prescribed"), (), 0.0)
    assert row.status == "done"
    assert row.kept or row.doubtful
    assert all(0.1 < ratio < 10.0 for ratio in row.ratios if ratio * row.error > 1e-3 * tolerance)


def test_balls_in_flight_are_followed_as_far_as_steps_allow():
    """A shaft that runs up throws balls for a third of a second."""
    run, _, rows = ran("bearing_6203_run_up")
    assert run.report.status == "done"
    first = beside(rows)[:, PLACE["begin"]].min()
    assert first == 0.0
    assert 0.0 < run.report.errors["companion_share"] < 0.35


def test_stretches_follow_each_other_through_a_part():
    assert list(stretches(6)) == [Window(BESIDE, begin, 2) for begin in (-1, 1, 3)]
    assert list(stretches(2)) == [Window(BESIDE, -1, 1), Window(BESIDE, 0, 1)]
    assert [one.length for one in stretches(21)] == [6, 6, 6, 3]
    assert len(list(stretches(1000))) == STRETCHES


def a_row(ball, begin, end, friction):
    row = np.zeros(len(WINDOW.columns))
    row[0], row[PLACE["begin"]], row[PLACE["ball"]], row[PLACE["friction"]] = end, begin, ball, friction
    return row


@pytest.mark.parametrize(("off", "horizon"), [(1.1 * BUMPED, 0.02), (0.9 * BUMPED, None)])
def test_errors_grow_where_they_are_far_beyond_what_any_window_shows(off, horizon):
    """Of a window at the tolerance itself: what steps make is told as any other error, and is no horizon."""
    growth = Growth(1e-4)
    rows = (0.0, 0.02, 2e-5), (0.02, 0.04, 2e-4), (0.04, 0.06, 1e-4 * off)
    for row in (a_row(ALL, 0.03, 0.031, 1e-4), *(a_row(BESIDE, *one) for one in rows)):
        growth.add(row, 50.0)
    assert growth.horizon == horizon


def moved(outputs=20, case="pockets, off centre"):
    """A motion whose balls bump, after so many outputs, and the records of it."""
    scene = load_scene(*UNSEEN[case])
    moving = WatchedMotion(scene.parameters, choose(scene))
    times = 1e-3 * np.arange(1, outputs + 1)
    moving.advance(times, times[-1])
    return moving, moving.take_records()["companion"], scene, times


def test_it_goes_on_from_a_snapshot_to_the_bit():
    moving, rows, scene, times = moved()
    assert len(beside(rows)) == STRETCHES
    assert moving.companion.second.apart is not None
    kept = json.loads(json.dumps(moving.snapshot()))
    moving.advance(times, times[-1])
    other = WatchedMotion(scene.parameters, choose(scene))
    other.resume(kept)
    other.advance(times, times[-1])
    assert np.array_equal(moving.take_records()["companion"], other.take_records()["companion"])
    old = json.loads(json.dumps(kept))
    del old["companion"]["second"]  # a snapshot of before
    other.resume(old)
    assert other.companion.second.apart is None


@pytest.mark.parametrize("told", [5, ["a"], [[1.0]], [0.0, [1.0]], [0.0, [[1.0, 2.0]], [3.0]], [0.0, "a", "b"]])
def test_what_no_memory_is_is_refused(told):
    fresh = Second(load_scene("bearing_6203", PRESSED).parameters)
    with pytest.raises((TypeError, ValueError)):
        fresh.remember(told)
    assert fresh.memory() == [0.0]


def test_it_is_the_same_however_a_run_is_cut():
    scene = load_scene(UNSEEN["ring, pockets"][0], (*UNSEEN["ring, pockets"][1], "run.duration=0.06"))
    simulation = Simulation(scene)
    whole = simulation.advance(61).records["companion"]
    simulation.reset()
    parts = [simulation.advance(count) for count in (1, 15, 25, 20)]
    assert np.array_equal(np.concatenate([one.records["companion"] for one in parts if one.records]), whole)


def test_integrals_are_told_of_each_stretch_by_itself():
    """Work of the drive and losses add up along a run; what they are off must not: it is over a stretch's time."""
    states, border = moved()[0].companion.second.apart
    assert np.abs(states[:, :MOTION]).max() > 0.0
    assert not states[:, MOTION:].any()
    assert not border[[WORK_DONE, LOST, LAND_WORK, SHAFT_WORK]].any()


def test_it_begins_where_it_got_to_in_the_part_before(monkeypatch):
    """State of balls and of ring and cage: as far off the run's as at the end of that part, on the same side."""
    begun, ended, starts = [], [], []
    real, start = second.all_beside, second.all_start

    def beside_too(parameters, part, window, scales, last, until):
        found = real(parameters, part, window, scales, last, until)
        if window.begin < 0:
            begun.append([np.array(one) for one in (last[0], last[4])])
        if until is not None:
            ended.append([np.array(one) for one in (found.last[0], found.last[4])])
        return found

    def start_too(*what):
        found = start(*what)
        starts.append([np.array(one) for one in (found[0][0], found[1])])
        return found

    monkeypatch.setattr(second, "all_beside", beside_too)
    monkeypatch.setattr(second, "all_start", start_too)
    moving, _, _, times = moved(10, "ring, pockets")
    apart = [one.copy() for one in moving.companion.second.apart]
    moving.advance(times, times[-1])
    assert len(begun) == len(starts) == 2
    for i, (there, moves) in enumerate(((begun[1][0], slice(None, MOTION)), (begun[1][1], slice(None, WORK_DONE)))):
        off = (ended[0][i] - starts[1][i])[..., moves]  # the second part begins where the run's first one ended
        assert np.abs(off).max() > 0.0
        assert there[..., moves] == pytest.approx(ended[0][i][..., moves], rel=1e-12, abs=1e-15)
        assert apart[i][..., moves] == pytest.approx(off, rel=1e-9, abs=1e-15)


def test_integrals_of_ring_and_cage_begin_each_stretch_as_the_runs(monkeypatch):
    seen = []
    real = second.all_beside

    def beside_too(parameters, part, window, scales, last, until):
        found = real(parameters, part, window, scales, last, until)
        seen.append((window, last[4].copy(), part.filled[2].copy(), found.last[4].copy()))
        return found

    monkeypatch.setattr(second, "all_beside", beside_too)
    moved(case="ring, pockets")
    assert len(seen) > 1
    for (_, _, border, ended), (window, last, *_) in pairwise(seen):
        assert np.array_equal(last[second.WORKS], border[window.begin][second.WORKS])
        assert not np.array_equal(ended[second.WORKS], last[second.WORKS])


def test_a_copy_sets_out_from_where_the_second_motion_got_to(monkeypatch):
    """Balls that bounced until a part are off across the raceways, too, by what is known then."""
    scene, differs = UNSEEN["6205, loose, slow"]
    real, motions, found = companion.all_beside, [], []

    def second_of(parameters):
        motions.append(Second(parameters))
        return motions[-1]

    def beside_too(parameters, part, window, *what):
        if window.ball == APART and window.begin < 0:
            found.append((what[1][0] - part.begun[0], motions[-1].apart))
        return real(parameters, part, window, *what)

    monkeypatch.setattr(companion, "Second", second_of)
    monkeypatch.setattr(companion, "all_beside", beside_too)
    ran(scene, *differs, "wanted.tolerance=0.01")
    off, (states, _) = next(one for one in found if one[1] is not None)
    assert np.abs(states[:, AXIS_DISTANCE]).max() > 0.0
    assert off[:, :MOTION] == pytest.approx(states[:, :MOTION], rel=1e-6, abs=1e-15)
