"""What figures of a bearing run are off where its contacts bear more or less than they should."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.kinds.bearing.drilling import SIDES
from bearing_twin.kinds.bearing.law_error import spots_off
from bearing_twin.kinds.bearing.quasi_static.model_error import LOADS_OF, Worth


def by_load(geometry, figures: Mapping[str, Any], load, share, worth: Worth | None, given: bool) -> dict[str, Any]:
    """Errors of figures where contacts are off by these shares (N, 2) of their load at the same approach.

    `load` (N, 2) [N] is their greatest, `worth` the equilibrium that stands for the run. What all contacts share scales
    their sum on a ring that is held, and only moves one whose load is `given`; what they do not share need not cancel.
    """
    greatest = float(share.max(initial=0.0))
    uneven = float(np.ptp(share[load[:, 0] > 0.0, 0])) if load[:, 0].any() else 0.0
    pitch = 0.5 * geometry.pitch_diameter
    carried = math.fsum(abs(one) for one in figures["normal_load_inner_n"])
    kept = share if worth is None else worth.kept * share
    found = {
        f"{key}_{side}_n": [float(kept[ball, place]) * abs(value) for ball, value in enumerate(values)]
        for key in LOADS_OF
        for place, side in enumerate(SIDES)
        for values in [figures[f"{key}_{side}_n"]]
    }
    if worth is not None:
        moved, ring = (np.abs(one) for one in (worth.response.coordinates, worth.response.ring_loads))
    else:
        moved, ring = np.zeros(5), np.zeros(5)
        for part, key, arm in ((slice(3), "ring_force_n", 1.0), (slice(3, 5), "ring_moment_nm", pitch)):
            ring[part] = 0.0 if given else greatest * max(map(abs, figures[key])) + arm * uneven * carried
        for part, key in ((slice(3), "ring_displacement_m"), (slice(3, 5), "misalignment_rad")):
            moved[part] = 2.0 / 3.0 * greatest * math.hypot(*figures.get(key, ())) if given else 0.0
    return {
        **found,
        **spots_off(figures, share),
        "ring_force_n": ring[:3].tolist(),
        "ring_moment_nm": ring[3:].tolist(),
        "ring_displacement_m": moved[:3].tolist(),
        "misalignment_rad": moved[3:].tolist(),
    }
