"""Lubricant and surfaces of a scene: viscosity at its temperature, and the numbers of its films for the core."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from bearing_twin.base.parameters import choice, quantity
from bearing_twin.base.units import CELSIUS
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.catalogue import entries
from bearing_twin.kinds.bearing.geometry import nominal_curvatures

if TYPE_CHECKING:  # to read a scene needs no arrays
    import numpy as np

KINDS = NONE, GREASE, OIL = "none", "grease", "oil"  # LubricantKind of friction.hpp
FILM_NUMBERS, FILM_RESULTS = 6, 6
# Mineral oils by ISO viscosity grade: nu = a exp(B/(T + 95)) [mm^2/s], T [degrees C]; and their viscosity at 40 degrees
GRADES = {"VG32": (0.0813, 808.0), "VG46": (0.0762, 866.0), "VG68": (0.0710, 929.0), "VG100": (0.0662, 990.0)}
COLDEST, HOTTEST = CELSIUS - 20.0, CELSIUS + 120.0  # K: mineral oils hardly flow below and age fast beyond
FORTY, HUNDRED = CELSIUS + 40.0, CELSIUS + 100.0
LEAST_FILM = 0.1  # of the roughness: thinner films carry no load to speak of, and no formula holds
ORDINARY_PRESSURE = 1e9  # Pa, of the contact whose film is judged before a run: load matters as its power -0.067
SECTION = 0.29  # ball diameter over (outside - bore), of deep groove bearings that no catalogue knows (`catalogue`)

_numbers = Function("core_film_numbers", None, (REALS, INTEGER, REALS, REALS, REAL, REAL, REALS_OUT))
_films = Function("core_films", None, (REALS, INTEGER, REALS, REALS, REALS, REALS_OUT))


@dataclass(frozen=True)
class Lubricant:
    """Lubricant of the contacts of balls and raceways; without it they are dry."""

    kind: str = choice(
        NONE,
        KINDS,
        "grease = little oil, whose films starve; oil = flooded; none = dry contacts, whose friction torque is no "
        "bearing's",
    )
    name: str = choice("auto", ("auto", *GRADES), "grade of a mineral (base) oil; auto = VG100, or the viscosities")
    viscosity_40: float = quantity(0.0, "m^2/s", "kinematic, at 40 °C, such as 68mm²/s; 0 = by name", at_least=0.0)
    viscosity_100: float = quantity(
        0.0, "m^2/s", "kinematic, at 100 °C; wanted with viscosity_40 for other temperatures than 40 °C", at_least=0.0
    )
    pressure_coefficient: float = quantity(
        0.0, "1/Pa", "of viscosity, at low pressure; 0 = 1.29e-7 viscosity_40^0.204, of mineral oils", at_least=0.0
    )
    density: float = quantity(870.0, "kg/m^3", "of the oil", above=0.0)
    film_friction: float = quantity(
        0.05, "1", "coefficient of friction on a whole film: mineral oil 0.05, synthetic 0.04 (SKF)", at_least=0.0
    )
    boundary_friction: float = quantity(
        0.12, "1", "where surfaces touch through the film, in place of contact.friction_coefficient (SKF)", above=0.0
    )


@dataclass(frozen=True)
class Surface:
    """The surfaces of balls and raceways."""

    roughness: float = quantity(
        1e-7, "m", "root of the mean square, of ball and raceway together; 0.06 to 0.1 um in print", above=0.0
    )


def is_lubricated(parameters) -> bool:
    """True if there is a lubricant."""
    return parameters.lubricant.kind != NONE


def _by_walther(cold: float, warm: float, temperature: float) -> float:
    """ASTM D341: log10 log10(nu + 0.7) = A - B log10(T), nu in mm^2/s, through values [m^2/s] at 40 and 100 degrees."""
    at_40, at_100 = (math.log10(math.log10(1e6 * viscosity + 0.7)) for viscosity in (cold, warm))
    slope = (at_40 - at_100) / math.log10(HUNDRED / FORTY)
    return 1e-6 * (10.0**10.0 ** (at_40 - slope * math.log10(temperature / FORTY)) - 0.7)


def viscosity_of(lubricant: Lubricant, temperature: float) -> float:
    """Kinematic viscosity [m^2/s] at this temperature [K]: by the oil's two viscosities, else by its grade (Vogel)."""
    if lubricant.viscosity_40:
        warm = lubricant.viscosity_100
        return lubricant.viscosity_40 if not warm else _by_walther(lubricant.viscosity_40, warm, temperature)
    a, b = GRADES["VG100" if lubricant.name == "auto" else lubricant.name]
    return 1e-6 * a * math.exp(b / (temperature - CELSIUS + 95.0))


