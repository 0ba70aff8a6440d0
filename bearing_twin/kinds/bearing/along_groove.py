"""What a contact's curvatures decide along a groove, as polynomials in its direction, made once for a bearing.

Across a groove the gap between it and a ball has one curvature, along it one that follows from the radial part n of
the contact's normal alone (`closed_forms.groove_curvatures`): so do the coefficient of a law that follows curvatures,
and the semi-axes of a contact patch over the root of its approach. They are taken at Chebyshev's points and held as
polynomials in |n| - 1. All laws then cost the same, and slopes are exact.

The points reach to a right angle, or to where the groove's radius about the axis is FURTHEST times that at angle zero,
or as small a part of it: at 0.52 of the ball, to 67 degrees where balls are half the pitch circle. Beyond, the
coefficient stays. The polynomial is off by 6e-14 in a 6203 and by 3e-11 where balls are 0.4 of the pitch circle or more
(`tests/test_laws.py`).
"""

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from bearing_twin.contact.elasticity import Elasticity, fresh_coefficient
from bearing_twin.contact.ellipse import semi_axes
from bearing_twin.kinds.bearing.lubricant import film_numbers
from bearing_twin.shapes.closed_forms import groove_curvatures

TERMS = 10
FURTHEST = 1.7


def _points_and_fit() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Chebyshev's points (TERMS,) between -1 and 0, what makes a series of numbers there, and terms of the series.

    One after the other: the product of both matrices loses five digits.
    """
    places = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
    bases = (Chebyshev.basis(order)(places) for order in range(TERMS))
    series = np.array([basis * (2.0 - (order == 0)) / TERMS for order, basis in enumerate(bases)])
    powers = np.zeros((TERMS, TERMS))
    for order in range(TERMS):
        powers[: order + 1, order] = Chebyshev.basis(order).convert(kind=Polynomial)(Polynomial([1.0, 2.0])).coef
    return 0.5 * (places - 1.0), series, powers


_POINTS, _SERIES, _POWERS = _points_and_fit()


def _along(ball_radius, locus_radius, groove_radius, side, radials, what):
    """What `what(small, large)` makes of the gap's curvatures where the normal has these radial parts."""
    return what(*groove_curvatures(ball_radius, locus_radius, groove_radius, side * radials))


def _reach_of(locus_radius, groove_radius, side):
    """1 - |n| up to which the groove's radius about the axis is near that at angle zero."""
    level = abs(side * locus_radius / groove_radius + 1.0)  # the radius there, over that of the groove
    return min(1.0, level * (FURTHEST - 1.0 if side < 0.0 else 1.0 - 1.0 / FURTHEST))


def _terms(found, reach) -> tuple[float, ...]:
    """The terms of the polynomial through these numbers (TERMS,), and then how far |n| - 1 falls to."""
    return (*(_POWERS @ (_SERIES @ found) / reach ** np.arange(TERMS)).tolist(), -reach)


def axes_along(ball_radius, locus_radius, groove_radius, side) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The polynomials of a spot's semi-axes, major and minor, over the root of the approach [m^0.5]; see `terms_along`.

    They are those of `ellipse.semi_axes`.
    """
    reach, groove = _reach_of(locus_radius, groove_radius, side), (ball_radius, locus_radius, groove_radius, side)
    major, minor = _along(*groove, 1.0 + reach * _POINTS, lambda small, large: semi_axes(small, large, 1.0))
    return _terms(major, reach), _terms(minor, reach)


def terms_along(law: Elasticity, ball_radius, locus_radius, groove_radius, side) -> tuple[float, ...]:
    """The polynomial of a law on an inner (side = -1) or outer (side = +1) raceway, lengths in m.

    Its TERMS, and then how far |n| - 1 falls to.
    """
    if not law.follows:
        return (law.given, *(0.0,) * TERMS)
    reach, groove = _reach_of(locus_radius, groove_radius, side), (ball_radius, locus_radius, groove_radius, side)
    found = _along(*groove, 1.0 + reach * _POINTS, lambda small, large: fresh_coefficient(law, small, large))
    return _terms(found, reach)


FILM_PLACES = np.array([0.0, -0.05, -0.1])  # |n| - 1 at contact angles of 0, 18 and 26 degrees


def films_along(lubricant: np.ndarray, raceway, ball_radius: float, side: float) -> np.ndarray:
    """The numbers of films on an inner (side = -1) or outer (side = +1) raceway, polynomials (FILM_NUMBERS, 3).

    They are logarithms, which hardly bend; `lubricant` as `lubricant.film_lubricant`.
    """
    groove = ball_radius, raceway.locus_radius, raceway.groove_radius
    small, large = np.broadcast_arrays(*groove_curvatures(*groove, side * (1.0 + FILM_PLACES)))
    found = film_numbers(lubricant, small, large, raceway.law.modulus, ball_radius)
    return np.linalg.solve(np.vander(FILM_PLACES, increasing=True), found).T
