"""Catalogue numbers of a ball bearing from its geometry: ratings, lives, static safety (ISO 281, ISO 76, ISO/TS 16281).

Radial ball bearings of one row, nominal contact angle up to 45 degrees. A life is that which nine of ten bearings
reach, by the standards' own assumptions about steel, film and dirt; it is no promise about one bearing.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elasticity import ellipse
from bearing_twin.kinds.bearing.catalogue import row_of
from bearing_twin.shapes import ball_in_groove
from bearing_twin.vibration import rolling_frequencies

# ISO 76: pressure and steel of the static rating. With 207 GPa the formula meets the standard's table of f_0 (C_0 over
# Z D^2 cos a) within its rounding; 206 GPa is 1 % high.
RATED_PRESSURE, RATED_MODULUS, RATED_POISSON = 4.2e9, 207e9, 0.3
# n d_m [mm/min]: of spindle bearings with oil and ceramic balls; of deep groove bearings of the fastest makers; at the
# limiting speeds in the catalogue of FBJ, series 60, 62 and 63 with bores of 10 to 100 mm, which it meets within 12 %
FASTEST, FASTEST_GROOVE, LIMITING = 2e6, 1e6, {"grease": 5e5, "oil": 6e5}
LIMITING_SCATTER = 0.12
LARGEST_PLAIN = 25.4e-3  # m; ISO 281: larger balls grow less
# ISO 281, single row: Fa / (Z D^2) [N/mm^2] (f0 Fa / C0 is that over cos a), then e and Y of a deep groove or 5 degrees
# (X = 0.56), of 10 degrees (X = 0.46) and of 15 degrees (X = 0.44)
GROOVE = np.array(
    [
        (0.172, 0.19, 2.30, 0.29, 1.88, 0.38, 1.47),
        (0.345, 0.22, 1.99, 0.32, 1.71, 0.40, 1.40),
        (0.689, 0.26, 1.71, 0.36, 1.52, 0.43, 1.30),
        (1.03, 0.28, 1.55, 0.38, 1.41, 0.46, 1.23),
        (1.38, 0.30, 1.45, 0.40, 1.34, 0.47, 1.19),
        (2.07, 0.34, 1.31, 0.44, 1.23, 0.50, 1.12),
        (3.45, 0.38, 1.15, 0.49, 1.10, 0.55, 1.02),
        (5.17, 0.42, 1.04, 0.54, 1.01, 0.56, 1.00),
        (6.89, 0.44, 1.00, 0.54, 1.00, 0.56, 1.00),
    ]
)
GROOVE_ANGLES = (0.0, 0.56), (5.0, 0.56), (10.0, 0.46), (15.0, 0.44)  # degrees, X
# ISO 281 and ISO 76, angular contact: angle [degrees], e, X, Y, X0, Y0
ANGULAR = np.array(
    [
        (20.0, 0.57, 0.43, 1.00, 0.5, 0.42),
        (25.0, 0.68, 0.41, 0.87, 0.5, 0.38),
        (30.0, 0.80, 0.39, 0.76, 0.5, 0.33),
        (35.0, 0.95, 0.37, 0.66, 0.5, 0.29),
        (40.0, 1.14, 0.35, 0.57, 0.5, 0.26),
        (45.0, 1.34, 0.33, 0.50, 0.5, 0.22),
    ]
)
# ISO 76: angle [degrees], X0, Y0 of a deep groove and of small contact angles
STATIC = np.array([(0.0, 0.6, 0.5), (5.0, 0.5, 0.52), (10.0, 0.5, 0.5), (15.0, 0.5, 0.46)])


class Ratings(NamedTuple):
    """Basic dynamic and static rating [N]."""

    dynamic: float
    static: float


class Lives(NamedTuple):
    """Basic and reference life [1e6 turns], static safety; infinite where nothing loads."""

    basic: float
    reference: float
    static_safety: float


def _gamma(geometry) -> float:
    return geometry.ball_diameter * math.cos(geometry.contact_angle) / geometry.pitch_diameter


def _race_ratio(geometry) -> float:
    """X of ISO/TS 16281 over 1.044, the ratio of the raceways' ratings."""
    gamma, f_i, f_o = _gamma(geometry), geometry.inner_conformity, geometry.outer_conformity
    return ((1.0 - gamma) / (1.0 + gamma)) ** 1.72 * (f_i / f_o * (2.0 * f_o - 1.0) / (2.0 * f_i - 1.0)) ** 0.41


