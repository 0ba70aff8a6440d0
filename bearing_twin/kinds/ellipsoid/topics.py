"""The topics of an ellipsoid on a plane: wrenches, the contact, frames and markers, as fields of messages.

The frame of the scene lies in the plane, z up; the frame of the plane is the same.
"""

import numpy as np

from bearing_twin.base.sample import Sample, Wrench
from bearing_twin.kinds.contract import MARKERS, Output, Topic
from bearing_twin.kinds.ellipsoid.parameters import BODY, PLANE, EllipsoidOnPlaneScene
from bearing_twin.kinds.ellipsoid.row import ELLIPSOID_ON_PLANE
from bearing_twin.kinds.markers import BLUE, CUBE, GLASS, LINE_LIST, SPHERE, STEEL, contact_markers, marker
from bearing_twin.kinds.topics import MARKER_ARRAY, body_topics, contacts_topic, one_contact, opposed, pose_topic
from bearing_twin.kinds.urdf import LinkShape, box, sphere
from bearing_twin.numerics.rotation import rotation_matrix

FRAME = ELLIPSOID_ON_PLANE.frame
NUMBERS = ("approach", "normal_load", "semi_major", "semi_minor", "peak_pressure", "drilling_torque")


def topics(parameters: EllipsoidOnPlaneScene) -> tuple[Topic, ...]:
    """The topics of an ellipsoid on a plane."""
    texts = {
        BODY: "on the body, by the plane, about its centre; gravity is not in it",
        PLANE: f"on the plane, by the body, about the origin of {FRAME}",
    }
    return (
        *body_topics(FRAME, wrenches, origins, texts, solids),
        contacts_topic(FRAME, contacts, "the contact, as arrays of one row"),
        pose_topic("pose", FRAME, "centre and orientation of the body"),
        Topic("markers", MARKER_ARRAY, MARKERS, marker_fields, "body, contact ellipse, load", FRAME),
    )


def origins(parameters: EllipsoidOnPlaneScene, sample: Sample) -> dict[str, np.ndarray]:
    """Centre of the body, and the origin [m]."""
    return {BODY: sample["position"], PLANE: np.zeros(3)}


def solids(parameters: EllipsoidOnPlaneScene) -> dict[str, list[LinkShape]]:
    """The bodies for `robot_description`: URDF has no ellipsoid, so only a ball is drawn, and the plane."""
    axes = parameters.body.semi_axes
    longest = max(axes)
    plane = {PLANE: [box((8.0 * longest, 8.0 * longest, 0.02 * longest), GLASS, (0.0, 0.0, -0.01 * longest))]}
    return plane | ({BODY: [sphere(longest, STEEL)]} if min(axes) == longest else {})


def wrenches(parameters: EllipsoidOnPlaneScene, sample: Sample) -> list[Wrench]:
    """On body and plane by each other, of load, friction and drilling."""
    force = np.array([0.0, 0.0, float(sample["normal_load"])]) + sample["friction_force"]
    drilling, point = np.array([0.0, 0.0, float(sample["drilling_torque"])]), sample["contact_point"]
    torque = np.cross(point - sample["position"], force) + drilling
    return opposed(BODY, PLANE, "centre, origin", force, torque, np.cross(point, -force) - drilling)


def contacts(parameters: EllipsoidOnPlaneScene, sample: Sample) -> dict:
    """The fields of Contacts: the plane acts on the body."""
    return one_contact(
        BODY, PLANE,
        **{name: float(sample[name]) for name in NUMBERS},
        **{name: sample[name] for name in ("friction_force", "slip", "major_axis")},
        spin_rate=float(sample["angular_velocity"][2]), point=sample["contact_point"], normal=(0.0, 0.0, 1.0),
    )  # fmt: skip


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the body with pins along its axes, the plane, the contact ellipse, the load."""
    sample, axes = output.sample, np.array(output.parameters.body.semi_axes)
    longest, centre, point = float(axes.max()), sample["position"], sample["contact_point"]
    reach = 1.05 * axes * np.array(rotation_matrix(tuple(map(float, sample["orientation"]))))
    pins = np.stack([centre - reach.T, centre + reach.T], axis=1)
    ground = (float(point[0]), float(point[1]), -0.01 * longest)
    size, thin = tuple(2.0 * axes), 0.02 * longest
    return {
        "markers": [
            marker("body", 0, SPHERE, size, STEEL, centre, sample["orientation"]),
            marker("pins", 0, LINE_LIST, (2.0 * thin, 0.0, 0.0), BLUE, points=pins),
            marker("plane", 0, CUBE, (8.0 * longest, 8.0 * longest, thin), GLASS, ground),
            *contact_markers(sample, (0.0, 0.0, 1.0), longest, (*ground[:2], -0.5 * longest)),
        ]
    }
