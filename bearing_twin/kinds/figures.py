"""What the figures of all kinds have in common: those drawn from channels alone, and the energy that numbers gain."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from bearing_twin.base.units import suffix_of

if TYPE_CHECKING:
    from bearing_twin.base.report import Choice
    from bearing_twin.base.sample import Block, Channel

STORED = ("kinetic_energy", "elastic_energy", "potential_energy")  # channels of the energy that a scene stores
ENERGY_GAIN = 0.01  # of the energy brought or the work moved; where less exactness is wanted, as much as that


def adds_up(closure: float, parameters) -> bool:
    """True if the energy that numbers gained or lost, a share, is no more than ENERGY_GAIN or than is wanted."""
    return abs(closure) <= max(ENERGY_GAIN, parameters.wanted.tolerance)


class ChannelFigure(NamedTuple):
    """A figure drawn from a channel of one number: its name, its key with the unit, and its meaning."""

    channel: Channel
    name: str
    key: str
    meaning: str


def channel_figures(channels: tuple[Channel, ...]) -> Iterator[tuple[ChannelFigure, ChannelFigure]]:
    """Two figures of each channel of one number: its value at the end, and its greatest magnitude."""
    for channel in channels:
        if channel.shape == ():
            names = {f"{channel.name}_at_end": "at the end", f"greatest_{channel.name}": "greatest magnitude"}
            yield tuple(
                ChannelFigure(channel, name, name + suffix_of(channel.unit), f"{channel.meaning}, {words}")
                for name, words in names.items()
            )


class ChannelFigures:
    """The figures of a kind that has no better ones: `channel_figures` without the keys that others have `taken`."""

    def __init__(self, parameters, choice: Choice, channels: tuple[Channel, ...], taken: Container[str] = ()):
        self._drawn, self._taken = tuple(channel_figures(channels)), taken
        self._last: dict[str, float] = {}
        self._greatest: dict[str, float] = {}

    def add(self, block: Block) -> None:
        for at_end, greatest in self._drawn:
            values = block.values[at_end.channel.name]
            self._last[at_end.key] = float(values[-1])
            self._greatest[greatest.key] = max(self._greatest.get(greatest.key, 0.0), float(abs(values).max()))

    def figures(self) -> dict[str, Any]:
        """`<channel>_at_end_<unit>` and `greatest_<channel>_<unit>`."""
        known = self._last | self._greatest
        return {
            one.key: known.get(one.key, math.nan) for both in self._drawn for one in both if one.key not in self._taken
        }

    def flags(self) -> list[str]:
        """None: nothing is known of this theory."""
        return []

    def status(self) -> str:
        """Gives "done" while all numbers are finite."""
        return "done" if all(map(math.isfinite, self._last.values())) else "failed: not finite"
