"""Distributions of inputs: the table of those that have a name, any other of scipy.stats, and some that SciPy lacks.

A new distribution is one function and one row of DISTRIBUTIONS. `greatest_entropy` gives the distribution that follows
from what is known of a quantity (paper 3, eq. 3).
"""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.optimize import brentq, root
from scipy.special import digamma, ndtr

from bearing_twin.base.errors import StatisticError, StudyError, echo, legal_hint
from bearing_twin.base.units import Limits

GREATEST_TILT = 500.0  # of `truncated_exponential`; a mean nearer to a bound than 1/500 of the range is refused
FARTHEST_CUT = 30.0  # deviations; a normal cut off farther out on its tail loses digits and is refused
BINS = 8192  # of a table, whose densities and distribution functions are then as in it to 1e-7 of the range
SCIPY = "scipy."  # before the name of a distribution of scipy.stats
SLOW = ("ksone", "kstwo", "studentized_range")  # of these; others take a second at most
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
        require(
            len(weights) == len(values), f"there are {len(weights)} weights for {len(values)} values; give one each"
        )
        require(np.all(weights >= 0.0) and np.any(weights > 0.0), "weights are 0 or above, and one is above 0")
        order = np.argsort(values)
        order = order[weights[order] > 0.0]
        shares = weights[order] / weights.max()  # scaled first: the sum of great weights may overflow
        self.values, self.shares = values[order], shares / shares.sum()
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


class Truncated:
    """A frozen SciPy distribution between two bounds, with its digits on both tails.

    Where the bounds enclose a part of one tail, which has all its digits on that side only, both quantiles are computed
    on that side.
    """

    def __init__(self, parent, low, high):
        self._low, self._high = float(max(low, parent.support()[0])), float(min(high, parent.support()[1]))
        self._parent, self._below, self._above = parent, parent.cdf(low), parent.sf(high)
        self.mass = parent.sf(low) - self._above if self._below > 0.5 else parent.cdf(high) - self._below

    def ppf(self, u):
        u = np.asarray(u, float)
        return self._from_above(1.0 - u) if self._below > 0.5 else self._from_below(u)

    def isf(self, u):
        u = np.asarray(u, float)
        return self._from_below(1.0 - u) if self._above > 0.5 else self._from_above(u)

    def _from_below(self, u):
        return np.clip(self._parent.ppf(self._below + self.mass * u), self._low, self._high)

    def _from_above(self, u):
        return np.clip(self._parent.isf(self._above + self.mass * u), self._low, self._high)

    def cdf(self, x):
        if self._below > 0.5:
            return 1.0 - self.sf(x)
        return np.clip((self._parent.cdf(x) - self._below) / self.mass, 0.0, 1.0)

    def sf(self, x):
        if self._above > 0.5:
            return 1.0 - self.cdf(x)
        return np.clip((self._parent.sf(x) - self._above) / self.mass, 0.0, 1.0)

    def pdf(self, x):
        x = np.asarray(x, float)
        return np.where((x >= self._low) & (x <= self._high), self._parent.pdf(x) / self.mass, 0.0)

    def support(self):
        return self._low, self._high

    def mean(self):
        return self._expect(lambda x: x)

    def std(self):
        mean = self.mean()
        return math.sqrt(self._expect(lambda x: (x - mean) ** 2))

    def _expect(self, function):
        """The mean of a function by the trapezoidal rule in the normal score, which converges exponentially."""
        z = np.linspace(-9.0, 9.0, 1153)
        x = np.piecewise(ndtr(-np.abs(z)), [z < 0.0], [self.ppf, self.isf])
        weights = np.exp(-0.5 * z**2)
        return float(weights @ function(x) / weights.sum())


