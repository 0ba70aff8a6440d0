"""Intervals hold the truth as often as they say, or are marked; by sampler, statistic and number of samples."""

import csv
import math
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from quantiles import from_table

from bearing_twin.charts import coverage
from bearing_twin.charts.coverage import CLOSER, LEAST, STATISTICS, draw, measure, reading, too_narrow
from bearing_twin.charts.table import write_table
from bearing_twin.uq.sampling import SAMPLERS, UnitPoints
from bearing_twin.uq.statistics import estimate

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")

SEEDS = 100, pytest.param(300, marks=pytest.mark.environment)
DECIDING = 5  # times as many other seeds decide here as where few fall short


def drawn_once(*given):
    """Points whose one chunk is drawn once."""
    points = UnitPoints(*given)
    chunk = cache(points.chunk)
    return SimpleNamespace(samples=points.samples, replicates=points.replicates, chunk=chunk)


def scatter(points):
    """Twice that of a share of 0.95 among the least seeds of a cell."""
    return 2.0 * math.sqrt(0.95 * 0.05 / min(p.seeds for p in points))


@pytest.fixture(scope="module", params=SEEDS)
def points(request):
    with pytest.MonkeyPatch.context() as patch:
        # SciPy copies the generator of each sequence for a `reset` that nobody asks for: a quarter of the time.
        patch.setattr("scipy.stats._qmc.copy", SimpleNamespace(deepcopy=lambda one: one))
        # Every problem takes the same points.
        patch.setattr(coverage, "UnitPoints", cache(drawn_once))
        gamma = coverage.PROBLEMS["gamma"]
        patch.setitem(coverage.PROBLEMS, "gamma", gamma._replace(each=SimpleNamespace(ppf=from_table(gamma.each.ppf))))
        patch.setattr(coverage, "CLOSER", DECIDING)
        return [
            *measure(("gamma",), tuple(SAMPLERS), (128, 1024), request.param),
            *measure(("lognormal",), ("random", "sobol"), (1024,), request.param),
        ]


def test_intervals_hold_the_truth_or_are_marked(points):
    """Before replicates were bent the 0.99 quantile at 1024 points of sobol was held in 67 %, the deviation in 89 %."""
    assert {p.statistic for p in points} == set(map(str, STATISTICS))
    least = LEAST - scatter(points)
    for p in points:
        assert p.either >= least, p
        if p.statistic in ("mean", "std") and p.problem == "gamma":
            assert least <= p.covered <= 0.99, p
        if p.statistic[0].isdigit():
            assert p.covered >= LEAST, p
    far = [p for p in points if (p.sampler, p.statistic, p.samples) == ("sobol", "0.99", 1024)]
    assert {p.basis for p in far} == {"order statistics"}


def test_a_kind_of_study_whose_intervals_hold_too_little_says_so(points):
    """By 30 effective points for a skewness, 128 samples of a gamma variable were marked in 86 %, and held it in 80."""
    assert [p for p in points if p.covered < LEAST - scatter(points)]
    for p in too_narrow(points):
        assert p.covered >= LEAST - 0.01, p


def test_a_cell_that_falls_short_by_few_seeds_is_decided_by_more():
    """By 20 seeds the median of 128 values is held in less than 93 %; a skewness, too, but that is marked."""
    by = {p.statistic: p for p in measure(("gamma",), ("random",), (128,), 20)}
    assert {name for name, p in by.items() if p.seeds == 20 * CLOSER} == {"0.5"}
    assert 0.93 < by["0.5"].covered < 1.0
    assert (by["skewness"].seeds, by["skewness"].unsafe) == (20, 1.0)
    assert by["skewness"].covered < LEAST


def test_marks_are_set_where_few_points_decide_and_only_there(points):
    by = {(p.problem, p.sampler, p.statistic, p.samples): p for p in points}
    assert by["lognormal", "sobol", "skewness", 1024].unsafe > 0.95
    assert by["lognormal", "sobol", "skewness", 1024].covered < 0.9
    assert by["gamma", "random", "mean", 1024].unsafe == by["gamma", "sobol", "mean", 1024].unsafe == 0.0
    assert not any(p.unsafe for p in points if p.statistic[0].isdigit())
    normal = np.random.default_rng(1).standard_normal(4000)
    assert all(estimate(normal, one).safe for one in ("mean", "std", "skewness"))


def test_picture_table_and_sentences(points, tmp_path):
    draw(points, tmp_path / "coverage.png")
    assert (tmp_path / "coverage.png").read_bytes().startswith(b"\x89PNG")
    write_table(points, tmp_path / "coverage.csv")
    with (tmp_path / "coverage.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["covered"]) for row in rows] == pytest.approx([p.covered for p in points], rel=1e-5)
    sentences = list(reading(points))
    assert len(sentences) == 4
    low, few = [p for p in points if p.covered < LEAST], too_narrow(points)
    assert sentences[3].startswith(f"{len(low)} of {len(points)} cells hold")
    assert f"; {len(low) - len(few)} of them" in sentences[3]
    assert "skewness of lognormal, 1024 samples" in sentences[2]
