"""Theory and method for a sphere on a beam: the cheapest adequate beam, modes and a Hertz spring, unless asked for."""

import math

from bearing_twin.errors import SceneError
from bearing_twin.kinds.beam.derived import touch_speed
from bearing_twin.kinds.beam.fineness import modes_for, modes_wanted, states_held, steps_for
from bearing_twin.kinds.beam.impact import MOST_BYTES, MOST_MODES
from bearing_twin.kinds.beam.parameters import TIMOSHENKO
from bearing_twin.kinds.beam.theory import reason_of, theory_of
from bearing_twin.kinds.beam.watched import PEAK_SAMPLES
from bearing_twin.kinds.charted import in_words, predicted, row_of
from bearing_twin.kinds.impact.collision import FEW_STEPS
from bearing_twin.report import Choice

CHARTED = {"1 cm/s, one contact": 0.01, "drop of 600 mm": 3.43}  # m/s of the blows of `chart beams`
SAME = "modes, 9", "modes, 41"  # of that chart, the same method with other numbers
AS_WANTED = "tolerance"  # what the chart calls modes and steps that the tolerance wants
VOLTERRA_STEPS = 500
"""Steps a contact below which the linear pieces of the Volterra equation are coarse."""
SECONDS = {"step": 1.5e-7, "instant": 1.5e-7}
"""Of one mode, on one core of a 2.x GHz x86-64 machine: a step of the contact, and an instant that is read off."""
COPIES = 3  # of the states of a contact: room, part, whole
LONG = 5.0  # seconds of computing that are told before


def choose(parameters) -> Choice:
    """A sphere on a beam: modes and Hertz spring unless another method is asked for.

    Raises SceneError for modes and steps that no memory holds.
    """
    solver, warnings = parameters.solver, []
    stepper = "modes" if solver.stepper == "auto" else solver.stepper
    if solver.stepper == "auto":
        why = "because cubic forces reach the tolerance in steps that do not follow the highest mode"
    else:
        why = "as the scene asks"
    modes, steps, theory = modes_for(parameters), steps_for(parameters, stepper), theory_of(parameters)
    few = VOLTERRA_STEPS if stepper == "volterra" else FEW_STEPS
    if 0 < solver.steps < few:
        warnings.append(f"solver.steps = {steps} is coarse for {stepper}: contacts may come apart; use {few} or more")
    if stepper == "sinusoidal":
        warnings.append("the force is assumed, not solved for: the beam will receive more energy than the sphere has")
    if not solver.modes and (wanted := modes_wanted(parameters)) > modes:
        warnings.append(
            f"wanted.tolerance = {parameters.wanted.tolerance:g} wants modes up to {wanted}; {MOST_MODES} is the most, "
            "so the result is less exact"
        )
    moved = 0.5 if parameters.blow.point == 0.5 else 1.0
    warnings += _cost(parameters, round(modes * moved * (2 if theory == TIMOSHENKO else 1)), steps)
    reason = (
        f"hertz, the law of a sphere on a plane; {theory} beam, {reason_of(parameters)}; {stepper}, {why}: "
        f"modes up to {modes}, {steps} steps a contact"
    )
    if solver.stepper != "auto" or solver.modes or solver.steps:
        return Choice("hertz", stepper, 0.0, reason, tuple(warnings))
    speed = touch_speed(parameters.blow)
    blow = min(CHARTED, key=lambda one: abs(math.log(CHARTED[one] / speed)))
    row = row_of("beams", blow, AS_WANTED, parameters.wanted.tolerance)
    reason += f"; {in_words('beams', row, parameters.wanted.tolerance, same=SAME)}"
    told = predicted(row, "steps", row.evaluations) | {"stepper": stepper}
    return Choice("hertz", stepper, 0.0, reason, tuple(warnings), predicted=told)


def _cost(parameters, modes, steps) -> list[str]:
    """What a long run will take, said before it; `modes` are all that move."""
    held = states_held(steps, modes)
    if held > MOST_BYTES:
        raise SceneError(
            f"{steps} steps a contact with {modes} modes would hold {1e-9 * held:.3g} GB; at most "
            f"{1e-9 * MOST_BYTES:g} GB: lower solver.steps or solver.modes, or loosen wanted.tolerance"
        )
    run, history = parameters.run, parameters.wanted.outputs == "history"
    instants = run.duration * run.output_rate + PEAK_SAMPLES * history
    seconds = modes * (SECONDS["step"] * steps + SECONDS["instant"] * instants)
    if seconds <= LONG:
        return []
    return [
        f"{modes} modes, {steps} steps a contact and {instants:.3g} instants take about {seconds:.2g} s and "
        f"up to {1e-6 * COPIES * held:.2g} MB: loosen wanted.tolerance, "
        "shorten beam.span or run.duration, or give wanted.outputs: peaks"
    ]
