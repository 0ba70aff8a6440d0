"""`model.control: auto`: runs from equilibria are those of balls that move; `bearing` is textbooks', and says so."""

import json

import numpy as np
import pytest

from bearing_twin.command import cli
from bearing_twin.errors import Stopped
from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.kinds.bearing.quasi_static import in_motion as equilibria
from bearing_twin.kinds.bearing.quasi_static.axes import (
    LITTLE,
    left_by_rolling,
    response_to_axes,
    response_to_slip,
    settling_matters,
)
from bearing_twin.kinds.bearing.quasi_static.in_motion import in_motion
from bearing_twin.kinds.bearing.quasi_static.settled import _parallel, balanced_on_the_way, settled_turn
from bearing_twin.kinds.bearing.quasi_static.statics import (
    EquilibriumSolver,
    Support,
    azimuths_of,
    load_line,
    setting_of,
    solver_of,
    support_of,
)
from bearing_twin.report import Choice
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.stopping import heeding

LAW, FREE = "hertz", (True, True, True, False, False)
EVEN = "gravity=[0,0,0]", "cage.kind=even"
QUASI_STATIC = "model.dimension=quasi_static"
MASS = "rings.inner.mass=0.5", "rings.inner.inertia=[1e-4,1e-4]", "rings.inner.support.damping=[200,200,200]"
ROLLING = ("model.control=shared",)
BINS = 24  # of a ball's way round


def parameters_of(*words, scene="bearing_6203", control="shared"):
    return load_scene(scene, (*EVEN, f"model.control={control}", *words)).parameters


def under(load, tilt=(0.0, 0.0)):
    return Support(FREE, (*load, 0.0, 0.0), (0.0, 0.0, 0.0, *tilt))


def by_place(*words):
    """A run, its loads [N] over the ball's azimuth (BINS, 2), and the ring's place (3,) [m], of its second half."""
    run = simulate(load_scene("bearing_6203", (*EVEN, "run.output_rate=1000", "run.publish_rate=1000", *words)))
    blocks = list(run.blocks())
    load, azimuth, place = (
        np.concatenate([block.values[name] for block in blocks])
        for name in ("normal_load", "orbit_angle", "inner_ring_offset")
    )
    half = slice(len(load) // 2, None)
    bins = (np.mod(azimuth[half].ravel(), 2.0 * np.pi) / (2.0 * np.pi) * BINS).astype(int)
    loads = load[half].reshape(-1, 2)
    return run, np.array([loads[bins == one].mean(axis=0) for one in range(BINS)]), place[half].mean(axis=0)


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ("0,-60,100", ("drive.tilt=[1e-3,0]",)),
        ("0,-300,500", ("drive.tilt=[1e-3,0]", "geometry.radial_clearance=1e-5")),
        ("0,-300,500", ("drive.speed=1000",)),
    ],
)
def test_a_run_from_equilibria_is_one_of_a_ring_with_mass(load, words):
    """Loads over the way of balls, and where the ring stands: nobody has said which axes balls have."""
    given = (f"rings.inner.load=[{load}]", "run.duration=0.4", *words)
    run, still, stands = by_place(QUASI_STATIC, *given)
    _, moving, goes = by_place("model.dimension=free", *MASS, *given)
    assert np.abs(still - moving).max() < 7e-4 * moving.max()  # of which 4e-4 is that bins are wide
    assert stands == pytest.approx(goes, abs=2e-4 * np.abs(goes).max())
    assert run.report.status == "done"
    assert "their axes of spin have settled" in run.report.choice_reason
    rolling = by_place(QUASI_STATIC, "model.control=shared", *given)[1]
    assert np.abs(rolling - moving).max() > 5.0 * np.abs(still - moving).max()


