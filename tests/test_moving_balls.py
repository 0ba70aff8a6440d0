"""How far contact angles in balance are off those of moving balls: the error told is the one that there is."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.kinds.bearing.quasi_static import moving_balls
from bearing_twin.kinds.bearing.quasi_static.answer import answer_of
from bearing_twin.kinds.bearing.quasi_static.axes import response_to_axes
from bearing_twin.kinds.bearing.quasi_static.in_motion import solved_in_motion
from bearing_twin.kinds.bearing.quasi_static.moving_balls import _late, angle_errors
from bearing_twin.kinds.bearing.quasi_static.statics import (
    EquilibriumSolver,
    Support,
    load_line,
    setting_of,
    solver_of,
    support_of,
)
from bearing_twin.kinds.doubt import LEFT_OUT
from bearing_twin.report import Choice
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

NO_GRAVITY = "gravity=[0,0,0]"
LAW, HELD = "hertz", (False,) * 5
BEARS = 1e-2  # of the greatest load
NAMES = "drive.offset", "drive.tilt"


def scene_of(*overrides):
    rolling = "model.control=shared", "model.dimension=prescribed"
    scene = (NO_GRAVITY, *rolling, "cage.kind=even", "solver.companion=off", *overrides)
    return load_scene("bearing_6203", scene).parameters


def in_balance(load, tilt, overrides):
    """The scene with the ring held where this load [N] puts it at this tilt [rad], and its coordinates."""
    support = Support((True, True, True, False, False), (*load, 0.0, 0.0), (0.0, 0.0, 0.0, *tilt))
    parameters = scene_of(*overrides)
    places = solver_of(parameters, LAW, load_line(support)).solve(support).coordinates.tolist()
    parts = (f"{name}={some}" for name, some in zip(NAMES, (places[:3], places[3:]), strict=True))
    return scene_of(*overrides, *parts, "wanted.tolerance=1e-4"), places


def settled(parameters, solver, support):
    """The equilibrium with settled axes; those of rolling are what `solved_in_motion` finds here."""
    return solved_in_motion(replace(parameters, model=replace(parameters.model, control="settled")), solver, support)


def off_and_told(load, tilt=(0.0, 0.0), overrides=(), after=0.1, solved=solved_in_motion):
    """Greatest differences of angles [rad] over a ball's spacing of way, and the greatest errors told."""
    parameters, places = in_balance(load, tilt, overrides)
    moving = bearing_motion(parameters, Choice(LAW, "rodas4", 0.0, "", ()))
    for _ in range(math.ceil(after)):
        moving.advance(np.array([after / math.ceil(after)]), after / math.ceil(after))
    speed, balls = parameters.drive.speed, parameters.geometry.balls
    spacing = 2.0 * np.pi / balls / (0.38 * speed)
    out = moving.advance(np.linspace(0.0, spacing, 25)[1:], spacing)
    off, told = 0.0, 0.0
    for azimuths, angles in zip(out.orbit_angle, out.contact_angle, strict=True):
        solver = EquilibriumSolver(setting_of(parameters, LAW, speed), azimuths)
        found = solved(parameters, solver, Support(HELD, (0.0,) * 5, tuple(places)))
        bears = found.contacts.load > BEARS * found.contacts.load.max()
        off = max(off, np.abs(np.abs(angles) - np.abs(found.contacts.angle))[bears].max())
        told = max(told, angle_errors(parameters, solver, found)[bears].max())
    return off, told


SMOOTH = "contact.friction_regularisation=0.1"
SLIPPERY = "contact.friction_coefficient=0.01"
CLEARANCE = "geometry.radial_clearance=10e-6"


@pytest.mark.parametrize(
    ("load", "tilt", "overrides", "after"),
    [
        ((0, 0, 100), (0, 0), ("drive.speed=1000",), 0.1),
        ((0, 0, 100), (0, 0), ("drive.speed=3000",), 0.1),
        ((0, -60, 100), (0, 0), ("drive.speed=567",), 20.0),
        ((0, -60, 100), (0, 0), ("drive.speed=1749",), 4.0),
        ((0, -60, 100), (0, 0), ("drive.speed=1000", SMOOTH), 6.0),
        ((0, -60, 100), (0, 0), ("drive.speed=1000", SLIPPERY), 6.0),
        ((0, 0, 100), (5e-4, 0), ("drive.speed=1000",), 4.0),
        ((0, -800, 300), (0, 0), ("drive.speed=157", CLEARANCE), 0.1),
        ((0, -800, 100), (0, 0), ("drive.speed=1000", CLEARANCE), 0.1),
        ((0, -100, 300), (0, 0), ("drive.speed=300", "geometry.designation=7204B"), 10.0),
    ],
)
def test_the_error_told_of_an_angle_is_within_a_factor_of_three(load, tilt, overrides, after):
    """Under thrust before the axes of spin settle, elsewhere once they have, which is worse there."""
    off, told = off_and_told(load, tilt, overrides, after)
    assert off > 5e-6
    assert off / 3.0 < told < 3.0 * off


