"""How many modes and steps a sphere on a beam is given: asked for, or as many as the tolerance wants."""

import math

from bearing_twin.kinds.beam.derived import beam_of, thrown_sphere, touch_speed
from bearing_twin.kinds.beam.impact import MOST_MODES, ONSET, hertz_contact_time, highest_mode
from bearing_twin.kinds.beam.parameters import SphereOnBeamScene
from bearing_twin.kinds.beam.theory import theory_of

FEWEST = 10  # steps a contact that are chosen


def steps_wanted(tolerance: float, stepper: str, peaks: bool = False) -> int:
    """Steps a Hertz contact time that a relative error of the force, or of its `peaks`, wants.

    The error falls as steps^-4 until the onset of the force, as time^1.5, is what is left; then steps^-6 is that of
    times and peaks. Hats converge as steps^-2.
    """
    if stepper == "volterra":
        return max(500, math.ceil(math.sqrt(7.0 / tolerance)))
    if tolerance < ONSET:
        return math.ceil(15.0 * tolerance ** (-1.0 / 6.0))
    return max(FEWEST, math.ceil(((16.0 if peaks else 40.0) / tolerance) ** 0.25))


def modes_wanted(parameters: SphereOnBeamScene) -> int:
    """Highest mode that the tolerance wants."""
    tau = hertz_contact_time(thrown_sphere(parameters), touch_speed(parameters.blow))
    beam, with_tail = beam_of(parameters, theory_of(parameters)), parameters.solver.static_tail == "contact"
    return highest_mode(beam, tau, parameters.wanted.tolerance, with_tail, parameters.wanted.outputs == "peaks")


def modes_for(parameters: SphereOnBeamScene) -> int:
    """Highest mode: asked for, or from the tolerance, at most MOST_MODES."""
    return parameters.solver.modes or min(modes_wanted(parameters), MOST_MODES)


def steps_for(parameters: SphereOnBeamScene, stepper: str) -> int:
    """Steps a Hertz contact time: asked for, or from the tolerance."""
    wanted = parameters.wanted
    return parameters.solver.steps or steps_wanted(wanted.tolerance, stepper, wanted.outputs == "peaks")


def steps_of(parameters: SphereOnBeamScene) -> int:
    """Steps a Hertz contact time of the scene's own method."""
    stepper = parameters.solver.stepper
    return steps_for(parameters, "modes" if stepper == "auto" else stepper)


def states_held(steps: int, modes: int) -> float:
    """Bytes of the states of all modes at every step of a contact up to twice Hertz's."""
    return 2 * steps * modes * 16.0
