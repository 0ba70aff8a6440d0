"""How functions are compiled, said once.

`kernel` compiles a function and keeps the result (see `code_cache`); `inlined` marks the small readable functions that
kernels are made of, so that loops over many balls become vector instructions.
"""

import numba

from bearing_twin.code_cache import CodeCache
from bearing_twin.code_linking import dispatcher

# No fast mathematics: a kernel gives the same bits whatever it is compiled into, so a log verifies to zero.
OPTIONS = {"error_model": "numpy"}
INLINED = {"forceinline": True, **OPTIONS}


def kept(function, alone=True, **options):
    """Compiles `function` and keeps the result on disk; of one that is not for itself `alone`, what Python calls."""
    compiled = dispatcher(function, {**OPTIONS, **options})
    if not numba.config.DISABLE_JIT:
        # In the place of Numba's own cache, which `cache=True` would put here.
        compiled._cache = CodeCache(function, alone)
    return compiled


def kernel(function):
    """Compiles `function`, releasing the GIL while it runs, and keeps the result on disk."""
    return kept(function, nogil=True)


def plain(compiled):
    """The same, but that Python runs it as it is written, with all that it calls: few numbers deserve no compiler."""
    compiled.plain = True
    return compiled


def inlined(function):
    """Compiles `function` into its callers."""
    return kept(function, alone=False, **INLINED)


def template(function):
    """Writes `function` into its callers before they are typed: for one that is handed functions."""
    return kept(function, alone=False, inline="always", **OPTIONS)
