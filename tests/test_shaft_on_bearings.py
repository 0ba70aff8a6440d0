"""A rigid shaft on two bearings: against single bearings, levers, linear theory, SciPy, and its own books of energy."""

import itertools
import json
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import linalg
from scipy.integrate import solve_ivp
from scipy.optimize import root
from shafts import energy, motion_of, outputs_of, parameters_of, same_when_cut

from bearing_twin.command.cli import BAD_INPUT, main
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.loading import Loading
from bearing_twin.kinds.bearing.quasi_static.statics import EquilibriumSolver, Support, azimuths_of, setting_of
from bearing_twin.kinds.bearing.ratings import equivalent_load, ratings_of, reference_life
from bearing_twin.kinds.shaft.course import ShaftCourse, constant_loads
from bearing_twin.kinds.shaft.derived import bearing_scene, middle_of, speeds_of
from bearing_twin.kinds.shaft.figures import wanted_errors
from bearing_twin.kinds.shaft.modes import (
    critical_speeds,
    matrices_of,
    modes_at,
    modes_of,
    stiffest_mode,
    unbalance_response,
)
from bearing_twin.kinds.shaft.motion import ShaftMotion
from bearing_twin.kinds.shaft.outputs import place_of
from bearing_twin.kinds.shaft.parameters import SIDES
from bearing_twin.kinds.shaft.rotor import RATE
from bearing_twin.kinds.shaft.statics import balance_of, rotor_of
from bearing_twin.kinds.shaft.topics import wrenches
from bearing_twin.kinds.shaft.worth import wide_of
from bearing_twin.numerics.rosenbrock_step import factorise, solve_factorised
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.sample import joined
from bearing_twin.uq.quantities import quantities_of

STILL = ("gravity=[0,0,0]", "shaft.unbalances=[]")
LOOSE = (  # two 6203 with clearance, one facing each way, so that the shaft is loaded alike along its axis
    *(f"{side}.{key}" for side in SIDES for key in ("geometry.radial_clearance=8e-6", "offset=0.0")),
    "left.place=-0.05",
    "right.place=0.05",
)


def alone(parameters, side, law="hertz"):
    """The solver of one bearing by itself, its balls where the shaft has them, without their weight."""
    scene = bearing_scene(parameters, side)
    azimuths = azimuths_of(scene.geometry.balls, getattr(parameters, side).ball_angle)
    return EquilibriumSolver(setting_of(scene, law, parameters.drive.speed), azimuths)


def coupling(parameters, side):
    """From the shaft's coordinates (5,) to those of a ring, without what stands there anyway: (5, 5)."""
    mounted = getattr(parameters, side)
    a, s = mounted.place, float(mounted.facing)
    return np.array([[1, 0, 0, 0, a], [0, 1, 0, -a, 0], [0, 0, s, 0, 0], [0, 0, 0, s, 0], [0, 0, 0, 0, s]], float)


def middles(parameters):
    return {side: np.array([0.0, 0.0, middle_of(getattr(parameters, side)), 0.0, 0.0]) for side in SIDES}


def loads_alone(parameters, side, ring):
    """(loads (5,), stiffness (5, 5)) of one bearing by itself, its ring held at `ring` (5,)."""
    found = alone(parameters, side).solve(Support((False,) * 5, (0.0,) * 5, tuple(map(float, ring))))
    return found.loads, found.stiffness


def test_a_symmetric_shaft_loads_each_bearing_by_half():
    """Against each bearing alone, its ring pushed by half the load and held along its axis and in tilt as it stands."""
    changes = (*STILL, *LOOSE, "shaft.loads=[[0,30,-800,0,0,0]]", "drive.speed=300")
    parameters = parameters_of(*changes)
    found = balance_of(parameters, "hertz", 300.0)
    for side, ring, contacts in zip(SIDES, found.rings, found.contacts, strict=True):
        support = Support((True, True, False, False, False), (15.0, -400.0, 0.0, 0.0, 0.0), tuple(map(float, ring)))
        expected = alone(parameters, side).solve(support)
        assert np.allclose(ring[:2], expected.coordinates[:2], rtol=0.0, atol=1e-9 * abs(ring[1]))
        assert np.abs(contacts.load - expected.contacts.load).max() <= 1e-9 * contacts.load.max()


def test_an_overhung_load_is_shared_by_levers():
    """Forces of the bearings balance force and moment, and where rings bear no moment of their own they are levers."""
    parameters = parameters_of(*STILL, *LOOSE, "shaft.loads=[[0.12,0,-300,0,0,0]]", "drive.speed=0")
    motion = motion_of(*STILL, *LOOSE, "shaft.loads=[[0.12,0,-300,0,0,0]]", "drive.speed=0")
    out = motion.first_outputs()
    force, moment = np.array(out["bearing_force"][0]), np.array(out["bearing_moment"][0])
    assert force[:, 1].sum() == pytest.approx(300.0, rel=1e-9)
    places = np.array([parameters.left.place, parameters.right.place])
    # about x: sum of - place F_y + M_x of the bearings, against that of the load
    assert (-places * force[:, 1] + moment[:, 0]).sum() == pytest.approx(-0.12 * 300.0, rel=1e-9)
    by_lever = np.array([300.0 * (0.05 - 0.12), 300.0 * (0.12 + 0.05)]) / 0.1
    # what the rings bear by themselves is off the levers, and nothing else
    off = moment[:, 0].sum() / 0.1
    assert force[:, 1] == pytest.approx(by_lever + np.array([-off, off]), rel=1e-9)
    assert force[:, 1] == pytest.approx(by_lever, rel=0.05)


