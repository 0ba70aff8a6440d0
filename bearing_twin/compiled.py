"""How functions are compiled, said once.

`kernel` compiles a function and keeps the result (see `code_cache`); `inlined` marks the small readable functions that
kernels are made of, so that loops over many balls become vector instructions.
"""

import numba
from numba import njit

from bearing_twin.code_cache import CodeCache

# No fast mathematics: a kernel gives the same bits whatever it is compiled into, so a log verifies to zero.
OPTIONS = {"error_model": "numpy"}


def kernel(function):
    """Compiles `function`, releasing the GIL while it runs, and keeps the result on disk."""
    compiled = njit(nogil=True, **OPTIONS)(function)
    if not numba.config.DISABLE_JIT:
        # In the place of Numba's own cache, which `cache=True` would put here.
        compiled._cache = CodeCache(function)
    return compiled


def inlined(function):
    """Compiles `function` into its callers."""
    return njit(forceinline=True, **OPTIONS)(function)
