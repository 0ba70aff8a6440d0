"""The messages of a log under other names: topics in another namespace, frames behind a prefix; without ROS."""

import dataclasses
import re
from collections.abc import Iterable

from bearing_twin.log import cdr

GLOBAL = frozenset({"/tf", "/tf_static", "/clock", "/diagnostics", "/rosout", "/parameter_events"})
FRAMES = ("frame_id", "child_frame_id")  # fields that name frames
DESCRIPTION = "robot_description"
_NAMES = re.compile(r"(<(?:robot|link|joint|material) name=\"|<(?:parent|child) link=\")")


class Retelling:
    """What the topics `names` of a log are called in `namespace`, and their messages with `frame_prefix`.

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
