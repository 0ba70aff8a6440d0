"""Which moments of a quantity exist: how fast it grows where an input runs into its tails.

With u the probability left on a tail of the input X, a quantity y = g(X) that grows as u^-s there has a moment of
order k only if k s < 1. For a gamma input of shape a and y = X^-p the lower tail has s = p/a: with the contact time of
spheres, tau ~ E^(-2/5), the mean is infinite for std/mean of E above 1.58, the variance above 1.118.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr, ndtr

from bearing_twin.errors import StatisticError, StudyError
from bearing_twin.uq.inputs import Input, Joint

FARTHEST_SCORE = 37.0  # probability 6e-300 is left beyond it
SURE_SCORE = 4.0  # within +-4 a quantity must be finite
STEP = 1.0 / 16.0
FAITHFUL = 1e-4  # relative; how well a quantile gives its probability back
FALLING = 0.9  # an exponent that falls by more when ln u doubles tends to 0
ORDERS = {"mean": 1, "std": 2, "skewness": 3, "kurtosis": 4}


class Tails(NamedTuple):
    """Scores (n,) within which the quantity is finite, its values (n,) there, the exponents s >= 0 of both tails."""

    scores: np.ndarray
    values: np.ndarray
    lower: float
    upper: float

    def has_moment(self, order: float) -> bool:
        return order * max(self.lower, self.upper) < 1.0


def tails(source: Input, function) -> Tails:
    """How `function`, vectorised over the input's values (n,) -> (n,), behaves out to the ends of the input.

    Exponents are measured between the last finite values, down to a probability of 6e-300. One that keeps falling
    (exponential, normal and lognormal tails) counts as 0. Raises StudyError where the quantity is not finite within
    4 deviations (in normal scores).
    """
    scores = np.arange(-FARTHEST_SCORE, FARTHEST_SCORE + 0.5 * STEP, STEP)
    with np.errstate(all="ignore"):
        at = source.at_score(scores)
        values = np.asarray(function(at), float)
        left = ndtr(-np.abs(scores))
        back = np.piecewise(at, [scores < 0.0], [source.cdf, source.distribution.sf])
    finite = np.isfinite(values) & np.isfinite(at)
    sure = np.abs(scores) <= SURE_SCORE
    if not finite[sure].all():
        where = at[sure][~finite[sure]][0]
        raise StudyError(f"the quantity is not finite at {source.key} = {where:g}: narrow the input")
    # near a bound other than 0 the digits of x run out before those of the probability: stop there
    usable = finite & (sure | (np.abs(back - left) < FAITHFUL * left))
    middle = len(scores) // 2
    first = middle - _run(usable[middle::-1]) + 1
    last = middle + _run(usable[middle:]) - 1
    depth = -log_ndtr(-np.abs(scores))
    lower = _exponent(depth[first : middle + 1][::-1], values[first : middle + 1][::-1])
    upper = _exponent(depth[middle : last + 1], values[middle : last + 1])
    return Tails(scores[first : last + 1], values[first : last + 1], lower, upper)


def tails_along(joint: Joint, function) -> Iterator[tuple[Input, Tails]]:
    """The same along each of several inputs that has a density, with the rest at their medians.

    `function` takes values (n, d) -> (n,). Right for products of powers of the inputs; inputs that only together
    reach an infinity are not found.
    """
    middle = joint.values(np.full((1, joint.dimension), 0.5))
    for index, source in enumerate(joint.inputs):
        if source.has_density:
            yield source, tails(source, _along(function, middle, index))


def refuse_missing_moment(source: Input, found: Tails, statistic: str) -> None:
    """Raise StatisticError with the reason where that statistic (a key of ORDERS) does not exist; else return."""
    order = ORDERS[statistic]
    if found.has_moment(order):
        return
    lower = found.lower >= found.upper
    power = "" if order == 1 else f" to the power {order}"
    raise StatisticError(
        f"the {statistic} does not exist: towards {'small' if lower else 'great'} {source.key} the quantity grows as "
        f"(probability left)^-{max(found.lower, found.upper):.3g}, and{power} that has no finite integral; "
        f"ask for quantiles, or give {source.key} a distribution that keeps away from there"
    )


def _along(function, middle, index):
    def one(at):
        values = np.repeat(middle, len(at), axis=0)
        values[:, index] = at
        return function(values)

    return one


def _run(flags):
    """Length of the run of True at the start."""
    stops = np.flatnonzero(~flags)
    return int(stops[0]) if len(stops) else len(flags)


def _exponent(depth, values):
    """Slope of ln |y| over -ln u at the end of a tail, `depth` = -ln u rising from the middle; 0 where it falls off."""
    end, size = depth[-1], np.log(np.maximum(np.abs(values), 1e-320))

    def slope(low, high):
        a, b = (float(np.interp(share * end, depth, size)) for share in (low, high))
        return (b - a) / ((high - low) * end)

    last, before = slope(0.9, 1.0), slope(0.45, 0.5)
    if last < 1e-6 or last < FALLING * before:
        return 0.0
    return last if math.isfinite(last) else math.inf
