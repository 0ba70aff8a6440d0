"""Everything can be stopped: signals and other threads end a compiled loop that would run for ever."""

import importlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin import signals
from bearing_twin.errors import Interrupted, Stopped
from bearing_twin.log import cdr
from bearing_twin.log.index_file import IndexFile
from bearing_twin.log.mcap_log import raw_messages, read_log
from bearing_twin.log.mcap_write import McapWriter
from bearing_twin.log.raw_log import RawLogWriter
from bearing_twin.run.chunks import CHUNK_OUTPUTS, chunk_outputs
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.sample import AT_ONCE
from bearing_twin.signals import AGAIN, RAISED, Unbroken, ended_by_signals
from bearing_twin.stopping import LOST, SIGNALLED, Halt, heeding_signals

MANY = ("geometry.balls=4000", "geometry.pitch_diameter=12.0")
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


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        *(("bearing_6203", (f"solver.stepper={one}", "run.output_rate=1e5")) for one in ("rodas4", "rk4", "imex")),
        ("ellipsoid_tumbling", ("solver.stepper=dop853",)),
        ("two_bodies_groove", ("run.duration=0.02",)),
    ],
    ids=["rodas4", "rk4", "imex", "ellipsoid", "two bodies"],
)
def test_every_loop_looks_before_each_step(name, changes):
    halt = Halt()
    halt.end()
    simulation = Simulation(load_scene(name, changes), halt)
    simulation.advance(1)
    with pytest.raises(Stopped):
        simulation.advance(1)
    halt.flag[:] = 0
    simulation.reset()
    simulation.advance(2)
    same = next(iter(simulate(load_scene(name, changes)).blocks()))
    simulation.reset()
    assert np.array_equal(simulation.advance(len(same)).values["normal_load"], same.values["normal_load"])


@pytest.mark.parametrize(
    "changes",
    [("solver.stepper=dop853",), ("model.dimension=quasi_static", "wanted.outputs=loads")],
    ids=["scipy", "equilibria"],
)
def test_a_loop_that_is_no_kernel_of_steps_looks_too(changes):
    halt = Halt()
    simulation = Simulation(load_scene("bearing_6203", ["solver.companion=off", *changes]), halt)
    simulation.advance(1)
    halt.end()
    with pytest.raises(Stopped):
        simulation.advance(1)


def test_outputs_of_thousands_of_balls_come_in_small_chunks():
    few, many = load_scene("bearing_6203"), load_scene("bearing_6203", MANY)
    row_bytes = 8 * sum(channel.width for channel in many.channels)
    assert chunk_outputs(few, 1 << 40) == CHUNK_OUTPUTS
    assert 1 <= chunk_outputs(many, 1 << 40) <= AT_ONCE // row_bytes < CHUNK_OUTPUTS


def test_signals_are_noted_while_a_scene_warms_up(monkeypatch):
    """With a tiny step its microsecond takes for ever too."""
    noted, simulation = [], Simulation(load_scene("ellipsoid_tumbling"))

    def advance(*_):
        signal.raise_signal(signal.SIGTERM)
        noted.append(int(SIGNALLED[0]))

    monkeypatch.setattr(simulation, "_new_motion", lambda: SimpleNamespace(advance=advance))
    previous = signal.signal(signal.SIGTERM, lambda *_: None)
    try:
        simulation.warm_up()
    finally:
        signal.signal(signal.SIGTERM, previous)
    assert noted == [signal.SIGTERM]


@pytest.mark.parametrize(("number", "ended"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)])
def test_a_signal_whose_exception_python_drops_comes_again(number, ended):
    """Its handler runs in a callback of the collector, of which Python passes nothing on: the run went on for ever."""

    class Collected:
        def __del__(self):
            signal.raise_signal(number)

    end = time.monotonic() + PATIENCE
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where tests run in the background
    try:
        with pytest.raises(ended), ended_by_signals():  # noqa: PT012 - what a command does meanwhile
            Collected()
            while time.monotonic() < end:
                time.sleep(0.01)
    finally:
        signal.signal(signal.SIGINT, previous)


