"""Ensembles of force histories: bands, density over time, autocorrelation, correlation with the inputs."""

import tracemalloc

import numpy as np
import pytest
from scipy import stats

from bearing_twin.base.errors import StatisticError
from bearing_twin.contact import hertz_impact as impact
from bearing_twin.uq.histories import FEWEST, PROBABILITIES, history_statistics, narrowing
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


# The instant at which histories come together after their peak, on histories whose instant is known.

SHARES = np.linspace(0.0, 1.0, 201)


def narrowed(times, histories, seed=0, inputs=None):
    """Of histories whose inputs do not matter."""
    return narrowing(times, histories, np.empty((len(histories), 0)) if inputs is None else inputs, seed)


def waves(count, seed):
    """A pulse and a random share of a wave that is zero at 0.603; a little noise of its own in each."""
    random = np.random.default_rng(seed)
    wave = np.sin(np.pi * (SHARES - 0.603) / 0.8)
    own = 0.02 * random.standard_normal((count, 1)) * np.cos(3.0 * SHARES)
    return np.sin(np.pi * SHARES) + 0.3 * random.standard_normal((count, 1)) * wave + own


def test_the_instant_and_its_interval():
    found = narrowed(SHARES, waves(800, 1))
    assert found.time == pytest.approx(0.603, abs=0.01)
    assert found.low <= found.time <= found.high
    assert found.high - found.low < 0.02
    assert found.mean == pytest.approx(np.sin(0.6 * np.pi), abs=0.01)
    assert found.std < 0.03
    assert found.modes == 1
    assert found == narrowed(SHARES, waves(800, 1))


def test_the_interval_covers():
    """Of 40 studies 34 at least: a binomial with 95 % gives fewer once in 300."""
    fine = np.linspace(0.59, 0.61, 2001)
    truth = fine[np.argmin((0.3 * np.sin(np.pi * (fine - 0.603) / 0.8)) ** 2 + (0.02 * np.cos(3.0 * fine)) ** 2)]
    hits = 0
    for seed in range(40):
        found = narrowed(SHARES, waves(300, seed), seed)
        low, high = found.low, found.high
        hits += low <= truth <= high
    assert hits >= 34


def test_where_there_is_none_it_says_so():
    with pytest.raises(StatisticError, match="at least"):
        narrowed(SHARES, waves(FEWEST - 1, 3))
    growing = np.sin(np.pi * SHARES) * (1.0 + np.random.default_rng(4).standard_normal((100, 1)) * SHARES**2)
    with pytest.raises(StatisticError, match="no instant"):
        narrowed(SHARES, growing)


def test_where_the_correlation_changes_its_sign():
    """With the share of the wave at its zero, 0.603; what else varies moves the least deviation, not that."""
    random = np.random.default_rng(5)
    share, other = random.standard_normal((2, 900, 1))
    wave = np.sin(np.pi * (SHARES - 0.603) / 0.8)
    values = np.sin(np.pi * SHARES) + 0.3 * share * wave + 0.2 * other * SHARES**2
    inputs = np.hstack([share, other])
    slope = 0.3 * np.pi / 0.8
    earlier = 2.0 * 0.2**2 * 0.603**3 / slope**2  # of the least: b b' + r r' = 0, by its first terms
    found = narrowed(SHARES, values, 1, inputs)
    assert found.signs[0].time == pytest.approx(0.603, abs=0.01)
    assert found.signs[0].later == pytest.approx(earlier, rel=0.25)
    assert 0.0 < found.signs[0].low < found.signs[0].later < found.signs[0].high < 2.0 * earlier
    assert found.signs[1] is None or abs(found.signs[1].later) > 0.1
    assert narrowed(SHARES, values, 1)[:-1] == found[:-1]


def test_where_a_tenth_of_the_resamples_has_none_it_says_so():
    """The least deviation of three instants is hardly less than its neighbours'."""
    random = np.random.default_rng(3)
    some = np.array([3.0, 2.0, 1.5]) + np.array([1.0, 0.85, 1.0]) * random.standard_normal((200, 3))
    assert some.std(axis=0)[1] < some.std(axis=0)[[0, 2]].min()
    with pytest.raises(StatisticError, match="no instant"):
        narrowed(np.arange(3.0), some)
