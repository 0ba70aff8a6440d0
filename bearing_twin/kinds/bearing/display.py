"""What others see of a bearing: its topics, and its view in the browser.

Topics are wrenches, contacts, state, joints and markers, as fields of messages. In the markers balls carry pins, so
that their rolling is seen; contact ellipses are drawn ELLIPSE_SCALE times as large; load arrows are relative, the
longest as long as a ball is thick, and a line of text says how many newtons that is. Few markers have many points each:
one point costs a thirtieth of one marker.

The view has the rings in section, balls that roll, ellipses, loads, the cage, and curves of loads and motion.
Deviations from the bearing without clearance or load are enlarged alike: those of the balls from their circle, those of
the ring from its seat, and the clearance of the raceways. What touches without enlargement touches with it, and what is
separated stays separated.
"""

import math
from itertools import pairwise

import numpy as np

from bearing_twin.base.sample import Channel, Sample
from bearing_twin.kinds import topics as shades
from bearing_twin.kinds.bearing import BEARING
from bearing_twin.kinds.bearing.accelerometer import Listener, tables
from bearing_twin.kinds.bearing.geometry import operating_geometry
from bearing_twin.kinds.bearing.outputs import RINGS, contact_details, contacts, origins, ring_attitude, wrenches
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.rings import EVEN, FREE_RING, POCKETS, PRESCRIBED, dimension_of, moving_centre
from bearing_twin.kinds.contract import MARKERS, PUBLISH, SECOND, Command, Output, Topic
from bearing_twin.kinds.topics import (
    BEARING_STATE,
    CYLINDER,
    DIAGNOSTICS,
    ELLIPSE_SCALE,
    FLOAT,
    JOINT_STATES,
    LINE_LIST,
    MARKER_ARRAY,
    POSE,
    SPHERE,
    SPHERE_LIST,
    body_topics,
    contacts_topic,
    crossed,
    load_command,
    marker,
    outlines,
    own_axes,
    placed,
    text_marker,
    turning_commands,
)
from bearing_twin.kinds.views import (
    BLUE,
    BRASS,
    ORANGE,
    PALETTE,
    RED,
    Arrows,
    ContactEllipses,
    Details,
    Enlarged,
    Look,
    Solid,
    View,
    along_axes,
    ball_curves,
    curves,
    grooved_ring,
    view_of,
)

LONGEST_ARROW = 1.0  # ball diameters
OUTER_WIDTH = 0.95  # of the inner ring's: coplanar faces flicker
LETTERS = 0.25  # height of a line of text in ball diameters: the line is no wider than the bearing

CORNERS = 6  # of the polygon that represents a cage, per ball

_SPOKES = ((-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0))


def markers(parameters, sample, details) -> list[dict]:
    """Fields of each marker of many outputs: balls, pins, rings, ellipses, load arrows and their scale.

    What contacts without a load have is a point: every output has as many points, and its text as many letters.
    """
    greatest = np.maximum(sample["normal_load"].max(axis=(1, 2)), 1e-30)
    scales = (f"longest arrow = {load:.4g} N\nellipses x {ELLIPSE_SCALE:g}" for load in greatest.tolist())
    diameter, shape = parameters.geometry.ball_diameter, (len(greatest), -1, 3)
    width, thick = (0.03 * diameter, 0.0, 0.0), (0.06 * diameter, 0.0, 0.0)
    ellipses, arrows = _outlines(sample, details), _arrows(parameters, sample, details, greatest)
    return [
        *(*_balls(parameters, sample), *_rings(parameters, sample), *_cage(parameters, sample)),
        marker("contact_ellipses", 0, LINE_LIST, width, shades.RED, points=ellipses.reshape(shape)),
        marker("loads", 0, LINE_LIST, thick, shades.GREEN, points=arrows.reshape(shape)),
        text_marker("scale", scales, LETTERS * diameter, (0.0, 0.0, 1.5 * diameter)),
    ]


