"""Messages from plain values: mappings for nested messages, arrays for arrays; what is left out is zero or empty.

Kinds of scenes describe their messages without knowing any message class; this is the one place that builds them.
"""

import functools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from bearing_twin.log import cdr

BASE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4  # kinds of fields, as the definitions number them
HEADER = "std_msgs/msg/Header"
_ZERO = {"string": "", "wstring": "", "bool": False}


def message(ros_type: str, values: Mapping[str, Any], stamp_ns: int, frame: str):
    """A message of that type with these fields; each header not given holds `stamp_ns` and `frame`.

    A nested message may be a mapping or the sequence of its fields; of one with a header, the key `frame_id` names
    another frame. Sequences of messages may be arrays with one row each. Raises KeyError for a field it has not.
    """
    # The last part keeps the headers of this message: many nested ones share one.
    return _filler(ros_type)(values, (stamp_ns, frame, {}))


def header(stamp_ns: int, frame: str):
    """std_msgs/Header with a stamp given in integer nanoseconds."""
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    time = cdr.message_class("builtin_interfaces/msg/Time")(seconds, nanoseconds)
    return cdr.message_class(HEADER)(time, frame)


@functools.cache
def _filler(ros_type: str) -> Callable:
    """The function (values, (stamp, frame, headers by frame)) -> message of a type."""
    cls, fields = cdr.message_class(ros_type), cdr.fields_of(ros_type)
    makers = {name: _maker(description) for name, description in fields}
    defaults = {name: maker(None, (0, "", {})) for name, maker in makers.items() if name != "header"}
    stamped = any(name == "header" for name, _ in fields)

    def fill(values, context):
        if not isinstance(values, Mapping):
            numbers = values.tolist() if isinstance(values, np.ndarray) else values
            return cls(*numbers)
        given = {name: makers[name](value, context) for name, value in values.items() if name != "frame_id"}
        if stamped and "header" not in given:
            stamp_ns, frame, headers = context
            frame = values.get("frame_id", frame)
            if frame not in headers:
                headers[frame] = header(stamp_ns, frame)
            given["header"] = headers[frame]
        return cls(**{**defaults, **given})

    return fill


def _maker(description) -> Callable:
    """The function (value, context) -> field; None gives its default."""
    node, what = description
    if node == NAME:
        return lambda value, context: _filler(what)({} if value is None else value, context)
    if node == BASE:
        zero = _ZERO.get(what[0], 0.0 if what[0].startswith("float") else 0)
        return lambda value, context: zero if value is None else value
    (inner, inner_what), length = what
    if inner == NAME:
        return lambda value, context: _messages(inner_what, value, context)
    if inner_what[0] in ("string", "wstring"):
        return lambda value, context: [] if value is None else list(value)
    kind = np.dtype(inner_what[0] if inner_what[0] not in ("byte", "char") else "uint8")
    size = length if node == ARRAY else 0

    def array(value, context):
        if value is None:
            return np.zeros(size, kind)
        return np.ascontiguousarray(value, dtype=kind).reshape(-1)

    return array


def _messages(ros_type, values, context):
    if values is None:
        return []
    fill = _filler(ros_type)
    if isinstance(values, np.ndarray):
        cls = cdr.message_class(ros_type)
        return [cls(*row) for row in values.reshape(-1, values.shape[-1]).tolist()]
    return [fill(one, context) for one in values]