@pytest.mark.parametrize(("number", "ended"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)])
def test_a_signal_waits_for_the_end_of_an_import(number, ended, tmp_path, monkeypatch):
    """An exception there became an ImportError or RuntimeError of the library, with a traceback, or was swallowed."""
    (tmp_path / "signalled.py").write_text(
        f"import signal\nsignal.raise_signal({int(number)})\nfor i in range(1000):\n    pass\nWHOLE = True\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(signals, "LONGEST_IMPORT", PATIENCE)  # a busy machine takes longer for it than users wait
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(ended), ended_by_signals():  # noqa: PT012 - what a command does meanwhile
            module = importlib.import_module("signalled")
            time.sleep(PATIENCE)
    finally:
        signal.signal(signal.SIGINT, previous)
        sys.modules.pop("signalled", None)
    assert module.WHOLE


@pytest.mark.parametrize(("number", "ended"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)])
def test_a_loop_that_stops_while_a_signal_waits_ends_as_that_signal(number, ended, tmp_path, monkeypatch):
    """Loops see a signal that came in an import at once, its handler a moment later: the command ended as bad input."""
    (tmp_path / "signalled.py").write_text(f"import signal\nsignal.raise_signal({int(number)})\n")
    monkeypatch.syspath_prepend(tmp_path)
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(ended), ended_by_signals(), heeding_signals():  # noqa: PT012 - what a command does meanwhile
            importlib.import_module("signalled")
            assert SIGNALLED[0] == number
            raise Stopped("the computation was stopped within a chunk")
        time.sleep(5.0 * AGAIN)  # the one that waited does not come as well
    finally:
        signal.signal(signal.SIGINT, previous)
        sys.modules.pop("signalled", None)


@pytest.mark.parametrize(("number", "ended"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)])
@pytest.mark.parametrize("swallowed", [True, False])
def test_what_became_of_a_signal_is_that_signal(number, ended, swallowed):
    """Where a library makes an error of its own of the exception, or none."""
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(ended), ended_by_signals():  # noqa: PT012 - what a command does meanwhile
            try:
                signal.raise_signal(number)
            except BaseException as error:
                if not swallowed:
                    raise ImportError("initialization failed") from error
            with heeding_signals():
                pytest.fail("goes on as if nothing had been")
    finally:
        signal.signal(signal.SIGINT, previous)
    assert not RAISED


@pytest.mark.parametrize("give_back", [signal.getsignal, signal.signal])
def test_no_signal_is_lost_while_handlers_are_given_back(give_back, monkeypatch):
    heard = []
    previous = signal.signal(signal.SIGTERM, lambda *_: heard.append("term"))
    try:
        unbroken = Unbroken()
        unbroken.watch()

        def signalled(number, *handler):
            if number == signal.SIGTERM:
                monkeypatch.undo()
                signal.raise_signal(signal.SIGTERM)
            return give_back(number, *handler)

        monkeypatch.setattr(signal, give_back.__name__, signalled)
        unbroken.release()
        assert heard == ["term"]
    finally:
        signal.signal(signal.SIGTERM, previous)


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=pytest.mark.environment)]
)
def test_a_signal_ends_the_command_in_the_middle_of_a_chunk(tmp_path, number, code, quick_starts):
    path, words = tmp_path / "run.mcap", [word for one in ENDLESS for word in ("--set", one)]
    command = [sys.executable, "-m", "bearing_twin", "simulate", "bearing_6203", *words, "--out", str(path)]
    root = Path(__file__).parents[1]
    with subprocess.Popen(command, stderr=subprocess.PIPE, cwd=root) as process:
        try:
            end = time.monotonic() + PATIENCE
            while not path.exists() and process.poll() is None and time.monotonic() < end:
                time.sleep(0.05)
            time.sleep(0.4)
            process.send_signal(number)
            said = process.communicate(timeout=PATIENCE)[1].decode()
        finally:
            process.kill()
    assert process.returncode == code, said
    assert "Traceback" not in said
    assert path.exists() is False or len(list(read_log(path))) <= 1


