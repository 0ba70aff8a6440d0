"""A ring that is thrown across its clearance: how far its errors grow, by a copy; balls that begin to roll."""

from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin.charts.tolerance import METHOD, ToleranceRow, beside_truth
from bearing_twin.kinds.bearing import watched
from bearing_twin.kinds.bearing.companion import throws
from bearing_twin.kinds.bearing.companion.deviations import Part
from bearing_twin.kinds.bearing.companion.inherited import carried_on, stiffest
from bearing_twin.kinds.bearing.companion.pointers import SLIDING, pointers
from bearing_twin.kinds.bearing.companion.throws import through_throw, thrown, unheld
from bearing_twin.kinds.bearing.companion.windows import (
    APART,
    BESIDE,
    LEAST_STEPS,
    PLACE,
    SLID,
    WINDOW,
    Window,
    since_begun,
    steps_before,
)
from bearing_twin.kinds.bearing.companion.worst import Worst
from bearing_twin.kinds.bearing.stepping.pointing import POINTED
from bearing_twin.kinds.bearing.watched import WatchedMotion
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene

HALVES = ("rings.inner.change={time: 0.02, load: [0, 500, 0]}", "drive.speed=170")


def through(tolerance, monkeypatch):
    """The part in which half a ring's load goes at 20 ms, with what is known of it, scales of steps and the motion."""
    found = []

    def noted(known, part, *rest):
        found.append((known, part, moving.scales.copy(), rest[-1]))
        return one(known, part, *rest)

    one = watched.carried_on
    monkeypatch.setattr(watched, "carried_on", noted)
    words = *HALVES, "wanted.outputs=loads", f"wanted.tolerance={tolerance}"
    scene = load_scene("bearing_6203_rig_1000N", words)
    moving = WatchedMotion(scene.parameters, choose(scene))
    moving.advance(np.arange(1, 51) * 1e-3, 0.05)
    return next(one for one in found if thrown(one[1])), [one for one in found if not thrown(one[1])], moving


def test_a_copy_that_starts_apart_shows_what_a_ring_is_off_that_is_thrown(monkeypatch):
    """Twice as far apart it is about twice as far off, where what steps add is little; others have no copy."""
    (_, part, scales, told), others, moving = through(1e-5, monkeypatch)
    assert told.load > 0.0
    assert all(one[-1] is None for one in others)
    greatest, off = moving.companion.greatest_load, 1e-1  # N: so much more than wanted that one copy says enough
    none, once, twice = (
        through_throw(moving.parameters, part, scales, times * off, 0.0, greatest) for times in (0.0, 1.0, 2.0)
    )
    assert none.load < 0.2 * once.load
    assert twice.load / once.load == pytest.approx(2.0, rel=0.1)
    across = through_throw(moving.parameters, part, scales, 0.0, off, greatest)
    assert across.load > 5.0 * none.load
    assert 0 < once.found.steps < 1.5 * part.pointer[..., 2].sum()
    outputs = []
    monkeypatch.setattr(throws, "all_beside", lambda parameters, part, window, *_: outputs.append(window.length))
    assert through_throw(moving.parameters, part, scales, off, 0.0, greatest) is None
    falls = np.flatnonzero(unheld(part))
    assert outputs == [throws.FAR * (1 + falls[-1])]  # once all have landed a ring may still knock to and fro
    assert not part.in_flight[-1].any()


def test_a_copy_of_a_thrown_ring_sets_out_with_the_speed_of_a_ring_that_swings(monkeypatch):
    """Its energy is that of two contacts in series pressed by what its load is off, or those across by its place."""
    (_, part, scales, _), _, moving = through(1e-5, monkeypatch)
    greatest, begun = moving.companion.greatest_load, []
    monkeypatch.setattr(throws, "all_beside", lambda *what: begun.append(what[-1][-1]))
    for off, wide in ((0.0, 0.0), (2e-2, 0.0), (0.0, 3e-2)):
        through_throw(moving.parameters, part, scales, off, wide, greatest)
    run, along, across = begun
    moved = {name: one - run for name, one in (("along", along), ("across", across))}
    stiffness, mass = stiffest(part.bearing.inner.law, greatest), moving.parameters.rings.inner.mass
    for one in moved.values():
        assert not np.delete(one, throws.SPEED).any()
    energy = {name: 0.5 * mass * np.square(one[throws.SPEED]).sum() for name, one in moved.items()}
    assert energy["along"] == pytest.approx(2e-2**2 / stiffness, rel=1e-6)  # each contact F^2 / 2k
    assert energy["across"] == pytest.approx(0.25 * 3e-2**2 / stiffness, rel=1e-6)  # k / 2 at a place F / k away
    load = (part.partners.load + part.partners.weight)[:2]
    assert moved["along"][throws.SPEED] @ load > 0.0
    assert abs(moved["across"][throws.SPEED] @ load) < 1e-9 * np.linalg.norm(load) * np.abs(moved["across"]).max()


