"""Where files that are not Python live, in a checkout or installed, and how files are written: whole or not at all."""

import os
import threading
from pathlib import Path

from bearing_twin.errors import BearingTwinError


def share_path(*parts: str) -> Path:
    """Path of a shared file or folder, given by its parts ("config", "scenes").

    In a checkout (also an editable or symlinked install) the folders lie beside the package; installed by
    colcon or pip they lie in share/bearing_twin of the prefix. Raises BearingTwinError when neither has it.
    """
    package = Path(__file__).resolve().parent
    roots = [package.parent, *(folder / "share" / "bearing_twin" for folder in package.parents)]
    for root in roots:
        if (root / "package.xml").is_file() and (found := root.joinpath(*parts)).exists():
            return found
    raise BearingTwinError(
        f"{'/'.join(parts)} of bearing_twin is neither in {roots[0]} nor in a share/bearing_twin above: reinstall it."
    )


def own_folder(name: str) -> Path:
    """The folder of the user's own files of a kind, `$XDG_CONFIG_HOME/bearing_twin/<name>`; it need not exist."""
    home = os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    return Path(home) / "bearing_twin" / name


def write_whole(path, content: bytes) -> Path:
    """Writes a file as `put_whole` does; raises BearingTwinError where it cannot be written."""
    path = Path(path)
    try:
        put_whole(path, content)
    except OSError as error:
        raise BearingTwinError(f"{path} cannot be written ({error.strerror}); give another path") from error
    return path


def put_whole(path: Path, content: bytes) -> None:
    """Writes a file through a draft beside it that takes its name, so that a full disk leaves what was there before.

    A link stays one; devices and pipes take the bytes themselves. Raises OSError where it cannot be written.
    """
    target = path.resolve()
    if target.exists() and not target.is_file():
        target.write_bytes(content)
        return
    draft = target.with_name(f".{os.getpid()}_{threading.get_ident()}.part")
    try:
        draft.write_bytes(content)
        os.replace(draft, target)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
