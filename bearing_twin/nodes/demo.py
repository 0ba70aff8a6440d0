"""The demonstration behind `make demo`: simulate in real time, record, watch, replay, and show the results.

Three nodes run as processes of their own, as with `ros2 run`; this process is the subscriber. It ends with a page for
the browser, made of the recording.
"""

import argparse
import contextlib
import math
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rich.console import Console
from rich.table import Table
from std_srvs.srv import SetBool

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import sample_range, topics
from bearing_twin.nodes.entry import node_command, started
from bearing_twin.nodes.messages import interface, qos_profile, rclpy
from bearing_twin.nodes.recorder_node import DEPTH, Sequences
from bearing_twin.run.report import plot
from bearing_twin.run.scene import Scene, load_scene
from bearing_twin.view.page import write_page
from bearing_twin.view.run_page import document_of_log

REPLAY_RATE = 2.0
DISCOVERY = 600.0  # s at most; it ends when every topic has its subscriber
REFRESH = 0.25  # s between updates of what is shown
LINE_PERIOD = 5.0  # s between lines about a wait where there is no terminal
LINE = 0.25  # s of simulated time between lines
QUIET = 0.5  # s for the last messages to come

SCENE, DURATION = "bearing_6203_load_and_speed", 2.0
STORY = {
    SCENE: (
        "Press play: the balls below carry the load, those on top leave the inner ring; gaps are drawn larger.",
        "At 0.4 s the load steps from 300 N to 1000 N: the arrows grow, and the inner ring sinks by a further 9 µm.",
        "From 1 s to 1.4 s the shaft runs up and the load comes round faster; click a ball to see its contacts.",
    )
}
GENERAL = (
    "Press play: balls roll and cage and ring move, displacements drawn larger; drag the picture to turn it.",
    "The arrows are the loads on the balls, the ellipses their contacts, coloured by pressure.",
    "Click a ball to see its contacts; click a curve to go to that time, drag across it to look closer.",
)
"""Three sentences on what to look at; some scenes have their own."""

progress = Console(stderr=True)
output = Console()


class DemoError(BearingTwinError):
    """A part of the demonstration failed."""


