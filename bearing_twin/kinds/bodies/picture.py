"""Drawings beside the curves of bodies that collide: force over approach; paths and outlines."""

import math

import numpy as np

from bearing_twin.kinds.bodies.derived import surface_of
from bearing_twin.kinds.bodies.display import bouncing_view, impact_view
from bearing_twin.kinds.bodies.figures import BOUNCE, CONTACT
from bearing_twin.kinds.picture import RunPicture
from bearing_twin.pictures import BALL_COLOURS, STYLE, heading, marker_of, readable_scale, style_axes
from bearing_twin.shapes import CONVEX, TORUS, rotation_matrix, support

OUTLINES, SIDES = 9, 96  # of a body along its path; sides of an outline
GRID = 160  # points across the section of a body that is drawn by it


class PairPicture(RunPicture):
    """The picture of one impact."""

    view, peaks = staticmethod(impact_view), (CONTACT, "start", "time", "peak_force")

    def draw_bodies(self, figure, cell, values) -> None:
        """The force over the approach."""
        axis, inside = figure.add_subplot(cell), values["approach"] >= 0.0
        style_axes(axis)
        deep, load = values["approach"][inside], values["normal_load"][inside]
        (by_length, length), (by_force, newtons) = readable_scale(deep, "m"), readable_scale(load, "N")
        axis.plot(by_length * deep, by_force * load, color=BALL_COLOURS[0], linewidth=2, marker=marker_of(len(inside)))
        across, up = f"approach [{length}]", f"contact force [{newtons}]"
        heading(axis, "Force against approach: the loop is the energy lost", across, up)


class BouncingPicture(RunPicture):
    """The picture of a run of bodies that bounce."""

    view, peaks = staticmethod(bouncing_view), (BOUNCE, "start", "time", "peak_load")

    def draw_bodies(self, figure, cell, values) -> None:
        """Paths and outlines of the bodies, seen across the direction in which the first one moves most, and along."""
        parameters = self.parameters
        right, up = _directions(parameters, values["position"])
        side, above = cell.subgridspec(2, 1, hspace=0.24).subplots()
        _draw_paths(side, values, parameters.bodies, np.stack([right, up]), "From the side: paths and outlines", True)
        _draw_paths(above, values, parameters.bodies, np.stack([right, np.cross(up, right)]), "From above", False)


def _directions(parameters, position) -> tuple[np.ndarray, np.ndarray]:
    """Right and up of the picture: up against gravity, right the fixed axis along which the first body moves most."""
    fall = np.array(parameters.gravity)
    vertical = int(np.argmax(np.abs(fall))) if fall.any() else 2
    spread = np.ptp(position, axis=0)
    spread[vertical] = -1.0
    return np.eye(3)[int(np.argmax(spread))], np.eye(3)[vertical] * (-1.0 if fall[vertical] > 0.0 else 1.0)


def _named(direction) -> str:
    """A fixed axis as a label."""
    return f"{'-' if direction.sum() < 0.0 else ''}{'xyz'[int(np.argmax(np.abs(direction)))]} [mm]"


def _draw_paths(axis, values, bodies, view, title: str, sections: bool) -> None:
    """Paths of centres and contact and outlines of the bodies across the directions `view` (2, 3), true to scale.

    Of planes and grooves the `sections`.
    """
    style_axes(axis)
    cut = []
    for body, prefix, colour in zip(bodies, ("", "second_"), (0, 4), strict=True):
        centre = values.get(f"{prefix}position", np.zeros((1, 3)))
        turns = values.get(f"{prefix}orientation", np.array([[0.0, 0.0, 0.0, 1.0]]))
        surface, colour_style = surface_of(body), {"color": BALL_COLOURS[colour]}
        if surface.kind not in CONVEX:
            cut.append((surface, centre[-1], turns[-1]))
            continue
        for row in _rows_along(values["position"]):
            outline = centre[row] + _outline(surface, turns[row], view)
            axis.plot(*(1e3 * outline @ view.T).T, alpha=0.35, linewidth=1.0, **colour_style)
        axis.plot(*(1e3 * centre @ view.T).T, linewidth=1.8, label=f"{body.shape}: centre", **colour_style)
        axis.plot(*(1e3 * view @ centre[0]), "o", markersize=7, **colour_style)
    point = np.where(values["in_contact"][:, None] > 0.0, 1e3 * values["contact_point"] @ view.T, np.nan)
    label = "point of contact" if values["in_contact"].any() else None
    axis.plot(*point.T, color=BALL_COLOURS[5], linewidth=1.0, label=label)
    axis.set_aspect("equal", adjustable="datalim")
    axis.autoscale_view()
    axis.figure.draw_without_rendering()
    for section in cut if sections else ():
        _draw_section(axis, *section, *view, values["position"][-1])
    axis.legend(loc="best", frameon=False, fontsize=11)
    heading(axis, title, *map(_named, view))


def _rows_along(position):
    """Rows spread evenly over the way of the centre; the first and the last are among them."""
    steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    if way[-1] == 0.0:
        return [0]
    return sorted({int(row) for row in np.searchsorted(way, np.linspace(0.0, way[-1], OUTLINES)).clip(0, len(way) - 1)})


def _outline(surface, orientation, view):
    """Points (n, 3) [m] of a convex body's outline seen across the two directions `view` (2, 3), about its centre."""
    turn = rotation_matrix(tuple(map(float, orientation)))
    angles = np.linspace(0.0, 2.0 * math.pi, SIDES + 1)
    directions = np.cos(angles)[:, None] * view[0] + np.sin(angles)[:, None] * view[1]
    return support(surface, directions @ turn) @ turn.T


def _draw_section(axis, surface, centre, orientation, right, up, through):
    """The section of a plane or a groove by the plane of the picture through the point `through`, filled."""
    x, y = (1e-3 * np.linspace(*limits, GRID) for limits in (axis.get_xlim(), axis.get_ylim()))
    depth = np.cross(right, up)
    points = x[:, None] * right + y[:, None, None] * up + (through @ depth) * depth
    local = (points - centre) @ rotation_matrix(tuple(map(float, orientation)))
    outside = local[..., 2]  # above zero outside the body
    if surface.kind == TORUS:
        ring, tube = surface.sizes[:2]
        outside = tube - np.hypot(np.hypot(local[..., 0], local[..., 1]) - ring, local[..., 2])
    axis.contourf(1e3 * x, 1e3 * y, outside, levels=[-np.inf, 0.0], colors=[STYLE["ring"]], zorder=0.5)
    axis.contour(1e3 * x, 1e3 * y, outside, levels=[0.0], colors=[STYLE["edge"]], linewidths=2.0)
