"""Picture of a shaft: curves, loads of all balls, orbits, natural frequencies over speed."""

import math

import numpy as np

from bearing_twin.kinds.picture import RunPicture
from bearing_twin.kinds.shaft.display import view
from bearing_twin.kinds.shaft.equilibrium import last_matrices, modes_at, modes_of
from bearing_twin.kinds.shaft.figures import approach_of, without_rounding
from bearing_twin.kinds.shaft.parameters import SIDES
from bearing_twin.pictures import (
    BALL_COLOURS,
    STYLE,
    draw_load_distribution,
    heading,
    legend_above,
    readable_scale,
    style_axes,
)

HEADROOM = 1.8  # times the greatest frequency: the legend is above the curves
SPEEDS, BEYOND = 121, 1.25  # of the panel of natural frequencies: number of speeds, last one over the greatest shown
LEAST = 0.5  # of the first mode's frequency: least speed at the panel's end
FORWARD, BACKWARD = 0.55, 0.45  # limits of the shares of forward and backward whirl


class ShaftPicture(RunPicture):
    """The picture of one run of a shaft."""

    view = staticmethod(view)

    def draw_bodies(self, figure, cell, values) -> None:
        """Loads of all balls at the end, orbits of both rings, natural frequencies over speed."""
        grid = cell.subgridspec(1, 4, wspace=0.3)
        for k, side in enumerate(SIDES):
            _draw_loads(figure.add_subplot(grid[k], projection="polar"), values, side, k)
        _draw_orbits(figure.add_subplot(grid[2]), values)
        _draw_frequencies(figure.add_subplot(grid[3]), self.parameters, self.choice.law)


def _draw_loads(axis, values, side, k):
    """Loads on both raceways of each ball at the last output; the arrow is the shaft's push on the bearing."""
    load, first = values[f"{side}_normal_load"][-1], values["orbit_angle"][-1, k]
    azimuth = first + 2.0 * np.pi * np.arange(len(load)) / len(load)
    push = -values["bearing_force"][-1, k]
    size = float(np.hypot(push[0], push[1]))
    draw_load_distribution(axis, azimuth, load, push[:2])
    title = f"{side.capitalize()}: ball loads at the end [N]"
    heading(axis, title, pad=26)
    axis.text(
        -0.12, -0.17, f"radial load {size:.4g} N, axial load {push[2]:.4g} N", transform=axis.transAxes, fontsize=10.5,
        color=STYLE["ink"],
    )  # fmt: skip
    if k == 0:
        axis.legend(frameon=False, fontsize=10, loc="upper left", bbox_to_anchor=(0.92, 0.06))


def _draw_orbits(axis, values):
    """The orbits of the rings' centres in the second half of the run, about their means."""
    style_axes(axis)
    offset = values["ring_offset"][len(values["time"]) // 2 :, :, :2]
    load = max(values[f"{side}_normal_load"][-1].max() for side in SIDES)
    offset = np.array(without_rounding(offset - offset.mean(axis=0), approach_of(values["elastic_energy"][-1], load)))
    factor, unit = readable_scale(offset, "m")
    for k, side in enumerate(SIDES):
        axis.plot(*(factor * offset[:, k]).T, color=BALL_COLOURS[k], linewidth=1.4, label=f"{side} bearing")
    axis.set_aspect("equal", adjustable="datalim")
    heading(axis, "Orbits of both rings about their means", f"x [{unit}]", f"y [{unit}]")
    legend_above(axis)


def _draw_frequencies(axis, parameters, law):
    """Natural frequencies over speed, with the stiffness at the run's end, and the line of the shaft's speed."""
    style_axes(axis)
    modes, critical = modes_of(parameters, law)
    matrices, end_speed = last_matrices(parameters, law)
    ends = [abs(end_speed), LEAST * 2.0 * math.pi * modes.frequencies[0], *critical[:1]]
    speeds = np.linspace(0.0, BEYOND * max(ends), SPEEDS)
    rows = [modes_at(matrices, speed) for speed in speeds]
    rpm = speeds * 30.0 / math.pi
    for k in range(min(len(row.frequencies) for row in rows)):
        shares = np.array([row.forward[k] for row in rows])
        curve = np.array([row.frequencies[k] for row in rows])
        for colour, (label, is_shown) in zip(BALL_COLOURS, _directions(shares), strict=False):
            axis.plot(rpm, np.where(is_shown, curve, np.nan), lw=2.0, color=colour, label=label)
    axis.plot(rpm, speeds / (2.0 * math.pi), "--", lw=1.5, color=STYLE["ink"], label="once per turn")
    axis.axvline(abs(end_speed) * 30.0 / math.pi, color=STYLE["soft"], lw=1.2, label="speed at the end")
    shown = np.array([speed for speed in critical if speed <= speeds[-1]])
    axis.plot(shown * 30.0 / math.pi, shown / (2.0 * math.pi), "o", ms=8, color=BALL_COLOURS[5])
    axis.margins(x=0.0)
    axis.locator_params(axis="x", nbins=6)
    axis.tick_params(pad=6)
    axis.set_ylim(0.0, HEADROOM * max(row.frequencies[-1] for row in (rows[0], rows[-1])))
    handles = dict(zip(*axis.get_legend_handles_labels()[::-1], strict=True))
    axis.legend(handles.values(), handles.keys(), frameon=False, fontsize=10, loc="upper left")
    heading(axis, "Natural and critical frequencies", "speed of the shaft [rpm]", "frequency [Hz]")


def _directions(shares):
    """Label, and at which of the speeds it holds, of the directions in which a mode whirls."""
    yield "forward", shares > FORWARD
    yield "backward", shares < BACKWARD
    yield "planar or axial", (shares >= BACKWARD) & (shares <= FORWARD)
