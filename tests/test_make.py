"""What `make mutants` and `make torture` run: broken products, short tortures."""

import pytest
import torture
from mutants import ROOMS, SOURCES, file_of, node_ids, read_rows
from torture_inputs import ROWS as INPUTS
from torture_logs import ROWS as LOGS


def test_every_mutant_matches_the_sources_and_names_tests():
    rows = read_rows()
    assert len(rows) == 50
    assert {row["room"] for row in rows} == set(ROOMS)
    for row in rows:
        assert file_of(row).suffix in SOURCES
        assert node_ids(row["tests"])


SHARES = {"kill": 0.04, "cut": 0.01, "flip": 0.01, "mutant": 0.03}
SLOW = ("kill",)  # tests/test_log_damage.py has one


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, id=row.name, marks=[pytest.mark.environment] if row.name in SLOW else [])
        for row in (*LOGS, *INPUTS)
    ],
)
def test_a_short_torture_is_survived(row, tmp_path):
    result = row.run(SHARES.get(row.name, 0.05), tmp_path)
    assert result.tried > 0
    assert (result.lost, result.silent, result.survived) == (0, 0, result.tried), result.figures


def test_a_row_takes_the_place_of_its_older_self_in_the_table(tmp_path):
    page = torture.PAGE.read_text(encoding="utf-8")
    cells = ("`full`", "x", "1", "2", "3", "4", "", "1", "5", "now")
    once = torture.written(page, {"full": cells})
    both_rows = torture.written(once, {"kill": ("`kill`", *cells[1:]), "full": (*cells[:-1], "later")})
    rows = [line for line in both_rows.splitlines() if line.startswith(("|`full`", "|`kill`"))]
    assert [row.split("|")[1] for row in rows] == ["`kill`", "`full`"]
    assert "later" in rows[1]
    assert "now" not in rows[1]
    assert torture.written(both_rows, {}, 12.0).count("All rows took 12 minutes") == 1
    assert [line for line in both_rows.splitlines() if not line.startswith("|")] == [
        line for line in page.splitlines() if not line.startswith("|")
    ]


SHARES_OF_NODES = {"hostile": 0.2}  # of others the least there is
# Processes are started, ended and stopped. That nodes end with whole logs, and goals with answers, other tests show.
SLOW_FOR_NODES = ("soak", "goals", "stops", "calls", "cancels")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.environment] if name in SLOW_FOR_NODES else [])
        for name in ("hostile", "goals", "calls", "cancels", "stops", "soak")
    ],
)
def test_a_short_torture_of_nodes_loses_nothing(name, tmp_path):
    """Times are measured by `make torture` alone."""
    import ros  # noqa: F401 - skips where there is no ROS
    import torture_nodes

    result = getattr(torture_nodes, name)(SHARES_OF_NODES.get(name, 1e-3), tmp_path)
    assert result.tried > 0
    assert (result.lost, result.silent) == (0, 0), result.figures
