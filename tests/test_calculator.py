"""The contact calculator, its command, and what it doubts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.half_space import load_across
from runs import reported
from scipy.integrate import quad
from scipy.special import ellipe

from bearing_twin.base.errors import BearingTwinError, SceneError
from bearing_twin.command import cli
from bearing_twin.command.commands import COMMANDS
from bearing_twin.contact.calculator import (
    POWERS,
    axis_stresses,
    contact_under_load,
    gap_in_groove,
    gap_of_curvatures,
    gap_of_radii,
    greatest_shear,
    solve,
)
from bearing_twin.contact.elasticity import axis_ratio, hertz_coefficient
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, Material, effective_modulus, yield_pressure
from bearing_twin.contact.validity import FELT, gap_error
from bearing_twin.kinds.bearing.geometry import nominal_curvatures
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

STEEL = Material(2.1e11, 0.3, 7850.0)
MODULUS = effective_modulus(STEEL, STEEL)


@settings(deadline=None)  # the first example compiles
@given(st.sampled_from(sorted(POWERS)), st.floats(1e-2, 1e4), st.floats(1.0, 1e5), st.floats(1e-3, 1e6))
def test_every_inverse_leads_back_to_the_load(name, small, ratio, load):
    gap = gap_of_curvatures(small, small * ratio)
    contact = contact_under_load(gap, MODULUS, load)
    solved = solve(gap, MODULUS, name, getattr(contact, name))
    assert list(solved) == pytest.approx(list(contact), rel=1e-12)


def test_sphere_on_plane_in_closed_form():
    """F = 4/3 E* sqrt(R) h^1.5, a = sqrt(R h), p0 = 3F/(2 pi a^2), stiffness 2 E* a."""
    contact = solve(gap_of_radii((0.01, 0.01), (math.inf, math.inf)), MODULUS, "approach", 1e-6)
    assert contact.normal_load == pytest.approx(15.384615384615384, rel=1e-12)
    assert contact.semi_major == pytest.approx(1e-4, rel=1e-12)
    assert contact.peak_pressure == pytest.approx(1.5 * contact.normal_load / (math.pi * 1e-8), rel=1e-12)
    assert contact.stiffness == pytest.approx(2.0 * MODULUS * 1e-4, rel=1e-12)


@given(st.floats(0.0, math.pi), st.tuples(*[st.floats(1e-3, 10.0)] * 4))
def test_crossed_bodies_have_the_eigenvalues_of_the_summed_curvatures(angle, radii):
    """Half the sum of the two curvature tensors, turned by the angle; the bodies may be exchanged."""
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    second = turn @ np.diag([1.0 / radii[2], 1.0 / radii[3]]) @ turn.T
    expected = 0.5 * np.linalg.eigvalsh(np.diag([1.0 / radii[0], 1.0 / radii[1]]) + second)
    gap = gap_of_radii(radii[:2], radii[2:], angle)
    assert gap[:2] == pytest.approx(expected, rel=1e-9)
    assert gap_of_radii(radii[2:], radii[:2], angle)[:2] == pytest.approx(gap[:2], rel=1e-12)


# Ball on raceway, steel E = 207.5 GPa: conformity, side, force constant, b/a (6203).
@pytest.mark.parametrize(
    ("conformity", "side", "coefficient", "ratio"),
    [
        (0.515, -1, 2.589e10, 0.0883),
        (0.515, 1, 2.763e10, 0.1181),
        (0.52, -1, 2.338e10, 0.1043),
        (0.52, 1, 2.502e10, 0.14),
    ],
)
def test_a_raceway_is_a_hollow_body(conformity, side, coefficient, ratio):
    steel = Material(2.075e11, 0.3, 7850.0)
    modulus = effective_modulus(steel, steel)
    gap = gap_in_groove(6.746e-3, 28.5e-3, conformity, side)
    contact = solve(gap, modulus, "approach", 1e-6)
    assert contact.normal_load / 1e-9 == pytest.approx(coefficient, rel=2.5e-4)
    assert contact.axis_ratio == pytest.approx(ratio, abs=6e-5)
    ball, groove, floor = 3.373e-3, conformity * 6.746e-3, 14.25e-3 + side * 3.373e-3
    same = gap_of_radii((ball, ball), (groove, floor), 0.0, (True, side > 0))
    assert same[:2] == pytest.approx(gap[:2], rel=1e-12)


def test_each_body_adds_its_own_compliance():
    """Steel 200 GPa, 0.3 on aluminium 70 GPa, 0.33: 1/E* = 4.55e-12 + 1.273e-11 1/Pa, whichever is named first."""
    steel, aluminium = Material(2.0e11, 0.3, 7850.0), Material(7.0e10, 0.33, 2700.0)
    assert effective_modulus(steel, aluminium) == pytest.approx(5.787037e10, rel=1e-6)
    assert effective_modulus(aluminium, steel) == effective_modulus(steel, aluminium)


@pytest.mark.parametrize("depth", [0.0, 0.1, 0.48, 1.0, 3.0])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
def test_stresses_below_a_circle_in_closed_form(depth, nu):
    """Johnson, Contact Mechanics, eq. (3.45), a = p0 = 1."""
    across, _, normal = axis_stresses(1.0, 1.0, 1.0, nu, depth)
    arc = 1.0 if depth == 0.0 else 1.0 - depth * math.atan(1.0 / depth)
    assert across == pytest.approx(-(1.0 + nu) * arc + 0.5 / (1.0 + depth**2), abs=1e-12)
    assert normal == pytest.approx(-1.0 / (1.0 + depth**2), abs=1e-12)


@pytest.mark.parametrize("ratio", [0.9999999, 0.5, 0.1])
def test_stresses_below_an_ellipse_are_the_integral_of_point_loads(ratio):
    """Normal stress 3 z^3/(2 pi r^5) and, with nu = 1/2, in-plane 3 x^2 z/(2 pi r^5) summed over the pressure."""
    depth = 0.6 * ratio

    def point(angle, power):
        def ring(t):
            x, y = t * math.cos(angle), ratio * t * math.sin(angle)
            r2 = x * x + y * y + depth * depth
            share = (x * x * depth, y * y * depth, depth**3)[power]
            return math.sqrt(max(1.0 - t * t, 0.0)) * share / r2**2.5 * ratio * t

        return quad(ring, 0.0, 1.0, epsrel=1e-9, epsabs=1e-12, limit=200)[0]

    results = axis_stresses(1.0, ratio, 1.0, 0.5, depth)
    for axis in range(3):
        summed = 4.0 * quad(lambda angle, axis=axis: point(angle, axis), 0.0, 0.5 * math.pi, epsrel=1e-8)[0]
        assert results[axis] == pytest.approx(-1.5 / math.pi * summed, rel=1e-6)


def test_greatest_shear_below_circle_and_line():
    """0.310 p0 at 0.481 a (circle) and 0.300 p0 at 0.786 b (line), nu = 0.3; in between both move monotonously."""
    circle, line = greatest_shear(1.0, 1.0, 1.0, 0.3), greatest_shear(1.0, 1e-4, 1.0, 0.3)
    assert circle == pytest.approx((0.310, 0.481), abs=5e-4)
    assert (line.stress, line.depth / 1e-4) == pytest.approx((0.300, 0.786), abs=5e-4)
    depths = [greatest_shear(1.0, ratio, 1.0, 0.3).depth / ratio for ratio in (1.0, 0.6, 0.3, 0.1, 0.03)]
    assert np.all(np.diff(depths) > 0.0)
    assert greatest_shear(1.0, 1.0, 1.0, -0.999999) == pytest.approx((0.75, 0.0), abs=1e-5)


def contact_command(line):
    parser, _ = cli.parsers("contact")
    return COMMANDS["contact"].run(parser.parse_args(["contact", *line.split()]))


def test_a_bearing_by_its_designation_and_by_its_curvatures_agree():
    bearing = contact_command("--bearing 6203 --race outer --load 100").result
    small, large = bearing["curvature_small_per_m"], bearing["curvature_large_per_m"]
    gap = contact_command(f"--curvature-small {small!r} --curvature-large {large!r} --young 2.075e11 --load 100").result
    assert gap["approach_m"] == pytest.approx(bearing["approach_m"], rel=1e-13)
    assert bearing["normal_load_n"] / bearing["approach_m"] ** 1.5 == pytest.approx(2.502e10, rel=2.5e-4)
    assert contact_command("--bearing 6203 --load 100").result["axis_ratio"] == pytest.approx(0.1043, abs=6e-5)


def test_yield_is_judged_where_it_is_known():
    assert "yield" in contact_command("--radii-1 0.01 --peak-pressure 3.3e9").warnings[0]
    assert contact_command("--radii-1 0.01 --peak-pressure 3.1e9").warnings == []
    assert contact_command("--radii-1 0.01 --young 1e11 --poisson 0.2 --peak-pressure 1e9").warnings == []
    assert (
        "yield" in contact_command("--radii-1 0.01 --young 1e11 --peak-pressure 1e9 --yield-strength 5e8").warnings[0]
    )


def test_damping_for_a_restitution_by_the_exact_relation_and_by_the_usual_formulas(capsys):
    outcome = contact_command("--radii-1 0.01 --speed 2 --mass 0.1 --restitution 0.5")
    results = outcome.result["damping"]
    assert [scale["restitution"] for scale in results.values()] == pytest.approx([0.5, 0.663, 0.725, 0.470], abs=6e-4)
    chi = results["exact"]["damping_s_per_m"] * 2.0
    assert chi * 1.5 == pytest.approx(math.log((1.0 + chi) / (1.0 - 0.5 * chi)), rel=1e-12)
    assert results["flores"]["damping_s_per_m"] == pytest.approx(0.8, rel=1e-12)
    outcome.show()
    shown = "".join(capsys.readouterr())
    assert "damping [s/m]" in shown
    assert "lankarani_nikravesh" in shown


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("--curvature-small -1 --curvature-large 2 --load 1", "conform"),
        ("--curvature-small 0 --curvature-large 2 --load 1", "line"),
        ("--curvature-small 3 --curvature-large 2 --load 1", "exchange"),
        ("--curvature-small 1 --curvature-large 1e14 --load 1", "this is a line"),
        ("--radii-1 0 --load 1", "above zero"),
        ("--radii-1 1 --load -1", "above 0"),
        ("--radii-1 1 --speed 1 --mass 0", "mass"),
        ("--load 1", "one way"),
        ("--radii-1 1", "exactly one of"),
        ("--radii-1 1 --load 1 --approach 1e-6", "exactly one of"),
        ("--radii-1 1 --speed 1", "belong together"),
        ("--radii-1 1 --load 1 --restitution 0.5", "goes with --speed"),
        ("--radii-1 1 --speed 1 --mass 1 --restitution 0", "above 0 and at most 1"),
        ("--radii-1 1 2 3 --load 1", "3 values"),
        ("--radii-1 1 --poisson 0.5 --load 1", "below 0.5"),
        ("--radii-1 1 --young nan --load 1", "not finite"),
        ("--radii-1 1 --material stel --load 1", "did you mean steel"),
        ("--radii-1 1 --race inner --load 1", "goes with --bearing"),
        ("--bearing 6203 --hollow x --load 1", "goes with --radii-1"),
        ("--bearing 9999 --load 1", "catalogue"),
        ("--curvature-small 1 --load 1", "both"),
        ("--radii-1 1 --load 1 --plot picture.jpg", "png"),
        ("--radii-1 1 --load 1 --yield-strength -1", "yield-strength"),
    ],
)  # fmt: skip
def test_bad_input_is_refused_with_the_reason(line, reason):
    with pytest.raises(BearingTwinError, match=reason):
        contact_command(line)


def test_a_law_that_diverges_has_no_error(capsys):
    """It was shown as a load of nan with an error of +0 %."""
    outcome = contact_command("--radii-1 0.01 --load 1")
    outcome.result["laws"]["hertz_unprojected"]["normal_load_n"] = math.nan
    outcome.show()
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("hertz_unprojected"))
    assert row.split() == ["hertz_unprojected", "diverges", "-"]


def test_the_law_constant_is_exact_where_it_is_frozen(capsys):
    line = "--bearing 6203 --load 50"
    circle, frozen = contact_command(line), contact_command(f"{line} --frozen-at 0.104322")
    assert circle.result["laws"]["constant"]["error"] == pytest.approx(-0.203, abs=1e-3)
    assert frozen.result["laws"]["constant"]["error"] == pytest.approx(0.0, abs=1e-5)
    frozen.show()
    assert "exact for b/a = 0.104322" in capsys.readouterr().out
    for ratio in ("0", "1.5", "nan"):
        with pytest.raises(SceneError, match="frozen_at"):
            contact_command(f"{line} --frozen-at {ratio}")


CALM = {
    "bearing_6203": (),
    "two_spheres": ("motion.first_velocity=0.01",),
    "two_discs": (
        "motion.first_velocity=1e-4",
        "disc.material.young_modulus=2e11",
        "disc.material.yield_strength=1e12",
        "contact.normal=auto",
        "wanted.tolerance=0.1",
    ),
    "sphere_on_beam": ("beam.theory=auto",),
}


# Estimated errors are no doubts of theory.
OF_ERRORS = ("the error is over", *(f"{scale} are off" for scale in ("loads", "friction", "peaks", "forces")))


def flags_of(name, *overrides):
    scene = load_scene(name, overrides)
    if scene.kind == "bearing":
        scene = load_scene(name, [*overrides, "run.duration=0.002"])
    run_ = simulate(scene)
    for _ in run_.blocks():
        pass
    return tuple(flag for flag in run_.report.flags if not flag.startswith(OF_ERRORS))


def test_the_weaker_body_yields_first_and_one_of_which_nothing_is_known_is_left_out():
    steel, ceramic, aluminium = (MATERIALS[name] for name in ("steel", "silicon_nitride", "aluminium"))
    assert yield_pressure(steel, aluminium) == yield_pressure(aluminium, steel) == YIELD_ONSET * 2.8e8
    assert yield_pressure(ceramic, steel) == YIELD_ONSET * 2.0e9
    assert yield_pressure(ceramic, ceramic) is None


@pytest.mark.parametrize("name", CALM)
def test_a_calm_contact_raises_no_doubt(name):
    assert flags_of(name, *CALM[name]) == ()


@pytest.mark.parametrize(
    ("bearing", "load", "parts"),
    [
        ("7210B", "0,0,-1000", True),
        ("7210B", "0,-500,2000", False),
    ],
)
def test_balls_that_press_where_an_angular_contact_bearing_has_no_shoulder_are_named(bearing, load, parts, capsys):
    assert cli.main(["bearing", bearing, "--load", load, "--json", "--strict"]) == (3 if parts else 0)
    assert ("no shoulder" in capsys.readouterr().err) == parts


@pytest.mark.parametrize(("push", "parts"), [(1.0, False), (-1.0, True)])
def test_bearings_that_face_one_way_are_taken_apart_by_a_load_the_other_way(push, parts):
    tandem = ["right.facing=1", "right.offset=-4e-6", "run.duration=0.002"]
    report = reported("shaft_angular_pair", f"shaft.loads=[[0.0,0.0,-50.0,{push * 900.0},0.0,0.0]]", *tandem)
    named = [flag.split(":")[0] for flag in report.flags if "no shoulder" in flag]
    assert named == (["left bearing", "right bearing"] if parts else [])


@pytest.mark.parametrize(("name", "side"), [("6203", 0), ("6203", 1), ("bearing_218_thrust", 0)])
@pytest.mark.parametrize("reach", [0.15, 0.26, 0.5])
def test_what_a_spot_along_its_groove_takes_of_the_load(name, side, reach):
    """The study of FELT: half-spaces pressed across the gap of ball and groove against the same across parabolas."""
    geometry, count = load_scene(name).parameters.geometry, 64
    small, large = nominal_curvatures(geometry)[side]
    ball = 0.5 * geometry.ball_diameter
    groove = 2.0 * (geometry.inner_conformity, geometry.outer_conformity)[side] * ball
    modulus = effective_modulus(MATERIALS["steel"], MATERIALS["steel"])
    major, ratio = reach * ball, axis_ratio(small, large)
    mean = 0.5 / (small + large)
    hertz = math.pi * 2.0 * modulus * major**3 / (6.0 * ratio**-2 * ellipe(1.0 - ratio**2) * mean)
    approach = (hertz / hertz_coefficient(small, large, modulus)) ** (2.0 / 3.0)
    sides = 3.0 * major / count, 3.0 * ratio * major / count
    x, y = np.meshgrid(*((np.arange(count) + 0.5 - 0.5 * count) * scale for scale in sides), indexing="ij")
    parabola = small * x**2 + large * y**2
    circles = ball - np.sqrt(ball**2 - x**2) - groove + np.sqrt(groove**2 - x**2) + large * y**2
    alike, less = (load_across(gap, sides, approach, modulus) for gap in (parabola, circles))
    assert alike == pytest.approx(hertz, rel=1e-3)
    assert 1.0 - less / alike == pytest.approx(FELT * gap_error(major, ball, groove), rel=0.12)
