"""The model of soft discs: one method, on a mesh whose error is known."""

from bearing_twin.kinds.charted import in_words, predicted, row_of
from bearing_twin.kinds.soft_discs.derived import predicted_error, predicted_seconds, predicted_step
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene
from bearing_twin.report import Choice

STEPPER = "central_differences"
LONG = 60.0  # s


def choose(parameters: SoftDiscsScene) -> Choice:
    """The formulation as law; its error is that of the mesh, measured on the mean problem of paper 3, section 5.2."""
    mesh, tolerance = parameters.mesh, parameters.wanted.tolerance
    error, seconds = predicted_error(mesh.order, mesh.divisions), predicted_seconds(parameters)
    warnings = []
    if error > tolerance:
        warnings.append(
            f"mesh.divisions = {mesh.divisions} of order {mesh.order} errs by about {error:.1g} in the force, more "
            f"than wanted.tolerance = {tolerance:g}; leave mesh.divisions out to have it chosen"
        )
    if seconds > LONG:
        warnings.append(f"this run takes about {seconds:.2g} s on one processor")
    row = row_of("discs", "mesh", f"order {mesh.order}", mesh.divisions)
    reason = f"{mesh.divisions} divisions of order {mesh.order}: the force is known to about {error:.1g}"
    reason += f"; {in_words('discs', row, tolerance, 'divisions:')}" if row else ""
    told = predicted(row, "steps", 0.0, 1.0 / predicted_step(parameters)) if row else None
    told = told and told | {"force_error": error}
    return Choice(parameters.formulation, STEPPER, error, reason, tuple(warnings), predicted=told)
