"""Parameters of nodes as data: name, default, unit, range and meaning, and the check of the values a user gave.

ROS accepts NaN, ignores misspelt names and refuses 5 where 5.0 is meant; `checked` does the opposite of all three.
"""

import itertools
import json
import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from bearing_twin.base.errors import ROS_ARGS, BearingTwinError, echo
from bearing_twin.base.parameters import read_number, unknown
from bearing_twin.base.units import labelled, with_unit
from bearing_twin.log.raw_log import Safety

ALLOW_INVALID = "allow_invalid"
NOT_ALLOWED = f"which the node's parameter {ALLOW_INVALID} = false forbids; omit it, or start the node with true"
SHOWN = {"log": "run.mcap", "node": "/bearing/sim_node"}  # in examples, where the default is empty
KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "text", list: "a list of texts"}


REMOVED = {
    "frame_prefix": "a replay keeps the frames of its log; beside others remap its /tf, as -r /tf:=/b/tf",
    "full": "every message is logged; a lower run.output_rate, or keep_files with split_size, limits the size of logs",
}


class NodeParameter(NamedTuple):
    """One parameter of a node; `unit` is SI or empty, `low` and `high` are inclusive, None where there is no range.

    A number may also be one of `words`, which stand for what is no number. `digits`: a whole number is taken as
    text, as a designation.
    """

    name: str
    default: bool | int | float | str | list
    help: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    read_only: bool = True
    words: tuple[str, ...] = ()
    digits: bool = False

    @property
    def description(self) -> str:
        return labelled(self.help, self.unit)


class ParameterError(BearingTwinError):
    """A node was started with parameters it cannot use."""


def checked(table: Sequence[NodeParameter], given: Mapping[str, Any], also_legal: Sequence[str] = ()) -> dict[str, Any]:
    """Every parameter's value: as given, else its default. Raises ParameterError that lists every mistake.

    `also_legal` are names that belong to ROS itself, such as use_sim_time.
    """
    names = [parameter.name for parameter in table]
    problems = [
        f"there is no parameter {echo(name)}; {REMOVED.get(name) or unknown(name, names)}"
        for name in given
        if name not in names and name not in also_legal
    ]
    values = {}
    for parameter in table:
        value = given.get(parameter.name, parameter.default)
        value = converted(parameter, value)
        problem = problem_of(parameter, value)
        if problem:
            problems.append(problem)
        values[parameter.name] = value
    if problems:
        raise ParameterError("; ".join(problems))
    return values


def converted(parameter: NodeParameter, value: Any) -> Any:
    """The value as the parameter holds it: ROS reads 5 as a whole number where 5.0 is meant, 6308 too, [] as None.

    YAML, and with it `ros2 param set`, takes 1e-5 for a text; a number may have its unit, as 20 ms.
    """
    kind = type(parameter.default)
    if value is None and kind is list:
        return []
    if kind is float and type(value) in (int, str) and value not in parameter.words:
        number, problem = read_number(value, parameter.unit)
        return value if problem else float(number)
    return str(value) if type(value) is int and parameter.digits else value


def help_of(name: str, what: str, table: Sequence[NodeParameter]) -> str:
    """Text of `--help`: the command, and the parameters of a node with defaults, units and ranges."""
    lines = [
        f"usage: bearing_twin node start {name} -p NAME:=VALUE [-p ...]",
        f"   or: ros2 run bearing_twin {name} {ROS_ARGS} -p NAME:=VALUE [-p ...]",
        "",
        *textwrap.wrap(what, 78),
        "",
    ]
    lines += ["parameters:" if all(one.read_only for one in table) else "parameters (changeable while it runs: *):"]
    for one in table:
        default = json.dumps(one.default) if not isinstance(one.default, float) else f"{one.default:g}"
        limits = "" if one.low is None else f", {limits_of(one)}"
        lines.append(f"  {one.name}{'' if one.read_only else '*'} = {default}{with_unit(one.unit)}{limits}")
        lines += textwrap.wrap(one.help, 72, initial_indent="      ", subsequent_indent="      ")
    first = table[0]
    value = first.default or SHOWN.get(first.name)
    lines += ["", "example:", f"  bearing_twin node start {name} -p {first.name}:={value}"]
    return "\n".join(lines)


def limits_of(parameter: NodeParameter) -> str:
    """`low to high`, and the words that may stand for a number."""
    return ", or ".join((f"{parameter.low:g} to {parameter.high:g}", *parameter.words))


def problem_of(parameter: NodeParameter, value: Any) -> str | None:
    """The reason why `value` cannot be used, or None."""
    kind, words = type(parameter.default), "".join(f", or {word}" for word in parameter.words)
    unit = with_unit(parameter.unit)
    if isinstance(value, str) and value in parameter.words:
        return None
    if kind is list:
        fits = isinstance(value, Sequence) and not isinstance(value, str) and all(isinstance(one, str) for one in value)
    else:
        fits = type(value) is kind
    if not fits:
        meant = f'; write {parameter.name}:="[{value!r}]"' if isinstance(value, str) and kind is list else ""
        shown = value if isinstance(value, str) or not isinstance(value, Sequence) else list(value)
        must = f"{KINDS[kind]}{unit and f' in{unit}'}{words}{meant}"
        return f"parameter {parameter.name} = {echo(shown)} must be {must}"
    if kind is float and not math.isfinite(value):
        return f"parameter {parameter.name} = {value} must be finite"
    low, high = parameter.low, parameter.high
    if (low is not None and value < low) or (high is not None and value > high):
        limits = f"between {low:g} and {high:g}{unit}"
        return f"parameter {parameter.name} = {value} must lie {limits}{words}"
    return None


