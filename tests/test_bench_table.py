"""The table of what everything costs: its rows are measured, kept by name, and missed goals are told."""

import csv
from dataclasses import replace

import measured
import pytest
import table


def test_rows_that_ran_replace_those_of_their_name(tmp_path, monkeypatch):
    monkeypatch.setattr(measured, "TABLE", tmp_path / "speed.csv")
    first, second, third = list(table.ROWS)[:3]
    measured.keep([replace(third, found=1.0), replace(first, found=2.0)], table.ROWS)
    measured.keep([replace(third, found=3.0), replace(second, found=4.0)], table.ROWS)
    with measured.TABLE.open(newline="") as stream:
        rows = [(row["what"], float(row["found"])) for row in csv.DictReader(stream)]
    assert rows == [(first.what, 2.0), (second.what, 4.0), (third.what, 3.0)]


def test_a_row_is_measured_and_a_missed_goal_is_told(tmp_path, monkeypatch, capsys):
    row = next(one for one in table.ROWS if one.what == "loads of a held ring")
    monkeypatch.setattr(measured, "TABLE", tmp_path / "speed.csv")
    monkeypatch.setattr(table, "ROWS", {replace(row, goal=1e-9): table.ROWS[row], replace(row, goal=1e9): lambda: 1.0})
    table.main(row.what)
    one, two = capsys.readouterr().out.splitlines()[1:]
    assert one.endswith("missed")
    assert 0.0 < float(one.removeprefix(row.what).split()[0]) < 1e6
    assert not two.endswith("missed")
    assert not measured.TABLE.exists()


@pytest.mark.parametrize(
    ("unit", "better", "goal", "scaled", "met"),
    [
        ("times real time", "more", 20.0, 36.0, True),
        ("times real time", "more", 37.0, 36.0, False),
        ("s", "less", 9.0, 9.0, True),
        ("us", "less", 8.9, 9.0, False),
        ("of point", "less", 17.9, 18.0, False),
        ("MB", "less", 18.1, 18.0, True),
    ],
)
def test_times_are_judged_as_on_the_machine_that_goals_are_of(unit, better, goal, scaled, met):
    """On one that takes twice as long a contact; ratios and memory are of no machine."""
    row = measured.Measured("it", "so", goal, better, unit, found=18.0, contact=2.0 * measured.YARDSTICK)
    assert (row.scaled, row.met) == (scaled, met)


def test_the_table_in_the_docs_has_every_row():
    kept = [row.what for row in measured.kept()]
    assert kept == [row.what for row in table.ROWS]
    assert len(set(kept)) == len(kept)


@pytest.mark.parametrize("row", list(table.ROWS), ids=lambda one: one.what)
def test_a_row_says_which_way_is_better(row):
    assert row.better in ("more", "less")
    assert row.goal > 0.0
