"""Whole runs and studies against closed forms, and numbers of programs that share nothing with this package."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bearing_twin.kinds.bearing.equilibrium import Support, solver_of
from bearing_twin.kinds.bearing.ratings import lives_of, ratings_of
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import load_study

PRELOADED = ("gravity=[0,0,0]", "model.dimension=free", "rings.inner.free=all", "rings.inner.load=[0,0,14.223]")


def channel(samples, name):
    return np.array([sample[name] for sample in samples])


@pytest.mark.parametrize(
    ("load", "tilt", "speed", "displacement", "loads", "life"),
    [
        ((0, -1000, 0), (2e-3, 1e-3), 157.0796, (0.209320, -21.713802, 24.53101),
         (585.822, 293.283, 0, 0, 0, 0, 0.003, 293.603), 804.0042),
        ((0, -700, 300), (3e-3, -1e-3), 157.0796, (-3.746012, -17.173672, 74.64679),
         (443.900, 262.656, 126.360, 111.506, 79.737, 36.033, 107.740, 348.145), 1326.0411),
        ((200, -500, 150), (-2e-3, 2e-3), 1500.0, (9.861250, -5.485427, 44.06689),
         (273.092, 241.617, 100.931, 0, 0, 0, 1.449, 101.674), 5516.7278),
    ],
)  # fmt: skip
def test_loads_and_reference_life_of_a_tilted_bearing(load, tilt, speed, displacement, loads, life):
    """By another program: true circles, exact Hertz, two unknowns a ball, SciPy's root for both; µm, N, 10⁶ turns."""
    scene = load_scene("bearing_6203_rig_1000N", [f"drive.speed={speed}"])
    solver = solver_of(scene.parameters, "hertz", -0.5 * math.pi)
    free = (True, True, True, False, False)
    equilibrium = solver.solve(Support(free, (*map(float, load), 0.0, 0.0), (0.0, 0.0, 0.0, *tilt)))
    assert equilibrium.coordinates[:3] * 1e6 == pytest.approx(displacement, rel=1e-5)
    assert equilibrium.contacts.load[:, 0] == pytest.approx(loads, abs=1.5e-3)
    lives = lives_of(scene.parameters, ratings_of(scene.parameters), load, *equilibrium.contacts.load.T)
    assert lives.reference == pytest.approx(life, rel=2e-6)


@pytest.mark.parametrize(("smoothing", "torque"), [(1e-3, 2.5233272e-3), (1e-2, 1.0231115e-3)])
def test_the_torque_of_balls_that_drill_under_thrust(smoothing, torque):
    """By another program: orbit, spin and place of a ball by SciPy's root, friction over 240 x 60 points of a spot."""
    overrides = [
        "contact.friction=spot_fine", f"contact.friction_regularisation={smoothing}", "drive.offset=[0,0,4e-5]",
        "gravity=[0,0,0]", "run.duration=0.3", "run.output_rate=100", "run.publish_rate=100",
    ]  # fmt: skip
    *_, sample = simulate(load_scene("bearing_6203", overrides))
    assert sample["drive_torque"] == pytest.approx(torque, rel=1e-5)
    assert sample["drilling_torque"][:, 0] == pytest.approx(sample["drilling_torque"][:, 1], rel=1e-3)


@pytest.mark.parametrize("speed", [600.0, 1150.0])
def test_a_shaft_out_of_balance_whirls_as_its_receptance_says(speed):
    """Stiffness 5 x 5, masses, gyroscopic moment; contacts, which go round with the balls, damp what they see of it."""
    unbalance, relaxation, mass, inertia = 2e-6, 3e-5, 0.5, 1e-4
    scene = load_scene("bearing_6203", [
        *PRELOADED, f"rings.inner.mass={mass}", f"rings.inner.inertia=[{inertia},{inertia}]",
        f"rings.inner.unbalance={unbalance}", "contact.friction_coefficient=0", f"contact.relaxation_time={relaxation}",
        "cage.kind=even", f"drive.speed={speed}", "drive.offset=[0,0,0]", "run.duration=0.5", "run.output_rate=20000",
        "run.publish_rate=20",
    ])  # fmt: skip
    samples = list(simulate(scene))
    support = Support((True,) * 5, (0.0, 0.0, 14.223, 0.0, 0.0), (0.0,) * 5)
    solver = solver_of(scene.parameters, "hertz")
    solver.setting = solver.setting._replace(share_inner=0.0, share_outer=0.0)  # nothing rubs: no gyroscopic moment
    stiffness = solver.solve(support).stiffness
    gyroscopic = np.zeros((5, 5))
    gyroscopic[3, 4], gyroscopic[4, 3] = inertia * speed, -inertia * speed
    relative_speed = speed - float(samples[-1]["cage_speed"])  # of the whirl, in the frame of the balls
    dynamic = stiffness * (1.0 + 1j * relative_speed * relaxation) + 1j * speed * gyroscopic
    dynamic -= speed**2 * np.diag([mass, mass, mass, inertia, inertia])
    expected = np.linalg.solve(dynamic, unbalance * speed**2 * np.array([1.0, -1j, 0.0, 0.0, 0.0]))
    turns = int(0.2 * speed / (2.0 * math.pi))  # of the end, where what the start left has died down
    last_turns = slice(-round(turns * 2.0 * math.pi / speed * 20000), None)
    motion = np.hstack([channel(samples, "inner_ring_offset"), channel(samples, "inner_ring_tilt")])[last_turns]
    turned = np.exp(-1j * channel(samples, "inner_ring_angle")[last_turns])
    amplitudes = 2.0 * (motion * turned[:, None]).mean(axis=0)
    assert np.abs(amplitudes[:2]) == pytest.approx(np.abs(expected[:2]), rel=3e-3)
    assert np.abs(amplitudes[3:]) == pytest.approx(np.abs(expected[3:]), rel=3.5e-3)  # 0.0031 at 1e-4, 1e-5 and 1e-6
    assert np.angle(amplitudes[0] / expected[0]) == pytest.approx(0.0, abs=5e-3)  # 0.018 of it


