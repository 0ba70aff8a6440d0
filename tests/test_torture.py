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

SHARES = {"kill": 0.04, "cut": 0.01, "flip": 0.01, "mutant": 0.03, "bomb": 0.03}
TIMED = ("bomb",)  # where survival is a matter of seconds: measured by `make torture` alone
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
    cells = ("`full`", "x", "1", "2", "3", "4", "", "1", "5", "now")
    once = torture.written(page, {"full": cells})
    other = torture.written(once, {"kill": ("`kill`", *cells[1:]), "full": (*cells[:-1], "later")})
    rows = [line for line in other.splitlines() if line.startswith(("|`full`", "|`kill`"))]
    assert [row.split("|")[1] for row in rows] == ["`kill`", "`full`"]
    assert "later" in rows[1]
    assert "now" not in rows[1]
    assert torture.written(other, {}, 12.0).count("All rows took 12 minutes") == 1
    assert [line for line in other.splitlines() if not line.startswith("|")] == [
        line for line in page.splitlines() if not line.startswith("|")
    ]


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
