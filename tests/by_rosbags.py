"""Messages written by `rosbags`: the independent truth for the bytes that the package writes itself."""

from bearing_twin.log import cdr


def message_class(ros_type):
    """The dataclass of a message type, built with keywords; arrays are exactly of the field's type."""
    return cdr._typestore().types[ros_type]


def serialise(ros_type, message):
    """Little-endian CDR behind the four-byte header, filled up to whole words."""
    data = bytes(cdr._typestore().serialize_cdr(message, ros_type, little_endian=True))
    return data + bytes(-len(data) % 4)
