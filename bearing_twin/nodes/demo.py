"""The demonstration behind `make demo`: simulate in real time, record, watch, replay, and show what came of it.

Three nodes run as processes of their own, as with `ros2 run`; this process is the subscriber.
"""

import argparse
import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table
from std_srvs.srv import SetBool

from bearing_twin.errors import BearingTwinError
from bearing_twin.log.mcap_log import read_log
from bearing_twin.log.stream import topics
from bearing_twin.nodes.messages import rclpy
from bearing_twin.nodes.watching import Watch, Watcher, ball_table, load_line
from bearing_twin.run.picture import plot
from bearing_twin.run.scene import Scene, load_scene

REPLAY_RATE = 2.0
PATIENCE = 120.0  # s, for everything that starts; the first time kernels are compiled
REFRESH = 0.25  # s
LINE_NS = 500_000_000  # simulated time between two lines, where there is no terminal
QUIET = 0.5  # s without a message that let the recorder catch up

progress = Console(stderr=True)
output = Console()


class DemoError(BearingTwinError):
    """A part of the demonstration failed."""


def main(args: list[str] | None = None) -> int:
    """Runs the demonstration; exit code 0, or 1 when samples were lost. Raises BearingTwinError when a part fails."""
    parser = argparse.ArgumentParser(prog="demo", description="Simulate, publish, record and replay a bearing.")
    parser.add_argument("--scene", default="bearing_6203", help="scene to run (default: %(default)s)")
    parser.add_argument("--duration", type=float, default=5.0, help="simulated time [s] (default: %(default)s)")
    parser.add_argument("--out", default="demo", help="folder for logs and pictures (default: %(default)s)")
    wanted = parser.parse_args(args)
    # A domain of its own, so that nodes of others on this machine are neither seen nor disturbed.
    os.environ.setdefault("ROS_DOMAIN_ID", str(10 + os.getpid() % 90))
    scene = load_scene(wanted.scene)
    folder = Path(wanted.out) / time.strftime("%Y%m%d_%H%M%S")
    folder.mkdir(parents=True)
    recording = folder / "recording.mcap"
    rclpy.init()
    try:
        live = _simulate(scene, wanted, folder, recording)
        replayed = _replay(scene, folder, recording)
    except (KeyboardInterrupt, ExternalShutdownException):
        return 130
    finally:
        rclpy.try_shutdown()
    return _show_results(scene, wanted.duration, folder, recording, live, replayed)


def _simulate(scene: Scene, wanted: argparse.Namespace, folder: Path, recording: Path) -> Watch:
    parameters = {"scene": wanted.scene, "duration": wanted.duration, "start_paused": True}
    with (
        _watching(scene) as (watcher, executor),
        _child("recorder_node", folder, {"log": recording}) as recorder,
        _child("sim_node", folder, parameters) as simulation,
    ):
        pause = watcher.create_client(SetBool, "/bearing/sim_node/pause")
        names = [topic.full_name for topic in topics(scene)]

        def ready() -> bool:
            heard = all(watcher.count_subscribers(name) >= 1 for name in names)
            return heard and watcher.count_subscribers("/bearing/samples") == 2 and pause.service_is_ready()

        _wait(executor, ready, "sim_node and recorder_node start", (simulation, recorder))
        answer = pause.call_async(SetBool.Request(data=False))
        _wait(executor, answer.done, "the kernels of the scene are compiled (once)", (simulation, recorder))
        if not answer.result().success:
            raise DemoError(f"sim_node did not start: {answer.result().message}")
        progress.print(f"{scene.name} runs in real time for {wanted.duration:g} s:")
        with _live_table(watcher.watch) as show:
            _spin(executor, lambda: simulation.poll() is not None, show, 10.0 * wanted.duration + PATIENCE)
        _finish(simulation, folder)
        _stop(recorder, folder)
        return watcher.watch


def _replay(scene: Scene, folder: Path, recording: Path) -> Watch:
    progress.print(f"replay_node plays {recording} at {REPLAY_RATE:g} times the pace")
    parameters = {"log": recording, "rate": REPLAY_RATE}
    with _watching(scene) as (watcher, executor), _child("replay_node", folder, parameters) as replay:
        _wait(executor, lambda: replay.poll() is not None, "replay", ())
        _finish(replay, folder)
        return watcher.watch


@contextlib.contextmanager
def _watching(scene: Scene) -> Iterator[tuple[Watcher, SingleThreadedExecutor]]:
    watcher, executor = Watcher(scene), SingleThreadedExecutor()
    executor.add_node(watcher)
    try:
        yield watcher, executor
    finally:
        executor.shutdown()
        watcher.destroy_node()


