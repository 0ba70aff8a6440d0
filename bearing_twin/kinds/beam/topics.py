"""The topics of a sphere on a beam: wrenches, the contact, frames and markers, as fields of messages.

The frame of the scene has its origin at one support, at the height of the upper surface at rest, x along the beam to
the other support and z against the blow.
"""

import numpy as np

from bearing_twin.base.sample import Sample, Wrench
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.beam.parameters import BEAM, BODY, SphereOnBeamScene
from bearing_twin.kinds.beam.row import SPHERE_ON_BEAM
from bearing_twin.kinds.contract import PUBLISH, Output, Topic
from bearing_twin.kinds.markers import BLUE, GREEN, LINE_STRIP, SPHERE, STEEL, TEXT, marker
from bearing_twin.kinds.topics import MARKER_ARRAY, body_topics, contacts_topic, one_contact, opposed
from bearing_twin.kinds.urdf import LinkShape, box, sphere

FRAME = SPHERE_ON_BEAM.frame
STILL = (0.0, 0.0, 0.0)
DEFLECTION_SCALE = 20.0  # of the beam in the markers


def topics(parameters: SphereOnBeamScene) -> tuple[Topic, ...]:
    """The topics of a sphere on a beam."""
    texts = {
        BODY: "on the sphere, by the beam, about its centre",
        BEAM: "on the beam, by the sphere, about the point of impact at rest; not by the supports",
    }
    return (
        *body_topics(FRAME, wrenches, origins, texts, solids),
        contacts_topic(FRAME, contacts, "the contact, as arrays of one row"),
        Topic("markers", MARKER_ARRAY, PUBLISH, marker_fields, "sphere and beam to look at", FRAME),
    )


def origins(parameters: SphereOnBeamScene, sample: Sample) -> dict[str, np.ndarray]:
    """Centre of the sphere and point of impact at rest [m]."""
    along = parameters.blow.point * parameters.beam.span
    height = parameters.sphere.radius - float(sample["sphere_position"])
    return {BODY: np.array([along, 0.0, height]), BEAM: np.array([along, 0.0, 0.0])}


def solids(parameters: SphereOnBeamScene) -> dict[str, list[LinkShape]]:
    """The bodies for `robot_description`; the frame of the beam stands at the point of impact, on its surface."""
    beam = parameters.beam
    middle = (0.5 - parameters.blow.point) * beam.span
    shape = box((beam.span, beam.width, beam.height), BLUE, (middle, 0.0, -0.5 * beam.height))
    return {BODY: [sphere(parameters.sphere.radius, STEEL)], BEAM: [shape]}


def wrenches(parameters: SphereOnBeamScene, sample: Sample) -> list[Wrench]:
    """On sphere and beam by each other; the force goes through both points."""
    return opposed(BODY, BEAM, "centre, point of impact", (0.0, 0.0, float(sample["normal_load"])), STILL, STILL)


def contacts(parameters: SphereOnBeamScene, sample: Sample) -> dict:
    """The fields of Contacts: the beam acts on the sphere, half-way between the surfaces."""
    sphere, load = parameters.sphere, float(sample["normal_load"])
    curvature, modulus = 0.5 / sphere.radius, effective_modulus(sphere.material, parameters.beam.material)
    semi_major, semi_minor, pressure = ellipse(curvature, curvature, modulus, load)
    middle = -0.5 * (float(sample["sphere_position"]) + float(sample["deflection"][0]))
    return one_contact(
        BODY, BEAM,
        approach=float(sample["approach"]), normal_load=load, semi_major=semi_major, semi_minor=semi_minor,
        peak_pressure=pressure, point=(parameters.blow.point * parameters.beam.span, 0.0, middle),
        normal=(0.0, 0.0, 1.0), major_axis=(1.0, 0.0, 0.0),
    )  # fmt: skip


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the sphere, the beam's line with its deflection enlarged, and the force."""
    parameters, sample = output.parameters, output.sample
    span, radius = parameters.beam.span, parameters.sphere.radius
    place = output.once(origins)[BODY]
    # The sphere follows the enlarged beam, so that it is drawn on it while they touch.
    place = place + np.array([0.0, 0.0, (1.0 - DEFLECTION_SCALE) * float(sample["sphere_position"])])
    shape = sample["shape"]
    line = np.zeros((len(shape), 3))
    line[:, 0], line[:, 2] = np.linspace(0.0, span, len(shape)), -DEFLECTION_SCALE * shape
    text = f"{float(sample['normal_load']):.4g} N, deflections x {DEFLECTION_SCALE:g}"
    return {
        "markers": [
            marker("sphere", 0, SPHERE, (2.0 * radius,) * 3, STEEL, place),
            marker("beam", 0, LINE_STRIP, (0.02 * span, 0.0, 0.0), BLUE, points=line),
            marker("force", 0, TEXT, (0.0, 0.0, 0.05 * span), GREEN, (0.5 * span, 0.0, 0.2 * span), text=text),
        ]
    }
