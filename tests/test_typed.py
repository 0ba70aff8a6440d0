"""Checkers of types see the public names and what they take and give; what can be pickled, and what says it cannot."""

import ast
import copy
import inspect
import pickle
import pydoc
import re
from pathlib import Path

import pytest

import bearing_twin
from bearing_twin import BearingTwinError, read_log, simulate, write_log
from bearing_twin.log.run_log import LogStream
from bearing_twin.run.simulation import Run
from bearing_twin.uq.result import StudyResult

PACKAGE = Path(bearing_twin.__file__).parent
PUBLIC = [name for name in dir(bearing_twin) if not name.startswith("_")]
FUNCTIONS = [one for one in map(bearing_twin.__getattr__, PUBLIC) if inspect.isfunction(one)]


def parts_of(owner):
    """Public methods and properties of a class, as functions."""
    members = {name: one for name, one in vars(owner).items() if not name.startswith("_")}
    return [one.fget if isinstance(one, property) else one for one in members.values() if not isinstance(one, type)]


def test_checkers_of_types_are_told_every_public_name_and_its_home():
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text())
    reported = {one.asname: node.module for node in tree.body if isinstance(node, ast.ImportFrom) for one in node.names}
    assert sorted(reported) == sorted(PUBLIC)
    for name, home in reported.items():
        assert getattr(bearing_twin, name).__module__ == home
    assert (PACKAGE / "py.typed").is_file()


def test_help_shows_the_public_names_and_an_import_of_all_has_them():
    shown, found = pydoc.plain(pydoc.render_doc(bearing_twin)), {}
    exec("from bearing_twin import *", found)
    for name in PUBLIC:
        assert found[name] is getattr(bearing_twin, name)
        assert re.search(rf"^ {{4}}(class )?{name}\(", shown, re.MULTILINE)


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda one: one.__name__)
def test_public_functions_say_what_they_take_and_give(function):
    signature = inspect.signature(function)
    assert signature.return_annotation is not inspect.Signature.empty
    assert all(one.annotation is not inspect.Parameter.empty for one in signature.parameters.values())


@pytest.mark.parametrize("owner", [Run, LogStream, StudyResult], ids=lambda one: one.__name__)
def test_what_they_give_has_types_and_words(owner):
    for one in filter(inspect.isfunction, parts_of(owner)):
        assert inspect.signature(one).return_annotation is not inspect.Signature.empty, one
        assert inspect.getdoc(one), one


def test_a_run_says_why_it_is_not_copied_and_what_can_be(tmp_path):
    run = simulate("two_spheres")
    blocks = list(run.blocks())
    for copied in (pickle.dumps, copy.copy, copy.deepcopy):
        with pytest.raises(BearingTwinError, match=r"take its scene"):
            copied(run)
    report, scene, again = pickle.loads(pickle.dumps((run.report, run.scene, blocks)))
    assert report.as_dict() == run.report.as_dict()
    first = next(iter(simulate(scene).blocks()))
    assert all((first[one.name] == again[0][one.name]).all() for one in run.channels)
    write_log(run, tmp_path / "run.mcap")
    assert len(pickle.loads(pickle.dumps(list(read_log(tmp_path / "run.mcap"))))) == run.outputs
