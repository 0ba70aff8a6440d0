"""Numbers of two discs that ranges of models are about, known before they meet."""

from bearing_twin.contact.validity import wave_transit


def thickness_over_radius(parameters) -> float:
    """Of each disc."""
    return parameters.disc.thickness / parameters.disc.radius


def speed_share(parameters) -> float:
    """Speed of each disc in the frame of both over that of waves in it."""
    material = parameters.disc.material
    return 0.5 * parameters.motion.speed * wave_transit(1.0, material.young_modulus, material.density)
