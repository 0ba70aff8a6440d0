"""The chart of rings and cages: what each model errs by, its table, picture and reading."""

import csv

import pytest

from bearing_twin.charts import cages
from bearing_twin.charts.cages import FULLEST, LOADS, MODELS, SPEEDS, draw, measure, reading, worst, write_table

HELD, FREE_NONE = ("prescribed", "even"), ("free", "none")


@pytest.fixture(scope="module")
def points():
    """Four models at one load and speed, over a shorter time and against a less tight truth."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (("SPAN", 0.12), ("LATE", 0.06), ("FINEST", 1e-4)):
            patch.setattr(cages, name, value)
        return measure(loads=(1000.0,), speeds=(157.0796,), models=(MODELS[0], HELD, FREE_NONE, ("free", "even")))


def test_a_cage_is_worth_what_it_costs(points):
    assert worst(points, MODELS[0], "load_error") < 3e-3
    assert worst(points, ("free", "even"), "ring_error") < 3e-3
    assert worst(points, HELD, "ring_error") < 3e-3
    assert worst(points, FREE_NONE, "orbit_error") > 10.0 * worst(points, ("free", "even"), "orbit_error")
    assert all(p.cost > 0.0 for p in points)


def test_table_picture_and_reading(points, tmp_path):
    write_table(points, tmp_path / "cages.csv")
    with (tmp_path / "cages.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["load_error"]) for row in rows] == [p.load_error for p in points]
    draw(points, tmp_path / "cages.png")
    assert (tmp_path / "cages.png").read_bytes().startswith(b"\x89PNG")
    said = reading(points)
    assert len(said) == 4
    assert said[2].startswith("free, no cage: off by at most: greatest ball load")


def test_the_shipped_table_holds_every_model_and_its_fullest_is_the_best():
    with (cages.Path(__file__).parent.parent / "docs" / "cages.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(MODELS) * len(LOADS) * len(SPEEDS)
    most = {model: max(max(float(row[key]) for key in cages.ERRORS) for row in rows
                       if (row["dimension"], row["cage"]) == model) for model in MODELS}  # fmt: skip
    assert min(most, key=most.get) == FULLEST
    assert most[FULLEST] < 2e-3