def bearing_stiffness(capsys, parameters, side, ring):
    """The 5 x 5 stiffness that `bearing_twin bearing` gives for one bearing with its ring held there."""
    geometry = getattr(parameters, side).geometry
    words = [f"geometry.{key}={getattr(geometry, key)}" for key in ("radial_clearance", "inner_conformity")]
    angle = math.degrees(getattr(parameters, side).ball_angle)
    command = ["bearing", geometry.designation, *(word for one in words for word in ("--set", one))]
    held = [
        "--displacement",
        ",".join(f"{one:.17g}" for one in ring[:3]),
        "--misalignment",
        ",".join(f"{one:.17g}" for one in ring[3:]),
    ]
    speed = ["--set", f"drive.speed={parameters.drive.speed}", "--ball-angle", str(angle), "--json"]
    assert main([*command, *held, *speed]) == 0
    return np.array(json.loads(capsys.readouterr().out)["stiffness"])


def test_natural_frequencies_are_those_of_the_bearings_stiffness(capsys):
    parameters = parameters_of("drive.speed=0", "shaft.unbalances=[]", "contact.relaxation_time=0")
    found = balance_of(parameters, "hertz", 0.0)
    stiffness = np.zeros((5, 5))
    for side, ring in zip(SIDES, found.rings, strict=True):
        across = coupling(parameters, side)
        stiffness += across.T @ bearing_stiffness(capsys, parameters, side, ring) @ across
    mass, inertia = parameters.shaft.mass, parameters.shaft.inertia[0]
    squares = linalg.eigh(stiffness, np.diag([mass] * 3 + [inertia] * 2), eigvals_only=True)
    modes, _ = modes_of(parameters, "hertz")
    assert modes.frequencies == pytest.approx(np.sqrt(squares) / (2.0 * math.pi), rel=1e-6)


def test_two_bearings_in_one_place_are_one_for_half_the_shaft():
    """A free ring on a preloaded bearing, doubled: 192.83, 289.77 and 2150.4 Hz; turning, 178.85 and 207.90 Hz.

    Those are with the mass of the balls, which `tests/test_ring_jacobian.py` has, and so up to 0.3 % lower.
    """
    geometry = "{radial_clearance: -6.0e-6}"
    pair = (
        *STILL,
        *(f"{side}.{key}" for side in SIDES for key in (f"geometry={geometry}", "facing=1", "offset=0.0")),
        "left.place=-1e-7",
        "right.place=1e-7",
        "shaft.mass=1.0",
        "contact.relaxation_time=0",
        "drive.speed=0",
    )
    single = parameters_of(*pair)
    push = 2.0 * loads_alone(single, "left", (0.0, 0.0, 10e-6, 0.0, 0.0))[0][2]
    loaded = (*pair, f"shaft.loads=[[0,0,0,{push:.17g},0,0]]")
    at_rest, _ = modes_of(parameters_of(*loaded, "shaft.inertia=[2e-4,1e-9]"), "hertz")
    expected = [192.83, 192.83, 289.77, 2150.4, 2150.4]
    assert at_rest.frequencies == pytest.approx(expected, rel=3e-3)
    assert (at_rest.frequencies > expected).all()
    parameters = parameters_of(*loaded, "shaft.inertia=[2e-4,2e-4]")
    turning = modes_at(
        matrices_of(rotor_of(parameters, "hertz"), balance_of(parameters, "hertz", 0.0).stiffness), 183.26
    )
    assert turning.frequencies[:2] == pytest.approx([178.85, 207.90], rel=3e-3)
    assert turning.forward[:2] == pytest.approx([0.0, 1.0], abs=1e-6)


def test_a_shaft_struck_lightly_rings_at_its_frequencies():
    changes = ("drive.speed=0", "shaft.unbalances=[]", "shaft.start=equilibrium", "wanted.tolerance=1e-6")
    motion = motion_of(*changes)
    modes, _ = modes_of(motion.parameters, "hertz")
    rest = motion.kept[1].copy()
    motion.kept[:2, RATE + 2] = 1e-5  # m/s along the axis
    motion.kept[:2, RATE + 3] = 1e-3  # rad/s
    times, out = outputs_of(motion, 0.2, 8000)
    for values, expected in (
        (out["position"][:, 2] - rest[2], modes.frequencies[0]),
        (out["tilt"][:, 0] - rest[3], modes.frequencies[1:]),
    ):
        spectrum = np.abs(np.fft.rfft(values * np.hanning(len(values))))
        peak = int(spectrum[5:].argmax()) + 5
        # the top of the parabola through three lines in logarithms
        low, top, high = np.log(spectrum[peak - 1 : peak + 2])
        line = (peak + 0.5 * (low - high) / (low - 2.0 * top + high)) / (times[1] * len(values))
        assert np.abs(line / expected - 1.0).min() < 5e-3


@pytest.mark.parametrize("speed", [100.0, 900.0])
def test_a_small_unbalance_answers_as_linear_theory_says(speed):
    """From the settled start on: q = Re(u exp(i w t)), by the 5 x 5 receptance with stiffness, damping, gyroscopes."""
    changes = ("gravity=[0,0,0]", f"drive.speed={speed}", "wanted.tolerance=1e-6")
    size = 1e-7 * (900.0 / speed) ** 2
    motion = motion_of(*changes, f"shaft.unbalances=[[0.02,{size},0.7]]")
    rotor, found = motion.rotor, balance_of(motion.parameters, "hertz", speed)
    matrices = matrices_of(rotor, found.stiffness)
    times, out = outputs_of(motion, 4.0 * math.pi / speed, 64)
    motion_now = np.concatenate([out["position"], out["tilt"]], axis=1) - found.coordinates
    inertia, k = np.diag(matrices.inertia), found.stiffness
    push = size * speed**2 * np.exp(0.7j) * np.array([1.0, -1.0j, 0.0, 0.02j, 0.02])
    answer = np.linalg.solve(
        k + 1j * speed * (rotor.relaxation_time * k + speed * matrices.gyroscopic) - speed**2 * inertia, push
    )
    assert unbalance_response(rotor, matrices, speed) == pytest.approx(answer, rel=1e-9)
    expected = (answer * np.exp(1j * speed * times)[:, None]).real
    for part in (slice(0, 2), slice(3, 5)):
        assert np.abs((motion_now - expected)[:, part]).max() < 1e-3 * np.abs(answer[part]).max()


