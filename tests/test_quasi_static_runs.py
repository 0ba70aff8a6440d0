"""Runs from equilibria: against balls that move by themselves, against static answers, in every command."""

import math

import numpy as np
import pytest
from bearings import motion
from runs import a_choice, run_all

from bearing_twin.base.errors import IntegrationError, SceneError
from bearing_twin.contact.materials import MATERIALS, effective_modulus
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.run.scene import choose, load_scene
from bearing_twin.run.simulation import Simulation, simulate
from bearing_twin.shapes import quaternion_product

NO_GRAVITY = "gravity=[0,0,0]"
QUASI_STATIC = "model.dimension=quasi_static"
OUTSIDE = "solver.allow_invalid=on"


def equilibrium_motion(*overrides, scene="bearing_6203"):
    parameters = load_scene(scene, overrides).parameters
    return KINDS["bearing"].motion(parameters, a_choice("hertz", "quasi_static"))


def test_the_error_of_a_load_zone_with_light_balls_is_that_of_moving_balls():
    """Balls at its end carry less than their centrifugal load and bounce: moving ones differ by some newtons."""
    held = ("drive.speed=3000rpm", "drive.offset=[0,-14.7e-6,114.3e-6]", "cage.kind=even", "run.duration=0.06")
    report, equilibria = run_all("6308", *held, "run.output_rate=8000", QUASI_STATIC)
    _, moving = run_all("6308", *held, "run.output_rate=8000", "model.dimension=prescribed")
    azimuths, moving_azimuths = (
        np.arctan2(values["position"][..., 1], values["position"][..., 0]) for values in (equilibria, moving)
    )
    order = np.argsort(azimuths, axis=None)
    for race in range(2):
        sorted_loads = equilibria["normal_load"][..., race].ravel()[order]
        expected = np.interp(moving_azimuths, azimuths.ravel()[order], sorted_loads, period=2.0 * math.pi)
        error = np.abs(moving["normal_load"][..., race] - expected).max() / sorted_loads.max()
        assert 0.3 < error / report.as_dict()["wanted_errors"]["loads"]["model_errors"]["left_out"] < 1.0, race


@pytest.mark.parametrize(("speed", "within"), [(183.0, 5e-4), (1000.0, 2e-3)])
def test_loads_and_angles_are_those_of_the_settled_motion(speed, within):
    """Vectors by their parts across the axis and along it, since balls have orbited a little differently."""
    scene = (NO_GRAVITY, f"drive.speed={speed}")
    moving = motion(*scene)
    for _ in range(5):
        settled = moving.advance(np.array([0.02]), 0.02)
    equilibrium = equilibrium_motion(*scene, "model.control=shared").first_outputs()  # axes take seconds to settle
    for name in ("normal_load", "contact_angle", "approach", "curvature_large"):
        assert getattr(equilibrium, name)[0] == pytest.approx(getattr(settled, name)[0], rel=within), name
    for name, size in (("position", 1e-8), ("velocity", 1e-3), ("point", 1e-7), ("normal", 1e-3)):
        for part in (lambda vectors: np.hypot(vectors[..., 0], vectors[..., 1]), lambda vectors: vectors[..., 2]):
            actual, expected = (part(getattr(vectors, name)[0]) for vectors in (equilibrium, settled))
            assert actual == pytest.approx(expected, abs=size * max(np.abs(expected).max(), 1.0)), name
    assert equilibrium.angular_velocity[0, :, 2] == pytest.approx(settled.angular_velocity[0, :, 2], rel=2e-3)
    assert equilibrium.roll_rate[0] == pytest.approx(settled.roll_rate[0], rel=1e-3)
    for name in ("kinetic_energy", "elastic_energy"):
        assert getattr(equilibrium, name) == pytest.approx(getattr(settled, name), rel=2e-3), name
    for name in ("inner_ring_force", "outer_ring_force"):
        assert getattr(equilibrium, name)[0, 2] == pytest.approx(getattr(settled, name)[0, 2], rel=within), name


