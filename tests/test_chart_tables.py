"""The one table of all charts that compare methods: its columns, its reader, and what stands in `docs`."""

import csv
import importlib
import json
import math
import shlex
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin import __version__
from bearing_twin.charts import motions, timing, work_precision
from bearing_twin.charts.chart import Chart, unsure
from bearing_twin.charts.contest import Asked, Kept
from bearing_twin.charts.made import made, processor
from bearing_twin.charts.table import (
    DONE,
    FAILED,
    MADE,
    NEWER,
    REFUSED,
    STOPPED,
    MapRow,
    Row,
    columns_of,
    read_table,
    write_rows,
    write_table,
)
from bearing_twin.command.chart_table import CHARTS, made_by
from bearing_twin.command.cli import main
from bearing_twin.kinds.charted import measured_rows

pytestmark = pytest.mark.usefixtures("quick_pictures")


@pytest.mark.parametrize("name", [name for name, chart in CHARTS.items() if chart.made in ("points", "told")])
def test_a_chart_of_points_is_read_again_from_its_table(name, tmp_path, capsys):
    """What `docs` holds, read, written and read once more; the table of another chart is none."""
    module = importlib.import_module(f"bearing_twin.charts.{CHARTS[name].module}")
    table = Path(__file__).parents[1] / "docs" / f"{name}.csv"
    if not table.is_file():
        assert main(["chart", name, "--read", "--out", str(tmp_path)]) == 2
        return
    points = read_table(table, module.POINT)
    write_table(points, tmp_path / f"{name}.csv")
    assert main(["chart", name, "--read", "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["reading"] == list(module.reading(points))
    other = "laws" if name != "laws" else "bounces"
    shutil.copy(table.with_name(f"{other}.csv"), tmp_path / f"{name}.csv")
    assert main(["chart", name, "--read", "--out", str(tmp_path)]) == 2


@pytest.mark.parametrize("name", made_by("contest"))
def test_every_contest_has_one_format_and_is_read_again(name, tmp_path, capsys):
    """Ten columns of every table in `docs`, further ones behind; a table of another chart is refused in a sentence."""
    tables = [f"{name}_cells.csv"] if name == "stability" else [f"{name}.csv"]
    docs = Path(__file__).parents[1] / "docs"
    for table in tables:
        with (docs / table).open(encoding="utf-8", newline="") as stream:
            header, *rows = csv.reader(stream)
        shared = columns_of(Row)  # in tables of earlier versions without NEWER
        assert header[: len(shared)] == shared or header[:10] == [one for one in shared if one not in NEWER]
        assert rows
        assert {row[7] for row in rows} <= {DONE, FAILED, REFUSED, STOPPED}
    assert main(["chart", name, "--read", "--out", str(docs), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["reading"]
    shutil.copy(docs / "cost.csv", tmp_path / f"{name}.csv")
    assert main(["chart", name, "--read", "--out", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert "make them without --read" in told
    assert name == "stability" or "is no table of this chart" in told


@pytest.mark.parametrize("every", [False, True])
@pytest.mark.parametrize("name", [name for name in made_by("contest") if name != "stability"])
def test_who_is_stopped_is_drawn_and_told(name, every, tmp_path):
    """The first contestant of the table in `docs`, or all of them."""
    chart = importlib.import_module(f"bearing_twin.charts.{CHARTS[name].module}").CONTESTS[name]
    rows = read_table(Path(__file__).parents[1] / "docs" / f"{name}.csv", chart.kind)
    setting = math.nan if name in ("laws", "friction", "fidelity") else rows[0].setting
    lost = chart.kind(*(rows[0].problem, rows[0].method), setting, seconds=0.5, status=STOPPED, reason="stopped early")
    others = [row for row in rows if (row.problem, row.method) != (lost.problem, lost.method) and row.status != STOPPED]
    rows = [lost, *([] if every else others)]
    chart.draw(rows, tmp_path / "x.png")
    assert (tmp_path / "x.png").stat().st_size > 5000
    said = chart.reading(rows)
    assert said[-1] == f"Without a result: {lost.method} of {lost.problem} (stopped early)."


def test_a_table_gives_back_what_was_written(tmp_path):
    rows = [
        MapRow("p", "m", 2097152.0, 1.0 / 3.0, status=DONE, reason="a, b", command='x --cell "y"', across=1e-300),
        MapRow("p", "m", 1e-9, evaluations=7),
    ]
    write_table(rows, tmp_path / "x.csv")
    again = read_table(tmp_path / "x.csv", MapRow)
    assert str(again[0]) == str(rows[0].but(load_error=0.333333333))
    assert str(again[1]) == str(rows[1].but(evaluations=7.0))
    assert (again[0].error, again[1].error) == (0.333333333, math.inf)
    with pytest.raises(ValueError, match="its columns differ in across"):
        read_table(tmp_path / "x.csv", Row)
    with (tmp_path / "x.csv").open(encoding="utf-8", newline="") as stream:
        cells = {row[MADE] for row in csv.DictReader(stream)}
    assert cells == {made()}
    assert made().startswith(f"bearing_twin {__version__}")
    assert {processor(), f"numpy {np.__version__}"} <= set(made().split("; "))


def test_a_chart_goes_on_with_finer_settings_and_keeps_its_order(monkeypatch):
    monkeypatch.setattr(halved, "__module__", "made_up.halving")
    monkeypatch.setitem(sys.modules, "made_up.halving", SimpleNamespace(halved=halved))
    made = Chart(
        judge=halved, problems={"p": "", "q": ""}, entries=lambda name: (("a", 1.0), ("b", 0.25)), further=_next
    )
    shares = []
    rows = made.measure(Asked(("p", "q"), shares.append, 0, 0.0, Kept(None)))
    assert [(row.problem, row.method, row.setting) for row in rows] == [
        (problem, *one) for problem in "pq" for one in (("a", 1.0), ("a", 0.5), ("a", 0.25), ("b", 0.25))
    ]
    assert shares == sorted(shares)
    assert shares[-1] < 1.0  # nobody knows how many rounds there will be


def halved(problem, method, setting, limit):
    """A run whose error is its setting."""
    return [Row(problem, method, setting, load_error=setting, status=DONE)]


def _next(rows):
    least = {(row.problem, row.method): row.setting for row in rows}
    return [(*one, 0.5 * setting) for one, setting in least.items() if setting > 0.25]


def test_a_table_from_before_there_was_a_spread_is_read(tmp_path):
    write_table([MapRow("p", "m", 1.0, status=DONE, across=2.0, spread=0.25)], tmp_path / "x.csv")
    with (tmp_path / "x.csv").open(encoding="utf-8", newline="") as stream:
        header, line = csv.reader(stream)
    old = [number for number, name in enumerate(header) if name not in ("spread", MADE)]
    write_rows(tmp_path / "x.csv", [header[one] for one in old], [[line[one] for one in old]])
    (row,) = read_table(tmp_path / "x.csv", MapRow)
    assert (row.across, row.unsure) == (2.0, False)
    assert math.isnan(row.spread)


def test_costs_that_are_known_badly_are_told():
    rows = [Row("p", "m", setting, status=DONE, spread=spread) for setting, spread in ((1, 0.05), (2, 0.25), (3, 0.5))]
    assert [row.unsure for row in rows] == [False, True, True]
    told = "Costs whose repeats lie over 10% apart, ringed: 2 of 3, the widest m of p at 3 (50%), m of p at 2 (25%)."
    assert unsure([*rows, Row("p", "m", 4.0)]) == [told]
    assert unsure(rows[:1]) == []


def _clocked(monkeypatch, seconds):
    """Work that takes these CPU seconds, one run after the other, and what it has done."""
    now, done, source = [0.0], [], iter(seconds)

    def work():
        now[0] += next(source)
        done.append(len(done))
        return done[-1]

    monkeypatch.setattr(timing.time, "thread_time", lambda: now[0])
    return work, done


@pytest.mark.parametrize(
    ("seconds", "enough", "seconds_found", "spread", "runs"),
    [
        ([9.0, *[0.2] * 5], 0.1, 9.0, math.nan, 1),  # long: once
        ([0.3, *[0.2] * 5], 0.1, 0.2, 0.0, 6),  # the first does not count
        ([0.3, *[0.2] * 5], 0.0, 0.3, math.nan, 1),
        ([0.3, 0.2, 0.2, 0.3, 0.3, *[0.2] * 20], 0.1, 0.2, 0.0, 10),  # until the middle is known
        ([0.06, 0.05, *[0.05] * 200], 0.1, 0.05, 0.0, 17),  # three to a timing, after one alone
    ],
)
def test_a_timing_goes_on_until_its_median_is_known(monkeypatch, seconds, enough, seconds_found, spread, runs):
    work, done = _clocked(monkeypatch, seconds)
    found, cost = timing.timed(work, enough)
    assert found == 0
    assert cost == pytest.approx((seconds_found, spread), nan_ok=True)
    assert len(done) == runs


def test_who_is_near_the_limit_is_not_run_again(monkeypatch):
    work, done = _clocked(monkeypatch, [0.5] * 9)
    monkeypatch.setattr(timing.signal, "getitimer", lambda which: (2.0, 0.0))
    assert timing.timed(work)[1].seconds == 0.5
    assert len(done) == 1


@pytest.mark.parametrize("name", ["steppers", "motions"])
def test_a_row_says_how_long_its_run_is(name):
    """As its command repeats it; and as the chart writes it today."""
    rows = [row for row in measured_rows(f"{name}.csv") if row["command"]]
    assert len(rows) > 200
    for row in rows:
        words = shlex.split(row["command"])
        lasts = [words[k + 1] for k, word in enumerate(words) if word == "--duration"]
        lasts += [word.split("=")[1] for word in words if word.startswith("run.duration=")]
        assert [float(one) for one in lasts] == [float(row["simulated"])]
    first = next(row for row in rows if row["status"] == DONE)
    judge = {"steppers": work_precision.judge_motion, "motions": motions.judge}[name]
    made_now = judge(first["problem"], first["method"], float(first["setting"]), 60.0)
    assert made_now.status == DONE
    assert made_now.simulated == float(first["simulated"])
