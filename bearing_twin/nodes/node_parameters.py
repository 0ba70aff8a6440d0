"""Parameters of nodes as data: name, default, unit, range and meaning, and the check of the values a user gave.

ROS accepts NaN, ignores misspelt names and refuses 5 where 5.0 is meant; `checked` does the opposite of all three.
"""

import itertools
import json
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from bearing_twin.base.errors import ROS_ARGS, BearingTwinError, echo
from bearing_twin.base.parameters import legal_hint, read_number
from bearing_twin.base.units import Limits, axis_label, with_unit
from bearing_twin.log.raw_log import KEPT_RATE, Safety

ALLOW_INVALID = "allow_invalid"
NOT_ALLOWED = f"which the node's parameter {ALLOW_INVALID} = false forbids; omit it, or start the node with true"
SHOWN = {"log": "run.mcap", "node": "/bearing/sim_node"}  # in examples, where the default is empty
KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "text", list: "a list of texts"}


REMOVED = {
    "frame_prefix": "a replay keeps the frames of its log; beside others remap its /tf, as -r /tf:=/b/tf",
}


class NodeParameter(NamedTuple):
    """One parameter of a node; `unit` is SI or empty, `low` and `high` are inclusive, None where there is no range.

    A number may also be one of `words`, which stand for what is no number.
    """

    name: str
    default: bool | int | float | str | list
    help: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    read_only: bool = True
    words: tuple[str, ...] = ()

    @property
    def description(self) -> str:
        return axis_label(self.help, self.unit)

    @property
    def legal(self) -> str:
        """What a value must be, as `a number in s, 0 to 60`."""
        unit, limits = with_unit(self.unit), "" if self.low is None else f", {self.low:g} to {self.high:g}"
        return ", or ".join((f"{KINDS[type(self.default)]}{unit and f' in{unit}'}{limits}", *self.words))


class ParameterError(BearingTwinError):
    """A node was started with parameters it cannot use."""


def checked(table: Sequence[NodeParameter], given: Mapping[str, Any], also_legal: Sequence[str] = ()) -> dict[str, Any]:
    """Every parameter's value: as given, else its default. Raises ParameterError that lists every mistake.

    `also_legal` are names that belong to ROS itself, such as use_sim_time.
    """
    names = [parameter.name for parameter in table]
    problems = [
        f"there is no parameter {echo(name)}; {REMOVED.get(name) or legal_hint(name, names)}"
        for name in given
        if name not in names and name not in also_legal
    ]
    values = {}
    for one in table:
        try:
            values[one.name] = read(one, given.get(one.name, one.default))
        except ParameterError as error:
            problems.append(str(error))
    if problems:
        raise ParameterError("; ".join(problems))
    return values


def read(parameter: NodeParameter, value: Any) -> Any:
    """The value as the parameter holds it; raises ParameterError with what it must be.

    ROS reads 5 as a whole number where 5.0 is meant, 6308 too, [] as None; YAML, and with it `ros2 param set`, takes
    1e-5 for a text; a number may have its unit, as 20 ms.
    """
    kind = type(parameter.default)
    if kind is list and value is None:
        return []
    if isinstance(value, str) and value in parameter.words:
        return value
    if kind in (int, float):
        limits = Limits(at_least=parameter.low, at_most=parameter.high)
        number, problem = read_number(value, parameter.unit, limits, integer=kind is int)
        if not problem:
            return kind(number)
    elif kind is str and type(value) is int:
        return str(value)
    elif kind is list and isinstance(value, Sequence) and not isinstance(value, str):
        if all(isinstance(one, str) for one in value):
            return list(value)
    elif kind is not list and type(value) is kind:
        return value
    shown = value if isinstance(value, str) or not isinstance(value, Sequence) else list(value)
    meant = f'; write {parameter.name}:="[{value!r}]"' if isinstance(value, str) and kind is list else ""
    raise ParameterError(f"parameter {parameter.name} = {echo(shown)} must be {parameter.legal}{meant}")


def help_of(name: str, what: str, table: Sequence[NodeParameter]) -> str:
    """Text of `--help`: the command, and the parameters of a node with defaults and legal values."""
    lines = [
        f"usage: bearing_twin node start {name} -p NAME:=VALUE [-p ...]",
        f"   or: ros2 run bearing_twin {name} {ROS_ARGS} -p NAME:=VALUE [-p ...]",
        "",
        *textwrap.wrap(what, 78),
        "",
    ]
    lines += ["parameters:" if all(one.read_only for one in table) else "parameters (changeable while it runs: *):"]
    for one in table:
        lines.append(f"  {one.name}{'' if one.read_only else '*'} = {json.dumps(one.default)}; {one.legal}")
        lines += textwrap.wrap(one.help, 72, initial_indent="      ", subsequent_indent="      ")
    first = table[0]
    value = first.default or SHOWN.get(first.name)
    lines += ["", "example:", f"  bearing_twin node start {name} -p {first.name}:={value}"]
    return "\n".join(lines)


LOG_SAFETY = (
    NodeParameter("full", True, f"log every message and output; false keeps {KEPT_RATE:g} a second of each topic"),
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
        kept_rate=0.0 if values["full"] else KEPT_RATE,
    )


def check_arguments(words: Sequence[str]) -> None:
    """Raises BearingTwinError for arguments that ROS would pass over in silence, wait for or refuse by its lexer."""
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
    NodeParameter("scene", "bearing_6203", "scene of the left bearing"),
    NodeParameter("scene_right", "", "scene of the right bearing; empty = the same"),
    NodeParameter("overrides", [], "changes to both scenes, such as ['contact.normal=volumetric']"),
    NodeParameter("frame_prefix", "", "prefix of left/ and right/ in every frame name but world"),
    NodeParameter("distance", 0.1, "from the left bearing to the right one along z of `world`", "m", -1e3, 1e3),
)


def values_given(table: Sequence[NodeParameter], words: Mapping[str, str]) -> dict[str, object]:
    """The parameters given as texts in `words`, converted to their types; raises BearingTwinError for illegal values.

    A list is YAML, such as ['run.duration=1']; a single text is a list of one.
    """
    given = {one.name: words[one.name] for one in table if words.get(one.name)}
    for one in table:
        if one.name in given and type(one.default) in (bool, list):
            value = _yaml(given[one.name])
            given[one.name] = [given[one.name]] if type(one.default) is list and not isinstance(value, list) else value
    return checked([one for one in table if one.name in given], given)


def _yaml(text: str) -> Any:
    """A value in YAML; what is none is a text."""
    try:
        return yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError):
        return text


def typed(default) -> str:
    """A default as it would be typed on a command line."""
    if default in ("", [], [""]):
        return "none"
    return str(default).lower() if isinstance(default, bool) else str(default)
