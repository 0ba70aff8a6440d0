"""Parameters of nodes as data: name, default, unit, range and meaning, and the check of the values a user gave.

ROS accepts NaN, ignores misspelt names and refuses 5 where 5.0 is meant; `checked_values` does the opposite of all
three.
"""

import contextlib
import itertools
import json
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from bearing_twin.base.errors import ROS_ARGS, BearingTwinError, echo, legal_hint
from bearing_twin.base.parameters import read_number
from bearing_twin.base.units import Limits, axis_label, with_unit
from bearing_twin.log.raw_log import KEPT_RATE, Safety

ALLOW_INVALID = "allow_invalid"
NOT_ALLOWED = f"which the node's parameter {ALLOW_INVALID} = false forbids; omit it, or start the node with true"
EXAMPLES = {"log": "run.mcap", "node": "/bearing/sim_node"}  # in examples, where the default is empty
KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "text", list: "a list of texts"}


REMOVED = {
    "frame_prefix": "a replay keeps the frames of its log; beside others remap its /tf, as -r /tf:=/b/tf",
}


class ParameterError(BearingTwinError):
    """A node was started with parameters it cannot use."""


class NodeParameter(NamedTuple):
    """One parameter of a node; `unit` is SI or empty, `low` and `high` are inclusive, None without a range.

    A number may also be one of the texts `alternatives`.
    """

    name: str
    default: bool | int | float | str | list
    help: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    read_only: bool = True
    alternatives: tuple[str, ...] = ()

    @property
    def description(self) -> str:
        return axis_label(self.help, self.unit)

    @property
    def legal(self) -> str:
        """What a value must be, as `a number in s, 0 to 60`."""
        unit, limits = with_unit(self.unit), "" if self.low is None else f", {self.low:g} to {self.high:g}"
        return ", or ".join((f"{KINDS[type(self.default)]}{unit and f' in{unit}'}{limits}", *self.alternatives))

    def convert(self, value: Any) -> Any:
        """The value in the type of the parameter; raises ParameterError with the legal values.

        ROS reads 5 as a whole number where 5.0 is meant, 6308 too, [] as None; YAML, and with it `ros2 param set`,
        takes 1e-5 for a text; a number may have its unit, as 20 ms, and one text is a list of one. Empty texts are left
        out of lists: a file of parameters has no other empty list than [""].
        """
        kind, is_text = type(self.default), isinstance(value, str)
        if is_text and value in self.alternatives:
            return value
        if kind is list and (value is None or isinstance(value, Sequence)):
            value = [item for item in ([value] if is_text else value or ()) if item != ""]
        if kind in (int, float):
            limits = Limits(at_least=self.low, at_most=self.high)
            number, problem = read_number(value, self.unit, limits, integer=kind is int)
            if not problem:
                return kind(number)
        elif kind is str and type(value) is int:
            return str(value)
        elif type(value) is kind and (kind is not list or all(isinstance(item, str) for item in value)):
            return value
        raise ParameterError(f"parameter {self.name} = {echo(value)} must be {self.legal}")


def checked_values(
    table: Sequence[NodeParameter], overrides: Mapping[str, Any], also_legal: Sequence[str] = ()
) -> dict[str, Any]:
    """The value of every parameter, by default its own. Raises ParameterError that lists every mistake.

    `also_legal` are names of ROS itself, such as use_sim_time.
    """
    names = [parameter.name for parameter in table]
    problems = [
        f"there is no parameter {echo(name)}; {REMOVED.get(name) or legal_hint(name, names)}"
        for name in overrides
        if name not in names and name not in also_legal
    ]
    values = {}
    for row in table:
        try:
            values[row.name] = row.convert(overrides.get(row.name, row.default))
        except ParameterError as error:
            problems.append(str(error))
    if problems:
        raise ParameterError("; ".join(problems))
    return values


def help_text(name: str, description: str, table: Sequence[NodeParameter]) -> str:
    """Text of `--help`: the command, and the parameters of a node with defaults and legal values."""
    lines = [
        f"usage: bearing_twin node start {name} -p NAME:=VALUE [-p ...]",
        f"   or: ros2 run bearing_twin {name} {ROS_ARGS} -p NAME:=VALUE [-p ...]",
        "",
        *textwrap.wrap(description, 78),
        "",
    ]
    lines += ["parameters:" if all(row.read_only for row in table) else "parameters (changeable while it runs: *):"]
    for row in table:
        lines.append(f"  {row.name}{'' if row.read_only else '*'} = {json.dumps(row.default)}; {row.legal}")
        lines += textwrap.wrap(row.help, 72, initial_indent="      ", subsequent_indent="      ")
    first = table[0]
    value = first.default or EXAMPLES.get(first.name)
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


def check_arguments(arguments: Sequence[str]) -> None:
    """Raises BearingTwinError for arguments that ROS would pass over in silence, or wait for."""
    for option, value in itertools.pairwise(arguments):
        if option in ("-p", "--param") and ROS_ARGS not in arguments[: arguments.index(option)]:
            raise BearingTwinError(f"-p {value} stands before {ROS_ARGS}; write {ROS_ARGS} -p {value}")
        if option == "--params-file" and not Path(value).is_file():
            raise BearingTwinError(f"{value} is not a file of parameters; give the path of a YAML file")


def initialisation_hint(error: str) -> str:
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
"""The arguments of every launch file; those of `two_bearings` in addition are SIDES."""
SIDES = (
    NodeParameter("scene", "bearing_6203", "scene of the left bearing"),
    NodeParameter("scene_right", "", "scene of the right bearing; empty = the same"),
    NodeParameter("overrides", [], "changes to both scenes, such as ['contact.normal=volumetric']"),
    NodeParameter("frame_prefix", "", "prefix of left/ and right/ in every frame name but world"),
    NodeParameter("distance", 0.1, "from the left bearing to the right one along z of `world`", "m", -1e3, 1e3),
)


def launch_values(table: Sequence[NodeParameter], texts: Mapping[str, str]) -> dict[str, object]:
    """The parameters with a text in `texts`, converted to their types; raises BearingTwinError for illegal values.

    A list is YAML, such as ['run.duration=1'], or a single text.
    """
    given = [row for row in table if texts.get(row.name)]
    return checked_values(given, {row.name: _typed(row.default, texts[row.name]) for row in given})


def _typed(default, text: str) -> Any:
    """The text of a truth value or of a list as what it is in YAML; any other text as it stands."""
    if isinstance(default, bool) or (isinstance(default, list) and text.startswith("[")):
        with contextlib.suppress(yaml.YAMLError, ValueError, RecursionError):
            return yaml.safe_load(text)
    return text
