"""An ellipsoid on a plane, and two bodies: closed forms, balances, published numbers."""

import math

import numpy as np
import pytest
from reference.ellipsoid import contact_delay, rocking_rate
from runs import a_choice, reported

from bearing_twin.base.errors import SceneError
from bearing_twin.base.sample import join_blocks
from bearing_twin.charts import reference
from bearing_twin.contact import hertz_impact as impact
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.laws import damping_number, law_names, restitution_of, steady_ratio
from bearing_twin.contact.materials import MATERIALS, effective_modulus
from bearing_twin.kinds.bodies.derived import inertia_of, mass_of
from bearing_twin.kinds.bodies.motion import EllipsoidMotion
from bearing_twin.kinds.bodies.parameters import GIVES, Shaped
from bearing_twin.run.scene import load_scene, parse_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.shapes import quaternion_from_vector, quaternion_product

pytestmark = pytest.mark.usefixtures("pictures_once")


GRAVITY = 9.80665
STORED = ("kinetic_energy", "potential_energy", "elastic_energy")
LOST = ("dissipated_viscous", "dissipated_friction")
STEEL = effective_modulus(MATERIALS["steel"], MATERIALS["steel"])
BALL = 4.0 / 3.0 * STEEL * math.sqrt(0.1)
MASS = 7850.0 * 4.0 / 3.0 * math.pi * 1e-3


def ran(name, *overrides):
    """The report and all channels, with the time [s], of a run; no test here asks for the errors of a companion."""
    run = simulate(load_scene(name, ["solver.companion=off", *overrides]))
    blocks = list(run.blocks())
    values = {channel.name: np.concatenate([b.values[channel.name] for b in blocks]) for channel in run.channels}
    return run.report, {"time": 1e-9 * np.concatenate([b.time_ns for b in blocks]), **values}


def energy(values, names=(*STORED, *LOST)):
    return sum(values[name] for name in names)


def law_keys(law):
    """Overrides that ask for a law; a linear spring with about the stiffness of the others."""
    return [f"contact.normal={law}", *(["contact.stiffness=3e8"] if law == "linear" else [])]


def contact(number, report):
    return report.figures["contacts"][number]


def test_a_ball_strikes_like_two_bodies_in_the_closed_form():
    """Landau and Lifchitz, section 9, the plane as a body without end; no gravity."""
    start = "start.velocity=[0,0,-2]", "start.height=0.02", "contact.restitution=1.0", "contact.normal=hertz_exact"
    report, values = ran("ellipsoid_on_plane", "gravity=[0,0,0]", *start, "run.duration=0.011", "run.output_rate=1e6")
    result = contact(0, report)
    exact = impact.force_history(values["time"] - result["start_s"], BALL, MASS, 2.0)
    assert values["normal_load"] == pytest.approx(exact, abs=1e-8 * exact.max())
    assert report.figures["contact_count"] == 1
    assert result["start_s"] == pytest.approx(0.01, rel=1e-13)
    assert result["duration_s"] == pytest.approx(impact.contact_time(BALL, MASS, 2.0), rel=1e-9)
    assert result["peak_force_n"] == pytest.approx(impact.peak_force(BALL, MASS, 2.0), rel=1e-7)
    assert report.figures["greatest_approach_m"] == pytest.approx(impact.greatest_approach(BALL, MASS, 2.0), rel=1e-7)
    assert result["impulse_ns"] == pytest.approx(2.0 * MASS * 2.0, rel=1e-9)
    assert result["restitution"] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("speed", [0.5, 5.0])
def test_restitution_is_what_was_asked_for(speed):
    common = ("gravity=[0,0,0]", f"start.velocity=[0,0,{-speed}]", "start.height=0.01", "run.duration=0.1")
    steady, _ = ran("ellipsoid_on_plane", "contact.restitution=0.6", *common)
    assert contact(0, steady)["restitution"] == pytest.approx(0.6, rel=1e-7)
    duration, restitution = reference.steady_contact(BALL, MASS, speed, steady_ratio(0.6))
    assert contact(0, steady)["duration_s"] == pytest.approx(duration, rel=1e-7)
    assert restitution == pytest.approx(0.6, rel=1e-12)
    hunt, _ = ran(
        "ellipsoid_on_plane",
        "contact.restitution=0.6",
        "contact.damping_law=hunt_crossley",
        "contact.restitution_speed=0.5",
        *common,
    )
    number = 0.6 if speed == 0.5 else restitution_of(10.0 * damping_number(0.6))
    assert contact(0, hunt)["restitution"] == pytest.approx(number, rel=1e-6)


