"""The chart of steppers: order of accuracy and cost, failures kept, picture and table written."""

from types import SimpleNamespace

import numpy as np
import pytest
from doc_tables import rows_of_steppers

from bearing_twin.charts import work_precision
from bearing_twin.charts.bearing_cells import errors, motion_of, truth
from bearing_twin.charts.contest import Asked, Kept
from bearing_twin.charts.contest_picture import cheapest
from bearing_twin.charts.table import DONE, FAILED, REFUSED, STOPPED, Row, read_table
from bearing_twin.charts.work_precision import (
    CASES,
    CONTESTS,
    WANTED,
    StepperRow,
    by_the_call,
    draw,
    further,
    reading,
    shares_of_steps,
)
from bearing_twin.command.cli import main
from bearing_twin.kinds.bearing.error_scales import STEP_SHARE
from bearing_twin.kinds.bearing.motion import bearing_motion
from bearing_twin.run.fidelity import choose
from bearing_twin.run.scene import load_scene

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")

LADDERS = {"rodas4": (1e-1, 1e-5), "rk4": (4e-6, 5e-7)}


def made(folder):
    """The sliding problem, cut short, by two methods; one step of rk4 is refused."""
    wanted = Asked(("sliding",), lambda share: None, 0, 0.0, Kept(None))
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(work_precision.CASES, "sliding", work_precision.CASES["sliding"]._replace(count=5))
        patch.setattr(work_precision, "LADDERS", LADDERS)
        patch.setattr(work_precision, "CLOSE", np.inf)
        return CONTESTS["steppers"].make(folder, "steppers", wanted)


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    return made(tmp_path_factory.mktemp("steppers")).rows


def test_tighter_is_more_accurate_and_failures_are_kept(rows):
    loose, tight, refused, explicit = rows
    assert tight.load_error < loose.load_error
    assert tight.friction_error < loose.friction_error < 1e-2
    assert refused.status == REFUSED
    assert "unstable" in refused.reason
    assert np.isnan(refused.seconds)
    assert explicit.friction_error < 1e-3
    assert explicit.seconds > 0.0
    assert explicit.evaluations >= 8 * 4 * 500  # balls, stages, steps


def test_the_cheapest_point_meets_both_errors(rows):
    best = cheapest(rows, "sliding", "rk4", WANTED)
    assert best.setting == 5e-7
    assert cheapest(rows, "sliding", "rodas4", 1e-15) is None
    sentence, again, shares = reading(rows)
    assert f"to {rows[3].error:.1g} (rk4)" in again
    assert "rk4" in sentence
    assert "may err by 0.2 of the tolerance" in shares


def test_the_public_call_has_errors_and_cost_of_its_own(rows):
    loose, tight, refused, explicit = by_the_call(rows)
    assert tight.load_error < loose.load_error
    assert tight.friction_error < loose.friction_error < 1e-1
    assert explicit.friction_error < 1e-3
    assert refused.status == REFUSED
    for called, moved in zip((loose, tight, explicit), (rows[0], rows[1], rows[3]), strict=True):
        assert (called.method, called.setting, called.command) == (moved.method, moved.setting, moved.command)
        assert called.seconds > 0.0
        assert called.seconds != moved.seconds
    assert "by the public call: rodas4 " in reading(rows)[0]


def test_what_has_no_public_call_is_not_told_as_one():
    """SciPy's methods are references there; a run that fails by the call alone is a failure there."""
    moved = StepperRow("settled", "radau", 1e-3, 1e-9, 1e-9, 1.0, status=DONE)
    assert by_the_call([moved, moved.but(status=STOPPED, reason="stopped")]) == []
    assert by_the_call([moved.but(method="rk4")]) == []  # of a table made before it was measured
    (lost,) = by_the_call([moved.but(method="rk4", reason="by the public call: x")])
    assert (lost.status, lost.reason) == (FAILED, "by the public call: x")
    assert lost.error == np.inf
    assert moved.error == 1e-9
    assert reading([moved])[0].endswith("radau 1.")


def test_the_share_of_the_tolerance_for_a_step_is_what_lift_off_just_allows():
    found = shares_of_steps(rows_of_steppers(), "rodas4")
    lasting = {name: share for name, (_, share) in found.items() if name != "sudden"}
    assert min(lasting, key=lasting.get) == "lift-off"
    assert 0.5 * lasting["lift-off"] < STEP_SHARE <= lasting["lift-off"]
    assert found["sudden"][1] < STEP_SHARE
    row = Row("lift-off", "rodas4", 1e-2, 1e-3, 5e-3, 1.0, status=DONE)
    assert shares_of_steps([row], "rodas4") == {"lift-off": (0.5, 0.4)}
    assert shares_of_steps([row], "rk4") == {}


