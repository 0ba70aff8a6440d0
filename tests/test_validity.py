"""What lies outside the theory is named on every kind of scene: yield, wide ellipses, a law off its curve, waves."""

import math

import numpy as np
import pytest

from bearing_twin.command.cli import main
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.hertz_impact import contact_time
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, effective_modulus, yield_pressure
from bearing_twin.contact.validity import FEWEST_TRANSITS, gap_error, wave_transit
from bearing_twin.contact.waves import bar_speed, restitution_lost_on_half_space
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


def test_the_gap_of_two_circles_is_as_far_off_its_parabola_as_is_said():
    ball, groove, reach = 3.373e-3, 3.508e-3, 0.8e-3
    gap = (ball - math.sqrt(ball**2 - reach**2)) - (groove - math.sqrt(groove**2 - reach**2))
    parabola = 0.5 * reach**2 * (1.0 / ball - 1.0 / groove)
    assert gap_error(reach, ball, groove) == pytest.approx(gap / parabola - 1.0, rel=0.05)
    assert gap_error(reach, ball, 1e9) == pytest.approx(0.25 * (reach / ball) ** 2)


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
