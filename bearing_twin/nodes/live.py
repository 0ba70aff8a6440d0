"""A run while it goes on, for a page: thinned outputs as text, and what the page must know; without ROS.

An event `frames` is base64 of little-endian numbers: how many outputs (a float64), their times [s] as float64, then the
rows of all series side by side as float32.
"""

import base64
import json
import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.errors import BearingTwinError, LogError, SceneError
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.blocks import block_of, channels_of, check_block
from bearing_twin.run.scene import Scene, read_logged
from bearing_twin.sample import Channel, Sample

LARGEST_SCENE = 1 << 20  # characters
LARGEST_BLOCK = 1 << 24  # B
WIDEST = 64  # numbers of a series
ROWS = 5  # outputs in one event, at most
PERIOD = 0.05  # s between events, at least


class Shown(NamedTuple):
    """What a page shows of a run: `series`, and the function from a sample of many outputs to their arrays."""

    series: tuple[Channel, ...]
    rows: Callable[[Sample], Mapping[str, np.ndarray]]


def shown_of(channels: tuple[Channel, ...]) -> Shown:
    """All channels but the very wide ones."""
    series = tuple(channel for channel in channels if channel.width <= WIDEST)
    return Shown(series, lambda sample: {channel.name: sample[channel.name] for channel in series})


class LiveRun:
    """The run of a scene as its topics tell it; `said` is the text of the topic `scene`.

    Raises BearingTwinError for a text that is no scene.
    """

    def __init__(self, said: str):
        self.said = said
        self.scene, self.law, self.stepper, self.reason = _read(said)
        self.shown: Shown | None = None
        self._channels: tuple[Channel, ...] = ()
        self._next: int | None = None
        self._due = -math.inf

    def frames(self, data: bytes, now: float) -> str:
        """The event `frames` of a SampleBlock that came at `now` [s]; empty where none is due.

        Raises LogError for bytes that are no block of this scene, and Again where the run has begun again.
        """
        if now < self._due:
            return ""
        if len(data) > LARGEST_BLOCK:
            raise LogError(f"samples of {len(data)} bytes are too long for a page")
        message = cdr.deserialise(cdr.SAMPLE_BLOCK, data)
        check_block("samples", message)
        channels = channels_of(self.scene, message)
        if self.shown is None:
            self.shown, self._channels = shown_of(channels), channels
        first, following = int(message.first_sequence), self._next
        self._next, self._due = first + int(message.count), now + PERIOD
        if channels != self._channels or (following is not None and first < following):
            self.shown = self._next = None
            raise Again("the run has begun again")
        block = block_of(channels, message)
        step = -(-len(block) // ROWS)
        rows = range((len(block) - 1) % step, len(block), step)
        return self._encoded(block.sampled(rows))

    def _encoded(self, sample: Sample) -> str:
        times = 1e-9 * np.asarray(sample.time_ns, "<f8")
        found = self.shown.rows(sample)
        parts = [np.reshape(found[channel.name], (len(times), -1)) for channel in self.shown.series]
        table = np.hstack(parts).astype("<f4") if parts else np.empty((len(times), 0), "<f4")
        head = np.array([len(times)], "<f8").tobytes()
        return base64.b64encode(head + times.tobytes() + table.tobytes()).decode("ascii")

    def described(self) -> dict[str, Any] | None:
        """What the page must know before the first event; None before a block has come."""
        if self.shown is None:
            return None
        series = [
            {"name": one.name, "unit": one.unit, "shape": list(one.shape), "meaning": one.meaning}
            for one in self.shown.series
        ]
        return {
            "title": self.scene.name,
            "subtitle": self.scene.description,
            "law": self.law,
            "stepper": self.stepper,
            "reason": self.reason,
            "series": series,
        }

    def commands(self) -> dict[str, str]:
        """The topics that a node with this scene obeys, below its namespace, with their types."""
        return {command.name: command.ros_type for command in KINDS[self.scene.kind].commands()}


class Again(LogError):
    """The run has begun again, or another one: what a page shows so far is over."""


def _read(said: str) -> tuple[Scene, str, str, str]:
    """Scene, law, stepper and reason in the text of the topic `scene`."""
    if len(said) > LARGEST_SCENE:
        raise SceneError(f"a scene of {len(said)} characters is none; restart the node that publishes it")
    try:
        told = json.loads(said)
        texts = [told["scene"], *(str(told.get(key, "")) for key in ("law", "stepper", "reason"))]
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise SceneError("what the topic scene says is no scene of a bearing_twin; look at the node's name") from error
    if not isinstance(texts[0], str):
        raise SceneError("what the topic scene says is no scene of a bearing_twin; look at the node's name")
    return read_logged(texts[0], "the topic scene"), *texts[1:]


def number_of(command: Mapping[str, Any], key: str) -> float:
    """A finite number in a command; raises BearingTwinError."""
    value = command.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise BearingTwinError(f"{key} must be a number")
    return float(value)


def vector_of(command: Mapping[str, Any], key: str) -> tuple[float, float, float]:
    """Three finite numbers in a command; raises BearingTwinError."""
    value = command.get(key)
    if not isinstance(value, list) or len(value) != 3:
        raise BearingTwinError(f"{key} must be three numbers")
    return tuple(number_of({key: one}, key) for one in value)
