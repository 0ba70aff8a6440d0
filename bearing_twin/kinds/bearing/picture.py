"""Pictures of a bearing: loads over a run and the bearing at its end, an equilibrium, and curves over a sweep."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Annulus, Circle, FancyArrowPatch

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Sample
from bearing_twin.base.units import rounded_to_error
from bearing_twin.kinds.bearing.display import view
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.kinds.bearing.rings import TORQUE
from bearing_twin.kinds.picture import RunPicture
from bearing_twin.kinds.views import CurvePanel
from bearing_twin.pictures import (
    GREATEST_LINES,
    RACEWAY_COLOURS,
    RACEWAYS,
    STYLE,
    Axis,
    Line,
    Panel,
    Sheet,
    ball_style,
    contrast_colour,
    draw_load_distribution,
    figure_of,
    finish_picture,
    heading,
    in_rows,
    line_style,
    save,
    style_axes,
)

GREATEST_TURNS = 8  # of the balls: more waves become a solid block
BALL_PANELS = {  # over the azimuth: title, axis, factor into its unit
    "contact_angle": ("Contact angle of each ball", "angle [°]", np.degrees(1.0)),
    "peak_pressure": ("Greatest Hertz pressure of each ball", "pressure [MPa]", 1e-6),
}
OFFSET = "inner_ring_offset"
GREATEST_NUMBERED = 40  # balls: more are too small for a number
RING, ARROW = 0.55, 2.0  # thickness of a drawn ring, length of the longest arrow of a load, in ball radii


class BearingPicture(RunPicture):
    """Loads and free coordinates over time; the bearing with angles and pressures at the last output."""

    view, named = staticmethod(view), ("normal_load",)

    def __init__(self, scene, choice: Choice):
        super().__init__(scene, choice)
        turned = self.parameters.drive.kind == TORQUE
        self.kept = ("normal_load", OFFSET, "cage_offset", *(("inner_ring_speed",) if turned else ()))

    def _kept_of(self, sample: Sample) -> dict[str, np.ndarray]:
        """The channels of a sample, the ring's offset against the start: under load it hardly moves."""
        channels = super()._kept_of(sample)
        if OFFSET in channels:
            channels[OFFSET] = channels[OFFSET] - self.first[OFFSET]
        return channels

    def _panels(self, values) -> list[CurvePanel]:
        panels = super()._panels(values)
        return [
            panel._replace(title=f"{panel.title} since the start") if panel.lines[0].series == OFFSET else panel
            for panel in panels
        ]

    def begin(self, time) -> float:
        """The time [s] from which on the balls orbit GREATEST_TURNS times."""
        turns = abs(float(self.last["orbit_angle"][0] - self.first["orbit_angle"][0])) / (2.0 * np.pi)
        return time[-1] - (time[-1] - time[0]) * min(1.0, GREATEST_TURNS / max(turns, 1.0))

    def title(self) -> str:
        """Balls and speed."""
        balls, speed = len(self.last["normal_load"]), float(self.last["inner_ring_speed"]) * 30.0 / np.pi
        return f"{self.scene.name}: {balls} ball{'s' * (balls != 1)}, inner ring at {speed:.5g} rpm"

    def draw_bodies(self, figure, place, values) -> None:
        """The bearing, contact angles and pressures at the last output."""
        last = self.last
        columns = {name: last[name] for name in ("normal_load", "contact_angle")}
        columns["peak_pressure"] = contact_details(self.parameters, last)["peak_pressure"]
        _draw_balls(figure, place, last["orbit_angle"], columns, lambda cell: _draw_bearing(figure, cell, last))


