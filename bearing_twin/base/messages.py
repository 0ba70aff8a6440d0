"""Words of messages: legal words near a wrong one, by the number of slips of the keyboard between; echoes of input."""

import re
from collections.abc import Iterable
from typing import Any

MOST_NAMED = 48  # legal words in a message
MOST_NEAR = 3
LONGEST = 80  # letters compared
SWAP = 0.75
ROS_ARGS = "--ros-args"  # what stands behind it is for ROS
LONGEST_ECHO = 60
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
_SURROGATE = re.compile(r"[\ud800-\udfff]")  # of which YAML, file names and arguments may have single ones


def slips(first: str, second: str) -> float:
    """Letters to insert, leave out, replace or swap with their neighbour to turn one word into the other.

    The optimal string alignment distance (Damerau 1964; Boytsov 2011, section 2.2), but that a swap counts `SWAP`: what
    has the same letters is nearer than what has others.
    """
    rows = [[float(place) for place in range(len(second) + 1)]]
    for i, letter in enumerate(first, start=1):
        row = [float(i)]
        for j, other in enumerate(second, start=1):
            fewest = min(rows[-1][j] + 1, row[-1] + 1, rows[-1][j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == second[j - 2] and first[i - 2] == other:
                fewest = min(fewest, rows[-2][j - 2] + SWAP)
            row.append(fewest)
        rows.append(row)
    return rows[-1][-1]


def nearest(word: Any, legal: Iterable[str]) -> list[str]:
    """The legal words with the fewest slips from `word`, at most MOST_NEAR of them; none where all are too many.

    Too many are more than half of the letters of the longer word. Case does not count; where one of two words goes on
    where the other ends, they are nearer than others.
    """
    asked = str(word).lower()[:LONGEST]
    counted = []
    for place, one in enumerate(legal):
        other = one.lower()[:LONGEST]
        if (number := slips(asked, other)) <= 0.5 * max(len(asked), len(other)):
            begun = len(asked) > 1 and (other.startswith(asked) or asked.startswith(other))
            counted.append((min(number, SWAP) if begun else number, number, place, one))
    counted.sort()
    return [one for key, _, _, one in counted if key == counted[0][0]][:MOST_NEAR]


def did_you_mean(word: Any, legal: Iterable[str]) -> str:
    """A question with the nearest legal words and a space behind it; "" where none is near."""
    near = nearest(word, legal)
    return f"did you mean {' or '.join([', '.join(near[:-1]), near[-1]] if near[1:] else near)}? " if near else ""


def unknown(word: Any, legal: Iterable[str]) -> str:
    """The tail of a message about an unknown word: the nearest legal ones, if any is near, and the legal ones."""
    legal = [str(one) for one in legal]
    hint = did_you_mean(word, legal)
    more = f" and {len(legal) - MOST_NAMED} more" if len(legal) > MOST_NAMED else ""
    return f"{hint}legal: {', '.join(legal[:MOST_NAMED])}{more}"


def echo(value: Any) -> str:
    """The offending value as a user may recognise it, cut to a readable length."""
    return shortened(repr(value))


def no_progress(given: Any, loader: str) -> str:
    """Why what was handed over as `progress` is refused: a list of changes is meant for the `loader`."""
    return f"progress = {echo(given)} must be a function; changes are handed to {loader}(name, changes)"


def harmless(text: str) -> str:
    """Text for a terminal: what would move its cursor, turn the direction of letters, or is in no UTF-8, as escapes."""
    return _CONTROL.sub(lambda one: one[0].encode("unicode_escape").decode(), text)


def is_text(value: Any, longest: int) -> bool:
    """True for a text of at most so many characters that UTF-8, and so a log or a topic, can hold."""
    return isinstance(value, str) and len(value) <= longest and not _SURROGATE.search(value)


def shortened(text: str) -> str:
    """Text cut to a readable length."""
    return text if len(text) <= LONGEST_ECHO else text[: LONGEST_ECHO - 3] + "..."


def name_of_peer(name: str) -> str:
    """A name that a peer gave, as it may be shown: one with more than letters, digits, _ and / as `echo` has it."""
    return name if len(name) <= LONGEST_ECHO and re.fullmatch(r"[\w/]+", name, re.ASCII) else echo(name)