def test_balls_that_pass_move_the_shaft_as_they_move_a_ring():
    """Slowly, so that nothing rings: against equilibria of a bearing under half the load, the balls as they pass."""
    changes = (*STILL, *LOOSE, "shaft.loads=[[0,0,-800,0,0,0]]", "drive.speed=5", "shaft.mass=0.01")
    motion = motion_of(*changes, "wanted.tolerance=1e-6", "shaft.inertia=[1e-5,1e-6]")
    ratio = motion.rotor.seats[0].ratio
    turn = 2.0 * math.pi / 8.0 / ratio / 5.0  # s, from ball to ball
    _, out = outputs_of(motion, turn, 32)
    parameters, heights = motion.parameters, []
    setting = setting_of(bearing_scene(parameters, "left"), "hertz", 5.0)
    for k in range(33):
        azimuths = azimuths_of(8, ratio * 5.0 * turn * k / 32.0)
        support = Support((True, True, False, False, False), (0.0, -400.0, 0.0, 0.0, 0.0), (0.0,) * 5)
        heights.append(EquilibriumSolver(setting, azimuths).solve(support).coordinates[1])
    swing = np.ptp(heights)
    assert swing > 5e-8
    assert np.abs(out["position"][:, 1] - heights).max() < 0.01 * swing


@pytest.mark.parametrize("scene", ["shaft_two_6203", "shaft_angular_pair"])
@pytest.mark.parametrize("more", [(), ("drive.change={time: 0.01, speed: 100.0}",)])
def test_the_books_of_the_shaft_balance(scene, more):
    _, out = outputs_of(motion_of(*more, "wanted.tolerance=1e-6", scene=scene), 0.05, 100)
    books, gross = energy(out)
    assert gross > 1e-7
    assert abs(books[-1] - books[0]) < 1e-6 * gross


def stored_and_taken(*changes, duration):
    """What contacts store (n,), and that less what they took and were led round, of a law with an energy.

    Balls have no mass, so that nothing but contacts holds energy; balance knows no speed.
    """
    law = "contact.normal=linear", "contact.stiffness=1e8", "gravity=[0,0,0]", "drive.speed=20"
    loads = ("shaft.loads=[[0.03,100,-500,0,15,10]]", "shaft.start=equilibrium", "shaft.unbalances=[[0.02,1e-2,0]]")
    motion = motion_of(*LOOSE, *law, *loads, "wanted.tolerance=1e-6", *changes)
    seats = tuple(seat._replace(setting=seat.setting._replace(ball_mass=0.0)) for seat in motion.rotor.seats)
    motion.rotor = motion.rotor._replace(seats=seats)
    _, out = outputs_of(motion, duration, 50)
    stored = out["elastic_energy"] - out["elastic_energy"][0]
    return stored, stored - out["bearing_work"] - out["cage_work"], out


def test_what_bearings_take_is_stored_or_led_round():
    """Moments tilt the rings, so that the cages' work of moments is 5000 times what may be left over."""
    stored, left, out = stored_and_taken("contact.relaxation_time=0", duration=0.1)
    assert np.abs(out["cage_work"]).max() > 0.05 * np.abs(stored).max() > 1e-7
    assert np.abs(left).max() < 1e-6 * np.abs(stored).max()


def test_what_viscous_bearings_take_is_stored_led_round_or_lost():
    """While the shaft rings: what contacts hold then is a quarter off what they will a relaxation time later."""
    change = "contact.relaxation_time=1e-5", "shaft.change={time: 0.001, load: [0, -50, 0]}"
    stored, left, out = stored_and_taken(*change, duration=0.005)
    assert out["dissipated"][-1] > 0.05 * np.abs(stored).max()
    assert np.abs(left).max() < 1e-3 * np.abs(stored).max()


@pytest.mark.parametrize(
    ("turns", "more", "within"),
    [(2, (), 2e-6), (3.7, (), 2e-6), (10, (), 2e-6), (3.7, ("shaft.loads=[[0.01,0,-300,0,0,0]]",), 1e-4)],
)
def test_a_settled_shaft_does_the_work_of_its_unbalance(turns, more, within):
    """Against far shorter steps, and by what the whirl loses; a load of 300 N makes it swing as balls pass, too."""
    duration = 2.0 * math.pi * turns / parameters_of().drive.speed
    motion, finer = motion_of(*more), motion_of(*more, "wanted.tolerance=1e-8")
    _, out = outputs_of(motion, duration, 10)
    _, exact = outputs_of(finer, duration, 10)
    books, gross = energy(out)
    assert motion.counts[0] < 0.2 * finer.counts[0]
    assert abs(books[-1] - books[0]) < 5e-7 * gross
    for name in ("load_work", "bearing_work", "dissipated"):
        assert np.abs(out[name] - exact[name]).max() < within * gross
    if not more:
        assert motion.counts[0] < 5 * turns + 12
        assert out["load_work"][-1] - out["load_work"][0] == pytest.approx(out["dissipated"][-1], rel=2e-2)


