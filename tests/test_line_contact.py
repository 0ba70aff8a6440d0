"""Line contact: paper 3, eq. (14), and Johnson's two-dimensional law, forwards, backwards and at their ends."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import lambertw

from bearing_twin.contact import line
from bearing_twin.contact.laws import line_law
from bearing_twin.contact.names import law_names

DISC = (1.0, 2.0, 5e9, 0.3)  # radius, thickness, Young's modulus, Poisson's ratio of paper 3, section 5.1


def printed(name, load, radius, thickness, modulus, ratio):
    """The approach as the books print it."""
    compliance, half = (1.0 - ratio**2) / (math.pi * modulus), 0.5 * thickness
    if name == "line":
        return load * compliance / half * (1.0 + math.log(8.0 * half**3 / (compliance * load * radius)))
    return load * compliance / half * (math.log(8.0 * half * radius / (compliance * load)) - 1.0)


@settings(deadline=None)
@given(st.floats(-690.0, -1.001))
def test_lambert_branch_solves_its_equation(w):
    assert line.lambert_lower(w * math.exp(w)) == pytest.approx(w, rel=1e-12 * (1.0 + 1e3 / abs(w + 1.0) ** 2 * 1e-3))


def test_lambert_branch_agrees_with_scipy_and_ends_where_it_ends():
    x = -np.concatenate([np.geomspace(1e-300, 0.1, 300), np.linspace(0.1, 0.3678, 300)])
    assert [line.lambert_lower(one) for one in x] == pytest.approx(list(lambertw(x, -1).real), rel=1e-12)
    assert line.lambert_lower(-1.0 / math.e) == pytest.approx(-1.0, abs=1e-7)
    assert math.isnan(line.lambert_lower(-0.4))
    assert math.isnan(line.lambert_lower(0.1))


@pytest.mark.parametrize("name", law_names("line", ()))
@settings(deadline=None)
@given(st.floats(1e-6, 0.99))
def test_load_inverts_the_printed_equation(name, share):
    """Paper 3, eq. (14), which the paper thought "very hard, if not impossible" to invert."""
    law = line_law(name, *DISC)
    approach = share * line.deepest(law)
    load = line.load(law, approach)
    assert printed(name, load, *DISC) == pytest.approx(approach, rel=1e-12)
    assert line.approach_of(law, load) == pytest.approx(approach, rel=1e-12)


@pytest.mark.parametrize("name", law_names("line", ()))
def test_energy_is_the_integral_of_the_load_and_can_be_inverted(name):
    law = line_law(name, *DISC)
    for share in (1e-4, 0.02, 0.3, 0.9):
        approach = share * line.deepest(law)
        work, _ = quad(lambda x, law=law: line.load(law, x), 0.0, approach, epsabs=0.0, epsrel=1e-11)
        stored = line.energy(law, line.load(law, approach))
        assert stored == pytest.approx(work, rel=1e-9)
        assert line.load_of_energy(law, stored) == pytest.approx(line.load(law, approach), rel=1e-12)


@pytest.mark.parametrize("name", law_names("line", ()))
def test_no_load_belongs_to_more_than_the_deepest_approach(name):
    law = line_law(name, *DISC)
    expected = 8.0 * 1.0**2 / 1.0 if name == "line" else 8.0 / math.e**2
    assert line.deepest(law) == pytest.approx(expected, rel=1e-12)
    assert math.isfinite(line.load(law, 0.999 * expected))
    assert math.isnan(line.load(law, 1.001 * expected))
    assert math.isnan(line.load_of_energy(law, 1.001 * line.greatest_energy(law)))
    assert line.load_of_energy(law, 0.999 * line.greatest_energy(law)) > 0.0


@pytest.mark.parametrize("name", law_names("line", ()))
def test_a_gap_bears_nothing_and_the_compiled_numbers_are_the_plain_ones(name):
    law = line_law(name, *DISC)
    assert line.load(law, -1e-3) == line.load(law, 0.0) == line.energy(law, 0.0) == 0.0
    assert line.approach_of(law, 0.0) == line.load_of_energy(law, 0.0) == 0.0
    for approach in (1e-6, 1e-3, 0.5):
        assert line.load.py_func(law, approach) == pytest.approx(line.load(law, approach), rel=1e-15)
