"""Propagation of one or a few inputs without sampling: existing moments, change of variable, polynomial chaos.

Which moments exist depends on how fast the quantity grows on the tails of an input.

With u the probability left on a tail of the input X, a quantity y = g(X) that grows as u^-s there has a moment of
order k only if k s < 1. For a gamma input of shape a and y = X^-p the lower tail has s = p/a: with the contact time of
spheres, tau ~ E^(-2/5), the mean is infinite for std/mean of E above 1.58, the variance above 1.118.
"""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.integrate import trapezoid
from scipy.special import log_ndtr, ndtr, ndtri

from bearing_twin.base.errors import StatisticError, StudyError, import_optional
from bearing_twin.uq.inputs import Input, Joint
from bearing_twin.uq.statistics import mode_indices

FARTHEST_SCORE = 37.0  # probability 6e-300 is left beyond it
SURE_SCORE = 4.0  # within +-4 a quantity must be finite
SCORES = np.arange(-FARTHEST_SCORE, FARTHEST_SCORE + 1.0 / 32.0, 1.0 / 16.0)
COARSE = np.arange(-6.0, 6.5)  # scores at which runs are made to find an exponent
LIGHT = 0.1  # exponent
FAITHFUL = 1e-4  # relative error of the probability of a quantile
FALLING = 0.9  # an exponent that falls by more when ln u doubles tends to 0
ORDERS = {"mean": 1, "std": 2, "skewness": 3}


class Tails(NamedTuple):
    """Scores (n,) within which the quantity is finite, its values (n,) there, the exponents s >= 0 of both tails."""

    scores: np.ndarray
    values: np.ndarray
    lower: float
    upper: float

    def has_moment(self, order: float) -> bool:
        return order * max(self.lower, self.upper) < 1.0


def tails_of(source: Input, function, scores=SCORES, strict=True) -> Tails:
    """The behaviour of `function`, vectorised over values (n,) of the input, out to the ends of the input.

    Exponents are measured between the last values that are finite and not lost to underflow, at the latest at a
    probability of 6e-300; one that keeps falling (exponential, normal and lognormal tails) counts as 0. Where `strict`
    raises StudyError if the quantity is not finite within 4 deviations (in normal scores).
    """
    with np.errstate(all="ignore"):
        x = np.fmax.accumulate(source.at_score(scores))  # SciPy's narrow gamma distributions step back near -4.5
        values = np.asarray(function(x), float)
        probability = ndtr(-np.abs(scores))
        recovered = np.piecewise(x, [scores < 0.0], [source.cdf, source.distribution.sf])
    sure = np.abs(scores) <= SURE_SCORE
    finite = np.isfinite(values) & np.isfinite(x)
    if strict and not finite[sure].all():
        failing = x[sure][~finite[sure]][0]
        raise StudyError(f"the quantity is not finite at {source.key} = {failing:g}: narrow the input")
    # near a bound other than 0 the digits of x run out before those of the probability; beyond it y may underflow to 0
    usable = finite & ((sure & strict) | ((np.abs(recovered - probability) < FAITHFUL * probability) & (values != 0.0)))
    middle = len(scores) // 2
    first, last = _run_around(middle, usable)
    depth = -log_ndtr(-np.abs(scores))
    lower = _exponent(depth[first : middle + 1][::-1], values[first : middle + 1][::-1])
    upper = _exponent(depth[middle : last + 1], values[middle : last + 1])
    if strict:  # lost digits there matter to no moment
        first, last = _run_around(middle, usable | (finite & (np.abs(scores) <= COUNTED_SCORE)))
    return Tails(scores[first : last + 1], values[first : last + 1], lower, upper)


def is_heavy(source: Input) -> bool:
    """True where a power of the input up to the third may have no mean, deviation or skewness.

    Near 0 a gamma variable of shape a has the probability x^a, a Pareto or Student variable runs to infinity as a power
    of its probability: exponents 1/a below 0.1 matter only for powers above the third.
    """
    if not source.has_density:
        return False
    powers = [np.abs, np.reciprocal] if source.low == 0.0 else [np.abs]
    return any(max(tails_of(source, power, strict=False)[2:]) > LIGHT for power in powers)


def refuse_missing_moment(source: Input, tails: Tails, statistic: str) -> None:
    """Raise StatisticError with the reason where that statistic (a key of ORDERS) does not exist; else return."""
    order = ORDERS[statistic]
    if tails.has_moment(order):
        return
    lower = tails.lower >= tails.upper
    power = "" if order == 1 else f" to the power {order}"
    raise StatisticError(
        f"the {statistic} does not exist: towards {'small' if lower else 'great'} {source.key} the quantity grows as "
        f"(probability left)^-{max(tails.lower, tails.upper):.3g}, and{power} that has no finite integral; "
        f"ask for quantiles, or give {source.key} a distribution that keeps away from there"
    )


