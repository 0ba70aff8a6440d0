"""What the numbers of a table were made with and when: software with its commit, processor, day."""

import datetime
import functools
import importlib.metadata
import platform
import subprocess
from pathlib import Path

from bearing_twin import __version__

LIBRARIES = "numpy", "scipy", "numba"


def processor() -> str:
    """The processor's name."""
    cpus = Path("/proc/cpuinfo")
    lines = cpus.read_text().splitlines() if cpus.exists() else ()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def _commit() -> str:
    """The commit of the checkout that runs, with a + where files differ from it; empty where there is none."""
    root = Path(__file__).parents[2]
    if not (root / ".git").exists():
        return ""
    words = ["git", "-C", str(root), "describe", "--always", "--dirty=+", "--exclude=*"]
    try:
        return subprocess.run(words, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""


@functools.cache
def made() -> str:
    """The cell of a table's column `made`."""
    commit = _commit()
    ours = f"bearing_twin {__version__}{f' {commit}' if commit else ''}"
    libraries = (f"{name} {importlib.metadata.version(name)}" for name in LIBRARIES)
    return "; ".join([ours, *libraries, processor(), str(datetime.date.today())])