def _draw_bearing(figure, cell, sample: Sample) -> None:
    """Rings, balls and their loads: arrows along the forces of raceways on balls, as long as the load."""
    position, load = sample["position"][:, :2], sample["normal_load"]
    radius = np.linalg.norm(sample["point"] - sample["position"][:, None, :], axis=-1).max()
    pitch, greatest = np.linalg.norm(position, axis=1).mean(), load.max() or 1.0
    reach = pitch + (ARROW + 1.3) * radius
    axis = figure.add_subplot(cell, aspect="equal", xlim=(-1.3 * reach, 1.3 * reach), ylim=(-reach, reach))
    axis.set_axis_off()
    for outside in (pitch - radius, pitch + (1.0 + RING) * radius):
        axis.add_artist(Annulus((0, 0), outside, RING * radius, fc=STYLE["ring"], ec=STYLE["edge"], zorder=1))
    lengths = min(ARROW * radius, 0.8 * (pitch - radius)), ARROW * radius
    for ball, centre in enumerate(position):
        colour = ball_style(ball)["color"] if len(position) <= GREATEST_LINES else STYLE["soft"]
        loose = load[ball].max() <= 0.0
        fill = {"fc": "white", "ec": colour, "ls": "--"} if loose else {"fc": colour, "ec": "white"}
        axis.add_artist(Circle(centre, radius, lw=1.6, zorder=3, **fill))
        if len(position) <= GREATEST_NUMBERED:
            size = min((234.0 if len(position) <= 10 else 150.0) * radius / reach, 15.0)
            ink = colour if loose else contrast_colour(colour)
            axis.text(*centre, f"{ball}", ha="center", va="center", fontsize=size, color=ink, weight="bold", zorder=4)
        outward = centre / np.linalg.norm(centre)
        for raceway, (side, longest, shade) in enumerate(zip((-1.0, 1.0), lengths, RACEWAY_COLOURS, strict=True)):
            if load[ball, raceway] > 0.0:
                tip = centre + side * radius * outward
                tail = tip + side * longest * load[ball, raceway] / greatest * outward
                style = {"arrowstyle": "simple,head_length=6,head_width=8,tail_width=3", "fc": shade, "ec": "white"}
                axis.add_artist(FancyArrowPatch(tail, tip, shrinkA=0, shrinkB=0, lw=0.6, zorder=5, **style))
    most = rounded_to_error(greatest, None, 4)
    heading(axis, f"The bearing at {sample.time_ns * 1e-9:.6g} s: load on each ball, up to {most} N")
    for name, colour, side in zip(RACEWAYS, RACEWAY_COLOURS, ("left", "right"), strict=True):
        style = {"transform": axis.transAxes, "va": "top", "fontsize": 11, "color": colour, "weight": "bold"}
        axis.text(float(side == "right"), 0.97, f"➤ by the {name} ring", ha=side, **style)
    corner = np.array([-1.22, -0.9]) * reach
    for direction, name in (((0.2, 0.0), "x"), ((0.0, 0.2), "y")):
        end = corner + reach * np.array(direction)
        axis.add_artist(FancyArrowPatch(corner, end, arrowstyle="-|>", mutation_scale=11, color=STYLE["soft"], lw=1.2))
        axis.text(*(corner + 1.3 * (end - corner)), name, ha="center", va="center", fontsize=11, color=STYLE["soft"])


def _draw_balls(figure, grid, azimuth, values: dict, draw_first: Callable) -> None:
    """Draw as `draw_first`, below it `values` (N, 2) of BALL_PANELS over the azimuth (N,) [rad] of the balls."""
    cells = grid.subgridspec(
        len(values), 1, height_ratios=(len(values) - 0.6, *(0.7,) * (len(values) - 1)), hspace=0.42
    )
    loads = values["normal_load"]
    draw_first(cells[0])
    degrees = (np.degrees(azimuth) + 180.0) % 360.0 - 180.0
    for row, (name, (title, label, factor)) in enumerate(BALL_PANELS.items(), 1):
        axis = figure.add_subplot(cells[row])
        style_axes(axis)
        for k, (colour, marker, shift) in enumerate(zip(RACEWAY_COLOURS, "os", (-3.0, 3.0), strict=True)):
            shown = np.where(loads[:, k] > 0.0, factor * values[name][:, k], np.nan)
            axis.plot(degrees + shift, shown, marker, ms=7, color=colour)
        axis.set_xlim(-190.0, 190.0)
        axis.set_xticks(np.arange(-180, 181, 45))
        low, high = axis.get_ylim()
        axis.set_ylim((0.0, 1.08 * high) if name == "peak_pressure" else (min(1.15 * low, -1.0), max(1.15 * high, 1.0)))
        heading(axis, title, "azimuth of the ball, from +x [°]" if row + 1 == len(values) else None, label)


