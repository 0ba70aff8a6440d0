"""MCAP files read with limits: every length is checked before it is used, every checksum in the file is compared.

The format allows more than ROS 2 writes: channels without a schema or of another encoding, messages outside chunks, no
summary, any order of time, attachments of any size. All of it is read or skipped. `DamagedLog` is raised where
lengths or checksums contradict each other, `LogLimit` where a part that is needed is larger than this reader allows, so
that a small file cannot fill the memory or keep the reader busy. Records are parsed by the library `mcap`; its
`StreamReader` is not used, because it loads attachments and unpacks chunks whole, without a limit.
"""

import bisect
import contextlib
import io
import itertools
import re
import struct
from array import array
from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator
from heapq import heappop, heappush, heapreplace
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
    Channel,
    Chunk,
    Metadata,
    Schema,
    Statistics,
)

from bearing_twin.base.errors import LogError
from bearing_twin.log.mcap_write import GREATEST_RATIO, MAGIC, StoredTopic, crc32

LARGEST_RECORD = 1 << 26  # bytes, packed or unpacked; writers make chunks of a few megabytes
LARGEST_MESSAGE = LARGEST_RECORD - (1 << 21)  # bytes, besides descriptions in its chunk and the overhead of packing
FREE_BYTES = 1 << 26  # unpacked bytes any file may have; beyond that GREATEST_RATIO holds
FREE_RECORDS = 200_000  # records any file may have
RECORDS_PER_BYTE = 1  # of the file, beyond that
MOST_TOPICS, MOST_SILENT = 10_000, 1000  # with messages and without: a fifth of a second to read
NO_END = "its end is missing (it is being written, the writer was stopped, or the file was cut)"
LAST_NS = (1 << 64) - 1  # the format counts time by 64 bits
_PACKED_CHUNK = re.compile(rb"\x06.{4}\0{4}.{28}(\x04\0\0\0zstd|\x03\0\0\0lz4)", re.DOTALL)  # how such a record begins
_PIECE = 1 << 20  # bytes that are read together
MOST_PENDING = 1 << 27  # bytes of messages that wait for earlier ones of chunks that overlap in time

_HEAD = struct.Struct("<BQ")  # of a record: opcode, length
_MESSAGE = struct.Struct("<BQHIQQ")  # of its record before the data
_FIELDS = np.dtype(  # the same
    {
        "names": ("length", "channel", "log_time"),
        "formats": ("<u8", "<u2", "<u8"),
        "offsets": (1, 9, 15),
        "itemsize": _MESSAGE.size,
    }
)
_FOOTER = struct.Struct("<BQQQI")  # head of its record, offsets of the index and of its groups, checksum
_USED = frozenset({Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE, Opcode.CHUNK, Opcode.METADATA})
_DATA = (Opcode.CHUNK, Opcode.MESSAGE)
_DESCRIBED = (Opcode.SCHEMA, Opcode.CHANNEL)
_PARSE_ERRORS = (McapError, struct.error, ValueError, KeyError, OverflowError, MemoryError)


class UnreadableLog(LogError):
    """Reading cannot continue at byte `offset`, for the `reason`."""

    sentence = ""

    def __init__(self, path, offset: int, reason: str):
        super().__init__(self.sentence.format(path, offset, reason))
        self.path, self.offset, self.reason = path, offset, reason


class DamagedLog(UnreadableLog):
    """The file is cut or altered."""

    sentence = "{0} is damaged at byte {1}: {2}; `bearing_twin recover {0} NEW_LOG` saves what is whole"


class LogLimit(UnreadableLog):
    """A part of the file that is needed is larger than the limit named."""

    sentence = "{} is beyond a limit of bearing_twin at byte {}: {}"


class LoggedMessage(NamedTuple):
    """One message as stored; times in ns."""

    topic: StoredTopic
    log_time: int
    publish_time: int
    data: bytes


class Stretch(NamedTuple):
    """A chunk, or messages in a row outside chunks: first and last log time [ns], offset, numbers of its channels."""

    first_ns: int
    last_ns: int
    offset: int
    channels: frozenset[int]


