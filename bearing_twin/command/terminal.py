"""Results as tables on standard output, in units that people read; progress on standard error."""

import contextlib
import io
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextvars import ContextVar
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from bearing_twin.base.errors import escape_controls
from bearing_twin.base.units import (
    readable_sentence,
    readable_unit,
)

GAP = "  "
HEADER = 9  # columns of words above numbers
INDENT = "    "
NAMES = 30  # columns of names beside their values


def width_of_terminal() -> int:
    """Columns of the terminal, or of COLUMNS; 80 in a pipe."""
    return max(shutil.get_terminal_size((80, 24)).columns, 40)


def split_columns(header: Sequence[str], columns: Sequence[Sequence[str]]) -> list[list[str]]:
    """Lines of tables of numbers below each other, each the first column and as many further ones as fit.

    Names in the header may hold line breaks.
    """
    width = width_of_terminal()
    sizes = [max(_longest_word([name, *column]), HEADER) for name, column in zip(header, columns, strict=True)]
    sizes[0] = _longest_word([header[0], *columns[0]])
    tables, start = [], 1
    while start < len(columns):
        end = start + 1
        while end < len(columns) and sizes[0] + sum(sizes[start : end + 1]) + len(GAP) * (end + 1 - start) <= width:
            end += 1
        shown = [0, *range(start, end)]
        rows = zip(*(columns[index] for index in shown), strict=True)
        names, widest = [header[index] for index in shown], [sizes[index] for index in shown]
        tables.append(_lines(names, rows, ["right"] * len(shown), widest))
        start = end
    return tables


def _lines(header, rows, sides: Sequence[str], widest: Sequence[int | None] = ()) -> list[str]:
    """Lines of a table of columns with these sides, at most as wide as `widest`."""
    from rich.console import Console
    from rich.table import Table

    rows = [[*map(str, row)] for row in rows]
    grid = Table(box=None, padding=(0, len(GAP), 0, 0), show_header=header is not None)
    names = header or [""] * len(sides)
    for index, (side, name, limit) in enumerate(zip_longest(sides, names, widest)):
        longest = _longest_word([name, *(row[index] for row in rows)])
        grid.add_column(name, justify=side, min_width=min(longest, limit or longest), max_width=limit)
    for row in rows:
        grid.add_row(*row)
    width = width_of_terminal() + len(GAP)  # behind the last column, too: without it rich cuts words there
    console = Console(file=io.StringIO(), width=width, highlight=False, markup=False, emoji=False, color_system=None)
    console.print(grid)
    return [line.rstrip() for line in console.file.getvalue().splitlines()]


def _paragraphs(header, rows) -> list[str]:
    """A paragraph a row: its names, below them the middle cells with their headers, then the last cell, a text."""
    lead = 1 if len({row[0] for row in rows}) == len(rows) or len(header) < 3 else 2
    lines = [f"{' '.join(header[:lead])}: {', '.join(header[lead:])}", ""]
    for row in rows:
        middle = "; ".join(f"{name} {cell}" for name, cell in zip(header[lead:-1], row[lead:-1], strict=True) if cell)
        lines.append("  ".join(row[:lead]))
        indents = {"initial_indent": INDENT, "subsequent_indent": INDENT}
        lines += [textwrap.fill(text, width_of_terminal(), **indents) for text in (middle, row[-1]) if text]
    return lines


def _longest_word(cells) -> int:
    return max((len(word) for cell in cells for word in cell.split()), default=0)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return cell in ("", "-")
    return True


if TYPE_CHECKING:  # a list of scenes needs no arrays
    from bearing_twin.base.sample import Block

SI: ContextVar[bool] = ContextVar("si", default=False)  # whether people read SI units too


def show_rows(header: Iterable[str], rows: Iterable[Iterable]) -> None:
    """Print a table, numbers to the right; where its words do not fit into the terminal, a paragraph for each row."""
    header, cells = list(header), [["" if cell is None else str(cell) for cell in row] for row in rows]
    columns = list(zip(header, *cells, strict=True))
    if sum(map(_longest_word, columns)) + len(GAP) * (len(columns) - 1) > width_of_terminal():
        lines = _paragraphs(header, cells)
    else:
        numbers = [bool(cells) and all(map(_is_number, column[1:])) for column in columns]
        lines = _lines(header, cells, ["right" if number else "left" for number in numbers])
    show_text("\n".join(lines))


def show_columns(header: Sequence[str], rows: Iterable[Sequence]) -> None:
    """Print a table of numbers whose first column are names; names in the header may hold line breaks."""
    show_text("\n".join(_lines(header, rows, ["left", *["right"] * (len(header) - 1)])))


def show_pairs(pairs: Iterable[tuple[str, str]]) -> None:
    """Print names and texts in two columns, without those whose text is empty."""
    shown = [(name, text) for name, text in pairs if text]
    show_text("\n".join(_lines(None, shown, ("left", "left"), (NAMES, None))))


def show_paragraph(text: str) -> None:
    """Print a sentence or more of a result on standard output, wrapped between words."""
    show_text("\n".join(textwrap.fill(line, width_of_terminal()) for line in in_shown_units(text).splitlines()))


def in_shown_units(sentence: str) -> str:
    """A sentence, as of a warning, in the units of the tables beside it."""
    return sentence if SI.get() else readable_sentence(sentence)


def shown_unit(unit: str, size: float) -> tuple[str, float]:
    """(unit, factor) in which values of up to `size` in a declared unit are shown: with --si as declared."""
    return (unit, 1.0) if SI.get() else readable_unit(unit, size)


def show_text(text: str = "") -> None:
    """Print a line of a result on standard output."""
    print(escape_controls(text))


def say(text: str) -> None:
    """Print a line about the work, not of its result, on standard error."""
    print(escape_controls(text), file=sys.stderr, flush=True)


@contextlib.contextmanager
def progress(description: str) -> Iterator[Callable[[float], None]]:
    """A function that takes the share of a work that is done, for a bar on standard error where that is a terminal."""
    if not sys.stderr.isatty():
        yield lambda share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    outer = _PROGRESS.get()
    text_column = TextColumn("{task.description}", markup=False)
    columns = text_column, BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    bars = outer or Progress(*columns, console=Console(stderr=True), transient=True)
    token, task = _PROGRESS.set(bars), bars.add_task(escape_controls(description), total=None)
    try:
        with contextlib.nullcontext() if outer else bars:
            yield lambda share: bars.update(task, completed=share, total=1.0)
    finally:
        bars.remove_task(task)
        _PROGRESS.reset(token)


_PROGRESS: ContextVar[Any] = ContextVar("bars", default=None)  # of the work that this one is a part of


def with_progress(blocks: Iterable["Block"], duration: float, what: str) -> Iterator["Block"]:
    """The blocks; `progress` shows their time as a share of `duration` [s]."""
    with progress(what) as update:
        for block in blocks:
            yield block
            update(block.time_ns[-1] * 1e-9 / duration)
