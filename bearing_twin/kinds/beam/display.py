"""The topics of a sphere on a beam: wrenches, the contact, frames and markers, as fields of messages.

The frame of the scene has its origin at one support, at the height of the upper surface at rest, x along the beam to
the other support and z against the motion of the sphere.
"""

import numpy as np

from bearing_twin.base.sample import Channel, Sample
from bearing_twin.contact.elasticity import ellipse
from bearing_twin.kinds.beam import SPHERE_ON_BEAM
from bearing_twin.kinds.beam.parameters import BEAM, BODY, SphereOnBeamScene
from bearing_twin.kinds.contract import PUBLISH, Output, Topic
from bearing_twin.kinds.topics import (
    BLUE,
    CUBE,
    LINE_STRIP,
    MARKER_ARRAY,
    SPHERE,
    STEEL,
    ContactPair,
    load_marker,
    marker,
    pair_topics,
    placed,
    times,
)
from bearing_twin.kinds.views import DARK, ORANGE, Arrows, Bar, Enlarged, Look, Solid, View, curves, energies, view_of

FRAME = SPHERE_ON_BEAM.frame
UP, ALONG = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
DEFLECTION_SCALE = 20.0  # of the beam in the markers


def topics(parameters: SphereOnBeamScene) -> tuple[Topic, ...]:
    """The topics of a sphere on a beam."""
    texts = {
        BODY: "on the sphere, by the beam, about its centre",
        BEAM: "on the beam, by the sphere, about the point of impact at rest; not by the supports",
    }
    return (
        *pair_topics(FRAME, pair_of, texts, solids),
        Topic("markers", MARKER_ARRAY, PUBLISH, marker_fields, "sphere and beam, for display", FRAME),
    )


def pair_of(parameters: SphereOnBeamScene, sample: Sample) -> ContactPair:
    """The contact, half-way between the surfaces; on the beam the point of impact at rest."""
    radius, load, along = parameters.sphere.radius, sample["normal_load"], parameters.blow.point * parameters.beam.span
    touch = -0.5 * (sample["sphere_position"] + sample["deflection"][..., 0])
    positions = (times(height, UP) + along * ALONG for height in (radius - sample["sphere_position"], 0.0, touch))
    patch = ellipse(0.5 / radius, 0.5 / radius, parameters.modulus, load)
    return ContactPair(*positions, -UP, sample["approach"], load, *patch, major_axis=ALONG)


def solids(parameters: SphereOnBeamScene) -> dict[str, list[dict]]:
    """The bodies as markers in their frames; that of the beam stands at the point of impact, on its surface."""
    beam = parameters.beam
    middle = (0.5 - parameters.blow.point) * beam.span, 0.0, -0.5 * beam.height
    return {
        BODY: [marker("sphere", 0, SPHERE, (2.0 * parameters.sphere.radius,) * 3, STEEL)],
        BEAM: [marker("beam", 0, CUBE, (beam.span, beam.width, beam.height), BLUE, middle)],
    }


def marker_fields(output: Output) -> dict:
    """visualization_msgs/MarkerArray: the sphere, the beam's line with its deflection enlarged, and the force."""
    parameters, sample = output.parameters, output.sample
    span, shape, (sphere,) = parameters.beam.span, sample["shape"], solids(output.parameters)[BODY]
    # The sphere follows the enlarged beam, so that it is drawn on it while they touch.
    height = parameters.sphere.radius - DEFLECTION_SCALE * sample["sphere_position"]
    line = times(-DEFLECTION_SCALE * shape, UP) + times(np.linspace(0.0, span, shape.shape[-1]), ALONG)
    foot, note = (0.5 * span, 0.0, 0.2 * span), f", deflections x {DEFLECTION_SCALE:g}"
    return {
        "markers": [
            placed(sphere, times(height, UP) + parameters.blow.point * span * ALONG),
            marker("beam", 0, LINE_STRIP, (0.02 * span, 0.0, 0.0), BLUE, points=line),
            load_marker(sample["normal_load"], span / 6.0, foot, note),
        ]
    }


