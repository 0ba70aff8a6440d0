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
import stat
import sys
import time
import traceback
import zlib
from pathlib import Path
from types import SimpleNamespace

import numba
import pytest
from numba.core import event
from numba.core.cpu import CPUContext

import bearing_twin
from bearing_twin import code_cache, compiled, source_state

DAY = 86400.0
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
def known():
    """What parsing gave for each text, and gave already where kernels were compiled."""
    base = code_cache._base()
    return dict(code_cache._remembered(base / "sources")) if base else {}


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


def test_a_start_that_only_loads_needs_no_rules_of_typing(root, warm):
    """Numba's rules take half a second of a start; who compiles nothing does without."""
    assert started(root, between=lambda: setattr(CPUContext, "refresh", None)) == (VALUES, [], "")


EDITS_WITHOUT_EFFECT = (
    ("upper", "    return", "    # a comment\n\n    return"),
    ("upper", "Four times and more.", "Another sentence,\n\n    and a second one.\n    "),
    ("upper", '"""A kernel."""\n', '# A comment\n"""Some kernels."""\n\n'),
    ("lower", "Twice and more.", "Another sentence."),
    ("lower", "2.0 * x", "(2.0  *  x)"),
    ("constants", '"""Numbers."""\n', ""),
)


def test_comments_and_docstrings_compile_nothing(root, warm):
    for module, old, new in EDITS_WITHOUT_EFFECT:
        edited(root, module, old, new)
    assert started_here(root) == (VALUES, [], "")


def test_what_an_import_changes_is_compiled_anew_and_nothing_else(root, warm):
    edited(root, "lower", "2.0", "3.0")
    assert started_here(root) == ([13.0, 9.0], ["four_times", "twice"], "")
    edited(root, "constants", "1.0", "0.5")
    assert started_here(root) == ([11.0, 9.0], ["four_times", "twice"], "")
    edited(root, "apart", "x * x\n\n", "x * x + 1.0\n\n")
    assert started_here(root) == ([11.0, 10.0], ["square"], "")
    edited(root, "apart", "x * x + 1.0", "x * x")
    assert started_here(root) == ([11.0, 9.0], [], ""), "an earlier state is still there"


@pytest.mark.parametrize(
    "head",
    [
        "from tiny import lower",
        "import tiny.lower",
        "import tiny.lower as low",
        "from . import lower",
        "from .lower import twice",
        "from tiny.lower import *",
        "from tiny import twice",
        "try:\n    from tiny.lower import twice\nexcept ImportError:\n    pass",
    ],
)
def test_every_form_of_import_is_followed(root, head, known, monkeypatch):
    package = root / "tiny"
    if head == "from tiny import twice":
        (package / "__init__.py").write_text("from tiny.lower import twice\n")
    edited(root, "upper", "from tiny.lower import twice", head)
    tiny = SimpleNamespace(__file__=str(package / "__init__.py"), __path__=[str(package)])
    monkeypatch.setitem(sys.modules, "tiny", tiny)
    before = source_state.state_of("tiny.upper", known)
    edited(root, "constants", "1.0", "0.5")
    assert None is not before != source_state.state_of("tiny.upper", known)


def test_fields_that_change_places_are_compiled_anew(root):
    head = "from typing import NamedTuple\nfrom bearing_twin.compiled import kernel\n\n\n"
    pair = "class Pair(NamedTuple):\n    left: float\n    right: float\n\n\nPAIR = Pair(left=1.0, right=2.0)\n"
    (root / "tiny" / "pairs.py").write_text(head + pair)
    text = head + "from tiny.pairs import PAIR\n\n\n@kernel\ndef left(pair):\n    return pair.left\n\n\n"
    (root / "tiny" / "reader.py").write_text(text + "def read():\n    return left(PAIR)\n")
    assert started_here(root, [("reader.read",)]) == ([1.0], ["left"], "")
    edited(root, "pairs", "left: float\n    right: float", "right: float\n    left: float")
    assert started_here(root, [("reader.read",)]) == ([1.0], ["left"], "")


def test_classes_of_one_name_are_kept_apart(root):
    head = "from typing import NamedTuple\n\n\nclass Pair(NamedTuple):\n"
    (root / "tiny" / "one.py").write_text(head + "    left: float\n    right: float\n")
    (root / "tiny" / "two.py").write_text(head + "    right: float\n    left: float\n")
    text = "from bearing_twin.compiled import kernel\nfrom tiny import one, two\n\n\n"
    text += "@kernel\ndef left(pairs):\n    return pairs[0].left\n\n\n"
    for name in ("one", "two"):
        text += f"def of_{name}():\n    return left(({name}.Pair(left=1.0, right=2.0),))\n\n\n"
    (root / "tiny" / "reader.py").write_text(text)
    assert started(root, [("reader.of_one",)]) == ([1.0], ["left"], "")
    assert started(root, [("reader.of_one",), ("reader.of_two",)]) == ([1.0, 1.0], ["left"], "")