@contextlib.contextmanager
def _child(name: str, folder: Path, parameters: dict) -> Iterator[subprocess.Popen]:
    """A node as a process, its output in `<name>.txt`; whatever happens here, it ends with the block."""
    words = [f"{key}:={str(value).lower() if isinstance(value, bool) else value}" for key, value in parameters.items()]
    command = [sys.executable, "-m", "bearing_twin.nodes.entry", name, "--ros-args"]
    with (folder / f"{name}.txt").open("wb") as said:
        process = subprocess.Popen(
            [*command, *(part for word in words for part in ("-p", word))], stdout=said, stderr=said
        )
        process.name = name
        try:
            yield process
        finally:
            for number in (signal.SIGINT, signal.SIGKILL):
                if process.poll() is None:
                    process.send_signal(number)
                    with contextlib.suppress(subprocess.TimeoutExpired):
                        process.wait(10.0)


def _wait(executor, done: Callable[[], bool], what: str, processes) -> None:
    """Spins until `done()`, with the seconds shown; raises DemoError when a process ends first or time is up."""
    started = time.monotonic()
    with progress.status(what) as status:

        def show() -> None:
            status.update(f"{what}: {time.monotonic() - started:.0f} s")
            for process in processes:
                if process.poll() is not None:
                    raise DemoError(f"{process.name} ended early, with exit code {process.returncode}")

        _spin(executor, done, show, PATIENCE)
    progress.print(f"{what}: {time.monotonic() - started:.1f} s")


def _spin(executor, done: Callable[[], bool], show: Callable[[], None], patience: float) -> None:
    started = shown = time.monotonic()
    while not done():
        executor.spin_once(timeout_sec=0.05)
        if not rclpy.ok():
            raise KeyboardInterrupt
        now = time.monotonic()
        if now - shown > REFRESH:
            shown = now
            show()
        if now - started > patience:
            raise DemoError(f"nothing more happened within {patience:.0f} s")
    quiet_since = time.monotonic()
    while time.monotonic() - quiet_since < QUIET:
        executor.spin_once(timeout_sec=0.05)


@contextlib.contextmanager
def _live_table(watch: Watch) -> Iterator[Callable[[], None]]:
    """A function that shows the wrenches as they are: a table that stays in place, lines where there is no terminal."""
    if not output.is_terminal:
        yield _lines(watch)
        return
    with Live(ball_table(watch), console=output, auto_refresh=False) as live:
        yield lambda: live.update(ball_table(watch), refresh=True)


def _lines(watch: Watch) -> Callable[[], None]:
    printed_ns = 0

    def show() -> None:
        nonlocal printed_ns
        if watch.time_ns - printed_ns >= LINE_NS:
            printed_ns = watch.time_ns
            output.print(load_line(watch), soft_wrap=True)

    return show


def _finish(process: subprocess.Popen, folder: Path) -> None:
    if process.wait(30.0) != 0:
        said = (folder / f"{process.name}.txt").read_text(errors="replace")
        raise DemoError(f"{process.name} ended with exit code {process.returncode}:\n{said}")


def _stop(process: subprocess.Popen, folder: Path) -> None:
    process.send_signal(signal.SIGINT)
    _finish(process, folder)


def _show_results(scene: Scene, duration: float, folder: Path, recording: Path, live: Watch, replayed: Watch) -> int:
    log = read_log(recording, allow_gaps=True)
    recorded = sum(len(block) for block in log.blocks())
    expected = int(1e9 * duration) // round(1e9 / scene.parameters.run.output_rate) + 1
    lost = {
        "live": expected - live.sequences.received,
        "recorded": expected - recorded,
        "replayed": expected - replayed.sequences.received,
    }
    picture = plot(log, folder / "ball_loads.png")
    table = Table(title=f"{scene.name}: {duration:g} s, {expected} solver outputs", padding=0)
    for heading in (
        "ball", "greatest load\n[N]\ninner  outer", "contact angle\n[deg]\ninner  outer", "ellipse\ninner\na x b [um]",
        "ellipse\nouter\na x b [um]", "\nwren-\nches", "\nrate\n[Hz]", "sam-\nples\nlost",
    ):  # fmt: skip
        table.add_column(escape(heading), justify="right", no_wrap=True)
    for row in live.rows():
        table.add_row(*row, str(max(lost.values())))
    output.print(table)
    output.print(f"samples lost: {', '.join(f'{count} {where}' for where, count in lost.items())}", soft_wrap=True)
    output.print(f"messages: {live.messages} live, {replayed.messages} replayed", soft_wrap=True)
    output.print(f"log:     {recording.resolve()}", soft_wrap=True)
    output.print(f"picture: {Path(picture).resolve()}", soft_wrap=True)
    if any(lost.values()):
        progress.print(f"Samples were lost; what the nodes said is in {folder}.")
        return 1
    return 0
