"""The volumetric law over the true overlap of two undeformed bodies, by rays from the contact: fit for a run.

Paper 1, section 4, for contacts that are no ellipse. Each lobe of an overlap has the energy

    U = f V^2 p^(1/2) / S^(7/4),   f = 0.357469 * 8 pi^(3/4) E* / 15,   load = dU/dh                          (9 before)

with volume V, area S of its projection along the normal and that projection's perimeter p. The outline is where the
surfaces cross: on each ray two equations f_A = f_B = 0 for distance and height. All sums around the outline are of
smooth periodic functions, so that equal weights converge faster than any power; dV/dh = S, and with the gap's gradient
g and its second derivative g_tt along the outline's tangent dS/dh = sum ds/g, dp/dh = sum g_tt ds/g^2.

Breaks: where the outline is no single curve around the contact, or leans so far that no normal is common to it
(`LOST`); for spots far from an ellipse the law itself is a guess (a flat punch comes out 50 % too stiff).
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.shapes.implicit import level

ENERGY_FACTOR = 0.357469 * 8.0 * math.pi**0.75 / 15.0
LEAN = 0.3  # tuned: least cosine between a surface's normal at the outline and the contact's
CLOSE = 1e-5  # of the distance: a Newton step below it leaves an error of its square
RADIAL = 6
FEWEST, MOST, AGREE = 12, 768, 1e-5
VOLUME, AREA, PERIMETER, AREA_RATE, PERIMETER_RATE, FIRST_X, FIRST_Y, SUMS = range(8)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(RADIAL)
SHARES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


class Lens(NamedTuple):
    """An overlap: energy [J], load [N], volume [m^3], area [m^2], perimeter [m], half-widths [m], centre (2,) [m].

    `centre_x`, `centre_y` are the centre of the volume in the tangent axes; `found` is False where there is none.
    """

    found: bool
    energy: float
    load: float
    volume: float
    area: float
    perimeter: float
    half_width_x: float
    half_width_y: float
    centre_x: float
    centre_y: float


class _Side(NamedTuple):
    """One body seen from the contact, in its own axes: origin, tangent axes and normal (3,), and room to work in."""

    surface: tuple
    origin: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    gradient: np.ndarray
    hesse: np.ndarray


@kernel
def _side(one, origin, axes, normal):
    turn = one.rotation.T
    return _Side(
        one.surface, turn @ (origin - one.position), turn @ axes[0], turn @ axes[1], turn @ normal,
        np.empty(3), np.empty((3, 3)),
    )  # fmt: skip


@kernel
def _level(side, x, y, z, place):
    """f of a body at (x, y, z) of the contact's frame; its derivatives stand in the side's room."""
    for i in range(3):
        place[i] = side.origin[i] + x * side.x[i] + y * side.y[i] + z * side.z[i]
    return level(side.surface, place, side.gradient, side.hesse)


@inlined
def _along(side, vector):
    return side.gradient[0] * vector[0] + side.gradient[1] * vector[1] + side.gradient[2] * vector[2]


@kernel
def _edge(a, b, x, y, start, height, place):
    """Where the surfaces cross on the ray (x, y) t: (t, height), by Newton's method from `start`; t < 0 if nowhere."""
    t, z = start, height
    for _ in range(60):
        value_a = _level(a, t * x, t * y, z, place)
        value_b = _level(b, t * x, t * y, z, place)
        slope_a, slope_b = x * _along(a, a.x) + y * _along(a, a.y), x * _along(b, b.x) + y * _along(b, b.y)
        rise_a, rise_b = _along(a, a.z), _along(b, b.z)
        determinant = slope_a * rise_b - slope_b * rise_a
        if not determinant < 0.0:  # the gap must open outward
            t, z = 0.5 * t, 0.5 * z
            continue
        step = (value_b * rise_a - value_a * rise_b) / determinant
        lift = (slope_b * value_a - slope_a * value_b) / determinant
        bound = min(max(step, -0.6 * t), 1.0 * t)
        if bound != step:
            lift *= bound / step
        t, z = t + bound, z + lift
        if abs(step) < CLOSE * t:
            return t, z
        if not t < 1e9:
            break
    return -1.0, z


@kernel
def _height(side, x, y, z, thick, place):
    """Height of a surface over (x, y) of the tangent plane, from a near one, where the bodies overlap by `thick`."""
    for _ in range(8):
        change = _level(side, x, y, z, place) / _along(side, side.z)
        z -= change
        if abs(change) < CLOSE * thick:
            break
    return z


@kernel
def _bend(side, tx, ty, place):
    """Second derivative of a surface's height along the unit tangent (tx, ty), from the derivatives in its room."""
    rise = _along(side, side.z)
    slope = -(tx * _along(side, side.x) + ty * _along(side, side.y)) / rise
    for i in range(3):
        place[i] = tx * side.x[i] + ty * side.y[i] + slope * side.z[i]
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += place[i] * side.hesse[i, j] * place[j]
    return -total / rise