@pytest.mark.parametrize(
    ("load", "tilt", "overrides", "after"),
    [
        ((0, -60, 100), (0, 0), ("drive.speed=183.26",), 0.1),
        ((0, -60, 100), (0, 0), ("drive.speed=183.26",), 20.0),
        ((0, -60, 100), (0, 0), ("drive.speed=977",), 0.1),
        ((0, -60, 100), (0, 0), ("drive.speed=977",), 20.0),
        ((0, -60, 100), (0, 0), ("drive.speed=1350",), 12.0),
        ((0, -60, 100), (0, 0), ("drive.speed=1660",), 0.1),
        ((0, 0, 100), (5e-4, 0), ("drive.speed=183.26",), 5.0),
        ((0, -100, 300), (0, 0), ("drive.speed=300", "geometry.designation=7204B"), 5.0),
    ],
)
def test_angles_are_those_of_moving_balls_where_centrifugal_loads_are_a_tenth(load, tilt, overrides, after):
    """Within 5e-4 of the greatest, at the start and once the axes of spin have settled."""
    off, _ = off_and_told(load, tilt, overrides, after, settled)
    parameters, places = in_balance(load, tilt, overrides)
    found = solver_of(parameters, LAW, 0.0).solve(Support(HELD, (0.0,) * 5, tuple(places)))
    contacts = found.contacts
    assert (contacts.centrifugal / contacts.load[:, 0]).max() < 0.1
    assert off < 5e-4 * np.abs(contacts.angle).max()


def test_what_friction_acts_on_adds_up():
    """The ring bears its load, contacts make up their ball's wrench; all forces are 0 but for where friction points."""
    load = "rings.inner.load=[20,-60,100]", "rings.inner.moment=[0.1,0.05]", "drive.speed=1500"
    scene = load_scene("bearing_6203", (*load, NO_GRAVITY, "model.dimension=quasi_static", "run.duration=0.02"))
    out = bearing_motion(scene.parameters, Choice(LAW, "quasi_static", 0.0, "", ())).advance(np.array([0.01]), 0.01)
    across = np.abs(out.friction_force.sum(axis=2)).max()
    assert across > 1e-3
    assert out.inner_ring_force[0] == pytest.approx([-20.0, 60.0, -100.0], rel=1e-9)
    assert out.inner_ring_torque[0, :2] == pytest.approx([-0.1, -0.05], rel=1e-9)
    own = (out.normal * out.normal_load[..., None] + out.friction_force).sum(axis=2)
    assert out.raceway_force == pytest.approx(own, abs=1e-8)
    sums = out.inner_ring_force + out.outer_ring_force + out.raceway_force.sum(axis=1)
    assert np.abs(sums).max() < 5e-6 * out.normal_load.sum()
    assert np.abs(sums).max() < 1e-2 * across


def test_a_bearing_at_rest_or_without_friction_is_in_balance_to_the_bit():
    support = Support((True, True, True, False, False), (0.0, -60.0, 100.0, 0.0, 0.0), (0.0,) * 5)
    for overrides in (("drive.speed=0",), ("contact.friction_coefficient=0",), ("contact.friction=spot",)):
        parameters = scene_of(*overrides)
        solver = solver_of(parameters, LAW, load_line(support))
        pair = solved_in_motion(parameters, solver, support), solver.solve(support)
        (*ones, contacts, left, _, _), (*others, other_contacts, other_left, _, _) = pair
        assert left == other_left
        assert all(np.array_equal(*two) for two in zip((*ones, *contacts), (*others, *other_contacts), strict=True))


