"""A shaft on two bearings: statics, frequencies, unbalance, loads over time, an independent integration."""

import math

import numpy as np
import pytest
from runs import run_all
from scipy import linalg
from scipy.integrate import solve_ivp
from shafts import energy, motion_of, outputs_of, parameters_of

from bearing_twin.base.errors import IntegrationError, SceneError
from bearing_twin.base.sample import join_blocks
from bearing_twin.command.cli import BAD_INPUT
from bearing_twin.contact.elasticity import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.equilibrium import EquilibriumSolver, Support, azimuths_of, setting_of
from bearing_twin.kinds.bearing.ratings import equivalent_load, ratings_of, reference_life
from bearing_twin.kinds.contract import Output
from bearing_twin.kinds.shaft.display import longest_arrow, ring_centres, topics, wrenches
from bearing_twin.kinds.shaft.equilibrium import (
    balance_of,
    critical_speeds,
    matrices_of,
    modes_at,
    modes_of,
    rotor_of,
    unbalance_response,
)
from bearing_twin.kinds.shaft.parameters import SIDES, bearing_scene, middle_of
from bearing_twin.run.scene import choose, load_scene
from bearing_twin.run.simulation import Simulation, simulate

FREE_OF_LOADS = ("gravity=[0,0,0]", "shaft.unbalances=[]")
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
    equilibrium = alone(parameters, side).solve(Support((False,) * 5, (0.0,) * 5, tuple(map(float, ring))))
    return equilibrium.loads, equilibrium.stiffness


def bearing_stiffness(run_json, parameters, side, ring, *options):
    """The 5 x 5 stiffness that `bearing_twin bearing` gives for one bearing with its ring held there."""
    geometry = getattr(parameters, side).geometry
    keys = [f"geometry.{key}={getattr(geometry, key)}" for key in ("radial_clearance", "inner_conformity")]
    angle = math.degrees(getattr(parameters, side).ball_angle)
    command = ["bearing", geometry.designation, *(argument for value in keys for argument in ("--set", value))]
    displacement, misalignment = (",".join(f"{value:.17g}" for value in part) for part in (ring[:3], ring[3:]))
    held = "--displacement", displacement, "--misalignment", misalignment
    speed = ["--set", f"drive.speed={parameters.drive.speed}", "--ball-angle", angle]
    return np.array(run_json(*command, *held, *speed, *options)["stiffness"])


def stiffness_of_both(run_json, parameters, *options):
    """The stiffness of the shaft on both bearings where it is in balance, by that of each; and the balance."""
    balance, stiffness = balance_of(parameters, "hertz", parameters.drive.speed), np.zeros((5, 5))
    for side in SIDES:
        transform = coupling(parameters, side)
        ring = transform @ balance.coordinates + middles(parameters)[side]
        stiffness += transform.T @ bearing_stiffness(run_json, parameters, side, ring, *options) @ transform
    return stiffness, balance


def test_natural_frequencies_are_those_of_the_bearings_stiffness(run_json):
    parameters = parameters_of("drive.speed=0", "shaft.unbalances=[]", "contact.relaxation_time=0")
    mass, inertia = parameters.shaft.mass, parameters.shaft.inertia[0]
    stiffness = stiffness_of_both(run_json, parameters)[0]
    squares = linalg.eigh(stiffness, np.diag([mass] * 3 + [inertia] * 2), eigvals_only=True)
    modes, _ = modes_of(parameters, "hertz")
    assert modes.frequencies == pytest.approx(np.sqrt(squares) / (2.0 * math.pi), rel=1e-6)


@pytest.mark.parametrize("speed", [100.0, 900.0])
def test_a_small_unbalance_answers_as_linear_theory_says(speed):
    """From the settled start on: q = Re(u exp(i w t)), by the 5 x 5 receptance with stiffness, damping, gyroscopes."""
    changes = ("gravity=[0,0,0]", f"drive.speed={speed}", "wanted.tolerance=1e-6")
    size = 1e-7 * (900.0 / speed) ** 2
    motion = motion_of(*changes, f"shaft.unbalances=[[0.02,{size},0.7]]")
    rotor, balance = motion.rotor, balance_of(motion.parameters, "hertz", speed)
    matrices = matrices_of(rotor, balance.stiffness)
    times, out = outputs_of(motion, 4.0 * math.pi / speed, 64)
    motion_now = np.concatenate([out["position"], out["tilt"]], axis=1) - balance.coordinates
    inertia, k = np.diag(matrices.inertia), balance.stiffness
    push = size * speed**2 * np.exp(0.7j) * np.array([1.0, -1.0j, 0.0, 0.02j, 0.02])
    response = np.linalg.solve(
        k + 1j * speed * (rotor.relaxation_time * k + speed * matrices.gyroscopic) - speed**2 * inertia, push
    )
    assert unbalance_response(rotor, matrices, speed) == pytest.approx(response, rel=1e-9)
    expected = (response * np.exp(1j * speed * times)[:, None]).real
    for part in (slice(0, 2), slice(3, 5)):
        assert np.abs((motion_now - expected)[:, part]).max() < 1e-3 * np.abs(response[part]).max()


