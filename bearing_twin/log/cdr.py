"""Messages as little-endian CDR: types of messages, their definitions as text and hashes, bytes written and read.

Everything comes from the .msg files and `rosbags`; no ROS is needed. Kinds of scenes describe their messages by
mappings of fields without knowing any message class; a field without a value is zero or empty. Messages are encoded one
at a time, or many of one topic at once, whose differences are columns. The bytes are those that rclpy sends and rosbag2
stores.
"""

import functools
import re
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bearing_twin.base.errors import LogError
from bearing_twin.base.paths import share_path

OWN_PACKAGE = "bearing_twin_msgs"

CLOCK = "rosgraph_msgs/msg/Clock"
CONTACTS = f"{OWN_PACKAGE}/msg/Contacts"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
FLOAT = "std_msgs/msg/Float64"
JOINT_STATE = "sensor_msgs/msg/JointState"
MARKERS = "visualization_msgs/msg/MarkerArray"
REALISATION = f"{OWN_PACKAGE}/msg/Realisation"
SAMPLE_BLOCK = f"{OWN_PACKAGE}/msg/SampleBlock"
STATE = f"{OWN_PACKAGE}/msg/BearingState"
STRING = "std_msgs/msg/String"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
WAVEFORM = f"{OWN_PACKAGE}/msg/Waveform"
WRENCH = "geometry_msgs/msg/WrenchStamped"

_RULE = "=" * 80
_NUMBERS = "bool int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64"
_DTYPES = {name: np.dtype(name).newbyteorder("<") for name in _NUMBERS.split()}
_DTYPES["byte"] = _DTYPES["char"] = _DTYPES["uint8"]
_TEXTS = ("string", "wstring")
_FIELD = re.compile(r"^[ \t]*([a-zA-Z0-9_/]+)(?:<=\d+)?(?:\[[^\]]*\])?[ \t]+[a-zA-Z]", re.MULTILINE)


def fields_of(ros_type: str) -> list[tuple]:
    """(name, description) of each field of a message type, in order, as `rosbags` describes them."""
    return _typestore().fielddefs[ros_type][1]


def is_known(ros_type: str) -> bool:
    """True for the common messages of ROS 2 Jazzy and our own."""
    return ros_type in _typestore().types


def deserialise(ros_type: str, cdr: bytes):
    """The message in `cdr`, arrays as read-only views of it; raises LogError if the bytes do not fit the type."""
    try:
        return _typestore().deserialize_cdr(cdr, ros_type)
    except (SerdeError, ValueError, IndexError, OverflowError, MemoryError) as error:
        raise LogError(
            f"a message of type {ros_type} cannot be decoded ({error}); the log is damaged or was written with another "
            "version of this type, so record it again"
        ) from error


def serialise(ros_type: str, message) -> bytes:
    """The bytes of a message as `deserialise` gives it."""
    return bytes(_typestore().serialize_cdr(message, ros_type))


@functools.cache
def schema_text(ros_type: str) -> str:
    """The definition in rosbag2's `ros2msg` form: the .msg text, then each dependency once, headed `MSG: pkg/Name`.

    Our own definitions are the files themselves, with units; the common ones are `rosbags`' (no comments), so that a
    log does not depend on whether ROS is installed where it is written.
    """
    return full_definition(ros_type, _definition)


def full_definition(ros_type: str, definition: Callable[[str], str]) -> str:
    """`definition(ros_type)`, then its dependencies depth first in alphabetical order, each once, as rosbag2 does."""
    seen: set[str] = set()

    def with_dependencies(name: str) -> str:
        text = definition(name)
        for dependency in sorted(_dependencies(name, text)):
            if dependency not in seen:
                seen.add(dependency)
                package, _, leaf = dependency.partition("/")
                text += f"\n{_RULE}\nMSG: {dependency}\n" + with_dependencies(f"{package}/msg/{leaf}")
        return text

    return with_dependencies(ros_type)


