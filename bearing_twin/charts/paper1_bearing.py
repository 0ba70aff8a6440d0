"""Paper 1's ball bearing in space (figure 5): grooves cut open, balls that roll, loads on the outer ring."""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.start import bearing_of
from bearing_twin.numerics.rotation import rotation_matrix
from bearing_twin.pictures.moving import write_moving
from bearing_twin.pictures.style import BALL_COLOURS, STYLE, heading
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene

GROOVE = math.radians(55.0)  # of a groove's meridian that is drawn, either way
OPEN = (math.radians(-200.0), math.radians(70.0))  # of the rings that is drawn round the axis
FRAMES = 24
OUTER = 1
SECTORS = 8  # of a ball that moves, in two colours by turns, so that one sees it roll
POLAR, ROUND = np.meshgrid(np.linspace(0.0, math.pi, 17), np.linspace(0.0, 2.0 * math.pi, 33))
SPHERE = np.array([np.sin(POLAR) * np.cos(ROUND), np.sin(POLAR) * np.sin(ROUND), np.cos(POLAR)])


def draw_still(axis, scene_name: str, time: float, marked: int) -> None:
    """The bearing at `time` [s] into a 3-D axis; ball `marked` has a colour of its own."""
    bearing, out = _run(scene_name, np.array([time]))
    _draw(axis, bearing, out, 0, marked)
    load = out.normal_load[0, :, OUTER]
    heading(
        axis, f"After {time:g} s, cut open; arrows: loads on the outer ring, {load.min():.3g} to {load.max():.3g} N"
    )


def draw_moving(path, scene_name: str, start: float, marked: int) -> Path:
    """A .gif of the bearing from `start` [s] on, while each ball moves to the place of the next one."""
    bearing, out = _run(scene_name, np.array([start, 1.001 * start]))
    angles = np.unwrap(np.arctan2(out.position[:, 0, 1], out.position[:, 0, 0]))
    orbit = (angles[1] - angles[0]) / (0.001 * start)
    period = 2.0 * math.pi / (bearing.balls * abs(orbit))
    times = start + period * np.arange(FRAMES) / FRAMES
    bearing, out = _run(scene_name, times)
    figure = Figure(figsize=(6.4, 4.6), dpi=72, facecolor="white")
    axis = figure.add_axes((0.0, 0.04, 1.0, 0.88), projection="3d")

    def draw(row):
        axis.clear()
        _draw(axis, bearing, out, row, marked, striped=True)
        axis.set_box_aspect((1.0, 1.0, 0.35), zoom=1.1)
        heading(axis, f"{1e3 * (times[row] - start):.2f} of {1e3 * period:.2f} ms: each ball to the next one's place")

    return write_moving(figure, path, range(FRAMES), draw)


def _run(scene_name, times):
    scene = load_scene(scene_name)
    choice = choose(scene)
    moving = BearingMotion(scene.parameters, choice)
    return bearing_of(scene.parameters, choice.law), moving.advance(times, times[-1])


def _draw(axis, bearing, out, row, marked, striped=False):
    for raceway, middle, colour in ((bearing.outer, 0.0, STYLE["edge"]), (bearing.inner, math.pi, BALL_COLOURS[4])):
        meridian, turn = np.meshgrid(np.linspace(-GROOVE, GROOVE, 9) + middle, np.linspace(*OPEN, 90))
        reach = 1e3 * (raceway.locus_radius + raceway.groove_radius * np.cos(meridian))
        height = 1e3 * raceway.groove_radius * np.sin(meridian)
        axis.plot_surface(reach * np.cos(turn), reach * np.sin(turn), height, color=colour, alpha=0.45, linewidth=0)
    for number, centre in enumerate(1e3 * out.position[row]):
        colour = BALL_COLOURS[1 if number == marked else 0]
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
