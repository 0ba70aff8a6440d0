"""Files that MCAP and rosbag2 allow and others write: read, or passed over and counted, never called damaged.

What means ill is refused in a sentence, in less than a second and 300 MB. Each row of the tables is one file.
"""

import contextlib
import io
import itertools
import json
import random
import sqlite3
import struct
import sys
import time
import zlib

import lz4.frame
import pytest
import yaml
import zstandard
from foreign_writers import by_mcap, by_rosbags
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, Message, Schema, Statistics
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, IndexType, Writer
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from runs import bits, made_up_block, made_up_run, made_up_scene
from torture_rows import in_a_process

from bearing_twin.base.errors import LogError
from bearing_twin.command.cli import BAD_INPUT, DONE, DOUBTFUL, main
from bearing_twin.log import cdr, run_log
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.raw_log import SCENE_RECORD, recover
from bearing_twin.log.run_log import read_log, write_log

SCENE = made_up_scene(balls=1)
OUTPUTS = 200
BLOCK = made_up_block(SCENE, OUTPUTS)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """The messages of a log of ours, (topic, type, log time, bytes) each."""
    path = tmp_path_factory.mktemp("source") / "run.mcap"
    write_log(made_up_run(SCENE, [BLOCK]), path, run_record=False)
    return [(topic.name, topic.ros_type, log_time, data) for topic, log_time, _, data in raw_messages(path)]


def channel(schema=None, topic="/other", encoding="json"):
    """Registers a channel of another program: without a schema, or with one (name, encoding, bytes)."""
    return lambda writer: writer.register_channel(topic, encoding, writer.register_schema(*schema) if schema else 0)


def many_channels(writer):
    for k in range(5000):
        writer.register_channel(f"/many/{k}", "cdr", 0)
    return channel()(writer)


def attached(size):
    return lambda writer: writer.add_attachment(0, 0, "camera.bin", "application/octet-stream", bytes(size))


def shuffled(messages):
    result = list(messages)
    random.Random(1).shuffle(result)
    return result


def by_topic(messages):
    """All of one topic, then all of the next."""
    return sorted(messages, key=lambda message: message[0])


MAGIC, END = b"\x89MCAP0\r\n", (DataEnd(0), Footer(0, 0, 0))


