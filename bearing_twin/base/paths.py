"""Shared files of the package, files written whole or not at all, and files that may be read on behalf of peers."""

import contextlib
import functools
import os
import re
import shutil
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path

from bearing_twin.base.errors import BearingTwinError

LONGEST_NAME = 60  # letters of a file's name, of four bytes each at most: systems take 255 with what follows


def share_path(*parts: str) -> Path:
    """Path of a shared file or folder, given by its parts ("config", "scenes").

    In a checkout (also an editable or symlinked install) the folders lie beside the package; installed by
    colcon or pip they lie in share/bearing_twin of the prefix. Raises BearingTwinError when neither has it.
    """
    roots = _roots(__file__)
    for root in roots:
        if (path := root.joinpath(*parts)).exists() and (root / "package.xml").is_file():
            return path
    raise BearingTwinError(
        f"{'/'.join(parts)} of bearing_twin is neither in {roots[0]} nor in a share/bearing_twin above: reinstall it."
    )


@functools.cache
def _roots(module_file: str) -> list[Path]:
    """Folders of shared files; cached, since links of all folders above are followed and every scene needs them."""
    package = Path(module_file).resolve().parent.parent
    return [package.parent, *(folder / "share" / "bearing_twin" for folder in package.parents)]


def file_name(text: str) -> str:
    """A name from a log, a scene or a goal as a file name: without folders, and not hidden."""
    return re.sub(r"[^\w.-]+", "_", text).strip(".")[:LONGEST_NAME] or "_"


def user_folder(name: str) -> Path:
    """The folder of the user's own files of a kind, `$XDG_CONFIG_HOME/bearing_twin/<name>`; it need not exist."""
    home = os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    return Path(home) / "bearing_twin" / name


def write_atomic(path, content: bytes) -> Path:
    """Write a file as `replace_file` does; raises BearingTwinError where it cannot be written."""
    try:
        replace_file(Path(path), content)
    except OSError as error:
        raise BearingTwinError(f"{path} cannot be written ({error.strerror or error}); give another path") from error
    return Path(path)


def replace_file(path: Path, content: bytes) -> None:
    """Write a file by `draft_file`; raises OSError where it cannot be written."""
    with draft_file(path) as draft:
        draft.write_bytes(content)


@contextlib.contextmanager
def draft_file(path: Path) -> Iterator[Path]:
    """A temporary file in the same folder, renamed to `path` at the end: on a full disk an earlier file stays.

    The permissions of an earlier file are kept. A link stays one; devices and pipes are written directly. Processes
    that write one file at the same time have a draft each. Raises OSError where it cannot be written.
    """
    target = path.resolve()
    if target.exists() and not target.is_file():
        yield target
        return
    draft = target.with_name(f".{os.urandom(8).hex()}.part{target.suffix}")
    try:
        draft.touch(exist_ok=False)
        yield draft
        with contextlib.suppress(FileNotFoundError):
            shutil.copymode(target, draft)
        os.replace(draft, target)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


# Folders in which files may be read now, and their name in messages; None = wherever the user may read.
READABLE: ContextVar[tuple[tuple[Path, ...], str] | None] = ContextVar("readable", default=None)


@contextlib.contextmanager
def restrict_reading(folders: Iterable, called: str) -> Iterator[None]:
    """Within it, files other than those of the package are read only if they lie below one of these folders.

    They must be regular files named *.yaml or *.yml; a relative path counts from each of the folders. The refusal does
    not show whether a file exists, as the request may come from the network. `called` names the folders in it.
    """
    token = READABLE.set((tuple(Path(os.path.realpath(folder)) for folder in folders), called))
    try:
        yield
    finally:
        READABLE.reset(token)
