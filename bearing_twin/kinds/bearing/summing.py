"""Outputs of a bearing summed up output by output, so that sums do not depend on how a stream of them is cut."""

import math
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from bearing_twin.base.sample import Block, Layout
from bearing_twin.core import INTEGER, INTEGERS, INTEGERS_OUT, REALS, REALS_OUT, Function

STRETCH = 50  # outputs, by their numbers: sums over the second half of a run begin at the end of such a stretch
STANDING = 1e-12  # of the speed that friction is smoothed over: what slides more slowly stands
MOST_STRETCHES = 256  # that are kept; more are added two by two
RING = {"inner_ring_offset": 3, "inner_ring_tilt": 2, "inner_ring_force": 3, "inner_ring_torque": 2}  # first numbers of
RING_WIDTH = sum(RING.values())
RING_COLUMNS = tuple(slice(end - RING[name], end) for name, end in zip(RING, accumulate(RING.values()), strict=True))
AT_GREATEST = "curvature_small", "curvature_large", "contact_angle", "spin_rate"
CENTRE = "cage_offset", "cage_velocity", "land_force"
_READ = (
    "normal_load", "raceway_torque", "inner_ring_torque", "roll_rate", "inner_ring_speed", "cage_slip", "orbit_angle",
    "pocket_force", "drive_work", "inner_ring_angle", "inner_ring_load_work", *AT_GREATEST, *RING, *CENTRE,
)  # fmt: skip
MISSING = -1  # in the place of the first column of a channel that is not there
# What logs of earlier versions have not: its numbers were 0, or are not known.
MAY_BE_MISSING = {"cage_slip", "pocket_force", "inner_ring_load_work", *CENTRE}


class Greatest(NamedTuple):
    """What is kept of single contacts (2 N,), of a ball's inner one and outer one in turn, over all outputs.

    The greatest load and AT_GREATEST (4, 2 N) there; outputs without a load. `off_even` (1,) [rad] is how far a gap
    between neighbours came off even spacing, `pocket_force` (1,) [N] the greatest of a cage on a ball,
    `land_force` (1,) [N] that of a land on the cage.
    """

    load: np.ndarray
    there: np.ndarray
    without: np.ndarray
    off_even: np.ndarray
    pocket_force: np.ndarray
    land_force: np.ndarray


class StretchSums(NamedTuple):
    """Sums over stretches of outputs, one row each; times [s] and orbit angles (N,) are those of their last outputs.

    So are `turned` (2,), the work [J] of turning the inner ring and its angle [rad].
    Contacts (2 N,) stand as in `Greatest`; `ring` (RING_WIDTH,) has the columns of RING side by side. `centre` (3,): of
    the cage's centre, distance from the axis [m], its square, and x dy/dt - y dx/dt [m^2/s].
    """

    time: np.ndarray
    orbit_angle: np.ndarray
    turned: np.ndarray
    count: np.ndarray
    load: np.ndarray
    torque: np.ndarray
    drive_torque: np.ndarray
    roll_rate: np.ndarray
    speed: np.ndarray
    cage_slip: np.ndarray
    centre: np.ndarray
    ring: np.ndarray
    ring_least: np.ndarray
    ring_greatest: np.ndarray


_sum_outputs = Function(
    "core_sum_outputs",
    None,
    (
        *(INTEGERS, REALS, INTEGER, INTEGER, INTEGERS, INTEGER, INTEGER, INTEGER),
        *(REALS_OUT, REALS_OUT, INTEGER, INTEGER, INTEGERS_OUT),
    ),
)
LAST = "time", "orbit_angle", "turned"
TOGETHER = {"ring_least": np.minimum, "ring_greatest": np.maximum}  # all others are added


def new_greatest(balls: int) -> np.ndarray:
    """The numbers of a `Greatest` that has seen nothing yet, side by side as the core takes them."""
    return np.zeros(2 * balls * (len(AT_GREATEST) + 2) + 3)


def named_greatest(room: np.ndarray, balls: int) -> Greatest:
    """The same numbers by their names."""
    widths = 2 * balls, len(AT_GREATEST) * 2 * balls, 2 * balls, 1, 1
    load, there, without, *single = np.split(room, np.cumsum(widths))
    return Greatest(load, there.reshape(len(AT_GREATEST), -1), without, *single)


def new_stretches(count: int, balls: int) -> np.ndarray:
    """Sums over `count` stretches without an output, a row each, as the core takes them."""
    return np.zeros((count, 4 * balls + 3 * RING_WIDTH + 11))