def test_signals_are_noted_within_and_forgotten_after():
    seen = []
    previous = signal.signal(signal.SIGTERM, lambda *_: seen.append("handled"))
    try:
        with heeding_signals():
            signal.raise_signal(signal.SIGTERM)
            noted = int(SIGNALLED[0])
    finally:
        signal.signal(signal.SIGTERM, previous)
    assert (noted, int(SIGNALLED[0]), seen) == (signal.SIGTERM, 0, ["handled"])
    assert signal.set_wakeup_fd(-1) == -1


@pytest.mark.parametrize(
    ("writer", "within"), [(McapWriter, "_append"), (McapWriter, "_put"), (IndexFile, "keep"), (McapWriter, "_tail")]
)
def test_a_signal_splits_nothing_that_is_written(writer, within, monkeypatch, tmp_path):
    """It comes within an append, at any of its parts; its handler runs after, and is the old one in the end."""
    come = []

    def leave(number, _):
        come.append(number)
        raise SystemExit(number)

    previous = signal.signal(signal.SIGTERM, leave)
    try:
        with pytest.raises(SystemExit), RawLogWriter(tmp_path / "run.mcap") as log:  # noqa: PT012 - a log and its end
            topic = log.add_topic("/a", cdr.STRING, cdr.schema_text(cdr.STRING), "", ())
            log.write(topic, 1, 1, b"\0\1\0\0\2\0\0\0a\0")
            log.flush()
            part = getattr(writer, within)

            def interrupted(self, *given):
                monkeypatch.undo()
                signal.raise_signal(signal.SIGTERM)
                return part(self, *given)

            monkeypatch.setattr(writer, within, interrupted)
            log.write(topic, 2, 2, b"\0\1\0\0\2\0\0\0b\0")
            log.flush()
        assert signal.getsignal(signal.SIGTERM) is leave
    finally:
        signal.signal(signal.SIGTERM, previous)
    assert come == [signal.SIGTERM]
    assert [message.log_time for message in raw_messages(tmp_path / "run.mcap")] == [1, 2]


@pytest.mark.parametrize(
    ("name", "inner"),
    [
        *((one, "") for one in ("bearing_6203", "bearing_6203_loose", "bearing_6203_rig_400N")),
        *((one, part) for one in ("ellipsoid_rocking", "two_bodies_groove") for part in ("", "_motion", "_finer")),
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
    outputs, wanted = [], 450
    while len(outputs) < wanted:
        halt._credit = LOST if times % 2 == 0 else 0.0
        times += 1
        try:
            block = interrupted.advance(min(40, wanted - len(outputs)))
        except Interrupted:
            assert times % 2
            assert not halt.flag[0]
            continue
        outputs += [row.tobytes() for row in block.matrix()]
    assert times > 2
    assert outputs == [row.tobytes() for row in plain.advance(wanted).matrix()]
    costs = plain.report().as_dict().keys() & {"ball_steps", "equilibria", "evaluations", "companion_steps"}
    assert costs
    assert all(plain.report().as_dict()[key] == interrupted.report().as_dict()[key] for key in costs)


def test_interruptions_wait_when_they_have_cost_their_share_and_never_undo_an_end():
    halt, motion = Halt(), SimpleNamespace(take_back=list)

    def interrupted():
        with halt.interruptible(motion):
            halt.interrupt()
            if halt.flag[0]:
                raise Stopped("stopped")

    halt.interrupt()
    assert not halt.flag[0]  # nothing computes
    with pytest.raises(Interrupted):
        interrupted()
    halt._credit = -1e-9
    interrupted()  # there is nothing left to lose
    assert halt._credit > -1e-9
    halt.end()
    with pytest.raises(Stopped) as ended:
        interrupted()
    assert type(ended.value) is Stopped
    assert halt.flag[0]


@pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="the system has no files in memory")
def test_the_signals_of_a_forked_worker_are_its_own():
    """The byte at which compiled loops look is in shared memory, for the system writes it: each process has its own."""
    SIGNALLED[:] = 7
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        before = int(SIGNALLED[0])
        with heeding_signals():
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
