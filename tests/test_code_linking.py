"""A kernel is compiled once for all that call it, joined to them at every start, and callable by Python on demand."""

import pickle
import re
import signal
import sys

import pytest
from numba.core.registry import cpu_target
from test_compiled import cache, edited, files, numba_is_ready, started, started_beside, warm  # noqa: F401 - fixtures

from bearing_twin import code_cache, code_linking, source_state

STEPS = "\n".join(f"    x = x * 1.0{n} + {n}.0 / (x * x + {n}.5)" for n in range(1, 11))
SOURCES = {
    "__init__": "",
    "long": f"from bearing_twin.compiled import kernel\n\n\n@kernel\ndef long(x):\n{STEPS}\n    return x\n",
    "short": (
        "from bearing_twin.compiled import inlined, kernel\nfrom tiny.long import long\n\n\n"
        "@kernel\ndef short(x):\n    return long(x) + 1.0\n\n\n@inlined\ndef half(x):\n    return 0.5 * short(x)\n"
    ),
    "upper": (
        "from bearing_twin.compiled import kernel\nfrom tiny.short import half, short\n\n\n"
        "@kernel\ndef upper(x):\n    return half(x) + short(2.0 * x)\n"
    ),
    "lax": "from bearing_twin import code_linking\n\n\ndef small_up_to(x):\n    code_linking.SMALL = x\n    return x\n",
}
UPPER, LONG, SHORT = ("upper.upper", 3.0), ("long.long", 3.0), ("short.short", 3.0)