def _ladder(stepper, ladder, answer):
    """The settings that one method is run at, by what `answer` (status, error, seconds) says of each."""
    waiting, rows = [("sliding", stepper, setting) for setting in ladder], []
    while waiting:
        for one in waiting:
            status, error, seconds = answer(one[2])
            rows.append(Row(*one, error, error, seconds, status=status))
        waiting = further(rows)
    return [row.setting for row in rows]


def test_a_ladder_goes_on_until_a_setting_is_good_or_too_slow():
    tolerances, steps = (1e-1, 1e-3), (4e-6, 2e-6)
    found = _ladder("dopri5", tolerances, lambda x: (DONE, 5.0 * x, 1.0))
    assert found == pytest.approx([1e-1, 1e-3, 1e-4, 3.2e-4, 1.8e-4])  # and back, see below
    assert _ladder("dopri5", (1e-1,), lambda x: (DONE, 1e-3, 1.0)) == [1e-1]
    assert _ladder("imex", steps, lambda x: (DONE, 300.0 * x, 1.0)) == [4e-6, 2e-6]
    assert _ladder("imex", steps, lambda x: (DONE, 1e3 * x, 1.0)) == [4e-6, 2e-6, 1e-6]
    assert _ladder("imex", steps, lambda x: (DONE, 1.0, 1.5e-3 / x)) == [4e-6, 2e-6, 1e-6]
    assert _ladder("imex", steps, lambda x: (STOPPED, np.nan, 20.0)) == [4e-6, 2e-6]
    refused = _ladder("imex", steps, lambda x: (REFUSED, np.nan, np.nan))
    assert refused == [4e-6 / 2**i for i in range(12)]


def test_the_loosest_good_setting_of_an_adaptive_method_is_looked_for_between_rungs():
    """To a factor of two: between 3e-3 and 1e-2 the cheapest run that is good enough took two thirds of the time."""
    rungs = (1e-1, 1e-2, 1e-3)
    assert _ladder("rodas3", rungs, lambda x: (DONE, x, 1.0)) == [*rungs, 3.2e-3, 1.8e-3]
    assert _ladder("rodas3", rungs, lambda x: (DONE, 0.2 * x, 1.0)) == [*rungs, 3.2e-3, 5.7e-3]
    assert _ladder("rodas3", rungs, lambda x: (FAILED if x > 2e-3 else DONE, x, 1.0)) == [*rungs, 3.2e-3, 1.8e-3]
    assert _ladder("rodas3", rungs, lambda x: (DONE, 1e-3 if x < 0.1 else 1e-2, 1.0)) == [*rungs, 3.2e-2, 5.7e-2]
    assert _ladder("rk4", (4e-6, 1e-6), lambda x: (DONE, 1e3 * x, 1.0)) == [4e-6, 1e-6]


def _but(outputs, **changes):
    return SimpleNamespace(**{**vars(outputs), **changes})


def test_friction_errs_against_what_it_could_be_at_that_contact():
    """One number off at one contact: over mu N there, over mu (N + N) R of the ball; loads over the greatest."""
    case = CASES["sliding"]._replace(count=2)
    motion = motion_of(case, "rodas4")
    names = ("normal_load", "friction_force", "raceway_torque")
    out = motion.advance(case.times, float(case.times[-1]))
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


@pytest.mark.parametrize("name", CASES)
def test_the_tolerance_means_the_error_of_load_and_friction(name):
    """Of the run as it is chosen and watched; where all has settled, errors die out and are far smaller."""
    case = CASES[name]
    for tolerance in (1e-1, 1e-2, 1e-3, 1e-4):
        scene = load_scene(case.scene, (*case.overrides, f"wanted.tolerance={tolerance}"))
        motion = bearing_motion(scene.parameters, choose(scene))
        assert max(errors(motion, motion.advance(case.times, float(case.times[-1])), truth(case))) < tolerance


def test_picture_and_table(tmp_path):
    found = made(tmp_path)
    assert (tmp_path / "steppers.png").read_bytes()[:4] == b"\x89PNG"
    rows = read_table(tmp_path / "steppers.csv", StepperRow)
    assert [row.method for row in rows] == ["rodas4", "rodas4", "rk4", "rk4"]
    assert rows[2].reason
    assert CONTESTS["steppers"].read(tmp_path, "steppers") == found.reading
    draw([*rows, StepperRow("sliding", "radau", 1e-3, seconds=20.0, status=STOPPED)], tmp_path / "stopped.png")


def test_bad_words_are_refused(tmp_path, capsys):
    assert main(["chart", "steppers", "--out", str(tmp_path / "nowhere")]) == 2
    assert main(["chart", "steppers", "--problem", "settle"]) == 2
    assert "settled" in capsys.readouterr().err
