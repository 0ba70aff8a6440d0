"""Choice of the law, the stepper and the contact points of bodies that collide, by the rules."""

from bearing_twin.base.report import Choice
from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.friction import FRICTIONS, roughness
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bodies.derived import (
    disc_impact_time,
    homogeneous_mass,
    impact_time,
    law_error,
    shortest_bounce,
    speed_share,
)
from bearing_twin.kinds.bodies.parameters import FEW_STEPS, FIXED_STEP, FREE, OVERLAP, EllipsoidOnPlaneScene
from bearing_twin.kinds.rules import BODIES, DISCS, ELLIPSOID, SPHERES, answers, drift, idle_step, odd_mass, sentences

RATIONAL = 1e-9  # no law is called wrong that is as near to exact Hertz as the rational form of hertz
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
    """Two spheres: closed forms wherever they give all that is requested."""
    found = answers(SPHERES, parameters)
    law, stepper = found["contact.normal"].value, found["solver.stepper"].value
    exact = sphere_coefficient("hertz", 1.0, 1.0)
    error = 0.0 if LAWS[law].measured else abs(float(sphere_coefficient(law, 1.0, 1.0) / exact) - 1.0)
    warnings = _odd_masses(parameters) + _step_warnings(parameters.solver, stepper, FIXED_STEP, impact_time(parameters))
    return Choice(law, stepper, error, sentences(found), tuple(warnings))


def choose_discs(parameters) -> Choice:
    """Two discs: Johnson's law unless another is specified, by quadrature when only peaks are requested."""
    found = answers(DISCS, parameters)
    law, stepper = found["contact.normal"].value, found["solver.stepper"].value
    error, warnings = line_contact_error(parameters)
    difference = disc_impact_time(parameters, law) / disc_impact_time(parameters, "johnson") - 1.0
    if abs(difference) > JOHNSON_ERROR:
        warnings.append(
            f"the law {law} gives a contact time {100.0 * difference:.2g} % from Johnson's, "
            "which thick discs follow; contact.normal: johnson costs no more"
        )
    warnings += _step_warnings(parameters.solver, stepper, FIXED_STEP, impact_time(parameters))
    return Choice(law, stepper, error + abs(difference), sentences(found), tuple(warnings))


def line_contact_error(parameters) -> tuple[float, list[str]]:
    """Approximate error of line contact against finite elasticity, and a warning with the better model if it is large.

    It grows with the speed as a share of that of waves, as the strain does; thin discs are not in plane strain, which
    makes the contact longer by 1 / sqrt(1 - nu^2). Both errors have opposite signs where they are small.
    """
    disc, share = parameters.disc, speed_share(parameters)
    error, why, keys = max(JOHNSON_ERROR, LARGE * share), [], "against: disc"
    if error > JOHNSON_ERROR:
        why.append(f"the speed of each disc is {share:.2g} of that of waves in it")
    if disc.thickness < disc.radius:
        error = max(error, (1.0 - disc.material.poisson_ratio**2) ** -0.5 - 1.0)
        why.append("discs thinner than their radius are not in plane strain")
        keys += " and plane: stress"
    if error <= max(2.0 * JOHNSON_ERROR, parameters.wanted.tolerance):
        return error, []
    return error, [
        f"line contact differs from finite elasticity by about {100.0 * error:.2g} % here: {', '.join(why)}; kind: "
        f"soft_discs with {keys} computes it"
    ]


def choose_bouncing(parameters) -> Choice:
    """Law, method and contact points of bodies that bounce; on a plane a law is judged over the whole surface."""
    on_plane = isinstance(parameters, EllipsoidOnPlaneScene)
    found, tolerance, warnings = answers(ELLIPSOID if on_plane else BODIES, parameters), parameters.wanted.tolerance, []
    law, stepper = found["contact.normal"].value, found["solver.stepper"].value
    error = law_error(parameters, law)
    if law != OVERLAP and error > max(tolerance, RATIONAL):
        warnings.append(
            f"the law {law} differs by {100.0 * error:.2g} % from exact Hertz here, more than wanted.tolerance = "
            f"{tolerance:g}; contact.normal: hertz costs no more"
        )
    warnings += [*_odd_masses(parameters), *drift(law), *roughness(FRICTIONS[parameters.contact.friction])]
    if on_plane:
        warnings += _step_warnings(parameters.solver, stepper, ("rk4",), shortest_bounce(parameters))
    return Choice(law, stepper, error, sentences(found), tuple(warnings))


def _odd_masses(parameters) -> list[str]:
    pairs = zip(parameters.names, parameters.bodies, strict=True)
    given = [(name, one) for name, one in pairs if one.mass and one.motion == FREE]
    return [warning for name, one in given for warning in odd_mass(f"{name}.mass", one.mass, homogeneous_mass(one))]


def _step_warnings(solver, stepper: str, fixed: tuple[str, ...], contact_time: float) -> list[str]:
    """Of a step that is long for a contact, or that does nothing as only the steppers `fixed` take it."""
    if stepper not in fixed or solver.step <= contact_time / FEW_STEPS:
        return idle_step(solver.step, stepper, fixed)
    return [
        f"solver.step = {solver.step:g} s is less than {FEW_STEPS} steps a contact: restitution may be wrong by 2 %; "
        f"use {contact_time / FEW_STEPS:.3g} s or less"
    ]