def draw_equilibrium(result: dict, path) -> Path:
    """Draw the loads around the bearing, angles and pressures of the balls; `result` as of `answer_of`."""
    figure = Figure(figsize=(10.0, 12.0), dpi=100, facecolor="white")
    units = {"normal_load": "n", "contact_angle": "rad", "peak_pressure": "pa"}
    values = {name: np.array([result[f"{name}_{race}_{unit}"] for race in RACEWAYS]).T for name, unit in units.items()}
    (grid,) = figure.add_gridspec(1, 1, left=0.1, right=0.96, top=0.87, bottom=0.08)
    azimuth, push = np.array(result["ball_azimuth_rad"]), -np.array(result["ring_force_n"][:2])

    def draw_loads(cell):
        axis = figure.add_subplot(cell, projection="polar")
        draw_load_distribution(axis, azimuth, values["normal_load"], push)
        heading(axis, "Load on each ball [N]; 0° is +x, 90° is +y", pad=24)
        axis.legend(frameon=False, fontsize=11, loc="lower left", bbox_to_anchor=(-0.32, -0.1))

    _draw_balls(figure, grid, azimuth, values, draw_loads)
    moved = ", ".join(rounded_to_error(round(1e6 * value, 6), None, 4) for value in result["ring_displacement_m"])
    load = ", ".join(rounded_to_error(-round(value, 6), None, 4) for value in result["ring_force_n"])
    title = f"{result['scene']}: load ({load}) N at {result['speed_rad_s'] * 30.0 / np.pi:.5g} rpm"
    clearance = f"clearance {1e6 * result['clearance_m']['operating']:.4g} µm"
    footer = f"inner ring moved by ({moved}) µm; law {result['law']}; {clearance}"
    return finish_picture(figure, title, footer, path, size=15)


SWEPT = {  # panels of a sweep: title, axis, labels of its curves
    "ring_displacement_m": ("Displacement of the inner ring", Axis("displacement", "m"), "xyz"),
    "stiffness": ("Stiffness against a small further load", Axis("stiffness", shown=("N/µm", 1e-6)), "xyz"),
    "greatest_normal_load_inner_n": ("Greatest load of a ball on the inner raceway", Axis("load", "N"), ""),
    "reference_life_mrev": ("Reference life L10r (ISO/TS 16281)", Axis("life [10⁶ turns]"), ""),
}


def draw_sweep(result: dict, path) -> Path:
    """Draw displacement, stiffness, greatest ball load and reference life over the swept number."""
    scale, label = result["axis"]["scale"], result["axis"]["label"]
    values, refused = scale * np.asarray(result["values"]), len(result["refused"])
    solved = [k for k, stiffness in enumerate(result["stiffness"]) if stiffness is not None]
    panels = []
    for key, (title, up, names) in SWEPT.items():
        rows = np.array([result[key][k] for k in solved], float)
        rows = np.diagonal(rows, axis1=1, axis2=2) if key == "stiffness" else rows.reshape(len(solved), -1)
        curves = np.full((len(values), rows.shape[1]), np.nan)  # broken where there is no equilibrium
        curves[solved] = rows
        lines = [Line(name, values, curves[:, k], line_style(k), bool(name)) for k, name in enumerate(names or [""])]
        is_log = key == "reference_life_mrev" and np.nanmax(rows, initial=0.0) > 20.0 * np.nanmin(rows, initial=np.inf)
        panels.append(Panel(title, Axis(label), up._replace(log=bool(is_log)), lines))
    note = f"{refused} of {len(values)} values have no equilibrium" if refused else ""
    footer = "; ".join(filter(None, (result["held"], f"law {result['law']}", note)))
    return save(figure_of(Sheet(f"{result['scene']}: equilibria over {label}", in_rows(panels, 2), footer, [])), path)