def definition_in_folders(folders: Iterable[Path]) -> Callable[[str], str]:
    """A `definition` for `full_definition` that reads `share/<package>/msg/<Name>.msg` below each of `folders`.

    It raises LogError for a type that is in none of the folders.
    """
    folders = tuple(folders)

    def definition(ros_type: str) -> str:
        package, _, leaf = ros_type.partition("/msg/")
        for folder in folders:
            path = Path(folder) / "share" / package / "msg" / f"{leaf}.msg"
            if path.is_file():
                return path.read_text(encoding="utf-8")
        raise LogError(f"there is no definition of {ros_type}; source the workspace that holds the package {package}")

    return definition


@functools.cache
def type_hash(ros_type: str) -> str:
    """The type's RIHS01 hash, which ROS compares between publishers, subscribers and logs."""
    return _typestore().hash_rihs01(ros_type)


def _dependencies(ros_type: str, text: str) -> set[str]:
    package = ros_type.partition("/")[0]
    names = set(_FIELD.findall(text)) - {*_DTYPES, *_TEXTS}
    return {name if "/" in name else f"{package}/{name}" for name in names}


def _definition(ros_type: str) -> str:
    text = _own_definitions().get(ros_type)
    return text if text is not None else _typestore().gendefhash(ros_type, {}, ros_version=2)[0]


@functools.cache
def _own_definitions() -> dict[str, str]:
    paths = sorted(Path(share_path("msg_schemas", "msg")).glob("*.msg"))
    return {f"{OWN_PACKAGE}/msg/{path.stem}": path.read_text(encoding="utf-8") for path in paths}


@functools.cache
def _typestore():
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {}
    for name, text in _own_definitions().items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    return store


BASE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4  # kinds of fields, as the definitions number them
HEADER = "std_msgs/msg/Header"
_REPRESENTATION = b"\x00\x01\x00\x00"  # plain CDR, little-endian: four bytes in front that alignment does not count
SECOND = 1_000_000_000  # ns


def encode(ros_type: str, values: Mapping[str, Any], stamp_ns: int, frame: str) -> bytes:
    """A message of that type with these fields; a header that is not given has `stamp_ns` and `frame`.

    A nested message may be a mapping or the sequence of its fields; of one with a header, the key `frame_id` names
    another frame. Sequences of messages may be arrays with a row for each. Raises LogError for an unknown field.
    It is padded to whole words of four bytes, as by the middleware.
    """
    return bytes(write_message(ros_type, values, Draft(stamp_ns, frame)).data)


