"""Kernels that count no references.

Numba counts references to every array that a function takes out of a named tuple or out of a table, one atomic addition
each. Counting took half the time of a step of balls with a border, whose arrays stand in named tuples. A function that
makes no arrays and returns none needs no count: its caller keeps what it is given.
"""

from bearing_twin.compiled import kept


def lean_kernel(function):
    """As `compiled.kernel`, for a function that makes no arrays and returns none; so are the kernels that it calls."""
    return kept(function, nogil=True, _nrt=False)


def owning_kernel(function):
    """As `compiled.kernel`, for a function that makes arrays and is called by lean ones."""
    return kept(function, nogil=True, _nrt=True)
