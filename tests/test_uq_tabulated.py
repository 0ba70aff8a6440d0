"""Quantiles from a table against those of the distribution, all the way out."""

import numpy as np
import pytest
from scipy import stats

from bearing_twin.uq.distributions import MOST, quantiles
from bearing_twin.uq.inputs import GREATEST_UNIT, LEAST_UNIT, Joint, read_input

TAILS = 2.0 ** -np.arange(1.0, 55.0)
UNIT = np.concatenate([TAILS, 1.0 - TAILS[:-1], [LEAST_UNIT, GREATEST_UNIT], np.random.default_rng(3).random(20_000)])


@pytest.mark.parametrize(
    ("name", "distribution"),
    [
        ("gamma", stats.gamma(8.1, scale=1.4e-5)),
        ("gamma", stats.gamma(0.3, scale=2.0)),
        ("gamma", stats.gamma(300.0)),
        ("beta", stats.beta(2.0, 3.0, loc=1.0, scale=4.0)),
        ("beta", stats.beta(0.5, 0.5)),
        ("beta", stats.beta(40.0, 2.0, loc=-3.0, scale=2.0)),
    ],
)
def test_a_table_is_exact_to_eleven_digits_and_rises(name, distribution):
    table, exact = quantiles(name, distribution), distribution.ppf(UNIT)
    low, high = distribution.support()
    off = np.abs(table(UNIT) - exact) / (exact if name == "gamma" else high - low)
    assert off.max() < 2.0 * MOST
    assert np.all(np.diff(table(np.sort(UNIT))) >= 0.0)


@pytest.mark.parametrize(
    ("name", "distribution"),
    [("gamma", stats.gamma(0.02)), ("gamma", stats.gamma(1e6)), ("normal", stats.norm()), ("uniform", stats.uniform())],
)
def test_what_no_table_holds_keeps_its_own_quantiles(name, distribution):
    assert quantiles(name, distribution) is None


def test_a_sampler_takes_tables_and_the_rest_stays_exact():
    """Between bounds nothing steps over them; a value alone is the same as among many."""
    inputs = [
        read_input("a", {"distribution": "gamma", "mean": 2.0, "std": 0.5}),
        read_input("b", {"distribution": "beta", "low": 0.1, "high": 0.3, "mean": 0.2, "std": 0.05}),
        read_input("c", {"distribution": "gamma", "shape": 0.02, "scale": 1.0}),
        read_input("d", {"distribution": "normal", "mean": 0.0, "std": 1.0}),
    ]
    unit = np.repeat(UNIT[:, None], len(inputs), axis=1)
    values = Joint(inputs).values(unit)
    for column, one in zip(values.T, inputs, strict=True):
        assert column == pytest.approx(one.ppf(UNIT), rel=2.0 * MOST, abs=1e-300)
    assert values[:, 1].min() >= 0.1
    assert values[:, 1].max() <= 0.3
    assert np.array_equal(values[:, 2], inputs[2].ppf(UNIT))
    assert np.array_equal(Joint(inputs).values(unit[7:8])[0], values[7])
