"""Tortures the logs and the nodes and writes what came of it: `make torture`, or `python tests/torture.py --only kill`.

Every row says how often it was tried and survived, what was lost against the promise, and what went wrong unsaid.
`--write` puts the rows that ran into the table of docs/reliability.md, with machine and date. `--share 0.1` does a
tenth of each. A long row of little load runs in a process of its own beside the others; what it says goes to a file.
Exit code 1 where something did not survive, 130 after Ctrl-C, when all that was started has ended.
"""

import argparse
import contextlib
import datetime
import functools
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from torture_inputs import ROWS as INPUTS
from torture_logs import ROWS as LOGS
from torture_rows import ENDS, Found, Row, end_children, until

from bearing_twin.charts.rows import processor

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reliability.md"
SAID = ROOT / "build" / "logs"
MEMORY = Path("/dev/shm")  # there fsync costs nothing
HEADER = ("row", "what", "tried", "survived", "lost", "silent", "measured", "share", "seconds", "when")
PATIENCE = 200.0  # s: three nodes of a row have a minute each to end
FOLDERS: list[str] = []  # of rows; what a row started may write there until it has ended
_TABLE = re.compile(r"(<!-- torture -->\n)(.*?)(<!-- end -->)", flags=re.DOTALL)
_WHOLE = re.compile(r"(<!-- torture: all rows -->\n)(.*?)(<!-- end -->)", flags=re.DOTALL)


class Outcome(NamedTuple):
    """What a row found, and how long it took [s]."""

    found: Found
    seconds: float

    @property
    def survived(self) -> bool:
        """Whether nothing went wrong."""
        return self.found.survived >= self.found.tried and not self.found.lost and not self.found.silent


@functools.cache
def rows() -> dict[str, Row]:
    """Every row by name; those of nodes only where there is ROS."""
    found = [*LOGS, *INPUTS]
    if all(map(importlib.util.find_spec, ("rclpy", "bearing_twin_msgs"))):
        from torture_nodes import ROWS as NODES
        from torture_stops import ROWS as STOPS

        found += [*STOPS, *NODES]
    else:
        print("torture: the rows of nodes are left out, for ROS is not set up", file=sys.stderr)
    return {row.name: row for row in found}


def written(page: str, found: dict[str, tuple[str, ...]]) -> str:
    """The page with these rows in its table, in place of what it said of them."""
    old = _TABLE.search(page)
    lines = [line.strip("|").split("|") for line in old[2].splitlines()[2:]]
    cells = {line[0].strip("`"): tuple(line) for line in lines} | found
    table = [HEADER, ("---",) * len(HEADER), *(cells[name] for name in rows() if name in cells)]
    return page[: old.start(2)] + "".join(f"|{'|'.join(line)}|\n" for line in table) + page[old.end(2) :]


def with_minutes(page: str, minutes: float) -> str:
    """The page with the time that all rows took."""
    return _WHOLE.sub(rf"\g<1>All rows took {minutes:.0f} minutes on {when()}.\n\g<3>", page)


def when() -> str:
    """Today, the processor, and how many of it."""
    return f"{datetime.date.today()}, {os.cpu_count()} cores of {processor()}"


def run(row: Row, share: float) -> Outcome:
    """Runs a row here, in a folder of its own."""
    began = time.monotonic()
    place = MEMORY if MEMORY.is_dir() else None
    with tempfile.TemporaryDirectory(dir=place, ignore_cleanup_errors=True) as folder:
        FOLDERS.append(folder)
        try:
            found = row.run(share, Path(folder))
        except Exception as error:  # the other rows are worth having
            traceback.print_exc()
            found = Found(1, 0, 0, 1, f"not measured: {type(error).__name__}")
    return Outcome(found, time.monotonic() - began)


