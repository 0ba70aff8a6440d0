"""A stepper that a bearing scene asks for, judged by the tables: what it erred and took, and what `auto` takes."""

from bearing_twin.kinds.bearing import measured
from bearing_twin.kinds.bearing.measured import SPREAD, Prediction, counted, error_of, predictions
from bearing_twin.kinds.bearing.motions import MOTIONS, motions_of, unmeasured
from bearing_twin.kinds.bearing.start import bearing_of, start_state
from bearing_twin.kinds.bearing.stepping.step_limits import FIXED_STEP, fastest_rates, step_at_start

# An implicit reference: a scene has it far tighter than rows, where it evaluates more, nobody knows what.
TIGHTER = "radau"


def setting_of(parameters, law: str) -> float:
    """Step [s] or tolerance of the stepper that a scene asks for; the step of balls that move each for itself."""
    solver = parameters.solver
    if solver.stepper not in FIXED_STEP:
        return parameters.wanted.tolerance
    if solver.step:  # known without a start
        return solver.step
    bearing = bearing_of(parameters, law)
    start = start_state(bearing, parameters.drive.speed, parameters.initial.motion)
    return step_at_start(parameters, fastest_rates(bearing, start), solver.stepper)[0]


def not_measured(parameters) -> str:
    """Where the stepper that a scene asks for was not measured, of what the scene is like; "" where it was in all."""
    if unlike := unmeasured(parameters):
        return f"with {unlike}"
    lacks = [one for one in motions_of(parameters) if (one, parameters.solver.stepper) not in measured.ladders()]
    return f"where {MOTIONS[lacks[0]][0]} ({lacks[0]})" if lacks else ""


def of_asked(parameters, law: str) -> Prediction:
    """What the stepper that a scene asks for did at its setting, all motions that the scene is like being measured.

    Errors are those of the motion in which it erred most, at the next looser setting measured, or the loosest; cost and
    evaluations are the most of all. Of TIGHTER nothing is counted. Raises SceneError where the scene has no start.
    """
    stepper, wanted, found = parameters.solver.stepper, setting_of(parameters, law), []
    motions = motions_of(parameters)
    for motion in motions:
        rungs = measured.ladders()[motion, stepper]
        loose = [rung for rung in rungs if rung.setting >= wanted * (1.0 - 1e-9)]
        found.append(Prediction(motion, stepper, *(loose[-1] if loose else rungs[0])))
    worst = max(found, key=lambda one: error_of(one, parameters.wanted.outputs))
    worst = worst._replace(cost=max(one.cost for one in found))
    if stepper == TIGHTER:
        return worst._replace(counted="")
    at_start, a_second = counted(parameters.geometry.balls, motions, stepper, wanted)
    return worst._replace(at_start=at_start, a_second=a_second)


def judged(parameters, law: str, warnings: list[str]) -> tuple[Prediction | None, str]:
    """What is foretold of the stepper that a scene asks for, and what to say; that it may miss joins the warnings."""
    stepper, wanted = parameters.solver.stepper, parameters.wanted.tolerance
    if lacks := not_measured(parameters):
        return None, f"{stepper}, as the scene asks: nothing is foretold, as no table has a row of it {lacks}"
    found = of_asked(parameters, law)
    worst, where = error_of(found, parameters.wanted.outputs), _setting_in_words(found)
    told = f"off by {worst:.2g} {where} where the motion was like this one ({found.motion})"
    if worst > wanted:
        warnings.append(f"solver.stepper = {stepper} was {told}, more than the wanted {wanted:g}; auto finds another")
    uncounted = "" if found.counted else "; what it evaluates is not foretold, as no row is as tight as a scene has it"
    return found, f"{stepper}, as the scene asks: it was {told}; {_instead(parameters, found)}{uncounted}"


def _setting_in_words(found: Prediction) -> str:
    fixed = found.stepper in FIXED_STEP
    return f"at a step of {found.setting:g} s" if fixed else f"at a tolerance of {found.setting:g}"


def _instead(parameters, found: Prediction) -> str:
    """What `auto` takes in place of what was asked for, or what comes next where it takes the same; by their cost."""
    best, *others = predictions(parameters)
    same = (best.stepper, best.setting) == (found.stepper, found.setting)
    if same and not others:
        return "auto takes it, too"
    other, who = (others[0], "auto takes it, too, and next came") if same else (best, "auto takes")
    times = other.cost / found.cost
    alike = 1.0 / (1.0 + SPREAD) <= times <= 1.0 + SPREAD
    cost = f"which cost the same within {100.0 * SPREAD:.0f} %" if alike else f"at {times:.3g} times its cost"
    return f"{who} {other.stepper} {_setting_in_words(other)}, {cost}"
