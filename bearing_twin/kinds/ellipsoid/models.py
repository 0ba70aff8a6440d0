"""Law and stepper of an ellipsoid on a plane: laws are weighed over the whole surface."""

from bearing_twin.contact.friction import FRICTIONS, roughness
from bearing_twin.kinds.charted import TUMBLES, evaluations_of, in_words, predicted, row_of
from bearing_twin.kinds.ellipsoid.derived import law_error_over, shortest_contact
from bearing_twin.kinds.impact.collision import FEW_STEPS
from bearing_twin.kinds.law_words import HERTZ_FOLLOWS, drift, idle_step
from bearing_twin.report import Choice
from bearing_twin.units import two_digits

EARLY = 1  # s, over which the row of one that bounces was made
RATIONAL = 1e-9  # no law is called wrong that is as near to exact Hertz as the rational form of hertz


def choose(parameters) -> Choice:
    """An ellipsoid on a plane: hertz and dop853 unless others are asked for; laws weighed over the whole surface."""
    warnings = []
    pinned, solver = parameters.contact.normal, parameters.solver
    law = "hertz" if pinned == "auto" else pinned
    stepper = "dop853" if solver.stepper == "auto" else solver.stepper
    error = law_error_over(parameters, law)
    reason = HERTZ_FOLLOWS if pinned == "auto" else f"{law}, as the scene asks"
    if error > max(parameters.wanted.tolerance, RATIONAL):
        warnings.append(
            f"the law {law} is {100.0 * error:.2g} % off exact Hertz somewhere on this body, more than "
            f"wanted.tolerance = {parameters.wanted.tolerance:g}; contact.normal: hertz costs no more"
        )
    warnings += drift(law)
    warnings += roughness(FRICTIONS[parameters.contact.friction])
    wanted, told = parameters.wanted.tolerance, None
    if solver.stepper == "auto":
        row = row_of("pairs", "ellipsoid on a plane", stepper, wanted)
        reason += "; dop853, because its steps follow the contact's own time and its error is controlled"
        reason += f"; {in_words('pairs', row, wanted)}"
    else:
        reason += f"; {stepper}, as the scene asks"
    if row := row_of("motions", TUMBLES, stepper, wanted):
        told = predicted(row, "evaluations", a_touch=evaluations_of(row).an_event, output="contact")
        reason += (
            f"; where one bounced ({row.problem}, at {row.setting:g}), contacts were off by {two_digits(row.error)} "
            f"within {EARLY} s, for {two_digits(evaluations_of(row).an_event)} evaluations a touch"
        )
    else:
        reason += "; nothing is foretold of it, as no table has a row of a body that bounces by it"
    warnings += idle_step(solver.step, stepper, ("rk4",))
    if stepper == "rk4" and solver.step > shortest_contact(parameters) / FEW_STEPS:
        warnings.append(
            f"solver.step = {solver.step:g} s is less than {FEW_STEPS} steps a contact: restitution may be off by 2 %; "
            f"use {shortest_contact(parameters) / FEW_STEPS:.3g} s or less"
        )
    return Choice(law, stepper, error, reason, tuple(warnings), predicted=told)
