"""The housing and its accelerometer as a scene gives them; `accelerometer` computes what it measures."""

import math
from dataclasses import dataclass

from bearing_twin.base.parameters import choice, quantity
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, dimension_of

NONE, HOUSING = "none", "housing"
FASTEST = 50e3  # Hz
SAMPLES_A_PULSE = 1.0  # of half the time in which a ball passes a spall


@dataclass(frozen=True)
class Housing:
    """The housing along the sensor's direction, outer ring included."""

    mass: float = quantity(5.0, "kg", "of the housing that moves with the outer ring", above=0.0)
    stiffness: float = quantity(1.8e9, "N/m", "of what holds it", at_least=0.0)
    damping: float = quantity(3.8e3, "N s/m", "of what holds it", at_least=0.0)


@dataclass(frozen=True)
class Sensor:
    """An accelerometer, whose samples are records of their own rate."""

    on: str = choice(NONE, (NONE, HOUSING), "where it is; none = there is none")
    direction: tuple[float, float, float] = quantity((0.0, 1.0, 0.0), "1", "along which it measures, of any length")
    rate: float = quantity(12e3, "Hz", "samples a second", above=0.0, at_most=FASTEST)
    noise: float = quantity(0.0, "m/s^2", "standard deviation of the noise of a sample", at_least=0.0)
    seed: int = quantity(0, "1", "of the noise", at_least=0)


def sensor_problems(parameters, geometry) -> list[str]:
    """What is impossible about a sensor, a sentence each."""
    sensor, problems = parameters.sensor, []
    if sensor.on == NONE:
        return problems
    if dimension_of(parameters) == QUASI_STATIC:
        problems.append(
            "sensor.on = housing hears what moves, which equilibria do not; use model.dimension: prescribed"
        )
    if not any(sensor.direction):
        problems.append("sensor.direction must not be zero; give it along which axis it measures")
    if (stepper := parameters.solver.stepper) not in ("auto", "rodas4", "rodas3"):
        problems.append(f"solver.stepper = {stepper} takes no samples between its steps; use rodas4, rodas3 or auto")
    ratio = geometry.ball_diameter / geometry.pitch_diameter
    for number, one in enumerate(parameters.defects):
        share = {"outer": 1.0 - ratio, "inner": 1.0 + ratio, "ball": 1.0 / ratio - ratio}[one.on]
        speed = 0.5 * share * abs(parameters.drive.changed_speed) * one.radius(geometry)
        least = SAMPLES_A_PULSE * speed / (0.5 * one.spall.length) if one.spall.length else 0.0
        if sensor.rate < least:
            problems.append(
                f"sensor.rate = {sensor.rate:g} Hz is too low for the double pulse of defects[{number}]; "
                f"at least {math.ceil(least)} Hz"
            )
    return problems
