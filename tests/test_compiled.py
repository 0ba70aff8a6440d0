"""What is compiled is kept, compiled anew when it changed and only then, and its cache never ends a program.

Each start imports `tiny`, a package of kernels made in a folder of the test, and tells which of its functions it
compiled. Where processes or their objects count it is one, forked so that Numba is there already; else this process
forgets all that it knows of `tiny` and of its cache.
"""

import contextlib
import functools
import importlib
import io
import multiprocessing
import os
import resource
import shutil
import sys
import traceback
import zlib

import numba
import pytest
from numba.core import event

from bearing_twin import code_cache, compiled, source_state

SOURCES = {
    "__init__": "",
    "constants": '"""Numbers."""\n\nOFFSET = 1.0\n',
    "lower": (
        '"""Small functions."""\n\nfrom bearing_twin.compiled import inlined\nfrom tiny.constants import OFFSET\n\n\n'
        '@inlined\ndef twice(x):\n    """Twice and more."""\n    return 2.0 * x + OFFSET\n'
    ),
    "upper": (
        '"""A kernel."""\n\nfrom bearing_twin.compiled import kernel\nfrom tiny.lower import twice\n\n\n'
        '@kernel\ndef four_times(x):\n    """Four times and more."""\n    return twice(twice(x))\n'
    ),
    "apart": (
        "from bearing_twin.compiled import kernel\n\n\n@kernel\ndef square(x):\n    return x * x\n\n\n"
        "@kernel\ndef cube(x):\n    return x * x * x\n"
    ),
}
CALLS = (("upper.four_times", 1.0), ("apart.square", 3.0))
VALUES = [7.0, 9.0]


@pytest.fixture(scope="module", autouse=True)
def numba_is_ready():
    """Numba prepares itself at its first compilation: once here, not in every process that is forked."""
    for x in (1, 1.0):
        compiled.inlined(lambda x: x * x)(x)


@pytest.fixture
def root(tmp_path):
    return made(tmp_path / "checkout")


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """A cache of this test alone: the folder that the package makes in the user's."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    return tmp_path / "cache" / "bearing_twin"


@pytest.fixture(scope="module")
def compiled_once(tmp_path_factory):
    """A cache in which all of `CALLS` is."""
    folder = tmp_path_factory.mktemp("once")
    assert started_beside(made(folder / "checkout")) == (VALUES, ["four_times", "square", "twice"], "")
    return folder / "cache" / "bearing_twin"


@pytest.fixture
def warm(compiled_once, cache):
    """The test's cache holds this from the start."""
    shutil.copytree(compiled_once, cache)


def made(root):
    (root / "tiny").mkdir(parents=True)
    for name, text in SOURCES.items():
        (root / "tiny" / f"{name}.py").write_text(text)
    return root


def edited(root, module, old, new):
    path = root / "tiny" / f"{module}.py"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))


def _start(root, calls, between):
    """(values, or how they failed, names of the functions compiled, what was said on standard error)."""
    compilations, said = [], io.StringIO()

    class Listener(event.Listener):
        def on_start(self, one):
            compilations.append(one.data["dispatcher"].py_func.__name__)

        def on_end(self, one):
            pass

    with contextlib.redirect_stderr(said), event.install_listener("numba:compile", Listener()):
        functions = []
        for name, *_ in calls:
            module, _, function = name.partition(".")
            functions.append(getattr(importlib.import_module(f"tiny.{module}"), function))
        between()
        try:
            values = [function(*arguments) for function, (_, *arguments) in zip(functions, calls, strict=True)]
        except BaseException:  # told through the pipe: there may be no room to print it
            values = traceback.format_exc()
    return values, sorted(set(compilations)), said.getvalue()


def _start_in_a_fork(pipe, root, *more):
    with new_to(root):
        pipe.send(_start(root, *more))


@contextlib.contextmanager
def new_to(root):
    """In this process, as in one that has just begun: nothing is known of `tiny` or of what is kept."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(root)
        patch.setattr(sys, "dont_write_bytecode", True)
        patch.setattr(code_cache, "_warned", False)
        patch.setattr(source_state, "_imported", dict(source_state._imported))
        for name in ("_private", "_state_folder", "_remembered"):
            patch.setattr(code_cache, name, functools.cache(getattr(code_cache, name).__wrapped__))
        try:
            yield
        finally:
            for name in [name for name in sys.modules if name.partition(".")[0] == "tiny"]:
                del sys.modules[name]


def begun(root, calls=CALLS, between=lambda: None):
    """A process under way that imports the modules, does `between` and calls the functions."""
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_start_in_a_fork, args=(there, root, calls, between))
    process.start()
    there.close()
    return process, here


def ended(process, pipe):
    try:
        found = pipe.recv()
    except EOFError:
        process.join()
        pytest.fail(f"the process ended without a word, exit code {process.exitcode}")
    finally:
        process.join()
    return _whole(found)


def _whole(found):
    if isinstance(found[0], str):
        pytest.fail(found[0])
    return found


def started(root, calls=CALLS, between=lambda: None):
    """(values, names of the functions compiled, what was said on standard error) of one start, a process."""
    return ended(*begun(root, calls, between))


def started_here(root, calls=CALLS):
    """As `started`, in this process."""
    with new_to(root):
        return _whole(_start(root, calls, lambda: None))


def started_beside(root, calls=CALLS):
    """As `started`, with the cache in a folder beside this checkout."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(root.parent / "cache"))
        patch.setattr(numba.config, "CACHE_DIR", "")
        return started(root, calls)


