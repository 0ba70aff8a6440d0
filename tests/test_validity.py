"""What lies outside the theory is named on every kind of scene: yield, wide ellipses, a law off its curve, waves."""

import math

import pytest

from bearing_twin.contact.materials import MATERIALS, YIELD_ONSET, yield_pressure
from bearing_twin.contact.validity import OFF_IN_GROOVE, gap_error, groove_doubt
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate

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
DOUBTFUL = [
    ("bearing_6203", "yield pressure", "materials.ball.yield_strength=3e8"),
    ("bearing_6203", "keep dents", "geometry.radial_clearance=-1.2e-4"),
    ("bearing_6203", "along its groove", "geometry.inner_conformity=0.501", "geometry.radial_clearance=-3e-5"),
    ("bearing_6203", "law volumetric", "contact.normal=volumetric", "geometry.inner_conformity=0.501"),
    ("bearing_6203", "wave", "geometry.radial_clearance=-1.2e-4"),
    ("two_spheres", "yield pressure", "first.material.yield_strength=1e8"),
    ("two_spheres", "half-space", "motion.first_velocity=500"),
    ("two_spheres", "wave", "motion.first_velocity=500"),
    ("two_discs", "yield pressure", "disc.material.yield_strength=1e3"),
    ("two_discs", "half-space", "motion.first_velocity=30"),
    ("two_discs", "wave", "motion.first_velocity=30"),
    ("sphere_on_beam", "yield pressure", "sphere.material.yield_strength=1e6"),
    ("sphere_on_beam", "half-space", "blow.speed=30"),
    ("sphere_on_beam", "wave", "beam.height=0.05", "blow.speed=10"),
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
