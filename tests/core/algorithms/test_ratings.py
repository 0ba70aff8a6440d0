"""Ratings, lives and operating clearance against the standards' formulas and printed numbers."""

import dataclasses
import math

import numpy as np
import pytest
from published_ratings import LIMITING_SPEEDS

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.elasticity import ellipse
from bearing_twin.kinds.bearing.equilibrium import Support, solver_of
from bearing_twin.kinds.bearing.geometry import clearance_parts, nominal_curvatures, operating_geometry
from bearing_twin.kinds.bearing.parameters import Geometry
from bearing_twin.kinds.bearing.ratings import (
    Ratings,
    basic_dynamic_rating,
    basic_static_rating,
    equivalent_load,
    limiting_speeds,
    lives_of,
    ratings_of,
    reference_life,
    static_load,
)
from bearing_twin.kinds.bearing.system import bearing_of
from bearing_twin.run.scene import load_scene


def parameters(*overrides, scene="bearing_6203"):
    return load_scene(scene, overrides).parameters


def test_the_ratings_of_a_6203_and_a_6308():
    geometry = parameters().geometry
    assert basic_dynamic_rating(geometry) == pytest.approx(9547.0, rel=1e-3)
    assert basic_static_rating(geometry) == pytest.approx(4763.0, rel=1e-3)
    assert basic_static_rating(parameters(scene="6308").geometry) == pytest.approx(24006.0, abs=15.0)


def test_the_factor_of_the_dynamic_rating_is_that_of_the_standard():
    """ISO 281, table 2: f_c of single-row bearings with grooves of 0.52 D, over D cos(a)/d_m, rounded to 0.1."""
    table = {0.05: 46.7, 0.10: 55.5, 0.14: 58.8, 0.20: 59.9, 0.26: 58.2, 0.30: 56.0, 0.36: 51.7, 0.40: 48.4}
    for ratio, factor in table.items():
        geometry = Geometry(balls=8, ball_diameter=10e-3, pitch_diameter=10e-3 / ratio)
        rating_factor = basic_dynamic_rating(geometry) / (1.3 * 8.0 ** (2.0 / 3.0) * 10.0**1.8)
        assert rating_factor == pytest.approx(factor, abs=0.06), ratio


def test_ratings_that_are_given_replace_those_of_the_geometry():
    scene = parameters("ratings.dynamic=9950", "ratings.static=4750")
    assert ratings_of(scene) == (9950.0, 4750.0)
    assert ratings_of(parameters("ratings.static=4750")).dynamic == pytest.approx(9547.0, rel=1e-3)


def test_larger_balls_rate_less_beyond_an_inch():
    """At 25.4 mm both branches of ISO 281 meet within the standard's rounding."""
    geometry = dataclasses.replace(parameters().geometry, ball_diameter=25.4e-3, pitch_diameter=110e-3)
    above = dataclasses.replace(geometry, ball_diameter=25.401e-3)
    assert basic_dynamic_rating(above) == pytest.approx(basic_dynamic_rating(geometry), rel=2e-3)


def test_a_radial_load_gives_the_life_of_iso_281():
    scene = parameters()
    ratings = Ratings(9547.0, 4810.0)
    lives = lives_of(scene, ratings, (600.0, -800.0, 0.0), np.ones(8), np.ones(8))
    assert lives.basic == pytest.approx(9.547**3, rel=1e-12)
    assert lives.static_safety == pytest.approx(4.81, rel=1e-12)


def test_reference_life_of_even_loads_by_the_formula_written_out():
    """A thrust that loads all balls the same: 16281's own sums fall away."""
    geometry = parameters().geometry
    gamma = geometry.ball_diameter / geometry.pitch_diameter
    x = 1.044 * ((1.0 - gamma) / (1.0 + gamma)) ** 1.72
    rated_inner = 9547.0 / (0.407 * 8.0) * (1.0 + x ** (10.0 / 3.0)) ** 0.3
    rated_outer = 9547.0 / (0.389 * 8.0) * (1.0 + x ** (-10.0 / 3.0)) ** 0.3
    expected = ((rated_inner / 300.0) ** (-10.0 / 3.0) + (rated_outer / 310.0) ** (-10.0 / 3.0)) ** -0.9
    life = reference_life(geometry, 9547.0, np.full(8, 300.0), np.full(8, 310.0))
    assert life == pytest.approx(expected, rel=1e-12)


