"""What a run says of its own figures: errors by source are added, a promise that is broken is never called done."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from runs import reported

from bearing_twin.command.terminal import show_result
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.doubt import FRICTION_MODEL, LAW, METHOD, Dearest, Errors, Promise
from bearing_twin.nodes.simulation_loop import errors_of
from bearing_twin.report import Choice, plain_json
from bearing_twin.run.doubt import DOUBTFUL, FAILED, STATUSES, companion_cost, exceeds, judged, promise_in_words
from bearing_twin.run.scene import load_scene
from bearing_twin.units import named, sentence_for_people, two_digits
from bearing_twin.view.tables import error_notes

FIGURES = {"torque_nm": 2.0, "load_n": [100.0, 50.0, 0.0], "speed_rad_s": 7.0, "none_j": None}


def promise(error, tolerance=1e-3):
    return Promise("loads", "over the greatest load", error, tolerance, "ball 3", "tighten it")


def test_errors_of_several_sources_are_kept_apart_and_added():
    parts = {
        "torque_nm": {METHOD: 0.01, LAW: 0.02},
        "load_n": {METHOD: [1.0, 2.0, 3.0], LAW: 0.5},
        "none_j": {LAW: 1.0},
    }
    found = judged(Errors(parts), FIGURES, "done")
    assert found.keys["torque_nm_error"] == 0.03
    assert found.keys["load_n_error"] == [1.5, 2.5, 3.5]
    assert found.keys["errors_by_source"] == {key: parts[key] for key in ("torque_nm", "load_n")}
    assert "none_j_error" not in found.keys
    assert "speed_rad_s_error" not in found.keys
    assert (found.status, found.flags) == ("done", ())


def test_figures_of_whose_error_nothing_is_known_are_named():
    found = judged(Errors({"load_n": {METHOD: 1.0}}), FIGURES | {"word": "x", "empty_m": []}, "done")
    assert found.keys["errors_unknown"] == {"figures": "nothing is known of the error of torque, speed"}
    spared = judged(Errors({"load_n": {METHOD: 1.0}}), FIGURES, "done", errorless=("torque_nm", "speed_rad_s"))
    assert not spared.keys["errors_unknown"]
    assert not judged(Errors(), FIGURES, "done").keys["errors_unknown"]  # of such a kind a note tells


@pytest.mark.parametrize(
    ("scene", "overrides", "unknown"),
    [
        ("bearing_6203", ["run.duration=0.01"], {"ring force range"}),
        ("bearing_218_thrust", ["run.duration=0.01"], {"drive work", "friction torque"}),
        (
            "bearing_6203_run_up",
            ["run.duration=0.02"],
            {"ring displacement range", "cage slip", "greatest pocket force"},
        ),
        ("shaft_two_6203", ["run.duration=0.01"], {"forward shares"}),
        ("ellipsoid_rocking", ["run.duration=0.05"], set()),
        ("two_bodies_groove", ["run.duration=0.02"], set()),
        ("sphere_on_beam_drop_50mm", [], set()),
        ("two_discs", [], set()),
        ("two_spheres", [], set()),
        ("soft_discs_mean", ["mesh.divisions=8", "mesh.order=2"], set()),
    ],
)
def test_every_figure_says_what_it_is_off_or_that_nobody_knows(scene, overrides, unknown):
    report = reported(scene, *overrides)
    doubt = KINDS[load_scene(scene).kind].doubt(load_scene(scene).parameters, Choice("hertz", "", 0.0, "", ()))
    note = report.errors["errors_unknown"].get("figures", "")
    named_ones = set(note.removeprefix("nothing is known of the error of ").split(", ")) - {""}
    assert unknown <= named_ones
    assert bool(unknown) == bool(named_ones)
    told = 0
    for key, value in report.figures.items():
        values = value if isinstance(value, list) else [value]
        if not all(isinstance(one, (int, float)) for one in values) or not values:
            continue
        words, error = named(key)[0], report.errors.get(f"{key}_error")
        if error is None:
            assert words in named_ones or key in doubt.errorless, key
        else:
            assert words not in named_ones
            assert np.shape(error) == np.shape(value), key
            told += 1
    assert told > 4


@pytest.mark.parametrize("error", [2e-3, math.nan, math.inf])
def test_worse_than_wanted_is_never_done(error):
    found = judged(Errors(promises=(promise(error),)), FIGURES, "done")
    assert found.status == f"{DOUBTFUL}: loads"
    assert "loads are off by" in found.flags[0]
    assert "wanted 0.001: tighten it" in found.flags[0]
    assert judged(Errors(promises=(promise(error),)), FIGURES, f"{FAILED}: energy").status == f"{FAILED}: energy"


def test_a_run_with_a_horizon_says_in_words_what_it_is_off_up_to_it(capsys):
    late = promise(0.12)._replace(before=3.3e-4)
    found = judged(Errors(promises=(late,), horizon=0.101), FIGURES, "done")
    assert "(ball 3), by 0.00033 up to 0.101 s, more than the wanted" in found.flags[0]
    show_result(FIGURES | found.keys)
    text = " ".join(capsys.readouterr().out.split())
    assert "0.12 over the greatest load, wanted 0.001; ball 3; 0.00033 up to the horizon" in text
    assert error_notes(found.keys)[0].endswith("; 0.00033 up to the horizon")
    told = errors_of(SimpleNamespace(status=found.status, errors=found.keys))
    assert told == {"status": "doubtful: loads", "loads_error": 0.12, "horizon_s": 0.101}


@pytest.mark.parametrize(("error", "may", "said"), [(4e-4, 9e-4, ""), (8e-4, 1.2e-3, ", which may be 0.0012, more")])
def test_what_may_be_off_by_more_than_wanted_is_doubtful(error, may, said):
    found = judged(Errors(promises=(promise(error)._replace(may=may),)), FIGURES, "done")
    assert found.status == ("doubtful: loads" if said else "done")
    assert said in " ".join(found.flags)
    told = found.keys["wanted_errors"]["loads"]
    assert told["may_be"] == may
    assert f"{two_digits(error)} (may be {two_digits(may)}) over the greatest load" in promise_in_words(told)
    assert ", more than the wanted" in judged(Errors(promises=(promise(2e-3),)), {}, "done").flags[0]


@pytest.mark.parametrize("error", [0.0, 1e-3, None])
def test_what_keeps_the_promise_or_is_not_known_is_done(error):
    found = judged(Errors(promises=(promise(error),)), FIGURES, "done")
    assert (found.status, found.flags) == ("done", ())


@pytest.mark.parametrize(
    ("figure", "error", "told"),
    [
        ("misalignment_rad", [7e-14, 0.0], [0.0, 0.0]),
        ("misalignment_rad", [7e-11, 0.0], [7e-11, 0.0]),
        ("ring_moment_nm", [0.0, 4e-15], [0.0, 0.0]),  # beside 1000 N on a spot of a millimetre
        ("ring_moment_nm", [0.0, 4e-11], [0.0, 4e-11]),
        ("work_j", math.nan, math.nan),
        ("load_n", 1e-10, 1e-10),  # of a load that is large it is told, however small
    ],
)
def test_what_rounding_leaves_of_a_figure_that_is_nothing_is_no_error(figure, error, told):
    figures = {"load_n": 1e3, "semi_major_m": 1e-3, "misalignment_rad": [0.0, 0.0], "ring_moment_nm": [0.0, 0.0]}
    figures["work_j"] = 0.0
    found = judged(Errors({figure: {METHOD: error}}), figures, "done")
    assert found.keys[f"{figure}_error"] == pytest.approx(told, nan_ok=True)
    assert bool(found.flags) == (figure != "load_n" and told != [0.0, 0.0])


def test_a_figure_whose_error_is_over_a_tenth_of_it_is_marked_with_its_greatest_source():
    parts = {"torque_nm": {METHOD: 1e-6, FRICTION_MODEL: 0.3}, "load_n": {METHOD: [1.0, 9.0, 9.9]}}
    (flag,) = judged(Errors(parts), FIGURES, "done").flags
    assert "torque 2 ± 0.3 N m, mostly friction model" in flag
    assert "load" not in flag
    (flag,) = judged(Errors({"torque_nm": {METHOD: 1.4e-3}}), {"torque_nm": 3.7e-10}, "done").flags
    assert "torque 0 ± 0.0014 N m, mostly method" in flag  # well below its error, a value has no digits
    assert "torque 0 ± 1.4 N mm, mostly method" in sentence_for_people(flag)
    # An error of a list counts against its greatest value; nothing is within a tenth of zero but zero.
    assert exceeds(0.0, 1e-12)
    assert not exceeds(0.0, 0.0)
    assert exceeds(FIGURES["load_n"], [0.0, 0.0, 11.0])
    assert exceeds(1.0, math.nan)


def test_a_sum_over_time_is_told_by_what_it_sums_and_what_is_far_below_what_cancels_by_none():
    parts = {"torque_nm": {METHOD: 0.3}, "work_j": {LAW: 3.0}, "moment_nm": {METHOD: [1e-3, 2e-3]}}
    figures = {"torque_nm": 1e-9, "work_j": 1e-7, "moment_nm": [1e-4, 0.0]}
    errors = Errors(parts, mends={LAW: "a law"}, told_by={"work_j": "torque_nm"}, spared={"moment_nm": 2e-3})
    found = judged(errors, figures, "done")
    assert found.flags == ("the error is over 10 % of the figure: torque 0.00 ± 0.3 N m, mostly method",)
    assert found.keys["moment_nm_error"] == [1e-3, 2e-3]
    assert found.keys["work_j_error"] == 3.0
    # alone, and beyond what cancels, they are named
    (flag,) = judged(errors, figures | {"torque_nm": 9.0, "moment_nm": [1e-4, 0.0]}, "done").flags
    assert flag.endswith("figure: work 0.0 ± 3 J, mostly law; to mend it: a law")
    for error in ([1e-3, 2.1e-3], math.nan):
        more = Errors(parts | {"moment_nm": {METHOD: error}}, told_by=errors.told_by, spared=errors.spared)
        assert "moment 0" in judged(more, figures, "done").flags[0]


@pytest.mark.parametrize(("before", "told"), [({"load_error": 2e-4}, 2e-4), ({"load_error": "x"}, None), ({}, None)])
def test_what_was_predicted_is_told_where_it_is_a_number(before, told):
    wanted = judged(Errors(promises=(promise(1.0),)), {}, "done", predicted=before).keys["wanted_errors"]
    assert wanted["loads"].get("predicted") == told


def test_the_first_word_of_every_status_is_in_the_table():
    for found in (judged(Errors(), {}, "done"), judged(Errors(promises=(promise(1.0),)), {}, "done")):
        assert found.status.partition(":")[0] in STATUSES


def test_a_table_shows_errors_behind_figures_and_marks_large_ones(capsys):
    parts = {"torque_nm": {FRICTION_MODEL: 0.5}, "load_n": {METHOD: [1.0, 2.0, 3.0]}, "row_m": {METHOD: [0.1] * 5}}
    figures = FIGURES | {"row_m": [1.0, 2.0, 3.0, 4.0, 5.0]}
    errors = Errors(parts, (promise(2e-4),), {METHOD: "half of it is not known"})
    show_result(figures | judged(errors, figures, "done").keys)
    text = capsys.readouterr().out
    assert "2000 ± 500 N mm (doubtful)" in text
    assert "100.0, 50.0, 0.0 ± 3 N" in text
    assert any(line.split()[:2] == ["±", "0.1"] for line in text.splitlines())
    assert "0.0002 over the greatest load, wanted 0.001; ball 3" in text
    assert "method: half of it is not known" in text
    assert "by source" not in text


def test_an_error_without_bound_is_shown_as_such(capsys):
    parts = {"torque_nm": {METHOD: math.inf}, "load_n": {METHOD: [math.inf, 1.0, 1.0]}}
    show_result(plain_json(FIGURES | judged(Errors(parts, (promise(math.inf),)), FIGURES, "done").keys))
    lines = capsys.readouterr().out.splitlines()
    assert sum(re.search(r"± inf N( mm)? \(doubtful\)", line) is not None for line in lines) == 2


def test_a_companion_that_takes_much_says_what_took_it():
    long, short = Dearest(300, "ball 6, 0 s to 0.01 s", 8, 60), Dearest(100, "ball 1, 0 s to 0.01 s", 8, 60)
    assert companion_cost({"ball_steps": 8000, "companion_ball_steps": 800}, long) == {"companion_share": 0.1}
    told = companion_cost({"ball_steps": 8000, "companion_ball_steps": 4000}, long)["companion_reason"]
    assert told.startswith("the companion took 50 %")
    assert "ball 6, 0 s to 0.01 s, took 300 of its 4000" in told
    assert (
        "is short, 50 steps of a ball"
        in companion_cost({"ball_steps": 400, "companion_ball_steps": 200}, short)["companion_reason"]
    )
    assert companion_cost({"steps": 10}, None) == {}