def _run_around(middle, flags):
    """First and last index of the run of True around the middle, which belongs to it in any case."""
    stops = np.flatnonzero(~flags)
    return np.max(stops[stops < middle] + 1, initial=0), np.min(stops[stops > middle] - 1, initial=len(flags) - 1)


def _exponent(depth, values):
    """Slope of ln |y| over -ln u at the end of a tail, `depth` = -ln u rising from the middle; 0 where it falls off."""
    if len(depth) < 3:
        return 0.0
    end, size = depth[-1], np.log(np.maximum(np.abs(values), 1e-320))

    def slope(low, high):
        a, b = (float(np.interp(share * end, depth, size)) for share in (low, high))
        return (b - a) / ((high - low) * end)

    last, before = slope(0.9, 1.0), slope(0.45, 0.5)
    if last < 1e-6 or last < FALLING * before:
        return 0.0
    return last if math.isfinite(last) else math.inf


# One uncertain input X and a monotone quantity y = g(X): its distribution by change of variable, without sampling.
#
# Paper 3, eqs. (6) to (10): with psi the inverse of g, P(y < m) = P(X < psi(m)) where g rises, and the density of y is
# f(psi(y)) |psi'(y)|. Here X is its normal score, so that f is the normal density whatever X is and g has no bounds.

NOISE = 1e-9  # of the range of y; a step back below it is rounding
DIFFERENCE = 2e-3  # step of the derivative by the normal score
BISECTIONS = 50  # of 1/16 of a deviation
NEGLIGIBLE = 1e-8
GRID, BEYOND = 2001, 3.3  # points of a density whose modes are counted, and the normal score of the last
SHALLOW = 1e-3  # of the greatest density
COUNTED_SCORE = 8.0  # beyond it 6e-16 of the probability is left, less than rounding


@dataclass(frozen=True)
class Derived:
    """The distribution of y = g(X), made by `derive`; y in the unit of the quantity.

    `mean`, `std` and `skewness` raise StatisticError with the reason where they do not exist.
    """

    source: Input
    function: Callable
    tails: Tails
    rising: bool

    def quantile(self, p):
        """Value(s) of y at probability p in (0, 1)."""
        x = np.atleast_1d(self.source.ppf(p) if self.rising else self.source.isf(p))
        return self.function(x).reshape(np.shape(p))[()]

    def cdf(self, y):
        """Probability of a value not above y (eq. 11)."""
        score = self._score(y)
        return ndtr(score if self.rising else -score)

    def pdf(self, y):
        """Density at y [1/unit of y] (eq. 8); 0 outside the range of g."""
        score = self._score(y)
        inside = np.isfinite(score)
        return np.where(inside, self._density(np.where(inside, score, 0.0)), 0.0)[()]

    @cached_property
    def modes(self) -> int:
        """Number of modes of the density but for its outermost parts; lower ones than SHALLOW are rounding."""
        density = self._density(np.linspace(-BEYOND, BEYOND, GRID))
        return len(mode_indices(density, SHALLOW))

    @cached_property
    def mean(self) -> float:
        refuse_missing_moment(self.source, self.tails, "mean")
        middle = float(self.quantile(0.5))
        return middle + self._moment(1, middle)

    @cached_property
    def std(self) -> float:
        refuse_missing_moment(self.source, self.tails, "std")
        return math.sqrt(self._moment(2, self.mean))

    @cached_property
    def skewness(self) -> float:
        refuse_missing_moment(self.source, self.tails, "skewness")
        return self._moment(3, self.mean) / self.std**3

    def _moment(self, order, center):
        """E[(y - center)^order] by the trapezoidal rule in the normal score, which converges exponentially here.

        Beyond the last finite value a power tail y ~ u^-s adds (y - center)^order u / (1 - order s). Relative errors
        are 1e-10, but 1e-4 where order s is within 1 % of 1, at which the moment ceases to exist.
        """
        scores, values = self.tails.scores, (self.tails.values - center) ** order
        terms = values * np.exp(-0.5 * scores**2) / math.sqrt(2.0 * math.pi)
        total = trapezoid(terms, scores)
        for index, exponent in ((0, self.tails.lower), (-1, self.tails.upper)):
            if exponent == 0.0 and abs(terms[index]) > NEGLIGIBLE * trapezoid(np.abs(terms), scores):
                raise StatisticError(
                    f"values beyond {self.source.key} = {self.source.at_score(scores[index]):g} still count in the "
                    f"moment of order {order}, and doubles reach no farther; ask for quantiles"
                )
            total += values[index] * ndtr(-abs(scores[index])) / (1.0 - order * exponent)
        return float(total)

    def _score(self, y):
        """Normal score of X at which g takes the value y, by bisection; -inf or inf outside the range of g."""
        sign = 1.0 if self.rising else -1.0
        target, scores, table = sign * np.asarray(y, float), self.tails.scores, sign * self.tails.values
        index = np.clip(np.searchsorted(table, target), 1, len(table) - 1)
        low, high = scores[index - 1], scores[index]
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            below = sign * self._at_score(middle) < target
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return np.where(target < table[0], -np.inf, np.where(target > table[-1], np.inf, 0.5 * (low + high)))

    def _density(self, score):
        """Density of y at a normal score of X."""
        with np.errstate(divide="ignore"):
            return np.exp(-0.5 * score**2) / math.sqrt(2.0 * math.pi) / np.abs(self._slope(score))

    def _slope(self, score):
        """Derivative of y by the normal score, of fourth order."""
        near, far = (
            self._at_score(score + step) - self._at_score(score - step) for step in (DIFFERENCE, 2.0 * DIFFERENCE)
        )
        return (8.0 * near - far) / (12.0 * DIFFERENCE)

    def _at_score(self, score):
        return self.function(self.source.at_score(np.ravel(score))).reshape(np.shape(score))