def test_the_second_motion_takes_shorter_steps_where_a_turn_sets_them():
    """Else it would find what the first one does, and tell no error."""
    first, second = motion_of(), motion_of(share=0.1)
    for motion in (first, second):
        motion.advance(np.zeros(0), 0.2)
    assert second.counts[0] > 1.8 * first.counts[0]


@pytest.mark.parametrize("more", [(), ("drive.change={time: 0.005, speed: 150.0}", "drive.acceleration=20000")])
def test_what_a_run_is_counted_from_does_not_change_it(more):
    """A whirl that is no answer to anything is added to what the motion is counted from, and taken from its start."""
    one, other = motion_of(*more, "wanted.tolerance=1e-6"), motion_of(*more, "wanted.tolerance=1e-6")
    added = 3e-8 * np.array([[1.0, -0.4, 0.2, 4.0, 3.0], [0.3, 1.2, -0.5, -2.0, 5.0]])
    other.rotor = other.rotor._replace(whirl=other.rotor.whirl + added)
    other.kept[:2, :RATE] -= added[0]
    other.kept[:2, RATE : 2 * RATE] += other.parameters.drive.speed * added[1]
    (_, a), (_, b) = outputs_of(one, 0.02, 40), outputs_of(other, 0.02, 40)
    for name in ("position", "velocity", "tilt", "tilt_rate"):
        assert np.abs(a[name] - b[name]).max() < 1e-3 * np.ptp(a[name], axis=0).max()
    assert np.abs(a["left_normal_load"] - b["left_normal_load"]).max() < 1e-6 * a["left_normal_load"].max()


def tilt_stiffness(parameters):
    return balance_of(parameters, "hertz", 0.0).stiffness[3, 3]


def test_an_o_arrangement_is_stiffer_against_tilt_than_x():
    """Of angular contacts at the same places and preload, by the distance of the contact lines' ends on the axis."""
    still = (*STILL, "drive.speed=0", "shaft.loads=[]")
    o = parameters_of(*still, scene="shaft_angular_pair")
    x = parameters_of(
        *still, "left.facing=-1", "right.facing=1", "left.offset=4e-6", "right.offset=-4e-6", scene="shaft_angular_pair"
    )
    for each in (o, x):
        forces = [one.load[:, 0].mean() for one in balance_of(each, "hertz", 0.0).contacts]
        assert forces == pytest.approx([forces[0]] * 2, rel=1e-9)
    # by the stiffness of one bearing: its springs act where its contact lines meet the axis, outside or inside
    ring = balance_of(o, "hertz", 0.0).rings[0]
    k = loads_alone(o, "left", ring)[1]
    for each, sign in ((o, 1.0), (x, -1.0)):
        expected = 2.0 * (k[3, 3] + 0.015**2 * k[1, 1] + sign * 0.015 * abs(k[1, 3] + k[3, 1]))
        assert tilt_stiffness(each) == pytest.approx(expected, rel=1e-6)
    assert tilt_stiffness(o) > 100.0 * tilt_stiffness(x)


def test_a_mirrored_scene_has_mirrored_answers():
    """Across the plane z = 0: what lies along z and tilts change their sign, the bearings their places."""
    loads = "shaft.loads=[[0.03,20,-300,{},{},0.4]]"
    one = motion_of(loads.format(40, 0.2), f"gravity=[0,-9.8,{2}]", scene="shaft_angular_pair")
    swapped = ["shaft.loads=[[-0.03,20,-300,-40,-0.2,-0.4]]", "gravity=[0,-9.8,-2]", "shaft.unbalances=[[0.05,1e-5,0]]"]
    other = motion_of(*swapped, scene="shaft_angular_pair")
    (_, a), (_, b) = outputs_of(one, 0.01, 50), outputs_of(other, 0.01, 50)
    for name, signs in (("position", (1, 1, -1)), ("tilt", (-1, -1))):
        assert np.abs(a[name] - b[name] * signs).max() < 1e-9 * np.abs(a[name]).max()
    assert np.abs(a["left_normal_load"] - b["right_normal_load"]).max() < 1e-9 * a["left_normal_load"].max()
    assert (
        np.abs(a["bearing_force"] - b["bearing_force"][:, ::-1] * (1, 1, -1)).max()
        < 1e-9 * np.abs(a["bearing_force"]).max()
    )


def test_the_error_falls_with_the_fourth_power_of_the_step():
    """At even steps through a rattling start, against a tolerance of rounding; steps are set by hand."""
    states = []
    for halvings in range(4):
        motion = motion_of("shaft.start=equilibrium")
        step = 1e-4 / 2**halvings
        motion._work.scales[:] = 1e30  # every step is accepted
        for _ in range(2**halvings * 10):
            motion.clock[2] = step
            until = motion.clock[1] + 0.5 * step
            motion.advance(np.zeros(0), until - 1e-9 * motion._now_ns)
        assert motion.clock[1] == pytest.approx(1e-3, rel=1e-9)
        states.append(motion.kept[1][:RATE].copy())
    off = [np.abs(one - two).max() for one, two in itertools.pairwise(states)]
    orders = [math.log2(a / b) for a, b in itertools.pairwise(off)]
    assert orders[-1] == pytest.approx(4.0, abs=0.5)


@pytest.mark.parametrize("change", [(), ("drive.change={time: 0.0123, speed: 50.0}",)])
def test_a_run_is_the_same_to_the_bit_however_it_is_cut(change):
    whole, parts = motion_of(*change), motion_of(*change)
    same_when_cut(whole, parts, (1, 7, 2, 20, 10))


