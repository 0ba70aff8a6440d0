"""The view of a sphere on a beam: both with enlarged displacements, force, deflection and stress."""

import numpy as np

from bearing_twin.base.sample import Channel
from bearing_twin.kinds.views import DARK, ORANGE, Arrows, Bar, Enlarged, Look, Solid, View, curves, picked

REACH, ARROW = 0.06, 0.22  # of the span: greatest drawn deflection, longest arrow
TAKEN = (
    *("approach", "normal_load", "sphere_position", "sphere_velocity", "deflection", "bending_stress", "shape"),
    *("kinetic_energy", "beam_energy", "elastic_energy"),
)
ENERGIES = (("kinetic_energy", "sphere"), ("beam_energy", "beam"), ("elastic_energy", "in the contact"))


def view(facts, channels) -> View:
    """x along the beam from its middle, y against the sphere's motion; the upper face at rest is y = 0."""
    parameters = facts.scene.parameters
    beam, radius, point = parameters.beam, parameters.sphere.radius, parameters.blow.point
    struck = (point - 0.5) * beam.span
    series = (
        *picked(channels, TAKEN),
        Channel("sphere_rest", "m", (3,), "centre of the sphere at the first touch"),
        Channel("sphere_way", "m", (3,), "from there"),
        Channel("blow", "N", (3,), "on the beam by the sphere"),
        Channel("above", "m", (3,), "where the arrow of the force ends"),
    )
    watched = watched_points(parameters)

    def points(title, unit, name):
        return curves(title, unit, *((name, words, column) for column, words in watched.items()))

    return View(
        series=series,
        rows=lambda sample: _rows(sample, struck, radius, struck + 1.25 * radius),
        panels=(
            curves("Contact force", "N", ("normal_load", "force")),
            points("Deflection, along the sphere's motion", "m", "deflection"),
            points("Bending stress of the lower fibre, tension positive", "Pa", "bending_stress"),
            curves("Velocity of the sphere, along its motion before", "m/s", ("sphere_velocity", "sphere")),
            curves("Energy", "J", *ENERGIES),
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


def _rows(sample, struck: float, radius: float, beside: float) -> dict[str, np.ndarray]:
    """The arrow of the force stands `beside` the sphere, which would hide it."""
    rest, way, blow, above = (np.zeros((len(sample["normal_load"]), 3)) for _ in range(4))
    rest[:, 0], rest[:, 1] = struck, radius
    way[:, 1] = -sample["sphere_position"]
    blow[:, 1] = -sample["normal_load"]
    above[:, 0], above[:, 1] = beside, 0.1 * radius
    return {name: sample[name] for name in TAKEN} | {
        "sphere_rest": rest,
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