def test_the_reference_life_under_the_load_distribution_of_the_standard_is_the_basic_life():
    """ISO/TS 16281 is built so: half the balls loaded (no clearance, epsilon 0.5) gives about (C/P)^3."""
    scene = parameters("geometry.radial_clearance=0.0", "drive.speed=0.0", "geometry.balls=9",
                       "geometry.ball_diameter=6e-3")  # fmt: skip
    free = (True, True, True, False, False)
    solver = solver_of(scene, "hertz", -0.5 * math.pi)
    equilibrium = solver.solve(Support(free, (0.0, -500.0, 0.0, 0.0, 0.0), (0.0,) * 5))
    lives = lives_of(scene, ratings_of(scene), (0.0, -500.0, 0.0), *equilibrium.contacts.load.T)
    assert lives.reference == pytest.approx(lives.basic, rel=0.12)


@pytest.mark.parametrize(
    ("degrees", "radial", "axial", "dynamic", "static"),
    [
        (0.0, 1000.0, 0.0, 1000.0, 1000.0),
        (0.0, 1000.0, 100.0, 1000.0, 1000.0),  # below e
        (0.0, 500.0, 345.0, 0.56 * 500.0 + 1.99 * 345.0, 500.0),  # a row of the table: F_a/(Z D^2) = 0.345 N/mm^2
        (5.0, 100.0, 689.0, 0.56 * 100.0 + 1.71 * 689.0, 0.5 * 100.0 + 0.52 * 689.0),
        (10.0, 100.0, 689.0, 0.46 * 100.0 + 1.52 * 689.0, 0.5 * 100.0 + 0.5 * 689.0),
        (15.0, 100.0, 689.0, 0.44 * 100.0 + 1.30 * 689.0, 0.5 * 100.0 + 0.46 * 689.0),
        (40.0, 1000.0, 2000.0, 0.35 * 1000.0 + 0.57 * 2000.0, 0.5 * 1000.0 + 0.26 * 2000.0),
        (40.0, 1000.0, 1000.0, 1000.0, 1000.0),
    ],
)
def test_equivalent_loads_have_the_factors_of_the_standards(degrees, radial, axial, dynamic, static):
    """ISO 281, table 3, and ISO 76, for ten balls of 10 mm."""
    geometry = Geometry(balls=10, ball_diameter=10e-3, pitch_diameter=60e-3, contact_angle=math.radians(degrees))
    assert equivalent_load(geometry, radial, axial) == pytest.approx(dynamic, rel=1e-9)
    assert static_load(geometry, radial, axial) == pytest.approx(static, rel=1e-9)


def test_the_dynamic_rating_falls_with_the_contact_angle():
    """f_c knows the angle by D cos(a)/d_m alone: two bearings with the same of that differ by (cos a)^0.7."""
    flat, cosine = parameters().geometry, math.cos(math.radians(40.0))
    steep = dataclasses.replace(flat, contact_angle=math.radians(40.0), pitch_diameter=flat.pitch_diameter * cosine)
    ratio = basic_dynamic_rating(steep) / basic_dynamic_rating(flat)
    assert ratio == pytest.approx(cosine**0.7, rel=1e-12)


@pytest.mark.parametrize("conformities", [(0.515, 0.53), (0.54, 0.505)])
def test_the_static_rating_presses_the_raceway_that_reaches_it_first_with_4200_mpa(conformities):
    inner, outer = conformities
    geometry = dataclasses.replace(parameters().geometry, inner_conformity=inner, outer_conformity=outer)
    load = 5.0 * basic_static_rating(geometry) / geometry.balls
    spots = [ellipse(*gap, 0.5 * 207e9 / (1.0 - 0.3**2), load) for gap in nominal_curvatures(geometry)]
    assert max(spot.peak_pressure for spot in spots) == pytest.approx(4.2e9, rel=1e-9)


# Clearance


@pytest.mark.parametrize(("balls", "loss"), [(0.0, 3.28e-6), (303.15, 4.05e-6)])
def test_a_warmer_inner_ring_takes_clearance(balls, loss):
    """10 K between the rings: balls at the mean of the rings, or as hot as the inner one."""
    clearance = clearance_parts(parameters("temperatures.inner_ring=303.15", f"temperatures.balls={balls}"))
    assert -clearance.temperature == pytest.approx(loss, rel=2e-3)
    assert clearance.operating == pytest.approx(clearance.initial - loss, abs=1e-8)