def test_friction_carries_the_gyroscopic_moment_and_every_ball_is_in_balance():
    moving = equilibrium_motion(NO_GRAVITY, "model.control=shared", "drive.speed=3000.0", "drive.offset=[0,0,3e-5]")
    out = moving.first_outputs()
    mass, radius = moving.setting.ball_mass, moving.setting.ball_radius
    # Newton and Euler of a ball that goes round evenly: m v' and (d/dt) I w, both turning with the orbit
    orbit = np.linalg.norm(out.velocity[0], axis=-1) / np.linalg.norm(out.position[0, :, :2], axis=-1)
    turning = np.stack([np.zeros(8), np.zeros(8), orbit], axis=-1)
    assert out.raceway_force[0] == pytest.approx(mass * np.cross(turning, out.velocity[0]), rel=2e-2, abs=1e-9)
    change = 0.4 * mass * radius**2 * np.cross(turning, out.angular_velocity[0])
    assert np.abs(change).max() > 1e-5
    assert out.raceway_torque[0] == pytest.approx(change, rel=2e-2, abs=1e-9)


def test_the_rig_under_load_is_in_balance_at_every_output():
    report, values = run_all("bearing_6203_rig_1000N", QUASI_STATIC, "rings.inner.mass=0", "run.duration=0.2")
    assert report.stepper == "quasi_static"
    assert report.status == "done"
    assert values["inner_ring_force"] == pytest.approx(np.tile([0.0, 1000.0, 0.0], (201, 1)), abs=1e-6)
    sag = -values["inner_ring_offset"][:, 1]
    assert 21.85e-6 < sag.min() < 21.86e-6 + 1e-8
    assert 22.11e-6 < sag.max() < 22.13e-6
    spacing = np.diff(values["orbit_angle"], axis=1)
    assert spacing == pytest.approx(math.pi / 4.0, abs=1e-12)
    orbit = (values["orbit_angle"][-1] - values["orbit_angle"][0]) / 0.2
    assert orbit == pytest.approx(0.5 * 157.0796 * (1.0 - 6.75 / 28.55), rel=1e-9)
    assert abs(report.figures["energy_closure"]) < 1e-9
    # the outer ring takes the load and the half of the balls' weight that is across their orbits; the cage the other,
    # and what the inner raceway, whose centre is below, pushes along them
    weight = 4.0 * 7850.0 * math.pi / 6.0 * 6.75e-3**3 * 9.80665
    sine, cosine = np.sin(values["orbit_angle"]), np.cos(values["orbit_angle"])
    along = cosine * values["raceway_force"][..., 1] - sine * values["raceway_force"][..., 0]
    x, y = values["inner_ring_offset"][:, :2].T[..., None]
    slope = (y * cosine - x * sine) / (0.5 * 28.55e-3)
    assert along == pytest.approx(-values["normal_load"][..., 0] * slope, rel=1e-5, abs=1e-12)
    assert values["outer_ring_force"][:, 1] == pytest.approx(-1000.0 - weight - (cosine * along).sum(axis=1), rel=1e-6)


@pytest.mark.parametrize(
    ("scene", "overrides"),
    [("6308", ("rings.inner.load=[0,-3000,0]", "run.duration=0.02")), ("bearing_218_thrust", ("run.duration=0.02",))],
)
def test_forces_and_torques_that_add_up_to_nothing_are_nothing(scene, overrides):
    """No 1e-16 N m in a channel, and so in no table, log or page of what is made of it."""
    report, values = run_all(scene, *overrides)
    assert report.stepper == "quasi_static"
    load, pitch = values["normal_load"].sum(axis=(1, 2)).max(), 0.1
    sums = {"inner_ring_force": 1.0, "inner_ring_torque": pitch, "outer_ring_force": 1.0, "outer_ring_torque": pitch}
    for name, arm in {**sums, "raceway_force": 1.0, "raceway_torque": pitch}.items():
        sizes = np.abs(values[name])
        assert sizes[sizes > 0.0].min(initial=np.inf) > 1e-11 * arm * load, name
    assert np.abs(values["outer_ring_force"]).max() > 2000.0


def test_figures_of_the_ring_are_those_of_its_channels():
    """Tilted by a moment, so that each kind of number is there; means and ranges over the second half."""
    load = ("rings.inner.load=[50,-300,100]", "rings.inner.moment=[0.4,-0.2]")
    report, values = run_all("bearing_6203", *load, "run.duration=0.4")
    assert report.stepper == "quasi_static"
    second_half = slice(200, None)  # blocks of 100 outputs
    for key, name, width in (
        ("ring_displacement_m", "inner_ring_offset", 3),
        ("misalignment_rad", "inner_ring_tilt", 2),
        ("ring_force_n", "inner_ring_force", 3),
        ("ring_moment_nm", "inner_ring_torque", 2),
    ):
        assert report.figures[key] == pytest.approx(values[name][second_half, :width].mean(axis=0), rel=1e-9), key
    spread = np.ptp(values["inner_ring_force"][second_half], axis=0)
    assert report.figures["ring_force_range_n"] == pytest.approx(spread, rel=1e-9)
    assert report.figures["ring_moment_nm"] == pytest.approx([-0.4, 0.2], rel=1e-6)
    assert np.abs(values["inner_ring_tilt"]).min() > 1e-6