def test_a_copy_of_a_thrown_ring_ends_once_the_ring_lies_and_errors_fade(monkeypatch):
    """Nothing that it would have shown later is greater; where they do not fade it goes on to the end of the part."""
    (_, part, scales, _), _, moving = through(1e-5, monkeypatch)
    what = moving.parameters, part, scales, 1e-1, 0.0, moving.companion.greatest_load
    ended = through_throw(*what)
    monkeypatch.setattr(throws, "FADED", 0.0)
    whole = through_throw(*what)
    assert ended.window.length < whole.window.length == len(part.times)
    assert ended.found.steps < 0.8 * whole.found.steps
    assert (ended.load, ended.friction) == (whole.load, whole.friction)
    assert np.array_equal(ended.found.states, whole.found.states[: ended.window.length])
    steps = len(whole.found.out.numbers), whole.found.states.shape[0]
    assert steps == (len(part.times), len(part.times))


def test_where_one_copy_does_not_decide_whether_a_thrown_ring_is_as_exact_as_wanted_a_second_one_goes(monkeypatch):
    (_, part, scales, _), _, moving = through(1e-5, monkeypatch)
    greatest, found = moving.companion.greatest_load, {}
    one = throws._copied
    monkeypatch.setattr(throws, "_copied", lambda *what: found.setdefault(tuple(what[-1][0]), one(*what)))
    for off, copies in ((1e-4, 1), (1e-2, 2), (1e-1, 1)):
        found.clear()
        told = through_throw(moving.parameters, part, scales, off, 0.0, greatest)
        assert len(found) == copies
        first = found[tuple(throws.SPEED)]
        over = max(first.load / greatest, first.friction) / 1e-5 if copies == 1 else None
        assert (told.errors == np.max([each.errors for each in found.values()], axis=0)).all()
        assert told.found.steps == sum(each.found.steps for each in found.values())
        assert over is None or not 1.0 / 3.0 < over <= 0.8


def test_a_copy_of_a_thrown_ring_goes_on_while_balls_hop(monkeypatch):
    """They make what had faded grow: a run was off by fifty times its tolerance, of which a hundredth was told."""
    (_, part, scales, _), _, moving = through(1e-5, monkeypatch)
    known = moving.parameters, part, scales
    less, more = ((*known, off, 0.0, moving.companion.greatest_load) for off in (1e-4, 1e-1))
    assert through_throw(*less).window.length < len(part.times)
    assert through_throw(*more).window.length < len(part.times)
    part.in_flight[-1, 0] = True
    assert through_throw(*less).window.length == len(part.times)
    assert through_throw(*more).window.length < len(part.times)  # which is off by more than is wanted in any case


def test_no_window_is_looked_at_where_a_copy_of_a_thrown_ring_goes(monkeypatch):
    rows = []
    one = watched.carried_on
    monkeypatch.setattr(
        watched, "carried_on", lambda known, part, found, *rest: _noted(rows, one, known, part, found, *rest)
    )
    through(1e-4, monkeypatch)
    assert any(copied for copied, _ in rows)
    assert all(not len(found) for copied, found in rows if copied)
    assert any(len(found) for copied, found in rows if not copied)


def _noted(rows, one, known, part, found, *rest):
    rows.append((rest[-1] is not None, found))
    return one(known, part, found, *rest)


def test_what_a_copy_showed_is_what_a_thrown_ring_is_off(monkeypatch):
    """In place of thirty times what windows show: it is told of the part, and what the next ones begin with."""
    (known, part, _, told), _, moving = through(1e-4, monkeypatch)
    rows = np.zeros((1, len(WINDOW.columns)))
    rows[0, :3], rows[0, PLACE["load"]] = (part.elapsed + 1e-3, part.elapsed, -1.0), 1e-3
    greatest, ringing = moving.companion.greatest_load, 0.05
    found = carried_on(known, part, rows, 1e-4, ringing, 0.0, greatest, 0.0, told)
    assert found.before[0, PLACE["load"]] == found.added[-1, PLACE["load"]] == told.load
    assert found.rows[-1, PLACE["friction"]] >= told.friction
    assert told.load * 10.0 ** (-part.duration / ringing) <= found.known[1] <= told.load
    guessed = carried_on(known, part, rows, 1e-4, ringing, 0.0, greatest)
    assert guessed.before[0, PLACE["load"]] == pytest.approx(30.0 * known[1])
    assert stiffest(part.bearing.inner.law, 0.0) == 0.0


