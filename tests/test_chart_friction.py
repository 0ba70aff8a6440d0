"""The chart of friction over a spot, and the exact solution it is measured against."""

import math

import numpy as np
import pytest
from scipy.special import ellipe

from bearing_twin.charts import friction
from bearing_twin.charts.friction import CONTESTANTS, POLES, PROBLEMS, SCIPY, by_scipy, draw, judge, reading, worst
from bearing_twin.charts.table import DONE, read_table, write_table
from bearing_twin.contact.friction import FRICTIONS, spot_friction_pade1, spot_friction_pade2
from bearing_twin.contact.spot_rules import RULES, over_spot, points
from bearing_twin.reference.spot import spot_friction_exact

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")

SHAPES = [name for name, ratio in PROBLEMS.items() if ratio in (1.0, 0.1)]
COARSE, FINE, FIRST, SECOND = "spot", "spot_fine", "pade1", "pade2"


@pytest.fixture(scope="module")
def measured():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(friction, "SPINS", np.geomspace(0.01, 100.0, 9))
        patch.setattr(friction, "POLES", (np.linspace(0.2, 1.0, 7), POLES[1][::4]))
        return [row for name in SHAPES for form in (*CONTESTANTS, SCIPY) for row in judge(name, form, 0.0, 0.0)]


@pytest.mark.parametrize("ratio", [1.0, 0.3, 0.03])
def test_the_exact_solution_in_its_limits_and_against_a_fine_quadrature(ratio):
    """Pure spin 3/8 a E(m); little spin <x^2>; the pole of the motion inside, near the edge, and outside the spot."""
    spinning = spot_friction_exact(2.0, 1.0, ratio, 0.0, 0.0, -3.0, 0.5)
    assert spinning.torque == pytest.approx(0.375 * ellipe(1.0 - ratio**2), rel=1e-12)
    sliding = spot_friction_exact(1.0, 1.0, ratio, 1.0, 0.0, 1e-3, 1.0)
    assert sliding.force_major == pytest.approx(-1.0, abs=1e-6)
    assert sliding.torque == pytest.approx(-1e-3 / 5.0, rel=1e-4)
    finer = points(120, 480)
    for slip in ((0.02, 0.3), (0.5 * ratio, 0.3), (0.0, 0.98), (0.0, 1.02), (2.0, 1.0)):
        exact = np.array(spot_friction_exact(1.0, 1.0, ratio, *slip, 1.0, 1.0))
        assert exact == pytest.approx(spot_friction_exact(1.0, 1.0, ratio, *slip, 1.0, 1.0, rays=16000), abs=1e-10)
        assert -np.array(over_spot(finer, 1.0, ratio, *slip, 1.0, 0.0)) == pytest.approx(exact, abs=2e-4)


@pytest.mark.parametrize(("form", "order"), [(spot_friction_pade1, 1.0), (spot_friction_pade2, 2.0)])
@pytest.mark.parametrize("ratio", [1.0, 0.3])
def test_the_closed_forms_are_right_in_both_limits_to_their_order(form, order, ratio):
    slip = math.cos(0.4), math.sin(0.4)

    def off(spin, part):
        arguments = 1.0, 1.0, ratio, *slip, spin, 1.0
        found, exact = form(*arguments, 0.0), spot_friction_exact(*arguments)
        return abs(found[part] - exact[part])

    for part, weak in ((0, False), (1, False), (2, True)):
        # Where the other motion vanishes: little spin for the force, little slip for the torque.
        near, nearer = (0.02, 0.01) if not weak else (100.0, 200.0)
        assert math.log2(off(near, part) / off(nearer, part)) > order - 0.1


def test_order_of_accuracy_and_cost(measured):
    for shape in SHAPES:
        for part in (0, 1):
            error = {form: worst(measured, form, shape)[part] for form in CONTESTANTS}
            assert all(error[form] <= FRICTIONS[form].error for form in CONTESTANTS)
            assert error[FINE] < 0.25 * error[COARSE]
            assert min(error[FIRST], error[SECOND]) > 0.15
    assert worst(measured, FIRST, SHAPES[-1])[1] > 0.9
    assert all(row.seconds > 0.0 for row in measured if row.method in CONTESTANTS)
    coarse, medium, fine = (rule.end - rule.first for rule in RULES.values())
    assert 4 * coarse <= medium <= fine // 4  # what they cost, on whatever machine


def test_scipy_finds_the_exact_solution_again(measured):
    again = [row.friction_error for row in measured if row.method == SCIPY]
    assert len(again) == len(SHAPES)
    assert max(again) < 1e-6
    motion = 2.0, 1e-3, 4e-4, 0.3, -0.2, 500.0, 0.1  # the pole inside, signs and sizes of all kinds
    exact = spot_friction_exact(*motion)
    assert by_scipy(*motion, 0.0) == pytest.approx(exact, abs=1e-7 * max(map(abs, exact)))


def test_failures_stay_in_table_picture_and_reading(measured, tmp_path):
    failed = {(row.method, row.problem, row.setting) for row in measured if row.status != DONE}
    failing = {form for form, _, _ in failed}
    assert failing >= {FIRST, SECOND}
    assert not failing & {COARSE, FINE}
    write_table(measured, tmp_path / "friction.csv")
    rows = read_table(tmp_path / "friction.csv", friction.FrictionRow)
    assert len(rows) == len(measured)
    assert sum(row.status != DONE for row in rows) == len(failed)
    sentences = reading(rows)
    assert len(sentences) == len(CONTESTANTS) + 1
    assert failing == {sentence.partition(":")[0] for sentence in sentences if "fails at" in sentence}
    draw(measured, tmp_path / "friction.png")
    assert (tmp_path / "friction.png").read_bytes().startswith(b"\x89PNG")