class Stage(Node):
    """Nodes as processes, and the subscriber of all topics of a scene and of /diagnostics; ends with a `with` body.

    It keeps the last message of each topic, and counts them.
    """

    def __init__(self, scene: Scene, folder: Path, **nodes: dict):
        super().__init__("watcher")
        place = KINDS[scene.kind].namespace
        self.wrenches = [f"{place}/ball_{ball}/wrench" for ball in range(scene.parameters.geometry.balls)]
        self.last, self.count, self.sequences, self._began = {}, Counter(), Sequences(), math.inf
        for topic in topics(scene):  # all, so that publishers can count this subscriber
            take, quality = partial(self._on_message, topic.full_name), qos_profile(topic.qos._replace(depth=DEPTH))
            self.create_subscription(interface(topic.ros_type, "msg"), topic.full_name, take, quality, raw=True)
        self.create_subscription(interface(cdr.DIAGNOSTICS, "msg"), "/diagnostics", self._on_diagnostics, 10)
        self._spinner = SingleThreadedExecutor()
        self._spinner.add_node(self)
        with contextlib.ExitStack() as stack:  # which ends the nodes that run where another one cannot be started
            self.processes = {
                name: stack.enter_context(started(name, node_command(name, parameters), folder))
                for name, parameters in nodes.items()
            }
            self._stack = stack.pop_all()

    def __enter__(self) -> "Stage":
        return self

    def __exit__(self, *error) -> None:
        self._stack.close()
        self._spinner.shutdown()
        self.destroy_node()

    def _on_message(self, name: str, data: bytes) -> None:
        self._began = min(self._began, time.monotonic())
        self.last[name] = data
        self.count[name] += 1
        if name.endswith("/samples"):
            self.sequences.note(*sample_range(data)[:2])

    def _on_diagnostics(self, array) -> None:
        for status in array.status:
            process = self.processes.get(status.name.partition(":")[0].rpartition("/")[2])
            if process:
                process.status, process.values = status.message, {pair.key: pair.value for pair in status.values}

    def forces(self) -> tuple[float, str]:
        """Simulated time [s] of the last wrenches and a line of their forces; 0 and nothing before the first."""
        if not all(name in self.last for name in self.wrenches):
            return 0.0, ""
        found = [deserialize_message(self.last[name], interface(cdr.WRENCH, "msg")) for name in self.wrenches]
        at = found[0].header.stamp.sec + 1e-9 * found[0].header.stamp.nanosec
        forces = [one.wrench.force for one in found]
        sizes = " ".join(f"{math.hypot(one.x, one.y, one.z):7.3f}" for one in forces)
        rate = self.count[self.wrenches[0]] / (time.monotonic() - self._began)
        return at, f"t = {at:5.2f} s  net |F| on balls [N]: {sizes}  at {rate:5.1f} Hz"

    def knows_publishers(self) -> bool:
        """True where every subscription has a publisher."""
        return all(one.get_publisher_count() for one in self.subscriptions)

    def spin(self, done: Callable[[], bool], show: Callable[[], None], ends: str = "") -> None:
        """Spins until `done()`, and `show()`s meanwhile; raises ProcessError for a node that fails or ends early."""
        shown, quiet_until = time.monotonic(), math.inf
        while (now := time.monotonic()) < quiet_until:
            self._spinner.spin_once(timeout_sec=0.05)
            if not rclpy.ok():
                raise KeyboardInterrupt
            for name, process in self.processes.items():
                process.look(may_end=name == ends)
            if done():
                quiet_until = min(quiet_until, now + QUIET)
            elif now - shown > REFRESH:
                shown = now
                show()

    def wait(self, done: Callable[[], bool], what: str, end: str, ends: str = "") -> None:
        """Spins until `done()`, with a line about `what` is waited for and about the `end`."""
        began = said = time.monotonic()
        with progress.status(what) as status:

            def show() -> None:
                nonlocal said
                now, doing = time.monotonic(), (f"{name}: {one.status}" for name, one in self.processes.items())
                text = f"{what} ({', '.join(doing)}): {now - began:.0f} s"
                status.update(text)
                if not progress.is_terminal and now - said > LINE_PERIOD:
                    said = now
                    progress.print(text, soft_wrap=True)

            self.spin(done, show, ends)
        progress.print(f"{end} after {time.monotonic() - began:.1f} s", soft_wrap=True)

    def unpause(self, service: str):
        """Lets time run; the future of the answer."""
        client = self.create_client(SetBool, service)
        self.wait(client.service_is_ready, "discovery of a service", "the service is found")
        return client.call_async(SetBool.Request(data=False))


def main(args: list[str] | None = None) -> int:
    """Runs the demonstration; exit code 0, or 1 when samples were lost. Raises BearingTwinError when a part fails."""
    parser = argparse.ArgumentParser(prog="demo", description="Simulate, publish, record and replay a bearing.")
    parser.add_argument("--scene", default=SCENE, help="scene to run (default: %(default)s)")
    parser.add_argument("--duration", type=float, default=DURATION, help="simulated time [s] (default: %(default)s)")
    parser.add_argument("--out", default="demo", help="folder for logs and pictures (default: %(default)s)")
    given = parser.parse_args(args)
    _keep_to_itself()
    scene = load_scene(given.scene, ["solver.check=none"])  # as nodes run it: without topics of a second run
    if scene.kind != "bearing":
        raise DemoError(f"scene {scene.name} is no bearing but of kind {scene.kind}: give the name of a bearing scene")
    parent = Path(given.out)
    parent.mkdir(parents=True, exist_ok=True)
    # A new folder named by date and time, which no other demonstration has.
    folder = Path(tempfile.mkdtemp(prefix=time.strftime("%Y%m%d_%H%M%S_"), dir=parent))
    rclpy.init()
    try:
        live = _simulate(scene, given, folder)
        replayed = _replay(scene, folder)
    except (KeyboardInterrupt, ExternalShutdownException):
        return 130
    finally:
        rclpy.try_shutdown()
    return _show_results(scene, given.duration, folder, live, replayed)


def _keep_to_itself() -> None:
    """A domain on this machine that is not the user's, so that nodes of others are neither seen nor disturbed."""
    taken = os.environ.get("ROS_DOMAIN_ID", "0")
    own = 10 + os.getpid() % 90
    os.environ["ROS_DOMAIN_ID"] = str(own if str(own) != taken else own + 1)
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"


