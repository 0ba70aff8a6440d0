"""A log as a paced stream of messages: what replay_node thinks, without ROS, clocks or decoding."""

import dataclasses
import re
from collections.abc import Callable, Container, Iterable, Iterator
from itertools import islice
from typing import NamedTuple

from bearing_twin.base.errors import LogError
from bearing_twin.log import cdr
from bearing_twin.log.bag import LogReader, Qos, offered_qos, raw_messages
from bearing_twin.log.mcap_read import LoggedMessage, StoredTopic
from bearing_twin.log.recover import advised
from bearing_twin.nodes.pacing import PacedStream, Pacer, Timed

GLOBAL = frozenset({"/tf", "/tf_static", "/clock", "/diagnostics", "/rosout", "/parameter_events"})
FRAMES = ("frame_id", "child_frame_id")  # fields that name frames
DESCRIPTION = "robot_description"
_NAMES = re.compile(r"(<(?:robot|link|joint|material) name=\"|<(?:parent|child) link=\")")


class Renaming:
    """Topics `names` of a log under their names in `namespace`, and their messages with `frame_prefix`.

    Empty words leave everything as it is. A log of one scene has its namespace replaced, as a node's is; one of several
    has it put in front. What all scenes share, such as /tf, keeps its name. A type that is not known keeps its frames.
    """

    def __init__(self, names: Iterable[str], namespace: str = "", frame_prefix: str = ""):
        names = list(names)
        homes = {name.rpartition("/")[0] for name in names if name.endswith("/samples")}
        self._home = homes.pop() + "/" if len(homes) == 1 else "/"
        self._place, self._prefix = namespace.strip("/"), frame_prefix

    def topic(self, name: str) -> str:
        """The name of a topic."""
        if not self._place or name in GLOBAL:
            return name
        return f"/{self._place}/{name.removeprefix(self._home).lstrip('/')}"

    def data(self, name: str, ros_type: str, data: bytes) -> bytes:
        """The bytes of a message of a topic, named as in the log; raises LogError for bytes that are none."""
        if not self._prefix or not cdr.is_known(ros_type):
            return data
        message = cdr.deserialise(ros_type, data)
        if ros_type == cdr.STRING:
            if not name.endswith(f"/{DESCRIPTION}"):
                return data
            named = _NAMES.sub(lambda found: found[1] + self._prefix, message.data)
            return cdr.serialised(ros_type, dataclasses.replace(message, data=named))
        renamed = self._renamed(message)
        return data if renamed is message else cdr.serialised(ros_type, renamed)

    def _renamed(self, value):
        """The same value, or a copy in which frames have the prefix."""
        if isinstance(value, list):
            found = [self._renamed(one) for one in value]
            return found if any(one is not other for one, other in zip(found, value, strict=True)) else value
        if not dataclasses.is_dataclass(value):
            return value
        changed = {}
        for field in dataclasses.fields(value):
            old = getattr(value, field.name)
            new = f"{self._prefix}{old}" if field.name in FRAMES and old else self._renamed(old)
            if new is not old:
                changed[field.name] = new
        return dataclasses.replace(value, **changed) if changed else value


BATCH = 200  # messages read ahead
SHORTEST_ROUND_NS = 1_000_000  # of a log that is played again and again: a shorter one would flood who listens


class ReplayTopic(NamedTuple):
    """A topic of a log; `changed` where its type has other fields now: subscribers could not read its bytes.

    `others` are types of further messages under its name, which are not played.
    """

    ros_type: str
    qos: Qos
    changed: bool
    others: frozenset[str] = frozenset()


