"""Limits of the theory of elastic contact: each warning is one sentence, or None."""

import math

WIDEST_ELLIPSE = 0.3  # tuned: the load is then 1 % less
"""Semi-axis over radius of the body above which the half-space is a rough picture.

Of a sphere, against `reference.half_space` (`tests/test_calculator.py`).
"""

FELT = 0.21  # tuned: against half-spaces across the true gap
"""Relative error of a contact's load at an approach, over that of the gap at the edge of the contact ellipse.

Against `reference.half_space`, of contact ellipses up to half the ball's radius in grooves of 0.52 to 0.5232
(`tests/test_calculator.py`).
"""

FEWEST_TRANSITS = 5.0  # tuned: a quarter of the energy goes into waves
"""Transits of waves through a body below which a contact leaves much energy in vibration.

No source: a sphere of steel that meets a half-space in five transits leaves a quarter of its energy in waves by
Hunter's estimate (`hertz_impact.restitution_lost_on_half_space`; `tests/test_calculator.py`).
"""

COUNTED, LEVEL = 0.1, 1e-9
"""Share of the greatest load of a ball, below which it says nothing of the bearing; an angle [rad] that is 0."""

LAW_TOLERANCE = 0.005
"""Relative error of a law's load that paper 1, section 4, claims for the volumetric law: more is named."""


def patch_radius(load: float, radius: float, modulus: float) -> float:
    """Radius [m] of a round contact patch, by relative radius [m] and effective modulus [Pa] of the bodies (Hertz)."""
    return (0.75 * load * radius / modulus) ** (1.0 / 3.0)


def pressure_warning(peak_pressure: float, yield_pressure: float | None) -> str | None:
    """Warning of a peak pressure [Pa]: beyond the `yield_pressure` of the two bodies (None: not known)."""
    if yield_pressure is None or peak_pressure <= yield_pressure:
        return None
    return (
        f"peak pressure {peak_pressure:.3g} Pa is beyond the yield pressure {yield_pressure:.3g} Pa: "
        "the bodies yield, the elastic result does not hold"
    )


def width_warning(semi_axis: float, size: float, body: str = "radius") -> str | None:
    """Warning of a semi-axis or half-width [m] against the size [m] of the body it lies on, named by `body`."""
    if semi_axis <= WIDEST_ELLIPSE * size:
        return None
    return (
        f"a semi-axis of {semi_axis:.3g} m is above {WIDEST_ELLIPSE:g} of the {body} {size:.3g} m: "
        "the half-space of Hertz's theory is a rough approximation"
    )


def gap_error(semi_axis, ball_radius: float, groove_radius):
    """Relative error of the gap between ball and groove at the edge of their contact, taken for a parabola (Hertz).

    FELT times it is that of the load at the same approach, which is listed among the errors of the model.

    Both circles go on by x^4 / 8 R^3: with 1/R the curvatures (radii in m), the next term over the first is
    x^2 (1/R_ball^2 + 1/(R_ball R_groove) + 1/R_groove^2) / 4 at the semi-axis x [m].
    """
    ball, groove = 1.0 / ball_radius, 1.0 / groove_radius
    return 0.25 * semi_axis**2 * (ball**2 + ball * groove + groove**2)


def shoulder_warning(nominal_angle: float, angles, loads) -> str | None:
    """Warning of balls that carry load where one ring of an angular contact bearing has no shoulder.

    `nominal_angle` [rad] is the one without load, 0 of a deep groove; `angles` [rad] those on the outer raceway, above
    0 on the side of the shoulders, and `loads` [N] those on the inner one. Balls with less than COUNTED of the greatest
    do not count.
    """
    enough = COUNTED * max(loads)
    bearing = (float(angle) for angle, load in zip(angles, loads, strict=True) if load > enough)
    least = min(bearing, default=math.inf) + 0.0  # without -0
    if nominal_angle <= 0.0 or least > LEVEL:
        return None
    return (
        f"balls carry load at a contact angle of {least:.3g} rad: where geometry.contact_angle is above 0 one ring "
        "has no shoulder on that side, and a real bearing comes apart; an axial load must keep the angles above 0"
    )


def law_warning(law: str, error: float, axis_ratio: float) -> str | None:
    """Warning of a law whose load has an `error` (relative) against exact Hertz at this semi-axis ratio b/a."""
    if abs(error) <= LAW_TOLERANCE:
        return None
    return f"law {law} differs by {100.0 * error:+.2g} % from exact Hertz at b/a = {axis_ratio:.3g}: more than 0.5 %"


def wave_transit(size: float, young_modulus: float, density: float) -> float:
    """Time [s] a wave takes through a body of `size` [m] at sqrt(E/density)."""
    return size / math.sqrt(young_modulus / density)


def wave_warning(contact_duration: float, transit: float) -> str | None:
    """Warning of the duration [s] of a contact against a wave's `transit` [s] of the body, which it must outlast.

    Hertz's static deformation needs a contact many transits long (Love 1927).
    """
    if contact_duration >= FEWEST_TRANSITS * transit:
        return None
    return (
        f"a contact of {contact_duration:.3g} s is shorter than {FEWEST_TRANSITS:g} times the {transit:.3g} s a wave "
        "takes through the body: elastic waves carry off energy, which Hertz's theory neglects"
    )


def gathered(*warnings: str | None) -> list[str]:
    """The warnings that are there, each once."""
    return list(dict.fromkeys(warning for warning in warnings if warning))