def test_bounce_heights_fall_as_the_square_of_the_restitution():
    report, values = ran("ellipsoid_on_plane")
    assert contact(0, report)["start_s"] == pytest.approx(math.sqrt(2.0 / GRAVITY), rel=1e-15)  # known to rounding
    tops = []
    for bounce, after in zip(report.figures["contacts"][:6], report.figures["contacts"][1:7], strict=True):
        inside = (values["time"] > bounce["start_s"]) & (values["time"] < after["start_s"])
        tops.append(values["position"][inside, 2].max() - 0.1)
    assert tops == pytest.approx([0.8 ** (2 * n) for n in range(1, 7)], rel=5e-3)
    assert report.figures["resting_since_s"] == pytest.approx(9.0 * math.sqrt(2.0 / GRAVITY), abs=0.01)
    static = (MASS * GRAVITY / BALL) ** (2.0 / 3.0)
    assert values["approach"][-1] == pytest.approx(static, rel=1e-4)
    assert abs(report.figures["energy_closure"]) < 1e-7  # what is lost where bodies part without load is in the books


def test_a_tumbling_body_keeps_its_energy_through_hundreds_of_bounces():
    """Curvatures change while it turns: only with the moment of the elastic energy do the books close."""
    overrides = "run.duration=20", "run.output_rate=20", "wanted.tolerance=1e-10"
    report, values = ran("ellipsoid_tumbling", *overrides)
    assert report.figures["contact_count"] > 100
    assert abs(energy(values) / energy(values)[0] - 1.0).max() < 1e-5
    assert np.ptp(values["velocity"][:, :2], axis=0).max() == 0.0
    assert np.ptp(values["angular_momentum"][:, 2]) == 0.0


@pytest.mark.parametrize("law", law_names("point", GIVES))
def test_forces_are_the_slope_of_the_elastic_energy(law):
    """Virtual work: -dU by height is the load, -dU by a small turn the moment of the load at its point."""
    scene = load_scene("ellipsoid_tumbling", ["start.height=-2e-5", *law_keys(law)])
    motion = EllipsoidMotion(scene.parameters, a_choice(law, "dop853"))

    def energy_of(state):
        return float(motion.outputs(state[None])["elastic_energy"][0])

    values_now = {name: array[0] for name, array in motion.first_outputs().items()}
    moment = np.cross(values_now["contact_point"] - values_now["position"], [0.0, 0.0, values_now["normal_load"]])
    state = motion.state.copy()
    state[2] -= 1e-10
    slope = (energy_of(state) - energy_of(motion.state)) / 1e-10
    assert slope == pytest.approx(values_now["normal_load"], rel=1e-4)
    for axis in range(3):
        energies = []
        for angle in (1e-6, -1e-6):
            small = quaternion_from_vector(tuple(angle * np.eye(3)[axis]))
            orientation = quaternion_product(small, tuple(motion.state[3:7]))
            turned = motion.state.copy()
            turned[3:7] = orientation
            energies.append(energy_of(turned))
        result = (energies[1] - energies[0]) / 2e-6
        assert result == pytest.approx(moment[axis], abs=1e-6 * values_now["normal_load"] * 0.03)