class ReplayLoop:
    """Delivers the messages of the log at `path` by their log times, from `start_ns` after the first one.

    What is latched comes first where a replay starts later: as it was last before, as late subscribers have it.
    Topics of a type that has changed since are not played; `notes` says which. With `namespace` and `frame_prefix`
    topics and frames have other names than in the log. Every method runs in the worker's thread; `deliver(timed)` sends
    one message. Raises LogError, also part way.
    """

    def __init__(
        self,
        path,
        deliver: Callable[[Timed], None],
        rate: float,
        start_ns: int = 0,
        loop: bool = False,
        namespace: str = "",
        frame_prefix: str = "",
    ):
        with advised(path):
            notes = LogReader(path, unfinished=True).notes
        logged = logged_topics(path)
        self._played = {name: topic for name, topic in logged.items() if not topic.changed}
        self._renaming = Renaming(self._played, namespace, frame_prefix)
        self.topics = {self._renaming.topic(name): topic for name, topic in self._played.items()}
        self.notes = notes + [
            f"{name} is not played: {topic.ros_type} has other fields now than when it was logged; play it with the "
            "bearing_twin that wrote it"
            for name, topic in logged.items()
            if topic.changed
        ]
        if not self.topics:
            raise LogError(self.notes[-1])
        self.notes += [
            f"messages of type {', '.join(sorted(topic.others))} on {name} are not played, for others there are of "
            f"type {topic.ros_type}"
            for name, topic in logged.items()
            if topic.others
        ]
        self.rounds = 0
        self._path, self._start_ns, self._loop = path, start_ns, loop
        self._latched = [name for name, topic in self._played.items() if topic.qos.durability == "transient_local"]
        self._messages = self._read()
        self._empty, self._first_ns, self._last_ns = True, None, 0
        self.paced = PacedStream(self._next_batch, deliver, Pacer(rate))
        self._turned = 0

    def turn(self, now: int) -> int | None:
        """`PacedStream.turn`; simulation time has not begun at 0, and where it goes back the replay goes on."""
        if now < self._turned:
            self.paced.resume_at(now)
        self._turned = now
        return self.paced.turn(now) if now else now

    def pause(self, now: int, paused: bool) -> str:
        """Holds the replay or lets it go on."""
        self.paced.pause(now, paused)
        return "paused" if paused else "playing"

    def _read(self) -> Iterator[Timed]:
        before = latest_messages(self._path, self._start_ns, self._latched) if self._start_ns else []
        for topic, log_time, _, data in raw_messages(self._path, self._start_ns, unfinished=True):
            for latched in before:
                yield from self._renamed_message(latched.topic, log_time, latched.data)
            before = ()
            yield from self._renamed_message(topic, log_time, data)

    def _renamed_message(self, topic: StoredTopic, time_ns: int, data: bytes) -> Iterator[Timed]:
        """A message as it goes out, if it does."""
        if not topic.foreign and topic.name in self._played and topic.ros_type == self._played[topic.name].ros_type:
            renamed = self._renaming.data(topic.name, topic.ros_type, data)
            yield Timed(time_ns, self._renaming.topic(topic.name), renamed)

    def _next_batch(self) -> list[Timed] | None:
        batch = list(islice(self._messages, BATCH))
        if batch:
            self._empty, self._last_ns = False, batch[-1].time_ns
            self._first_ns = batch[0].time_ns if self._first_ns is None else self._first_ns
            return batch
        if self._empty:
            raise LogError(f"{self._path} holds no messages from {self._start_ns * 1e-9:g} s on: lower `start`")
        self.rounds += 1
        if not self._loop:
            return None
        if (span_ns := self._last_ns - self._first_ns) < SHORTEST_ROUND_NS:
            raise LogError(
                f"{self._path} from {self._start_ns * 1e-9:g} s on covers {span_ns * 1e-9:g} s, too little to be "
                "played again and again: leave `loop` out, or lower `start`"
            )
        self._messages = self._read()
        self.paced.restart()
        return []


def logged_topics(path) -> dict[str, ReplayTopic]:
    """Every CDR topic of a log, by name; raises LogError."""
    topics: dict[str, ReplayTopic] = {}
    with advised(path):
        stored = LogReader(path, unfinished=True).topics
    for one in stored:
        if one.foreign:
            continue
        ros_type, said = one.ros_type, one.metadata
        logged_hash = said.get("topic_type_hash", "")
        changed = cdr.is_known(ros_type) and logged_hash.startswith("RIHS") and logged_hash != cdr.type_hash(ros_type)
        known = topics.get(one.name)
        if known is not None and known.ros_type != ros_type:
            topics[one.name] = known._replace(others=known.others | {ros_type})
            continue
        others = known.others if known is not None else frozenset()
        topics[one.name] = ReplayTopic(ros_type, offered_qos(said.get("offered_qos_profiles", "")), changed, others)
    if not topics:
        raise LogError(f"{path} holds no ROS topics: give a log written by bearing_twin or `ros2 bag record -s mcap`")
    return topics


def latest_messages(path, start_ns: int, topics: Container[str]) -> list[LoggedMessage]:
    """The last message of each of these topics before `start_ns` nanoseconds after the log's first; raises LogError."""
    reader = LogReader(path, unfinished=True)
    found = {one.topic.name: one for one in reader.messages(topics, until_ns=reader.first_ns + start_ns)}
    return sorted(found.values(), key=lambda one: one.log_time)
