"""Disks that fill up."""

import errno
import os


def full_after(writes: int, monkeypatch) -> None:
    """The disk has room for so many writes of logs, and for none after them."""
    write, calls = os.pwritev, []

    def full(*arguments):
        calls.append(arguments)
        if len(calls) > writes:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(*arguments)

    monkeypatch.setattr(os, "pwritev", full)
