"""Stress and energy at one point of LANES elements side by side; lengths in radii, stresses in Young's moduli.

Rows of `f` (4 LANES,) hold the gradient H = F - 1 of the displacement as xx, xy, yx, yy; `shear_part` and `volume_part`
put the first Piola-Kirchhoff stress times the weight of the point in their place. Rows of `found` (3 LANES,) gather the
energy, the least det F and the least eigenvalue of Green's strain E. The laws, cut in two for selective integration:

    St. Venant-Kirchhoff   W = mu E:E + (lambda/2) (tr E)^2,  E = (F^T F - 1)/2
    neo-Hookean            W = (mu/2) (tr C - 3 - 2 ln J) + (lambda/2) (ln J)^2
    linear                 W = mu e:e + (lambda/2) (tr e)^2,  e = sym(H)

In plane stress the first and the last take lambda* = 2 lambda mu / (lambda + 2 mu) for lambda; the neo-Hookean disc
finds its stretch c through the thickness from mu (c^2 - 1) + lambda ln(J c) = 0 and has no second part. Breaks: St.
Venant-Kirchhoff softens in compression and has no stiffness left at a stretch of 1/sqrt(3).
"""

import math

from bearing_twin.compiled import inlined
from bearing_twin.kinds.soft_discs.mesh import LANES

STVK, NEO_HOOKEAN, LINEAR = range(3)
FORMULATIONS = {"stvk": STVK, "neo_hookean": NEO_HOOKEAN, "linear": LINEAR}
NEWTON_STEPS = 30  # at most, for the stretch through the thickness
LEAST = 1e-12  # det F in a logarithm; a disc with less has collapsed and is not gone on with


@inlined
def shear_part(law, plane_stress, mu, lame, f, weights, found):
    """The part with the shear modulus; of a neo-Hookean disc in plane stress, all."""
    if law == STVK:
        for k in range(LANES):
            a, b, c, d = 1.0 + f[0 * LANES + k], f[1 * LANES + k], f[2 * LANES + k], 1.0 + f[3 * LANES + k]
            e11, e22, e12 = _green(f[0 * LANES + k], b, c, f[3 * LANES + k])
            factor = 2.0 * mu * weights[k]
            found[0 * LANES + k] += 0.5 * factor * (e11 * e11 + e22 * e22 + 2.0 * e12 * e12)
            found[1 * LANES + k] = min(found[1 * LANES + k], a * d - b * c)
            found[2 * LANES + k] = min(found[2 * LANES + k], _least_eigenvalue(e11, e22, e12))
            f[0 * LANES + k], f[1 * LANES + k] = factor * (a * e11 + b * e12), factor * (a * e12 + b * e22)
            f[2 * LANES + k], f[3 * LANES + k] = factor * (c * e11 + d * e12), factor * (c * e12 + d * e22)
    elif law == LINEAR:
        for k in range(LANES):
            xx, yy, xy = f[0 * LANES + k], f[3 * LANES + k], 0.5 * (f[1 * LANES + k] + f[2 * LANES + k])
            e11, e22, e12 = _green(xx, f[1 * LANES + k], f[2 * LANES + k], yy)
            factor = 2.0 * mu * weights[k]
            found[0 * LANES + k] += 0.5 * factor * (xx * xx + yy * yy + 2.0 * xy * xy)
            found[1 * LANES + k] = min(
                found[1 * LANES + k], (1.0 + xx) * (1.0 + yy) - f[1 * LANES + k] * f[2 * LANES + k]
            )
            found[2 * LANES + k] = min(found[2 * LANES + k], _least_eigenvalue(e11, e22, e12))
            f[0 * LANES + k], f[3 * LANES + k] = factor * xx, factor * yy
            f[1 * LANES + k], f[2 * LANES + k] = factor * xy, factor * xy
    else:
        for k in range(LANES):
            a, b, c, d = 1.0 + f[0 * LANES + k], f[1 * LANES + k], f[2 * LANES + k], 1.0 + f[3 * LANES + k]
            e11, e22, e12 = _green(f[0 * LANES + k], b, c, f[3 * LANES + k])
            det = a * d - b * c
            found[1 * LANES + k] = min(found[1 * LANES + k], det)
            found[2 * LANES + k] = min(found[2 * LANES + k], _least_eigenvalue(e11, e22, e12))
            grown, thick = math.log(max(det, LEAST)), 0.0
            if plane_stress:
                thick = _thickening(mu, lame, grown)
                grown += thick
            square = math.exp(2.0 * thick)
            factor, share = mu * weights[k], square / max(det, LEAST)
            energy = e11 + e22 + 0.5 * (square - 1.0) - grown  # (tr C - 3)/2 - ln J
            found[0 * LANES + k] += factor * energy
            if plane_stress:
                found[0 * LANES + k] += 0.5 * lame * weights[k] * grown * grown
            f[0 * LANES + k], f[1 * LANES + k] = factor * (a - share * d), factor * (b + share * c)
            f[2 * LANES + k], f[3 * LANES + k] = factor * (c + share * b), factor * (d - share * a)


@inlined
def volume_part(law, plane_stress, lame, f, weights, found):
    """The part with Lame's first parameter."""
    if law == STVK:
        for k in range(LANES):
            a, b, c, d = 1.0 + f[0 * LANES + k], f[1 * LANES + k], f[2 * LANES + k], 1.0 + f[3 * LANES + k]
            e11, e22, e12 = _green(f[0 * LANES + k], b, c, f[3 * LANES + k])
            share = lame * weights[k] * (e11 + e22)
            found[0 * LANES + k] += 0.5 * share * (e11 + e22)
            found[1 * LANES + k] = min(found[1 * LANES + k], a * d - b * c)
            found[2 * LANES + k] = min(found[2 * LANES + k], _least_eigenvalue(e11, e22, e12))
            f[0 * LANES + k], f[1 * LANES + k] = share * a, share * b
            f[2 * LANES + k], f[3 * LANES + k] = share * c, share * d
    elif law == LINEAR:
        for k in range(LANES):
            trace = f[0 * LANES + k] + f[3 * LANES + k]
            share = lame * weights[k] * trace
            found[0 * LANES + k] += 0.5 * share * trace
            f[0 * LANES + k], f[1 * LANES + k], f[2 * LANES + k], f[3 * LANES + k] = share, 0.0, 0.0, share
    else:
        for k in range(LANES):
            a, b, c, d = 1.0 + f[0 * LANES + k], f[1 * LANES + k], f[2 * LANES + k], 1.0 + f[3 * LANES + k]
            det = a * d - b * c
            found[1 * LANES + k] = min(found[1 * LANES + k], det)
            grown = 0.0 if plane_stress else math.log(max(det, LEAST))
            share = lame * weights[k] * grown
            found[0 * LANES + k] += 0.5 * share * grown
            share /= max(det, LEAST)
            f[0 * LANES + k], f[1 * LANES + k] = share * d, -share * c
            f[2 * LANES + k], f[3 * LANES + k] = -share * b, share * a


@inlined
def _green(xx, xy, yx, yy):
    """Green's strain (11, 22, 12) of the displacement gradient, with all digits at small strains."""
    return (
        xx + 0.5 * (xx * xx + yx * yx),
        yy + 0.5 * (xy * xy + yy * yy),
        0.5 * (xy + yx + xx * xy + yx * yy),
    )


@inlined
def _least_eigenvalue(e11, e22, e12):
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
