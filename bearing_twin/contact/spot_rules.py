"""Rules by which friction is summed over an elliptic spot: points of the unit disc with their shares of the pressure.

Where a spot's rim is slow by its spin against sqrt(slip^2 + regularisation^2), friction is nearly a polynomial of the
place, and FEW_POINTS are as exact as those of a `Rule`. Between its `easy` and `hard` both are blended smoothly, so
that steps see no jump: `blend`. `bearing_twin chart friction` measures what each rule errs by.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics.inverse_root import inverse_root

FEW = 12  # points of the rule for slow rims, the first rows of POINTS
ROUND = 1.5  # tuned: few points err as much on a circle as on a narrow ellipse with a rim sqrt(1 + ROUND) times as fast


def rings(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Radii (count,) of rings on the unit disc and their shares of the pressure 3/2 sqrt(1 - rho^2), by Gauss.

    In rho = sin(t) both the pressure's edge and the kink at the centre of a spinning spot are smooth.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    angle = 0.25 * math.pi * (nodes + 1.0)
    shares = weights * np.cos(angle) ** 2 * np.sin(angle)
    return np.sin(angle), shares / shares.sum()


def points(count: int, spokes: int) -> np.ndarray:
    """Points (count * spokes, 3) of a quadrature over the unit disc: x, y and share of the pressure."""
    angles = 2.0 * math.pi * (np.arange(spokes) + 0.5) / spokes
    return np.array(
        [
            (radius * math.cos(angle), radius * math.sin(angle), share / spokes)
            for radius, share in zip(*rings(count), strict=True)
            for angle in angles
        ]
    )


def few_points() -> np.ndarray:
    """Points (12, 3) of a rule that is exact for the pressure times a polynomial of degree 7.

    Stroud and Secrest's form for round weights: four points on the axes, eight on the diagonals. A point and the next
    one lie opposite each other. The moments of the pressure are <r^2> = 2/5, <x^2 y^2> = 1/35, <x^6> = 1/21.
    """
    squares = (7.0 + math.sqrt(19.0) * np.array([-1.0, 1.0])) / 15.0  # of the distances on the diagonals
    on_axes = 9.0 / 140.0
    on_diagonals = np.linalg.solve(np.stack([np.ones(2), squares]), [0.25 - on_axes, 0.1 - on_axes * 2.0 / 3.0])
    far = math.sqrt(2.0 / 3.0)
    near = [(far, 0.0, on_axes), (0.0, far, on_axes)]
    for square, share in zip(squares, on_diagonals, strict=True):
        place = math.sqrt(0.5 * square)
        near += [(place, place, share), (place, -place, share)]
    return np.array([point for x, y, share in near for point in ((x, y, share), (-x, -y, share))])


class Rule(NamedTuple):
    """A rule as kernels know it: its rows of POINTS from `first` to `end`, and where it takes over from few points.

    `easy` and `hard` are of the quotient of `rim_share`: up to `easy` few points are taken, from `hard` on all.
    """

    first: int
    end: int
    easy: float
    hard: float


NO_RULE = Rule(0, 0, 0.0, 1.0)  # of models that are no sums over points
SIZES = {
    "coarse": (6, 16, 0.16, 0.25),  # tuned: errors of the friction table
    "medium": (12, 32, 0.04, 0.0625),  # tuned: the same
    "fine": (24, 96, 0.0064, 0.01),  # tuned: the same
}
"""Rings and spokes of each rule, `easy` and `hard`: there few points err by 8e-7 of mu N, 4e-9 and 1e-11."""


def _laid() -> tuple[np.ndarray, dict[str, Rule]]:
    """The points of all rules below each other, the few first, and the rules by name."""
    rows, rules = [few_points()], {}
    for name, (count, spokes, easy, hard) in SIZES.items():
        first = sum(map(len, rows))
        rules[name] = Rule(first, first + count * spokes, easy, hard)
        rows.append(points(count, spokes))
    return np.concatenate(rows), rules


POINTS, RULES = _laid()
FEW_POINTS = POINTS[:FEW]
_ON_AXES, _NEAR, _FAR = ((float(x), float(share)) for x, _, share in FEW_POINTS[[0, 4, 8]])  # x and share of each four


@inlined
def rim_share(semi_major, semi_minor, slip_major, slip_minor, spin, regularisation):
    """The rim's speed by spin, squared, and slip^2 + regularisation^2, whose quotient chooses: either may be zero."""
    rim = spin * spin * (semi_major * semi_major + ROUND * semi_minor * semi_minor)
    return rim, slip_major * slip_major + slip_minor * slip_minor + regularisation * regularisation


