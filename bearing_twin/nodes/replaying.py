"""A log as a paced stream of messages: what replay_node thinks, without ROS, clocks or decoding."""

from collections.abc import Callable, Iterator
from itertools import islice

import yaml

from bearing_twin.errors import LogError
from bearing_twin.log.bag import Qos
from bearing_twin.log.mcap_read import DamagedLog, McapReader
from bearing_twin.log.raw_log import log_files, raw_messages
from bearing_twin.log.recover import advice
from bearing_twin.nodes.pacing import PacedStream, Pacer, Timed

BATCH = 200  # messages read ahead
NUMBERED = {
    "reliability": {1: "reliable", 2: "best_effort"},
    "durability": {1: "transient_local", 2: "volatile"},
}  # how older bags write the policies


class ReplayLoop:
    """Delivers the messages of the log at `path` by their log times, from `start_ns` after the first one.

    Every method runs in the worker's thread; `deliver(timed)` sends one message. Raises LogError, also part way.
    """

    def __init__(self, path, deliver: Callable[[Timed], None], rate: float, start_ns: int = 0, loop: bool = False):
        self.topics = logged_topics(path)
        self.rounds = 0
        self._path, self._start_ns, self._loop = path, start_ns, loop
        self._messages = self._read()
        self._empty = True
        self.paced = PacedStream(self._next_batch, deliver, Pacer(rate))
        self.turn = self.paced.turn

    def pause(self, now: int, paused: bool) -> str:
        """Holds the replay or lets it go on."""
        self.paced.pause(now, paused)
        return "paused" if paused else "playing"

    def _read(self) -> Iterator[Timed]:
        for topic, log_time, publish_time, data in raw_messages(self._path, self._start_ns):
            if topic.name in self.topics:
                yield Timed(log_time, topic.name, publish_time, data)

    def _next_batch(self) -> list[Timed] | None:
        batch = list(islice(self._messages, BATCH))
        if batch:
            self._empty = False
            return batch
        if self._empty:
            raise LogError(f"{self._path} holds no messages from {self._start_ns * 1e-9:g} s on: lower `start`")
        self.rounds += 1
        if not self._loop:
            return None
        self._messages = self._read()
        self.paced.restart()
        return []


def logged_topics(path) -> dict[str, tuple[str, Qos]]:
    """Type and quality of service of every CDR topic of a log, by name; raises LogError."""
    topics: dict[str, tuple[str, Qos]] = {}
    for file in log_files(path):
        try:
            with McapReader(file) as reader:
                summary = reader.summary()
        except DamagedLog as error:
            raise advice(path, error) from error
        for channel in summary.channels.values():
            if channel.message_encoding == "cdr" and channel.schema_id in summary.schemas:
                profiles = channel.metadata.get("offered_qos_profiles", "")
                topics[channel.topic] = (summary.schemas[channel.schema_id].name, offered_qos(profiles))
    if not topics:
        raise LogError(f"{path} holds no ROS topics: give a log written by bearing_twin or `ros2 bag record -s mcap`")
    return topics


def offered_qos(text: str) -> Qos:
    """The first of the profiles that a bag lists as YAML; reliable and volatile where it says nothing usable."""
    try:
        profile = yaml.safe_load(text)[0]
        reliability = NUMBERED["reliability"].get(profile["reliability"], profile["reliability"])
        durability = NUMBERED["durability"].get(profile["durability"], profile["durability"])
        depth = int(profile["depth"])
    except (yaml.YAMLError, LookupError, TypeError, ValueError, RecursionError):
        return Qos()
    return Qos(
        depth if 1 <= depth <= 10_000 else Qos().depth,
        "best_effort" if reliability == "best_effort" else "reliable",
        "transient_local" if durability == "transient_local" else "volatile",
    )
