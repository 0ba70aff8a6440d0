"""MCAP files read with distrust: every length is checked before it is used, every CRC that is there is compared.

What is wrong with a file becomes `DamagedLog`, with the byte at which it shows. Chunks are unpacked under limits
on size, ratio and number of records, so that a small file cannot fill the memory or keep the reader busy.
"""

import bisect
import io
import struct
import zlib
from array import array
from collections.abc import Container, Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    DataEnd,
    Footer,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from bearing_twin.errors import LogError
from bearing_twin.log.checksum import crc32
from bearing_twin.log.mcap_write import GREATEST_RATIO, MAGIC

LARGEST_RECORD = 1 << 26  # bytes, packed or unpacked; writers make chunks of a few megabytes
LARGEST_MESSAGE = LARGEST_RECORD - (1 << 21)  # bytes, beside what is in its chunk before and what packing adds
FREE_BYTES = 1 << 26  # unpacked bytes any file may have; beyond that GREATEST_RATIO holds
FREE_RECORDS = 200_000  # records any file may have
LZ4_PIECE = 1 << 20  # bytes
RECORDS_PER_BYTE = 4  # of the file, beyond that

_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_CHUNK_PLACE = struct.Struct("<16xQ")  # where its chunk begins, in the index of one
_CHUNK_TOPICS = struct.Struct("<Q24xI")  # its first time there, and the length of the list of its channels
_CHUNK_TOPIC = struct.Struct("<H8x")
_PIECE = 1 << 20  # bytes of an index that are looked at together
_FOOTER_RECORD = 9 + 20
_PARSERS = {
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK: Chunk,
    Opcode.STATISTICS: Statistics,
    Opcode.METADATA: Metadata,
    Opcode.METADATA_INDEX: MetadataIndex,
    Opcode.DATA_END: DataEnd,
}
_PARSE_ERRORS = (McapError, struct.error, ValueError, KeyError, OverflowError, MemoryError)


class DamagedLog(LogError):
    """The file is cut or altered; `offset` is the byte at which it shows, `what` the reason.

    `hopeless`: it is not worth while to read on behind it.
    """

    def __init__(self, path, offset: int, what: str, hopeless: bool = False):
        super().__init__(f"{path} is damaged at byte {offset}: {what}; `bearing_twin recover` saves what is whole")
        self.path, self.offset, self.what, self.hopeless = path, offset, what, hopeless


class StoredTopic(NamedTuple):
    """A channel of a log: full topic name, ROS type, definition text, encoding and metadata as stored."""

    name: str
    ros_type: str
    definition: str
    message_encoding: str
    metadata: dict[str, str]


class LoggedMessage(NamedTuple):
    """One message as stored; times in ns."""

    topic: StoredTopic
    log_time: int
    publish_time: int
    data: bytes


MOST_TOPICS = 10_000  # a tenth of a second to read


class Summary(NamedTuple):
    """The index from byte `start` of a log on; `chunks` are where they begin: a day of a node has a million."""

    start: int
    schemas: dict[int, Schema]
    channels: dict[int, Channel]
    statistics: Statistics | None
    chunks: array
    metadata: list[MetadataIndex]


