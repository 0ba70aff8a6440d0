"""The topics of two bodies: wrenches, the contact, poses, frames and markers, as fields of messages."""

import functools
import math

import numpy as np

from bearing_twin.base.sample import Sample, Wrench
from bearing_twin.kinds.contract import MARKERS, Output, Topic
from bearing_twin.kinds.markers import BLUE, CUBE, GLASS, LINE_LIST, SPHERE, STEEL, contact_markers, marker
from bearing_twin.kinds.topics import MARKER_ARRAY, body_topics, contacts_topic, one_contact, opposed, pose_topic
from bearing_twin.kinds.two_bodies.derived import ROWS
from bearing_twin.kinds.two_bodies.parameters import FIRST, SECOND, Shaped, TwoBodiesScene
from bearing_twin.kinds.two_bodies.row import TWO_BODIES
from bearing_twin.kinds.urdf import LinkShape, sphere
from bearing_twin.shapes.implicit import PLANE, TORUS, support

FRAME = TWO_BODIES.frame
ROUND, RINGS = 48, 7  # sides of a ring; rings each way
NUMBERS = ("approach", "normal_load", "semi_major", "semi_minor", "peak_pressure", "drilling_torque", "spin_rate")


def topics(parameters: TwoBodiesScene) -> tuple[Topic, ...]:
    """The topics of two bodies."""
    texts = {
        FIRST: "on the first body, by the second, about its centre; gravity is not in it",
        SECOND: "on the second body, by the first, about its centre",
    }
    poses = (
        pose_topic(f"{body}/pose", FRAME, f"centre and orientation of the {body} body", prefix)
        for body, prefix in ((FIRST, ""), (SECOND, "second_"))
    )
    return (
        *body_topics(FRAME, wrenches, origins, texts, solids),
        contacts_topic(FRAME, contacts, "the contact, as arrays of one row"),
        *poses,
        Topic("markers", MARKER_ARRAY, MARKERS, marker_fields, "bodies, contact ellipse, load to look at", FRAME),
    )


def origins(parameters: TwoBodiesScene, sample: Sample) -> dict[str, np.ndarray]:
    """The centres [m]."""
    return {FIRST: sample["position"], SECOND: sample["second_position"]}


def solids(parameters: TwoBodiesScene) -> dict[str, list[LinkShape]]:
    """The bodies for `robot_description`: of those that URDF has, spheres."""
    both = {FIRST: parameters.first, SECOND: parameters.second}
    return {body: [sphere(one.radius, STEEL)] for body, one in both.items() if one.shape == "sphere"}


def wrenches(parameters: TwoBodiesScene, sample: Sample) -> list[Wrench]:
    """On each body by the other, of load, friction and drilling."""
    normal, point = sample["normal"], sample["contact_point"]
    force = sample["friction_force"] - float(sample["normal_load"]) * normal
    drilling = float(sample["drilling_torque"]) * normal
    torque = np.cross(point - sample["position"], force) + drilling
    other = np.cross(point - sample["second_position"], -force) - drilling
    return opposed(FIRST, SECOND, "centres", force, torque, other)


def contacts(parameters: TwoBodiesScene, sample: Sample) -> dict:
    """The fields of Contacts: the second body acts on the first; normals and torques about them point into it."""
    given = {name: float(sample[name]) for name in NUMBERS}
    return one_contact(
        FIRST, SECOND,
        **{**given, "drilling_torque": -given["drilling_torque"], "spin_rate": -given["spin_rate"]},
        **{name: sample[name] for name in ("friction_force", "slip", "major_axis")},
        point=sample["contact_point"], normal=-sample["normal"],
    )  # fmt: skip


def _body_marker(name: str, one: Shaped, sample: Sample, prefix: str, longest: float) -> dict:
    """A solid where markers have one, else lines on the surface."""
    pose = sample[f"{prefix}position"], sample[f"{prefix}orientation"]
    if one.shape == "plane":
        return marker(name, 0, CUBE, (8.0 * longest, 8.0 * longest, 0.01 * longest), GLASS, *pose)
    if one.shape in ("sphere", "ellipsoid"):
        axes = one.semi_axes if one.shape == "ellipsoid" else (one.radius,) * 3
        return marker(name, 0, SPHERE, tuple(2.0 * axis for axis in axes), STEEL, *pose)
    return marker(name, 0, LINE_LIST, (0.01 * longest, 0.0, 0.0), STEEL, *pose, points=lines_of(one))


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the bodies, a pin on the first, the contact ellipse, the load."""
    sample, parameters = output.sample, output.parameters
    free = [one for one in (parameters.first, parameters.second) if one.shape != "plane"]
    longest = min(max(*one.semi_axes, one.radius) for one in free)
    centre, point = sample["position"], sample["contact_point"]
    return {
        "markers": [
            _body_marker(FIRST, parameters.first, sample, "", longest),
            _body_marker(SECOND, parameters.second, sample, "second_", longest),
            marker("arm", 0, LINE_LIST, (0.02 * longest, 0.0, 0.0), BLUE, points=np.stack([centre, point])),
            *contact_markers(sample, sample["normal"], longest, centre),
        ]
    }


@functools.lru_cache(maxsize=16)
def lines_of(one: Shaped) -> np.ndarray:
    """Ends (n, 2, 3) [m] of lines on the surface of a body, none of a plane."""
    surface = ROWS[one.shape].surface(one)
    if surface.kind == PLANE:
        return np.empty((0, 2, 3))
    rings = _torus_rings(*surface.sizes[:2]) if surface.kind == TORUS else _convex_rings(surface)
    return np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])


def _torus_rings(locus: float, tube: float):
    turn = np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    for angle in np.linspace(0.0, 2.0 * math.pi, RINGS + 1)[:-1]:
        reach = locus + tube * math.cos(angle)
        height = np.full_like(turn, tube * math.sin(angle))
        yield np.stack([reach * np.cos(turn), reach * np.sin(turn), height], axis=1)
    for angle in np.linspace(0.0, 2.0 * math.pi, 2 * RINGS + 1)[:-1]:
        reach = locus + tube * np.cos(turn)
        yield np.stack([reach * math.cos(angle), reach * math.sin(angle), tube * np.sin(turn)], axis=1)


def _convex_rings(surface):
    """Sections of a convex body through its centre: boundary points in directions of great circles."""
    turn = np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    flat, up = np.stack([np.cos(turn), np.sin(turn)], axis=1), np.array([0.0, 0.0, 1.0])
    for tilt in np.linspace(0.0, math.pi, RINGS)[:-1]:
        side = np.array([math.cos(tilt), math.sin(tilt), 0.0])
        yield support(surface, flat @ np.stack([side, up]))
    yield support(surface, flat @ np.eye(3)[:2])