@pytest.fixture(scope="module", autouse=True)
def small():
    """Ten lines are a long kernel already, which are compiled in a third of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(code_linking, "SMALL", 40)
        yield


def made(root):
    (root / "tiny").mkdir(parents=True)
    for name, text in SOURCES.items():
        (root / "tiny" / f"{name}.py").write_text(text)
    return root


@pytest.fixture
def root(tmp_path):
    return made(tmp_path / "checkout")


@pytest.fixture(scope="module")
def compiled_once(tmp_path_factory):
    """A cache in which UPPER is, with all that it takes."""
    folder = tmp_path_factory.mktemp("once")
    found = started_beside(made(folder / "checkout"), [UPPER])
    assert found == ([TRUTH], ["half", "long", "short", "upper"], "")
    return folder / "cache" / "bearing_twin"


def long(x):
    for n in range(1, 11):
        x = x * float(f"1.0{n}") + n / (x * x + n + 0.5)
    return x


TRUTH = 0.5 * (long(3.0) + 1.0) + long(6.0) + 1.0
TRUTH_SHORT = long(3.0) + 1.0


def file_of(cache, name):  # noqa: F811
    return next(path for path in files(cache) if path.name.startswith(f"{name}-"))


def content_of(root, path):
    """What a file holds: key, compiled form, how it is called by name, and what it calls by name."""
    sys.path.insert(0, str(root))
    try:
        return pickle.loads(code_cache._read(path))
    finally:
        sys.path.remove(str(root))
        for name in [name for name in sys.modules if name.partition(".")[0] == "tiny"]:
            del sys.modules[name]
            source_state._imported.pop(name, None)


def test_a_long_kernel_is_called_and_a_short_one_is_put_into_its_callers(root, cache, warm):  # noqa: F811
    upper, short, long_one = (content_of(root, file_of(cache, name)) for name in ("upper", "short", "long"))
    assert [one[2][1] for one in (upper, short, long_one)] == [False, False, True]
    assert [one.function for one in upper[3]] == ["long"]
    identity = long_one[2][0]
    assert identity == upper[3][0] == short[3][0]
    assert identity.symbol in dict.fromkeys(re.findall(r"[\w.$]+", long_one[1][0][2][0].decode("latin-1")))


def test_a_kernel_that_was_called_by_name_may_become_a_short_one(root, cache):  # noqa: F811
    """Forms with a way in and without can lie on either side of the limit: callers need what their code calls."""
    assert started(root, [SHORT])[0] == [TRUTH_SHORT]
    file_of(cache, "long").unlink()
    assert started(root, [("lax.small_up_to", 10**6), LONG])[1] == ["long"]
    assert content_of(root, file_of(cache, "long"))[2][1] is False
    assert started(root, [UPPER]) == ([TRUTH], ["half", "upper"], "")
    assert [one.function for one in content_of(root, file_of(cache, "upper"))[3]] == ["long"]
    assert started(root, [UPPER]) == ([TRUTH], [], "")


def test_a_start_joins_what_was_kept(root, warm):  # noqa: F811
    assert started(root, [UPPER]) == ([TRUTH], [], "")


def test_a_called_kernel_that_is_lost_is_compiled_again_and_no_other(root, cache, warm):  # noqa: F811
    file_of(cache, "long").unlink()
    assert started(root, [UPPER]) == ([TRUTH], ["long"], "")
    assert started(root, [UPPER]) == ([TRUTH], [], "")


def test_an_edit_of_a_called_kernel_is_seen(root, warm):  # noqa: F811
    edited(root, "long", "    return x", "    return x + 4.0")
    assert started(root, [UPPER])[0] == [pytest.approx(TRUTH + 0.5 * 4.0 + 4.0, rel=1e-15)]


def test_python_calls_what_kernels_called_first(root, warm):  # noqa: F811
    """Its way in is made when it is wanted, once, before or after the kernel that needs none."""
    values = [TRUTH, pytest.approx(long(3.0), rel=1e-15)]
    assert started(root, [UPPER, LONG]) == (values, ["long"], "")
    assert started(root, [UPPER, LONG]) == (values, [], "")
    assert started(root, [LONG, UPPER]) == (values[::-1], [], "")


def test_what_python_gets_of_a_callee_is_whole(root):
    """An array that it returns needs constants, which its callers keep without those of its way in."""
    made = "import numpy as np\nfrom bearing_twin.compiled import kernel\n\n\n@kernel\ndef room(n):\n"
    (root / "tiny" / "made.py").write_text(f"{made}    return np.full(n, 1.5)\n")
    caller = "from bearing_twin.compiled import kernel\nfrom tiny.made import room\n\n\n@kernel\ndef last(n):\n"
    (root / "tiny" / "caller.py").write_text(f"{caller}    return room(n)[-1] + room(n + 1)[-2]\n")
    for calls in ([("caller.last", 1)], [("made.room", 1)], [("caller.last", 1), ("made.room", 1)]):
        values = started(root, calls)[0]
    assert (values[0], list(values[1])) == (3.0, [1.5])
    assert started(root, calls)[1:] == ([], "")


def test_what_python_calls_of_inlined_functions_is_kept(root):
    half = ("short.half", 3.0)
    value = [pytest.approx(0.5 * (long(3.0) + 1.0), rel=1e-15)]
    assert started(root, [half])[:2] == (value, ["half", "long", "short"])
    assert started(root, [half]) == (value, [], "")
    assert started(root, [UPPER, half])[1] == ["half", "upper"], "its compiled form is in its caller, where half is"


def test_a_kernel_that_is_not_what_it_was_is_not_called(root, cache, warm, monkeypatch):  # noqa: F811
    path = file_of(cache, "upper")
    key, form, own, needed, constants = content_of(root, path)
    code_cache._write(
        path, pickle.dumps((key, form, own, [one._replace(symbol="another") for one in needed], constants))
    )
    assert started(root, [UPPER]) == ([TRUTH], ["half", "upper"], "")


def test_names_of_kernels_say_what_they_are_compiled_from():
    """Two of one name that say different things are two symbols; the same thing said twice is one."""
    symbols = []
    for number in (1.5, 2.5, 1.5):
        scope = {"__name__": __name__}
        exec(f"def one(x):\n{STEPS}\n    return x + {number}", scope)
        function = code_linking.dispatcher(scope["one"], {"error_model": "numpy"})
        function._cache = code_cache.CodeCache(scope["one"])
        function._cache.disable()
        function(1.0)
        symbols.append(next(iter(function.overloads.values())).fndesc.llvm_func_name)
        assert function(1.0) == long(1.0) + number
    assert symbols[0] == symbols[2] != symbols[1]


def test_a_signal_while_code_is_loaded_leaves_no_wrong_code(root, warm):  # noqa: F811
    """LLVM asks Python for the code and drops what a handler raises there; it compiled other code, which crashed."""

    def signalled():
        engine = cpu_target.target_context.codegen()._engine._ee
        given, compile_, asked = engine._object_cache_getbuffer, code_linking._Dispatcher.compile, []

        def interrupted(module):
            asked.append(module.name)
            signal.raise_signal(signal.SIGINT)
            return given(module)

        def again(self, sig):
            try:
                return compile_(self, sig)
            except KeyboardInterrupt:
                engine._object_cache_getbuffer = given
                print(f"interrupted after {len(asked)}", file=sys.stderr)
                return compile_(self, sig)

        signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where tests run in the background
        engine._object_cache_getbuffer, code_linking._Dispatcher.compile = interrupted, again

    values, compiled, said = started(root, [UPPER], signalled)
    assert (values, compiled) == ([TRUTH], [])
    assert "interrupted after" in said
