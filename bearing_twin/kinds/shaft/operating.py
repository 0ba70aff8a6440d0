"""A shaft while it runs: whether its bearings carry what it is told."""

import numpy as np

from bearing_twin.base.errors import BearingTwinError, IntegrationError
from bearing_twin.kinds.bearing.drive import SPEED
from bearing_twin.kinds.bearing.quasi_static.operating import OVERLOAD, PLACES, check_goal, commanded_loads, tried_at
from bearing_twin.kinds.shaft.course import about_centre, constant_loads, loads_of
from bearing_twin.kinds.shaft.parameters import ShaftScene
from bearing_twin.kinds.shaft.statics import solver_of, weighed_support


def check_load(parameters: ShaftScene, law: str, speed: float, force, moment) -> None:
    """Raises BearingTwinError for a load [N], [N m] at `shaft.load_place` that the bearings do not carry.

    It is tried as `refuse_uncarried` does, with the constant loads. None for force and moment: the scene's first loads.
    """
    loads = loads_of(parameters, 0.0)
    if force is not None:
        commanded = about_centre(parameters.shaft.load_place, commanded_loads(force, moment))
        loads = constant_loads(parameters) + commanded
    refuse_uncarried(parameters, law, speed, loads)


def check_drive(parameters: ShaftScene, law: str, key: str, value: float, load: tuple) -> None:
    """Raises BearingTwinError for a commanded `key` that is no speed [rad/s], or one at which a load is not carried.

    The `load` is (force, moment), None for both being the scene's own.
    """
    check_goal(SPEED, key, value)
    check_load(parameters, law, value, *load)


def refuse_uncarried(parameters: ShaftScene, law: str, speed: float, loads: np.ndarray) -> None:
    """Raises BearingTwinError for loads (5,) [N, N m] about the centre of mass that the bearings do not carry.

    They are tried in balance, with the shaft's weight, at `speed` [rad/s] and with the balls at PLACES of their way
    from one to the next.
    """
    support = weighed_support(parameters, loads)
    for place in range(PLACES):
        solver = solver_of(parameters, law, speed, lambda balls, place=place: tried_at(support, balls, place))
        solver.settle(support)
        solver.refuse_thrown_out(support)


def explained(error: IntegrationError, parameters: ShaftScene, law: str, speed: float, loads) -> IntegrationError:
    """`error`, or one that names the loads (5,) on the shaft then, with time and limit, where nothing carries them."""
    try:
        refuse_uncarried(parameters, law, speed, loads)
    except BearingTwinError as limit:
        return IntegrationError(f"at {error.seconds:.9g} s {limit}", OVERLOAD, error.seconds, "shaft")
    return error