@pytest.mark.parametrize("scene", ["shaft_two_6203", "shaft_angular_pair"])
@pytest.mark.parametrize("changes", [(), ("drive.change={time: 0.01, speed: 100.0}",)])
def test_the_books_of_the_shaft_balance(scene, changes):
    _, out = outputs_of(motion_of(*changes, "wanted.tolerance=1e-6", scene=scene), 0.05, 100)
    books, gross = energy(out)
    assert gross > 1e-7
    assert abs(books[-1] - books[0]) < 1e-6 * gross


def tilt_stiffness(parameters):
    return balance_of(parameters, "hertz", 0.0).stiffness[3, 3]


def test_an_o_arrangement_is_stiffer_against_tilt_than_x():
    """Of angular contacts at the same places and preload, by the distance of the contact lines' ends on the axis."""
    at_rest = (*FREE_OF_LOADS, "drive.speed=0", "shaft.loads=[]")
    o = parameters_of(*at_rest, scene="shaft_angular_pair")
    turned = "left.facing=-1", "right.facing=1", "left.offset=4e-6", "right.offset=-4e-6"
    x = parameters_of(*at_rest, *turned, scene="shaft_angular_pair")
    for arrangement in (o, x):
        forces = [contacts.load[:, 0].mean() for contacts in balance_of(arrangement, "hertz", 0.0).contacts]
        assert forces == pytest.approx([forces[0]] * 2, rel=1e-9)
    # by the stiffness of one bearing: its springs act where its contact lines meet the axis, outside or inside
    ring = coupling(o, "left") @ balance_of(o, "hertz", 0.0).coordinates + middles(o)["left"]
    k = loads_alone(o, "left", ring)[1]
    for arrangement, sign in ((o, 1.0), (x, -1.0)):
        expected = 2.0 * (k[3, 3] + 0.015**2 * k[1, 1] + sign * 0.015 * abs(k[1, 3] + k[3, 1]))
        assert tilt_stiffness(arrangement) == pytest.approx(expected, rel=1e-6)
    assert tilt_stiffness(o) > 100.0 * tilt_stiffness(x)


def ball_loads(setting, azimuths, ring):
    """Loads (5,) of the ring on its balls by an own balance: Hertz contacts of two springs in line, SciPy's root."""
    total = np.zeros(5)
    reach_i, reach_o = (groove.groove_radius - setting.ball_radius for groove in (setting.inner, setting.outer))
    stiff_i, stiff_o = (groove.law.given for groove in (setting.inner, setting.outer))
    for azimuth in azimuths:
        cosine, sine = math.cos(azimuth), math.sin(azimuth)
        lateral, lean = ring[1] * cosine - ring[0] * sine, ring[3] * cosine + ring[4] * sine
        opening = np.array([
            setting.inner.locus_radius - setting.outer.locus_radius + ring[0] * cosine + ring[1] * sine
            - lateral**2 / setting.pitch_diameter,
            ring[2] + setting.arm * (ring[3] * sine - ring[4] * cosine) - lateral * lean,
        ])  # fmt: skip
        length = np.linalg.norm(opening)
        squeeze = length - reach_i - reach_o
        if squeeze <= 0.0:
            continue
        # linear springs in line without a load on the ball: it rests on the line of both centres
        load = squeeze / (1.0 / stiff_i + 1.0 / stiff_o)
        radial, axial = load * opening / length
        moment, ahead = setting.arm * axial, -2.0 * lateral / setting.pitch_diameter * radial - lean * axial
        total += [cosine * radial - sine * ahead, sine * radial + cosine * ahead, axial, 0.0, 0.0]
        total[3:] += [sine * moment - cosine * lateral * axial, -cosine * moment - sine * lateral * axial]
    return total


