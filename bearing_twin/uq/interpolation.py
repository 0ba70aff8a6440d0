"""One uncertain input and no closed form: a few runs, a polynomial through them, and its change of variable.

Section 6 of paper 3: with one stochastic parameter a numerical function of it is enough, and 10 to 50 runs suffice.
The function is a polynomial in the normal score of the input, from runs at Chebyshev's points, straight beyond the last
of them. Its degree is that of which each run is best foretold by the others (least leave-one-out error), so that noise
of runs is not followed; this error is told. Runs are doubled, the old ones kept, until it is below TOLERANCE. Kinks and
jumps spoil it, and the error says so.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.chebyshev import chebvander
from scipy.special import ndtr, ndtri

from bearing_twin.errors import StudyError
from bearing_twin.uq.change_of_variable import Derived, derive
from bearing_twin.uq.inputs import Input

REACHES = (4.0, 3.0)  # normal scores of the last points; the next where a run fails at the first
LADDER = (9, 17, 33)  # runs
TOLERANCE = 1e-4
SPARE = 3  # runs more than the degree, at least


class Interpolated(NamedTuple):
    """The distribution by all runs and `before` their last doubling; the runs' inputs and quantities (n,).

    `error`: root mean square by which runs are missed by the polynomial of the others, over the deviation. `left_out`:
    probability of the inputs beyond the last points, where the function goes on straight.
    """

    derived: Derived
    before: Derived
    at: np.ndarray
    values: np.ndarray
    error: float
    left_out: float


def interpolate(source: Input, function: Callable[[np.ndarray], np.ndarray]) -> Interpolated:
    """The distribution of y = g(X) by LADDER runs of `function` (n,) -> (n,), NaN where a run fails.

    Raises StudyError where a run fails within the last of REACHES, or g is not monotone: then an ensemble is the way.
    """
    for reach in REACHES:
        scores = _points(reach, LADDER[0])
        values = function(source.at_score(scores))
        if np.isfinite(values).all():
            break
    before = None
    for count in LADDER[1:]:
        fresh = _points(reach, count)
        new = np.empty(count)
        new[::2], new[1::2] = values, function(source.at_score(fresh[1::2]))
        if not np.isfinite(new).all():
            where = source.at_score(fresh[~np.isfinite(new)][0])
            raise StudyError(
                f"the run at {source.key} = {where:g} fails, and an interpolant needs every run; choose the method "
                f"ensemble, or narrow {source.key}"
            )
        before = derive(source, through(source, source.at_score(scores), values))
        scores, values = fresh, new
        derived = derive(source, through(source, source.at_score(scores), values))
        error = _polynomial(scores, values)[1] / derived.std
        if error < TOLERANCE:
            break
    return Interpolated(derived, before, source.at_score(scores), values, error, 2.0 * float(ndtr(-reach)))


def through(source: Input, at: np.ndarray, values: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The function (n,) -> (n,) by `values` at the inputs `at`, which are Chebyshev's points in the score."""
    scores = _score(source, at)
    polynomial, last = _polynomial(scores, values)[0], scores[-1]
    slope = polynomial.deriv()

    def function(x):
        score = _score(source, x)
        inside = np.clip(score, -last, last)
        return polynomial(inside) + slope(inside) * (score - inside)

    return function


def _points(reach, count):
    """Chebyshev's points of the second kind, rising; every other one of 2 n - 1 is one of n."""
    return reach * np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, count))


def _polynomial(scores, values):
    """The polynomial of the best degree, and the root mean square of its leave-one-out errors."""
    basis, _ = np.linalg.qr(chebvander(scores / scores[-1], len(scores) - SPARE))
    fitted = np.cumsum(basis * (values @ basis), axis=1)
    missed = (values[:, None] - fitted) / (1.0 - np.cumsum(basis**2, axis=1))
    errors = np.sqrt(np.mean(missed**2, axis=0))
    degree = int(np.argmin(errors))
    return Chebyshev.fit(scores, values, degree, domain=[scores[0], scores[-1]]), float(errors[degree])


def _score(source, x):
    below, above = source.cdf(x), source.distribution.sf(x)
    return np.where(below < 0.5, ndtri(below), -ndtri(above))
