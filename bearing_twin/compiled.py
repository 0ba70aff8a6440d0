"""How functions are compiled, said once.

`kernel` compiles and caches a function; `inlined` marks the small readable functions that kernels are made of, so
that loops over many balls become vector instructions. Compiled code is cached per user and per state of the sources:
Numba's own cache does not notice a change in a function that another file inlines.
"""

import hashlib
import os
from pathlib import Path

import numba
from numba import njit

# No fast mathematics: a kernel gives the same bits whatever it is compiled into, so a log verifies to zero.
OPTIONS = {"error_model": "numpy"}


def _cache_folder() -> str:
    """A folder of compiled code that belongs to exactly these kernels; empty when there is no home for it."""
    texts = (source.read_bytes() for source in sorted(Path(__file__).parent.rglob("*.py")))
    digest = hashlib.sha256(b"".join(text for text in texts if b"bearing_twin.compiled" in text))
    root = os.environ.get("XDG_CACHE_HOME") or os.environ.get("HOME")
    if not root:
        return ""
    base = Path(root) if "XDG_CACHE_HOME" in os.environ else Path(root) / ".cache"
    return str(base / "bearing_twin" / f"kernels-{digest.hexdigest()[:16]}")


if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = _cache_folder()


def kernel(function):
    """Compiles `function`, releasing the GIL while it runs, and keeps the result on disk."""
    return njit(cache=True, nogil=True, **OPTIONS)(function)


def inlined(function):
    """Compiles `function` into its callers."""
    return njit(forceinline=True, **OPTIONS)(function)