def test_nothing_is_kept_for_a_function_handed_over(root, cache):
    text = "from bearing_twin.compiled import kernel\nfrom tiny.lower import twice\n\n\n"
    text += (
        "@kernel\ndef applied(function, x):\n    return function(x)\n\n\ndef run():\n    return applied(twice, 1.0)\n"
    )
    (root / "tiny" / "taker.py").write_text(text)
    assert started(root, [("taker.run",)]) == ([3.0], ["applied", "twice"], "")
    assert files(cache) == []


def test_two_checkouts_share_what_is_compiled(root, tmp_path):
    started_here(root)
    other = made(tmp_path / "a" / "clone")
    for path in other.rglob("*.py"):
        os.utime(path, (1e9, 1e9))
    shutil.rmtree(root)
    assert started_here(other) == (VALUES, [], "")


def test_other_types_and_values_in_a_closure_are_kept_apart(root):
    text = "from bearing_twin.compiled import kernel\n\n\ndef _of(n):\n    @kernel\n    def power(x):\n"
    text += "        return x**n\n\n    return power\n\n\n_all = {n: _of(n) for n in (2, 3)}\n\n\n"
    text += "def both(x):\n    return [_all[2](x), _all[3](x)]\n\n\n"
    text += (
        "def _by(function):\n    @kernel\n    def applied(x):\n        return function(x)\n\n    return applied\n\n\n"
    )
    text += "by = _by(_all[2])\n"
    (root / "tiny" / "powers.py").write_text(text)
    calls = [("powers.both", 2.0), ("powers.both", 3)]
    assert started(root, calls) == ([[4.0, 8.0], [9, 27]], ["power"], "")
    assert started(root, calls) == ([[4.0, 8.0], [9, 27]], [], "")
    # What a function in a closure is made of, nobody can tell from this module's sources.
    for _ in range(2):
        assert started(root, [("powers.by", 3.0)]) == ([9.0], ["applied"], "")


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


def test_another_processor_or_compiler_has_code_of_its_own(root, warm, monkeypatch):
    calls, values = CALLS[1:], VALUES[1:]
    for owner, name, value in ((numba.config, "CPU_NAME", "generic"), (code_cache.llvmlite, "__version__", "0.0")):
        with monkeypatch.context() as other:
            other.setattr(owner, name, value)
            assert started_here(root, calls) == (values, ["square"], "")
            assert started_here(root, calls) == (values, [], "")
    assert started_here(root) == (VALUES, [], "")


def test_files_that_went_away_are_compiled_afresh(root, cache, warm):
    assert started(root, between=lambda: shutil.rmtree(cache)) == (VALUES, ["four_times", "square", "twice"], "")
    assert started(root) == (VALUES, [], "")


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


def test_the_folder_is_private(root, cache):
    cache.mkdir(parents=True, mode=0o755)
    started_here(root)
    folders = [cache, *(path for path in cache.iterdir() if path.is_dir())]
    assert len(folders) == 3
    assert {stat.S_IMODE(folder.stat().st_mode) for folder in folders} == {0o700}
    assert {stat.S_IMODE(path.stat().st_mode) for path in cache.rglob("*") if path.is_file()} == {0o600}


def test_the_users_own_folder_for_numba_is_respected(root, cache, tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "wanted"))
    started_here(root)
    assert len(files(tmp_path / "wanted" / "bearing_twin")) == 2
    assert not cache.exists()


def _aged(path, days):
    path.mkdir(parents=True, exist_ok=True)
    then = time.time() - days * DAY
    os.utime(path, (then, then))
    return path


def test_old_states_are_removed(root, cache):
    upper = [_aged(cache / f"tiny.upper-{n:020x}", days) for n, days in enumerate((3, 4, 5, 6))]
    young = [_aged(cache / f"tiny.upper-{n:020x}", 0.5) for n in range(10, 12)]
    other = [_aged(cache / f"tiny.uppermost-{n:020x}", 9) for n in range(5)]
    (cache / "kernels-00000000000000aa" / "contact_0").mkdir(parents=True)
    earlier = _aged(cache / "kernels-00000000000000aa" / "contact_0", 9).parent
    used = cache / "kernels-00000000000000bb"
    _aged(used / "contact_0", 0.5)
    foreign = [_aged(cache / name, 99) for name in ("kernels", "tiny.upper-notes", "kernels-00000000000000aaa")]
    _aged(earlier, 9)
    _aged(used, 9)
    started_here(root)
    assert [path.exists() for path in upper] == [False] * 4, "three later ones are there"
    assert all(path.exists() for path in [*young, *other, used, *foreign])
    assert not earlier.exists()