def named_stretches(room: np.ndarray, balls: int) -> StretchSums:
    """The columns of these sums by their names."""
    widths = {"orbit_angle": balls, "turned": 2, "load": 2 * balls, "torque": balls, "centre": 3}
    widths |= dict.fromkeys(("ring", "ring_least", "ring_greatest"), RING_WIDTH)
    ends = list(accumulate(widths.get(name, 1) for name in StretchSums._fields))
    named = zip(StretchSums._fields, np.split(room, ends[:-1], axis=1), strict=True)
    return StretchSums(*(part if name in widths else part[:, 0] for name, part in named))


def columns_of(layout: Layout) -> np.ndarray:
    """The first column of each channel that is read in a row of all channels; raises ChannelError for one too few."""
    missing = MAY_BE_MISSING.difference(layout.places)
    missing |= set(CENTRE) if missing.intersection(CENTRE) else set()
    return np.array([MISSING if name in missing else layout.places[name][0].start for name in _READ])


class Sums:
    """The stretches of a run so far, in memory that does not grow with it, and the greatest of its contacts."""

    def __init__(self, balls: int):
        self.outputs = self.stretches = 0
        self._balls, self._greatest = balls, new_greatest(balls)
        self._rows = new_stretches(MOST_STRETCHES + 1, balls)

    @property
    def greatest(self) -> Greatest:
        """The greatest of all contacts so far."""
        return named_greatest(self._greatest, self._balls)

    @property
    def _kept(self) -> StretchSums:
        return named_stretches(self._rows, self._balls)

    def add(self, block: Block, columns: np.ndarray) -> None:
        """Takes in a block that ends, unless it is the last, before a sequence number divisible by STRETCH."""
        numbers, times, done = block.matrix(), block.time_ns, 0
        while done < len(block):
            rest, ended = numbers[done:], np.array([0, self.stretches])
            _sum_outputs(
                *(columns, rest, *rest.shape, times[done:], block.first_sequence + done, STRETCH, self._balls),
                *(self._greatest, self._rows, *self._rows.shape, ended),
            )
            taken, self.stretches = ended.tolist()
            done += taken
            if self.stretches > MOST_STRETCHES:
                self._halve()
        self.outputs += len(block)

    def _halve(self) -> None:
        """Makes one stretch of every two; of an odd number the last stays as it is."""
        pairs, odd = divmod(self.stretches, 2)
        for name, kept in self._kept._asdict().items():
            one, other = kept[0 : 2 * pairs : 2], kept[1 : 2 * pairs : 2]
            both = other.copy() if name in LAST else TOGETHER.get(name, np.add)(one, other)
            kept[pairs] = kept[self.stretches - 1]
            kept[:pairs] = both
            kept[pairs + odd :] = 0.0
        self.stretches = pairs + odd

    def from_row(self, first: int) -> dict:
        """All stretches from number `first` on as one, by the names of `StretchSums`."""
        found = {}
        for name, kept in self._kept._asdict().items():
            rows = kept[first : self.stretches]
            found[name] = rows[-1] if name in LAST else TOGETHER.get(name, np.add).reduce(rows, axis=0)
        return found

    def ends(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times [s] (n,), orbit angles [rad] (n, N) and `turned` (n, 2) at the ends of all stretches."""
        rows = slice(self.stretches)
        return self._kept.time[rows], self._kept.orbit_angle[rows], self._kept.turned[rows]


def centre_figures(centre: np.ndarray, greatest: Greatest) -> dict[str, float]:
    """Eccentricity [m], whirl [rad/s] of the cage's centre from means of `StretchSums.centre`; the land's force [N]."""
    distance, square, turned = centre.tolist()
    return {
        "cage_eccentricity_m": distance,
        "cage_whirl_rad_s": turned / square if square > 0.0 else 0.0,
        "greatest_land_force_n": float(greatest.land_force[0]),
    }


def turning(parameters, speed: float) -> float:
    """A speed of balls [rad/s] as a figure holds it: 0 where it is rounding beside what friction is smoothed over."""
    slowest = STANDING * parameters.contact.friction_regularisation / (0.5 * parameters.geometry.ball_diameter)
    return 0.0 if abs(speed) <= slowest else float(speed)


def mean_torque(late: dict, before: dict, known: bool) -> float:
    """The mean torque of the drive [N m] over `late`, which follows the instant `before`.

    Where the work of turning is `known` it is work over angle, which keeps no noise of single outputs; else, or where
    the ring did not turn, the mean of the outputs.
    """
    (work, angle), (work_before, angle_before) = late["turned"], before["turned"]
    if not known or angle == angle_before or math.isnan(work):
        return float(late["drive_torque"] / late["count"])
    return float((work - work_before) / (angle - angle_before))