@pytest.mark.parametrize(
    ("turn", "restitution"), [((0.3, 0.5, 0.2), 1.0), ((0.3, 0.5, 0.2), 0.7), ((0.1, 0.9, -0.4), 0.8)]
)
def test_an_ellipsoid_that_strikes_off_its_centre_leaves_as_a_rigid_body_does(turn, restitution):
    """The impulse along the normal that turns the speed of the point of contact round; without friction."""
    axes, density = np.array([0.03, 0.02, 0.015]), 7850.0
    scene = load_scene("ellipsoid_on_plane", [
        f"body.semi_axes={axes.tolist()}", "start.height=0.02", f"start.turn={list(turn)}",
        f"contact.restitution={restitution}", "contact.damping_law=steady", "contact.friction_coefficient=0",
        "run.duration=0.068", "run.output_rate=1e5", "run.publish_rate=1e3",
    ])  # fmt: skip
    samples = list(simulate(scene))
    touching = np.flatnonzero(channel(samples, "normal_load") > 0.0)
    before, after = samples[touching[0] - 1], samples[touching[-1] + 1]
    mass = density * 4.0 / 3.0 * math.pi * axes.prod()
    turned = Rotation.from_quat(before["orientation"]).as_matrix()
    inertia = turned @ np.diag(mass / 5.0 * (np.square(axes).sum() - axes**2)) @ turned.T
    normal = np.array([0.0, 0.0, 1.0])
    body_normal = turned.T @ normal
    arm = -turned @ (axes**2 * body_normal) / math.sqrt((axes**2 * body_normal**2).sum())
    spun = np.linalg.solve(inertia, np.cross(arm, normal))
    approach = before["velocity"][2] + np.cross(before["angular_velocity"], arm)[2]
    impulse = -(1.0 + restitution) * approach / (1.0 / mass + np.cross(spun, arm)[2])
    fall = 9.80665 * (after.time_ns - before.time_ns) * 1e-9
    assert after["velocity"][2] + fall == pytest.approx(before["velocity"][2] + impulse / mass, abs=2e-3)
    size = np.linalg.norm(impulse * spun)
    assert after["angular_velocity"] == pytest.approx(before["angular_velocity"] + impulse * spun, abs=3e-3 * size)


def test_shares_of_the_variance_of_a_product_of_lognormals(tmp_path):
    """tau ~ m^(2/5) R^(-1/5) v^(-1/5): first and total indices in closed form, each within its interval."""
    (tmp_path / "study.yaml").write_text(
        "scene: two_spheres\n"
        "inputs:\n"
        "  first.radius: {distribution: lognormal, mean_log: -3.96, std_log: 0.3, also: [second.radius]}\n"
        "  motion.first_velocity: {distribution: lognormal, mean_log: 2.3, std_log: 0.5}\n"
        "  first.mass: {distribution: lognormal, mean_log: -1.49, std_log: 0.3, also: [second.mass]}\n"
        "quantities: [contact_duration]\nsamples: 512\nsampler: sobol\nsensitivity: 4096\nchecks: 0\n"
    )
    indices = run_study(load_study(tmp_path / "study.yaml")).as_dict()["quantities"]["contact_duration"]["sobol"]
    spreads = {"first.radius": 0.2 * 0.3, "motion.first_velocity": 0.2 * 0.5, "first.mass": 0.4 * 0.3}
    variance = sum(deviation**2 for deviation in spreads.values())
    for name, spread in spreads.items():
        first = math.expm1(spread**2) / math.expm1(variance)
        total = 1.0 - math.expm1(variance - spread**2) / math.expm1(variance)
        for kind, exact in (("first", first), ("total", total)):
            reported = indices[name][kind]
            assert reported["low"] - 0.003 <= exact <= reported["high"] + 0.003
            assert reported["value"] == pytest.approx(exact, abs=0.01)
