"""Ensembles of force histories: bands, autocorrelation, correlation with the inputs, and where they come together."""

import tracemalloc

import numpy as np
import pytest
from scipy import stats

from bearing_twin.contact import hertz_impact as impact
from bearing_twin.uq.inputs import read_input
from bearing_twin.uq.sampling import UnitPoints
from bearing_twin.uq.statistics import HISTORY_PROBABILITIES, history_statistics

TIMES = np.linspace(0.0, 1.4e-4, 71)
MASS = 0.5 * 0.2258


def forces(count=1500, std=4e-5, seed=3):
    """Force histories (n, t) of the steel balls of paper 3 and their alpha (n, 1)."""
    source = read_input("alpha", {"distribution": "gamma", "mean": 1.138e-4, "std": std})
    alpha = source.ppf(UnitPoints("random", 1, seed, count).chunk(0, count))
    return impact.force_history(TIMES, impact.coefficient_of_alpha(alpha, MASS), MASS, 20.0), alpha


@pytest.mark.parametrize("count", [3, 1500])
def test_statistics_in_pieces_are_those_of_the_whole(count):
    force, alpha = forces(count)
    statistics = history_statistics(force, alpha, ["alpha"])
    assert statistics["mean"] == pytest.approx(force.mean(axis=0), rel=1e-12)
    assert statistics["std"] == pytest.approx(force.std(axis=0, ddof=1), rel=1e-9)
    moving, rows = force.std(axis=0) > 0.0, statistics["rows"]
    assert statistics["skewness"][moving] == pytest.approx(stats.skew(force[:, moving]), rel=1e-6, abs=1e-9)
    moved = moving[rows]
    expected = np.corrcoef(force[:, rows[moved]].T)
    assert statistics["autocorrelation"][np.ix_(moved, moved)] == pytest.approx(expected, abs=1e-9)
    correlations = np.corrcoef(np.column_stack([alpha, force[:, moving]]).T)
    assert statistics["correlation with alpha"][moving] == pytest.approx(correlations[0, 1:], abs=1e-9)
    for p in HISTORY_PROBABILITIES:
        assert np.array_equal(statistics[f"{p:.2f}"], np.quantile(force, p, 0, method="median_unbiased"))
    for constant in (
        statistics["skewness"][~moving],
        statistics["autocorrelation"][0],
        statistics["correlation with alpha"][~moving],
    ):
        assert not constant.any()


def test_the_correlation_with_alpha_changes_its_sign_during_the_contact():
    """A stiffer pair meets harder and parts sooner: at first less alpha is more force, at last none."""
    statistics = history_statistics(*forces(std=1e-5), ["alpha"])
    duration = 1.138e-4 * 20.0**-0.2
    early, late = (int(share * duration / TIMES[1]) for share in (0.2, 0.85))
    assert statistics["correlation with alpha"][early] < -0.95
    assert statistics["correlation with alpha"][late] > 0.95
    # with the sign changes the deviation has a minimum, and the force is anticorrelated with itself
    spread = statistics["std"][early : late + 1]
    assert spread.min() < 0.5 * min(spread[0], spread[-1])
    first, last = (int(np.argmin(np.abs(statistics["rows"] - index))) for index in (early, late))
    assert statistics["autocorrelation"][first, last] < -0.9


def test_little_memory_is_taken_beside_the_histories():
    """100 000 realisations of 8 instants are 6.4 MB; their statistics may take four times as much."""
    histories = np.random.default_rng(1).standard_normal((100_000, 8)) * [0.1, 2.0, 3.0, 2.0, 1.0, 2.0, 2.0, 0.1]
    histories += [0.0, 8.0, 9.0, 8.0, 7.0, 6.0, 5.0, 0.0]
    inputs = np.empty((100_000, 0))
    tracemalloc.start()
    assert history_statistics(histories, inputs, [])["0.95"].shape == (8,)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5.0 * histories.nbytes