def basic_dynamic_rating(geometry) -> float:
    """C [N] of ISO 281: 1.3 f_c (cos a)^0.7 Z^(2/3) D^1.8 with D in mm, 3.647 D^1.4 above 25.4 mm.

    f_c = 38.197 (2 r_i/(2 r_i - D))^0.41 g^0.3 (1-g)^1.39/(1+g)^(1/3) [1 + (1.04 X_0)^(10/3)]^-0.3, g = D cos a/d_m,
    with the standard's reduction of 0.95 in the factor.
    """
    gamma, f_i = _gamma(geometry), geometry.inner_conformity
    factor = (
        38.197
        * (2.0 * f_i / (2.0 * f_i - 1.0)) ** 0.41
        * gamma**0.3
        * (1.0 - gamma) ** 1.39
        / (1.0 + gamma) ** (1.0 / 3.0)
        * (1.0 + (1.04 * _race_ratio(geometry)) ** (10.0 / 3.0)) ** -0.3
    )
    millimetres = 1e3 * geometry.ball_diameter
    size = millimetres**1.8 if geometry.ball_diameter <= LARGEST_PLAIN else 3.647 * millimetres**1.4
    return 1.3 * factor * math.cos(geometry.contact_angle) ** 0.7 * geometry.balls ** (2.0 / 3.0) * size


def basic_static_rating(geometry) -> float:
    """C_0 [N] of ISO 76: Z Q cos a / 5 with the load Q that presses the ball on a raceway with 4200 MPa.

    By Hertz for steel of 207 GPa, on the raceway that reaches it first, at the nominal contact angle.
    """
    modulus = 0.5 * RATED_MODULUS / (1.0 - RATED_POISSON**2)
    radius, cosine = 0.5 * geometry.ball_diameter, math.cos(geometry.contact_angle)
    least = math.inf
    for side, conformity in ((-1.0, geometry.inner_conformity), (1.0, geometry.outer_conformity)):
        groove = conformity * geometry.ball_diameter
        # the ball on its pitch circle, touching at the contact angle
        locus = 0.5 * geometry.pitch_diameter - side * (groove - radius) * cosine
        lever = groove - radius
        position = locus + side * lever * cosine, lever * math.sin(geometry.contact_angle)
        contact = ball_in_groove(*position, radius, locus, groove)
        pressure = ellipse(contact.curvature_small, contact.curvature_large, modulus, 1.0).peak_pressure
        least = min(least, (RATED_PRESSURE / pressure) ** 3)
    return geometry.balls * least * cosine / 5.0


def ratings_of(parameters) -> Ratings:
    """The ratings of the scene, else those that follow from its geometry."""
    stated, geometry = parameters.ratings, parameters.geometry
    return Ratings(stated.dynamic or basic_dynamic_rating(geometry), stated.static or basic_static_rating(geometry))


def _interpolated(table: np.ndarray, argument: float) -> list[float]:
    """The other columns of a table at an argument of the first one, linear between rows."""
    return [float(np.interp(argument, table[:, 0], column)) for column in table[:, 1:].T]


