"""The subcommands `scenes` and `topics`. Imports are late, so that --help is quick."""

import argparse

from bearing_twin.command.outcome import Outcome, Subcommand, listed


def _scenes_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `scenes` to its parser."""
    lists = parser.add_mutually_exclusive_group()
    lists.add_argument("--keys", action="store_true", help="list every key of a scene: default, unit, limits, meaning")
    lists.add_argument("--figures", action="store_true", help="list every figure of a run: unit, meaning")
    lists.add_argument("--rules", action="store_true", help="list the rules by which models and methods are chosen")


def _scenes(arguments: argparse.Namespace) -> Outcome:
    """The requested list."""
    from bearing_twin.base.yaml_files import SCENES

    if arguments.keys:
        return _scene_keys()
    if arguments.figures:
        return _scene_figures()
    if arguments.rules:
        return _scene_rules()
    header = ("name", "kind", "description")
    return listed("scenes", header, ({name: head[name] for name in header} for head in SCENES.headers()))


def _scene_keys() -> Outcome:
    from bearing_twin.base.parameters import describe
    from bearing_twin.kinds import KINDS

    rows = [(kind, row) for kind, entry in KINDS.items() for row in describe(entry.parameters)]
    names = ("key", "type", "default", "unit", "limits", "help")
    return listed("keys", names, ({"kind": kind} | {name: getattr(row, name) for name in names} for kind, row in rows))


def _scene_figures() -> Outcome:
    from bearing_twin.base.units import label_and_unit
    from bearing_twin.kinds import KINDS

    rows = [(kind, key, meaning) for kind, entry in KINDS.items() for key, meaning in entry.meanings_of().items()]
    header = ("kind", "figure", "unit", "meaning")
    figures = (
        {"kind": kind, "figure": key, "unit": label_and_unit(key)[1], "meaning": meaning} for kind, key, meaning in rows
    )
    return listed("figures", header, figures)


def _scene_rules() -> Outcome:
    from bearing_twin.kinds.rules import RULES

    header = ("kinds", "key", "choice", "when", "why")
    rules = (
        {"kinds": ", ".join(row.kinds), "example": list(row.example)}
        | {name: getattr(row, name) for name in header[1:]}
        for row in RULES
    )
    return listed("rules", header, rules)


SCENES = Subcommand(
    "list the scenes, every key of a scene, or the rules by which models are chosen",
    _scenes_arguments,
    _scenes,
    ("bearing_twin scenes", "bearing_twin scenes --keys", "bearing_twin scenes --rules"),
)


def _topics_arguments(parser) -> None:
    """The arguments of the subcommand."""
    parser.add_argument("scene", nargs="?", help="name of a scene or path of a YAML file; without, every kind")


def _topics(arguments) -> Outcome:
    """The table; raises SceneError."""
    from bearing_twin.kinds import KINDS
    from bearing_twin.log import stream
    from bearing_twin.run.scene import load_scene

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
