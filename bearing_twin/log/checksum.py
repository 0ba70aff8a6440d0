"""CRC-32 as zlib has it, several times as fast where the processor multiplies polynomials.

Data is folded 64 bytes at a time into 16 bytes with the same remainder, of which zlib then takes the CRC (Gopal et al.,
"Fast CRC Computation for Generic Polynomials Using PCLMULQDQ Instruction", Intel 2009, bit-reflected).
"""

import functools
import sys
import zlib

import numpy as np

STRIDE = 64  # bytes folded at once
LEAST = 4096  # bytes for which it is worth the call


def crc32(data, value: int = 0) -> int:
    """`zlib.crc32(data, value)` of contiguous bytes.

    Only where Numba is loaded anyway: to import it takes longer than the CRC of a gigabyte.
    """
    data = memoryview(data)
    whole = len(data) // STRIDE * STRIDE
    if whole < LEAST or "numba" not in sys.modules or (fold := _fold()) is None:
        return zlib.crc32(data, value)
    folded = np.empty(2, np.uint64)
    fold(np.frombuffer(data[:whole], np.uint64), np.uint64(value ^ 0xFFFFFFFF), folded)
    return zlib.crc32(data[whole:], zlib.crc32(folded, 0xFFFFFFFF))


@functools.cache
def _fold():
    """The kernel that folds, None where the processor or Numba cannot."""
    from bearing_twin.log.folding import can_fold, fold

    return fold if can_fold() else None
