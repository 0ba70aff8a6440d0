"""Contact ellipses against SciPy's elliptic integrals, published tables and the limits of circle and line."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipe, ellipkm1

from bearing_twin.contact.ellipse import (
    CURVATURE_RATIO_MAX,
    axis_ratio,
    curvature_ratio,
    ellipse,
    elliptic_b_d,
    hertz_coefficient,
)
from bearing_twin.contact.materials import MATERIALS, Material, effective_modulus

STEEL_2_1 = Material(2.1e11, 0.3, 7850.0)


@pytest.mark.parametrize("kc", [1.0, 0.999, 0.7, 0.2, 1e-2, 1e-4, 1e-6])
def test_elliptic_integrals_agree_with_scipy(kc):
    b, d = elliptic_b_d(kc)
    assert b + d == pytest.approx(ellipkm1(kc * kc), rel=2e-15)
    assert b + kc * kc * d == pytest.approx(ellipe(1.0 - kc * kc), rel=2e-15)


# Complete-ellipse table: Q/P, long/short axis, K(m), E(m).
@pytest.mark.parametrize(
    ("ratio", "axes", "first", "second"),
    [
        (2.0, 1.58580, 1.95211, 1.29715),
        (5.0, 2.89018, 2.49374, 1.12052),
        (10.0, 4.49945, 2.91420, 1.05988),
        (100.0, 18.18710, 4.28950, 1.00573),
    ],
)
def test_axis_ratio_matches_the_published_table(ratio, axes, first, second):
    found = axis_ratio(1.0, ratio)
    b, d = elliptic_b_d(found)
    assert 1.0 / found == pytest.approx(axes, abs=6e-6)
    assert b + d == pytest.approx(first, abs=6e-6)
    assert b + found**2 * d == pytest.approx(second, abs=6e-6)


def test_equation_8_has_its_root_for_every_ratio():
    """Paper 1, Theorem 1: one eccentricity for every P/Q in (0, 1]; found to 1e-13 from circle to b/a = 1e-6."""
    for target in np.concatenate([1.0 + np.geomspace(1e-12, 1.0, 60), np.geomspace(2.0, CURVATURE_RATIO_MAX, 200)]):
        found = axis_ratio(1.0, target)
        assert 0.0 < found <= 1.0
        assert curvature_ratio(found) == pytest.approx(target, rel=1e-13)


def test_near_circle_follows_its_series():
    """b/a = (P/Q)^(2/3) to first order; the textbook form (E/(1-m) - K)/(K - E) is noise here."""
    for excess in (1e-4, 1e-6, 1e-8, 1e-10):
        assert 1.0 - axis_ratio(1.0, 1.0 + excess) == pytest.approx(2.0 / 3.0 * excess, rel=2e-4, abs=3e-16)


@pytest.mark.parametrize("pair", [(-1.0, 1.0), (2.0, 1.0), (0.0, 1.0), (math.nan, 1.0)])
def test_curvatures_that_make_no_ellipse_give_nan(pair):
    assert math.isnan(axis_ratio(*pair))
    assert math.isnan(hertz_coefficient(*pair, 1.0))


def test_circular_contact_is_hertz():
    load = hertz_coefficient(50.0, 50.0, effective_modulus(STEEL_2_1, STEEL_2_1)) * 1e-6**1.5
    assert load == pytest.approx(15.384615384615, rel=1e-12)


# Ball on raceway: ball diameter, pitch diameter, conformity, side, C of F = C h^1.5 at E = 207.5 GPa, b/a.
@pytest.mark.parametrize(
    ("ball", "pitch", "conformity", "side", "coefficient", "ratio"),
    [
        (6.746e-3, 28.5e-3, 0.515, -1, 2.589e10, 0.0883),
        (6.746e-3, 28.5e-3, 0.515, +1, 2.763e10, 0.1181),
        (6.746e-3, 28.5e-3, 0.52, -1, 2.338e10, 0.1043),
        (6.746e-3, 28.5e-3, 0.52, +1, 2.502e10, 0.1400),
        (7.94e-3, 39.04e-3, 0.52, -1, 2.551e10, 0.1071),
        (7.94e-3, 39.04e-3, 0.52, +1, 2.703e10, 0.1376),
    ],
)
def test_bearing_contacts_match_published_stiffness(ball, pitch, conformity, side, coefficient, ratio):
    radius = 0.5 * ball
    small = 0.5 * (1.0 / radius - 1.0 / (conformity * ball))
    large = 0.5 * (1.0 / radius - side / (0.5 * pitch + side * radius))
    modulus = effective_modulus(MATERIALS["steel"], MATERIALS["steel"])
    assert hertz_coefficient(small, large, modulus) == pytest.approx(coefficient, rel=2.5e-4)
    assert axis_ratio(small, large) == pytest.approx(ratio, abs=6e-5)


@given(st.floats(1.0, 1e6), st.floats(1e-3, 1e5), st.floats(1e8, 1e12), st.floats(1e-3, 1e5))
def test_ellipse_satisfies_hertz_equations(ratio, small, modulus, load):
    """Load, approach and curvatures agree through the pressure: F = 2/3 p a b pi, P = p b D/(E* a^2)."""
    found = ellipse(small, small * ratio, modulus, load)
    _, d = elliptic_b_d(found.semi_minor / found.semi_major)
    assert 2.0 / 3.0 * found.peak_pressure * math.pi * found.semi_major * found.semi_minor == pytest.approx(load)
    assert found.peak_pressure * found.semi_minor * d / (modulus * found.semi_major**2) == pytest.approx(small)


def test_no_load_no_ellipse():
    assert ellipse(1.0, 2.0, 1e11, 0.0) == (0.0, 0.0, 0.0)
