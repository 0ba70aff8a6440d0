"""From what is known of a quantity to the distribution of greatest entropy that knows no more (paper 3, eq. 3).

Greatest entropy under given expectations of functions t_i(x) has the density exp(sum of l_i t_i(x)) on the support:

| known | distribution |
|---|---|
| low, high | uniform |
| low, high, mean | truncated exponential (uniform where the mean is the middle) |
| low, high, mean, std | truncated normal, while std is below that of the truncated exponential |
| mean, std | normal |
| positive, mean | exponential |
| positive, mean, std | normal truncated at 0, while std < mean; exponential at std = mean; none beyond |
| positive, mean, mean_log | gamma |
| positive, mean_log, std_log | lognormal |

Paper 3 says that positiveness and a bounded second moment give the gamma distribution. They do not: the gamma
distribution follows from E[X] and E[ln X]. `mean_log` is E[ln X] and `std_log` the deviation of ln X, X in SI units.
"""

import math
from collections.abc import Mapping

import numpy as np
from scipy import stats
from scipy.optimize import brentq, root
from scipy.special import digamma

from bearing_twin.base.errors import StudyError
from bearing_twin.base.parameters import echo, unknown
from bearing_twin.uq.distributions import FARTHEST_CUT, Truncated

FACTS = ("positive", "low", "high", "mean", "std", "mean_log", "std_log")
PLENTY = 9.0  # deviations between mean and bound beyond which the bound cuts nothing off
LEAST_SPREAD = 0.0025  # deviation over range that the quadrature between two bounds resolves


def greatest_entropy(facts: Mapping) -> tuple[str, dict]:
    """Name and parameters of the distribution of greatest entropy, as `inputs.DISTRIBUTIONS` takes them.

    `facts` holds numbers under the names of FACTS and `positive` True or False. Constraints are met to 1e-10.
    Raises StudyError with the reason where no such distribution exists or the facts contradict each other.
    """
    wrong = [fact for fact in facts if fact not in FACTS]
    if wrong:
        raise StudyError(f"{echo(wrong[0])} is no fact; {unknown(wrong[0], FACTS)}")
    if not isinstance(facts.get("positive", True), bool):
        raise StudyError(f"positive = {echo(facts['positive'])} must be true or false")
    given = frozenset(fact for fact in facts if fact != "positive" or facts[fact])
    if given not in _SOLVERS:
        legal = "; ".join(", ".join(fact for fact in FACTS if fact in one) for one in _SOLVERS)
        raise StudyError(
            f"no distribution of greatest entropy is known here for {', '.join(sorted(given)) or 'nothing'}; "
            f"state one of these: {legal}"
        )
    for fact in given & {"std", "std_log"}:
        _require(facts[fact] > 0.0, f"{fact} must be above 0; a certain value is fixed")
    _require("positive" not in given or facts.get("mean", 1.0) > 0.0, "the mean of a positive quantity is above 0")
    return _SOLVERS[given](**{fact: facts[fact] for fact in FACTS if fact in given and fact != "positive"})


def _require(condition, reason):
    if not condition:
        raise StudyError(reason)


def _between(low, high):
    _require(low < high, f"low = {low:g} must be below high = {high:g}")
    return "uniform", {"low": low, "high": high}


def _between_with_mean(low, high, mean):
    _require(low < mean < high, f"mean = {mean:g} must lie between low = {low:g} and high = {high:g}")
    if abs(mean - 0.5 * (low + high)) < 1e-9 * (high - low):
        return _between(low, high)
    return "truncated_exponential", {"low": low, "high": high, "mean": mean}


