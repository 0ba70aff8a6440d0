"""Pictures of a bearing: loads over a run and the bearing at its end, an equilibrium, and curves over a sweep."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Annulus, Circle, FancyArrowPatch

from bearing_twin import __version__
from bearing_twin.base.sample import Block, Sample, Thinned
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.kinds.bearing.rings import FREE_RING, TORQUE, dimension_of, moving_centre
from bearing_twin.kinds.contract import Facts
from bearing_twin.pictures import (
    GREATEST_LINES,
    LOAD_MAP,
    RACEWAY_COLOURS,
    RACEWAYS,
    SIZE,
    STYLE,
    ball_line,
    draw_loads_around,
    finish,
    frame,
    heading,
    key_above,
    marker_of,
    readable_on,
    scaled,
)

GREATEST_ROWS, GREATEST_COLUMNS = 100_000, 4096  # outputs kept, of longer runs one in 2, 4, ...; slices that are drawn
FLAT = 0.6  # where the lowest load exceeds this part of the highest, the axis need not show zero
GREATEST_TURNS = 8  # of the balls round the bearing: more waves than this become a solid block
MOVED = {  # what moves by itself: title of its panel and axis, factor into its unit
    "inner_ring_offset": ("Inner ring's centre, from where it started", "displacement [µm]", 1e6),
    "cage_offset": ("Cage's centre, off the axis", "displacement [µm]", 1e6),
    "inner_ring_speed": ("Speed of the inner ring, turned by a torque", "speed [rpm]", 30.0 / np.pi),
}
OF_BALLS = {  # panels over the azimuth: title, axis, factor into its unit
    "contact_angle": ("Contact angle of each ball", "angle [°]", np.degrees(1.0)),
    "peak_pressure": ("Greatest Hertz pressure of each ball", "pressure [MPa]", 1e-6),
}


GREATEST_NUMBERED = 40  # balls: more are too small for a number
RING, ARROW = 0.55, 2.0  # thickness of a drawn ring, length of the longest arrow of a load, in ball radii


class BearingPicture:
    """Loads over time, and the bearing with angles and pressures at the last output; without a scene no pressures."""

    def __init__(self, facts: Facts):
        self._facts, self._first, self._last, self._greatest = facts, None, None, np.zeros(2)
        parameters = facts.scene.parameters if facts.scene else None
        moves = parameters and {
            "inner_ring_offset": dimension_of(parameters) == FREE_RING,
            "cage_offset": moving_centre(parameters),
            "inner_ring_speed": parameters.drive.kind == TORQUE,
        }
        self._moved = [name for name, one in (moves or {}).items() if one]
        names = ("normal_load", *self._moved)
        self._kept = Thinned(GREATEST_ROWS, lambda sample: {name: np.array(sample[name]) for name in names})

    def add(self, block: Block) -> None:
        """Takes a block in."""
        if len(block):
            self._first, self._last = self._first or block[0], block[-1]
            self._greatest = np.maximum(self._greatest, block.values["normal_load"].max(axis=(0, 1)))
            self._kept.add(block)

    def write(self, path, errors=()) -> Path:
        """Draws what was taken in; raises BearingTwinError where there is nothing or no place for it."""
        time, values, scene, last = self._kept.time, self._kept.values, self._facts.scene, self._last
        turns = abs(float(last["orbit_angle"][0] - self._first["orbit_angle"][0])) / (2.0 * np.pi)
        shown, part = slice(None), ""
        if turns > GREATEST_TURNS:
            begin = time[-1] - (time[-1] - time[0]) * GREATEST_TURNS / turns
            shown = slice(int(np.searchsorted(time, begin)), None)
            part = f", last {time[-1] - begin:.3g} s of {time[-1]:.4g} s"
        balls = values["normal_load"].shape[1]
        rows = [
            (f"Normal load of each ball on the {name} raceway{part}", "normal load [N]",
             values["normal_load"][shown, :, k], [], float(self._greatest[k]))
            for k, name in enumerate(RACEWAYS)
        ]  # fmt: skip
        for name in self._moved:
            words, up, factor = MOVED[name]
            begin = np.ravel(self._first[name]) * (name == "inner_ring_offset")
            curves = factor * (values[name][shown].reshape(len(time[shown]), -1) - begin)
            rows.append((words, up, curves, list("xyz"[: len(begin)]) if len(begin) > 1 else [], None))
        figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
        edges = {"left": 0.06, "right": 0.975, "top": 0.88, "bottom": 0.095}
        grid = figure.add_gridspec(1, 2, width_ratios=(1.25, 1.0), wspace=0.14, **edges)
        axes = grid[0].subgridspec(len(rows), 1, hspace=0.2 + 0.1 * len(rows)).subplots(squeeze=False)
        for k, (axis, row) in enumerate(zip(axes.ravel(), rows, strict=True)):
            _draw_over_time(axis, time[shown], *row)
            axis.tick_params(labelbottom=k + 1 == len(rows))
            axis.set_xlabel(axis.get_xlabel() if k + 1 == len(rows) else "")
            if k > 1:  # the balls have their colours and numbers in the drawing beside
                key_above(axis)
        found = {name: last[name] for name in ("normal_load", "contact_angle")}
        if scene:
            found["peak_pressure"] = contact_details(scene.parameters, last)["peak_pressure"]
        _draw_balls(figure, grid[1], last["orbit_angle"], found, lambda place: _draw_bearing(figure, place, last))
        speed = float(last["inner_ring_speed"]) * 30.0 / np.pi
        title = f"{scene.name if scene else 'Bearing'}: {balls} ball{'s' * (balls != 1)}, inner ring at {speed:.5g} rpm"
        facts, kept = self._facts, self._kept
        words = (
            f"law {facts.law}" if facts.law else "",
            f"stepper {facts.stepper}" if facts.stepper else "",
            f"{kept.outputs} output{'s' * (kept.outputs != 1)} up to {last.time_ns * 1e-9:.6g} s",
        )
        return finish(figure, title, _footer(*words), path, errors=errors)


def _footer(*words: str) -> str:
    return "   ·   ".join(word for word in (*words, f"bearing_twin {__version__}") if word)


def _draw_over_time(axis, time, words, up, values, names, greatest) -> None:
    """Curves of `values` (n, m) over time [s], of many balls as a map; `greatest` is that of a run of loads."""
    starts = np.arange(0, len(time), -(-len(time) // GREATEST_COLUMNS))
    low, high = (bound.reduceat(values, starts) for bound in (np.minimum, np.maximum))  # of slices: no peak is lost
    scale, unit = scaled(time[-1], "s")
    at = time[starts] * scale
    frame(axis)
    heading(axis, words, f"time [{unit}]", up)
    axis.margins(x=0.0 if time[-1] > time[0] else 0.05)
    if low.shape[1] > GREATEST_LINES:
        axis.grid(False)
        axis.set_ylabel("ball")
        at, high = (at, high) if len(at) > 1 else (np.append(at, at + 1.0), np.repeat(high, 2, axis=0))
        look = {"cmap": LOAD_MAP, "vmin": 0.0, "vmax": greatest or 1.0, "shading": "nearest", "rasterized": True}
        image = axis.pcolormesh(at, np.arange(high.shape[1]), high.T, **look)
        axis.figure.colorbar(image, ax=axis, pad=0.015, label=up)
        return
    for k in range(low.shape[1]):
        curve = np.stack([low[:, k], high[:, k]], axis=1).ravel()
        look = {"label": names[k]} if names else {}
        axis.plot(np.repeat(at, 2), curve, linewidth=1.6, marker=marker_of(len(at)), **ball_line(k), **look)
    axis.ticklabel_format(useOffset=False, style="plain")
    if greatest is None:
        return
    if greatest > 1.02 * high.max():
        axis.axhline(greatest, color=STYLE["soft"], linewidth=1.0, linestyle=":")
        note = {"xycoords": ("axes fraction", "data"), "ha": "right", "va": "bottom", "color": STYLE["soft"]}
        axis.annotate(f"greatest of the run {greatest:.4g} N", (0.995, greatest), **note)
    if low.min() <= FLAT * max(high.max(), greatest):
        axis.set_ylim(0.0, 1.06 * max(high.max(), greatest) or 1.0)


def _draw_bearing(figure, place, sample: Sample) -> None:
    """Rings, balls and their loads: arrows point the way a raceway pushes the ball, and are as long as the load."""
    position, load = sample["position"][:, :2], sample["normal_load"]
    radius = np.linalg.norm(sample["point"] - sample["position"][:, None, :], axis=-1).max()
    pitch, greatest = np.linalg.norm(position, axis=1).mean(), load.max() or 1.0
    reach = pitch + (ARROW + 1.3) * radius
    axis = figure.add_subplot(place, aspect="equal", xlim=(-1.3 * reach, 1.3 * reach), ylim=(-reach, reach))
    axis.set_axis_off()
    for outside in (pitch - radius, pitch + (1.0 + RING) * radius):
        axis.add_artist(Annulus((0, 0), outside, RING * radius, fc=STYLE["ring"], ec=STYLE["edge"], zorder=1))
    room = ARROW * radius, min(ARROW * radius, 0.8 * (pitch - radius))
    for ball, centre in enumerate(position):
        colour = ball_line(ball)["color"] if len(position) <= GREATEST_LINES else STYLE["soft"]
        loose = load[ball].max() <= 0.0
        look = {"fc": "white", "ec": colour, "ls": "--"} if loose else {"fc": colour, "ec": "white"}
        axis.add_artist(Circle(centre, radius, lw=1.6, zorder=3, **look))
        if len(position) <= GREATEST_NUMBERED:
            size = np.clip(234.0 * radius / reach, 6.0, 15.0)
            ink = colour if loose else readable_on(colour)
            axis.text(*centre, f"{ball}", ha="center", va="center", fontsize=size, color=ink, weight="bold", zorder=4)
        outward = centre / np.linalg.norm(centre)
        for raceway, (side, longest, fill) in enumerate(zip((-1.0, 1.0), room[::-1], RACEWAY_COLOURS, strict=True)):
            if load[ball, raceway] > 0.0:
                tip = centre + side * radius * outward
                tail = tip + side * longest * load[ball, raceway] / greatest * outward
                style = {"arrowstyle": "simple,head_length=6,head_width=8,tail_width=3", "fc": fill, "ec": "white"}
                axis.add_artist(FancyArrowPatch(tail, tip, shrinkA=0, shrinkB=0, lw=0.6, zorder=5, **style))
    heading(axis, f"The bearing at {sample.time_ns * 1e-9:.6g} s: load on each ball, up to {greatest:.4g} N")
    for row, (name, colour) in enumerate(zip(RACEWAYS, RACEWAY_COLOURS, strict=True)):
        words = {"transform": axis.transAxes, "va": "top", "fontsize": 11, "color": colour, "weight": "bold"}
        axis.text(0.0, 0.97 - 0.06 * row, f"➤ by the {name} ring", **words)
    corner = np.array([-1.22, -0.9]) * reach
    for way, name in (((0.2, 0.0), "x"), ((0.0, 0.2), "y")):
        end = corner + reach * np.array(way)
        axis.add_artist(FancyArrowPatch(corner, end, arrowstyle="-|>", mutation_scale=11, color=STYLE["soft"], lw=1.2))
        axis.text(*(corner + 1.3 * (end - corner)), name, ha="center", va="center", fontsize=11, color=STYLE["soft"])


def _draw_balls(figure, grid, azimuth, values: dict, draw_first: Callable) -> None:
    """Draws as `draw_first`, and further `values` (N, 2) of OF_BALLS over the azimuth (N,) [rad] of the balls."""
    parts = grid.subgridspec(
        len(values), 1, height_ratios=(len(values) - 0.6, *(0.7,) * (len(values) - 1)), hspace=0.42
    )
    loads = values["normal_load"]
    draw_first(parts[0])
    degrees = (np.degrees(azimuth) + 180.0) % 360.0 - 180.0
    for row, (name, (words, up, factor)) in enumerate(OF_BALLS.items(), 1):
        if name not in values:
            continue
        axis = figure.add_subplot(parts[row])
        frame(axis)
        for k, (colour, mark, aside) in enumerate(zip(RACEWAY_COLOURS, "os", (-3.0, 3.0), strict=True)):
            shown = np.where(loads[:, k] > 0.0, factor * values[name][:, k], np.nan)
            axis.plot(degrees + aside, shown, mark, ms=7, color=colour)
        axis.set_xlim(-190.0, 190.0)
        axis.set_xticks(np.arange(-180, 181, 45))
        low, high = axis.get_ylim()
        axis.set_ylim((0.0, 1.08 * high) if name == "peak_pressure" else (min(1.15 * low, -1.0), max(1.15 * high, 1.0)))
        heading(axis, words, "azimuth of the ball, from +x [°]" if row + 1 == len(values) else None, up)


def draw_equilibrium(result: dict, path) -> Path:
    """Draws the loads around the bearing, angles and pressures of the balls; `result` as of `answer_of`."""
    figure = Figure(figsize=(10.0, 12.0), dpi=100, facecolor="white")
    units = {"normal_load": "n", "contact_angle": "rad", "peak_pressure": "pa"}
    values = {name: np.array([result[f"{name}_{race}_{unit}"] for race in RACEWAYS]).T for name, unit in units.items()}
    (grid,) = figure.add_gridspec(1, 1, left=0.1, right=0.96, top=0.87, bottom=0.08)
    azimuth, push = np.array(result["ball_azimuth_rad"]), -np.array(result["ring_force_n"][:2])

    def draw_loads(place):
        around = figure.add_subplot(place, projection="polar")
        draw_loads_around(around, azimuth, values["normal_load"], push)
        heading(around, "Load on each ball [N]; 0° is +x, 90° is +y", pad=24)
        around.legend(frameon=False, fontsize=11, loc="lower left", bbox_to_anchor=(-0.32, -0.1))

    _draw_balls(figure, grid, azimuth, values, draw_loads)
    moved = ", ".join(f"{round(1e6 * value, 6) + 0.0:.4g}" for value in result["ring_displacement_m"])
    load = ", ".join(f"{0.0 - round(value, 6):.4g}" for value in result["ring_force_n"])
    title = f"{result['scene']}: load ({load}) N at {result['speed_rad_s'] * 30.0 / np.pi:.5g} rpm"
    words = (
        f"inner ring moved by ({moved}) µm",
        f"law {result['law']}",
        f"clearance {1e6 * result['clearance_m']['operating']:.4g} µm",
    )
    return finish(figure, title, _footer(*words), path, size=15)


SWEPT = {  # panels of a sweep: title, axis, factor into its unit, labels of its curves
    "ring_displacement_m": ("Displacement of the inner ring", "displacement [µm]", 1e6, "xyz"),
    "stiffness": ("Stiffness against a small further load", "stiffness [N/µm]", 1e-6, "xyz"),
    "greatest_normal_load_inner_n": ("Greatest load of a ball on the inner raceway", "load [N]", 1.0, ""),
    "reference_life_mrev": ("Reference life L10r (ISO/TS 16281)", "life [10⁶ turns]", 1.0, ""),
}


def draw_sweep(result: dict, path) -> Path:
    """Draws displacement, stiffness, greatest ball load and reference life over the swept number."""
    figure = Figure(figsize=(15.0, 9.0), dpi=100, facecolor="white")
    edges = {"left": 0.07, "right": 0.975, "top": 0.87, "bottom": 0.11}
    axes = figure.subplots(2, 2, gridspec_kw={"wspace": 0.2, "hspace": 0.34, **edges})
    scale, label = result["axis"]["scale"], result["axis"]["label"]
    values, refused = scale * np.asarray(result["values"]), len(result["refused"])
    solved = [k for k, one in enumerate(result["stiffness"]) if one is not None]
    for axis, (key, (words, up, factor, names)) in zip(axes.ravel(), SWEPT.items(), strict=True):
        frame(axis)
        found = factor * np.array([result[key][k] for k in solved], float)
        found = np.diagonal(found, axis1=1, axis2=2) if key == "stiffness" else found.reshape(len(solved), -1)
        curves = np.full((len(values), found.shape[1]), np.nan)  # broken where there is no equilibrium
        curves[solved] = found
        for k in range(max(len(names), 1)):
            axis.plot(values, curves[:, k], lw=2.0, **ball_line(k), **({"label": names[k]} if names else {}))
        if key == "reference_life_mrev" and np.nanmax(found, initial=0.0) > 20.0 * np.nanmin(found, initial=np.inf):
            axis.set_yscale("log")
        heading(axis, words, label, up)
        key_above(axis)
    lost = f"{refused} of {len(values)} values have no equilibrium" if refused else ""
    title = f"{result['scene']}: equilibria over {label}"
    return finish(figure, title, _footer(f"law {result['law']}", lost), path)
