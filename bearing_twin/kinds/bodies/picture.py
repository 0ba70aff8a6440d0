"""The pictures of bodies that collide.

Force over time and approach, velocities; paths, outlines, tilt, gap, slip; and where the energy goes.
"""

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from bearing_twin.base.units import prefixed
from bearing_twin.kinds.bodies.derived import surface_of
from bearing_twin.kinds.bodies.display import ENERGIES, LOST, STORED
from bearing_twin.kinds.bodies.figures import BOUNCE, CONTACT
from bearing_twin.kinds.bodies.impact import peak_of
from bearing_twin.pictures import (
    BALL_COLOURS,
    STYLE,
    RunPicture,
    draw_peaks,
    frame,
    heading,
    marker_of,
    scaled,
    scaled_time,
)
from bearing_twin.shapes import CONVEX, TORUS, rotation_matrix, rotation_rows, support

MISSED = 10  # outputs in a contact: fewer may pass its peak by
NONE = np.empty((3, 0))
OUTLINES, SIDES = 9, 96  # of a body along its path; sides of an outline
GRID = 160  # points across the section of a body that is drawn by it
BESIDE, FEW = 1.4, 1e2  # room below and above the loads, as a factor; greatest over least that has numbers between
ROOM = {"left": 0.06, "right": 0.98, "bottom": 0.095}
LEGEND = {"frameon": False, "fontsize": 11}
ABOVE = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.98), "borderpad": 0}  # of a panel


