"""The table of distributions an input may have, on SciPy's; and the two that SciPy has not.

A new distribution is one function and one row of DISTRIBUTIONS.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.optimize import brentq

from bearing_twin.errors import StatisticError
from bearing_twin.units import Limits
from bearing_twin.uq.knowledge import FARTHEST_CUT

GREATEST_TILT = 500.0  # of `truncated_exponential`; a mean nearer to a bound than 1/500 of the range is refused
LIMITS = {name: Limits(above=0.0) for name in ("std", "shape", "scale", "std_log", "a", "b")}


class EmpiricalValues:
    """The distribution that takes each of the given values equally often; one value = no uncertainty.

    It has the methods of a frozen SciPy distribution that inputs use. Values have no density: `pdf` raises
    StatisticError. The deviation is that of the distribution (divided by n), not an estimate from a sample.
    """

    def __init__(self, values):
        self.values = np.sort(np.atleast_1d(np.asarray(values, float)))

    def ppf(self, u):
        rank = np.ceil(np.asarray(u, float) * len(self.values)).astype(int) - 1
        return self.values[np.clip(rank, 0, len(self.values) - 1)]

    def isf(self, u):
        return self.ppf(1.0 - np.asarray(u, float))

    def cdf(self, x):
        return np.searchsorted(self.values, x, side="right") / len(self.values)

    def pdf(self, x):
        raise StatisticError("single values have no density: ask for the distribution function or for quantiles")

    def mean(self):
        return float(np.mean(self.values))

    def std(self):
        return float(np.std(self.values))

    def support(self):
        return float(self.values[0]), float(self.values[-1])


class _TruncatedExponential(stats.rv_continuous):
    """Density proportional to exp(tilt t) on 0 <= t <= 1, falling for tilt < 0; |tilt| <= GREATEST_TILT."""

    def _argcheck(self, tilt):
        return (tilt != 0.0) & (np.abs(tilt) <= GREATEST_TILT)

    def _pdf(self, x, tilt):
        return tilt * np.exp(tilt * x) / np.expm1(tilt)

    def _cdf(self, x, tilt):
        return np.expm1(tilt * x) / np.expm1(tilt)

    def _sf(self, x, tilt):
        # the mirror image has the opposite tilt
        return np.expm1(-tilt * (1.0 - x)) / np.expm1(-tilt)

    def _ppf(self, q, tilt):
        return np.log1p(q * np.expm1(tilt)) / tilt

    def _isf(self, q, tilt):
        return 1.0 + np.log1p(q * np.expm1(-tilt)) / tilt

    def _stats(self, tilt):
        tilt = float(np.ravel(tilt)[0])  # a frozen distribution has one
        return _tilted_mean(tilt), _tilted_variance(tilt), None, None


_tilted = _TruncatedExponential(a=0.0, b=1.0, name="truncated_exponential")


class _TruncatedNormal(type(stats.truncnorm)):
    """SciPy's truncated normal with all digits on the upper tail too: that is the lower tail of its mirror image."""

    def _isf(self, q, a, b):
        return -self._ppf(q, -b, -a)

    def _sf(self, x, a, b):
        return self._cdf(-x, -b, -a)


_truncated_normal_of = _TruncatedNormal(name="truncated_normal")


def truncated_exponential(low, high, mean):
    """Frozen SciPy distribution on [low, high], density exponential in x, with that mean.

    Of all distributions with these bounds and this mean it has the greatest entropy. Raises ValueError with the
    reason where the mean is the middle (that is the uniform distribution) or too near to a bound for doubles.
    """
    share = (mean - low) / (high - low)
    if not 0.0 < share < 1.0:
        raise ValueError("the mean must lie between low and high")
    if abs(share - 0.5) < 1e-9:
        raise ValueError("with its mean in the middle it is the uniform distribution: give uniform, low and high")
    if not _tilted_mean(-GREATEST_TILT) <= share <= _tilted_mean(GREATEST_TILT):
        raise ValueError(f"the mean is nearer to a bound than 1/{GREATEST_TILT:g} of the range")
    tilt = brentq(lambda c: _tilted_mean(c) - share, -GREATEST_TILT, GREATEST_TILT, xtol=1e-15, rtol=1e-14)
    return _tilted(tilt, loc=low, scale=high - low)