def _simulate(scene: Scene, given: argparse.Namespace, folder: Path) -> Stage:
    recorded = {"log": folder / "recording.mcap", "topics": [topic.full_name for topic in topics(scene)]}
    simulated = {"scene": given.scene, "duration": given.duration, "start_paused": True}
    progress.print(f"sim_node and recorder_node start; their output goes to {folder}", soft_wrap=True)
    with Stage(scene, folder, recorder_node=recorded, sim_node=simulated) as stage:
        simulation, recorder, printed = stage.processes["sim_node"], stage.processes["recorder_node"], 0.0

        def found() -> bool:
            # Publisher and subscriber learn of each other one after the other, and what is sent in between may be lost.
            subscribers = int(simulation.values.get("least_subscribers", 0))  # one here, one in recorder_node
            publishers = int(recorder.values.get("least_publishers", 0))
            return subscribers >= 2 and publishers >= 1 and stage.knows_publishers()

        def show() -> None:
            nonlocal printed
            at, line = stage.forces()
            if at - printed >= LINE:
                printed = at
                output.print(line, soft_wrap=True)

        stage.wait(found, "discovery of all topics", "all topics are found")
        answer = stage.unpause("/bearing/sim_node/pause")
        stage.wait(lambda: answer.done() or stage.last, "the start of time", "time runs")
        if answer.done() and not answer.result().success:
            raise DemoError(f"sim_node did not start: {answer.result().message}; its output is in {simulation.said}")
        progress.print(f"{scene.name} runs in real time for {given.duration:g} s:")
        stage.spin(lambda: simulation.ended, show, ends="sim_node")
        del stage.processes["sim_node"]
        recorder.interrupt()
        stage.wait(lambda: recorder.ended, "completing the log", "the recording is complete", ends="recorder_node")
        return stage


def _replay(scene: Scene, folder: Path) -> Stage:
    recording = folder / "recording.mcap"
    progress.print(f"replay_node plays {recording} at {REPLAY_RATE:g} times the pace", soft_wrap=True)
    played = {"log": recording, "rate": REPLAY_RATE, "discovery": DISCOVERY, "start_paused": True}
    with Stage(scene, folder, replay_node=played) as stage:
        stage.wait(stage.knows_publishers, "discovery of all topics", "all topics are found")
        stage.unpause("/replay_node/pause")  # carried out when replay_node has found its subscribers
        ended = lambda: stage.processes["replay_node"].ended  # noqa: E731
        stage.wait(ended, "replay", "the replay is over", ends="replay_node")
        return stage


def _show_results(scene: Scene, duration: float, folder: Path, live: Stage, replayed: Stage) -> int:
    progress.print("reading the log")
    recording = folder / "recording.mcap"
    log = read_log(recording, allow_gaps=True)
    blocks = list(log.blocks())
    expected = int(1e9 * duration) // round(1e9 / scene.parameters.run.output_rate) + 1
    lost = {
        "live": expected - live.sequences.received,
        "recorded": expected - sum(map(len, blocks)),
        "replayed": expected - replayed.sequences.received,
    }
    picture = plot(log, folder / "ball_loads.png")
    page = write_page(document_of_log(recording), folder / "view.html")
    greatest = np.max([block.values["normal_load"].max(axis=0) for block in blocks], axis=0)
    table = Table(title=f"{scene.name}: {duration:g} s, {expected} solver outputs", padding=0)
    for heading in ("ball", "greatest load\n\\[N]\ninner  outer", "wrenches", "samples\nlost"):
        table.add_column(heading, justify="right", no_wrap=True)
    for ball, (loads, name) in enumerate(zip(greatest, live.wrenches, strict=True)):
        shown = "  ".join(f"{load:.1f}" for load in loads)
        table.add_row(str(ball), shown, str(live.count[name]), str(max(lost.values())))
    output.print(table)
    for line in (
        f"samples lost: {', '.join(f'{count} {where}' for where, count in lost.items())}",
        f"messages: {live.count.total()} live, {replayed.count.total()} replayed",
        f"log:     {recording.resolve()}",
        f"picture: {Path(picture).resolve()}",
        f"browser: {page.resolve()}",
        *(f"  {sentence}" for sentence in STORY.get(scene.name, GENERAL)),
    ):
        output.print(line, soft_wrap=True, highlight=False)
    if any(lost.values()):
        progress.print(f"Samples were lost; the output of the nodes is in {folder}.")
    return int(any(lost.values()))