class PairPicture(RunPicture):
    """The picture of one impact, from all its outputs: an impact is short."""

    kept = CONTACT.name

    def contacts(self) -> np.ndarray:
        """Begin, end [s] and greatest force [N] of each contact that has ended, (3, n)."""
        start, lasting, peak = self.recorded(CONTACT, "start", "duration", "peak_force")
        return np.stack([start, start + lasting, peak])  # "time" may be that of the output that brought the record

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        grid = figure.add_gridspec(2, 2, top=0.89, hspace=0.3, wspace=0.16, **ROOM)
        force, approach, velocity, energy = (figure.add_subplot(grid[k // 2, k % 2]) for k in range(4))
        time, scale, unit = scaled_time(values["time"])
        draw_force(force, time, values, scale, self.contacts())
        force.set_xlabel(f"time [{unit}]")
        frame(approach)
        inside, marks = values["approach"] >= 0.0, {"linewidth": 2, "marker": marker_of(len(time))}
        deep, load = values["approach"][inside], values["normal_load"][inside]
        (by_length, length), (by_force, newtons) = scaled(deep, "m"), scaled(values["normal_load"], "N")
        approach.plot(by_length * deep, by_force * load, color=BALL_COLOURS[0], **marks)
        across, up = f"approach [{length}]", f"contact force [{newtons}]"
        heading(approach, "Force against approach: the loop is the energy lost", across, up)
        both = dict(zip(("first", "second"), values["velocity"].T, strict=True))
        draw_curves(velocity, time, both, "The two bodies", f"time [{unit}]", "velocity [m/s]")
        draw_energies(energy, time, unit, values)


def draw_curves(axis, time, curves, title: str, across=None, up=None, dashed: bool = False, **legend) -> None:
    """Curves over time by their names; `dashed` are all but the first, which some of them may hide."""
    frame(axis)
    for place, (name, values) in enumerate(curves.items()):
        line = (0, (5, 1 + 2 * place)) if dashed and place else "-"
        look = {"color": BALL_COLOURS[place], "linewidth": 1.6, "linestyle": line, "marker": marker_of(len(time))}
        axis.plot(time, values, label=name, **look)
    axis.margins(x=0.0)
    if len(curves) > 1:
        axis.legend(**LEGEND | legend)
    heading(axis, title, across, up)


def draw_force(axis, time, values, scale: float = 1.0, contacts=NONE) -> None:
    """The contact force over time, its peak in the heading; `time` is by `scale` in another unit than the contacts.

    Of `contacts`, (3, n) as of `PairPicture.contacts`, those that fewer outputs than MISSED see are marked.
    """
    frame(axis)
    load, (begin, end, recorded) = values["normal_load"], (scale * contacts[0], scale * contacts[1], contacts[2])
    peak = max(float(load.max()), float(recorded.max())) if recorded.size else peak_of(load)
    factor, unit = prefixed(peak, "N")
    axis.fill_between(time, factor * load, color=BALL_COLOURS[0], alpha=0.2, linewidth=0)
    axis.plot(time, factor * load, color=BALL_COLOURS[0], linewidth=2, marker=marker_of(len(time)))
    seen = np.searchsorted(time, end, side="right") - np.searchsorted(time, begin)
    missed = seen < MISSED
    if missed.any():
        draw_peaks(axis, time[-1] - time[0], begin[missed], end[missed], factor * recorded[missed])
        axis.legend(frameon=False, fontsize=10, loc="best")
    axis.margins(x=0.0)
    heading(axis, f"Contact force, peak {factor * peak:.5g} {unit}", up=f"contact force [{unit}]")


def draw_energies(axis, time, unit, values, shown=ENERGIES) -> None:
    """Stored energies on top of each other, as a share of the initial energy: it is conserved where they reach 1."""
    initial = values["kinetic_energy"][0]
    parts = [values[name] / initial for name, _ in shown]
    _stack(axis, time, parts, shown, BALL_COLOURS, 3, max(1.3, 1.15 * float(np.sum(parts, axis=0).max())))
    heading(axis, "Energy", f"time [{unit}]", "share of the initial energy")


def _stack(axis, time, parts, shown, colours, columns: int, top: float) -> None:
    """Shares of an energy on top of each other, named by `shown`, and a line at 1."""
    frame(axis)
    labels = [text for _, text in shown]
    axis.stackplot(time, parts, labels=labels, colors=colours[: len(parts)], alpha=0.78, linewidth=0)
    axis.axhline(1.0, color=STYLE["ink"], linewidth=1.0, linestyle=":")
    axis.margins(x=0.0)
    axis.tick_params(pad=6)  # its first numbers stand in one corner
    axis.set_ylim(0.0, top)
    axis.legend(frameon=False, fontsize=10, ncol=columns, loc="upper right", columnspacing=1.0, handlelength=1.2)


class BouncingPicture(RunPicture):
    """The picture of a run of bodies that bounce, of any length, with the contacts, whose peaks fall between outputs.

    Of an ellipsoid on a plane its path from the side and from above and its tilt; of two bodies paths from the side,
    gap, slip and spin.
    """

    kept = BOUNCE.name

    def draw(self, figure: Figure, values: dict[str, np.ndarray]) -> None:
        parameters, time = self._facts.scene.parameters, values["time"]
        bodies, pair = parameters.bodies, "second_position" in values
        grid = figure.add_gridspec(3, 2, top=0.90, hspace=0.36, wspace=0.24 if pair else 0.16, **ROOM)
        left = [figure.add_subplot(grid[rows, 0]) for rows in ((slice(0, 2), 2) if pair else (0, slice(1, 3)))]
        upper, load, energy = (figure.add_subplot(grid[row, 1]) for row in range(3))
        for axis in (load, energy, *left[1:] * pair):
            axis.sharex(upper)
        if pair:
            right, up = _directions(parameters, values["position"])
            _draw_paths(left[0], values, bodies, right, up, "From the side: paths of the centres, outlines")
            _draw_slip(left[1], time, values)
            factor, unit = prefixed(float(np.abs(values["approach"]).max()), "m")
            gap = {"gap": -factor * values["approach"]}
            draw_curves(upper, time, gap, "Gap between the opposing points", up=f"gap [{unit}]")
            values = values | {"potential_energy": values["potential_energy"] - values["potential_energy"].min()}
        else:
            x, y, z = np.eye(3)
            if np.ptp(values["position"][:, 0]) < 0.5 * max(bodies[0].semi_axes):
                draw_curves(
                    left[0], time, {"z": 1e3 * values["position"][:, 2]}, "Height of the centre", "time [s]", "z [mm]"
                )
                left[0].axhline(0.0, color=STYLE["edge"], linewidth=2.5)
            else:
                _draw_paths(left[0], values, bodies, x, z, "From the side: path of the centre, outlines of the body")
            _draw_paths(left[1], values, bodies[:1], x, y, "From above: paths, outlines of the body")
            # An axis has no direction: 0 to 90 degrees.
            upward = np.abs(rotation_rows(values["orientation"].T)[2]).clip(max=1.0)
            tilts = {f"own {name}": np.degrees(np.arccos(one)) for name, one in zip("xyz", upward, strict=True)}
            draw_curves(upper, time, tilts, "Tilt of the body's axes", up="to the vertical [°]", ncol=3, **ABOVE)
            upper.set(ylim=(-2.0, 92.0), yticks=(0, 30, 60, 90))
        contacts = self.recorded(BOUNCE, "start", "time", "peak_load")
        _draw_load(load, time, values, self._values.greatest["normal_load"], contacts)
        scale = max(float(sum(values[name] for name, _ in STORED).max()), 1e-300)
        parts, shown = [np.maximum(values[name] / scale, 0.0) for name, _ in (*STORED, *LOST)], (*STORED, *LOST)
        _stack(energy, time, parts, shown, [BALL_COLOURS[k] for k in (0, 4, 5, 1, 7)], 5, 1.3)
        heading(energy, "Energy balance: the shares add up to 1", "time [s]", "share")
        for axis in (upper, load):
            axis.tick_params(labelbottom=False)


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


def _draw_paths(axis, values, bodies, right, up, title: str) -> None:
    """Paths of the centres and outlines of the bodies, true to scale; planes and grooves by their section.

    Of one body also the path of the contact.
    """
    frame(axis)
    view, sections = np.stack([right, up]), []
    for one, prefix, colour in zip(bodies, ("", "second_"), (0, 5), strict=False):
        centre = values.get(f"{prefix}position", np.zeros((1, 3)))
        turns = values.get(f"{prefix}orientation", np.array([[0.0, 0.0, 0.0, 1.0]]))
        surface, look = surface_of(one), {"color": BALL_COLOURS[colour]}
        if surface.kind not in CONVEX:
            sections.append((surface, centre[-1], turns[-1]))
            continue
        for row in _rows_along(values["position"]):
            outline = centre[row] + _outline(surface, turns[row], view)
            axis.plot(*(1e3 * outline @ view.T).T, alpha=0.35, linewidth=1.0, **look)
        axis.plot(*(1e3 * centre @ view.T).T, linewidth=1.8, label=f"{one.shape}: centre", **look)
        axis.plot(*(1e3 * view @ centre[0]), "o", markersize=7, **look)
    if len(bodies) == 1:
        point = np.where(values["in_contact"][:, None] > 0.0, 1e3 * values["contact_point"] @ view.T, np.nan)
        axis.plot(*point.T, color=BALL_COLOURS[5], linewidth=1.0, label="point of contact")
    axis.set_aspect("equal", adjustable="datalim")
    axis.autoscale_view()
    axis.figure.draw_without_rendering()
    for section in sections:
        _draw_section(axis, *section, right, up, values["position"][-1])
    axis.legend(loc="best", **LEGEND)
    heading(axis, title, _named(right), _named(up))


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
    ways = np.cos(angles)[:, None] * view[0] + np.sin(angles)[:, None] * view[1]
    return support(surface, ways @ turn) @ turn.T


def _draw_section(axis, surface, centre, orientation, right, up, through):
    """The section of a plane or a groove by the plane of the picture through the point `through`, filled."""
    x, y = (1e-3 * np.linspace(*limits, GRID) for limits in (axis.get_xlim(), axis.get_ylim()))
    depth = np.cross(right, up)
    points = x[:, None] * right + y[:, None, None] * up + (through @ depth) * depth
    own = (points - centre) @ rotation_matrix(tuple(map(float, orientation)))
    outside = own[..., 2]  # above zero outside the body
    if surface.kind == TORUS:
        ring, tube = surface.sizes[:2]
        outside = tube - np.hypot(np.hypot(own[..., 0], own[..., 1]) - ring, own[..., 2])
    axis.contourf(1e3 * x, 1e3 * y, outside, levels=[-np.inf, 0.0], colors=[STYLE["ring"]], zorder=0.5)
    axis.contour(1e3 * x, 1e3 * y, outside, levels=[0.0], colors=[STYLE["edge"]], linewidths=2.0)


def _draw_slip(axis, time, values):
    """Slip in contact on the left, spin on the right."""
    frame(axis)
    touching, other = values["in_contact"] > 0.0, axis.twinx()
    sizes = np.linalg.norm(values["slip"], axis=1), values["spin_rate"]
    words = ("slip", "slip [m/s]"), ("spin about the normal", "spin [rad/s]")
    for one, size, (label, up), colour in zip((axis, other), sizes, words, (0, 5), strict=True):
        drawn = np.where(touching, size, np.nan)
        one.plot(time, drawn, ".", markersize=3, color=BALL_COLOURS[colour], label=label)
        one.set_ylabel(up, size=12, color=STYLE["ink"])
    axis.margins(x=0.0)
    other.tick_params(length=0, labelsize=11)
    other.spines[:].set_visible(False)
    lines = [*axis.get_lines(), *other.get_lines()]
    axis.legend(lines, [line.get_label() for line in lines], markerscale=4, ncols=2, **LEGEND, **ABOVE)
    heading(axis, "Slip and spin in contact", "time [s]")


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
    if np.any(load > 0.0):  # bounces of one or two outputs make no line
        axis.plot(time, loaded, ".-", color=BALL_COLOURS[0], linewidth=1.0, markersize=2, label="at the outputs")
    hit = peak > 0.0  # a touch so light that it has no peak is not on this axis
    if np.any(hit):
        draw_peaks(axis, time[-1] - time[0], begin[hit], end[hit], factor * peak[hit])
        axis.legend(ncol=2, **LEGEND, **ABOVE)
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
