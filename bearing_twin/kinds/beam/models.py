"""Theory and method for a sphere on a beam: the cheapest adequate beam, modes and a Hertz spring, unless asked for."""

from bearing_twin.kinds.beam.impact import MOST_MODES
from bearing_twin.kinds.beam.motion import modes_for, modes_wanted, steps_for
from bearing_twin.kinds.beam.theory import reason_of, theory_of
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
    modes, steps, theory = modes_for(parameters), steps_for(parameters, stepper), theory_of(parameters)
    few = VOLTERRA_STEPS if stepper == "volterra" else FEW_STEPS
    if steps < few:
        warnings.append(f"solver.steps = {steps} is coarse for {stepper}: contacts may come apart; use {few} or more")
    if stepper == "sinusoidal":
        warnings.append("the force is assumed, not solved for: the beam will receive more energy than the sphere has")
    if not solver.modes and (wanted := modes_wanted(parameters)) > modes:
        warnings.append(
            f"wanted.tolerance = {parameters.wanted.tolerance:g} wants modes up to {wanted}; {MOST_MODES} is the most, "
            "so the result is less exact"
        )
    reason = (
        f"hertz, the law of a sphere on a plane; {theory} beam, {reason_of(parameters)}; {stepper}, {why}: "
        f"modes up to {modes}, {steps} steps a contact"
    )
    return Choice("hertz", stepper, 0.0, reason, tuple(warnings))
