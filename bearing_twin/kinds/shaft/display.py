"""The topics of a shaft on two bearings: wrenches, pose, frames and markers, as fields of messages."""

from itertools import pairwise

import numpy as np

from bearing_twin.base.sample import Channel, Sample, Wrench
from bearing_twin.kinds import views
from bearing_twin.kinds.bearing.outputs import ring_attitude
from bearing_twin.kinds.contract import MARKERS, PUBLISH, Command, Output, Topic
from bearing_twin.kinds.shaft import SHAFT
from bearing_twin.kinds.shaft.equilibrium import constant_loads
from bearing_twin.kinds.shaft.parameters import SIDES, Mounted, ShaftScene
from bearing_twin.kinds.topics import (
    BLUE,
    CYLINDER,
    GLASS,
    LINE_LIST,
    MARKER_ARRAY,
    POSE,
    RED,
    STEEL,
    body_topics,
    load_command,
    marker,
    placed,
    turning_commands,
)
from bearing_twin.kinds.views import (
    DARK,
    ORANGE,
    Arrows,
    CurvePanel,
    Enlarged,
    Look,
    Solid,
    View,
    along_axes,
    ball_curves,
    curves,
    energies,
    view_of,
)

FRAME = SHAFT.frame
BODY = "shaft"
BEARINGS = tuple(f"{side}_bearing" for side in SIDES)
WIDE, BEYOND = 2.0, 0.3  # width of a bearing in ball diameters, ends of the shaft in distances of the bearings
ARROW = 2.0  # longest arrow, in outer radii of the bearings, from which it protrudes


def topics(parameters: ShaftScene) -> tuple[Topic, ...]:
    """The topics of a shaft."""
    texts = {BODY: "on the shaft, by both bearings, about its centre of mass; weight and loads are not in it"}
    texts |= {
        name: f"on the shaft, by the {side} bearing, about the centre of its inner ring"
        for side, name in zip(SIDES, BEARINGS, strict=True)
    }
    return (
        *body_topics(FRAME, wrenches, origins, texts, solids),
        Topic("shaft/pose", POSE, PUBLISH, pose, "centre of mass and attitude of the shaft, tilted and turned", FRAME),
        Topic("markers", MARKER_ARRAY, MARKERS, marker_fields, "shaft, bearings and their forces, for display", FRAME),
    )  # fmt: skip


def commands() -> tuple[Command, ...]:
    """The topics that a running shaft obeys."""
    return *turning_commands("the shaft", FRAME), load_command("on the shaft about shaft.load_place", FRAME)


def ring_centres(parameters: ShaftScene, sample: Sample) -> np.ndarray:
    """Centres (..., 2, 3) [m] of the inner rings, left and right, from the middle of the shaft as made."""
    centres = np.array([[0.0, 0.0, getattr(parameters, side).place] for side in SIDES])
    return sample["ring_offset"] + centres


def origins(parameters: ShaftScene, sample: Sample) -> dict[str, np.ndarray]:
    """Origins [m] of the frames of the bodies: the centre of mass, and the centres of the inner rings."""
    centres = ring_centres(parameters, sample)
    return {BODY: sample["position"], **{name: centres[..., k, :] for k, name in enumerate(BEARINGS)}}


def wrenches(parameters: ShaftScene, sample: Sample) -> list[Wrench]:
    """The wrench of both bearings on the shaft about its centre of mass, then those of each about its ring's centre."""
    force, moment = sample["bearing_force"], np.zeros(sample["bearing_force"].shape)
    moment[..., :2] = sample["bearing_moment"]
    arms = ring_centres(parameters, sample) - sample["position"][..., None, :]
    # To first order, as the shaft's motion has it: along the axis the arms alone count.
    arms[..., :2] = 0.0
    total = Wrench(
        BODY, "bearings", "centre of mass", BODY, force.sum(axis=-2), (moment + np.cross(arms, force)).sum(axis=-2)
    )
    rows = [
        Wrench(BODY, name, "ring centre", name, force[..., k, :], moment[..., k, :]) for k, name in enumerate(BEARINGS)
    ]
    return [total, *rows]


def ring_sizes(mounted: Mounted) -> tuple[float, float, float]:
    """Radii [m] of the shaft in a bearing and of its outside, and its width, as they are drawn."""
    ball, pitch = mounted.geometry.ball_diameter, mounted.geometry.pitch_diameter
    return max(0.5 * pitch - 0.9 * ball, 0.1 * pitch), 0.5 * pitch + 0.9 * ball, WIDE * ball


def longest_arrow(parameters: ShaftScene) -> float:
    """Length [m] of the arrow of the greatest force."""
    return ARROW * max(ring_sizes(getattr(parameters, side))[1] for side in SIDES)


def sizes(parameters: ShaftScene) -> tuple[float, float, float]:
    """Radius [m] of the shaft as it is drawn, and where it begins and ends along z."""
    mounted = [getattr(parameters, side) for side in SIDES]
    shaft = parameters.shaft
    positions = (
        [bearing.place for bearing in mounted] + [row[0] for row in shaft.loads + shaft.unbalances] + [shaft.load_place]
    )
    beyond = BEYOND * (mounted[1].place - mounted[0].place)
    return min(ring_sizes(bearing)[0] for bearing in mounted), min(positions) - beyond, max(positions) + beyond


def solids(parameters: ShaftScene) -> dict[str, list[dict]]:
    """The bodies as markers in their frames."""
    radius, low, high = sizes(parameters)
    middle = 0.0, 0.0, 0.5 * (low + high)
    markers = {BODY: [marker("shaft", 0, CYLINDER, (2.0 * radius, 2.0 * radius, high - low), STEEL, middle)]}
    for k, (side, name) in enumerate(zip(SIDES, BEARINGS, strict=True)):
        _, outside, wide = ring_sizes(getattr(parameters, side))
        markers[name] = [marker("bearings", k, CYLINDER, (2.0 * outside, 2.0 * outside, wide), GLASS)]
    return markers