def _tilted_mean(tilt):
    """1/(1 - exp(-c)) - 1/c, by its series where the two cancel."""
    if abs(tilt) < 1e-2:
        return 0.5 + tilt / 12.0 - tilt**3 / 720.0 + tilt**5 / 30240.0
    return -1.0 / math.expm1(-tilt) - 1.0 / tilt


def _tilted_variance(tilt):
    """1/c^2 - 1/(2 sinh(c/2))^2, by its series where the two cancel."""
    if abs(tilt) < 1e-2:
        return 1.0 / 12.0 - tilt**2 / 240.0 + tilt**4 / 6048.0
    return 1.0 / tilt**2 - 1.0 / (2.0 * math.sinh(0.5 * tilt)) ** 2


class Distribution(NamedTuple):
    """A row of DISTRIBUTIONS: `forms` = the sets of parameters it may be given by, `build` = those to SciPy's object.

    `build` raises ValueError with the reason where the parameters do not go together.
    """

    forms: tuple[tuple[str, ...], ...]
    build: Callable
    help: str

    @property
    def parameters(self) -> tuple[str, ...]:
        """Every parameter of any form, once, in the order of the forms."""
        return tuple(dict.fromkeys(name for form in self.forms for name in form))


def _gamma(mean=None, std=None, shape=None, scale=None):
    if shape is None:
        _want(mean > 0.0, "the mean of a gamma distribution is above 0")
        shape, scale = (mean / std) ** 2, std**2 / mean
    return stats.gamma(shape, scale=scale)


def _uniform(low, high):
    _want(low < high, "low must be below high")
    return stats.uniform(low, high - low)


def _truncated_normal(mean, std, low=-math.inf, high=math.inf):
    _want(low < high, "low must be below high")
    cut, top = (low - mean) / std, (high - mean) / std
    _want(
        cut <= FARTHEST_CUT and top >= -FARTHEST_CUT,
        f"a bound lies more than {FARTHEST_CUT:g} std out on the tail of the normal, of which nothing is left",
    )
    return _truncated_normal_of(cut, top, loc=mean, scale=std)


def _lognormal(mean=None, std=None, mean_log=None, std_log=None):
    if mean_log is None:
        _want(mean > 0.0, "the mean of a lognormal distribution is above 0")
        variance = math.log1p((std / mean) ** 2)
        mean_log, std_log = math.log(mean) - 0.5 * variance, math.sqrt(variance)
    return stats.lognorm(std_log, scale=math.exp(mean_log))


def _beta(low, high, mean=None, std=None, a=None, b=None):
    _want(low < high, "low must be below high")
    if a is None:
        _want(low < mean < high, "the mean must lie between low and high")
        share, spread = (mean - low) / (high - low), std / (high - low)
        _want(
            spread**2 < share * (1.0 - share), "no distribution between these bounds has this mean and so great a std"
        )
        both = share * (1.0 - share) / spread**2 - 1.0
        a, b = share * both, (1.0 - share) * both
    return stats.beta(a, b, loc=low, scale=high - low)


def _exponential(mean):
    _want(mean > 0.0, "the mean of an exponential distribution is above 0")
    return stats.expon(scale=mean)


def _want(condition, reason):
    if not condition:
        raise ValueError(reason)


DISTRIBUTIONS = {
    "gamma": Distribution((("mean", "std"), ("shape", "scale")), _gamma, "positive; paper 3, eqs. (4) and (5)"),
    "uniform": Distribution((("low", "high"),), _uniform, "nothing known but the bounds"),
    "normal": Distribution((("mean", "std"),), lambda mean, std: stats.norm(mean, std), "the whole line"),
    "truncated_normal": Distribution(
        (("mean", "std", "low", "high"), ("mean", "std", "low"), ("mean", "std", "high")),
        _truncated_normal,
        "a normal between bounds; mean and std are those of the whole normal",
    ),
    "lognormal": Distribution((("mean", "std"), ("mean_log", "std_log")), _lognormal, "its logarithm is normal"),
    "beta": Distribution((("low", "high", "mean", "std"), ("low", "high", "a", "b")), _beta, "between bounds"),
    "exponential": Distribution((("mean",),), _exponential, "positive, only the mean known"),
    "truncated_exponential": Distribution(
        (("low", "high", "mean"),), truncated_exponential, "between bounds, only the mean known"
    ),
    "fixed": Distribution((("value",),), lambda value: EmpiricalValues(value), "no doubt"),
    "empirical": Distribution((("values",),), EmpiricalValues, "measured values, each equally likely"),
}
