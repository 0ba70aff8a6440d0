"""One Hertz contact answered in full: any of load, approach, pressure, semi-axes or impact in, everything else out.

At fixed curvatures every quantity is a power of the load (approach ~ F^(2/3), semi-axes and pressure ~ F^(1/3)), so
the contact under 1 N gives all inverses in closed form.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import elliprd

from bearing_twin.base.errors import SceneError
from bearing_twin.contact import validity
from bearing_twin.contact.elasticity import (
    AXIS_RATIO_MIN,
    approaches_of_loads,
    axis_ratio,
    coefficient_from_circle,
    coefficient_of,
    curvature_ratio,
    elastic,
    ellipse,
    greatest_approaches,
    hertz_coefficient,
)
from bearing_twin.contact.hertz_impact import CONTACT_CONSTANT
from bearing_twin.contact.laws import HERTZIAN, LAWS, law_names
from bearing_twin.contact.materials import YIELD_ONSET, Material, effective_modulus
from bearing_twin.shapes import ball_in_groove

COMPARED = law_names("point", ("curvatures", "frozen", "stiffness", "state"))
"""The laws that are put side by side."""


class Gap(NamedTuple):
    """z = P x^2 + Q y^2 between undeformed bodies: P <= Q [1/m], and the least radius [m] of the two bodies."""

    curvature_small: float
    curvature_large: float
    least_radius: float


class LoadedContact(NamedTuple):
    """A loaded Hertz contact, exact; SI units."""

    approach: float
    normal_load: float
    semi_major: float
    semi_minor: float
    axis_ratio: float
    peak_pressure: float
    stiffness: float


class LawResult(NamedTuple):
    """A law's load [N] at the contact's approach, and its relative error against exact Hertz."""

    normal_load: float
    error: float


def gap_of_curvatures(small: float, large: float) -> Gap:
    """The gap with these coefficients P and Q [1/m]; raises SceneError where they make no ellipse."""
    if not (math.isfinite(small) and math.isfinite(large)):
        raise SceneError(f"curvatures {small:g} and {large:g} 1/m are not finite; give numbers in 1/m")
    if large <= 0.0 or small < 0.0:
        raise SceneError(
            f"curvatures {small:g} and {large:g} 1/m of the gap are not above zero: the bodies conform or overlap "
            "elsewhere and touch in no ellipse; a hollow must be wider than what lies in it"
        )
    if small == 0.0:
        raise SceneError(
            "the smaller curvature of the gap is zero: the bodies touch along a line, not in an ellipse; "
            "give at least one body a crown"
        )
    if small > large:
        raise SceneError(f"the smaller curvature {small:g} 1/m is above the larger, {large:g} 1/m; exchange the two")
    ratio = axis_ratio(small, large)
    if ratio < AXIS_RATIO_MIN:
        raise SceneError(
            f"the ellipse would have b/a = {ratio:.2g}, below {AXIS_RATIO_MIN:g}: this is a line, "
            "which is no contact of this calculator; give curvatures nearer to each other"
        )
    return Gap(small, large, 0.5 / large)


def gap_of_radii(first, second, angle: float = 0.0, hollow: tuple[bool, bool] = (False, False)) -> Gap:
    """The gap of two bodies by principal radii [m], each (along x, along y), math.inf for flat; raises SceneError.

    `hollow` marks directions in which the second body is hollow (its centre of curvature on the first body's side);
    `angle` [rad] turns the second body's principal directions about the normal. Half the sum and the difference of
    the relative curvatures follow Hertz (1882).
    """
    for radius in (*first, *second):
        if not radius > 0.0:
            raise SceneError(f"radius {radius:g} m must be above zero; give inf for a plane and mark a hollow as such")
    if not math.isfinite(angle):
        raise SceneError(f"the angle {angle:g} between the bodies must be a finite number of radians")
    x1, y1 = (1.0 / radius for radius in first)
    x2, y2 = (-1.0 / radius if dent else 1.0 / radius for radius, dent in zip(second, hollow, strict=True))
    total = 0.5 * (x1 + y1 + x2 + y2)
    d1, d2 = x1 - y1, x2 - y2
    difference = 0.5 * math.sqrt(max(d1 * d1 + d2 * d2 + 2.0 * d1 * d2 * math.cos(2.0 * angle), 0.0))
    if abs(math.sin(2.0 * angle)) < 1e-15:  # along the same directions nothing need be subtracted from a sum
        pair = (x1 + x2, y1 + y2) if abs(math.cos(angle)) > 0.5 else (x1 + y2, y1 + x2)
        small, large = 0.5 * min(pair), 0.5 * max(pair)
    else:
        small, large = 0.5 * (total - difference), 0.5 * (total + difference)
    gap = gap_of_curvatures(small, large)
    return gap._replace(least_radius=min(radius for radius in (*first, *second)))


def gap_in_groove(ball_diameter: float, pitch_diameter: float, conformity: float, side: float) -> Gap:
    """The gap of a ball at the bottom of its raceway, contact angle zero; `side` -1 inner, +1 outer ring."""
    radius, groove = 0.5 * ball_diameter, conformity * ball_diameter
    distance = 0.5 * pitch_diameter
    touching = ball_in_groove(distance, 0.0, radius, distance - side * (groove - radius), groove)
    gap = gap_of_curvatures(touching.curvature_small, touching.curvature_large)
    return gap._replace(least_radius=min(radius, groove))


def contact_under_load(gap: Gap, modulus: float, normal_load: float) -> LoadedContact:
    """The contact under `normal_load` [N] > 0 by exact Hertz; `modulus` [Pa] is E*."""
    coefficient = hertz_coefficient(gap.curvature_small, gap.curvature_large, modulus)
    approach = approaches_of_loads(coefficient, HERTZIAN, normal_load)
    patch = ellipse(gap.curvature_small, gap.curvature_large, modulus, normal_load)
    return LoadedContact(
        approach,
        normal_load,
        patch.semi_major,
        patch.semi_minor,
        axis_ratio(gap.curvature_small, gap.curvature_large),
        patch.peak_pressure,
        elastic(coefficient, HERTZIAN, approach).stiffness,
    )


POWERS = {"normal_load": 1.0, "approach": 1.5, "peak_pressure": 3.0, "semi_major": 3.0, "semi_minor": 3.0}
"""Quantities that may be specified, and the power of each that the load follows."""


def solve(gap: Gap, modulus: float, quantity: str, value: float) -> LoadedContact:
    """The contact in which `quantity`, a name in `POWERS`, has that value (SI, above zero); raises SceneError."""
    label = quantity.replace("_", " ")
    if not (math.isfinite(value) and value > 0.0):
        raise SceneError(f"{label} = {value:g} must be a finite number above zero")
    unit = contact_under_load(gap, modulus, 1.0)
    try:
        load = (value / getattr(unit, quantity)) ** POWERS[quantity]
        contact = contact_under_load(gap, modulus, load)._replace(**{quantity: value})
    except (OverflowError, ZeroDivisionError):
        contact = None
    if contact is None or not all(math.isfinite(number) and number > 0.0 for number in contact):
        raise SceneError(f"{label} = {value:g} leads beyond the range of double precision; give a realistic value")
    return contact


def impact(gap: Gap, modulus: float, speed: float, mass: float) -> tuple[LoadedContact, float]:
    """The greatest compression of an elastic impact and its duration [s]; `mass` [kg] is m1 m2/(m1 + m2).

    Energy: 2/5 c h^(5/2) = m v^2/2; duration 2.9433 h/v (Hertz 1882; paper 3, eq. 2, with the constant recomputed).
    """
    for name, value in (("speed", speed), ("mass", mass)):
        if not (math.isfinite(value) and value > 0.0):
            raise SceneError(f"{name} = {value:g} must be a finite number above zero")
    coefficient = hertz_coefficient(gap.curvature_small, gap.curvature_large, modulus)
    deepest = greatest_approaches(coefficient, HERTZIAN, mass, speed)
    contact = solve(gap, modulus, "approach", deepest)
    return contact, CONTACT_CONSTANT * contact.approach / speed


def laws_at(
    gap: Gap, modulus: float, approach: float, frozen_at: float = 1.0, stiffness: float | None = None
) -> dict[str, LawResult]:
    """Every law of `COMPARED` at this approach [m]; those that carry states, carried here from a circle.

    `constant` does not follow the curvatures: its coefficient is that of the gap of equal sqrt(PQ) whose ellipse has
    the b/a `frozen_at`. `linear` has the `stiffness` [N/m] given, else the slope of exact Hertz here. Raises SceneError
    for one outside [1e-6, 1], or a stiffness not above zero.
    """
    if not AXIS_RATIO_MIN <= frozen_at <= 1.0:
        raise SceneError(f"frozen_at = {frozen_at:g} must be a semi-axis ratio b/a from {AXIS_RATIO_MIN:g} to 1")
    if stiffness is not None and not (math.isfinite(stiffness) and stiffness > 0.0):
        raise SceneError(f"stiffness = {stiffness:g} must be a finite number of N/m above zero")
    small, large = gap.curvature_small, gap.curvature_large
    mean, stretch = math.sqrt(small * large), math.sqrt(curvature_ratio(frozen_at))
    exact = elastic(hertz_coefficient(small, large, modulus), HERTZIAN, approach)
    numbers = {
        "frozen": hertz_coefficient(mean / stretch, mean * stretch, modulus),
        "stiffness": exact.stiffness if stiffness is None else stiffness,
    }
    results = {}
    for name in COMPARED:
        row = LAWS[name]
        number = next((numbers[need] for need in row.needs if need in numbers), 0.0)
        if row.carries:
            coefficient = coefficient_from_circle(name, small, large, modulus)
        else:
            coefficient = coefficient_of(name, small, large, modulus, number)
        load = float(elastic(coefficient, row.power, approach).load)
        results[name] = LawResult(load, load / exact.load - 1.0)
    return results


def answer(
    gap: Gap,
    first: Material,
    second: Material,
    contact: LoadedContact,
    yield_strength: float | None,
    frozen_at: float = 1.0,
    stiffness: float | None = None,
) -> dict:
    """The contact with laws side by side, shear and warnings, by SI-suffixed keys; `yield_strength` [Pa] may be None.

    `frozen_at` and `stiffness` as in `laws_at`.
    """
    modulus = effective_modulus(first, second)
    laws = laws_at(gap, modulus, contact.approach, frozen_at, stiffness)
    patch = contact.semi_major, contact.semi_minor, contact.peak_pressure
    shears = [greatest_shear(*patch, body.poisson_ratio) for body in (first, second)]
    shear = max(shears, key=lambda shear: shear.stress)
    flags = validity.gathered(
        validity.pressure_warning(contact.peak_pressure, yield_strength and YIELD_ONSET * yield_strength),
        validity.width_warning(contact.semi_major, gap.least_radius),
        *(validity.law_warning(name, law.error, contact.axis_ratio) for name, law in laws.items() if LAWS[name].keeps),
    )
    return {
        "approach_m": contact.approach,
        "normal_load_n": contact.normal_load,
        "semi_major_m": contact.semi_major,
        "semi_minor_m": contact.semi_minor,
        "axis_ratio": contact.axis_ratio,
        "peak_pressure_pa": contact.peak_pressure,
        "stiffness_n_per_m": contact.stiffness,
        "max_shear_pa": shear.stress,
        "max_shear_depth_m": shear.depth,
        "curvature_small_per_m": gap.curvature_small,
        "curvature_large_per_m": gap.curvature_large,
        "effective_modulus_pa": modulus,
        "constant_frozen_at_axis_ratio": frozen_at,
        "laws": {name: {"normal_load_n": law.normal_load, "error": law.error} for name, law in laws.items()},
        "flags": flags,
    }


class Shear(NamedTuple):
    """Greatest shear stress on the axis [Pa] and its depth below the surface [m]."""

    stress: float
    depth: float


def axis_stresses(semi_major, semi_minor, peak_pressure, poisson_ratio, depth):
    """Principal stresses [Pa] at `depth` [m] >= 0 below the centre: along the major axis, the minor axis, and normal.

    Boussinesq's potentials of the pressure p0 sqrt(1 - x^2/a^2 - y^2/b^2) on a half-space without friction, reduced
    to Carlson's integrals R_D: no term cancels at the circle (Johnson, Contact Mechanics, section 3.7, prints forms
    that do). Tension is positive; `depth` may be an array.
    """
    a, b, nu = semi_major, semi_minor, poisson_ratio
    z = np.asarray(depth, dtype=float)
    a2, b2, z2 = a * a + z * z, b * b + z * z, z * z
    root = np.sqrt(a2 * b2)
    shape = np.sqrt(b2 / a2)
    below = np.maximum(z2, np.finfo(float).tiny)
    # The integrals over w from z^2 to infinity of 1/((a^2 + w) W), 1/((b^2 + w) W), 1/(w W), W^2 = (a^2+w)(b^2+w) w.
    along, across = z * elliprd(below, b2, a2) / 1.5, z * elliprd(below, a2, b2) / 1.5
    inward = np.where(z > 1e-9 * b, z * elliprd(a2, b2, below) / 1.5, 2.0 / root)
    j_along, j_across = 2.0 / (a2 * (1.0 + shape)), 2.0 / (b2 * (1.0 + 1.0 / shape))
    half = 0.5 * a * b * peak_pressure
    stress_x = half * (-2.0 * nu * inward + along - (1.0 - 2.0 * nu) * (j_along - along))
    stress_y = half * (-2.0 * nu * inward + across - (1.0 - 2.0 * nu) * (j_across - across))
    return stress_x, stress_y, -2.0 * half / root


def greatest_shear(semi_major, semi_minor, peak_pressure, poisson_ratio) -> Shear:
    """The greatest shear stress on the axis, half the difference of the extreme principal stresses, and its depth.

    To 1e-3 of the minor semi-axis, and so the stress to 1e-6: 0.310 p0 at 0.481 a below a circle, 0.300 p0 at 0.786 b
    below a line (nu = 0.3); at the surface itself as Poisson's ratio nears -1.
    """
    depths = semi_minor * np.linspace(0.0, 2.0, 2001)
    stresses = np.array(axis_stresses(semi_major, semi_minor, peak_pressure, poisson_ratio, depths))
    shear = 0.5 * (stresses.max(axis=0) - stresses.min(axis=0))
    best = int(shear.argmax())
    return Shear(float(shear[best]), float(depths[best]))