def lubricant_sentence(parameters) -> str:
    """The lubricant of a scene, at its temperature, as a sentence."""
    lubricant, celsius = parameters.lubricant, parameters.temperature - CELSIUS
    grade = "two viscosities" if lubricant.viscosity_40 else "VG100" if lubricant.name == "auto" else lubricant.name
    viscosity = 1e6 * viscosity_of(lubricant, parameters.temperature)
    return f"Lubricant: {lubricant.kind}, {grade}, {celsius:.4g} °C, {viscosity:.3g} mm²/s."


def boundary_dimensions(geometry) -> tuple[float, float]:
    """Bore and outside diameter [m]: of the catalogue where the bearing is in it, else estimated from its balls."""
    if entry := entries().get(geometry.designation):
        return entry.bore, entry.outside_diameter
    half = 0.5 * geometry.ball_diameter / SECTION
    return geometry.pitch_diameter - half, geometry.pitch_diameter + half


def inlet_factors(geometry, viscosity: float) -> tuple[float, float]:
    """Numbers of SKF's factors of heating and starvation of the inlet, 1/(1 + first n^1.28) and exp(-second n).

    They are 1.84e-9 d_m^1.28 nu^0.64 and K nu (d + D) sqrt(K_z/(2 (D - d))), n in 1/min.
    """
    bore, outside = (1e3 * diameter for diameter in boundary_dimensions(geometry))
    replenished = 4.4 if geometry.contact_angle else 3.1
    heating = 1.84e-9 * (0.5 * (bore + outside)) ** 1.28 * (1e6 * viscosity) ** 0.64
    return heating, 6e-8 * 1e6 * viscosity * (bore + outside) * math.sqrt(replenished / (2.0 * (outside - bore)))


def rolling_speed(geometry, speed: float) -> float:
    """Speed u = |w| d_m (1 - g^2)/4 [m/s], g = D/d_m, of balls that roll on both raceways at contact angle zero."""
    return 0.25 * abs(speed) * geometry.pitch_diameter * (1.0 - (geometry.ball_diameter / geometry.pitch_diameter) ** 2)


def film_lubricant(parameters) -> "np.ndarray":
    """The numbers of a Lubricant of friction.hpp; the speed of the bearing is that at which its balls roll so fast."""
    import numpy as np

    lubricant, geometry = parameters.lubricant, parameters.geometry
    if not is_lubricated(parameters):
        return np.zeros(8)
    viscosity = viscosity_of(lubricant, parameters.temperature)
    cold = viscosity_of(lubricant, FORTY)
    turns = 30.0 / math.pi / rolling_speed(geometry, 1.0)
    heating, starvation = inlet_factors(geometry, viscosity)
    return np.array(
        [
            *(KINDS.index(lubricant.kind), viscosity * lubricant.density),
            lubricant.pressure_coefficient or 1.29e-7 * cold**0.204,
            *(math.log(parameters.surface.roughness), lubricant.boundary_friction, lubricant.film_friction),
            *(heating * turns**1.28, starvation * turns),
        ]
    )


