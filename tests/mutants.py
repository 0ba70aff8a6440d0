"""Mutation tests: `make mutants`, or `python tests/mutants.py [ID ...]`.

A row of mutants.yaml describes a fault, the text that it replaces in the only file of a folder with that text, and the
names of the tests that must fail. Every mutant is tried in a copy of the checkout. The exit code is 1 if more than
SURVIVORS pass their tests, or if a row does not match the sources any more.
"""

import argparse
import functools
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent
ROWS = Path(__file__).with_suffix(".yaml")
KEYS = {"id", "room", "breaks", "where", "find", "put", "tests"}
ROOMS = ("contact", "bearing", "ring", "log", "uq", "nodes", "vibration")
SURVIVORS = 2  # accepted
SOURCES = (".py", ".hpp", ".cpp")
LINKED = (".venv", "install")  # folders of the checkout that the copy shares
LONGEST = 900  # s for the tests of a mutant; a mutant that hangs is noticed


def read_rows() -> list[dict]:
    """The rows of mutants.yaml; raises ValueError for an incomplete or repeated row."""
    rows = yaml.safe_load(ROWS.read_text(encoding="utf-8"))
    for row in rows:
        if set(row) != KEYS or row["room"] not in ROOMS or row["find"] == row["put"]:
            raise ValueError(
                f"mutant {row.get('id')}: a row has the keys {', '.join(sorted(KEYS))}, and changes a text"
            )
    if len({row["id"] for row in rows}) < len(rows):
        raise ValueError("two mutants have the same id")
    return rows


@functools.cache
def sources_below(folder: str) -> dict[Path, str]:
    """The texts of the sources below a folder of the checkout."""
    paths = sorted(path for path in (ROOT / folder).rglob("*") if path.suffix in SOURCES)
    return {path: path.read_text(encoding="utf-8") for path in paths}


def node_ids(names: list[str]) -> list[str]:
    """The pytest ids, as tests/test_x.py::test_name, of tests by name; raises ValueError for an unknown test."""
    texts, ids = sources_below("tests"), []
    for name in names:
        bare = name.partition("[")[0]
        files = [path for path, text in texts.items() if f"\ndef {bare}(" in text]
        if len(files) != 1:
            raise ValueError(f"{bare} is the name of {len(files)} tests; it must be that of one")
        ids.append(f"{files[0].relative_to(ROOT).as_posix()}::{name}")
    return ids


def file_of(row: dict) -> Path:
    """The file, relative to the checkout, with the text of a row; raises ValueError unless the text occurs once."""
    counts = {path: text.count(row["find"]) for path, text in sources_below(row["where"]).items()}
    if sum(counts.values()) != 1:
        raise ValueError(f"{row['where']} has its text {sum(counts.values())} times; correct the row")
    return max(counts, key=counts.get).relative_to(ROOT)


def copy_checkout(target: Path) -> None:
    """Copy tracked and new files of the checkout, and link what the set-up made."""
    names = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=ROOT, stdout=subprocess.PIPE, check=True
    ).stdout
    for name in filter(None, names.decode().split("\0")):
        if (ROOT / name).is_file() and name not in LINKED:
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target / name)
    for name in LINKED:
        if (ROOT / name).exists():
            (target / name).symlink_to((ROOT / name).resolve())


def environment_of(target: Path, cache: Path) -> dict[str, str]:
    """The environment of the tests: the package of the copy, and a cache of its own."""
    paths = [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path and path != str(ROOT)]
    return {**os.environ, "XDG_CACHE_HOME": str(cache), "PYTHONPATH": os.pathsep.join([str(target), *paths])}


def run_tests(target: Path, environment: dict[str, str], ids: list[str]) -> int | None:
    """The exit code of pytest for these tests in the copy, after a build; None if they take longer than LONGEST."""
    build = [sys.executable, target / "core" / "build.py"]
    subprocess.run(build, env=environment, stdout=subprocess.DEVNULL, check=True)
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *ids]
    with subprocess.Popen(
        command,
        cwd=target,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        try:
            return process.wait(LONGEST)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            return None


def main(arguments: list[str] | None = None) -> int:
    """Try the mutants of these ids, or all."""
    parser = argparse.ArgumentParser(prog="python tests/mutants.py", description="Tests against broken products.")
    parser.add_argument("ids", nargs="*", metavar="ID", help="mutants to try; all without")
    requested = parser.parse_args(arguments).ids
    rows = [row for row in read_rows() if not requested or row["id"] in requested]
    problems, mutants = [], {}
    for row in rows:
        try:
            mutants[row["id"]] = file_of(row), node_ids(row["tests"])
        except ValueError as error:
            problems.append(f"{row['id']}: {error}")
    if problems:
        print(*problems, sep="\n")
        return 1
    survivors = 0
    with tempfile.TemporaryDirectory(prefix="mutants_") as folder:
        target, cache = Path(folder) / "checkout", Path(folder) / "cache"
        copy_checkout(target)
        environment = environment_of(target, cache)
        every = sorted({node_id for _, ids in mutants.values() for node_id in ids})
        if run_tests(target, environment, every) != 0:
            print(f"the tests fail without a mutant: python -m pytest {' '.join(every)}")
            return 1
        for row in rows:
            (file, ids), start = mutants[row["id"]], time.monotonic()
            path = target / file
            text = path.read_text(encoding="utf-8")
            path.write_text(text.replace(row["find"], row["put"]), encoding="utf-8")
            survived = run_tests(target, environment, ids) == 0
            path.write_text(text, encoding="utf-8")
            survivors += survived
            seconds = time.monotonic() - start
            print(
                f"{'SURVIVED' if survived else 'killed  '} {row['id']:28}{seconds:6.0f} s  {row['breaks']}", flush=True
            )
    print(f"{len(rows) - survivors} of {len(rows)} killed")
    return int(survivors > SURVIVORS)


if __name__ == "__main__":
    sys.exit(main())
