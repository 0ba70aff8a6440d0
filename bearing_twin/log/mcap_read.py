"""MCAP files read behind limits: every length is checked before it is used, every checksum in the file is compared.

The format allows more than ROS 2 writes: channels without a schema or of another encoding, messages outside chunks, no
summary, any order of time, attachments of any size. All of it is read or passed over. `DamagedLog` is raised where
lengths or checksums contradict each other, `LogLimit` where a part that is needed is larger than this reader allows, so
that a small file cannot fill the memory or keep the reader busy. Records are parsed by the library `mcap`; its
`StreamReader` is not used, because it loads attachments and unpacks chunks whole, without a limit.
"""

import bisect
import io
import itertools
import struct
from array import array
from collections import Counter
from collections.abc import Container, Iterator
from heapq import heappop, heappush
from pathlib import Path
from typing import BinaryIO, NamedTuple

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    Footer,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from bearing_twin.base.errors import LogError
from bearing_twin.log.mcap_write import GREATEST_RATIO, MAGIC, StoredTopic, crc32

LARGEST_RECORD = 1 << 26  # bytes, packed or unpacked; writers make chunks of a few megabytes
LARGEST_MESSAGE = LARGEST_RECORD - (1 << 21)  # bytes, beside what is in its chunk before and what packing adds
FREE_BYTES = 1 << 26  # unpacked bytes any file may have; beyond that GREATEST_RATIO holds
FREE_RECORDS = 200_000  # records any file may have
RECORDS_PER_BYTE = 4  # of the file, beyond that
MOST_TOPICS, MOST_SILENT = 10_000, 1000  # with messages and without: a fifth of a second to read
LAST_NS = (1 << 64) - 1  # the format counts time by 64 bits
MOST_PENDING = 1 << 27  # bytes of messages that wait for earlier ones of chunks that overlap in time

_HEAD = struct.Struct("<BQ")  # of a record: opcode, length
_MESSAGE = struct.Struct("<BQHIQQ")  # head of a record and of the message in it
_FIELDS = _MESSAGE.size - _HEAD.size
_CHUNK_INDEX = struct.Struct("<QQQQI")  # start and end time, place, length, length of the list of its channels
_PIECE = 1 << 20  # bytes that are read, unpacked or put into a stretch of messages together
_DATA_END_RECORD, _FOOTER_RECORD = _HEAD.size + 4, _HEAD.size + 20
_USED = frozenset({Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE, Opcode.CHUNK, Opcode.METADATA})
_DATA = (Opcode.CHUNK, Opcode.MESSAGE)
_PARSE_ERRORS = (McapError, struct.error, ValueError, KeyError, OverflowError, MemoryError)


class UnreadableLog(LogError):
    """Reading cannot go on at byte `offset`; `what` is the reason."""

    said = ""

    def __init__(self, path, offset: int, what: str):
        super().__init__(self.said.format(path, offset, what))
        self.path, self.offset, self.what = path, offset, what


class DamagedLog(UnreadableLog):
    """The file is cut or altered."""

    said = "{0} is damaged at byte {1}: {2}; `bearing_twin recover {0} NEW_LOG` saves what is whole"


class LogLimit(UnreadableLog):
    """A part of the file that is needed is larger than the limit named."""

    said = "{} is beyond a limit of bearing_twin at byte {}: {}"


class LoggedMessage(NamedTuple):
    """One message as stored; times in ns."""

    topic: StoredTopic
    log_time: int
    publish_time: int
    data: bytes


class Contents(NamedTuple):
    """Summary of a file: channels and the counts of their messages by number, first and last log time, metadata.

    `end` is the byte behind the last whole record; `ended` is False where the end of the data is missing, because the
    file is being written, or was cut.
    """

    topics: dict[int, StoredTopic]
    counts: dict[int, int]
    first_ns: int
    last_ns: int
    metadata: list[Metadata]
    end: int
    ended: bool


