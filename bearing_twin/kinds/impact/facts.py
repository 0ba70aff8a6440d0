"""Numbers and conditions of two bodies that meet that rules and ranges of models are about, known before they do."""

from bearing_twin.contact.validity import wave_transit
from bearing_twin.kinds.impact.derived import is_elastic, is_steady, sphere_law


def is_measured(parameters) -> bool:
    """True if the coefficient of two spheres is given."""
    return sphere_law(parameters) == "measured"


def spheres_closed(parameters) -> bool:
    """True if closed forms give all that is wanted of two spheres."""
    contact = parameters.contact
    return is_elastic(contact) or (parameters.wanted.outputs == "peaks" and not is_steady(contact))


def thickness_over_radius(parameters) -> float:
    """Of each disc."""
    return parameters.disc.thickness / parameters.disc.radius


def speed_share(parameters) -> float:
    """Speed of each disc in the frame of both over that of waves in it."""
    material = parameters.disc.material
    return 0.5 * parameters.motion.speed * wave_transit(1.0, material.young_modulus, material.density)