def test_impulse_and_momentum_agree_with_the_recorded_forces():
    """Integrals of the recorded contact forces and moments against the change of momentum, all six components."""
    _, values = ran("ellipsoid_rocking", "run.duration=0.04", "run.output_rate=2e6", "contact.friction=spot",
                    "contact.damping_law=hunt_crossley", "contact.restitution_speed=0.5")  # fmt: skip
    force = values["friction_force"].copy()
    force[:, 2] += values["normal_load"]
    arm = values["contact_point"] - values["position"]
    moment = np.cross(arm, force)
    moment[:, 2] += values["drilling_torque"]
    scene = load_scene("ellipsoid_rocking").parameters
    mass = scene.body.material.density * 4.0 / 3.0 * math.pi * math.prod(scene.body.semi_axes)
    gained = mass * (values["velocity"][-1] - values["velocity"][0] + [0.0, 0.0, GRAVITY * values["time"][-1]])
    step = values["time"][1]

    def integral(array):
        return step * (array.sum(axis=0) - 0.5 * (array[0] + array[-1]))

    assert integral(force) == pytest.approx(gained, abs=1e-6 * np.linalg.norm(gained))
    turned = values["angular_momentum"][-1] - values["angular_momentum"][0]
    assert integral(moment) == pytest.approx(turned, abs=1e-6 * np.linalg.norm(turned))
    power = np.einsum("ij,ij->i", values["friction_force"], values["slip"])
    power += values["drilling_torque"] * values["angular_velocity"][:, 2]
    assert power.max() <= 0.0
    assert -integral(power) == pytest.approx(values["dissipated_friction"][-1], rel=1e-6)


@pytest.mark.parametrize("rolling", [False, True])
def test_rocking_at_rest_has_the_frequency_of_the_closed_form(rolling):
    """Frictionless the centre stays where it is; a rough plane (high friction) makes it roll."""
    axes, mass = (0.03, 0.02, 0.012), 7850.0 * 4.0 / 3.0 * math.pi * 0.03 * 0.02 * 0.012
    gap = 0.5 * 0.012 / 0.03**2, 0.5 * 0.012 / 0.02**2
    pressed = (mass * GRAVITY / coefficient_of("hertz", *gap, STEEL)) ** (2.0 / 3.0)
    rough = (
        ("contact.friction_coefficient=1.0", "contact.friction_regularisation=1e-4")
        if rolling
        else ("contact.friction_coefficient=0",)
    )
    report, values = ran("ellipsoid_rocking", f"start.height={-pressed!r}", "start.turn=[0.01,0,0]", "run.duration=1.0",
                         "start.velocity=[0,0,0]", "start.angular_velocity=[0,0,0]", "run.output_rate=2000",
                         *rough)  # fmt: skip
    tilt = values["angular_velocity"][:, 0]
    crossings = np.flatnonzero((tilt[:-1] > 0.0) & (tilt[1:] <= 0.0))
    instants = values["time"][crossings] + 5e-4 * tilt[crossings] / (tilt[crossings] - tilt[crossings + 1])
    rate = 2.0 * math.pi * (len(instants) - 1) / (instants[-1] - instants[0])
    assert len(instants) >= 3
    assert rate == pytest.approx(rocking_rate(axes, GRAVITY, rolling), rel=2e-3 if rolling else 2e-4)
    assert report.figures["contact_count"] == 1


@pytest.mark.parametrize(
    ("height", "velocity", "spin"),
    [(1.0, "[0,0,-20]", "[0,0,0]"), (1.0, "[3,0,-20]", "[200,-300,50]"), (0.04, "[0,0,0]", "[0,900,0]")],
)
def test_no_touch_is_stepped_over(height, velocity, spin):
    """A metre of gap at 20 m/s, and bodies that turn many times on the way."""
    overrides = (f"start.height={height}", f"start.velocity={velocity}", f"start.angular_velocity={spin}",
                 "run.duration=0.2", "run.output_rate=1e5", "body.material.young_modulus=2e11")  # fmt: skip
    report, values = ran("ellipsoid_tumbling", *overrides)
    assert report.figures["contact_count"] >= 1
    first = contact(0, report)["start_s"]
    clear = values["time"] < first
    assert values["approach"][clear].max() <= 0.0
    smallest = 0.012
    assert (values["position"][:, 2] > 0.5 * smallest).all()


def test_a_ball_laid_on_the_plane_closes_its_books():
    """All that is stored is below the energy of the start, which is none but for rounding."""
    report, values = ran("ellipsoid_on_plane", "start.height=0", "run.duration=0.02")
    assert report.figures["dissipated_viscous_j"] > 1e-6
    assert report.status == "done"
    assert np.abs(energy(values) - energy(values)[0]).max() < 1e-6 * report.figures["dissipated_viscous_j"]


