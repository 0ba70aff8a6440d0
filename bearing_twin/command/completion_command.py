"""The subcommand `completion`, and what a shell may complete: commands, options, names of scenes, studies and keys."""

import argparse
import os

from bearing_twin.command.node_start import NODES
from bearing_twin.command.outcome import Outcome

HELP = "what makes your shell complete commands, options and names: print it for bash, zsh or fish"
EXAMPLES = ("bearing_twin completion bash", "bearing_twin completion fish")
SHELLS = ("bash", "zsh", "fish")
ASKED = "_ARGCOMPLETE"  # the shell sets it where it wants completions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the argument of `completion` to its parser."""
    parser.add_argument("shell", choices=SHELLS, help='write eval "$(bearing_twin completion bash)" into ~/.bashrc')


def run(arguments: argparse.Namespace) -> Outcome:
    """The shell's code; raises BearingTwinError where the package argcomplete is missing."""
    from bearing_twin.command.terminal import show_text
    from bearing_twin.extras import wanted

    code = wanted("argcomplete", "completion").shellcode(["bearing_twin"], shell=arguments.shell)
    return Outcome({"shell": arguments.shell, "code": code}, [], lambda: show_text(code))


def complete(parser: argparse.ArgumentParser) -> None:
    """Answers a shell that asks for completions, and ends the program; returns where none asks."""
    if ASKED not in os.environ:
        return
    from bearing_twin.extras import wanted

    _teach(parser)
    wanted("argcomplete", "completion").autocomplete(parser)


def _teach(parser: argparse.ArgumentParser) -> None:
    """Gives the arguments of a parser, and of those below it, what completes them."""
    for action in parser._actions:
        if isinstance(action.choices, dict):
            for below in action.choices.values():
                _teach(below)
        elif action.dest in COMPLETERS:
            action.completer = COMPLETERS[action.dest]


def _scenes(prefix, **_) -> list[str]:
    """Scenes and designations, or files where a path was begun."""
    from bearing_twin.kinds import KINDS
    from bearing_twin.shelf import SCENES

    names = [*SCENES.names(), *(name for kind in KINDS.values() for name in kind.catalogue())]
    return names if "/" not in prefix else _files(prefix)


def _bearings(prefix, **_) -> list[str]:
    return [name.removeprefix("bearing_") for name in _scenes(prefix) if name.startswith("bearing_") or name.isalnum()]


def _studies(prefix, **_) -> list[str]:
    from bearing_twin.shelf import STUDIES

    return STUDIES.names() if "/" not in prefix else _files(prefix)


def _sources(prefix, **_) -> list[str]:
    """What a page or a layout may be made of: files, scenes, studies."""
    return [*_files(prefix), *_scenes(prefix), *_studies(prefix)]


def _materials(**_) -> list[str]:
    from bearing_twin.contact.materials import MATERIALS

    return list(MATERIALS)


def _parameters(prefix, parsed_args=None, **_) -> list[str]:
    """Parameters of the node that is to start, as its parameter file has them: to read it needs no ROS."""
    import yaml

    from bearing_twin.paths import share_path

    content = yaml.safe_load(share_path("config", f"{parsed_args.executable}.yaml").read_text(encoding="utf-8"))
    (of_node,) = content.values()
    return ["-p", *(f"{name}:=" for name in of_node["ros__parameters"])]


def _keys(prefix, **_) -> list[str]:
    """Keys of scenes with an equals sign, or the legal words of one."""
    from bearing_twin.kinds import KINDS
    from bearing_twin.parameters import describe

    rows = {row.key: row for kind in KINDS.values() for row in describe(kind.parameters)}
    key, equals, _ = prefix.partition("=")
    if equals:
        return [f"{key}={word}" for word in rows[key].options] if key in rows else []
    return [f"{name}=" for name in rows]


def _files(prefix: str) -> list[str]:
    from glob import glob

    return [f"{path}/" if os.path.isdir(path) else path for path in glob(f"{prefix}*")]


COMPLETERS = {"scene": _scenes, "bearing": _bearings, "study": _studies, "set": _keys, "executable": lambda **_: NODES}
COMPLETERS |= {"what": _sources, "source": _sources, "material": _materials, "words": _parameters}
