"""CDR, definitions and hashes against independent sources: ROS's own type hashes and definition files."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from foreign_writers import serialise
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bearing_twin.base.errors import LogError
from bearing_twin.log import cdr
from bearing_twin.log.cdr import Encoder, encode

COMMON_HASHES = {  # from the type descriptions in the Jazzy packages
    cdr.WRENCH: "RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77",
    cdr.JOINT_STATE: "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    cdr.MARKERS: "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
    cdr.DIAGNOSTICS: "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
    cdr.CLOCK: "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    cdr.TRANSFORMS: "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    cdr.FLOAT: "RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a",
}
OWN = (cdr.CONTACTS, cdr.STATE, cdr.SAMPLE_BLOCK, cdr.WAVEFORM)
needs_ros = pytest.mark.skipif(
    not (Path(sys.prefix) / "share" / "geometry_msgs").is_dir(), reason="ROS 2 is not in this environment: `make setup`"
)


@pytest.mark.parametrize("frame", ["", "x", "xy", "xyz", "bearing_link"])
def test_bytes_of_a_wrench(frame):
    """Aligned, and filled up to whole words of four bytes, as the middleware hands them over."""
    fields = {"wrench": {"force": (1.5, 2.0, 3.0), "torque": (4.0, 5.0, 6.0)}}
    data = encode(cdr.WRENCH, fields, 3_000_000_007, frame)
    head = b"\x03\0\0\0\x07\0\0\0" + np.uint32(len(frame) + 1).tobytes() + frame.encode() + b"\0"
    numbers = np.array([1.5, 2, 3, 4, 5, 6], dtype="<f8").tobytes()
    assert data == b"\x00\x01\x00\x00" + head + bytes(-len(head) % 8) + numbers
    assert cdr.deserialise(cdr.WRENCH, data).wrench.torque.z == 6.0
    data = encode("std_msgs/msg/Header", {"stamp": (3, 7), "frame_id": frame}, 0, "")
    assert data == b"\x00\x01\x00\x00" + head + bytes(-len(head) % 4)


@pytest.mark.parametrize("stamp_ns", [0, 999_999_999, 1_000_000_000, 1_899_999_999_999_999_999])
def test_stamps_are_whole_seconds_and_the_nanoseconds_above(stamp_ns):
    """Also where the quotient of doubles is the next second."""
    for data in (
        encode(cdr.JOINT_STATE, {}, stamp_ns, ""),
        *Encoder(cdr.JOINT_STATE, "").encode({"position": np.zeros((1, 2))}, np.array([stamp_ns])),
    ):
        stamp = cdr.deserialise(cdr.JOINT_STATE, data).header.stamp
        assert (stamp.sec, stamp.nanosec) == divmod(stamp_ns, 10**9)


@pytest.mark.parametrize(
    "data", [b"", b"\x00\x01", b"\x00\x01\x00\x00\x03\x00", b"nonsense that is long enough for it all"]
)
def test_bytes_that_do_not_fit_are_a_log_error(data):
    with pytest.raises(LogError, match="geometry_msgs/msg/WrenchStamped cannot be decoded"):
        cdr.deserialise(cdr.WRENCH, data)


@pytest.mark.parametrize("ros_type", COMMON_HASHES)
def test_hash_of_common_types(ros_type):
    assert cdr.type_hash(ros_type) == COMMON_HASHES[ros_type]


@pytest.mark.parametrize("ros_type", [*COMMON_HASHES, *OWN])
def test_definition_text_alone_gives_the_same_type(ros_type):
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(cdr.schema_text(ros_type), ros_type))
    assert store.hash_rihs01(ros_type) == cdr.type_hash(ros_type)


def test_the_definition_for_a_ros_without_tf2_msgs_is_that_of_tf2_msgs():
    text = (Path(__file__).parents[1] / "cmake" / "tf2_msgs" / "msg" / "TFMessage.msg").read_text()
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(text, "here/msg/TFMessage"))
    assert store.fielddefs["here/msg/TFMessage"] == store.fielddefs[cdr.TRANSFORMS]
    assert cdr.type_hash(cdr.TRANSFORMS) == COMMON_HASHES[cdr.TRANSFORMS]


def test_a_dependency_of_several_parts_is_defined_once():
    """Markers hold poses, points, colours and headers over and over."""
    headings = [line for line in cdr.schema_text(cdr.MARKERS).splitlines() if line.startswith("MSG: ")]
    assert len(headings) == len(set(headings)) > 10


@needs_ros
@pytest.mark.parametrize("ros_type", COMMON_HASHES)
def test_definitions_have_the_fields_and_the_order_of_ros_own_files(ros_type):
    built = Path(__file__).parents[1] / "install" / "tf2_msgs"  # where ROS itself has none
    theirs = cdr.full_definition(ros_type, cdr.definition_in_folders([Path(sys.prefix), built]))
    assert fields(cdr.schema_text(ros_type)) == fields(theirs)


@pytest.mark.parametrize("ros_type", [*OWN, cdr.TRANSFORMS])
def test_hash_of_own_types_is_the_one_rosidl_built(ros_type):
    package, _, leaf = ros_type.partition("/msg/")
    built = Path(__file__).parents[1] / "install" / package / "share" / package / "msg" / f"{leaf}.json"
    if not built.is_file():
        pytest.skip("the interface package is not built: `make setup`")
    hashes = {row["type_name"]: row["hash_string"] for row in json.loads(built.read_text())["type_hashes"]}
    assert hashes[ros_type] == cdr.type_hash(ros_type)


def test_unknown_type_names_its_package():
    with pytest.raises(LogError, match=r"no definition of other_msgs/msg/Thing; source the workspace .* other_msgs"):
        cdr.full_definition("other_msgs/msg/Thing", cdr.definition_in_folders([Path("/nowhere")]))
    assert not cdr.is_known("other_msgs/msg/Thing")
    assert cdr.is_known(cdr.SAMPLE_BLOCK)


def fields(text):
    """Field lines without comments, defaults, and the package that a type of the same package may leave out."""
    lines = []
    for line in text.splitlines():
        parts = line.split("#")[0].replace(" =", "=").replace("= ", "=").split()
        if parts:
            lines.append((parts[0].rpartition("/")[2], *parts[1:2]))
    return lines


def test_what_is_left_out_is_zero_or_empty():
    """Against rosbags: nested messages, empty sequences of everything, texts, and vectors as mappings."""
    for fields in (
        {},
        {"ns": "a", "id": -3, "points": np.arange(6.0).reshape(2, 3), "text": "b"},
        {"points": [{"x": 1.0}, (1, 2, 3)], "colors": [(0, 1, 0.5, 1)], "scale": {"y": 2.0}, "frame_locked": True},
    ):
        data = encode("visualization_msgs/msg/Marker", fields, 3_000_000_007, "bearing_link")
        again = cdr.deserialise("visualization_msgs/msg/Marker", data)
        assert serialise("visualization_msgs/msg/Marker", again) == data
        assert (again.header.stamp.sec, again.header.stamp.nanosec) == (3, 7)
        assert (again.ns, again.id, again.text) == (fields.get("ns", ""), fields.get("id", 0), fields.get("text", ""))
        assert len(again.points) == len(fields.get("points", ()))
        assert len(again.colors) == len(fields.get("colors", ()))
    assert [(p.x, p.y, p.z) for p in again.points] == [(1.0, 0.0, 0.0), (1.0, 2.0, 3.0)]
    assert (again.scale.x, again.scale.y, again.colors[0].b, again.frame_locked) == (0.0, 2.0, 0.5, True)
    with pytest.raises(LogError, match=r"has no field 'colour'; it has"):
        encode("visualization_msgs/msg/Marker", {"colour": 1}, 0, "")


def test_texts_of_many_messages_keep_their_lengths():
    texts = ["0 N", "12.5 N", "1.8 N", "7 N"]
    marker = {"text": np.array([text.encode() for text in texts]), "scale": np.arange(12.0).reshape(4, 3)}
    fields = {"markers": [marker]}
    several = Encoder("visualization_msgs/msg/MarkerArray", "link").encode(fields, np.arange(4))
    messages = [cdr.deserialise("visualization_msgs/msg/MarkerArray", data).markers[0] for data in several]
    assert [message.text for message in messages] == texts
    assert [message.scale.x for message in messages] == [0.0, 3.0, 6.0, 9.0]


def test_rows_of_other_length_are_refused_and_another_size_is_laid_out_anew():
    encoder, stamps = Encoder(cdr.JOINT_STATE, "bearing_link"), np.arange(3) * 10**9
    with pytest.raises(LogError, match="has 2 rows for 3 messages"):
        encoder.encode({"position": np.zeros((2, 4))}, stamps)
    for size in (4, 0, 2):
        data = encoder.encode({"name": ["a", "bcd"], "position": np.arange(3.0 * size).reshape(3, size)}, stamps)
        messages = [cdr.deserialise(cdr.JOINT_STATE, content) for content in data]
        assert [message.position.tolist() for message in messages] == np.arange(3.0 * size).reshape(3, size).tolist()
        headers = [message.header for message in messages]
        assert [(header.stamp.sec, header.frame_id) for header in headers] == [(k, "bearing_link") for k in range(3)]
        assert [serialise(cdr.JOINT_STATE, message) for message in messages] == data
