"""Every way to fail that the docs name is provoked, and answered as they say."""

import shlex

import pytest
from failure_rows import FAILURES

from bearing_twin.command.chart_table import CHARTS
from bearing_twin.command.cli import main


@pytest.mark.parametrize("row", [row for row in FAILURES if row.command], ids=lambda row: row.command[:60])
def test_the_command_provokes_the_answer(row, capsys):
    assert main(shlex.split(row.command)) == row.code
    told = capsys.readouterr()
    assert row.words in " ".join((told.out + told.err).split())


def test_every_row_is_on_a_chart():
    assert {row.chart for row in FAILURES} <= set(CHARTS)
