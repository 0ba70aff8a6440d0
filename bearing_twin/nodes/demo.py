"""The demonstration behind `make demo`: simulate in real time, record, watch, replay, and show the results.

The nodes run as processes of their own, as with `ros2 run`; this process prints the forces on the balls as they are
published. It ends with a page for the browser, made of the recording.
"""

import argparse
import math
import os
import tempfile
import time
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
from geometry_msgs.msg import WrenchStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rich.console import Console
from rich.table import Table

from bearing_twin.kinds import KINDS
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import topics
from bearing_twin.nodes.entry import node_command, started
from bearing_twin.nodes.messages import rclpy
from bearing_twin.run.report import plot
from bearing_twin.run.scene import Scene, load_scene
from bearing_twin.view.page import write_page
from bearing_twin.view.run_page import log_document

REPLAY_RATE = 2.0
DISCOVERY = 600.0  # s at most; it ends when the recorder subscribes to every topic
LINE = 0.25  # s of simulated time between lines
POLL = 0.05  # s
DEPTH = 100  # messages of a ball that may wait

SCENE, DURATION = "bearing_6203_load_and_speed", 2.0
STORY = (
    "Press play: the balls below carry the load, those on top leave the inner ring; gaps are drawn larger.",
    "At 0.4 s the load steps from 300 N to 1000 N: the arrows grow, and the inner ring sinks by a further 9 µm.",
    "From 1 s to 1.4 s the shaft runs up and the load comes round faster; click a ball to see its contacts.",
)
"""Hints for the page of SCENE."""

progress = Console(stderr=True)
output = Console()


class Watcher(Node):
    """Prints the forces on the balls of a bearing as they are published, after each LINE of simulated time."""

    def __init__(self, scene: Scene):
        super().__init__("watcher")
        self._forces, self._next = [0.0] * scene.parameters.geometry.balls, 0.0
        for ball, name in enumerate(wrenches(scene)):
            self.create_subscription(WrenchStamped, name, partial(self._on_wrench, ball), DEPTH)

    def _on_wrench(self, ball: int, message: WrenchStamped) -> None:
        force, stamp = message.wrench.force, message.header.stamp
        self._forces[ball] = math.hypot(force.x, force.y, force.z)
        time_s = stamp.sec + 1e-9 * stamp.nanosec
        if ball == len(self._forces) - 1 and time_s >= self._next:
            self._next = time_s + LINE
            sizes = " ".join(f"{size:7.3f}" for size in self._forces)
            output.print(f"t = {time_s:5.2f} s  net |F| on balls [N]: {sizes}", soft_wrap=True)


def wrenches(scene: Scene) -> list[str]:
    """The topics of the wrenches on the balls."""
    namespace = KINDS[scene.kind].namespace
    return [f"{namespace}/ball_{ball}/wrench" for ball in range(scene.parameters.geometry.balls)]


def main(args: list[str] | None = None) -> int:
    """Runs the demonstration; exit code 0, or 1 when samples were lost. Raises ProcessError when a part fails."""
    parser = argparse.ArgumentParser(prog="demo", description="Simulate, publish, record and replay a bearing.")
    parser.add_argument("--duration", type=float, default=DURATION, help="simulated time [s] (default: %(default)s)")
    parser.add_argument("--out", default="demo", help="folder for logs and pictures (default: %(default)s)")
    arguments = parser.parse_args(args)
    _keep_to_itself()
    scene = load_scene(SCENE, ["solver.check=none"])  # as nodes run it: without topics of a second run
    parent = Path(arguments.out)
    parent.mkdir(parents=True, exist_ok=True)
    # A new folder named by date and time, which no other demonstration has.
    folder = Path(tempfile.mkdtemp(prefix=time.strftime("%Y%m%d_%H%M%S_"), dir=parent))
    progress.print(f"the nodes' own output goes to {folder}", soft_wrap=True)
    rclpy.init()
    try:
        watcher = Watcher(scene)
        progress.print(f"{scene.name} runs in real time for {arguments.duration:g} s", soft_wrap=True)
        simulated = {"scene": SCENE, "duration": arguments.duration}
        recording = _recorded(scene, folder / "recording.mcap", "sim_node", simulated, watcher)
        progress.print(f"replay_node plays {recording} at {REPLAY_RATE:g} times the pace", soft_wrap=True)
        played = {"log": recording, "rate": REPLAY_RATE}
        replayed = _recorded(scene, folder / "replayed.mcap", "replay_node", played, watcher)
    except (KeyboardInterrupt, ExternalShutdownException):
        return 130
    finally:
        rclpy.try_shutdown()
    return _show_results(scene, arguments.duration, recording, replayed)


