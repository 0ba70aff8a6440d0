"""Equilibria of balls whose axes of spin have settled: those of a run that has, which starts there and stays there."""

import json
import math

import numpy as np
import pytest

from bearing_twin.command import cli
from bearing_twin.kinds.bearing.controls import CONTROL_WORDS
from bearing_twin.kinds.bearing.forces.equations import single_contact
from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.kinds.bearing.quasi_static import turn_table as columns
from bearing_twin.kinds.bearing.quasi_static.answer import answer_of
from bearing_twin.kinds.bearing.quasi_static.axes import left_by_rolling
from bearing_twin.kinds.bearing.quasi_static.in_motion import in_motion
from bearing_twin.kinds.bearing.quasi_static.moving_balls import angle_errors
from bearing_twin.kinds.bearing.quasi_static.settled import Turn, settled_turn
from bearing_twin.kinds.bearing.quasi_static.statics import (
    EquilibriumSolver,
    Support,
    load_line,
    setting_of,
    solver_of,
    support_of,
)
from bearing_twin.kinds.bearing.quasi_static.surroundings import Surroundings
from bearing_twin.kinds.bearing.quasi_static.turn_search import Search
from bearing_twin.kinds.bearing.start import bearing_of
from bearing_twin.numerics.rotation import about_z
from bearing_twin.report import Choice
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

LAW, FREE, HELD = "hertz", (True, True, True, False, False), (False,) * 5
ALONE = "gravity=[0,0,0]", "cage.kind=even", "solver.companion=off", "wanted.tolerance=1e-4"
ACROSS, THRUST = (0, -60, 100), (0, 0, 100)
SMOOTH = "contact.friction_regularisation=0.1"  # axes settle ten times as fast
ANGULAR = "geometry.designation=7204B"


def scene_of(*words, scene="bearing_6203"):
    return load_scene(scene, (*ALONE, *words)).parameters


def held_where(load, tilt=(0.0, 0.0), words=(), control="settled"):
    """The scene with the ring held where this load [N] puts it in rolling, at this tilt [rad]."""
    support = Support(FREE, (*load, 0.0, 0.0), (0.0, 0.0, 0.0, *tilt))
    found = solver_of(scene_of(*words), LAW, load_line(support)).solve(support).coordinates.tolist()
    where = f"drive.offset={found[:3]}", f"drive.tilt={found[3:]}"
    return scene_of("model.dimension=prescribed", f"model.control={control}", *where, *words)


def motion_of(parameters):
    return bearing_motion(parameters, Choice(LAW, "rodas4", 0.0, "", ()))


def marched(motion, seconds):
    parts = max(1, math.ceil(seconds))
    for _ in range(parts):
        motion.advance(np.array([seconds / parts]), seconds / parts)


def settled_at(parameters, azimuths, coordinates=None):
    """The settled equilibrium with the balls at these azimuths, the ring held."""
    drive = parameters.drive
    places = (*drive.offset, *drive.tilt) if coordinates is None else tuple(coordinates)
    solver = EquilibriumSolver(setting_of(parameters, LAW, drive.speed), azimuths)
    return in_motion(parameters, solver, Support(HELD, (0.0,) * 5, places))


def off(parameters, outputs):
    """Greatest differences of loads and angles of outputs from equilibria there, over the greatest."""
    worst, settled = np.zeros(2), 0.0
    for azimuths, loads, angles in zip(outputs.orbit_angle, outputs.normal_load, outputs.contact_angle, strict=True):
        found, _, turn = settled_at(parameters, azimuths)
        assert not turn.why
        pairs = (found.contacts.load, loads), (np.abs(found.contacts.angle), np.abs(angles))
        worst = np.maximum(worst, [np.abs(one - two).max() / np.abs(two).max() for one, two in pairs])
        settled = found.settled
    return worst, settled


def over_a_spacing(parameters, motion, count=4):
    spacing = 2.0 * np.pi / parameters.geometry.balls / abs(0.38 * parameters.drive.speed)
    return motion.advance(np.linspace(0.0, spacing, count + 1)[1:], spacing)


