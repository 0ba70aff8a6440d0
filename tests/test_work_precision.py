"""The chart of steppers: order of accuracy and cost, failures kept, picture and table written."""

import csv
import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from doc_tables import points_of_steppers

from bearing_twin.charts import work_precision
from bearing_twin.charts.work_precision import (
    FINEST,
    PROBLEMS,
    Method,
    StepperPoint,
    cheapest,
    draw,
    errors,
    measure,
    reading,
    shares_of_steps,
    write_table,
)
from bearing_twin.command.cli import main
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds.bearing.error_scales import STEP_SHARE
from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene


@pytest.fixture(scope="module")
def points():
    """The sliding problem, cut short, by two methods; one step of rk4 is refused."""
    patch = pytest.MonkeyPatch()
    short = work_precision.PROBLEMS["sliding"]._replace(count=5)
    patch.setitem(work_precision.PROBLEMS, "sliding", short)
    patch.setattr(work_precision, "LADDERS", (Method("rodas4", (1e-1, 1e-5)), Method("rk4", (4e-6, 5e-7))))
    yield list(measure(["sliding"]))
    patch.undo()


def test_tighter_is_more_accurate_and_failures_are_kept(points):
    loose, tight, refused, explicit = points
    assert tight.load_error < loose.load_error
    assert tight.friction_error < loose.friction_error < 1e-2
    assert "unstable" in refused.failure
    assert np.isnan(refused.seconds_per_second)
    assert explicit.friction_error < 1e-3
    assert explicit.seconds_per_second > 0.0


def test_the_cheapest_point_meets_both_errors(points):
    best = cheapest(points, "sliding", "rk4")
    assert best.setting == 5e-7
    assert cheapest(points, "sliding", "rodas4", wanted=1e-15) is None
    sentence, again, shares = reading(points)
    assert f"to {max(points[3].load_error, points[3].friction_error):.1g} (rk4)" in again
    assert "rk4" in sentence
    assert "may err by 0.2 of the tolerance" in shares


def test_the_share_of_the_tolerance_for_a_step_is_what_lift_off_just_allows():
    found = shares_of_steps(points_of_steppers(), "rodas4")
    lasting = {name: share for name, (_, share) in found.items() if name != "sudden"}
    assert min(lasting, key=lasting.get) == "lift-off"
    assert 0.5 * lasting["lift-off"] < STEP_SHARE <= lasting["lift-off"]
    assert found["sudden"][1] < STEP_SHARE
    point = StepperPoint("lift-off", "rodas4", 1e-2, 1e-3, 5e-3, 1.0)
    assert shares_of_steps([point], "rodas4") == {"lift-off": (0.5, 0.4)}
    assert shares_of_steps([point], "rk4") == {}


def _ladder(monkeypatch, method, answer):
    """The settings that one method is run at, by what `answer` (load error, friction error, cost) says of each."""
    monkeypatch.setattr(work_precision, "LADDERS", (method,))
    monkeypatch.setattr(work_precision, "_run", lambda motion, problem: None)
    monkeypatch.setattr(
        work_precision,
        "_measure",
        lambda name, problem, stepper, setting, exact: StepperPoint(name, stepper, setting, *answer(setting)),
    )
    return [point.setting for point in measure(["sliding"])]


def test_a_ladder_goes_on_until_a_setting_is_good_or_too_slow(monkeypatch):
    explicit, fixed = Method("dopri5", (1e-1, 1e-3)), Method("imex", (4e-6, 2e-6))
    assert _ladder(monkeypatch, explicit, lambda x: (0.0, 10.0 * x, 1.0)) == pytest.approx([1e-1, 1e-3, 1e-4])
    assert _ladder(monkeypatch, explicit, lambda x: (x, x, 1.0)) == [1e-1, 1e-3]
    assert _ladder(monkeypatch, fixed, lambda x: (300.0 * x, 0.0, 1.0)) == [4e-6, 2e-6]
    assert _ladder(monkeypatch, fixed, lambda x: (1e3 * x, 0.0, 1.0)) == [4e-6, 2e-6, 1e-6]
    assert _ladder(monkeypatch, fixed, lambda x: (1.0, 1.0, 1.5e-3 / x)) == [4e-6, 2e-6, 1e-6]
    refused = _ladder(monkeypatch, fixed, lambda x: (np.inf, np.inf, np.nan, "refused"))
    assert refused == [4e-6 / 2**i for i in range(12)]


