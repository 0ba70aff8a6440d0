"""Pictures of bearings in balance: the load around the bearing, and curves over a sweep."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin import __version__
from bearing_twin.pictures.panels import draw_loads_around, finish
from bearing_twin.pictures.style import RACEWAY_COLOURS, RACEWAYS, STYLE, ball_line, frame, heading, key_above

AXES = ("x", "y", "z")


def draw_equilibrium(result: dict, path) -> Path:
    """Draws the loads around the bearing, angles and pressures of the balls; `result` as of `answer_of`."""
    figure = Figure(figsize=(15.0, 8.2), dpi=100, facecolor="white")
    edges = {"left": 0.05, "right": 0.975, "top": 0.86, "bottom": 0.12}
    grid = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.05), wspace=0.12, **edges)
    right = grid[1].subgridspec(2, 1, hspace=0.28)
    left = grid[0].subgridspec(2, 1, height_ratios=(0.06, 1.0), hspace=0.0)
    _draw_loads(figure.add_subplot(left[1], projection="polar"), result)
    angles, pressures = figure.add_subplot(right[0]), figure.add_subplot(right[1])
    azimuth = np.degrees(np.asarray(result["ball_azimuth_rad"]))
    azimuth = (azimuth + 180.0) % 360.0 - 180.0
    order = np.argsort(azimuth)
    rows = (
        (angles, "contact_angle", "rad", np.degrees(1.0), "contact angle [°]", "Contact angle of each ball"),
        (pressures, "peak_pressure", "pa", 1e-6, "peak pressure [MPa]", "Greatest Hertz pressure of each ball"),
    )
    for axis, name, unit, scale, label, words in rows:
        frame(axis)
        for race, colour, mark, aside in zip(RACEWAYS, RACEWAY_COLOURS, "os", (-3.0, 3.0), strict=True):
            loaded = np.asarray(result[f"normal_load_{race}_n"]) > 0.0
            values = np.where(loaded, scale * np.asarray(result[f"{name}_{race}_{unit}"]), np.nan)
            axis.plot(azimuth[order] + aside, values[order], mark, ms=8, color=colour, label=f"{race} raceway")
        axis.set_xlim(-190.0, 190.0)
        axis.set_xticks(np.arange(-180, 181, 45))
        heading(axis, words, up=label)
    low, high = pressures.get_ylim()
    pressures.set_ylim(0.0, 1.08 * high)
    low, high = angles.get_ylim()
    if high - low < 0.5:
        angles.set_ylim(-1.0, 1.0)
    angles.legend(frameon=False, fontsize=11, loc="best")
    pressures.set_xlabel("azimuth of the ball, from +x [°]")
    return finish(figure, _title(result), _footer(result), path, size=17)


def _draw_loads(axis, result):
    loads = np.array([result[f"normal_load_{race}_n"] for race in RACEWAYS]).T
    draw_loads_around(axis, np.asarray(result["ball_azimuth_rad"]), loads, -np.asarray(result["ring_force_n"][:2]))
    axis.set_title("Load on each ball [N]; 0° is +x, 90° is +y", loc="left", fontsize=13.5, color=STYLE["ink"], pad=24)
    axis.legend(frameon=False, fontsize=11, loc="lower left", bbox_to_anchor=(-0.08, -0.1))


def _title(result):
    shown = [f"{round(1e6 * value, 6) + 0.0:.4g}" for value in result["ring_displacement_m"]]
    load = ", ".join(f"{0.0 - round(value, 6):.4g}" for value in result["ring_force_n"])
    return f"{result['scene']}: load ({load}) N moves the inner ring by ({', '.join(shown)}) µm"


def _footer(result):
    words = (
        f"law {result['law']}",
        f"{result['speed_rad_s'] * 30.0 / np.pi:.5g} rpm",
        f"clearance {1e6 * result['clearance_m']['operating']:.4g} µm",
        f"bearing_twin {__version__}",
    )
    return "   ·   ".join(words)


def draw_sweep(result: dict, path) -> Path:
    """Draws displacement, stiffness, greatest ball load and reference life over the swept number."""
    figure = Figure(figsize=(15.0, 9.0), dpi=100, facecolor="white")
    grid = figure.add_gridspec(2, 2, left=0.07, right=0.975, top=0.87, bottom=0.11, wspace=0.2, hspace=0.34)
    scale, label = result["axis"]["scale"], result["axis"]["label"]
    values = scale * np.asarray(result["values"])
    curves = {
        key: np.array([_filled(one, key) for one in result[key]], dtype=float)
        for key in ("ring_displacement_m", "stiffness", "greatest_normal_load_inner_n", "reference_life_mrev")
    }
    panels = [figure.add_subplot(grid[k // 2, k % 2]) for k in range(4)]
    moved, stiff = 1e6 * curves["ring_displacement_m"], 1e-6 * curves["stiffness"]
    for i, name in enumerate(AXES):
        panels[0].plot(values, moved[:, i], lw=2.0, **ball_line(i), label=name)
        panels[1].plot(values, stiff[:, i, i], lw=2.0, **ball_line(i), label=f"along {name}")
    panels[2].plot(values, curves["greatest_normal_load_inner_n"], lw=2.0, color=RACEWAY_COLOURS[0])
    life = curves["reference_life_mrev"]
    panels[3].plot(values, life, lw=2.0, color=RACEWAY_COLOURS[1])
    if np.nanmax(life, initial=0.0) > 20.0 * np.nanmin(life, initial=np.inf):
        panels[3].set_yscale("log")
    words = (
        ("Displacement of the inner ring", "displacement [µm]"),
        ("Stiffness against a small further load", "stiffness [N/µm]"),
        ("Greatest load of a ball on the inner raceway", "load [N]"),
        ("Reference life (ISO/TS 16281), no promise", "life [10⁶ turns]"),
    )
    for panel, (head, unit) in zip(panels, words, strict=True):
        frame(panel)
        heading(panel, head, label, unit)
    for panel in panels[:2]:
        key_above(panel)
    return finish(figure, f"{result['scene']}: equilibria over {label}", _sweep_footer(result), path)


def _filled(one, key):
    if one is not None:
        return one
    return {"ring_displacement_m": [np.nan] * 3, "stiffness": [[np.nan] * 5] * 5}.get(key, np.nan)


def _sweep_footer(result):
    lost = (
        f"{len(result['refused'])} of {len(result['values'])} values have no equilibrium" if result["refused"] else ""
    )
    words = (f"law {result['law']}", lost, f"bearing_twin {__version__}")
    return "   ·   ".join(word for word in words if word)
