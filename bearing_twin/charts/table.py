"""The table beside a picture: its points as comma-separated values."""

import csv
from collections.abc import Iterable, Sequence
from dataclasses import astuple, fields
from pathlib import Path


def write_points(points: Sequence, path: Path) -> None:
    """Writes points, all of one dataclass, a row each below the names of its fields; raises OSError as `write_rows`."""
    write_rows(path, [field.name for field in fields(points[0])], map(astuple, points))


def write_rows(path: Path, header: Iterable[str], rows: Iterable[Iterable]) -> None:
    """Writes a header and rows; raises OSError where that is impossible."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(header)
        table.writerows(rows)
