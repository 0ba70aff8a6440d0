"""Tables of numbers, most of them over time, from a scene or from a CSV file."""

import csv
import dataclasses
import functools
import os
import re
import stat

from bearing_twin.parameters import echo, read_number
from bearing_twin.permission import ROOM

GREATEST_FILE = 16_000_000  # bytes
MOST_ROWS = 50_000  # under a second to read


def table(columns, help, over_time=True):
    """Rows of numbers, one each of `columns` (name, unit); () where none. `over_time`: the first are s, increasing.

    Given as a list of rows, or as the name of a CSV file of rows, whose first may hold names with units in brackets: it
    is read at once, from the working directory, and its rows stand in the scene from then on.
    """
    read = functools.partial(read_table, over_time=over_time)
    return dataclasses.field(default=(), metadata={"columns": tuple(columns), "help": help, "read": read})


def read_table(given, columns, over_time=True) -> tuple[tuple, str]:
    """(rows, "") of a `table`, or ((), the tail of a sentence about the first row that is wrong)."""
    words = ", ".join(f"{name} [{unit}]" for name, unit in columns)
    legal = f"must be rows of {words}, or the name of a CSV file of them"
    if isinstance(given, str):
        name, (given, problem) = given, _rows_of(given)
        if not problem and given and len(given[-1]) == 1 < len(columns):
            problem = "numbers are parted by commas, and have a point before their decimals"
        elif not problem and given and all(read_number(cell)[1] for cell in given[0]):
            problem = _misnamed(given.pop(0), columns)
        if not problem and not given:
            problem = "it holds no row"
        if problem:
            return (), f" = {echo(name)} {legal}: {problem}"
    if not isinstance(given, (list, tuple)):
        return (), f" = {echo(given)} {legal}"
    if len(given) > MOST_ROWS:
        return (), f" has {len(given)} rows, more than {MOST_ROWS}; leave some out, for it is straight between them"
    rows = []
    for number, row in enumerate(given):
        if not isinstance(row, (list, tuple)) or len(row) != len(columns):
            return (), f"[{number}] = {echo(row)} {legal}: {len(columns)} numbers a row, none left out"
        found = [read_number(cell, unit) for cell, (_, unit) in zip(row, columns, strict=True)]
        wrong = [(name, cell, one[1]) for (name, _), cell, one in zip(columns, row, found, strict=True) if one[1]]
        if wrong:
            return (), "[{}]: {} = {!r} {}".format(number, *wrong[0])
        values = tuple(float(one[0]) for one in found)
        if over_time and rows and values[0] <= rows[-1][0]:
            return (), f"[{number}]: time must grow from row to row; {values[0]:g} s follows {rows[-1][0]:g} s"
        rows.append(values)
    return tuple(rows), ""


def _misnamed(header, columns) -> str:
    """What is wrong with the first row of a file, which names its columns: another unit or order; or nothing."""
    names = [name for name, _ in columns]
    for number, (cell, (name, unit)) in enumerate(zip(header, columns, strict=False), start=1):
        word, _, told = cell.replace("(", "[").replace(")", "]").partition("[")
        told = re.sub(r"[\s.*·]", "", told.rstrip("] "))
        if told and told != unit.replace(" ", ""):
            return f"column {number} is named {echo(cell)}, and is {name} in {unit}"
        if (word := word.strip().lower()) != name and word in names:
            return f"column {number} is named {echo(cell)}, and is {name}: the order is {', '.join(names)}"
    return ""


def _rows_of(name: str) -> tuple[list, str]:
    """(rows of text of a CSV file, "") or ([], what is wrong); nothing is read on behalf of somebody else."""
    if ROOM.get() is not None:
        return [], "files are not read for this; give the rows"
    try:
        found = os.stat(name)
        if not stat.S_ISREG(found.st_mode) or found.st_size > GREATEST_FILE:
            return [], f"it is no file of at most {GREATEST_FILE} bytes"
        with open(name, newline="", encoding="utf-8-sig") as file:  # spreadsheets begin such a file with a mark
            return [row for row in csv.reader(file) if row], ""
    except UnicodeDecodeError:
        return [], "it is not UTF-8 text; save it as CSV in UTF-8"
    except (OSError, ValueError, csv.Error) as error:
        where = "" if os.path.isabs(name) else f", looked for in {os.getcwd()}"
        return [], f"{getattr(error, 'strerror', None) or error}{where}"
