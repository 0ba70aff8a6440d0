"""The chart of soft discs: what it measures, on few meshes, and that its files hold it."""

import pytest

from bearing_twin.charts import soft_discs
from bearing_twin.charts.contest import Asked, Kept
from bearing_twin.charts.soft_discs import ANOTHER, CONTESTS, INTEGRATION, PROBLEMS
from bearing_twin.charts.table import read_table

pytestmark = [pytest.mark.environment, pytest.mark.usefixtures("quick_pictures", "quick_timings")]


def test_errors_fall_and_files_hold_them(tmp_path, monkeypatch):
    few = {"LADDER": (6, 12), "FURTHER": (), "SHARES": (1.0, 0.5), "SECOND": (18, 2), "ENOUGH": 0.0}
    for name, value in (few | {"REFERENCE": ("mesh.divisions=18", "mesh.order=3")}).items():
        monkeypatch.setattr(soft_discs, name, value)
    chart = CONTESTS["discs"]
    made = chart.make(tmp_path, "discs", Asked(tuple(PROBLEMS), lambda share: None, 0, 0.0, Kept(None)))
    rows = made.rows
    assert {row.problem for row in rows} == set(PROBLEMS)
    for problem in ("mesh", "formulation", "locking"):
        for line in {row.method for row in rows if row.problem == problem} - {ANOTHER.format("mesh")}:
            errors = [row.error for row in rows if (row.problem, row.method) == (problem, line)]
            assert errors[-1] < errors[0], line
    steps = [row for row in rows if row.problem == "step"]
    # Long steps all err by what the mesh makes ring, of which they get the phase wrong.
    assert max(row.error for row in steps) < 3e-3
    again = [row for row in rows if row.method.startswith(ANOTHER.format(""))]
    assert len(again) == len(PROBLEMS)
    assert max(row.error for row in again) < 0.02
    locked, kept = (
        next(row for row in reversed(rows) if row.method == INTEGRATION.format(word)) for word in ("full", "selective")
    )
    assert locked.error > 5.0 * kept.error
    assert "full locks" in made.reading[-2]
    assert "mesh to" in made.reading[-1]
    assert (tmp_path / "discs.png").stat().st_size > 10_000
    assert len(read_table(tmp_path / "discs.csv", soft_discs.DiscRow)) == len(rows)
    assert chart.read(tmp_path, "discs") == made.reading