def test_the_motion_is_that_of_scipy_with_an_own_balance_of_balls():
    """Balls without mass between linear contacts rest on the line between the grooves' centres: a closed form."""
    changes = (
        *(key for key in LOOSE if "offset" not in key),
        "left.offset=-30e-6", "right.offset=30e-6", "contact.normal=linear", "contact.stiffness=5e7",
        "shaft.loads=[[0.02,0,-300,50,0,0]]", "shaft.unbalances=[[0.03,2e-4,0.4]]", "wanted.tolerance=1e-8",
        "contact.relaxation_time=2e-6", "drive.change={time: 0.002, speed: -60.0}", "drive.acceleration=30000",
    )  # fmt: skip
    motion = motion_of(*changes)
    seats = tuple(seat._replace(setting=seat.setting._replace(ball_mass=0.0)) for seat in motion.rotor.seats)
    motion.rotor = motion.rotor._replace(seats=seats)
    motion.reset()
    parameters = motion.parameters
    inertia = np.array([parameters.shaft.mass] * 3 + [parameters.shaft.inertia[0]] * 2)
    offsets = middles(parameters)
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
        for position, size, azimuth in parameters.shaft.unbalances:
            turn = size * np.exp(1j * (angle + azimuth)) * (now**2 - 1j * rising)
            force += [turn.real, turn.imag, 0.0, -position * turn.imag, position * turn.real]
        for side, seat in zip(SIDES, motion.rotor.seats, strict=True):
            transform = coupling(parameters, side)
            ring = transform @ (q + 2e-6 * v) + offsets[side]
            azimuths = seat.ratio * angle + 2.0 * math.pi * np.arange(8) / 8.0
            force -= transform.T @ ball_loads(seat.setting, azimuths, ring)
        polar = parameters.shaft.inertia[1] * now
        force[3] -= polar * v[4]
        force[4] += polar * v[3]
        return np.concatenate([v, force / inertia])

    times = np.array([0.001, 0.002, 0.003, 0.004, 0.006])
    first = motion.first_outputs()
    begin = np.concatenate([first[name][0] for name in ("position", "tilt", "velocity", "tilt_rate")])
    pieces, begin_time = [], 0.0
    for end in times:  # the speed's change bends the rates: pieces end there
        step = solve_ivp(slopes, (begin_time, end - 1e-15), begin, "DOP853", rtol=1e-8, atol=1e-12)
        begin, begin_time = step.y[:, -1], end
        pieces.append(begin)
    out = motion.advance(times, times[-1])
    actual = np.concatenate([out["position"], out["tilt"]], axis=1)
    expected = np.array(pieces)[:, :5]
    assert np.abs(actual - expected).max(axis=0) == pytest.approx(0.0, abs=1e-10)
    assert np.abs(actual - expected).max() < 1e-5 * np.ptp(expected[:, 1])


def test_a_critical_speed_is_where_a_forward_whirl_meets_the_shaft():
    parameters = parameters_of("contact.relaxation_time=0")
    matrices = matrices_of(rotor_of(parameters, "hertz"), balance_of(parameters, "hertz", 314.159).stiffness)
    speeds = critical_speeds(matrices)
    assert speeds
    for speed in speeds:
        modes = modes_at(matrices, speed)
        nearest = np.abs(modes.frequencies * 2.0 * math.pi / speed - 1.0).argmin()
        assert modes.frequencies[nearest] * 2.0 * math.pi == pytest.approx(speed, rel=1e-6)
        assert modes.forward[nearest] >= 0.5


def test_the_wrench_of_both_bearings_about_the_centre_of_mass_holds_weight_and_loads():
    position, *load = loads = [0.02, 30.0, -80.0, 10.0, 1.0, -0.5]
    scene = load_scene("shaft_two_6203", ("shaft.unbalances=[]", f"shaft.loads=[{loads}]"))
    sample = Simulation(scene).advance(1)[0]
    wrench = wrenches(scene.parameters, sample)[0]
    weight = np.array([0.0, -9.80665 * scene.parameters.shaft.mass, 0.0])
    assert wrench.force == pytest.approx(-weight - np.array(load[:3]), rel=1e-6, abs=1e-6)
    moment = np.cross([0.0, 0.0, position], load[:3]) + np.array([*load[3:], 0.0])
    assert wrench.torque == pytest.approx(-moment, rel=1e-6, abs=1e-8)


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
    return run, join_blocks(list(run.blocks()))


