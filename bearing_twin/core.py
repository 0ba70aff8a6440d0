"""The compiled core: finds its library, checks it, and declares its C functions; loaded when one is first called.

The sources are in `core/`, which `core/build.py` compiles into `_core/` beside this file: one library for the machine
at hand, or from a wheel one for each instruction set, of which the best that this processor has is taken. The folder
`$BEARING_TWIN_CORE` takes the place of `_core/`, as for libraries with a sanitizer. ctypes lets other threads run while
a function does.
"""

import ctypes
import functools
import importlib.util
import os
import platform
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from bearing_twin.base.errors import CoreError

PACKAGE = Path(__file__).resolve().parent
WHEEL = (
    f"the wheel bearing_twin-*-py3-none-linux_{platform.machine()}.whl, "
    "which has it compiled (`make wheel` in a checkout on another machine builds it)"
)
_LEVELS = (  # what /proc/cpuinfo calls the instructions of x86-64-v2, -v3 and -v4, as far as the core is made of them
    {"cx16", "popcnt", "ssse3", "sse4_1", "sse4_2"},
    {"avx", "avx2", "bmi1", "bmi2", "fma", "movbe"},
    {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
)


class _Array:
    """Type of an argument: arrays of one type of number, C-contiguous; others are a ctypes.ArgumentError.

    As `ndpointer`, which takes six times as long for each argument; it has those that are read-only.
    """

    def __init__(self, number: str, *flags: str):
        self._number, self._flags = number, ("C_CONTIGUOUS", *flags)
        self._dtype = self._any = None  # until the first call, so that lists of what there is need not import numpy

    def from_param(self, array):
        if self._dtype is None:
            import numpy as np

            self._dtype = np.dtype(self._number)
            self._any = np.ctypeslib.ndpointer(self._dtype, flags=self._flags)
        if array.dtype is self._dtype:
            try:
                return _ADDRESS.from_buffer(array)
            except (BufferError, TypeError, ValueError):  # read-only, or in pieces
                pass
        return self._any.from_param(array)


_ADDRESS = ctypes.c_char * 0  # ctypes hands arrays over as pointers, and keeps what they are made from
REAL, INTEGER = ctypes.c_double, ctypes.c_int64
REALS, REALS_OUT = _Array("float64"), _Array("float64", "WRITEABLE")
INTEGERS, INTEGERS_OUT = _Array("int64"), _Array("int64", "WRITEABLE")
FLAG, FLAGS, FLAGS_OUT = _Array("uint8"), _Array("bool"), _Array("bool", "WRITEABLE")


@dataclass(frozen=True)
class Function:
    """A C function of the core: its name, the type of its result (None for none) and those of its arguments."""

    name: str
    result: Any
    arguments: tuple[Any, ...] = ()

    def __call__(self, *values):
        return self._bound(*values)

    @functools.cached_property
    def _bound(self):
        function = getattr(library(), self.name)
        function.restype, function.argtypes = self.result, self.arguments
        return function


def elementwise(function: Function, results: int, before: tuple, *numbers) -> list:
    """Results of an elementwise function of the core for numbers and arrays that broadcast.

    It takes `before`, the number of elements, the arrays and so many arrays of results, which are floats where all
    `numbers` are.
    """
    import numpy as np

    shape = np.broadcast(*numbers).shape
    values = [np.empty(shape) for _ in range(results)]
    arrays = (np.ascontiguousarray(np.broadcast_to(array, shape) if shape else array, float) for array in numbers)
    function(*before, values[0].size, *arrays, *values)
    return values if shape else [float(value) for value in values]


_version = Function("core_version", ctypes.c_char_p)
simd_lanes = Function("core_lanes", ctypes.c_int)


def version() -> str:
    """Build, compiler and instruction set of the library, for logs; raises CoreError where there is none."""
    return _version().decode()


@functools.cache
def library() -> ctypes.CDLL:
    """The library of this process; raises CoreError as `load` does."""
    return load(Path(os.environ.get("BEARING_TWIN_CORE", PACKAGE / "_core")))


def load(folder: Path) -> ctypes.CDLL:
    """The best library of a folder for this processor.

    Raises
    ------
    CoreError
        There is none, it is not whole, it is of other sources than those of the checkout, or for another processor.
    """
    builder = _builder()
    root = PACKAGE.parent
    remedy = f"run `make setup` in {root}, or `python3 {root}/core/build.py` alone" if builder else (
        "install bearing_twin again from its checkout, by `pip install .`"
    )  # fmt: skip
    levels = {path: _level_of(path.stem) for path in folder.glob("libbearing_twin_core-*.so")}
    if not levels:
        missing = f"the compiled core of bearing_twin is not in {folder}"
        if builder and builder.compiler():
            raise CoreError(f"{missing}: {remedy}")
        raise CoreError(
            f"{missing}: where there is a C++ compiler (Debian: apt install g++) {remedy}; else install {WHEEL}"
        )
    supported = processor_level()
    if not (fitting := [path for path, level in levels.items() if level <= supported]):
        least = min(levels.values())
        raise CoreError(
            f"the compiled core in {folder} is for processors of x86-64-v{least} and this one is of "
            f"x86-64-v{supported}: {remedy}, which builds for the machine at hand"
        )
    path = max(fitting, key=levels.__getitem__)
    if not _is_complete(path):
        raise CoreError(f"{path} is not whole: {remedy}")
    try:
        core = ctypes.CDLL(str(path))
        core.core_version.restype = ctypes.c_char_p
        version_text = core.core_version().decode()
    except (OSError, AttributeError) as error:
        raise CoreError(f"{path} is no library of this machine ({error}): {remedy}") from error
    if builder and (build := builder.build_id()) not in version_text:
        raise CoreError(
            f"{path} is of other sources ({version_text}) than those of the checkout (build {build}): {remedy}"
        )
    return core


def processor_level() -> int:
    """The level of this x86-64 processor, 1 to 4 as in x86-64-v1 to -v4; 0 for another architecture."""
    if platform.machine() != "x86_64":
        return 0
    with open("/proc/cpuinfo", "rb") as file:
        match = re.search(r"^flags\s*:(.*)$", file.read(16384).decode(errors="replace"), flags=re.MULTILINE)
    flags = set(match[1].split()) if match else set()
    return 1 + next((level for level, needed in enumerate(_LEVELS) if needed - flags), len(_LEVELS))


def _level_of(name: str) -> int:
    match = re.search(r"x86-64-v(\d)$", name)
    return int(match[1]) if match else 0


def _is_complete(path: Path) -> bool:
    """True if an ELF file goes on to its last table, where linkers put it."""
    with path.open("rb") as file:
        header = file.read(64)
    if len(header) < 64:
        return False
    begin, size, number = struct.unpack_from("<Q10xHH", header, 40)
    return begin + size * number <= path.stat().st_size


def _builder() -> ModuleType | None:
    """The module core/build.py of a checkout, None where the package is installed without its sources."""
    path = PACKAGE.parent / "core" / "build.py"
    if not (path.is_file() and (PACKAGE.parent / "package.xml").is_file()):
        return None
    spec = importlib.util.spec_from_file_location("bearing_twin_core_build", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
