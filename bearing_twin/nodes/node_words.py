"""Words of the command line of a node that ROS passes over in silence, or answers in words of its own; without ROS."""

import itertools
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml

from bearing_twin.errors import BearingTwinError
from bearing_twin.spelling import ROS_ARGS, echo, harmless

PARAMETERS = "ros__parameters"
_TOKENS = {"*": "/[^/]+", "**": "(/[^/]+)*"}  # of names of nodes in a file of parameters


def refuse_no_assignment(words: Sequence[str]) -> None:
    """Raises BearingTwinError for a `-p` that assigns nothing, and names what was meant: ROS answers with its lexer."""
    for option, word in itertools.pairwise(words):
        if option not in ("-p", "--param"):
            continue
        if ROS_ARGS not in words[: words.index(option)]:
            better = f"{ROS_ARGS} -p {word}"
            raise BearingTwinError(f"-p {word} stands before {ROS_ARGS} and would set nothing; write {better}")
        if ":=" not in word:
            name, _, value = word.replace(":", "=").partition("=")
            raise BearingTwinError(f"-p {echo(word)} sets nothing; write -p {name or 'NAME'}:={value or 'VALUE'}")


def refuse_no_parameters(words: Sequence[str]) -> None:
    """Raises BearingTwinError for a file of parameters that names none: ROS passes over it in silence."""
    for option, path in itertools.pairwise(words):
        if option == "--params-file" and PARAMETERS not in Path(path).read_text(errors="replace"):
            raise BearingTwinError(f"{path} holds no parameters; begin it with the node's name and {PARAMETERS}:")


def files_of_others(words: Sequence[str], node: str) -> Iterator[str]:
    """Sentences on files of parameters that hold none for a node of this full name: ROS passes over them in silence."""
    for option, path in itertools.pairwise(words):
        if option != "--params-file":
            continue
        try:
            names = list(_names(yaml.safe_load(Path(path).read_text(errors="replace")), ""))
        except (OSError, yaml.YAMLError, ValueError, RecursionError):  # ROS has read it all the same
            continue
        if not any(_pattern(one).fullmatch(node) for one in names):
            named = ", ".join(map(harmless, names[:5]))
            yield f"{path} holds no parameters for {node}, but for {named}; write /**/{node.rpartition('/')[2]} for it"


def advice(error: str) -> str:
    """What to do where ROS cannot be started, by what it says of it."""
    if "logging" in error:
        return "give a ROS_LOG_DIR"
    if "params file" in error:
        return "give a YAML file that begins with the name of a node and ros__parameters:"
    if "remap rule" in error:
        return "write -r FROM:=TO, -r __ns:=/NAMESPACE or -r __node:=NAME"
    return "write -p NAME:=VALUE for a parameter"


def _names(tree: Any, place: str) -> Iterator[str]:
    """Full names of the nodes, or patterns of them, that a file of parameters is for."""
    for key, value in tree.items() if isinstance(tree, dict) else ():
        if key == PARAMETERS:
            yield place
        else:
            yield from _names(value, f"{place}/{str(key).strip('/')}")


def _pattern(name: str) -> re.Pattern:
    return re.compile("".join(_TOKENS.get(one, f"/{re.escape(one)}") for one in name.split("/")[1:]))
