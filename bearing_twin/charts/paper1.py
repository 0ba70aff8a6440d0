"""Paper 1's ball bearing: the bearing in space (figure 5), one ball by several elastic laws, and what the laws cost.

Followed are r_P, the contact point of ball 0 with the outer raceway, and n_A, the raceway's normal there, by exact
Hertz and by each other law; "their coordinates coincide with a very high accuracy" (section 5) becomes a number. The
paper prints no dimension, speed, damping or friction of its bearing: those of the scene stand for them.
"""

import math
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.start import bearing_of
from bearing_twin.numerics.rotation import rotation_matrix
from bearing_twin.pictures.moving import write_moving
from bearing_twin.pictures.style import BALL_COLOURS, SIZE, STYLE, frame, heading
from bearing_twin.pictures.worth import finish
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene

SCENE, DURATION, OUTPUTS = "bearing_6203", 0.1, 400
EXACT, LAWS = "hertz_exact", ("hertz", "hertz_differential", "volumetric", "constant")
BALL, OUTER = 0, 1
REPEATS = 3  # of a run, of which the quickest counts
GROOVE = math.radians(55.0)  # of a groove's meridian that is drawn, either way
OPEN = (math.radians(-200.0), math.radians(70.0))  # of the rings that is drawn round the axis
FRAMES = 24
SECTORS = 8  # of a ball that moves, in two colours by turns, so that one sees it roll
POLAR, ROUND = np.meshgrid(np.linspace(0.0, math.pi, 17), np.linspace(0.0, 2.0 * math.pi, 33))
SPHERE = np.array([np.sin(POLAR) * np.cos(ROUND), np.sin(POLAR) * np.sin(ROUND), np.cos(POLAR)])


@dataclass(frozen=True)
class LawRun:
    """One law: CPU ns a ball's rates, greatest distance from exact Hertz of r_P [m], n_A [rad] and load (relative)."""

    law: str
    ns_a_ball_rate: float
    greatest_point_off_m: float
    greatest_normal_off_rad: float
    greatest_load_off: float
    histories: tuple = field(default=(), repr=False)


POINT = LawRun


def _times() -> np.ndarray:
    return DURATION / OUTPUTS * np.arange(1, OUTPUTS + 1)


def _run(law: str):
    """The outputs by a law over DURATION, and the CPU nanoseconds a ball's rates took."""
    scene = load_scene(SCENE, [f"contact.normal={law}"])
    moving, least = BearingMotion(scene.parameters, choose(scene)), math.inf
    moving.advance(np.array([1e-4]), 1e-4)  # compiled or loaded before the clock starts
    for _ in range(REPEATS):
        moving.reset()
        began = time.process_time()
        out = moving.advance(_times(), DURATION)
        least = min(least, time.process_time() - began)
    return out, 1e9 * least / moving.costs()["ball_rates"]


def measure() -> list[LawRun]:
    """Every law against exact Hertz, which comes first."""
    runs, truth = [], None
    for law in (EXACT, *LAWS):
        out, nanoseconds = _run(law)
        point, normal, load = (np.array(one[:, BALL, OUTER]) for one in (out.point, out.normal, out.normal_load))
        truth = truth or (point, normal, load)
        runs.append(
            LawRun(
                law=law,
                ns_a_ball_rate=nanoseconds,
                greatest_point_off_m=float(np.linalg.norm(point - truth[0], axis=1).max()),
                greatest_normal_off_rad=float(np.linalg.norm(normal - truth[1], axis=1).max()),
                greatest_load_off=float(np.abs(load / truth[2] - 1.0).max()),
                histories=(point, normal),
            )
        )
    return runs


