"""What lies outside the theory of elastic contact: each doubt is one sentence, or None where there is no doubt."""

import math

YIELD_ONSET = 1.6
"""Peak pressure over yield strength at which a Hertz contact begins to yield (Johnson, Contact Mechanics, 6.1)."""

WIDEST_ELLIPSE = 0.1
"""Semi-axis over radius of the body above which the half-space is a rough picture."""

WIDEST_IN_GROOVE = 0.15
"""The same along a groove's meridian: ball bearings pass 0.1 under ordinary loads; its square, 2 %, is the error."""

LAW_TOLERANCE = 0.005
"""Relative error of a law's load that paper 1, section 4, claims for the volumetric law: more is named."""

YIELD_STRENGTH = {"steel": 2.0e9, "aluminium": 2.8e8}
"""Yield strength [Pa] of named materials as used here: hardened bearing steel 100Cr6, aluminium 6061-T6."""


def pressure_doubt(peak_pressure: float, yield_strength: float | None) -> str | None:
    """Doubt about a peak pressure [Pa]: above 1.6 times the yield strength [Pa] of the weaker body it yields."""
    if yield_strength is None or peak_pressure <= YIELD_ONSET * yield_strength:
        return None
    return (
        f"peak pressure {peak_pressure:.3g} Pa is above 1.6 times the yield strength {yield_strength:.3g} Pa: "
        "the bodies yield, the elastic result is formal"
    )


def width_doubt(semi_axis: float, radius: float, limit: float = WIDEST_ELLIPSE) -> str | None:
    """Doubt about an ellipse's semi-axis [m] against the radius [m] of the body it lies on."""
    if semi_axis <= limit * radius:
        return None
    return (
        f"a semi-axis of {semi_axis:.3g} m is above {limit:g} of the radius {radius:.3g} m: "
        "the half-space of Hertz's theory is a rough picture"
    )


def law_doubt(law: str, error: float, axis_ratio: float) -> str | None:
    """Doubt about a law whose load is off exact Hertz by `error` (relative) at this semi-axis ratio b/a."""
    if abs(error) <= LAW_TOLERANCE:
        return None
    return f"law {law} is {100.0 * error:+.2g} % off exact Hertz at b/a = {axis_ratio:.3g}: outside its curve of 0.5 %"


def wave_doubt(contact_duration: float, size: float, young_modulus: float, density: float) -> str | None:
    """Doubt about an impact of `contact_duration` [s] on a body of `size` [m]: waves must cross it many times.

    The transit there and back at sqrt(E/density); Hertz's static deformation needs a longer contact (Love 1927).
    """
    transit = 2.0 * size / math.sqrt(young_modulus / density)
    if contact_duration > transit:
        return None
    return (
        f"the contact lasts {contact_duration:.3g} s, shorter than a wave's way through the body and back, "
        f"{transit:.3g} s: vibration takes a share of the energy that Hertz's theory does not know"
    )


def gathered(*doubts: str | None) -> list[str]:
    """The doubts that are there, each once."""
    return list(dict.fromkeys(doubt for doubt in doubts if doubt))
