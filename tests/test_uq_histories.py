"""Ensembles of force histories: bands, density over time, autocorrelation, correlation with the inputs."""

import tracemalloc

import numpy as np
import pytest
from scipy import stats

from bearing_twin.contact import hertz_impact as impact
from bearing_twin.uq.histories import PROBABILITIES, history_statistics, narrowing
from bearing_twin.uq.inputs import read_input
from bearing_twin.uq.sampling import UnitPoints

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
    one = history_statistics(force, alpha)
    assert one.mean == pytest.approx(force.mean(axis=0), rel=1e-12)
    assert one.std == pytest.approx(force.std(axis=0, ddof=1), rel=1e-9)
    moving = force.std(axis=0) > 0.0
    assert one.skewness[moving] == pytest.approx(stats.skew(force[:, moving]), rel=1e-6, abs=1e-9)
    assert not one.skewness[~moving].any()
    rows = moving[one.rows]
    expected = np.corrcoef(force[:, one.rows[rows]].T)
    assert one.autocorrelation[np.ix_(rows, rows)] == pytest.approx(expected, abs=1e-9)
    assert not one.autocorrelation[0].any()
    both = np.corrcoef(np.column_stack([alpha, force[:, moving]]).T)
    assert one.correlation[0, moving] == pytest.approx(both[0, 1:], abs=1e-9)
    assert np.array_equal(one.quantiles, np.quantile(force, PROBABILITIES, 0, method="median_unbiased"))


def test_the_mean_of_the_runs_is_not_the_run_at_the_mean():
    found = history_statistics(*forces())
    nominal = impact.force_history(TIMES, impact.coefficient_of_alpha(1.138e-4, MASS), MASS, 20.0)
    assert np.max(np.abs(found.mean - nominal)) > 0.1 * nominal.max()
    low, middle, high = found.quantiles
    assert np.all((low <= middle) & (middle <= high))
    assert np.all(low >= 0.0)
    assert np.any(found.mean - found.std < 0.0)  # the band of paper 3's figure 17 that no force can have


def test_the_correlation_with_alpha_changes_its_sign_during_the_contact():
    """A stiffer pair meets harder and parts sooner: at first less alpha is more force, at last none."""
    found = history_statistics(*forces(std=1e-5))
    duration = 1.138e-4 * 20.0**-0.2
    early, late = (int(share * duration / TIMES[1]) for share in (0.2, 0.85))
    assert found.correlation[0, early] < -0.95
    assert found.correlation[0, late] > 0.95
    # with the sign changes the deviation has a minimum, and the force is anticorrelated with itself
    spread = found.std[early : late + 1]
    assert spread.min() < 0.5 * min(spread[0], spread[-1])
    first, last = (int(np.argmin(np.abs(found.rows - one))) for one in (early, late))
    assert found.autocorrelation[first, last] < -0.9


def test_little_memory_is_taken_beside_the_histories():
    """200 000 realisations of 8 instants are 12.8 MB; their statistics may take four times as much."""
    histories = np.random.default_rng(1).standard_normal((200_000, 8)) * [0.1, 2.0, 3.0, 2.0, 1.0, 2.0, 2.0, 0.1]
    histories += [0.0, 8.0, 9.0, 8.0, 7.0, 6.0, 5.0, 0.0]
    inputs = np.empty((200_000, 0))
    tracemalloc.start()
    found = history_statistics(histories, inputs)
    assert found.quantiles.shape == (3, 8)
    assert 3.5 < narrowing(np.arange(8.0), histories, inputs).time < 4.5
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4.0 * histories.nbytes


def test_histories_that_do_not_differ_have_no_correlation():
    same = history_statistics(np.ones((3, 71)), np.ones((3, 1)))
    assert not same.autocorrelation.any()
    assert not same.correlation.any()
    assert not same.skewness.any()