def equivalent_load(geometry, radial: float, axial: float) -> float:
    """P [N] of ISO 281 from radial and axial load [N]: the greater of F_r and X F_r + Y F_a, beyond F_a/F_r = e.

    Factors between the angles of the tables by straight lines; up to 15 degrees they depend on F_a/(Z D^2).
    """
    if axial == 0.0:
        return radial
    per_square = 1e-6 * axial / (geometry.balls * geometry.ball_diameter**2)  # N/mm^2 is f_0 F_a / C_0
    e0, y0, e10, y10, e15, y15 = _interpolated(GROOVE, per_square)
    by_load = (e0, y0), (e0, y0), (e10, y10), (e15, y15)
    small = [(angle, e, x, y) for (angle, x), (e, y) in zip(GROOVE_ANGLES, by_load, strict=True)]
    e, x, y = _interpolated(np.vstack([small, ANGULAR[:, :4]]), math.degrees(geometry.contact_angle))
    return radial if axial <= e * radial else x * radial + y * axial


def static_load(geometry, radial: float, axial: float) -> float:
    """P_0 [N] of ISO 76: the greater of F_r and X_0 F_r + Y_0 F_a."""
    x, y = _interpolated(np.vstack([STATIC, ANGULAR[:, [0, 4, 5]]]), math.degrees(geometry.contact_angle))
    return max(radial, x * radial + y * axial)


def equivalent_loads(geometry, force) -> tuple[float, float]:
    """P of ISO 281 and P_0 of ISO 76 [N] of a force (3,) [N] on the inner ring."""
    radial, axial = math.hypot(force[0], force[1]), abs(force[2])
    return equivalent_load(geometry, radial, axial), static_load(geometry, radial, axial)


def reference_life(geometry, dynamic: float, inner_loads, outer_loads) -> float:
    """L_10r [1e6 turns] of ISO/TS 16281 from the loads of the balls [N], the inner ring turning.

    Q_ci = C/(0.407 Z cos(a)^0.7) [1 + X^(10/3)]^0.3, Q_ce = C/(0.389 Z cos(a)^0.7) [1 + X^(-10/3)]^0.3;
    Q_ei = (sum Q^3/Z)^(1/3), Q_ee = (sum Q^(10/3)/Z)^0.3; L = [(Q_ci/Q_ei)^(-10/3) + (Q_ce/Q_ee)^(-10/3)]^(-0.9).
    """
    power, x = 10.0 / 3.0, 1.044 * _race_ratio(geometry)
    rated = dynamic / (geometry.balls * math.cos(geometry.contact_angle) ** 0.7)
    q_ci = rated / 0.407 * (1.0 + x**power) ** 0.3
    q_ce = rated / 0.389 * (1.0 + x**-power) ** 0.3
    q_ei = float(np.mean(np.asarray(inner_loads) ** 3)) ** (1.0 / 3.0)
    q_ee = float(np.mean(np.asarray(outer_loads) ** power)) ** 0.3
    damage = (q_ei / q_ci) ** power + (q_ee / q_ce) ** power
    return damage**-0.9 if damage > 0.0 else math.inf


def hours_of(turns: float, speed: float) -> float:
    """A life of `turns` [1e6] in hours at this speed [rad/s] of the inner ring; infinite at rest."""
    return 1e6 * turns * 2.0 * math.pi / abs(speed) / 3600.0 if speed else math.inf


def speed_warning(geometry, speed: float) -> str | None:
    """A sentence on a speed [rad/s] that no such bearing runs at, by n d_m [mm/min]; None for others."""
    rpm = abs(speed) * 30.0 / math.pi
    product, fastest = 1e3 * geometry.pitch_diameter * rpm, FASTEST if geometry.contact_angle else FASTEST_GROOVE
    if product <= fastest:
        return None
    return (
        f"{rpm:.6g} rpm is n d_m = {product:.2g} mm/min on a pitch circle of {1e3 * geometry.pitch_diameter:.4g} mm: "
        "greased ball bearings run to about 5e5, deep groove bearings to 1e6 at most, spindles with oil and ceramic "
        "balls to 2e6; a number without a unit is in rad/s"
    )