CASES = [
    (THRUST, (0, 0), ("drive.speed=3000",)),
    (THRUST, (0, 0), ("drive.speed=-5900",)),
    (ACROSS, (0, 0), ("drive.speed=183.26",)),
    (ACROSS, (0, 0), ("drive.speed=-1749",)),
    (ACROSS, (0, 0), ("drive.speed=3000",)),
    (ACROSS, (0, 0), ("drive.speed=5600",)),
    (THRUST, (5e-4, 0), ("drive.speed=1000",)),
    ((30, -60, 100), (5e-4, 2e-4), ("drive.speed=2500", SMOOTH)),
    ((0, -100, 300), (0, 0), ("drive.speed=900", ANGULAR)),
]


@pytest.mark.parametrize(("load", "tilt", "words"), CASES)
def test_a_run_starts_settled_and_stays_there(load, tilt, words):
    """Loads and angles are those of the equilibrium at the first output and half a second later."""
    parameters = held_where(load, tilt, words)
    motion = motion_of(parameters)
    first, settled = off(parameters, motion.first_outputs())
    marched(motion, 0.5)
    later, _ = off(parameters, over_a_spacing(parameters, motion))
    assert first.max() < 1e-4
    assert later.max() < 1e-4
    assert settled == 5e-4


@pytest.mark.parametrize(("load", "speed"), [((0, -250, 300), 900), ((0, -320, 400), -600), ((0, -100, 300), 1500)])
def test_a_run_stays_settled_where_balls_slide_on_part_of_their_way(load, speed):
    """More azimuths find that, with the speed of the cage as it varies while balls pass: an even one is 2e-2 off."""
    parameters = held_where(load, words=(f"drive.speed={speed}", ANGULAR))
    motion = motion_of(parameters)
    first, settled = off(parameters, motion.first_outputs())
    marched(motion, 0.2)
    later, _ = off(parameters, over_a_spacing(parameters, motion, 2))
    assert first.max() < 4e-4
    assert later.max() < 4e-4
    assert settled == 5e-4
    turn = settled_at(parameters, np.zeros(1)).turn
    assert len(turn.motion) > 65
    orbit, change = turn.pace(np.array([0.7, 0.7 + 1e-6, 0.7 + 2.0 * np.pi / parameters.geometry.balls]))
    assert orbit[2] == pytest.approx(orbit[0], rel=1e-12)
    assert orbit[1] - orbit[0] == pytest.approx(1e-6 * change[0], rel=1e-3)


def test_the_cage_of_a_run_goes_round_as_its_settled_motion_says():
    """Its speed varies as balls pass, about a mean, as that of balls that move."""
    parameters = held_where((0, -100, 300), words=("drive.speed=1500", ANGULAR))
    motion = motion_of(parameters)
    marched(motion, 0.1)
    turn = settled_at(parameters, np.zeros(1)).turn
    seen = over_a_spacing(parameters, motion, 40)
    told, _ = turn.pace(seen.orbit_angle[:, 0])
    assert np.ptp(told) > 0.1
    assert seen.cage_speed == pytest.approx(told, abs=0.03 * np.ptp(told))


def test_the_cases_reach_where_the_centrifugal_load_is_more_than_that_of_the_contact():
    parameters = held_where(ACROSS, words=("drive.speed=5600",))
    contacts = settled_at(parameters, np.arange(8) * np.pi / 4.0).found.contacts
    assert (contacts.centrifugal / contacts.load[:, 0]).max() > 1.4


@pytest.mark.parametrize(
    ("load", "tilt", "words", "seconds"),
    [
        (THRUST, (0, 0), ("drive.speed=5000", SMOOTH), 2.0),
        (ACROSS, (0, 0), ("drive.speed=3000", SMOOTH), 2.0),
        (ACROSS, (0, 0), ("drive.speed=-4500", SMOOTH), 1.0),
        (THRUST, (5e-4, 0), ("drive.speed=1000",), 1.0),
    ],
)
def test_a_run_from_rolling_drifts_there(load, tilt, words, seconds):
    """With the axes of rolling at the start it is off at first, and no more once they have turned."""
    parameters = held_where(load, tilt, words, control="shared")
    settled = held_where(load, tilt, words)
    motion = motion_of(parameters)
    early, _ = off(settled, motion.first_outputs())
    marched(motion, seconds)
    late, _ = off(settled, over_a_spacing(parameters, motion))
    assert early.max() > 1e-3
    assert late.max() < 5e-4