REACH, ARROW = 0.06, 0.22  # of the span: greatest drawn deflection, longest arrow
ENERGIES = (("kinetic_energy", "sphere"), ("beam_energy", "beam"), ("elastic_energy", "in the contact"))


def view(parameters, channels) -> View:
    """x along the beam from its middle, y against the sphere's motion; the upper face at rest is y = 0."""
    beam, radius, point = parameters.beam, parameters.sphere.radius, parameters.blow.point
    impact_x = (point - 0.5) * beam.span
    drawn = (
        Channel("sphere_rest", "m", (3,), "centre of the sphere at the first touch"),
        Channel("sphere_way", "m", (3,), "from there"),
        Channel("blow", "N", (3,), "on the beam by the sphere"),
        Channel("above", "m", (3,), "where the arrow of the force ends"),
    )
    watched = watched_points(parameters)

    def points(title, unit, name):
        return curves(title, unit, *((name, words, column) for column, words in watched.items()))

    return view_of(
        channels,
        drawn,
        rows=lambda sample: _rows(sample, impact_x, radius, impact_x + 1.25 * radius),
        panels=(
            curves("Contact force", "N", ("normal_load", "force")),
            points("Deflection, along the sphere's motion", "m", "deflection"),
            points("Bending stress of the lower fibre, tension positive", "Pa", "bending_stress"),
            curves("Velocity of the sphere, along its motion before", "m/s", ("sphere_velocity", "sphere")),
            energies(*ENERGIES),
        ),
        solids=(
            Solid("sphere", "sphere", {"ellipsoid": (radius,) * 3}, position="sphere_rest", deviation="sphere_way"),
            Solid("supports", "supports", _supports(beam), DARK),
        ),
        marks=(
            Bar("beam", "beam", "shape", beam.span, beam.width, beam.height),
            Arrows("force", "force on the beam", "N", "blow", ARROW * beam.span, (ORANGE,), point="above"),
        ),
        look=Look(
            0.5 * beam.span,
            (0.22, 0.3, 1.0),
            middle=(0.0, 0.6 * radius, 0.0),
            at_start=((0.5 * beam.span, 0.0, 0.6 * radius), 0.5 * beam.span),
        ),
        enlarged=Enlarged("deflection and approach", ("shape",), REACH * beam.span),
        words="The sphere's way is as much enlarged as the deflection, so that contact and gap are seen.",
    )


def watched_points(parameters) -> dict[int, str]:
    """Columns of deflection and stress that are shown, and where on the beam each is; the point of impact once."""
    shares, point = parameters.outputs.points, parameters.blow.point
    return {0: "impact"} | {k + 1: f"{share:g} of the span" for k, share in enumerate(shares) if share != point}


def _rows(sample, impact_x: float, radius: float, offset: float) -> dict[str, np.ndarray]:
    """The arrow of the force stands at `offset` from the sphere, which would hide it."""
    sphere_centre, way, blow, above = (np.zeros((len(sample["normal_load"]), 3)) for _ in range(4))
    sphere_centre[:, 0], sphere_centre[:, 1] = impact_x, radius
    way[:, 1] = -sample["sphere_position"]
    blow[:, 1] = -sample["normal_load"]
    above[:, 0], above[:, 1] = offset, 0.1 * radius
    return {
        "sphere_rest": sphere_centre,
        "sphere_way": way,
        "blow": blow,
        "above": above,
    }


def _supports(beam) -> dict:
    """A wedge under each end of the span."""
    low, wide = -beam.height, 0.6 * beam.height
    wedges = [
        [(end, low), (end - wide, low - 1.4 * wide), (end + wide, low - 1.4 * wide)]
        for end in (-0.5 * beam.span, 0.5 * beam.span)
    ]
    return {"extruded": {"outlines": wedges, "low": -0.5 * beam.width, "high": 0.5 * beam.width}}
