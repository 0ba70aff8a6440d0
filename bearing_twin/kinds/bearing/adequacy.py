"""When equilibria are enough for a bearing, and when its balls need a cage: rows of reasons, and errors as measured."""

import math

import numpy as np

from bearing_twin.kinds.bearing.clearance import leaves_raceway, squeezes
from bearing_twin.kinds.bearing.drive import with_speeds
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.kinds.bearing.quasi_static.equilibrium import (
    Support,
    azimuths_of,
    setting_of,
    solver_of,
    support_of,
    weighed_solver,
    weighed_support,
)
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, free_coordinates
from bearing_twin.kinds.bearing.stepping.step_limits import FIXED_STEP
from bearing_twin.kinds.bearing.still import Still, still_at_start
from bearing_twin.kinds.ranges import FASTEST_CHANGE
from bearing_twin.units import CELSIUS

COLD = 150.0  # K, below all but cryogenic bearings
# Of a ball's way round: what equilibria are off by where all balls bear load on their way, and where some do not.
# Measured are up to 1.2e-4 and 3.2e-3 (2.1e-3 in `chart dimensions`).
WAY_OFF, WAY_OFF_LOOSE = 3e-4, 4e-3
PLACES = 90  # around the ring, where loads are compared


def way_error(parameters, law: str) -> float:
    """What loads of equilibria are off at the end of a run, over the greatest, as balls are elsewhere on their way.

    It grows with the angle turned, by how loads differ from place to place round the ring; raises SceneError.
    """
    drive, geometry, balls = parameters.drive, parameters.geometry, parameters.geometry.balls
    speed = max(drive.speed, drive.speed + drive.change.speed, key=abs)
    setting = setting_of(parameters, law, drive.speed)
    ring = weighed_solver(parameters, setting, azimuths_of(balls, 0.0)).solve(support_of(parameters)).coordinates
    held = Support((False,) * 5, (0.0,) * 5, tuple(ring.tolist()))
    load = weighed_solver(parameters, setting, azimuths_of(PLACES, 0.0)).solve(held).contacts.load
    greatest = float(load.max())
    if greatest <= 0.0:
        return 0.0
    off = WAY_OFF if load.min() > 0.0 else WAY_OFF_LOOSE
    slope = float(np.abs(load - np.roll(load, 1, axis=0)).max()) / (2.0 * math.pi / PLACES)
    turned = 0.5 * abs(speed) * (1.0 - geometry.ball_diameter / geometry.pitch_diameter) * parameters.run.duration
    return min(slope * off * turned, float(np.ptp(load, axis=0).max())) / greatest


def told_of_equilibria(parameters, choice) -> float | None:
    """What loads of a run from equilibria are off by, over the greatest; None of other runs.

    Where loads alone are wanted balls are compared at the same instants, elsewhere at the same places: a run that is to
    give a history is one of equilibria because the ring's load asks for it.
    """
    if choice.stepper != QUASI_STATIC:
        return None
    still = max(still_at_start(one, choice.law).error for one in with_speeds(parameters))
    return max(still, way_error(parameters, choice.law)) if parameters.wanted.outputs == LOADS else still


def _start(parameters, still) -> str:
    return "balls that start from rest skid" if parameters.initial.motion == "rest" else ""


def _jump(parameters, still) -> str:
    change = parameters.drive.change
    return (
        "contacts ring when drive.change.offset shifts the ring at once" if change.time and any(change.offset) else ""
    )


def hurried(parameters) -> bool:
    """Whether the scene's change of speed comes faster than balls follow in rolling."""
    return relative_acceleration(parameters) > FASTEST_CHANGE


def relative_acceleration(parameters) -> float:
    """Acceleration of the scene's change of speed over the least speed [1/s]; 0 where none comes."""
    drive = parameters.drive
    slowest = min(abs(drive.speed), abs(drive.speed + drive.change.speed))
    return drive.acceleration / max(slowest, 1.0) if drive.change.time and drive.change.speed else 0.0


def _hurry(parameters, still) -> str:
    if not hurried(parameters):
        return ""
    return f"at {parameters.drive.acceleration:g} rad/s^2 the speed changes faster than balls follow in rolling"


def _spin(parameters, still) -> str:
    if still.error < parameters.wanted.tolerance:
        return ""
    return (
        f"the centrifugal load is {still.share:.2g} of the contact's, where equilibria are off by up to "
        f"{100.0 * still.error:.2g} % in load and more in angle, by how the spin axes settle"
    )


def _spacing(parameters, still) -> str:
    if parameters.cage.kind != "none" or not any(parameters.drive.offset[:2]):
        return ""
    return "what a ball carries depends on where it is, and no cage keeps the balls evenly spaced"


def way_doubt(parameters, law: str) -> str:
    """Why equilibria are no answer at instants where loads alone are wanted, "" where they are."""
    error = way_error(parameters, law) if parameters.wanted.outputs == LOADS else 0.0
    if error < parameters.wanted.tolerance:
        return ""
    return (
        f"what a ball carries depends on where it is, and in {parameters.run.duration:g} s equilibria are so far off "
        f"its way round that loads are off by up to {100.0 * error:.2g} % at an instant"
    )


DOUBTS = (_start, _jump, _hurry, _spin, _spacing)
"""What may speak against equilibria: functions of parameters and `Still` that give a sentence, or ""."""


def doubts(parameters, still: Still) -> list[str]:
    """What speaks against a run from equilibria, one sentence each."""
    return [sentence for doubt in DOUBTS if (sentence := doubt(parameters, still))]


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
    """Whether a ring that is held squeezes balls at some place of it while nothing turns; a tilt counts as yes."""
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