def limiting_speeds(geometry) -> dict[str, float] | None:
    """Limiting speeds [rad/s] of a deep groove bearing with grease and with oil, by n d_m; None for other bearings.

    Of 63 bearings those in the catalogue of FBJ, within 12 %; other makers' are up to half as high again.
    """
    if geometry.contact_angle:
        return None
    return {name: product / (1e3 * geometry.pitch_diameter) * math.pi / 30.0 for name, product in LIMITING.items()}


def command_warning(parameters, speed: float) -> str:
    """A sentence on a commanded speed [rad/s] above the limiting speed, which may be meant in rpm; "" for others.

    `parameters` are those of a bearing or of a shaft on two. The limit is that with oil, of angular contact bearings
    that of spindles.
    """
    bearings = [parameters] if hasattr(parameters, "geometry") else [parameters.left, parameters.right]
    limits = [
        (FASTEST if bearing.geometry.contact_angle else LIMITING["oil"]) / (1e3 * bearing.geometry.pitch_diameter)
        for bearing in bearings
    ]
    to_rpm, limit = 30.0 / math.pi, float(f"{min(limits):.2g}")
    if abs(speed) * to_rpm <= min(limits):
        return ""
    return (
        f"{speed:.5g} rad/s is {speed * to_rpm:.5g} rpm, above the bearing's limiting speed of about {limit:.6g} rpm; "
        f"{speed / to_rpm:.5g} rad/s is {speed:.5g} rpm"
    )


def lives_of(parameters, ratings: Ratings, force, inner_loads, outer_loads) -> Lives:
    """The lives under a force [N] (3,) on the inner ring that loads the balls like this [N]; see `Lives`."""
    geometry = parameters.geometry
    equivalent, static = equivalent_loads(geometry, force)
    return Lives(
        (ratings.dynamic / equivalent) ** 3 if equivalent > 0.0 else math.inf,
        reference_life(geometry, ratings.dynamic, inner_loads, outer_loads),
        ratings.static / static if static > 0.0 else math.inf,
    )


GREASE, OIL_BATH, OIL_JET = 1.0, 2.0, 4.0
"""Palmgren's f_0 of single-row ball bearings, by lubrication."""
BASE_VISCOSITY = 32e-6
"""Kinematic viscosity [m^2/s] of the base oil at running temperature that `palmgren_torque` takes by default."""
TORQUE_SCATTER = 0.5
"""Relative scatter of measured friction torques about `palmgren_torque`; that of fresh grease and seals is larger."""
# Harris, Rolling Bearing Analysis: contact angle [degrees], z and y of f_1 = z (P_0/C_0)^y
LOAD_TORQUE = np.array([(0.0, 0.0005, 0.55), (15.0, 0.0007, 0.44), (30.0, 0.001, 0.33), (40.0, 0.0013, 0.33)])


def palmgren_torque(
    geometry, static: float, force, speed: float, viscosity: float = BASE_VISCOSITY, lubrication: float = GREASE
) -> float | None:
    """Friction torque [N m] of a lubricated bearing without seals by Palmgren's rule of thumb; None at rest.

    M_0 = 1e-7 f_0 (nu n)^(2/3) d_m^3 for nu n > 2000, else 160e-7 f_0 d_m^3, and M_1 = f_1 P_1 d_m [N mm; mm, mm^2/s,
    1/min], f_1 = z (P_0/C_0)^y, P_1 the greater of F_r and 3 F_a - 0.1 F_r (angular contact: 0.9 F_a cot a - 0.1 F_r).

    Parameters
    ----------
    geometry
        Pitch diameter [m] and contact angle [rad] of the bearing.
    static
        Basic static rating C_0 [N].
    force
        Force (3,) [N] on the inner ring, z along the axis.
    speed
        Speed of the inner ring against the outer one [rad/s], of either sign.
    viscosity
        Kinematic viscosity of the (base) oil at running temperature [m^2/s].
    lubrication
        f_0: GREASE, OIL_BATH or OIL_JET.
    """
    if speed == 0.0:
        return None
    radial, axial = math.hypot(force[0], force[1]), abs(force[2])
    angle, pitch = math.degrees(geometry.contact_angle), 1e3 * geometry.pitch_diameter
    viscosity_speed = 1e6 * viscosity * abs(speed) * 30.0 / math.pi
    churning = 1e-7 * viscosity_speed ** (2.0 / 3.0) if viscosity_speed > 2000.0 else 160e-7
    without_load = lubrication * pitch**3 * churning
    thrust = 0.9 / math.tan(geometry.contact_angle) if angle >= 15.0 else 3.0
    torque_load = max(radial, thrust * axial - 0.1 * radial)
    z, y = _interpolated(LOAD_TORQUE, angle)
    return 1e-3 * (without_load + z * (static_load(geometry, radial, axial) / static) ** y * torque_load * pitch)