def ball_loads(setting, azimuths, ring):
    """Loads (5,) of the ring on its balls by an own balance: Hertz contacts of two springs in line, SciPy's root."""
    total = np.zeros(5)
    reach_i, reach_o = (one.groove_radius - setting.ball_radius for one in (setting.inner, setting.outer))
    stiff_i, stiff_o = (one.law.given for one in (setting.inner, setting.outer))
    for azimuth in azimuths:
        cosine, sine = math.cos(azimuth), math.sin(azimuth)
        aside, leans = ring[1] * cosine - ring[0] * sine, ring[3] * cosine + ring[4] * sine
        opening = np.array([
            setting.inner.locus_radius - setting.outer.locus_radius + ring[0] * cosine + ring[1] * sine
            - aside**2 / setting.pitch_diameter,
            ring[2] + setting.arm * (ring[3] * sine - ring[4] * cosine) - aside * leans,
        ])  # fmt: skip
        length = np.linalg.norm(opening)
        squeeze = length - reach_i - reach_o
        if squeeze <= 0.0:
            continue
        # linear springs in line without a load on the ball: it rests on the line of both centres
        load = squeeze / (1.0 / stiff_i + 1.0 / stiff_o)
        radial, axial = load * opening / length
        moment, ahead = setting.arm * axial, -2.0 * aside / setting.pitch_diameter * radial - leans * axial
        total += [cosine * radial - sine * ahead, sine * radial + cosine * ahead, axial, 0.0, 0.0]
        total[3:] += [sine * moment - cosine * aside * axial, -cosine * moment - sine * aside * axial]
    return total


def test_the_motion_is_that_of_scipy_with_an_own_balance_of_balls():
    """Balls without mass between linear contacts rest on the line between the grooves' centres: a closed form."""
    changes = (
        *LOOSE, "left.offset=-30e-6", "right.offset=30e-6", "contact.normal=linear", "contact.stiffness=5e7",
        "shaft.loads=[[0.02,0,-300,50,0,0]]", "shaft.unbalances=[[0.03,2e-4,0.4]]", "wanted.tolerance=1e-8",
        "contact.relaxation_time=2e-6", "drive.change={time: 0.002, speed: -60.0}", "drive.acceleration=30000",
    )  # fmt: skip
    motion = motion_of(*changes)
    seats = tuple(seat._replace(setting=seat.setting._replace(ball_mass=0.0)) for seat in motion.rotor.seats)
    motion.rotor = motion.rotor._replace(seats=seats)
    parameters = motion.parameters
    inertia = np.array([parameters.shaft.mass] * 3 + [parameters.shaft.inertia[0]] * 2)
    stays = middles(parameters)
    speed = parameters.drive.speed

    def turned(t):
        ramp = min(max(t - 0.002, 0.0), 0.002)
        angle = speed * t - 15000.0 * ramp**2 - 60.0 * max(t - 0.004, 0.0)
        return angle, speed - 30000.0 * ramp, -30000.0 if 0.002 < t < 0.004 else 0.0

    def slopes(t, y):
        angle, now, rising = turned(t)
        q, v = y[:5], y[5:]
        force = np.array([0.0, -300.0, 50.0, 0.02 * 300.0, 0.0])
        force[:3] += parameters.shaft.mass * np.array(parameters.gravity)
        for place, size, azimuth in parameters.shaft.unbalances:
            turn = size * np.exp(1j * (angle + azimuth)) * (now**2 - 1j * rising)
            force += [turn.real, turn.imag, 0.0, -place * turn.imag, place * turn.real]
        for side, seat in zip(SIDES, motion.rotor.seats, strict=True):
            across = coupling(parameters, side)
            ring = across @ (q + 2e-6 * v) + stays[side]
            azimuths = seat.ratio * angle + 2.0 * math.pi * np.arange(8) / 8.0
            force -= across.T @ ball_loads(seat.setting, azimuths, ring)
        polar = parameters.shaft.inertia[1] * now
        force[3] -= polar * v[4]
        force[4] += polar * v[3]
        return np.concatenate([v, force / inertia])

    times = np.array([0.001, 0.002, 0.003, 0.004, 0.006])
    first = motion.first_outputs()
    begin = np.concatenate([first[name][0] for name in ("position", "tilt", "velocity", "tilt_rate")])
    pieces, at = [], 0.0
    for end in times:  # the speed's change bends the rates: pieces end there
        step = solve_ivp(slopes, (at, end - 1e-15), begin, "DOP853", rtol=1e-10, atol=1e-14)
        begin, at = step.y[:, -1], end
        pieces.append(begin)
    out = motion.advance(times, times[-1])
    found = np.concatenate([out["position"], out["tilt"]], axis=1)
    expected = np.array(pieces)[:, :5]
    assert np.abs(found - expected).max(axis=0) == pytest.approx(0.0, abs=1e-10)
    assert np.abs(found - expected).max() < 1e-5 * np.ptp(expected[:, 1])


def test_the_stiffest_mode_is_the_fastest_at_rest():
    """Its period is what first and least steps are measured by."""
    parameters = parameters_of("contact.relaxation_time=0", scene="shaft_angular_pair")
    matrices = matrices_of(rotor_of(parameters, "hertz"), balance_of(parameters, "hertz", 0.0).stiffness)
    assert stiffest_mode(matrices) == pytest.approx(2.0 * math.pi * modes_at(matrices, 0.0).frequencies[-1], rel=1e-9)


def test_a_critical_speed_is_where_a_forward_whirl_meets_the_shaft():
    parameters = parameters_of("contact.relaxation_time=0")
    matrices = matrices_of(rotor_of(parameters, "hertz"), balance_of(parameters, "hertz", 314.159).stiffness)
    found = critical_speeds(matrices)
    assert found
    for speed in found:
        modes = modes_at(matrices, speed)
        nearest = np.abs(modes.frequencies * 2.0 * math.pi / speed - 1.0).argmin()
        assert modes.frequencies[nearest] * 2.0 * math.pi == pytest.approx(speed, rel=1e-6)
        assert modes.forward[nearest] >= 0.5