@pytest.mark.parametrize(("load", "tilt", "speed"), [((0, -60, 100), (1e-3, 0), 157), ((0, 0, 100), (1e-3, 5e-4), 183)])
def test_what_balls_in_one_cage_slip_is_told(load, tilt, speed):
    """Loads to a tenth of it, where little else is: the ring goes across the load."""
    support, words = under(load, tilt), (f"drive.speed={speed}",)
    solver = solver_of(parameters_of(*words), LAW, load_line(support))
    found = in_motion(parameters_of(*words), solver, support).found
    truth = in_motion(parameters_of(*words, control="settled"), solver, support).found
    told = response_to_slip(parameters_of(*words), solver, support, found)
    off = truth.contacts.load - found.contacts.load
    assert np.abs(off).max() > 1e-2 * found.contacts.load.max()
    assert np.abs(told.loads - off).max() < 0.1 * np.abs(off).max()
    moved, held = truth.coordinates - found.coordinates, truth.loads - found.loads
    assert told.coordinates == pytest.approx(moved, abs=0.2 * np.abs(moved).max())
    assert 1.0 < told.ring_loads[4] / held[4] < 3.0  # friction across takes some of it
    assert np.abs(response_to_axes(parameters_of(*words), solver, support).loads).max() < 0.02 * np.abs(off).max()


def test_nothing_slips_where_all_balls_are_loaded_alike_or_nothing_rubs():
    for support, words in ((under((0, 0, 100)), ()), (under((0, -60, 100)), ("contact.friction_coefficient=0",))):
        parameters = parameters_of(*words)
        solver = solver_of(parameters, LAW, load_line(support))
        found = solver.solve(support)
        told = response_to_slip(parameters, solver, support, found)
        assert max(np.abs(one).max() for one in told[:3]) < 1e-9


def test_axes_settle_where_that_is_much_against_the_tolerance():
    """Under 100 N of thrust loads change by 1e-4 at 183 rad/s, 3e-3 at 1000; a tenth of the tolerance is little."""
    support = under((0, 0, 100))
    for speed, change in ((183.26, 9.8e-5), (1000.0, 2.9e-3)):
        parameters = parameters_of(f"drive.speed={speed}")
        solver = solver_of(parameters, LAW)
        found = solver.solve(support)
        left = left_by_rolling(parameters, solver, support, found).loads.max() / found.contacts.load.max()
        assert left == pytest.approx(change, rel=0.05)
        for tolerance in (0.9 * left / LITTLE, 1.1 * left / LITTLE):
            wanted = parameters_of(f"drive.speed={speed}", f"wanted.tolerance={tolerance}", control="auto")
            assert settling_matters(wanted, solver, support, found) == (tolerance < left / LITTLE)
            assert len(in_motion(wanted, solver, support).turn.motion) == (tolerance < left / LITTLE)
    at_rest = parameters_of("drive.speed=0", control="auto")
    solver = solver_of(at_rest, LAW)
    assert not settling_matters(at_rest, solver, support, solver.solve(support))


def test_balls_that_move_start_in_rolling_where_nobody_asks():
    first = [
        next(simulate(load_scene("bearing_218_thrust", ("model.dimension=prescribed", *words))).blocks())
        for words in (
            (
                "rings.inner.free=none",
                "rings.inner.load=[0,0,0]",
                "drive.offset=[0,0,6.8e-4]",
                f"model.control={control}",
            )
            for control in ("auto", "shared", "settled")
        )
    ]
    loads = [one.values["normal_load"][0] for one in first]
    assert np.array_equal(loads[0], loads[1])
    assert np.abs(loads[2] / loads[0] - 1.0).max() > 0.03


