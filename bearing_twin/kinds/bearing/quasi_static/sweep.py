"""Equilibria over a load or over a number of the scene: the curves of `bearing_twin bearing --sweep`."""

from collections.abc import Callable, Iterable

import numpy as np

from bearing_twin.errors import SceneError

EACH = ("ring_displacement_m", "misalignment_rad", "ring_force_n", "ring_moment_nm", "stiffness")
ALONE = ("basic_life_mrev", "reference_life_mrev", "static_safety")
GREATEST = ("normal_load_inner_n", "normal_load_outer_n", "contact_angle_inner_rad", "peak_pressure_inner_pa")


def curves_of(values: Iterable[float], solved: Callable[[float], dict]) -> dict:
    """Curves over `values`: lists with one entry a value, None where `solved(value)` raises SceneError.

    `greatest_<key>` is the greatest magnitude over the balls, `loaded_balls` counts those between both rings; `refused`
    holds the value and the reason of each that has no equilibrium.
    """
    curves = {key: [] for key in (*EACH, *ALONE, *(f"greatest_{key}" for key in GREATEST), "loaded_balls")}
    refused = []
    for value in values:
        try:
            found = solved(value)
        except SceneError as error:
            refused.append({"value": value, "reason": str(error)})
            row = dict.fromkeys(curves)
        else:
            row = {key: found[key] for key in (*EACH, *ALONE)}
            row |= {f"greatest_{key}": float(np.abs(found[key]).max()) for key in GREATEST}
            row["loaded_balls"] = sum(load > 0.0 for load in found["normal_load_inner_n"])
        for key, curve in curves.items():
            curve.append(row[key])
    if len(refused) == len(curves["stiffness"]):
        raise SceneError(f"no value of this sweep has an equilibrium; at the first: {refused[0]['reason']}")
    return curves | {"refused": refused}