def ring_sizes(parameters) -> tuple[float, float, float]:
    """Diameters of the inner and of the outer raceway, and the width [m] that rings are drawn with."""
    geometry = operating_geometry(parameters)
    reach = geometry.ball_diameter + 0.5 * geometry.radial_clearance
    return geometry.pitch_diameter - reach, geometry.pitch_diameter + reach, 1.2 * geometry.ball_diameter


def solids(parameters) -> dict[str, list[dict]]:
    """The bodies as markers in their frames: balls, a solid inner ring in a translucent outer one."""
    (inner, outer, wide), ball = ring_sizes(parameters), (parameters.geometry.ball_diameter,) * 3
    balls = {f"ball_{k}": [marker("balls", k, SPHERE, ball, shades.STEEL)] for k in range(parameters.geometry.balls)}
    return balls | {
        "inner_ring": [marker("rings", 0, CYLINDER, (inner, inner, wide), shades.ORANGE)],
        "outer_ring": [marker("rings", 1, CYLINDER, (outer, outer, OUTER_WIDTH * wide), shades.GLASS)],
    }


def _balls(parameters, sample):
    """Balls, each with two pins through its centre, along its own x and y axes."""
    diameter, position = parameters.geometry.ball_diameter, sample["position"]
    yield marker("balls", 0, SPHERE_LIST, (diameter,) * 3, shades.STEEL, points=position)
    reach = [0.53 * diameter * axis for axis in own_axes(sample["orientation"])[:2]]
    ends = np.stack([position + side * axis for axis in reach for side in (-1.0, 1.0)], axis=-2)
    width = (0.1 * diameter, 0.0, 0.0)
    yield marker("ball_pins", 0, LINE_LIST, width, shades.BLUE, points=ends.reshape(len(position), -1, 3))


def _rings(parameters, sample):
    """A solid inner ring with spokes, so that its turning is seen, in a translucent outer one."""
    diameter, bodies = parameters.geometry.ball_diameter, solids(parameters)
    tilt, angle, centre = sample["inner_ring_tilt"], sample["inner_ring_angle"], sample["inner_ring_offset"]
    inner = ring_sizes(parameters)[0]
    spokes = [(0.5 * inner * x, 0.5 * inner * y, 0.61 * diameter) for x, y in _SPOKES]
    width = (0.05 * diameter, 0.0, 0.0)
    yield placed(bodies["inner_ring"][0], centre, ring_attitude(tilt, np.zeros(angle.shape)))
    yield bodies["outer_ring"][0]
    yield marker("spokes", 0, LINE_LIST, width, shades.BLUE, centre, ring_attitude(tilt, angle), points=spokes)


