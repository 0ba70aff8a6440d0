"""Warnings of a bearing scene before it runs, and what reduces the error of its method."""

import math

from bearing_twin.base.units import CELSIUS
from bearing_twin.kinds.bearing.clearance import leaves_raceway, squeezes
from bearing_twin.kinds.bearing.quasi_static.equilibrium import solver_of, weighed_support
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, free_coordinates
from bearing_twin.kinds.bearing.step_limits import FIXED_STEP
from bearing_twin.kinds.bearing.still import still_at_start

COLD = 150.0  # K, below all but cryogenic bearings


def told_of_equilibria(parameters, choice) -> float | None:
    """The error of loads of a run from equilibria, over the greatest, against balls that move; None of other runs."""
    return still_at_start(parameters, choice.law).error if choice.stepper == QUASI_STATIC else None


def of_temperatures(parameters) -> list[str]:
    """What is to be said of temperatures in which steel bearings hardly run: they may have been meant in °C."""
    given = {
        name: getattr(parameters.temperatures, name) for name in ("reference", "inner_ring", "outer_ring", "balls")
    }
    cold = {name: value for name, value in given.items() if 0.0 < value < COLD}
    return [
        f"temperatures.{name} = {value:g} K is {value - CELSIUS:g} °C: if °C was meant, write {value + CELSIUS:g}"
        for name, value in cold.items()
    ]


def of_held_ring(parameters) -> list[str]:
    """What is to be said of a ring that is held where it is: that it touches no ball, or leaves some on their way."""
    if not touches_still(parameters):
        return [
            "the inner ring stands where it touches no ball, so that nothing loads or drives them: move it by "
            "drive.offset by more than the clearance, or free it under a load (rings.inner.load, model.dimension)"
        ]
    return list(filter(None, [cage_needed(parameters)]))


def touches_still(parameters) -> bool:
    """True if a ring that is held squeezes balls at some place of it while nothing turns; a tilt counts as yes."""
    return any(parameters.drive.tilt) or any(near > 0.0 for near, _ in squeezes(parameters))


def untouched(parameters, speed: float, work: float) -> str | None:
    """What is to be said of a ring at `speed` [rad/s] that balls touch at no output, the drive's `work` [J].

    Of one that no ball would touch at rest either `of_held_ring` tells before the run.
    """
    if work:
        return "balls touch the inner ring between outputs alone, unseen by its loads: give a greater run.output_rate"
    if not touches_still(parameters):
        return None
    return (
        f"at {speed:g} rad/s the balls are thrown off the inner ring, so that it neither carries nor drives them: "
        "lower drive.speed, which is in rad/s, or press the rings together harder"
    )


def of_falling_balls(parameters, law: str) -> list[str]:
    """What is to be said of a ring so slow that balls which bear nothing at the start fall off the outer raceway.

    At the top of their way, where their weight is more than their centrifugal load at the speed of rolling.
    """
    geometry = parameters.geometry
    orbit = math.sqrt(math.hypot(*parameters.gravity[:2]) / (0.5 * geometry.pitch_diameter))
    limit = orbit / (0.5 * (1.0 - geometry.ball_diameter / geometry.pitch_diameter))
    if abs(parameters.drive.speed) >= limit:
        return []
    if solver_of(parameters, law).solve(weighed_support(parameters)).contacts.load[:, 0].min() > 0.0:
        return []
    return [
        f"below {limit:.3g} rad/s the weight of balls is more than their centrifugal load: those that bear nothing "
        "fall off the outer raceway and hop between the rings, which carries errors on, so that what is seen of them "
        "at one instant keeps no tolerance; means do"
    ]


def mend_of_method(parameters, choice) -> str:
    """What makes the error of the integration method smaller, as far as anything does."""
    if of_falling_balls(parameters, choice.law):
        return "no tolerance mends what hopping balls do at one instant: take means, or turn the ring faster"
    if choice.stepper == QUASI_STATIC:
        return f"set model.dimension: {'free' if any(free_coordinates(parameters)) else 'prescribed'}, whose balls move"
    if choice.stepper in FIXED_STEP:
        return "halve solver.step, or set solver.stepper: rodas4"
    other = "" if choice.stepper in ("rodas4", "auto") else "solver.stepper: rodas4, or "
    return f"set {other}a tenth of wanted.tolerance"


def cage_needed(parameters) -> str:
    """Why balls without a cage would not stay apart, "" where they do: some leave a raceway on their way round."""
    if parameters.cage.kind != "none" or parameters.geometry.balls == 1:
        return ""
    if not leaves_raceway(parameters):
        return ""
    return (
        "balls leave the inner raceway on part of their way, and nothing keeps them apart: within about 0.1 s "
        "their spacing and orbit speed leave what rolling gives, which a cage prevents"
    )
