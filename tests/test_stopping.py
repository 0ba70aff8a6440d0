"""Everything can be stopped: signals and other threads end a compiled loop that would run for ever."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from bearing_twin.base.errors import Interrupted, Stopped
from bearing_twin.base.stopping import CREDIT, SIGNALLED, Halt, signal_flag
from bearing_twin.log import cdr
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.mcap_write import McapWriter
from bearing_twin.log.raw_log import RawLogWriter
from bearing_twin.log.run_log import read_log
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation

ENDLESS = ("solver.stepper=rk4", "solver.step=1e-11")  # a day for the first chunk
PATIENCE = 300.0  # s: what does not end at all fails


def test_another_thread_ends_a_chunk():
    halt, ended = Halt(), []
    simulation = Simulation(load_scene("bearing_6203", ENDLESS), halt)
    simulation.advance(1)

    def run():
        with pytest.raises(Stopped, match="was stopped at 0 s"):
            simulation.advance(1)
        ended.append(simulation.sequence)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    time.sleep(0.2)
    halt.end()
    thread.join(PATIENCE)
    assert ended == [0]
    assert not SIGNALLED[0]


def test_signals_are_noted_while_the_start_of_a_run_is_found(monkeypatch):
    noted, simulation = [], Simulation(load_scene("ellipsoid_tumbling"))
    found = simulation._motion.first_outputs

    def first_outputs():
        signal.raise_signal(signal.SIGTERM)
        noted.append(int(SIGNALLED[0]))
        return found()

    monkeypatch.setattr(simulation._motion, "first_outputs", first_outputs)
    previous = signal.signal(signal.SIGTERM, lambda *_: None)
    try:
        simulation.advance(1)
    finally:
        signal.signal(signal.SIGTERM, previous)
    assert noted == [signal.SIGTERM]


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=pytest.mark.environment)]
)
def test_a_signal_ends_the_command_in_the_middle_of_a_chunk(tmp_path, number, code):
    path, arguments = tmp_path / "run.mcap", [argument for line in ENDLESS for argument in ("--set", line)]
    command = [sys.executable, "-m", "bearing_twin", "simulate", "bearing_6203", *arguments, "--out", str(path)]
    root = Path(__file__).parents[1]
    with subprocess.Popen(command, stderr=subprocess.PIPE, cwd=root) as process:
        try:
            end = time.monotonic() + PATIENCE
            while not path.exists() and process.poll() is None and time.monotonic() < end:
                time.sleep(0.05)
            time.sleep(0.4)
            process.send_signal(number)
            stderr = process.communicate(timeout=PATIENCE)[1].decode()
        finally:
            process.kill()
    assert process.returncode == code, stderr
    assert "Traceback" not in stderr
    assert path.exists() is False or len(list(read_log(path))) <= 1


@pytest.mark.parametrize("within", ["_append", "_build_chunk", "_build_summary"])
def test_a_signal_splits_nothing_that_is_written(within, monkeypatch, tmp_path):
    """It comes within an append, at any of its parts; its handler runs after, and is the old one in the end."""
    signals = []

    def leave(number, _):
        signals.append(number)
        raise SystemExit(number)

    previous = signal.signal(signal.SIGTERM, leave)
    try:
        with pytest.raises(SystemExit), RawLogWriter(tmp_path / "run.mcap") as log:  # noqa: PT012 - a log and its end
            topic = log.add_topic("/a", cdr.STRING)
            log.write(topic, 1, 1, b"\0\1\0\0\2\0\0\0a\0")
            log.flush()
            part = getattr(McapWriter, within)

            def interrupted(self, *arguments):
                monkeypatch.undo()
                signal.raise_signal(signal.SIGTERM)
                return part(self, *arguments)

            monkeypatch.setattr(McapWriter, within, interrupted)
            log.write(topic, 2, 2, b"\0\1\0\0\2\0\0\0b\0")
            log.flush()
        assert signal.getsignal(signal.SIGTERM) is leave
    finally:
        signal.signal(signal.SIGTERM, previous)
    assert signals == [signal.SIGTERM]
    assert [message.log_time for message in raw_messages(tmp_path / "run.mcap")] == [1, 2]


@pytest.mark.parametrize(
    ("name", "inner"),
    [
        *((one, "") for one in ("bearing_6203", "bearing_6203_rig_400N")),
        *(("ellipsoid_rocking", part) for part in ("", "_motion", "_second")),
        ("two_bodies_groove", ""),
    ],
)
def test_an_interrupted_run_gives_the_same_to_the_bit(name, inner):
    """Interrupted before a chunk, or before its part in one of two motions side by side."""
    scene, halt = load_scene(name, ["run.output_rate=1e5"] if name.startswith("two") else []), Halt()
    plain, interrupted, times = Simulation(scene), Simulation(scene, halt), 0
    motion = getattr(interrupted._motion, inner) if inner else interrupted._motion
    move = motion.advance

    def disturbed(*arguments):
        halt.interrupt()
        return move(*arguments)

    motion.advance = disturbed
    outputs, expected = [], 450
    while len(outputs) < expected:
        halt._credit = CREDIT if times % 2 == 0 else 0.0
        times += 1
        try:
            block = interrupted.advance(min(40, expected - len(outputs)))
        except Interrupted:
            assert times % 2
            assert not halt.flag[0]
            continue
        outputs += [row.tobytes() for row in block.matrix()]
    assert times > 2
    assert outputs == [row.tobytes() for row in plain.advance(expected).matrix()]
    counted = "ball_steps", "equilibria", "evaluations", "second_run_ball_steps", "second_run_steps"
    costs = plain.report().as_dict().keys() & set(counted)
    assert costs
    assert all(plain.report().as_dict()[key] == interrupted.report().as_dict()[key] for key in costs)


@pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="the system has no files in memory")
def test_the_signals_of_a_forked_worker_are_its_own():
    """The byte at which compiled loops look is in shared memory, for the system writes it: each process has its own."""
    SIGNALLED[:] = 7
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        before = int(SIGNALLED[0])
        with signal_flag():
            signal.signal(signal.SIGUSR1, lambda *_: None)
            signal.raise_signal(signal.SIGUSR1)
            os.write(writer, bytes([before, int(SIGNALLED[0])]))
        os._exit(0)
    try:
        os.waitpid(child, 0)
        assert os.read(reader, 2) == bytes([0, signal.SIGUSR1])
        assert SIGNALLED[0] == 7
    finally:
        SIGNALLED[:] = 0
        os.close(reader)
        os.close(writer)
