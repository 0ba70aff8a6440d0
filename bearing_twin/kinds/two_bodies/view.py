"""The view of two bodies: both shapes, the way of the first, the contact and the load in it."""

import math

import numpy as np

from bearing_twin.kinds.ellipsoid.view import contact_view
from bearing_twin.kinds.two_bodies.derived import ROWS, reach_of
from bearing_twin.kinds.two_bodies.parameters import Shaped
from bearing_twin.kinds.views import BLUE, GLASS, STEEL, Look, Solid, View, along_axes, curves
from bearing_twin.shapes.implicit import support

ROUND, ACROSS = 64, 32  # directions of a mesh round its axis and from pole to pole
EDGE = math.radians(78.0)  # how far up a groove is drawn
BEHIND = 0.5  # radii of the tube: the ring behind a groove


def view(facts, channels) -> View:
    """Up is against gravity; a groove is cut through its middle."""
    parameters = facts.scene.parameters
    first, second = parameters.first, parameters.second
    fall = np.array(parameters.gravity)
    upward = -fall / np.linalg.norm(fall) if fall.any() else np.array([0.0, 0.0, 1.0])
    if abs(upward[2]) < 0.9:
        direction = np.array([0.0, 0.0, 1.0]) + 0.42 * upward
    else:
        direction = np.array([0.35, -1.0, 0.0]) + 0.3 * upward
    solids = (
        _solid("first", first, "", BLUE if second.shape == first.shape else STEEL),
        _solid("second", second, "second_", STEEL if second.shape == first.shape else GLASS),
    )
    seen = [one for one in (first, second) if math.isfinite(reach_of(one))]
    places = np.array([one.position for one in seen])
    amid = 0.5 * (places.min(axis=0) + places.max(axis=0))
    far = max(float(np.linalg.norm(np.array(one.position) - amid)) + reach_of(one) for one in seen)
    look = Look(
        (1.1 if second.shape != "groove" else 1.5) * max(map(reach_of, seen)),
        tuple(direction.tolist()),
        tuple(upward.tolist()),
        around=("position",) if second.shape != "groove" else ("second_position",),
        at_start=(tuple(amid.tolist()), far),
        follows="first" if second.shape == "plane" else "",
    )
    motion = curves("Position of the first body's centre", "m", *along_axes("position"))
    reach = reach_of(first) if first in seen else look.radius
    return contact_view(channels, solids, reach, look, motion, lambda sample: -sample["normal"])


def _solid(name: str, one: Shaped, prefix: str, colour: str) -> Solid:
    ground = one.shape == "plane"
    return Solid(
        name,
        f"{name} body, {one.shape}",
        SHAPES[one.shape](one),
        colour,
        position=f"{prefix}position",
        orientation=f"{prefix}orientation",
        marked=not ground,
        opacity=0.5 if ground else 1.0,
    )


def _mesh(one: Shaped) -> dict:
    """A convex body from its support: the farthest point along each of many directions, whose normal it is."""
    surface = ROWS[one.shape].surface(one)
    tilts, turns = np.linspace(0.0, math.pi, ACROSS + 1), np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    ways = np.stack(
        [
            np.outer(np.sin(tilts), np.cos(turns)),
            np.outer(np.sin(tilts), np.sin(turns)),
            np.outer(np.cos(tilts), turns**0),
        ],
        axis=-1,
    ).reshape(-1, 3)
    corner = (np.arange(ACROSS)[:, None] * (ROUND + 1) + np.arange(ROUND)).ravel()
    below = corner + ROUND + 1
    triangles = np.concatenate(
        [np.stack([corner, below, corner + 1], axis=1), np.stack([corner + 1, below, below + 1], axis=1)]
    )
    points = support(surface, ways)
    return {"mesh": {"vertices": points.tolist(), "normals": ways.tolist(), "triangles": triangles.tolist()}}


def _groove(one: Shaped) -> dict:
    """The half z < 0 of a ring with a groove of the tube's radius inside."""
    tube, ring = one.radius, one.ring_radius
    arc = [(ring + tube * math.cos(angle), -tube * math.sin(angle)) for angle in np.linspace(0.0, EDGE, 16)]
    back, face = ring + (1.0 + BEHIND) * tube, -1.25 * tube
    rim = (arc[-1][0], face)
    return {
        "turned": {
            "strokes": [arc, [arc[-1], rim], [rim, (back, face)], [(back, face), (back, 0.0)], [(back, 0.0), arc[0]]]
        }
    }


SHAPES = {
    "plane": lambda one: {"ground": {}},
    "sphere": lambda one: {"ellipsoid": (one.radius,) * 3},
    "ellipsoid": lambda one: {"ellipsoid": one.semi_axes},
    "superellipsoid": _mesh,
    "groove": _groove,
}
"""How each shape of `derived.ROWS` is drawn."""
