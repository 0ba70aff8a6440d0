"""What a run was foretold to take stands beside what it took: in its report, its log, its table, for nodes."""

import json
import math

import pytest

from bearing_twin.command.cli import main
from bearing_twin.log.run_log import read_log, write_log
from bearing_twin.nodes.simulation_loop import worth
from bearing_twin.report import BESIDE
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


def test_a_scene_that_no_table_is_like_has_nothing_foretold():
    run = Run(load_scene("bearing_6203", ["run.duration=0.01", "geometry.balls=13"]))
    for _ in run.blocks():
        pass
    assert KEY not in run.report.errors
    assert "cost_over_predicted" not in worth(run.report)


@pytest.mark.parametrize("before", [None, "many", 0, 40])
def test_what_finding_how_balls_move_took_is_told_and_not_counted(before):
    still = {"motion": "equilibria", "counted": "equilibria", "at_start": 1.0, "a_second": 100.0, "before": before}
    told = cost_told(still, {"equilibria": 101, BESIDE: 2}, 1.0)[KEY]
    beside = 42 if before == 40 else 2
    assert (told["ratio"], told[BESIDE]) == (1.0, beside)
    found = f"{beside} evaluations of what acts on a ball, to find how balls move"
    assert cost_in_words(told) == f"101 equilibria, foretold 100; not counted: {found}"
    assert BESIDE not in cost_told(still | {"before": None}, {"equilibria": 101}, 1.0)[KEY]


LIGHT = "model.dimension=quasi_static", "run.duration=0.02"


@pytest.mark.parametrize(
    ("words", "least", "most"),
    [
        (("bearing_6203_tilted", *LIGHT), 10 * 17, 1e5),  # its axes settle: Newton's method at 17 azimuths and more
        (("bearing_6203_rig_400N", *LIGHT), 10 * 64 * 8, 1e8),  # balls leave a raceway: they are moved
        (("bearing_6203_rig_400N", *LIGHT, "rings.inner.mass=0", "wanted.tolerance=0.05"), 0, 0),  # as in rolling
    ],
)
def test_the_start_of_equilibria_is_said_with_what_it_took(words, least, most):
    run = Run(load_scene(words[0], words[1:]))
    for _ in run.blocks():
        pass
    told = run.report.errors[KEY]
    assert told["ratio"] == pytest.approx(1.0, rel=0.1)
    assert least <= told.get(BESIDE, 0) <= most
    assert run.choice.predicted["before"] <= told.get(BESIDE, 0)
