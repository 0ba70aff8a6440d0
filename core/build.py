"""Builds the compiled core: `python core/build.py`; the standard library and a C++ compiler are enough.

Every `.cpp` below this folder is a unit of its own. A unit is compiled again where its text, that of a header it
includes or its flags have changed. A linked library is renamed at the end, so that no incomplete one is loaded.
"""

import functools
import hashlib
import os
import platform
import re
import shlex
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

SOURCES = Path(__file__).resolve().parent
PACKAGE = SOURCES.parent / "bearing_twin" / "_core"  # where the library stands beside the package
OBJECTS = SOURCES.parent / "build" / "core"
FLAGS = (
    *("-std=c++20", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),
    *("-fPIC", "-fvisibility=hidden", "-Wall", "-Wextra", "-Wno-psabi", f"-I{SOURCES}"),
)
# Units by -O3, where runs spend their time: they take 16 % less. The others compile in two thirds of the time by -O2.
OFTEN = ("rosenbrock_balls", "balls", "equilibrium", "shaft", "soft_discs", "two_bodies")
ALL = ("x86-64-v2", "x86-64-v3", "x86-64-v4") if platform.machine() == "x86_64" else ("native",)
JOBS = 2
NAME = "libbearing_twin_core-{}.so"  # with the instruction set
COMPILERS = ("c++", "g++", "clang++")
_INCLUDED = re.compile(rb'^\s*#\s*include\s+"([^"]+)"', flags=re.MULTILINE)
_LEVELS = (("__AVX512VL__", "-x86-64-v4"), ("__AVX2__", "-x86-64-v3"), ("__SSE4_2__", "-x86-64-v2"))


class BuildError(Exception):
    """The core cannot be built here; the message is a sentence."""


def sources() -> list[Path]:
    """All sources of the library, sorted: units, headers, and this file with the flags."""
    return sorted(path for path in SOURCES.rglob("*") if path.suffix in (".cpp", ".hpp", ".py"))


def build_id() -> str:
    """Twelve hexadecimal digits for the text of all sources."""
    digest = hashlib.sha256()
    for path in sources():
        content = path.read_bytes()
        digest.update(f"{path.relative_to(SOURCES).as_posix()} {len(content)} ".encode() + content)
    return digest.hexdigest()[:12]


def compiler() -> list[str] | None:
    """Arguments that call the compiler: `$CXX`, or the first of COMPILERS that is installed; None without one."""
    requested = shlex.split(os.environ.get("CXX", ""))
    for program, *arguments in filter(None, (requested, *([name] for name in COMPILERS))):
        if path := shutil.which(program):
            return [path, *arguments]
    return None


def build(target: Path = PACKAGE, march: Sequence[str] = ("native",), extra: Sequence[str] = ()) -> list[Path]:
    """Build one library in the folder `target` for each instruction set, and remove those of others from there.

    Parameters
    ----------
    target : Path
        Folder of the libraries, each a NAME; it is made.
    march : sequence of str
        Values of `-march`: "native" for the processor at hand, "x86-64-v3", "armv8-a"; ["all"] for ALL, as in wheels.
    extra : sequence of str
        Further flags, after FLAGS.

    Raises
    ------
    BuildError
        There is no compiler, or it fails.
    """
    if not (command := compiler()):
        raise BuildError("no C++ compiler is found (Debian: apt install g++); CXX names another one")
    target.mkdir(parents=True, exist_ok=True)
    made = [_library(target, command, level, tuple(extra)) for level in (ALL if list(march) == ["all"] else march)]
    for path in target.glob(NAME.format("*")):
        if path not in made:
            path.unlink()
    return made


def _library(target: Path, command: list[str], march: str, extra: tuple[str, ...]) -> Path:
    from concurrent.futures import ThreadPoolExecutor  # imported here, as build_id needs none of it

    call = [*command, *FLAGS, f"-march={march}", *extra]
    macros = _run([*call, "-dM", "-E", "-x", "c++", os.devnull])
    name = march
    if march == "native":
        name += next((level for macro, level in _LEVELS if f" {macro} " in macros), "")
    compiler_version = re.search(r' __VERSION__ "(.*)"', macros)
    text = f"{Path(command[0]).name} {compiler_version[1] if compiler_version else ''}, {' '.join((name, *extra))}"
    version = (
        'extern "C" [[gnu::visibility("default")]] const char *core_version();\n'
        f'const char *core_version() {{ return "build {build_id()}, {text}"; }}\n'
    )
    objects = OBJECTS / re.sub(r"\W+", "_", text)
    objects.mkdir(parents=True, exist_ok=True)
    (objects / "version.cpp").write_text(version, encoding="utf-8")
    with ThreadPoolExecutor(JOBS) as pool:
        units = [objects / "version.cpp", *sorted(SOURCES.rglob("*.cpp"))]
        compiled = list(pool.map(functools.partial(_object, objects, call, macros), units))
    for path in objects.glob("*.o"):
        if path not in compiled:
            path.unlink()
    library = target / NAME.format(name)
    static = () if march == "native" else ("-static-libstdc++", "-static-libgcc")  # for machines with other compilers
    _write_complete(library, [*call, "-shared", "-Wl,--no-undefined", *static, *map(str, compiled)])
    return library


def _object(folder: Path, call: list[str], macros: str, unit: Path) -> Path:
    """The object file of a unit, whose name has a digest of its sources and flags."""
    if unit.stem in OFTEN:
        call = [*call]
        call[call.index("-O2")] = "-O3"
    digest = hashlib.sha256(f"{call}{macros}".encode())
    for source, content in sorted(_texts(unit, {}).items()):
        digest.update(f"{source} {len(content)} ".encode() + content)
    path = folder / f"{unit.stem}-{digest.hexdigest()[:16]}.o"
    if not path.exists():
        _write_complete(path, [*call, "-c", str(unit)])
    return path


def _texts(path: Path, known: dict[Path, bytes]) -> dict[Path, bytes]:
    """A source file and all of ours that it includes."""
    if path not in known:
        known[path] = path.read_bytes()
        for name in _INCLUDED.findall(known[path]):
            for folder in (path.parent, SOURCES):
                if (included := (folder / name.decode()).resolve()).is_file():
                    _texts(included, known)
                    break
    return known


def _write_complete(path: Path, call: list[str]) -> None:
    """Run a command that writes a file by `-o`, which is renamed when it is complete."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        _run([*call, "-o", str(draft)])
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def _run(call: list[str]) -> str:
    import subprocess

    done = subprocess.run(call, capture_output=True, text=True, check=False)
    if done.returncode:
        raise BuildError(f"{shlex.join(call)} failed with exit code {done.returncode}:\n{done.stderr}")
    sys.stderr.write(done.stderr)
    return done.stdout


def main() -> int:
    """Build, and print the paths of the libraries; 2 where it cannot be."""
    import argparse

    parser = argparse.ArgumentParser(description="Builds the compiled core of bearing_twin.")
    parser.add_argument("--march", nargs="+", default=["native"], help="instruction sets (default: native), or all")
    parser.add_argument("--into", type=Path, default=PACKAGE, metavar="FOLDER", help=f"default: {PACKAGE}")
    parser.add_argument("--flags", default="", help='further flags, as --flags="-g -fsanitize=undefined"')
    arguments = parser.parse_args()
    try:
        print(*build(arguments.into, arguments.march, shlex.split(arguments.flags)), sep="\n")
    except BuildError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
