"""Choice of the law and the stepper of two colliding bodies."""

from bearing_twin.base.report import Choice
from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.impact.collision import FEW_STEPS
from bearing_twin.kinds.impact.derived import contact_time_by, homogeneous_mass, pair_contact_time, speed_share
from bearing_twin.kinds.impact.parameters import FIXED_STEP
from bearing_twin.kinds.rules import DISCS, SPHERES, answers, idle_step, odd_mass, sentences

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
    pair = {"first.mass": parameters.first, "second.mass": parameters.second}
    masses = [one for key, body in pair.items() for one in odd_mass(key, body.mass, homogeneous_mass(body))]
    return Choice(law, stepper, error, sentences(found), (*masses, *_step_warnings(parameters, stepper)))


def choose_discs(parameters) -> Choice:
    """Two discs: Johnson's law unless another is specified, by quadrature when only peaks are requested."""
    found = answers(DISCS, parameters)
    law, stepper = found["contact.normal"].value, found["solver.stepper"].value
    error, warnings = line_contact_error(parameters)
    if parameters.contact.normal != "auto":
        difference = contact_time_by(parameters, law) / contact_time_by(parameters, "johnson") - 1.0
        error += abs(difference)
        if abs(difference) > JOHNSON_ERROR:
            warnings.append(
                f"the law {law} gives a contact time {100.0 * difference:.2g} % from Johnson's, "
                "which thick discs follow; contact.normal: johnson costs no more"
            )
    warnings += _step_warnings(parameters, stepper)
    return Choice(law, stepper, error, sentences(found), tuple(warnings))


def line_contact_error(parameters) -> tuple[float, list[str]]:
    """Approximate error of line contact against finite elasticity, and a warning with the better model if it is large.

    It grows with the speed as a share of that of waves, as the strain does; thin discs are not in plane strain, which
    makes the contact longer by 1 / sqrt(1 - nu^2). Both errors have opposite signs where they are small.
    """
    disc = parameters.disc
    share = speed_share(parameters)
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
        f"line contact differs from finite elasticity by about {100.0 * error:.2g} % here: {', and '.join(why)}; kind: "
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