def inside(*records):
    """The bytes of records, as in a chunk or a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()


def rewritten(path, change=lambda record: record, behind=b""):
    """The file again, record by record, in which `change` may replace or leave out records, without index and CRCs."""
    records = StreamReader(io.BytesIO(path.read_bytes()), emit_chunks=True).records
    data = itertools.takewhile(lambda record: not isinstance(record, DataEnd), records)
    path.write_bytes(MAGIC + inside(*filter(None, map(change, data))) + behind + inside(*END) + MAGIC)


def unknown_record(path, messages):
    by_mcap(path, messages)
    rewritten(path, behind=struct.pack("<BQ", 0x90, 5) + b"other")


def longer_end(path, messages):
    """With a field of a later version in the record that ends the data."""
    by_mcap(path, messages)
    rewritten(path)
    head = struct.Struct("<BQI")
    path.write_bytes(path.read_bytes().replace(head.pack(0x0F, 4, 0), head.pack(0x0F, 8, 0) + b"more"))


def in_frames(path, messages):
    """Chunks of two frames of zstd each, as programs write them that pack in parallel."""

    def change(record):
        if isinstance(record, Chunk):
            data = zstandard.ZstdDecompressor().decompress(record.data)
            pieces = data[: len(data) // 2], data[len(data) // 2 :]
            record.data = b"".join(map(zstandard.ZstdCompressor().compress, pieces))
        return record

    by_mcap(path, messages)
    rewritten(path, change)


def mixed(path, messages):
    """Half of the messages in chunks, half of them outside."""
    half = len(messages) // 2
    by_mcap(path, messages[:half])
    records = StreamReader(io.BytesIO(path.read_bytes())).records
    numbers = {record.topic: record.id for record in records if isinstance(record, Channel)}
    loose = (Message(numbers[name], time_ns, data, time_ns, 0) for name, _, time_ns, data in messages[half:])
    rewritten(path, behind=inside(*loose))


def growing(path, messages):
    """As it is while it is written: the last chunk half, no end."""
    by_mcap(path, messages, chunk_size=20_000)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 3 // 4])


def appended(path, messages):
    by_mcap(path, messages)
    with path.open("ab") as file:
        file.write(bytes(3000))


def plain(messages, **options):
    return lambda path, source: by_mcap(path, messages(source), **options)


same = list
BINARY = ("a/b", "protobuf", b"\xff\xfe\x00")  # a schema
LEGAL = {  # how the file is made, messages that are passed over, a word of the warning
    "a channel without a schema": (plain(same, raw=channel()), 7, "/other"),
    "a schema that is no text": (plain(same, raw=channel(BINARY, encoding="protobuf")), 7, "/other"),
    "CDR without a schema": (plain(same, raw=channel(encoding="cdr")), 7, "no schema"),
    "a foreign channel on our topic": (plain(same, raw=channel(topic="/bearing/samples")), 7, "/bearing/samples"),
    "5000 channels": (plain(same, raw=many_channels), 7, "/other"),
    "no chunks and a schemaless channel": (plain(same, raw=channel(), use_chunking=False), 7, "/other"),
    "no statistics": (plain(same, use_statistics=False), 0, ""),
    "no channels in the summary": (plain(same, repeat_channels=False, repeat_schemas=False), 0, ""),
    "no index of chunks": (plain(same, index_types=IndexType.MESSAGE, raw=channel()), 7, "/other"),
    "no summary at all": (
        plain(same, use_statistics=False, use_summary_offsets=False, repeat_channels=False, repeat_schemas=False,
              index_types=IndexType.NONE), 0, "",
    ),
    "no checksums": (plain(same, enable_crcs=False), 0, ""),
    "all checksums": (plain(same, enable_data_crcs=True), 0, ""),
    "lz4": (plain(same, compression=CompressionType.LZ4), 0, ""),
    "uncompressed": (plain(same, compression=CompressionType.NONE), 0, ""),
    "a chunk a message": (plain(same, chunk_size=1), 0, ""),
    "an attachment of 80 MB": (plain(same, more=attached(80_000_000)), 0, ""),
    "an attachment under a checksum": (plain(same, more=attached(3_000_000), enable_data_crcs=True), 0, ""),
    "a record of another program": (unknown_record, 0, ""),
    "a longer record at the end": (longer_end, 0, ""),
    "chunks of several frames": (in_frames, 0, ""),
    "bytes behind the end": (appended, 0, ""),
    "messages in chunks and outside": (mixed, 0, ""),
    "backwards in small chunks": (plain(lambda messages: messages[::-1], chunk_size=5000), 0, ""),
    "shuffled": (plain(shuffled, chunk_size=20_000), 0, ""),
    "shuffled without chunks": (plain(shuffled, use_chunking=False), 0, ""),
    "chunks that overlap in time": (plain(by_topic, chunk_size=20_000, raw=channel()), 7, "/other"),
}  # fmt: skip


@pytest.mark.parametrize("case", LEGAL)
def test_what_the_format_allows_is_read_by_time_and_what_is_foreign_counted(case, source, tmp_path, capsys, run_json):
    make, foreign, phrase = LEGAL[case]
    path, saved = tmp_path / "run.mcap", tmp_path / "saved.mcap"
    make(path, source)
    assert bits(read_log(path)) == bits(BLOCK)
    assert main(["report", str(path), "--json", "--strict"]) in (DONE, DOUBTFUL)
    out, err = capsys.readouterr()
    assert json.loads(out).get("messages_foreign", 0) == foreign
    assert (f"{foreign} messages are passed over" in err) == (foreign > 0)
    assert phrase in err
    messages = list(raw_messages(path))
    assert [message.log_time for message in messages] == sorted(message.log_time for message in messages)
    recovered = recover(path, saved)
    assert (recovered.messages, recovered.samples) == (len(source) + foreign, OUTPUTS)
    assert len(recovered.problems) == (case == "an attachment of 80 MB")  # larger than what is read
    assert run_json("report", saved).get("messages_foreign", 0) == foreign


def test_what_is_foreign_is_recovered_as_it_is(source, tmp_path):
    """Also what surrounds the messages: encodings, schemas that are no text, metadata, attachments."""
    raw = channel(BINARY, encoding="protobuf")
    path, saved = tmp_path / "run.mcap", tmp_path / "saved.mcap"
    by_mcap(path, source, raw, lambda writer: (attached(100)(writer), writer.add_metadata("theirs", {"key": "value"})))

    def reported(file):
        records = {}
        for record in StreamReader(io.BytesIO(file.read_bytes()), validate_crcs=True).records:
            records.setdefault(type(record).__name__, []).append(record)
        schemas = {schema.id: (schema.name, schema.encoding, schema.data) for schema in records["Schema"]}
        channels = {(row.topic, row.message_encoding, schemas[row.schema_id]) for row in records["Channel"]}
        numbers = {channel.id: channel.topic for channel in records["Channel"]}
        messages = [(numbers[message.channel_id], message.log_time, message.data) for message in records["Message"]]
        attachments = [(row.name, row.media_type, row.data) for row in records["Attachment"]]
        return channels, messages, attachments, [record for record in records["Metadata"] if record.name == "theirs"]

    path.write_bytes(path.read_bytes()[:-100])
    recover(path, saved)
    by_mcap(path, source, raw, lambda writer: (attached(100)(writer), writer.add_metadata("theirs", {"key": "value"})))
    assert reported(saved) == reported(path)


def test_a_page_names_a_few_of_the_topics_that_it_does_not_show(source, tmp_path, run_cli):
    hidden = [(f"/other/{k}", cdr.STRING, 0, b"\0\1\0\0\2\0\0\0x\0") for k in range(50)]
    by_mcap(tmp_path / "run.mcap", source + hidden)
    assert "/other/0 (std_msgs/msg/String), /other/1 (std_msgs/msg/String)" in (
        notes := run_cli("view", tmp_path / "run.mcap", "--out", tmp_path / "run.html").err
    )
    assert "and 47 others" in notes


def test_a_file_that_is_written_is_read_to_its_last_whole_chunk(source, tmp_path, run_cli):
    path = tmp_path / "run.mcap"
    growing(path, source)
    out, err = run_cli("report", path, "--json", "--strict", code=DOUBTFUL)
    assert 50 <= json.loads(out)["samples"] < OUTPUTS
    assert "has no end" in err
    with pytest.raises(LogError, match="bearing_twin recover"):
        read_log(path)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(LogError, match="no outputs are in it so far"):
        read_log(path, allow_gaps=True)
    samples = [one for one in source if one[1] == cdr.SAMPLE_BLOCK]
    by_mcap(path, samples, use_chunking=False)
    path.write_bytes(path.read_bytes().partition(samples[0][3])[0])  # a channel, and the beginning of a message
    with pytest.raises(LogError, match="no outputs are in it so far"):
        read_log(path, allow_gaps=True)
    growing(path, source)
    log = read_log(path, allow_gaps=True)
    assert bits(log) == bits(BLOCK)[: json.loads(out)["samples"]]


MANY = 150_000


def test_the_memory_of_a_reader_does_not_grow_with_the_number_of_messages(source, tmp_path):
    """Outside chunks, with messages among them that come last by time."""
    samples = [message for message in source if message[1] == cdr.SAMPLE_BLOCK]
    by_mcap(tmp_path / "run.mcap", [("/bearing/scene", cdr.STRING, 0, b""), *samples], use_chunking=False)
    times = (1 << 60 if k % 5000 == 0 else 1000 * k for k in range(MANY))
    texts = b"".join(struct.pack("<BQHIQQ", 5, 31, 1, 0, time_ns, 0) + b"\0\1\0\0\1\0\0\0\0" for time_ns in times)
    rewritten(tmp_path / "run.mcap", behind=texts)

    def work():
        with pytest.raises(LogError, match="the scene in"):
            read_log(tmp_path / "run.mcap")
        assert sum(1 for _ in raw_messages(tmp_path / "run.mcap")) == MANY + 1 + len(samples)

    cost = in_a_process(work)
    assert cost.well
    assert cost.memory < 15e6


def test_a_damaged_message_outside_chunks_costs_itself_and_doubles_no_other(source, tmp_path):
    """One too short for its fields, between whole ones."""
    path, samples = tmp_path / "run.mcap", [message for message in source if message[1] == cdr.SAMPLE_BLOCK]
    by_mcap(path, samples, use_chunking=False)
    data = path.read_bytes()
    last = data.rindex(samples[-1][3]) - 31  # where its record begins
    path.write_bytes(data[:last] + struct.pack("<BQ3s", 5, 3, b"bad") + data[last:])
    recovered = recover(path, tmp_path / "saved.mcap")
    assert recovered.messages == len(samples)
    assert f"at byte {last}: " in recovered.problems[0]


def test_chunks_that_all_go_on_to_the_end_are_read_once(tmp_path):
    """Each begins within the one before it: looking for a whole one among them would take hours."""
    size, count = 45, 3000
    ends = (len(MAGIC) + size * number - 9 for number in range(count, 0, -1))
    heads = (struct.pack("<BQQQQI", 6, end - len(MAGIC), 0, 1, 100, 0) + b"\4\0\0\0zstd" for end in ends)
    (tmp_path / "run.mcap").write_bytes(MAGIC + b"".join(heads))
    with pytest.raises(LogError, match="nothing in") as refused:
        recover(tmp_path / "run.mcap", tmp_path / "saved.mcap")
    assert str(refused.value).count("at byte") == 2


def test_outputs_that_begin_again_and_again_are_refused(source, tmp_path, monkeypatch):
    monkeypatch.setattr(run_log, "MOST_RUNS", 3)
    samples = [message for message in source if message[1] == cdr.SAMPLE_BLOCK][:3]
    twice = [message for message in samples for _ in range(2)]
    by_mcap(tmp_path / "run.mcap", twice)
    with pytest.raises(LogError, match="begin again more than 3 times"):
        read_log(tmp_path / "run.mcap")


def test_long_runs_that_overlap_in_time_are_two_runs(source, tmp_path, monkeypatch):
    """As by the clock of a simulation that began again: by time their outputs alternate."""
    samples = [message for message in source if message[1] == cdr.SAMPLE_BLOCK]
    monkeypatch.setattr(run_log, "MOST_RUNS", 3)
    by_mcap(tmp_path / "run.mcap", [*samples, *samples])
    assert read_log(tmp_path / "run.mcap").runs == 2


def without_description(path, messages):
    by_rosbags(path, messages)
    (path / "metadata.yaml").unlink()


def one_file(path, messages):
    by_rosbags(path, messages)
    [file] = path.glob("*.db3")
    content = file.read_bytes()
    (path / "metadata.yaml").unlink()
    file.unlink()
    path.rmdir()
    path.with_suffix(".db3").write_bytes(content)


def in_files(path, messages):
    """In forty files, message by message in turn, so that all overlap in time but for their ends."""
    by_rosbags(path, messages[:1], StoragePlugin.MCAP)
    names = [f"part_{k}.mcap" for k in range(40)]
    for k, name in enumerate(names):
        by_mcap(path / name, messages[k::40])
    description = yaml.safe_load((path / "metadata.yaml").read_text())
    description["rosbag2_bagfile_information"]["relative_file_paths"] = names
    (path / "metadata.yaml").write_text(yaml.safe_dump(description))


BAGS = {
    "MCAP in forty files": (in_files, "run"),
    "sqlite3": (by_rosbags, "run"),
    "sqlite3, shuffled": (lambda path, messages: by_rosbags(path, shuffled(messages)), "run"),
    "sqlite3 without metadata.yaml": (without_description, "run"),
    "a file of sqlite3": (one_file, "run.db3"),
    "MCAP": (lambda path, messages: by_rosbags(path, messages, StoragePlugin.MCAP), "run"),
}


@pytest.mark.parametrize("case", BAGS)
def test_bags_are_read_reported_on_and_recovered(case, source, tmp_path, run_json):
    make, name = BAGS[case]
    make(tmp_path / "run", source)
    path = tmp_path / name
    assert bits(read_log(path)) == bits(BLOCK)
    assert run_json("report", path)["samples"] == OUTPUTS
    assert recover(path, tmp_path / "saved.mcap").messages == len(source)
    assert bits(read_log(tmp_path / "saved.mcap")) == bits(BLOCK)


@pytest.mark.parametrize(("mode", "name"), [("MESSAGE", "bag"), ("FILE", "bag/bag.db3.zstd")])
def test_a_compressed_bag_is_named_with_the_command_that_converts_it(mode, name, source, tmp_path):
    path, fresh = tmp_path / "bag", tmp_path / "new"
    by_rosbags(path, source, mode=CompressionMode[mode])
    with pytest.raises(LogError, match="compressed") as error:
        read_log(tmp_path / name)
    command = str(error.value).partition("`")[2].partition("`")[0].replace("NEW_BAG", str(fresh)).split()
    assert command[0] == "rosbags-convert"
    assert in_a_process(lambda: convert(command)).well
    assert bits(read_log(fresh)) == bits(BLOCK)


def convert(arguments):
    from rosbags.convert.__main__ import main as converted

    sys.argv = arguments
    with contextlib.suppress(SystemExit):
        converted()


def of_chunk(content, **changes):
    """A file of one chunk that has this content, with header, index and end as far as a reader needs them."""
    fields = {"compression": "", "data": content, "message_end_time": 0, "message_start_time": 0}
    chunk = Chunk(**fields | {"uncompressed_crc": zlib.crc32(content), "uncompressed_size": len(content)} | changes)
    return of_records(chunk)


def packed(content, times=1, compression="zstd", **changes):
    """A file of so many chunks that have this content packed."""
    data = zstandard.compress(content) if compression == "zstd" else lz4.frame.compress(content)
    fields = {"compression": compression, "data": data, "uncompressed_crc": 0, "uncompressed_size": len(content)}
    return of_records(SCHEMA, CLOCK, *[Chunk(message_end_time=0, message_start_time=0, **fields | changes)] * times)


def of_scene(text):
    """A log without outputs whose metadata have this text as its scene."""
    written = io.BytesIO()
    writer = Writer(written)
    writer.start("ros2")
    channel((cdr.SAMPLE_BLOCK, "ros2msg", b""), "/bearing/samples", "cdr")(writer)
    writer.add_metadata(SCENE_RECORD, {"scene": text})
    writer.finish()
    return written.getvalue()


def of_records(*records):
    return MAGIC + inside(Header("ros2", ""), *records, *END) + MAGIC


def of_summary(*records, messages=0):
    """A file without messages whose summary has these records, and statistics that count so many messages."""
    data = inside(Header("ros2", ""), DataEnd(0))
    chunks = sum(isinstance(record, ChunkIndex) for record in records)
    statistics = Statistics(0, 0, {}, chunks, messages, 0, 0, 0, 0)
    return MAGIC + data + inside(*records, statistics, Footer(len(MAGIC + data), 0, 0)) + MAGIC


def indexed_at(offset):
    """A file without messages whose end says that its index begins there."""
    return of_records()[:-28] + struct.pack("<QQI", offset, 0, 0) + MAGIC


SCHEMA, CLOCK = Schema(1, b"", "ros2msg", "a/msg/B"), Channel(1, "/a", "cdr", {}, 1)
HEAD = struct.Struct("<BQ")
FAR = ChunkIndex(0, 1 << 63, "", 0, 9, 0, {}, 0, 0)
EMPTY = struct.pack("<BQHIQQ", 5, 22, 1, 0, 0, 0)
TABLE = '{"kind": "bearing", "rings": {"inner": {"table": [%s]}}}'
HOSTILE = {  # the bytes of a file, or what makes them, and what is said of it
    "a message shorter than its head": (of_chunk(inside(SCHEMA, CLOCK) + HEAD.pack(5, 3) + b"abc"), "damaged"),
    "a record longer than its chunk": (of_chunk(HEAD.pack(0x80, 1 << 40)), "damaged"),
    "a chunk that ends within a record": (of_chunk(b"\x05\x00"), "damaged"),
    "a chunk of another size than it says": (of_chunk(b"", uncompressed_size=7), "damaged"),
    "a chunk with another checksum": (of_chunk(inside(SCHEMA), uncompressed_crc=7), "damaged"),
    "a chunk of no known compression": (of_chunk(b"", compression="brotli"), "beyond a limit"),
    "zstd that is none": (of_chunk(b"nothing", compression="zstd"), "damaged"),
    "lz4 that is none": (of_chunk(b"nothing", compression="lz4"), "damaged"),
    "a chunk that says 2^60 bytes": (of_chunk(b"", uncompressed_size=1 << 60), "beyond a limit"),
    "a chunk of 70 MB": (of_chunk(bytes(70 << 20)), "beyond a limit"),
    "a record of 2^63 bytes": (of_records()[:-50] + HEAD.pack(6, 1 << 63), "damaged"),
    "3 million empty records": (lambda: packed(HEAD.pack(0x80, 0) * 3_000_000, compression="lz4"), "beyond a limit"),
    "a million empty messages": (lambda: packed(EMPTY * 1_000_000), "beyond a limit"),
    "256 MB": (lambda: packed(bytes(1 << 28)), "beyond a limit"),
    "256 MB by lz4": (lambda: packed(bytes(1 << 28), compression="lz4"), "beyond a limit"),
    "256 MB that say 64, eight times": (lambda: packed(bytes(1 << 28), 8, uncompressed_size=1 << 26), "size it states"),
    "64 MB, four times": (lambda: packed(bytes(1 << 26), 4, "lz4"), "beyond a limit"),
    "a schema of 30 MB": (lambda: of_records(Schema(1, bytes(30_000_000), "ros2msg", "a/msg/B")), "holds no topic"),
    "a scene of 30 MB": (lambda: of_scene("kind: bearing\ndescription: " + "x" * 30_000_000), "the scene in"),
    "a scene of lists": (lambda: of_scene('{"kind": "bearing", "a": [' + "[]," * 2_300_000 + "0]}"), "the scene in"),
    "a scene of deep lists": (lambda: of_scene('{"a": ' + "[" * 5_000_000), "the scene in"),
    "a scene with a long table": (lambda: of_scene(TABLE % ("[1, 1,1,1,0,0]," * 300_000)), "the scene in"),
    "an index before the start": (indexed_at(3), "holds no topic"),
    "an index behind the end": (indexed_at(1 << 62), "holds no topic"),
    "an index of chunks that are not there": (of_summary(FAR, FAR), "holds no topic"),
    "an index that counts other messages": (of_summary(messages=7), "its index counts 7 messages, and it holds 0"),
    "zeros": (MAGIC + bytes(10_000_000), "its end is missing"),
    "a footer in the middle": (of_records(Footer(0, 0, 0), SCHEMA), "damaged"),
    "a message of a channel that nothing describes": (of_records(Message(9, 0, b"", 0, 0)), "holds no topic"),
    "all channels there can be": (
        of_records(SCHEMA, *(Channel(k, f"/{k}", "cdr", {}, 1) for k in range(65_536))), "holds no topic",
    ),
    "a name that is no text": (of_chunk(HEAD.pack(4, 12) + b"\1\0\0\0\4\0\0\0" + b"\xff" * 4), "holds no topic"),
    "zeros that state 1000 bytes": (
        of_chunk(bytes(1000), data=zstandard.compress(bytes(1 << 27)), compression="zstd"), "size it states",
    ),
    "nothing": (b"", "is empty"),
    "a table": (b"time,load\n0,1\n", "is not an MCAP file"),
    "a beginning alone": (MAGIC, "is damaged"),
    "a database": (b"SQLite format 3\0" + bytes(100), "is not an MCAP file"),
}  # fmt: skip


def cost_of_refusing(paths, saved, seconds):
    """In one process, `report` and `recover` of each, which may take so many processor seconds together.

    Of messages without end `recover` saves the first.
    """

    def work():
        for path in paths:
            begin = time.process_time()
            assert main(["report", str(path)]) == BAD_INPUT, path
            assert main(["recover", str(path), str(saved), "--force"]) in (DONE, BAD_INPUT), path
            assert time.process_time() - begin < seconds, path

    return in_a_process(work)


def test_what_means_ill_is_refused_for_what_it_is_and_soon(tmp_path):
    files = {tmp_path / f"{case}.mcap": row for case, row in HOSTILE.items()}

    def write():
        for path, (content, _) in files.items():
            path.write_bytes(content if isinstance(content, bytes) else content())

    assert in_a_process(write).well
    cost = cost_of_refusing(files, tmp_path / "out.mcap", 2.0)
    assert cost.well
    assert cost.memory < 190e6  # 300 MB with the program itself
    for path, (_, sentence) in files.items():
        with pytest.raises(LogError) as error:
            read_log(path)
        assert sentence in str(error.value)


def test_where_nothing_can_be_recovered_several_problems_are_named(tmp_path):
    path = tmp_path / "run.mcap"
    path.write_bytes(packed(bytes(1000), 5, uncompressed_size=999))
    with pytest.raises(LogError, match=r"\(run.mcap at byte \d+: [^:]*, run.mcap at byte .* and 2 others\)"):
        recover(path, tmp_path / "saved.mcap")


def test_a_file_that_has_no_end_is_refused_by_its_name():
    with pytest.raises(LogError, match="/proc/self/mem cannot be read"):
        read_log("/proc/self/mem")


def hostile_bag(path, statements):
    path.mkdir()
    with sqlite3.connect(path / "run.db3") as database:
        database.executescript(statements)
    database.close()


SCHEMA_OF_BAGS = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, offered_qos_profiles TEXT);
INSERT INTO topics VALUES(1, '/bearing/samples', 'bearing_twin_msgs/msg/SampleBlock', 'cdr', '');
"""
ENDLESS = """
CREATE VIEW messages(id, topic_id, timestamp, data) AS
WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x, 1, 1, x FROM n;
"""
HOSTILE_BAGS = {
    "no tables": "",
    "a view without end": SCHEMA_OF_BAGS + ENDLESS,
    "data that are made on reading": SCHEMA_OF_BAGS + """
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER,
                              data BLOB GENERATED ALWAYS AS (zeroblob(900000000)) VIRTUAL);
        INSERT INTO messages(topic_id, timestamp) VALUES(1, 1);""",
    "times that are words": SCHEMA_OF_BAGS + """
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp, data);
        INSERT INTO messages VALUES(1, 1, 'noon', 'x');""",
    "times before the start": SCHEMA_OF_BAGS + """
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp, data);
        INSERT INTO messages VALUES(1, 1, -5, x'00010000');""",
    "times of a hundred digits": SCHEMA_OF_BAGS + f"""
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp, data);
        INSERT INTO messages VALUES(1, 1, '{"9" * 100}', x'00010000');""",
}  # fmt: skip


