"""Number of modes: none invented in one-mode samples, clear ones found, the critical bandwidth is critical."""

import math

import numpy as np
import pytest

from bearing_twin.base.errors import StatisticError
from bearing_twin.uq.statistics import binned, critical_bandwidth, modality, mode_indices, smoothed

ONE_MODE = {
    "gamma": lambda rng, n: rng.gamma(32.4, 1.0, n),
    "exponential": lambda rng, n: rng.exponential(1.0, n),
    "lognormal": lambda rng, n: rng.lognormal(0.0, 0.8, n),
    "normal": lambda rng, n: rng.normal(size=n),
    "uniform": lambda rng, n: rng.random(n),
    "student": lambda rng, n: rng.standard_t(3, n),
}


@pytest.mark.parametrize("name", sorted(ONE_MODE))
def test_one_mode_samples_are_not_taken_for_two(name):
    results = [modality(ONE_MODE[name](np.random.default_rng(seed), 600), seed, 100) for seed in range(4)]
    assert sum(result.modes > 1 for result in results) <= 1


@pytest.mark.parametrize(("centers", "share"), [((-2.0, 2.0), 0.5), ((-2.0, 2.0), 0.3), ((-4.0, 0.0, 4.0), 1 / 3)])
def test_clear_mixtures_show_their_modes_whatever_the_unit_and_stray_values(centers, share):
    results = []
    for seed in (1, 2):
        rng = np.random.default_rng(seed)
        chance = [share, 1.0 - share] if len(centers) == 2 else None
        sample = rng.choice(centers, 2000, p=chance) + rng.normal(size=2000)
        results.append(modality(sample, seed, 100))
        assert results[-1].modes == len(centers)
        assert results[-1].p_value < 0.05 < results[-1].p_values[-1]
        assert len(results[-1].p_values) == len(centers)
        assert results[-1].positions == pytest.approx(centers, abs=0.6)
    assert results[-1] == modality(np.append(sample, np.nan), 2, 100)
    scaled = modality(1e-5 * (sample + 10.0), 2, 100)
    assert (scaled.modes, scaled.p_values) == (results[-1].modes, results[-1].p_values)
    assert modality(np.append(sample, [1e6, -1e9]), 2, 100).modes == len(centers)


def test_the_critical_bandwidth_is_where_a_mode_disappears():
    sample = np.random.default_rng(1).gamma(3.0, 1.0, 500)
    counts = binned(sample, 0.0, sample.max() + 1.0, 2048)
    for modes in (1, 2, 3):
        critical = critical_bandwidth(counts, modes)
        assert len(mode_indices(smoothed(counts, critical))) <= modes
        assert len(mode_indices(smoothed(counts, 0.999 * critical))) > modes
    # two equal normals of deviation s, 2 d apart: one mode once s^2 + h^2 >= d^2
    x = np.arange(2048) - 1023.5
    pair = np.exp(-0.5 * ((x - 200.0) / 50.0) ** 2) + np.exp(-0.5 * ((x + 200.0) / 50.0) ** 2)
    assert critical_bandwidth(pair, 1) == pytest.approx(math.sqrt(200.0**2 - 50.0**2), rel=2e-3)


def test_equal_values_and_few_samples_have_no_modes():
    """A force that is exactly 0 in some realisations has no density there."""
    force = np.append(np.zeros(40), np.random.default_rng(3).normal(5.0, 1.0, 960))
    for equal in (force, np.zeros(500), [3.0] * 30, np.repeat(np.arange(5.0), 40)):
        with pytest.raises(StatisticError, match="exactly"):
            modality(equal)
    assert modality(force[36:]).modes == 1
    with pytest.raises(StatisticError, match="19 samples are too few"):
        modality([*range(19), np.nan])
