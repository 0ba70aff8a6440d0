"""The picture of two bodies: their paths and outlines, gap and load, slip and spin, and where their energy goes."""

import math

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.base.units import prefixed
from bearing_twin.kinds.ellipsoid.picture import BouncingPicture
from bearing_twin.kinds.two_bodies.derived import ROWS
from bearing_twin.numerics.rotation import rotation_matrix
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading
from bearing_twin.shapes.implicit import CONVEX, level, support

OUTLINES, SIDES = 9, 96  # of a body along its path; sides of an outline
GRID = 160  # points across the section of a body that is drawn by it


class TwoBodiesPicture(BouncingPicture):
    """The picture of one run of any length."""

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        grid = figure.add_gridspec(3, 2, left=0.06, right=0.98, top=0.90, bottom=0.095, hspace=0.36, wspace=0.24)
        _draw_side(figure.add_subplot(grid[:2, 0]), values, self._facts.scene.parameters)
        time, gap = values["time"], figure.add_subplot(grid[0, 1])
        _draw_slip(figure.add_subplot(grid[2, 0], sharex=gap), time, values)
        _draw_gap(gap, time, values)
        risen = values["potential_energy"] - values["potential_energy"].min()
        self.draw_load_and_energy(figure, grid, gap, values | {"potential_energy": risen})


def _view(parameters, position) -> tuple[np.ndarray, np.ndarray, str, str]:
    """Right and up of the picture: up against gravity, right the fixed axis along which the first body moves most."""
    fall = np.array(parameters.gravity)
    vertical = int(np.argmax(np.abs(fall))) if fall.any() else 2
    spread = np.ptp(position, axis=0)
    spread[vertical] = -1.0
    along = int(np.argmax(spread))
    up = np.eye(3)[vertical] * (-1.0 if fall[vertical] > 0.0 else 1.0)
    return np.eye(3)[along], up, "xyz"[along], ("-" if up[vertical] < 0.0 else "") + "xyz"[vertical]


def _draw_side(axis, values, parameters):
    """Paths of the centres and outlines of the bodies, true to scale; planes and grooves by their section."""
    frame(axis)
    right, up, across, height = _view(parameters, values["position"])
    view = np.stack([right, up])
    rows = np.unique(np.linspace(0, len(values["time"]) - 1, OUTLINES).astype(int))
    sections = []
    for one, prefix, colour in ((parameters.first, "", 0), (parameters.second, "second_", 5)):
        centre = values[f"{prefix}position"]
        surface = ROWS[one.shape].surface(one)
        if surface.kind not in CONVEX:
            sections.append((surface, centre[-1], values[f"{prefix}orientation"][-1]))
            continue
        for row in rows:
            outline = centre[row] + _outline(surface, values[f"{prefix}orientation"][row], view)
            axis.plot(*(1e3 * outline @ view.T).T, color=BALL_COLOURS[colour], alpha=0.35, linewidth=1.0)
        axis.plot(*(1e3 * centre @ view.T).T, color=BALL_COLOURS[colour], linewidth=1.8, label=f"{one.shape}: centre")
        axis.plot(*(1e3 * view @ centre[0]), "o", color=BALL_COLOURS[colour], markersize=7)
    axis.set_aspect("equal", adjustable="datalim")
    axis.autoscale_view()
    axis.figure.draw_without_rendering()
    for section in sections:
        _draw_section(axis, *section, right, up, values["position"][-1])
    axis.legend(frameon=False, fontsize=11, loc="best")
    heading(axis, "From the side: paths of the centres, outlines", f"{across} [mm]", f"{height} [mm]")


def _outline(surface, orientation, view):
    """Points (n, 3) [m] of a convex body's outline seen across the two directions `view` (2, 3), about its centre."""
    turn = rotation_matrix(tuple(map(float, orientation)))
    angles = np.linspace(0.0, 2.0 * math.pi, SIDES + 1)
    ways = np.cos(angles)[:, None] * view[0] + np.sin(angles)[:, None] * view[1]
    return support(surface, ways @ turn) @ turn.T


def _draw_section(axis, surface, centre, orientation, right, up, through):
    """The section of a body by the plane of the picture through the point `through`, filled where the body is."""
    turn = rotation_matrix(tuple(map(float, orientation)))
    x, y = (1e-3 * np.linspace(*limits, GRID) for limits in (axis.get_xlim(), axis.get_ylim()))
    depth = np.cross(right, up)
    values = np.empty((GRID, GRID))
    for row, high in enumerate(y):
        for column, far in enumerate(x):
            point = far * right + high * up + (through @ depth) * depth
            values[row, column] = level(surface, turn.T @ (point - centre)).value
    axis.contourf(1e3 * x, 1e3 * y, values, levels=[-np.inf, 0.0], colors=[STYLE["ring"]], zorder=0.5)
    axis.contour(1e3 * x, 1e3 * y, values, levels=[0.0], colors=[STYLE["edge"]], linewidths=2.0)


def _draw_gap(axis, time, values):
    frame(axis)
    gap = -values["approach"]
    factor, unit = prefixed(float(np.abs(gap).max()), "m")
    axis.plot(time, factor * gap, color=BALL_COLOURS[2], linewidth=1.4)
    axis.margins(x=0.0)
    heading(axis, "Gap between the opposing points", up=f"gap [{unit}]")


def _draw_slip(axis, time, values):
    """Slip in contact on the left, spin on the right."""
    frame(axis)
    touching = values["in_contact"] > 0.0
    slip = np.where(touching, np.linalg.norm(values["slip"], axis=1), np.nan)
    axis.plot(time, slip, ".", markersize=3, color=BALL_COLOURS[0], label="slip")
    axis.set_ylabel("slip [m/s]")
    axis.set_xlabel("time [s]")
    axis.margins(x=0.0)
    other = axis.twinx()
    spin = np.where(touching, values["spin_rate"], np.nan)
    other.plot(time, spin, ".", markersize=3, color=BALL_COLOURS[5], label="spin about the normal")
    other.set_ylabel("spin [rad/s]", size=12, color=STYLE["ink"])
    other.tick_params(length=0, labelsize=11)
    for spine in other.spines.values():
        spine.set_visible(False)
    lines = [*axis.get_lines(), *other.get_lines()]
    look = {"frameon": False, "fontsize": 10, "markerscale": 4, "ncols": 2, "borderaxespad": 0.0}
    axis.legend(lines, [line.get_label() for line in lines], loc="lower right", bbox_to_anchor=(1.0, 1.0), **look)
    heading(axis, "Slip and spin in contact")
