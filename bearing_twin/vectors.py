"""How wide the vector instructions of compiled code are: LLVM is told.

Of processors with 512 bits LLVM uses all on those called znver, and 256 on all of Intel's (`TuningPrefer256Bit` of its
X86.td), as the clock of the first of these falls where 512 are used. Functions that say how wide they want to be are
compiled so, and no others: what a user compiles by Numba in the same process stays as it is.
"""

from numba.core.registry import cpu_target

# Servers of Intel's from Ice Lake on: two units take 512 bits at once, at the clock they have with 256 or nearly so.
# Skylake's and Cascade Lake's slow down; of Ice Lake, Rocket Lake and Tiger Lake for desktops one unit does.
WHOLE = ("icelake-server", "sapphirerapids", "emeraldrapids", "graniterapids", "graniterapids-d", "diamondrapids")


def bits_for(processor: str, features: str) -> int:
    """512 or 256: the width of instructions for a processor, by LLVM's name of it and its features.

    What a user sets by `NUMBA_CPU_NAME` and `NUMBA_CPU_FEATURES` stands in both: `+prefer-256-bit` and
    `-prefer-256-bit` have the last word.
    """
    said = features.split(",")
    if "+avx512f" not in said or "-evex512" in said or "+prefer-256-bit" in said:
        return 256
    return 512 if processor.startswith("znver") or processor in WHOLE or "-prefer-256-bit" in said else 256


# What Numba compiles for, by which compiled code is kept, too.
_, _PROCESSOR, _FEATURES = cpu_target.target_context.codegen().magic_tuple()
BITS = bits_for(_PROCESSOR, _FEATURES)


def widen(module) -> None:
    """Lets LLVM use vectors of BITS in the functions that a module (`llvmlite.ir.Module`) defines."""
    if BITS > 256:
        for one in module.functions:
            if not one.is_declaration:
                # llvmlite's `add` knows no attributes that are pairs of texts; they are written as they stand.
                set.add(one.attributes, f'"prefer-vector-width"="{BITS}"')
