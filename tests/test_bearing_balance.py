"""What outputs are off between the ends of long steps, and how far what nobody looked at exceeds what windows show."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin.charts.bearing_cells import errors
from bearing_twin.charts.tolerance import METHOD, ToleranceRow, beside_truth, compared, up_to, words_of
from bearing_twin.kinds.bearing import measured, watched
from bearing_twin.kinds.bearing.companion import balance
from bearing_twin.kinds.bearing.companion.balance import in_longest_steps, off_balance, rung_out
from bearing_twin.kinds.bearing.companion.growth import Growth
from bearing_twin.kinds.bearing.companion.inherited import all_of_it
from bearing_twin.kinds.bearing.companion.meetings import LEAST_APART, Drift
from bearing_twin.kinds.bearing.companion.windows import ALL, APART, BESIDE, BETWEEN, BUMPING, INHERITED, PLACE, WINDOW
from bearing_twin.kinds.bearing.companion.worst import (
    MISSED,
    SPREAD_ALONE,
    SPREAD_CALM,
    SPREAD_TOGETHER,
    Worst,
    spread_of,
)
from bearing_twin.kinds.bearing.doubt import BearingDoubt
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, ORBIT_ANGLE
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.kinds.bearing.stepping.pointing import POINTED, STEPS_IN
from bearing_twin.kinds.bearing.watched import WatchedMotion
from bearing_twin.numerics.lanes import COLUMNS
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

OFF_CENTRE = "run.duration=0.06", "drive.offset=[0, -2e-6, 0]"


def parts_of(scene, *overrides, monkeypatch):
    """Outputs of a watched run, its rows of WINDOW, and what the balance says at them, of parts as they were kept."""
    found = {}

    def noted(parameters, part, tolerance, greatest):
        found[part.elapsed] = off_balance(part, False, np.arange(len(part.times)), greatest)
        return one(parameters, part, tolerance, greatest)

    one = watched.between_steps
    monkeypatch.setattr(watched, "between_steps", noted)
    loaded = load_scene(scene, overrides)
    moving = WatchedMotion(loaded.parameters, choose(loaded))
    rate, duration = loaded.parameters.run.output_rate, loaded.parameters.run.duration
    out = moving.advance(np.arange(1, round(rate * duration) + 1) / rate, duration)
    return out, moving.take_records()["companion"], np.concatenate([found[begun] for begun in sorted(found)])


def exact(scene, *overrides):
    """The outputs of a run that counts as true."""
    loaded = load_scene(scene, (*overrides, "wanted.tolerance=1e-8", "solver.companion=off"))
    moving = BearingMotion(loaded.parameters, choose(loaded))
    rate, duration = loaded.parameters.run.output_rate, loaded.parameters.run.duration
    return moving.advance(np.arange(1, round(rate * duration) + 1) / rate, duration)


@pytest.mark.parametrize("more", [(), ("cage.kind=even",)])
def test_loads_between_steps_are_off_by_what_their_balance_says(more, monkeypatch):
    """Steps are longer than the 1 ms between outputs; windows see a seventh of it where balls are taken alone."""
    monkeypatch.setattr(measured, "LIKE_MEASURED", (30.0, 1.0))  # steps as long as can be
    scene = "bearing_6203", *OFF_CENTRE, *more, "wanted.tolerance=1e-4"
    out, rows, said = parts_of(*scene, monkeypatch=monkeypatch)
    true, said = np.abs(out.normal_load - exact(*scene[:-1]).normal_load).max(axis=-1), said[..., 0]
    assert said.max() == pytest.approx(true.max(), rel=0.03)
    worst = true > 0.2 * true.max()
    assert np.median(said[worst] / true[worst]) == pytest.approx(1.0, abs=0.03)
    # Told is what outputs in the longest steps show.
    between = rows[rows[:, PLACE["ball"]] == BETWEEN]
    assert between[:, PLACE["load"]].max() == pytest.approx(said.max())
    if not more:
        assert rows[rows[:, PLACE["ball"]] >= ALL, PLACE["load"]].max() < 0.3 * true.max()
    run = simulate(load_scene(scene[0], scene[1:]))
    list(run.blocks())
    told = run.report.errors["wanted_errors"]["loads"]
    assert 0.95 < told["error"] * out.normal_load.max() / true.max() < 3.0


def test_balance_counts_how_far_contacts_lean(monkeypatch):
    """By 20 degrees, where half of what is left over would be 6 % less than what each raceway takes of it."""
    scene = "bearing_6203", "run.duration=0.06", "drive.offset=[0, -4e-6, 1e-4]", "wanted.tolerance=1e-4"
    out, _, said = parts_of(*scene, monkeypatch=monkeypatch)
    true, said = np.abs(out.normal_load - exact(*scene[:-1]).normal_load).max(axis=-1), said[..., 0]
    assert said.max() == pytest.approx(true.max(), rel=0.03)
    worst = true > 0.2 * true.max()
    assert np.median(said[worst] / true[worst]) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("scene", [("bearing_6203_fast", "run.output_rate=2000"), ("bearing_6203", *OFF_CENTRE)])
@pytest.mark.parametrize("more", [(), ("cage.kind=even",)])
def test_friction_between_steps_is_off_by_what_moments_and_forces_say(scene, more, monkeypatch):
    """Friction follows slip within microseconds: what an interpolant misses of slip is no balance of moments."""
    scene = scene[0], "run.duration=0.02", *scene[1:], *more, "wanted.tolerance=1e-3"
    out, _, said = parts_of(*scene, monkeypatch=monkeypatch)
    truth, parameters = exact(*scene[:-1]), load_scene(scene[0], scene[1:]).parameters
    limit, radius = parameters.contact.friction_coefficient, 0.5 * parameters.geometry.ball_diameter
    torque = np.linalg.norm(out.raceway_torque - truth.raceway_torque, axis=-1)
    force = np.linalg.norm(out.friction_force - truth.friction_force, axis=-1) / (limit * truth.normal_load)
    true = np.maximum(force.max(axis=-1), torque / (radius * limit * truth.normal_load.sum(axis=-1)))
    worst = true > 0.2 * true.max()
    ratio = said[..., 1][worst] / true[worst]
    if more:  # what the cage pushes is not known: the half that turns the ball is told
        assert 0.3 < np.median(ratio) < 1.0
        assert 0.3 < said[..., 1].max() / true.max() < 1.1
    else:
        assert np.median(ratio) == pytest.approx(1.0, abs=0.05)
        assert said[..., 1].max() == pytest.approx(true.max(), rel=0.1)


def test_a_run_is_not_done_again_for_friction_where_outputs_are_too_far_apart_for_accelerations():
    """Balls go round by 0.4 rad from output to output and roll in and out of load: 40 times too much would be told."""
    scene = load_scene(
        "bearing_6203_fast",
        (
            "geometry.radial_clearance=8.27e-6",
            "drive.tilt=[5.87e-4, -2.85e-4]",
            "model.dimension=prescribed",
            "wanted.tolerance=1e-2",
        ),
    )
    moving = WatchedMotion(scene.parameters, choose(scene))
    moving.advance(np.arange(1, 21) / 2000.0, 0.01)
    assert moving.setting > 0.1


@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_what_both_contacts_rub_follows_from_the_moment_and_the_force_that_are_left(angle):
    """By e_i and e_o, where the normal n meets the ball: the force is their sum, the moment R n x (e_o - e_i)."""
    n, across = np.array([np.cos(angle), 0.0, np.sin(angle)]), np.array([-np.sin(angle), 0.0, np.cos(angle)])
    along, radius, loads = np.array([0.0, 1.0, 0.0]), 3e-3, (20.0, 30.0)
    inner, outer = 0.02 * along - 0.01 * across, -0.01 * along + 0.04 * across
    force, torque = inner + outer + 5.0 * n, radius * np.cross(n, outer - inner) + 1e-3 * n
    given = balance._Given(1e-3, 1e-9, radius, 1.5, 1.5, (0.0, 0.0, 0.0), 0.1, 1e6, 0.1)
    share, turned = balance._rubs(given, False, loads, angle, tuple(torque), tuple(force))
    assert share == pytest.approx(max(np.linalg.norm(inner) / 20.0, np.linalg.norm(outer) / 30.0) / 0.1)
    assert turned == pytest.approx(radius * np.linalg.norm(outer - inner))
    # A cage may push along the orbit: that part of the sum is not known.
    half = 0.5 * (inner + outer)[1] * along
    share, _ = balance._rubs(given, True, loads, angle, tuple(torque), tuple(force))
    assert share == pytest.approx(max(np.linalg.norm(inner - half) / 20.0, np.linalg.norm(outer - half) / 30.0) / 0.1)


def test_outputs_in_the_longest_steps_are_looked_at_whichever_ball_takes_them():
    pointer = np.full((3, 300, POINTED), 50.0)
    pointer[1, 250:290, STEPS_IN] = pointer[2, 20:40, STEPS_IN] = 0.1
    part = SimpleNamespace(times=np.arange(300.0), pointer=pointer)
    here = in_longest_steps(part)
    assert len(here) == 100
    assert set(range(250, 290)) | set(range(20, 40)) <= set(here)
    assert (np.diff(here) > 0).all()


def test_balance_says_nothing_of_balls_that_swing_or_fly(monkeypatch):
    """A ring jumps by 5 um: where balls are thrown, or steps follow their swing, no acceleration is known."""
    scene = "bearing_6203_sudden", "run.duration=0.025", "wanted.tolerance=1e-4"
    out, _, said = parts_of(*scene, monkeypatch=monkeypatch)
    true, said = np.abs(out.normal_load - exact(*scene[:-1]).normal_load).max(axis=-1), said[..., 0]
    assert said.max() < 1.1 * true.max()
    assert not said[(out.normal_load == 0.0).any(axis=-1)].any()


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2])
def test_a_swing_that_long_steps_end_at_once_is_told(tolerance):
    """Contacts that hardly damp let it go on for milliseconds: 1.4 times what it is where it crosses an output."""
    scene = ("bearing_6203", "contact.relaxation_time=1e-8", "run.duration=0.02")
    row = beside_truth(ToleranceRow("swing", METHOD, tolerance), scene, ("wanted.outputs=loads",), 0.0)
    assert 1.0 < row.load_estimate / row.load_error < 2.0


def test_a_swing_falls_as_contacts_damp_it(monkeypatch):
    """To exp(-k tau t / 2 m) of what is left over of the forces at the start; steps that follow it lose nothing."""
    parts = []
    one = watched.between_steps
    monkeypatch.setattr(watched, "between_steps", lambda *given: parts.append(given) or one(*given))
    loaded = load_scene("bearing_6203", ("contact.relaxation_time=1e-8", "wanted.tolerance=1e-2"))
    moving = WatchedMotion(loaded.parameters, choose(loaded))
    moving.advance(np.arange(1, 11) * 1e-3, 0.01)
    parameters, part = parts[0][:2]
    bearing, load, depth = part.bearing, part.load[-1].mean(), part.out["approach"][-1].mean()
    rate = 1.5 * load / depth * bearing.relaxation_time / bearing.ball_mass  # 1/s, of both contacts
    first = rung_out(parameters, part)
    for tau, times in ((2e-8, 1.0), (5e-8, 4.0)):
        other = replace(part, bearing=bearing._replace(relaxation_time=tau))
        assert rung_out(parameters, other) / first == pytest.approx(np.exp(-times * rate * 1e-3), rel=0.02)
    part.pointer[..., STEPS_IN] = 60.0  # it swings 43 times in 1 ms
    assert rung_out(parameters, part) == 0.0


def test_what_pockets_rub_is_not_told_as_an_error_of_friction():
    """Left out of the balance, it was told as 45 times the true error, and parts were done again in vain."""
    case = "pockets, off centre"
    row = beside_truth(ToleranceRow(case, METHOD, 1e-3), words_of(case), (), 0.0)
    assert row.kept
    assert all(1.0 / 3.0 < ratio < 3.0 for ratio in row.ratios)


def a_row(end, ball, **more):
    row = np.zeros(len(WINDOW.columns))
    row[0], row[PLACE["ball"]] = end, ball
    for name, value in more.items():
        row[PLACE[name]] = value
    return row


def test_what_windows_miss_is_added_where_contacts_come_and_go():
    worst = Worst()
    worst.add(a_row(0.01, 3, load=1.0, friction=0.1, torque=3.0, loss=2.0))
    worst.add(a_row(0.02, ALL, load=0.5, friction=0.2))
    worst.add(a_row(0.03, INHERITED, load=1.2, friction=0.05))
    assert worst.seen("load", 1.0, False) == 1.2
    assert worst.seen("load", 1.0, True) == MISSED * 1.0
    assert worst.seen("friction", 1.0, True) == MISSED * 0.2
    assert worst.seen("friction", 30.0, True) == 30.0 * 0.2  # of coupled balls, what bumps do holds it
    assert worst.seen("loss", 1.0, True) == 2.0  # a mean over a window
    assert worst.seen("torque", 1.0, False) == 3.0
    # What it may be by the spread of such estimates; what is known exactly has none.
    wide, calm = spread_of(True, False), spread_of(False, False)
    assert worst.seen("load", 1.0, True, wide) == SPREAD_ALONE * MISSED
    assert worst.seen("load", 1.0, False, calm) == SPREAD_CALM * 1.2
    assert worst.seen("friction", 30.0, True, wide) == SPREAD_TOGETHER * 30.0 * 0.2
    assert spread_of(True, True).told < spread_of(True, False).told
    worst.add(a_row(0.04, BETWEEN, load=99.0))
    assert worst.seen("load", 1.0, True, wide) == 99.0
    worst.add(a_row(0.05, BESIDE, load=200.0))  # what bumps were seen to grow is no estimate either
    assert worst.seen("load", 1.0, True, wide) == 200.0
    assert worst.windows == 5
    assert "all balls together" in worst.where("friction")
    assert worst.where("steps") == ""


def test_what_rows_told_up_to_a_horizon_is_kept_in_little_room():
    worst = Worst()
    for end in range(1, 1000):
        worst.add(a_row(end, 3, load=1e-6 * end))
    assert worst.until(0.5).seen("load", 1.0, False) == 0.0
    assert worst.until(500).seen("load", 1.0, False) == pytest.approx(500e-6, rel=0.011)
    one = Worst()
    one.add(a_row(0.25, 3, load=1.0))
    assert one.until(0.25).seen("load", 1.0, False) == 1.0  # what is known up to its end
    assert worst.until(999).seen("load", 1.0, False) == pytest.approx(worst.seen("load", 1.0, False), rel=0.011)
    assert len(worst._noticed) < 500


def test_meetings_that_nobody_looked_at_end_what_is_known():
    growth = Growth(1e-4)
    (row,) = all_of_it(0.07, 1e-4, 0.05, 300.0, False)
    assert not growth.add(row, 300.0)
    assert not growth.notes  # as far as is known, meetings do no harm
    (row,) = all_of_it(0.1, 1e-4, 0.09, 300.0, True)
    growth.add(row, 300.0)
    assert growth.kept == 0.05  # now it is known that they do, also where nobody looked before
    assert "balls met after 0.05 s where nobody looked" in growth.notes["horizon"]
    assert "only statistics of many runs hold" in growth.notes["horizon"]
    copied = Growth(1e-4)
    for row in (
        *all_of_it(0.07, 1e-4, 0.05, 300.0, False),
        a_row(0.08, APART, friction=1e-6),
        a_row(0.09, APART, friction=1.0),
    ):
        copied.add(row, 300.0)
    assert copied.kept == 0.05
    assert "since balls met: beyond 0.05 s" in copied.notes["horizon"]


def test_a_run_with_a_horizon_is_compared_up_to_it():
    """A run that says 30 ms, and one that says nothing, of the same outputs."""
    run = simulate(load_scene("bearing_6203", (*OFF_CENTRE, "wanted.tolerance=1e-2")))
    blocks = list(run.blocks())
    found = Rows(blocks[0].values.layout, np.concatenate([block.matrix() for block in blocks])[1:])
    true = Rows(found.layout, found.numbers.copy())
    true["normal_load"][:20] *= 1.0 + 1e-3
    true["normal_load"][20:] *= 1.0 + 1e-2
    true["normal_load"][50] *= 2.0  # the greatest load comes later
    run = SimpleNamespace(scene=run.scene, choice=run.choice, report=run.report)
    whole = compared(run, found, true, true)
    assert np.isnan(whole["horizon"])
    assert whole["load_error"] == whole["to_the_end"]
    run.report.errors["horizon_s"] = 0.03
    for told in run.report.errors["wanted_errors"].values():
        told["error_up_to_horizon"] = 0.5
    first = compared(run, found, true, true)
    motion, greatest = BearingMotion(run.scene.parameters, run.choice), true.normal_load.max()
    assert (first["load_error"], first["friction_error"]) == errors(motion, up_to(found, 30), up_to(true, 30), greatest)
    assert first["load_error"] < 0.1 * whole["load_error"]
    assert first["to_the_end"] == whole["to_the_end"]
    assert first["load_estimate"] == first["friction_estimate"] == 0.5
    run.report.errors["horizon_s"] = 1e-4  # before the first output
    assert compared(run, found, true, true)["load_error"] == 0.0


@pytest.mark.parametrize(("scene", "kept"), [("bearing_6203", 1.0), ("bearing_6203_rig_400N", BUMPING)])
def test_bumps_into_a_cage_make_loads_err_where_the_ring_moves(scene, kept):
    """They drive balls round: of a held ring they make friction err, and loads by the place of a ball alone."""
    parameters = load_scene(scene, ("cage.kind=pockets",)).parameters
    doubt = BearingDoubt(parameters, choose(load_scene(scene, ("cage.kind=pockets",))))
    doubt.load[:], doubt.least = 50.0, 0.0
    doubt.worst.add(a_row(0.01, ALL, load=1.0, friction=0.01))
    assert doubt._seen("load") == pytest.approx(max(kept, MISSED))
    assert doubt._seen("friction") == pytest.approx(BUMPING * 0.01)
    doubt.worst.add(a_row(0.01, ALL, orbit_angle=0.01))
    assert doubt._seen("load") == pytest.approx(max(kept, MISSED) + 0.01 * BUMPING * 50.0)


def test_what_is_told_of_friction_is_no_more_than_friction_can_be_off():
    """Both runs rub with all of mu N, the one this way and the other that, and with mu N R of both contacts of a ball.

    A ball that is off by a radian or more bears anything between the greatest load and the least.
    """
    scene = load_scene("bearing_6203_loose", ("contact.friction_coefficient=0.08",))
    doubt = BearingDoubt(scene.parameters, choose(scene))
    doubt.load[:], doubt.load[3], doubt.least = 5.0, (50.0, 45.0), 0.0
    doubt.worst.add(a_row(0.01, ALL, friction=1.97, torque=1.0, orbit_angle=9.0, loss=7.0))
    wide = spread_of(True, False)
    assert doubt._seen("friction") == doubt._seen("friction", spread=wide) == 2.0
    radius = 0.5 * scene.parameters.geometry.ball_diameter
    assert doubt._seen("torque") == pytest.approx(2.0 * 0.08 * 95.0 * radius)
    assert doubt._seen("load") == pytest.approx(50.0)
    assert doubt._seen("loss") == BUMPING * 7.0
    (told,) = (one for one in doubt._promises(None, None) if one.output == "friction")
    assert told.error == told.may == 2.0
    assert told.broken


def test_a_copy_starts_apart_by_a_share_of_what_steps_may_err_where_nothing_was_seen():
    drift, state = Drift(2), np.zeros((2, COLUMNS))
    state[:, AXIS_DISTANCE] = 0.014
    drift.set_apart(state, 0.0, 1e-3)
    assert state[:, ORBIT_ANGLE] == pytest.approx([-LEAST_APART * 1e-9 / 0.014, LEAST_APART * 1e-9 / 0.014])
