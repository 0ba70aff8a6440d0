"""Numbers of a bearing scene that ranges of models are about, known before it runs."""

import math

from bearing_twin.contact.ellipse import axis_ratio as ratio_of
from bearing_twin.kinds.bearing.start import nominal_curvatures
from bearing_twin.kinds.bearing.still import share_at_start


def axis_ratio(parameters) -> float:
    """b/a of the narrower ellipse of the two nominal contacts."""
    return min(ratio_of(*pair) for pair in nominal_curvatures(parameters.geometry))


def slip_at_start(parameters) -> float:
    """What the balls lack of rolling at the start, as a share of it."""
    return 1.0 if parameters.initial.motion == "rest" and parameters.drive.speed else 0.0


def ring_shift(parameters) -> float:
    """How far [m] the ring jumps under way."""
    return math.hypot(*parameters.drive.change.offset) if parameters.drive.change.time else 0.0


def centrifugal_share(parameters) -> float:
    """The greatest centrifugal load over the load on the inner raceway, at the start; raises SceneError."""
    law = parameters.contact.normal
    return share_at_start(parameters, "hertz" if law == "auto" else law)
