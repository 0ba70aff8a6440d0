"""Where the files that are not Python live: config/, launch/ and msg_schemas/, in a checkout or installed."""

import os
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
