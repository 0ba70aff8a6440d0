"""Model errors of two bodies: as of an ellipsoid on a plane."""

from collections.abc import Mapping
from typing import Any

from bearing_twin.kinds.bouncing import COARSEST, FINEST
from bearing_twin.kinds.ellipsoid.doubt import ContactComparison, EllipsoidDoubt
from bearing_twin.kinds.error_estimates import finer_setting
from bearing_twin.kinds.two_bodies.figures import TwoBodiesFigures
from bearing_twin.kinds.two_bodies.motion import setting_of


class TwoBodiesComparison(ContactComparison):
    """As of an ellipsoid on a plane."""

    def refined(self):
        setting = finer_setting(setting_of(self.parameters, self.choice), FINEST, COARSEST)
        return self.parameters, self.choice._replace(setting=setting)


class TwoBodiesDoubt(EllipsoidDoubt):
    """The law against exact Hertz where each contact was hardest."""

    figures_type = TwoBodiesFigures
    frictional = ()  # normal loads change the velocities, too

    def left_out(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """What waves take is known of a sphere on a half-space alone."""
        return {}
