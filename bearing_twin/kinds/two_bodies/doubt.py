"""Model errors of two bodies: as of an ellipsoid on a plane."""

from collections.abc import Mapping
from typing import Any

from bearing_twin.kinds.ellipsoid.doubt import ContactComparison, EllipsoidDoubt
from bearing_twin.kinds.two_bodies.figures import TwoBodiesFigures


class TwoBodiesComparison(ContactComparison):
    """As of an ellipsoid on a plane."""


class TwoBodiesDoubt(EllipsoidDoubt):
    """The law against exact Hertz where each contact was hardest."""

    figures_type = TwoBodiesFigures
    frictional = ()  # normal loads change the velocities, too

    def left_out(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """What waves take is known of a sphere on a half-space alone."""
        return {}
