"""Markers as fields of visualization_msgs/Marker, for RViz and Foxglove: few of them, with many points each."""

import numpy as np

CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, SPHERE_LIST, TEXT = 1, 2, 3, 4, 5, 7, 9

STEEL = (0.75, 0.77, 0.80, 1.0)
BRASS = (0.72, 0.55, 0.20, 1.0)
BLUE = (0.15, 0.25, 0.45, 1.0)
ORANGE = (0.90, 0.55, 0.15, 1.0)
GLASS = (0.35, 0.35, 0.40, 0.2)
RED = (0.85, 0.15, 0.15, 0.9)
GREEN = (0.10, 0.60, 0.25, 1.0)

ELLIPSE_SCALE = 10.0  # contact ellipses are drawn this many times as large
_ORIGIN = (0.0, 0.0, 0.0)
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)
OUTLINE_SIDES = 8
_ANGLES = np.repeat(np.linspace(0.0, 2.0 * np.pi, OUTLINE_SIDES + 1), 2)[1:-1, None]  # both ends of each side
_COSINES, _SINES = np.cos(_ANGLES), np.sin(_ANGLES)


def marker(namespace, number, kind, scale, color, position=_ORIGIN, orientation=_UPRIGHT, *, points=None, text=""):
    """One marker: `kind` as CUBE ... TEXT, `scale` and `points` [m], `color` red, green, blue, opacity."""
    pose = {"position": position, "orientation": orientation}
    points = () if points is None else np.reshape(points, (-1, 3))
    return {
        "ns": namespace, "id": number, "type": kind, "pose": pose, "scale": scale, "color": color, "points": points,
        "text": text,
    }  # fmt: skip


def crossed(a, b) -> np.ndarray:
    """The vector products of (..., 3) and (..., 3): as `numpy.cross`, which takes five times as long for a few rows."""
    found = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        found[..., axis] = a[..., one] * b[..., other] - a[..., other] * b[..., one]
    return found


def outlines(centres, major, minor) -> np.ndarray:
    """Both ends of every side of polygons around the ellipses with these centres and semi-axes (..., 3) [m]."""
    return centres[..., None, :] + _COSINES * major[..., None, :] + _SINES * minor[..., None, :]


def contact_markers(sample, normal, longest: float, place) -> list[dict]:
    """The contact ellipse of a sample, ELLIPSE_SCALE times as large, while it is loaded; its load as text at `place`.

    `normal` (3,) is that of the contact, `longest` [m] the longest semi-axis of the body, by which sizes are drawn.
    """
    load, major = float(sample["normal_load"]), sample["major_axis"]
    sides = outlines(
        sample["contact_point"][None],
        ELLIPSE_SCALE * float(sample["semi_major"]) * major[None],
        ELLIPSE_SCALE * float(sample["semi_minor"]) * np.cross(normal, major)[None],
    )
    width, height = (0.02 * longest, 0.0, 0.0), (0.0, 0.0, 0.3 * longest)
    return [
        marker("contact_ellipses", 0, LINE_LIST, width, RED, points=sides if load > 0.0 else None),
        marker("load", 0, TEXT, height, GREEN, place, text=f"{load:.4g} N, ellipse x {ELLIPSE_SCALE:g}"),
    ]
