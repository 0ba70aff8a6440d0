"""A change of variable of a few runs: exact for smooth ones, quiet about noise, honest about kinks."""

import numpy as np
import pytest
from scipy import stats

from bearing_twin.base.errors import StudyError
from bearing_twin.uq.inputs import read_input
from bearing_twin.uq.propagation import LADDER, interpolate, through

MODULUS = read_input("E", {"distribution": "gamma", "mean": 1.0, "std": 0.2})


def test_smooth_functions_take_few_runs_and_are_exact():
    asked = []

    def function(x):
        asked.append(len(x))
        return x**-0.5

    found = interpolate(MODULUS, function)
    assert sum(asked) == len(found.values) in LADDER
    truth = stats.gamma(25.0, scale=0.04)
    assert found.derived.quantile(0.05) == pytest.approx(truth.ppf(0.95) ** -0.5, rel=1e-5)
    assert found.derived.mean == pytest.approx(truth.expect(lambda x: x**-0.5), rel=1e-5)
    assert found.derived.pdf(1.1) == pytest.approx(truth.pdf(1.1**-2) * 2.0 * 1.1**-3, rel=1e-3)
    assert found.error < 1e-4
    again = through(MODULUS, found.at, found.values)(np.array([0.7, 1.0, 1.3]))
    assert again == pytest.approx(np.array([0.7, 1.0, 1.3]) ** -0.5, rel=1e-4)


def test_noise_of_runs_is_told_and_not_followed():
    noise = np.random.default_rng(1)
    found = interpolate(MODULUS, lambda x: np.sqrt(x) + 2e-3 * noise.standard_normal(len(x)))
    assert len(found.values) == LADDER[-1]
    assert found.error == pytest.approx(0.02, rel=0.5)  # of a deviation of 0.1
    heights = found.derived.pdf(np.linspace(0.7, 1.3, 200))
    assert np.sum((heights[1:-1] > heights[:-2]) & (heights[1:-1] > heights[2:])) == 1


def test_kinks_are_told_and_jumps_back_refused():
    assert interpolate(MODULUS, lambda x: x + 3.0 * np.maximum(x - 1.0, 0.0)).error > 0.005
    with pytest.raises(StudyError, match="not a monotone function of E; choose the method ensemble"):
        interpolate(MODULUS, lambda x: (x - 1.0) ** 2)


def test_a_run_that_fails_far_out_brings_the_points_nearer():
    far = MODULUS.ppf(2e-4)
    found = interpolate(MODULUS, lambda x: np.where(x < far, np.nan, x))
    assert found.left_out == pytest.approx(2.0 * stats.norm.cdf(-3.0))
    with pytest.raises(StudyError, match=r"the run at E = 0\.5\d* fails"):
        interpolate(MODULUS, lambda x: np.where(x < 0.7, np.nan, x))