def test_a_shaft_that_turns_backward_whirls_as_it_turns():
    parameters = parameters_of()
    matrices = matrices_of(rotor_of(parameters, "hertz"), balance_of(parameters, "hertz", 314.159).stiffness)
    ahead, backward = (modes_at(matrices, speed) for speed in (1000.0, -1000.0))
    assert backward.frequencies == pytest.approx(ahead.frequencies, rel=1e-9)
    assert backward.forward == pytest.approx(ahead.forward, abs=1e-6)
    assert ahead.forward.max() > 0.9


def test_the_wrench_of_both_bearings_about_the_centre_of_mass_holds_weight_and_loads():
    place, *load = loads = [0.02, 30.0, -80.0, 10.0, 1.0, -0.5]
    scene = load_scene("shaft_two_6203", ("shaft.unbalances=[]", f"shaft.loads=[{loads}]"))
    sample = Simulation(scene).advance(1)[0]
    whole = wrenches(scene.parameters, sample)[0]
    weight = np.array([0.0, -9.80665 * scene.parameters.shaft.mass, 0.0])
    assert whole.force == pytest.approx(-weight - np.array(load[:3]), rel=1e-6, abs=1e-6)
    moment = np.cross([0.0, 0.0, place], load[:3]) + np.array([*load[3:], 0.0])
    assert whole.torque == pytest.approx(-moment, rel=1e-6, abs=1e-8)


def test_a_disc_whirls_forward_at_no_speed_where_its_polar_inertia_is_greater():
    """Tilt alone: (I_t - I_p) w^2 = k. Motion along the axis goes round at no speed, however little goes across."""
    stiffness = np.diag([1e8, 1e8, 1e6, 1e4, 1e4])
    stiffness[0, 2] = stiffness[2, 0] = 1.0
    thin = parameters_of("shaft.inertia=[1e-3,2e-3]")  # no body has more about its axis
    rotor = rotor_of(thin, "hertz")._replace(polar=4e-4)
    slender = critical_speeds(matrices_of(rotor, stiffness))
    assert len(slender) == 2
    assert slender[0] == pytest.approx(math.sqrt(1e4 / 6e-4), rel=1e-9)
    assert slender[1] == pytest.approx(math.sqrt(1e8 / rotor.mass), rel=1e-9)
    assert critical_speeds(matrices_of(rotor._replace(polar=1.5e-3), stiffness)) == pytest.approx(slender[1:])


@pytest.fixture(scope="module")
def angular_run():
    """A short run of the shaft on two angular contact bearings, and all its outputs."""
    run = simulate(load_scene("shaft_angular_pair", ("run.duration=0.02",)))
    return run, joined(list(run.blocks()))


def test_the_second_motion_tells_the_error_of_the_first(angular_run):
    """What a run says of its ball loads against a motion at a thousandth of its tolerance."""
    run, whole = angular_run
    scene = run.scene
    said = run.report.errors["wanted_errors"]["ball_loads"]["error"]
    exact = ShaftMotion(scene.parameters, run.choice, 1e-3)
    loads = [exact.first_outputs()["left_normal_load"]]
    times = 1e-9 * whole.time_ns[1:]
    loads.append(exact.advance(times, times[-1])["left_normal_load"])
    off = (
        np.abs(np.concatenate(loads) - whole.values["left_normal_load"]).max() / whole.values["left_normal_load"].max()
    )
    assert off <= scene.parameters.wanted.tolerance
    assert 0.0 < said <= scene.parameters.wanted.tolerance
    assert 0.3 < said / off < 10.0


def test_what_ball_loads_are_off_is_over_the_greatest_of_any_and_no_later_output_takes_it_back():
    own = SimpleNamespace(latest=np.array([10.0, 5.0]), off=0.0)
    loads = {
        "left": SimpleNamespace(load=np.array([80.0, 100.0])),
        "right": SimpleNamespace(load=np.array([9.0, 10.0])),
    }
    for finer in ([10.5, 5.0], [10.0, 5.2]):
        told = wanted_errors(own, SimpleNamespace(latest=np.array(finer), bearings=loads))
        assert told == {"ball_loads": pytest.approx(0.005)}


def test_studies_ask_for_lengths_and_the_least_frequencies_of_a_shaft(angular_run):
    figures = angular_run[0].report.figures
    found = {name: row.figure(figures) for name, row in quantities_of("shaft").items()}
    assert found["first_natural_frequency"] == figures["natural_frequencies_hz"][0]
    assert found["first_critical_speed"] == figures["critical_speeds_rad_s"][0]
    lengths = {"displacement": "displacement_m", "vibration": "displacement_range_m", "tilt": "tilt_rad"}
    for name, key in (lengths | {f"{side}_force": f"{side}_force_n" for side in SIDES}).items():
        assert found[name] == pytest.approx(np.linalg.norm(figures[key]), rel=1e-12)


def test_what_is_left_out_of_a_load_is_left_out_of_its_pressure_by_the_cube_root_and_so_is_the_spot(angular_run):
    report, parameters = angular_run[0].report, angular_run[0].scene.parameters
    wide = wide_of(parameters, "hertz", float(parameters.drive.speed), 0.0)
    for side in SIDES:
        load, pressure = (
            report.errors["errors_by_source"][key]["left_out"] / report.figures[key]
            for key in (f"{side}_greatest_ball_load_n", f"{side}_peak_pressure_pa")
        )
        spot = wide[side].at(report.figures[f"{side}_greatest_ball_load_n"]).contact
        assert (1.0 + load) ** (1.0 / 3.0) * (1.0 + spot) ** (1.0 / 3.0) - 1.0 == pytest.approx(pressure, rel=2e-2)
        assert 0.0 < load < spot


