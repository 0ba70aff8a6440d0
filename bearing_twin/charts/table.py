"""The table beside a picture: its points as comma-separated values."""

import csv
from collections.abc import Iterable, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, get_type_hints


def write_points(points: Sequence, path: Path) -> None:
    """Writes points, all of one dataclass, a row each below the names of its fields; raises OSError as `write_rows`."""
    write_rows(path, [field.name for field in fields(points[0])], map(astuple, points))


def write_rows(path: Path, header: Iterable[str], rows: Iterable[Iterable]) -> None:
    """Writes a header and rows; raises OSError where that is impossible."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(header)
        table.writerows(rows)


def read_points(path: Path, kind: type) -> list:
    """The points of a chart from its table, whose columns are the fields of `kind` in order; further ones are left out.

    Raises OSError where there is no table, and TypeError or ValueError where it is another's.
    """
    hints = get_type_hints(kind)
    with path.open(encoding="utf-8", newline="") as stream:
        header, *rows = csv.reader(stream)
    if header[0] != next(iter(hints)):
        raise ValueError(f"its first column is {header[0]}, not {next(iter(hints))}")
    types = tuple(hints.values())
    return [kind(*map(_value, types, row)) for row in rows]


def _value(kind: type, word: str) -> Any:
    if kind is bool:
        return word == "True"
    return float(word or "nan") if kind is float else kind(word)
