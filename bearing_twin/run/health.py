"""Checks of every output: what no motion can have ends the run.

Numbers are finite, orientations unit quaternions, lengths and speeds of a size that a scene may have, and no more
energy appears than there was and was brought.
"""

from functools import lru_cache

import numpy as np

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.sample import Block, Channel, layout_of
from bearing_twin.base.units import UNITS
from bearing_twin.core import INTEGER, INTEGERS, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.contract import STORED, Kind

UNIT_NORM = 1e-6  # of a quaternion's length, from 1
BOUNDED = ("m", "m/s", "rad/s")
GAIN = 1.0  # of the energy there was and was brought: a run that gained less goes on, and its report says so
ROUNDING = 1e-9  # of the energies at hand


_within_limits = Function("core_within_limits", INTEGER, (REALS, INTEGER, INTEGER, REALS, INTEGERS, INTEGER, REAL))
_first_gain = Function(
    "core_first_gain", INTEGER, (REALS, INTEGER, INTEGER, INTEGERS, INTEGER, REALS, REAL, REAL, REALS_OUT)
)


class Health:
    """Watches the outputs of one run, from its start or from where it is continued."""

    def __init__(self, kind: Kind, channels: tuple[Channel, ...]):
        places = layout_of(channels).fields
        self._kind = kind
        self._limits, self._rotations = _allowed(channels)
        stored = np.array([places[name][0].start for name in STORED if name in places])
        self._stored = stored if len(stored) == len(STORED) else None
        self._brought = places["gross_work"][0].start if "gross_work" in places else -1
        self._begin: np.ndarray | None = None
        self._energies = np.zeros(2)  # J: the most that was there or was brought so far; what was gained

    def check(self, block: Block) -> None:
        """Raises IntegrationError at the first output that no motion can have."""
        numbers, rotations = block.matrix(), self._rotations
        if not _within_limits(numbers, *numbers.shape, self._limits, rotations, len(rotations), 2.0 * UNIT_NORM):
            self._refuse_unsound(block)
        if self._stored is not None:
            self._check_energy(block)

    def _refuse_unsound(self, block: Block) -> None:
        for channel in block.channels:
            values, limit = block.values[channel.name], _limit(channel)
            self._refuse(block, channel, ~np.isfinite(values), "not finite", "is not finite")
            far = f"is beyond {limit:g} {channel.unit}"
            self._refuse(block, channel, np.abs(values) > limit, "out of bounds", far)
        for channel in filter(_is_rotation, block.channels):
            square = np.square(block.values[channel.name]).sum(axis=-1)
            bad = np.abs(square - 1.0) > 2.0 * UNIT_NORM
            self._refuse(block, channel, bad, "not a rotation", "is no unit quaternion")

    def _check_energy(self, block: Block) -> None:
        numbers = block.matrix()
        if self._begin is None:
            brought = abs(numbers[0, self._brought]) if self._brought >= 0 else 0.0
            self._begin = np.array([*numbers[0, self._stored], brought])
        where = numbers, *numbers.shape, self._stored, self._brought
        row = _first_gain(*where, self._begin, GAIN, ROUNDING, self._energies)
        if row >= 0:
            seconds, (most, gained) = 1e-9 * int(block.time_ns[row]), self._energies
            raise IntegrationError(
                f"at {seconds:.9g} s there are {gained:.3g} J more than at the start, of which {most:.3g} J "
                "were there or were brought; tighten wanted.tolerance or shorten solver.step",
                "energy",
                seconds,
            )

    def _refuse(self, block: Block, channel: Channel, bad: np.ndarray, reason: str, sentence: str) -> None:
        if not bad.any():
            return
        row, *index = np.argwhere(bad)[0].tolist()
        body, contact = self._kind.place_of(channel, tuple(index))
        seconds = 1e-9 * int(block.time_ns[row])
        where = " of " + ", ".join(part for part in (body, contact) if part) if body else ""
        raise IntegrationError(
            f"at {seconds:.9g} s {channel.name}{where} {sentence}; tighten wanted.tolerance or shorten solver.step",
            reason,
            seconds,
            body,
            contact,
        )


@lru_cache(maxsize=64)
def _allowed(channels: tuple[Channel, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The limit of each number of all channels side by side, and where quaternions begin."""
    places = (layout_of(channels).fields[one.name][0] for one in filter(_is_rotation, channels))
    starts = [np.arange(at.start, at.stop, 4) for at in places]
    limits = np.concatenate([np.full(channel.width, _limit(channel)) for channel in channels])
    return limits, np.concatenate([np.empty(0, np.int64), *starts])


def _is_rotation(channel: Channel) -> bool:
    return channel.name == "orientation" and channel.shape[-1:] == (4,)


def _limit(channel: Channel) -> float:
    return UNITS[channel.unit].greatest if channel.unit in BOUNDED else float(np.finfo(float).max)
