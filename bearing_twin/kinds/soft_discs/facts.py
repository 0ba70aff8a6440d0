"""Numbers of soft discs that ranges of models are about, known before they meet."""

from bearing_twin.kinds.soft_discs.derived import bodies_of, capped_ratio, wall_speed, wave_speed


def speed_share(parameters) -> float:
    """Speed of the disc that comes fastest for its stiffness, in the frame of both, over that of waves in it."""
    return max(wall_speed(one) / wave_speed(one) for one in bodies_of(parameters).values())


def thickness_over_radius(parameters) -> float:
    """Of the smaller disc."""
    return max(one.disc.thickness / one.disc.radius for one in bodies_of(parameters).values())


def poisson_ratio_in_strain(parameters) -> float | None:
    """The greatest Poisson's ratio, as Lame's first parameter takes it; None in plane stress."""
    if parameters.plane != "strain":
        return None
    return max(capped_ratio(one) for one in bodies_of(parameters).values())
