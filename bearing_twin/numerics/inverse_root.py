"""The inverse of a root without the processor's unit for roots and quotients, which eight lanes wait for."""

import numpy as np

from bearing_twin.compiled import inlined

_HALVES = np.int64(0x5FE6EB50C7B537A9)  # less half of a number's bits: those of its inverse root, within 3.5 %


@inlined
def inverse_root(square):
    """The inverse of the root of a number above zero, within 3e-16; of zero a large one.

    Four of Newton's steps, each the square of the error before, from a start by the exponent (Lomont 2003).
    """
    half = 0.5 * square
    bits = _HALVES - (np.float64(square).view(np.int64) >> np.int64(1))
    found = np.int64(bits).view(np.float64)
    found *= 1.5 - half * found * found
    found *= 1.5 - half * found * found
    found *= 1.5 - half * found * found
    return found * (1.5 - half * found * found)
