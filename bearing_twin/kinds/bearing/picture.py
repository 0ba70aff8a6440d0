"""The picture of one run: the load on every ball over time, and the bearing as it stands at the last sample."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Annulus, Circle, FancyArrowPatch

from bearing_twin import __version__
from bearing_twin.base.errors import LogError
from bearing_twin.base.sample import Block, Sample
from bearing_twin.kinds.bearing.drive import TORQUE
from bearing_twin.kinds.bearing.history import LoadHistory
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.kinds.bearing.rings import FREE_RING, dimension_of, moving_centre
from bearing_twin.kinds.contract import Facts
from bearing_twin.pictures.panels import axes_mark, finish, readable_on
from bearing_twin.pictures.style import (
    BALL_COLOURS,
    GREATEST_LINES,
    LOAD_MAP,
    RACEWAY_COLOURS,
    RACEWAYS,
    SIZE,
    STYLE,
    ball_line,
    frame,
    heading,
    marker_of,
    scaled,
)

FLAT = 0.6  # where the lowest load exceeds this part of the highest, the axis need not show zero
GREATEST_TURNS = 8  # of the balls round the bearing: more waves than this become a solid block
WORDS = {  # panel and axis of what moves, and the factor into its unit
    "inner_ring_offset": ("Inner ring's centre, from where it started", "displacement [µm]", 1e6),
    "cage_offset": ("Cage's centre, off the axis", "displacement [µm]", 1e6),
    "inner_ring_speed": ("Speed of the inner ring, turned by a torque", "speed [rpm]", 30.0 / np.pi),
}
GREATEST_NUMBERED = 40
RING = 0.55  # radial thickness of a drawn ring, in ball radii
ARROW = 2.0  # length of the longest load arrow, in ball radii


class BearingPicture:
    """Loads over time, the bearing and its contacts at the last output; of logs without a scene what is known."""

    def __init__(self, facts: Facts):
        self._facts, self._history = facts, LoadHistory()
        parameters = facts.scene.parameters if facts.scene else None
        self._moved = [LoadHistory("inner_ring_offset")] if parameters and dimension_of(parameters) == FREE_RING else []
        self._moved += [LoadHistory("cage_offset")] if parameters and moving_centre(parameters) else []
        self._moved += [LoadHistory("inner_ring_speed")] if parameters and parameters.drive.kind == TORQUE else []

    def add(self, block: Block) -> None:
        """Takes a block in."""
        self._history.add_block(block)
        for moved in self._moved:
            moved.add_block(block)

    def write(self, path, errors=()) -> Path:
        """Draws what was taken in; raises BearingTwinError where there is nothing or no place for it."""
        history, scene = self._history, self._facts.scene
        if history.last is None:
            raise LogError("there is no sample to draw; give a run or a log that holds at least one")
        figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
        edges = {"left": 0.06, "right": 0.98, "top": 0.90, "bottom": 0.095}
        grid = figure.add_gridspec(1, 2, width_ratios=(1.25, 1.0), wspace=0.14, **edges)
        left = grid[0].subgridspec(2 + len(self._moved), 1, hspace=(0.16, 0.24, 0.34, 0.44)[len(self._moved)])
        right = grid[1].subgridspec(3, 1, height_ratios=(4.0, 0.95, 0.7), hspace=0.2)
        loads = [figure.add_subplot(left[row]) for row in (0, 1)]
        _draw_loads(figure, loads, history)
        above = loads[1]
        for row, moved in enumerate(self._moved):
            above.tick_params(labelbottom=False)
            above.set_xlabel("")
            above = figure.add_subplot(left[2 + row])
            _draw_moved(above, moved)
        _draw_bearing(figure.add_subplot(right[0]), history.last, scene)
        _draw_contacts(figure.add_subplot(right[1]), figure.add_subplot(right[2]), history.last, scene)
        return finish(figure, _title(history, scene), _footer(self._facts, history), path, errors=errors)


def _draw_loads(figure, axes, history):
    whole = history.envelope()
    time, low, high = _shown(history) or whole
    part = f", last {time[-1] - time[0]:.3g} s of {history.last.time_ns * 1e-9:.4g} s" if time[0] > whole[0][0] else ""
    span = time[-1] - time[0]
    scale, unit = scaled(time[-1], "s")
    for raceway, axis in enumerate(axes):
        frame(axis)
        greatest = whole[2][:, :, raceway].max()
        if low.shape[1] > GREATEST_LINES:
            image = _load_map(axis, time * scale, high[:, :, raceway], whole[2].max() or 1.0)
            figure.colorbar(image, ax=axis, pad=0.015, label="normal load [N]")
            axis.set_ylabel("ball")
        else:
            _load_lines(axis, time * scale, low[:, :, raceway], high[:, :, raceway], greatest if part else None)
            axis.set_ylabel("normal load [N]")
        heading(axis, f"Normal load of each ball on the {RACEWAYS[raceway]} raceway{part}")
        axis.margins(x=0.0 if span else 0.05)
    axes[0].tick_params(labelbottom=False)
    axes[1].set_xlabel(f"time [{unit}]")


def _draw_moved(axis, history):
    """A ring's speed; or how far its centre is from where it started, or a cage's from the axis, along each axis."""
    name, envelope = history.channel, _shown(history) or history.envelope()
    time, low, high = (one.reshape(len(one), -1) for one in envelope)
    words, up, factor = WORDS[name]
    start = np.ravel(history.first[name]) * (name == "inner_ring_offset")
    scale, unit = scaled(time[-1], "s")
    frame(axis)
    for i, begin in enumerate(start):
        path = factor * (np.stack([low[:, i], high[:, i]], axis=1).ravel() - begin)
        look = {"label": "xyz"[i], "color": BALL_COLOURS[i]} if len(start) > 1 else {"color": STYLE["ink"]}
        axis.plot(np.repeat(time * scale, 2), path, linewidth=1.6, **look)
    heading(axis, words, f"time [{unit}]", up)
    axis.margins(x=0.0)
    if len(start) > 1:
        look = {"frameon": False, "fontsize": 10, "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.0}
        axis.legend(ncols=3, loc="lower right", **look)


def _shown(history):
    """The last turns of a run with many, if there are enough outputs in them; None = show all of it."""
    if history.turns <= GREATEST_TURNS:
        return None
    duration = (history.last.time_ns - history.first.time_ns) * 1e-9
    return history.latest(duration * GREATEST_TURNS / history.turns)


def _load_lines(axis, time, low, high, greatest_of_run):
    for ball in range(low.shape[1]):
        # low and high of a slice one after the other: no peak is lost, and it is one line for the eye
        load = np.stack([low[:, ball], high[:, ball]], axis=1).ravel()
        axis.plot(np.repeat(time, 2), load, linewidth=1.6, marker=marker_of(len(time)), **ball_line(ball))
    least, greatest = low.min(), high.max()
    if greatest_of_run is not None and greatest_of_run > 1.02 * greatest:
        greatest = greatest_of_run
        axis.axhline(greatest, color=STYLE["soft"], linewidth=1.0, linestyle=":")
        axis.annotate(f"greatest of the run {greatest:.4g} N", (0.995, greatest), xycoords=("axes fraction", "data"),
                      ha="right", va="bottom", color=STYLE["soft"])  # fmt: skip
    if least > FLAT * greatest:
        margin = max(0.08 * (greatest - least), 1e-4 * greatest)
        axis.set_ylim(least - margin, greatest + margin)
        note = "axis does not start at 0"
        axis.annotate(note, (0.995, 0.02), xycoords="axes fraction", ha="right", color=STYLE["soft"])
    else:
        axis.set_ylim(0.0, 1.06 * greatest or 1.0)
    axis.ticklabel_format(useOffset=False, style="plain")


def _load_map(axis, time, load, greatest):
    axis.grid(False)
    if len(time) == 1:
        time, load = np.array([time[0], time[0] + 1.0]), np.repeat(load, 2, axis=0)
    look = {"cmap": LOAD_MAP, "vmin": 0.0, "vmax": greatest, "shading": "nearest", "rasterized": True}
    return axis.pcolormesh(time, np.arange(load.shape[1]), load.T, **look)


def _draw_contacts(axes, angles, sample, scene):
    """Semi-axes and contact angle of every contact at the last sample; without a scene only the angle is known."""
    in_contact = sample["normal_load"] > 0.0
    balls = np.arange(len(in_contact))
    size = 7.0 if len(balls) <= GREATEST_LINES else 4.0
    for axis in (axes, angles):
        frame(axis)
        axis.set_xlim(-0.6, len(balls) - 0.4)
        axis.set_xticks(balls[:: -(-len(balls) // 16)])
    degrees = np.degrees(sample["contact_angle"])
    details = contact_details(scene.parameters, sample) if scene else {}
    for raceway, colour in enumerate(RACEWAY_COLOURS):
        touching = balls[in_contact[:, raceway]]
        where = touching + (-0.14, 0.14)[raceway]
        for name, fill in (("semi_major", colour), ("semi_minor", "white")) if details else ():
            label = f"{RACEWAYS[raceway]}, {name.removeprefix('semi_')}"
            look = {"ms": size, "mec": colour, "mew": 1.6, "mfc": fill, "label": label}
            axes.plot(where, details[name][touching, raceway] * 1e6, "o", **look)
        angles.plot(where, degrees[touching, raceway], "o", ms=size, mec=colour, mfc=colour)
    heading(axes, "Contacts", up="semi-axis [µm]")
    axes.set_ylim(0.0, 1.12 * axes.get_ylim()[1])
    axes.tick_params(labelbottom=False)
    if details:
        look = {"frameon": False, "fontsize": 10, "columnspacing": 0.7, "handletextpad": 0.0, "borderaxespad": 0.0}
        axes.legend(ncols=4, loc="lower right", bbox_to_anchor=(1.0, 1.0), **look)
    else:
        note = "known with the scene: give a run or a log"
        axes.annotate(note, (0.5, 0.45), xycoords="axes fraction", ha="center", color=STYLE["soft"])
    widest = max(1.25 * np.abs(degrees[in_contact]).max(initial=0.0), 1.0)
    angles.set_ylim(-widest, widest)
    angles.set_ylabel("angle [°]")
    angles.set_xlabel("ball      (angle: of the load against the radial plane)")


def _title(history, scene):
    balls = len(history.last["normal_load"])
    speed = float(history.last["inner_ring_speed"]) * 30.0 / np.pi
    name = scene.name if scene else "Bearing"
    return f"{name}: {balls} ball{'s' * (balls != 1)}, inner ring at {speed:.5g} rpm"


def _footer(facts, history):
    words = [
        f"scene {facts.scene.name}" if facts.scene else "",
        f"law {facts.law}" if facts.law else "",
        f"stepper {facts.stepper}" if facts.stepper else "",
        f"{history.outputs} output{'s' * (history.outputs != 1)} up to {history.last.time_ns * 1e-9:.6g} s",
        f"bearing_twin {__version__}",
    ]
    return "   ·   ".join(word for word in words if word)


def _draw_bearing(axis, sample: Sample, scene) -> None:
    """Draw rings, balls and loads; arrows point the way the raceway pushes the ball, their length is the load."""
    position, load = sample["position"][:, :2], sample["normal_load"]
    radius = np.linalg.norm(sample["point"] - sample["position"][:, None, :], axis=-1).max()
    pitch = np.linalg.norm(position, axis=1).mean()
    inner, outer = pitch - radius, pitch + radius
    axis.set_aspect("equal")
    axis.set_axis_off()
    reach = outer + (ARROW + 0.3) * radius
    axis.set_xlim(-1.3 * reach, 1.3 * reach)  # so that artists need not tell how far they reach, which takes long
    axis.set_ylim(-reach, reach)
    for outside, width in ((inner, RING), (outer + RING * radius, RING)):
        axis.add_artist(Annulus((0, 0), outside, width * radius, fc=STYLE["ring"], ec=STYLE["edge"], lw=1.0, zorder=1))

    greatest = load.max() or 1.0
    for ball, centre in enumerate(position):
        colour = _ball_colour(ball, len(position), load[ball].max() / greatest)
        loose = load[ball].max() <= 0.0
        look = {"fc": "white", "ec": colour, "ls": (0, (3, 2))} if loose else {"fc": colour, "ec": "white"}
        axis.add_artist(Circle(centre, radius, lw=1.6, zorder=3, **look))
        if len(position) <= GREATEST_NUMBERED:
            size = np.clip(0.9 * radius / reach * 260, 6, 15)
            ink = colour if loose else readable_on(colour)
            axis.text(*centre, f"{ball}", ha="center", va="center", fontsize=size, color=ink, weight="bold", zorder=4)
        for raceway in (0, 1):
            _arrow(axis, centre, radius, load[ball, raceway] / greatest, raceway, pitch)
    _words(axis, sample, scene, greatest, reach)


def _arrow(axis, centre, radius, share, raceway, pitch):
    """From beyond the ring to the contact; its length is `share` of the longest."""
    if share <= 0.0:
        return
    outward = centre / np.linalg.norm(centre)
    side = -1.0 if raceway == 0 else 1.0
    room = min(ARROW * radius, 0.8 * (pitch - radius)) if raceway == 0 else ARROW * radius
    tip = centre + side * radius * outward
    tail = tip + side * share * room * outward
    axis.add_artist(
        FancyArrowPatch(
            tail,
            tip,
            arrowstyle="simple,head_length=6,head_width=8,tail_width=3",
            shrinkA=0,
            shrinkB=0,
            fc=RACEWAY_COLOURS[raceway],
            ec="white",
            lw=0.6,
            zorder=5,
        )
    )


def _words(axis, sample, scene, greatest, reach):
    ink, left = {"fontsize": 11, "color": STYLE["ink"]}, -1.3 * reach
    heading(axis, f"The bearing at {sample.time_ns * 1e-9:.6g} s: load on each ball")
    axis.text(left, 0.99 * reach, f"longest arrow {greatest:.4g} N", va="top", **ink)
    for row, (word, colour) in enumerate(zip(("inner ring", "outer ring"), RACEWAY_COLOURS, strict=True)):
        high = (0.88 - 0.1 * row) * reach  # above the tail of an arrow half-way up
        axis.text(left, high, f"➤ by the {word}", va="top", fontsize=11, color=colour, weight="bold")
    loose = (sample["normal_load"] <= 0.0).sum(axis=0)
    words = [f"{count} off the {ring} ring" for count, ring in zip(loose, ("inner", "outer"), strict=True) if count]
    axis.text(-left, 0.99 * reach, "\n".join(words), ha="right", va="top", linespacing=1.5, **ink)
    axes_mark(axis, left, reach)
    gravity = np.asarray(scene.parameters.gravity if scene else (0.0, 0.0, 0.0))[:2]
    if np.linalg.norm(gravity) > 0.0:
        start = np.array([1.12 * reach, -0.62 * reach])
        end = start + 0.22 * reach * gravity / np.linalg.norm(gravity)
        axis.add_artist(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=14, color=STYLE["ink"], lw=1.6))
        look = {"ha": "left", "va": "center", "style": "italic", "fontsize": 13, "color": STYLE["ink"]}
        axis.text(start[0] + 0.05 * reach, start[1], "g", **look)


def _ball_colour(ball, balls, share):
    if balls <= GREATEST_LINES:
        return BALL_COLOURS[ball % len(BALL_COLOURS)]
    return matplotlib.colors.to_hex(matplotlib.colormaps[LOAD_MAP](share))
