"""The elastic laws against each other, against published errors, and by their shape."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from bearing_twin.contact import line
from bearing_twin.contact.damping import damped_load
from bearing_twin.contact.differential import shape_of
from bearing_twin.contact.elastic import (
    HERTZIAN,
    approaches_of_loads,
    elastic,
    energies_at,
    greatest_approaches,
    loads_at,
)
from bearing_twin.contact.elasticity import (
    carries,
    coefficient_of,
    elasticity,
    follows,
    line_elastic,
    sphere_coefficient,
)
from bearing_twin.contact.ellipse import curvature_ratio, hertz_coefficient
from bearing_twin.contact.friction import friction_factor
from bearing_twin.contact.laws import LAWS, Place, line_law
from bearing_twin.contact.names import law_names

POINT = [name for name, row in LAWS.items() if row.fits == "point"]
CURVED = [name for name in POINT if LAWS[name].follows]


@pytest.mark.parametrize("name", POINT)
def test_load_is_the_slope_of_the_energy_and_stiffness_that_of_the_load(name):
    coefficient, power = coefficient_of(name, 30.0, 200.0, 1e11, 2e7), LAWS[name].power

    def at(approach):
        return elastic(coefficient, power, approach)

    here, step = at(2e-6), 1e-10
    assert (at(2e-6 + step).energy - at(2e-6 - step).energy) / (2.0 * step) == pytest.approx(here.load, rel=1e-7)
    assert (at(2e-6 + step).load - at(2e-6 - step).load) / (2.0 * step) == pytest.approx(here.stiffness, rel=1e-7)
    assert approaches_of_loads(coefficient, power, here.load) == pytest.approx(2e-6, rel=1e-12)
    assert greatest_approaches(coefficient, power, 2.0 * here.energy, 1.0) == pytest.approx(2e-6, rel=1e-12)
    assert loads_at(coefficient, power, 2e-6) == pytest.approx(here.load, rel=1e-14)
    assert energies_at(coefficient, power, 2e-6) == pytest.approx(here.energy, rel=1e-14)
    for gap in (0.0, -1e-6):
        assert at(gap)[1:] == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", law_names("line", ()))
def test_a_line_contact_answers_in_one_call(name):
    law = line_law(name, 1.0, 2.0, 5e9, 0.3)
    step = 1e-8
    here, ahead, behind = (line_elastic(law, approach) for approach in (1e-4, 1e-4 + step, 1e-4 - step))
    assert here.load == line.load(law, 1e-4)
    assert (ahead.energy - behind.energy) / (2.0 * step) == pytest.approx(here.load, rel=1e-6)
    assert (ahead.load - behind.load) / (2.0 * step) == pytest.approx(here.stiffness, rel=1e-6)
    assert line_elastic(law, -1e-4)[1:] == (0.0, 0.0, 0.0)


def test_every_law_in_use_is_the_row_of_its_name():
    """Numbers from the compiled choice against each row's own function."""
    place = Place(3.0, 40.0, 1e11, 123.0, shape_of(3.0, 40.0))
    for name in POINT:
        row, law = LAWS[name], elasticity(name, 1e11, 123.0)
        found = coefficient_of(name, 3.0, 40.0, 1e11, 123.0)
        assert found == row.coefficient(place)
        assert row.follows or found == 123.0
        assert (law.power, follows(law), carries(law)) == (row.power, row.follows, row.state is not None)


def test_spheres_by_every_law():
    for name in CURVED:
        found = sphere_coefficient(name, 2.0, np.array([1.0, 4.0]))
        assert found == pytest.approx(coefficient_of(name, 0.5, 0.5, 2.0) * np.array([1.0, 2.0]), rel=1e-10)
    assert sphere_coefficient("linear", 2.0, 1.0, 7.0) == 7.0


def test_rational_hertz_is_exact_to_1e_10_in_its_range_and_exact_outside():
    for ratio in np.concatenate([np.linspace(0.01, 1.0, 400), np.geomspace(1e-5, 0.01, 30)]):
        large = curvature_ratio(ratio)
        found = coefficient_of("hertz", 1.0, large, 1.0)
        assert found == pytest.approx(hertz_coefficient(1.0, large, 1.0), rel=1e-10)