def test_states_are_kept_while_they_are_few_or_young(root, cache):
    upper = [_aged(cache / f"tiny.upper-{n:020x}", days) for n, days in enumerate((3, 400, 4, 500))]
    apart = [_aged(cache / f"tiny.apart-{n:020x}", 1.5) for n in range(9)]
    started_here(root)
    assert [path.exists() for path in upper] == [True, False, True, False]
    assert all(path.exists() for path in apart)


def test_a_use_is_marked_once_a_day(root, cache, warm):
    old, young = sorted(path for path in cache.iterdir() if path.is_dir())
    _aged(old, 1.5)
    marked = _aged(young, 0.5).stat().st_mtime
    began = time.time() - 0.25 * DAY
    assert started_here(root) == (VALUES, [], "")
    assert old.stat().st_mtime > began
    assert young.stat().st_mtime == marked


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


def test_what_was_edited_after_its_import_is_not_kept_as_the_new_state(root):
    values, names, _ = started(root, between=lambda: edited(root, "constants", "1.0", "0.5"))
    assert (values, names) == (VALUES, ["four_times", "square", "twice"])
    assert started(root) == ([5.5, 9.0], ["four_times", "twice"], "")


def test_importing_kernels_reads_no_sources_and_makes_no_folder(root, cache, monkeypatch):
    def refused(*_):
        raise AssertionError("this is for the first call")

    monkeypatch.setattr(code_cache, "state_of", refused)
    (root / "tiny" / "idle.py").write_text("from tiny import apart, upper\n\n\ndef nothing():\n    pass\n")
    assert started(root, [("idle.nothing",)]) == ([None], [], "")
    assert not cache.exists()


def test_numba_compiles_as_before_when_it_keeps_nothing(monkeypatch):
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    assert compiled.kernel(_plain) is _plain


def _plain(x):
    return x


def _kernel_states(known):
    names = [f"bearing_twin.{'.'.join(path.with_suffix('').parts)}" for path in map(Path, _KERNEL_FILES)]
    return {name: source_state.state_of(name, known) for name in names}


_PACKAGE = Path(bearing_twin.__file__).parent
_KERNEL_FILES = [
    str(path.relative_to(_PACKAGE)) for path in sorted(_PACKAGE.rglob("*.py")) if "\n@kernel\n" in path.read_text()
]


@pytest.fixture(scope="module")
def before(known):
    """The states of this checkout."""
    return _kernel_states(known)


@pytest.fixture
def copy(before, tmp_path, monkeypatch):
    """A copy of the package, which stands in its place."""
    copy = tmp_path / "bearing_twin"
    shutil.copytree(_PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(bearing_twin, "__path__", [str(copy)])
    monkeypatch.setattr(source_state, "_imported", {})
    return copy


def test_an_edit_in_a_beam_compiles_no_bearing(before, known, copy):
    for path in sorted((copy / "kinds" / "bearing").rglob("*.py"))[::8]:  # some of them: each is parsed for it
        path.write_text("# a comment\n" + path.read_text())
    assert None not in before.values()
    for path in (copy / "kinds" / "beam").glob("*.py"):
        path.write_text(path.read_text() + "\n\nEDITED = 1\n")
    after = _kernel_states(known)
    changed = {name for name in before if after[name] != before[name]}
    assert {name for name in before if ".kinds.beam." in name} <= changed
    assert not [name for name in changed if ".kinds.bearing." in name or ".contact." in name]


def test_an_edit_of_a_method_compiles_every_module_with_a_kernel_that_contains_it(before, known, copy):
    for name in ("numerics/rotation.py", "compiled.py"):
        path = copy / name
        text = path.read_text()
        path.write_text(text + "\n\nEDITED = 1\n")
        after = _kernel_states(known)
        changed = {one for one in before if after[one] != before[one]}
        assert {"bearing_twin.kinds.bearing.stepping.steps", "bearing_twin.kinds.ellipsoid.steps"} <= changed
        assert ("bearing_twin.contact.line" in changed) == (name == "compiled.py")
        path.write_text(text)
