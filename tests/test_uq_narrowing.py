"""The instant at which histories come together after their peak, on histories whose instant is known."""

import numpy as np
import pytest

from bearing_twin.base.errors import StatisticError
from bearing_twin.uq import histories as module
from bearing_twin.uq.histories import FEWEST

TIMES = np.linspace(0.0, 1.0, 201)


def narrowing(times, histories, seed=0, inputs=None):
    """Of histories whose inputs do not matter."""
    return module.narrowing(times, histories, np.empty((len(histories), 0)) if inputs is None else inputs, seed)


def histories(count, seed):
    """A pulse and a random share of a wave that is zero at 0.603; a little noise of its own in each."""
    random = np.random.default_rng(seed)
    wave = np.sin(np.pi * (TIMES - 0.603) / 0.8)
    own = 0.02 * random.standard_normal((count, 1)) * np.cos(3.0 * TIMES)
    return np.sin(np.pi * TIMES) + 0.3 * random.standard_normal((count, 1)) * wave + own


def test_the_instant_and_its_interval():
    found = narrowing(TIMES, histories(800, 1))
    assert found.time == pytest.approx(0.603, abs=0.01)
    assert found.low <= found.time <= found.high
    assert found.high - found.low < 0.02
    assert found.mean == pytest.approx(np.sin(0.6 * np.pi), abs=0.01)
    assert found.std < 0.03
    assert found.modes == 1
    assert found == narrowing(TIMES, histories(800, 1))


def test_the_interval_covers():
    """Of 40 studies 34 at least: a binomial with 95 % gives fewer once in 300."""
    fine = np.linspace(0.59, 0.61, 2001)
    truth = fine[np.argmin((0.3 * np.sin(np.pi * (fine - 0.603) / 0.8)) ** 2 + (0.02 * np.cos(3.0 * fine)) ** 2)]
    hits = 0
    for seed in range(40):
        found = narrowing(TIMES, histories(300, seed), seed)
        low, high = found.low, found.high
        hits += low <= truth <= high
    assert hits >= 34


def test_where_there_is_none_it_says_so():
    with pytest.raises(StatisticError, match="at least"):
        narrowing(TIMES, histories(FEWEST - 1, 3))
    growing = np.sin(np.pi * TIMES) * (1.0 + np.random.default_rng(4).standard_normal((100, 1)) * TIMES**2)
    with pytest.raises(StatisticError, match="no instant"):
        narrowing(TIMES, growing)


def test_where_the_correlation_changes_its_sign():
    """With the share of the wave at its zero, 0.603; what else varies moves the least deviation, not that."""
    random = np.random.default_rng(5)
    share, other = random.standard_normal((2, 900, 1))
    wave = np.sin(np.pi * (TIMES - 0.603) / 0.8)
    values = np.sin(np.pi * TIMES) + 0.3 * share * wave + 0.2 * other * TIMES**2
    inputs = np.hstack([share, other])
    slope = 0.3 * np.pi / 0.8
    earlier = 2.0 * 0.2**2 * 0.603**3 / slope**2  # of the least: b b' + r r' = 0, by its first terms
    found = narrowing(TIMES, values, 1, inputs)
    assert found.signs[0].time == pytest.approx(0.603, abs=0.01)
    assert found.signs[0].later == pytest.approx(earlier, rel=0.25)
    assert 0.0 < found.signs[0].low < found.signs[0].later < found.signs[0].high < 2.0 * earlier
    assert found.signs[1] is None or abs(found.signs[1].later) > 0.1
    assert narrowing(TIMES, values, 1)[:-1] == found[:-1]


def test_where_a_tenth_of_the_resamples_has_none_it_says_so():
    """The least deviation of three instants is hardly less than its neighbours'."""
    random = np.random.default_rng(3)
    some = np.array([3.0, 2.0, 1.5]) + np.array([1.0, 0.85, 1.0]) * random.standard_normal((200, 3))
    assert some.std(axis=0)[1] < some.std(axis=0)[[0, 2]].min()
    with pytest.raises(StatisticError, match="no instant"):
        narrowing(np.arange(3.0), some)
