"""The arguments of launch files as data: what every one takes, and what the words given say to a node; without ROS."""

import os
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import yaml

from bearing_twin.errors import BearingTwinError
from bearing_twin.nodes.node_parameters import NodeParameter, checked
from bearing_twin.parameters import echo

TRUTH = {"true": True, "false": False}
LOG_LEVELS = ("debug", "info", "warn", "error", "fatal")


class Argument(NamedTuple):
    """One argument of a launch file; `default` as it would be typed, `choices` empty where anything goes."""

    name: str
    default: str
    meaning: str
    choices: tuple[str, ...] = ()


SHARED = (
    Argument("namespace", "", "where the nodes stand, such as /left; empty = where the kind of scene puts its node"),
    Argument("params_file", "", "YAML file of parameters of nodes, named as /**/sim_node; arguments win over it"),
    Argument("record", "", "MCAP file (or bag folder, without .mcap) for recorder_node; empty = none"),
    Argument("log_level", "info", "what nodes say", LOG_LEVELS),
    Argument("rviz", "false", "open RViz with the layout of the package", tuple(TRUTH)),
    Argument("foxglove", "false", "open a foxglove_bridge on this machine for Foxglove", tuple(TRUTH)),
)


def stay_on_this_host() -> None:
    """What this process starts is found by nodes of this machine alone, unless the environment says otherwise."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


def arguments_of(table: Sequence[NodeParameter]) -> list[Argument]:
    """One argument for each parameter of a node, empty where it is left to the node and its parameter file."""
    return [Argument(one.name, "", f"{one.description} [default: {_typed(one.default)}]") for one in table]


def values_given(table: Sequence[NodeParameter], words: Mapping[str, str]) -> dict[str, object]:
    """The parameters that `words` give, in their types; raises BearingTwinError for words that are no such values.

    A list is YAML, such as ['run.duration=1']; a single word is a list of one.
    """
    named = [parameter for parameter in table if words.get(parameter.name)]
    return checked(named, {parameter.name: _read(parameter, words[parameter.name]) for parameter in named})


def truth(words: Mapping[str, str], name: str) -> bool:
    """Whether an argument that is true or false says true; raises BearingTwinError for another word."""
    text = words.get(name, "false").lower()
    if text not in TRUTH:
        raise BearingTwinError(f"{name}:={echo(text)} must be true or false")
    return TRUTH[text]


def _read(parameter: NodeParameter, text: str):
    kind = type(parameter.default)
    if kind is str:
        return text
    if kind is bool:
        return TRUTH.get(text.lower(), text)
    if kind is list:
        try:
            value = yaml.safe_load(text)
        except (yaml.YAMLError, ValueError, RecursionError):
            return text
        return value if isinstance(value, list) else [text]
    try:
        return kind(text)
    except ValueError:
        return text


def _typed(default) -> str:
    if default in ("", [], [""]):
        return "none"
    return str(default).lower() if isinstance(default, bool) else str(default)
