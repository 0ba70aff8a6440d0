"""Distributions of inputs: the table of those that have a name, any other of scipy.stats, and some that SciPy lacks.

A new distribution is one function and one row of DISTRIBUTIONS.
"""

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq
from scipy.special import expit, logit, ndtr

from bearing_twin.base.errors import StatisticError
from bearing_twin.base.parameters import echo, unknown
from bearing_twin.base.units import Limits

GREATEST_TILT = 500.0  # of `truncated_exponential`; a mean nearer to a bound than 1/500 of the range is refused
FARTHEST_CUT = 30.0  # deviations; a normal cut off farther out on its tail loses digits and is refused
SCIPY = "scipy."  # before the name of a distribution of scipy.stats
LISTS = ("values", "weights", "x", "density")  # parameters that are lists of numbers
LIMITS = {name: Limits(above=0.0) for name in ("std", "shape", "scale", "std_log", "a", "b")}


class DiscreteValues:
    """The distribution that takes each of some values with a probability; one value = a fixed input.

    It has the methods of a frozen SciPy distribution that inputs use. Values have no density: `pdf` raises
    StatisticError. The deviation is that of the distribution (divided by n), not an estimate from a sample.
    """

    def __init__(self, values, weights=None):
        values = np.atleast_1d(np.asarray(values, float))
        weights = np.ones(len(values)) if weights is None else np.asarray(weights, float)
        _require(
            len(weights) == len(values), f"there are {len(weights)} weights for {len(values)} values; give one each"
        )
        _require(np.all(weights >= 0.0) and weights.sum() > 0.0, "weights are 0 or above, and one is above 0")
        order = np.argsort(values)
        order = order[weights[order] > 0.0]
        self.values, self.shares = values[order], weights[order] / weights.sum()
        self._until = np.cumsum(self.shares)

    def ppf(self, u):
        rank = np.searchsorted(self._until * (1.0 + 1e-13), np.asarray(u, float))  # shares are rounded
        return self.values[np.minimum(rank, len(self.values) - 1)]

    def isf(self, u):
        return self.ppf(1.0 - np.asarray(u, float))

    def cdf(self, x):
        return np.append(0.0, self._until)[np.searchsorted(self.values, x, side="right")]

    def pdf(self, x):
        raise StatisticError("single values have no density: ask for the distribution function or for quantiles")

    def mean(self):
        return float(self.shares @ self.values)

    def std(self):
        return math.sqrt(self.shares @ (self.values - self.mean()) ** 2)

    def support(self):
        return float(self.values[0]), float(self.values[-1])


class _Continuous:
    """A continuous distribution with the methods of a frozen one of SciPy that inputs use."""

    def __init__(self, low, high):
        self._low, self._high = float(low), float(high)

    def support(self):
        return self._low, self._high

    def isf(self, u):
        return self.ppf(1.0 - np.asarray(u, float))

    def sf(self, x):
        return 1.0 - self.cdf(x)

    def mean(self):
        return self.expect(lambda x: x)

    def std(self):
        mean = self.mean()
        return math.sqrt(self.expect(lambda x: (x - mean) ** 2))

    def expect(self, function):
        """The mean of a function by the trapezoidal rule in the normal score, which converges exponentially."""
        z = np.linspace(-9.0, 9.0, 1153)
        x = np.piecewise(ndtr(-np.abs(z)), [z < 0.0], [self.ppf, self.isf])
        weights = np.exp(-0.5 * z**2)
        return float(weights @ function(x) / weights.sum())


class Truncated(_Continuous):
    """A frozen SciPy distribution between two bounds, with its digits on both tails.

    Of a piece of one tail, which has its digits on that side alone, both quantiles are found there.
    """

    def __init__(self, whole, low, high):
        super().__init__(max(low, whole.support()[0]), min(high, whole.support()[1]))
        self._whole, self._below, self._above = whole, whole.cdf(low), whole.sf(high)
        self.mass = whole.sf(low) - self._above if self._below > 0.5 else whole.cdf(high) - self._below

    def ppf(self, u):
        u = np.asarray(u, float)
        return self._from_above(1.0 - u) if self._below > 0.5 else self._from_below(u)

    def isf(self, u):
        u = np.asarray(u, float)
        return self._from_below(1.0 - u) if self._above > 0.5 else self._from_above(u)

    def _from_below(self, u):
        return np.clip(self._whole.ppf(self._below + self.mass * u), self._low, self._high)

    def _from_above(self, u):
        return np.clip(self._whole.isf(self._above + self.mass * u), self._low, self._high)

    def cdf(self, x):
        if self._below > 0.5:
            return 1.0 - self.sf(x)
        return np.clip((self._whole.cdf(x) - self._below) / self.mass, 0.0, 1.0)

    def sf(self, x):
        if self._above > 0.5:
            return 1.0 - self.cdf(x)
        return np.clip((self._whole.sf(x) - self._above) / self.mass, 0.0, 1.0)

    def pdf(self, x):
        x = np.asarray(x, float)
        return np.where((x >= self._low) & (x <= self._high), self._whole.pdf(x) / self.mass, 0.0)


