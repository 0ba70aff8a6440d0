"""The chart of steppers: order of accuracy and cost, failures kept, picture and table written."""

import csv

import numpy as np
import pytest

from bearing_twin.charts import work_precision
from bearing_twin.charts.work_precision import Method, cheapest, draw, measure, reading, write_table
from bearing_twin.command.cli import main


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
    assert tight.torque_error < loose.torque_error < 1e-2
    assert "too long" in refused.failure
    assert np.isnan(refused.seconds_per_second)
    assert explicit.torque_error < 1e-3
    assert explicit.seconds_per_second > 0.0


def test_the_cheapest_point_meets_both_errors(points):
    best = cheapest(points, "sliding", "rk4")
    assert best.setting == 5e-7
    assert cheapest(points, "sliding", "rodas4", wanted=1e-15) is None
    (sentence,) = reading(points)
    assert "rk4" in sentence


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