class Beside:
    """A row that runs in a process of its own. A terminal's Ctrl-C does not reach it: it is handed on, once."""

    def __init__(self, row: Row, share: float):
        self.row, self.said = row, SAID / f"torture_{row.name}.txt"
        SAID.mkdir(parents=True, exist_ok=True)
        words = [sys.executable, __file__, "--only", row.name, "--share", str(share), "--json"]
        with self.said.open("wb") as said:
            self._process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=said, start_new_session=True)
        print(f"{row.name}: begun beside the others; what it says: {self.said}", file=sys.stderr)

    def outcome(self) -> Outcome:
        """What came of it, once it has ended."""
        if self._process.poll() is None:
            print(f"{self.row.name}: still runs", file=sys.stderr)
        told, _ = self._process.communicate()
        try:
            one = json.loads(told)
        except ValueError:
            return Outcome(Found(1, 0, 0, 1, f"not measured: exit code {self._process.returncode}"), 0.0)
        return Outcome(Found(**one["found"]), one["seconds"])

    def end(self) -> None:
        """Ends it and what it started."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        if not until(lambda: self._process.poll() is not None, PATIENCE):
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()


def outcomes(chosen: list[Row], share: float) -> Iterator[tuple[Row, Outcome]]:
    """Each row with what came of it: those of long time and little load last, for they run beside the others."""
    alone = [row for row in chosen if not row.beside] or chosen
    besides: list[Beside] = []
    try:
        for row in chosen:
            if row not in alone:
                besides.append(Beside(row, share))
        for row in alone:
            yield row, run(row, share)
        for one in besides:
            yield one.row, one.outcome()
    finally:
        for one in besides:
            one.end()


def main() -> int:
    """Runs the rows that are asked for; see the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", default=[], choices=list(rows()), metavar="ROW", help=", ".join(rows()))
    parser.add_argument("--share", type=float, default=1.0, help="of every row, 1 = all of it")
    parser.add_argument("--write", action="store_true", help="write the table of docs/reliability.md")
    parser.add_argument("--json", action="store_true", help="an object a row instead of a sentence")
    asked = parser.parse_args()
    # A shell's job in the background ignores it, and so would all that is started here, which is ended by it.
    for number in ENDS:
        signal.signal(number, signal.default_int_handler)
    try:
        chosen = [row for name, row in rows().items() if name in (asked.only or rows())]
        with contextlib.closing(outcomes(chosen, asked.share)) as running:
            return tell(running, asked)
    except KeyboardInterrupt:
        for number in ENDS:  # all that was started is being ended
            signal.signal(number, signal.SIG_IGN)
        end_children()
        for folder in FOLDERS:
            shutil.rmtree(folder, ignore_errors=True)
        print("torture: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT


def _plain(number) -> int | float:
    return number.item()  # of NumPy


def tell(running: Iterator[tuple[Row, Outcome]], asked: argparse.Namespace) -> int:
    """Prints and writes what comes of rows; 1 where something did not survive."""
    began, bad, cells = time.monotonic(), 0, {}
    for row, outcome in running:
        found, seconds = outcome
        bad += not outcome.survived
        if asked.json:
            print(
                json.dumps({"row": row.name, "found": found._asdict(), "seconds": seconds}, default=_plain), flush=True
            )
        else:
            print(f"{row.name}: {found.tried} tried, {found.survived} survived, {found.lost} lost, "
                  f"{found.silent} silent; {found.figures} ({seconds:.0f} s)", flush=True)  # fmt: skip
        counts = (str(one) for one in found[:4])
        cells[row.name] = (
            f"`{row.name}`", row.what, *counts, found.figures, f"{asked.share:g}", f"{seconds:.0f}", when()
        )  # fmt: skip
        if asked.write:
            PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), cells), encoding="utf-8")
    if asked.write and len(cells) == len(rows()) and asked.share == 1.0:
        minutes = (time.monotonic() - began) / 60.0
        PAGE.write_text(with_minutes(PAGE.read_text(encoding="utf-8"), minutes), encoding="utf-8")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