def test_friction_is_all_there_is_between_angles_in_balance_and_of_moving_balls():
    """Ten thousandth of the friction leaves a hundredth of the difference, far below 5e-4 of the angles."""
    load, speed = (0, -60, 100), "drive.speed=1749"
    with_friction = off_and_told(load, overrides=(speed,))[0]
    slippery = (speed, "contact.friction_coefficient=8e-6")
    without = off_and_told(load, overrides=slippery)[0]
    assert without < 0.03 * with_friction
    assert without < 2e-4 * 0.13


@pytest.mark.parametrize("speed", [1000.0, 3000.0])
def test_what_the_gyroscopic_moment_does_under_thrust_is_its_closed_form(speed):
    """0.4 (x/(2 + x))^2 of the angle, x = F_c/Q_i, at the outer race; friction across cannot lag where all is even."""
    parameters, places = in_balance((0, 0, 100), (0, 0), (f"drive.speed={speed}",))
    solver = solver_of(parameters, LAW, 0.3)
    found = solver.solve(Support(HELD, (0.0,) * 5, tuple(places)))
    geometry, orbit = parameters.geometry, found.contacts.orbit
    mass = parameters.materials.ball.density * np.pi / 6.0 * geometry.ball_diameter**3
    x = mass * orbit**2 * 0.5 * geometry.pitch_diameter / found.contacts.load[:, 0]
    wanted = 0.4 * (x / (2.0 + x)) ** 2 * np.abs(found.contacts.angle[:, 1])
    assert angle_errors(parameters, solver, found)[:, 1] == pytest.approx(wanted, rel=0.03)


@pytest.mark.parametrize("speed", [1000.0, -1000.0])
def test_a_lag_is_followed_the_way_the_balls_go(speed, monkeypatch):
    """From one of 192 azimuths to the next: rising where the ring turns about +z."""
    taken = []
    monkeypatch.setattr(moving_balls, "_late", lambda wanted, *rest: taken.append(wanted) or 0.0 * wanted)
    parameters, places = in_balance((0, -60, 100), (0, 0), (f"drive.speed={speed}",))
    solver = solver_of(parameters, LAW, 0.0)
    found = solver.solve(Support(HELD, (0.0,) * 5, tuple(places)))
    angle_errors(parameters, solver, found)
    met = taken[1][:: int(np.sign(speed))][::24]  # where the eight balls stand now
    assert met == pytest.approx(found.contacts.angle[:, 1], rel=1e-6)


def test_a_ball_is_told_what_it_meets_within_half_a_spacing():
    azimuths = 2.0 * np.pi * np.arange(192) / 192
    balls, errors, everywhere = azimuths[::24], np.zeros((192, 2)), np.ones(192, bool)
    errors[59], errors[0] = (3.0, 1.0), (0.5, 0.7)  # nearly half a spacing before ball 2, at ball 0
    told = moving_balls._nearby(errors, everywhere, azimuths, balls)
    assert told.tolist() == [[0.5, 0.7], [0.0, 0.0], [3.0, 1.0], *[[0.0, 0.0]] * 5]
    told = moving_balls._nearby(errors, ~everywhere, azimuths, balls)
    assert told.tolist() == [[0.5, 0.7], *[[0.0, 0.0]] * 7]


def test_nothing_is_told_without_friction_or_at_rest():
    support = Support((True, True, True, False, False), (0.0, -60.0, 100.0, 0.0, 0.0), (0.0,) * 5)
    for overrides in (("drive.speed=0",), ("contact.friction_coefficient=0",)):
        parameters = scene_of(*overrides)
        solver = solver_of(parameters, LAW, load_line(support))
        assert not angle_errors(parameters, solver, solver.solve(support)).any()


@pytest.mark.parametrize("lag", [1e-3, 0.02, 0.3, 3.0])
def test_a_lag_is_that_of_first_order(lag):
    """a' = (cos - a)/lag once round: off by the part at a right angle and the part in phase."""
    angles = 2.0 * np.pi * np.arange(192) / 192
    late = _late(1e-3 * np.cos(angles), np.full(192, lag), np.zeros(192))
    exact = 1e-3 * (lag * lag * np.cos(angles) - lag * np.sin(angles)) / (1.0 + lag * lag)
    settled = np.exp(-2.0 * 2.0 * np.pi / lag)  # of the start, at the beginning of the third turn
    assert late == pytest.approx(exact, abs=1e-3 * (0.02 * lag / (1.0 + lag) + settled))
    assert settled < 0.02


