"""The picture of an ellipsoid on a plane: its path, its tilt, the load it presses with, and where its energy goes."""

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from bearing_twin.base.units import prefixed
from bearing_twin.kinds.ellipsoid.figures import CONTACT
from bearing_twin.kinds.ellipsoid.view import LOST, STORED
from bearing_twin.numerics.rotation import rotation_matrix, rotation_rows
from bearing_twin.pictures.panels import draw_peaks
from bearing_twin.pictures.run import RunPicture
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, frame, heading

OUTLINES = 9  # of the body along its path
BESIDE, FEW = 1.4, 1e2  # room below and above the loads, as a factor; greatest over least that has numbers between


class BouncingPicture(RunPicture):
    """Common to pictures of bouncing bodies: they keep the contacts, whose peaks fall between outputs."""

    kept = CONTACT.name

    def draw_load_and_energy(self, figure: Figure, grid, above, values: dict[str, np.ndarray]) -> None:
        """Both below the panel `above` at the right."""
        load, energy = (figure.add_subplot(grid[row, 1], sharex=above) for row in (1, 2))
        contacts = self.recorded(CONTACT, "start", "time", "peak_load")
        _draw_load(load, values["time"], values, self._values.greatest["normal_load"], contacts)
        _draw_energy(energy, values["time"], values)
        for axis in (above, load):
            axis.tick_params(labelbottom=False)


class EllipsoidPicture(BouncingPicture):
    """The picture of one run of any length."""

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        grid = figure.add_gridspec(3, 2, left=0.06, right=0.98, top=0.90, bottom=0.095, hspace=0.36, wspace=0.16)
        _draw_side(figure.add_subplot(grid[0, 0]), values, self._facts.scene)
        _draw_plan(figure.add_subplot(grid[1:, 0]), values, self._facts.scene)
        tilt = figure.add_subplot(grid[0, 1])
        _draw_tilt(tilt, values["time"], values)
        self.draw_load_and_energy(figure, grid, tilt, values)


def _draw_side(axis, values, scene):
    """Height of the centre along x with the body's outline seen along y, true to scale where the path allows it."""
    frame(axis)
    x, z = 1e3 * values["position"][:, 0], 1e3 * values["position"][:, 2]
    semi_axes = np.array(scene.parameters.body.semi_axes)
    time = values["time"]
    axis.axhline(0.0, color=STYLE["edge"], linewidth=2.5)
    still = np.ptp(x) < 0.5e3 * semi_axes.max()
    if still:
        axis.plot(time, z, color=BALL_COLOURS[0], linewidth=1.6)
        axis.margins(x=0.0)
        heading(axis, "Height of the centre", "time [s]")
    else:
        for row in _rows_along(values["position"]):
            outline = 1e3 * _outline(semi_axes, values["orientation"][row], (0, 2))
            axis.add_patch(
                Polygon(outline + np.array([x[row], z[row]]), closed=True, fill=False, color=BALL_COLOURS[4])
            )
        axis.plot(x, z, color=BALL_COLOURS[0], linewidth=1.6)
        axis.set_aspect("equal", adjustable="datalim")
        axis.autoscale_view()
        heading(axis, "From the side: path of the centre, outlines of the body", "x [mm]")
    axis.set_ylabel("z [mm]")


def _draw_plan(axis, values, scene):
    """Centre and point of contact from above."""
    frame(axis)
    centre, touching = 1e3 * values["position"], values["in_contact"] > 0.0
    point = np.where(touching[:, None], 1e3 * values["contact_point"], np.nan)
    semi_axes = np.array(scene.parameters.body.semi_axes)
    for row in _rows_along(values["position"]):
        outline = 1e3 * _outline(semi_axes, values["orientation"][row], (0, 1))
        axis.add_patch(Polygon(outline + centre[row, :2], closed=True, fill=False, color=BALL_COLOURS[4], alpha=0.8))
    if touching.any():
        axis.plot(point[:, 0], point[:, 1], color=BALL_COLOURS[5], linewidth=1.0, label="point of contact")
    axis.plot(centre[:, 0], centre[:, 1], color=BALL_COLOURS[0], linewidth=2.0, label="centre")
    axis.plot(*centre[0, :2], "o", color=BALL_COLOURS[0], markersize=8, label="start")
    axis.set_aspect("equal", adjustable="datalim")
    axis.autoscale_view()
    axis.legend(frameon=False, fontsize=11, loc="best")
    heading(axis, "From above: paths, outlines of the body", "x [mm]", "y [mm]")


