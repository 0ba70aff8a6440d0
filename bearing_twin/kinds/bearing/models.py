"""The cheapest adequate law, dimension and stepper for a bearing, and why.

What a scene pins is kept; a pinned model that misses the tolerance is named in the warnings.
"""

from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.names import AUTO
from bearing_twin.kinds.bearing.adequacy import (
    cage_needed,
    doubts,
    of_falling_balls,
    of_held_ring,
    of_temperatures,
    way_doubt,
)
from bearing_twin.kinds.bearing.asked import judged
from bearing_twin.kinds.bearing.drive import TORQUE
from bearing_twin.kinds.bearing.friction_choice import as_chosen, chosen_friction, of_pinned
from bearing_twin.kinds.bearing.measured import (
    SPREAD,
    Prediction,
    as_cheap,
    dimension_costs,
    error_of,
    predictions,
)
from bearing_twin.kinds.bearing.motions import unmeasured
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.kinds.bearing.rings import FREE_RING, PRESCRIBED, QUASI_STATIC, dimension_of
from bearing_twin.kinds.bearing.start import nominal_curvatures
from bearing_twin.kinds.bearing.stepping.step_limits import FIXED_STEP
from bearing_twin.kinds.bearing.still import still_at_start
from bearing_twin.kinds.law_words import HERTZ_FOLLOWS, drift, idle_step
from bearing_twin.report import Choice

DEFAULT = "rodas4"  # where nothing was measured
OFF_RINGS = 0.014  # of ball loads at an instant, by equilibria of a ring with mass: `chart fidelity`, rigs
RING_MOVES = "the inner ring moves with its mass, in one step with all balls"


def law_error(law: str, parameters) -> float:
    """Greatest relative load error of a law against exact Hertz at a bearing's two nominal contacts; 0 if measured."""
    worst = 0.0
    if LAWS[law].measured:
        return worst
    for small, large in nominal_curvatures(parameters.geometry):
        exact = hertz_coefficient(small, large, 1.0)
        worst = max(worst, abs(coefficient_of(law, small, large, 1.0, exact) / exact - 1.0))
    return worst


def _dimension(parameters, law: str, warnings: list[str]) -> tuple[str, str, dict | None]:
    """(dimension, why, what equilibria promise); what it leaves out, or does without, joins the warnings."""
    asked, dimension = parameters.model.dimension != "auto", dimension_of(parameters)
    turned = parameters.drive.kind == TORQUE
    if dimension == FREE_RING:
        why = f"because equilibria of a ring with mass are off by up to {100.0 * OFF_RINGS:g} % in load at an instant"
        why = "because a torque turns the ring under a load" if turned else why
        why = "as the scene asks" if asked else why
        return FREE_RING, f"free, {why}: {RING_MOVES}", None
    loads_alone = not (asked or turned) and dimension == PRESCRIBED and parameters.wanted.outputs == LOADS
    if dimension == PRESCRIBED and not loads_alone:
        warnings += of_held_ring(parameters)
        why = "as the scene asks" if asked else "because friction torque, slip and losses are among the outputs"
        return PRESCRIBED, f"prescribed, {why}", None
    still = still_at_start(parameters, law)
    against, way = doubts(parameters, still), way_doubt(parameters, law)
    if loads_alone and (against or way):
        warnings += of_held_ring(parameters)
        return PRESCRIBED, f"prescribed, because {' and '.join(against or [way])}", None
    costs = dimension_costs(parameters, still.share)
    if loads_alone and not cage_needed(parameters) and costs[PRESCRIBED] <= costs[QUASI_STATIC]:
        times = _times(costs[QUASI_STATIC], costs[PRESCRIBED])
        why = (
            f"because at {parameters.run.output_rate:g} outputs a second moving balls cost {times} less than "
            "equilibria and hold friction too"
        )
        return PRESCRIBED, f"prescribed, {why}", None
    warnings += [*(f"{doubt}: a run from equilibria has nothing of that" for doubt in against), *([way] if way else ())]
    if parameters.solver.stepper != "auto":
        warnings.append("solver.stepper does nothing in a run from equilibria, which has no steps")
    why = "as the scene asks"
    if not asked:
        because = "the inner ring is loaded or tilted"
        if loads_alone:
            because = "loads and angles alone are wanted"
            if costs[PRESCRIBED] > costs[QUASI_STATIC]:
                because += f", and moving balls would cost {_times(costs[PRESCRIBED], costs[QUASI_STATIC])} more"
        why = (
            f"because {because}: every output is an equilibrium, in a cage that spaces the balls evenly; friction "
            "torque, skidding and ringing are not in it"
        )
    told = {"motion": "equilibria", "stepper": QUASI_STATIC, "load_error": still.error, "cost": costs[QUASI_STATIC]}
    told |= {"counted": "equilibria", "at_start": 1.0, "a_second": parameters.run.output_rate}
    why += (
        f"; the centrifugal load is {still.share:.2g} of the contact's at the start, where loads are within "
        f"{100.0 * still.error:.2g} % of those of moving balls"
    )
    return QUASI_STATIC, f"quasi_static, {why}", told


