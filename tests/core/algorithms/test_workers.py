"""Worker processes: how they are started where, what a second one costs in imports and processes, how they end."""

import json
import os
import signal
import subprocess
import sys
import threading
from multiprocessing.connection import Connection

import numpy as np
import pytest
from sources import ROOT
from test_ensemble import LONG_RUN, LOSSY, children, living, run, stat_of, wait_for

from bearing_twin.base.errors import StudyError
from bearing_twin.kinds import KINDS
from bearing_twin.run.scene import open_scene
from bearing_twin.uq import workers
from bearing_twin.uq.realisations import realise, task_of
from bearing_twin.uq.study import parse_study
from bearing_twin.uq.workers import Ensemble


def test_a_worker_is_a_fork_where_there_is_no_other_thread():
    """Seen in a fork of the tests, which has one thread whatever they have begun."""
    reported, tells = os.pipe()
    if not (child := os.fork()):
        try:
            alone, over = workers.start_method(), threading.Event()
            thread = threading.Thread(target=over.wait)
            thread.start()
            threaded = workers.start_method()
            over.set()
            thread.join()
            os.write(tells, f"{alone} {threaded}".encode())
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    os.close(tells)
    with os.fdopen(reported) as stream:
        assert stream.read() == ("fork spawn" if sys.platform == "linux" else "spawn spawn")


@pytest.mark.parametrize("way", ["fork", pytest.param("spawn", marks=pytest.mark.environment)])
def test_numbers_are_the_same_however_workers_are_started_and_a_fork_imports_nothing(way, tmp_path, monkeypatch):
    """A kind's own module is read by each process that is started afresh, and by no other."""
    name = f"counted_kind_{os.getpid()}"
    lines = (
        "import dataclasses, os",
        "from bearing_twin.kinds import KINDS, register",
        f"with open({str(tmp_path / 'read')!r}, 'a') as stream: stream.write(f'{{os.getpid()}} ')",
        "register(dataclasses.replace(KINDS['two_spheres'], name='counted'), __name__)",
    )
    (tmp_path / f"{name}.py").write_text("\n".join(lines), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(workers, "start_method", lambda: way)
    __import__(name)
    try:
        scene = open_scene("two_spheres")[0] | {"kind": "counted"}
        task = task_of(parse_study({**LOSSY, "scene": scene}, "s"))
        values = np.linspace(0.9e-4, 1.6e-4, 40)[:, None]
        with Ensemble(task, 2, "processes", lambda: False) as ensemble:
            by_workers = ensemble.evaluate(values)
            assert len(children()) == 2
        in_this_process = realise(task, values)
    finally:
        del KINDS["counted"], sys.modules[name]
    assert np.isfinite(in_this_process.quantities).all()
    assert np.array_equal(by_workers.quantities, in_this_process.quantities)
    assert len((tmp_path / "read").read_text().split()) - 1 == {"fork": 0, "spawn": 2}[way]
    assert children() == []


def test_what_one_worker_meets_and_nobody_foresaw_is_raised_with_where_it_was(monkeypatch):
    def realise(task, values):
        raise MemoryError("no room")

    monkeypatch.setattr(workers, "start_method", lambda: "fork")
    monkeypatch.setattr(workers, "realise", realise)
    with pytest.raises(MemoryError, match="no room") as met:
        run(LOSSY, ["workers=2"])
    assert "in realise" in str(met.value.__cause__)
    assert children() == []


def test_a_worker_that_dies_while_it_sends_ends_the_study_too(monkeypatch):
    """Half an answer is no answer that somebody waits on for ever."""

    def half(pipe, message):
        os.write(pipe.fileno(), bytes(message)[: len(message) // 2])
        os.kill(os.getpid(), signal.SIGKILL)

    def realise_and_die(task, values):
        Connection._send = half  # in this worker alone
        return realise(task, values)

    monkeypatch.setattr(workers, "start_method", lambda: "fork")
    monkeypatch.setattr(workers, "realise", realise_and_die)
    with pytest.raises(StudyError, match="a worker process died"):
        run(LOSSY, ["workers=2"])
    assert children() == []


def test_where_no_process_can_be_started_it_is_told(monkeypatch):
    class Refusing:
        def Pipe(self):
            raise OSError(24, "Too many open files")

    monkeypatch.setattr(workers.multiprocessing, "get_context", lambda method: Refusing())
    with pytest.raises(StudyError, match=r"worker processes cannot be started \(Too many open files\)"):
        run(LOSSY)


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.environment), signal.SIGKILL]
)
def test_no_process_of_two_workers_outlives_a_signal(number, tmp_path):
    path = tmp_path / "long.yaml"
    path.write_text(json.dumps({**LONG_RUN, "workers": 2}), encoding="utf-8")
    command = [sys.executable, "-m", "bearing_twin", "study", str(path), "--json"]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    started = wait_for(lambda: pids if len(pids := children(process.pid)) == 2 else [], 300.0)
    process.send_signal(number)
    _, error = process.communicate(timeout=300)
    wait_for(lambda: all(stat_of(pid)[:1] in ([], ["Z"]) for pid in started), 300.0)
    assert number != signal.SIGINT or b"stopped by Ctrl-C with 0 of 8 samples done" in error
    expected = {signal.SIGINT: 130, signal.SIGTERM: 128 + signal.SIGTERM, signal.SIGKILL: -signal.SIGKILL}
    assert process.returncode == expected[number], error
    assert b"Traceback" not in error


@pytest.mark.parametrize(
    ("until", "changes"),
    [
        ("multiprocessing.active_children()", {}),
        pytest.param("reported", {"set": ["run.duration=0.02"], "samples": 10000}, marks=pytest.mark.environment),
    ],
)
def test_an_interpreter_that_ends_waits_for_no_study_of_a_thread(until, changes, tmp_path):
    """And takes its workers along, while they start or while they compute; nothing is said of it."""
    script = tmp_path / "ends.py"
    lines = (
        "import multiprocessing, threading, time",
        "from bearing_twin import parse_study, run_study",
        f"mapping = { {**LONG_RUN, **changes, 'workers': 2}!r}",
        "reported = []",
        "def study(): run_study(parse_study(mapping, 's'), reported.append)",
        "if __name__ == '__main__':",
        "    threading.Thread(target=study, daemon=True).start()",
        f"    while not {until}: time.sleep(0.01)",
    )
    script.write_text("\n".join(lines), encoding="utf-8")
    process = subprocess.Popen([sys.executable, script], cwd=ROOT, start_new_session=True, stderr=subprocess.PIPE)
    try:
        assert process.communicate(timeout=300)[1] == b""
        assert process.returncode == 0
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        raise
    wait_for(lambda: not living(3, process.pid), 300.0)


def test_a_worker_heeds_no_handler_of_the_process_that_started_it(monkeypatch):
    """Else a signal to end it would be an exception within a realisation, and its failure."""
    heard = []

    def realise(task, values):
        os.kill(os.getpid(), signal.SIGTERM)
        return

    monkeypatch.setattr(workers, "start_method", lambda: "fork")
    monkeypatch.setattr(workers, "realise", realise)
    previous = signal.signal(signal.SIGTERM, lambda *_: heard.append(1))
    try:
        with pytest.raises(StudyError, match="a worker process died"):
            run(LOSSY, ["workers=2"])
    finally:
        signal.signal(signal.SIGTERM, previous)
    assert not heard
