"""The chart of rings and cages: what each model errs by, its table, picture and reading."""

import pytest

from bearing_twin.charts import cages
from bearing_twin.charts.cages import AGAIN, FULLEST, MODELS, PROBLEMS, SPEEDS, CageRow, draw, judge, reading, worst
from bearing_twin.charts.table import read_table, write_table

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")

HELD, FREE_NONE = ("prescribed", "even"), ("free", "none")


@pytest.fixture(scope="module")
def rows():
    """Five models at one load and speed, over a shorter time and against a less tight truth."""
    models = (MODELS[0], HELD, FREE_NONE, ("free", "even"))
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (("SPAN", 0.12), ("LATE", 0.06), ("FINEST", 1e-4), ("MODELS", models)):
            patch.setattr(cages, name, value)
        return judge("1000 N", "all", 157.0796, 0.0)


def test_a_cage_is_worth_what_it_costs(rows):
    assert worst(rows, MODELS[0], "load_error") < 3e-3
    assert worst(rows, ("free", "even"), "ring_error") < 3e-3
    assert worst(rows, HELD, "ring_error") < 3e-3
    assert worst(rows, FREE_NONE, "orbit_error") > 10.0 * worst(rows, ("free", "even"), "orbit_error")
    assert all(row.seconds > 0.0 for row in rows)


def test_another_stepper_comes_nearer_to_the_truth_than_another_model(rows):
    (again,) = (row for row in rows if row.method == AGAIN)
    assert max(getattr(again, key) for key in cages.ERRORS) < 1e-3
    assert again.orbit_error < 0.1 * worst(rows, FREE_NONE, "orbit_error")


def test_table_picture_and_reading(rows, tmp_path):
    write_table(rows, tmp_path / "cages.csv")
    again = read_table(tmp_path / "cages.csv", CageRow)
    assert [row.load_error for row in again] == pytest.approx([row.load_error for row in rows], rel=1e-5)
    draw(rows, tmp_path / "cages.png")
    assert (tmp_path / "cages.png").read_bytes().startswith(b"\x89PNG")
    said = reading(again)
    assert len(said) == 5
    assert said[2].startswith("free, no cage: off by at most: greatest ball load")
    assert said[4].startswith("The truth is found again by rodas3")
    assert reading([CageRow("400 N", cages.ALL, 94.2478, status="stopped")]) == []


def test_the_shipped_table_holds_every_model_and_its_fullest_is_the_best():
    rows = read_table(cages.Path(__file__).parent.parent / "docs" / "cages.csv", CageRow)
    assert len(rows) == (len(MODELS) + 1) * len(PROBLEMS) * len(SPEEDS)
    most = {model: max(worst(rows, model, key) for key in cages.ERRORS) for model in MODELS}
    assert min(most, key=most.get) == FULLEST
    assert most[FULLEST] < 2e-3