def files(cache):
    return sorted(cache.glob("*/*.code"))


def test_a_second_start_compiles_nothing(root, cache):
    assert started(root) == (VALUES, ["four_times", "square", "twice"], "")
    assert [path.name.partition("-")[0] for path in files(cache)] == ["square", "four_times"]
    assert started(root) == (VALUES, [], "")


def test_what_an_import_changes_is_compiled_anew_and_nothing_else(root, warm):
    edited(root, "lower", "2.0", "3.0")
    assert started_here(root) == ([13.0, 9.0], ["four_times", "twice"], "")
    edited(root, "constants", "1.0", "0.5")
    assert started_here(root) == ([11.0, 9.0], ["four_times", "twice"], "")
    edited(root, "apart", "x * x\n\n", "x * x + 1.0\n\n")
    assert started_here(root) == ([11.0, 10.0], ["square"], "")
    edited(root, "apart", "x * x + 1.0", "x * x")
    assert started_here(root) == ([11.0, 9.0], [], ""), "an earlier state is still there"


def _other_format(content):
    rest = content.split(b"\n", 1)[1]
    return b"bearing_twin code 0\n" + rest


def _sealed(inner):
    return code_cache._MARK + zlib.crc32(inner).to_bytes(4, "big") + inner


DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "a bit": lambda content: content[:-100] + bytes([content[-100] ^ 1]) + content[-99:],
    "garbage": lambda content: b"\x80\x05garbage" * 100,
    "another format": _other_format,
    "what cannot be rebuilt": lambda content: _sealed(b"\x80\x04cno_such_module\nno_such_name\n."),
    "what is no code": lambda content: _sealed(b"N."),
}


def test_damaged_files_are_compiled_afresh(root, cache, warm):
    calls, values = CALLS[1:], VALUES[1:]
    for name, damage in DAMAGES.items():
        for path in (*cache.glob("*/square-*.code"), cache / "sources"):
            path.write_bytes(damage(path.read_bytes()))
        assert started_here(root, calls) == (values, ["square"], ""), name
        assert started_here(root, calls) == (values, [], ""), name


def _a_file_in_its_place(cache):
    cache.parent.mkdir()
    cache.write_text("")


def _folders_in_place_of_files(cache):
    for path in files(cache):
        path.unlink()
        path.mkdir()


def _a_folder_of_others(cache):
    cache.mkdir(parents=True)
    os.chown(cache, os.getuid() + 1, -1)


def _no_room(cache):
    # Files may not grow beyond this size in the processes of this test.
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))


@pytest.mark.parametrize("where", [_a_file_in_its_place, _folders_in_place_of_files, _a_folder_of_others, _no_room])
def test_where_nothing_can_be_kept_one_warning_is_all(root, cache, where, request):
    if where is _a_folder_of_others and os.getuid() != 0:
        pytest.skip("only root can give a folder away")
    if where is _folders_in_place_of_files:
        request.getfixturevalue("warm")
    if where is not _no_room:
        where(cache)
    between = (lambda: where(cache)) if where is _no_room else (lambda: None)
    values, names, said = started(root, between=between)
    assert (values, names) == (VALUES, ["four_times", "square", "twice"])
    assert said.startswith(f"bearing_twin: compiled code cannot be kept in {cache} (")
    assert said.count("\n") == 1
    assert where is _a_file_in_its_place or list(cache.rglob("*.part*")) == []


def test_processes_that_compile_at_once_do_not_mix(root, cache):
    calls = [("apart.square", 3.0), ("apart.square", 3), ("apart.square", 3j), ("apart.cube", 2), ("apart.cube", 2.0)]
    orders = [calls, calls[::-1], calls[2:] + calls[:2]]
    wanted = {repr(call): value for call, value in zip(calls, [9.0, 9, -9 + 0j, 8, 8.0], strict=True)}
    for values, order in zip([ended(*one) for one in [begun(root, order) for order in orders]], orders, strict=True):
        assert repr(values[0]) == repr([wanted[repr(call)] for call in order])
        assert values[2] == ""
    assert len(files(cache)) == len(calls)
    assert list(cache.rglob("*.part*")) == []
    assert started(root, calls) == (list(wanted.values()), [], "")