def reading(points) -> list[str]:
    """What the chart says."""
    runs = {one.law: one for one in points}
    volumetric, carried = (runs[name] for name in ("volumetric", "hertz_differential"))
    cost = {name: one.ns_a_ball_rate / runs[EXACT].ns_a_ball_rate for name, one in runs.items()}
    return [
        f"volumetric against exact Hertz over {DURATION:g} s: r_P within {volumetric.greatest_point_off_m:.2g} m, n_A "
        f"within {volumetric.greatest_normal_off_rad:.2g} rad, load within {100 * volumetric.greatest_load_off:.2g} %",
        f"hertz_differential, its integrals carried: r_P within {carried.greatest_point_off_m:.2g} m, load within "
        f"{carried.greatest_load_off:.2g}",
        f"cost of a ball's rates against exact Hertz ({runs[EXACT].ns_a_ball_rate:.0f} ns): hertz_differential "
        f"{cost['hertz_differential']:.2f}, volumetric {cost['volumetric']:.2f}, constant {cost['constant']:.2f} (the "
        f"paper: at most 0.5), hertz {cost['hertz']:.2f}",
    ]


def draw(points, path) -> Path:
    """The bearing in space, also moving in a .gif; r_P and n_A of a ball by exact Hertz, how far laws are off; cost."""
    figure = Figure(figsize=SIZE, dpi=100, facecolor="white")
    grid = figure.add_gridspec(3, 2, left=0.05, right=0.97, top=0.90, bottom=0.115, hspace=0.42, wspace=0.22)
    runs = {one.law: one for one in points}
    _draw_still(figure.add_subplot(grid[:2, 0], projection="3d"))
    times, (point, normal) = 1e3 * _times(), runs[EXACT].histories
    first, second, off, cost = (figure.add_subplot(grid[place]) for place in ((0, 1), (1, 1), (2, 1), (2, 0)))
    for axis, values, names in ((first, 1e3 * point, "r"), (second, normal, "n")):
        for column, letter in enumerate("xyz"):
            label = rf"${names}_{{{letter}}}$"
            axis.plot(times, values[:, column], color=BALL_COLOURS[column], linewidth=1.6, label=label)
        axis.legend(frameon=False, fontsize=12, ncol=3, loc="lower right", bbox_to_anchor=(1.0, 0.97), borderpad=0)
        axis.tick_params(labelbottom=False)
    heading(first, "Contact point of a ball with the outer ring", up="r_P [mm]")
    heading(second, "Normal of the raceway there", up="n_A")
    for number, law in enumerate(LAWS):
        away = np.linalg.norm(runs[law].histories[0] - point, axis=1)
        off.plot(times, np.maximum(away, 1e-18), color=BALL_COLOURS[number], linewidth=1.3, label=law)
    off.set_yscale("log")
    off.legend(frameon=False, fontsize=10, ncol=4, loc="center right", bbox_to_anchor=(1.0, 0.6))
    heading(off, "r_P by other laws, from that by exact Hertz", "time [ms]", "distance [m]")
    names = [one.law for one in points]
    cost.barh(range(len(names)), [one.ns_a_ball_rate for one in points], color=BALL_COLOURS[4])
    cost.set_yticks(range(len(names)), names)
    cost.invert_yaxis()
    heading(cost, "Cost of the laws in this run", "CPU time of one ball's rates [ns]")
    for axis in (first, second, off, cost):
        frame(axis)
        if axis is not cost:
            axis.margins(x=0.0)
    cost.grid(False, axis="y")
    box = cost.get_position()
    cost.set_position([box.x0 + 0.09, box.y0, box.width - 0.09, box.height])
    _draw_moving(Path(path).with_suffix(".gif"))
    return finish(figure, "The ball bearing of Kosenko and Aleksandrov, section 5", _footer(), path, size=17)


def _footer() -> str:
    parameters = load_scene(SCENE).parameters
    geometry, contact, drive = parameters.geometry, parameters.contact, parameters.drive
    return ", ".join(
        (
            f"{SCENE}: {geometry.balls} balls of {1e3 * geometry.ball_diameter:g} mm",
            f"pitch {1e3 * geometry.pitch_diameter:g} mm",
            f"conformities {geometry.inner_conformity:g} and {geometry.outer_conformity:g}",
            f"inner ring {drive.speed:g} rad/s",
            f"gravity {math.hypot(*parameters.gravity):g} m/s² along -y",
            f"friction {contact.friction_coefficient:g} (slip scale {contact.friction_regularisation:g} m/s)",
            f"relaxation {contact.relaxation_time:g} s",
        )
    )


