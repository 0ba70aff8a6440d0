"""Where compiled code is kept: $XDG_CACHE_HOME/bearing_twin/<module>-<state>/, one file for a function and its types.

The state says what the code was compiled from (`source_state`) and by what. Files are written whole under another name
and then moved, carry a checksum, and are found by their content: processes that compile at the same time cannot mix
their results, as they can in Numba's numbered files. What is damaged is thrown away and compiled afresh; where nothing
can be kept, one warning is printed and compiled code lives in memory only.
"""

import contextlib
import functools
import hashlib
import os
import pickle
import re
import shutil
import sys
import time
import types as python_types
import zlib
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.types import Callable

from bearing_twin import code_linking
from bearing_twin.base.paths import put_whole
from bearing_twin.source_state import note_imported, state_of

FORMAT = 4  # of the files
MOST_STATES = 3  # of one module that are kept
DAY = 86400.0
GREATEST_MEMORY = 2000  # texts whose parsing is remembered

_MARK = b"bearing_twin code %d\n" % FORMAT
_STATE_FOLDER = re.compile(r"([\w.]+)-[0-9a-f]{20}")
_EARLIER_FOLDER = re.compile(r"kernels-[0-9a-f]{16}")  # of versions that kept all kernels together
_PLAIN = (bool, int, float, complex, str, bytes, type(None))


class CodeCache(_Cache):
    """What Numba asks for the compiled forms of one function: load one by its types, save one.

    Of a function that does not stand `alone`, but in its callers, only what Python calls is kept.
    """

    def __init__(self, function, alone=True):
        note_imported(function.__module__)
        self._function = function
        self.alone = alone
        self._enabled = True
        function.code_cache = self  # where the compiler finds it

    @property
    def cache_path(self):
        """The folder of the function's module, or None where nothing can be kept."""
        folder = self._folder()
        return folder and str(folder)

    def enable(self):
        """Keeps code again after `disable`."""
        self._enabled = True

    def disable(self):
        """Neither loads nor saves from now on."""
        self._enabled = False

    def flush(self):
        """Removes all that is kept of this function."""
        folder = self._folder()
        for path in folder.glob(f"{self._name()}-*.code") if folder else ():
            _remove(path)

    def load_overload(self, sig, target_context):
        """The compiled form for these types, or None if it must be compiled."""
        if not self.alone and not code_linking.wanted_by_python():
            return None
        rtsys.initialize(target_context)  # not `refresh`: what is only loaded needs none of the rules of typing
        key, path = self._key_and_path(sig, target_context.codegen())
        if path is None or (content := _read(path)) is None:
            return None
        try:
            kept_key, form, (identity, by_name), needed, constants = pickle.loads(content)
            if kept_key != key:
                return None
            libraries = code_linking.load(needed)
            found = CompileResult._rebuild(target_context, *form)
            found.library.needs = needed
            code_linking.introduce(found.library, identity, by_name, libraries)
            code_linking.complete(found.environment, constants)
        except Exception:  # whatever unpickling raises: what cannot be rebuilt is compiled afresh
            _remove(path)
            return None
        return found if code_linking.has_way_in(found) or not code_linking.wanted_by_python() else None

    def save_overload(self, sig, data):
        """Keeps a compiled form for these types; prints one warning a process if that is not possible."""
        if not self.alone and not code_linking.wanted_by_python():
            return
        if data.library.has_dynamic_globals or any(not one.can_cache for one in data.lifted):
            return
        key, path = self._key_and_path(sig, data.codegen)
        args, needed = tuple(getattr(sig, "args", sig)), code_linking.needs_of(data.library)
        identity, by_name = None, False
        if self.alone and key is not None:
            symbol = data.fndesc.llvm_func_name
            identity = code_linking.Needed(self._function.__module__, self._function.__qualname__, args, symbol)
            by_name = code_linking.is_called_by_name(data)
        try:
            if by_name:
                code_linking.keep_names(data.library)
            if path is None:
                return
            fresh = not path.parent.is_dir()
            _write(path, dumps((key, data._reduce(), (identity, by_name), needed, list(data.environment.consts))))
            if fresh:
                _remove_old_states(path.parent)
        except OSError as error:
            _warn_once(path.parent.parent, error)
        finally:
            code_linking.introduce(data.library, identity, by_name)

    def _name(self) -> str:
        return re.sub(r"[^\w.]", "", self._function.__qualname__)[:80]

    def _folder(self) -> Path | None:
        base = _base() if self._enabled else None
        return base and _state_folder(base, self._function.__module__)

    def digest(self, args, codegen) -> str | None:
        """What names the form for these types; None where the source does not say what is compiled."""
        key = self._key(args, codegen)
        return key and self._digest(key, args)

    def _key(self, args, codegen) -> tuple | None:
        """What tells one compiled form from all others of its module's state."""
        cells = [cell.cell_contents for cell in self._function.__closure__ or ()]
        # What is in a closure or handed over can be a function, whose source the state need not contain.
        if not all(map(_is_plain, cells)) or any(isinstance(one, Callable) for one in args):
            return None
        machine = codegen.magic_tuple()  # kind of processor and its instructions
        return args, machine, _shape(self._function.__code__, self._function.__doc__), repr(cells)

    def _key_and_path(self, sig, codegen):
        """What tells one compiled form from all others, if anything does, and its file, if there is a place for it."""
        folder, args = self._folder(), getattr(sig, "args", sig)
        key = self._key(args, codegen)
        if folder is None or key is None:
            return key, None
        return key, folder / f"{self._name()}-{self._digest(key, args)}.code"

    def _digest(self, key, args) -> str:
        classes = [getattr(one, "instance_class", None) for one in args]
        return hashlib.sha256(repr((key, classes, self._function.__module__)).encode()).hexdigest()[:20]


