"""All that sentences recommend exists: keys, their words, options, subcommands; read from the source."""

import argparse
import ast
import functools
import inspect
import itertools
import re

from sources import PACKAGE, nodes_of, package_trees

import bearing_twin
from bearing_twin.base.parameters import describe
from bearing_twin.command.cli import parsers
from bearing_twin.contact.friction import PATCH_NAMES
from bearing_twin.kinds import KINDS
from bearing_twin.run.simulation import Run
from bearing_twin.uq.study import Settings

FILES = (".mcap", ".png", ".nc", ".html")  # ends of names that are no keys
OF_OTHERS = {"--ros-args", "--from-paths", "--layout", "--datafile", "--src", "--dst", "--dst-storage"}
# options of nodes, of rosdep, of PlotJuggler and of rosbags-convert
NO_ADVICE = {
    "sqrt",
    "exp",
    "ln",
    "d",
    "choose",
    "done",
    "requestAnimationFrame",
}  # of formulas, of code that is made, of a page's script
GAP = "\0"  # stands for what an f-string fills in
ROWS = {kind: describe(row.parameters) for kind, row in KINDS.items()}
STUDY_KEYS = {row.key for row in describe(Settings)} | {"stop.quantity"}
KEYS = STUDY_KEYS | {row.key for rows in ROWS.values() for row in rows}
SECTIONS = {key.split(".")[0] for key in KEYS if "." in key}


@functools.cache
def sentences():
    """(where, text) of every text of several words in the package but its docstrings."""
    return [(where, text) for where, text in texts() if " " in text]


def texts():
    for path in package_trees():
        nodes = [node for node in nodes_of(path) if isinstance(node, (ast.Expr, ast.JoinedStr, ast.Constant))]
        silent = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        for node in nodes:
            if isinstance(node, ast.JoinedStr):
                silent |= {id(part) for part in node.values}
                parts = [part.value if isinstance(part, ast.Constant) else GAP for part in node.values]
                yield f"{path.relative_to(PACKAGE)}:{node.lineno}", "".join(map(str, parts))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in silent:
                yield f"{path.relative_to(PACKAGE)}:{node.lineno}", node.value


def matches_in(pattern):
    return [(location, match) for location, text in sentences() for match in re.finditer(pattern, text)]


@functools.cache
def keys_at(location):
    """The keys that a sentence at this location may name: those of the kinds in its folder, or of all."""
    folder = re.match(r"kinds/(\w+)/", location)
    kinds = [kind for kind, row in KINDS.items() if folder and f".kinds.{folder[1]}." in row.parameters.__module__]
    return {row.key for kind in kinds for row in ROWS[kind]} or KEYS


def test_every_key_in_a_sentence_is_one():
    keys_named = matches_in(rf"(?<![\w./\[{{])({'|'.join(sorted(SECTIONS))})((?:\.[a-z]\w*)+)(?![\w/(\0])")
    assert len(keys_named) > 60
    keys = ((location, match.group()) for location, match in keys_named if not match.group().endswith(FILES))
    assert [
        (location, name)
        for location, name in keys
        if not any(key == name or key.startswith(f"{name}.") for key in keys_at(location))
    ] == []


def test_every_word_recommended_for_a_key_is_legal():
    """`solver.stepper: dop853`: the word is an option of that key in some kind of scene."""
    options = {}
    for row in itertools.chain(*ROWS.values()):
        options.setdefault(row.key, set()).update(row.options)
    options["contact.friction"].update(PATCH_NAMES)
    values_named = [
        (location, match.group(1), match.group(2))
        for location, match in matches_in(r"(?<![\w.])([a-z]+(?:\.[a-z_]+)+): ([a-z]\w*)")
        if options.get(match.group(1))
    ]
    assert len(values_named) > 5
    assert [(location, key, value) for location, key, value in values_named if value not in options[key]] == []


def options_of(parser):
    """The options of a parser and of the parsers of its own subcommands."""
    options, subparsers = set(), []
    for action in parser._actions:
        options.update(action.option_strings)
        subparsers += action.choices.values() if isinstance(action, argparse._SubParsersAction) else ()
    return options.union(*map(options_of, subparsers))


def test_every_option_in_a_sentence_is_one():
    options = set().union(*map(options_of, parsers()[1].values())) | OF_OTHERS
    options_named = matches_in(r"(?<![\w-])--[a-z][a-z0-9-]*(?![\w\0-])")
    assert len(options_named) > 15
    assert [
        (location, match.group()) for location, match in options_named if match.group() not in options | {"--version"}
    ] == []


def test_every_subcommand_in_a_sentence_is_one():
    commands_named = matches_in(r"`bearing_twin ([a-z]+)")
    assert len(commands_named) > 3
    commands = parsers()[1]
    assert [(location, match.group(1)) for location, match in commands_named if match.group(1) not in commands] == []


def test_every_function_in_a_sentence_is_a_public_name_and_takes_what_is_told():
    """As `recover(path, out) in Python`: whoever follows it writes `from bearing_twin import recover`."""
    public = {name: getattr(bearing_twin, name) for name in bearing_twin.__all__}
    calls = [
        (location, match[1]) for location, match in matches_in(r"(?<![\w.])([a-z]\w*)\(") if match[1] not in NO_ADVICE
    ]
    assert {"simulate", "read_log"} <= {name for _, name in calls}
    assert [call for call in calls if call[1] not in public and not hasattr(Run, call[1])] == []
    reported = [(location, match[1]) for location, match in matches_in(r"(?<![\w.])([a-z]+(?:_[a-z]+)+)=True")]
    assert {"allow_gaps", "last_run"} <= {name for _, name in reported}
    functions = [value for value in public.values() if not isinstance(value, type)]
    parameters = set().union(*(inspect.signature(function).parameters for function in functions))
    assert [call for call in reported if call[1] not in parameters] == []