def test_a_database_that_means_ill_is_refused_soon(tmp_path):
    for case, statements in HOSTILE_BAGS.items():
        hostile_bag(tmp_path / case, statements)
    cost = cost_of_refusing([tmp_path / case for case in HOSTILE_BAGS], tmp_path / "out.mcap", 1.0)
    assert cost.well
    assert cost.memory < 190e6


def test_descriptions_of_bags_are_anybodys(tmp_path):
    """Nothing is read outside the folder, nothing takes long, and what cannot be read is said."""
    folder = tmp_path / "bag"
    with pytest.raises(LogError, match=r"there is no log .*bag"):
        read_log(folder)
    folder.mkdir()
    with pytest.raises(LogError, match=r"holds no .mcap file"):
        read_log(folder)
    lines = "rosbag2_bagfile_information:\n  "
    for text in (
        "{" * 600, "", "[]", "{", lines + "relative_file_paths: 7", lines + "relative_file_paths: [../../etc/passwd]",
        lines + "{storage_identifier: tape, relative_file_paths: [a]}", "a: &a [*a]", "x" * 3_000_000,
        lines + "{compression_mode: file, relative_file_paths: [a]}", lines + "relative_file_paths: [[1]]",
    ):  # fmt: skip
        (folder / "metadata.yaml").write_text(text)
        with pytest.raises(LogError):
            read_log(folder)
    (folder / "metadata.yaml").write_text(lines + "relative_file_paths: [metadata.yaml, metadata.yaml]")
    with pytest.raises(LogError, match="names a file twice"):
        read_log(folder)