def _between_with_mean_std(low, high, mean, std):
    """exp(l t + q t^2) on 0 <= t <= 1 with q < 0, with l and q from E[t] and E[t^2]."""
    _require(low < mean < high, f"mean = {mean:g} must lie between low = {low:g} and high = {high:g}")
    share, spread = (mean - low) / (high - low), std / (high - low)
    if min(share, 1.0 - share) > PLENTY * spread:  # the bounds cut nothing off
        return "truncated_normal", {"mean": mean, "std": std, "low": low, "high": high}
    _require(spread > LEAST_SPREAD, "std is so small against the bounds that one of them says nothing; leave it out")
    _require(spread**2 < share * (1.0 - share), "no distribution between these bounds has this mean and so great a std")
    points, weights = np.polynomial.legendre.leggauss(16)  # in each of 64 pieces
    points = (np.arange(64)[:, None] + 0.5 * (points + 1.0)).ravel() / 64.0
    powers, weights = np.stack([points, points**2]), np.tile(weights, 64)

    def off(at):
        """Errors of both moments, and their derivatives by l and q: the covariances of t and t^2."""
        exponent = at @ powers
        mass = weights * np.exp(exponent - exponent.max())
        mass /= mass.sum()
        centred = powers - (powers @ mass)[:, None]
        return powers @ mass - (share, spread**2 + share**2), (centred * mass) @ centred.T

    found = root(off, np.array([share, -0.5]) / spread**2, jac=True, tol=1e-14).x
    error = np.max(np.abs(off(found)[0]))
    _require(
        error < 1e-10 and found[1] < 0.0,
        f"with std = {std:g} the density of greatest entropy does not fall towards both bounds; "
        "give a smaller std, or leave it out, or name a beta distribution",
    )
    width = math.sqrt(-0.5 / found[1])
    center = float(found[0]) * width**2
    scale = high - low
    return "truncated_normal", {"mean": low + scale * center, "std": scale * width, "low": low, "high": high}


def _positive_with_mean_log(mean, mean_log):
    """ln k - psi(k) = ln E[X] - E[ln X], whose left side falls from infinity to 0 over the shapes k."""
    gap = math.log(mean) - mean_log
    _require(
        gap > 0.0, f"mean_log = {mean_log:g} must be below ln(mean) = {math.log(mean):g}, whatever the distribution"
    )
    _require(1e-12 < gap < 1e3, f"ln(mean) - mean_log = {gap:g} is too small or too large for a gamma distribution")

    def excess(log_shape):
        shape = math.exp(log_shape)
        return log_shape - float(digamma(shape)) - gap

    # 1/(2k) < ln k - psi(k) < 1/k brackets the shape
    log_shape = brentq(excess, math.log(0.4 / gap), math.log(1.1 / gap), xtol=1e-15, rtol=1e-15)
    shape = math.exp(log_shape)
    return "gamma", {"shape": shape, "scale": mean / shape}


def _positive_with_mean_std(mean, std):
    variation = std / mean
    _require(
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
    _require(
        variation < greatest,
        f"std/mean = {variation:g}, between {greatest:.4f} and 1, is exponential but for its last digits; "
        "state the mean alone",
    )
    cut = brentq(excess, -1.0 / variation - 1.0, FARTHEST_CUT, xtol=1e-14, rtol=1e-14)
    scale = mean / _cut_normal(cut)[0]
    return "truncated_normal", {"mean": -cut * scale, "std": scale, "low": 0.0}


def _cut_normal(cut) -> tuple[float, float]:
    """Mean above the cut and deviation of a standard normal variable cut off below `cut`."""
    rest = Truncated(stats.norm(), cut, math.inf)
    return rest.mean() - cut, rest.std()


_SOLVERS = {
    frozenset({"low", "high"}): _between,
    frozenset({"low", "high", "mean"}): _between_with_mean,
    frozenset({"low", "high", "mean", "std"}): _between_with_mean_std,
    frozenset({"mean", "std"}): lambda **given: ("normal", given),
    frozenset({"positive", "mean"}): lambda **given: ("exponential", given),
    frozenset({"positive", "mean", "std"}): _positive_with_mean_std,
    frozenset({"positive", "mean", "mean_log"}): _positive_with_mean_log,
    frozenset({"positive", "mean_log", "std_log"}): lambda **given: ("lognormal", given),
}

FORMS = tuple(_SOLVERS)
"""The sets of facts that can be known together."""
