"""Numbers of an ellipsoid on a plane that ranges of models are about, known before it falls."""

from bearing_twin.contact.ellipse import axis_ratio as ratio_of
from bearing_twin.kinds.ellipsoid.derived import curvatures_over, law_error_over


def axis_ratio(parameters) -> float:
    """b/a of the narrowest ellipse over the body's surface."""
    return min(ratio_of(*pair) for pair in curvatures_over(parameters))


def coefficient_change(parameters) -> float:
    """The greatest change of Hertz's coefficient over the body's surface, relative to that of the start."""
    return law_error_over(parameters, "constant")
