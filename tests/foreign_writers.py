"""Logs as others write them: messages and bag folders by rosbags, files by the library of the format's authors."""

import functools

from mcap.writer import Writer
from rosbags.rosbag2 import CompressionFormat, StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bearing_twin.log import cdr


@functools.cache
def typestore_with(ros_type):
    """The common messages of ROS 2, and one of another type."""
    typestore = get_typestore(Stores.ROS2_JAZZY)
    types = get_types_from_msg(cdr.schema_text(ros_type), ros_type)
    typestore.register({name: fields for name, fields in types.items() if name not in typestore.types})
    return typestore


def message_class(ros_type):
    """The dataclass of a message type, built with keywords; arrays are exactly of the field's type."""
    return typestore_with(ros_type).types[ros_type]


def serialise(ros_type, message):
    """Little-endian CDR behind the four-byte header, filled up to whole words."""
    data = bytes(typestore_with(ros_type).serialize_cdr(message, ros_type, little_endian=True))
    return data + bytes(-len(data) % 4)


RAW = [("raw", 10_000_000 * k, bytes([k, 255, 0])) for k in range(7)]  # on channels of other programs


def by_mcap(path, messages, raw=None, more=lambda writer: None, **options):
    """The messages by the library of the format's authors, then some on a channel that `raw(writer)` registers."""
    with path.open("wb") as file:
        writer, channels = Writer(file, **options), {}
        writer.start("ros2", "another program")
        if raw is not None:
            channels["raw"] = raw(writer)
        for name, ros_type, time_ns, data in messages:
            if name not in channels:
                schema = writer.register_schema(ros_type, "ros2msg", cdr.schema_text(ros_type).encode())
                channels[name] = writer.register_channel(name, "cdr", schema)
            writer.add_message(channels[name], time_ns, data, time_ns)
        for name, time_ns, data in RAW if raw is not None else ():
            writer.add_message(channels[name], time_ns, data, time_ns)
        more(writer)
        writer.finish()


def by_rosbags(path, messages, storage=StoragePlugin.SQLITE3, mode=None):
    writer = BagWriter(path, version=9, storage_plugin=storage)
    if mode is not None:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for name, ros_type, time_ns, data in messages:
            if name not in connections:
                given = {"msgdef": cdr.schema_text(ros_type), "rihs01": cdr.type_hash(ros_type)}
                connections[name] = writer.add_connection(name, ros_type, typestore=typestore_with(ros_type), **given)
            writer.write(connections[name], time_ns, data)
