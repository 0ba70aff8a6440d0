"""Figures of a kind that has no better ones: what its channels say at the end, and at their greatest."""

from __future__ import annotations

import math
from collections.abc import Container
from typing import TYPE_CHECKING, Any

from bearing_twin.base.units import suffix_of

if TYPE_CHECKING:
    from bearing_twin.base.report import Choice
    from bearing_twin.base.sample import Block, Channel


class PlainFigures:
    """Figures drawn from the channels alone: every channel of one number at the end and at its greatest magnitude.

    Keys that are `taken` by figures of another meaning are left out.
    """

    def __init__(self, parameters, choice: Choice, channels: tuple[Channel, ...], taken: Container[str] = ()):
        self._channels, self._taken = [channel for channel in channels if channel.shape == ()], taken
        self._last: dict[str, float] = {}
        self._greatest: dict[str, float] = {}

    def add(self, block: Block) -> None:
        for channel in self._channels:
            values = block.values[channel.name]
            self._last[channel.name] = float(values[-1])
            self._greatest[channel.name] = max(self._greatest.get(channel.name, 0.0), float(abs(values).max()))

    def figures(self) -> dict[str, Any]:
        """`<channel>_at_end_<unit>` and `greatest_<channel>_<unit>`."""
        found = {}
        for channel in self._channels:
            suffix = suffix_of(channel.unit)
            found[f"{channel.name}_at_end{suffix}"] = self._last.get(channel.name, math.nan)
            found[f"greatest_{channel.name}{suffix}"] = self._greatest.get(channel.name, math.nan)
        return {key: value for key, value in found.items() if key not in self._taken}

    def flags(self) -> list[str]:
        """None: nothing is known of this theory."""
        return []

    def status(self) -> str:
        """Gives "done" while all numbers are finite."""
        return "done" if all(map(math.isfinite, self._last.values())) else "failed: not finite"