def _keep_to_itself() -> None:
    """A domain on this machine that is not the user's, so that nodes of others are neither seen nor disturbed."""
    taken = os.environ.get("ROS_DOMAIN_ID", "0")
    domain = 10 + os.getpid() % 90
    os.environ["ROS_DOMAIN_ID"] = str(domain if str(domain) != taken else domain + 1)
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"


def _recorded(scene: Scene, log: Path, name: str, parameters: dict, watcher: Watcher) -> Path:
    """Runs a node to its end, recorded in `log`; raises ProcessError where it or the recorder fails."""
    recorded = {"log": log, "topics": [topic.full_name for topic in topics(scene)]}
    # A node waits for the recorder, which knows a publisher before it subscribes: nothing is lost at the beginning.
    publishing = node_command(name, parameters | {"discovery": DISCOVERY})
    with (
        started("recorder_node", node_command("recorder_node", recorded), log.parent) as recorder,
        started(name, publishing, log.parent) as node,
        progress.status(f"{name} and recorder_node"),
    ):
        while node.poll() is None:
            rclpy.spin_once(watcher, timeout_sec=POLL)
            recorder.check()
        node.check(may_end=True)
    recorder.check(may_end=True)
    return log


def _show_results(scene: Scene, duration: float, recording: Path, replayed: Path) -> int:
    progress.print("reading the logs")
    expected = int(1e9 * duration) // round(1e9 / scene.parameters.run.output_rate) + 1
    log, again = (read_log(path, allow_gaps=True) for path in (recording, replayed))
    blocks = list(log.blocks())
    lost = {"recorded": expected - sum(map(len, blocks)), "replayed": expected - sum(map(len, again.blocks()))}
    counts = Counter(message.topic.name for message in raw_messages(recording))
    picture = plot(log, recording.with_name("ball_loads.png"))
    page = write_page(log_document(recording), recording.with_name("view.html"))
    greatest = np.max([block.values["normal_load"].max(axis=0) for block in blocks], axis=0)
    table = Table(title=f"{scene.name}: {duration:g} s, {expected} solver outputs", padding=0)
    for heading in ("ball", "greatest load\n\\[N]\ninner  outer", "wrenches", "samples\nlost"):
        table.add_column(heading, justify="right", no_wrap=True)
    for ball, (loads, name) in enumerate(zip(greatest, wrenches(scene), strict=True)):
        shown = "  ".join(f"{load:.1f}" for load in loads)
        table.add_row(str(ball), shown, str(counts[name]), str(max(lost.values())))
    output.print(table)
    for line in (
        f"samples lost: {', '.join(f'{count} {kind}' for kind, count in lost.items())}",
        f"messages: {counts.total()} recorded",
        f"log:     {recording.resolve()}",
        f"picture: {Path(picture).resolve()}",
        f"browser: {page.resolve()}",
        *(f"  {sentence}" for sentence in STORY),
    ):
        output.print(line, soft_wrap=True, highlight=False)
    if any(lost.values()):
        progress.print(f"Samples were lost; the output of the nodes is in {recording.parent}.")
    return int(any(lost.values()))
