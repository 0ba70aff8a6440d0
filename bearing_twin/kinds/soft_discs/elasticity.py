"""Stress and energy at one point of LANES elements side by side; lengths in radii, stresses in Young's moduli.

Rows XX, XY, YX, YY of `f` hold the gradient H = F - 1 of the displacement; `shear_part` and `volume_part` put the
first Piola-Kirchhoff stress times the weight of the point in their place. Rows ENERGY, LEAST_DET and LEAST_STRAIN of
`found` gather the energy, the least det F and the least eigenvalue of Green's strain E. The laws, cut in two for
selective integration:

    St. Venant-Kirchhoff   W = mu E:E + (lambda/2) (tr E)^2,  E = (F^T F - 1)/2
    neo-Hookean            W = (mu/2) (tr C - 3 - 2 ln J) + (lambda/2) (ln J)^2
    linear                 W = mu e:e + (lambda/2) (tr e)^2,  e = sym(H)

In plane stress the first and the last take lambda* = 2 lambda mu / (lambda + 2 mu) for lambda; the neo-Hookean disc
finds its stretch c through the thickness from mu (c^2 - 1) + lambda ln(J c) = 0 and has no second part. Breaks: St.
Venant-Kirchhoff softens in compression and has no stiffness left at a stretch of 1/sqrt(3).
"""

import math

from bearing_twin.compiled import inlined
from bearing_twin.kinds.soft_discs.lanes import (
    ENERGY,
    LANES,
    LEAST_DET,
    LEAST_STRAIN,
    XX,
    XY,
    YX,
    YY,
    get,
    increase,
    lessen,
    put,
)

STVK, NEO_HOOKEAN, LINEAR = range(3)
FORMULATIONS = {"stvk": STVK, "neo_hookean": NEO_HOOKEAN, "linear": LINEAR}
NEWTON_STEPS = 30  # at most, for the stretch through the thickness
LEAST = 1e-12  # det F in a logarithm; a disc with less has collapsed and is not gone on with


@inlined
def shear_part(law, plane_stress, mu, lame, f, weights, found):
    """The part with the shear modulus; of a neo-Hookean disc in plane stress, all. Also looks for the least of all."""
    for k in range(LANES):
        xx, xy, yx, yy = get(f, XX, k), get(f, XY, k), get(f, YX, k), get(f, YY, k)
        lessen(found, LEAST_DET, k, (1.0 + xx) * (1.0 + yy) - xy * yx)
        lessen(found, LEAST_STRAIN, k, _least_eigenvalue(_green(xx, xy, yx, yy)))
    if law == STVK:
        for k in range(LANES):
            xx, xy, yx, yy = get(f, XX, k), get(f, XY, k), get(f, YX, k), get(f, YY, k)
            e11, e22, e12 = _green(xx, xy, yx, yy)
            factor = 2.0 * mu * weights[k]
            increase(found, ENERGY, k, 0.5 * factor * (e11 * e11 + e22 * e22 + 2.0 * e12 * e12))
            put(f, XX, k, factor * ((1.0 + xx) * e11 + xy * e12))
            put(f, XY, k, factor * ((1.0 + xx) * e12 + xy * e22))
            put(f, YX, k, factor * (yx * e11 + (1.0 + yy) * e12))
            put(f, YY, k, factor * (yx * e12 + (1.0 + yy) * e22))
    elif law == LINEAR:
        for k in range(LANES):
            xx, yy, xy = get(f, XX, k), get(f, YY, k), 0.5 * (get(f, XY, k) + get(f, YX, k))
            factor = 2.0 * mu * weights[k]
            increase(found, ENERGY, k, 0.5 * factor * (xx * xx + yy * yy + 2.0 * xy * xy))
            put(f, XX, k, factor * xx)
            put(f, XY, k, factor * xy)
            put(f, YX, k, factor * xy)
            put(f, YY, k, factor * yy)
    else:
        for k in range(LANES):
            _neo_hookean_shear(plane_stress, mu, lame, f, weights[k], found, k)


