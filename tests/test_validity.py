"""What lies outside the theory is named on every kind of scene: yield, wide ellipses, a law off its curve, waves."""

import pytest

from bearing_twin.command.cli import main
from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, yield_pressure
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
