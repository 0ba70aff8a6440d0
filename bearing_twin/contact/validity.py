"""What lies outside the theory of elastic contact: each doubt is one sentence, or None where there is no doubt."""

import math

WIDEST_ELLIPSE = 0.1
"""Semi-axis over radius of the body above which the half-space is a rough picture."""

WIDEST_IN_GROOVE = 0.15
"""The same along a groove's meridian: ball bearings pass 0.1 under ordinary loads; its square, 2 %, is the error."""

FEWEST_TRANSITS = 5.0
"""Transits of waves through a body below which a contact leaves much energy in vibration."""

LAW_TOLERANCE = 0.005
"""Relative error of a law's load that paper 1, section 4, claims for the volumetric law: more is named."""


def spot_radius(load: float, radius: float, modulus: float) -> float:
    """Radius [m] of the round spot between bodies of this relative radius [m] and effective modulus [Pa] (Hertz)."""
    return (0.75 * load * radius / modulus) ** (1.0 / 3.0)


def pressure_doubt(peak_pressure: float, yield_pressure: float | None) -> str | None:
    """Doubt about a peak pressure [Pa]: beyond the `yield_pressure` of the two bodies (None: not known)."""
    if yield_pressure is None or peak_pressure <= yield_pressure:
        return None
    return (
        f"peak pressure {peak_pressure:.3g} Pa is beyond the yield pressure {yield_pressure:.3g} Pa: "
        "the bodies yield, the elastic result is formal"
    )


def width_doubt(semi_axis: float, size: float, limit: float = WIDEST_ELLIPSE, body: str = "radius") -> str | None:
    """Doubt about a semi-axis or half-width [m] against the size [m] of the body it lies on, named by `body`."""
    if semi_axis <= limit * size:
        return None
    return (
        f"a semi-axis of {semi_axis:.3g} m is above {limit:g} of the {body} {size:.3g} m: "
        "the half-space of Hertz's theory is a rough picture"
    )


def law_doubt(law: str, error: float, axis_ratio: float) -> str | None:
    """Doubt about a law whose load is off exact Hertz by `error` (relative) at this semi-axis ratio b/a."""
    if abs(error) <= LAW_TOLERANCE:
        return None
    return f"law {law} is {100.0 * error:+.2g} % off exact Hertz at b/a = {axis_ratio:.3g}: outside its curve of 0.5 %"


def wave_transit(size: float, young_modulus: float, density: float) -> float:
    """Time [s] a wave takes through a body of `size` [m] at sqrt(E/density)."""
    return size / math.sqrt(young_modulus / density)


def wave_doubt(contact_duration: float, transit: float) -> str | None:
    """Doubt about the duration [s] of a contact against a wave's `transit` [s] of the body, which it must outlast.

    Hertz's static deformation needs a contact many transits long (Love 1927).
    """
    if contact_duration >= FEWEST_TRANSITS * transit:
        return None
    return (
        f"a contact of {contact_duration:.3g} s is shorter than {FEWEST_TRANSITS:g} times the {transit:.3g} s a wave "
        "takes through the body: vibration takes a share of the energy that Hertz's theory does not know"
    )


def gathered(*doubts: str | None) -> list[str]:
    """The doubts that are there, each once."""
    return list(dict.fromkeys(doubt for doubt in doubts if doubt))
