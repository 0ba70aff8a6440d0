"""A ring that is thrown across its clearance: how far its errors grow, by a motion from before it."""

import copy
import json
from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin.charts.tolerance import METHOD, ToleranceRow, beside_truth
from bearing_twin.kinds.bearing import watched
from bearing_twin.kinds.bearing.companion import throws
from bearing_twin.kinds.bearing.companion.deviations import Part
from bearing_twin.kinds.bearing.companion.earlier import Earlier, stiffest
from bearing_twin.kinds.bearing.companion.inherited import carried_on
from bearing_twin.kinds.bearing.companion.pointers import SLIDING, pointers
from bearing_twin.kinds.bearing.companion.throws import Throws, Witness, thrown, unheld
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
from bearing_twin.kinds.bearing.forces.layout import MOTION, PLACES, RING_X, RING_Y
from bearing_twin.kinds.bearing.stepping.pointing import POINTED
from bearing_twin.kinds.bearing.watched import WatchedMotion
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
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
    moving = half(tolerance)
    moving.advance(np.arange(1, 51) * 1e-3, 0.05)
    return next(one for one in found if thrown(one[1])), [one for one in found if not thrown(one[1])], moving


def half(tolerance):
    """The motion of a ring half of whose load goes at 20 ms."""
    words = *HALVES, "wanted.outputs=loads", f"wanted.tolerance={tolerance}"
    scene = load_scene("bearing_6203_rig_1000N", words)
    return WatchedMotion(scene.parameters, choose(scene))


def shown(moving, part, scales, pushed=0.0):
    """What a motion shows beside a part that sets out before it, its ring `pushed` [m/s] along its load."""
    earlier, told = Earlier(moving.bearing.balls), copy.deepcopy(moving.companion.throws.earlier.memory())
    told[0][2][-1][PLACES + RING_Y] -= pushed
    earlier.remember(told)
    return Witness(*earlier.beside(part, scales), scales).beside(moving.parameters, part, greatest_of(moving))


def greatest_of(moving):
    """The greatest load [N] that a motion has met."""
    return moving.companion.greatest_load


def test_a_motion_from_before_a_throw_shows_what_a_ring_brings_into_it(monkeypatch):
    """Twice as far off before, the run is twice as far off after, where what steps add is little."""
    (_, part, scales, told), others, moving = through(1e-5, monkeypatch)
    assert told.load > 0.0
    assert all(one[-1] is None for one in others)
    none, once, twice = (shown(moving, part, scales, times * 1e-2) for times in (0.0, 1.0, 2.0))
    assert none.load < 0.2 * once.load
    assert twice.load / once.load == pytest.approx(2.0, rel=0.15)
    assert 0 < once.found.steps < 2.0 * part.pointer[..., 2].sum()


def test_where_it_gets_to_before_a_throw_is_nearer_to_the_truth_than_the_run_is(monkeypatch):
    """Against a run with a thousandth of the tolerance: so the difference is the run's error."""
    begun, one = [], Earlier.beside
    monkeypatch.setattr(
        Earlier,
        "beside",
        lambda earlier, part, scales: begun.append((part, one(earlier, part, scales))) or begun[-1][1],
    )
    half(1e-4).advance(np.arange(1, 31) * 1e-3, 0.03)
    exact = half(1e-7)
    exact.advance(np.arange(1, 21) * 1e-3, 0.02)
    part, (last, steps) = begun[0]
    assert part.elapsed == pytest.approx(0.02)
    assert steps > 0
    for columns in (slice(RING_X, RING_Y + 1), slice(PLACES + RING_X, PLACES + RING_Y + 1)):
        run, found, true = (border[columns] for border in (part.begun[4], last[4], exact.border))
        assert np.linalg.norm(found - true) < 0.5 * np.linalg.norm(run - true)
    assert np.array_equal(last[0][:, MOTION:], part.begun[0][:, MOTION:])  # works are those of the run


def test_a_motion_beside_a_thrown_ring_ends_once_the_ring_lies_and_errors_fade(monkeypatch):
    """Nothing that it would have shown later is greater; where they do not fade it goes on to the end of the part."""
    (_, part, scales, _), _, moving = through(1e-5, monkeypatch)
    ended = shown(moving, part, scales, 1e-4)
    monkeypatch.setattr(throws, "FADED", 0.0)
    whole = shown(moving, part, scales, 1e-4)
    assert ended.window.length < whole.window.length == len(part.times) == len(whole.found.out.numbers)
    assert ended.window.length >= throws.FAR * (1 + np.flatnonzero(unheld(part))[-1])
    assert ended.found.steps < 0.8 * whole.found.steps
    assert (ended.load, ended.friction) == (whole.load, whole.friction)
    assert np.array_equal(ended.found.states, whole.found.states[: ended.window.length])


def test_a_motion_beside_a_thrown_ring_goes_on_while_balls_hop(monkeypatch):
    """They make what had faded grow: a run was off by fifty times its tolerance, of which a hundredth was told."""
    (_, part, scales, _), _, moving = through(1e-5, monkeypatch)
    assert shown(moving, part, scales).window.length < len(part.times)
    part.in_flight[-1, 0] = True
    assert shown(moving, part, scales).window.length == len(part.times)
    monkeypatch.setattr(throws, "CARRIED", 0.0)
    assert shown(moving, part, scales).window.length < len(part.times)  # off by more than is wanted in any case


