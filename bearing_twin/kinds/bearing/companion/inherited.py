"""What no window of a bearing run sees: what its balls and its ring are off from before, and what that does.

A moving ring carries on what it is off until its contacts have damped it. Errors of steps are as often one way as the
other, so that they add up as a random walk does: with the root of that time over the time of the window they were seen
in. What a ring is off, or a ball on its way round, makes loads err; where a contact bears little, that is much of its
load, and as much of its friction. Windows are short and lie elsewhere: both are therefore found from what all outputs
say of friction and load, and recorded as a row of WINDOW of its own.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elastic import elastic
from bearing_twin.kinds.bearing.companion.deviations import LEAST_LOAD, Part
from bearing_twin.kinds.bearing.companion.pointers import lengths
from bearing_twin.kinds.bearing.companion.windows import ALL, BUMPING, INHERITED, PLACE, WINDOW, carries
from bearing_twin.kinds.bearing.forces.equations import Bearing

NOTHING = (0.0, 0.0, 0.0)  # see `carried_on`
ERRORS = slice(PLACE["load"], None)  # of a row of WINDOW


def ringing_time(parameters, bearing: Bearing, greatest: float) -> float:
    """Time [s] in which a ring that rings on the ball that bears most, `greatest` [N], falls to a tenth; 0 without one.

    A mass m on two contacts of stiffness k in series, each with a viscous term k times the relaxation time.
    """
    if not carries(parameters) or greatest <= 0.0:
        return 0.0
    law = bearing.inner.law
    stiffness = 0.5 * elastic(law.given, law.power, (greatest / law.given) ** (1.0 / law.power)).stiffness
    damping = stiffness * bearing.relaxation_time
    return math.log(10.0) * 2.0 * parameters.rings.inner.mass / damping if damping > 0.0 else math.inf


def light_share(part: Part, greatest: float) -> float:
    """How much friction errs, over mu N, where approaches are off by what changes the greatest load by its whole.

    The contact that feels it most: its load changes with its stiffness, as N^(1 - 1/p), and its friction with its load.
    """
    coefficient = part.bearing.friction_coefficient
    if coefficient <= 0.0 or greatest <= 0.0:
        return 0.0
    load, law = part.out["normal_load"], part.bearing.inner.law
    rubs = lengths(part.out["friction_force"]) / np.maximum(load, LEAST_LOAD * greatest)
    bears = load > 0.0
    felt = rubs[bears] * (greatest / load[bears]) ** (1.0 / law.power)
    return float(felt.max(initial=0.0)) / coefficient


def all_of_it(part_began: float, now: float, tolerance: float, greatest: float) -> np.ndarray:
    """A row of WINDOW of a part of which nothing is known: loads off by the `greatest` [N], friction by twice mu N."""
    row = np.zeros((1, len(WINDOW.columns)))
    row[0, : PLACE["torque"]] = now, part_began, INHERITED, 0.0, tolerance, greatest, 2.0
    return row


def thrown(part: Part) -> bool:
    """Whether a ring is thrown across its clearance: some ball then touches neither raceway at an output."""
    return bool((part.out["normal_load"].max(axis=2) == 0.0).any())


class Carried(NamedTuple):
    """Rows of WINDOW with that of what a part inherits, if it is more than was told before; what is then known.

    `added` are the rows with what the part itself adds, which alone another go at it betters; `before` is the row of
    what it has from before.
    """

    rows: np.ndarray
    added: np.ndarray
    before: np.ndarray
    known: tuple


def carried_on(known: tuple, part: Part, rows: np.ndarray, seconds: float, around: float, greatest: float) -> Carried:
    """What a part that began with what is `known` inherits, beside these rows of WINDOW.

    `seconds` a ring goes on with what it is off; `around` [rad] balls may be off their way round. Known are the
    greatest share of `light_share`, how far loads are off [N], which falls as the ring rings down, and what was told of
    friction. What a ring that is thrown against its balls is off grows with each blow, as where balls bump into a cage.
    """
    light, off, told = known
    row = np.zeros(len(WINDOW.columns))
    row[: PLACE["load"]] = part.elapsed + part.duration, part.elapsed, INHERITED, 0.0, rows[0, PLACE["tolerance"]]
    before, whole = row.copy(), rows[rows[:, PLACE["ball"]] == ALL] if seconds else rows[:0]
    for one in whole:
        # How far balls are off their way round nothing damps.
        until = np.where(np.arange(len(row)) == PLACE["orbit_angle"], one[0], min(one[0], seconds))
        longer = np.sqrt(np.maximum(until / (one[0] - one[PLACE["begin"]]), 1.0))
        row[ERRORS] = np.maximum(row, longer * one)[ERRORS]
    now = float(row[PLACE["load"]]) + around * float(np.ptp(part.out["normal_load"]))
    if seconds and thrown(part):
        before[PLACE["load"]] = off = min(BUMPING * off, greatest)
    light = max(light, light_share(part, greatest))
    for one, load in ((row, now), (before, off)):
        one[PLACE["friction"]] = max(float(one[PLACE["friction"]]), light * load / greatest if greatest else 0.0)
    later = max(now, off * (10.0 ** (-part.duration / seconds) if seconds else 1.0))
    both = np.maximum(row, before)
    friction = float(both[PLACE["friction"]])
    if friction <= max(told, float(rows[:, PLACE["friction"]].max())) and not len(whole):
        return Carried(rows, rows, before[None], (light, later, told))
    known = light, later, max(told, friction)
    return Carried(*(np.concatenate([rows, one[None]]) for one in (both, row)), before[None], known)
