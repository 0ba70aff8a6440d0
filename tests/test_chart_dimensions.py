"""The chart of dimensions: equilibria follow moving balls as closely as is told, and what each model errs by."""

from pathlib import Path

import pytest
from PIL import Image

from bearing_twin.charts import cages, preloaded
from bearing_twin.charts.cages import FULLEST, MODELS, PROBLEMS, SPEEDS
from bearing_twin.charts.dimension_row import DimensionRow, worst
from bearing_twin.charts.dimensions import ALL, CONTESTS, draw, judge, reading, settings
from bearing_twin.charts.preloaded import EARLY, LOADS, SHARES, late
from bearing_twin.charts.table import read_table, write_table
from bearing_twin.kinds.bearing.measured import dimension_costs, method_of
from bearing_twin.kinds.bearing.still import still_error
from bearing_twin.run.scene import load_scene

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")

SOME = (0.03, 0.3)
KEYS = ("load_error", "angle_error", "early_load_error", "early_angle_error")
ACROSS = "100 N thrust, 60 N across"
HELD, FREE_NONE, FREE_EVEN = (method_of(*one) for one in (("prescribed", "even"), ("free", "none"), ("free", "even")))
DOCS = Path(__file__).parent.parent / "docs"


@pytest.fixture(scope="module")
def rows():
    """Two loads on the preloaded bearing, one of them across, at two speeds, over a shorter time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(preloaded, "LATE", 0.15)
        patch.setattr(preloaded, "ENOUGH", 0.0)
        return [row for name in ("100 N thrust", ACROSS) for share in SOME for row in judge(name, ALL, share, 0.0)]


@pytest.fixture(scope="module")
def caged():
    """Four models of the rig at one load and speed, over a shorter time and against a less tight truth."""
    models = (MODELS[0], ("prescribed", "even"), ("free", "none"), ("free", "even"))
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (("SPAN", 0.12), ("LATE", 0.06), ("FINEST", 1e-4), ("MODELS", models)):
            patch.setattr(cages, name, value)
        return judge("rig, 1000 N", ALL, 157.0796, 0.0)


def test_every_problem_has_its_settings():
    found = {name: [one for _, one in settings(name)] for name in CONTESTS["dimensions"].problems}
    of_part = {tuple(LOADS): SHARES, tuple(PROBLEMS): SPEEDS}
    assert found == {name: list(some) for names, some in of_part.items() for name in names}


def test_equilibria_are_as_close_as_fidelity_believes(rows):
    still = [row for row in rows if row.method == "quasi_static"]
    assert len(still) == 4
    for row in still:
        assert 0.0 < row.early_load_error <= still_error(row.setting), row
        assert 0.0 < row.load_error <= still_error(row.setting), row
    for key in KEYS[2:]:  # worse when faster, where the spin axes have not settled
        assert worst(rows, "quasi_static", key, 0.03) < 0.3 * worst(rows, "quasi_static", key)
    thrust = [row for row in rows if row.problem == "100 N thrust"]
    assert max(worst(thrust, "prescribed", key) for key in KEYS) < 1e-6
    speeds = {row.setting: row.speed for row in thrust}
    assert speeds == pytest.approx({0.03: 1058.43, 0.3: 3134.94}, rel=1e-4)


def test_a_late_look_under_thrust_is_when_the_axes_of_spin_have_settled():
    """tau = 5 mu Q d_m/(2 F_c s) is 5.7 s at a tenth."""
    parameters = load_scene("bearing_6203", ()).parameters
    assert late(parameters, "20 N thrust", 0.1) == pytest.approx(10.0 * 5.7, rel=1e-2)
    assert late(parameters, "20 N thrust", 100.0) == late(parameters, ACROSS, 0.01) == 2.0


def test_rk4_finds_the_truth_again(rows):
    again = [row for row in rows if row.method == preloaded.AGAIN]
    assert len(again) == 2
    assert max(max(row.early_load_error, row.early_angle_error) for row in again) < 1e-6


def test_a_cage_is_worth_what_it_costs(caged):
    assert worst(caged, "quasi_static", "load_error") < 3e-3
    assert worst(caged, FREE_EVEN, "ring_error") < 3e-3
    assert worst(caged, HELD, "ring_error") < 3e-3
    assert worst(caged, FREE_NONE, "orbit_error") > 10.0 * worst(caged, FREE_EVEN, "orbit_error")
    assert all(row.seconds > 0.0 for row in caged)


def test_another_stepper_comes_nearer_to_the_truth_than_another_model(caged):
    (again,) = (row for row in caged if row.method == cages.AGAIN)
    assert max(getattr(again, key) for key in cages.ERRORS) < 1e-3
    assert again.orbit_error < 0.1 * worst(caged, FREE_NONE, "orbit_error")


@pytest.fixture(scope="module")
def shipped():
    return read_table(DOCS / "dimensions.csv", DimensionRow)


def test_the_shipped_table_is_within_what_is_believed_and_told(shipped):
    still = [row for row in shipped if row.method == "quasi_static" and row.problem in LOADS]
    assert {row.problem for row in still} == set(LOADS)
    for row in still:
        assert row.early_load_error <= still_error(row.setting), row


def test_the_shipped_table_holds_every_model_and_its_fullest_is_the_best(shipped):
    rows = [row for row in shipped if row.problem in PROBLEMS]
    assert len(rows) == (len(MODELS) + 1) * len(PROBLEMS) * len(SPEEDS)
    most = {model: max(worst(rows, method_of(*model), key) for key in cages.ERRORS) for model in MODELS}
    assert min(most, key=most.get) == FULLEST
    assert most[FULLEST] < 2e-3


def test_the_chooser_reads_costs_of_bearings_with_clearance_where_there_is_a_cage(shipped):
    """By the speed; else by the share alone, whatever the speeds of the rig are."""
    free = load_scene("bearing_6203", ()).parameters
    assert dimension_costs(free, 600.0) == dimension_costs(free, 1.4)
    caged = load_scene("bearing_6203_rig_1000N", ("drive.speed=600", "run.output_rate=1000")).parameters
    costs = dimension_costs(caged, 1.4)
    rows = {row.method: row.seconds for row in shipped if row.problem == "rig, 1000 N" and row.setting > 600.0}
    wanted = {"quasi_static": rows["quasi_static"], "prescribed": rows["prescribed, even cage"]}
    assert costs == pytest.approx(wanted, rel=0.1)  # a cost an output, where that is all there is


def test_the_chooser_reads_costs_at_both_rates_that_were_measured(shipped):
    wanted = {"seconds": 1000, "cost_at_100_hz": 100}
    for column, rate in wanted.items():
        scene = load_scene("bearing_6203", (f"run.output_rate={rate}", "drive.offset=[0,0,1e-5]")).parameters
        rows = [row for row in shipped if row.problem == "500 N thrust" and row.setting == 0.03]
        costs = {row.method: getattr(row, column) for row in rows if row.method in ("quasi_static", "prescribed")}
        assert dimension_costs(scene, 0.03) == pytest.approx(costs, rel=1e-6)


def test_table_picture_and_reading(rows, caged, tmp_path):
    write_table([*rows, *caged], tmp_path / "dimensions.csv")
    again = read_table(tmp_path / "dimensions.csv", DimensionRow)
    assert [row.speed for row in again] == pytest.approx([row.speed for row in (*rows, *caged)], rel=1e-5)
    draw(again, tmp_path / "dimensions.png")
    assert (tmp_path / "dimensions.png").read_bytes().startswith(b"\x89PNG")
    said = reading(again)
    whole = " ".join(said)
    assert f"{1e3 * EARLY:g} ms after the start" in whole
    assert f"{worst(rows, 'quasi_static', 'load_error'):.1g} up to 0.3" in whole
    assert "in an even cage" in whole
    assert "found again by rk4" in whole
    assert said[-3].startswith("Rig, free, no cage: off by at most: greatest ball load")
    assert said[-1].startswith("The truth of the rig is found again by rodas3")
    alone = [DimensionRow("rig, 400 N", ALL, 94.2478, status="stopped")]
    assert reading(alone) == []
    draw(alone, tmp_path / "alone.png")


def test_problems_of_one_kind_of_bearing_are_drawn_by_themselves(shipped, tmp_path):
    draw([row for row in shipped if row.problem == ACROSS], tmp_path / "one.png")
    with Image.open(tmp_path / "one.png") as one:
        assert one.height < 0.6 * one.width