def test_a_held_ring_of_the_rig_feels_balls_pass():
    """Held at -21.853 micrometres, no gravity: 975.5 to 1000.1 N, 988.2 N on average, 12.7 N at the ball pass."""
    held = ("rings.inner.load=[0,0,0]", "rings.inner.free=none", QUASI_STATIC, NO_GRAVITY,
            "drive.offset=[0,-21.853e-6,0]", "run.duration=0.4", "run.output_rate=4000")  # fmt: skip
    _, values = run_all("bearing_6203_rig_1000N", *held)
    force = values["inner_ring_force"][:, 1]
    assert force.mean() == pytest.approx(988.2, rel=1e-3)
    assert force.min() == pytest.approx(975.5, rel=1e-3)
    assert force.max() == pytest.approx(1000.1, rel=1.2e-3)  # 1 N of it goes back where the circle is moved sideways
    azimuth = values["orbit_angle"][:, 0]
    passes = azimuth < 2.0 * np.pi / 8.0 * 30.0
    swing = force - force[passes].mean()
    amplitude = 2.0 * abs(np.mean((swing * np.exp(8j * azimuth))[passes]))
    assert amplitude == pytest.approx(12.7, rel=0.03)


def test_a_run_does_not_depend_on_how_it_is_cut():
    first, second = equilibrium_motion(scene="bearing_6203_rig_400N"), equilibrium_motion(scene="bearing_6203_rig_400N")
    for moving in (first, second):
        moving.goal_speed = 300.0
    times = 1e-3 * np.arange(1, 21)
    at_once = first.advance(times, times[-1])
    parts = [second.advance(1e-3 * np.arange(1, 6), 5e-3) for _ in range(4)]
    for name, values in at_once.items():
        cut = np.concatenate([part[name] for part in parts])
        assert cut == pytest.approx(values, rel=1e-6, abs=1e-9), name


def test_the_drive_is_followed():
    change = "drive.change={time: 0.01, speed: 100.0, offset: [0, 0, 2e-6]}"
    _, values = run_all("bearing_6203", change, QUASI_STATIC, OUTSIDE, "run.duration=0.1")
    speed, offset = values["inner_ring_speed"], values["inner_ring_offset"][:, 2]
    assert speed[:11] == pytest.approx(183.26)
    assert speed[15] == pytest.approx(183.26 + 2000.0 * 0.005)
    assert speed[-1] == 283.26
    assert offset[9] == 1e-5
    assert offset[12] == pytest.approx(1.2e-5)
    angle = np.concatenate([[0.0], np.cumsum(0.5e-3 * (speed[1:] + speed[:-1]))])
    assert values["inner_ring_angle"] == pytest.approx(angle, abs=1e-9)
    # how a ball lies follows from how it turns
    assert np.linalg.norm(values["orientation"], axis=-1) == pytest.approx(1.0, abs=1e-12)


def test_equilibria_say_what_they_do_not_give():
    resting = choose(load_scene("bearing_6203", [QUASI_STATIC, "solver.stepper=rk4"]))
    assert "solver.stepper does nothing in a run from equilibria, which has no steps" in resting.warnings
    assert not choose(load_scene("bearing_6203_rig_400N", [QUASI_STATIC])).warnings
    report, _ = run_all("bearing_6203_rig_400N", QUASI_STATIC, "run.duration=0.02")
    assert "friction" in report.errors["errors_unknown"]["left_out"]
    assert not {"friction_torque_nm", "drive_torque_nm", "dissipated_j", "cage_slip"} & set(report.figures)
    quantity = KINDS["bearing"].quantities_of()["drive_torque"]
    assert math.isnan(quantity.figure(report.figures))


