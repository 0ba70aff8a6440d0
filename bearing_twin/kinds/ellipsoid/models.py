"""Law and stepper of an ellipsoid on a plane, by the rules; a law is judged over the whole surface."""

from dataclasses import replace

from bearing_twin.base.report import Choice
from bearing_twin.contact.friction import FRICTIONS, roughness
from bearing_twin.kinds.ellipsoid.derived import ellipsoid_mass, law_error_over, shortest_contact
from bearing_twin.kinds.impact.collision import FEW_STEPS
from bearing_twin.kinds.rules import ELLIPSOID, answers, drift, idle_step, odd_mass, sentences

RATIONAL = 1e-9  # no law is called wrong that is as near to exact Hertz as the rational form of hertz


def choose(parameters) -> Choice:
    """Law and stepper of an ellipsoid on a plane."""
    found, solver, warnings = answers(ELLIPSOID, parameters), parameters.solver, []
    law, stepper = found["contact.normal"].value, found["solver.stepper"].value
    error = law_error_over(parameters, law)
    if error > max(parameters.wanted.tolerance, RATIONAL):
        warnings.append(
            f"the law {law} differs by {100.0 * error:.2g} % from exact Hertz somewhere on this body, more than "
            f"wanted.tolerance = {parameters.wanted.tolerance:g}; contact.normal: hertz costs no more"
        )
    whole = ellipsoid_mass(replace(parameters.body, mass=0.0))
    warnings += [
        *odd_mass("body.mass", parameters.body.mass, whole),
        *drift(law),
        *roughness(FRICTIONS[parameters.contact.friction]),
    ]
    warnings += idle_step(solver.step, stepper, ("rk4",))
    if stepper == "rk4" and solver.step > shortest_contact(parameters) / FEW_STEPS:
        warnings.append(
            f"solver.step = {solver.step:g} s is less than {FEW_STEPS} steps a contact: restitution may err by 2 %; "
            f"use {shortest_contact(parameters) / FEW_STEPS:.3g} s or less"
        )
    return Choice(law, stepper, error, sentences(found), tuple(warnings))
