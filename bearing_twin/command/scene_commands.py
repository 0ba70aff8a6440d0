"""The subcommands `scenes`, `topics` and `completion`. Imports are late, so that --help is quick."""

import argparse
import os
from glob import glob

from bearing_twin.command.node_command import NODES
from bearing_twin.command.outcome import Outcome, Subcommand, listed
from bearing_twin.command.terminal import show_text


def _scenes_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `scenes` to its parser."""
    lists = parser.add_mutually_exclusive_group()
    lists.add_argument("--keys", action="store_true", help="list every key of a scene: default, unit, limits, meaning")
    lists.add_argument("--figures", action="store_true", help="list every figure of a run: unit, meaning")
    lists.add_argument("--rules", action="store_true", help="list the rules by which models and methods are chosen")
    lists.add_argument("--schema", action="store_true", help="the JSON Schema of scene and study files, for editors")


def _scenes(arguments: argparse.Namespace) -> Outcome:
    """The requested list."""
    from bearing_twin.base.yaml_files import SCENES

    if arguments.keys:
        return _scene_keys()
    if arguments.figures:
        return _scene_figures()
    if arguments.rules:
        return _scene_rules()
    if arguments.schema:
        return _scene_schema()
    header = ("name", "kind", "description")
    return listed("scenes", header, ({name: head[name] for name in header} for head in SCENES.heads()))


def _scene_keys() -> Outcome:
    from bearing_twin.base.parameters import describe
    from bearing_twin.kinds import KINDS

    rows = [(kind, row) for kind, entry in KINDS.items() for row in describe(entry.parameters)]
    names = ("key", "type", "default", "unit", "limits", "help")
    return listed("keys", names, ({"kind": kind} | {name: getattr(row, name) for name in names} for kind, row in rows))


def _scene_figures() -> Outcome:
    from bearing_twin.base.units import named
    from bearing_twin.kinds import KINDS

    rows = [(kind, key, meaning) for kind, entry in KINDS.items() for key, meaning in entry.meanings_of().items()]
    header = ("kind", "figure", "unit", "meaning")
    found = ({"kind": kind, "figure": key, "unit": named(key)[1], "meaning": meaning} for kind, key, meaning in rows)
    return listed("figures", header, found)


def _scene_rules() -> Outcome:
    from bearing_twin.kinds.rules import RULES

    header = ("kinds", "key", "choice", "when", "why")
    found = (
        {"kinds": ", ".join(row.kinds), "example": list(row.example)}
        | {name: getattr(row, name) for name in header[1:]}
        for row in RULES
    )
    return listed("rules", header, found)


def _scene_schema() -> Outcome:
    from bearing_twin.base.report import json_text
    from bearing_twin.uq.schema import schema

    found = schema()
    return Outcome(found, [], lambda: show_text(json_text(found)))


SCENES = Subcommand(
    "list the scenes, every key of a scene, or the rules by which models are chosen",
    _scenes_arguments,
    _scenes,
    ("bearing_twin scenes", "bearing_twin scenes --keys", "bearing_twin scenes --rules"),
)


def _topics_arguments(parser) -> None:
    """The arguments of the subcommand."""
    parser.add_argument("scene", nargs="?", help="name of a scene or path of a YAML file; without, every kind")
    parser.add_argument("--markdown", action="store_true", help="the tables of docs/topics.md")


def _topics(arguments) -> Outcome:
    """The table, as text, JSON or Markdown; raises SceneError."""
    from bearing_twin.base.errors import BearingTwinError
    from bearing_twin.kinds import KINDS
    from bearing_twin.log import stream
    from bearing_twin.run.scene import load_scene

    if arguments.markdown:
        if arguments.scene:
            raise BearingTwinError("--markdown writes the table of every kind; leave out the scene")

        text = stream.markdown()
        return Outcome({"markdown": text}, [], lambda: show_text(text.rstrip("\n")))
    if arguments.scene:
        rows = [row._asdict() for row in stream.scene_rows(load_scene(arguments.scene))]
        return listed("topics", stream.TopicRow._fields, rows)
    rows = [{"kind": kind, **row._asdict()} for kind in KINDS for row in stream.kind_rows(kind)]
    return listed("topics", ("kind", *stream.TopicRow._fields), rows)


TOPICS = Subcommand(
    "list the topics of a scene, or of every kind of scene",
    _topics_arguments,
    _topics,
    ("bearing_twin topics bearing_6203", "bearing_twin topics"),
)


SHELLS = ("bash", "zsh", "fish")
COMPLETING = "_ARGCOMPLETE"  # the shell sets it where it wants completions


def _completion_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the argument of `completion` to its parser."""
    parser.add_argument("shell", choices=SHELLS, help='write eval "$(bearing_twin completion bash)" into ~/.bashrc')


def _completion(arguments: argparse.Namespace) -> Outcome:
    """The shell's code; raises BearingTwinError where the package argcomplete is missing."""
    from bearing_twin.base.errors import wanted

    code = wanted("argcomplete", "completion").shellcode(["bearing_twin"], shell=arguments.shell)
    return Outcome({"shell": arguments.shell, "code": code}, [], lambda: show_text(code))


def complete(parser: argparse.ArgumentParser) -> None:
    """Answers a shell that asks for completions, and ends the program; returns where none asks."""
    if COMPLETING not in os.environ:
        return
    from bearing_twin.base.errors import wanted

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


def _names(prefix, **_) -> list[str]:
    """Scenes, designations and studies, or files where a path was begun."""
    from bearing_twin.base.yaml_files import SCENES, STUDIES
    from bearing_twin.kinds.bearing import designations

    return _files(prefix) if "/" in prefix else [*SCENES.names(), *designations(), *STUDIES.names()]


def _sources(prefix, **_) -> list[str]:
    """Sources of a page or a layout: files, scenes, studies."""
    return [*glob(f"{prefix}*"), *_names(prefix)]


def _materials(**_) -> list[str]:
    from bearing_twin.contact.materials import MATERIALS

    return list(MATERIALS)


def _parameters(prefix, parsed_args=None, **_) -> list[str]:
    """Parameters of the node that is to start, as its parameter file has them: to read it needs no ROS."""
    import yaml

    from bearing_twin.base.paths import share_path

    content = yaml.safe_load(share_path("config", f"{parsed_args.executable}.yaml").read_text(encoding="utf-8"))
    (of_node,) = content.values()
    return ["-p", *(f"{name}:=" for name in of_node["ros__parameters"])]


def _keys(prefix, **_) -> list[str]:
    """Keys of scenes with an equals sign, or the legal words of one."""
    from bearing_twin.base.parameters import describe
    from bearing_twin.kinds import KINDS

    rows = {row.key: row for kind in KINDS.values() for row in describe(kind.parameters)}
    key, equals, _ = prefix.partition("=")
    if equals:
        return [f"{key}={word}" for word in rows[key].options] if key in rows else []
    return [f"{name}=" for name in rows]


def _files(prefix: str) -> list[str]:
    return [f"{path}/" if os.path.isdir(path) else path for path in glob(f"{prefix}*")]


COMPLETERS = {
    **dict.fromkeys(("scene", "bearing", "study"), _names),
    **dict.fromkeys(("what", "source"), _sources),
    "set": _keys,
    "executable": lambda **_: NODES,
    "material": _materials,
    "words": _parameters,
}


COMPLETION = Subcommand(
    "what makes your shell complete commands, options and names: print it for bash, zsh or fish",
    _completion_arguments,
    _completion,
    ("bearing_twin completion bash", "bearing_twin completion fish"),
)
