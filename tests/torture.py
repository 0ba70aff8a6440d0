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

from bearing_twin.charts.made import processor

PAGE = Path(__file__).resolve().parent.parent / "docs" / "reliability.md"
MEMORY = Path("/dev/shm")  # there fsync costs nothing
HEADER = ("row", "what", "tried", "survived", "lost", "silent", "measured", "share", "when")
_TABLE = re.compile(r"(<!-- torture -->\n)(.*?)(<!-- end -->)", flags=re.DOTALL)


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


def machine() -> str:
    """The processor, and how many of it."""
    return f"{os.cpu_count()} cores of {processor()}"


def main() -> int:
    """Runs the rows that are asked for; see the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", default=[], choices=list(rows()), metavar="ROW", help=", ".join(rows()))
    parser.add_argument("--share", type=float, default=1.0, help="of every row, 1 = all of it")
    parser.add_argument("--write", action="store_true", help="write the table of docs/reliability.md")
    asked = parser.parse_args()
    # A shell's job in the background ignores it, and so would all that is started here, which is ended by it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    bad, cells = 0, {}
    for name, row in rows().items():
        if asked.only and name not in asked.only:
            continue
        began = time.monotonic()
        with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
            try:
                found = row.run(asked.share, Path(folder))
            except Exception as error:  # the other rows are worth having
                traceback.print_exc()
                found = Found(1, 0, 0, 1, f"not measured: {type(error).__name__}")
        took = time.monotonic() - began
        bad += found.survived < found.tried or found.lost > 0 or found.silent > 0
        told = f"{datetime.date.today()}, {machine()}"
        counts = (str(one) for one in found[:4])
        cells[name] = (f"`{name}`", row.what, *counts, found.figures, f"{asked.share:g}", told)
        print(f"{name}: {found.tried} tried, {found.survived} survived, {found.lost} lost, {found.silent} silent; "
              f"{found.figures} ({took:.0f} s)", flush=True)  # fmt: skip
        if asked.write:
            PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), cells), encoding="utf-8")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
