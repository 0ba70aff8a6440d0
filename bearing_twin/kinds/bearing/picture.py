"""Pictures of a bearing: loads over a run and its last output, an equilibrium, and curves over a sweep."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Annulus, Circle, FancyArrowPatch

from bearing_twin import __version__
from bearing_twin.base.sample import Block, Sample, Thinned
from bearing_twin.kinds.bearing.outputs import contact_details
from bearing_twin.kinds.bearing.rings import FREE_RING, TORQUE, dimension_of, moving_centre
from bearing_twin.kinds.contract import Facts
from bearing_twin.pictures.panels import axes_mark, draw_loads_around, finish, readable_on
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
    key_above,
    marker_of,
    scaled,
)

GREATEST_ROWS, GREATEST_COLUMNS = 100_000, 4096  # outputs kept, of longer runs one in 2, 4, ...; slices that are drawn
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
        time, values, scene, first, last = (
            self._kept.time,
            self._kept.values,
            self._facts.scene,
            self._first,
            self._last,
        )
        turns = abs(float(last["orbit_angle"][0] - first["orbit_angle"][0])) / (2.0 * np.pi)
        shown, part = slice(None), ""
        if turns > GREATEST_TURNS:
            begin = time[-1] - (time[-1] - time[0]) * GREATEST_TURNS / turns
            shown = slice(int(np.searchsorted(time, begin)), None)
            part = f", last {time[-1] - begin:.3g} s of {time[-1]:.4g} s"
        starts = np.arange(0, len(time[shown]), -(-len(time[shown]) // GREATEST_COLUMNS))
        at, spans = time[shown][starts], {}
        for name, one in values.items():
            spans[name] = [bound.reduceat(one[shown], starts) for bound in (np.minimum, np.maximum)]
        figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
        edges = {"left": 0.06, "right": 0.98, "top": 0.90, "bottom": 0.095}
        grid = figure.add_gridspec(1, 2, width_ratios=(1.25, 1.0), wspace=0.14, **edges)
        left = grid[0].subgridspec(2 + len(self._moved), 1, hspace=(0.16, 0.24, 0.34, 0.44)[len(self._moved)])
        right = grid[1].subgridspec(3, 1, height_ratios=(4.0, 0.95, 0.7), hspace=0.2)
        loads = [figure.add_subplot(left[row]) for row in (0, 1)]
        _draw_loads(figure, loads, at, *spans["normal_load"], self._greatest, part)
        above = loads[1]
        for row, moved in enumerate(self._moved):
            above.tick_params(labelbottom=False)
            above.set_xlabel("")
            above = figure.add_subplot(left[2 + row])
            _draw_moved(above, moved, at, *spans[moved], first)
        _draw_bearing(figure.add_subplot(right[0]), last, scene)
        _draw_contacts(figure.add_subplot(right[1]), figure.add_subplot(right[2]), last, scene)
        return finish(figure, _title(last, scene), _footer(self._facts, self._kept, last), path, errors=errors)


def _draw_loads(figure, axes, time, low, high, greatest, part):
    """Lowest and highest loads (slices, balls, 2) in slices of time, with the greatest (2,) of the whole run."""
    span = time[-1] - time[0]
    scale, unit = scaled(time[-1], "s")
    for raceway, axis in enumerate(axes):
        frame(axis)
        if low.shape[1] > GREATEST_LINES:
            image = _load_map(axis, time * scale, high[:, :, raceway], greatest.max() or 1.0)
            figure.colorbar(image, ax=axis, pad=0.015, label="normal load [N]")
            axis.set_ylabel("ball")
        else:
            _load_lines(axis, time * scale, low[:, :, raceway], high[:, :, raceway], greatest[raceway])
            axis.set_ylabel("normal load [N]")
        heading(axis, f"Normal load of each ball on the {RACEWAYS[raceway]} raceway{part}")
        axis.margins(x=0.0 if span else 0.05)
    axes[0].tick_params(labelbottom=False)
    axes[1].set_xlabel(f"time [{unit}]")


def _draw_moved(axis, name, time, low, high, first):
    """A ring's speed; or how far its centre is from where it started, or a cage's from the axis, along each axis."""
    low, high = (one.reshape(len(one), -1) for one in (low, high))
    words, up, factor = WORDS[name]
    start = np.ravel(first[name]) * (name == "inner_ring_offset")
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


def _load_lines(axis, time, low, high, greatest_of_run):
    for ball in range(low.shape[1]):
        # low and high of a slice one after the other: no peak is lost, and it is one line for the eye
        load = np.stack([low[:, ball], high[:, ball]], axis=1).ravel()
        axis.plot(np.repeat(time, 2), load, linewidth=1.6, marker=marker_of(len(time)), **ball_line(ball))
    least, greatest = low.min(), high.max()
    if greatest_of_run > 1.02 * greatest:
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
            look = {"ms": size, "mec": colour, "mew": 1.6, "mfc": fill, "label": label, "clip_on": False}
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


def _title(last, scene):
    balls = len(last["normal_load"])
    speed = float(last["inner_ring_speed"]) * 30.0 / np.pi
    name = scene.name if scene else "Bearing"
    return f"{name}: {balls} ball{'s' * (balls != 1)}, inner ring at {speed:.5g} rpm"


def _footer(facts, kept, last):
    words = [
        f"scene {facts.scene.name}" if facts.scene else "",
        f"law {facts.law}" if facts.law else "",
        f"stepper {facts.stepper}" if facts.stepper else "",
        f"{kept.outputs} output{'s' * (kept.outputs != 1)} up to {last.time_ns * 1e-9:.6g} s",
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


AXES = ("x", "y", "z")


def draw_equilibrium(result: dict, path) -> Path:
    """Draws the loads around the bearing, angles and pressures of the balls; `result` as of `answer_of`."""
    figure = Figure(figsize=(15.0, 8.2), dpi=100, facecolor="white")
    edges = {"left": 0.05, "right": 0.975, "top": 0.86, "bottom": 0.12}
    grid = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.05), wspace=0.12, **edges)
    right = grid[1].subgridspec(2, 1, hspace=0.28)
    left = grid[0].subgridspec(2, 1, height_ratios=(0.06, 1.0), hspace=0.0)
    _draw_equilibrium_loads(figure.add_subplot(left[1], projection="polar"), result)
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
    return finish(figure, _equilibrium_title(result), _equilibrium_footer(result), path, size=17)


def _draw_equilibrium_loads(axis, result):
    loads = np.array([result[f"normal_load_{race}_n"] for race in RACEWAYS]).T
    draw_loads_around(axis, np.asarray(result["ball_azimuth_rad"]), loads, -np.asarray(result["ring_force_n"][:2]))
    axis.set_title("Load on each ball [N]; 0° is +x, 90° is +y", loc="left", fontsize=13.5, color=STYLE["ink"], pad=24)
    axis.legend(frameon=False, fontsize=11, loc="lower left", bbox_to_anchor=(-0.08, -0.1))


def _equilibrium_title(result):
    shown = [f"{round(1e6 * value, 6) + 0.0:.4g}" for value in result["ring_displacement_m"]]
    load = ", ".join(f"{0.0 - round(value, 6):.4g}" for value in result["ring_force_n"])
    return f"{result['scene']}: load ({load}) N moves the inner ring by ({', '.join(shown)}) µm"


def _equilibrium_footer(result):
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
        ("Reference life L10r (ISO/TS 16281)", "life [10⁶ turns]"),
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
