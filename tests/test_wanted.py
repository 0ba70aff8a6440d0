"""Which tests a change wants: by imports, in the order of their distance, and what is left out is said."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import wanted


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
    for name in ("conftest.py", "domains.py", "forks.py", "starts.py"):
        shutil.copy(Path(__file__).parent / name, tmp_path)
    for name in ("always", "other"):
        (tmp_path / f"test_{name}.py").write_text("def test_a():\n    pass\n\n\ndef test_b():\n    pass\n")
    words = ["-m", "pytest", "--within=0.4", "--always=test_always", str(tmp_path)]
    bare = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # other plugins take a second to load
    done = subprocess.run([sys.executable, *words], cwd=tmp_path, env=bare, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout
    assert "1 tests near the change were left out" in done.stdout
