"""The cheapest adequate model for a scene, and why.

`choose` turns facts about a scene (how narrow its ellipses are, how fast contacts ring and friction creeps, how often
outputs are wanted) and the wanted tolerance into an elastic law and a stepper. What a scene pins is kept; a pinned
model that misses the tolerance is named in `warnings`.
"""

from typing import NamedTuple

from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.normal import LAWS, load_coefficient
from bearing_twin.errors import SceneError
from bearing_twin.scene import Scene
from bearing_twin.scenes.bearing_start import bearing_of, fastest_rates, stable_step, start_state

RINGING_OUTPUTS = 0.5
"""Outputs spaced closer than this share of a contact's duration ask for the ringing itself."""


class Choice(NamedTuple):
    """Elastic law and stepper, the law's relative load error at this geometry, the reason, and what to watch."""

    law: str
    stepper: str
    law_error: float
    reason: str
    warnings: tuple[str, ...]


def law_error(law: str, scene: Scene) -> float:
    """Greatest relative load error of a law against exact Hertz at the scene's two nominal contacts."""
    geometry = scene.parameters.geometry
    ball = 2.0 / geometry.ball_diameter
    worst = 0.0
    for side, conformity in ((-1.0, geometry.inner_conformity), (1.0, geometry.outer_conformity)):
        small = 0.5 * (ball - 1.0 / (conformity * geometry.ball_diameter))
        large = 0.5 * (ball - side / (0.5 * geometry.pitch_diameter + side / ball))
        exact = hertz_coefficient(small, large, 1.0)
        worst = max(worst, abs(load_coefficient(LAWS[law], small, large, 1.0, exact) / exact - 1.0))
    return worst


def choose(scene: Scene) -> Choice:
    """Law and stepper for a bearing scene; raises SceneError where the scene has no start."""
    if scene.kind != "bearing":
        raise SceneError(f"no model can be chosen for a scene of kind {scene.kind}; use kind: bearing")
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
        bearing = bearing_of(parameters, law)
        start = start_state(bearing, parameters.drive.speed, parameters.initial.motion)
        rates = fastest_rates(bearing, start, parameters.drive.speed)
        wanted, fixed = 1.0 / parameters.run.output_rate, stable_step(rates)
        if wanted < RINGING_OUTPUTS * rates.shortest_contact and wanted < 8.0 * fixed:
            stepper = "rk4"
            reasons.append(
                f"rk4, because outputs every {wanted:.2g} s follow contacts of {rates.shortest_contact:.2g} s "
                f"and steps of {fixed:.2g} s are needed for them anyway"
            )
        else:
            stepper = "rodas4"
            reasons.append(
                f"rodas4, because outputs every {wanted:.2g} s do not ask for steps of {fixed:.2g} s, "
                "which contact stiffness and friction would force on an explicit method"
            )
    return Choice(law, stepper, error, "; ".join(reasons), tuple(warnings))