def test_the_peak_pressure_is_that_of_hertz_at_the_greatest_load_of_either_raceway(angular_run):
    """Curvatures by the pitch diameter: a ball curves towards the inner raceway and away from the outer one."""
    run, block = angular_run
    for side in SIDES:
        mounted, load = getattr(run.scene.parameters, side), block.values[f"{side}_normal_load"]
        geometry, angle = mounted.geometry, block.values[f"{side}_contact_angle"]
        ball, moduli, pressures = geometry.ball_diameter, [], []
        for race, (ring, sign) in enumerate(
            ((mounted.materials.inner_ring, 1.0), (mounted.materials.outer_ring, -1.0))
        ):
            moduli.append(effective_modulus(mounted.materials.ball, ring))
            row = np.unravel_index(load[..., race].argmax(), load.shape[:2])
            across = ball * math.cos(angle[(*row, race)])
            along = 1.0 / ball + sign * across / ball / (geometry.pitch_diameter - sign * across)
            groove = 1.0 / ball - 0.5 / (geometry.inner_conformity * ball)
            pressures.append(ellipse(groove, along, moduli[-1], load[(*row, race)]).peak_pressure)
        assert abs(pressures[0] / pressures[1] - 1.0) > 0.05
        assert run.report.figures[f"{side}_peak_pressure_pa"] == pytest.approx(max(pressures), rel=1e-3)