def test_a_place_names_the_raceway_that_bears_the_centrifugal_load_as_well(angular_run):
    _, whole = angular_run
    for side in SIDES:
        [channel] = [one for one in whole.channels if one.name == f"{side}_normal_load"]
        race = int(whole.values[channel.name][0, 3].argmax())
        assert place_of(channel, (3, race)) == (f"{side} ball 3", "outer race")


def test_the_peak_pressure_is_that_of_hertz_at_the_greatest_load_of_either_raceway(angular_run):
    """Curvatures by the pitch diameter: a ball curves towards the inner raceway and away from the outer one."""
    run, whole = angular_run
    for side in SIDES:
        mounted, load = getattr(run.scene.parameters, side), whole.values[f"{side}_normal_load"]
        geometry, angle = mounted.geometry, whole.values[f"{side}_contact_angle"]
        ball, moduli, pressures = geometry.ball_diameter, [], []
        for race, (ring, sign) in enumerate(
            ((mounted.materials.inner_ring, 1.0), (mounted.materials.outer_ring, -1.0))
        ):
            moduli.append(effective_modulus(mounted.materials.ball, ring))
            at = np.unravel_index(load[..., race].argmax(), load.shape[:2])
            across = ball * math.cos(angle[(*at, race)])
            along = 1.0 / ball + sign * across / ball / (geometry.pitch_diameter - sign * across)
            groove = 1.0 / ball - 0.5 / (geometry.inner_conformity * ball)
            pressures.append(ellipse(groove, along, moduli[-1], load[(*at, race)]).peak_pressure)
        assert abs(pressures[0] / pressures[1] - 1.0) > 0.05
        assert run.report.figures[f"{side}_peak_pressure_pa"] == pytest.approx(max(pressures), rel=1e-3)


def test_flags_name_the_bearing_that_yields_and_how_far_a_spot_leaves_the_parabolas():
    """A radial load under which the near bearing yields on its inner raceway alone; circles beside parabolas."""
    keys = ("shaft.load=[0,-4600,0]", "shaft.unbalances=[]", "drive.speed=10", "run.duration=0.002")
    run = simulate(load_scene("shaft_two_6203", (*keys, "solver.companion=off")))
    list(run.blocks())
    left, right = (run.report.figures[f"{side}_peak_pressure_pa"] for side in SIDES)
    flags = run.report.flags
    assert left > 3.2e9 > right
    assert [flag.partition(" ")[0] for flag in flags if "is beyond the yield pressure 3.2e+09 Pa" in flag] == ["left"]
    geometry = run.scene.parameters.left.geometry
    told = [
        re.match(r"(\w+) bearing: a spot reaches (\S+) m along its groove, .* are (\S+) % further", one)
        for one in flags
    ]
    found = {one[1]: (float(one[2]), float(one[3])) for one in told if one}
    assert set(found) == set(SIDES)
    for reach, percent in found.values():
        ball, groove = 0.5 * geometry.ball_diameter, geometry.outer_conformity * geometry.ball_diameter
        true = (ball - math.sqrt(ball**2 - reach**2)) - (groove - math.sqrt(groove**2 - reach**2))
        assert 100.0 * (true / (0.5 * reach**2 * (1.0 / ball - 1.0 / groove)) - 1.0) == pytest.approx(percent, rel=0.25)


def test_lives_are_those_of_the_loads_in_the_second_half_of_the_run(angular_run):
    run, whole = angular_run
    late, figures = whole.time_ns >= 0.01e9, run.report.figures
    assert 0 < np.count_nonzero(~late) < np.count_nonzero(late)
    for place, side in enumerate(SIDES):
        scene, loads = bearing_scene(run.scene.parameters, side), whole.values[f"{side}_normal_load"][late]
        rated, force = ratings_of(scene), whole.values["bearing_force"][late, place]
        life = reference_life(scene.geometry, rated.dynamic, loads[..., 0], loads[..., 1])
        assert figures[f"{side}_reference_life_mrev"] == pytest.approx(life, rel=1e-12)
        radial, axial = np.hypot(force[:, 0], force[:, 1]).mean(), np.abs(force[:, 2]).mean()
        basic = (rated.dynamic / equivalent_load(scene.geometry, radial, axial)) ** 3
        assert figures[f"{side}_basic_life_mrev"] == pytest.approx(basic, rel=1e-12)
        turns_an_hour = 3600.0 * figures["shaft_speed_at_end_rad_s"] / (2.0 * math.pi)
        for name in ("basic_life", "reference_life"):
            hours = 1e6 * figures[f"{side}_{name}_mrev"] / turns_an_hour
            assert figures[f"{side}_{name}_h"] == pytest.approx(hours, rel=1e-12)


def test_the_greatest_speed_tells_what_balance_is_worth_whichever_way_the_shaft_turns():
    """A shaft that slows down, from a speed below zero too: the centrifugal load is that of its start."""
    slows = "drive.change.time=0.05", "drive.change.speed=1000"
    told = [
        choose(load_scene("shaft_two_6203", changes)).reason.partition("; its forces were off by")[0]
        for changes in (("drive.speed=-1200", *slows), ("drive.speed=-1200",), ("drive.speed=-900",))
    ]
    assert told[0] == told[1] != told[2]


