"""What LLVM makes of a kernel."""

import types

from bearing_twin.code_linking import dispatcher
from bearing_twin.compiled import OPTIONS


def machine_code(function, *arguments) -> str:
    """Machine code of a Python function that is compiled anew, as kernels are, and called with such arguments."""
    alone = types.FunctionType(function.__code__, function.__globals__, function.__name__)  # under a name of its own
    compiled = dispatcher(alone, OPTIONS)
    compiled(*arguments)
    (code,) = compiled.inspect_asm().values()
    return code