def pose(output: Output) -> dict:
    """geometry_msgs/PoseStamped of the shaft."""
    sample = output.sample
    attitude = ring_attitude(sample["tilt"], sample["shaft_angle"])
    return {"pose": {"position": sample["position"], "orientation": attitude}}


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the shaft with a line on it, both bearings, and their forces on the shaft."""
    parameters, sample, bodies = output.parameters, output.sample, solids(output.parameters)
    (radius, low, high), tilt, angle = sizes(parameters), sample["tilt"], sample["shaft_angle"]
    along = np.stack([tilt[..., 1], -tilt[..., 0], np.ones(angle.shape)], axis=-1)
    middle = sample["position"] + 0.5 * (low + high) * along
    force, centres = sample["bearing_force"], output.once(ring_centres)
    scale = longest_arrow(parameters) / np.maximum(np.linalg.norm(force, axis=-1).max(axis=-1), 1e-9)
    tails = centres - scale[..., None, None] * force
    arrows = np.stack([tails, centres], axis=-2).reshape(*angle.shape, -1, 3)
    line, thin = [(1.02 * radius, 0.0, low), (1.02 * radius, 0.0, high)], (0.1 * radius, 0.0, 0.0)
    return {
        "markers": [
            placed(bodies[BODY][0], middle, ring_attitude(tilt, np.zeros(angle.shape))),
            marker("shaft", 1, LINE_LIST, thin, BLUE, sample["position"], ring_attitude(tilt, angle), points=line),
            *(
                placed(bodies[name][0], (0.0, 0.0, getattr(parameters, side).place))
                for side, name in zip(SIDES, BEARINGS, strict=True)
            ),
            marker("forces", 0, LINE_LIST, thin, RED, points=arrows),
        ]
    }


REACH = 0.15  # of the shaft's radius: greatest drawn displacement


def view(parameters, channels) -> View:
    """z along the shaft; all positions are in `shaft_link`."""
    radius, low, high = sizes(parameters)
    drawn = (
        Channel("turn", "1", (2,), "cosine and sine of the shaft's angle"),
        Channel("centres", "m", (2, 3), "of the inner rings"),
        Channel("varying_load", "N", (3,), "the load but shaft.loads, which no command replaces"),
    )
    return view_of(
        channels,
        drawn,
        rows=lambda sample: _rows(parameters, sample),
        panels=_panels(parameters),
        solids=(
            Solid(
                "shaft", "shaft", {"turned": {"strokes": _rod(radius, low, high)}}, views.STEEL,
                deviation="position", turn="turn", tilt="tilt", marked=True,
            ),
            *(
                Solid(
                    f"{side}_bearing", f"{side} bearing", {"turned": {"strokes": _housing(getattr(parameters, side))}},
                    DARK, opacity=0.5,
                )
                for side in SIDES
            ),
        ),
        marks=(
            Arrows(
                "forces", "force on the shaft", "N", "bearing_force", longest_arrow(parameters), (ORANGE,),
                point="centres",
            ),
        ),
        look=Look(0.6 * (high - low), (-1.0, 0.35, 0.35), middle=(0.0, 0.0, 0.5 * (low + high))),
        enlarged=Enlarged("displacement of the shaft", ("position",), REACH * radius),
        words="The shaft is drawn as wide as its bearings' bores; its displacement is enlarged, and its tilt as much.",
        axes=True,
    )  # fmt: skip


def _panels(parameters) -> tuple[CurvePanel, ...]:
    return (
        curves("Centre of mass", "m", *along_axes("position")),
        curves("Tilt", "rad", ("tilt", "about x", 0), ("tilt", "about y", 1)),
        *(
            curves(f"Force of the {side} bearing on the shaft", "N", *along_axes("bearing_force", 3 * b))
            for b, side in enumerate(SIDES)
        ),
        *(
            ball_curves(f"Load on each ball, {side} bearing, inner raceway", "N", f"{side}_normal_load", balls, 0)
            for side, balls in ((side, getattr(parameters, side).geometry.balls) for side in SIDES)
        ),
        curves("Load on the shaft, without its weight", "N", *along_axes("load")),
        curves("Speed of the shaft", "rad/s", ("shaft_speed", "about z")),
        energies(("kinetic_energy", "kinetic"), ("elastic_energy", "in the contacts")),
        curves(
            "Work since the start", "J", ("load_work", "of loads and unbalances"), ("bearing_work", "on the bearings"),
            ("dissipated", "lost to damping"),
        ),
    )  # fmt: skip


def _rows(parameters, sample) -> dict[str, np.ndarray]:
    angle = sample["shaft_angle"]
    turn = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    varying = sample["load"] - constant_loads(parameters)[:3]
    return {"turn": turn, "centres": ring_centres(parameters, sample), "varying_load": varying}


def _rod(radius: float, low: float, high: float) -> list[list[tuple[float, float]]]:
    return [[(0.0, low), (radius, low)], [(radius, low), (radius, high)], [(radius, high), (0.0, high)]]


def _housing(mounted) -> list[list[tuple[float, float]]]:
    """The section (radius, z) of a ring around the shaft."""
    inner, outer, wide = ring_sizes(mounted)
    low, high, inside = mounted.place - 0.5 * wide, mounted.place + 0.5 * wide, 0.5 * (inner + outer)
    corners = [(inside, low), (outer, low), (outer, high), (inside, high), (inside, low)]
    return [list(pair) for pair in pairwise(corners)]