def _rows_along(position):
    """Rows spread evenly over the way of the centre; the first and the last are among them."""
    steps = np.linalg.norm(np.diff(position, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    if way[-1] == 0.0:
        return [0]
    return sorted({int(row) for row in np.searchsorted(way, np.linspace(0.0, way[-1], OUTLINES)).clip(0, len(way) - 1)})


def _outline(semi_axes, orientation, plane):
    """Outline (n, 2) [m] of the ellipsoid seen along the axis that is not in `plane`, about its centre.

    The shadow of {R A s} is the ellipse of the support function |A R^T d|: points R A^2 R^T d / |A R^T d|.
    """
    turn = rotation_matrix(orientation)
    angle = np.linspace(0.0, 2.0 * math.pi, 73)
    direction = np.zeros((len(angle), 3))
    direction[:, plane[0]], direction[:, plane[1]] = np.cos(angle), np.sin(angle)
    own = (direction @ turn) * semi_axes
    points = (own * semi_axes) @ turn.T / np.linalg.norm(own, axis=1)[:, None]
    return points[:, list(plane)]


def _draw_tilt(axis, time, values):
    """Angle of each own axis to the vertical, 0 to 90 degrees: an axis has no direction."""
    frame(axis)
    _, _, upward = rotation_rows(values["orientation"].T)
    for number, (name, cosine) in enumerate(zip("xyz", upward, strict=True)):
        angle = np.degrees(np.arccos(np.minimum(np.abs(cosine), 1.0)))
        axis.plot(time, angle, color=BALL_COLOURS[number], linewidth=1.4, label=f"own {name}")
    axis.set_ylim(-2.0, 92.0)
    axis.set_yticks([0, 30, 60, 90])
    axis.margins(x=0.0)
    axis.legend(frameon=False, fontsize=11, ncol=3, loc="lower right", bbox_to_anchor=(1.0, 0.98), borderpad=0)
    heading(axis, "Tilt of the body's axes", up="to the vertical [°]")


def _draw_load(axis, time, values, seen, contacts):
    """Normal load over time, and the peak of every contact that has ended: outputs may lie on either side of it.

    `seen` [N] is the greatest at any output, also one that a long run's picture leaves out.
    """
    frame(axis)
    axis.margins(x=0.0)
    load = values["normal_load"]
    begin, end, peak = contacts
    greatest = max(seen, float(peak.max(initial=0.0)))
    if not greatest > 0.0:
        axis.set_yticks([])
        look = {"transform": axis.transAxes, "ha": "center", "va": "center", "color": STYLE["soft"], "fontsize": 12}
        axis.text(0.5, 0.5, "no contact that has ended, and no load at an output", **look)
        heading(axis, "Normal load", up="normal load [N]")
        return
    factor, unit = prefixed(greatest, "N")
    loaded = np.where(load > 0.0, factor * load, np.nan)
    beside = np.concatenate([[0.0], load, [0.0]])
    alone = (load > 0.0) & ((beside[:-2] <= 0.0) | (beside[2:] <= 0.0))  # bounces of one or two outputs make no line
    if np.any(load > 0.0):
        axis.plot(time, loaded, color=BALL_COLOURS[0], linewidth=1.0, label="at the outputs")
    axis.plot(time[alone], loaded[alone], ".", color=BALL_COLOURS[0])
    hit = peak > 0.0  # a touch so light that it has no peak is not on this axis
    if np.any(hit):
        draw_peaks(axis, time[-1] - time[0], begin[hit], end[hit], factor * peak[hit])
        axis.legend(frameon=False, fontsize=11, ncol=2, loc="lower right", bbox_to_anchor=(1.0, 0.98), borderpad=0)
    axis.set_xlim(time[0], time[-1])
    axis.set_yscale("log")
    high = factor * greatest
    low = min(high, *(float(one.min(initial=high)) for one in (loaded[load > 0.0], factor * peak[hit])))
    axis.set_ylim(low / BESIDE, high * BESIDE)
    if high < FEW * low:  # powers of ten alone would leave an axis with one number
        axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.yaxis.set_minor_formatter(NullFormatter())
    heading(axis, f"Normal load, peak {factor * greatest:.4g} {unit}", up=f"normal load [{unit}]")


def _draw_energy(axis, time, values):
    """Where the energy is, stacked: potential energy from where it is least."""
    frame(axis)
    scale = max(float(sum(values[name] for name, _ in STORED).max()), 1e-300)
    parts = [np.maximum(values[name] / scale, 0.0) for name, _ in (*STORED, *LOST)]
    labels = [text for _, text in (*STORED, *LOST)]
    colours = [BALL_COLOURS[k] for k in (0, 4, 5, 1, 7)]
    axis.stackplot(time, parts, labels=labels, colors=colours, alpha=0.8, linewidth=0)
    axis.axhline(1.0, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.margins(x=0.0)
    axis.set_ylim(0.0, 1.3)
    axis.tick_params(pad=6)
    axis.legend(frameon=False, fontsize=10, ncol=5, loc="upper right", columnspacing=1.0, handlelength=1.2)
    heading(axis, "Energy: the books are closed where the sum stays at 1", "time [s]", "share")
