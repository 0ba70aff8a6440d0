"""What a run was foretold to take stands beside what it took: in its report, its log, its table, for nodes."""

import json
import math

import pytest

from bearing_twin.command.cli import main
from bearing_twin.log.mcap_log import write_log
from bearing_twin.log.run_log import read_log
from bearing_twin.nodes.simulating import worth
from bearing_twin.run.foretold import KEY, MUCH, WORDS, cost_in_words, cost_told
from bearing_twin.run.passes import Run
from bearing_twin.run.report_of import report_of
from bearing_twin.run.scene import load_scene
from bearing_twin.view.tables import error_notes

TOLD = {"motion": "settled", "counted": "ball_rates", "at_start": 100.0, "a_second": 1000.0}


def test_what_was_taken_stands_over_what_was_foretold_for_the_seconds_that_were_simulated():
    told = cost_told(TOLD, {"ball_rates": 900}, 0.5)[KEY]
    assert told == {"counted": "ball_rates", "predicted": 600.0, "taken": 900, "ratio": 1.5}
    assert cost_in_words(told) == "900 evaluations of a ball's rates, foretold 600"


@pytest.mark.parametrize(("taken", "told"), [(299, False), (300, False), (301, True), (30000, True), (1, False)])
def test_more_than_three_times_as_much_is_told_in_a_sentence(taken, told):
    found = cost_told(TOLD, {"ball_rates": taken}, 0.0)[KEY]
    assert MUCH == 3.0
    assert ("reason" in found) == told
    assert ("times the evaluations of a ball's rates that were foretold" in cost_in_words(found)) == told
    assert ("settled" in found.get("reason", "")) == told


@pytest.mark.parametrize(
    ("predicted", "costs"),
    [
        (None, {"ball_rates": 5}),
        ({}, {"ball_rates": 5}),
        (TOLD, {}),
        (TOLD, {"ball_rates": 0}),
        (TOLD | {"counted": "apples"}, {"apples": 5}),
        (TOLD | {"counted": ["ball_rates"]}, {"ball_rates": 5}),
        (TOLD | {"at_start": None}, {"ball_rates": 5}),
        (TOLD | {"a_second": "many"}, {"ball_rates": 5}),
        (TOLD | {"at_start": -1e9}, {"ball_rates": 5}),
        (TOLD | {"a_second": math.nan}, {"ball_rates": 5}),
    ],
)
def test_nothing_is_told_where_nothing_was_foretold_or_counted_whatever_a_log_says(predicted, costs):
    assert cost_told(predicted, costs, 1.0) == {}


def test_run_log_table_page_and_diagnostics_say_the_same(tmp_path, capsys):
    scene = load_scene("bearing_6203", ["run.duration=0.05"])
    run = Run(scene)
    write_log(run, tmp_path / "run.mcap")
    told = run.report.errors[KEY]
    assert told["taken"] == run.report.costs["ball_rates"]
    assert report_of(read_log(tmp_path / "run.mcap"))[0].errors[KEY] == told
    assert f"took {cost_in_words(told)}" in error_notes(run.report.errors)
    assert worth(run.report)["cost_over_predicted"] == told["ratio"]
    assert main(["report", str(tmp_path / "run.mcap"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[KEY] == told
    assert main(["report", str(tmp_path / "run.mcap")]) == 0
    shown = capsys.readouterr().out
    assert f"{told['taken']} {WORDS['ball_rates']}" in " ".join(shown.split())
    assert KEY not in shown


def test_a_model_that_a_scene_asks_for_has_nothing_foretold():
    run = Run(load_scene("bearing_6203", ["run.duration=0.01", "solver.stepper=rodas4"]))
    for _ in run.blocks():
        pass
    assert KEY not in run.report.errors
    assert "cost_over_predicted" not in worth(run.report)