@kernel
def _leans(side):
    """True if the surface leans too far from the contact's normal."""
    square = _along(side, side.gradient)
    rise = _along(side, side.z)
    return rise * rise < LEAN * LEAN * square


@kernel
def _ray(a, b, angle, half_x, half_y, approach, start, sums, place):
    """Adds a ray to all sums (VOLUME ...); returns its end (share of the half-widths, height), below 0 if none."""
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y = half_x * cosine, half_y * sine
    t, z = _edge(a, b, x, y, start[0], start[1], place)
    if t <= 0.0:
        return t, z
    _level(a, t * x, t * y, z, place)
    _level(b, t * x, t * y, z, place)
    if _leans(a) or _leans(b):
        return -1.0, z
    rise_a, rise_b = _along(a, a.z), _along(b, b.z)
    gap_x = _along(a, a.x) / rise_a - _along(b, b.x) / rise_b
    gap_y = _along(a, a.y) / rise_a - _along(b, b.y) / rise_b
    steep = math.hypot(gap_x, gap_y)
    over_x, over_y = -half_x * sine, half_y * cosine  # d(x, y)/d(angle)
    change = -t * (gap_x * over_x + gap_y * over_y) / (gap_x * x + gap_y * y)
    arc = math.hypot(t * over_x + change * x, t * over_y + change * y)
    tx, ty = -gap_y / steep, gap_x / steep
    sums[PERIMETER] += arc
    sums[AREA] += 0.5 * t * t * half_x * half_y
    sums[AREA_RATE] += arc / steep
    sums[PERIMETER_RATE] += arc * (_bend(b, tx, ty, place) - _bend(a, tx, ty, place)) / (steep * steep)
    for k in range(RADIAL):
        share = SHARES[k]
        thick, square = approach * (1.0 - share * share), share * share
        top = _height(a, share * t * x, share * t * y, 0.5 * approach + (z - 0.5 * approach) * square, thick, place)
        low = _height(b, share * t * x, share * t * y, -0.5 * approach + (z + 0.5 * approach) * square, thick, place)
        part = (top - low) * WEIGHTS[k] * share * t * t * half_x * half_y
        sums[VOLUME] += part
        sums[FIRST_X] += part * share * t * x
        sums[FIRST_Y] += part * share * t * y
    return t, z


@kernel
def lens(body_a, body_b, origin, axes, normal, approach, size, modulus):
    """The overlap (`Lens`) of two `tracking.Body` that press into each other by `approach` h > 0 [m].

    `origin` (3,) lies between the opposing points, `normal` (3,) is outward of A there, `axes` (2, 3) complete it;
    `size` [m] is about the bodies' least radius, `modulus` E* [Pa]. Rays are doubled until those in between agree
    with the others to AGREE: the error of all together is about its square.
    """
    a, b = _side(body_a, origin, axes, normal), _side(body_b, origin, axes, normal)
    place, sums, between = np.empty(3), np.zeros(SUMS), np.zeros(SUMS)
    guess = math.sqrt(approach * size)
    half_x, _ = _edge(a, b, 1.0, 0.0, guess, 0.0, place)
    half_y, z = _edge(a, b, 0.0, 1.0, guess, 0.0, place)
    if not (half_x > 0.0 and half_y > 0.0):
        return Lens(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    rays, offset = FEWEST, 0.0
    while True:
        between[:] = 0.0
        turn = 2.0 * math.pi / rays
        end = (1.0, z)
        for ray in range(rays):
            end = _ray(a, b, 0.5 * math.pi + turn * (ray + offset), half_x, half_y, approach, end, between, place)
            if end[0] <= 0.0:
                return Lens(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        if offset == 0.0:
            sums[:] = between
            offset = 0.5
            continue
        off = max(
            abs(sums[AREA] - between[AREA]) / sums[AREA], abs(sums[PERIMETER] - between[PERIMETER]) / sums[PERIMETER]
        )
        sums += between
        rays *= 2
        if off < AGREE or rays >= MOST:
            break
    sums *= 2.0 * math.pi / rays
    volume, area, perimeter = sums[VOLUME], sums[AREA], sums[PERIMETER]
    energy = ENERGY_FACTOR * modulus * volume * volume * math.sqrt(perimeter) / area**1.75
    growth = 2.0 * area / volume + 0.5 * sums[PERIMETER_RATE] / perimeter - 1.75 * sums[AREA_RATE] / area
    return Lens(
        True, energy, energy * growth, volume, area, perimeter, half_x, half_y, sums[FIRST_X] / volume,
        sums[FIRST_Y] / volume,
    )  # fmt: skip
