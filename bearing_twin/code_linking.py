"""Kernels that are compiled once and called, not compiled anew into every kernel above them.

Numba links the code of a function into each of its callers and optimises it there once more: a kernel four calls deep
was optimised and translated four times. Here a kernel has a name that says what it is compiled from, its callers keep
only that name, and the two are joined when they are loaded. A small kernel is still put into its callers.

Numba also makes, for each function, what Python calls it by, which unpacks every array of every named tuple: of kernels
with many arguments more code than their own. It is made only for what Python calls.
"""

import importlib
import itertools
import threading
from typing import NamedTuple

import llvmlite.binding as llvm
import numba
from numba.core import sigutils
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher

from bearing_twin.vectors import widen

SMALL = 120  # instructions up to which a kernel is put into its callers: there LLVM would put it by itself

_within = threading.local()


class Needed(NamedTuple):
    """A kernel that others can call by its `symbol`: where it is found, and for which types."""

    module: str
    function: str
    args: tuple
    symbol: str


class _Within:
    """While this is entered, what is compiled or loaded is wanted by other compiled code and not by Python."""

    def __enter__(self):
        _within.depth = getattr(_within, "depth", 0) + 1

    def __exit__(self, *error):
        _within.depth -= 1


def wanted_by_python() -> bool:
    """True if what is compiled or loaded now is wanted by Python."""
    return getattr(_within, "depth", 0) == 0


class _Flags(Flags):
    """Numba's options of one compilation, which are no part of a kernel's name: some follow from who calls it first."""

    __slots__ = ()

    def get_mangle_string(self):
        return "kernel"


class _Library(JITCodeLibrary):
    """Numba's place for the code of one form, where functions have wide vectors (`vectors`)."""

    def add_ir_module(self, ir_module):
        """Takes a module that Numba made."""
        widen(ir_module)
        super().add_ir_module(ir_module)


class _NamedCompiler(Compiler):
    """Numba's compiler, which names kernels by a digest, not by a number that counts on, and spares ways in."""

    def _compile_bytecode(self):
        identity = self.state.func_id
        keep = getattr(identity.func, "code_cache", None)
        digest = keep and keep.digest(self.state.args, self.state.targetctx.codegen())
        if digest is not None:
            # Of a function that is put into its callers, what Python calls is another form beside those in them.
            digest += "p" if wanted_by_python() and not keep.alone else ""
            identity.unique_id = digest
            identity.unique_name = f"{identity.func_qualname}${digest}"
            self.state.flags = _Flags(self.state.flags)
        flags = self.state.flags
        flags.no_cpython_wrapper = flags.no_cfunc_wrapper = not wanted_by_python()
        self.state.library = _Library(self.state.targetctx.codegen(), identity.func_qualname)
        self.state.library.enable_object_caching()
        with _Within():
            return super()._compile_bytecode()


class _Dispatcher(CPUDispatcher):
    """Numba's table of a function's compiled forms, where a form that only compiled code calls has no way in."""

    plain = False  # whether Python runs it as it is written, with all that it calls

    def __call__(self, *values):
        """The function's result; see `plain`."""
        if not (self.plain or getattr(_within, "plain", False)):
            return super().__call__(*values)
        before, _within.plain = getattr(_within, "plain", False), True
        try:
            return self.py_func(*values)
        finally:
            _within.plain = before

    def compile(self, sig):
        """The way into the form for these types, compiled with one where Python wants it and there is none.

        Never in the main thread: a handler of a signal can raise there between what LLVM did and what Python notes of
        it, after which memory is freed twice, or where LLVM asks Python for code and takes none for an answer. The main
        thread waits, which a signal ends at once.
        """
        if threading.current_thread() is threading.main_thread() and not global_compiler_lock.is_locked():
            return _in_another_thread(lambda: self._compiled(sig))
        return self._compiled(sig)

    def _compiled(self, sig):
        form = self.overloads.get(tuple(sigutils.normalize_signature(sig)[0]))
        if form is not None and wanted_by_python() and not has_way_in(form):
            del self.overloads[tuple(form.signature.args)]
        return super().compile(sig)

    def add_overload(self, cres):
        """Keeps a form; Python finds it if it can call it."""
        if has_way_in(cres):
            super().add_overload(cres)
        else:
            self.overloads[tuple(cres.signature.args)] = cres


def _in_another_thread(work):
    """What `work` returns or raises in a thread of its own, which goes on where the wait for it is interrupted."""
    found = []

    def run():
        try:
            found.append((work(), None))
        except BaseException as error:
            found.append((None, error))

    thread = threading.Thread(target=run, name="compilation", daemon=True)
    thread.start()
    thread.join()
    value, error = found.pop()
    if error is not None:
        raise error
    return value


def dispatcher(function, options):
    """What stands for `function`, compiled without Python's objects for the types it is called with."""
    if numba.config.DISABLE_JIT:
        return function
    options = {"nopython": True, "boundscheck": None, **options}
    return _Dispatcher(py_func=function, targetoptions=options, pipeline_class=_NamedCompiler)


def has_way_in(form) -> bool:
    """True if Python can call a compiled form."""
    return form.library.get_pointer_to_function(form.fndesc.llvm_cpython_wrapper_name) != 0


def is_called_by_name(form) -> bool:
    """True if callers of a form just compiled call it by its name: all but small ones."""
    function = form.library.get_function(form.fndesc.llvm_func_name)
    instructions = (1 for block in function.blocks for _ in block.instructions)
    return sum(itertools.islice(instructions, SMALL + 1)) > SMALL  # to count on takes a call of LLVM for each


def needs_of(library) -> list:
    """The kernels that the code of a library calls and does not hold.

    The code itself says so: whether a kernel is small can differ between its forms with a way in and without.
    """
    if not hasattr(library, "needs"):
        missing = {one.name for one in library._final_module.functions if one.is_declaration}
        found, seen, wanted = {}, set(), list(library._linking_libraries)
        while wanted:
            one = wanted.pop()
            if id(one) in seen:
                continue
            seen.add(id(one))
            identity = getattr(one, "identity", None)
            if identity is not None and identity.symbol in missing:
                found[identity.symbol] = identity
            else:
                wanted += one._linking_libraries
        library.needs = list(found.values())
    return library.needs


def keep_names(library) -> None:
    """Keeps of a library, for the cache and for callers, no more than the names of what it defines."""
    module = library._final_module
    names = [one.name for one in module.functions if not one.is_declaration]
    library._shared_module = llvm.parse_assembly("\n".join(f'define void @"{one}"() {{ ret void }}' for one in names))


def introduce(library, identity, by_name, kept=()) -> None:
    """Lets callers of a library call it: `by_name`, or with its code in theirs; `kept` stays as long as it does."""
    library.identity, library.kept = identity, kept
    if by_name:
        library._shared_module = llvm.parse_assembly(str(library.codegen._create_empty_module(library.name)))
    elif kept:
        library._linking_libraries = list(kept)


def complete(environment, constants) -> None:
    """Gives a form just loaded the constants of its way in.

    Numba finds them by the form's name. A caller loaded before can have brought those of a form without a way in, which
    are the first of these.
    """
    if len(constants) > len(environment.consts):
        environment.consts[:] = constants


def load(needed) -> list:
    """Loads or compiles the kernels that another calls; raises LookupError where one is not what it was."""
    libraries = []
    for one in needed:
        found = getattr(importlib.import_module(one.module), one.function)
        with _Within():
            found.compile(one.args)
        form = found.overloads[one.args]
        if form.fndesc.llvm_func_name != one.symbol:
            raise LookupError(one.symbol)
        libraries.append(form.library)
    return libraries