class McapReader:
    """The content of one MCAP file in file order; use as a context manager. Raises LogError if it is no MCAP file."""

    def __init__(self, path):
        self.path = Path(path)
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._topics: dict[int, StoredTopic] = {}
        self._packed = self._unpacked = self._records = 0
        self._starts = array("Q")  # of chunks, where the index is known
        self._chunked = False
        try:
            self._stream: BinaryIO = self.path.open("rb")
        except OSError as error:
            raise LogError(f"{path} cannot be read ({error.strerror}); give the path of a log") from error
        self._size = self._stream.seek(0, io.SEEK_END)
        self._stream.seek(0)
        magic = self._stream.read(len(MAGIC))
        if magic != MAGIC:
            self._stream.close()
            reason = "is empty" if self._size == 0 else "is not an MCAP file"
            raise LogError(f"{path} {reason}; give a log written by bearing_twin or `ros2 bag record -s mcap`")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stream.close()

    def summary(self) -> Summary:
        """The index, checked; raises DamagedLog when the file was not closed properly or the index is altered."""
        start = self._summary_start()
        summary = Summary(start, {}, {}, None, array("Q"), [])
        for offset, opcode, content in self._raw(start, check_data=False):
            if opcode == Opcode.CHUNK_INDEX:
                if len(content) < _CHUNK_PLACE.size:
                    raise DamagedLog(self.path, offset, "the index of a chunk is too short")
                summary.chunks.append(_CHUNK_PLACE.unpack_from(content)[0])
                continue
            record = self._parse(offset, _PARSERS[opcode], content) if opcode in _PARSERS else None
            if isinstance(record, Schema):
                summary.schemas[record.id] = record
            elif isinstance(record, Channel):
                summary.channels[record.id] = record
            elif isinstance(record, MetadataIndex):
                summary.metadata.append(record)
            elif isinstance(record, Statistics):
                summary = summary._replace(statistics=record)
        return summary

    def content(self, from_ns: int | None = None, begin: int = len(MAGIC)) -> Iterator[LoggedMessage | Metadata]:
        """Messages and metadata in file order, checked to the end; raises DamagedLog where reading cannot go on.

        Whole chunks before `from_ns` are passed over unread. `begin` is the byte to start at, a record's first.
        """
        if from_ns is not None:
            self.learn(self.summary())
        for offset, record in self._parsed(begin, check_data=begin == len(MAGIC)):
            if isinstance(record, Metadata):
                yield record
            elif isinstance(record, Schema | Channel):
                self._learn(offset, record)
            elif isinstance(record, Message) and not self._chunked:  # else its kind is altered: nobody writes both
                yield self._message(offset, record.channel_id, record.log_time, record.publish_time, record.data)
            elif isinstance(record, Chunk) and (from_ns is None or record.message_end_time >= from_ns):
                self._chunked = True
                yield from self._chunk(offset, record)
            elif isinstance(record, DataEnd):
                break

    def latest(self, summary: Summary, topics: Container[str], before_ns: int) -> list[LoggedMessage]:
        """The last message of each of these topics before a time, if any; reads no chunk without them."""
        found = {}
        self.learn(summary)
        wanted = {number: channel.topic for number, channel in summary.channels.items() if channel.topic in topics}
        for place in reversed(self._chunks_with(summary.start, wanted, before_ns)):
            if found.keys() >= set(wanted.values()):
                break
            offset, chunk = next(self._parsed(place, check_data=False), (0, None))
            if not isinstance(chunk, Chunk):
                raise DamagedLog(self.path, place, "the index points to something else than a chunk")
            here = {one.topic.name: one for one in self._chunk(offset, chunk) if one.log_time < before_ns}
            found = {name: one for name, one in here.items() if name in topics} | found
        return sorted(found.values(), key=lambda one: one.log_time)

    def _chunks_with(self, start: int, channels: Container[int], before_ns: int) -> list[int]:
        """Where the chunks begin that have a message of one of these channels, and one before a time.

        The index begins at byte `start`.
        """
        places = []
        for _, opcode, content in self._raw(start, check_data=False):
            if opcode == Opcode.CHUNK_INDEX and len(content) >= _CHUNK_TOPICS.size:
                first_ns, length = _CHUNK_TOPICS.unpack_from(content)
                rows = content[_CHUNK_TOPICS.size : _CHUNK_TOPICS.size + length]
                rows = rows[: len(rows) // _CHUNK_TOPIC.size * _CHUNK_TOPIC.size]
                if first_ns < before_ns and any(one in channels for (one,) in _CHUNK_TOPIC.iter_unpack(rows)):
                    places.append(_CHUNK_PLACE.unpack_from(content)[0])
        return places

    def learn(self, summary: Summary) -> None:
        """Takes topics from the index, for reading that does not start with the chunk that describes them."""
        self._schemas.update(summary.schemas)
        self._channels.update(summary.channels)
        self._starts = array("Q", sorted(summary.chunks))

    def metadata(self, summary: Summary) -> list[Metadata]:
        """The metadata records that the index lists."""
        records = []
        for index in summary.metadata:
            if not len(MAGIC) <= index.offset < self._size:
                raise DamagedLog(self.path, index.offset, "the index points outside the file")
            _, record = next(self._parsed(index.offset, check_data=False), (0, None))
            if not isinstance(record, Metadata):
                raise DamagedLog(self.path, index.offset, "the index points to something else than metadata")
            records.append(record)
        return records

    def record_after(self, offset: int) -> int | None:
        """Where the record after the one at `offset` begins, if the one at `offset` still tells."""
        self._stream.seek(offset)
        head = self._stream.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        opcode, length = _HEAD.unpack(head)
        following = offset + _HEAD.size + length
        return following if opcode in _PARSERS and following < self._size else None

    def _summary_start(self) -> int:
        end = self._size - len(MAGIC)
        self._stream.seek(max(end - _FOOTER_RECORD, 0))
        tail = self._stream.read()
        if len(tail) != _FOOTER_RECORD + len(MAGIC) or tail[-len(MAGIC) :] != MAGIC or tail[0] != Opcode.FOOTER:
            raise DamagedLog(
                self.path,
                self._size,
                "its end is missing (it is still written, the writer was stopped, or the file was cut)",
            )
        footer = self._parse(end - _FOOTER_RECORD, Footer, tail[9 : -len(MAGIC)])
        start = footer.summary_start
        if not len(MAGIC) <= start <= end - _FOOTER_RECORD:
            raise DamagedLog(self.path, end, "it has no index")
        self._stream.seek(start)
        crc, left = 0, end - _FOOTER_RECORD - start
        while footer.summary_crc and left > 0 and (piece := self._stream.read(min(left, _PIECE))):
            crc, left = zlib.crc32(piece, crc), left - len(piece)
        if footer.summary_crc and zlib.crc32(tail[: 9 + 16], crc) != footer.summary_crc:
            raise DamagedLog(self.path, start, "its index does not have the CRC it was written with")
        return start

    def _raw(self, position: int, check_data: bool) -> Iterator[tuple[int, int, bytes]]:
        """Offset, opcode and content of the records from byte `position` up to and with the footer."""
        self._stream.seek(position)
        crc = zlib.crc32(MAGIC)
        while True:
            head = self._stream.read(_HEAD.size)
            if len(head) < _HEAD.size:
                raise DamagedLog(self.path, position, "it ends here, without an index")
            opcode, length = _HEAD.unpack(head)
            if position + _HEAD.size + length > self._size:
                raise DamagedLog(self.path, position, "a record goes on beyond the end of the file")
            if length > LARGEST_RECORD:
                raise DamagedLog(self.path, position, f"a record of {length} bytes is larger than any log needs")
            end = position + _HEAD.size + length
            if (opcode == Opcode.DATA_END and length != 4) or (
                opcode == Opcode.FOOTER and end != self._size - len(MAGIC)
            ):
                raise DamagedLog(self.path, position, "a record says that the data end here, and they do not")
            if bisect.bisect_left(self._starts, end) > bisect.bisect_right(self._starts, position):
                raise DamagedLog(self.path, position, "a record goes on into the next chunk")
            content = self._stream.read(length)
            if check_data and opcode == Opcode.DATA_END:
                expected = self._parse(position, DataEnd, content).data_section_crc
                if expected and expected != crc:
                    raise DamagedLog(self.path, position, "the data do not have the CRC they were written with")
                check_data = False
            elif check_data:
                crc = crc32(content, zlib.crc32(head, crc))
            yield position, opcode, content
            if opcode == Opcode.FOOTER:
                return
            position = end

    def _parsed(self, begin: int, check_data: bool) -> Iterator[tuple[int, object]]:
        for offset, opcode, content in self._raw(begin, check_data):
            if opcode == Opcode.MESSAGE:
                self._count(offset, 1)
                yield offset, self._parse(offset, Message, content, len(content))
            elif opcode in _PARSERS:
                yield offset, self._parse(offset, _PARSERS[opcode], content)

    def _parse(self, offset: int, kind: type, content: bytes, *more):
        try:
            return kind.read(ReadDataStream(io.BytesIO(content)), *more)
        except _PARSE_ERRORS as error:
            raise DamagedLog(self.path, offset, f"a {kind.__name__} record cannot be read ({error})") from error

    def _count(self, offset: int, records: int) -> None:
        self._records += records
        if self._records > FREE_RECORDS + RECORDS_PER_BYTE * self._size:
            raise DamagedLog(self.path, offset, "it holds more records than a file of its size can have honestly")

    def _chunk(self, offset: int, chunk: Chunk) -> Iterator[LoggedMessage]:
        data = self._unpacked_data(offset, chunk)
        position = 0
        while position < len(data):
            if position + _HEAD.size > len(data):
                raise DamagedLog(self.path, offset, "a record in this chunk is cut")
            opcode, length = _HEAD.unpack_from(data, position)
            start = position + _HEAD.size
            position = start + length
            if position > len(data):
                raise DamagedLog(self.path, offset, "a record in this chunk is longer than the chunk")
            self._count(offset, 1)
            if opcode == Opcode.MESSAGE:
                if length < _MESSAGE_HEAD.size:
                    raise DamagedLog(self.path, offset, "a message in this chunk is too short")
                channel, _, log_time, publish_time = _MESSAGE_HEAD.unpack_from(data, start)
                payload = bytes(data[start + _MESSAGE_HEAD.size : position])
                yield self._message(offset, channel, log_time, publish_time, payload)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._learn(offset, self._parse(offset, _PARSERS[opcode], data[start:position]))

    def _unpacked_data(self, offset: int, chunk: Chunk) -> bytes:
        size = chunk.uncompressed_size
        packed, unpacked = self._packed + len(chunk.data), self._unpacked + size
        if size > LARGEST_RECORD or unpacked > FREE_BYTES + GREATEST_RATIO * packed:
            raise DamagedLog(self.path, offset, f"it unpacks to {unpacked} bytes, more than its size allows")
        self._packed, self._unpacked = packed, unpacked
        try:
            if chunk.compression == "zstd":
                # Bounded by `read`: the size written inside the zstd frame is not to be trusted.
                data = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(size + 1)
            elif chunk.compression == "lz4":
                data = _lz4_unpacked(chunk.data, size)
            elif chunk.compression == "":
                data = chunk.data
            else:
                compression = f"a chunk is compressed by {chunk.compression!r}; convert it to zstd or lz4"
                raise DamagedLog(self.path, offset, compression)
        except (zstandard.ZstdError, RuntimeError, ValueError, EOFError, MemoryError) as error:
            raise DamagedLog(self.path, offset, f"a chunk cannot be unpacked ({error})") from error
        if len(data) != size:
            raise DamagedLog(self.path, offset, "a chunk does not have the size it states")
        if chunk.uncompressed_crc and crc32(data) != chunk.uncompressed_crc:
            raise DamagedLog(self.path, offset, "a chunk does not have the CRC it was written with")
        return data

    def _learn(self, offset: int, record: Schema | Channel) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif record.schema_id in self._schemas:
            if self._channels.get(record.id) != record:
                self._channels[record.id] = record
                self._topics.pop(record.id, None)
            if len(self._channels) > MOST_TOPICS:
                raise DamagedLog(self.path, offset, f"it has more than {MOST_TOPICS} topics, as no log has", True)
        else:
            raise DamagedLog(self.path, offset, f"the topic {record.topic!r} has no type")

    def _message(self, offset: int, channel: int, log_time: int, publish_time: int, data: bytes) -> LoggedMessage:
        topic = self._topics.get(channel)
        if topic is None:
            if channel not in self._channels or self._channels[channel].schema_id not in self._schemas:
                raise DamagedLog(self.path, offset, f"a message belongs to the unknown channel {channel}")
            topic = self._topics[channel] = self._topic(offset, self._channels[channel])
        return LoggedMessage(topic, log_time, publish_time, data)

    def _topic(self, offset: int, channel: Channel) -> StoredTopic:
        schema = self._schemas[channel.schema_id]
        try:
            text = schema.data.decode()
        except UnicodeDecodeError as error:
            raise DamagedLog(self.path, offset, f"the definition of {schema.name!r} is not text") from error
        return StoredTopic(channel.topic, schema.name, text, channel.message_encoding, dict(channel.metadata))


def _lz4_unpacked(packed: bytes, size: int) -> bytearray:
    """What is packed, up to one byte more than `size`, in pieces: in one, lz4 takes twice the memory."""
    unpacker, data = lz4.frame.LZ4FrameDecompressor(), bytearray()
    piece = unpacker.decompress(packed, max_length=LZ4_PIECE)
    while piece and len(data) <= size:
        data += piece
        piece = b"" if unpacker.eof else unpacker.decompress(b"", max_length=LZ4_PIECE)
    return data