@pytest.mark.parametrize("speed", [3000.0, -5000.0])
def test_under_thrust_axes_are_parallel_to_the_bearings(speed):
    """No pitch, no gyroscopic moment, and the orbit speed of a ball that rolls so, in closed form."""
    parameters = held_where(THRUST, words=(f"drive.speed={speed}",))
    contacts = settled_at(parameters, np.arange(8) * np.pi / 4.0).found.contacts
    inner, outer = np.cos(contacts.angle[0])
    gamma = parameters.geometry.ball_diameter / parameters.geometry.pitch_diameter
    approach = 0.5 * contacts.approach[0] / (0.5 * parameters.geometry.ball_diameter)
    # of points half the approach inside the ball, its centre on the pitch circle to 1e-3
    wanted = speed * (1.0 - gamma * inner) * outer / (inner + outer)
    assert contacts.orbit == pytest.approx(np.full(8, wanted), rel=2.0 * (approach.max() + 5e-4))
    assert np.abs(contacts.pitch).max() < 1e-6 * abs(speed)
    assert np.abs(contacts.friction).max() < 1e-6 * contacts.load.max()


def test_contacts_are_those_of_balls_that_move():
    """Loads, slip and moments of a ball anyhow in motion, ring displaced, are those of `forces.equations`."""
    parameters = scene_of("drive.offset=[2e-6,-1e-6,1.2e-5]", "drive.speed=700", "contact.relaxation_time=2e-6")
    setting, bearing = setting_of(parameters, LAW, 700.0), bearing_of(parameters, LAW)
    azimuths, orbit = np.array([0.3, 2.0, 4.4]), 280.0
    acting = Surroundings(parameters, setting, (*parameters.drive.offset, 0.0, 0.0), azimuths)
    motion = np.array([[1.3e-4, 1.6e-5, 2e-4, -3e-4, 60.0, 4.0, -1150.0]] * 3) * np.array([[1.0], [1.02], [0.99]])
    found = acting.wrench(motion, orbit)
    force = found.force()
    for k, azimuth in enumerate(azimuths):
        radius, height = setting.outer.locus_radius + motion[k, 0], motion[k, 1]
        place, velocity = (radius, 0.0, height), (motion[k, 2], radius * orbit, motion[k, 3])
        centre = about_z(math.cos(azimuth), -math.sin(azimuth), parameters.drive.offset)
        total, moment = np.zeros(3), np.zeros(3)
        for raceway, middle, speed in ((bearing.inner, centre, 700.0), (bearing.outer, (0.0, 0.0, 0.0), 0.0)):
            one = single_contact(bearing, raceway, middle, speed, place, velocity, tuple(motion[k, 4:]))
            total, moment = total + one.force, moment + one.torque
        scale = found.contacts.load[k].max()
        assert scale > 1.0
        assert force[k] == pytest.approx(total, abs=2e-5 * scale)
        assert found.moment[k] == pytest.approx(moment, abs=2e-5 * scale * setting.ball_radius)


def test_derivatives_of_the_search_are_those_of_what_is_left():
    parameters = held_where(ACROSS, words=("drive.speed=3000",))
    setting, ring = setting_of(parameters, LAW, 3000.0), (*parameters.drive.offset, *parameters.drive.tilt)
    turn = settled_turn(parameters, setting, ring)
    search = Search(parameters, setting, ring, len(turn.motion), 100.0)
    at = np.concatenate([turn.motion.ravel(), [turn.orbit], turn.swing])
    at[2::7] *= 1.0 + 1e-3
    matrix, towards = search.derivatives(at), np.random.default_rng(3).normal(size=len(at)) * search.columns
    step = 1e-7
    exact = (search.left(at + step * towards) - search.left(at - step * towards)) / (2.0 * step)
    size = np.abs(matrix) @ np.abs(towards)
    assert (np.abs(matrix @ towards - exact) < 1e-3 * size + 1e-9).all()


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("drive.speed=0",), "stands still"),
        (("contact.friction_coefficient=0",), "without friction"),
        (("contact.friction=spot",), "over spots"),
        (("geometry.radial_clearance=10e-6", "rings.inner.load=[0,-500,100]", "drive.speed=157.08"), "next to nothing"),
    ],
)
def test_where_axes_do_not_settle_equilibria_are_those_of_rolling_and_say_why(words, reason):
    load = "rings.inner.load=[0,-60,100]", "model.dimension=quasi_static"
    found = []
    for control in ("settled", "shared"):
        parameters = scene_of(*load, *words, f"model.control={control}")
        support = support_of(parameters)
        found.append(in_motion(parameters, solver_of(parameters, LAW, load_line(support)), support))
    one, two = found
    assert reason in one.turn.why
    assert not two.turn.why
    assert math.isnan(one.found.settled)
    assert np.array_equal(one.found.contacts.load, two.found.contacts.load)
    assert np.array_equal(one.found.coordinates, two.found.coordinates)


