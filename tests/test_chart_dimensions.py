"""The chart of dimensions: equilibria follow moving balls as closely as fidelity believes; table, picture, reading."""

import csv

import pytest

from bearing_twin.charts import dimensions
from bearing_twin.charts.dimensions import EARLY, LOADS, draw, measure, reading, worst, write_table
from bearing_twin.kinds.bearing.adequacy import still_error

SHARES = (0.03, 0.3)
KEYS = ("load_error", "angle_error", "early_load_error", "early_angle_error")


@pytest.fixture(scope="module")
def points():
    """Two loads, one of them across, at two speeds, over a shorter time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dimensions, "SETTLED", 0.3)
        patch.setattr(dimensions, "REPEATS", 1)
        names = ("100 N thrust", "100 N thrust, 60 N across")
        return measure(loads={name: LOADS[name] for name in names}, shares=SHARES)


def test_equilibria_are_as_close_as_fidelity_believes(points):
    still = [p for p in points if p.dimension == "quasi_static"]
    assert len(still) == 4
    for p in still:
        assert 0.0 < max(p.load_error, p.early_load_error) <= still_error(p.centrifugal_share), p
    for key in KEYS:  # worse when faster, and worst where the spin axes have not settled
        assert worst(points, "quasi_static", key, 0.03) < 0.3 * worst(points, "quasi_static", key)
    assert worst(points, "quasi_static", "early_load_error") > worst(points, "quasi_static", "load_error")
    thrust = [p for p in points if p.load == "100 N thrust"]
    assert max(worst(thrust, "prescribed", key) for key in KEYS) < 1e-6
    speeds = {p.centrifugal_share: p.speed for p in thrust}
    assert speeds == pytest.approx({0.03: 1058.43, 0.3: 3134.94}, rel=1e-4)


def test_the_shipped_table_is_within_what_fidelity_believes():
    with (dimensions.Path(__file__).parent.parent / "docs" / "dimensions.csv").open(encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["dimension"] == "quasi_static"]
    assert {row["load"] for row in rows} == set(LOADS)
    for row in rows:
        bound = still_error(float(row["centrifugal_share"]))
        assert max(float(row["load_error"]), float(row["early_load_error"])) <= bound, row


def test_table_picture_and_reading(points, tmp_path):
    write_table(points, tmp_path / "dimensions.csv")
    with (tmp_path / "dimensions.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["load_error"]) for row in rows] == [p.load_error for p in points]
    draw(points, tmp_path / "dimensions.png")
    assert (tmp_path / "dimensions.png").read_bytes().startswith(b"\x89PNG")
    said = " ".join(reading(points))
    assert f"{1e3 * EARLY:g} ms after the start" in said
    assert f"{worst(points, 'quasi_static', 'load_error'):.1g} up to 0.3" in said
    assert "where no cage spaces the balls" in said