def test_the_lag_holds_whichever_way_the_ring_turns():
    load, told = (0, -60, 100), []
    for speed in (1000.0, -1000.0):
        parameters, places = in_balance(load, (0.0, 0.0), (f"drive.speed={speed}",))
        solver = solver_of(parameters, LAW, 0.3)
        told.append(angle_errors(parameters, solver, solver.solve(Support(HELD, (0.0,) * 5, tuple(places)))))
    assert told[0].max() == pytest.approx(told[1].max(), rel=1e-2)
    assert told[0].min() > 0.0


def test_an_answer_and_a_run_tell_the_error_of_their_angles():
    """At 1749 rad/s, once the axes of spin have settled; that of the answer holds law and half-spaces as well."""
    load = "rings.inner.load=[0,-60,100]", "drive.speed=1749"
    still = "model.dimension=quasi_static", "model.control=shared", "run.duration=0.02"
    scene = load_scene("bearing_6203", (*load, NO_GRAVITY, *still))
    run = simulate(scene)
    assert len(list(run)) > 10
    told = run.report.errors["errors_by_source"]["contact_angle_inner_rad"]
    off = off_and_told((0, -60, 100), overrides=("drive.speed=1749",), after=20.0)[0]
    assert off / 3.0 < told[LEFT_OUT][0] < 3.0 * off
    parameters = scene.parameters
    support = support_of(parameters)
    solver = solver_of(parameters, LAW, load_line(support))
    answer = answer_of(parameters, LAW, solver, support, solver.solve(support))
    assert max(answer["contact_angle_inner_rad_error"]) > off


@pytest.mark.parametrize(("friction", "seconds"), [("point", 80.0), ("spot", 0.3)])
def test_loads_of_equilibria_err_by_what_settled_axes_of_spin_make_of_them(friction, seconds):
    """A 218 held where it bears 17.8 kN: axes end parallel to the bearing's, or the outer raceway takes the moment."""
    ring = ["model.control=shared", "model.dimension=prescribed", "rings.inner.free=none"]
    held = [*ring, "rings.inner.load=[0,0,0]", "gravity=[0,0,0]"]
    rates = [f"run.duration={seconds}", "run.output_rate=10", "run.publish_rate=10", "solver.companion=off"]
    given = load_scene(
        "bearing_218_thrust",
        [*held, *rates, "drive.offset=[0,0,6.8647e-4]", "geometry.balls=3", f"contact.friction={friction}"],
    )
    *_, last = simulate(given)
    parameters = given.parameters
    support = support_of(parameters)
    solver = solver_of(parameters, "hertz")
    rolling = solver.solve(support)
    told = response_to_axes(parameters, solver, support)
    off = last["normal_load"] - rolling.contacts.load
    assert (off > 50.0).all()
    assert (0.8 * off < told.loads).all()
    assert (told.loads < 1.3 * off).all()


def test_axes_of_spin_change_nothing_at_rest_and_next_to_nothing_in_a_deep_groove():
    for scene, words, most in (
        ("bearing_218_thrust", ["drive.speed=0"], 1e-12),
        ("bearing_6203", ["drive.offset=[0,0,2e-5]"], 1e-4),
    ):
        parameters = load_scene(scene, words).parameters
        solver, support = solver_of(parameters, "hertz"), support_of(parameters)
        loads = response_to_axes(parameters, solver, support).loads
        assert np.abs(loads).max() <= most * solver.solve(support).contacts.load.max()


def test_a_run_of_equilibria_says_what_settled_axes_do_to_its_loads():
    shared = ("model.control=shared",)
    run = simulate(load_scene("bearing_218_thrust", shared))
    for _ in run.blocks():
        pass
    errors = run.report.errors
    assert errors["errors_by_source"]["normal_load_outer_n"]["friction_model"][0] == pytest.approx(157.5, rel=1e-3)
    assert errors["normal_load_outer_n_error"][0] > 157.4
    wants_loads = simulate(load_scene("bearing_218_thrust", ["wanted.outputs=loads", *shared]))
    for _ in wants_loads.blocks():
        pass
    for one in (run, wants_loads):
        assert one.report.status == "doubtful: loads"
        assert one.report.errors["wanted_errors"]["loads"]["error"] == pytest.approx(157.5 / 1888.75, rel=1e-3)