def test_the_command_stays_with_textbooks_and_flags_what_they_leave_out(capsys):
    def answered(*words):
        assert cli.main(["bearing", "bearing_218_thrust", *words, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    plain, settled = answered(), answered("--control", "settled")
    assert (plain["control"], settled["control"]) == ("shared", "settled")
    (flag,) = (one for one in plain["flags"] if "balls that move differ in load by up to 8.3 %" in one)
    assert "--control settled holds" in flag
    assert not any("balls that move" in one for one in settled["flags"])
    off = np.subtract(settled["normal_load_outer_n"], plain["normal_load_outer_n"])
    assert np.all(np.abs(off) < np.array(plain["normal_load_outer_n_error"]) * 1.1)
    assert np.all(np.abs(off) > 0.08 * np.array(plain["normal_load_outer_n"]))
    spots = answered("--set", "contact.friction=spot")
    assert not any("--control settled" in one for one in spots["flags"])


def test_balls_that_are_all_loaded_alike_settle_at_their_closed_form():
    """No slip, no gyroscopic moment: Newton's method begins next to what it finds."""
    parameters = parameters_of(scene="bearing_218_thrust", control="settled")
    found = solver_of(parameters, LAW).solve(support_of(parameters))
    setting = setting_of(parameters, LAW, parameters.drive.speed)
    turn = settled_turn(parameters, setting, found.coordinates)
    place, contacts = balanced_on_the_way(setting, found.coordinates, azimuths_of(1, 0.0))
    near = _parallel(setting, found.coordinates, place, contacts)
    assert near[:2] == pytest.approx(turn.motion[0, :2], rel=1e-6)
    assert near[4:] == pytest.approx([turn.motion[0, 4], turn.orbit], rel=1e-6)


def test_a_ring_finds_its_place_where_one_place_after_another_leads_away():
    """A map that throws errors to ten times the other side is followed home within its dimensions and two more."""
    home, away = np.array([1.0, -2.0, 3.0, 0.5, 0.0]), np.diag([0.2, -10.0, 0.1, -3.0, 0.0])
    away[0, 1], away[1, 0] = 4.0, -4.0
    at, tried = np.zeros(5), []
    for _ in range(7):
        tried.append((at, away @ (at - home) + home - at))
        at = equilibria._next(*zip(*tried, strict=True))
    assert at == pytest.approx(home, abs=1e-6)


def test_a_free_ring_and_settled_balls_agree(monkeypatch):
    """Within 6 rounds, where a ring that took its answers as they came was thrown aside 40 times as far each round."""
    rounds = []
    real = equilibria.settled_turn
    monkeypatch.setattr(equilibria, "settled_turn", lambda *given, **more: rounds.append(1) or real(*given, **more))
    parameters = parameters_of("drive.speed=1200", scene="bearing_218_thrust", control="settled")
    held = in_motion(parameters, solver_of(parameters, LAW), support_of(parameters))
    assert not held.turn.why
    assert len(rounds) <= 6
    assert held.found.loads[2] == pytest.approx(17800.0, rel=1e-9)
    assert np.abs(held.found.coordinates[:2]).max() < 1e-9


@pytest.mark.parametrize("control", ["shared", "outer"])
def test_stiffness_is_the_derivative_of_the_answer(control):
    """At 1000 rad/s, tilted, with a load across, friction and all: by differences of what holds the ring."""
    parameters = parameters_of("drive.speed=1000", control=control)
    support = Support((True,) * 5, (0.0, -300.0, 500.0, 0.5, -1.0), (0.0,) * 5)
    solver = solver_of(parameters, LAW, load_line(support))
    found = in_motion(parameters, solver, support).found
    steps = np.array([1e-9] * 3 + [1e-7] * 2)
    for column, step in enumerate(steps):
        loads = []
        for side in (1.0, -1.0):
            place = found.coordinates.copy()
            place[column] += side * step
            held = Support((False,) * 5, (0.0,) * 5, tuple(place))
            loads.append(in_motion(parameters, solver_of(parameters, LAW, load_line(support)), held).found.loads)
        slope = (loads[0] - loads[1]) / (2.0 * step)
        size = np.sqrt(np.abs(np.diagonal(found.stiffness) * found.stiffness[column, column]))
        assert slope / size == pytest.approx(found.stiffness[:, column] / size, abs=2e-6)


def test_a_search_for_settled_axes_can_be_stopped():
    """It takes seconds where balls are about to slide."""
    parameters = parameters_of("geometry.designation=7204B", "drive.speed=1136", control="settled")
    support = under((0.0, 0.0, 85.9), (-1e-4, 6e-4))
    asked = []
    with heeding(lambda: asked.append(1) or len(asked) > 20), pytest.raises(Stopped):
        in_motion(parameters, solver_of(parameters, LAW), support)
    assert len(asked) == 21


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ((0, -60, 100), ("drive.tilt=[1e-3,0]",)),
        ((0, -60, 100), ("drive.speed=1749",)),
        ((0, -100, 300), ("drive.speed=900", "geometry.designation=7204B")),
    ],
)
def test_friction_of_settled_equilibria_is_that_of_balls_that_move(load, words):
    """Force by force within what is told, over mu N; where axes are those of rolling nothing is known of it."""
    still = f"rings.inner.load={list(load)}", "model.dimension=quasi_static", "run.duration=0.002"
    runs = [simulate(load_scene("bearing_6203", (*EVEN, *words, *still, *more))) for more in ((), ROLLING)]
    settled, _ = [list(run.blocks()) for run in runs]
    promised = [run.report.errors["wanted_errors"]["friction"]["error"] for run in runs]
    assert promised == [5e-4, None]
    assert runs[0].report.status == "done"
    held = (
        f"drive.offset={settled[0].values['inner_ring_offset'][0].tolist()}",
        "model.control=settled",
        "solver.companion=off",
    )
    parameters = parameters_of("model.dimension=prescribed", *words, *held, control="auto")
    moving = bearing_motion(parameters, Choice(LAW, "rodas4", 0.0, "", ()))
    moving.advance(np.array([0.2]), 0.2)
    speed, off = parameters.drive.speed, 0.0
    ring = (*parameters.drive.offset, *parameters.drive.tilt)
    out = moving.advance(np.linspace(0.0, 2.0 / speed, 5)[1:], 2.0 / speed)
    for azimuths, forces in zip(out.orbit_angle, out.friction_force, strict=True):
        solver = EquilibriumSolver(setting_of(parameters, LAW, speed), azimuths)
        contacts = in_motion(parameters, solver, Support((False,) * 5, (0.0,) * 5, ring)).found.contacts
        along = np.stack([-np.sin(azimuths), np.cos(azimuths)], axis=1)
        radial = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
        angle = contacts.angle
        pushed = np.einsum("kij,kj->ki", forces[..., :2], along) - contacts.along
        outward = np.einsum("kij,kj->ki", forces[..., :2], radial)
        across = np.cos(angle) * forces[..., 2] - np.sin(angle) * outward - contacts.friction
        most = parameters.contact.friction_coefficient * contacts.load
        off = max(off, (np.hypot(pushed, across) / most).max())
    assert 1e-6 < off < 5e-4


