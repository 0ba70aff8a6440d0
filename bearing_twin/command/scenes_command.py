"""The subcommand `scenes`: scenes, keys, figures, JSON Schema. Imports are late, so that --help is quick."""

import argparse

from bearing_twin.command.outcome import Outcome, listed

HELP = "list the scenes, or every key of a scene"
EXAMPLES = ("bearing_twin scenes", "bearing_twin scenes --keys", "bearing_twin scenes --figures --json")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `scenes` to its parser."""
    lists = parser.add_mutually_exclusive_group()
    lists.add_argument("--keys", action="store_true", help="list every key of a scene: default, unit, limits, meaning")
    lists.add_argument("--figures", action="store_true", help="list every figure of a run: unit, meaning")
    lists.add_argument("--schema", action="store_true", help="the JSON Schema of scene and study files, for editors")


def run(arguments: argparse.Namespace) -> Outcome:
    """The list that is asked for."""
    from bearing_twin.shelf import SCENES

    if arguments.keys:
        return _keys()
    if arguments.figures:
        return _figures()
    if arguments.schema:
        return _schema()
    header = ("name", "kind", "description")
    return listed("scenes", header, ({name: head[name] for name in header} for head in SCENES.heads()))


def _keys() -> Outcome:
    from bearing_twin.kinds import KINDS
    from bearing_twin.parameters import describe

    rows = [(kind, row) for kind, entry in KINDS.items() for row in describe(entry.parameters)]
    names = ("key", "type", "default", "unit", "limits", "help")
    return listed("keys", names, ({"kind": kind} | {name: getattr(row, name) for name in names} for kind, row in rows))


def _figures() -> Outcome:
    from bearing_twin.kinds import KINDS
    from bearing_twin.units import named

    rows = [(kind, key, meaning) for kind, entry in KINDS.items() for key, meaning in entry.meanings_of().items()]
    header = ("kind", "figure", "unit", "meaning")
    found = ({"kind": kind, "figure": key, "unit": named(key)[1], "meaning": meaning} for kind, key, meaning in rows)
    return listed("figures", header, found)


def _schema() -> Outcome:
    from bearing_twin.command.terminal import show_text
    from bearing_twin.report import json_text
    from bearing_twin.uq.schema import schema

    found = schema()
    return Outcome(found, [], lambda: show_text(json_text(found)))