def truncated_exponential(low, high, mean):
    """The distribution on [low, high] whose density is exponential in x, with that mean.

    Of all distributions with these bounds and this mean it has the greatest entropy. Raises StudyError with the
    reason where the mean is the middle (that is the uniform distribution) or too near to a bound for doubles.
    """
    share = (mean - low) / (high - low)
    if not 0.0 < share < 1.0:
        raise StudyError("the mean must lie between low and high")
    if abs(share - 0.5) < 1e-9:
        raise StudyError("with its mean in the middle it is the uniform distribution: give uniform, low and high")
    if not _tilted_mean(-GREATEST_TILT) <= share <= _tilted_mean(GREATEST_TILT):
        raise StudyError(f"the mean is nearer to a bound than 1/{GREATEST_TILT:g} of the range")
    tilt = brentq(lambda c: _tilted_mean(c) - share, -GREATEST_TILT, GREATEST_TILT, xtol=1e-15, rtol=1e-14)
    scale = (high - low) / abs(tilt)
    parent = stats.expon(low, scale) if tilt < 0.0 else stats.weibull_max(1.0, high, scale)  # its mirror image
    return Truncated(parent, low, high)


def _tilted_mean(tilt):
    """1/(1 - exp(-c)) - 1/c, by its series where the two cancel."""
    if abs(tilt) < 1e-2:
        return 0.5 + tilt / 12.0 - tilt**3 / 720.0 + tilt**5 / 30240.0
    return -1.0 / math.expm1(-tilt) - 1.0 / tilt