class Contents(NamedTuple):
    """Contents of a file: channels and the counts of their messages by number, first and last log time, metadata.

    `end` is the byte after the last complete record; `ended` is False where the end of the data is missing, because the
    file is being written or was truncated.
    """

    topics: dict[int, StoredTopic]
    counts: dict[int, int]
    first_ns: int
    last_ns: int
    metadata: list[Metadata]
    end: int
    ended: bool
    stretches: list[Stretch]


class McapReader:
    """The content of one MCAP file; use as a context manager. Raises LogError if it is no MCAP file.

    The whole file is checked before messages are returned, unless `contents` of another reader are given. Its index
    only serves to find damage, and to continue after it.
    """

    def __init__(self, path, contents: Contents | None = None):
        self.path = Path(path)
        self._contents = contents
        self._schemas: dict[int, bytes] = {}
        self._channels: dict[int, bytes] = {}
        self._topics: dict[int, StoredTopic] = {}
        self._packed = self._unpacked = self._record_count = 0
        self._position = len(MAGIC)  # after the last complete record
        self._end_found = False  # whether the end of the data was read
        self._chunk_offsets: list[int] = []  # by the index
        self._indexed_count: int | None = None  # number of messages by the index
        try:
            self._stream: BinaryIO = self.path.open("rb")
            self._size = self._stream.seek(0, io.SEEK_END) if contents is None else contents.end
            head = self._bytes_at(0, len(MAGIC))
        except OSError as error:  # files below /proc open, and may have no end to seek
            raise LogError(f"{path} cannot be read ({error.strerror}); give the path of a log") from error
        if head != MAGIC:
            self._stream.close()
            reason = "is empty" if self._size == 0 else "is not an MCAP file"
            raise LogError(f"{path} {reason}; give a log written by bearing_twin or `ros2 bag record -s mcap`")
        self._footer = self._size - len(MAGIC) - _FOOTER.size
        tail = self._bytes_at(max(self._footer, 0), self._size)
        self._summary = 0  # its offset
        self._has_footer = tail[: _HEAD.size] == _HEAD.pack(Opcode.FOOTER, 20) and tail[_FOOTER.size :] == MAGIC
        if self._has_footer and contents is None:
            self._read_index(tail)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stream.close()

    def _bytes_at(self, position: int, size: int) -> bytes:
        self._stream.seek(position)
        return self._stream.read(size)

    def contents(self) -> Contents:
        """Contents of the file; raises DamagedLog and LogLimit where they cannot be read."""
        if self._contents is None:
            self._contents = self._scan()
        return self._contents

    def content(self, damage: list[tuple] | None = None) -> Iterator[LoggedMessage | Metadata | Attachment]:
        """All messages, metadata and attachments in the order of the file, while they are checked.

        Raises DamagedLog and LogLimit where reading cannot continue, and where the end is missing; with a list
        `damage`, offset and reason are appended to it instead, and reading continues after the damaged part.
        """
        begin: int | None = len(MAGIC)
        while begin is not None:
            try:
                for offset, opcode, content in self._records(begin, _USED | {Opcode.ATTACHMENT}, False):
                    if opcode in _DATA:
                        records = self._records_of(offset, opcode, content)
                        positions = array("q")
                        try:
                            self._walk(offset, records, positions)
                        finally:  # those before the damage
                            yield from _messages(records, positions, self._topic)
                    elif opcode in (Opcode.METADATA, Opcode.ATTACHMENT):
                        yield self._parse(offset, Metadata if opcode == Opcode.METADATA else Attachment, content)
                    else:
                        self._store_description(offset, opcode, content)
                if self._end_found:
                    return
                raise DamagedLog(self.path, self._position, NO_END)
            except UnreadableLog as error:
                if damage is None:
                    raise
                begin = self._next_record(max(error.offset, begin))
                lost = begin is not None and error.reason == NO_END
                damage.append((error.offset, "no record begins here" if lost else error.reason))

    def messages(
        self, names: Container[str] | None = None, from_ns: int = 0, by_time: bool = True
    ) -> Iterator[LoggedMessage]:
        """Messages of the ROS topics `names` (None: of all channels) from `from_ns` on.

        They are sorted by log time, messages of equal time in the order of the file, unless `by_time` is False. Chunks
        before that, or without a message of these topics, are not read.
        """
        topics = self.contents().topics
        if names is not None:
            topics = {number: topic for number, topic in topics.items() if topic.name in names and not topic.foreign}
        rows = [
            row for row in self.contents().stretches if row.last_ns >= from_ns and not row.channels.isdisjoint(topics)
        ]
        numbers = np.array([*topics], np.uint16)

        def select(row: Stretch) -> tuple[bytes, np.ndarray]:
            records = self._records_at(row.offset)
            positions = self._message_positions(row.offset, records)
            times = _field("log_time", records, positions)
            selected = np.isin(_field("channel", records, positions), numbers) & (times >= from_ns)
            if by_time:
                positions, selected = (values[np.argsort(times, kind="stable")] for values in (positions, selected))
            return records, positions[selected]

        if by_time:
            yield from self._merge(sorted(rows), select, topics.get)
        else:
            for row in rows:
                yield from _messages(*select(row), topics.get)

    def _next_record(self, offset: int) -> int | None:
        """Offset of the record that follows that at `offset` by its length, or of a chunk by index or search."""
        head = self._bytes_at(offset, _HEAD.size)
        offsets = self._chunk_after(offset)
        if len(head) == _HEAD.size and head[0] in _USED | {Opcode.ATTACHMENT, Opcode.MESSAGE_INDEX}:
            offsets.append(offset + _HEAD.size + _HEAD.unpack(head)[1])
        return min((offset for offset in offsets if offset <= self._size), default=None) or self._search(offset + 1)

    def _search(self, offset: int) -> int | None:
        """Offset of the next packed chunk, by how such a record begins."""
        while data := self._bytes_at(offset, 1 << 16):
            if match := _PACKED_CHUNK.search(data):
                return offset + match.start()
            offset += max(1, len(data) - 48)  # as long as a beginning is
        return None

    def _chunk_after(self, offset: int) -> list[int]:
        """The offset of the next chunk of the index, if there is one."""
        number = bisect.bisect_right(self._chunk_offsets, offset)
        return self._chunk_offsets[number : number + 1]

    def _read_index(self, tail: bytes) -> None:
        """Reads the offsets of chunks, the channels and the number of messages from an index that is not damaged."""
        _, _, start, _, crc = _FOOTER.unpack_from(tail)
        self._summary = start
        if not len(MAGIC) < start < self._footer:
            return
        self._stream.seek(start)
        if crc and crc != self._update_crc(self._footer + _FOOTER.size - 4 - start, 0):
            return
        with contextlib.suppress(DamagedLog, LogLimit, struct.error):
            for offset, opcode, content in self._records(start, (Opcode.CHUNK_INDEX, Opcode.STATISTICS, *_DESCRIBED)):
                if opcode in _DESCRIBED:
                    self._store_description(offset, opcode, content)
                elif opcode == Opcode.CHUNK_INDEX:
                    self._chunk_offsets += struct.unpack_from("<Q", content, 16)
                else:
                    self._indexed_count = self._parse(offset, Statistics, content).message_count
        self._chunk_offsets.sort()

    def _update_crc(self, size: int, crc: int) -> int:
        """The checksum `crc` continued over the next `size` bytes of the file."""
        while size > 0 and (piece := self._stream.read(min(size, _PIECE))):
            crc, size = crc32(piece, crc), size - len(piece)
        return crc

    def _scan(self) -> Contents:
        """The contents, from reading the whole file."""
        counts, metadata, stretches, known = Counter(), [], [], {}
        for offset, opcode, content in self._records(len(MAGIC)):
            if opcode in _DATA:
                records = self._records_of(offset, opcode, content)
                positions = self._message_positions(offset, records)
                if not len(positions):
                    continue
                times = _field("log_time", records, positions)
                numbers, amounts = np.unique(_field("channel", records, positions), return_counts=True)
                counts.update(dict(zip(numbers.tolist(), amounts.tolist(), strict=True)))
                channels = frozenset(numbers.tolist())
                channels = known.setdefault(channels, channels)
                stretches.append(Stretch(int(times.min()), int(times.max()), offset, channels))
            elif opcode == Opcode.METADATA:
                metadata.append(self._parse(offset, Metadata, content))
            else:
                self._store_description(offset, opcode, content)
        if self._indexed_count not in (None, counts.total()):
            reason = f"its index counts {self._indexed_count} messages, and it holds {counts.total()}"
            raise DamagedLog(self.path, self._position, reason)
        first_ns = min((stretch.first_ns for stretch in stretches), default=0)
        last_ns = max((stretch.last_ns for stretch in stretches), default=0)
        topics = self._topics_of(counts)
        return Contents(topics, dict(counts), first_ns, last_ns, metadata, self._position, self._end_found, stretches)

    def _topics_of(self, counts: dict[int, int]) -> dict[int, StoredTopic]:
        """The channels by number: all with messages, and at most MOST_SILENT without."""
        if len(counts) > MOST_TOPICS:
            reason = f"it has messages on {len(counts)} channels, and {MOST_TOPICS} are read at most"
            raise LogLimit(self.path, self._position, reason)
        silent = itertools.islice((number for number in self._channels if number not in counts), MOST_SILENT)
        return {number: self._topic(number) for number in (*counts, *silent)}

    def _merge(self, rows: list[Stretch], select: Callable, topic_of: Callable) -> Iterator[LoggedMessage]:
        """The messages of stretches sorted by time; `rows` are sorted by their first times.

        Of stretches that overlap in time the messages after the next one's first are copied, to wait in a heap.
        """
        waiting: list[tuple] = []  # of a stretch: time of its next message, offset, this message, the others, bytes
        size = 0
        for row, following in itertools.zip_longest(rows, rows[1:]):
            records, positions = select(row)
            end = LAST_NS + 1 if following is None else following.first_ns
            ready = np.count_nonzero(_field("log_time", records, positions) < end)
            copies, places = _copied(records, positions[ready:])
            size += len(copies)
            if size > MOST_PENDING:
                reason = f"its chunks overlap in time by more than {MOST_PENDING >> 20} MB; sort it by `mcap sort`"
                raise LogLimit(self.path, row.offset, reason)
            due = _messages(records, positions[:ready], topic_of)
            if not waiting:
                yield from due
            for messages, held in ((due, 0), (_messages(copies, places, topic_of), len(copies))):
                if (message := next(messages, None)) is not None:
                    heappush(waiting, (message.log_time, row.offset, message, messages, held))
            while waiting and waiting[0][0] < end:
                _, offset, message, messages, held = waiting[0]
                yield message
                if (message := next(messages, None)) is not None:
                    heapreplace(waiting, (message.log_time, offset, message, messages, held))
                else:
                    heappop(waiting)
                    size -= held

    def _records(
        self, begin: int, used: Container[int] = _USED, in_rows: bool = True
    ) -> Iterator[tuple[int, int, bytes]]:
        """Offset, opcode and content of the records with an opcode in `used`, from byte `begin` to the section's end.

        From the start of the file on, the checksum of the data is compared. With `in_rows` messages outside chunks are
        read together; without, damage to one is found at its own offset.
        """
        position, crc = begin, crc32(MAGIC) if begin == len(MAGIC) else None
        while position < self._size:
            head = self._bytes_at(position, _HEAD.size)
            self._position = position
            opcode, length = _HEAD.unpack(head) if len(head) == _HEAD.size else (0, self._size)
            end = position + _HEAD.size + length
            if not self._has_footer and (end > self._size or not opcode):  # being written, or cut
                return
            if end > self._size:
                raise DamagedLog(self.path, position, "a record goes on beyond the end of the file")
            if opcode == Opcode.FOOTER and position == self._footer:
                return
            if opcode == Opcode.DATA_END and (length == 4 or (length > 4 and end in (self._footer, self._summary))):
                expected = int.from_bytes(self._stream.read(4), "little")
                if crc is not None and expected not in (0, crc):
                    raise DamagedLog(self.path, position, "the data do not have the CRC they were written with")
                self._position, self._end_found = end, True
                return
            if opcode in (0, Opcode.DATA_END, Opcode.FOOTER):
                raise DamagedLog(self.path, position, "a record says that the data end here, and they do not")
            if any(chunk < end for chunk in self._chunk_after(position)):
                raise DamagedLog(self.path, position, "a record goes on into the next chunk")
            if opcode in used:
                if length > LARGEST_RECORD:
                    reason = f"a record of {length} bytes is larger than the {LARGEST_RECORD >> 20} MB that are read"
                    raise LogLimit(self.path, position, reason)
                content = self._stream.read(length)
                crc = None if crc is None else crc32(content, crc32(head, crc))
                if opcode == Opcode.MESSAGE:
                    more = self._loose_records(end) if in_rows else b""
                    crc = None if crc is None else crc32(more, crc)
                    content = head + content + more
                    end += len(more)
                yield position, opcode, content
            elif crc is not None:
                crc = self._update_crc(length, crc32(head, crc))
            position = end
        self._position = position

    def _loose_records(self, position: int) -> bytes:
        """The records of messages and descriptions from `position` on that are complete within a piece of the file."""
        size = min([position + _PIECE, self._size, *self._chunk_after(position - 1)]) - position
        begin, data = 0, self._bytes_at(position, size)
        while begin + _HEAD.size <= len(data):
            opcode, length = _HEAD.unpack_from(data, begin)
            end = begin + _HEAD.size + length
            if opcode not in (Opcode.MESSAGE, *_DESCRIBED) or end > len(data):
                break
            begin = end
        return data[:begin]

    def _parse(self, offset: int, kind: type, content: bytes):
        try:
            return _read(kind, content)
        except _PARSE_ERRORS as error:
            raise DamagedLog(self.path, offset, f"a {kind.__name__} record cannot be read ({error})") from error

    def _store_description(self, offset: int, opcode: int, content: bytes) -> None:
        """Stores the record of a schema or channel, which is parsed when a message needs it."""
        if len(content) < 4:
            raise DamagedLog(self.path, offset, "the description of a channel is too short")
        number = int.from_bytes(content[:2], "little")
        descriptions = self._schemas if opcode == Opcode.SCHEMA else self._channels
        if descriptions.get(number) != content:
            descriptions[number] = bytes(content)
            self._topics.clear()

    def _topic(self, number: int) -> StoredTopic:
        """The channel of that number, from `_topics` once it was parsed."""
        if number not in self._topics:
            self._topics[number] = self._parse_topic(number)
        return self._topics[number]

    def _parse_topic(self, number: int) -> StoredTopic:
        """The channel of that number; without a record in UTF-8 that describes it, it has no type and no encoding."""
        try:
            channel = _read(Channel, self._channels[number])
        except _PARSE_ERRORS:
            return StoredTopic(f"(channel {number})", "", "", "", {}, "")
        try:
            schema = _read(Schema, self._schemas[channel.schema_id])
            name, text, encoding = schema.name, schema.data.decode(errors="surrogateescape"), schema.encoding
        except _PARSE_ERRORS:
            name = text = encoding = ""
        return StoredTopic(channel.topic, name, text, channel.message_encoding, channel.metadata, encoding)

    def _records_at(self, offset: int) -> bytes:
        """The records in the stretch at `offset`."""
        start, opcode, content = next(self._records(offset, _DATA), (0, 0, b""))
        if start != offset:
            raise DamagedLog(self.path, offset, "it was changed while it was read")
        self._packed = self._unpacked = self._record_count = 0  # the file as a whole is within the limits
        return self._records_of(offset, opcode, content)

    def _records_of(self, offset: int, opcode: int, content: bytes) -> bytes:
        """The records in a chunk, or those outside chunks, which `content` is then."""
        if opcode == Opcode.CHUNK:
            return self._unpack(offset, content)
        _, length, _, sequence, *_ = _MESSAGE.unpack_from(content.ljust(_MESSAGE.size))
        if self._packed and sequence == length - 6 and not sequence % 16:  # as in an index after a chunk
            raise DamagedLog(self.path, offset, "the index of messages of a chunk has the kind of a message")
        return content

    def _message_positions(self, offset: int, records: bytes) -> np.ndarray:
        """Positions of messages among the records of a stretch; stores descriptions."""
        positions = array("q")
        self._walk(offset, records, positions)
        return np.array(positions)

    def _walk(self, offset: int, records: bytes, positions: array) -> None:
        """Appends the positions of messages, also where records are damaged further on."""
        position, size = 0, len(records)
        limit = FREE_RECORDS + RECORDS_PER_BYTE * self._size - self._record_count
        for count in range(limit + 1):
            if position == size:
                self._record_count += count
                return
            if position + _HEAD.size > size:
                raise DamagedLog(self.path, offset, "a record in this chunk is cut")
            opcode, length = _HEAD.unpack_from(records, position)
            end = position + _HEAD.size + length
            if end > size:
                raise DamagedLog(self.path, offset, "a record in this chunk is longer than the chunk")
            if opcode == 5:  # a message
                if position + _MESSAGE.size > end:
                    raise DamagedLog(self.path, offset, "a message in this chunk is too short")
                positions.append(position)
            elif opcode in _DESCRIBED:
                self._store_description(offset, opcode, records[position + _HEAD.size : end])
            position = end
        self._record_count += limit
        raise LogLimit(self.path, offset, "it holds more records than a file of its size may have here")

    def _unpack(self, offset: int, content: bytes) -> bytes:
        chunk = self._parse(offset, Chunk, content)
        size = chunk.uncompressed_size
        packed, unpacked = self._packed + len(chunk.data), self._unpacked + size
        if size > LARGEST_RECORD or unpacked > FREE_BYTES + GREATEST_RATIO * packed:
            limit = f"more than the {LARGEST_RECORD >> 20} MB a chunk or its size allows"
            raise LogLimit(self.path, offset, f"it unpacks to {unpacked} bytes, {limit}")
        self._packed, self._unpacked = packed, unpacked
        try:
            if chunk.compression == "zstd":
                # Bounded by `read`: the size written inside the zstd frame is not to be trusted.
                data = zstandard.ZstdDecompressor().stream_reader(chunk.data, read_across_frames=True).read(size + 1)
            elif chunk.compression == "lz4":
                data = lz4.frame.LZ4FrameFile(io.BytesIO(chunk.data)).read(size + 1)
            elif chunk.compression == "":
                data = chunk.data
            else:
                reason = f"a chunk is compressed by {chunk.compression!r}; convert it to zstd or lz4"
                raise LogLimit(self.path, offset, reason)
        except (zstandard.ZstdError, RuntimeError, ValueError, EOFError, MemoryError) as error:
            raise DamagedLog(self.path, offset, f"a chunk cannot be unpacked ({error})") from error
        if len(data) != size:
            mismatch = "size it states"
        elif chunk.uncompressed_crc and crc32(data) != chunk.uncompressed_crc:
            mismatch = "CRC it was written with"
        else:
            return data
        del data  # an error keeps the variables of its functions
        raise DamagedLog(self.path, offset, f"a chunk does not have the {mismatch}")


