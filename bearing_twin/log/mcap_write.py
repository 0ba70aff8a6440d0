"""An MCAP file while it is written: what has been appended stays readable after any failure.

Every append is all or nothing, and nothing that was appended is written again. Chunks end by content, so that the same
messages give the same bytes, and at each `flush`.
"""

import contextlib
import errno
import os
import struct
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import lz4.frame
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from bearing_twin.base.errors import LogError

try:  # four to five times as fast as zlib, on which a log would wait
    from zlib_ng.zlib_ng import crc32
except ImportError:  # no package of Debian, so that a ROS installed from there lacks it
    from zlib import crc32

MAGIC = b"\x89MCAP0\r\n"
CHUNK_BYTES = 512 * 1024
HELD_BYTES = 16 * 1024 * 1024  # of messages that may wait for room on the disk
COMPRESSION, LESS_PACKED = "zstd", "lz4"
COMPRESSION_LEVEL = -10  # an eighth of the time of the default level 3, for files 13 % larger
GREATEST_RATIO = 5000  # unpacked / packed bytes, beyond which readers take a chunk for a bomb; of lz4 it is below 256
_MESSAGE = struct.Struct("<BQHIQQ")
_FOOTER_START = struct.Struct("<BQQQ")


FIELDS = 22  # bytes of a message record besides its data, after opcode and length


class StoredTopic(NamedTuple):
    """A channel of a log as stored: topic, type and text of its definition ("" without a schema), encodings, metadata.

    A definition that is not UTF-8 has its bytes as surrogates.
    """

    name: str
    ros_type: str
    definition: str
    message_encoding: str
    metadata: dict[str, str]
    schema_encoding: str = "ros2msg"

    @property
    def foreign(self) -> bool:
        """True where no ROS 2 program can read its messages: without a schema, or not in CDR."""
        return self.message_encoding != "cdr" or not self.ros_type

    @property
    def identity(self) -> tuple:
        """A key that distinguishes it from other channels."""
        return self[:4] + self[5:] + tuple(sorted(self.metadata.items()))


NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class FullDisk(LogError):
    """There is no room for a log, or for more of it; where it is written and how is not to blame."""


def log_error(sentence: str, error: BaseException) -> LogError:
    """The LogError for an error of the system; FullDisk where the disk is full."""
    return (FullDisk if getattr(error, "errno", None) in NO_ROOM else LogError)(sentence)