class Draft:
    """A message that is being written; of `many`, the first, with offset, format and array of each field that varies.

    The array of a stamp is None.
    """

    __slots__ = ("data", "frame", "many", "stamp_ns", "varying")

    def __init__(self, stamp_ns, frame: str, many: bool = False):
        self.stamp_ns, self.frame, self.many = stamp_ns, frame, many
        self.data = bytearray(_REPRESENTATION)
        self.varying: list[tuple[int, Any, Any]] = []

    def align(self, size: int) -> None:
        """Pads to a multiple of `size` bytes, counted after the representation."""
        self.data += bytes(-(len(self.data) - 4) % size)

    def text(self, value: str) -> None:
        """A string: its length with the closing zero, then both."""
        self.align(4)
        if isinstance(value, np.ndarray):
            self.varying.append((len(self.data) + 4, (value.dtype, (1,)), value))
            content = bytes(value.flat[0])
        else:
            content = value.encode()
        self.data += struct.pack("<I", len(content) + 1) + content + b"\0"

    def numbers(self, value, kind: np.dtype, width: int | None = None) -> None:
        """One number or several; with `width` a sequence after its length, in elements of so many numbers."""
        varies = self.many and isinstance(value, np.ndarray)
        array = np.ascontiguousarray(value[0] if varies else value, dtype=kind).reshape(-1)
        if width is not None:
            self.align(4)
            self.data += struct.pack("<I", array.size // width)
        if array.size:
            self.align(kind.itemsize)
        if varies and array.size:
            self.varying.append((len(self.data), (kind, (array.size,)), value))
        self.data += array.tobytes()

    def header(self, frame: str) -> None:
        """std_msgs/Header with the stamp of the message."""
        self.align(4)
        stamp_ns = self.stamp_ns
        if self.many:
            self.varying.append((len(self.data), np.dtype("<i8"), None))
            stamp_ns = int(stamp_ns[0])
        self.data += struct.pack("<iI", *divmod(stamp_ns, SECOND))
        self.text(frame)


def write_message(ros_type: str, values, draft: Draft) -> Draft:
    """The draft with a complete message of that type."""
    _writer(ros_type)(values, draft)
    draft.data += bytes(-len(draft.data) % 4)
    return draft


@functools.cache
def _writer(ros_type: str) -> Callable:
    """The function (values, draft) that writes a message of a type."""
    fields = {name: (_field_writer(description), _default(description)) for name, description in fields_of(ros_type)}

    def write(values, draft):
        if not isinstance(values, dict):
            values = dict(zip(fields, values, strict=True))
        if unknown := values.keys() - fields.keys() - {"frame_id"}:
            raise LogError(f"{ros_type} has no field {min(unknown)!r}; it has {', '.join(fields)}")
        for name, (put, default) in fields.items():
            if name == "header" and name not in values:
                draft.header(values.get("frame_id", draft.frame))
            else:
                put(values.get(name, default), draft)

    return write


@functools.cache
def _uniform_numbers(ros_type: str) -> tuple[str, int] | None:
    """Type and count of the numbers of a message with numbers of one type only, as a vector; None for any other."""
    kinds, count = set(), 0
    for _, (node, detail) in fields_of(ros_type):
        if node == NAME:
            inner = _uniform_numbers(detail)
        else:
            inner = (detail[0], 1) if node == BASE and detail[0] not in _TEXTS else None
        if inner is None:
            return None
        kinds.add(inner[0])
        count += inner[1]
    return (kinds.pop(), count) if len(kinds) == 1 else None


def _field_writer(description) -> Callable:
    """The function (value, draft) that writes a field."""
    node, detail = description
    if node == NAME:
        return _message_writer(detail)
    if node == BASE:
        if detail[0] in _TEXTS:
            return lambda value, draft: draft.text(value)
        kind = _DTYPES[detail[0]]
        return lambda value, draft: draft.numbers(value, kind)
    (inner, inner_detail), _ = detail
    counted = node == SEQUENCE
    if inner == BASE and inner_detail[0] not in _TEXTS:
        kind = _DTYPES[inner_detail[0]]
        return lambda value, draft: draft.numbers(value, kind, 1 if counted else None)
    uniform = _uniform_numbers(inner_detail) if inner == NAME else None
    return _sequence_writer(_field_writer((inner, inner_detail)), counted, uniform)


def _message_writer(ros_type: str) -> Callable:
    write, uniform = _writer(ros_type), _uniform_numbers(ros_type)
    if uniform is None:
        return write
    kind = _DTYPES[uniform[0]]
    return lambda value, draft: write(value, draft) if isinstance(value, dict) else draft.numbers(value, kind)


def _sequence_writer(put: Callable, counted: bool, uniform: tuple[str, int] | None) -> Callable:
    """The function that writes texts or messages one by one; an array of messages of equal numbers in one piece."""

    def write(values, draft):
        if uniform is not None and isinstance(values, np.ndarray):
            draft.numbers(values, _DTYPES[uniform[0]], uniform[1] if counted else None)
            return
        if counted:
            draft.align(4)
            draft.data += struct.pack("<I", len(values))
        for value in values:
            put(value, draft)

    return write


def _default(description):
    """The value of a field that is not given."""
    node, detail = description
    if node == NAME:
        return {}
    if node == BASE:
        return "" if detail[0] in _TEXTS else 0
    (inner, inner_detail), length = detail
    if node == SEQUENCE:
        return ()
    return [_default((inner, inner_detail))] * length


MOST_LAYOUTS = 200  # of one topic that are cached


class Encoder:
    """Encoder of the messages of one topic, many at once; the layout of each size of message is cached.

    Fields are those of `encode`, but arrays have a leading axis of messages, and texts may be an array of bytes;
    other values are the same in all messages of this encoder.
    """

    def __init__(self, ros_type: str, frame: str):
        self._type, self._frame = ros_type, frame
        self._layouts: dict[tuple, _Layout] = {}

    def encode(self, values: Mapping, stamps_ns: np.ndarray) -> list[bytes]:
        """A message for each stamp [ns], in order."""
        texts = [array for array in _arrays(values) if array.dtype.kind == "S"]
        if not texts:
            return self._encode_equal(values, stamps_ns)
        messages = [b""] * len(stamps_ns)
        sizes = np.stack([np.char.str_len(array) for array in texts], axis=-1)
        for size in np.unique(sizes, axis=0):
            rows = np.flatnonzero((sizes == size).all(axis=-1))
            for row, data in zip(rows, self._encode_equal(_rows_of(values, rows), stamps_ns[rows]), strict=True):
                messages[row] = data
        return messages

    def _encode_equal(self, values: Mapping, stamps_ns: np.ndarray) -> list[bytes]:
        arrays = list(_arrays(values))
        sizes = tuple((array.shape[1:], array.itemsize) for array in arrays)
        layout = self._layouts.get(sizes)
        if layout is None:
            if len(self._layouts) >= MOST_LAYOUTS:
                self._layouts.clear()
            layout = self._layouts[sizes] = self._make_layout(values, stamps_ns, arrays)
        size = layout.record.itemsize
        records = np.empty(len(stamps_ns), layout.record)
        records.view((np.uint8, size))[...] = layout.template
        for name, number in zip(layout.record.names, layout.sources, strict=True):
            records[name] = _stamps(stamps_ns) if number is None else arrays[number].reshape(len(stamps_ns), -1)
        data = records.tobytes()
        return [data[low : low + size] for low in range(0, len(data), size)]

    def _make_layout(self, values, stamps_ns, arrays) -> "_Layout":
        for array in arrays:
            if len(array) != len(stamps_ns):
                raise LogError(f"a field of {self._type} has {len(array)} rows for {len(stamps_ns)} messages")
        draft = write_message(self._type, values, Draft(stamps_ns, self._frame, many=True))
        offsets, formats, varying = zip(*draft.varying, strict=True) if draft.varying else ((), (), ())
        numbers = {id(array): number for number, array in enumerate(arrays)}
        record = {
            "names": [f"f{field}" for field in range(len(varying))],
            "formats": formats,
            "offsets": offsets,
            "itemsize": len(draft.data),
        }
        template = np.frombuffer(bytes(draft.data), np.uint8)
        return _Layout(template, [numbers.get(id(array)) for array in varying], np.dtype(record))


class _Layout(NamedTuple):
    """Messages of one size: the first, the numbers of the arrays of varying fields (None: the stamp), their record."""

    template: np.ndarray
    sources: list[int | None]
    record: np.dtype


def _stamps(stamps_ns: np.ndarray) -> np.ndarray:
    """Stamps as in a header: eight bytes, seconds first, then nanoseconds."""
    seconds, nanoseconds = np.divmod(stamps_ns, SECOND)
    return seconds + (nanoseconds << 32)


def _rows_of(values, rows: np.ndarray):
    """The fields of some of the messages, whose texts are of one length."""
    if isinstance(values, np.ndarray):
        return np.array(values[rows].tolist()) if values.dtype.kind == "S" else values[rows]
    if isinstance(values, dict):
        return {name: _rows_of(value, rows) for name, value in values.items()}
    if isinstance(values, (list, tuple)) and values and isinstance(values[0], dict):
        return [_rows_of(value, rows) for value in values]
    return values


def _arrays(values) -> Iterator[np.ndarray]:
    """Every array in nested mappings and sequences, in order."""
    for value in values.values() if isinstance(values, dict) else values:
        if isinstance(value, np.ndarray):
            yield value
        elif isinstance(value, dict) or (isinstance(value, (list, tuple)) and value and isinstance(value[0], dict)):
            yield from _arrays(value)
