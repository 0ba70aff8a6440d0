"""Numbers in the commands of a page, checked, and words for it: whoever sends them may send anything."""

import math
from collections.abc import Mapping
from typing import Any

from bearing_twin.errors import BearingTwinError


def number_of(command: Mapping[str, Any], key: str, called: str = "") -> float:
    """A finite number in a command; raises BearingTwinError that calls it `called`, or else by its key."""
    value = command.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise BearingTwinError(f"{called or key} must be a number")
    return float(value)


def vector_of(command: Mapping[str, Any], key: str) -> tuple[float, float, float]:
    """Three finite numbers in a command; raises BearingTwinError."""
    value = command.get(key)
    if not isinstance(value, list) or len(value) != 3:
        raise BearingTwinError(f"{key} must be three numbers")
    return tuple(number_of({key: one}, key) for one in value)


def cut_short(text: str, longest: int) -> str:
    """The text on one line, of at most so many characters, with an ellipsis where the rest is left out."""
    line = " ".join(text.split())
    return line if len(line) <= longest else f"{line[: longest - 2]} …"
