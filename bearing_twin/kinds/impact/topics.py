"""The topics of two colliding bodies: wrenches, the contact, frames and markers, as fields of messages.

The frame of the scene has x along the line of impact, forward, and its origin where the centre of the first
body starts; the axes of discs lie along z.
"""

from functools import partial

import numpy as np

from bearing_twin.base.sample import Sample, Wrench
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.contract import PUBLISH, Output, Topic
from bearing_twin.kinds.impact.derived import strip_of
from bearing_twin.kinds.impact.parameters import FIRST, SECOND, TwoDiscsScene
from bearing_twin.kinds.impact.row import TWO_DISCS, TWO_SPHERES
from bearing_twin.kinds.markers import BLUE, CYLINDER, GREEN, ORANGE, SPHERE, TEXT, marker
from bearing_twin.kinds.topics import MARKER_ARRAY, body_topics, contacts_topic, one_contact, opposed
from bearing_twin.kinds.urdf import LinkShape, cylinder, sphere

STILL = (0.0, 0.0, 0.0)


def topics(link: str, parameters) -> tuple[Topic, ...]:
    """The topics of two spheres or two discs."""
    texts = {body: f"on the {body} body, by the other, about its centre" for body in (FIRST, SECOND)}
    return (
        *body_topics(link, wrenches, origins, texts, solids),
        contacts_topic(link, contacts, "the contact, as arrays of one row"),
        Topic("markers", MARKER_ARRAY, PUBLISH, marker_fields, "both bodies", link),
    )


spheres_topics = partial(topics, TWO_SPHERES.frame)
discs_topics = partial(topics, TWO_DISCS.frame)


def radii(parameters) -> tuple[float, float]:
    """Radii [m] of the two bodies."""
    if isinstance(parameters, TwoDiscsScene):
        return parameters.disc.radius, parameters.disc.radius
    return parameters.first.radius, parameters.second.radius


def origins(parameters, sample: Sample) -> dict[str, np.ndarray]:
    """Centres of the two bodies [m]."""
    first, second = sample["displacement"]
    apart = sum(radii(parameters)) + parameters.motion.gap
    return {FIRST: np.array([first, 0.0, 0.0]), SECOND: np.array([apart + second, 0.0, 0.0])}


def solids(parameters) -> dict[str, list[LinkShape]]:
    """The bodies for `robot_description`."""
    colors = zip((FIRST, SECOND), radii(parameters), (ORANGE, BLUE), strict=True)
    if isinstance(parameters, TwoDiscsScene):
        return {body: [cylinder(radius, parameters.disc.thickness, color)] for body, radius, color in colors}
    return {body: [sphere(radius, color)] for body, radius, color in colors}


def wrenches(parameters, sample: Sample) -> list[Wrench]:
    """On each body by the other, about its centre: the force goes through both."""
    return opposed(FIRST, SECOND, "centre", (-float(sample["normal_load"]), 0.0, 0.0), STILL, STILL)


def contacts(parameters, sample: Sample) -> dict:
    """The fields of Contacts: the second body acts on the first, half-way between the surfaces."""
    places, sizes, load = origins(parameters, sample), radii(parameters), float(sample["normal_load"])
    middle = 0.5 * (places[FIRST][0] + sizes[0] + places[SECOND][0] - sizes[1])
    semi_major, semi_minor, pressure = _patch(parameters, load)
    return one_contact(
        FIRST, SECOND,
        approach=float(sample["approach"]), normal_load=load, semi_major=semi_major, semi_minor=semi_minor,
        peak_pressure=pressure, point=(middle, 0.0, 0.0), normal=(-1.0, 0.0, 0.0), major_axis=(0.0, 0.0, 1.0),
    )  # fmt: skip


def _patch(parameters, load: float) -> tuple[float, float, float]:
    """Semi-axes [m] and peak pressure [Pa] by Hertz, of discs half the length and half the width of the line."""
    if load <= 0.0:
        return STILL
    if isinstance(parameters, TwoDiscsScene):
        return 0.5 * parameters.disc.thickness, *strip_of(parameters.disc, load)
    curvature = 0.5 * sum(1.0 / radius for radius in radii(parameters))
    return tuple(
        ellipse(curvature, curvature, effective_modulus(parameters.first.material, parameters.second.material), load)
    )


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: both bodies and, as text, the force between them."""
    parameters, sample = output.parameters, output.sample
    discs = isinstance(parameters, TwoDiscsScene)
    rows = []
    for number, (place, radius, color) in enumerate(
        zip(output.once(origins).values(), radii(parameters), (ORANGE, BLUE), strict=True)
    ):
        length = parameters.disc.thickness if discs else 2.0 * radius
        size = (2.0 * radius, 2.0 * radius, length)
        rows.append(marker("bodies", number, CYLINDER if discs else SPHERE, size, color, place))
    height = 0.3 * max(radii(parameters))
    place = (radii(parameters)[0], 1.3 * max(radii(parameters)), 0.0)
    text = f"{float(sample['normal_load']):.4g} N"
    rows.append(marker("force", 0, TEXT, (0.0, 0.0, height), GREEN, place, text=text))
    return {"markers": rows}
