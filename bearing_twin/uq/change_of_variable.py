"""One uncertain input X and a monotone quantity y = g(X): its distribution by change of variable, without sampling.

Paper 3, eqs. (6) to (10): with psi the inverse of g, P(y < m) = P(X < psi(m)) where g rises, and the density of y is
f(psi(y)) |psi'(y)|. The inverse is found by regula falsi in the normal score of X, g' by differences of fourth order.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import trapezoid
from scipy.special import ndtr

from bearing_twin.errors import StatisticError, StudyError
from bearing_twin.uq.inputs import Input
from bearing_twin.uq.tails import SURE_SCORE, Tails, refuse_missing_moment, tails

NOISE = 1e-9  # of the range of y; a step back below it is rounding
DIFFERENCE = 1e-3  # step of the derivative, in distances to the nearer end of the support or deviations
ITERATIONS = 60
NEGLIGIBLE = 1e-8
COUNTED_SCORE = 8.0  # beyond it 6e-16 of the probability is left, less than rounding


@dataclass(frozen=True)
class Derived:
    """The distribution of y = g(X), made by `derive`; y in the unit of the quantity.

    `mean`, `std`, `skewness` and `kurtosis` (3 for a normal one) raise StatisticError with the reason where
    they do not exist.
    """

    source: Input
    function: Callable
    found: Tails
    rising: bool

    def quantile(self, p):
        """Value(s) of y at probability p in (0, 1)."""
        p = np.asarray(p, float)
        return self.function(np.atleast_1d(self.source.ppf(p) if self.rising else self.source.isf(p))).reshape(p.shape)[
            ()
        ]

    def cdf(self, y):
        """Probability of a value not above y (eq. 11)."""
        score = self._score(y)
        return ndtr(score if self.rising else -score)

    def pdf(self, y):
        """Density at y [1/unit of y] (eq. 8); 0 outside the range of g."""
        score = self._score(y)
        inside = np.isfinite(score)
        x = self.source.at_score(np.where(inside, score, 0.0))
        with np.errstate(divide="ignore"):
            return np.where(inside, self.source.pdf(x) / np.abs(self._derivative(x)), 0.0)[()]

    @cached_property
    def mean(self) -> float:
        refuse_missing_moment(self.source, self.found, "mean")
        middle = float(self.quantile(0.5))
        return middle + self._moment(1, middle)

    @cached_property
    def std(self) -> float:
        refuse_missing_moment(self.source, self.found, "std")
        return math.sqrt(self._moment(2, self.mean))

    @cached_property
    def skewness(self) -> float:
        refuse_missing_moment(self.source, self.found, "skewness")
        return self._moment(3, self.mean) / self.std**3

    @cached_property
    def kurtosis(self) -> float:
        refuse_missing_moment(self.source, self.found, "kurtosis")
        return self._moment(4, self.mean) / self.std**4

    def _moment(self, order, center):
        """E[(y - center)^order] by the trapezoidal rule in the normal score, which converges exponentially here.

        Beyond the last finite value a power tail y ~ u^-s adds (y - center)^order u / (1 - order s). Relative errors
        are 1e-10, but 1e-4 where order s is within 1 % of the 1 at which the moment ceases to exist.
        """
        scores, values = self.found.scores, (self.found.values - center) ** order
        terms = values * np.exp(-0.5 * scores**2) / math.sqrt(2.0 * math.pi)
        total = trapezoid(terms, scores)
        for index, exponent in ((0, self.found.lower), (-1, self.found.upper)):
            if exponent == 0.0 and abs(terms[index]) > NEGLIGIBLE * trapezoid(np.abs(terms), scores):
                raise StatisticError(
                    f"values beyond {self.source.key} = {self.source.at_score(scores[index]):g} still count in the "
                    f"moment of order {order}, and doubles reach no farther; ask for quantiles"
                )
            total += values[index] * ndtr(-abs(scores[index])) / (1.0 - order * exponent)
        return float(total)

    def _score(self, y):
        """Normal score of X at which g takes the value y; -inf or inf outside the range of g.

        The table of g brackets it; then the regula falsi with Illinois' halving, on all y at once.
        """
        shape, y = np.shape(y), np.atleast_1d(np.asarray(y, float))
        sign = 1.0 if self.rising else -1.0
        scores, table = self.found.scores, sign * self.found.values
        place = np.clip(np.searchsorted(table, sign * y), 1, len(table) - 1)
        low, high = scores[place - 1], scores[place]
        old, new, at_old, at_new = low, high, table[place - 1] - sign * y, table[place] - sign * y
        for _ in range(ITERATIONS):
            with np.errstate(all="ignore"):
                guess = new - at_new * (new - old) / (at_new - at_old)
            guess = np.clip(np.where(np.isfinite(guess), guess, new), low, high)
            moved = np.max(np.abs(guess - new), initial=0.0)
            at_guess = sign * (self.function(self.source.at_score(guess)) - y)
            crossed = at_guess * at_new <= 0.0
            old, at_old = np.where(crossed, new, old), np.where(crossed, at_new, 0.5 * at_old)
            new, at_new = guess, at_guess
            if moved < 1e-14:
                break
        score = np.where(sign * y < table[0], -np.inf, np.where(sign * y > table[-1], np.inf, new))
        return score.reshape(shape)

    def _derivative(self, x):
        shape, source, x = np.shape(x), self.source, np.atleast_1d(x)
        room = np.minimum(np.minimum(x - source.low, source.high - x), source.std if source.std > 0.0 else np.inf)
        step = DIFFERENCE * room
        near = self.function(x + step) - self.function(x - step)
        far = self.function(x + 2.0 * step) - self.function(x - 2.0 * step)
        return ((8.0 * near - far) / (12.0 * step)).reshape(shape)


def derive(source: Input, function) -> Derived:
    """The distribution of y = g(X) for one input; `function` is g, vectorised (n,) -> (n,) over values of X in SI.

    Raises StudyError where the input has no density, or g is not finite or flat over a stretch within 4 deviations (in
    normal scores), or not monotone within 8: then an ensemble is the way. Where g turns farther out, it ends.
    """
    if not source.has_density:
        raise StudyError(f"{source.key} is {source.distribution_name} and has no density; choose the method ensemble")
    found = tails(source, function)
    y = found.values[np.abs(found.scores) <= SURE_SCORE]
    sign = np.sign(y[-1] - y[0])
    steps = sign * np.diff(y)
    if sign != 0.0:
        found = _until_it_turns(found, sign, NOISE * abs(y[-1] - y[0]))
    if sign == 0.0 or np.min(sign * np.diff(found.values)) < -NOISE * abs(y[-1] - y[0]):
        raise StudyError(f"the quantity is not a monotone function of {source.key}; choose the method ensemble")
    if np.any((steps[1:] == 0.0) & (steps[:-1] == 0.0)):
        raise StudyError(f"the quantity does not change over a stretch of {source.key}; choose the method ensemble")
    return Derived(source, function, found, bool(y[-1] > y[0]))


def _until_it_turns(found: Tails, sign: float, noise: float) -> Tails:
    """The part of `found` between its turns beyond COUNTED_SCORE, of which nothing is known farther out."""
    back = np.flatnonzero(sign * np.diff(found.values) < -noise)
    first = np.max(back[found.scores[back + 1] < -COUNTED_SCORE] + 1, initial=0)
    last = np.min(back[found.scores[back] > COUNTED_SCORE], initial=len(found.scores) - 1)
    lower = found.lower if first == 0 else 0.0
    upper = found.upper if last == len(found.scores) - 1 else 0.0
    return Tails(found.scores[first : last + 1], found.values[first : last + 1], lower, upper)
