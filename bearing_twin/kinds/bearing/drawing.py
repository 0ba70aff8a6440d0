"""The bearing seen along its axis at one sample: rings, balls, and an arrow of the load at every contact."""

import matplotlib
import numpy as np
from matplotlib.patches import Annulus, Circle, FancyArrowPatch

from bearing_twin.pictures.style import BALL_COLOURS, GREATEST_LINES, LOAD_MAP, RACEWAY_COLOURS, STYLE, heading
from bearing_twin.sample import Sample

GREATEST_NUMBERED = 40
RING = 0.55  # radial thickness of a drawn ring, in ball radii
ARROW = 2.0  # length of the longest load arrow, in ball radii


def draw_bearing(axis, sample: Sample, scene=None) -> None:
    """Draw rings, balls and loads; arrows point the way the raceway pushes the ball, their length is the load."""
    position, load = sample["position"][:, :2], sample["normal_load"]
    radius = np.linalg.norm(sample["point"] - sample["position"][:, None, :], axis=-1).max()
    pitch = np.linalg.norm(position, axis=1).mean()
    inner, outer = pitch - radius, pitch + radius
    axis.set_aspect("equal")
    axis.set_axis_off()
    reach = outer + (ARROW + 0.3) * radius
    axis.set_xlim(-1.3 * reach, 1.3 * reach)
    axis.set_ylim(-reach, reach)
    for outside, width in ((inner, RING), (outer + RING * radius, RING)):
        axis.add_patch(Annulus((0, 0), outside, width * radius, fc=STYLE["ring"], ec=STYLE["edge"], lw=1.0, zorder=1))

    greatest = load.max() or 1.0
    for ball, centre in enumerate(position):
        colour = _ball_colour(ball, len(position), load[ball].max() / greatest)
        loose = load[ball].max() <= 0.0
        look = {"fc": "white", "ec": colour, "ls": (0, (3, 2))} if loose else {"fc": colour, "ec": "white"}
        axis.add_patch(Circle(centre, radius, lw=1.6, zorder=3, **look))
        if len(position) <= GREATEST_NUMBERED:
            size = np.clip(0.9 * radius / reach * 260, 6, 15)
            ink = colour if loose else _readable_on(colour)
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
    axis.add_patch(
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
    ink = {"fontsize": 11, "color": STYLE["ink"]}
    left = -1.3 * reach
    heading(axis, f"The bearing at {sample.time_ns * 1e-9:.6g} s: load on each ball")
    axis.text(left, 0.93 * reach, f"longest arrow {greatest:.4g} N", **ink)
    for row, (word, colour) in enumerate(zip(("inner ring", "outer ring"), RACEWAY_COLOURS, strict=True)):
        axis.text(left, (0.82 - 0.11 * row) * reach, f"➤ by the {word}", fontsize=11, color=colour, weight="bold")
    loose = (sample["normal_load"] <= 0.0).sum(axis=0)
    words = [f"{count} off the {ring} ring" for count, ring in zip(loose, ("inner", "outer"), strict=True) if count]
    axis.text(-left, 0.97 * reach, "\n".join(words), ha="right", va="top", linespacing=1.5, **ink)
    _axes_mark(axis, left, reach)
    gravity = np.asarray(scene.parameters.gravity if scene else (0.0, 0.0, 0.0))[:2]
    if np.linalg.norm(gravity) > 0.0:
        start = np.array([1.12 * reach, -0.62 * reach])
        end = start + 0.22 * reach * gravity / np.linalg.norm(gravity)
        axis.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=14, color=STYLE["ink"], lw=1.6))
        axis.text(
            start[0] + 0.05 * reach,
            start[1],
            "g",
            ha="left",
            va="center",
            style="italic",
            fontsize=13,
            color=STYLE["ink"],
        )


def _axes_mark(axis, left, reach):
    origin = np.array([left + 0.08 * reach, -0.9 * reach])
    for direction, name in (((1.0, 0.0), "x"), ((0.0, 1.0), "y")):
        end = origin + 0.2 * reach * np.array(direction)
        axis.add_patch(FancyArrowPatch(origin, end, arrowstyle="-|>", mutation_scale=11, color=STYLE["soft"], lw=1.2))
        axis.text(
            *(origin + 0.26 * reach * np.array(direction)),
            name,
            ha="center",
            va="center",
            fontsize=11,
            color=STYLE["soft"],
        )


def _ball_colour(ball, balls, share):
    if balls <= GREATEST_LINES:
        return BALL_COLOURS[ball % len(BALL_COLOURS)]
    return matplotlib.colors.to_hex(matplotlib.colormaps[LOAD_MAP](share))


def _readable_on(colour):
    red, green, blue = matplotlib.colors.to_rgb(colour)
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.6 else STYLE["ink"]
