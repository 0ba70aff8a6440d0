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

    A nested message may be a dict or the sequence of its fields; of one with a header, the key `frame_id` names
    another frame. Sequences of messages may be arrays with one row each. Raises KeyError for a field it has not.
    """
    return _filler(ros_type)(values, (stamp_ns, frame))


@functools.lru_cache(maxsize=64)
def header(stamp_ns: int, frame: str):
    """std_msgs/Header with a stamp given in integer nanoseconds."""
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    time = cdr.message_class("builtin_interfaces/msg/Time")(seconds, nanoseconds)
    return cdr.message_class(HEADER)(time, frame)


@functools.cache
def _filler(ros_type: str) -> Callable:
    """The function (values, (stamp, frame)) -> message of a type."""
    cls, described = cdr.message_class(ros_type), cdr.fields_of(ros_type)
    makers = {name: _maker(description) for name, description in described}
    defaults = {name: _default(description) for name, description in described if name != "header"}
    stamped = any(name == "header" for name, _ in described)

    def fill(values, context):
        if not isinstance(values, dict):
            return cls(*(values.tolist() if isinstance(values, np.ndarray) else values))
        fields = defaults.copy()
        for name, value in values.items():
            if name != "frame_id":
                maker = makers[name]
                fields[name] = value if maker is None else maker(value, context)
        if stamped and "header" not in values:
            fields["header"] = header(context[0], values.get("frame_id", context[1]))
        return cls(**fields)

    return fill


def _maker(description) -> Callable | None:
    """The function (value, context) -> field; None where the value is the field."""
    node, what = description
    if node == NAME:
        return _filler(what)
    if node == BASE:
        return None
    (inner, inner_what), _ = what
    if inner == NAME:
        return lambda value, context: _messages(inner_what, value, context)
    if inner_what[0] in ("string", "wstring"):
        return lambda value, _: list(value)
    kind = _dtype(inner_what[0])
    return lambda value, _: np.ascontiguousarray(value, dtype=kind).reshape(-1)


def _default(description):
    """The field that is left out."""
    node, what = description
    if node == NAME:
        return _filler(what)({}, (0, ""))
    if node == BASE:
        return _ZERO.get(what[0], 0.0 if what[0].startswith("float") else 0)
    (inner, inner_what), length = what
    if inner == NAME or inner_what[0] in ("string", "wstring"):
        return []
    return np.zeros(length if node == ARRAY else 0, _dtype(inner_what[0]))


def _dtype(name: str) -> np.dtype:
    return np.dtype("uint8" if name in ("byte", "char") else name)


def _messages(ros_type, values, context):
    fill = _filler(ros_type)
    if isinstance(values, np.ndarray):
        cls = cdr.message_class(ros_type)
        return [cls(*row) for row in values.reshape(-1, values.shape[-1]).tolist()]
    return [fill(one, context) for one in values]
