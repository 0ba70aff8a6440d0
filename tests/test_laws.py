"""The elastic laws against each other, against published errors, and by their shape."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from bearing_twin.contact.damping import damped_load
from bearing_twin.contact.ellipse import curvature_ratio, hertz_coefficient
from bearing_twin.contact.friction import friction_factor
from bearing_twin.contact.normal import (
    LAWS,
    elastic_energy,
    elastic_load,
    elastic_stiffness,
    hertz_rational,
    load_coefficient,
)
from bearing_twin.reference.fit_hertz import fit

CURVED = sorted(set(LAWS) - {"constant"})


def test_rational_hertz_is_exact_to_1e_10_in_its_range_and_exact_outside():
    for ratio in np.concatenate([np.linspace(0.01, 1.0, 400), np.geomspace(1e-5, 0.01, 30)]):
        large = curvature_ratio(ratio)
        found = load_coefficient(LAWS["hertz"], 1.0, large, 1.0, 0.0)
        assert found == pytest.approx(hertz_coefficient(1.0, large, 1.0), rel=1e-10)


def test_the_fit_can_be_made_again():
    numerator, denominator, error = fit("HERTZ")
    assert error < 1e-10
    u = np.linspace(0.0, 0.9, 7)
    refit = np.polyval(numerator[::-1], u) / np.polyval(denominator[::-1], u)
    large = ((1.0 + np.sqrt(u)) / (1.0 - np.sqrt(u))) ** 2
    committed = [hertz_rational(1.0 / math.sqrt(q), math.sqrt(q), 1.0) for q in large]
    assert refit == pytest.approx(committed, rel=2e-10)


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
    found = load_coefficient(LAWS["volumetric"], 1.0, float(ratio), 1.0, 0.0)
    assert 100.0 * (found / exact - 1.0) == pytest.approx(percent, abs=6e-3)


def test_the_constant_law_returns_its_constant():
    assert load_coefficient(LAWS["constant"], 1.0, 7.0, 1e11, 123.0) == 123.0


@pytest.mark.parametrize("law", CURVED)
@given(st.floats(1.0, 500.0), st.floats(1e-2, 1e4), st.floats(0.1, 10.0))
def test_coefficients_scale_with_size_and_modulus(law, ratio, small, factor):
    """Geometrically similar contacts: c ~ 1/sqrt(curvature), c ~ E*."""
    base = load_coefficient(LAWS[law], small, small * ratio, 1e11, 0.0)
    assert load_coefficient(LAWS[law], factor * small, factor * small * ratio, 1e11, 0.0) == pytest.approx(
        base / math.sqrt(factor), rel=1e-9
    )
    assert load_coefficient(LAWS[law], small, small * ratio, factor * 1e11, 0.0) == pytest.approx(
        factor * base, rel=1e-12
    )


@given(st.floats(-1e-3, 1e-3), st.floats(0.0, 1e-4))
def test_load_rises_with_approach_and_is_zero_for_a_gap(approach, more):
    load = elastic_load(2e10, approach)
    assert load >= 0.0
    assert load > 0.0 if approach > 1e-12 else load < 1e-7
    assert load == 0.0 or approach > 0.0
    assert elastic_load(2e10, approach + more) >= load


def test_energy_is_the_integral_of_the_load():
    work, _ = quad(lambda h: elastic_load(2e10, h), -1e-6, 5e-6, points=[0.0], epsabs=0.0, epsrel=1e-11)
    assert elastic_energy(2e10, 5e-6) == pytest.approx(work, rel=1e-9)
    assert elastic_energy(2e10, -1e-6) == 0.0


def test_viscous_term_vanishes_with_the_approach_and_never_pulls():
    """Paper 1, section 5: F_visc = -d(h) dh/dt with d(h) -> 0; as h^1.5 for one part and h^0.5 for the other."""
    rates = np.linspace(-20.0, 20.0, 41)
    for approach in (1e-12, 1e-9, 1e-6):
        elastic, stiffness = elastic_load(2e10, approach), elastic_stiffness(2e10, approach)
        assert stiffness == pytest.approx(1.5 * elastic / approach, rel=1e-12)
        for damping, relaxation, bound in ((0.2, 0.0, 0.2 * elastic), (0.0, 1e-6, 1e-6 * stiffness)):
            loads = np.array([damped_load(elastic, stiffness, rate, damping, relaxation) for rate in rates])
            assert np.all(loads >= 0.0)
            assert np.abs(loads - elastic).max() <= 20.0 * bound * (1.0 + 1e-12)
    assert damped_load(10.0, 0.0, -6.0, 0.2, 0.0) == 0.0
    assert elastic_stiffness(2e10, -1e-6) == 0.0


@given(st.tuples(*[st.floats(-10.0, 10.0)] * 3), st.floats(1e-6, 1.0))
def test_friction_opposes_slip_and_stays_in_its_cone(slip, regularisation):
    force = friction_factor(50.0, *slip, 0.1, regularisation) * np.linalg.norm(slip)
    assert 0.0 <= force <= 0.1 * 50.0 * (1.0 + 1e-12)
    if np.linalg.norm(slip) > 30.0 * regularisation:
        assert force > 0.999 * 5.0
