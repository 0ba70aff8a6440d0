"""The table of what everything costs: its rows are measured, kept by name, and missed goals are told."""

import csv
from dataclasses import replace

import pytest
import table


def test_rows_that_ran_replace_those_of_their_name(tmp_path, monkeypatch):
    monkeypatch.setattr(table, "TABLE", tmp_path / "speed.csv")
    first, second, third = list(table.ROWS)[:3]
    table.keep([replace(third, found=1.0), replace(first, found=2.0)])
    table.keep([replace(third, found=3.0), replace(second, found=4.0)])
    with table.TABLE.open(newline="") as stream:
        rows = [(row["what"], float(row["found"])) for row in csv.DictReader(stream)]
    assert rows == [(first.what, 2.0), (second.what, 4.0), (third.what, 3.0)]


def test_a_row_is_measured_and_a_missed_goal_is_told(tmp_path, monkeypatch, capsys):
    row = next(one for one in table.ROWS if one.what == "loads of a held ring")
    monkeypatch.setattr(table, "TABLE", tmp_path / "speed.csv")
    monkeypatch.setattr(table, "ROWS", {replace(row, goal=1e-9): table.ROWS[row], replace(row, goal=1e9): lambda: 1.0})
    table.main(row.what)
    one, two = capsys.readouterr().out.splitlines()[1:]
    assert one.endswith("missed")
    assert 0.0 < float(one.removeprefix(row.what).split()[0]) < 1e6
    assert not two.endswith("missed")
    assert not table.TABLE.exists()


def test_the_table_in_the_docs_has_every_row():
    with table.TABLE.open(newline="", encoding="utf-8") as stream:
        kept = [row["what"] for row in csv.DictReader(stream)]
    assert kept == [row.what for row in table.ROWS]
    assert len(set(kept)) == len(kept)


@pytest.mark.parametrize("row", list(table.ROWS), ids=lambda one: one.what)
def test_a_row_says_which_way_is_better(row):
    assert row.better in ("more", "less")
    assert row.goal > 0.0
