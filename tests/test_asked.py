"""Steppers that a bearing scene asks for: judged by the rows of the tables, as those that are chosen."""

import csv
import math
import re

import pytest

from bearing_twin.kinds.bearing.asked import setting_of
from bearing_twin.kinds.bearing.measured import SPREAD, predictions
from bearing_twin.paths import share_path
from bearing_twin.run.fidelity import choose
from bearing_twin.run.foretold import KEY
from bearing_twin.run.passes import Run
from bearing_twin.run.scene import load_scene


def rows_of(table, **given):
    """Rows of a table in which a run came to its end."""
    with share_path("config", "measured", f"{table}.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return [row for row in rows if row["status"] == "done" and given.items() <= row.items()]


@pytest.mark.parametrize(
    ("scene", "words", "row"),
    [
        ("bearing_6203", ("rodas3", "wanted.tolerance=1e-5"), ("steppers", "settled", "1e-05")),
        ("bearing_6203", ("rodas4", "wanted.tolerance=2e-5"), ("steppers", "settled", "3e-05")),  # the next looser
        ("bearing_6203", ("rodas4", "wanted.tolerance=1e-7"), ("steppers", "settled", "1e-05")),  # the tightest
        ("bearing_6203", ("dopri5",), ("steppers", "settled", "0.001")),
        ("bearing_6203", ("dop853",), ("steppers", "settled", "1e-05")),  # ten thousand times tighter, in a scene
        ("bearing_6203", ("imex", "solver.step=4e-7"), ("steppers", "settled", "5e-07")),
        ("bearing_6203_loose", ("rk4", "solver.step=1e-6"), ("steppers", "lift-off", "1e-06")),
        ("bearing_6203_sudden", ("dopri5",), ("steppers", "sudden", "0.001")),
        ("bearing_6203_rig_400N", ("rodas3", "wanted.tolerance=1e-4"), ("motions", "free ring", "0.0001")),
    ],
)
def test_a_stepper_that_is_asked_for_is_foretold_by_its_row_and_gets_what_is_wanted(scene, words, row):
    scene = load_scene(scene, (f"solver.stepper={words[0]}", *words[1:]))
    choice, (table, motion, setting) = choose(scene), row
    [found] = rows_of(table, problem=motion, method=words[0], setting=setting)
    told = choice.predicted
    assert (choice.stepper, choice.setting) == (words[0], scene.parameters.wanted.tolerance)
    assert (told["motion"], told["stepper"]) == (motion, words[0])
    assert (told["load_error"], told["friction_error"]) == (float(found["load_error"]), float(found["friction_error"]))
    assert told["cost"] >= float(found["seconds"])
    assert f"{words[0]}, as the scene asks: it was off by" in choice.reason
    assert f"({motion})" in choice.reason


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        ("bearing_6203", ("rodas3", "run.duration=0.05")),
        ("bearing_6203", ("dopri5", "run.duration=0.004")),
        ("bearing_6203", ("dop853", "run.duration=0.001")),
        ("bearing_6203_loose", ("rodas4_landing", "run.duration=0.05")),
        ("bearing_6203_sticking", ("imex", "run.duration=0.002")),
        ("bearing_6203_rig_400N", ("rodas3", "run.duration=0.05")),
        ("bearing_6205", ("rodas4", "run.duration=0.05", "wanted.tolerance=1e-5")),
    ],
)
def test_what_a_stepper_that_is_asked_for_evaluates_is_foretold(scene, words):
    run = Run(load_scene(scene, (f"solver.stepper={words[0]}", "solver.companion=off", *words[1:])))
    for _ in run.blocks():
        pass
    told = run.report.errors[KEY]
    assert told["taken"] == run.report.costs["ball_rates"]
    assert 1.0 / 4.0 < told["ratio"] < 3.0


@pytest.mark.parametrize("words", [("rk4",), ("imex", "solver.step=3e-7"), ("imex", "solver.step=8e-7")])
def test_evaluations_of_fixed_steps_are_foretold_by_their_length(words):
    run = Run(load_scene("bearing_6203", (f"solver.stepper={words[0]}", "run.duration=0.004", *words[1:])))
    for _ in run.blocks():
        pass
    assert run.report.errors[KEY]["ratio"] == pytest.approx(1.0, rel=1e-2)  # outputs shorten a step each
    assert setting_of(run.scene.parameters, "hertz") == run.simulation._motion.step


@pytest.mark.parametrize(
    ("scene", "words", "told"),
    [
        ("bearing_6203", ("rk4", "contact.friction=spot"), "where friction is summed over the spots (drilling)"),
        ("bearing_6203", ("imex", "contact.relaxation_time=1e-8"), "where contacts are hardly damped (hardly damped)"),
        ("bearing_6203", ("rodas3", "geometry.balls=13"), "with balls that can touch"),
    ],
)
def test_a_row_that_is_missing_is_named(scene, words, told):
    choice = choose(load_scene(scene, (f"solver.stepper={words[0]}", *words[1:])))
    assert choice.predicted is None
    assert f"nothing is foretold, as no table has a row of it {told}" in choice.reason


def test_of_an_implicit_reference_errors_are_foretold_and_no_evaluations():
    run = Run(load_scene("bearing_6203", ("solver.stepper=radau", "run.duration=0.001")))
    for _ in run.blocks():
        pass
    assert run.report.errors["wanted_errors"]["loads"]["predicted"] == run.choice.predicted["load_error"]
    assert KEY not in run.report.errors
    assert "what it evaluates is not foretold" in run.choice.reason


@pytest.mark.parametrize("stepper", ["rodas4", "rodas3", "rodas4_landing", "imex", "rk4", "dopri5"])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
def test_what_auto_takes_instead_is_named_with_its_cost(stepper, tolerance):
    scene = load_scene("bearing_6203_loose", (f"solver.stepper={stepper}", f"wanted.tolerance={tolerance}"))
    choice, best = choose(scene), predictions(scene.parameters)
    same = (best[0].stepper, best[0].setting) == (stepper, choice.predicted["setting"])
    other = best[1] if same else best[0]
    told = re.search(r"auto takes (it, too, and next came )?(\w+) at a tolerance of ([0-9.e-]+), (.*)$", choice.reason)
    assert (bool(told[1]), told[2], told[3]) == (same, other.stepper, f"{other.setting:g}")
    times = other.cost / choice.predicted["cost"]
    if abs(math.log(times)) <= math.log(1.0 + SPREAD):
        assert told[4] == "which cost the same within 33 %"
    else:
        assert told[4] == f"at {times:.3g} times its cost"
