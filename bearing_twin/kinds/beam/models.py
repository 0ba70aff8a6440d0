"""The method for a sphere on a beam: modes and a Hertz spring unless another is asked for."""

from bearing_twin.kinds.beam.motion import modes_for, steps_for
from bearing_twin.kinds.impact.collision import FEW_STEPS
from bearing_twin.report import Choice

VOLTERRA_STEPS = 500
"""Steps a contact below which the linear pieces of the Volterra equation are coarse."""


def choose(parameters) -> Choice:
    """A sphere on a beam: modes and Hertz spring unless another method is asked for."""
    solver, warnings = parameters.solver, []
    stepper = "modes" if solver.stepper == "auto" else solver.stepper
    if solver.stepper == "auto":
        why = "because cubic forces reach the tolerance in steps that do not follow the highest mode"
    else:
        why = "as the scene asks"
    modes, steps = modes_for(parameters, stepper), steps_for(parameters, stepper)
    few = VOLTERRA_STEPS if stepper == "volterra" else FEW_STEPS
    if steps < few:
        warnings.append(f"solver.steps = {steps} is coarse for {stepper}: contacts may come apart; use {few} or more")
    if stepper == "sinusoidal":
        warnings.append("the force is assumed, not solved for: the beam will receive more energy than the sphere has")
    reason = f"hertz, the law of a sphere on a plane; {stepper}, {why}: modes up to {modes}, {steps} steps a contact"
    return Choice("hertz", stepper, 0.0, reason, tuple(warnings))
