"""Tortures the logs and the nodes and writes what came of it: `make torture`, or `python tests/torture.py --only kill`.

Every row says how often it was tried and survived, what was lost against the promise, and what went wrong unsaid.
`--write` puts the rows that ran into the table of docs/reliability.md, with machine and date. `--share 0.1` does a
tenth of each. Exit code 1 where something did not survive.
"""

import argparse
import datetime
import functools
import importlib.util
import os
import re
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path

from torture_inputs import ROWS as INPUTS
from torture_logs import ROWS as LOGS
from torture_rows import Found, Row

from bearing_twin.charts.contest import processor

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reliability.md"
MEMORY = Path("/dev/shm")  # there fsync costs nothing
HEADER = ("row", "what", "tried", "survived", "lost", "silent", "measured", "share", "seconds", "when")
_TABLE = re.compile(r"(<!-- torture -->\n)(.*?)(<!-- end -->)", flags=re.DOTALL)
_WHOLE = re.compile(r"(<!-- torture: all rows -->\n)(.*?)(<!-- end -->)", flags=re.DOTALL)


@functools.cache
def rows() -> dict[str, Row]:
    """Every row by name; those of nodes only where there is ROS."""
    tables = [*LOGS, *INPUTS]
    if all(map(importlib.util.find_spec, ("rclpy", "bearing_twin_msgs"))):
        from torture_nodes import ROWS as NODES

        tables += NODES
    else:
        print("torture: the rows of nodes are left out, for ROS is not set up", file=sys.stderr)
    return {row.name: row for row in tables}


def written(page: str, measured: dict[str, tuple[str, ...]], minutes: float | None = None) -> str:
    """The page with these rows in its table, in place of what it said of them, and with the time that all rows took."""
    old = _TABLE.search(page)
    lines = [line.strip("|").split("|") for line in old[2].splitlines()[2:]]
    cells = {line[0].strip("`"): tuple(line) for line in lines} | measured
    table = [HEADER, ("---",) * len(HEADER), *(cells[name] for name in rows() if name in cells)]
    page = page[: old.start(2)] + "".join(f"|{'|'.join(line)}|\n" for line in table) + page[old.end(2) :]
    if minutes is None:
        return page
    return _WHOLE.sub(rf"\g<1>All rows took {minutes:.0f} minutes on {when()}.\n\g<3>", page)


def when() -> str:
    """Today, the processor, and how many of it."""
    return f"{datetime.date.today()}, {os.cpu_count()} cores of {processor()}"


def run(row: Row, share: float) -> tuple[Found, float]:
    """Findings of a row, in a folder of its own, and how long it took [s]."""
    began = time.monotonic()
    parent = MEMORY if MEMORY.is_dir() else None
    with tempfile.TemporaryDirectory(dir=parent, ignore_cleanup_errors=True) as folder:
        try:
            outcome = row.run(share, Path(folder))
        except Exception as error:  # the other rows are still wanted
            traceback.print_exc()
            outcome = Found(1, 0, 0, 1, f"not measured: {type(error).__name__}")
    return outcome, time.monotonic() - began


def main() -> int:
    """Runs the rows that are asked for; see the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", default=[], choices=list(rows()), metavar="ROW", help=", ".join(rows()))
    parser.add_argument("--share", type=float, default=1.0, help="of every row, 1 = all of it")
    parser.add_argument("--write", action="store_true", help="write the table of docs/reliability.md")
    selected = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a job in the background passes on as ignored
    began, bad, cells = time.monotonic(), 0, {}
    for name, row in rows().items():
        if name not in (selected.only or rows()):
            continue
        outcome, seconds = run(row, selected.share)
        bad += outcome.survived < outcome.tried or bool(outcome.lost or outcome.silent)
        print(f"{name}: {outcome.tried} tried, {outcome.survived} survived, {outcome.lost} lost, "
              f"{outcome.silent} silent; {outcome.figures} ({seconds:.0f} s)", flush=True)  # fmt: skip
        counts = (str(count) for count in outcome[:4])
        measured = outcome.figures, f"{selected.share:g}", f"{seconds:.0f}", when()
        cells[name] = (f"`{name}`", row.what, *counts, *measured)
        if selected.write:
            minutes = (time.monotonic() - began) / 60.0 if len(cells) == len(rows()) else None
            PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), cells, minutes), encoding="utf-8")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
