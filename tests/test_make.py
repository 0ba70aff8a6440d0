"""What `make check`, `make mutants` and `make torture` run: the choice of tests, broken products, short tortures."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import torture
import wanted
from mutants import ROOMS, SOURCES, places_of, read_rows, seed_of
from torture_inputs import ROWS as INPUTS
from torture_logs import ROWS as LOGS
from torture_rows import until


@pytest.fixture(scope="module")
def graph():
    return wanted.import_graph()


def test_a_test_that_imports_a_module_is_one_step_from_it(graph):
    near = wanted.distances(["bearing_twin/contact/elasticity.py"], graph)
    assert near["tests/test_laws.py"] == 1
    assert near["tests/test_cli.py"] > near["tests/test_laws.py"]
    assert "tests/test_cdr.py" not in near


def test_late_imports_and_helpers_of_tests_count(graph):
    assert "bearing_twin/contact/calculator.py" in graph["bearing_twin/command/contact_command.py"]
    near = wanted.distances(["bearing_twin/kinds/bearing/motion.py"], graph)
    assert "tests/bearings.py" in graph["tests/test_stability.py"]
    assert near["tests/test_stability.py"] <= 2


def test_a_changed_test_is_nearest_and_a_file_that_is_no_python_goes_by_its_name(graph):
    assert wanted.distances(["tests/test_laws.py"], graph) == {"tests/test_laws.py": 0}
    readme = wanted.distances(["README.md"], graph)
    assert "tests/test_readme.py" in readme
    assert len(readme) < 10
    assert wanted.distances(["no/such_" + "folder_/such_" + "file_.xyz"], graph) == {}


def test_without_git_the_core_is_run(graph, monkeypatch, capsys):
    ran = []
    monkeypatch.setattr(wanted, "_git", lambda *words: None)
    monkeypatch.setattr(wanted, "import_graph", lambda: graph)
    done = subprocess.CompletedProcess([], 0)
    monkeypatch.setattr(wanted.subprocess, "run", lambda words, **more: ran.append(words) or done)
    assert wanted.main([]) == 0
    assert ran[0][-len(wanted.CORE) :] == [f"tests/{name}.py" for name in wanted.CORE]
    assert "the core tests only" in capsys.readouterr().err


def test_what_does_not_fit_is_left_out_and_said(tmp_path):
    for name in ("conftest.py", "processes.py", "starts.py"):
        shutil.copy(Path(__file__).parent / name, tmp_path)
    for name in ("always", "other"):
        (tmp_path / f"test_{name}.py").write_text("def test_a():\n    pass\n\n\ndef test_b():\n    pass\n")
    words = ["-m", "pytest", "--within=0.4", "--always=test_always", str(tmp_path)]
    bare = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # other plugins take a second to load
    done = subprocess.run([sys.executable, *words], cwd=tmp_path, env=bare, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout
    assert "1 tests near the change were left out" in done.stdout


def test_every_mutant_has_its_place_in_the_sources_and_its_tests():
    rows = read_rows()
    assert len(rows) == 50
    assert {row["room"] for row in rows} == set(ROOMS)
    for row in rows:
        assert seed_of(row).suffix in SOURCES
        assert places_of(row["tests"])


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


SHARES_OF_NODES = {"hostile": 0.03, "frozen": 0.1}  # of others the least there is
# Processes are started, ended and stopped. That nodes end with whole logs, and goals with answers, other tests show.
SLOW_FOR_NODES = ("soak", "goals", "frozen", "stops", "calls", "cancels")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(one, marks=[pytest.mark.environment] if one in SLOW_FOR_NODES else [])
        for one in ("hostile", "frozen", "goals", "calls", "cancels", "stops", "soak")
    ],
)
def test_a_short_torture_of_nodes_loses_nothing(name, tmp_path, quick_starts):
    """Times are measured by `make torture` alone."""
    import ros  # noqa: F401 - skips where there is no ROS
    import torture_nodes

    found = getattr(torture_nodes, name)(SHARES_OF_NODES.get(name, 1e-3), tmp_path)
    assert found.tried > 0
    assert (found.lost, found.silent) == (0, 0), found.figures