SIZES = {  # of a bearing in a row of the catalogue: the end of their keys there
    "balls": "",
    "ball_diameter": "_m",
    "pitch_diameter": "_m",
    "inner_conformity": "",
    "outer_conformity": "",
    "contact_angle": "_rad",
}


def row_in_use(parameters) -> dict:
    """The row of the scene's designation; a size that the scene gives takes the place of the row's, and is certain."""
    geometry, row = parameters.geometry, row_of(parameters.geometry.designation)
    given = [name for name, end in SIZES.items() if getattr(geometry, name) != row[f"{name}{end}"]]
    for name in given:
        row[f"{name}{SIZES[name]}"] = getattr(geometry, name)
        if (uncertainty := f"{name}_doubt{SIZES[name]}") in row:
            row[uncertainty] = 0
    if geometry.contact_angle:
        row["radial_clearance_m"] = None
    if given:
        row["source"] = f"given by the scene: {', '.join(given).replace('_', ' ')}"
    return row


def frequency_errors(row: dict, parameters) -> dict[str, float]:
    """Errors of fault frequencies [Hz], as the row's pitch circle, ball diameter and number of balls may be."""
    geometry, speed = parameters.geometry, parameters.drive.speed
    sizes = {
        "pitch_diameter": row["pitch_diameter_doubt_m"],
        "ball_diameter": row["ball_diameter_doubt_m"],
        "balls": row["balls_doubt"],
    }
    errors = dict.fromkeys(rolling_frequencies(geometry, speed), 0.0)
    for key, deviation in sizes.items():
        ends = [replace(geometry, **{key: getattr(geometry, key) + sign * deviation}) for sign in (-1, 1)]
        low, high = (rolling_frequencies(scaled, speed) for scaled in ends)
        errors = {line: error + 0.5 * abs(high[line] - low[line]) for line, error in errors.items()}
    return errors


def catalogue_sheet(parameters) -> dict:
    """The row of a scene's designation, the ratings by ISO 281 and ISO 76 and fault frequencies.

    Fault frequencies are those of balls that roll without load, at the nominal contact angle.
    """
    ratings, speed, row = ratings_of(parameters), parameters.drive.speed, row_in_use(parameters)
    limits, clearance = row["radial_clearance_m"], parameters.geometry.radial_clearance
    if limits and abs(clearance - 0.5 * sum(limits)) > 1e-9:
        row["radial_clearance_m"] = [clearance, clearance]
    return row | {
        "basic_dynamic_rating_n": ratings.dynamic,
        "basic_static_rating_n": ratings.static,
        "speed_rad_s": speed,
        "limiting_speed_rad_s": limiting_speeds(parameters.geometry),
        "fault_frequencies_hz": rolling_frequencies(parameters.geometry, speed),
        "fault_frequencies_hz_error": frequency_errors(row, parameters),
        "flags": [warning] if (warning := speed_warning(parameters.geometry, speed)) else [],
    }
