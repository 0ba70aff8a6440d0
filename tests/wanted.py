"""Runs the tests that a change wants, within about a minute: `make check`, or `python tests/wanted.py [FILE ...]`.

Changed is what differs from where this branch left `main`, committed or not, or the files named. A test file is the
nearer to a change the fewer imports lie between them. Nearest first, tests are taken as long as the seconds they took
last time fit, and begun if they will end in time; those of CORE always are, at the end, so that a
busy machine has its time for what is near. What is left out is said.
"""

import ast
import re
import subprocess
import sys
from collections import deque
from collections.abc import Iterable, Mapping
from pathlib import Path

from sources import ROOT, statements_of

CORE = ("test_architecture", "test_parameters", "test_scene")  # quick, and about the whole house
MAIN = ("main", "origin/main", "origin/HEAD")
PLACE = re.compile(r'"(?:\{\w+\}\.)?([a-z]\w*(?:\.\w+)*): ?\w')
SECONDS = 45  # of tests; starting, collecting and compiling what changed come on top


def changed_files() -> list[str] | None:
    """Paths relative to the checkout, or None where git cannot tell."""
    bases = (_git("merge-base", branch, "HEAD") for branch in MAIN)
    base = next((found for found in bases if found), None)
    if not base:
        return None
    listed = [_git("diff", "--name-only", base[0]), _git("ls-files", "--others", "--exclude-standard")]
    return None if None in listed else sorted({*listed[0], *listed[1]})


def import_graph(root: Path = ROOT) -> dict[str, set[str]]:
    """Imports of each Python file of package and tests, paths relative to `root`; late ones and those by name, too."""
    paths = [
        *(root / "bearing_twin").rglob("*.py"),
        *(root / "tests").glob("*.py"),
        *(root / "tests").glob("*/test_*.py"),
    ]
    names = {_module(path.relative_to(root)): path.relative_to(root).as_posix() for path in paths}
    graph = {}
    for path in paths:
        found = set()
        for node in statements_of(path):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        found |= _named_places(path, root)
        graph[path.relative_to(root).as_posix()] = {names[name] for name in found & set(names)}
    return graph


def _named_places(path: Path, root: Path) -> set[str]:
    """Modules that a package names for an import at first use, as "module:name", or in a face as "module: words"."""
    package = _module(path.relative_to(root).parent / "__init__.py")
    found = PLACE.findall(path.read_text(encoding="utf-8"))
    return {name for module in found for name in (module, f"{package}.{module}")}


def distances(changed: Iterable[str], graph: Mapping[str, set[str]], root: Path = ROOT) -> dict[str, int]:
    """Number of imports between each test file and the nearest change.

    A file that is no Python counts as imported by the tests that name it, or its folder.
    """
    importers: dict[str, set[str]] = {}
    for path, imported in graph.items():
        for one in imported:
            importers.setdefault(one, set()).add(path)
    near, waiting = {}, deque()
    for path in changed:
        starts = {path} if path in graph else _naming(path, root)
        for start in starts:
            if near.setdefault(start, 0 if path in graph else 1) is not None:
                waiting.append(start)
    while waiting:
        path = waiting.popleft()
        for importer in importers.get(path, ()):
            if importer not in near or near[path] + 1 < near[importer]:
                near[importer] = near[path] + 1
                waiting.append(importer)
    return {path: steps for path, steps in near.items() if Path(path).name.startswith("test_")}


def _naming(path: str, root: Path) -> set[str]:
    words = {Path(path).name, *(f'"{name}"' for name in (Path(path).stem, Path(path).parent.name) if name)}
    tests = (root / "tests").rglob("test_*.py")
    return {one.relative_to(root).as_posix() for one in tests if any(word in one.read_text("utf-8") for word in words)}


def _module(path: Path) -> str:
    parts = path.with_suffix("").parts
    parts = parts[1:] if parts[0] == "tests" else parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _git(*words: str) -> list[str] | None:
    try:
        done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError:
        return None
    return done.stdout.split("\n")[:-1] if done.returncode == 0 else None


def main(named: list[str]) -> int:
    """Runs pytest on the files chosen; returns its exit code."""
    core = [f"tests/{name}.py" for name in CORE]
    changed = named or changed_files()
    if changed is None:
        print("git does not tell what changed (no branch main): the core tests only", file=sys.stderr)
    graph = import_graph()
    near = distances(changed or [], graph)
    for path in changed or []:
        if not distances([path], graph):
            print(f"no test is known to need {path}", file=sys.stderr)
    chosen = sorted(near.keys() - core, key=lambda path: (near[path], path)) + core
    print(f"{len(changed or [])} files changed; {len(chosen)} test files are near them", file=sys.stderr)
    words = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        f"--within={SECONDS}",
        f"--until={SECONDS}",
        f"--always={','.join(CORE)}",
        *chosen,
    ]
    return subprocess.run(words, cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
