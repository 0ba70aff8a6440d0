"""The inverse of a root without the processor's unit for roots and quotients, for which eight lanes wait long."""

import numpy as np

from bearing_twin.compiled import inlined

# Less half of a number's bits: those of its inverse root, within 3.4 %; and what steps begin with: 3/4 of the
# square of the error before added to Newton's 3/2, so that what is left lies evenly about zero (Moroz et al., Applied
# Mathematics and Computation 316, 2018; the last by that rule).
_START = np.int64(0x5FE6ED2102DCBFDA)
_FIRST, _SECOND, _THIRD = 1.50087895511633457, 1.50000057967625766, 1.5 + 2.52e-13


@inlined
def inverse_root(square):
    """The inverse of the root of a number above zero, within 3e-13; of zero a large one.

    Three of Newton's steps, each of which leaves 3/4 of the square of the error before.
    """
    half = 0.5 * square
    bits = _START - (np.float64(square).view(np.int64) >> np.int64(1))
    found = np.int64(bits).view(np.float64)
    found *= _FIRST - half * found * found
    found *= _SECOND - half * found * found
    return found * (_THIRD - half * found * found)
