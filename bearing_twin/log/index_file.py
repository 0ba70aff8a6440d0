"""The index of a log while it is written: in a file without a name, which also holds back room for the log's end.

In memory it would grow by tens of megabytes an hour.
"""

import errno
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

RESERVE_BYTES = 256 * 1024
PIECE = 1 << 20  # bytes of the index that are in memory at a time


class IndexFile:
    """Records of an index in the folder of their log, and as much room again; it vanishes with this process.

    Raises OSError where the disk has no room for it.
    """

    def __init__(self, folder: Path):
        self._file = tempfile.TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115
        self._bytes = self._reserved = 0
        self._in_memory: list[bytes] = []  # records for which the file had no room
        self._reserve()

    def keep(self, record: bytes) -> None:
        """Adds one record."""
        try:
            if 2 * (self._bytes + len(record)) + RESERVE_BYTES // 2 > self._reserved:
                self._reserve()
            self._file.seek(self._bytes)
            if self._file.write(record) != len(record):
                raise OSError(errno.ENOSPC, "no room")
            self._bytes += len(record)
        except (OSError, ValueError):  # the next append to the log will tell; ValueError: it is closed
            self._in_memory.append(record)

    def release(self) -> None:
        """Gives the disk space back that holds no record."""
        self._file.truncate(self._bytes)

    def pieces(self) -> Iterator[bytes]:
        """All records in order, some at a time."""
        for begin in range(0, self._bytes, PIECE):
            yield os.pread(self._file.fileno(), min(PIECE, self._bytes - begin), begin)
        yield b"".join(self._in_memory)

    def close(self) -> None:
        """Gives all disk space back; may be called twice."""
        self._file.close()

    def _reserve(self) -> None:
        self._file.seek(self._reserved)
        self._reserved += self._file.write(bytes(RESERVE_BYTES))