def derive(source: Input, function) -> Derived:
    """The distribution of y = g(X) for one input; `function` is g, vectorised (n,) -> (n,) over values of X in SI.

    Raises StudyError where the input has no density, or g is not finite or flat over a stretch within 4 deviations (in
    normal scores), or not monotone within 8: then use an ensemble. Where g turns farther out, the distribution ends.
    """
    if not source.has_density:
        raise StudyError(f"{source.key} is {source.distribution_name} and has no density; choose the method ensemble")
    tails = tails_of(source, function)
    y = tails.values[np.abs(tails.scores) <= SURE_SCORE]
    sign = np.sign(y[-1] - y[0])
    steps = sign * np.diff(y)
    if sign != 0.0:
        tails = _until_it_turns(tails, sign, NOISE * abs(y[-1] - y[0]))
    if sign == 0.0 or np.min(sign * np.diff(tails.values)) < -NOISE * abs(y[-1] - y[0]):
        raise StudyError(f"the quantity is not a monotone function of {source.key}; choose the method ensemble")
    if np.any((steps[1:] == 0.0) & (steps[:-1] == 0.0)):
        raise StudyError(f"the quantity does not change over a stretch of {source.key}; choose the method ensemble")
    return Derived(source, function, tails, bool(y[-1] > y[0]))


def _until_it_turns(tails: Tails, sign: float, noise: float) -> Tails:
    """The part of `tails` between its turns beyond COUNTED_SCORE, of which nothing is known farther out."""
    turns = np.flatnonzero(sign * np.diff(tails.values) < -noise)
    first = np.max(turns[tails.scores[turns + 1] < -COUNTED_SCORE] + 1, initial=0)
    last = np.min(turns[tails.scores[turns] > COUNTED_SCORE], initial=len(tails.scores) - 1)
    lower = tails.lower if first == 0 else 0.0
    upper = tails.upper if last == len(tails.scores) - 1 else 0.0
    return Tails(tails.scores[first : last + 1], tails.values[first : last + 1], lower, upper)


# Polynomial chaos: D. Xiu and G. E. Karniadakis, The Wiener-Askey polynomial chaos, SIAM J. Sci. Comput. 24 (2002), by
# chaospy (J. Feinberg and H. P. Langtangen, J. Comput. Sci. 11, 2015). Uniform and truncated exponential inputs take a
# uniform germ and Legendre polynomials, all others their normal score and Hermite polynomials; with a copula all germs
# are normal. Coefficients are projections by the tensor Gauss rule of degree + 1 points a germ, up to a total degree;
# mean, deviation and Sobol indices are sums over them. The error is measured at the nodes of the next lower degree (of
# the higher one for degree 1), which had no part in the fit, and the degree of the least error is taken, so that noise
# is not followed. The error falls exponentially with the degree for smooth quantities; kinks and jumps spoil that.

MOST_INPUTS = 4
GREATEST_DEGREE = 12
MOST_RUNS = 5000
TOLERANCE, PATIENCE = 1e-4, 3  # of the error; degrees without a smaller one, after which it is not raised further
UNIFORM_GERMS = ("uniform", "truncated_exponential")


