"""Where a run breaks off: the outputs before, and what to go on after."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.sample import Block
from bearing_twin.run.failure import SAME


class Broken(NamedTuple):
    """Why nothing comes behind some outputs; the number of the output to go on after, and the motion's state there."""

    error: IntegrationError
    sequence: int
    state: Any


def state_of(motion):
    """The state of a motion as plain data, None of one that has none."""
    return motion.snapshot() if hasattr(motion, "snapshot") else None


def up_to_break(
    motion, made: Callable[[np.ndarray], Block], first: int, times: np.ndarray, now: float, begun: Broken, block
) -> tuple[Block | None, Broken]:
    """The outputs before the error of a chunk from number `first` on, at `times` (n,) [s] from `now` [s].

    `block` has them all where it is one of them that no motion can have; else they are `made` anew, up to the error or
    earlier, from where the motion begins again. None where there is none, or the motion cannot go back.
    """
    times = times[now + times < begun.error.seconds * (1.0 - SAME)]
    if block is not None:
        return block.part(0, len(times)), begun
    while len(times) and hasattr(motion, "take_back"):
        motion.take_back()
        try:
            block = made(times)
        except IntegrationError:  # earlier than it said
            times = times[: len(times) // 2]
        else:
            return block, Broken(begun.error, first + len(times) - 1, state_of(motion))
    return None, begun