# Paper 1, eq. (9): "0.5 % for b/a in [0.1, 1]" holds, and the error is a curve beyond: Q/P, error in %.
@pytest.mark.parametrize(
    ("ratio", "percent"),
    [
        (1, -0.475), (2, -0.355), (5, 0.057), (10, 0.361), (20, 0.456), (40, 0.199), (100, -0.814), (200, -2.11),
        (1000, -6.70),
    ],
)  # fmt: skip
def test_volumetric_error_curve(ratio, percent):
    exact = hertz_coefficient(1.0, float(ratio), 1.0)
    found = coefficient_of("volumetric", 1.0, float(ratio), 1.0)
    assert 100.0 * (found / exact - 1.0) == pytest.approx(percent, abs=6e-3)


def test_the_constant_law_returns_its_constant():
    assert coefficient_of("constant", 1.0, 7.0, 1e11, 123.0) == 123.0


@pytest.mark.parametrize("law", CURVED)
@given(st.floats(1.0, 500.0), st.floats(1e-2, 1e4), st.floats(0.1, 10.0))
def test_coefficients_scale_with_size_and_modulus(law, ratio, small, factor):
    """Geometrically similar contacts: c ~ 1/sqrt(curvature), c ~ E*."""
    base = coefficient_of(law, small, small * ratio, 1e11)
    assert coefficient_of(law, factor * small, factor * small * ratio, 1e11) == pytest.approx(
        base / math.sqrt(factor), rel=1e-9
    )
    assert coefficient_of(law, small, small * ratio, factor * 1e11) == pytest.approx(factor * base, rel=1e-12)


@given(st.floats(-1e-3, 1e-3), st.floats(0.0, 1e-4))
def test_load_rises_with_approach_and_is_zero_for_a_gap(approach, more):
    load = elastic(2e10, HERTZIAN, approach).load
    assert load >= 0.0
    assert load > 0.0 if approach > 1e-12 else load < 1e-7
    assert load == 0.0 or approach > 0.0
    assert elastic(2e10, HERTZIAN, approach + more).load >= load


def test_energy_is_the_integral_of_the_load():
    work, _ = quad(lambda h: elastic(2e10, HERTZIAN, h).load, -1e-6, 5e-6, points=[0.0], epsabs=0.0, epsrel=1e-11)
    assert elastic(2e10, HERTZIAN, 5e-6).energy == pytest.approx(work, rel=1e-9)
    assert elastic(2e10, HERTZIAN, -1e-6).energy == 0.0


def test_viscous_term_vanishes_with_the_approach_and_never_pulls():
    """Paper 1, section 5: F_visc = -d(h) dh/dt with d(h) -> 0; as h^1.5 for one part and h^0.5 for the other."""
    rates = np.linspace(-20.0, 20.0, 41)
    for approach in (1e-12, 1e-9, 1e-6):
        _, load, stiffness, _ = elastic(2e10, HERTZIAN, approach)
        assert stiffness == pytest.approx(1.5 * load / approach, rel=1e-12)
        for damping, relaxation, bound in ((0.2, 0.0, 0.2 * load), (0.0, 1e-6, 1e-6 * stiffness)):
            loads = np.array([damped_load(load, stiffness, rate, damping, relaxation) for rate in rates])
            assert np.all(loads >= 0.0)
            assert np.abs(loads - load).max() <= 20.0 * bound * (1.0 + 1e-12)
    assert damped_load(10.0, 0.0, -6.0, 0.2, 0.0) == 0.0
    assert elastic(2e10, HERTZIAN, -1e-6).stiffness == 0.0


@given(st.tuples(*[st.floats(-10.0, 10.0)] * 3), st.floats(1e-6, 1.0))
def test_friction_opposes_slip_and_stays_in_its_cone(slip, regularisation):
    force = friction_factor(50.0, *slip, 0.1, regularisation) * np.linalg.norm(slip)
    assert 0.0 <= force <= 0.1 * 50.0 * (1.0 + 1e-12)
    if np.linalg.norm(slip) > 30.0 * regularisation:
        assert force > 0.999 * 5.0