def test_a_contact_ends_once():
    """A touch of 4 ns followed the first impact at 1e-3, where the approach at its end was positive by rounding."""
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-6):
        report = reported("ellipsoid_tumbling", "run.duration=0.4", f"wanted.tolerance={tolerance}")
        assert [contact["duration_s"] > 5e-5 for contact in report.figures["contacts"]] == [True] * 4, tolerance


def test_fixed_steps_converge():
    """The classical method, limited to order 2.5 by the load that begins as t^1.5."""
    errors = []
    exact = impact.contact_time(BALL, MASS, 2.0)
    for count in (16, 256):
        report, _ = ran("ellipsoid_on_plane", "gravity=[0,0,0]", "start.velocity=[0,0,-2]", "contact.restitution=1.0",
                        "start.height=0.2", "run.duration=0.11", "solver.stepper=rk4",
                        f"solver.step={exact / count!r}")  # fmt: skip
        errors.append(abs(contact(0, report)["restitution"] - 1.0))
    assert math.log(errors[0] / errors[1]) / math.log(16.0) > 2.3


def instants(law, *overrides):
    """Touches of the ball of paper 1 over 3.2 s."""
    report, _ = ran("ellipsoid_on_plane", "run.duration=3.2", f"contact.normal={law}", "wanted.tolerance=1e-11",
                    *overrides)  # fmt: skip
    return np.array([contact["start_s"] for contact in report.figures["contacts"]])


def test_the_volumetric_law_delays_every_lossless_bounce_by_its_stiffness():
    """Paper 1, figure 4: c^(-2/5) of each contact time; gravity within a contact adds g tau/v."""
    hertz, volumetric = (instants(law, "contact.restitution=1.0") for law in ("hertz", "volumetric"))
    ratio = coefficient_of("volumetric", 5.0, 5.0, STEEL) / BALL
    assert ratio == pytest.approx(0.99525, abs=2e-5)
    tau = impact.contact_time(BALL, MASS, math.sqrt(2.0 * GRAVITY))
    delay = contact_delay(ratio, tau)
    assert delay == pytest.approx(0.00190585 * tau, rel=1e-3)
    assert volumetric - hertz == pytest.approx(delay * np.arange(len(hertz)), rel=2e-3, abs=1e-11)


STEEL_BALL = MATERIALS["steel"]
DROP = {
    "kind": "two_bodies",
    "first": {"radius": 0.01, "position": [0.0, 0.0, 0.0101]},
    "contact": {"normal": "hertz"},
    "gravity": [0.0, 0.0, 0.0],
    "run": {"duration": 4e-4, "output_rate": 1e6},
    "solver": {"companion": "off"},  # of whose errors no test here asks
}


def scene(**sections):
    """A drop with other sections; keys of a section that stay are kept."""
    mapping = {key: dict(value) if isinstance(value, dict) else value for key, value in DROP.items()}
    for key, value in sections.items():
        mapping[key] = {**mapping.get(key, {}), **value} if isinstance(value, dict) else value
    return parse_scene(mapping, "scene made up")


def run(**sections):
    """Figures and all outputs of a run."""
    result = simulate(scene(**sections))
    outputs = join_blocks(list(result.blocks()))
    return result.report.figures, outputs.values


@pytest.mark.parametrize("tracking", ["closed", "algebraic", "differential"])
def test_a_ball_on_a_plate_is_hertz_impact(tracking):
    figures, values = run(first={"velocity": [0.0, 0.0, -1.0]}, contact={"tracking": tracking})
    mass = STEEL_BALL.density * 4.0 / 3.0 * math.pi * 1e-6
    coefficient = 4.0 / 3.0 * effective_modulus(STEEL_BALL, STEEL_BALL) * 0.1
    assert figures["contact_duration_s"] == pytest.approx(impact.contact_time(coefficient, mass, 1.0), rel=1e-6)
    assert figures["peak_force_n"] == pytest.approx(impact.peak_force(coefficient, mass, 1.0), rel=3e-3)
    assert figures["contacts"][0]["start_s"] == pytest.approx(1e-4, rel=1e-9)
    assert figures["contacts"][0]["impulse_ns"] == pytest.approx(2.0 * mass, rel=1e-6)
    assert figures["restitution"] == pytest.approx(1.0, abs=1e-6)
    assert abs(figures["energy_closure"]) < 1e-6
    assert figures["tracking_error_m"] < 1e-9
    assert values["normal"] == pytest.approx(np.tile([0.0, 0.0, -1.0], (len(values["normal"]), 1)), abs=1e-12)