def _times(more: float, less: float) -> str:
    return f"{more / less:.3g} times"


def _stepper(parameters, law: str, warnings: list[str]) -> tuple[str, Prediction | None, str]:
    """Stepper, what it did when measured (None where nothing like it was) and why."""
    pinned = parameters.solver.stepper
    if pinned != "auto":
        return pinned, *judged(parameters, law, warnings)
    if unlike := unmeasured(parameters):
        return DEFAULT, None, f"{DEFAULT} at the wanted tolerance, because no stepper was measured with {unlike}"
    found, wanted = predictions(parameters), parameters.wanted
    first, *others = found
    worst = error_of(first, wanted.outputs)
    where = f"where the motion was most like this one ({first.motion}): off by {worst:.2g}"
    if worst <= wanted.tolerance:
        because = f"because it was the cheapest within the wanted {wanted.tolerance:g} {where}"
    else:
        because = f"as wanted, though {where}"
    why = f"{first.stepper} at a tolerance of {first.setting:g}, {because}"
    equals = [one.stepper for one in as_cheap(found)[1:]]
    if equals:
        why += f"; {' and '.join(equals)} cost the same within {100.0 * SPREAD:.0f} %"
    elif others:
        why += f"; next came {others[0].stepper} at {_times(others[0].cost, first.cost)} its cost"
    return first.stepper, first, why


def choose(parameters) -> Choice:
    """Law, stepper and friction for a bearing scene; raises SceneError where the scene has no start."""
    asked, pinned_law = parameters, parameters.contact.normal
    parameters = as_chosen(parameters)
    reasons, warnings = [], []

    law = "hertz" if pinned_law == "auto" else pinned_law
    reasons.append(HERTZ_FOLLOWS if pinned_law == "auto" else f"{law}, as the scene asks")
    error = law_error(law, parameters)
    if error > parameters.wanted.tolerance:
        warnings.append(
            f"the law {law} is {100 * error:.2g} % off exact Hertz here, more than the wanted "
            f"{100 * parameters.wanted.tolerance:.2g} %; contact.normal: hertz costs no more"
        )
    warnings += [*drift(law), *of_temperatures(parameters)]

    dimension, why, still = _dimension(parameters, law, warnings)
    reasons.append(why)
    if dimension == QUASI_STATIC:
        return Choice(law, QUASI_STATIC, error, "; ".join(reasons), tuple(warnings), predicted=still)
    stepper, prediction, why = _stepper(parameters, law, warnings)
    reasons.append(why)
    warnings += idle_step(parameters.solver.step, stepper, FIXED_STEP)
    friction, left = FRICTIONS[parameters.contact.friction], asked.contact.friction == AUTO
    told, doubts_of_it = ("", []) if left else of_pinned(parameters)
    if left:
        reasons.append(chosen_friction(asked).reason)
    elif friction.over_spot:
        told = f"; {told}" if told else ""
        reasons.append(f"friction over the spot ({friction.name}): it resists spin, and a step costs more{told}")
    if parameters.cage.kind != "none":
        reasons.append(f"the balls of the cage ({parameters.cage.kind}) share one step")
    warnings += [*doubts_of_it, *of_falling_balls(parameters, law)]
    left_to_tables = prediction and asked.solver.stepper == AUTO
    setting = prediction.setting if left_to_tables else parameters.wanted.tolerance
    predicted = prediction._asdict() if prediction else None
    named = friction.name if left else ""
    return Choice(law, stepper, error, "; ".join(reasons), tuple(warnings), setting, predicted, friction=named)
