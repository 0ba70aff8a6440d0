"""Law, dimension, friction and stepper of a bearing, by the rules, and warnings of what a scene fixes."""

import math

from bearing_twin.base.report import Choice
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import AUTO, FRICTIONS, roughness
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bearing.facts import (
    axis_ratio,
    of_falling_balls,
    of_held_ring,
    of_temperatures,
    rim_speed,
    without_friction,
)
from bearing_twin.kinds.bearing.geometry import nominal_curvatures
from bearing_twin.kinds.bearing.model_error import rule_error
from bearing_twin.kinds.bearing.rings import PRESCRIBED, QUASI_STATIC
from bearing_twin.kinds.bearing.step_limits import FIXED_STEP
from bearing_twin.kinds.ranges import left_by
from bearing_twin.kinds.rules import BEARING, SETTING, answers, drift, idle_step, pick, sentences


def law_error(law: str, parameters) -> float:
    """Greatest relative load error of a law against exact Hertz at a bearing's two nominal contacts; 0 if measured."""
    if LAWS[law].measured:
        return 0.0
    worst = 0.0
    for small, large in nominal_curvatures(parameters.geometry):
        exact = hertz_coefficient(small, large, 1.0)
        worst = max(worst, abs(coefficient_of(law, small, large, 1.0, exact) / exact - 1.0))
    return worst


def _coarse_points(parameters, friction: str) -> list[str]:
    """A warning of a rule of points over the contact patch that a scene fixes, and that its spin is too fast for."""
    if parameters.contact.friction == AUTO or not FRICTIONS[friction].over_spot or without_friction(parameters):
        return []
    error = rule_error(parameters.contact, axis_ratio(parameters), rim_speed(parameters))
    if error <= parameters.wanted.tolerance:
        return []
    enough = pick(BEARING, "contact.friction", parameters).value
    return [
        f"contact.friction = {friction} errs by up to {error:.2g} of mu N where balls spin as fast as here, more than "
        f"wanted.tolerance = {parameters.wanted.tolerance:g}; auto takes {enough}"
    ]


def choose(parameters) -> Choice:
    """Law, dimension, friction and stepper; raises SceneError where a scene has no equilibrium to start from."""
    found = answers(BEARING, parameters)
    law, dimension = found["contact.normal"].value, found["model.dimension"].value
    error, wanted, warnings = law_error(law, parameters), parameters.wanted.tolerance, []
    if error > wanted:
        warnings.append(
            f"the law {law} differs by {100 * error:.2g} % from exact Hertz here, more than the tolerance of "
            f"{100 * wanted:.2g} %; contact.normal: hertz costs no more"
        )
    warnings += [*drift(law), *of_temperatures(parameters)]
    if dimension == QUASI_STATIC:
        for key in ("cage.kind", "contact.friction", "solver.stepper", SETTING):
            found.pop(key)
        if parameters.model.dimension == AUTO:
            warnings += left_by(parameters, ("model.dimension", dimension))
        if parameters.solver.stepper != AUTO:
            warnings.append("solver.stepper does nothing in a run from equilibria, which has no steps")
        return Choice(law, QUASI_STATIC, error, sentences(found), tuple(warnings))
    stepper, friction = found["solver.stepper"].value, found["contact.friction"].value
    if dimension == PRESCRIBED:
        warnings += of_held_ring(parameters)
    warnings += [*idle_step(parameters.solver.step, stepper, FIXED_STEP), *roughness(FRICTIONS[friction])]
    warnings += [*_coarse_points(parameters, friction), *of_falling_balls(parameters, law)]
    named = friction if parameters.contact.friction == AUTO else ""
    setting = found[SETTING].value if parameters.solver.stepper == AUTO else math.nan
    if parameters.solver.stepper != AUTO:
        found.pop(SETTING)
    return Choice(law, stepper, error, sentences(found), tuple(warnings), setting, friction=named)
