"""The volumetric law for any overlap: volume, area and perimeter from a gap function (paper 1, section 4).

The undeformed bodies overlap where h - gap(x, y) > 0 and, if a body ends, where `within(x, y)` > 0. Each lobe of that
region is a spot of its own with the energy

    U = f V^2 p^(1/2) / S^(7/4),   f = 0.357469 * 8 pi E* / (15 pi^(1/4)),   load = dU/dh.

The outline is a polygon refined until its arcs are flat; each arc then counts as a parabola through its middle.
For ellipses this is equation (9). For other spots the law is a guess: a flat punch comes out 50 % too stiff.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError

CELLS = 48  # of the first grid across the window; lobes smaller than a cell are not seen
CLOSER = 2  # grids laid closer round the spot after that
FLATNESS = 3e-8  # of the spot's size: an arc that is that near to its parabola is measured as one
BENT = 0.05  # height over chord above which an arc is split in any case
REFINEMENTS = 24
STENCIL = 0.01  # relative step in h of the five-point derivatives of S and p
ENERGY_FACTOR = 0.357469 * 8.0 * math.pi**0.75 / 15.0
RADIAL, ACROSS = np.polynomial.legendre.leggauss(8), np.polynomial.legendre.leggauss(4)

Field = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Overlap(NamedTuple):
    """One lobe of the overlap: volume [m^3], area [m^2], perimeter [m], and the closed outline (n, 2) [m]."""

    volume: float
    area: float
    perimeter: float
    outline: np.ndarray


class SpotLoad(NamedTuple):
    """Normal load [N] and elastic energy [J] of the whole overlap, and its lobes."""

    normal_load: float
    energy: float
    lobes: list[Overlap]


def overlap_load(
    gap: Field, window, approach: float, effective_modulus: float, within: Field | None = None
) -> SpotLoad:
    """The load of the volumetric law at `approach` h [m] for any gap [m] >= 0 between undeformed bodies.

    `gap` and `within` take arrays x, y [m] and must be smooth and defined over the whole `window` (x low, x high, y
    low, y high); `within` is positive where both bodies are. dV/dh is S, the other derivatives by differences: wrong
    within 2 % of an h at which lobes meet. Raises SceneError where the spot leaves the window.
    """
    if approach <= 0.0:
        return SpotLoad(0.0, 0.0, [])
    lobes = overlap(gap, window, approach, within)
    steps = {k: overlap(gap, window, approach * (1.0 + k * STENCIL), within) for k in (-2, -1, 1, 2)}
    for others in steps.values():
        if len(others) != len(lobes):
            raise SceneError(
                f"lobes of the contact appear or meet within 2 % of an approach of {approach:g} m, where the load "
                "has a corner; give another approach"
            )
    load = energy = 0.0
    for lobe in lobes:
        near = {k: _nearest(lobe, others) for k, others in steps.items()}

        def slope(name, near=near):
            values = {k: getattr(one, name) for k, one in near.items()}
            return (8.0 * (values[1] - values[-1]) - (values[2] - values[-2])) / (12.0 * STENCIL * approach)

        stored = ENERGY_FACTOR * effective_modulus * lobe.volume**2 * math.sqrt(lobe.perimeter) / lobe.area**1.75
        growth = (
            2.0 * lobe.area / lobe.volume + 0.5 * slope("perimeter") / lobe.perimeter - 1.75 * slope("area") / lobe.area
        )
        energy += stored
        load += stored * growth
    return SpotLoad(load, energy, lobes)


def overlap(gap: Field, window, approach: float, within: Field | None = None) -> list[Overlap]:
    """Volume, area and perimeter of every lobe at this approach [m]; arguments as `overlap_load`."""

    def depth(points):
        return approach - gap(points[..., 0], points[..., 1])

    def inside(points):
        """Positive within the spot."""
        value = depth(points)
        if within is None:
            return value
        return np.minimum(value, within(points[..., 0], points[..., 1]))

    window = np.asarray(window, dtype=float)
    outlines = _outlines(inside, window)
    for _ in range(
        CLOSER if outlines else 0
    ):  # grids just round the spot: a small one in a wide window is resolved too
        points = np.concatenate(outlines)
        cell = np.repeat((window[1::2] - window[::2]) / CELLS, 2) * (-1.0, 1.0, -1.0, 1.0)
        closer = np.stack([points.min(axis=0), points.max(axis=0)], axis=1).ravel() + 3.0 * cell
        window = np.where(cell < 0.0, np.maximum(closer, window), np.minimum(closer, window))
        outlines = _outlines(inside, window)
    found = [_measure(depth, *_refined(inside, outline)) for outline in outlines]
    if any(lobe.area <= 0.0 for lobe in found):
        raise SceneError("the spot has a hole in it; the volumetric law knows no such contact")
    return found


def _nearest(lobe, others):
    middle = lobe.outline.mean(axis=0)
    return min(others, key=lambda one: np.linalg.norm(one.outline.mean(axis=0) - middle))


def _outlines(inside, window):
    """Closed polygons (n, 2) by marching squares, the spot on their left; corners lie on the outline to rounding."""
    x, y = np.linspace(*window[:2], CELLS + 1), np.linspace(*window[2:], CELLS + 1)
    nodes = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    solid = inside(nodes) > 0.0
    if solid[[0, -1]].any() or solid[:, [0, -1]].any():
        raise SceneError("the contact spot reaches the edge of the window; give a wider window")
    middles = inside(0.25 * (nodes[1:, 1:] + nodes[:-1, 1:] + nodes[1:, :-1] + nodes[:-1, :-1])) > 0.0
    mixed = np.argwhere(
        (solid[1:, 1:] != solid[:-1, :-1]) | (solid[1:, :-1] != solid[:-1, 1:]) | (solid[1:, 1:] != solid[1:, :-1])
    )
    follows = {}
    for i, j in map(tuple, mixed.tolist()):
        ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]  # anticlockwise
        edges = [(ring[k], ring[(k + 1) % 4]) for k in range(4)]
        leaving = [k for k, (a, b) in enumerate(edges) if solid[a] and not solid[b]]
        entering = [k for k, (a, b) in enumerate(edges) if solid[b] and not solid[a]]
        for k in leaving:  # where the spot ends going round the cell, its outline begins; it ends at the next entry ...
            turn = 1 if len(leaving) == 2 and middles[i, j] else -1
            partner = min(entering, key=lambda one, k=k, turn=turn: (turn * (one - k)) % 4)
            follows[frozenset(edges[k])] = frozenset(edges[partner])
    polygons = []
    while follows:
        start, edge = next(iter(follows.items()))
        chain = [start]
        del follows[start]
        while edge != start:
            chain.append(edge)
            edge = follows.pop(edge)
        ends = np.array([sorted(one, key=lambda node: not solid[node]) for one in chain])
        polygons.append(_crossing(inside, nodes[tuple(ends[:, 0].T)], nodes[tuple(ends[:, 1].T)]))
    return polygons


def _crossing(inside, full, empty):
    """Points (n, 2) between points within and points outside the spot, on its outline to rounding (regula falsi).

    Illinois' rule: the value at an end that stays twice is halved.
    """
    low, high = np.zeros(len(full)), np.ones(len(full))
    at_low, at_high = inside(full), inside(empty)
    last, side, step = low, np.zeros(len(full)), empty - full
    for _ in range(60):
        drop = at_low - at_high
        middle = low + (high - low) * np.divide(at_low, drop, out=np.full(len(drop), 0.5), where=drop > 0.0)
        value = inside(full + middle[:, None] * step)
        solid = value > 0.0
        at_high = np.where(solid, np.where(side > 0.0, 0.5 * at_high, at_high), value)
        at_low = np.where(solid, value, np.where(side < 0.0, 0.5 * at_low, at_low))
        low, high = np.where(solid, middle, low), np.where(solid, high, middle)
        side = np.where(solid, 1.0, -1.0)
        if np.all((np.abs(middle - last) < 1e-15) | (value == 0.0)):
            break
        last = middle
    return full + middle[:, None] * step


def _refined(inside, polygon):
    """The polygon with arcs split until each is a parabola, and the middle point of each arc."""
    size = np.ptp(polygon, axis=0).max()
    polygon = polygon[np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1) > 1e-12 * size]
    rough = np.ones(len(polygon), bool)  # arcs still to be looked at
    for _ in range(REFINEMENTS):
        before, after = polygon[rough], np.roll(polygon, -1, axis=0)[rough]
        length = np.linalg.norm(after - before, axis=1)
        shares = np.repeat((0.5, 0.25, 0.75), len(before))[:, None]
        found, heights = _bulge(inside, np.tile(before, (3, 1)), np.tile(after, (3, 1)), shares)
        middle, (height, *quarters) = found[: len(before)], heights.reshape(3, -1)
        off = np.max([np.abs(quarter - 0.75 * height) for quarter in quarters], axis=0)
        bent = ((off > FLATNESS * size) | (np.abs(height) > BENT * length)) & (length > 1e-11 * size)
        rough[rough] = bent
        if not bent.any():
            break
        places = np.flatnonzero(rough) + 1
        polygon, rough = np.insert(polygon, places, middle[bent], axis=0), np.insert(rough, places, True)
    return polygon, _bulge(inside, polygon, np.roll(polygon, -1, axis=0), 0.5)[0]


def _bulge(inside, before, after, share):
    """Where the outline crosses the chords' normals at a share of them, and how far out; the chord if it does not."""
    chord = after - before
    normal = np.stack([chord[:, 1], -chord[:, 0]], axis=1)  # to the right, out of the spot
    foot = before + share * chord
    found = foot.copy()
    out = np.where(inside(foot) > 0.0, 1.0, -1.0)[:, None]
    open_ = np.ones(len(foot), bool)
    for reach in (0.1, 0.5, 2.5):
        far = foot + out * reach * normal
        fit = open_ & ((inside(far) > 0.0) != (out[:, 0] > 0.0))
        full, empty = np.where(out > 0.0, foot, far)[fit], np.where(out > 0.0, far, foot)[fit]
        found[fit] = _crossing(inside, full, empty)
        open_ &= ~fit
        if not open_.any():
            break
    length = np.maximum(np.linalg.norm(chord, axis=1), np.finfo(float).tiny)
    return found, np.einsum("ij,ij->i", found - foot, normal) / length