class TableDensity(_Continuous):
    """The density whose graph goes straight through the points (x, density), made to have the mass 1."""

    def __init__(self, x, density):
        x, density = np.asarray(x, float), np.asarray(density, float)
        _require(len(x) == len(density) >= 2, "x and density are lists of the same length, two places at least")
        _require(np.all(np.diff(x) > 0.0), "the places x must rise")
        _require(np.all(density >= 0.0) and density.max() > 0.0, "a density is 0 or above, and somewhere above 0")
        masses = 0.5 * np.diff(x) * (density[1:] + density[:-1])
        self._x, self._density = x, density / masses.sum()
        self._until = np.append(0.0, np.cumsum(masses)) / masses.sum()
        filled = np.flatnonzero(masses)
        super().__init__(float(x[filled[0]]), float(x[filled[-1] + 1]))

    def pdf(self, x):
        return np.interp(x, self._x, self._density, left=0.0, right=0.0)

    def cdf(self, x):
        x = np.clip(np.asarray(x, float), self._x[0], self._x[-1])
        piece = np.clip(np.searchsorted(self._x, x, side="right") - 1, 0, len(self._x) - 2)
        return self._until[piece] + 0.5 * (x - self._x[piece]) * (self._density[piece] + self.pdf(x))

    def ppf(self, u):
        u = np.asarray(u, float)
        piece = np.clip(np.searchsorted(self._until, u) - 1, 0, len(self._x) - 2)
        left, slope = self._density[piece], (np.diff(self._density) / np.diff(self._x))[piece]
        more = np.maximum(u - self._until[piece], 0.0)
        height = np.sqrt(np.maximum(left**2 + 2.0 * slope * more, 0.0))  # the density at the quantile
        with np.errstate(all="ignore"):
            step = np.where(more > 0.0, 2.0 * more / (left + height), 0.0)
        return np.clip(self._x[piece] + step, self._low, self._high)

    def expect(self, function):
        """The mean of a function by Gauss's rule of two points a piece, which is exact for mean and variance."""
        half, middle = 0.5 * np.diff(self._x), 0.5 * (self._x[1:] + self._x[:-1])
        points = (middle + side * half / math.sqrt(3.0) for side in (-1.0, 1.0))
        return float(sum(half @ (function(x) * self.pdf(x)) for x in points))


