"""The demonstration behind `make demo`: simulate in real time, record, watch, replay, and show what came of it.

Three nodes run as processes of their own, as with `ros2 run`; this process is the subscriber. It ends with a page for
the browser, made of the recording.
"""

import argparse
import contextlib
import math
import os
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table
from std_srvs.srv import SetBool

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos
from bearing_twin.log.cdr import DIAGNOSTICS
from bearing_twin.log.run_log import read_log
from bearing_twin.log.sample_block import sample_range
from bearing_twin.log.stream import topics
from bearing_twin.nodes.entry import NodeProcess, node_command, started
from bearing_twin.nodes.messages import interface, qos_profile, rclpy
from bearing_twin.nodes.recording import DEPTH, Sequences
from bearing_twin.run.report import plot
from bearing_twin.run.scene import Scene, load_scene
from bearing_twin.view.logs import document_of_log
from bearing_twin.view.page import write_page

RATE_WINDOW = 100  # messages
ROOM = 7  # columns of a number in the live table


class Received:
    """What has been received so far; arrays have one row a ball."""

    def __init__(self, balls: int):
        self.force = np.zeros((balls, 3))
        self.torque = np.zeros((balls, 3))
        self.count = np.zeros(balls, dtype=np.int64)
        self.seen = [deque(maxlen=RATE_WINDOW) for _ in range(balls)]
        self.greatest = np.zeros((balls, 2))
        self.ellipse_load = np.zeros((balls, 2))
        self.contact_angle = np.zeros((balls, 2))
        self.semi_major = np.zeros((balls, 2))
        self.semi_minor = np.zeros((balls, 2))
        self.sequences = Sequences()
        self.messages = 0
        self.time_ns = 0
        self.model: dict[str, str] = {}

    def wrench(self, ball: int, message) -> None:
        """Takes a WrenchStamped of one ball."""
        force, torque = message.wrench.force, message.wrench.torque
        self.force[ball] = force.x, force.y, force.z
        self.torque[ball] = torque.x, torque.y, torque.z
        self.time_ns = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        self.seen[ball].append(time.monotonic())
        self.count[ball] += 1
        self.messages += 1

    def contacts(self, message) -> None:
        """Takes a Contacts message; angle and ellipse of balls and raceways are kept where the load was greatest."""
        rows = 2 * len(self.count)
        load = np.reshape(message.normal_load[:rows], (-1, 2))
        higher = load > self.ellipse_load
        for mine, theirs in (
            (self.ellipse_load, message.normal_load),
            (self.contact_angle, message.contact_angle),
            (self.semi_major, message.semi_major),
            (self.semi_minor, message.semi_minor),
        ):
            mine[higher] = np.reshape(theirs[:rows], (-1, 2))[higher]
        self.model["law"] = message.law
        self.messages += 1

    def samples(self, data: bytes) -> None:
        """Takes a SampleBlock as bytes: counts its outputs and keeps the greatest load among all of them."""
        self.sequences.saw(*sample_range(data))
        block = cdr.deserialise(cdr.SAMPLE_BLOCK, data)
        edges = np.cumsum([0, *block.channel_width])
        place = block.channel_name.index("normal_load")
        load = block.values.reshape(block.count, -1)[:, edges[place] : edges[place + 1]]
        self.greatest = np.maximum(self.greatest, load.max(axis=0).reshape(-1, 2))
        self.messages += 1

    def rate(self) -> np.ndarray:
        """Wrenches received per second of wall time, for each ball, over the last RATE_WINDOW of them."""
        return np.array([(len(seen) - 1) / (seen[-1] - seen[0]) if len(seen) > 1 else 0.0 for seen in self.seen])

    def rows(self) -> Iterator[tuple[str, ...]]:
        """One row of text a ball: greatest loads, contact angles, ellipses, wrenches received and their rate."""
        for ball, (count, rate) in enumerate(zip(self.count, self.rate(), strict=True)):
            loads = "  ".join(_short(load, 2) for load in self.greatest[ball])
            angles = "  ".join(f"{math.degrees(angle):+.1f}" for angle in self.contact_angle[ball])
            axes = zip(self.semi_major[ball] * 1e6, self.semi_minor[ball] * 1e6, strict=True)
            ellipses = (f"{_short(major, 1)} x {_short(minor, 1)}" for major, minor in axes)
            yield str(ball), loads, angles, *ellipses, str(count), f"{rate:.1f}"


def _short(value: float, decimals: int) -> str:
    """A number with so many decimals, one less from 100 on."""
    return f"{value:.{decimals - (abs(value) >= 100.0)}f}"