def test_lives_are_those_of_the_loads_in_the_second_half_of_the_run(angular_run):
    run, block = angular_run
    second_half, figures = block.time_ns >= 0.01e9, run.report.figures
    assert 0 < np.count_nonzero(~second_half) < np.count_nonzero(second_half)
    for index, side in enumerate(SIDES):
        scene, loads = bearing_scene(run.scene.parameters, side), block.values[f"{side}_normal_load"][second_half]
        rated, force = ratings_of(scene), block.values["bearing_force"][second_half, index]
        life = reference_life(scene.geometry, rated.dynamic, loads[..., 0], loads[..., 1])
        assert figures[f"{side}_reference_life_mrev"] == pytest.approx(life, rel=1e-12)
        radial, axial = np.hypot(force[:, 0], force[:, 1]).mean(), np.abs(force[:, 2]).mean()
        basic = (rated.dynamic / equivalent_load(scene.geometry, radial, axial)) ** 3
        assert figures[f"{side}_basic_life_mrev"] == pytest.approx(basic, rel=1e-12)
        turns_an_hour = 3600.0 * figures["shaft_speed_at_end_rad_s"] / (2.0 * math.pi)
        for name in ("basic_life", "reference_life"):
            hours = 1e6 * figures[f"{side}_{name}_mrev"] / turns_an_hour
            assert figures[f"{side}_{name}_h"] == pytest.approx(hours, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (("right.place=-0.04",), "left.place = -0.04 m and right.place = -0.04 m leave no distance"),
        (("left.facing=0",), "left.facing = 0 must be 1 or -1"),
        (("shaft.inertia=[1e-4,3e-4]",), "belongs to no body"),
        (("left.geometry.balls=40",), "left.geometry.balls = 40 balls"),
        (("right.geometry.designation=9999",), "right.geometry.designation"),
        (("shaft.loads=[[0.0,1.0]]",), r"shaft.loads\[0\].*must be rows of place"),
        (("shaft.table=[[0,0,-1]]",), "6 numbers a row, none left out"),
        (("shaft.change={time: 0.01, load: [0,-1e6,0]}",), "pushes the shaft through the balls"),
        (("shaft.loads=[[0,0,-1e6,0,0,0]]",), "pushes the shaft through the balls.*the greatest in this direction is"),
        (
            ("shaft.loads=[[0,0,0,1e6,0,0]]",),
            "a load of .* pushes the shaft through|tilts the contacts out of the grooves",
        ),
        ((*FREE_OF_LOADS, *LOOSE), "no ball touches both rings, so that nothing holds the shaft along"),
        (
            ("drive.speed=60000",),
            "at 60000 rad/s the balls are thrown outwards so far that nothing holds the shaft along x",
        ),
        (("drive={acceleration: 1e6, change: {time: 0.1, speed: 6e4}}",), "at 60183.3 rad/s the balls are thrown"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(changes, message, run_cli):
    command = ["simulate", "shaft_two_6203", *(argument for change in changes for argument in ("--set", change))]
    error = run_cli(*command, code=BAD_INPUT).err.strip().splitlines()
    assert len(error) == 1
    with pytest.raises(SceneError, match=message):
        choose(load_scene("shaft_two_6203", changes))


AT_REST = ("drive.speed=0", "shaft.unbalances=[]")


def coordinates(out):
    return np.concatenate([out["position"], out["tilt"]], axis=1)


def test_after_a_step_the_shaft_rests_in_balance_and_the_load_has_worked_along_its_way():
    step = "shaft.change={time: 0.01, load: [30, -200, 40], moment: [0.5, -1]}"
    motion = motion_of(*AT_REST, step, "contact.relaxation_time=1e-4", "shaft.load_place=0.02")
    before, after = (balance_of(motion.parameters, "hertz", 0.0, time).coordinates for time in (0.0, 1.0))
    _, out = outputs_of(motion, 0.3, 300)
    path = coordinates(out)
    assert np.abs(path[9] - before).max() < 1e-9 * np.abs(before).max()
    assert path[-1] == pytest.approx(after, rel=1e-6)
    push = np.array([30.0, -200.0, 40.0, 0.5 + 0.02 * 200.0, -1.0 + 0.02 * 30.0])
    assert np.concatenate([out["load"][11], out["load_moment"][11]]) == pytest.approx(push)
    assert not out["load"][10].any()  # that of the part which ends there
    assert out["load_work"][-1] == pytest.approx(push @ (after - before), rel=1e-5)
    books, gross = energy(out)
    assert np.abs(books - books[0]).max() < 1e-5 * gross


def test_a_load_in_between_that_nothing_carries_ends_the_run_with_time_load_and_limit():
    motion = motion_of("shaft.table=[[0,0,0,0,0,0],[0.011,0,0,0,0,0],[0.0111,0,-1e9,0,0,0],[0.012,0,0,0,0,0]]")
    message = (
        r"^at 0.0110\d* s a load of \(.*, -.*, 0\) N.* pushes the shaft through.*the greatest in this direction is"
    )
    with pytest.raises(IntegrationError, match=message) as caught:
        motion.advance(np.arange(1, 30) * 1e-3, 0.029)
    assert (caught.value.reason, caught.value.body) == ("overload", "shaft")


LOADED = (
    *("shaft.unbalances=[]", "shaft.load=[50,-400,30]", "shaft.moment=[3,4]", "shaft.loads=[[0.02,0,-20,7,0,0]]"),
    *("left.ball_angle=0.3", "drive.speed=100", "solver.companion=off"),
)


@pytest.fixture(scope="module")
def drawn():
    """A tilted shaft whose bearings push unlike each other: its scene, and its outputs."""
    scene = load_scene("shaft_two_6203", LOADED)
    return scene, Simulation(scene).advance(60)


def test_arrows_of_forces_end_at_the_rings(drawn):
    scene, block = drawn
    parameters, sample = scene.parameters, block[59]
    [row] = [topic for topic in topics(parameters) if topic.name == "markers"]
    markers = {
        (topic["ns"], topic["id"]): topic for topic in row.fields(Output(parameters, "hertz", sample))["markers"]
    }
    centres, force = ring_centres(parameters, sample), sample["bearing_force"]
    begins, ends = np.moveaxis(np.reshape(markers["forces", 0]["points"], (2, 2, 3)), 1, 0)
    assert ends == pytest.approx(centres, abs=1e-12)
    longest = np.linalg.norm(force, axis=1).max()
    assert ends - begins == pytest.approx(longest_arrow(parameters) * force / longest, rel=1e-9)


def test_figures_are_those_of_the_second_half():
    keys = "shaft.change={time: 0.004, load: [0, -300, 0]}", "run.duration=0.02"
    report, block = run_all("shaft_two_6203", *keys)
    second_half, figures = block.time_ns >= 10_000_000, report.figures
    position, force = block.values["position"][second_half], block.values["bearing_force"][second_half]
    assert figures["displacement_m"] == pytest.approx(position.mean(axis=0).tolist(), rel=1e-9, abs=1e-18)
    assert figures["displacement_range_m"] == pytest.approx(np.ptp(position, axis=0).tolist(), rel=1e-9, abs=1e-18)
    assert figures["left_force_n"] == pytest.approx(force[:, 0].mean(axis=0).tolist(), rel=1e-9, abs=1e-9)
