"""Errors of a study's quantities: how they follow from those of figures, where they are found, and who tells them."""

import json

import numpy as np
import pytest

from bearing_twin import load_study, run_study
from bearing_twin.base.errors import StudyError
from bearing_twin.kinds.contract import Quantity
from bearing_twin.kinds.error_estimates import LAW, METHOD
from bearing_twin.log.study_log import read_study, write_study
from bearing_twin.uq.inputs import quantities_of
from bearing_twin.uq.realisations import RealisationErrors, empty, errors_of, simulated_scene, task_of
from bearing_twin.uq.result import model_error_sentences
from bearing_twin.uq.run import model_errors_of_checked
from bearing_twin.uq.study import parse_study
from bearing_twin.uq.workers import Ensemble
from bearing_twin.view.study_page import study_document

pytestmark = pytest.mark.usefixtures("quick_workers")

SPHERES = {
    "scene": "two_spheres",
    "inputs": {"motion.first_velocity": {"distribution": "uniform", "low": 0.05, "high": 0.1}},
    "quantities": ["peak_force", "contact_duration", "restitution"],
    "samples": 40,
    "method": "ensemble",
    "modality": "no",
}


def quantity_of(name, **settings):
    return run_study(parse_study({**SPHERES, **settings}, "study of spheres")).as_dict()["quantities"][name]


def test_errors_go_through_what_a_quantity_makes_of_figures():
    length = Quantity(("at",))
    figures = {"at": [3.0, -4.0], "else": 1.0}
    errors_of_length = errors_of(length, figures, {"at": {"method": [0.3, 0.4], "law": 0.0}, "else": {"left_out": 9.0}})
    assert errors_of_length == pytest.approx({"method": 0.5, "law": 0.0})
    assert errors_of(length, figures, {"else": {"method": 1.0}}) == {}
    greatest = quantities_of("bearing")["greatest_ball_load"]
    loads = {"greatest_normal_load_inner_n": [5.0, 9.0], "greatest_normal_load_outer_n": [6.0, 8.0]}
    # The error of a ball that carries less counts where it may carry most.
    errors = {"greatest_normal_load_outer_n": {"method": [4.0, 0.5]}}
    assert errors_of(greatest, loads, errors) == pytest.approx({"method": 1.0})


LOOSE = {
    "scene": "bearing_6203_loose",
    "set": ["run.duration=0.012", "run.output_rate=1000", "wanted.tolerance=0.01"],
    "inputs": {"geometry.radial_clearance": {"distribution": "uniform", "low": 8e-6, "high": 14e-6}},
    "quantities": ["greatest_ball_load", "cage_speed", "dissipated_energy"],
    "modality": "no",
    "workers": 1,
    "samples": 70,
}


def test_a_realisation_has_no_second_run_unless_it_is_checked():
    task = task_of(parse_study(LOOSE, "study"))
    asked = [simulated_scene(candidate)["solver"]["check"] for candidate in (task, task._replace(checked=True))]
    assert asked == ["none", "second_run"]


def test_the_greatest_error_by_each_source_stands_for_all_and_their_sum_for_the_model():
    study = parse_study(SPHERES, "study")
    each = [{METHOD: 3.0, LAW: 0.1}, {METHOD: 1.0, LAW: 0.4}, {METHOD: 2.0, LAW: 0.3}]
    of_rows = {row: RealisationErrors(dict.fromkeys(study.quantities, errors), {}) for row, errors in enumerate(each)}
    realisations = empty(task_of(study), len(each))._replace(errors=of_rows)
    by_quantity, checks, _ = model_errors_of_checked(study, realisations)
    assert checks["realisations"] == 3
    for reported in by_quantity.values():
        assert reported == {"error": pytest.approx(3.4), "errors_by_source": {METHOD: 3.0, LAW: 0.4}}


