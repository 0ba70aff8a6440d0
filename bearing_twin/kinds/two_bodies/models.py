"""Law and stepper of two bodies."""

from bearing_twin.contact.elasticity import coefficient_of
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS, roughness
from bearing_twin.contact.laws import LAWS
from bearing_twin.errors import SceneError
from bearing_twin.kinds.charted import in_words, row_of
from bearing_twin.kinds.law_words import HERTZ_FOLLOWS, drift
from bearing_twin.kinds.two_bodies.derived import start_contact, tracking_of
from bearing_twin.kinds.two_bodies.parameters import OVERLAP, TRACKINGS
from bearing_twin.report import Choice


def law_error(parameters, law: str) -> float:
    """Relative load error of a law against exact Hertz at the contact the scene starts from; 0 where none is told."""
    if law == OVERLAP or LAWS[law].measured or LAWS[law].state is not None:
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
    """`hertz`, or `overlap` where a body may be flat; one stepper. A law further off than what is wanted is named."""
    contact, warnings = parameters.contact, []
    flat = "superellipsoid" in (parameters.first.shape, parameters.second.shape)
    law = (OVERLAP if flat else "hertz") if contact.normal == "auto" else contact.normal
    if contact.normal != "auto":
        reason = f"{law}, as the scene asks"
    elif flat:
        reason = "overlap, because a superellipsoid has places where no contact is an ellipse"
    else:
        reason = HERTZ_FOLLOWS
    error = law_error(parameters, law)
    if error > parameters.wanted.tolerance and not flat:
        warnings.append(
            f"the law {law} is {100.0 * error:.2g} % off exact Hertz here, more than wanted.tolerance = "
            f"{parameters.wanted.tolerance:g}; contact.normal: hertz is exact"
        )
    warnings += drift(law)
    warnings += roughness(FRICTIONS[contact.friction])
    wanted, tracking = parameters.wanted.tolerance, TRACKINGS[tracking_of(parameters)]
    row = row_of("two_bodies", "ball in a groove", tracking, wanted) if contact.tracking == "auto" else None
    told = f"; points {tracking}, {in_words('two_bodies', row, wanted)}" if row else ""
    reason = f"{reason}; dop853, whose steps follow the contact's own time{told}"
    return Choice(law, "dop853", error, reason, tuple(warnings))