class Watcher(Node):
    """Subscribes to the wrenches of all balls, to contacts and to samples of a scene, and keeps a Watch of them."""

    def __init__(self, scene: Scene, **options):
        super().__init__("watcher", **options)
        balls = scene.parameters.geometry.balls
        self.watch = Received(balls)
        namespace = KINDS[scene.kind].namespace
        qos = qos_profile(Qos(DEPTH))
        for ball in range(balls):
            name = f"{namespace}/ball_{ball}/wrench"
            self.create_subscription(interface(cdr.WRENCH, "msg"), name, partial(self.watch.wrench, ball), qos)
        self.create_subscription(interface(cdr.CONTACTS, "msg"), f"{namespace}/contacts", self.watch.contacts, qos)
        samples = interface(cdr.SAMPLE_BLOCK, "msg")
        self.create_subscription(samples, f"{namespace}/samples", self.watch.samples, qos, raw=True)


def ball_table(watch: Received) -> Table:
    """The wrench of each ball as it was last received, and the rate it comes at."""
    table = Table(title=f"t = {watch.time_ns * 1e-9:.2f} s, net wrench on each ball in bearing_link", padding=0)
    forces, torques = ("Fx", "Fy", "Fz", "|F|"), ("Tx", "Ty", "Tz")
    for heading in ("ball", *(f"{one}\n[N]" for one in forces), *(f"{one}\n[N mm]" for one in torques), "rate\n[Hz]"):
        table.add_column(escape(heading), justify="right", no_wrap=True)
    for ball, (force, torque, rate) in enumerate(zip(watch.force, watch.torque, watch.rate(), strict=True)):
        newtons = (_signed(value, 3) for value in (*force, np.linalg.norm(force)))
        table.add_row(str(ball), *newtons, *(_signed(1e3 * value, 4) for value in torque), f"{rate:.1f}")
    return table


def _signed(value: float, decimals: int) -> str:
    """A number with its sign and so many decimals at most, as many as its column has room for."""
    told = (f"{value:+.{places}f}" for places in range(decimals, -1, -1))
    return next((one for one in told if len(one) <= ROOM), f"{value:+.1e}")


def load_line(watch: Received) -> str:
    """The same in one line: time, the size of each ball's force, both raceways together, and the mean rate."""
    sizes = " ".join(f"{size:7.3f}" for size in np.linalg.norm(watch.force, axis=1))
    return f"t = {watch.time_ns * 1e-9:5.2f} s  net |F| on balls [N]: {sizes}  at {watch.rate().mean():5.1f} Hz"


REPLAY_RATE = 2.0
DISCOVERY = 600.0  # s at most; it ends when every topic has its subscriber
REFRESH = 0.25  # s
LINE_PERIOD = 5.0  # s between two lines about a wait, where there is no terminal
LINE_NS = 500_000_000  # simulated time between two lines, where there is no terminal
QUIET = 0.5  # s without a message that let the recorder catch up

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
    "The arrows are the loads on the balls, the spots their contact ellipses, coloured by pressure.",
    "Click a ball to see its contacts; click a curve to go to that time, drag across it to look closer.",
)
"""Three sentences on what to look at, of some scenes their own."""

progress = Console(stderr=True)
output = Console()


class DemoError(BearingTwinError):
    """A part of the demonstration failed."""


def main(args: list[str] | None = None) -> int:
    """Runs the demonstration; exit code 0, or 1 when samples were lost. Raises BearingTwinError when a part fails."""
    parser = argparse.ArgumentParser(prog="demo", description="Simulate, publish, record and replay a bearing.")
    parser.add_argument("--scene", default=SCENE, help="scene to run (default: %(default)s)")
    parser.add_argument("--duration", type=float, default=DURATION, help="simulated time [s] (default: %(default)s)")
    parser.add_argument("--out", default="demo", help="folder for logs and pictures (default: %(default)s)")
    wanted = parser.parse_args(args)
    _keep_to_itself()
    # As nodes run it: the topics of a second run would have no publisher.
    scene = load_scene(wanted.scene, ["solver.check=none"])
    if scene.kind != "bearing":
        raise DemoError(f"scene {scene.name} is no bearing but of kind {scene.kind}: give the name of a bearing scene")
    folder = _own_folder(Path(wanted.out))
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


def _own_folder(parent: Path) -> Path:
    """A new folder named by date and time, with a number where another demonstration has begun in the same second."""
    parent.mkdir(parents=True, exist_ok=True)
    name = time.strftime("%Y%m%d_%H%M%S")
    folder, number = parent / name, 1
    while True:
        try:
            folder.mkdir()
            return folder
        except FileExistsError:
            number += 1
            folder = parent / f"{name}_{number}"


