"""All that sentences recommend exists: keys, their words, options, subcommands; read from the source."""

import argparse
import ast
import functools
import inspect
import itertools
import re

import pytest
from sources import PACKAGE, nodes_of, package_trees

import bearing_twin
from bearing_twin.base.parameters import describe
from bearing_twin.command.cli import _parsers
from bearing_twin.contact.friction import PATCH_NAMES
from bearing_twin.run.scene import KINDS
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


def found(pattern):
    return [(where, match) for where, text in sentences() for match in re.finditer(pattern, text)]


@functools.cache
def keys_at(where):
    """The keys that a sentence at this place may name: those of the kinds in its folder, or of all."""
    folder = re.match(r"kinds/(\w+)/", where)
    kinds = [kind for kind, row in KINDS.items() if folder and f".kinds.{folder[1]}." in row.parameters.__module__]
    return {row.key for kind in kinds for row in ROWS[kind]} or KEYS


def test_every_key_in_a_sentence_is_one():
    words = found(rf"(?<![\w./\[{{])({'|'.join(sorted(SECTIONS))})((?:\.[a-z]\w*)+)(?![\w/(\0])")
    assert len(words) > 60
    keys = ((where, match.group()) for where, match in words if not match.group().endswith(FILES))
    assert [
        one for one in keys if not any(key == one[1] or key.startswith(f"{one[1]}.") for key in keys_at(one[0]))
    ] == []


def test_every_word_recommended_for_a_key_is_legal():
    """`solver.stepper: dop853`: the word is an option of that key in some kind of scene."""
    options = {}
    for row in itertools.chain(*ROWS.values()):
        options.setdefault(row.key, set()).update(row.options)
    options["contact.friction"].update(PATCH_NAMES)
    words = [
        (where, match.group(1), match.group(2))
        for where, match in found(r"(?<![\w.])([a-z]+(?:\.[a-z_]+)+): ([a-z]\w*)")
        if options.get(match.group(1))
    ]
    assert len(words) > 5
    assert [(where, key, word) for where, key, word in words if word not in options[key]] == []


def options_of(parser):
    """The options of a parser and of the parsers of its own subcommands."""
    found, inner = set(), []
    for action in parser._actions:
        found.update(action.option_strings)
        inner += action.choices.values() if isinstance(action, argparse._SubParsersAction) else ()
    return found.union(*map(options_of, inner))


def test_every_option_in_a_sentence_is_one():
    options = set().union(*map(options_of, _parsers()[1].values())) | OF_OTHERS
    words = found(r"(?<![\w-])--[a-z][a-z0-9-]*(?![\w\0-])")
    assert len(words) > 15
    assert [(where, match.group()) for where, match in words if match.group() not in options | {"--version"}] == []


def test_every_subcommand_in_a_sentence_is_one():
    words = found(r"`bearing_twin ([a-z]+)")
    assert len(words) > 3
    there = _parsers()[1]
    assert [(where, match.group(1)) for where, match in words if match.group(1) not in there] == []


def test_every_function_in_a_sentence_is_a_public_name_and_takes_what_is_told():
    """As `recover(path, out) in Python`: whoever follows it writes `from bearing_twin import recover`."""
    public = {name: getattr(bearing_twin, name) for name in bearing_twin.__all__}
    words = [(where, match[1]) for where, match in found(r"(?<![\w.])([a-z]\w*)\(") if match[1] not in NO_ADVICE]
    assert {"simulate", "read_log"} <= {name for _, name in words}
    assert [one for one in words if one[1] not in public and not hasattr(Run, one[1])] == []
    reported = [(where, match[1]) for where, match in found(r"(?<![\w.])([a-z]+(?:_[a-z]+)+)=True")]
    assert {"allow_gaps", "last_run"} <= {name for _, name in reported}
    taken = set().union(*(inspect.signature(one).parameters for one in public.values() if not isinstance(one, type)))
    assert [one for one in reported if one[1] not in taken] == []


@pytest.mark.parametrize("theory", ["boundary element", "multigrid", "theory of line contact"])
def test_no_sentence_sends_anyone_to_a_theory_that_is_not_here(theory):
    assert [where for where, text in sentences() if theory in text.lower()] == []