def _draw_still(axis) -> None:
    """The bearing after DURATION into a 3-D axis."""
    bearing, out = _bearing_at(np.array([DURATION]))
    _draw_bearing(axis, bearing, out, 0)
    load, ring = out.normal_load[0, :, OUTER], "loads on the outer ring"
    heading(axis, f"After {DURATION:g} s, cut open; arrows: {ring}, {load.min():.3g} to {load.max():.3g} N")


def _draw_moving(path) -> Path:
    """A .gif of the bearing from DURATION on, while each ball moves to the place of the next one."""
    bearing, out = _bearing_at(np.array([DURATION, 1.001 * DURATION]))
    angles = np.unwrap(np.arctan2(out.position[:, 0, 1], out.position[:, 0, 0]))
    orbit = (angles[1] - angles[0]) / (0.001 * DURATION)
    period = 2.0 * math.pi / (bearing.balls * abs(orbit))
    times = DURATION + period * np.arange(FRAMES) / FRAMES
    bearing, out = _bearing_at(times)
    figure = Figure(figsize=(6.4, 4.6), dpi=72, facecolor="white")
    axis = figure.add_axes((0.0, 0.04, 1.0, 0.88), projection="3d")

    def draw(row):
        axis.clear()
        _draw_bearing(axis, bearing, out, row, striped=True)
        axis.set_box_aspect((1.0, 1.0, 0.35), zoom=1.1)
        heading(
            axis, f"{1e3 * (times[row] - DURATION):.2f} of {1e3 * period:.2f} ms: each ball to the next one's place"
        )

    return write_moving(figure, path, range(FRAMES), draw)


def _bearing_at(times):
    """The bearing, and its outputs at `times` [s]."""
    scene = load_scene(SCENE)
    choice = choose(scene)
    moving = BearingMotion(scene.parameters, choice)
    return bearing_of(scene.parameters, choice.law), moving.advance(times, times[-1])


def _draw_bearing(axis, bearing, out, row, striped=False):
    """Grooves cut open, balls that roll, the one that is followed in a colour of its own, loads on the outer ring."""
    for raceway, middle, colour in ((bearing.outer, 0.0, STYLE["edge"]), (bearing.inner, math.pi, BALL_COLOURS[4])):
        meridian, turn = np.meshgrid(np.linspace(-GROOVE, GROOVE, 9) + middle, np.linspace(*OPEN, 90))
        reach = 1e3 * (raceway.locus_radius + raceway.groove_radius * np.cos(meridian))
        height = 1e3 * raceway.groove_radius * np.sin(meridian)
        axis.plot_surface(reach * np.cos(turn), reach * np.sin(turn), height, color=colour, alpha=0.45, linewidth=0)
    for number, centre in enumerate(1e3 * out.position[row]):
        colour = BALL_COLOURS[1 if number == BALL else 0]
        turned = np.tensordot(rotation_matrix(out.orientation[row, number]), SPHERE, axes=1)
        x, y, z = 1e3 * bearing.ball_radius * turned + centre[:, None, None]
        look = {"facecolors": _stripes(colour), "rstride": 1, "cstride": 1} if striped else {"color": colour}
        axis.plot_surface(x, y, z, linewidth=0, **look)
        foot = 1e3 * out.point[row, number, OUTER]
        axis.quiver(*foot, *(-4.0 * out.normal[row, number, OUTER]), color=BALL_COLOURS[5], linewidth=1.6)
    axis.set_box_aspect((1.0, 1.0, 0.35), zoom=1.35)
    axis.set_xlim(-20.0, 20.0)
    axis.set_ylim(-20.0, 20.0)
    axis.set_zlim(-7.0, 7.0)
    axis.view_init(elev=38.0, azim=-60.0)
    axis.set_xlabel("x [mm]")
    axis.set_ylabel("y [mm]")
    axis.set_zticks([-5.0, 0.0, 5.0])
    axis.set_zlabel("z [mm]")


def _stripes(colour):
    """Colours of the faces of SPHERE, sectors round its own axis."""
    light = (np.floor(ROUND * SECTORS / (2.0 * math.pi)).astype(int) % 2).astype(bool)
    faces = np.full(light.shape, colour, dtype=object)
    faces[light] = "white"
    return faces