class McapReader:
    """The content of one MCAP file; use as a context manager. Raises LogError if it is no MCAP file."""

    def __init__(self, path):
        self.path = Path(path)
        self._schemas: dict[int, bytes] = {}
        self._read_schemas: dict[int, tuple[str, str, str]] = {}
        self._channels: dict[int, bytes] = {}
        self._topics: dict[int, StoredTopic | None] = {}  # None: not wanted
        self._wanted: Container[str] | None = None
        self._packed = self._unpacked = self._records = 0
        self._contents: Contents | None = None
        self._stretches = array("Q")  # start and end time and place of chunks, and of messages outside of them
        self._starts: list[int] = []  # of chunks, where they are known
        self._read_to = len(MAGIC)  # behind the last whole record
        self._whole = False  # whether the end of the data was read
        try:
            self._stream: BinaryIO = self.path.open("rb")
            self._size = self._stream.seek(0, io.SEEK_END)
            head = self._at(0, len(MAGIC))
        except OSError as error:  # files below /proc open, and may have no end to seek
            raise LogError(f"{path} cannot be read ({error.strerror}); give the path of a log") from error
        if head != MAGIC:
            self._stream.close()
            reason = "is empty" if self._size == 0 else "is not an MCAP file"
            raise LogError(f"{path} {reason}; give a log written by bearing_twin or `ros2 bag record -s mcap`")
        footer = self._size - len(MAGIC) - _FOOTER_RECORD
        tail = self._at(max(footer, 0), self._size)
        self.ended = tail[:9] == _HEAD.pack(Opcode.FOOTER, 20) and tail[29:] == MAGIC
        self._footer = self._parse(footer, Footer, tail[9:29]) if self.ended else Footer(0, 0, 0)
        self._data_end = footer if self.ended else self._size
        self._known_end = self.ended and self._footer.summary_start <= footer
        if self._known_end and self._footer.summary_start:
            self._data_end = self._footer.summary_start

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stream.close()

    def _at(self, position: int, size: int) -> bytes:
        self._stream.seek(position)
        return self._stream.read(size)

    def contents(self) -> Contents:
        """Contents by the summary, or read through where that is incomplete; raises DamagedLog."""
        if self._contents is None and self._footer.summary_start:
            try:
                self._contents = self._summarised()
            except DamagedLog:
                self._data_end, self._known_end = self._size - len(MAGIC) - _FOOTER_RECORD, False
                raise
        if self._contents is None:
            self._contents = self._scanned()
        return self._contents

    def require_end(self) -> None:
        """Raises DamagedLog where the end of the data is missing; to be called once the file was read."""
        if not self.ended and not self._whole:
            what = "its end is missing (it is being written, the writer was stopped, or the file was cut)"
            raise DamagedLog(self.path, self._read_to, what)

    def content(
        self, wanted: Container[str] | None = None, begin: int = len(MAGIC), attachments: bool = False
    ) -> Iterator[LoggedMessage | Metadata | Attachment]:
        """Messages of the `wanted` ROS topics (None: of all channels) and metadata from byte `begin` on, as they stand.

        Read from its start the whole file is checked. Raises DamagedLog and LogLimit where reading cannot go on; with
        `attachments` these are among the items.
        """
        whole = begin == len(MAGIC)
        self._want(wanted, whole)
        for offset, opcode, content in self._raw(begin, _USED | {Opcode.ATTACHMENT} if attachments else _USED, whole):
            if opcode in _DATA:
                yield from self._messages(offset, self._data_of(offset, opcode, content), by_time=False)
            elif opcode in (Opcode.METADATA, Opcode.ATTACHMENT):
                yield self._parse(offset, Metadata if opcode == Opcode.METADATA else Attachment, content)
            else:
                self._learn(offset, opcode, content)

    def by_time(
        self, wanted: Container[str] | None = None, from_ns: int = 0, until_ns: int = LAST_NS + 1
    ) -> Iterator[LoggedMessage]:
        """Messages of the `wanted` ROS topics (None: of all channels) from `from_ns` to before `until_ns`, by time.

        Those of one time come in the order of the file. Chunks that hold nothing of it are passed over; a file that is
        read without limits of time is checked whole first.
        """
        self.contents()
        if from_ns <= 0 and until_ns > LAST_NS and not self._whole:
            for _ in self._raw(len(MAGIC), (), True):
                pass
        self._want(wanted)
        rows = np.frombuffer(self._stretches, np.uint64).reshape(-1, 3)
        rows = rows[(rows[:, 1] >= max(from_ns, 0)) & (rows[:, 0] <= min(until_ns - 1, LAST_NS))]
        found = self._merged(rows[np.lexsort((rows[:, 2], rows[:, 0]))].tolist())
        yield from (one for one in found if from_ns <= one.log_time < until_ns)

    def record_after(self, offset: int) -> int | None:
        """Place of the record behind that at `offset` by its length, or of the next chunk of the summary."""
        head = self._at(offset, _HEAD.size)
        found = self._starts[bisect.bisect_right(self._starts, offset) :][:1]
        if len(head) == _HEAD.size and head[0] in _USED | {Opcode.ATTACHMENT, Opcode.MESSAGE_INDEX}:
            found.append(offset + _HEAD.size + _HEAD.unpack(head)[1])
        return min((one for one in found if one < self._data_end), default=None)

    def _want(self, wanted: Container[str] | None, afresh: bool = True) -> None:
        self._wanted = wanted
        self._topics.clear()
        if afresh:
            self._packed = self._unpacked = self._records = 0

    def _summarised(self) -> Contents | None:
        """The contents by the summary, checked; None where it does not describe all of the file."""
        statistics, metadata, start = None, [], self._footer.summary_start
        covered = _HEAD.unpack(self._at(len(MAGIC), _HEAD.size))[1] + len(MAGIC) + _HEAD.size + _DATA_END_RECORD
        for offset, opcode, content in self._summary(start, self._size - len(MAGIC)):
            if opcode == Opcode.CHUNK_INDEX:
                try:
                    *row, channels = _CHUNK_INDEX.unpack_from(content)
                    (indexed,) = struct.unpack_from("<Q", content, _CHUNK_INDEX.size + channels)
                except struct.error:
                    raise DamagedLog(self.path, offset, "the index of a chunk is too short") from None
                self._stretches.extend(row[:3])
                covered += row[3] + indexed
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._learn(offset, opcode, content)
            elif opcode == Opcode.STATISTICS:
                statistics = self._parse(offset, Statistics, content)
            else:
                kind = MetadataIndex if opcode == Opcode.METADATA_INDEX else AttachmentIndex
                index = self._parse(offset, kind, content)
                covered += index.length
                metadata += [index.offset] if kind is MetadataIndex else []
        self._starts = sorted(self._stretches[2::3])
        if (
            statistics is None
            or covered != start
            or any(_schema_of(one) not in (0, *self._schemas) for one in self._channels.values())
            or sum(statistics.channel_message_counts.values()) != statistics.message_count
            or len(self._channels) != statistics.channel_count
        ):
            return None
        found = []
        for place in metadata:
            _, opcode, content = next(self._raw(place, _USED, False), (0, 0, b""))
            if opcode != Opcode.METADATA:
                raise DamagedLog(self.path, place, "the index points to something else than metadata")
            found.append(self._parse(place, Metadata, content))
        times = statistics.message_start_time, statistics.message_end_time
        counts = statistics.channel_message_counts
        return Contents(self._topics_of(counts), counts, *times, found, self._data_end, True)

    def _summary(self, start: int, end: int) -> Iterator[tuple[int, int, bytes]]:
        """Offset, opcode and content of the records of the summary, whose checksum is compared first."""
        if not len(MAGIC) + _HEAD.size <= start <= end - _FOOTER_RECORD:
            raise DamagedLog(self.path, end, "its end names no place of its index")
        if self._footer.summary_crc:
            self._stream.seek(start)
            if self._crc_of(end - start - 4, 0) != self._footer.summary_crc:
                raise DamagedLog(self.path, start, "its index does not have the CRC it was written with")
        used = {Opcode.SCHEMA, Opcode.CHANNEL, Opcode.STATISTICS, Opcode.CHUNK_INDEX}
        return self._raw(start, used | {Opcode.METADATA_INDEX, Opcode.ATTACHMENT_INDEX}, False)

    def _crc_of(self, size: int, crc: int) -> int:
        """The checksum `crc` continued over the next `size` bytes."""
        while size > 0 and (piece := self._stream.read(min(size, _PIECE))):
            crc, size = crc32(piece, crc), size - len(piece)
        return crc

    def _scanned(self) -> Contents:
        """The contents of a file without a usable summary, read through."""
        self._want(())
        del self._stretches[:]
        counts, metadata, rows, end = Counter(), [], self._stretches, len(MAGIC)
        for offset, opcode, content in self._raw(len(MAGIC), _USED, True):
            end = offset + _HEAD.size + len(content)
            if opcode in _DATA:
                numbers, times, _ = self._walked(offset, self._data_of(offset, opcode, content))
                counts.update(numbers)
                rows.extend((min(times, default=0), max(times, default=0), offset))
            elif opcode == Opcode.METADATA:
                metadata.append(self._parse(offset, Metadata, content))
            else:
                self._learn(offset, opcode, content)
        times = min(rows[::3], default=0), max(rows[1::3], default=0)
        end = max(end, self._read_to)
        return Contents(self._topics_of(counts), dict(counts), *times, metadata, end, self._whole)

    def _topics_of(self, counts: dict[int, int]) -> dict[int, StoredTopic]:
        """The channels by number: all that have messages, and some of the others."""
        numbers = [number for number, count in counts.items() if count]
        if len(numbers) > MOST_TOPICS:
            what = f"it has messages on {len(numbers)} channels, and {MOST_TOPICS} are read at most"
            raise LogLimit(self.path, self._data_end, what)
        numbers += itertools.islice((one for one in self._channels if not counts.get(one)), MOST_SILENT)
        return {number: self._described(number) for number in numbers}

    def _merged(self, rows: list[list[int]]) -> Iterator[LoggedMessage]:
        """The messages of stretches by their time; `rows` are in the order of their first times."""
        pending: list[tuple[int, int, int, LoggedMessage]] = []
        held = 0
        for row, following in itertools.zip_longest(rows, rows[1:]):
            while pending and pending[0][0] < row[0]:
                held -= len(pending[0][3].data)
                yield heappop(pending)[3]
            if not pending and (following is None or row[1] < following[0]):
                yield from self._stretch(row[2])
                continue
            for number, message in enumerate(self._stretch(row[2])):
                heappush(pending, (message.log_time, row[2], number, message))
                held += len(message.data)
            if held > MOST_PENDING:
                what = f"its chunks overlap in time by more than {MOST_PENDING >> 20} MB; sort it by `mcap sort`"
                raise LogLimit(self.path, row[2], what)
        while pending:
            yield heappop(pending)[3]

    def _stretch(self, begin: int) -> Iterator[LoggedMessage]:
        """The messages of a chunk in the order of time, or the one outside of chunks that stands there."""
        offset, opcode, content = next(self._raw(begin, _DATA, False), (0, 0, b""))
        if offset != begin or opcode not in _DATA:
            raise DamagedLog(self.path, begin, "the index points to something else than a chunk")
        yield from self._messages(begin, self._data_of(begin, opcode, content), by_time=True)

    def _raw(self, position: int, used: Container[int], check: bool) -> Iterator[tuple[int, int, bytes]]:
        """Offset, opcode and content of the records of the kinds `used`, from byte `position` to the end of a section.

        With `check` (from the start) the checksum of the data is compared.
        """
        if position > self._size:
            raise DamagedLog(self.path, self._size, "the index points outside the file")
        in_data, wrong_end = position < self._data_end, "a record says that the data end here, and they do not"
        data_end = self._at(max(self._data_end - _DATA_END_RECORD, 0), _DATA_END_RECORD) if check else b""
        states_none = self.ended and data_end == _HEAD.pack(Opcode.DATA_END, 4) + bytes(4)
        crc = crc32(MAGIC) if check and not states_none else None
        while position < self._size:
            head = self._at(position, _HEAD.size)
            self._read_to = position
            opcode, length = _HEAD.unpack(head) if len(head) == _HEAD.size else (0, self._size)
            end = position + _HEAD.size + length
            if not self.ended and (end > self._size or not opcode):  # being written, or cut
                return
            if end > self._size:
                raise DamagedLog(self.path, position, "a record goes on beyond the end of the file")
            if opcode == Opcode.FOOTER and not in_data and end == self._size - len(MAGIC):
                return
            if opcode == Opcode.DATA_END:
                if length != 4 or (self._known_end and end != self._data_end):
                    raise DamagedLog(self.path, position, wrong_end)
                expected = int.from_bytes(self._stream.read(4), "little")
                if crc is not None and expected and expected != crc:
                    raise DamagedLog(self.path, position, "the data do not have the CRC they were written with")
                self._read_to, self._whole = end, True
                return
            if not opcode or opcode == Opcode.FOOTER or (in_data and end > self._data_end):
                raise DamagedLog(self.path, position, wrong_end)
            if bisect.bisect_left(self._starts, end) > bisect.bisect_right(self._starts, position):
                raise DamagedLog(self.path, position, "a record goes on into the next chunk")
            if opcode in used:
                if length > LARGEST_RECORD:
                    what = f"a record of {length} bytes is larger than the {LARGEST_RECORD >> 20} MB that are read"
                    raise LogLimit(self.path, position, what)
                content = self._stream.read(length)
                crc = None if crc is None else crc32(content, crc32(head, crc))
                yield position, opcode, content
            elif crc is not None:
                crc = self._crc_of(length, crc32(head, crc))
            position = end
        self._read_to = position

    def _parse(self, offset: int, kind: type, content: bytes):
        try:
            return kind.read(ReadDataStream(io.BytesIO(content)))
        except _PARSE_ERRORS as error:
            raise DamagedLog(self.path, offset, f"a {kind.__name__} record cannot be read ({error})") from error

    def _learn(self, offset: int, opcode: int, content: bytes) -> None:
        """Keeps the description of a schema or channel, which is read when a message needs it."""
        if len(content) < 4:
            raise DamagedLog(self.path, offset, "the description of a channel is too short")
        number = int.from_bytes(content[:2], "little")
        kept, read = (self._schemas, self._read_schemas) if opcode == Opcode.SCHEMA else (self._channels, self._topics)
        if kept.get(number) != content:
            kept[number] = bytes(content)
            read.pop(number, None)

    def _described(self, number: int) -> StoredTopic:
        """The channel of that number; one that nothing describes, or in no UTF-8, has no type and no encoding."""
        try:
            channel = Channel.read(ReadDataStream(io.BytesIO(self._channels[number])))
        except _PARSE_ERRORS:
            return StoredTopic(f"(channel {number})", "", "", "", {}, "", described=False)
        name, text, encoding = self._schema(channel.schema_id)
        return StoredTopic(channel.topic, name, text, channel.message_encoding, channel.metadata, encoding)

    def _schema(self, number: int) -> tuple[str, str, str]:
        """Name, text and encoding of the schema of that number, empty where there is none."""
        if number not in self._read_schemas:
            try:
                schema = Schema.read(ReadDataStream(io.BytesIO(self._schemas[number])))
                found = schema.name, schema.data.decode(errors="surrogateescape"), schema.encoding
            except _PARSE_ERRORS:
                found = "", "", ""
            self._read_schemas[number] = found
        return self._read_schemas[number]

    def _topic(self, number: int) -> StoredTopic | None:
        """The channel of that number, None where it is not wanted; foreign channels are never among wanted topics."""
        if number not in self._topics:
            topic = self._described(number)
            wanted = self._wanted is None or (topic.name in self._wanted and not topic.foreign)
            self._topics[number] = topic if wanted else None
        return self._topics[number]

    def _data_of(self, offset: int, opcode: int, content: bytes) -> bytes:
        """The records in a chunk, or the one of a message outside chunks."""
        if opcode == Opcode.CHUNK:
            return self._unpacked_chunk(offset, content)
        sequence = int.from_bytes(content[2:6], "little")
        if self._packed and sequence == len(content) - 6 and not sequence % 16:  # as stands in an index behind a chunk
            raise DamagedLog(self.path, offset, "the index of messages of a chunk has the kind of a message")
        return _HEAD.pack(opcode, len(content)) + content

    def _messages(self, offset: int, data: bytes, by_time: bool) -> Iterator[LoggedMessage]:
        """The wanted messages among records, in their order or that of time."""
        numbers, times, places = map(np.frombuffer, self._walked(offset, data), (np.uint16, np.uint64, np.uint64))
        topics = {number: self._topic(number) for number in np.unique(numbers).tolist()}
        rows = np.flatnonzero(np.isin(numbers, [number for number, topic in topics.items() if topic is not None]))
        if by_time:
            rows = rows[np.argsort(times[rows], kind="stable")]
        for place in places[rows].tolist():
            _, length, number, _, log_time, publish_time = _MESSAGE.unpack_from(data, place)
            payload = bytes(data[place + _MESSAGE.size : place + _HEAD.size + length])
            yield LoggedMessage(topics[number], log_time, publish_time, payload)

    def _walked(self, offset: int, data: bytes) -> tuple[array, array, array]:
        """Channel, log time and place of each message among records; learns the descriptions among them."""
        numbers, times, places = array("H"), array("Q"), array("Q")
        position, end, head, unpack = 0, len(data), _HEAD.size, _MESSAGE.unpack_from
        whole, records, left = end - _MESSAGE.size, 0, FREE_RECORDS + RECORDS_PER_BYTE * self._size - self._records
        while position < end and records <= left:
            if position <= whole:
                opcode, length, number, _, log_time, _ = unpack(data, position)
            elif position + head <= end:
                opcode, length = _HEAD.unpack_from(data, position)
            else:
                raise DamagedLog(self.path, offset, "a record in this chunk is cut")
            begin, position = position, position + head + length
            if position > end:
                raise DamagedLog(self.path, offset, "a record in this chunk is longer than the chunk")
            records += 1
            if opcode == 5:  # a message
                if length < _FIELDS:
                    raise DamagedLog(self.path, offset, "a message in this chunk is too short")
                numbers.append(number)
                times.append(log_time)
                places.append(begin)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._learn(offset, opcode, data[begin + head : position])
        self._records += records
        if self._records > (most := FREE_RECORDS + RECORDS_PER_BYTE * self._size):
            raise LogLimit(self.path, offset, f"it holds more records than a file of its size may have here, {most}")
        return numbers, times, places

    def _unpacked_chunk(self, offset: int, content: bytes) -> bytes:
        chunk = self._parse(offset, Chunk, content)
        size = chunk.uncompressed_size
        packed, unpacked = self._packed + len(chunk.data), self._unpacked + size
        if size > LARGEST_RECORD or unpacked > FREE_BYTES + GREATEST_RATIO * packed:
            what = f"it unpacks to {unpacked} bytes, more than the {LARGEST_RECORD >> 20} MB a chunk or its size allows"
            raise LogLimit(self.path, offset, what)
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
                what = f"a chunk is compressed by {chunk.compression!r}; convert it to zstd or lz4"
                raise LogLimit(self.path, offset, what)
        except (zstandard.ZstdError, RuntimeError, ValueError, EOFError, MemoryError) as error:
            raise DamagedLog(self.path, offset, f"a chunk cannot be unpacked ({error})") from error
        what = "" if len(data) == size else "size it states"
        if not what and chunk.uncompressed_crc and crc32(data) != chunk.uncompressed_crc:
            what = "CRC it was written with"
        if what:
            del data  # an error holds what its functions hold
            raise DamagedLog(self.path, offset, f"a chunk does not have the {what}")
        return data


def _schema_of(channel: bytes) -> int:
    """The number of the schema of a channel."""
    return int.from_bytes(channel[2:4], "little")


def _lz4_unpacked(packed: bytes, size: int) -> bytearray:
    """The content of `packed`, up to one byte more than `size`, in pieces: in one, lz4 takes twice the memory."""
    unpacker, data = lz4.frame.LZ4FrameDecompressor(), bytearray()
    piece = unpacker.decompress(packed, max_length=_PIECE)
    while piece and len(data) <= size:
        data += piece
        piece = b"" if unpacker.eof else unpacker.decompress(b"", max_length=_PIECE)
    return data
