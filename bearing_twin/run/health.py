"""Whether the numbers of a run are those of a motion: looked at block by block, so that nonsense is not given out.

Numbers are finite, orientations unit quaternions, lengths and speeds of a size that a scene may have, and no more
energy appears than there was and was brought.
"""

import math

import numpy as np

from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.contract import Kind
from bearing_twin.sample import Block, Channel
from bearing_twin.units import UNITS

UNIT_NORM = 1e-6  # of a quaternion's length, from 1
BOUNDED = ("m", "m/s", "rad/s")
GAIN = 1.0  # of the energy there was and was brought: a run that gained less goes on, and its report says so
STORED = ("kinetic_energy", "elastic_energy", "potential_energy")
ROUNDING = 1e-9  # of the energies at hand


class Health:
    """Watches the outputs of one run, from its start or from where it is continued."""

    def __init__(self, kind: Kind, channels: tuple[Channel, ...]):
        self._kind, self._names = kind, {channel.name for channel in channels}
        self._limits = np.concatenate([np.full(channel.width, _limit(channel)) for channel in channels])
        self._quaternions = [one for one in channels if one.name == "orientation" and one.shape[-1:] == (4,)]
        self._first: np.ndarray | None = None
        self._there = 0.0  # J: most that was there or was brought so far

    def check(self, block: Block) -> None:
        """Raises IntegrationError at the first output that no motion can have."""
        if not (np.abs(block.matrix()) <= self._limits).all():  # nor is a NaN
            for channel in block.channels:
                values, limit = block.values[channel.name], _limit(channel)
                self._refuse(block, channel, ~np.isfinite(values), "not finite", "is not finite")
                far = f"is beyond {limit:g} {channel.unit}"
                self._refuse(block, channel, np.abs(values) > limit, "out of bounds", far)
        for channel in self._quaternions:
            square = np.square(block.values[channel.name]).sum(axis=-1)
            self._refuse(
                block, channel, np.abs(square - 1.0) > 2.0 * UNIT_NORM, "not a rotation", "is no unit quaternion"
            )
        if self._names.issuperset(STORED):
            self._check_energy(block)

    def _check_energy(self, block: Block) -> None:
        nothing = np.zeros(len(block))
        kinetic, elastic, potential = (block.values[name] for name in STORED)
        brought = np.abs(block.values["gross_work"]) if "gross_work" in self._names else nothing
        if self._first is None:
            self._first = np.array([kinetic[0], elastic[0], potential[0], brought[0]])
        begin = self._first
        gained = kinetic + elastic + potential - begin[:3].sum()
        there = begin[0] + begin[1] + np.abs(brought - begin[3]) + np.abs(potential - begin[2])
        # The most so far: a body that falls and comes back up has all of it, though none at the instant it is back.
        there = np.maximum.accumulate(np.maximum(there, self._there))
        self._there = float(there[-1])
        limit = (1.0 + GAIN) * there + ROUNDING * (kinetic + elastic + np.abs(potential))
        for row in np.flatnonzero(gained > limit)[:1]:
            seconds = 1e-9 * int(block.time_ns[row])
            raise IntegrationError(
                f"at {seconds:.9g} s there are {gained[row]:.3g} J more than at the start, of which {there[row]:.3g} J "
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


def _limit(channel: Channel) -> float:
    return UNITS[channel.unit].greatest if channel.unit in BOUNDED else float(np.finfo(float).max)


def worst_contact(kind: Kind, sample, channels: tuple[Channel, ...], body: str) -> str:
    """The contact of `body` that is pressed in deepest in an output; empty where the kind names none."""
    deepest, found = -math.inf, ""
    for channel in channels:
        if channel.name != "approach" or sample is None:
            continue
        for index in np.ndindex(channel.shape):
            place, value = kind.place_of(channel, index), float(sample[channel.name][index])
            if place[0] == body and place[1] and value > deepest:
                deepest, found = value, place[1]
    return found
