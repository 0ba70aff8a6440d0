"""Lines on the surface of a body, to draw it by: in its own axes."""

import functools
import math

import numpy as np

from bearing_twin.kinds.two_bodies.derived import ROWS
from bearing_twin.kinds.two_bodies.parameters import Shaped
from bearing_twin.shapes.implicit import PLANE, TORUS
from bearing_twin.shapes.opposing import support

ROUND, RINGS = 48, 7  # sides of a ring; rings each way


@functools.lru_cache(maxsize=16)
def lines_of(one: Shaped) -> np.ndarray:
    """Ends (n, 2, 3) [m] of lines on the surface of a body, none of a plane."""
    surface = ROWS[one.shape].surface(one)
    if surface.kind == PLANE:
        return np.empty((0, 2, 3))
    rings = _torus_rings(*surface.sizes[:2]) if surface.kind == TORUS else _convex_rings(surface)
    return np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])


def _torus_rings(locus: float, tube: float):
    turn = np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    for angle in np.linspace(0.0, 2.0 * math.pi, RINGS + 1)[:-1]:
        reach = locus + tube * math.cos(angle)
        height = np.full_like(turn, tube * math.sin(angle))
        yield np.stack([reach * np.cos(turn), reach * np.sin(turn), height], axis=1)
    for angle in np.linspace(0.0, 2.0 * math.pi, 2 * RINGS + 1)[:-1]:
        reach = locus + tube * np.cos(turn)
        yield np.stack([reach * math.cos(angle), reach * math.sin(angle), tube * np.sin(turn)], axis=1)


def _convex_rings(surface):
    """Sections of a convex body through its centre: boundary points in directions of great circles."""
    turn = np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    flat, up = np.stack([np.cos(turn), np.sin(turn)], axis=1), np.array([0.0, 0.0, 1.0])
    for tilt in np.linspace(0.0, math.pi, RINGS)[:-1]:
        side = np.array([math.cos(tilt), math.sin(tilt), 0.0])
        yield np.array([support(surface, c * side + s * up) for c, s in flat])
    yield np.array([support(surface, np.array([c, s, 0.0])) for c, s in flat])
