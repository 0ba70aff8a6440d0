"""The chart of samplers: order of accuracy by realisations, never by time; picture and table written."""

import numpy as np
import pytest

from bearing_twin.charts import samplers
from bearing_twin.charts.contest import Asked, Kept
from bearing_twin.charts.samplers import (
    CHAOS,
    CONTESTS,
    EXACT,
    PROBLEMS,
    SamplerRow,
    draw,
    needed,
    of_problem,
    reading,
    slope,
)
from bearing_twin.charts.table import DONE, read_table, write_table
from bearing_twin.uq.sampling import SAMPLERS

pytestmark = pytest.mark.usefixtures("quick_pictures", "quick_timings")

LADDER = (32, 128, 512, 2048, 8192, 32768, 131072)


@pytest.fixture(scope="module")
def points():
    few = {"MOST_EVEN": 2**13, "LADDER": LADDER, "SEEDS": 4, "MANY": 4}
    with pytest.MonkeyPatch.context() as patch:
        for name, value in few.items():
            patch.setattr(samplers, name, value)
        return CONTESTS["samplers"].measure(Asked(tuple(PROBLEMS), lambda share: None, 0, 0.0, Kept(None)))


@pytest.mark.parametrize("problem", PROBLEMS)
def test_scrambled_sobol_needs_a_twentieth_of_the_realisations(points, problem):
    mine = of_problem(points, problem)
    even = needed(mine, "sobol", 1e-4)
    assert 20 * even.setting <= LADDER[-1]
    assert needed(mine, "random", 1e-4) is None  # not with all of the ladder


@pytest.mark.parametrize("problem", PROBLEMS)
def test_slopes(points, problem):
    mine = of_problem(points, problem)
    for statistic in ("mean", "std"):
        assert slope(mine, "random", statistic) == pytest.approx(-0.5, abs=0.15)
        assert slope(mine, "sobol", statistic) < -0.8
    hypercube = slope(mine, "latin_hypercube", "std")
    assert hypercube < -0.8 if problem == "one" else hypercube > -0.7


def test_quadrature_converges_exponentially(points):
    chaos = {p.setting: p for p in of_problem(points, "one") if p.method == CHAOS}
    assert chaos[4].mean_error < 1e-8
    assert chaos[8].std_error < 1e-12
    assert chaos[2].std_error > chaos[3].std_error > chaos[4].std_error
    for statistic in ("mean_error", "std_error"):
        found = [getattr(p, statistic) for p in of_problem(points, "four") if p.method == CHAOS]
        assert len(found) == 7
        assert np.all(np.diff(np.log10(found)) < -1.0)  # a digit a degree, towards the product of one-input moments
    (exact,) = (p for p in points if p.method == EXACT)
    assert max(exact.mean_error, exact.std_error) < 1e-9


def test_every_sampler_of_the_table_is_on_the_chart(points):
    for problem in PROBLEMS:
        mine = of_problem(points, problem)
        assert {p.method for p in mine} == {*SAMPLERS, CHAOS, *([EXACT] if problem == "one" else [])}
        for name in SAMPLERS:
            reached = LADDER if name == "random" else LADDER[:5]
            assert tuple(p.setting for p in mine if p.method == name) == reached
    assert all(p.seconds > 0.0 for p in points)
    assert all(p.mean_low <= p.mean_error <= p.mean_high for p in points)


def test_a_size_is_enough_only_if_all_larger_ones_are():
    errors = ((32, 1e-5), (128, 1e-3), (512, 1e-5), (2048, 1e-6))
    points = [
        SamplerRow("one", "random", size, error, seconds=1.0, evaluations=size, status=DONE) for size, error in errors
    ]
    assert needed(points, "random", 1e-4).setting == 512
    assert needed(points, "random", 1e-7) is None


def test_reading_picture_and_table(points, tmp_path):
    sentences = reading(points)
    assert "random more than 131072" in sentences[0]
    assert "more than" in sentences[1]
    assert sentences[-1].startswith("References that other methods find: one to")
    draw(points, tmp_path / "samplers.png")
    write_table(points, tmp_path / "samplers.csv")
    assert (tmp_path / "samplers.png").read_bytes().startswith(b"\x89PNG")
    rows = read_table(tmp_path / "samplers.csv", SamplerRow)
    assert [row.setting for row in rows] == [p.setting for p in points]
    assert rows[0].mean_error == pytest.approx(points[0].mean_error, rel=1e-5)
    lost = SamplerRow("one", "sobol", 2048.0, seconds=20.0, status="stopped")
    draw([*points, lost], tmp_path / "samplers.png")
    assert reading([*points, lost])[0] != sentences[0]  # what was stopped holds nothing