def test_two_free_balls_keep_their_momenta_whichever_is_first():
    """An oblique blow with friction and spin: linear and angular momentum to rounding, energy by its books."""
    first = {
        "shape": "sphere",
        "motion": "free",
        "radius": 0.01,
        "velocity": [0.5, 0.1, 0.0],
        "angular_velocity": [20.0, 80.0, -30.0],
    }
    second = {"shape": "sphere", "motion": "free", "radius": 0.02, "position": [0.03005, 0.0012, 0.0]}
    first["position"] = [0.0, 0.0, 0.0]
    contact = {"friction_coefficient": 0.3, "friction": "spot", "restitution": 0.7}
    straight = run(first=first, second=second, contact=contact, run={"duration": 1.2e-3, "output_rate": 1e5})
    swapped = run(first=second, second=first, contact=contact, run={"duration": 1.2e-3, "output_rate": 1e5})
    for (figures, values), names in ((straight, ("", "second_")), (swapped, ("second_", ""))):
        assert figures["contact_count"] == 1
        assert figures["restitution"] == pytest.approx(0.7, abs=2e-3)
        assert figures["dissipated_friction_j"] > 0.0
        assert abs(figures["energy_closure"]) < 1e-5
        masses = [STEEL_BALL.density * 4.0 / 3.0 * math.pi * radius**3 for radius in (0.01, 0.02)]
        linear = sum(mass * values[f"{name}velocity"] for mass, name in zip(masses, names, strict=True))
        about = sum(
            mass * np.cross(values[f"{name}position"], values[f"{name}velocity"]) + values[f"{name}angular_momentum"]
            for mass, name in zip(masses, names, strict=True)
        )
        assert np.abs(linear - linear[0]).max() < 1e-12 * np.abs(linear).max()
        assert np.abs(about - about[0]).max() < 1e-9 * np.abs(about).max()
    assert straight[1]["velocity"][-1] == pytest.approx(swapped[1]["second_velocity"][-1], rel=1e-6, abs=1e-9)


def test_opposing_points_of_an_ellipsoid_and_a_plane_in_closed_form_and_followed():
    """Two formulations agree to the moment of the load by turning curvatures, which points that are followed lack."""
    overrides = "run.duration=0.025", "contact.restitution=1"
    (exact, truth), (report, values) = (
        ran("two_bodies_ellipsoid", *overrides, f"contact.tracking={way}") for way in ("closed", "differential")
    )
    assert report.figures["contact_count"] == exact.figures["contact_count"] >= 1
    for key, close in (("contact_duration_s", 1e-3), ("peak_force_n", 5e-3)):
        assert report.figures[key] == pytest.approx(exact.figures[key], rel=close)
    for name in ("position", "velocity", "angular_velocity"):
        assert values[name][-1] == pytest.approx(truth[name][-1], rel=2e-3, abs=2e-3 * np.abs(truth[name]).max()), name
    assert abs(exact.figures["energy_closure"]) < 1e-7  # to which only the moment closes it
    assert 1e-6 < abs(report.figures["energy_closure"]) < 1e-3


def test_a_ball_that_rolls_in_a_groove_swings_as_a_rolling_pendulum():
    """Path radius rho, no slip: T = 2 pi sqrt(7 rho/(5 g)), for 0.1 rad longer by a**2/16; a quarter of it here."""
    rho, ball, amplitude, g = 0.02, 0.005, 0.1, 9.80665
    period = 2.0 * math.pi * math.sqrt(1.4 * rho / g) * (1.0 + amplitude**2 / 16.0)
    soft = {"young_modulus": 2e8, "poisson_ratio": 0.3, "density": 7850.0, "yield_strength": 0.0}
    _, values = run(
        first={
            "radius": ball, "material": soft,
            "position": [rho * math.sin(amplitude), 0.0, -rho * math.cos(amplitude)],
        },
        second={
            "shape": "groove", "ring_radius": rho + ball - 0.006, "radius": 0.006, "turn": [0.5 * math.pi, 0.0, 0.0],
            "motion": "held",
        },
        contact={"friction_coefficient": 0.8, "friction_regularisation": 3e-4, "restitution": 0.3},
        gravity=[0.0, 0.0, -g],
        run={"duration": 0.28 * period, "output_rate": 1000.0},
    )  # fmt: skip
    x, time = values["position"][:, 0], 1e-3 * np.arange(len(values["position"]))
    after = int(np.flatnonzero(x < 0.0)[0])
    crossing = np.interp(0.0, x[[after, after - 1]], time[[after, after - 1]])
    assert crossing == pytest.approx(0.25 * period, rel=2e-3)
    assert values["angular_velocity"][after, 1] * ball == pytest.approx(values["velocity"][after, 0], rel=5e-3)