@inlined
def _neo_hookean_shear(plane_stress, mu, lame, f, weight, found, k):
    xx, xy, yx, yy = get(f, XX, k), get(f, XY, k), get(f, YX, k), get(f, YY, k)
    e11, e22, _ = _green(xx, xy, yx, yy)
    det = max((1.0 + xx) * (1.0 + yy) - xy * yx, LEAST)
    grown, thick = math.log(det), 0.0
    if plane_stress:
        thick = _thickening(mu, lame, grown)
        grown += thick
    square, factor = math.exp(2.0 * thick), mu * weight
    share = square / det
    increase(found, ENERGY, k, factor * (e11 + e22 + 0.5 * (square - 1.0) - grown))  # (tr C - 3)/2 - ln J
    if plane_stress:
        increase(found, ENERGY, k, 0.5 * lame * weight * grown * grown)
    put(f, XX, k, factor * (1.0 + xx - share * (1.0 + yy)))
    put(f, XY, k, factor * (xy + share * yx))
    put(f, YX, k, factor * (yx + share * xy))
    put(f, YY, k, factor * (1.0 + yy - share * (1.0 + xx)))


@inlined
def volume_part(law, plane_stress, lame, f, weights, found):
    """The part with Lame's first parameter."""
    if law == STVK:
        for k in range(LANES):
            xx, xy, yx, yy = get(f, XX, k), get(f, XY, k), get(f, YX, k), get(f, YY, k)
            e11, e22, _ = _green(xx, xy, yx, yy)
            share = lame * weights[k] * (e11 + e22)
            increase(found, ENERGY, k, 0.5 * share * (e11 + e22))
            lessen(found, LEAST_DET, k, (1.0 + xx) * (1.0 + yy) - xy * yx)
            put(f, XX, k, share * (1.0 + xx))
            put(f, XY, k, share * xy)
            put(f, YX, k, share * yx)
            put(f, YY, k, share * (1.0 + yy))
    elif law == LINEAR:
        for k in range(LANES):
            trace = get(f, XX, k) + get(f, YY, k)
            share = lame * weights[k] * trace
            increase(found, ENERGY, k, 0.5 * share * trace)
            put(f, XX, k, share)
            put(f, XY, k, 0.0)
            put(f, YX, k, 0.0)
            put(f, YY, k, share)
    else:
        for k in range(LANES):
            xx, xy, yx, yy = get(f, XX, k), get(f, XY, k), get(f, YX, k), get(f, YY, k)
            det = (1.0 + xx) * (1.0 + yy) - xy * yx
            lessen(found, LEAST_DET, k, det)
            grown = 0.0 if plane_stress else math.log(max(det, LEAST))
            share = lame * weights[k] * grown
            increase(found, ENERGY, k, 0.5 * share * grown)
            share /= max(det, LEAST)
            put(f, XX, k, share * (1.0 + yy))
            put(f, XY, k, -share * yx)
            put(f, YX, k, -share * xy)
            put(f, YY, k, share * (1.0 + xx))


@inlined
def _green(xx, xy, yx, yy):
    """Green's strain (11, 22, 12) of the displacement gradient, with all digits at small strains."""
    return (
        xx + 0.5 * (xx * xx + yx * yx),
        yy + 0.5 * (xy * xy + yy * yy),
        0.5 * (xy + yx + xx * xy + yx * yy),
    )


@inlined
def _least_eigenvalue(strain):
    e11, e22, e12 = strain
    return 0.5 * (e11 + e22 - math.sqrt((e11 - e22) ** 2 + 4.0 * e12 * e12))


@inlined
def _thickening(mu, lame, grown):
    """Logarithm g of the stretch through the thickness of a neo-Hookean disc in plane stress, ln det F being `grown`.

    mu (e^2g - 1) + lambda (g + grown) is convex and rises with g, so that Newton's method converges from anywhere.
    """
    g = -lame * grown / (lame + 2.0 * mu)
    for _ in range(NEWTON_STEPS):
        square = math.exp(2.0 * g)
        change = (mu * (square - 1.0) + lame * (g + grown)) / (2.0 * mu * square + lame)
        g -= change
        if abs(change) < 1e-14:
            break
    return g
