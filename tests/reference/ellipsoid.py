"""Closed forms of an ellipsoid on a plane: what a stiffer law does to a bounce, rocking at rest."""

import math

import numpy as np


def contact_delay(coefficient_ratio, duration):
    """By how much [s] a contact of `duration` [s] ends later when the law's coefficient is `coefficient_ratio` times.

    Contact time goes as c^(-2/5) (paper 3, eqs. 1, 2): for paper 1's volumetric law on a sphere 0.9953^(-2/5) - 1 =
    0.19 % of it, a bounce. Without loss nothing else differs: speeds, and so flights, stay the same.
    """
    return duration * (np.asarray(coefficient_ratio) ** -0.4 - 1.0)


def rocking_rate(semi_axes, gravity: float, rolling: bool) -> float:
    """Angular frequency [rad/s] of small rocking about x of an ellipsoid that rests on the end of its z axis.

    The height of the centre is c + (b^2 - c^2)/(2 c) angle^2. Without friction the centre stays over one point and only
    the moment of inertia m (b^2 + c^2)/5 resists; `rolling` without slip adds m c^2. Imaginary (a top) for b < c: NaN.
    """
    _, b, c = semi_axes
    restoring = gravity * (b * b - c * c) / c
    if restoring <= 0.0:
        return math.nan
    return math.sqrt(restoring / ((b * b + c * c) / 5.0 + (c * c if rolling else 0.0)))