def _but(outputs, **changes):
    return SimpleNamespace(**{**vars(outputs), **changes})


def test_friction_errs_against_what_it_could_be_at_that_contact():
    """One number off at one contact: over mu N there, over mu (N + N) R of the ball; loads over the greatest."""
    problem = PROBLEMS["sliding"]._replace(count=2)
    motion = work_precision._motion(problem, "rodas4", 1e-3)
    names = ("normal_load", "friction_force", "raceway_torque")
    out = work_precision._run(motion, problem)
    exact = SimpleNamespace(**{name: np.array(getattr(out, name)) for name in names})
    loads, limit = exact.normal_load, motion.parameters.contact.friction_coefficient
    spoiled = _but(exact, friction_force=exact.friction_force.copy())
    spoiled.friction_force[1, 3, 0] += [0.0, 3e-3, 4e-3]
    assert errors(motion, spoiled, exact) == pytest.approx((0.0, 5e-3 / (limit * loads[1, 3, 0])))
    spoiled = _but(exact, raceway_torque=exact.raceway_torque.copy(), normal_load=1.01 * loads)
    spoiled.raceway_torque[0, 2] += [0.0, 0.0, 1e-6]
    wanted = 1e-6 / (limit * motion.bearing.ball_radius * loads[0, 2].sum())
    assert errors(motion, spoiled, exact) == pytest.approx((0.01, wanted))
    assert errors(motion, _but(exact, normal_load=np.nan * loads), exact) == (np.inf, np.inf)


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_tolerance_means_the_error_of_load_and_friction(name):
    """Of the run as it is chosen and watched; where all has settled, errors die out and are far smaller."""
    problem = PROBLEMS[name]
    exact = work_precision._run(work_precision._motion(problem, "rodas4", FINEST), problem)
    for tolerance in (1e-1, 1e-2, 1e-3, 1e-4):
        scene = load_scene(problem.scene, (*problem.overrides, f"wanted.tolerance={tolerance}"))
        motion = bearing_motion(scene.parameters, choose(scene))
        assert max(errors(motion, work_precision._run(motion, problem), exact)) < tolerance


def test_picture_and_table(points, tmp_path):
    draw(points, tmp_path / "steppers.png")
    write_table(points, tmp_path / "steppers.csv")
    assert (tmp_path / "steppers.png").read_bytes()[:4] == b"\x89PNG"
    rows = list(csv.DictReader((tmp_path / "steppers.csv").open()))
    assert [row["stepper"] for row in rows] == ["rodas4", "rodas4", "rk4", "rk4"]
    assert rows[2]["failure"]


def test_bad_words_are_refused(tmp_path, capsys):
    assert main(["chart", "steppers", "--out", str(tmp_path / "nowhere")]) == 2
    assert main(["chart", "steppers", "--problem", "settle"]) == 2
    assert "settled" in capsys.readouterr().err


def test_problems_that_are_finished_are_not_measured_again(points, tmp_path, monkeypatch):
    """The second problem is interrupted the first time round."""
    measured = []

    def measure(names, say):
        measured.extend(names)
        if len(measured) == 2:
            raise BearingTwinError("interrupted")
        return [dataclasses.replace(point, problem=names[0]) for point in points]

    monkeypatch.setattr(work_precision, "measure", measure)
    words = ["chart", "steppers", "--problem", "settled", "--problem", "fast", "--out", str(tmp_path)]
    assert main(words) == 2
    assert main(words) == 0
    assert measured == ["settled", "fast", "fast"]
    rows = list(csv.DictReader((tmp_path / "steppers.csv").open()))
    assert [row["problem"] for row in rows] == ["settled"] * len(points) + ["fast"] * len(points)
    assert not list(tmp_path.glob("*.unfinished"))