@pytest.mark.parametrize("duration", [0.005, 0.02, 0.1])
def test_a_scene_ends_with_the_speed_that_its_shaft_has_then(duration):
    """Before a change of speed, while it speeds up, and long after."""
    parameters = parameters_of("drive.change={time: 0.01, speed: 50}", f"run.duration={duration}")
    end = ShaftCourse(parameters, Loading(parameters.shaft)).turned(duration)[1]
    assert speeds_of(parameters)[-1] == pytest.approx(end, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (("right.place=-0.04",), "left.place = -0.04 m and right.place = -0.04 m leave no distance"),
        (("left.facing=0",), "left.facing = 0 must be 1 or -1"),
        (("left.facing=2",), "left.facing = 2 is out of range"),
        (("shaft.inertia=[1e-4,3e-4]",), "belongs to no body"),
        (("left.geometry.balls=40",), "left.geometry.balls = 40 balls"),
        (("right.geometry.designation=9999",), "right.geometry.designation"),
        (("shaft.loads=[[0.0,1.0]]",), r"shaft.loads\[0\].*must be rows of place"),
        (("shaft.loads=[[0,0,-1e6,0,0,0]]",), "pushes the shaft through the balls.*the greatest in this direction is"),
        (
            ("shaft.loads=[[0,0,0,1e6,0,0]]",),
            "a load of .* pushes the shaft through|tilts the contacts out of the grooves",
        ),
        ((*STILL, *LOOSE), "no ball touches both rings, so that nothing holds the shaft along"),
        (
            ("drive.speed=60000",),
            "at 60000 rad/s the balls are thrown outwards so far that nothing holds the shaft along x",
        ),
        (("drive={acceleration: 1e6, change: {time: 0.1, speed: 6e4}}",), "at 60183.3 rad/s the balls are thrown"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(changes, words, capsys):
    command = ["simulate", "shaft_two_6203", *(word for change in changes for word in ("--set", change))]
    assert main(command) == BAD_INPUT
    error = capsys.readouterr().err.strip().splitlines()
    assert len(error) == 1
    with pytest.raises(SceneError, match=words):
        choose(load_scene("shaft_two_6203", changes))


def test_a_root_of_scipy_is_the_balance():
    """Static equilibrium on both bearings against SciPy's root of the sum of single bearings."""
    parameters = parameters_of("shaft.loads=[[-0.1,50,-200,30,0,0.3]]", scene="shaft_angular_pair")
    found = balance_of(parameters, "hertz", 523.599)
    wanted = rotor_of(parameters, "hertz")
    scales, stays = np.array([1e-6, 1e-6, 1e-6, 1e-4, 1e-4]), middles(parameters)

    def left(unknown):
        total = wanted.weight + constant_loads(parameters)
        for side in SIDES:
            across = coupling(parameters, side)
            ring = across @ (unknown * scales) + stays[side]
            total = total - across.T @ loads_alone(parameters, side, ring)[0]
        return total

    solved = root(left, found.coordinates / scales + 0.3, tol=1e-12)
    # the weight of the balls, which single bearings here leave out, moves the shaft by less
    assert np.abs(solved.x * scales - found.coordinates) / scales == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize(("speed", "load", "orbit"), [(183.26, 2e-4, 0.01), (1000.0, 2e-3, 0.03)])
def test_balls_that_move_by_themselves_say_the_same(speed, load, orbit):
    """A free ring whose balls move, with friction and an even cage, against two such bearings in one place, all twice.

    Loads, means and the orbit that an unbalance drives; equilibria leave out the mass of the balls and friction.
    """
    settled, damped = ("gravity=[0,0,0]", "solver.companion=off", "run.output_rate=5000"), 2e-5
    settled = (*settled, "wanted.tolerance=1e-5")  # what differs is the model
    ring = "{mass: 0.5, inertia: [1.0e-4, 1.0e-4], free: all, unbalance: 1.0e-5, load: [0, -30, 20]}"
    moving = (f"rings.inner={ring}", "model.dimension=free", "cage.kind=even", "drive.offset=[0,0,0]")
    shaft = "{mass: 1.0, inertia: [2.0e-4, 2.0e-4], unbalances: [[0, 2.0e-5, 0]], loads: [[0, 0, -60, 40, 0, 0]]}"
    one = "facing: 1, offset: 0, geometry: {radial_clearance: -6.0e-6}"
    both = (f"shaft={shaft}", f"left={{place: -1e-7, {one}}}", f"right={{place: 1e-7, {one}}}")
    found = []
    for scene, changes in (("bearing_6203", moving), ("shaft_two_6203", both)):
        more = (f"drive.speed={speed}", f"contact.relaxation_time={damped}", "run.duration=0.3")
        found.append(joined(list(simulate(load_scene(scene, (*settled, *changes, *more))).blocks())).values)
    ring, shaft = (values[name][750:] for values, name in zip(found, ("inner_ring_offset", "position"), strict=True))
    assert ring.mean(axis=0)[1:] == pytest.approx(shaft.mean(axis=0)[1:], rel=2e-3)
    assert np.ptp(ring, axis=0)[:2] == pytest.approx(np.ptp(shaft, axis=0)[:2], rel=orbit)
    greatest = (found[0]["normal_load"][750:].max(axis=(0, 1)), found[1]["left_normal_load"][750:].max(axis=(0, 1)))
    assert greatest[0] == pytest.approx(greatest[1], rel=load)


def test_a_dense_system_is_solved_as_numpy_does():
    random = np.random.default_rng(3)
    for n in (1, 4, 10):
        matrix, right = random.normal(size=(n, n)), random.normal(size=n)
        matrix[0, 0] = 0.0 if n > 1 else 1.0  # wants an exchange of rows
        factors, rows, found = matrix.copy(), np.zeros(n, np.int64), right.copy()
        factorise(factors, rows)
        solve_factorised(factors, rows, found)
        assert found == pytest.approx(np.linalg.solve(matrix, right), rel=1e-9)