def _read(kind: type, content: bytes):
    """The record of the class `kind` of the library `mcap` in these bytes."""
    return kind.read(ReadDataStream(io.BytesIO(content)))


def _field(name: str, records: bytes, positions: np.ndarray) -> np.ndarray:
    """A field of the messages at these positions among records."""
    heads = np.ndarray(max(0, len(records) - _FIELDS.itemsize + 1), _FIELDS, records, strides=(1,))
    return heads[name][positions]


def _messages(records: bytes, positions: Iterable[int], topic_of: Callable) -> Iterator[LoggedMessage]:
    """The messages at these positions among records, with the channel that `topic_of` returns by its number."""
    for position in memoryview(positions):
        _, length, number, _, log_time, publish_time = _MESSAGE.unpack_from(records, position)
        data = records[position + _MESSAGE.size : position + _HEAD.size + length]
        yield LoggedMessage(topic_of(number), log_time, publish_time, data)


def _copied(records: bytes, positions: np.ndarray) -> tuple[bytes, np.ndarray]:
    """The messages at these positions alone, and their positions then."""
    sizes = _HEAD.size + _field("length", records, positions).astype(np.int64)
    ends = positions + sizes
    copies = [records[begin:end] for begin, end in zip(positions.tolist(), ends.tolist(), strict=True)]
    return b"".join(copies), np.cumsum(sizes) - sizes