class Chaos(NamedTuple):
    """A polynomial chaos expansion of a quantity of total `degree`: its mean, deviation and Sobol indices.

    `first` and `total` (inputs,) are the shares of the variance that an input explains alone and takes part in; they
    are for independent inputs. `error` is the root mean square error at nodes of another degree over the
    deviation of the quantity; `runs` counts all evaluations, these included. `predict` gives the quantity (n,) at
    points (n, inputs) of the unit cube.
    """

    degree: int
    mean: float
    std: float
    first: np.ndarray
    total: np.ndarray
    error: float
    runs: int
    predict: Callable[[np.ndarray], np.ndarray]


def expand(joint: Joint, function, degree=None) -> Chaos:
    """The polynomial chaos expansion of a quantity.

    Parameters
    ----------
    function
        Of values (n, d) of the inputs [SI]; returns (n,).
    degree : int, optional
        Total degree. Without it the degree is raised until the error is below TOLERANCE or falls no more, or the next
        degree would take more than MOST_RUNS runs; `error` then says what was reached.

    Raises StudyError for no or more than four uncertain inputs, inputs without a density, or a quantity that is not
    finite where it is needed; BearingTwinError without chaospy.
    """
    chaospy = import_optional("chaospy", "chaos")
    _check_expandable(joint)
    germs = {k: joint.independent and joint.inputs[k].distribution_name in UNIFORM_GERMS for k in joint.uncertain}
    density = chaospy.J(*(chaospy.Uniform(-1, 1) if uniform else chaospy.Normal() for uniform in germs.values()))
    runs = 0

    @functools.cache
    def at_nodes(order: int):
        """Nodes and weights of the Gauss rule of a degree, and the quantity there."""
        nonlocal runs
        nodes, weights = chaospy.generate_quadrature(order, density, rule="gaussian")
        unit = np.full((nodes.shape[1], joint.dimension), 0.5)
        for germ, (index, uniform) in zip(nodes, germs.items(), strict=True):
            unit[:, index] = 0.5 * (germ + 1.0) if uniform else ndtr(germ)
        runs += len(unit)
        return nodes, weights, _evaluated(joint, function, unit)

    trials = []
    for order in [degree] if degree is not None else range(1, GREATEST_DEGREE + 1):
        basis = chaospy.generate_expansion(order, density, normed=True)
        polynomial, coefficients = chaospy.fit_quadrature(basis, *at_nodes(order), retall=1)
        std = float(np.sqrt(np.sum(coefficients[1:] ** 2)))
        nodes, weights, values = at_nodes(order - 1 or 2)
        error = float(np.sqrt(weights @ (polynomial(*nodes) - values) ** 2)) / (std or 1.0)
        trials.append((error, order, polynomial, coefficients, std))
        best = min(trials, key=lambda trial: trial[0])
        if error < TOLERANCE or (order + 2) ** len(nodes) + runs > MOST_RUNS or order - best[1] == PATIENCE:
            break
    error, order, polynomial, coefficients, std = best
    squares = coefficients[1:] ** 2
    used = chaospy.glexindex(order + 1, dimensions=len(germs), graded=True, reverse=True)[1:] > 0
    first, total = np.zeros((2, joint.dimension))
    first[[*germs]] = squares @ (used & (used.sum(axis=1, keepdims=True) == 1)) / (squares.sum() or 1.0)
    total[[*germs]] = squares @ used / (squares.sum() or 1.0)

    def predict(unit):
        return polynomial(*(2.0 * unit[:, k] - 1.0 if uniform else ndtri(unit[:, k]) for k, uniform in germs.items()))

    return Chaos(order, float(coefficients[0]), std, first, total, error, runs, predict)


def _check_expandable(joint) -> None:
    """Raises StudyError where an expansion does not take the uncertain inputs."""
    for index in joint.uncertain:
        source = joint.inputs[index]
        if not source.has_density:
            raise StudyError(
                f"{source.key} takes single values: polynomial chaos needs a density; choose the method ensemble"
            )
    if not 1 <= (count := len(joint.uncertain)) <= MOST_INPUTS:
        raise StudyError(
            f"polynomial chaos takes 1 to {MOST_INPUTS} uncertain inputs, not {count}; choose the method ensemble"
        )


def _evaluated(joint, function, unit):
    values = joint.values(unit)
    result = np.asarray(function(values), float)
    if not np.isfinite(result).all():
        failing = values[~np.isfinite(result)][0]
        point = ", ".join(f"{key} = {value:g}" for key, value in zip(joint.keys, failing, strict=True))
        raise StudyError(f"the quantity is not finite at {point}: choose the method ensemble, or narrow the inputs")
    return result
