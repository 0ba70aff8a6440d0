"""What lies outside the theory is named on every kind of scene: yield, wide ellipses, a law off its curve, waves."""

import json
import math

import numpy as np
import pytest
from reference.half_space import load_across
from scipy.special import ellipe

from bearing_twin.command.cli import main
from bearing_twin.contact.ellipse import axis_ratio, hertz_coefficient
from bearing_twin.contact.hertz_impact import contact_time
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, effective_modulus, yield_pressure
from bearing_twin.contact.validity import FELT, FEWEST_TRANSITS, OFF_IN_GROOVE, gap_error, groove_doubt, wave_transit
from bearing_twin.contact.waves import bar_speed, restitution_lost_on_half_space
from bearing_twin.kinds.bearing.start import nominal_curvatures
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene

CALM = {
    "bearing_6203": (),
    "two_spheres": ("motion.first_velocity=0.01",),
    "two_discs": (
        "motion.first_velocity=1e-4",
        "disc.material.young_modulus=2e11",
        "disc.material.yield_strength=1e12",
    ),
    "sphere_on_beam": ("beam.theory=auto",),
}
OUTSIDE = "solver.allow_invalid=on"
ROUGH = "beam.theory=timoshenko", "wanted.tolerance=1e-2", "solver.companion=off"
DOUBTFUL = [
    ("bearing_6203", "yield pressure", "materials.ball.yield_strength=3e8"),
    ("bearing_6203", "keep dents", "geometry.radial_clearance=-1.2e-4"),
    ("bearing_6203", "along its groove", "geometry.inner_conformity=0.501", "geometry.radial_clearance=-3e-5"),
    ("bearing_6203", "law volumetric", "contact.normal=volumetric", "geometry.inner_conformity=0.501", OUTSIDE),
    ("bearing_6203", "a wave takes through", "geometry.radial_clearance=-1.2e-4"),
    ("two_spheres", "yield pressure", "first.material.yield_strength=1e8"),
    ("two_spheres", "half-space", "motion.first_velocity=500"),
    ("two_spheres", "a wave takes through", "motion.first_velocity=500"),
    ("two_discs", "yield pressure", "disc.material.yield_strength=1e3"),
    ("two_discs", "half-space", "motion.first_velocity=30"),
    ("two_discs", "a wave takes through", "motion.first_velocity=30"),
    ("sphere_on_beam", "yield pressure", "sphere.material.yield_strength=1e6"),
    ("sphere_on_beam", "half-space", "blow.speed=30"),
    ("sphere_on_beam", "a wave takes through", "beam.height=0.05", "blow.speed=10", OUTSIDE),
    ("sphere_on_beam", "is large for a span", "beam.height=2e-3", "blow.speed=4", *ROUGH),
]


# Estimated errors are no doubts of theory.
OF_ERRORS = ("the error is over", *(f"{one} are off" for one in ("loads", "friction", "peaks", "forces")))


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


@pytest.mark.parametrize("case", DOUBTFUL, ids=" ".join)
def test_each_doubt_is_named_where_it_arises(case):
    name, word, *overrides = case
    assert any(word in flag for flag in flags_of(name, *overrides))


def test_a_law_within_its_curve_is_not_doubted():
    """The volumetric law in a stock groove is 0.46 % off at most; the claim is 0.5 %."""
    assert flags_of("bearing_6203", "contact.normal=volumetric") == ()


def test_the_gap_of_two_circles_is_as_far_off_its_parabola_as_is_said():
    ball, groove, reach = 3.373e-3, 3.508e-3, 0.8e-3
    gap = (ball - math.sqrt(ball**2 - reach**2)) - (groove - math.sqrt(groove**2 - reach**2))
    parabola = 0.5 * reach**2 * (1.0 / ball - 1.0 / groove)
    assert gap_error(reach, ball, groove) == pytest.approx(gap / parabola - 1.0, rel=0.05)
    assert gap_error(reach, ball, 1e9) == pytest.approx(0.25 * (reach / ball) ** 2)


def test_a_groove_is_doubted_by_its_conformity_and_not_at_ordinary_loads():
    """A 6203 passes a quarter of the ball's radius at an eighth of its static rating."""
    ball = 3.373e-3
    assert groove_doubt((0.26 * ball, 0.2 * ball), ball, (0.52, 0.53)) is None
    assert "0.000944 m" in groove_doubt((0.2 * ball, 0.28 * ball), ball, (0.52, 0.53))
    # Of two spots alike that in the closer groove is further off.
    assert groove_doubt((0.27 * ball,) * 2, ball, (0.52, 0.52)) is not None
    assert groove_doubt((0.27 * ball,) * 2, ball, (1.0, 1.0)) is None
    assert 0.0 < OFF_IN_GROOVE < 0.1