def pressed(inner, outer, bore, seat, outside, interference):
    """Displacements (2,) [m] of bore and outside of two rings pressed on each other: u = a r + b / r in each."""
    rows, right = np.zeros((4, 4)), np.zeros(4)

    def stress(material, radius):
        """Of a and b: E/(1 - nu^2) ((1 + nu) a - (1 - nu) b / r^2) is the radial stress."""
        e, nu = material.young_modulus, material.poisson_ratio
        return np.array([1.0 + nu, (nu - 1.0) / radius**2]) * e / (1.0 - nu**2)

    rows[0, :2], rows[1, 2:] = stress(inner, bore), stress(outer, outside)
    rows[2, :2], rows[2, 2:] = stress(inner, seat), -stress(outer, seat)
    rows[3], right[3] = [-seat, -1.0 / seat, seat, 1.0 / seat], 0.5 * interference
    constants = np.linalg.solve(rows / np.abs(rows).max(axis=1, keepdims=True), right / np.abs(rows).max(axis=1))
    return constants[:2] @ [bore, 1.0 / bore], constants[2:] @ [outside, 1.0 / outside]


@pytest.mark.parametrize(
    ("hollow", "thick", "shaft", "housing"),
    [(9e-3, 52e-3, "silicon_nitride", "aluminium"), (0.0, 0.0, "steel", "steel")],
)
def test_shafts_and_housings_press_as_elastic_rings_do(hollow, thick, shaft, housing):
    """Hollow and thin ones of other materials; a solid shaft, and a housing without end, of steel."""
    seats = [f"fits.{part}.interference=10e-6" for part in ("shaft", "housing")]
    seats += ["fits.shaft.diameter=17e-3", f"fits.shaft.other_diameter={hollow}", f"fits.shaft.material={shaft}"]
    seats += ["fits.housing.diameter=40e-3", f"fits.housing.other_diameter={thick}", f"fits.housing.material={housing}"]
    scene = parameters(*seats)
    clearance, geometry, fits, rings = clearance_parts(scene), scene.geometry, scene.fits, scene.materials
    inner, outer = (0.5 * (geometry.pitch_diameter + sign * geometry.ball_diameter) for sign in (-1.0, 1.0))
    _, grows = pressed(fits.shaft.material, rings.inner_ring, 0.5 * hollow or 1e-7, 8.5e-3, inner, 10e-6)
    shrinks, _ = pressed(rings.outer_ring, fits.housing.material, outer, 20e-3, 0.5 * thick or 1e3, 10e-6)
    assert clearance.shaft_fit == pytest.approx(-2.0 * grows, rel=1e-8)
    assert clearance.housing_fit == pytest.approx(2.0 * shrinks, rel=1e-8)
    assert (
        clearance.operating
        == operating_geometry(scene).radial_clearance
        == pytest.approx(sum(clearance[:4]), rel=1e-12)
    )


def test_a_run_has_the_operating_clearance():
    warm, plain = parameters("temperatures.inner_ring=303.15"), parameters()
    change = clearance_parts(warm).temperature
    same = dataclasses.replace(plain, geometry=dataclasses.replace(plain.geometry, radial_clearance=-6e-6 + change))
    assert bearing_of(warm, "hertz") == bearing_of(same, "hertz")


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["fits.shaft.interference=1e-5"], "fits.shaft.diameter = 0 m must lie between .* give the ring's bore"),
        (["fits.shaft.interference=1e-5", "fits.shaft.diameter=22e-3"], "the inner raceway's 0.021754 m"),
        (["fits.housing.interference=1e-5", "fits.housing.diameter=30e-3"], "the outer raceway's 0.035246 m"),
        (["geometry.contact_angle=0.3", "geometry.radial_clearance=1e-5"], "say the same thing; keep one of them"),
        (["temperatures.inner_ring=900"], "geometry.radial_clearance = .* must be between"),
    ],
)
def test_impossible_fits_are_refused(overrides, message):
    with pytest.raises(SceneError, match=message):
        parameters(*overrides)


def test_limiting_speeds_meet_those_of_a_catalogue():
    for (series, lubricant), rows in LIMITING_SPEEDS.items():
        for bore_code, published in enumerate(rows):
            limit = limiting_speeds(parameters(scene=f"{series}{bore_code:02d}").geometry)[lubricant]
            assert limit * 30.0 / math.pi == pytest.approx(published, rel=0.14), (series, bore_code)
    assert limiting_speeds(parameters(scene="7205B").geometry) is None
