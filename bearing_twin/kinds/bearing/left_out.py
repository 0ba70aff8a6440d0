"""What a bearing scene leaves out: one row each, a sentence where it applies, and a number where one is computed."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from bearing_twin.base.units import LUBRICATED
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.kinds.bearing.drive import TORQUE, shaft_inertia
from bearing_twin.kinds.bearing.outputs import has_films
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, dimension_of, free_coordinates, moving_centre


class LeftOut(NamedTuple):
    """Something that real bearings have: whether a scene lacks it, and what is to be said of its effect."""

    applies: Callable[[object], bool]
    sentence: str


ROWS = {
    "film": LeftOut(
        lambda parameters: not has_films(parameters),
        "no oil film: its thickness, its rolling resistance and what oil takes along are not computed",
    ),
    LUBRICATED: LeftOut(
        has_films,
        "films are steady ones, at the temperature given: churning, seals and fresh grease are not computed, and a "
        "measured torque may differ by half",
    ),
    "vibration": LeftOut(
        lambda parameters: dimension_of(parameters) != QUASI_STATIC,
        "balls and rings are rigid outside their contacts: energy that goes into their vibration is not computed",
    ),
    "cage": LeftOut(
        lambda parameters: parameters.cage.kind == "none",
        "no cage: its friction and its pushes on the balls are not computed; cage.kind: pockets has them",
    ),
    "cage_guidance": LeftOut(
        lambda parameters: parameters.cage.kind != "none" and not moving_centre(parameters),
        "the cage stays centred: what guides it, and its friction there, are not computed; cage.guidance has them",
    ),
    "cage_tilt": LeftOut(
        moving_centre,
        "the cage moves in its plane alone: its tilt, and what it does along the axis, are not computed",
    ),
    "whirl": LeftOut(
        lambda parameters: (
            dimension_of(parameters) == QUASI_STATIC
            and any(free_coordinates(parameters))
            and not parameters.rings.inner.mass
            and parameters.contact.friction_coefficient > 0.0
        ),
        "whether the ring stays in its equilibrium: friction along the grooves can make it whirl, which is looked at "
        "where rings.inner.mass is given",
    ),
    "shear": LeftOut(
        lambda parameters: dimension_of(parameters) != QUASI_STATIC,
        "no tangential elasticity: friction answers to slip alone, smoothed by contact.friction_regularisation, so "
        "that creep in rolling is what the smoothing gives",
    ),
}
"""What is left out, by name."""


def left_out(parameters) -> dict[str, str]:
    """The sentences that apply to a scene, by name."""
    return {name: row.sentence for name, row in ROWS.items() if row.applies(parameters)}


def unknown_drilling(parameters) -> str:
    """What errors of the friction model do not hold, of a scene whose friction is chosen; "" for nothing."""
    model, beyond = FRICTIONS[parameters.contact.friction], "not what the motion makes of it, as in roll rates"
    if not model.over_spot:
        return (
            "contact.friction: point holds no drilling: errors hold the torque and the loss that the spots' spin would "
            f"add, {beyond}; contact.friction: spot computes it"
        )
    if dimension_of(parameters) == QUASI_STATIC:
        return ""
    return f"errors hold torque and loss that contact.friction: {model.name} errs by, {beyond}"


def of_torque(parameters, figures: Mapping[str, Any], torque: float, seconds: float) -> dict[str, float]:
    """What friction off by this torque [N m] does in so many seconds: to the drive's torque, or to its speed."""
    if parameters.drive.kind != TORQUE:
        return {"drive_torque_nm": torque}
    faster = torque * seconds / shaft_inertia(parameters)
    work = abs(figures["drive_torque_nm"]) * faster * seconds
    return {"inner_ring_speed_at_end_rad_s": faster, "drive_torque_nm": 0.0, "drive_work_j": work}
