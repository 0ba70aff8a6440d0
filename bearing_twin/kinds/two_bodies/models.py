"""Law, method and contact points of two bodies, by the rules."""

from dataclasses import replace

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS, roughness
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.rules import BODIES, answers, drift, odd_mass, sentences
from bearing_twin.kinds.two_bodies.derived import rigid_of, start_contact
from bearing_twin.kinds.two_bodies.parameters import HELD, OVERLAP


def law_error(parameters, law: str) -> float:
    """Relative load error of a law against exact Hertz at the contact the scene starts from; 0 where none is told."""
    if law == OVERLAP or LAWS[law].measured or LAWS[law].carries:
        # The volumetric law on a circle: further off it is nowhere among ellipses that it is for.
        circle = hertz_coefficient(1.0, 1.0, 1.0)
        return abs(coefficient_of("volumetric", 1.0, 1.0, 1.0, circle) / circle - 1.0) if law == OVERLAP else 0.0
    try:
        start = start_contact(parameters)
    except SceneError:
        return 0.0
    curvatures = start.curvature_small, start.curvature_large, 1.0
    exact = hertz_coefficient(*curvatures)
    return abs(coefficient_of(law, *curvatures, exact) / exact - 1.0)


def choose(parameters) -> Choice:
    """Law, method and contact points of two bodies; a law further off than what is wanted is named."""
    found, contact, warnings = answers(BODIES, parameters), parameters.contact, []
    law = found["contact.normal"].value
    error = law_error(law=law, parameters=parameters)
    if error > parameters.wanted.tolerance and law != OVERLAP:
        warnings.append(
            f"the law {law} differs by {100.0 * error:.2g} % from exact Hertz here, more than wanted.tolerance = "
            f"{parameters.wanted.tolerance:g}; contact.normal: hertz is exact"
        )
    for key, one in {"first.mass": parameters.first, "second.mass": parameters.second}.items():
        if one.mass and one.motion != HELD:
            warnings += odd_mass(key, one.mass, rigid_of(replace(one, mass=0.0)).mass)
    warnings += [*drift(law), *roughness(FRICTIONS[contact.friction])]
    return Choice(law, found["solver.stepper"].value, error, sentences(found), tuple(warnings))