@pytest.mark.parametrize(("name", "axis", "share"), [("6203", 1, 0.12), ("bearing_218_thrust", 2, 0.62)])
def test_a_wide_spot_is_flagged_at_that_share_of_the_static_rating(name, axis, share, capsys):
    """Across an eighth, along the axis five times as much, of which the static equivalent load is 0.26."""

    def asked(load):
        loads = [0.0, 0.0, 0.0]
        loads[axis] = load
        assert main(["bearing", name, "--load", ",".join(map(str, loads)), "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    rating = asked(10.0)["basic_static_rating_n"]
    below, above = asked(0.95 * share * rating), asked(1.05 * share * rating)
    assert [any("along its groove" in flag for flag in one["flags"]) for one in (below, above)] == [False, True]
    assert 5.0 < above["static_safety"] < below["static_safety"] < 9.5


@pytest.mark.parametrize(("name", "side"), [("6203", 0), ("6203", 1), ("bearing_218_thrust", 0)])
@pytest.mark.parametrize("reach", [0.15, 0.26, 0.5])
def test_what_a_spot_along_its_groove_takes_of_the_load(name, side, reach):
    """The study of FELT: half-spaces pressed across the gap of ball and groove against the same across parabolas."""
    geometry, count = load_scene(name).parameters.geometry, 96
    small, large = nominal_curvatures(geometry)[side]
    ball = 0.5 * geometry.ball_diameter
    groove = 2.0 * (geometry.inner_conformity, geometry.outer_conformity)[side] * ball
    modulus = effective_modulus(MATERIALS["steel"], MATERIALS["steel"])
    major, ratio = reach * ball, axis_ratio(small, large)
    mean = 0.5 / (small + large)
    hertz = math.pi * 2.0 * modulus * major**3 / (6.0 * ratio**-2 * ellipe(1.0 - ratio**2) * mean)
    approach = (hertz / hertz_coefficient(small, large, modulus)) ** (2.0 / 3.0)
    sides = 3.0 * major / count, 3.0 * ratio * major / count
    x, y = np.meshgrid(*((np.arange(count) + 0.5 - 0.5 * count) * one for one in sides), indexing="ij")
    parabola = small * x**2 + large * y**2
    circles = ball - np.sqrt(ball**2 - x**2) - groove + np.sqrt(groove**2 - x**2) + large * y**2
    alike, less = (load_across(gap, sides, approach, modulus) for gap in (parabola, circles))
    assert alike == pytest.approx(hertz, rel=1e-3)
    assert 1.0 - less / alike == pytest.approx(FELT * gap_error(major, ball, groove), rel=0.12)


def test_a_contact_of_five_transits_leaves_a_quarter_of_its_energy_in_a_half_space():
    """FEWEST_TRANSITS: of a steel sphere, by Hertz's contact time and Hunter's estimate."""
    steel, radius = MATERIALS["steel"], 0.01
    wave, mass = bar_speed(steel.young_modulus, steel.density), 4.0 / 3.0 * math.pi * radius**3 * steel.density
    coefficient = hertz_coefficient(0.5 / radius, 0.5 / radius, effective_modulus(steel, steel))
    transit = wave_transit(2.0 * radius, steel.young_modulus, steel.density)
    speeds = np.geomspace(1e-3, 1.0, 3000) * wave
    lasting = contact_time(coefficient, mass, speeds)
    speed = float(np.interp(-FEWEST_TRANSITS, -lasting / transit, speeds))
    assert 2.0 * restitution_lost_on_half_space(speed, wave) == pytest.approx(0.25, rel=0.2)


@pytest.mark.parametrize(
    ("bearing", "load", "parts"),
    [
        ("7210B", "0,0,-1000", True),
        ("7210B", "0,-2000,0", True),
        ("7210B", "0,-500,2000", False),
        ("6308", "0,-500,-2000", False),
    ],
)
def test_balls_that_press_where_an_angular_contact_bearing_has_no_shoulder_are_named(bearing, load, parts, capsys):
    assert main(["bearing", bearing, "--load", load, "--json", "--strict"]) == (3 if parts else 0)
    assert ("no shoulder" in capsys.readouterr().err) == parts


@pytest.mark.parametrize(("way", "parts"), [(1.0, False), (-1.0, True)])
def test_a_run_names_the_missing_shoulder_too(way, parts):
    scene = load_scene("7204B", [f"drive.offset=[0.0,0.0,{way * 2.7e-4}]", "run.duration=0.002"])
    run = simulate(scene)
    list(run.blocks())
    assert any("no shoulder" in flag for flag in run.report.flags) == parts


@pytest.mark.parametrize(("push", "parts"), [(1.0, False), (-1.0, True)])
def test_bearings_that_face_one_way_are_taken_apart_by_a_load_the_other_way(push, parts):
    tandem = ["right.facing=1", "right.offset=-4e-6", "run.duration=0.002"]
    run = simulate(load_scene("shaft_angular_pair", [f"shaft.loads=[[0.0,0.0,-50.0,{push * 900.0},0.0,0.0]]", *tandem]))
    list(run.blocks())
    named = [flag.split(":")[0] for flag in run.report.flags if "no shoulder" in flag]
    assert named == (["left bearing", "right bearing"] if parts else [])
