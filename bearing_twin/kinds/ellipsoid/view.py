"""The view of an ellipsoid on a plane: the body, the way of its centre, the contact and the load in it."""

from collections.abc import Callable

import numpy as np

from bearing_twin.base.sample import Channel, Sample
from bearing_twin.kinds.views import (
    GLASS,
    ORANGE,
    Arrows,
    CurvePanel,
    Look,
    Solid,
    Spots,
    Trail,
    View,
    along_axes,
    curves,
    picked,
)

ARROW, SPOT = 1.6, 0.35  # longest arrow, greatest drawn semi-axis of a contact; in sizes of the body
TAKEN = (
    *("position", "orientation", "second_position", "second_orientation", "contact_point", "major_axis", "slip"),
    *("semi_major", "semi_minor", "peak_pressure", "normal_load", "kinetic_energy", "potential_energy"),
    *("elastic_energy", "dissipated_viscous", "dissipated_friction"),
)

STORED = (("kinetic_energy", "kinetic"), ("potential_energy", "of height"), ("elastic_energy", "in the contact"))
LOST = (("dissipated_viscous", "lost to viscosity"), ("dissipated_friction", "lost to friction"))
"""Channels and words of the energies, in the order in which they are shown."""


def view(facts, channels) -> View:
    """The scene's axes, z up from the plane."""
    axes, start = facts.scene.parameters.body.semi_axes, facts.scene.parameters.start
    high = max(start.height, 0.0)
    solids = (
        Solid("plane", "plane", {"ground": {}}, GLASS, opacity=0.5),
        Solid("body", "ellipsoid", {"ellipsoid": axes}, position="position", orientation="orientation", marked=True),
    )
    upward = (0.0, 0.0, 1.0)
    amid = 0.5 * high + max(axes)  # from the plane to the top of the body
    seen = (0.0, 0.0, amid), amid + 0.15 * max(axes)
    follows = "body" if travels(axes, start) else ""
    look = Look(1.15 * max(axes), (0.35, -1.0, 0.3), upward, around=("position",), at_start=seen, follows=follows)
    height = curves("Height of the centre", "m", ("position", "above the plane", 2))
    return contact_view(
        channels, solids, max(axes), look, height, lambda sample: np.full(sample["position"].shape, upward)
    )


def travels(axes, start) -> bool:
    """True if a body with these semi-axes [m] that starts like this moves along a level plane that it falls on."""
    return min(axes) != max(axes) or any(start.velocity[:2]) or any(start.angular_velocity)


def contact_view(
    channels,
    solids: tuple[Solid, ...],
    size: float,
    look: Look,
    motion: CurvePanel,
    push: Callable[[Sample], np.ndarray],
) -> View:
    """The view of a body of that `size` [m] on another: what an ellipsoid on a plane and two bodies have in common.

    `push` gives the direction (count, 3) in which the normal load acts on the first body.
    """
    series = picked(channels, TAKEN)
    return View(
        series=(*series, Channel("push", "1", (3,), "direction of the normal load on the first body")),
        rows=lambda sample: {one.name: sample[one.name] for one in series} | {"push": push(sample)},
        panels=(
            curves("Normal load", "N", ("normal_load", "normal load")),
            motion,
            curves("Peak pressure", "Pa", ("peak_pressure", "peak pressure")),
            curves("Slip at the contact", "m/s", *along_axes("slip")),
            curves("Energy", "J", *STORED, *LOST),
        ),
        solids=solids,
        marks=(
            Trail("way", "way of the centre", "position"),
            Arrows(
                "load", "normal load on the body", "N", "push", ARROW * size, (ORANGE,), "normal_load",
                point="contact_point",
            ),
            Spots(
                "contact", "contact", "push", "semi_major", "semi_minor", "peak_pressure", SPOT * size,
                major_axis="major_axis", point="contact_point",
            ),
        ),
        look=look,
        words="Bodies and places are true to scale.",
    )  # fmt: skip