def test_a_free_ring_bears_its_load_where_its_balls_have_settled():
    """In one equilibrium, in a run of them, and at the start of balls that move: the ring hardly moves from there."""
    load = "rings.inner.load=[20,-60,100]", "rings.inner.moment=[0.1,0.05]", "drive.speed=2500"
    still = scene_of(*load, "model.dimension=quasi_static", "model.control=settled")
    support = support_of(still)
    found = in_motion(still, solver_of(still, LAW, 0.0), support).found
    assert found.loads == pytest.approx([20.0, -60.0, 100.0, 0.1, 0.05], rel=1e-9)
    run = bearing_motion(still, Choice(LAW, "quasi_static", 0.0, "", ())).first_outputs()
    # its friction was looked at with a ball on the load line
    assert run.inner_ring_offset[0] == pytest.approx(found.coordinates[:3], rel=5e-3)
    assert run.normal_load[0] == pytest.approx(found.contacts.load, rel=2e-3)
    mass = "rings.inner.mass=0.2", "rings.inner.inertia=[1e-4,1e-4]"
    moving = scene_of(*load, *mass, "model.dimension=free", "model.control=settled")
    motion = motion_of(moving)
    begin = motion.first_outputs()
    assert begin.inner_ring_offset[0] == pytest.approx(found.coordinates[:3], abs=1e-9)
    assert begin.normal_load[0] == pytest.approx(found.contacts.load, rel=5e-4)
    rolling = scene_of(*load, "model.dimension=quasi_static", "model.control=shared")
    elsewhere = solver_of(rolling, LAW, 0.0).solve(support).coordinates[:3]
    marched(motion, 0.01)
    now = motion.advance(np.array([1e-3]), 1e-3).inner_ring_offset[0]
    assert np.abs(now - found.coordinates[:3]).max() < 0.2 * np.abs(now - elsewhere).max()


def test_what_is_told_of_settled_equilibria_is_what_is_left():
    parameters = held_where(ACROSS, words=("drive.speed=4500",))
    support = support_of(parameters)
    solver = solver_of(parameters, LAW, load_line(support))
    found = in_motion(parameters, solver, support).found
    told = angle_errors(parameters, solver, found)
    assert told == pytest.approx(np.full((8, 2), 5e-4 * np.abs(found.contacts.angle).max()))
    answer = answer_of(parameters, LAW, solver, support, found)["normal_load_inner_n_error"]
    unsettled = found._replace(settled=math.nan)
    rolling = answer_of(parameters, LAW, solver, support, unsettled)["normal_load_inner_n_error"]
    left = left_by_rolling(parameters, solver, support, unsettled).loads[:, 0]
    assert np.array(answer) - 5e-4 * found.contacts.load.max() == pytest.approx(np.array(rolling) - left)


def test_a_speed_that_passes_scales_what_balls_do():
    """Loads go on evenly while the ring speeds up, and end where they are at the last speed alone."""
    words = "rings.inner.load=[0,-60,100]", "model.dimension=quasi_static", "drive.acceleration=5000"
    words = (*words, "model.control=settled")
    motion = bearing_motion(scene_of(*words, "drive.speed=2000"), Choice(LAW, "quasi_static", 0.0, "", ()))
    motion.first_outputs()
    motion.goal_speed = 2500.0
    ramp = motion.advance(np.linspace(0.0, 0.1, 101)[1:], 0.1)
    outward = ramp.normal_load[:, :, 1].sum(axis=1)
    steps = np.diff(outward)
    assert np.abs(steps - steps.mean()).max() < 0.5 * (outward[-1] - outward[0])
    motion.advance(np.array([0.1]), 0.1)
    there = bearing_motion(scene_of(*words, "drive.speed=2500"), Choice(LAW, "quasi_static", 0.0, "", ()))
    last = motion.advance(np.array([1e-3]), 1e-3)
    assert last.cage_speed[0] == pytest.approx(there.first_outputs().cage_speed[0], rel=1e-7)


def answered(capsys, *words):
    assert cli.main(["bearing", *words, "--json"]) == cli.DONE
    return json.loads(capsys.readouterr().out)


