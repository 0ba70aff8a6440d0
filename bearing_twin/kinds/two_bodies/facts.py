"""Numbers and conditions of two bodies that rules and ranges of models are about, known before they move."""

from bearing_twin.contact.ellipse import axis_ratio as ratio_of
from bearing_twin.kinds.two_bodies.derived import ROWS, start_contact
from bearing_twin.shapes.opposing import closed_form_known

FLAT = "superellipsoid"  # the only shape that may have flat places


def axis_ratio(parameters) -> float:
    """b/a of the contact that the scene starts from; raises SceneError where that is no ellipse."""
    start = start_contact(parameters)
    return ratio_of(start.curvature_small, start.curvature_large)


def greatest_exponent(parameters) -> float | None:
    """Of both bodies; None where neither is a superellipsoid."""
    bodies = (parameters.first, parameters.second)
    return max((max(one.exponents) for one in bodies if one.shape == FLAT), default=None)


def has_closed_form(parameters) -> bool:
    """True if a closed form gives the opposing points of both shapes."""
    return closed_form_known(*(ROWS[one.shape].surface(one).kind for one in (parameters.first, parameters.second)))