def test_a_turning_plate_works_on_the_ball_that_lies_on_it():
    """The books close only with the work of the held body; without friction it does none."""
    common = {
        "first": {"position": [0.02, 0.0, 0.00999999]},
        "second": {"shape": "plane", "motion": "held", "angular_velocity": [0.0, 0.0, 30.0]},
        "gravity": [0.0, 0.0, -9.80665],
        "run": {"duration": 0.01, "output_rate": 1000.0},
    }
    figures, values = run(**common, contact={"friction_coefficient": 0.2, "restitution": 0.5})
    assert figures["held_work_j"] < -1e-7
    assert abs(figures["energy_closure"]) < 1e-5
    assert values["velocity"][-1, 1] > 1e-3
    idle, _ = run(**common, contact={"restitution": 0.5})
    assert idle["held_work_j"] == pytest.approx(0.0, abs=1e-15)


def test_a_rounded_box_lands_on_a_face_which_is_no_ellipse():
    """Flat on the plate: energy kept, no turning, the duration between those of a sphere and of a punch."""
    first = {
        "shape": "superellipsoid", "semi_axes": [0.01, 0.01, 0.01], "exponents": [4.0, 4.0],
        "position": [0.0, 0.0, 0.0101], "velocity": [0.0, 0.0, -1.0],
    }  # fmt: skip
    figures, values = run(first=first, contact={"normal": "overlap"}, run={"duration": 2.5e-4})
    assert figures["restitution"] == pytest.approx(1.0, abs=1e-5)
    assert abs(figures["energy_closure"]) < 2e-5
    assert np.abs(values["angular_velocity"]).max() < 1e-6
    assert values["curvature_small"].max() < 1e-6
    with pytest.raises(SceneError, match=r"overlap"):
        scene(first=first, contact={"normal": "hertz"})


def test_a_tumbling_rounded_box_keeps_its_energy():
    """The load acts where its moment is that of the elastic energy: at the volume's centre 1e-3 of it went astray."""
    report, _ = ran("two_bodies_superellipsoid", "run.duration=0.1")
    assert abs(report.figures["energy_closure"]) < 5e-5


def test_masses_and_moments_of_a_superellipsoid_by_counting():
    axes, (n, m), points = np.array([0.03, 0.02, 0.01]), (2.5, 6.0), 80
    box = Shaped(shape="superellipsoid", semi_axes=tuple(axes), exponents=(n, m))
    x, y = np.meshgrid(*((np.arange(points) + 0.5) / points,) * 2, indexing="ij")
    height = np.maximum(1.0 - (x**n + y**n) ** (m / n), 0.0) ** (1.0 / m)
    cell = 8.0 * axes.prod() / points**2 * STEEL_BALL.density
    squares = cell * axes**2 * [(x**2 * height).sum(), (y**2 * height).sum(), (height**3 / 3.0).sum()]
    assert mass_of(box) == pytest.approx(cell * height.sum(), rel=5e-3)
    assert inertia_of(box) == pytest.approx(squares.sum() - squares, rel=1e-2)