def test_a_part_that_is_done_again_has_the_motion_beside_the_first_go_as_a_witness(monkeypatch):
    """It costs nothing more. Where the run was off by far more than is wanted, so may be this motion: another goes."""
    (_, part, scales, _), _, moving = through(1e-5, monkeypatch)
    monkeypatch.setattr(throws, "FADED", np.inf)
    going, greatest = Throws(moving.parameters), greatest_of(moving)
    going.earlier.remember(moving.companion.throws.earlier.memory())
    first, steps = going.through(part, scales, False, greatest)
    assert first.over(moving.parameters, greatest) < throws.CARRIED
    assert steps == first.found.steps > 0
    part.out["normal_load"][...] *= 1.0 + 1e-4
    again, none = going.through(part, scales, True, greatest)
    assert none == 0
    assert again.load > first.load
    assert going.through(part, scales, False, greatest)[1] == steps  # another part, which is off by too much
    assert going.through(part, scales, True, greatest)[1] == steps


def test_what_lies_before_a_throw_is_kept_as_far_back_as_a_ring_rings(monkeypatch):
    """In time of the run, from an output on; a go at a part that is done again takes the place of the one before."""
    (_, part, scales, _), _, moving = through(1e-5, monkeypatch)
    earlier = Earlier(moving.bearing.balls)
    for begun in (0.0, 0.03, 0.03, 0.06):
        part.elapsed = begun
        earlier.passed(part, 0.01)
    kept = [one[:2] for one in earlier.memory()]
    assert np.allclose(kept, [[0.05, 0.01], [0.08, 0.01]], rtol=0.0, atol=1e-12)
    part.elapsed = 0.09
    whole, _ = earlier.beside(part, scales)
    assert not np.array_equal(whole[0][:, :MOTION], part.begun[0][:, :MOTION])
    part.bearing = part.bearing._replace(offset=(1e-6, 0.0, 0.0))  # shifted at once: where it was before is elsewhere
    begun, steps = earlier.beside(part, scales)
    assert steps == 0
    assert np.array_equal(begun[0], part.begun[0])
    earlier.passed(part, 0.0)  # nothing rings
    assert [one[:2] for one in earlier.memory()] == kept


def test_what_lies_before_a_throw_is_in_a_snapshot():
    """Halfway to the throw, the run goes on to the bit; that of another bearing is refused, an older one has none."""
    moving, times = half(1e-3), np.arange(1, 13) * 1e-3
    moving.advance(times, 0.012)
    kept = json.loads(json.dumps(moving.snapshot()))
    assert kept["companion"]["earlier"]
    ended = []
    for other in (moving, half(1e-3), half(1e-3)):
        if len(ended) == 2:
            del kept["companion"]["earlier"]
        if ended:
            other.resume(kept)
        other.advance(np.arange(1, 31) * 1e-3, 0.03)
        ended.append((other.state, other.take_records()[WINDOW.name][-1]))
    assert all(np.array_equal(*pair) for pair in zip(*ended[:2], strict=True))
    assert not np.array_equal(ended[1][1], ended[2][1])
    told = moving.companion.throws.earlier.memory()
    with pytest.raises(ValueError, match="earlier"):
        Earlier(moving.bearing.balls + 1).remember(told)


def test_a_chunk_is_done_again_where_steps_before_a_throw_made_what_a_run_is_off(monkeypatch):
    """Its throw was first seen once the part was done again, and its error left too great: the run was doubtful."""
    words = ("bearing_6203_rig_1000N", *HALVES, "run.duration=1", "wanted.tolerance=1e-2")
    run = simulate(load_scene(words[0], words[1:]))
    for _ in run.blocks():
        pass
    assert run.report.status == "done"


def test_no_window_is_looked_at_where_a_motion_goes_beside_a_thrown_ring(monkeypatch):
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


def test_what_a_motion_beside_it_showed_is_what_a_thrown_ring_is_off(monkeypatch):
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
def test_a_ring_whose_load_reverses_keeps_its_tolerance_and_says_what_it_is_off(tolerance):
    """With a ring displaced by guess a run was off by 1.6 times its tolerance, unsaid, or said four times too much."""
    words = ("bearing_6203_rig_400N", "rings.inner.change={time: 0.02, load: [0, 250, 0]}", "drive.speed=140")
    row = beside_truth(ToleranceRow("reverses", METHOD, tolerance), (*words, "run.duration=0.05"), (), 0.0)
    assert row.kept
    assert not row.doubtful
    assert all(0.5 < ratio < 2.0 for ratio in row.ratios)


@pytest.mark.parametrize(
    ("scene", "time", "load", "speed", "tolerance"),
    [
        ("bearing_6203_rig_1000N", 0.0222, "717, 788", 232, 1e-2),  # a copy displaced by guess showed a fiftieth ...
        ("bearing_6203_rig_1000N", 0.0283, "-310, 910", 238, 1e-2),  # ... 22 times ...
        ("bearing_6203_rig_400N", 0.0310, "-200, 287", 125, 1e-3),  # ... 15 times what the run was off
    ],
)
def test_throws_drawn_by_chance_say_what_runs_are_off(scene, time, load, speed, tolerance):
    words = (scene, f"rings.inner.change={{time: {time}, load: [{load}, 0]}}", f"drive.speed={speed}")
    row = beside_truth(ToleranceRow("drawn", METHOD, tolerance), (*words, f"run.duration={time + 0.04:.3f}"), (), 0.0)
    assert row.kept or row.doubtful
    assert all(1.0 / 3.0 < ratio < 3.0 for ratio in row.ratios)


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
