"""The chart of the laws: order of accuracy and cost, failures kept, files written."""

import csv

import numpy as np
import pytest

from bearing_twin.charts.laws import CONTESTANTS, draw, measure, reading, worst, write_table


@pytest.fixture(scope="module")
def points():
    return measure(np.array([0.002, 0.01, 0.08, 0.1, 0.13, 0.18, 0.5, 0.99, 1.0]))


def test_order_of_accuracy_and_cost(points):
    near = {law: worst(points, law, 0.08, 0.18) for law in CONTESTANTS}
    assert near["hertz_exact"] == 0.0
    assert near["hertz"] < 1e-10 < near["volumetric"] < 0.005 < near["constant"]
    assert near["hertz_differential"] < near["hertz_unprojected"]
    assert all(point.nanoseconds > 0.0 for point in points)


def test_failures_stay_in_table_picture_and_reading(points, tmp_path):
    failed = {(point.law, point.axis_ratio) for point in points if point.failed}
    assert ("volumetric", 0.002) in failed
    assert ("hertz_differential", 1.0) in failed  # the circle is crossed: no state to carry
    assert not any(law in ("hertz", "hertz_exact") for law, _ in failed)
    write_table(points, tmp_path / "laws.csv")
    rows = list(csv.DictReader((tmp_path / "laws.csv").open(encoding="utf-8")))
    assert {(row["law"], float(row["axis_ratio"])) for row in rows if row["failed"] == "True"} == failed
    sentences = reading(points)
    assert len(sentences) == len(CONTESTANTS)
    assert "fails at" in sentences[CONTESTANTS.index("volumetric")]
    draw(points, tmp_path / "laws.png")
    assert (tmp_path / "laws.png").read_bytes().startswith(b"\x89PNG")
