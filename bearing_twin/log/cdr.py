"""The types of messages used here: their fields, definitions as text and hashes, and how their bytes are read.

Everything comes from the .msg files and `rosbags`; no ROS is needed. `encoding` writes what is read here.
"""

import functools
import re
from collections.abc import Callable, Iterable
from pathlib import Path

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
_PRIMITIVE = frozenset(
    {"bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32"}
    | {"int64", "uint64", "string", "wstring"}
)
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


def serialised(ros_type: str, message) -> bytes:
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
    """A `definition` for `full_definition` that looks for `share/<package>/msg/<Name>.msg` below each of `folders`.

    What it returns raises LogError for a type that none of the folders has.
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
    names = set(_FIELD.findall(text)) - _PRIMITIVE
    return {name if "/" in name else f"{package}/{name}" for name in names}


def _definition(ros_type: str) -> str:
    own = _own_definitions().get(ros_type)
    return own if own is not None else _typestore().gendefhash(ros_type, {}, ros_version=2)[0]


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