def _is_plain(value) -> bool:
    return all(map(_is_plain, value)) if type(value) is tuple else type(value) in _PLAIN


def _shape(code, docstring=None) -> str:
    """What a function's code says, without file, line numbers and docstring."""
    parts = [_shape(one) if isinstance(one, python_types.CodeType) else _text(one) for one in code.co_consts]
    if docstring is not None and code.co_consts and code.co_consts[0] == docstring:
        parts[0] = "None"
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    return hashlib.sha256(repr((code.co_code, parts, names)).encode()).hexdigest()


def _text(constant) -> str:
    # The order of a set differs between processes.
    return repr(sorted(map(repr, constant))) if isinstance(constant, frozenset) else repr(constant)


def _base() -> Path | None:
    """The folder of all compiled code, private to the user; None if there is none to be trusted."""
    root = os.environ.get("XDG_CACHE_HOME", "")
    place = numba.config.CACHE_DIR or (root if os.path.isabs(root) else os.path.expanduser("~/.cache"))
    return _private(Path(place, "bearing_twin"))


@functools.cache
def _private(base: Path) -> Path | None:
    # Who can write here can run code as the user.
    try:
        base.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = base.stat()
        if status.st_uid == os.getuid() and status.st_mode & 0o077:
            base.chmod(0o700)
        elif status.st_uid != os.getuid() and (status.st_uid != 0 or status.st_mode & 0o022):
            raise PermissionError(0, "others can write there")
    except OSError as error:
        _warn_once(base, error)
        return None
    return base


@functools.cache
def _state_folder(base: Path, module: str) -> Path | None:
    """The folder of a module in its present state; marks it as used."""
    memory = base / "sources"
    known = _remembered(memory)
    before = len(known)
    state = state_of(module, known)
    if len(known) > before:
        with contextlib.suppress(OSError):
            _write(memory, pickle.dumps(dict(list(known.items())[-GREATEST_MEMORY:])))
    if state is None:
        return None
    flags = ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT")
    made_by = (
        (FORMAT, sys.version_info[:], sys.implementation.cache_tag),
        (numba.__version__, llvmlite.__version__, np.__version__),
        [getattr(numba.config, flag, None) for flag in flags],
    )
    digest = hashlib.sha256(repr((state, made_by)).encode()).hexdigest()[:20]
    folder = base / f"{module}-{digest}"
    with contextlib.suppress(OSError):
        if time.time() - folder.stat().st_mtime > DAY:
            os.utime(folder)
    return folder


@functools.cache
def _remembered(memory: Path) -> dict:
    """What parsing the sources gave at earlier starts."""
    try:
        found = pickle.loads(_read(memory) or b"")
    except Exception:  # nothing there, or of another version: sources are parsed afresh
        found = None
    return found if isinstance(found, dict) else {}


def _read(path: Path) -> bytes | None:
    """The content of a file of this cache; None if there is none, and a damaged one is removed."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    start = len(_MARK) + 4
    if content.startswith(_MARK) and zlib.crc32(content[start:]) == int.from_bytes(content[len(_MARK) : start], "big"):
        return content[start:]
    _remove(path)
    return None


def _write(path: Path, content: bytes) -> None:
    """Writes a file as a whole or not at all."""
    path.parent.parent.mkdir(mode=0o700, exist_ok=True)
    path.parent.mkdir(mode=0o700, exist_ok=True)
    put_whole(path, _MARK + zlib.crc32(content).to_bytes(4, "big") + content, 0o600)


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()


def _remove_old_states(folder: Path) -> None:
    """Removes states of this module beyond the latest, folders of earlier versions and files left half-written.

    Nothing used within the last day goes: a use is marked once a day, so a mark two days old is of no recent use.
    """
    module = _STATE_FOLDER.fullmatch(folder.name).group(1)
    states = []
    for entry in folder.parent.iterdir():
        match = _STATE_FOLDER.fullmatch(entry.name)
        with contextlib.suppress(OSError):
            if match and match.group(1) == module:
                states.append((entry.stat().st_mtime, entry))
            elif _EARLIER_FOLDER.fullmatch(entry.name) or entry.name.startswith("."):
                latest = max(one.stat().st_mtime for one in (entry, *entry.glob("*")))
                if time.time() - latest > 2 * DAY:
                    _remove(entry) if entry.is_file() else shutil.rmtree(entry, ignore_errors=True)
    for used, entry in sorted(states, reverse=True)[MOST_STATES:]:
        if time.time() - used > 2 * DAY:
            shutil.rmtree(entry, ignore_errors=True)


_warned = False


def _warn_once(base: Path, error: OSError) -> None:
    global _warned
    if not _warned:
        _warned = True
        reason = error.strerror or error
        print(f"bearing_twin: compiled code cannot be kept in {base} ({reason}); each start compiles", file=sys.stderr)
