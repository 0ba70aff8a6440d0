"""What the choices of a run foretell, one after the other: a new one is compared with what it takes from then on."""

import json
import math

import pytest

from bearing_twin.nodes.simulation_loop import errors_of
from bearing_twin.report import BESIDE
from bearing_twin.run.foretold import KEY, SINCE, Account, cost_in_words, logged
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

FIRST = {"motion": "settled", "counted": "ball_rates", "at_start": 100.0, "a_second": 1000.0, "load_error": 1e-5}
THEN = {"motion": "fast", "counted": "ball_rates", "at_start": 50.0, "a_second": 5000.0, "load_error": 1e-4}
STILL = {"motion": "equilibria", "counted": "equilibria", "at_start": 1.0, "a_second": 100.0, "load_error": 1e-6}
SOON, FAST = "drive.acceleration=50000.0", 1500.0  # rad/s^2, rad/s


def test_of_the_last_choice_it_is_told_what_it_takes_and_of_all_what_they_err():
    account = Account(FIRST)
    assert account.told({"ball_rates": 600}, 0.5)[KEY] == {
        "counted": "ball_rates",
        "predicted": 600.0,
        "taken": 600,
        "ratio": 1.0,
    }
    account.goes_on(THEN, 0.5, {"ball_rates": 600})
    told = account.told({"ball_rates": 600 + 2 * 1050}, 0.7)[KEY]
    assert (told["predicted"], told["taken"], told["ratio"]) == (pytest.approx(1050.0), 2100, pytest.approx(2.0))
    assert told[SINCE] == 0.5
    assert "from 0.5 s on, foretold 1000" in cost_in_words(told)
    assert account.errors == {"load_error": 1e-4}
    account.goes_on(STILL, 0.7, {"ball_rates": 2700, "equilibria": 5, BESIDE: 7})
    told = account.told({"ball_rates": 2700, "equilibria": 16, BESIDE: 7}, 0.8)[KEY]
    assert (told["taken"], told["ratio"]) == (11, pytest.approx(1.0))
    assert BESIDE not in told  # that was before
    assert account.errors == {"load_error": 1e-4}


def test_where_one_choice_foretold_nothing_nothing_is_known_of_errors():
    account = Account(FIRST | {"friction_error": 1e-3})
    account.goes_on(STILL, 0.1, {})
    assert account.errors == {"load_error": 1e-5}
    account.goes_on(None, 0.2, {"ball_rates": 5})
    assert account.errors == {} == account.told({"ball_rates": 50}, 0.5)
    account.goes_on(THEN, 0.3, {"ball_rates": 50})
    assert account.errors == {}
    assert account.told({"ball_rates": 60}, 0.5)[KEY]["taken"] == 10


COST = {"counted": "ball_rates", "predicted": 10.0, "taken": 12, "ratio": 1.2, SINCE: 0.5}
ROWS = {"loads": {"predicted": 1e-5}, "friction": {"error": 1.0}, "none": 3}


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ({KEY: COST, "wanted_errors": ROWS}, ({"load_error": 1e-5}, {KEY: COST})),
        ({KEY: {key: one for key, one in COST.items() if key != SINCE}, "wanted_errors": ROWS}, None),
        ({KEY: COST | {"counted": "apples"}, "wanted_errors": ROWS}, None),
        ({KEY: COST | {"counted": ["ball_rates"]}, "wanted_errors": ROWS}, None),
        ({KEY: COST | {"ratio": math.nan}, "wanted_errors": ROWS}, None),
        ({KEY: COST | {"taken": "12"}, "wanted_errors": ROWS}, None),
        ({KEY: COST, "wanted_errors": 3}, None),
        ({KEY: 3, "wanted_errors": ROWS}, None),
        ({}, None),
    ],
)
def test_a_log_is_believed_where_it_says_what_a_run_does(said, told):
    assert logged(said) == told
    assert logged(json.loads(json.dumps(said))) == told


@pytest.mark.usefixtures("made_up_costs")
def test_after_a_command_what_the_new_choice_takes_stands_beside_what_was_foretold_of_it():
    simulation = Simulation(load_scene("bearing_6203", (SOON, "run.output_rate=1e3")))
    first = simulation.choice.predicted
    simulation.advance(101)
    told = simulation.report().errors[KEY]
    assert SINCE not in told
    simulation.set_speed(FAST)
    simulation.advance(1)
    before = simulation.report().errors[KEY][SINCE]
    simulation.advance(500)
    report, then = simulation.report(), simulation.choice.predicted
    told = report.errors[KEY]
    assert (simulation.choice.stepper, then["motion"]) == ("rodas3", "fast")
    assert before == pytest.approx(0.1)
    assert told[SINCE] >= before
    assert 0 < told["taken"] < report.costs["ball_rates"]
    assert 1.0 / 4.0 < told["ratio"] < 3.0
    assert then["load_error"] != first["load_error"]
    shown, wanted = errors_of(report), report.errors["wanted_errors"]
    assert shown["cost_over_predicted"] == told["ratio"]
    for output, key in (("loads", "load_error"), ("friction", "friction_error")):
        assert shown[f"{output}_error_predicted"] == wanted[output]["predicted"] == max(first[key], then[key])
    simulation.reset()
    simulation.advance(101)
    assert SINCE not in simulation.report().errors[KEY]


def test_a_new_choice_of_which_little_was_given_out_is_not_told_to_take_too_much():
    """Costs hold what was computed ahead: so does what is foretold."""
    simulation = Simulation(load_scene("bearing_6203", (SOON, "run.output_rate=1e4")))
    simulation.advance(1001)
    simulation.set_speed(FAST)
    ratios = []
    for _ in range(40):
        simulation.advance(5)
        ratios.append(simulation.report().errors[KEY]["ratio"])
    assert max(ratios) < 3.0
