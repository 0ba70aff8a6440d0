"""MCAP files read behind limits: every length is checked before it is used, every checksum in the file is compared.

The format allows more than ROS 2 writes: channels without a schema or of another encoding, messages outside chunks, no
summary, any order of time, attachments of any size. All of it is read or passed over. `DamagedLog` is raised where
lengths or checksums contradict each other, `LogLimit` where a part that is needed is larger than this reader allows, so
that a small file cannot fill the memory or keep the reader busy. Records are parsed by the library `mcap`; its
`StreamReader` is not used, because it loads attachments and unpacks chunks whole, without a limit.
"""

import bisect
import contextlib
import io
import itertools
import struct
from collections import Counter
from collections.abc import Callable, Container, Iterator
from heapq import heappop, heappush
from pathlib import Path
from typing import BinaryIO, NamedTuple

import lz4.frame
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
LARGEST_MESSAGE = LARGEST_RECORD - (1 << 21)  # bytes, beside what is in its chunk before and what packing adds
FREE_BYTES = 1 << 26  # unpacked bytes any file may have; beyond that GREATEST_RATIO holds
FREE_RECORDS = 200_000  # records any file may have
RECORDS_PER_BYTE = 1  # of the file, beyond that
MOST_TOPICS, MOST_SILENT = 10_000, 1000  # with messages and without: a fifth of a second to read
LAST_NS = (1 << 64) - 1  # the format counts time by 64 bits
MOST_PENDING = 1 << 27  # bytes of messages that wait for earlier ones of chunks that overlap in time

_HEAD = struct.Struct("<BQ")  # of a record: opcode, length
_FIELDS = struct.Struct("<HIQQ")  # of a message: channel, sequence number, log time, publish time
_FOOTER = struct.Struct("<BQQQI")  # head of its record, place of the index, of its groups, checksum
_PIECE = 1 << 20  # bytes that are read, unpacked or put into a stretch of messages together
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
    """What a file holds: channels and the counts of their messages by number, first and last log time, metadata.

    `end` is the byte behind the last whole record; `ended` is False where the end of the data is missing, because the
    file is being written, or was cut. `stretches` are (first time, last time, place) of chunks, and of messages outside
    of them.
    """

    topics: dict[int, StoredTopic]
    counts: dict[int, int]
    first_ns: int
    last_ns: int
    metadata: list[Metadata]
    end: int
    ended: bool
    stretches: list[tuple[int, int, int]]