@inlined
def blend(easy, hard, rim, square):
    """The part of a rule's points in the blend, 0 to 1, and its slope by rim/square; `rim`, `square` of `rim_share`."""
    place = (rim - easy * square) / ((hard - easy) * max(square, 1e-300))
    place = min(max(place, 0.0), 1.0)
    return place * place * (3.0 - 2.0 * place), 6.0 * place * (1.0 - place) / (hard - easy)


@inlined
def slip_share(x, y, weight, slip_major, slip_minor, spin, regularisation):
    """One point's share of the slip's mean direction along both axes, and of its moment about the centre [m].

    `x`, `y` [m] from the spot's centre along its axes. With a speed of exactly zero the share is zero.
    """
    u, v = slip_major - spin * y, slip_minor + spin * x
    factor = weight * inverse_root(max(u * u + v * v + regularisation * regularisation, 1e-300))
    return factor * u, factor * v, factor * (x * v - y * u)


@kernel
def over_spot(points, semi_major, semi_minor, slip_major, slip_minor, spin, regularisation):
    """Means over the pressure of the slip's direction along both axes, and of its moment about the centre [m]."""
    along = across = moment = 0.0
    for i in range(len(points)):
        x, y, weight = points[i, 0], points[i, 1], points[i, 2]
        one = slip_share(semi_major * x, semi_minor * y, weight, slip_major, slip_minor, spin, regularisation)
        along += one[0]
        across += one[1]
        moment += one[2]
    return along, across, moment


@inlined
def _opposite(x, y, weight, slip_major, slip_minor, spin, square):
    """Of two points that lie opposite, with 1/speed as weight: their sum, their difference times x and y, r^2 the sum.

    The speeds are no differences of near numbers where few points are taken.
    """
    distance = x * x + y * y
    middle, aside = square + spin * spin * distance, 2.0 * spin * (slip_minor * x - slip_major * y)
    here, there = inverse_root(max(middle + aside, 1e-300)), inverse_root(max(middle - aside, 1e-300))
    both, more = weight * (here + there), weight * (here - there)
    return both, x * more, y * more, distance * both


@inlined
def over_few(semi_major, semi_minor, slip_major, slip_minor, spin, square):
    """`over_spot` by FEW_POINTS, `square` as `rim_share` gives it; opposite points share what is the same for both."""
    x, y = _ON_AXES[0] * semi_major, _ON_AXES[0] * semi_minor
    a = _opposite(x, 0.0, _ON_AXES[1], slip_major, slip_minor, spin, square)
    b = _opposite(0.0, y, _ON_AXES[1], slip_major, slip_minor, spin, square)
    x, y = _NEAR[0] * semi_major, _NEAR[0] * semi_minor
    c = _opposite(x, y, _NEAR[1], slip_major, slip_minor, spin, square)
    d = _opposite(x, -y, _NEAR[1], slip_major, slip_minor, spin, square)
    x, y = _FAR[0] * semi_major, _FAR[0] * semi_minor
    e = _opposite(x, y, _FAR[1], slip_major, slip_minor, spin, square)
    f = _opposite(x, -y, _FAR[1], slip_major, slip_minor, spin, square)
    both, by_square = a[0] + b[0] + c[0] + d[0] + e[0] + f[0], a[3] + b[3] + c[3] + d[3] + e[3] + f[3]
    by_x, by_y = a[1] + c[1] + d[1] + e[1] + f[1], b[2] + c[2] + d[2] + e[2] + f[2]
    return (
        slip_major * both - spin * by_y,
        slip_minor * both + spin * by_x,
        slip_minor * by_x - slip_major * by_y + spin * by_square,
    )


@kernel
def blended_over_spot(first, end, easy, hard, semi_major, semi_minor, slip_major, slip_minor, spin, regularisation):
    """`over_spot` by FEW_POINTS where these are enough, by those of a rule where not, and smoothly by both between."""
    motion = slip_major, slip_minor, spin
    rim, square = rim_share(semi_major, semi_minor, *motion, regularisation)
    part, _ = blend(easy, hard, rim, square)
    few = many = (0.0, 0.0, 0.0)
    if part < 1.0:
        few = over_few(semi_major, semi_minor, *motion, square)
    if part > 0.0:
        many = over_spot(POINTS[first:end], semi_major, semi_minor, *motion, regularisation)
    rest = 1.0 - part
    return rest * few[0] + part * many[0], rest * few[1] + part * many[1], rest * few[2] + part * many[2]