class McapWriter:
    """A new MCAP file at `path`, profile `ros2`; raises LogError if the path exists or cannot be written.

    With `fsync` a flush also outlives the machine. A `patient` file keeps messages in memory while the disk is full, as
    many as fit, and goes on when there is room; `dropped` counts the others. Any other file has failed then for good.
    """

    def __init__(self, path: Path, library: str, fsync: bool = False, patient: bool = False):
        self.path = Path(path)
        self._fsync, self._patient = fsync, patient
        try:
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        except OSError as error:
            raise log_error(
                f"{path} cannot be written ({error.strerror}); give another place for the log", error
            ) from error
        self.bytes = 0  # of the file, up to which it is complete
        self._crc = 0  # of what was appended
        self.problem = ""  # why the file cannot grow, and how much is in it
        self._closed = False
        self._index = bytearray()  # of the chunks, 10 MB an hour of a bearing of eight balls
        self._compressor = zstandard.ZstdCompressor(level=COMPRESSION_LEVEL)
        self._room = bytearray()  # the chunk in progress
        self._chunk_index: defaultdict[int, list[tuple[int, int]]] = defaultdict(list)  # time and offset of messages
        self.dropped = 0
        self._waiting: list[Schema | Channel] = []  # described in the unfinished chunk
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._channels = 0
        self._described: list[Schema | Channel] = []
        self._chunks = 0
        self._added: list[MetadataIndex | AttachmentIndex] = []
        self.counts: dict[int, int] = {}  # messages on disk for good, by channel
        self.first_ns: int | None = None
        self.last_ns = 0
        try:
            self._append((MAGIC + _record(Header("ros2", library)),))
        except LogError as error:
            self.discard()
            cause = error.__cause__
            raise log_error(
                f"{path} cannot be written ({cause.strerror}); give another place for the log", cause
            ) from error

    def register(self, topic: StoredTopic) -> int:
        """Describes a channel and returns its number; without a type and a schema's encoding it gets no schema."""
        data, schema_id = topic.definition.encode(errors="surrogateescape"), 0
        if topic.ros_type or topic.schema_encoding:
            schema = topic.ros_type, topic.schema_encoding, data
            if (schema_id := self._schemas.get(schema, 0)) == 0:
                schema_id = self._schemas[schema] = len(self._schemas) + 1
                self._describe(Schema(id=schema_id, data=data, encoding=schema[1], name=schema[0]))
        self._channels += 1
        self._describe(
            Channel(
                id=self._channels,
                schema_id=schema_id,
                topic=topic.name,
                message_encoding=topic.message_encoding,
                metadata=topic.metadata,
            )
        )
        self.counts[self._channels] = 0
        return self._channels

    def write_all(self, messages: Iterable[tuple[int, int, int, bytes]]) -> None:
        """Adds messages (channel, log time, publish time, data).

        Raises LogError, with the number of messages in the file, once the file cannot grow. A patient file keeps them
        in memory then, and raises LogError for the first one for which there is no room in memory either.
        """
        index, pack = self._chunk_index, _MESSAGE.pack
        for channel, log_time, publish_time, data in messages:
            room = self._room
            if self.problem or self._closed:
                self._check_room(len(room) + len(data))
            index[channel].append((log_time, len(room)))
            room += pack(Opcode.MESSAGE, FIELDS + len(data), channel, 0, log_time, publish_time)
            room += data
            if len(room) >= CHUNK_BYTES and not self.problem:
                self.end_chunk()

    def add(self, record: Metadata | Attachment) -> None:
        """Adds a metadata record or an attachment; it ends the chunk in progress."""
        self._check_open()
        self.end_chunk()
        content, offset = _record(record), self.bytes
        self._append((content,))
        if isinstance(record, Metadata):
            self._added.append(MetadataIndex(offset, len(content), record.name))
        else:
            sizes = {"offset": offset, "length": len(content), "data_size": len(record.data)}
            fields = ("log_time", "create_time", "name", "media_type")
            self._added.append(AttachmentIndex(**sizes, **{field: getattr(record, field) for field in fields}))

    def end_chunk(self) -> None:
        """Appends the chunk in progress for good; descriptions without a message wait for the next."""
        if not self._chunk_index:
            return
        times = [log_time for entries in self._chunk_index.values() for log_time, _ in entries]
        first, last = min(times), max(times)
        parts, index = self._build_chunk(first, last)
        self._append(parts)
        self._index += index
        self._chunks += 1
        for channel, entries in self._chunk_index.items():
            self.counts[channel] += len(entries)
        self.first_ns = first if self.first_ns is None else min(self.first_ns, first)
        self.last_ns = max(self.last_ns, last)
        self._described += self._waiting
        self._waiting = []
        self._room = bytearray()
        self._chunk_index.clear()

    def flush(self) -> None:
        """Writes every message so far to disk, also those that waited for room; raises LogError if it is full."""
        if self._closed or not self._patient:
            self._check_open()
        self.end_chunk()
        self.problem = ""  # not before: other threads read `problem`
        if self._fsync:
            os.fsync(self._file)

    def close(self) -> None:
        """Writes pending messages and the index, and closes the file; raises LogError if that is impossible.

        Where there is no room for pending messages, those on disk get their index if it fits.
        """
        if self._closed:
            return
        self._closed = True
        try:
            try:
                if self._patient or not self.problem:
                    self.end_chunk()
            finally:
                self.problem = ""
                self._append(self._build_summary())
                with contextlib.suppress(OSError):
                    os.ftruncate(self._file, self.bytes)  # bytes that another program appended
                    os.fsync(self._file)
        finally:
            os.close(self._file)

    def discard(self) -> None:
        """Closes and removes the file."""
        self._closed = True
        os.close(self._file)
        self.path.unlink(missing_ok=True)

    @property
    def has_messages(self) -> bool:
        """True once a message has been written."""
        return bool(self._chunk_index) or self.first_ns is not None

    def _check_room(self, used: int) -> None:
        """Raises LogError where a message cannot be taken that would fill the chunk in progress up to `used` bytes."""
        if not self._patient:
            self._check_open()
        elif self.problem and used > HELD_BYTES:
            self.dropped += 1
            self._check_open()

    def _check_open(self) -> None:
        if self.problem:
            raise LogError(self.problem)
        if self._closed:
            raise LogError(f"{self.path} is closed; write to a new log")

    def _describe(self, record: Schema | Channel) -> None:
        self._room += _record(record)
        self._waiting.append(record)

    def _build_chunk(self, first: int, last: int) -> tuple[list[bytes], bytes]:
        """The chunk in progress with its message index, for the end of the file; and its chunk index record.

        `first` and `last` are its least and greatest log time.
        """
        content = self._room
        name, packed = COMPRESSION, self._compressor.compress(content)
        if len(content) > GREATEST_RATIO * len(packed):  # such as zeros, which would look like a bomb
            name, packed = LESS_PACKED, lz4.frame.compress(content)
        times = {"message_start_time": first, "message_end_time": last}
        sizes = {"uncompressed_crc": crc32(content), "uncompressed_size": len(content)}
        parts = [_record(Chunk(compression=name, data=packed, **times, **sizes))]
        offsets, position = {}, self.bytes + len(parts[0])
        for channel, entries in self._chunk_index.items():
            offsets[channel] = position
            parts.append(_record(MessageIndex(channel, entries)))
            position += len(parts[-1])
        index = ChunkIndex(
            chunk_length=len(parts[0]),
            chunk_start_offset=self.bytes,
            compression=name,
            compressed_size=len(packed),
            message_index_length=position - self.bytes - len(parts[0]),
            message_index_offsets=offsets,
            uncompressed_size=len(content),
            **times,
        )
        return [parts[0], b"".join(parts[1:])], _record(index)  # the system writes at most 1024 parts together

    def _build_summary(self) -> list[bytes]:
        """End of the data section, summary with the index of the chunks on disk, and footer."""
        data_end = _record(DataEnd(self._crc))
        start = self.bytes + len(data_end)
        channels = [record.id for record in self._described if isinstance(record, Channel)]
        metadata = sum(isinstance(record, MetadataIndex) for record in self._added)
        statistics = Statistics(
            attachment_count=len(self._added) - metadata,
            channel_count=len(channels),
            channel_message_counts={channel: self.counts[channel] for channel in channels},
            chunk_count=self._chunks,
            message_count=sum(self.counts.values()),
            message_end_time=self.last_ns,
            message_start_time=self.first_ns or 0,
            metadata_count=metadata,
            schema_count=len(self._described) - len(channels),
        )
        schemas_first = sorted(self._described, key=lambda record: isinstance(record, Channel))
        before, after = (b"".join(map(_record, records)) for records in ((*schemas_first, statistics), self._added))
        summary = b"".join((before, self._index, after))
        crc = crc32(_FOOTER_START.pack(Opcode.FOOTER, 20, start, 0), crc32(summary))
        return [
            data_end,
            summary,
            _record(Footer(summary_start=start, summary_offset_start=0, summary_crc=crc)) + MAGIC,
        ]

    def _append(self, parts: Sequence[bytes]) -> None:
        """Appends parts to the complete part of the file; on failure none of them remains."""
        status = os.fstat(self._file)
        if status.st_size < self.bytes or not status.st_nlink:  # a file that was moved continues there
            self.problem = f"{self.path} was removed or cut by another program; write to a new log"
            raise LogError(self.problem)
        size = sum(map(len, parts))
        try:
            done = os.pwritev(self._file, parts, self.bytes)
            while done < size:  # a file seldom takes less than all
                done += os.pwritev(self._file, (memoryview(b"".join(parts))[done:],), self.bytes + done)
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self.bytes)
            count = f"{sum(self.counts.values())} messages (up to t = {self.last_ns * 1e-9:.6f} s) are kept"
            self.problem = (
                f"{self.path} cannot grow ({error.strerror}): {'no message is' if self.first_ns is None else count} in "
                f"it; make room{'' if self._patient else ' and write to a new log'}"
            )
            raise log_error(self.problem, error) from error
        self.bytes += size
        for part in parts:
            self._crc = crc32(part, self._crc)


def _record(record) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
