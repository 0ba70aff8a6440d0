"""Two bodies of any shape: closed forms, the other kinds' programs, balances, and what is refused."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bearing_twin.contact import hertz_impact
from bearing_twin.contact.materials import MATERIALS, effective_modulus
from bearing_twin.errors import SceneError
from bearing_twin.kinds.two_bodies.derived import rigid_of
from bearing_twin.kinds.two_bodies.parameters import Shaped
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene, parse_scene
from bearing_twin.sample import joined

STEEL = MATERIALS["steel"]
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
    found = simulate(scene(**sections))
    whole = joined(list(found.blocks()))
    return found.report.figures, whole.values


@pytest.mark.parametrize("tracking", ["closed", "algebraic", "differential"])
def test_a_ball_on_a_plate_is_hertz_impact(tracking):
    figures, values = run(first={"velocity": [0.0, 0.0, -1.0]}, contact={"tracking": tracking})
    mass = STEEL.density * 4.0 / 3.0 * math.pi * 1e-6
    coefficient = 4.0 / 3.0 * effective_modulus(STEEL, STEEL) * 0.1
    assert figures["contact_duration_s"] == pytest.approx(hertz_impact.contact_time(coefficient, mass, 1.0), rel=1e-6)
    assert figures["peak_force_n"] == pytest.approx(hertz_impact.peak_force(coefficient, mass, 1.0), rel=3e-3)
    assert figures["contacts"][0]["start_s"] == pytest.approx(1e-4, rel=1e-9)
    assert figures["contacts"][0]["impulse_ns"] == pytest.approx(2.0 * mass, rel=1e-6)
    assert figures["restitution"] == pytest.approx(1.0, abs=1e-6)
    assert abs(figures["energy_closure"]) < 1e-6
    assert figures["tracking_error_m"] < 1e-9
    assert values["normal"] == pytest.approx(np.tile([0.0, 0.0, -1.0], (len(values["normal"]), 1)), abs=1e-12)


def test_two_free_balls_keep_their_momenta_whichever_is_first():
    """An oblique blow with friction and spin: linear and angular momentum to rounding, energy by its books."""
    one = {
        "shape": "sphere",
        "motion": "free",
        "radius": 0.01,
        "velocity": [0.5, 0.1, 0.0],
        "angular_velocity": [20.0, 80.0, -30.0],
    }
    other = {"shape": "sphere", "motion": "free", "radius": 0.02, "position": [0.03005, 0.0012, 0.0]}
    one["position"] = [0.0, 0.0, 0.0]
    contact = {"friction_coefficient": 0.3, "friction": "spot", "restitution": 0.7}
    straight = run(first=one, second=other, contact=contact, run={"duration": 1.2e-3, "output_rate": 1e5})
    swapped = run(first=other, second=one, contact=contact, run={"duration": 1.2e-3, "output_rate": 1e5})
    for (figures, values), names in ((straight, ("", "second_")), (swapped, ("second_", ""))):
        assert figures["contact_count"] == 1
        assert figures["restitution"] == pytest.approx(0.7, abs=2e-3)
        assert figures["dissipated_friction_j"] > 0.0
        assert abs(figures["energy_closure"]) < 1e-5
        masses = [STEEL.density * 4.0 / 3.0 * math.pi * radius**3 for radius in (0.01, 0.02)]
        linear = sum(mass * values[f"{name}velocity"] for mass, name in zip(masses, names, strict=True))
        about = sum(
            mass * np.cross(values[f"{name}position"], values[f"{name}velocity"]) + values[f"{name}angular_momentum"]
            for mass, name in zip(masses, names, strict=True)
        )
        assert np.abs(linear - linear[0]).max() < 1e-12 * np.abs(linear).max()
        assert np.abs(about - about[0]).max() < 1e-9 * np.abs(about).max()
    assert straight[1]["velocity"][-1] == pytest.approx(swapped[1]["second_velocity"][-1], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("tracking", ["closed", "differential"])
def test_an_ellipsoid_on_a_plane_is_as_the_kind_made_for_it(tracking):
    """Two programs: to the moment of the load by turning curvatures, which only the other kind has."""
    turn, spin = [0.3, 0.5, 0.2], [20.0, -35.0, 15.0]
    other = parse_scene(
        {
            "kind": "ellipsoid_on_plane",
            "body": {"semi_axes": [0.03, 0.02, 0.012]},
            "start": {"height": 1e-4, "turn": turn, "angular_velocity": spin, "velocity": [0.1, 0.0, -0.5]},
            "contact": {"friction_coefficient": 0.1},
            "run": {"duration": 0.02, "output_rate": 1000.0},
        },
        "scene",
    )
    found = simulate(other)
    truth = joined(list(found.blocks())).values
    expected = found.report.figures
    first = {
        "shape": "ellipsoid", "semi_axes": [0.03, 0.02, 0.012], "position": truth["position"][0].tolist(),
        "turn": turn, "velocity": [0.1, 0.0, -0.5], "angular_velocity": spin,
    }  # fmt: skip
    contact = {"friction_coefficient": 0.1, "tracking": tracking}
    mapping = {
        **DROP, "first": first, "contact": contact, "gravity": [0.0, 0.0, -9.80665],
        "run": {"duration": 0.02, "output_rate": 1000.0},
    }  # fmt: skip
    mine = simulate(parse_scene(mapping, "scene"))
    values = joined(list(mine.blocks())).values
    figures = mine.report.figures
    assert figures["contact_count"] == expected["contact_count"] >= 1
    assert figures["contact_duration_s"] == pytest.approx(expected["contact_duration_s"], rel=1e-3)
    assert figures["peak_force_n"] == pytest.approx(expected["peak_force_n"], rel=5e-3)
    for name in ("position", "velocity", "angular_velocity"):
        assert values[name][-1] == pytest.approx(truth[name][-1], rel=2e-3, abs=2e-3 * np.abs(truth[name]).max()), name
    assert abs(figures["energy_closure"]) < 1e-3


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


@pytest.mark.parametrize(("exponents", "points"), [((2.0, 2.0), 80), ((4.0, 4.0), 80), ((2.5, 6.0), 80)])
def test_masses_and_moments_of_superellipsoids_by_counting(exponents, points):
    axes, (n, m) = (0.03, 0.02, 0.01), exponents
    one = Shaped(shape="superellipsoid", semi_axes=axes, exponents=exponents)
    grid = (np.arange(points) + 0.5) / points
    x, y = np.meshgrid(grid, grid, indexing="ij")
    inside = x**n + y**n < 1.0
    height = np.where(inside, (1.0 - np.where(inside, x**n + y**n, 0.0) ** (m / n)) ** (1.0 / m), 0.0)
    cell = 8.0 * math.prod(axes) / points**2
    volume = cell * height.sum()
    squares = [
        axes[0] ** 2 * (x**2 * height).sum(),
        axes[1] ** 2 * (y**2 * height).sum(),
        axes[2] ** 2 * (height**3).sum() / 3,
    ]
    squares = [cell * one * STEEL.density for one in squares]
    rigid = rigid_of(one)
    assert rigid.mass == pytest.approx(STEEL.density * volume, rel=5e-3)
    assert rigid.inertia[0] == pytest.approx(squares[1] + squares[2], rel=1e-2)
    assert rigid.inertia[2] == pytest.approx(squares[0] + squares[1], rel=1e-2)
    ball = rigid_of(dataclasses.replace(one, shape="ellipsoid", exponents=(2.0, 2.0)))
    if exponents == (2.0, 2.0):
        assert rigid.inertia == pytest.approx(ball.inertia, rel=1e-12)


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
    ({"contact": {"normal": "linear"}}, "needs contact.stiffness"),
    ({"contact": {"normal": "overlaps"}}, "did you mean overlap"),
]  # fmt: skip


@pytest.mark.parametrize(("sections", "sentence"), REFUSED)
def test_what_makes_no_pair_is_refused_with_a_sentence(sections, sentence):
    with pytest.raises(SceneError, match=sentence) as caught:
        scene(**sections)
    assert "\n" not in str(caught.value) or "problems" in str(caught.value)


def test_several_closest_points_are_refused():
    """A long ellipsoid along a groove's axis touches both flanks alike."""
    turn = Rotation.from_euler("y", 90, degrees=True).as_rotvec().tolist()
    with pytest.raises(SceneError, match=r"several closest points|saddle|flat"):
        scene(
            first={"shape": "ellipsoid", "semi_axes": [0.0095, 0.002, 0.002], "position": [0.1, 0, 0], "turn": turn},
            second={"shape": "groove", "radius": 0.01, "ring_radius": 0.1, "motion": "held"},
        )


def test_a_contact_whose_load_ends_while_bodies_touch_keeps_its_impulse():
    """Steady damping ends a contact with a corner, and answers at once where it begins: no step goes across either."""

    def contacts(tolerance):
        words = ("run.duration=0.03", "solver.companion=off", f"wanted.tolerance={tolerance}")
        run = simulate(load_scene("two_bodies_ellipsoid", words))
        for _ in run.blocks():
            pass
        return np.array([(one["peak_force_n"], one["impulse_ns"]) for one in run.report.figures["contacts"]])

    exact = contacts(1e-10)
    for tolerance in (1e-2, 1e-5):
        assert np.abs(contacts(tolerance) / exact - 1.0).max() < 1e-6
