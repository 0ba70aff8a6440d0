"""What a tilt of first order is off: the circle of the inner groove's centres keeps its radius, a true one does not.

Seen by a ball at an azimuth where the tilt lifts its point of the circle by R b, that circle is nearer to the axis by
R b^2/2. A true contact is pressed less by the cosine of its angle times that, and the moment of what presses it has no
such lever (`forces.ring_seat`). As balls go round, b is the whole tilt for each of them at some time.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.base.sample import Block
from bearing_twin.kinds.bearing.drilling import SIDES
from bearing_twin.kinds.bearing.law_error import spots_off
from bearing_twin.kinds.bearing.quasi_static.model_error import LOADS_OF

POWER = 1.5  # of the load by the approach


class Tilted:
    """The greatest `tilt` [rad] of a run, and how far contacts (balls, 2) were pressed [m] at their greatest loads."""

    def __init__(self, balls: int):
        self.tilt = 0.0
        self.approach = np.zeros((balls, 2))

    def add(self, block: Block, better: np.ndarray, at: tuple) -> None:
        """Takes a block in, whose contacts `at` bear more than all before where that is `better` (balls, 2)."""
        tilt = block.values["inner_ring_tilt"]
        self.tilt = max(self.tilt, float(np.sqrt(np.square(tilt).sum(axis=-1)).max()))
        self.approach[better] = block.values["approach"][at]

    def errors(self, geometry, figures: Mapping[str, Any], load: np.ndarray, given: bool) -> dict[str, Any]:
        """Errors of figures, by their names, with the greatest `load` (balls, 2) [N]; nothing where no ring is tilted.

        `given` are the ring's loads, which otherwise follow from its place.
        """
        if self.tilt == 0.0:
            return {}
        radius = 0.5 * geometry.pitch_diameter + (geometry.inner_conformity - 0.5) * geometry.ball_diameter
        distance = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
        angle = np.abs(figures["contact_angle_inner_rad"])
        lower, cosine, sine = 0.5 * radius * self.tilt**2, np.cos(angle), np.sin(angle)
        pressed = self.approach.sum(axis=1)
        both = load.max(axis=1)
        stiffness = np.divide(POWER * both, pressed, out=np.zeros_like(both), where=pressed > 0.0)
        off = np.minimum(stiffness * cosine * lower, both)
        share = np.divide(off[:, None], load, out=np.zeros_like(load), where=load > 0.0)
        tilt = math.hypot(*figures.get("misalignment_rad", (self.tilt,)))  # mean, as the moment is
        moment = tilt * radius * float(cosine @ np.abs(figures["normal_load_inner_n"]))
        # What a tilt is off whose moment is given, nothing being known of its stiffness but what it was.
        carried = max(map(abs, figures["ring_moment_nm"]))
        turned = min(moment / carried, 1.0) * tilt if carried else tilt
        held = 0.0 if given else 0.5 * float(off.sum())
        return {
            **{f"{key}_{side}_n": off.tolist() for key in LOADS_OF for side in SIDES},
            **{f"contact_angle_{side}_rad": (lower * sine / distance).tolist() for side in SIDES},
            **spots_off(figures, np.minimum(share, 1.0)),
            "ring_force_n": [held] * 3,
            "ring_moment_nm": [moment * (not given)] * 2,
            "ring_displacement_m": [lower * given] * 3,
            "misalignment_rad": [turned * given] * 2,
        }


def added(*parts: Mapping[str, Any]) -> dict[str, Any]:
    """The sum of sets of errors by figure; one that a single one of them names is that one's."""
    found: dict[str, Any] = {}
    for part in parts:
        for key, error in part.items():
            found[key] = np.add(found[key], error).tolist() if key in found else error
    return found
