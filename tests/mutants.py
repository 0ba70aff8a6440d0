"""Runs the tests against a product that is broken on purpose: `make mutants`, or `python tests/mutants.py [ID ...]`.

Each row of mutants.yaml says what it breaks in words, which text becomes which other in the one file of a folder that
holds it, and the names of the tests that must notice. Every mutant is tried in a copy of the checkout.
Exit code 1 if more than SURVIVORS are not noticed, or a row fits the sources no more.
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
SURVIVORS = 2  # that are let pass
SOURCES = (".py", ".hpp", ".cpp")
LINKED = (".venv", "install")  # of the checkout, which the copy shares
LONGEST = 900  # s of one mutant's tests: what hangs is noticed


def read_rows() -> list[dict]:
    """The rows of mutants.yaml; raises ValueError for one that is not whole or that is there twice."""
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
def texts_below(folder: str) -> dict[Path, str]:
    """The sources below a folder of the checkout, as they are."""
    paths = sorted(path for path in (ROOT / folder).rglob("*") if path.suffix in SOURCES)
    return {path: path.read_text(encoding="utf-8") for path in paths}


def places_of(names: list[str]) -> list[str]:
    """Paths of pytest, as tests/test_x.py::test_name, of tests by their names; raises ValueError for one not there."""
    texts, places = texts_below("tests"), []
    for name in names:
        bare = name.partition("[")[0]
        found = [path for path, text in texts.items() if f"\ndef {bare}(" in text]
        if len(found) != 1:
            raise ValueError(f"{bare} is the name of {len(found)} tests; give that of one")
        places.append(f"{found[0].relative_to(ROOT).as_posix()}::{name}")
    return places


def seed_of(row: dict) -> Path:
    """The file, below the checkout, that holds a row's text; raises ValueError unless it stands there once, in one."""
    counts = {path: text.count(row["find"]) for path, text in texts_below(row["where"]).items()}
    if sum(counts.values()) != 1:
        raise ValueError(f"{row['where']} holds its text {sum(counts.values())} times: seed it where the code is now")
    return max(counts, key=counts.get).relative_to(ROOT)


def copy_checkout(target: Path) -> None:
    """Files that git knows of the checkout, changed or new, and links to what the set-up made."""
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


def surroundings(target: Path, cache: Path) -> dict[str, str]:
    """The environment of the tests: the package of the copy, and a cache of its own."""
    paths = [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path and path != str(ROOT)]
    return {**os.environ, "XDG_CACHE_HOME": str(cache), "PYTHONPATH": os.pathsep.join([str(target), *paths])}


def tested(target: Path, environment: dict[str, str], places: list[str]) -> int | None:
    """Exit code of pytest on these tests in the copy, its core as its sources are; None where they exceed LONGEST."""
    build = [sys.executable, target / "core" / "build.py"]
    subprocess.run(build, env=environment, stdout=subprocess.DEVNULL, check=True)
    words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *places]
    with subprocess.Popen(
        words, cwd=target, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    ) as process:
        try:
            return process.wait(LONGEST)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            return None


def main(words: list[str] | None = None) -> int:
    """Try the mutants of these ids, or all; see the top of the file for the exit code."""
    parser = argparse.ArgumentParser(prog="python tests/mutants.py", description="Tests against broken products.")
    parser.add_argument("ids", nargs="*", metavar="ID", help="mutants to try; all without")
    asked = parser.parse_args(words).ids
    rows = [row for row in read_rows() if not asked or row["id"] in asked]
    problems, seeds = [], {}
    for row in rows:
        try:
            seeds[row["id"]] = seed_of(row), places_of(row["tests"])
        except ValueError as error:
            problems.append(f"{row['id']}: {error}")
    if problems:
        print(*problems, sep="\n")
        return 1
    survivors = 0
    with tempfile.TemporaryDirectory(prefix="mutants_") as folder:
        target, cache = Path(folder) / "checkout", Path(folder) / "cache"
        copy_checkout(target)
        environment = surroundings(target, cache)
        every = sorted({place for _, places in seeds.values() for place in places})
        if tested(target, environment, every) != 0:
            print(f"the tests fail as it is: python -m pytest {' '.join(every)}")
            return 1
        for row in rows:
            (seed, places), begun = seeds[row["id"]], time.monotonic()
            path = target / seed
            text = path.read_text(encoding="utf-8")
            path.write_text(text.replace(row["find"], row["put"]), encoding="utf-8")
            survived = tested(target, environment, places) == 0
            path.write_text(text, encoding="utf-8")
            survivors += survived
            seconds = time.monotonic() - begun
            print(
                f"{'SURVIVED' if survived else 'killed  '} {row['id']:28}{seconds:6.0f} s  {row['breaks']}", flush=True
            )
    print(f"{len(rows) - survivors} of {len(rows)} killed")
    return int(survivors > SURVIVORS)


if __name__ == "__main__":
    sys.exit(main())