def _cage(parameters, sample):
    """A circle through the middle of the pockets, and a web between each two of them, where the cage is."""
    if parameters.cage.kind == "none":
        return
    radius, half = 0.5 * parameters.geometry.pitch_diameter, 0.3 * parameters.geometry.ball_diameter
    balls, points = parameters.geometry.balls, []
    corners = np.linspace(0.0, 2.0 * np.pi, CORNERS * balls + 1)
    circle = np.stack([radius * np.cos(corners), radius * np.sin(corners), np.zeros_like(corners)], axis=-1).tolist()
    for side in pairwise(circle):
        points += side
    for k in range(balls):
        x, y, _ = circle[CORNERS * k + CORNERS // 2]
        points += [(x, y, -half), (x, y, half)]
    angle, offset = sample["cage_angle"], sample["cage_offset"]
    centre = np.concatenate([offset, np.zeros_like(offset[..., :1])], axis=-1)
    turned = ring_attitude(np.zeros_like(offset), angle)
    yield marker("cage", 0, LINE_LIST, (0.1 * half, 0.0, 0.0), shades.BRASS, centre, turned, points=points)


def _outlines(sample, details) -> np.ndarray:
    """Outlines of all contact ellipses, as polygons of OUTLINE_SIDES sides: both ends of every side."""
    along = details["major_axis"]
    across = crossed(sample["normal"], along)
    major = ELLIPSE_SCALE * details["semi_major"][..., None] * along
    minor = ELLIPSE_SCALE * details["semi_minor"][..., None] * across
    return outlines(sample["point"], major, minor)


def _arrows(parameters, sample, details, greatest) -> np.ndarray:
    """Both ends of a shaft and two barbs of an arrow at every contact, their tips there."""
    length = LONGEST_ARROW * parameters.geometry.ball_diameter / greatest
    tip = sample["point"]
    along = sample["normal"] * (length[:, None, None] * sample["normal_load"])[..., None]
    barb = 0.12 * crossed(details["major_axis"], along)
    left, right = tip - 0.25 * along + barb, tip - 0.25 * along - barb
    return np.stack([tip - along, tip, left, tip, right, tip], axis=-2)


FRAME = BEARING.frame
STATE_ARRAYS = ("orbit_angle", "position", "velocity", "orientation", "angular_velocity", "roll_rate")
STATE_NUMBERS = (
    "inner_ring_angle", "inner_ring_speed", "drive_torque", "kinetic_energy", "elastic_energy", "potential_energy",
    "drive_work", "dissipated",
)  # fmt: skip


def topics(parameters: BearingScene) -> tuple[Topic, ...]:
    """The topics of a bearing with these balls."""
    balls = parameters.geometry.balls
    texts = {f"ball_{k}": f"on ball {k}, by raceways and neighbours, about its centre" for k in range(balls)}
    texts |= dict.fromkeys(RINGS, "on the ring, by the balls and a cage on its land, about its centre")
    return (
        *body_topics(FRAME, wrenches, origins, texts, solids),
        contacts_topic(FRAME, contacts, "all contacts, of balls with raceways and with each other, as arrays"),
        Topic("state", BEARING_STATE, PUBLISH, state, "motion of balls and rings, energies", FRAME),
        Topic(
            "inner_ring/pose", POSE, PUBLISH, ring_pose, "centre and attitude of the inner ring, tilted and turned",
            FRAME,
        ),
        Topic("joint_states", JOINT_STATES, PUBLISH, joints, "angles of inner ring and orbits", FRAME),
        *_cage_topics(parameters),
        *(
            Topic(
                "health", DIAGNOSTICS, SECOND, Listener,
                "of a scene with a sensor: damage that the spectrum of its last 10 s names, and levels of lines [dB]",
            )
            for _ in tables(parameters)
        ),
        Topic("markers", MARKER_ARRAY, MARKERS, marker_fields, "balls, rings, ellipses, loads, for display", FRAME),
    )  # fmt: skip


def _cage_topics(parameters: BearingScene) -> tuple[Topic, ...]:
    if parameters.cage.kind == "none":
        return ()
    text = (
        "of a cage, where there is one: angle [rad], speed [rad/s]; effort: torque of the balls on it [N m]; and x, y "
        "of a centre that moves [m, m/s]; effort: force of the land on it [N]"
    )
    return (Topic("cage/state", JOINT_STATES, PUBLISH, cage, text, FRAME),)


def commands() -> tuple[Command, ...]:
    """The topics that a running bearing obeys."""
    speed, stamped = turning_commands("the inner ring", FRAME)
    torque = Command(
        "command/torque", FLOAT, lambda message: ("set_torque", message.data),
        "torque on the inner ring about +z [N m], of a scene whose drive.kind is torque; held until the next",
    )  # fmt: skip
    return speed, torque, stamped, load_command("on the inner ring about its centre", FRAME)


def state(output: Output) -> dict:
    """bearing_twin_msgs/BearingState."""
    sample = output.sample
    return {
        "sequence": sample.sequence,
        "balls": output.parameters.geometry.balls,
        "cage_speed": orbit_rates(sample).mean(axis=-1),
        "inner_ring_offset": sample["inner_ring_offset"],
        "inner_ring_tilt": sample["inner_ring_tilt"],
        **{name: sample[name] for name in STATE_ARRAYS + STATE_NUMBERS},
    }


def ring_pose(output: Output) -> dict:
    """geometry_msgs/PoseStamped of the inner ring."""
    sample = output.sample
    attitude = ring_attitude(sample["inner_ring_tilt"], sample["inner_ring_angle"])
    return {"pose": {"position": sample["inner_ring_offset"], "orientation": attitude}}


def joints(output: Output) -> dict:
    """sensor_msgs/JointState: angle [rad] and speed [rad/s] of the inner ring and of each ball's orbit."""
    sample = output.sample
    balls = output.parameters.geometry.balls
    return {
        "name": ["inner_ring_joint", *(f"ball_{k}_orbit_joint" for k in range(balls))],
        "position": np.concatenate([sample["inner_ring_angle"][..., None], sample["orbit_angle"]], axis=-1),
        "velocity": np.concatenate([sample["inner_ring_speed"][..., None], orbit_rates(sample)], axis=-1),
    }


def cage(output: Output) -> dict:
    """sensor_msgs/JointState of the cage: angle [rad], speed [rad/s], and torque of the balls on it about +z [N m].

    The angle is 0 where ball 0 is in the middle of its pocket. The torque is that of the forces along the orbits; what
    friction of the pockets adds, at most cage.friction times ball diameter over pitch diameter of it, is left out.
    Equilibria know none: it is 0 there. Of a centre that moves: x and y [m], velocity [m/s], force of the land [N].
    """
    sample, moving = output.sample, moving_centre(output.parameters)
    x, y, _ = np.moveaxis(sample["position"], -1, 0)
    torque = -(sample["pocket_force"] * np.hypot(x, y)).sum(axis=-1)
    return {
        "name": ["cage_joint", *(("cage_x_joint", "cage_y_joint") if moving else ())],
        "position": _with_centre(sample["cage_angle"], sample["cage_offset"], moving),
        "velocity": _with_centre(sample["cage_speed"], sample["cage_velocity"], moving),
        "effort": _with_centre(torque, sample["land_force"], moving),
    }


def _with_centre(turning, centre, moving: bool) -> np.ndarray:
    return np.concatenate([turning[..., None], centre], axis=-1) if moving else turning[..., None]


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray."""
    return {"markers": markers(output.parameters, output.sample, output.once(contact_details))}


def orbit_rates(sample: Sample) -> np.ndarray:
    """Angular velocity [rad/s] of each ball's centre about the bearing's axis."""
    x, y, _ = np.moveaxis(sample["position"], -1, 0)
    along_x, along_y, _ = np.moveaxis(sample["velocity"], -1, 0)
    return (x * along_y - y * along_x) / (x**2 + y**2)


# The view in the browser.

REACH = 0.12  # ball radii: how far the greatest deviation is drawn
ARROW, RING_ARROW = 0.8, 0.55  # longest arrow of a ball's load in ball diameters, of the ring's in radii of its bore
WIDTH, SHOULDER, WALL = 0.75, 0.2, 0.42  # ball diameters: half width of a ring, depth of a groove, ring behind it
CYCLE = 6.0  # s of viewing per orbit of the balls


def view(parameters, channels) -> View:
    """The view of a bearing scene; all positions are in `bearing_link`."""
    geometry, n = operating_geometry(parameters), parameters.geometry.balls
    ball, free = geometry.ball_diameter, dimension_of(parameters) == FREE_RING
    drawn = (
        Channel("seat", "m", (n, 3), "ball centres on the pitch circle"),
        Channel("deviation", "m", (n, 3), "of the ball centres from there"),
        Channel("semi_major", "m", (n, 2), "of the contact ellipse"),
        Channel("semi_minor", "m", (n, 2), "of the contact ellipse"),
        Channel("peak_pressure", "Pa", (n, 2), "at the middle of the contact ellipse"),
        Channel("slip_speed", "m/s", (n, 2), "of the ball's surface on the raceway at the contact's middle"),
        Channel("ring_turn", "1", (2,), "cosine and sine of the inner ring's angle"),
        Channel("cage_turn", "1", (2,), "cosine and sine of the cage's angle"),
        Channel("cage_place", "m", (3,), "of the cage's centre off the axis"),
        Channel("ring_load", "N", (3,), "on the inner ring, carried by the balls"),
        Channel("friction_torque", "N m", (), "of the balls on the inner ring about the axis"),
        Channel("orbit_speed", "rad/s", (), "of the balls around the axis, mean"),
    )
    return view_of(
        channels,
        drawn,
        rows=lambda sample: _rows(parameters, sample, free),
        panels=_panels(n, dimension_of(parameters) != PRESCRIBED, moving_centre(parameters)),
        solids=tuple(_solids(parameters, geometry)),
        marks=_marks(geometry),
        look=Look(0.5 * geometry.pitch_diameter + (0.5 + WALL) * ball, (-0.1, -0.52, 0.85)),
        enlarged=Enlarged(
            "displacements and clearance",
            ("deviation", "inner_ring_offset", *(("cage_place",) if moving_centre(parameters) else ())),
            REACH * 0.5 * ball, 0.25 * abs(geometry.radial_clearance),
        ),
        details=Details(
            "balls", "ball", ("inner raceway", "outer raceway"), "semi_major", "semi_minor", "peak_pressure",
            (("load", "normal_load"), ("contact angle", "contact_angle"), ("slip speed", "slip_speed")),
        ),
        period=_period(parameters, ball / geometry.pitch_diameter),
        words="Rings are cut through the middle of the balls; the outer ring is at rest.",
        axes=True,
    )  # fmt: skip


def _period(parameters, slenderness: float) -> float:
    """Simulated seconds per second of viewing, so that balls orbit once in CYCLE seconds."""
    speed = max(abs(parameters.drive.speed), abs(parameters.drive.speed + parameters.drive.change.speed))
    return 2.0 * math.pi / (0.5 * (1.0 - slenderness) * speed) / CYCLE if speed else 0.0


def _rows(parameters, sample, free) -> dict[str, np.ndarray]:
    position = sample["position"]
    axis_distance, seat = np.hypot(position[..., 0], position[..., 1]), np.zeros_like(position)
    radius = 0.5 * parameters.geometry.pitch_diameter
    seat[..., :2] = position[..., :2] * (radius / axis_distance)[..., None]
    details = contact_details(parameters, sample)
    return {
        "seat": seat,
        "deviation": position - seat,
        **{name: details[name] for name in ("semi_major", "semi_minor", "peak_pressure")},
        "slip_speed": np.where(sample["normal_load"] > 0.0, np.linalg.norm(sample["slip"], axis=-1), 0.0),
        "ring_turn": _turn(sample["inner_ring_angle"]),
        "cage_turn": _turn(sample["cage_angle"]),
        "cage_place": np.pad(sample["cage_offset"], [*((0, 0),) * (sample["cage_offset"].ndim - 1), (0, 1)]),
        "ring_load": sample["inner_ring_load"] if free else -sample["inner_ring_force"],
        "friction_torque": sample["inner_ring_torque"][..., 2],
        "orbit_speed": orbit_rates(sample).mean(axis=-1),
    }


def _turn(angle) -> np.ndarray:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _solids(parameters, geometry):
    ball, pitch = geometry.ball_diameter, geometry.pitch_diameter
    opening = 0.25 * geometry.radial_clearance
    for name, label, side, conformity in (
        ("inner_ring", "inner ring", -1.0, geometry.inner_conformity),
        ("outer_ring", "outer ring", 1.0, geometry.outer_conformity),
    ):
        inner, bottom, groove = side < 0.0, 0.5 * (pitch + side * ball), conformity * ball
        steepest = math.acos(1.0 - SHOULDER * ball / groove)
        strokes = grooved_ring(bottom, side * groove, steepest, bottom + side * WALL * ball, -WIDTH * ball)
        yield Solid(
            name,
            label,
            {"turned": {"strokes": strokes, "grow": side * opening}},
            deviation="inner_ring_offset" if inner else "",
            turn="ring_turn" if inner else "",
            tilt="inner_ring_tilt" if inner else "",
            marked=inner,
        )
    yield Solid(
        "balls", "balls", {"ellipsoid": (0.5 * ball,) * 3}, PALETTE, parameters.geometry.balls,
        "seat", "deviation", "orientation", marked=True,
    )  # fmt: skip
    if parameters.cage.kind in (EVEN, POCKETS):
        outlines = _webs(parameters.geometry.balls, pitch, ball, parameters.cage.pocket_clearance)
        shape = {"extruded": {"outlines": outlines, "low": -0.42 * ball, "high": 0.06 * ball}}
        deviation = "cage_place" if moving_centre(parameters) else ""
        yield Solid("cage", "cage", shape, BRASS, deviation=deviation, turn="cage_turn")


def _webs(balls: int, pitch: float, ball: float, clearance: float) -> list[list[tuple[float, float]]]:
    """Outlines (x, y) of the pieces of a cage between the balls, ball 0 at angle 0, joined by a ring behind them."""
    inner, outer, pocket = 0.5 * pitch - 0.16 * ball, 0.5 * pitch + 0.16 * ball, 0.5 * (ball + clearance)
    webs = []
    for k in range(balls):
        middle, half = 2.0 * math.pi * (k + 0.5) / balls, math.pi / balls
        sides = []
        for sign in (-1.0, 1.0):
            # the rim of the pocket between the two circles of the cage; webs that would vanish keep a sliver
            for radius in np.linspace(inner, outer, 7)[:: 1 if sign < 0.0 else -1]:
                cosine = (radius**2 + 0.25 * pitch**2 - pocket**2) / (radius * pitch)
                away = min(math.acos(min(cosine, 1.0)), 0.97 * half)
                angle = middle + sign * (half - away)
                sides.append((radius * math.cos(angle), radius * math.sin(angle)))
        webs.append(sides)
    return webs


def _marks(geometry):
    ball = geometry.ball_diameter
    bore = 0.5 * geometry.pitch_diameter - (0.5 + WALL) * ball
    return (
        Arrows(
            "loads", "load on a ball by inner and outer raceway", "N", "normal", ARROW * ball, (BLUE, ORANGE),
            "normal_load", on="balls", radius=0.5 * ball,
        ),
        Arrows("ring_load", "load on the inner ring", "N", "ring_load", RING_ARROW * bore, (RED,), from_point=True),
        ContactEllipses(
            "ellipses", "contact ellipses", "normal", "semi_major", "semi_minor", "peak_pressure", 0.45 * ball,
            on="balls", radius=0.5 * ball,
        ),
    )  # fmt: skip


def _panels(balls: int, moves: bool, cage_moves: bool):
    displaced = curves("Inner ring's displacement", "m", *along_axes("inner_ring_offset"))
    off_axis = curves("Cage's centre, off the axis", "m", ("cage_offset", "x", 0), ("cage_offset", "y", 1))
    return (
        ball_curves("Load on each ball, inner raceway", "N", "normal_load", balls, 0),
        ball_curves("Load on each ball, outer raceway", "N", "normal_load", balls, 1),
        *((displaced,) if moves else ()),
        *((off_axis,) if cage_moves else ()),
        ball_curves("Peak pressure, inner raceway", "Pa", "peak_pressure", balls, 0),
        curves("Friction torque on the inner ring", "N m", ("friction_torque", "about the axis")),
        curves("Speed about the axis", "rad/s", ("inner_ring_speed", "inner ring"), ("orbit_speed", "balls, mean")),
        curves(
            "Energy", "J",
            ("kinetic_energy", "kinetic"), ("elastic_energy", "elastic"), ("potential_energy", "of height"),
        ),
        curves(
            "Work since the start", "J",
            ("drive_work", "by drive and loads"), ("dissipated", "lost to friction, damping"),
        ),
    )  # fmt: skip