def _keep_to_itself() -> None:
    """A domain on this machine that is not the user's, so that nodes of others are neither seen nor disturbed."""
    taken = os.environ.get("ROS_DOMAIN_ID", "0")
    own = 10 + os.getpid() % 90
    os.environ["ROS_DOMAIN_ID"] = str(own if str(own) != taken else own + 1)
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"


def _simulate(scene: Scene, wanted: argparse.Namespace, folder: Path, recording: Path) -> Received:
    names = [topic.full_name for topic in topics(scene)]
    parameters = {"scene": wanted.scene, "duration": wanted.duration, "start_paused": True}
    progress.print(f"sim_node and recorder_node start; what they say goes to {folder}", soft_wrap=True)
    with (
        _watching(scene) as (watcher, executor),
        started(
            "recorder_node", node_command("recorder_node", {"log": recording, "topics": names, "full": True}), folder
        ) as recorder,
        started("sim_node", node_command("sim_node", parameters), folder) as simulation,
    ):
        nodes = (simulation, recorder)
        _listen(watcher, nodes)
        pause = watcher.create_client(SetBool, "/bearing/sim_node/pause")

        def found() -> bool:
            # Publisher and subscriber learn of each other one after the other, and what is sent in between may be lost.
            subscribers = int(simulation.values.get("least_subscribers", 0))  # one here, one in recorder_node
            publishers = int(recorder.values.get("least_publishers", 0))
            return subscribers >= 2 and publishers >= 1 and _knows_publishers(watcher) and pause.service_is_ready()

        compiled = lambda: simulation.status not in ("starting", "compiling")  # noqa: E731
        _wait(executor, compiled, lambda: f"sim_node is {simulation.status}", "the scene is ready", nodes)
        _wait(executor, found, lambda: "discovery of all topics", "all topics are found", nodes)
        answer = pause.call_async(SetBool.Request(data=False))
        _wait(
            executor,
            lambda: answer.done() or watcher.watch.messages > 0,
            lambda: "the start of time",
            "time runs",
            nodes,
        )
        if answer.done() and not answer.result().success:
            raise DemoError(f"sim_node did not start: {answer.result().message}; what it said is in {simulation.said}")
        progress.print(f"{scene.name} runs in real time for {wanted.duration:g} s:")
        with _live_table(watcher.watch) as show:
            _spin(executor, lambda: simulation.ended, show, nodes, may_end=(simulation,))
        simulation.look(time.monotonic(), may_end=True)
        recorder.interrupt()
        what = lambda: "recorder_node completes its log"  # noqa: E731
        _wait(executor, lambda: recorder.ended, what, "the recording is complete", (recorder,), may_end=(recorder,))
        recorder.look(time.monotonic(), may_end=True)
        return watcher.watch


def _replay(scene: Scene, folder: Path, recording: Path) -> Received:
    progress.print(f"replay_node plays {recording} at {REPLAY_RATE:g} times the pace", soft_wrap=True)
    parameters = {"log": recording, "rate": REPLAY_RATE, "discovery": DISCOVERY, "start_paused": True}
    command = node_command("replay_node", parameters)
    with _watching(scene) as (watcher, executor), started("replay_node", command, folder) as replay:
        _listen(watcher, (replay,))
        pause = watcher.create_client(SetBool, "/replay_node/pause")
        found = lambda: _knows_publishers(watcher) and pause.service_is_ready()  # noqa: E731
        _wait(executor, found, lambda: "discovery of all topics", "all topics are found", (replay,))
        pause.call_async(SetBool.Request(data=False))  # carried out when replay_node has found its subscribers
        what = lambda: f"replay_node is {replay.status}, {watcher.watch.messages} messages"  # noqa: E731
        _wait(executor, lambda: replay.ended, what, "the replay is over", (replay,), may_end=(replay,))
        replay.look(time.monotonic(), may_end=True)
        return watcher.watch


@contextlib.contextmanager
def _watching(scene: Scene) -> Iterator[tuple[Watcher, SingleThreadedExecutor]]:
    watcher, executor = Watcher(scene), SingleThreadedExecutor()
    heard = {subscription.topic_name for subscription in watcher.subscriptions}
    for topic in topics(scene):  # all of them, so that a publisher can tell from its own count when nobody is missing
        if topic.full_name not in heard:
            kind, qos = interface(topic.ros_type, "msg"), qos_profile(topic.qos)
            watcher.create_subscription(kind, topic.full_name, lambda data: None, qos, raw=True)
    executor.add_node(watcher)
    try:
        yield watcher, executor
    finally:
        executor.shutdown()
        watcher.destroy_node()


def _knows_publishers(watcher: Watcher) -> bool:
    return all(subscription.get_publisher_count() for subscription in watcher.subscriptions)