class Distribution(NamedTuple):
    """A row of DISTRIBUTIONS: `forms` = the sets of parameters it may be given by, `build` = those to SciPy's object.

    `build` raises StudyError with the reason where the parameters do not go together.
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
        require(mean > 0.0, "the mean of a gamma distribution is above 0")
        shape, scale = (mean / std) ** 2, std**2 / mean
    return stats.gamma(shape, scale=scale)


def _uniform(low, high):
    require(low < high, "low must be below high")
    return stats.uniform(low, high - low)


def _truncated_normal(mean, std, low=-math.inf, high=math.inf):
    require(low < high, "low must be below high")
    cut, top = (low - mean) / std, (high - mean) / std
    require(
        cut <= FARTHEST_CUT and top >= -FARTHEST_CUT,
        f"a bound lies more than {FARTHEST_CUT:g} std out on the tail of the normal, of which nothing is left",
    )
    return Truncated(stats.norm(mean, std), low, high)


def _lognormal(mean=None, std=None, mean_log=None, std_log=None):
    if mean_log is None:
        require(mean > 0.0, "the mean of a lognormal distribution is above 0")
        variance = math.log1p((std / mean) ** 2)
        mean_log, std_log = math.log(mean) - 0.5 * variance, math.sqrt(variance)
    return stats.lognorm(std_log, scale=math.exp(mean_log))


def _beta(low, high, mean=None, std=None, a=None, b=None):
    require(low < high, "low must be below high")
    if a is None:
        require(low < mean < high, "the mean must lie between low and high")
        share, spread = (mean - low) / (high - low), std / (high - low)
        require(
            spread**2 < share * (1.0 - share), "no distribution between these bounds has this mean and so great a std"
        )
        concentration = share * (1.0 - share) / spread**2 - 1.0
        a, b = share * concentration, (1.0 - share) * concentration
    return stats.beta(a, b, loc=low, scale=high - low)


def _exponential(mean):
    require(mean > 0.0, "the mean of an exponential distribution is above 0")
    return stats.expon(scale=mean)


def _weibull(shape, scale):
    return stats.weibull_min(shape, scale=scale)


def _triangular(low, mode, high):
    require(low < high and low <= mode <= high, "low must be below high, and the mode between them")
    return stats.triang((mode - low) / (high - low), loc=low, scale=high - low)


def _truncated_gamma(low=0.0, high=math.inf, **parameters):
    require(0.0 <= low < high, "low must be below high, and 0 or above")
    truncated = Truncated(_gamma(**parameters), low, high)
    require(truncated.mass > 1e-9, "less than 1e-9 of the whole distribution lies between the bounds; give others")
    return truncated


def _table(x, density):
    """The density whose graph goes straight through the points (x, density), as a histogram of BINS, of mass 1."""
    x, density = np.asarray(x, float), np.asarray(density, float)
    require(len(x) == len(density) >= 2, "x and density are lists of the same length, two points at least")
    require(np.all(np.diff(x) > 0.0), "the values of x must rise")
    require(np.all(density >= 0.0) and density.max() > 0.0, "a density is 0 or above, and somewhere above 0")
    bins = -(-BINS // (len(x) - 1)) * (len(x) - 1)  # as many in each piece
    edges = np.interp(np.linspace(0.0, len(x) - 1.0, bins + 1), np.arange(len(x)), x)
    masses = np.diff(edges) * np.interp(0.5 * (edges[1:] + edges[:-1]), x, density / density.max())
    filled = np.flatnonzero(masses)
    first, last = filled[0], filled[-1] + 1
    return stats.rv_histogram((masses[first:last], edges[first : last + 1]), density=False)


def of_scipy(name, **parameters):
    """The frozen distribution `scipy.stats.NAME` with shape parameters, `loc` and `scale` by keyword."""
    family = getattr(stats, str(name), None)
    if not isinstance(family, (stats.rv_continuous, stats.rv_discrete)):
        raise StudyError(
            f"scipy.stats has no distribution {echo(name)} that is given by numbers; see its documentation"
        )
    legal = [*(family.shapes or "").replace(" ", "").split(","), "loc"]
    legal = [*filter(None, legal)] + ["scale"] * isinstance(family, stats.rv_continuous)
    for key in parameters:
        require(key in legal, f"{echo(key)} is no parameter of scipy.stats.{name}; {legal_hint(key, legal)}")
    missing = [parameter for parameter in legal[: family.numargs] if parameter not in parameters]
    require(not missing, f"scipy.stats.{name} needs {', '.join(missing)} too")
    require(name not in SLOW, f"scipy.stats.{name} takes minutes for a few numbers; give its density as a table")
    frozen = family(**parameters)
    require(frozen.support()[0] <= frozen.support()[1], f"these parameters make no distribution scipy.stats.{name}")
    return frozen


def as_mapping(frozen) -> dict:
    """A frozen `scipy.stats` distribution as a study file has it; raises StudyError for one that no file can hold."""
    family = frozen.dist
    if type(getattr(stats, family.name, None)) is not type(family):
        raise StudyError(
            "only distributions by a name of scipy.stats can be stored with a study; give others as a table of x and "
            "density, or as values with weights"
        )
    names = [*filter(None, (family.shapes or "").replace(" ", "").split(",")), "loc", "scale"]
    parameters = dict(zip(names, frozen.args, strict=False)) | frozen.kwds
    require(not any(map(np.ndim, parameters.values())), "parameters of a distribution must be single numbers")
    return {"distribution": f"{SCIPY}{family.name}", **{key: float(value) for key, value in parameters.items()}}


def require(condition, reason):
    """Raises StudyError with the reason unless the condition holds."""
    if not condition:
        raise StudyError(reason)


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
            (*form, *ends)
            for form in (("mean", "std"), ("shape", "scale"))
            for ends in (("low", "high"), ("low",), ("high",))
        ),
        _truncated_gamma,
        "a gamma distribution between bounds; mean and std are those of the whole one",
    ),
    "table": Distribution((("x", "density"),), _table, "a density of one's own, straight between its points"),
    "fixed": Distribution((("value",),), lambda value: DiscreteValues(value), "a known value"),
    "empirical": Distribution((("values",),), DiscreteValues, "measured values, each equally likely"),
    "discrete": Distribution((("values", "weights"),), DiscreteValues, "single values, with their weights"),
}


# The distribution of greatest entropy under what is known of a quantity (paper 3, eq. 3).
#
# Greatest entropy under given expectations of functions t_i(x) has the density exp(sum of l_i t_i(x)) on the support:
#
# | known | distribution |
# |---|---|
# | low, high | uniform |
# | low, high, mean | truncated exponential (uniform where the mean is the middle) |
# | low, high, mean, std | truncated normal, while std is below that of the truncated exponential |
# | mean, std | normal |
# | positive, mean | exponential |
# | positive, mean, std | normal truncated at 0, while std < mean; exponential at std = mean; none beyond |
# | positive, mean, mean_log | gamma |
# | positive, mean_log, std_log | lognormal |
#
# Paper 3 says that positiveness and a bounded second moment give the gamma distribution. They do not: the gamma
# distribution follows from E[X] and E[ln X]. `mean_log` is E[ln X] and `std_log` the deviation of ln X, X in SI units.

FACTS = ("positive", "low", "high", "mean", "std", "mean_log", "std_log")
PLENTY = 9.0  # deviations between mean and bound beyond which the bound cuts nothing off
LEAST_SPREAD = 0.0025  # deviation over range that the quadrature between two bounds resolves


def greatest_entropy(facts: Mapping) -> tuple[str, dict]:
    """Name and parameters of the distribution of greatest entropy, as DISTRIBUTIONS takes them.

    `facts` holds numbers under the names of FACTS and `positive` True or False. Constraints are met to 1e-10.
    Raises StudyError with the reason where no such distribution exists or the facts contradict each other.
    """
    for fact in facts:
        require(fact in FACTS, f"{echo(fact)} is no fact; {legal_hint(fact, FACTS)}")
    positive = facts.get("positive", True)
    require(isinstance(positive, bool), f"positive = {echo(positive)} must be true or false")
    known = frozenset(fact for fact in facts if fact != "positive" or facts[fact])
    if known not in FORMS:
        legal = "; ".join(", ".join(fact for fact in FACTS if fact in form) for form in FORMS)
        raise StudyError(
            f"no distribution of greatest entropy is known here for {', '.join(sorted(known)) or 'nothing'}; "
            f"state one of these: {legal}"
        )
    for fact in known & {"std", "std_log"}:
        require(facts[fact] > 0.0, f"{fact} must be above 0; a certain value is fixed")
    require("positive" not in known or facts.get("mean", 1.0) > 0.0, "the mean of a positive quantity is above 0")
    return FORMS[known](**{fact: facts[fact] for fact in FACTS if fact in known and fact != "positive"})


def _between(low, high):
    require(low < high, f"low = {low:g} must be below high = {high:g}")
    return "uniform", {"low": low, "high": high}


def _between_with_mean(low, high, mean):
    require(low < mean < high, f"mean = {mean:g} must lie between low = {low:g} and high = {high:g}")
    if abs(mean - 0.5 * (low + high)) < 1e-9 * (high - low):
        return _between(low, high)
    return "truncated_exponential", {"low": low, "high": high, "mean": mean}


def _between_with_mean_std(low, high, mean, std):
    """exp(l t + q t^2) on 0 <= t <= 1 with q < 0, with l and q from E[t] and E[t^2]."""
    require(low < mean < high, f"mean = {mean:g} must lie between low = {low:g} and high = {high:g}")
    share, spread = (mean - low) / (high - low), std / (high - low)
    if min(share, 1.0 - share) > PLENTY * spread:  # the bounds cut nothing off
        return "truncated_normal", {"mean": mean, "std": std, "low": low, "high": high}
    require(spread > LEAST_SPREAD, "std is so small against the bounds that one of them says nothing; leave it out")
    require(spread**2 < share * (1.0 - share), "no distribution between these bounds has this mean and so great a std")
    points, weights = np.polynomial.legendre.leggauss(16)  # in each of 64 pieces
    points = (np.arange(64)[:, None] + 0.5 * (points + 1.0)).ravel() / 64.0
    powers, weights = np.stack([points, points**2]), np.tile(weights, 64)

    def residual(multipliers):
        """Errors of both moments, and their derivatives by l and q: the covariances of t and t^2."""
        exponent = multipliers @ powers
        mass = weights * np.exp(exponent - exponent.max())
        mass /= mass.sum()
        centred = powers - (powers @ mass)[:, None]
        return powers @ mass - (share, spread**2 + share**2), (centred * mass) @ centred.T

    multipliers = root(residual, np.array([share, -0.5]) / spread**2, jac=True, tol=1e-14).x
    error = np.max(np.abs(residual(multipliers)[0]))
    require(
        error < 1e-10 and multipliers[1] < 0.0,
        f"with std = {std:g} the density of greatest entropy does not fall towards both bounds; "
        "give a smaller std, or leave it out, or name a beta distribution",
    )
    width = math.sqrt(-0.5 / multipliers[1])
    center = float(multipliers[0]) * width**2
    scale = high - low
    return "truncated_normal", {"mean": low + scale * center, "std": scale * width, "low": low, "high": high}


def _positive_with_mean_log(mean, mean_log):
    """ln k - psi(k) = ln E[X] - E[ln X], whose left side falls from infinity to 0 over the shapes k."""
    gap = math.log(mean) - mean_log
    require(
        gap > 0.0, f"mean_log = {mean_log:g} must be below ln(mean) = {math.log(mean):g}, whatever the distribution"
    )
    require(1e-12 < gap < 1e3, f"ln(mean) - mean_log = {gap:g} is too small or too large for a gamma distribution")

    def excess(log_shape):
        shape = math.exp(log_shape)
        return log_shape - float(digamma(shape)) - gap

    # 1/(2k) < ln k - psi(k) < 1/k brackets the shape
    log_shape = brentq(excess, math.log(0.4 / gap), math.log(1.1 / gap), xtol=1e-15, rtol=1e-15)
    shape = math.exp(log_shape)
    return "gamma", {"shape": shape, "scale": mean / shape}


def _positive_with_mean_std(mean, std):
    variation = std / mean
    require(
        variation < 1.0 + 1e-9,
        f"std/mean = {variation:g} above 1: on (0, inf) no distribution of greatest entropy exists; "
        "name one that fits, such as lognormal or gamma, or state mean and mean_log",
    )
    if variation > 1.0 - 1e-9:
        return "exponential", {"mean": mean}

    def excess(cut):
        first, spread = _cut_normal(cut)
        return spread / first - variation

    greatest = excess(FARTHEST_CUT) + variation
    require(
        variation < greatest,
        f"std/mean = {variation:g}, between {greatest:.4f} and 1, is exponential but for its last digits; "
        "state the mean alone",
    )
    cut = brentq(excess, -1.0 / variation - 1.0, FARTHEST_CUT, xtol=1e-14, rtol=1e-14)
    scale = mean / _cut_normal(cut)[0]
    return "truncated_normal", {"mean": -cut * scale, "std": scale, "low": 0.0}


def _cut_normal(cut) -> tuple[float, float]:
    """Mean above the cut and deviation of a standard normal variable cut off below `cut`."""
    tail = Truncated(stats.norm(), cut, math.inf)
    return tail.mean() - cut, tail.std()


FORMS = {
    frozenset({"low", "high"}): _between,
    frozenset({"low", "high", "mean"}): _between_with_mean,
    frozenset({"low", "high", "mean", "std"}): _between_with_mean_std,
    frozenset({"mean", "std"}): lambda **parameters: ("normal", parameters),
    frozenset({"positive", "mean"}): lambda **parameters: ("exponential", parameters),
    frozenset({"positive", "mean", "std"}): _positive_with_mean_std,
    frozenset({"positive", "mean", "mean_log"}): _positive_with_mean_log,
    frozenset({"positive", "mean_log", "std_log"}): lambda **parameters: ("lognormal", parameters),
}
"""The distribution of greatest entropy by the set of facts that is known."""
