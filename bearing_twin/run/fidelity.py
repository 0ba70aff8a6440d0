"""The cheapest adequate model for a scene, and why.

`choose` turns facts about a scene (how narrow its ellipses are, how fast contacts ring and friction creeps, how often
outputs are wanted) and the wanted tolerance into an elastic law and a stepper. What a scene pins is kept; a pinned
model that misses the tolerance is named in `warnings`.
"""

from typing import NamedTuple

from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.normal import LAWS, load_coefficient
from bearing_twin.contact.validity import LAW_TOLERANCE
from bearing_twin.kinds.beam import motion as sphere_on_beam
from bearing_twin.kinds.bearing.start import nominal_curvatures
from bearing_twin.kinds.ellipsoid.parameters import law_error_over, shortest_contact
from bearing_twin.kinds.impact.collision import FEW_STEPS, FIXED_STEP
from bearing_twin.kinds.impact.parameters import contact_time_by, pair_contact_time
from bearing_twin.run.scene import Scene

JOHNSON_ERROR = 0.04
"""Of contact times by Johnson's line contact, against plane-strain elasticity of a disc as thick as its radius."""

VOLTERRA_STEPS = 500
"""Steps a contact below which the linear pieces of the Volterra equation are coarse."""


class Choice(NamedTuple):
    """Elastic law and stepper, the law's relative load error at this geometry, the reason, and what to watch."""

    law: str
    stepper: str
    law_error: float
    reason: str
    warnings: tuple[str, ...]


def law_error(law: str, scene: Scene) -> float:
    """Greatest relative load error of a law against exact Hertz at the scene's two nominal contacts."""
    worst = 0.0
    for small, large in nominal_curvatures(scene.parameters.geometry):
        exact = hertz_coefficient(small, large, 1.0)
        worst = max(worst, abs(load_coefficient(LAWS[law], small, large, 1.0, exact) / exact - 1.0))
    return worst


def choose(scene: Scene) -> Choice:
    """Law and stepper for a scene; raises SceneError where a bearing has no start."""
    return CHOOSERS[scene.kind](scene)


def choose_bearing(scene: Scene) -> Choice:
    """Law and stepper for a bearing scene; raises SceneError where the scene has no start."""
    parameters = scene.parameters
    pinned_law, pinned_stepper = parameters.contact.normal, parameters.solver.stepper
    reasons, warnings = [], []

    law = "hertz" if pinned_law == "auto" else pinned_law
    error = law_error(law, scene)
    if pinned_law == "auto":
        reasons.append(
            "hertz, because its rational form is exact to 1e-10 and the cheapest law that follows the curvatures"
        )
    else:
        reasons.append(f"{law}, as the scene asks")
    if error > parameters.solver.tolerance:
        warnings.append(
            f"the law {law} is {100 * error:.2g} % off exact Hertz here, more than the wanted "
            f"{100 * parameters.solver.tolerance:.2g} %; contact.normal: hertz costs no more"
        )

    if pinned_stepper != "auto":
        stepper = pinned_stepper
        reasons.append(f"{stepper}, as the scene asks")
    else:
        stepper = "rodas4"
        reasons.append(
            "rodas4, because it was the cheapest method at every accuracy and in every motion measured, "
            "from settled running to ringing contacts"
        )
    if parameters.contact.friction == "spot":
        reasons.append(
            "friction over the spot, as the scene asks: it resists spin, and a step costs several times more"
        )
    return Choice(law, stepper, error, "; ".join(reasons), tuple(warnings))


def choose_spheres(scene: Scene) -> Choice:
    """Two spheres: closed forms wherever they say all that is wanted."""
    parameters = scene.parameters
    contact, solver = parameters.contact, parameters.solver
    law = "measured" if contact.measured_alpha else "hertz"
    reasons = ["the measured alpha, as the scene asks" if contact.measured_alpha else "hertz, the law of spheres"]
    if solver.stepper != "auto":
        stepper = solver.stepper
        reasons.append(f"{stepper}, as the scene asks")
    elif contact.damping_law == "steady" and contact.restitution < 1.0:
        stepper = "dop853"
        reasons.append("dop853, because steady damping has no closed form for times and forces")
    elif contact.restitution == 1.0:
        stepper = "closed_form"
        reasons.append("closed_form, because contact time, peak force and history are exact without any step")
    elif parameters.run.wanted == "peaks":
        stepper = "closed_form"
        reasons.append("closed_form, because only contact time and peak force are wanted: a quadrature gives them")
    else:
        stepper = "dop853"
        reasons.append("dop853, because the force history with losses needs the differential equation")
    return Choice(law, stepper, 0.0, "; ".join(reasons), _step_warnings(parameters, stepper))


