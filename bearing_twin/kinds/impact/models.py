"""Law and stepper of two bodies that meet: closed forms wherever they say all that is wanted."""

from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.charted import Charted, in_words, predicted, row_of
from bearing_twin.kinds.impact.collision import FEW_STEPS
from bearing_twin.kinds.impact.derived import contact_time_by, is_elastic, is_steady, pair_contact_time, sphere_law
from bearing_twin.kinds.impact.facts import speed_share
from bearing_twin.kinds.impact.methods import FIXED_STEP
from bearing_twin.kinds.law_words import idle_step
from bearing_twin.report import Choice

JOHNSON_ERROR = 0.04
"""Of force and contact time of slow discs by Johnson in plane strain (`tests/test_impact_physics.py`)."""
LARGE = 3.0
"""Error of force or contact time by Johnson's law over the disc's speed as a share of that of waves in it.

Against `soft_discs` (against: disc, contact.stiffness_ratio: 300, 24 divisions of order 3, Poisson's ratio 0.3, force
averaged over 2 % of the contact), at shares of 0.01, 0.03, 0.06, 0.1 and 0.14 the force is 3, 10, 18, 30 and 42 % too
great and the contact time 3, 0, -5, -9 and -14 % off; the force is 2 to 5 % less off with a ratio of 0, more with
0.45 (`tests/test_impact_physics.py`).
"""


def choose_spheres(parameters) -> Choice:
    """Two spheres: closed forms wherever they say all that is wanted."""
    contact, solver = parameters.contact, parameters.solver
    law = sphere_law(parameters)
    if contact.normal != "auto":
        reasons = [f"{law}, as the scene asks"]
    else:
        reasons = ["the measured alpha, as the scene asks" if law == "measured" else "hertz, the law of spheres"]
    if solver.stepper != "auto":
        stepper = solver.stepper
        reasons.append(f"{stepper}, as the scene asks")
    elif is_steady(contact):
        stepper = "dop853"
        reasons.append("dop853, because steady damping has no closed form for times and forces")
    elif is_elastic(contact):
        stepper = "closed_form"
        reasons.append("closed_form, because contact time, peak force and history are exact without any step")
    elif parameters.wanted.outputs == "peaks":
        stepper = "closed_form"
        reasons.append("closed_form, because only contact time and peak force are wanted: a quadrature gives them")
    else:
        stepper = "dop853"
        reasons.append("dop853, because the force history with losses needs the differential equation")
    exact = sphere_coefficient("hertz", 1.0, 1.0)
    error = 0.0 if LAWS[law].measured else abs(float(sphere_coefficient(law, 1.0, 1.0) / exact) - 1.0)
    row = _row(parameters, "elastic spheres" if is_elastic(contact) else "spheres, restitution 0.8", stepper, reasons)
    told = predicted(row, "evaluations", row.evaluations) if row else None
    return Choice(law, stepper, error, "; ".join(reasons), _step_warnings(parameters, stepper), predicted=told)


def _row(parameters, problem: str, stepper: str, reasons: list[str]) -> Charted | None:
    """The row that speaks for a stepper, chosen or asked for, which joins the reasons; None of fixed steps.

    Those of the table are of its contact's time, and a scene's are of its own.
    """
    if stepper in FIXED_STEP:
        reasons.append("nothing is foretold of it, as rows of fixed steps are of another contact's time")
        return None
    wanted = parameters.wanted.tolerance
    row = row_of("pairs", problem, stepper, wanted)
    reasons += filter(None, [in_words("pairs", row, wanted)])
    return row


def choose_discs(parameters) -> Choice:
    """Two discs: Johnson's law unless another is asked for, by quadrature when only peaks are wanted."""
    pinned, solver = parameters.contact.normal, parameters.solver
    law = "johnson" if pinned == "auto" else pinned
    error, warnings = off_elements(parameters)
    if pinned == "auto":
        told = f"johnson, because discs follow its two-dimensional solution to {100.0 * error:.2g} % here"
        reasons = [told]
    else:
        times = [contact_time_by(parameters, one) for one in (law, "johnson")]
        apart, reasons = abs(times[0] / times[1] - 1.0), [f"{law}, as the scene asks"]
        error += apart
        if apart > JOHNSON_ERROR:
            warnings.append(
                f"the law {law} gives a contact time {100.0 * (times[0] / times[1] - 1.0):.2g} % from Johnson's, "
                "which thick discs follow; contact.normal: johnson costs no more"
            )
    if solver.stepper != "auto":
        stepper = solver.stepper
        reasons.append(f"{stepper}, as the scene asks")
    elif parameters.wanted.outputs == "peaks":
        stepper = "closed_form"
        reasons.append("closed_form, because contact time and peak force are a quadrature exact to 1e-12")
    else:
        stepper = "dop853"
        reasons.append("dop853, because a force history is wanted")
    row = _row(parameters, "discs, line contact", stepper, reasons)
    told = predicted(row, "evaluations", row.evaluations) if row else None
    warnings += _step_warnings(parameters, stepper)
    return Choice(law, stepper, error, "; ".join(reasons), tuple(warnings), predicted=told)


def off_elements(parameters) -> tuple[float, list[str]]:
    """About the error of line contact against finite elasticity, and where that is much, the kind that knows better.

    It grows with the speed as a share of that of waves, as the strain does; thin discs are not in plane strain, which
    makes the contact longer by 1 / sqrt(1 - nu^2). Both errors have opposite signs where they are small.
    """
    disc = parameters.disc
    share = speed_share(parameters)
    error, why, keys = max(JOHNSON_ERROR, LARGE * share), [], "against: disc"
    if error > JOHNSON_ERROR:
        why.append(f"each disc comes with {share:.2g} of the speed of waves in it")
    if disc.thickness < disc.radius:
        error = max(error, (1.0 - disc.material.poisson_ratio**2) ** -0.5 - 1.0)
        why.append("thinner than their radius they are not in plane strain")
        keys += " and plane: stress"
    if error <= max(2.0 * JOHNSON_ERROR, parameters.wanted.tolerance):
        return error, []
    return error, [
        f"line contact is about {100.0 * error:.2g} % off finite elasticity here: {', and '.join(why)}; kind: "
        f"soft_discs with {keys} computes it"
    ]


def _step_warnings(parameters, stepper: str) -> tuple[str, ...]:
    expected = pair_contact_time(parameters)
    if stepper not in FIXED_STEP or parameters.solver.step <= expected / FEW_STEPS:
        return tuple(idle_step(parameters.solver.step, stepper, FIXED_STEP))
    return (
        f"solver.step = {parameters.solver.step:g} s is less than {FEW_STEPS} steps a contact: restitution may be off "
        f"by 2 %; use {expected / FEW_STEPS:.3g} s or less",
    )
