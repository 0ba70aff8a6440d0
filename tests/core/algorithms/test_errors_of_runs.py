"""Errors that a run reports: those of the method and of the model apart, and no status done above the tolerance."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from runs import reported

from bearing_twin.base.report import Choice
from bearing_twin.kinds.error_estimates import FRICTION_MODEL, LAW, Errors
from bearing_twin.run.report import DOUBTFUL, FAILED, STATUSES, is_large_error, judge_errors
from bearing_twin.run.second_run import OutputError

FIGURES = {"torque_nm": 2.0, "load_n": [100.0, 50.0, 0.0], "speed_rad_s": 7.0, "none_j": None}
CHOICE = Choice("hertz", "rodas4", 0.0, "", ())
NORM = "over the greatest load"


def estimate(figures=None, error=0.0, horizon=None, until=None):
    """An estimate of these figures' errors, and of loads."""
    outputs = {"loads": OutputError(NORM, error, 0.018, until)}
    gathered = {"horizon": horizon, "note": "", "smaller": "tighten it", "tolerance": 1e-3}
    return SimpleNamespace(of_figures=lambda _: figures or {}, of_outputs=lambda: outputs, **gathered)


def test_errors_of_method_and_model_stand_apart():
    """The error of a figure is the method's alone; a figure without one has null."""
    model = Errors({"torque_nm": {LAW: 0.02}, "load_n": {LAW: [1.0, 2.0, 3.0]}, "none_j": {LAW: 1.0}})
    judged = judge_errors(model, estimate({"torque_nm": 0.01, "speed_rad_s": None}), FIGURES, "done", CHOICE)
    assert judged.keys["torque_nm_error"] == 0.01
    assert judged.keys["speed_rad_s_error"] is None
    assert judged.keys["load_n_error"] is None
    assert "none_j_error" not in judged.keys
    assert judged.keys["model_errors"] == {LAW: {"torque_nm": 0.02, "load_n": [1.0, 2.0, 3.0]}}
    assert (judged.status, judged.flags) == ("done", ())


@pytest.mark.parametrize(("error", "status"), [(2e-3, DOUBTFUL), (math.nan, DOUBTFUL), (1e-3, "done"), (None, "done")])
def test_above_the_tolerance_a_run_is_doubtful_and_says_what_would_mend_it(error, status):
    judged = judge_errors(Errors(), estimate(error=error), FIGURES, "done", CHOICE)
    assert judged.status.partition(":")[0] == status
    assert judged.status.partition(":")[0] in STATUSES
    assert len(judged.exceeded) == (status == DOUBTFUL)
    assert all("tighten it" in sentence and "0.001" in sentence for sentence in judged.exceeded)
    failed = judge_errors(Errors(), estimate(error=error), FIGURES, f"{FAILED}: energy", CHOICE)
    assert failed.status == f"{FAILED}: energy"


def test_a_figure_whose_error_is_over_a_tenth_of_it_is_marked_with_its_source():
    figures = {"torque_nm": 1e-6, "load_n": [1.0, 9.0, 9.9]}
    (flag,) = judge_errors(
        Errors({"torque_nm": {FRICTION_MODEL: 0.3}}), estimate(figures), FIGURES, "done", CHOICE
    ).flags
    assert "torque 2 ± 0.3 N m, mostly friction model" in flag
    assert "load" not in flag
    figures = {"torque_nm": 1.0, "load_n": [20.0, 9.0, 1.0]}
    for errors, named in (
        ({}, {"torque", "load"}),
        ({"integral_of": {"torque_nm": "load_n"}}, {"load"}),
        ({"negligible": {"torque_nm": 1.0}}, {"load"}),
        ({"negligible": {"torque_nm": 0.9}}, {"torque", "load"}),
    ):
        (flag,) = judge_errors(Errors(**errors), estimate(figures), FIGURES, "done", CHOICE).flags
        assert {name for name in ("torque", "load") if name in flag} == named
    for thrust, error, flags in ((1e-11, 1e-11, 0), (1e-9, 1e-9, 1), (0.0, 1.0, 0)):  # rounding beside 100 N; nothing
        judged = judge_errors(Errors(), estimate({"thrust_n": error}), FIGURES | {"thrust_n": thrust}, "done", CHOICE)
        assert (len(judged.flags), len(judged.keys["large_errors"])) == (flags, flags)
    assert not is_large_error(0.4, 0.8, "dB")  # a level near 0 dB is no small amplitude
    assert is_large_error(50.0, 0.9, "dB")


@pytest.mark.parametrize(
    ("scene", "overrides"),
    [
        ("bearing_6203", ["run.duration=0.01"]),
        ("bearing_6203_run_up", ["run.duration=0.005"]),
        ("bearing_218_thrust", ["run.duration=0.01"]),
    ],
)
def test_every_figure_has_an_error_in_its_shape_or_null(scene, overrides):
    report = reported(scene, *overrides)
    known = {key.removesuffix("_error"): error for key, error in report.errors.items() if key.endswith("_error")}
    for key, error in known.items():
        assert error is None or np.shape(error) == np.shape(report.figures[key])
    assert (report.stepper == "quasi_static") == all(error is None for error in known.values())


def test_no_figure_shows_more_digits_than_its_model_has(shown):
    """`cage speed 646.524 ± 0.00081 rpm` stood beside 3.2 % off rolling."""
    model = Errors({"speed_rad_s": {LAW: 0.3}})
    judged = judge_errors(model, estimate({"speed_rad_s": 1e-6, "torque_nm": 1e-3}), FIGURES, "done", CHOICE)
    lines = {line.split()[0]: line for line in shown(FIGURES | judged.keys).splitlines() if line.strip()}
    assert "±" not in lines["speed"]
    assert "±" in lines["torque"]
    assert "4.3 %" in lines["model"]
