"""The tortures of `make torture` in a short form: nothing is lost, and nothing goes wrong unsaid."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import torture
from torture_inputs import ROWS as INPUTS
from torture_logs import ROWS as LOGS
from torture_rows import until

SHARES = {"kill": 0.04, "cut": 0.005, "flip": 0.01, "mutant": 0.03, "bomb": 0.03, "size": 0.02, "report": 0.02}
TIMED = ("bomb", "report")  # where survival is a matter of seconds: measured by `make torture` alone
SLOW = ("kill", "bomb")  # processes that are killed, or have little memory: tests/test_log_damage.py has one of each


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, id=row.name, marks=[pytest.mark.environment] if row.name in SLOW else [])
        for row in (*LOGS, *INPUTS)
    ],
)
def test_a_short_torture_is_survived(row, tmp_path):
    found = row.run(SHARES.get(row.name, 0.05), tmp_path)
    assert found.tried > 0
    assert (found.lost, found.silent) == (0, 0), found.figures
    if row.name not in TIMED:
        assert found.survived == found.tried, found.figures


def test_a_row_takes_the_place_of_its_older_self_in_the_table(tmp_path):
    page = torture.PAGE.read_text(encoding="utf-8")
    cells = ("`torn`", "x", "1", "2", "3", "4", "", "1", "5", "now")
    once = torture.written(page, {"torn": cells})
    other = torture.written(once, {"kill": ("`kill`", *cells[1:]), "torn": (*cells[:-1], "later")})
    rows = [line for line in other.splitlines() if line.startswith(("|`torn`", "|`kill`"))]
    assert [row.split("|")[1] for row in rows] == ["`kill`", "`torn`"]
    assert "later" in rows[1]
    assert "now" not in rows[1]
    assert [line for line in other.splitlines() if not line.startswith("|")] == [
        line for line in page.splitlines() if not line.startswith("|")
    ]


def test_the_time_of_all_rows_takes_the_place_of_an_older_one():
    page = torture.PAGE.read_text(encoding="utf-8")
    later = torture.with_minutes(torture.with_minutes(page, 50.0), 12.0)
    assert "All rows took 12 minutes" in later
    assert later.count("All rows took") == 1


def test_a_row_beside_the_others_tells_what_it_found(tmp_path, monkeypatch, quick_starts):
    monkeypatch.setattr(torture, "SAID", tmp_path)
    [row] = (row for row in LOGS if row.name == "torn")
    chosen = [row._replace(beside=True), *(row for row in LOGS if row.name == "full")]
    found = {row.name: outcome for row, outcome in torture.outcomes(chosen, 0.05)}
    assert list(found) == ["full", "torn"]
    assert found["torn"].survived
    assert found["torn"].found.tried == 20
    assert [path.name for path in tmp_path.iterdir()] == ["torture_torn.txt"]


def test_what_a_row_beside_the_others_did_not_tell_counts_as_not_survived(tmp_path, monkeypatch):
    """Python ends with 2 where there is no such program, at once."""
    monkeypatch.setattr(torture, "SAID", tmp_path)
    monkeypatch.setattr(torture, "__file__", str(tmp_path / "nothing.py"))
    one = torture.Beside(LOGS[0], 0.05)
    outcome = one.outcome()
    assert not outcome.survived
    assert "exit code 2" in outcome.found.figures


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.environment)])
def test_a_signal_ends_the_torture_and_all_that_it_started(number, quick_starts):
    words = [sys.executable, torture.__file__, "--only", "kill"]
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True, start_new_session=True)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    assert until(lambda: process.poll() is None and bool(children.read_text()), 300.0)
    process.send_signal(number)
    _, said = process.communicate()
    assert process.returncode == 130
    assert said.splitlines()[-1] == "torture: interrupted"
    with pytest.raises(ProcessLookupError):  # nobody is left of its group
        os.killpg(process.pid, 0)
