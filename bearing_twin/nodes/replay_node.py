"""replay_node: publishes the messages of a log again, byte for byte, at a multiple of the pace they were logged at."""

import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import TimeoutError as StillBusy
from functools import partial
from itertools import islice, takewhile

from std_srvs.srv import SetBool

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.log import cdr
from bearing_twin.log.bag import LogReader, topic_qos
from bearing_twin.log.mcap_write import StoredTopic
from bearing_twin.nodes.base_node import (
    CLOCK_PERIOD,
    BaseNode,
    declare,
    guarded,
)
from bearing_twin.nodes.messages import DIAGNOSTICS_PERIOD, ERROR, OK, SERVICE, WARN
from bearing_twin.nodes.node_parameters import NodeParameter
from bearing_twin.nodes.outlet import Outlet
from bearing_twin.nodes.pacing import LAG_SHOWN, PacedStream, Timed, Worker

# fmt: off
PARAMETERS = (
    NodeParameter("log", "", "MCAP file or bag folder to play"),
    NodeParameter("rate", 1.0, "pace, a multiple of that of the log", "1", 0.001, 1000.0, read_only=False),
    NodeParameter("start", 0.0, "start, from the first message", "s", 0.0, 1e9),
    NodeParameter("loop", False, "start again at the end"),
    NodeParameter("start_paused", False, "wait until ~/pause is called with false"),
    NodeParameter("discovery", 3.0, "longest wait until every topic has a subscriber", "s", 0.0, 600.0),
    NodeParameter("publish_clock", False, "publish the time of the log on /clock"),
)
# fmt: on
GLOBAL = frozenset({"/tf", "/tf_static", "/clock", "/diagnostics", "/rosout", "/parameter_events"})
COMMAND_TIMEOUT = 5.0  # s
BATCH = 200  # messages read ahead
SHORTEST_ROUND_NS = 1_000_000  # of a log that is played again and again: a shorter one would flood who listens


def renamed_topics(names: Collection[str], namespace: str = "") -> dict[str, str]:
    """Names of topics in a `namespace` by their names in a log, the same where it is empty.

    A log of one scene has its namespace replaced, as a node's is; one of several has it put in front. What all scenes
    share, such as /tf, keeps its name.
    """
    homes = {name.rpartition("/")[0] for name in names if name.endswith("/samples")}
    home = homes.pop() + "/" if len(homes) == 1 else "/"
    prefix = namespace.strip("/")
    return {
        name: f"/{prefix}/{name.removeprefix(home).lstrip('/')}" if prefix and name not in GLOBAL else name
        for name in names
    }


def playable_topics(path, reader: LogReader) -> tuple[dict[str, StoredTopic], list[str]]:
    """The topics of a log that can be played, by name, and notes on the log and on those that cannot.

    Subscribers could not read the bytes of a type that has changed its fields, nor those of a second type under a name.
    Raises LogError if there is none.
    """
    topics: dict[str, StoredTopic] = {}
    omitted: list[str] = []
    for topic in reader.topics:
        name, ros_type = topic.name, topic.ros_type
        logged_hash = topic.metadata.get("topic_type_hash", "")
        if topic.foreign or (name in topics and topics[name].ros_type == ros_type):
            continue
        if name in topics:
            omitted.append(
                f"messages of type {ros_type} on {name} are not played, as others have type {topics[name].ros_type}"
            )
        elif cdr.is_known(ros_type) and logged_hash.startswith("RIHS") and logged_hash != cdr.type_hash(ros_type):
            omitted.append(
                f"{name} is not played: {ros_type} has changed its fields since it was logged; play it with the "
                "version of bearing_twin that wrote it"
            )
        else:
            topics[name] = topic
    if not topics:
        none = f"{path} holds no ROS topics: give a log written by bearing_twin or `ros2 bag record -s mcap`"
        raise LogError(omitted[-1] if omitted else none)
    return topics, [*reader.notes, *dict.fromkeys(omitted)]


