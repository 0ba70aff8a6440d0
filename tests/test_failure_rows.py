"""Every way to fail that the docs name is provoked, and answered as they say."""

import shlex
from pathlib import Path

import pytest
from failure_rows import FAILURES

from bearing_twin.charts import CHARTS
from bearing_twin.command.cli import main

DOCS = Path(__file__).resolve().parent.parent / "docs"


@pytest.mark.parametrize("row", FAILURES, ids=lambda row: row.command[:60])
def test_the_command_provokes_the_answer(row, capsys, tmp_path, monkeypatch, quick_workers):
    monkeypatch.chdir(tmp_path)  # a run that fails writes down its last good state
    words = [str(DOCS / "charts") if word == "docs/charts" else word for word in shlex.split(row.command)]
    assert main(words) == row.code
    reported = capsys.readouterr()
    assert row.words in " ".join((reported.out + reported.err).split())


def test_every_row_is_on_a_chart():
    assert {row.chart for row in FAILURES} <= set(CHARTS)
