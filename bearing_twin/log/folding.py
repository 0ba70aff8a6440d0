"""The compiled half of `checksum`: products of polynomials with coefficients of one bit, four pairs at once."""

import platform

import llvmlite.binding
import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from bearing_twin.compiled import kernel

# x^n modulo the polynomial, bit-reflected: by these the two words of a pair are taken n bits further.
PAST_FOUR = 0x154442BD4, 0x1C6E41596  # n = 544, 480: past four pairs
PAST_ONE = 0x1751997D0, 0x0CCAA009E  # n = 160, 96: past one
PAIRS = 4
_WORD, _PAIR = ir.IntType(64), ir.VectorType(ir.IntType(64), 2)


def can_fold() -> bool:
    """Whether this processor has the instruction, and kernels are compiled at all."""
    if numba.config.DISABLE_JIT or platform.machine() not in ("x86_64", "AMD64"):
        return False
    return bool(llvmlite.binding.get_host_cpu_features().get("pclmul"))


def _further(builder, pair, by, other):
    """`pair` taken further by two factors, xored with `other`."""
    byte = ir.IntType(8)
    multiply = builder.module.declare_intrinsic("llvm.x86.pclmulqdq", (), ir.FunctionType(_PAIR, [_PAIR, _PAIR, byte]))
    factors = ir.Constant(_PAIR, by)
    low, high = (builder.call(multiply, [pair, factors, ir.Constant(byte, which)]) for which in (0x00, 0x11))
    return builder.xor(builder.xor(low, high), other)


@intrinsic
def _folded(context, words, first, folded):
    """See `fold`."""
    signature = types.void(words, first, folded)

    def generate(context, builder, signature, arguments):
        given, room = (context.make_array(signature.args[k])(context, builder, arguments[k]) for k in (0, 2))
        data, answer = (builder.bitcast(one.data, _PAIR.as_pointer()) for one in (given, room))
        size = builder.extract_value(given.shape, 0)

        def pair_at(place):
            found = builder.load(builder.gep(data, [place]))
            found.align = 8
            return found

        def constant(number):
            return ir.Constant(size.type, number)

        pairs = [cgutils.alloca_once_value(builder, pair_at(constant(k))) for k in range(PAIRS)]
        begun = builder.insert_element(ir.Constant(_PAIR, [0, 0]), arguments[1], ir.Constant(ir.IntType(32), 0))
        builder.store(builder.xor(builder.load(pairs[0]), begun), pairs[0])
        strides = builder.sub(builder.sdiv(size, constant(2 * PAIRS)), constant(1))
        with cgutils.for_range(builder, strides) as loop:
            begin = builder.mul(builder.add(loop.index, constant(1)), constant(PAIRS))
            for k, pair in enumerate(pairs):
                following = pair_at(builder.add(begin, constant(k)))
                builder.store(_further(builder, builder.load(pair), PAST_FOUR, following), pair)
        last = builder.load(pairs[0])
        for pair in pairs[1:]:
            last = _further(builder, last, PAST_ONE, builder.load(pair))
        builder.store(last, answer).align = 8
        return context.get_dummy_value()

    return signature, generate


@kernel
def fold(words, first, folded):
    """Fills `folded` (2,) with the remainder of `words` (n,), the first of them xored with `first`.

    n is a multiple of 8, at least 8; all are uint64, arrays contiguous.
    """
    _folded(words, first, folded)
