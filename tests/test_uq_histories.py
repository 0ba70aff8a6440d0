"""Ensembles of force histories: bands, density over time, autocorrelation, correlation with the inputs."""

import tracemalloc

import numpy as np
import pytest
from scipy import stats

from bearing_twin.base.errors import StatisticError
from bearing_twin.contact import hertz_impact as impact
from bearing_twin.uq.histories import Histories, narrowing
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
    one = Histories(TIMES, force, alpha)
    assert one.count == count
    assert one.mean == pytest.approx(force.mean(axis=0), rel=1e-12)
    assert one.std == pytest.approx(force.std(axis=0, ddof=1), rel=1e-9)
    moving = force.std(axis=0) > 0.0
    assert one.skewness[moving] == pytest.approx(stats.skew(force[:, moving]), rel=1e-6, abs=1e-9)
    assert not one.skewness[~moving].any()
    correlation = one.autocorrelation()
    assert correlation[np.ix_(moving, moving)] == pytest.approx(np.corrcoef(force[:, moving].T), abs=1e-9)
    assert np.isnan(correlation[0]).all()
    both = np.corrcoef(np.column_stack([alpha, force[:, moving]]).T)
    assert one.input_correlation()[0, moving] == pytest.approx(both[0, 1:], abs=1e-9)
    assert np.array_equal(one.quantiles(), np.quantile(force, [0.05, 0.5, 0.95], 0, method="median_unbiased"))


def test_the_mean_of_the_runs_is_not_the_run_at_the_mean():
    force, _ = forces()
    found = Histories(TIMES, force)
    nominal = impact.force_history(TIMES, impact.coefficient_of_alpha(1.138e-4, MASS), MASS, 20.0)
    assert np.max(np.abs(found.mean - nominal)) > 0.1 * nominal.max()
    low, middle, high = found.quantiles()
    assert np.all((low <= middle) & (middle <= high))
    assert np.all(low >= 0.0)
    assert np.any(found.mean - found.std < 0.0)  # the band of paper 3's figure 17 that no force can have


def test_the_correlation_with_alpha_changes_its_sign_during_the_contact():
    """A stiffer pair meets harder and parts sooner: at first less alpha is more force, at last none."""
    force, alpha = forces(std=1e-5)
    found = Histories(TIMES, force, alpha)
    correlation = found.input_correlation()[0]
    duration = 1.138e-4 * 20.0**-0.2
    early, late = (int(share * duration / TIMES[1]) for share in (0.2, 0.85))
    assert correlation[early] < -0.95
    assert correlation[late] > 0.95
    # with the sign changes the deviation has a minimum, and the force is anticorrelated with itself
    spread = found.std[early : late + 1]
    assert spread.min() < 0.5 * min(spread[0], spread[-1])
    assert found.autocorrelation()[early, late] < -0.9


def test_density_over_time_has_mass_one_and_follows_the_samples():
    force, _ = forces()
    found = Histories(TIMES, force)
    levels, density = found.density(150, low=0.0)
    width = levels[1] - levels[0]
    assert levels[0] > 0.0
    assert density.shape == (71, 150)
    assert density.sum(axis=1) * width == pytest.approx(np.ones(71))
    assert np.all(density >= 0.0)
    assert density @ levels * width == pytest.approx(force.mean(axis=0), abs=2.0 * width)
    assert np.argmax(density[0]) == 0


def test_quantiles_are_those_of_all_histories():
    """Of the first 4096 of 20000 alone they would be those of 0."""
    force = np.repeat(np.where(np.arange(20_000) < 5000, 0.0, np.arange(20_000))[:, None], 9, axis=1)
    found = Histories(np.arange(9.0), force)
    assert found.quantiles((0.5,))[0] == pytest.approx(np.full(9, 9999.5))
    assert found.density(20)[1][0] @ np.ones(20) * 1100.0 == pytest.approx(1.0, rel=0.01)
    with pytest.raises(StatisticError, match="choose a coarser time grid"):
        Histories(np.arange(5000.0), np.zeros((1, 5000)))


def test_little_memory_is_taken_beside_the_histories():
    """200 000 realisations of 8 instants are 12.8 MB; their statistics may take four times as much."""
    histories = np.random.default_rng(1).standard_normal((200_000, 8)) * [0.1, 2.0, 3.0, 2.0, 1.0, 2.0, 2.0, 0.1]
    histories += [0.0, 8.0, 9.0, 8.0, 7.0, 6.0, 5.0, 0.0]
    tracemalloc.start()
    found = Histories(np.arange(8.0), histories)
    assert found.quantiles().shape == (3, 8)
    assert 3.5 < narrowing(found.times, found.whole).time < 4.5
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4.0 * histories.nbytes


def test_failed_and_missing_histories():
    force, alpha = forces(50)
    force[::5, 3] = np.nan
    found = Histories(TIMES, force, alpha)
    assert found.count == 40
    good = np.arange(50) % 5 > 0
    assert np.array_equal(
        found.input_correlation(), Histories(TIMES, force[good], alpha[good]).input_correlation(), True
    )
    empty = Histories(TIMES, force[:0])
    asks = (lambda: empty.mean, lambda: empty.std, lambda: empty.skewness)
    for ask in (*asks, empty.quantiles, empty.autocorrelation, empty.density):
        with pytest.raises(StatisticError, match="samples at least, there are 0"):
            ask()
    with pytest.raises(ValueError, match="as many rows of inputs"):
        Histories(TIMES, force, alpha[:3])
    same = Histories(TIMES, np.ones((3, 71)))
    assert np.isnan(same.autocorrelation()).all()
    with pytest.raises(StatisticError, match="all histories are equal"):
        same.density()
