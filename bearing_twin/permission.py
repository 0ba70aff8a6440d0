"""Which files may be read on behalf of somebody else."""

import contextlib
import os
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path

# Folders in which files may be read now, and what they are called; None = wherever the user may read.
ROOM: ContextVar[tuple[tuple[Path, ...], str] | None] = ContextVar("room", default=None)


@contextlib.contextmanager
def only_below(folders: Iterable, called: str) -> Iterator[None]:
    """Within it, files other than those of the package are read only if they lie below one of these folders.

    They must be regular files named *.yaml or *.yml; a relative path counts from each of the folders. What is refused
    is refused in the same words whether it exists or not: who asks may be anybody on the network. `called` is what
    the folders are called in these words.
    """
    token = ROOM.set((tuple(Path(os.path.realpath(folder)) for folder in folders), called))
    try:
        yield
    finally:
        ROOM.reset(token)
