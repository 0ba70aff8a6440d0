"""Choices and reports before a run begins: rules and their reasons, its cost; the time left while it goes on."""

import sys

import numpy as np
import pytest

from bearing_twin.base.parameters import describe
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.rules import RESOLVED, RULES, SETTING, answers
from bearing_twin.log.run_log import write_log
from bearing_twin.run import simulation as cost
from bearing_twin.run.scene import choose, load_scene, scene_names
from bearing_twin.run.simulation import cost_of, simulate


@pytest.mark.parametrize("row", RULES, ids=lambda row: f"{row.kinds[0]} {row.key} {row.choice}")
def test_every_row_applies_to_its_example_and_is_the_reason_that_a_report_gives(row):
    scene = load_scene(row.example[0], row.example[1:])
    assert answers(scene.kind, scene.parameters)[row.key].rule is row
    choice = choose(scene)
    silent = choice.stepper == "quasi_static" and row.key in (
        "cage.kind",
        "contact.friction",
        "solver.stepper",
        SETTING,
    )
    assert row.why in choice.reason or silent


def test_every_key_of_the_rules_has_a_last_row_and_exists():
    for kind in {kind for row in RULES for kind in row.kinds}:
        known = {row.key: row for row in describe(KINDS[kind].parameters)}
        for key in {row.key for row in RULES if kind in row.kinds}:
            *_, last = (row for row in RULES if kind in row.kinds and row.key == key)
            assert not last.when, f"{kind}: {key}"
            if key in known and known[key].options and last.value is None:
                assert all(row.choice in known[key].options for row in RULES if kind in row.kinds and row.key == key)


@pytest.mark.parametrize("name", scene_names())
def test_what_a_scene_fixes_is_kept_and_what_it_leaves_open_is_explained(name, run_json):
    reported = {entry["key"]: entry for entry in run_json("explain", name)["choices"]}
    scene = load_scene(name)
    for key, answer in answers(scene.kind, scene.parameters).items():
        assert (reported[key]["value"], reported[key]["why"]) == (answer.value, answer.sentence)
        assert (answer.rule is None) == answer.sentence.endswith("as specified")
        if key in RESOLVED:
            assert answers(scene.kind, load_scene(scene.resolved()).parameters)[key].value == answer.value


def test_a_log_keeps_the_friction_model_that_was_chosen(tmp_path):
    """A later version may choose another one: figures of the log are those of the model it was made with."""
    from bearing_twin import read_log, simulate, write_log

    scene = load_scene("bearing_6203", ["contact.friction=auto", "run.duration=0.002", "solver.companion=off"])
    run = simulate(scene)
    write_log(run, tmp_path / "run.mcap")
    assert run.report.law == "hertz"
    assert read_log(tmp_path / "run.mcap").choice.friction == "spot"


@pytest.mark.parametrize("balls", [8, 3])
def test_the_log_is_as_large_as_told(balls, tmp_path):
    pinned = ("run.duration=2", "solver.stepper=rodas4", "contact.normal=hertz", f"geometry.balls={balls}")
    scene = load_scene("bearing_6203", pinned)
    written = write_log(simulate(scene), tmp_path / "run.mcap")
    reported = cost_of(scene)
    assert (reported.outputs, reported.sentence(True, np.inf)) == (written.samples, "")
    assert 0.8 < written.bytes / reported.log_bytes < 1.25


def test_a_large_run_is_announced_before_it_begins(tmp_path, monkeypatch, run_cli):
    reported = cost_of(load_scene("bearing_6203", ["run.duration=86400"]))
    assert 3e11 < reported.log_bytes < 6e11
    assert f"a log of about {reported.log_bytes:.2g} B where 1e+09 B are free" in reported.sentence(True, 1e9)
    monkeypatch.setattr(cost, "LARGE", 1e6)
    command = ["simulate", "bearing_6203", "--duration", "0.3", "--json"]
    assert "bearing_6203: 301 outputs, a log of about 1." in run_cli(*command, "--out", tmp_path / "run.mcap").err
    assert "a log" not in run_cli(*command).err


@pytest.mark.parametrize("terminal_there", [True, False])
def test_progress_is_shown_on_a_terminal_alone(terminal_there, monkeypatch, run_cli):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal_there)
    monkeypatch.setenv("TERM", "xterm")
    printed = run_cli("simulate", "bearing_6203", "--duration", "0.02", "--json")
    assert printed.out.count("\n") == 1
    assert ("100%" in printed.err) == terminal_there
