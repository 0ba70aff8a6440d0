"""Tests in processes side by side are told of as if one process had run them, whatever ends a process."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

FILES = {
    "ends": (
        "import os, signal, time, pytest",
        "from bearing_twin.stopping import SIGNALLED, heeding_signals",
        "def test_alone():",
        "    for _ in range(100):",
        "        assert SIGNALLED[0] == 0",
        "        time.sleep(0.01)",
        "    with heeding_signals():",
        "        signal.signal(signal.SIGUSR1, lambda *_: None)",
        "        signal.raise_signal(signal.SIGUSR1)",
        "        assert SIGNALLED[0] == signal.SIGUSR1",
        "TORN_DOWN = []",
        "@pytest.fixture(scope='module')",
        "def made():",
        "    yield [os.getpid()]",
        "    with open('torn_down', 'a') as stream: stream.write('made ')",
        "def test_before(made, tmp_path): made.append(2)",
        "def test_killed(made): os.kill(os.getpid(), signal.SIGKILL)",
        "def test_after(made): made.append(2)",
        "def test_shared(made): assert made == [os.getpid(), 2]",
        "def test_left(made): os._exit(0)",
    ),
    "other": (
        "import os, sys, warnings, pytest",
        "from bearing_twin.stopping import SIGNALLED, heeding_signals",
        "def test_alone():",
        "    assert SIGNALLED[0] == 0",
        "    SIGNALLED[:] = 1",
        "def test_wrong():",
        "    print('to be seen')",
        "    warnings.warn('take care')",
        "    assert 1 == 2",
        "@pytest.mark.skip('not here')",
        "def test_skipped(): pass",
        "@pytest.fixture",
        "def bad(): raise ValueError",
        "def test_unready(bad): pass",
        "def test_apart(tmp_path): assert not os.path.exists(tmp_path.parent / 'test_before0')",
        "@pytest.mark.xfail",
        "def test_known(): assert False",
    ),
}
STOPS = ("import time", "def test_first(): assert False", *(f"def test_{k}(): time.sleep(0.3)" for k in range(40)))


def run(folder, files, *words):
    """What pytest prints of these files in two processes, and its exit code."""
    for name in ("conftest.py", "domains.py", "forks.py", "side_by_side.py", "starts.py"):
        shutil.copy(Path(__file__).parent / name, folder)
    for name, lines in files.items():
        (folder / f"test_{name}.py").write_text("\n".join(lines) + "\n", encoding="utf-8")
    bare = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # other plugins take a second to load
    command = [sys.executable, "-m", "pytest", "--side-by-side=2", "-ra", "-W", "always", *words, str(folder)]
    done = subprocess.run(command, cwd=folder, env=bare, capture_output=True, text=True, check=False)
    return done.stdout, done.returncode


def test_every_test_is_told_of_once_and_one_that_ends_its_process_has_failed(tmp_path):
    out, code = run(tmp_path, FILES)
    assert code == 1, out
    last = out.splitlines()[-1]
    assert re.search(r"3 failed, 6 passed, 1 skipped, 1 xfailed, 1 warning, 1 error in", last), out
    killed = "the process of this test ended in the middle of it, by signal SIGKILL"
    assert f"failed: test_ends.py::test_killed (call, 0 s)\n{killed}" in out
    assert "FAILED test_ends.py::test_left" in out
    assert "by exit code 0" in out
    assert "FAILED test_other.py::test_wrong - assert 1 == 2" in out
    assert "to be seen" in out
    assert "UserWarning: take care" in out
    assert "ERROR test_other.py::test_unready - ValueError" in out
    assert "[100%]" in out
    assert not (tmp_path / "torn_down").exists(), "both processes that had it were ended"


def test_the_first_failure_stops_the_other_process_too(tmp_path):
    out, code = run(tmp_path, {"stops": STOPS, "other": ("import time", *STOPS[2:])}, "-x")
    assert code == 1, out
    assert "stopping after 1 failures" in out
    passed = re.search(r"1 failed, (\d+) passed", out)
    assert passed is None or int(passed[1]) < 40, out


def test_what_goes_wrong_outside_tests_is_told(tmp_path):
    lines = ("def pytest_runtest_protocol(item):", "    raise OSError('of the hook')")
    (tmp_path / "wrong.py").write_text("\n".join(lines), encoding="utf-8")
    out, code = run(tmp_path, {"one": ("def test_one(): pass",)}, "-p", "wrong")
    assert code == 3, out
    assert "OSError: of the hook" in out
