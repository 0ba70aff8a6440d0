"""The table of rules: every row applies to its example, is listed and is given as the reason."""

import json

import pytest

from bearing_twin import load_scene
from bearing_twin.base.parameters import describe
from bearing_twin.command.cli import main
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.rules import RESOLVED, RULES, SETTING, answers
from bearing_twin.run.scene import choose, scene_names


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


def test_the_table_is_short_and_every_key_of_it_has_a_last_row_and_exists():
    assert len(RULES) <= 40
    for kind in {kind for row in RULES for kind in row.kinds}:
        known = {one.key: one for one in describe(KINDS[kind].parameters)}
        for key in {row.key for row in RULES if kind in row.kinds}:
            *_, last = (row for row in RULES if kind in row.kinds and row.key == key)
            assert not last.when, f"{kind}: {key}"
            if key in known and known[key].options and last.value is None:
                assert all(row.choice in known[key].options for row in RULES if kind in row.kinds and row.key == key)


@pytest.mark.parametrize("name", scene_names())
def test_what_a_scene_fixes_is_kept_and_what_it_leaves_open_is_explained(name, capsys):
    assert main(["explain", name, "--json"]) == 0
    reported = {one["key"]: one for one in json.loads(capsys.readouterr().out)["choices"]}
    scene = load_scene(name)
    for key, one in answers(scene.kind, scene.parameters).items():
        assert (reported[key]["value"], reported[key]["why"]) == (one.value, one.sentence)
        assert (one.rule is None) == one.sentence.endswith("as given")
        if key in RESOLVED:
            assert answers(scene.kind, load_scene(scene.resolved()).parameters)[key].value == one.value


def test_the_rules_are_listed(capsys):
    assert main(["scenes", "--rules", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rules"]
    assert [(one["key"], one["choice"], one["why"]) for one in rows] == [
        (row.key, row.choice, row.why) for row in RULES
    ]


def test_a_log_keeps_the_friction_model_that_was_chosen(tmp_path):
    """A later version may choose another one: figures of the log are those of the model it was made with."""
    from bearing_twin import read_log, simulate, write_log

    scene = load_scene("bearing_6203", ["contact.friction=auto", "run.duration=0.002", "solver.companion=off"])
    run = simulate(scene)
    write_log(run, tmp_path / "run.mcap")
    assert run.report.law == "hertz"
    assert read_log(tmp_path / "run.mcap").choice.friction == "spot"
