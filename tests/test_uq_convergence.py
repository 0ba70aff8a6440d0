"""Paths of mean and deviation, and the bands they keep to."""

import numpy as np
import pytest

from bearing_twin.errors import StatisticError
from bearing_twin.uq.inputs import read_input
from bearing_twin.uq.propagation import derive
from bearing_twin.uq.statistics import half_widths, paths


def gamma(std):
    return derive(read_input("x", {"distribution": "gamma", "mean": 1.138e-4, "std": std}), lambda x: x * 20.0**-0.2)


def test_a_path_is_mean_and_deviation_of_the_first_samples():
    samples = 1e6 + np.random.default_rng(1).normal(size=(3, 50))
    found = paths(samples)
    assert found.counts.tolist() == list(range(2, 51))
    for place, count in enumerate(found.counts):
        assert found.mean[:, place] == pytest.approx(samples[:, :count].mean(axis=1), rel=1e-14)
        assert found.std[:, place] == pytest.approx(samples[:, :count].std(axis=1, ddof=1), rel=1e-9)


@pytest.mark.parametrize("samples", [[1.0], 3.0, [1.0, np.nan, 2.0]])
def test_what_has_no_path_is_refused(samples):
    with pytest.raises(StatisticError, match="2 finite samples"):
        paths(samples)


def test_kurtosis_of_a_gamma_is_3_and_6_over_its_shape():
    for std in (2e-5, 4e-5, 6e-5):
        assert gamma(std).kurtosis == pytest.approx(3.0 + 6.0 * (std / 1.138e-4) ** 2, rel=1e-8)


def test_the_band_of_the_deviation_has_the_published_width():
    exact = gamma(6e-5)
    widths = half_widths(exact, [700, 2000], confidence=0.6826894921370859)  # one standard error
    assert exact.kurtosis == pytest.approx(4.668, abs=5e-4)
    assert widths.std / exact.std == pytest.approx([0.0362, 0.0214], abs=5e-5)
    assert widths.mean == pytest.approx(exact.std / np.sqrt([700, 2000]), rel=1e-9)


def test_the_bands_hold_the_share_they_promise():
    exact, rng = gamma(6e-5), np.random.default_rng(2)
    found = paths(exact.quantile(rng.random((400, 1000))))
    widths = half_widths(exact, found.counts[-1], 0.9)
    for error, width in ((found.mean[:, -1] - exact.mean, widths.mean), (found.std[:, -1] - exact.std, widths.std)):
        assert 0.85 < np.mean(np.abs(error) < width) < 0.95  # three standard errors of a share of 400 either side


def test_a_band_needs_the_moment_it_rests_on():
    heavy = derive(read_input("x", {"distribution": "gamma", "mean": 1.0, "std": 1.0}), lambda x: x**-0.3)
    assert np.isfinite(heavy.std)
    with pytest.raises(StatisticError, match="the kurtosis does not exist"):
        half_widths(heavy, 100)
