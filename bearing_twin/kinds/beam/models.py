"""Theory, method, modes and steps of a sphere on a beam, by the rules, and what a user should know of what is fixed."""

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.kinds.beam.fineness import modes_wanted, states_held
from bearing_twin.kinds.beam.impact import MOST_BYTES, MOST_MODES
from bearing_twin.kinds.beam.parameters import TIMOSHENKO
from bearing_twin.kinds.beam.watched import PEAK_SAMPLES
from bearing_twin.kinds.impact.collision import FEW_STEPS
from bearing_twin.kinds.impact.derived import homogeneous_mass
from bearing_twin.kinds.law_words import odd_mass
from bearing_twin.kinds.rules import BEAM, answers, sentences

VOLTERRA_STEPS = 500
"""Steps a contact below which the linear pieces of the Volterra equation are coarse."""
SECONDS = {"step": 1.5e-7, "instant": 1.5e-7}
"""Of one mode, on one core of a 2.x GHz x86-64 machine: a step of the contact, and an instant that is read off."""
COPIES = 3  # of the states of a contact: room, part, whole
LONG = 5.0  # seconds of computing that are announced


def choose(parameters) -> Choice:
    """A sphere on a beam: its theory, method, modes and steps; raises SceneError for more than memory holds."""
    found, solver = answers(BEAM, parameters), parameters.solver
    warnings = odd_mass("sphere.mass", parameters.sphere.mass, homogeneous_mass(parameters.sphere))
    stepper, theory = found["solver.stepper"].value, found["beam.theory"].value
    modes, steps = found["solver.modes"].value, found["solver.steps"].value
    few = VOLTERRA_STEPS if stepper == "volterra" else FEW_STEPS
    if 0 < solver.steps < few:
        warnings.append(f"solver.steps = {steps} is coarse for {stepper}: contacts may come apart; use {few} or more")
    if stepper == "sinusoidal":
        warnings.append("the force is assumed, not solved for: the beam will receive more energy than the sphere has")
    if not solver.modes and (wanted := modes_wanted(parameters)) > modes:
        warnings.append(
            f"wanted.tolerance = {parameters.wanted.tolerance:g} needs modes up to {wanted}; {MOST_MODES} is the most, "
            "so the result is less exact"
        )
    moved = 0.5 if parameters.blow.point == 0.5 else 1.0
    warnings += _cost(parameters, round(modes * moved * (2 if theory == TIMOSHENKO else 1)), steps)
    return Choice("hertz", stepper, 0.0, f"hertz, the law of a sphere on a plane; {sentences(found)}", tuple(warnings))


def _cost(parameters, modes, steps) -> list[str]:
    """The cost of a long run, announced before it; `modes` are all that move."""
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