@pytest.mark.parametrize(("tolerance", "wanted"), [(1e-1, "loads"), (1e-3, "loads"), (1e-3, "history")])
def test_a_run_whose_ring_is_thrown_says_what_it_is_off(tolerance, wanted):
    """Where thirty times were told, 20 to 200 times too much was, and runs took three times the steps."""
    words = ("bearing_6203_rig_1000N", *HALVES, "run.duration=0.05")
    row = ToleranceRow("half", METHOD, tolerance)
    row = beside_truth(row, words, (f"wanted.outputs={wanted}",), 0.0)
    assert row.kept
    assert not row.doubtful
    assert all(1.0 / 3.0 < ratio < 3.0 for ratio in row.ratios)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2, 1e-3, 1e-4])
def test_a_ring_whose_load_reverses_keeps_its_tolerance_by_what_its_speed_was_off(tolerance):
    """It swings across its load: with a ring displaced alone a run was off by 1.6 times its tolerance, unsaid."""
    words = ("bearing_6203_rig_400N", "rings.inner.change={time: 0.02, load: [0, 250, 0]}", "drive.speed=140")
    row = beside_truth(ToleranceRow("reverses", METHOD, tolerance), (*words, "run.duration=0.05"), (), 0.0)
    assert row.kept
    assert not row.doubtful
    assert all(0.5 < ratio < 4.0 for ratio in row.ratios)


@pytest.mark.parametrize(("load", "force", "share"), [(100.0, 10.0, 1.0), (100.0, 5.0, 0.5), (100.0, 0.1, 0.01)])
def test_what_points_to_slip_is_how_steeply_friction_changes_with_it(load, force, share):
    """(1 - f^2)^1.5 of friction f over mu N: where balls slide it is known, where they roll slip is small."""
    bearing = SimpleNamespace(friction_coefficient=0.1)
    out = {"normal_load": np.full((1, 1, 2), load), "friction_force": np.zeros((1, 1, 2, 3))}
    out["friction_force"][0, 0, :, 0] = force, 0.5 * force
    part = Part(
        bearing=bearing,
        out=out,
        partners=SimpleNamespace(active=False),
        pointer=np.ones((1, 1, POINTED)),
        **dict.fromkeys(("drive", "near", "times", "duration", "begun", "filled", "elapsed", "taken")),
    )
    grids, _ = pointers(part, 1.0)
    assert grids[SLIDING].shape == (1, 1)
    assert grids[SLIDING][0, 0] == pytest.approx(0.1 * share * (1.0 - share**2) ** 1.5)


def test_a_window_of_a_ball_that_slides_begins_with_its_part_where_that_is_near():
    most = int(SLID * LEAST_STEPS)
    before = steps_before(np.full(2 * most, 1.0))
    assert since_begun(Window(3, 5, 10), before) == Window(3, -1, 16)
    assert since_begun(Window(3, most, 10), before) == Window(3, most, 10)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2])
def test_balls_that_begin_to_roll_say_what_their_friction_is_off(tolerance):
    """Two of eight are between sliding and rolling at an output; either may be off ten times as far as the other."""
    words = ("bearing_6203_start", "drive.speed=60", "drive.offset=[0, -2e-6, 6e-6]", "run.duration=0.01")
    row = beside_truth(ToleranceRow("begin", METHOD, tolerance), words, (), 0.0)
    assert row.kept
    assert 1.0 / 3.0 < row.friction_estimate / row.friction_error < 3.0


def test_what_goes_on_since_a_run_began_has_in_its_loads_what_balls_are_off_their_way_round():
    worst = Worst()
    for ball in (APART, BESIDE):
        row = np.zeros(len(WINDOW.columns))
        row[PLACE["ball"]], row[PLACE["load"]], row[PLACE["orbit_angle"]] = ball, 2.0, 1e-3
        worst.add(row)
        assert row[PLACE["orbit_angle"]] == 1e-3  # as it is recorded
    assert worst.seen("load", 1.0, False) == 2.0
    assert worst.seen("orbit_angle", 1.0, False) == 0.0
