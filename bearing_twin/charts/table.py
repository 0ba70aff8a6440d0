"""The table beside a picture: its points as comma-separated values."""

import csv
from collections.abc import Iterable
from pathlib import Path


def write_rows(path: Path, header: Iterable[str], rows: Iterable[Iterable]) -> None:
    """Writes a header and rows; raises OSError where that is impossible."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(header)
        table.writerows(rows)