class McapReader:
    """The content of one MCAP file; use as a context manager. Raises LogError if it is no MCAP file.

    The file is read through and checked before messages are given out, or was when another reader made its `contents`.
    Its index is not relied on: it serves to find damage, and to go on behind that.
    """

    def __init__(self, path, contents: Contents | None = None):
        self.path = Path(path)
        self._contents = contents
        self._schemas: dict[int, bytes] = {}
        self._channels: dict[int, bytes] = {}
        self._topics: dict[int, StoredTopic] = {}
        self._packed = self._unpacked = self._records = 0
        self._read_to = len(MAGIC)  # behind the last whole record
        self._whole = False  # whether the end of the data was read
        self._starts: list[int] = []  # places of chunks by the index
        self._counted: int | None = None  # messages by the index
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
        self._footer = self._size - len(MAGIC) - _FOOTER.size
        tail = self._at(max(self._footer, 0), self._size)
        self._ended = tail[: _HEAD.size] == _HEAD.pack(Opcode.FOOTER, 20) and tail[_FOOTER.size :] == MAGIC
        if self._ended and contents is None:
            self._read_index(tail)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stream.close()

    def _at(self, position: int, size: int) -> bytes:
        self._stream.seek(position)
        return self._stream.read(size)

    def contents(self) -> Contents:
        """What the file holds; raises DamagedLog and LogLimit where it is not whole."""
        if self._contents is None:
            self._contents = self._scanned()
        return self._contents

    def require_end(self) -> None:
        """Raises DamagedLog where the end of the data is missing; to be called once the file was read."""
        if not self._whole:
            what = "its end is missing (it is being written, the writer was stopped, or the file was cut)"
            raise DamagedLog(self.path, self._read_to, what)

    def content(self, damage: list[tuple] | None = None) -> Iterator[LoggedMessage | Metadata | Attachment]:
        """All messages, metadata and attachments as they stand, while they are checked.

        Raises DamagedLog and LogLimit where reading cannot go on; with a list for `damage` place and reason are put
        into it, and reading goes on behind them.
        """
        begin: int | None = len(MAGIC)
        while begin is not None:
            try:
                for offset, opcode, content in self._raw(begin, _USED | {Opcode.ATTACHMENT}):
                    if opcode in _DATA:
                        yield from self._messages(offset, self._data_of(offset, opcode, content), self._topic)
                    elif opcode in (Opcode.METADATA, Opcode.ATTACHMENT):
                        yield self._parse(offset, Metadata if opcode == Opcode.METADATA else Attachment, content)
                    else:
                        self._learn(offset, opcode, content)
                return
            except UnreadableLog as error:
                if damage is None:
                    raise
                damage.append((error.offset, error.what))
                begin = self._record_after(max(error.offset, begin))

    def messages(
        self,
        wanted: Container[str] | None = None,
        from_ns: int = 0,
        until_ns: int = LAST_NS + 1,
        by_time: bool = True,
    ) -> Iterator[LoggedMessage]:
        """Messages of the `wanted` ROS topics (None: of all channels) from `from_ns` to before `until_ns`.

        They come by time, those of one time in the order of the file, or all in that order. Chunks that hold nothing
        of it are passed over.
        """
        topics = self.contents().topics
        if wanted is not None:
            topics = {number: one for number, one in topics.items() if one.name in wanted and not one.foreign}
        rows = [row for row in self.contents().stretches if row[1] >= from_ns and row[0] < until_ns]
        if by_time:
            found = self._merged(sorted(rows), topics)
        else:
            found = (one for row in rows for one in self._messages(row[2], self._data_at(row[2]), topics.get))
        yield from (one for one in found if from_ns <= one.log_time < until_ns)

    def _record_after(self, offset: int) -> int | None:
        """Place of the record behind that at `offset` by its length, or of the next chunk of the index."""
        head = self._at(offset, _HEAD.size)
        found = self._starts[bisect.bisect_right(self._starts, offset) :][:1]
        if len(head) == _HEAD.size and head[0] in _USED | {Opcode.ATTACHMENT, Opcode.MESSAGE_INDEX}:
            found.append(offset + _HEAD.size + _HEAD.unpack(head)[1])
        return min((one for one in found if one < self._size), default=None)

    def _read_index(self, tail: bytes) -> None:
        """Notes where chunks begin by the index, its channels, and how many messages it counts; nothing if damaged."""
        _, _, start, _, crc = _FOOTER.unpack_from(tail)
        if not len(MAGIC) < start < self._footer:
            return
        self._stream.seek(start)
        if crc and crc != self._crc_of(self._footer + _FOOTER.size - 4 - start, 0):
            return
        described = Opcode.SCHEMA, Opcode.CHANNEL
        with contextlib.suppress(DamagedLog, LogLimit, struct.error):
            for offset, opcode, content in self._raw(start, (Opcode.CHUNK_INDEX, Opcode.STATISTICS, *described)):
                if opcode in described:
                    self._learn(offset, opcode, content)
                elif opcode == Opcode.CHUNK_INDEX:
                    self._starts += struct.unpack_from("<Q", content, 16)
                else:
                    self._counted = self._parse(offset, Statistics, content).message_count
        self._starts.sort()

    def _crc_of(self, size: int, crc: int) -> int:
        """The checksum `crc` continued over the next `size` bytes."""
        while size > 0 and (piece := self._stream.read(min(size, _PIECE))):
            crc, size = crc32(piece, crc), size - len(piece)
        return crc

    def _scanned(self) -> Contents:
        """The contents of the file, read through."""
        counts, metadata, stretches = Counter(), [], []
        for offset, opcode, content in self._raw(len(MAGIC)):
            if opcode in _DATA:
                first, last = LAST_NS, 0
                for log_time, _, _, number, _ in self._walked(offset, self._data_of(offset, opcode, content)):
                    counts[number] += 1
                    first, last = min(first, log_time), max(last, log_time)
                if first <= last:
                    stretches.append((first, last, offset))
            elif opcode == Opcode.METADATA:
                metadata.append(self._parse(offset, Metadata, content))
            else:
                self._learn(offset, opcode, content)
        if self._counted not in (None, counts.total()):
            what = f"its index counts {self._counted} messages, and it holds {counts.total()}"
            raise DamagedLog(self.path, self._read_to, what)
        times = min((first for first, _, _ in stretches), default=0), max((last for _, last, _ in stretches), default=0)
        topics = self._topics_of(counts)
        return Contents(topics, dict(counts), *times, metadata, self._read_to, self._whole, stretches)

    def _topics_of(self, counts: dict[int, int]) -> dict[int, StoredTopic]:
        """The channels by number: all that have messages, and some of the others."""
        if len(counts) > MOST_TOPICS:
            what = f"it has messages on {len(counts)} channels, and {MOST_TOPICS} are read at most"
            raise LogLimit(self.path, self._read_to, what)
        silent = itertools.islice((one for one in self._channels if one not in counts), MOST_SILENT)
        return {number: self._topic(number) for number in (*counts, *silent)}

    def _merged(self, rows: list[tuple[int, int, int]], topics: dict[int, StoredTopic]) -> Iterator[LoggedMessage]:
        """The messages of stretches by their time; `rows` are in the order of their first times."""
        pending: list[tuple[int, int, int, LoggedMessage]] = []
        held = 0
        for (first, last, place), following in itertools.zip_longest(rows, rows[1:]):
            while pending and pending[0][0] < first:
                held -= len(pending[0][3].data)
                yield heappop(pending)[3]
            messages = self._messages(place, self._data_at(place), topics.get, by_time=True)
            if not pending and (following is None or last < following[0]):
                yield from messages
                continue
            for number, message in enumerate(messages):
                heappush(pending, (message.log_time, place, number, message))
                held += len(message.data)
            if held > MOST_PENDING:
                what = f"its chunks overlap in time by more than {MOST_PENDING >> 20} MB; sort it by `mcap sort`"
                raise LogLimit(self.path, place, what)
        while pending:
            yield heappop(pending)[3]

    def _raw(self, begin: int, used: Container[int] = _USED) -> Iterator[tuple[int, int, bytes]]:
        """Offset, opcode and content of the records of the kinds `used`, from byte `begin` to the end of a section.

        From the start of the file on the checksum of the data is compared.
        """
        position, crc = begin, crc32(MAGIC) if begin == len(MAGIC) else None
        while position < self._size:
            head = self._at(position, _HEAD.size)
            self._read_to = position
            opcode, length = _HEAD.unpack(head) if len(head) == _HEAD.size else (0, self._size)
            end = position + _HEAD.size + length
            if not self._ended and (end > self._size or not opcode):  # being written, or cut
                return
            if end > self._size:
                raise DamagedLog(self.path, position, "a record goes on beyond the end of the file")
            if opcode == Opcode.FOOTER and position == self._footer:
                return
            if opcode == Opcode.DATA_END and length == 4:
                expected = int.from_bytes(self._stream.read(4), "little")
                if crc is not None and expected not in (0, crc):
                    raise DamagedLog(self.path, position, "the data do not have the CRC they were written with")
                self._read_to, self._whole = end, True
                return
            if opcode in (0, Opcode.DATA_END, Opcode.FOOTER):
                raise DamagedLog(self.path, position, "a record says that the data end here, and they do not")
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
            return _read(kind, content)
        except _PARSE_ERRORS as error:
            raise DamagedLog(self.path, offset, f"a {kind.__name__} record cannot be read ({error})") from error

    def _learn(self, offset: int, opcode: int, content: bytes) -> None:
        """Keeps the description of a schema or channel, which is read when a message needs it."""
        if len(content) < 4:
            raise DamagedLog(self.path, offset, "the description of a channel is too short")
        number = int.from_bytes(content[:2], "little")
        kept = self._schemas if opcode == Opcode.SCHEMA else self._channels
        if kept.get(number) != content:
            kept[number] = bytes(content)
            self._topics.clear()

    def _topic(self, number: int) -> StoredTopic:
        """The channel of that number; one that nothing describes, or in no UTF-8, has no type and no encoding."""
        if number not in self._topics:
            self._topics[number] = self._described(number)
        return self._topics[number]

    def _described(self, number: int) -> StoredTopic:
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

    def _data_at(self, place: int) -> bytes:
        """The records in the chunk of the contents at this place, or the one of a message outside chunks there."""
        offset, opcode, content = next(self._raw(place, _DATA), (0, 0, b""))
        if offset != place:
            raise DamagedLog(self.path, place, "it was changed while it was read")
        self._packed = self._unpacked = self._records = 0  # as a whole it is within the limits
        return self._data_of(place, opcode, content)

    def _data_of(self, offset: int, opcode: int, content: bytes) -> bytes:
        """The records in a chunk, or the one of a message outside chunks."""
        if opcode == Opcode.CHUNK:
            return self._unpacked_chunk(offset, content)
        sequence = int.from_bytes(content[2:6], "little")
        if self._packed and sequence == len(content) - 6 and not sequence % 16:  # as stands in an index behind a chunk
            raise DamagedLog(self.path, offset, "the index of messages of a chunk has the kind of a message")
        return _HEAD.pack(opcode, len(content)) + content

    def _messages(self, offset: int, data: bytes, topic_of: Callable, by_time: bool = False) -> Iterator[LoggedMessage]:
        """The messages among records whose channel `topic_of` gives by its number, in their order or that of time."""
        found = self._walked(offset, data)
        for log_time, begin, end, number, publish_time in sorted(found) if by_time else found:
            if (topic := topic_of(number)) is not None:
                yield LoggedMessage(topic, log_time, publish_time, bytes(data[begin:end]))

    def _walked(self, offset: int, data: bytes) -> Iterator[tuple[int, int, int, int, int]]:
        """Log time, begin and end of the data, channel and publish time of each message; learns the descriptions."""
        position, size, left = 0, len(data), FREE_RECORDS + RECORDS_PER_BYTE * self._size - self._records
        for count in itertools.count(1):
            if position == size:
                self._records += count
                return
            if position + _HEAD.size > size:
                raise DamagedLog(self.path, offset, "a record in this chunk is cut")
            opcode, length = _HEAD.unpack_from(data, position)
            begin, position = position + _HEAD.size, position + _HEAD.size + length
            if position > size:
                raise DamagedLog(self.path, offset, "a record in this chunk is longer than the chunk")
            if count > left:
                self._records += count
                raise LogLimit(self.path, offset, "it holds more records than a file of its size may have here")
            if opcode == 5:  # a message
                if length < _FIELDS.size:
                    raise DamagedLog(self.path, offset, "a message in this chunk is too short")
                number, _, log_time, publish_time = _FIELDS.unpack_from(data, begin)
                yield log_time, begin + _FIELDS.size, position, number, publish_time
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._learn(offset, opcode, data[begin:position])

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
                data = lz4.frame.LZ4FrameFile(io.BytesIO(chunk.data)).read(size + 1)
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


def _read(kind: type, content: bytes):
    """The record of the library of this kind in its bytes."""
    return kind.read(ReadDataStream(io.BytesIO(content)))