class ReplayLoop(PacedStream):
    """Delivers the messages of the log at `path` by their log times, from `start_ns` after the first one.

    A replay with a later start begins with the last latched messages before it, as late subscribers receive them.
    Topics of a type that has changed since are not played; `notes` names them. With `namespace` topics have other
    names than in the log. Every method runs in the worker's thread; `deliver(timed)` sends one message. Raises
    LogError, also part way.
    """

    def __init__(
        self,
        path,
        deliver: Callable[[Timed], None],
        rate: float,
        start_ns: int = 0,
        loop: bool = False,
        namespace: str = "",
    ):
        super().__init__(deliver, rate)
        self._reader = LogReader(path, unfinished=True)
        self._played, self.notes = playable_topics(path, self._reader)
        self._names = renamed_topics(self._played, namespace)
        self.topics = {self._names[name]: topic for name, topic in self._played.items()}
        self.rounds = 0
        self._path, self._start_ns, self._loop = path, start_ns, loop
        self._messages = self._read()
        self._first_ns, self._last_ns, self._last_turn = None, 0, 0

    def turn(self, now: int) -> int | None:
        """`PacedStream.turn`; simulation time 0 has not begun, and where it goes back the replay continues."""
        if now < self._last_turn:
            self.resume_at(now)
        self._last_turn = now
        return super().turn(now) if now else now

    def _read(self) -> Iterator[Timed]:
        start_ns, before = 0, []
        if self._start_ns:
            start_ns = self._reader.first_ns + self._start_ns
            latched = [name for name, topic in self._played.items() if topic_qos(topic).durability == "transient_local"]
            earlier = takewhile(lambda message: message.log_time < start_ns, self._reader.messages(latched))
            latest = {message.topic.name: message for message in earlier}
            before = sorted(latest.values(), key=lambda message: message.log_time)
        for message in self._reader.messages(self._played, start_ns):
            for played in (*before, message):
                if played.topic.ros_type == self._played[played.topic.name].ros_type:
                    yield Timed(message.log_time, self._names[played.topic.name], played.data)
            before = []

    def next_batch(self) -> list[Timed] | None:
        """The next messages of the log, None at its end."""
        if batch := list(islice(self._messages, BATCH)):
            self._last_ns = batch[-1].time_ns
            self._first_ns = batch[0].time_ns if self._first_ns is None else self._first_ns
            return batch
        start = f"{self._path} from {self._start_ns * 1e-9:g} s on"
        if self._first_ns is None:
            raise LogError(f"{start} holds no messages{': lower `start`' if self._start_ns else ''}")
        self.rounds += 1
        if not self._loop:
            return None
        if (span_ns := self._last_ns - self._first_ns) < SHORTEST_ROUND_NS:
            problem = f"{start} covers {span_ns * 1e-9:g} s, too little for `loop`"
            raise LogError(f"{problem}: omit `loop`, or lower `start`")
        self._messages = self._read()
        self.restart()
        return []


class ReplayNode(BaseNode):
    """Publishes a log on the topics it was logged from, or in its own namespace where it has one.

    Raises BearingTwinError for a log it cannot play.
    """

    def __init__(self, **options):
        super().__init__("replay_node", "replay", **options)
        values = declare(self, PARAMETERS, change=self._on_change)
        if not values["log"]:
            raise BearingTwinError("parameter log is empty: give the path of an .mcap file or of a bag folder")
        by_ros_time = self.get_parameter("use_sim_time").value
        if by_ros_time and values["publish_clock"]:
            raise BearingTwinError("with use_sim_time the replay follows /clock, so it cannot publish_clock: unset one")
        prefix, start_ns = self.get_namespace().strip("/"), round(values["start"] * 1e9)
        deliver = lambda message: self._outlet.deliver(message)  # noqa: E731  (its topics are those of the loop)
        self.loop = loop = ReplayLoop(values["log"], deliver, values["rate"], start_ns, values["loop"], prefix)
        for sentence in loop.notes:
            self.get_logger().warning(sentence)
        topics = ((name, topic.ros_type, topic_qos(topic)) for name, topic in loop.topics.items())
        self._outlet = outlet = Outlet(self, topics, values["publish_clock"])
        loop.paused, loop.tick = values["start_paused"], outlet.tick
        self.create_service(SetBool, "~/pause", self._on_pause, qos_profile=SERVICE)
        self.every(DIAGNOSTICS_PERIOD, self._on_diagnostics)
        if outlet.has_clock:
            self.every(CLOCK_PERIOD, self._on_clock)
        self.get_logger().info(f"{values['log']}: {len(outlet.publishers)} topics")
        wait = partial(outlet.wait_for_subscribers, values["discovery"], lambda: self.worker.stopping)
        clock = (lambda: self.get_clock().now().nanoseconds) if by_ros_time else time.monotonic_ns
        self.worker = Worker(self._turn, wait, self._on_end, clock)
        self.worker.start()

    def close(self) -> None:
        """Ends the replay; may be called twice."""
        self.worker.stop(timeout=COMMAND_TIMEOUT)

    # In the worker's thread

    def _turn(self, now: int) -> int | None:
        wake_at = self.loop.turn(now)
        if self.loop.finished and not self.done.is_set():
            self._outlet.wait_for_acknowledgement()
            self.get_logger().info(f"done, {self._outlet.published} messages")
            self.done.set()
        return wake_at

    def _on_end(self, error: Exception | None) -> None:
        if error is not None:
            self.report(ERROR, str(error), {})
            self.fail(error)

    # Callbacks

    @guarded
    def _on_pause(self, request, response):
        future = self.worker.post(self.loop.pause, request.data)
        try:
            response.message = future.result(timeout=COMMAND_TIMEOUT)
        except StillBusy:
            response.message = "accepted: carried out when every topic has a subscriber or `discovery` has passed"
        response.success = True
        return response

    @guarded
    def _on_clock(self):
        if self.loop.paused and self.loop.position_ns:  # for late subscribers
            self._outlet.tick(self.loop.position_ns)

    def _on_change(self, name, value):
        self.worker.post(self.loop.set_factor, value)  # `rate`, the only one that changes

    @guarded
    def _on_diagnostics(self):
        values = self.loop.progress() | {"messages": self._outlet.published, "rounds": self.loop.rounds}
        level, message = OK, "paused" if self.loop.paused else "playing"
        held_up_by = self._outlet.slow_topic()
        if values["lag_s"] > LAG_SHOWN:
            level, message = WARN, f"cannot keep up: {values['lag_s']:.3g} s behind{held_up_by}"
            self.get_logger().warning(f"{message}; lower `rate`", once=True)
        self.report(level, message, values)
