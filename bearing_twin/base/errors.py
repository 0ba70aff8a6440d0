"""Errors that a user can cause, one sentence each that says what to do; optional packages; words of messages."""

import importlib
import re
import sys
from collections.abc import Iterable
from types import ModuleType
from typing import Any


class BearingTwinError(Exception):
    """Base of every error raised for bad input or a failed run; the command line turns it into exit code 2."""


class SceneError(BearingTwinError):
    """A scene file, scene name or override cannot be used."""


class StudyError(BearingTwinError):
    """A study, one of its uncertain inputs, or its method of sampling or propagation cannot be used."""


class StatisticError(BearingTwinError):
    """A requested statistic does not exist, or cannot be computed from these samples."""


class LogError(BearingTwinError):
    """A log cannot be read, or may not be written."""


class ChannelError(BearingTwinError, KeyError):
    """There is no channel of that name."""

    __str__ = Exception.__str__  # that of KeyError puts a sentence into quotes


class IntegrationError(BearingTwinError):
    """The integration stopped: `reason` ("not finite", "too deep", ...), at `seconds`, for which `body` and `contact`.

    Where a method cannot tell, `reason`, `body` and `contact` are empty and `seconds` is NaN. `record` is plain data of
    the last good output and state, where there is one.
    """

    def __init__(
        self, sentence: str, reason: str = "", seconds: float = float("nan"), body: str = "", contact: str = ""
    ):
        super().__init__(sentence)
        self.reason, self.seconds, self.body, self.contact = reason, seconds, body, contact
        self.record: dict | None = None


class Stopped(BearingTwinError):
    """A computation ended because a stop was requested; its earlier outputs are complete."""


class Interrupted(Stopped):
    """A computation interrupted by a command; it is repeated from where it began, so only time is lost."""


class CoreError(BearingTwinError):
    """The library of the compiled core is missing, incomplete, of other sources or for another processor."""


class MissingInterfacesError(BearingTwinError):
    """ROS 2 or the interface package bearing_twin_msgs cannot be imported."""


def missing_package(error: ModuleNotFoundError) -> str:
    """The sentence for a Python package that is not installed; raises `error` again for a module of bearing_twin."""
    name = (error.name or "").partition(".")[0]
    if name in ("", "bearing_twin"):
        raise error
    return (
        f"the Python package {name} is not installed for {sys.executable}: "
        f"run `{sys.executable} -m pip install {name}`; "
        "in a ROS workspace `rosdep install --from-paths src` or requirements/workspace.txt bring all that is needed"
    )


EXTRAS = {  # extra of the package: its purpose
    "chaos": "polynomial chaos expansions",
    "completion": "completions of commands by the shell",
    "dask": "studies on a cluster",
    "export": "tables and data sets for pandas, xarray and what reads CSV, Parquet and NetCDF",
    "view": "animations",
}


def install_command(extra: str) -> str:
    """The command that installs an extra, in the checkout: the package is on no index."""
    return f"pip install '.[{extra}]' (in the checkout)"


def import_optional(module: str, extra: str) -> ModuleType:
    """The module of an optional package; raises BearingTwinError naming the extra that installs it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0].replace("_", "-")
        raise BearingTwinError(
            f"{EXTRAS[extra]} need the package {package}; install it with: {install_command(extra)}"
        ) from error


MOST_NAMED = 48  # legal names in a message
MOST_NEAR = 3
LONGEST = 80  # letters compared
SWAP = 0.75
ROS_ARGS = "--ros-args"  # the arguments behind it are those of ROS
LONGEST_ECHO = 60
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
_SURROGATE = re.compile(r"[\ud800-\udfff]")  # of which YAML, file names and arguments may have single ones


def edit_distance(first: str, second: str) -> float:
    """The number of letters to insert, delete, replace or swap with their neighbour to turn one word into the other.

    The optimal string alignment distance (Damerau 1964; Boytsov 2011, section 2.2), but that a swap counts `SWAP`:
    words of the same letters are nearer than others.
    """
    rows = [[float(j) for j in range(len(second) + 1)]]
    for i, first_letter in enumerate(first, start=1):
        row = [float(i)]
        for j, second_letter in enumerate(second, start=1):
            least = min(rows[-1][j] + 1, row[-1] + 1, rows[-1][j - 1] + (first_letter != second_letter))
            if i > 1 and j > 1 and first_letter == second[j - 2] and first[i - 2] == second_letter:
                least = min(least, rows[-2][j - 2] + SWAP)
            row.append(least)
        rows.append(row)
    return rows[-1][-1]


def nearest(name: Any, legal: Iterable[str]) -> list[str]:
    """The legal names of the least edit distance from `name`, at most MOST_NEAR; none where all are too distant.

    Too distant is more than half of the letters of the longer name. Case does not count. Names of which one begins
    with the other are nearer than others.
    """
    typed = str(name).lower()[:LONGEST]
    candidates = []
    for index, legal_name in enumerate(legal):
        candidate = legal_name.lower()[:LONGEST]
        if (distance := edit_distance(typed, candidate)) <= 0.5 * max(len(typed), len(candidate)):
            is_prefix = len(typed) > 1 and (candidate.startswith(typed) or typed.startswith(candidate))
            candidates.append((min(distance, SWAP) if is_prefix else distance, distance, index, legal_name))
    candidates.sort()
    return [legal_name for distance, *_, legal_name in candidates if distance == candidates[0][0]][:MOST_NEAR]


def did_you_mean(name: Any, legal: Iterable[str]) -> str:
    """A question with the nearest legal names and a space behind it; "" where none is near."""
    near = nearest(name, legal)
    return f"did you mean {' or '.join([', '.join(near[:-1]), near[-1]] if near[1:] else near)}? " if near else ""


def legal_hint(name: Any, legal: Iterable[str]) -> str:
    """The end of a message about an unknown name: the nearest legal ones, if any is near, and the legal ones."""
    legal = [*map(str, legal)]
    omitted = f" and {len(legal) - MOST_NAMED} more" if len(legal) > MOST_NAMED else ""
    return f"{did_you_mean(name, legal)}legal: {', '.join(legal[:MOST_NAMED])}{omitted}"


def echo(value: Any) -> str:
    """The representation of an offending value, cut to a readable length."""
    return shorten(repr(value))


def progress_error(progress: Any, loader: str) -> str:
    """The sentence that refuses a `progress` that is no function: a list of changes is meant for the `loader`."""
    return f"progress = {echo(progress)} must be a function; changes are handed to {loader}(name, changes)"


def escape_controls(text: str) -> str:
    """Text for a terminal, with control characters, changes of direction and lone surrogates as escapes."""
    return _CONTROL.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


def is_text(value: Any, longest: int) -> bool:
    """True for a text of at most `longest` characters that UTF-8, and so a log or a topic, can hold."""
    return isinstance(value, str) and len(value) <= longest and not _SURROGATE.search(value)


def shorten(text: str) -> str:
    """Text cut to a readable length."""
    return text if len(text) <= LONGEST_ECHO else text[: LONGEST_ECHO - 3] + "..."


def peer_name(name: str) -> str:
    """A name given by a peer, for display: with more than letters, digits, _ and / as by `echo`."""
    return name if len(name) <= LONGEST_ECHO and re.fullmatch(r"[\w/]+", name, re.ASCII) else echo(name)