def test_the_error_of_a_law_is_what_another_law_gives():
    exact, approximate = quantity_of("peak_force", set=[]), quantity_of("peak_force", set=["contact.normal=volumetric"])
    error = approximate["errors_by_source"]["law"]
    # The greatest realisation is off most: the greatest of the sample bounds the mean.
    assert 1.0 < error / abs(approximate["mean"] - exact["mean"]) < 3.0
    assert exact["errors_by_source"]["law"] < 1e-12 * exact["mean"]
    assert approximate["error"] == pytest.approx(sum(approximate["errors_by_source"].values()))


def test_a_checked_realisation_is_the_one_of_the_sample():
    study = parse_study({**LOOSE, "quantities": ["greatest_ball_load"]}, "study of a bearing")
    task, values = task_of(study), study.joint.values(np.full((1, 1), 0.5))
    with Ensemble(task, 1, "processes", lambda: False) as ensemble:
        alone, checked = (
            ensemble.evaluate(values, task=task._replace(checked=is_checked)) for is_checked in (False, True)
        )
    assert alone.quantities.tobytes() == checked.quantities.tobytes()
    assert checked.errors[0].by_quantity["greatest_ball_load"]["method"] > 0.0


def test_without_checks_the_errors_are_not_known_and_that_is_said():
    result = run_study(parse_study({**SPHERES, "companions": 0}, "study"))  # the name of earlier versions
    assert result.study.settings.checks == 0
    with pytest.raises(StudyError, match="checks twice"):
        parse_study({**SPHERES, "companions": 0, "checks": 2}, "study")
    assert result.summary["quantities"]["peak_force"]["error"] is None
    assert "checks: 0" in result.summary["companions"]["errors_unknown"]["method"]
    assert not [sentence for sentence in model_error_sentences(result.summary) if "\u00b1" in sentence]


def test_without_a_sample_realisations_are_those_at_the_ends_of_the_inputs():
    result = run_study(parse_study({**SPHERES, "method": "change_of_variable", "quantities": ["peak_force"]}, "study"))
    assert not len(result.quantities)
    reported = result.summary["companions"]
    assert (reported["realisations"], reported["failed"]) == (3, 0)
    assert "5 and 95 %" in reported["where"]
    assert (
        0.0
        < result.summary["quantities"]["peak_force"]["error"]
        < 0.1 * result.summary["quantities"]["peak_force"]["mean"]
    )


def test_an_error_over_a_tenth_of_a_quantity_is_a_doubt():
    torque = {
        "scene": "bearing_6203",
        "set": ["run.duration=0.004"],
        "inputs": {"drive.speed": {"distribution": "uniform", "low": 180.0, "high": 190.0}},
        "quantities": ["drive_torque", "greatest_ball_load"],
        "samples": 3,
        "workers": 1,
    }
    result = run_study(parse_study(torque, "study of the torque"))
    assert [sentence for sentence in result.doubts if sentence.startswith("drive_torque: the error of the model is")]
    assert not [sentence for sentence in result.doubts if sentence.startswith("greatest_ball_load:")]
    (reported,) = (sentence for sentence in result.doubts if sentence.startswith("drive_torque:"))
    assert "mostly friction model: no sampling" in reported
    parts = result.summary["quantities"]["drive_torque"]["errors_by_source"]
    assert parts["friction_model"] > 100.0 * parts["method"] > 0.0
    assert "film" in result.summary["companions"]["errors_unknown"]


def test_log_and_page_tell_the_same(tmp_path):
    result = run_study(load_study("discs_small_10", ["samples=40"]))
    path = write_study(result, tmp_path / "study.mcap")
    assert json.loads(json.dumps(read_study(path).summary)) == json.loads(json.dumps(result.summary))
    reported = list(model_error_sentences(result.summary))
    page = study_document(result)
    assert set(reported) <= set(page["errors"])
    rows = {row["words"]: row for row in page["statistics"][0]["rows"]}
    assert float(rows["mean"]["error"]) > 0.0
    assert rows["standard deviation"]["error"] == ""