def test_the_command_takes_the_words_of_the_scene(capsys):
    """An option and the scene's key are one; which axes are taken is told, and why they are not those asked for."""
    scene = "bearing_218_thrust"
    orbit = {}
    for control in CONTROL_WORDS:
        by_option, by_scene = (
            answered(capsys, scene, *words) for words in (("--control", control), ("--set", f"model.control={control}"))
        )
        assert by_option == by_scene
        assert by_option["control"] == ("shared" if control == "auto" else control)
        orbit[control] = by_option["fault_frequencies_hz"]["ftf"]
    assert orbit["auto"] == orbit["shared"]
    assert orbit["settled"] > 1.08 * orbit["shared"]
    assert answered(capsys, scene, "--set", "contact.friction=spot")["control"] == "outer"
    still = answered(capsys, scene, "--control", "settled", "--set", "drive.speed=0")
    assert still["control"] == "shared"
    assert "stands still" in still["control_reason"]


def test_a_reset_takes_a_run_of_settled_equilibria_back_to_the_bit():
    words = "rings.inner.load=[0,-60,100]", "model.dimension=quasi_static", "model.control=settled", "drive.speed=2000"
    motion = bearing_motion(scene_of(*words), Choice(LAW, "quasi_static", 0.0, "", ()))
    first = motion.advance(np.array([1e-3]), 1e-3)
    motion.goal_speed = 2100.0
    motion.advance(np.array([0.2]), 0.2)
    motion.reset()
    again = motion.advance(np.array([1e-3]), 1e-3)
    assert all(np.array_equal(one, two) for one, two in zip(first, again, strict=True))


@pytest.mark.parametrize(
    "words",
    [
        ("model.dimension=quasi_static", "rings.inner.load=[0,-60,100]"),
        ("model.dimension=prescribed", "drive.offset=[0,-1e-6,3e-5]"),
        ("wanted.outputs=loads", "drive.offset=[0,-1e-6,3e-5]"),
        ("model.dimension=free", "rings.inner={load: [0,-60,100], mass: 0.2, inertia: [1e-4,1e-4]}"),
    ],
)
def test_a_run_looks_for_its_settled_motion_from_rolling_once(monkeypatch, words):
    """Who chooses, starts and tells what the run is worth begins with what was found, however often it is asked."""
    searches = []
    found = Search.found
    monkeypatch.setattr(Search, "found", lambda self, begin: searches.append(self.count) or found(self, begin))
    words = (*ALONE[:2], *words, "model.control=settled", "drive.speed=1003", "run.duration=0.005")
    run = simulate(load_scene("bearing_6203", words))
    assert list(run)
    assert run.report.figures
    assert len(searches) == len(set(searches)) == 1


def test_a_run_says_why_axes_have_not_settled(capsys):
    words = "rings.inner.load=[0,-60,100]", "model.dimension=quasi_static", "model.control=settled"
    told = [choose(load_scene("bearing_6203", (*words, *more))).warnings for more in ((), ("contact.friction=spot",))]
    assert not any("settled" in one for one in told[0])
    (warning,) = (one for one in told[1] if "settled" in one)
    scene = "bearing_6203", "--load", "0,-60,100", "--control", "settled", "--set", "contact.friction=spot"
    assert answered(capsys, *scene)["control_reason"] == warning
    assert "because friction over spots resists drilling" in warning


def test_a_table_is_passed_on_to_a_speed_nearby():
    """Accelerations go with the square of the speed, speeds with it, forces of friction as they are."""
    rows = np.random.default_rng(3).uniform(1.0, 2.0, (4, columns.SIZES))
    rows[:, columns.SPEED] = 100.0
    passed = rows.copy()
    columns.pass_speed(passed, 101.0)
    times = passed / rows
    assert times[:, [columns.ORBIT, columns.ROLL, columns.PITCH, columns.SPEED]] == pytest.approx(1.01)
    assert times[:, [columns.INERTIA, columns.INERTIA + 1, columns.HEAVY]] == pytest.approx(1.01**2)
    rest = [*range(columns.INERTIA), columns.HOLDING, columns.VISCOUS, columns.VISCOUS + 1]
    assert (times[:, rest] == 1.0).all()
    turn = Turn(rows[:, :5], 40.0).quicker(1.01)
    assert turn.orbit == pytest.approx(40.4)
    assert turn.motion[:, 2:] == pytest.approx(1.01 * rows[:, 2:5])
    assert (turn.motion[:, :2] == rows[:, :2]).all()