def film_numbers(lubricant: "np.ndarray", small, large, modulus: float, ball_radius: float) -> "np.ndarray":
    """Numbers (N, FILM_NUMBERS) of films before loads and speeds, by the curvatures of the gap [1/m] (N,)."""
    import numpy as np

    small, large = (np.ascontiguousarray(curvatures, float) for curvatures in (small, large))
    numbers = np.empty((len(small), FILM_NUMBERS))
    _numbers(lubricant, len(small), small, large, modulus, ball_radius, numbers)
    return numbers


def films(lubricant: "np.ndarray", numbers: "np.ndarray", load, speed) -> "np.ndarray":
    """Films of contacts with `film_numbers`, loads [N] and rolling speeds [m/s] (N,) above 0.

    Returns
    -------
    array (N, 6)
        Thickness at the centre [m], the same over the roughness (Lambda), rolling resistance on each surface [N],
        moments of hysteresis and of differential slip about the ball's axis [N m], coefficient of friction.
    """
    import numpy as np

    load, speed = np.ascontiguousarray(load, float), np.ascontiguousarray(speed, float)
    results = np.empty((len(load), FILM_RESULTS))
    _films(lubricant, len(load), np.ascontiguousarray(numbers), load, speed, results)
    return results


def lubricant_problems(parameters) -> list[str]:
    """Problems of the lubricant, one sentence each."""
    lubricant = parameters.lubricant
    if not is_lubricated(parameters):
        has_oil = lubricant.name != "auto" or lubricant.viscosity_40 or lubricant.viscosity_100
        return ["lubricant.kind = none leaves the oil unused; give lubricant.kind: grease or oil"] if has_oil else []
    cold, warm, temperature = lubricant.viscosity_40, lubricant.viscosity_100, parameters.temperature
    named, speed = lubricant.name != "auto" and (cold or warm), parameters.drive.speed
    rows = (
        (named, "lubricant.name and lubricant.viscosity_40, viscosity_100 say the same thing; keep one of them"),
        (
            not named and warm and not warm < cold,
            f"lubricant.viscosity_100 = {warm:g} m^2/s must be below lubricant.viscosity_40 = {cold:g} m^2/s: oils "
            "thin as they warm",
        ),
        (
            not named and cold and not warm and abs(temperature - FORTY) > 0.5,
            f"temperature = {temperature:g} K wants lubricant.viscosity_100, too: one viscosity holds at 40 °C alone",
        ),
        (
            not COLDEST <= temperature <= HOTTEST,
            f"temperature = {temperature:g} K is outside the oil's, {COLDEST:g} to {HOTTEST:g} K (-20 to 120 °C), "
            "where its viscosity is known; without a unit it is in K, so give °C as 65°C",
        ),
    )
    problems = [sentence for wrong, sentence in rows if wrong]
    if problems or not speed or (ratio := ordinary_film(parameters, speed)) >= LEAST_FILM:
        return problems
    return [
        f"the film is {ratio:.2g} of surface.roughness = {parameters.surface.roughness:g} m at {speed:g} rad/s: "
        f"below {LEAST_FILM:g} contacts are dry and no formula of films holds; raise the viscosity or the speed, "
        "lower temperature, or leave lubricant out"
    ]


def ordinary_film(parameters, speed: float) -> float:
    """Thickness over roughness of the inner contact at the peak pressure ORDINARY_PRESSURE and this speed [rad/s]."""
    from bearing_twin.contact.elasticity import ellipse

    geometry, materials = parameters.geometry, parameters.materials
    radius, modulus = 0.5 * geometry.ball_diameter, effective_modulus(materials.ball, materials.inner_ring)
    small, large = nominal_curvatures(geometry)[0]
    load = (ORDINARY_PRESSURE / ellipse(small, large, modulus, 1.0).peak_pressure) ** 3
    lubricant = film_lubricant(parameters)
    numbers = film_numbers(lubricant, [small], [large], modulus, radius)
    return float(films(lubricant, numbers, [load], [rolling_speed(geometry, speed)])[0, 1])
