"""A subscriber to a bearing's topics that keeps what people look at: wrenches, loads, ellipses, rates, losses."""

import math
import time
from collections import deque
from collections.abc import Iterator
from functools import partial

import numpy as np
from rclpy.node import Node
from rich.markup import escape
from rich.table import Table

from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.bag import Qos
from bearing_twin.log.blocks import sample_range
from bearing_twin.nodes.messages import interface, qos_profile
from bearing_twin.nodes.recording import DEPTH, Sequences
from bearing_twin.run.scene import Scene

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
