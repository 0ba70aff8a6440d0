"""A bearing while it runs: whether it carries a load it is told, and how stiff it is where it stands."""

import math

import numpy as np

from bearing_twin.base.errors import BearingTwinError, SceneError
from bearing_twin.kinds.bearing.drive import SPEED, TORQUE
from bearing_twin.kinds.bearing.quasi_static.equilibrium import (
    Support,
    azimuths_of,
    controlled,
    load_line,
    setting_of,
    weighed_solver,
    weighed_support,
)
from bearing_twin.kinds.bearing.rings import PRESCRIBED, dimension_of, idle_loads
from bearing_twin.kinds.contract import OperatingPoint

PLACES = 3  # of the balls on their way round, from one on the load line to two beside it
OVERLOAD = "overload"  # reason of the error of a run whose load nothing carries


def commanded_loads(force, moment) -> tuple[float, ...]:
    """Force (3,) [N] and moment (2,) or (3,) [N m] as the loads of the five coordinates; raises BearingTwinError."""
    values = (*force, *moment)
    if not all(map(math.isfinite, values)):
        raise BearingTwinError(f"force {_words(force)} N and torque {_words(moment)} N m must be finite")
    if any(values[5:]):
        raise BearingTwinError(
            f"the torque of {values[5]:g} N m about z is the drive's, which has a command of its own"
        )
    return tuple(map(float, values[:5]))


def check_load(parameters, law: str, speed: float, force, moment) -> None:
    """Raises BearingTwinError for a load [N], [N m] on the inner ring that nothing follows or no ball carries.

    It is tried in balance, with the weights on a ring with mass, at `speed` [rad/s] and with the balls at PLACES of
    their way from one to the next. None for force and moment: the scene's own load.
    """
    if dimension_of(parameters) == PRESCRIBED:
        if force is None:
            return
        raise BearingTwinError(
            "model.dimension = prescribed holds the inner ring, so that a load does not move it; run the scene with "
            "model.dimension: quasi_static or free, and rings.inner.free: displacement"
        )
    loads = None
    if force is not None:
        loads = commanded_loads(force, moment)
        for problem in idle_loads(parameters, loads[:3], loads[3:], "force", "torque"):
            raise BearingTwinError(problem)
    support = weighed_support(parameters, loads)
    setting, balls = setting_of(parameters, law, speed), parameters.geometry.balls
    for place in range(PLACES):
        azimuths = azimuths_of(balls, tried_at(support, balls, place))
        weighed_solver(parameters, setting, azimuths).solve(support)


def tried_at(support: Support, balls: int, place: int) -> float:
    """Azimuth [rad] of the first of so many balls, when a load is tried with them at that one of PLACES."""
    return load_line(support) + math.pi / balls * place / (PLACES - 1)


def check_drive(parameters, law: str, key: str, value: float, load: tuple) -> None:
    """Raises BearingTwinError for a commanded `key`, speed [rad/s] or torque [N m], that is not the drive's to take.

    Also for a speed at which the `load` (force, moment) is not carried, None for both being the scene's own.
    """
    check_goal(parameters.drive.kind, key, value)
    if key == SPEED:
        check_load(parameters, law, value, *load)


def check_goal(kind: str, key: str, value: float) -> None:
    """Raises BearingTwinError for a `key`, SPEED or TORQUE, that a drive of this kind does not take, or no number."""
    if key != kind:
        why = "the speed follows from the torque" if kind == TORQUE else "the torque follows from the speed"
        raise BearingTwinError(f"drive.kind = {kind}: {why}; command the {kind} instead")
    if not math.isfinite(value):
        raise BearingTwinError(f"a {key} of {value:g} is not finite")


def operating_point(parameters, law: str, sample) -> OperatingPoint:
    """The ring of an output with its loads and stiffness, the balls in balance at their azimuths there.

    A ring that moves or balls that ring are off this balance by their inertia. Raises BearingTwinError.
    """
    coordinates = np.array([*sample["inner_ring_offset"], *sample["inner_ring_tilt"]])
    setting, azimuths = setting_of(parameters, law, float(sample["inner_ring_speed"])), sample["orbit_angle"]
    held = Support((False,) * 5, (0.0,) * 5, tuple(coordinates))
    try:
        solver = weighed_solver(parameters, setting, azimuths)
        found = controlled(parameters, solver, held)
    except SceneError as error:
        raise BearingTwinError(f"there is no stiffness where the ring stands now: {error}") from error
    return OperatingPoint(found.coordinates, found.loads, found.stiffness)


def _words(values) -> str:
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"