def test_balls_that_leave_a_raceway_are_said_to_need_a_cage():
    bare = "cage.kind=none"
    for scene, overrides, needed in (
        ("bearing_6203_loose", (), True),
        ("bearing_6203", (), False),
        ("bearing_6203_loose", ("drive.offset=[0,0,2e-4]",), False),  # pushed along the axis, all balls carry
        ("bearing_6203_loose", ("geometry.balls=1",), False),
        ("bearing_6203_loose", ("drive.change={time: 0.1, offset: [0, 9e-6, 0]}",), True),
        ("bearing_6203", ("drive.change={time: 0.1, offset: [0, 5e-6, 0]}", "drive.offset=[0,0,0]"), True),
        ("bearing_6203_rig_1000N", (), True),
        ("bearing_6203_rig_1000N", ("geometry.radial_clearance=-1e-5", "rings.inner.load=[0,-10,0]"), False),
    ):
        warnings = choose(load_scene(scene, (bare, *overrides))).warnings
        assert any("cage.kind: even" in warning for warning in warnings) is needed, (scene, overrides)


def test_a_ring_that_is_held_where_it_touches_no_ball_is_named():
    """A 6001 has 10.5 micrometres of clearance: 5.25 to each side."""
    for overrides, is_named in (
        ((), True),
        (("cage.kind=even",), True),
        (("drive.offset=[0,-5.2e-6,0]",), True),
        (("drive.offset=[0,-5.3e-6,0]",), False),
        (("drive.change={time: 0.1, offset: [0, 9e-6, 0]}",), False),
        (("drive.tilt=[2e-3,0]",), False),
    ):
        warnings = choose(load_scene("6001", overrides)).warnings
        assert any("it touches no ball" in warning for warning in warnings) is is_named, overrides


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["rings.inner.load=[0,-10,0]", "model.dimension=prescribed"], "use model.dimension: free"),
        (
            ["rings.inner.load=[0,-10,5]", "rings.inner.free=radial"],
            r"rings.inner.load\[2\] = 5 N acts on a coordinate",
        ),
        (["model.dimension=free"], "has no free coordinate"),
        (["model.dimension=free", "rings.inner.load=[0,-10,0]"], "wants rings.inner.mass above 0 kg"),
        (["model.dimension=free", "rings.inner.free=all", "rings.inner.mass=1"], "wants rings.inner.inertia"),
        (["rings.inner.unbalance=1e-5"], "act on a ring with mass"),
        (["cage.kind=even", "solver.stepper=imex"], "solver.stepper = imex does not move a cage; use rodas4"),
        (["cage.kind=pockets", "cage.mass=0"], "pockets wants cage.mass or cage.inertia"),
        (["cage.kind=pockets", "cage.pocket_clearance=6e-3"], "reaches into the next pocket; at most 0.005596 m"),
    ],
)
def test_contradictions_are_refused(overrides, message):
    with pytest.raises(SceneError, match=message):
        load_scene("bearing_6203", overrides)


def test_a_change_that_cannot_be_borne_ends_a_run_at_its_time():
    change = ("drive.change.time=5e-3", "drive.change.offset=[0,0,1e-4]", "drive.offset=[0,0,0]")
    scene = load_scene("bearing_6203", [*change, "drive.tilt=[0.015,0]", "run.duration=0.02"])
    with pytest.raises(IntegrationError, match="squeezed too hard, or leaves the grooves") as caught:
        list(simulate(scene))
    assert caught.value.seconds == pytest.approx(5e-3, abs=1.1e-3)


def test_a_commanded_speed_is_followed():
    simulation = Simulation(load_scene("bearing_6203_rig_400N", [QUASI_STATIC]))
    first = simulation.advance(11)
    simulation.set_speed(250.0)
    block = simulation.advance(100)
    assert block.values["inner_ring_speed"][0] > 158.0  # from the next output on
    assert block.values["inner_ring_speed"][-1] == 250.0
    orbited, turned = np.diff(block.values["orbit_angle"][:, 0]), np.diff(block.values["inner_ring_angle"])
    assert orbited == pytest.approx(0.5 * (1.0 - 6.75 / 28.55) * turned, rel=1e-6)
    assert block.values["inner_ring_force"][:, 1] == pytest.approx(400.0 + 0.5 * 9.80665, rel=1e-9)
    simulation.reset()
    assert np.array_equal(simulation.advance(11).matrix(), first.matrix())


def test_a_change_that_comes_while_the_ring_brakes_is_added_to_its_goal():
    change = "drive.change={time: 2.0e-3, speed: 10.0}"
    simulation = Simulation(load_scene("bearing_6203", [QUASI_STATIC, OUTSIDE, "drive.acceleration=1e4", change]))
    begin = simulation.advance(1).values["inner_ring_speed"][0]
    simulation.set_speed(begin - 50.0)
    block = simulation.advance(20)
    falls = np.maximum(begin - 1e4 * 1e-9 * block.time_ns, begin - 40.0)
    assert block.values["inner_ring_speed"] == pytest.approx(falls, rel=1e-12)


