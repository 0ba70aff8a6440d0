"""Ensembles of force histories: bands, autocorrelation, correlation with the inputs, and where they come together."""

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
SHARES = np.linspace(0.0, 1.0, 201)
WAVE = np.sin(np.pi * (SHARES - 0.603) / 0.8)


def forces(count=1500, std=4e-5, seed=3):
    """Force histories (n, t) of the steel balls of paper 3 and their alpha (n, 1)."""
    source = read_input("alpha", {"distribution": "gamma", "mean": 1.138e-4, "std": std})
    alpha = source.ppf(UnitPoints("random", 1, seed, count).chunk(0, count))
    return impact.force_history(TIMES, impact.coefficient_of_alpha(alpha, MASS), MASS, 20.0), alpha


@pytest.mark.parametrize("count", [3, 1500])
def test_statistics_in_pieces_are_those_of_the_whole(count):
    force, alpha = forces(count)
    one = history_statistics(force, alpha, ["alpha"])
    assert one["mean"] == pytest.approx(force.mean(axis=0), rel=1e-12)
    assert one["std"] == pytest.approx(force.std(axis=0, ddof=1), rel=1e-9)
    moving, rows = force.std(axis=0) > 0.0, one["rows"]
    assert one["skewness"][moving] == pytest.approx(stats.skew(force[:, moving]), rel=1e-6, abs=1e-9)
    moved = moving[rows]
    expected = np.corrcoef(force[:, rows[moved]].T)
    assert one["autocorrelation"][np.ix_(moved, moved)] == pytest.approx(expected, abs=1e-9)
    both = np.corrcoef(np.column_stack([alpha, force[:, moving]]).T)
    assert one["correlation with alpha"][moving] == pytest.approx(both[0, 1:], abs=1e-9)
    for p in PROBABILITIES:
        assert np.array_equal(one[f"{p:.2f}"], np.quantile(force, p, 0, method="median_unbiased"))
    for still in (one["skewness"][~moving], one["autocorrelation"][0], one["correlation with alpha"][~moving]):
        assert not still.any()


def test_the_correlation_with_alpha_changes_its_sign_during_the_contact():
    """A stiffer pair meets harder and parts sooner: at first less alpha is more force, at last none."""
    found = history_statistics(*forces(std=1e-5), ["alpha"])
    duration = 1.138e-4 * 20.0**-0.2
    early, late = (int(share * duration / TIMES[1]) for share in (0.2, 0.85))
    assert found["correlation with alpha"][early] < -0.95
    assert found["correlation with alpha"][late] > 0.95
    # with the sign changes the deviation has a minimum, and the force is anticorrelated with itself
    spread = found["std"][early : late + 1]
    assert spread.min() < 0.5 * min(spread[0], spread[-1])
    first, last = (int(np.argmin(np.abs(found["rows"] - one))) for one in (early, late))
    assert found["autocorrelation"][first, last] < -0.9


def test_little_memory_is_taken_beside_the_histories():
    """100 000 realisations of 8 instants are 6.4 MB; their statistics may take four times as much."""
    histories = np.random.default_rng(1).standard_normal((100_000, 8)) * [0.1, 2.0, 3.0, 2.0, 1.0, 2.0, 2.0, 0.1]
    histories += [0.0, 8.0, 9.0, 8.0, 7.0, 6.0, 5.0, 0.0]
    inputs = np.empty((100_000, 0))
    tracemalloc.start()
    assert history_statistics(histories, inputs, [])["0.95"].shape == (8,)
    assert 3.5 < narrowing(np.arange(8.0), histories, inputs, [])["time_s"] < 4.5
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5.0 * histories.nbytes


def waves(count, seed):
    """A pulse and a random share of a wave that is zero at 0.603; a little noise of its own in each."""
    random = np.random.default_rng(seed)
    own = 0.02 * random.standard_normal((count, 1)) * np.cos(3.0 * SHARES)
    return np.sin(np.pi * SHARES) + 0.3 * random.standard_normal((count, 1)) * WAVE + own


def narrowed(histories, seed=0):
    return narrowing(SHARES, histories, np.empty((len(histories), 0)), [], seed)


def test_the_instant_of_least_deviation_and_its_interval():
    """Of 20 studies 16 at least hold the true instant: a binomial with 95 % gives fewer once in 380."""
    fine = np.linspace(0.59, 0.61, 2001)
    truth = fine[np.argmin((0.3 * np.sin(np.pi * (fine - 0.603) / 0.8)) ** 2 + (0.02 * np.cos(3.0 * fine)) ** 2)]
    found = [narrowed(waves(300, seed), seed) for seed in range(20)]
    assert sum(one["interval_s"][0] <= truth <= one["interval_s"][1] for one in found) >= 16
    assert found[3] == narrowed(waves(300, 3), 3)
    for one in found:
        assert one["time_s"] == pytest.approx(0.603, abs=0.01)
        assert one["interval_s"][1] - one["interval_s"][0] < 0.03
        assert one["mean"] == pytest.approx(np.sin(0.6 * np.pi), abs=0.01)
        assert one["std"] < 0.03
    assert sum(one["modes"] == 1 for one in found) >= 18


def test_where_there_is_none_it_says_so():
    """Among them three instants of which a tenth of the resamples has no least deviation in the middle."""
    random = np.random.default_rng(3)
    some = np.array([3.0, 2.0, 1.5]) + np.array([1.0, 0.85, 1.0]) * random.standard_normal((200, 3))
    assert some.std(axis=0)[1] < some.std(axis=0)[[0, 2]].min()
    growing = np.sin(np.pi * SHARES) * (1.0 + np.random.default_rng(4).standard_normal((100, 1)) * SHARES**2)
    for times, histories, words in (
        (SHARES, waves(FEWEST - 1, 3), "at least"),
        (SHARES, growing, "no instant"),
        (np.arange(3.0), some, "no instant"),
    ):
        with pytest.raises(StatisticError, match=words):
            narrowing(times, histories, np.empty((len(histories), 0)), [])


def test_where_the_correlation_changes_its_sign():
    """With the share of the wave at its zero, 0.603; what else varies moves the least deviation, not that."""
    share, other = np.random.default_rng(5).standard_normal((2, 900, 1))
    values = np.sin(np.pi * SHARES) + 0.3 * share * WAVE + 0.2 * other * SHARES**2
    slope = 0.3 * np.pi / 0.8
    earlier = 2.0 * 0.2**2 * 0.603**3 / slope**2  # of the least: b b' + r r' = 0, by its first terms
    found = narrowing(SHARES, values, np.hstack([share, other]), ["share", "other"], 1)
    signs = found.pop("sign_changes")
    low, high = signs["share"]["interval_s"]
    assert signs["share"]["time_s"] == pytest.approx(0.603, abs=0.01)
    assert signs["share"]["later_s"] == pytest.approx(earlier, rel=0.25)
    assert 0.0 < low < signs["share"]["later_s"] < high < 2.0 * earlier
    assert "other" not in signs or abs(signs["other"]["later_s"]) > 0.1
    assert narrowed(values, 1) == found | {"sign_changes": {}}
