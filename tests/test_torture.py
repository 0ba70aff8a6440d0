"""The tortures of `make torture` in a short form: nothing is lost, and nothing goes wrong unsaid."""

import pytest
import torture
from torture_inputs import ROWS as INPUTS
from torture_logs import ROWS as LOGS

SHARES = {"kill": 0.04, "cut": 0.005, "flip": 0.01, "mutant": 0.03, "bomb": 0.03, "size": 0.02, "report": 0.02}
TIMED = ("bomb", "report")  # where survival is a matter of seconds: measured by `make torture` alone


@pytest.mark.parametrize("row", [*LOGS, *INPUTS], ids=lambda row: row.name)
def test_a_short_torture_is_survived(row, tmp_path):
    found = row.run(SHARES.get(row.name, 0.05), tmp_path)
    assert found.tried > 0
    assert (found.lost, found.silent) == (0, 0), found.figures
    if row.name not in TIMED:
        assert found.survived == found.tried, found.figures


def test_a_row_takes_the_place_of_its_older_self_in_the_table(tmp_path):
    page = torture.PAGE.read_text(encoding="utf-8")
    cells = ("`torn`", "x", "1", "2", "3", "4", "", "1", "now")
    once = torture.written(page, {"torn": cells})
    other = torture.written(once, {"kill": ("`kill`", *cells[1:]), "torn": (*cells[:-1], "later")})
    rows = [line for line in other.splitlines() if line.startswith(("|`torn`", "|`kill`"))]
    assert [row.split("|")[1] for row in rows] == ["`kill`", "`torn`"]
    assert "later" in rows[1]
    assert "now" not in rows[1]
    assert [line for line in other.splitlines() if not line.startswith("|")] == [
        line for line in page.splitlines() if not line.startswith("|")
    ]
