"""What moves a bearing, by the model that was chosen."""

from bearing_twin.base.report import Choice
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.quasi_static.equilibrium_motion import QuasiStaticMotion
from bearing_twin.kinds.bearing.rings import QUASI_STATIC


def moving_by(parameters: BearingScene, choice: Choice):
    """What moves a bearing by the chosen model: equilibria, or balls by their equations of motion."""
    if choice.stepper == QUASI_STATIC:
        return QuasiStaticMotion(parameters, choice)
    return BearingMotion(parameters, choice)