def test_balls_turn_as_fast_as_they_say():
    moving = equilibrium_motion("drive.offset=[0,0,3e-5]")
    moving.first_outputs()
    out = moving.advance(1e-6 * np.arange(1, 3), 2e-6)
    before, after = out.orientation[:, 3] * [[-1.0, -1.0, -1.0, 1.0], [1.0] * 4]  # the first one's conjugate
    turn = quaternion_product(after, before)  # whose vector is half the rotation between both
    assert 2.0 * turn[:3] / 1e-6 == pytest.approx(out.angular_velocity[0, 3], rel=1e-3, abs=1e-2)
    heights = -(out.position @ np.array(moving.parameters.gravity)).sum(axis=1)
    assert out.potential_energy == pytest.approx(moving.setting.ball_mass * heights, rel=1e-9, abs=1e-15)


def test_each_raceway_is_as_stiff_as_its_own_ring_makes_it():
    """By Hertz load goes as E* approach^1.5 and pressure as E*^(2/3) load^(1/3), at angles that hardly differ."""

    def stiffness(*overrides):
        thrust = "contact.normal=hertz_exact", QUASI_STATIC, "rings.inner.load=[0,0,100]"
        scene = load_scene("bearing_6203", [*thrust, *overrides])
        sample = Simulation(scene).advance(1)
        load, pressure = sample["normal_load"][0, 0], contact_details(scene.parameters, sample)["peak_pressure"][0, 0]
        return np.array([load / sample["approach"][0, 0] ** 1.5, (pressure / np.cbrt(load)) ** 1.5])

    steel, ceramic = (MATERIALS[name] for name in ("steel", "silicon_nitride"))
    factor = effective_modulus(steel, ceramic) / effective_modulus(steel, steel)
    for ring, expected in (("inner_ring", [factor, 1.0]), ("outer_ring", [1.0, factor])):
        ratio = stiffness(f"materials.{ring}=silicon_nitride") / stiffness()
        assert ratio == pytest.approx(np.array([expected] * 2), rel=3e-4)


def test_the_greatest_contact_angle_is_the_same_for_a_thrust_the_other_way():
    """At speed the inner raceway's is the greater one, whatever its sign."""
    angles = []
    for thrust in (17800.0, -17800.0):
        load = f"rings.inner.load=[0,0,{thrust}]"
        report, _ = run_all("bearing_218_thrust", load, "run.duration=0.002", NO_GRAVITY)
        inner, outer = (abs(report.figures[f"contact_angle_{ring}_rad"][0]) for ring in ("inner", "outer"))
        angles.append(KINDS["bearing"].quantities_of()["greatest_contact_angle"].figure(report.figures))
        assert angles[-1] == pytest.approx(inner, rel=1e-9)
        assert inner > 1.1 * outer
    assert angles[0] == pytest.approx(angles[1], rel=1e-6)


def test_equilibria_that_a_command_takes_back_are_not_counted():
    simulation = Simulation(load_scene("bearing_6203", [QUASI_STATIC]))
    simulation.advance(5)
    simulation.set_speed(200.0)
    simulation.advance(95)
    assert simulation.report().costs["equilibria"] <= 100


def test_spin_and_slip_of_equilibria_are_those_of_balls_against_their_raceways():
    _, values = run_all("bearing_218_thrust", "run.duration=0.002")
    along_z = values["inner_ring_speed"][:, None, None] * np.array([0.0, 0.0, 1.0])
    for side, turning in ((0, along_z), (1, 0.0 * along_z)):
        normal, point = values["normal"][:, :, side], values["point"][:, :, side]
        centre = values["inner_ring_offset"][:, None] if side == 0 else 0.0
        spin = -np.einsum("nbi,nbi->nb", values["angular_velocity"] - turning, normal)
        assert values["spin_rate"][:, :, side] == pytest.approx(spin, rel=1e-9)
        arm = point - values["position"]
        across = values["velocity"] + np.cross(values["angular_velocity"], arm) - np.cross(turning, point - centre)
        slip = across - np.einsum("nbi,nbi->nb", across, normal)[..., None] * normal
        assert values["slip"][:, :, side] == pytest.approx(slip, rel=1e-6, abs=1e-9)
    assert np.abs(values["spin_rate"]).max() > 100.0
