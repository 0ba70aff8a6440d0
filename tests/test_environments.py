"""Slow and strange surroundings: empty caches, a starved processor, an end in the middle, other Pythons.

`make test-environments` runs these; nothing here depends on how fast the machine is.
"""

import contextlib
import functools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages import ROOT, copied_sources

NODE = [sys.executable, "-m", "bearing_twin.nodes.entry"]
BUSY_LOOPS = 3

pytestmark = pytest.mark.environment


def surroundings(**changes):
    return os.environ | {"PYTHONPATH": os.pathsep.join((str(ROOT), os.environ.get("PYTHONPATH", "")))} | changes


@contextlib.contextmanager
def busy(core):
    """Processes that never rest, on this core."""
    pin = functools.partial(os.sched_setaffinity, 0, {core})
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"], preexec_fn=pin) for _ in range(BUSY_LOOPS)]
    try:
        yield pin
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="processes cannot be confined to one core here")
def test_the_demo_passes_at_the_first_try_with_an_empty_cache_and_a_quarter_of_a_core(tmp_path):
    import ros  # noqa: F401  (skips where ROS is missing)

    command = [*NODE, "demo", "--duration", "1", "--out", str(tmp_path)]
    with busy(max(os.sched_getaffinity(0))) as pin:
        done = subprocess.run(
            command,
            env=surroundings(XDG_CACHE_HOME=str(tmp_path / "cache")),
            cwd=ROOT,
            preexec_fn=pin,
            capture_output=True,
            text=True,
            check=False,
        )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "samples lost: 0 recorded, 0 replayed" in done.stdout
    assert not (tmp_path / "cache" / "bearing_twin").exists()


def python_of(minor):
    """A Python 3.<minor> that runs, on the path or of pyenv; None if there is none."""
    name = f"python3.{minor}"
    for python in (shutil.which(name), *Path.home().glob(f".pyenv/versions/*/bin/{name}")):
        if python and subprocess.run([python, "-c", ""], stderr=subprocess.DEVNULL, check=False).returncode == 0:
            return python
    return None


@pytest.mark.parametrize("minor", [version for version in range(10, 14) if version != sys.version_info.minor])
def test_the_package_runs_with_another_python(minor, tmp_path):
    """Installed with what it needs into an environment of its own; versions as pip finds them for this Python."""
    python = python_of(minor)
    if python is None:
        pytest.skip(f"there is no Python 3.{minor} here")
    subprocess.run([python, "-m", "venv", tmp_path / "venv"], check=True)
    venv_python = tmp_path / "venv" / "bin" / "python"
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    environment["XDG_CACHE_HOME"] = str(tmp_path / "cache")
    copied_sources(tmp_path / "source")
    subprocess.run(
        [venv_python, "-m", "pip", "install", "--quiet", "--retries", "20", "--timeout", "60", tmp_path / "source"],
        env=environment,
        check=True,
    )
    command = [venv_python, "-m", "bearing_twin", "simulate", "two_spheres", "--json", "--out", "run.mcap"]
    done = subprocess.run(command, env=environment, cwd=tmp_path, stdout=subprocess.PIPE, check=True)
    assert json.loads(done.stdout)["status"] == "done"
    command = [venv_python, "-c", "from bearing_twin import core; print(core.simd_lanes())"]
    assert int(subprocess.run(command, env=environment, cwd=tmp_path, stdout=subprocess.PIPE, check=True).stdout) > 1