LOG_SAFETY = (
    NodeParameter("max_loss", 0.1, "longest part of the log that a crash of the node may lose", "s", 0.01, 60.0),
    NodeParameter("fsync", False, "guarantee that for a crash of the machine too; slow on some disks"),
    NodeParameter("split_size", 0.0, "size after which a new file of the log begins; 0 = never", "B", 0.0, 1e15),
    NodeParameter("split_duration", 0.0, "time after which a new file begins; 0 = never", "s", 0.0, 1e9),
    NodeParameter("keep_files", 0, "number of files of a split log that are kept, the newest; 0 = all", "", 0, 100_000),
)


def safety_of(values: Mapping[str, Any]) -> Safety:
    """Settings of a log from the values of LOG_SAFETY; raises ParameterError where one needs another."""
    if values["keep_files"] and not (values["split_size"] or values["split_duration"]):
        raise ParameterError("keep_files limits the files of a split log, so it needs split_size or split_duration")
    return Safety(
        max_loss=values["max_loss"],
        fsync=values["fsync"],
        patient=True,
        split_bytes=round(values["split_size"]),
        split_seconds=values["split_duration"],
        keep=values["keep_files"],
    )


def check_arguments(words: Sequence[str]) -> None:
    """Raises BearingTwinError for arguments that ROS would pass over in silence, wait for, or refuse by its lexer."""
    for option, word in itertools.pairwise(words):
        if option in ("-p", "--param"):
            if ROS_ARGS not in words[: words.index(option)]:
                raise BearingTwinError(f"-p {word} stands before {ROS_ARGS}; write {ROS_ARGS} -p {word}")
            if ":=" not in word:
                name, _, value = word.replace(":", "=").partition("=")
                raise BearingTwinError(f"-p {echo(word)} sets nothing; write -p {name or 'NAME'}:={value or 'VALUE'}")
            if word.endswith(":="):
                said = f"-p {echo(word)} has no value"
                raise BearingTwinError(f"{said}; omit it, or write -p \"{word}''\" for an empty text")
        if word.startswith("__ns:=") and word.endswith("/") and word != "__ns:=/":
            raise BearingTwinError(f"-r {echo(word)} ends with a slash; write -r __ns:=/NAMESPACE")
        if option == "--params-file" and not Path(word).is_file():
            raise BearingTwinError(f"{word} is not a file of parameters; give the path of a YAML file")


def advice(error: str) -> str:
    """The next step where ROS cannot be initialised, by the text of its error."""
    if "log level" in error:
        return "the levels are debug, info, warn, error and fatal"
    if "logging" in error or "for writing" in error:
        return "give a ROS_LOG_DIR"
    if "params file" in error:
        return "give a YAML file that begins with the name of a node and ros__parameters:"
    if "remap rule" in error:
        return "write -r FROM:=TO, -r __ns:=/NAMESPACE or -r __node:=NAME"
    return "write -p NAME:=VALUE for a parameter"


# Arguments of launch files

SHARED = (
    NodeParameter("namespace", "", "of the nodes, such as /left; empty = where the kind of scene puts its node"),
    NodeParameter("params_file", "", "YAML file of parameters, under names as /**/sim_node; arguments have precedence"),
    NodeParameter("record", "", "MCAP file (or bag folder, without .mcap) for recorder_node; empty = none"),
    NodeParameter("log_level", "info", "least severity that nodes log: debug, info, warn, error or fatal"),
    NodeParameter("rviz", False, "open RViz with the layout of the package"),
    NodeParameter("foxglove", False, "open a foxglove_bridge on this machine for Foxglove"),
)
"""The arguments of every launch file; those of `two_bearings` beside them are SIDES."""
SIDES = (
    NodeParameter("scene", "bearing_6203", "scene of the left bearing", digits=True),
    NodeParameter("scene_right", "", "scene of the right bearing; empty = the same", digits=True),
    NodeParameter("overrides", [], "changes to both scenes, such as ['contact.normal=volumetric']"),
    NodeParameter("frame_prefix", "", "prefix of left/ and right/ in every frame name but world"),
    NodeParameter("distance", 0.1, "from the left bearing to the right one along z of `world`", "m", -1e3, 1e3),
)


def values_given(table: Sequence[NodeParameter], words: Mapping[str, str]) -> dict[str, object]:
    """The parameters given as texts in `words`, converted to their types; raises BearingTwinError for illegal values.

    A list is YAML, such as ['run.duration=1']; a single text is a list of one.
    """
    named = [one for one in table if words.get(one.name)]
    return checked(named, {one.name: _read(one, words[one.name]) for one in named})


def _read(parameter: NodeParameter, text: str):
    kind = type(parameter.default)
    if kind is str:
        return text
    try:
        value = yaml.safe_load(text)
        if kind is list:
            return value if isinstance(value, list) else [text]
        return float(value) if kind is float else value
    except (yaml.YAMLError, ValueError, TypeError, RecursionError):
        return text


def typed(default) -> str:
    """A default as it would be typed on a command line."""
    if default in ("", [], [""]):
        return "none"
    return str(default).lower() if isinstance(default, bool) else str(default)
