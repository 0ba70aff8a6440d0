"""The chart of soft discs: what it measures, on few meshes, and that its files hold it."""

import csv

from bearing_twin.charts import soft_discs as chart


def test_errors_fall_and_files_hold_them(tmp_path, monkeypatch):
    monkeypatch.setattr(chart, "REPEATS", 1)
    points = list(chart.measure(ladder=(6, 12), reference=("mesh.divisions=18", "mesh.order=3"), shares=(1.0, 0.5)))
    assert {point.panel for point in points} == {"mesh", "step", "formulation", "locking"}
    for panel in ("mesh", "formulation", "locking"):
        for line in {point.line for point in points if point.panel == panel}:
            errors = [point.error for point in points if (point.panel, point.line) == (panel, line)]
            assert errors[-1] < errors[0], line
    steps = [point for point in points if point.panel == "step"]
    # Long steps all err by what the mesh makes ring, of which they get the phase wrong.
    assert max(point.error for point in steps) < 3e-3
    locked, kept = (
        next(point for point in reversed(points) if point.line == f"{word} integration")
        for word in ("full", "selective")
    )
    assert locked.error > 5.0 * kept.error
    assert "full locks" in list(chart.reading(points))[-1]
    chart.draw(points, tmp_path / "discs.png")
    chart.write_table(points, tmp_path / "discs.csv")
    assert (tmp_path / "discs.png").stat().st_size > 10_000
    rows = list(csv.reader((tmp_path / "discs.csv").open()))
    assert len(rows) == len(points) + 1
