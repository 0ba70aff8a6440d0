"""What every impact scene takes: a sphere, and how the run is cut into outputs."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from bearing_twin.contact.materials import MATERIALS, Material
from bearing_twin.parameters import choice, quantity, section


@dataclass(frozen=True)
class Sphere:
    """A homogeneous elastic sphere."""

    radius: float = quantity(0.01905, "m", "radius", above=0.0)
    mass: float = quantity(0.0, "kg", "mass; 0 = from radius and density", at_least=0.0)
    material: Material = section(Material, "steel", MATERIALS)


@dataclass(frozen=True)
class Run:
    """What is computed and how often it is given out; zeros are replaced by numbers that suit the contact."""

    wanted: str = choice(
        "history", ("history", "peaks"), "history = forces over time; peaks = contact time, peak force"
    )
    duration: float = quantity(
        0.0, "s", "simulated time; 0 = the whole contact and some more", at_least=0.0, at_most=60
    )
    output_rate: float = quantity(0.0, "Hz", "solver outputs; 0 = chosen", at_least=0.0, at_most=1e9)
    publish_rate: float = quantity(0.0, "Hz", "published outputs; 0 = all", at_least=0.0, at_most=1e9)


def sphere_mass(sphere: Sphere) -> float:
    """Mass [kg]: given, or that of the homogeneous sphere; numbers or arrays that broadcast."""
    whole = sphere.material.density * 4.0 / 3.0 * math.pi * sphere.radius**3
    return np.where(np.greater(sphere.mass, 0.0), sphere.mass, whole)[()]


def resolved_run(run: Run, whole: float, outputs: int) -> Run:
    """The run with its zeros replaced: `whole` [s] long, about `outputs` outputs, all of them published."""
    duration = run.duration or float(f"{whole:.4g}")
    period_ns = max(1, round(1e9 * duration / outputs))
    output_rate = run.output_rate or 1e9 / period_ns
    return dataclasses.replace(
        run, duration=duration, output_rate=output_rate, publish_rate=run.publish_rate or output_rate
    )


def check_run(run: Run) -> list[str]:
    """What is impossible about a run's rates and length."""
    problems = []
    if run.output_rate and run.publish_rate > run.output_rate:
        problems.append(
            f"run.publish_rate = {run.publish_rate:g} Hz cannot exceed run.output_rate = {run.output_rate:g} Hz; "
            "raise the latter or lower the former"
        )
    if run.duration * run.output_rate > 1e7:
        problems.append(f"run.duration * run.output_rate = {run.duration * run.output_rate:g} outputs is too many; 1e7")
    return problems
