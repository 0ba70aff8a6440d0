"""Checks of every output: impossible values end the run.

Numbers are finite, orientations unit quaternions, lengths and speeds of a size that a scene may have, and the energy
grows by no more than what was stored and supplied.
"""

from functools import lru_cache

import numpy as np

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.sample import Block, Channel, layout_of
from bearing_twin.base.units import UNITS
from bearing_twin.core import INTEGER, INTEGERS, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.contract import STORED, Kind

UNIT_NORM = 1e-6  # of a quaternion's length, from 1
BOUNDED_UNITS = ("m", "m/s", "rad/s")
GAIN = 1.0  # of the energy there was and was brought: a run that gained less goes on, and its report says so
ROUNDING = 1e-9  # of the energies at hand


_within_limits = Function("core_within_limits", INTEGER, (REALS, INTEGER, INTEGER, REALS, INTEGERS, INTEGER, REAL))
_first_gain = Function(
    "core_first_gain", INTEGER, (REALS, INTEGER, INTEGER, INTEGERS, INTEGER, REALS, REAL, REAL, REALS_OUT)
)


class Health:
    """Checks the outputs of one run, from its start or from where it is continued."""

    def __init__(self, kind: Kind, channels: tuple[Channel, ...]):
        fields = layout_of(channels).fields
        self._kind = kind
        self._limits, self._rotations = _limits_and_rotations(channels)
        stored = np.array([fields[name][0].start for name in STORED if name in fields])
        self._stored = stored if len(stored) == len(STORED) else None
        self._work_column = fields["gross_work"][0].start if "gross_work" in fields else -1
        self._initial: np.ndarray | None = None
        self._energies = np.zeros(2)  # J: the most that was there or was brought so far; what was gained

    def check(self, block: Block) -> None:
        """Raise IntegrationError at the first impossible output."""
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
        if self._initial is None:
            brought = abs(numbers[0, self._work_column]) if self._work_column >= 0 else 0.0
            self._initial = np.array([*numbers[0, self._stored], brought])
        arguments = numbers, *numbers.shape, self._stored, self._work_column
        row = _first_gain(*arguments, self._initial, GAIN, ROUNDING, self._energies)
        if row >= 0:
            seconds, (available, gained) = 1e-9 * int(block.time_ns[row]), self._energies
            raise IntegrationError(
                f"at {seconds:.9g} s the energy has grown by {gained:.3g} J without work, where {available:.3g} J were "
                "stored or supplied; tighten wanted.tolerance or shorten solver.step",
                "energy",
                seconds,
            )

    def _refuse(self, block: Block, channel: Channel, bad: np.ndarray, reason: str, sentence: str) -> None:
        if not bad.any():
            return
        row, *index = np.argwhere(bad)[0].tolist()
        body, contact = self._kind.place_of(channel, tuple(index))
        seconds = 1e-9 * int(block.time_ns[row])
        location = " of " + ", ".join(part for part in (body, contact) if part) if body else ""
        raise IntegrationError(
            f"at {seconds:.9g} s {channel.name}{location} {sentence}; tighten wanted.tolerance or shorten solver.step",
            reason,
            seconds,
            body,
            contact,
        )


@lru_cache(maxsize=64)
def _limits_and_rotations(channels: tuple[Channel, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The limit of each number of all channels side by side, and the columns where quaternions begin."""
    rotations = (layout_of(channels).fields[channel.name][0] for channel in filter(_is_rotation, channels))
    starts = [np.arange(columns.start, columns.stop, 4) for columns in rotations]
    limits = np.concatenate([np.full(channel.width, _limit(channel)) for channel in channels])
    return limits, np.concatenate([np.empty(0, np.int64), *starts])


def _is_rotation(channel: Channel) -> bool:
    return channel.name == "orientation" and channel.shape[-1:] == (4,)


def _limit(channel: Channel) -> float:
    return UNITS[channel.unit].greatest if channel.unit in BOUNDED_UNITS else float(np.finfo(float).max)