def choose_discs(scene: Scene) -> Choice:
    """Two discs: Johnson's law unless another is asked for, by quadrature when only peaks are wanted."""
    parameters = scene.parameters
    pinned, solver, warnings = parameters.contact.normal, parameters.solver, []
    law = "johnson" if pinned == "auto" else pinned
    if pinned == "auto":
        error, reasons = JOHNSON_ERROR, ["johnson, because thick discs follow its two-dimensional solution"]
    else:
        times = [contact_time_by(parameters, one) for one in (law, "johnson")]
        error, reasons = JOHNSON_ERROR + abs(times[0] / times[1] - 1.0), [f"{law}, as the scene asks"]
        if error > 2.0 * JOHNSON_ERROR:
            warnings.append(
                f"the law {law} gives a contact time {100.0 * (times[0] / times[1] - 1.0):.2g} % from Johnson's, "
                "which thick discs follow; contact.normal: johnson costs no more"
            )
    if solver.stepper != "auto":
        stepper = solver.stepper
        reasons.append(f"{stepper}, as the scene asks")
    elif parameters.run.wanted == "peaks":
        stepper = "closed_form"
        reasons.append("closed_form, because contact time and peak force are a quadrature exact to 1e-12")
    else:
        stepper = "dop853"
        reasons.append("dop853, because a force history is wanted")
    return Choice(law, stepper, error, "; ".join(reasons), (*warnings, *_step_warnings(parameters, stepper)))


def choose_beam(scene: Scene) -> Choice:
    """A sphere on a beam: modes and Hertz spring unless another method is asked for."""
    parameters = scene.parameters
    solver, warnings = parameters.solver, []
    stepper = "modes" if solver.stepper == "auto" else solver.stepper
    if solver.stepper == "auto":
        why = "because cubic forces reach the tolerance in steps that do not follow the highest mode"
    else:
        why = "as the scene asks"
    modes, steps = sphere_on_beam.modes_for(parameters, stepper), sphere_on_beam.steps_for(parameters, stepper)
    few = VOLTERRA_STEPS if stepper == "volterra" else FEW_STEPS
    if steps < few:
        warnings.append(f"solver.steps = {steps} is coarse for {stepper}: contacts may come apart; use {few} or more")
    if stepper == "sinusoidal":
        warnings.append("the force is assumed, not solved for: the beam will receive more energy than the sphere has")
    reason = f"hertz, the law of a sphere on a plane; {stepper}, {why}: modes up to {modes}, {steps} steps a contact"
    return Choice("hertz", stepper, 0.0, reason, tuple(warnings))


def choose_ellipsoid(scene: Scene) -> Choice:
    """An ellipsoid on a plane: hertz and dop853 unless others are asked for; laws weighed over the whole surface."""
    parameters, warnings = scene.parameters, []
    pinned, solver = parameters.contact.normal, parameters.solver
    law = "hertz" if pinned == "auto" else pinned
    stepper = "dop853" if solver.stepper == "auto" else solver.stepper
    error = law_error_over(parameters, law)
    if pinned == "auto":
        reason = "hertz, because its rational form is exact to 1e-10 and the cheapest law that follows the curvatures"
    else:
        reason = f"{law}, as the scene asks"
    if error > LAW_TOLERANCE:
        warnings.append(
            f"the law {law} is {100.0 * error:.2g} % off exact Hertz somewhere on this body; "
            "contact.normal: hertz costs no more"
        )
    if law == "hertz_unprojected":
        warnings.append("nothing pulls the errors of hertz_unprojected back; contact.normal: hertz_differential does")
    if solver.stepper == "auto":
        reason += "; dop853, because its steps follow the contact's own time and its error is controlled"
    else:
        reason += f"; {stepper}, as the scene asks"
    if stepper == "rk4" and solver.step > shortest_contact(parameters) / FEW_STEPS:
        warnings.append(
            f"solver.step = {solver.step:g} s is less than {FEW_STEPS} steps a contact: restitution may be off by 2 %; "
            f"use {shortest_contact(parameters) / FEW_STEPS:.3g} s or less"
        )
    return Choice(law, stepper, error, reason, tuple(warnings))


def _step_warnings(parameters, stepper: str) -> tuple[str, ...]:
    expected = pair_contact_time(parameters)
    if stepper not in FIXED_STEP or parameters.solver.step <= expected / FEW_STEPS:
        return ()
    return (
        f"solver.step = {parameters.solver.step:g} s is less than {FEW_STEPS} steps a contact: restitution may be off "
        f"by 2 %; use {expected / FEW_STEPS:.3g} s or less",
    )


CHOOSERS = {
    "bearing": choose_bearing,
    "two_spheres": choose_spheres,
    "two_discs": choose_discs,
    "sphere_on_beam": choose_beam,
    "ellipsoid_on_plane": choose_ellipsoid,
}
