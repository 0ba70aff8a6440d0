"""Kernels that count no references.

Numba counts references to every array that a function takes out of a named tuple or out of a table, one atomic addition
each. Counting took half the time of a step of balls with a border, whose arrays stand in named tuples. A function that
makes no arrays and returns none needs no count: its caller keeps what it is given.
"""

import numba
from numba import njit

from bearing_twin.code_cache import CodeCache
from bearing_twin.compiled import OPTIONS


def _kept(function, counts):
    compiled = njit(nogil=True, _nrt=counts, **OPTIONS)(function)
    if not numba.config.DISABLE_JIT:
        compiled._cache = CodeCache(function)
    return compiled


def lean_kernel(function):
    """As `compiled.kernel`, for a function that makes no arrays and returns none; so are the kernels that it calls."""
    return _kept(function, False)


def owning_kernel(function):
    """As `compiled.kernel`, for a function that makes arrays and is called by lean ones."""
    return _kept(function, True)