def test_a_tilted_ring_that_is_held_bears_what_its_balls_slip():
    """Loads of balls hardly change, the force on the ring by 3 %: that of balls that move in one cage."""
    words = *EVEN, "drive.offset=[0,0,5e-5]", "drive.tilt=[1e-3,0]", "run.duration=0.05"
    still, moving = (
        list(simulate(load_scene("bearing_6203", (*words, f"model.dimension={one}"))).blocks())[-1].values
        for one in ("quasi_static", "prescribed")
    )
    force, truth = still["inner_ring_force"][-1], moving["inner_ring_force"][-1]
    assert abs(truth[0]) > 0.03 * np.linalg.norm(truth)
    assert force == pytest.approx(truth, abs=1e-3 * np.linalg.norm(truth))


def test_errors_of_a_run_hold_those_at_the_speed_it_ends_with():
    """No settled motion is found there, and loads are off by a fifth; no speed that passes is searched for long."""
    ramp = "drive.speed=300", "drive.change={time: 0.02, speed: 2700.0}", "drive.acceleration=1e5"
    words = *EVEN, "rings.inner.load=[0,-100,800]", "run.duration=0.05"
    run = simulate(load_scene("7204B", (*words, *ramp)))
    assert all(len(block.values["normal_load"]) for block in run.blocks())
    assert run.report.status == "doubtful: loads"
    end = simulate(load_scene("7204B", (*words, "drive.speed=3000")))
    assert all(len(block.values["normal_load"]) for block in end.blocks())
    told = [one.report.errors["wanted_errors"]["loads"]["error"] for one in (run, end)]
    assert told[0] == pytest.approx(told[1], rel=1e-6)
    assert told[0] > 0.1