def truncated_exponential(low, high, mean):
    """The distribution on [low, high] whose density is exponential in x, with that mean.

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
    scale = (high - low) / abs(tilt)
    whole = stats.expon(low, scale) if tilt < 0.0 else stats.weibull_max(1.0, high, scale)  # its mirror image
    return Truncated(whole, low, high)


def _tilted_mean(tilt):
    """1/(1 - exp(-c)) - 1/c, by its series where the two cancel."""
    if abs(tilt) < 1e-2:
        return 0.5 + tilt / 12.0 - tilt**3 / 720.0 + tilt**5 / 30240.0
    return -1.0 / math.expm1(-tilt) - 1.0 / tilt


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
        _require(mean > 0.0, "the mean of a gamma distribution is above 0")
        shape, scale = (mean / std) ** 2, std**2 / mean
    return stats.gamma(shape, scale=scale)


def _uniform(low, high):
    _require(low < high, "low must be below high")
    return stats.uniform(low, high - low)


def _truncated_normal(mean, std, low=-math.inf, high=math.inf):
    _require(low < high, "low must be below high")
    cut, top = (low - mean) / std, (high - mean) / std
    _require(
        cut <= FARTHEST_CUT and top >= -FARTHEST_CUT,
        f"a bound lies more than {FARTHEST_CUT:g} std out on the tail of the normal, of which nothing is left",
    )
    return Truncated(stats.norm(mean, std), low, high)


def _lognormal(mean=None, std=None, mean_log=None, std_log=None):
    if mean_log is None:
        _require(mean > 0.0, "the mean of a lognormal distribution is above 0")
        variance = math.log1p((std / mean) ** 2)
        mean_log, std_log = math.log(mean) - 0.5 * variance, math.sqrt(variance)
    return stats.lognorm(std_log, scale=math.exp(mean_log))


def _beta(low, high, mean=None, std=None, a=None, b=None):
    _require(low < high, "low must be below high")
    if a is None:
        _require(low < mean < high, "the mean must lie between low and high")
        share, spread = (mean - low) / (high - low), std / (high - low)
        _require(
            spread**2 < share * (1.0 - share), "no distribution between these bounds has this mean and so great a std"
        )
        both = share * (1.0 - share) / spread**2 - 1.0
        a, b = share * both, (1.0 - share) * both
    return stats.beta(a, b, loc=low, scale=high - low)


def _exponential(mean):
    _require(mean > 0.0, "the mean of an exponential distribution is above 0")
    return stats.expon(scale=mean)


def _weibull(shape, scale):
    return stats.weibull_min(shape, scale=scale)


def _triangular(low, mode, high):
    _require(low < high and low <= mode <= high, "low must be below high, and the mode between them")
    return stats.triang((mode - low) / (high - low), loc=low, scale=high - low)


def _truncated_gamma(low=0.0, high=math.inf, **whole):
    _require(0.0 <= low < high, "low must be below high, and 0 or above")
    found = Truncated(_gamma(**whole), low, high)
    _require(found.mass > 1e-9, "less than 1e-9 of the whole distribution lies between the bounds; give others")
    return found


def of_scipy(name, **parameters):
    """The frozen distribution `scipy.stats.NAME` with shape parameters, `loc` and `scale` by keyword."""
    family = getattr(stats, str(name), None)
    if not isinstance(family, (stats.rv_continuous, stats.rv_discrete)):
        raise ValueError(
            f"scipy.stats has no distribution {echo(name)} that is given by numbers; see its documentation"
        )
    legal = [*(family.shapes or "").replace(" ", "").split(","), "loc"]
    legal = [one for one in legal if one] + ["scale"] * isinstance(family, stats.rv_continuous)
    wrong = [one for one in parameters if one not in legal]
    if wrong:
        raise ValueError(f"{echo(wrong[0])} is no parameter of scipy.stats.{name}; {unknown(wrong[0], legal)}")
    lacking = [one for one in legal[: family.numargs] if one not in parameters]
    _require(not lacking, f"scipy.stats.{name} needs {', '.join(lacking)} too")
    frozen = family(**parameters)
    _require(frozen.support()[0] <= frozen.support()[1], f"these parameters make no distribution scipy.stats.{name}")
    return frozen


def as_mapping(frozen) -> dict:
    """A frozen `scipy.stats` distribution as a study file has it; raises ValueError for one that no file can hold."""
    family = frozen.dist
    if type(getattr(stats, family.name, None)) is not type(family):
        raise ValueError(
            "only distributions by a name of scipy.stats can be stored with a study; give others as a table of x and "
            "density, or as values with weights"
        )
    names = [*filter(None, (family.shapes or "").replace(" ", "").split(",")), "loc", "scale"]
    given = dict(zip(names, frozen.args, strict=False)) | frozen.kwds
    if any(np.ndim(one) for one in given.values()):
        raise ValueError("parameters of a distribution must be single numbers")
    return {"distribution": f"{SCIPY}{family.name}", **{key: float(one) for key, one in given.items()}}


def _require(condition, reason):
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
    "weibull": Distribution((("shape", "scale"),), _weibull, "positive; strengths and lives"),
    "triangular": Distribution((("low", "mode", "high"),), _triangular, "between bounds, most likely value known"),
    "truncated_gamma": Distribution(
        tuple(
            (*whole, *ends)
            for whole in (("mean", "std"), ("shape", "scale"))
            for ends in (("low", "high"), ("low",), ("high",))
        ),
        _truncated_gamma,
        "a gamma distribution between bounds; mean and std are those of the whole one",
    ),
    "table": Distribution((("x", "density"),), TableDensity, "a density of one's own, straight between its points"),
    "fixed": Distribution((("value",),), lambda value: DiscreteValues(value), "a known value"),
    "empirical": Distribution((("values",),), DiscreteValues, "measured values, each equally likely"),
    "discrete": Distribution((("values", "weights"),), DiscreteValues, "single values, with their weights"),
}


# Quantiles of a gamma variable from a table: SciPy finds each by iteration, which a million of them wait for.
#
# Over t = log(u/(1 - u)) stands a cubic spline of the logarithm of the value, which is nearly straight far out. SciPy's
# `NumericalInversePolynomial` is no substitute: it is good to 1e-6 in the tails, and hangs for some shapes.

MOST = 1e-11  # relative error
NODES, FARTHEST = 8192, 38.0  # over |t| <= FARTHEST: as far out as doubles reach


@functools.lru_cache(maxsize=4)
def gamma_quantiles(shape: float, scale: float) -> Callable[[np.ndarray], np.ndarray] | None:
    """Quantiles (n,) at probabilities (n,) in (0, 1); None where the error between nodes would be above MOST."""
    t, distribution = np.linspace(-FARTHEST, FARTHEST, 2 * NODES - 1), stats.gamma(shape, scale=scale)
    with np.errstate(all="ignore"):
        x = np.where(t < 0.0, distribution.ppf(expit(t)), distribution.isf(expit(-t)))  # u has no digits left near 1
        slopes = np.nan_to_num(expit(t) * expit(-t) / (distribution.pdf(x) * x), posinf=0.0)
        values = np.log(x)
        if not np.isfinite(values).all():
            return None
        spline = CubicHermiteSpline(t[::2], values[::2], slopes[::2])
        error = np.max(np.abs(np.exp(spline(t[1::2])) / x[1::2] - 1.0))
    return (lambda u: np.exp(spline(logit(u)))) if error <= MOST else None