REFUSED = [
    ({"first": {"shape": "superellipsoid", "semi_axes": [1, 1, 1], "exponents": [1.5, 2]}}, "edges"),
    ({"first": {"shape": "ellipsoid"}}, "needs first.semi_axes above zero"),
    ({"first": {"semi_axes": [0.1, 0.1, 0.1]}}, "first.semi_axes is nothing a sphere has"),
    ({"second": {"shape": "plane", "motion": "free"}}, "no mass of its own; give second.motion: held"),
    ({"first": {"motion": "held"}}, "nothing moves"),
    ({"first": {"shape": "groove", "radius": 0.001, "ring_radius": 0.1, "motion": "held"},
      "second": {"shape": "plane", "motion": "held"}}, "nothing moves"),
    ({"first": {"shape": "groove", "radius": 0.2, "ring_radius": 0.1, "motion": "held"}}, "below first.ring_radius"),
    ({"first": {"shape": "ellipsoid", "semi_axes": [0.1, 0.1, 0.1]},
      "second": {"shape": "sphere", "motion": "free", "position": [0, 0, 1]},
      "contact": {"tracking": "closed"}}, "no closed form"),
    ({"first": {"position": [0.0, 0.0, 0.001]}}, "press 0.009 m into each other"),
    ({"first": {"shape": "ellipsoid", "semi_axes": [0.02, 0.001, 0.02], "position": [0.1, 0, 0]},
      "second": {"shape": "groove", "radius": 0.002, "ring_radius": 0.1, "motion": "held"}}, "start"),
    ({"first": {"radius": 0.01, "position": [0.09995, 0, 0]},
      "second": {"shape": "groove", "radius": 0.010001, "ring_radius": 0.1, "motion": "held"}}, "touch over more than"),
    ({"first": {"shape": "ellipsoid", "semi_axes": [0.0095, 0.002, 0.002], "position": [0.1, 0, 0],
                "turn": [0, 0.5 * math.pi, 0]},  # along the axis of a groove, it touches both flanks
      "second": {"shape": "groove", "radius": 0.01, "ring_radius": 0.1, "motion": "held"}},
     "several closest points|saddle|flat"),
    ({"contact": {"normal": "linear"}}, "needs contact.stiffness"),
    ({"contact": {"normal": "overlaps"}}, "did you mean overlap"),
]  # fmt: skip


@pytest.mark.parametrize(("sections", "sentence"), REFUSED)
def test_what_makes_no_pair_is_refused_with_a_sentence(sections, sentence):
    with pytest.raises(SceneError, match=sentence) as caught:
        scene(**sections)
    assert "\n" not in str(caught.value) or "problems" in str(caught.value)


def test_a_contact_whose_load_ends_while_bodies_touch_keeps_its_impulse():
    """Steady damping ends a contact with a corner, and answers at once where it begins: no step goes across either."""

    def contacts(tolerance):
        overrides = ("run.duration=0.03", "solver.companion=off", f"wanted.tolerance={tolerance}")
        report = reported("two_bodies_ellipsoid", *overrides)
        return np.array([(contact["peak_force_n"], contact["impulse_ns"]) for contact in report.figures["contacts"]])

    exact = contacts(1e-10)
    for tolerance in (1e-2, 1e-5):
        assert np.abs(contacts(tolerance) / exact - 1.0).max() < 1e-6


def test_a_contact_that_goes_on_at_the_end_has_no_duration_to_warn_of():
    """It has lasted a twentieth of its time, a part of a transit of waves."""
    overrides = "start.height=1.00165", "run.duration=0.452", "run.output_rate=1000", "solver.check=none"
    report = reported("ellipsoid_on_plane", *overrides)
    (contact,) = report.figures["contacts"]
    assert 0.0 < contact["duration_s"] < 4e-5
    assert contact["impulse_ns"] is None is contact["restitution"]
    assert not any("wave" in flag for flag in report.flags)


def test_the_moment_of_changing_curvatures_that_two_bodies_lack_is_a_model_error():
    """The same body on the same plane, with this moment and without: the first contact, of 134 us."""
    reports = []
    for tracking in ("closed", "algebraic"):
        report = reported("two_bodies_ellipsoid", "run.duration=0.024", f"contact.tracking={tracking}")
        reports.append(report.as_dict())
    with_moment, without = reports
    difference = abs(without["peak_force_n"] - with_moment["peak_force_n"])
    assert difference > 100.0 * without["peak_force_n_error"]  # which is the method's alone
    assert 0.1 * difference < without["model_errors"]["left_out"]["peak_force_n"] < 10.0 * difference