def _listen(watcher: Watcher, nodes: Sequence[NodeProcess]) -> None:
    """Hands the heartbeats of these nodes to them; the name of a status begins with the node's."""
    by_name = {node.name: node for node in nodes}

    def take(array) -> None:
        for status in array.status:
            node = by_name.get(status.name.partition(":")[0].rpartition("/")[2])
            if node is not None:
                node.heard(status.message, {pair.key: pair.value for pair in status.values})

    watcher.create_subscription(interface(DIAGNOSTICS, "msg"), "/diagnostics", take, 10)


def _wait(executor, done: Callable[[], bool], what: Callable[[], str], end: str, nodes, may_end=()) -> None:
    """Spins until `done()`, shows `what()` meanwhile and `end` then; raises ProcessError for a node that fails."""
    began = said = time.monotonic()
    with progress.status(what()) as status:

        def show() -> None:
            nonlocal said
            now = time.monotonic()
            status.update(f"{what()}: {now - began:.0f} s")
            if not progress.is_terminal and now - said > LINE_PERIOD:
                said = now
                progress.print(f"{what()}: {now - began:.0f} s so far", soft_wrap=True)

        _spin(executor, done, show, nodes, may_end)
    progress.print(f"{end} after {time.monotonic() - began:.1f} s", soft_wrap=True)


def _spin(executor, done: Callable[[], bool], show: Callable[[], None], nodes, may_end=()) -> None:
    shown = time.monotonic()
    while not done():
        executor.spin_once(timeout_sec=0.05)
        if not rclpy.ok():
            raise KeyboardInterrupt
        now = time.monotonic()
        for node in nodes:
            node.look(now, node in may_end)
        if now - shown > REFRESH:
            shown = now
            show()
    quiet_since = time.monotonic()
    while time.monotonic() - quiet_since < QUIET:
        executor.spin_once(timeout_sec=0.05)


@contextlib.contextmanager
def _live_table(watch: Received) -> Iterator[Callable[[], None]]:
    """A function that shows the wrenches as they are: a table that stays in place, lines where there is no terminal."""
    if not output.is_terminal:
        yield _lines(watch)
        return
    with Live(ball_table(watch), console=output, auto_refresh=False) as live:
        yield lambda: live.update(ball_table(watch), refresh=True)


def _lines(watch: Received) -> Callable[[], None]:
    printed_ns = 0

    def show() -> None:
        nonlocal printed_ns
        if watch.time_ns - printed_ns >= LINE_NS:
            printed_ns = watch.time_ns
            output.print(load_line(watch), soft_wrap=True)

    return show


def result_table(title: str, live: Received, lost: int) -> Table:
    """What was received of each ball, and how many samples were `lost`, for a terminal of 80 columns."""
    table = Table(title=title, padding=0)
    for heading in (
        "ball", "greatest load\n[N]\ninner  outer", "contact angle\n[°]\ninner  outer", "ellipse\ninner\na x b [µm]",
        "ellipse\nouter\na x b [µm]", "\nwren-\nches", "\nrate\n[Hz]", "sam-\nples\nlost",
    ):  # fmt: skip
        table.add_column(escape(heading), justify="right", no_wrap=True)
    for row in live.rows():
        table.add_row(*row, str(lost))
    return table


def _show_results(
    scene: Scene, duration: float, folder: Path, recording: Path, live: Received, replayed: Received
) -> int:
    progress.print("the log is read and drawn")
    log = read_log(recording, allow_gaps=True)
    recorded = sum(len(block) for block in log.blocks())
    expected = int(1e9 * duration) // round(1e9 / scene.parameters.run.output_rate) + 1
    lost = {
        "live": expected - live.sequences.received,
        "recorded": expected - recorded,
        "replayed": expected - replayed.sequences.received,
    }
    picture = plot(log, folder / "ball_loads.png")
    page = write_page(document_of_log(recording), folder / "view.html")
    output.print(result_table(f"{scene.name}: {duration:g} s, {expected} solver outputs", live, max(lost.values())))
    output.print("loads are the greatest of all outputs, angles and ellipses of messages on contacts", soft_wrap=True)
    output.print(f"samples lost: {', '.join(f'{count} {where}' for where, count in lost.items())}", soft_wrap=True)
    output.print(f"messages: {live.messages} live, {replayed.messages} replayed", soft_wrap=True)
    output.print(f"log:     {recording.resolve()}", soft_wrap=True)
    output.print(f"picture: {Path(picture).resolve()}", soft_wrap=True)
    output.print(f"browser: {page.resolve()}", soft_wrap=True)
    for sentence in STORY.get(scene.name, GENERAL):
        output.print(f"  {sentence}", soft_wrap=True, highlight=False)
    if any(lost.values()):
        progress.print(f"Samples were lost; what the nodes said is in {folder}.")
        return 1
    return 0
