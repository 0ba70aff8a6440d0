"""The mesh of soft discs, by the rules, and what a user should know of one that is fixed."""

from bearing_twin.base.report import Choice
from bearing_twin.kinds.rules import SOFT, answers, sentences
from bearing_twin.kinds.soft_discs.derived import predicted_error, predicted_seconds
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

LONG = 60.0  # s


def choose(parameters: SoftDiscsScene) -> Choice:
    """The formulation as law; its error is that of the mesh, measured on the mean problem of paper 3, section 5.2."""
    ratio = parameters.contact.stiffness_ratio
    found, mesh, tolerance = answers(SOFT, parameters), parameters.mesh, parameters.wanted.tolerance
    error, seconds = predicted_error(mesh.order, mesh.divisions, ratio), predicted_seconds(parameters)
    warnings = []
    if error > tolerance:
        warnings.append(
            f"mesh.divisions = {mesh.divisions} of order {mesh.order} errs by about {error:.1g} in the force, more "
            f"than wanted.tolerance = {tolerance:g}; leave mesh.divisions out to have it chosen"
        )
    if seconds > LONG:
        warnings.append(f"this run takes about {seconds:.2g} s on one processor")
    stepper = found["solver.stepper"].value
    return Choice(parameters.formulation, stepper, error, sentences(found), tuple(warnings))
