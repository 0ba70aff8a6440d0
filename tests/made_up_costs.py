"""Tables of what steppers cost, made up: tests of how the chooser reads one do not hang on what was measured last."""

from bearing_twin.kinds.bearing.measured import Rung
from bearing_twin.kinds.bearing.motions import MOTIONS

SETTINGS = (1e-1, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5)
ERRS = {"rodas4": 1e-3, "rodas4_landing": 1e-3, "rodas3": 5e-3}  # times the setting


def made_up_ladders(**costs: dict[str, float]) -> dict[tuple[str, str], tuple[Rung, ...]]:
    """What `measured.ladders` gives, for steppers by what they cost in motions, at all settings; 1 in other motions."""
    return {
        (motion, stepper): tuple(
            Rung(one, 0.1 * ERRS[stepper] * one, ERRS[stepper] * one, dear.get(motion, 1.0)) for one in SETTINGS
        )
        for stepper, dear in costs.items()
        for motion in MOTIONS
    }