def _measure(depth, polygon, middle):
    """The lobe inside a polygon with parabolic arcs: a fan of triangles from its middle, and the slivers outside."""
    after = np.roll(polygon, -1, axis=0)
    chord = after - polygon
    length = np.linalg.norm(chord, axis=1)
    bulge = middle - 0.5 * (polygon + after)
    sagitta = (bulge[:, 0] * chord[:, 1] - bulge[:, 1] * chord[:, 0]) / length  # to the right: outwards
    centre = polygon.mean(axis=0)
    a, b = polygon - centre, after - centre
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    sliver = 2.0 / 3.0 * length * sagitta
    volume = float(np.sum(sliver * depth(0.5 * (polygon + after) + 0.4 * bulge)))
    for r, r_weight in zip(0.5 * (RADIAL[0] + 1.0), 0.5 * RADIAL[1], strict=True):
        for s, s_weight in zip(0.5 * (ACROSS[0] + 1.0), 0.5 * ACROSS[1], strict=True):
            points = centre + r * ((1.0 - s) * a + s * b)
            volume += float(np.sum(depth(points) * twice)) * r * r_weight * s_weight
    area = 0.5 * float(twice.sum()) + float(sliver.sum())
    perimeter = float(np.sum(length * (1.0 + 8.0 / 3.0 * (sagitta / length) ** 2)))
    return Overlap(volume, area, perimeter, polygon)
