"""Words and numbers as lines of at most a given width: text wraps between words, and a number is never cut."""

import shutil
import textwrap
from collections.abc import Iterable, Sequence
from itertools import zip_longest

GAP = "  "
LEAST_TEXT = 24  # columns that a column of sentences gets beside others
SHORT = 32  # columns of cells that may be broken at every word
HEADER = 11  # columns that words above numbers get without being broken
NAMES = 30  # columns of names beside their values


def width_of_terminal() -> int:
    """Columns of the terminal, or of COLUMNS; 80 in a pipe."""
    return max(shutil.get_terminal_size((80, 24)).columns, 40)


def wrapped(text: str, width: int) -> list[str]:
    """The lines of a text, broken between words, at least one; a word that is longer than `width` stays whole."""
    found = []
    for line in text.splitlines() or [""]:
        found += textwrap.wrap(line, max(width, 1), break_long_words=False, break_on_hyphens=False) or [""]
    return found


def named_values(pairs: Sequence[tuple[str, str]], width: int) -> list[str]:
    """Lines of names and values in two columns."""
    names = [wrapped(name, NAMES) for name, _ in pairs]
    first = max((len(line) for lines in names for line in lines), default=0)
    found = []
    for lines, (_, value) in zip(names, pairs, strict=True):
        found += _side_by_side((lines, wrapped(value, width - first - len(GAP))), (first, 0), (str.ljust, str.ljust))
    return found


def table(header: Sequence[str], rows: Iterable[Sequence], width: int) -> list[str]:
    """Lines of a table, numbers to the right; where it would be wider than `width`, a paragraph for each row."""
    cells = [[str(cell) for cell in row] for row in rows]
    columns = list(zip(*([list(header), *cells]), strict=True))
    numbers = [bool(cells) and all(map(_is_number, column[1:])) for column in columns]
    widths = [max(len(line) for cell in column for line in cell.split("\n")) for column in columns]
    words = [_longest_word(column) for column in columns]
    wide = [min(size, max(LEAST_TEXT, word)) for word, size in zip(words, widths, strict=True)]
    tight = [word if size <= SHORT else one for word, one, size in zip(words, wide, widths, strict=True)]
    wide = [word if number else one for word, one, number in zip(words, wide, numbers, strict=True)]
    room = width - len(GAP) * (len(columns) - 1)
    least = wide if sum(wide) <= room else tight
    if sum(least) > room:
        return _paragraphs(header, cells, width)
    for place in sorted(range(len(columns)), key=lambda place: -widths[place]):  # the widest gives way first
        widths[place] = max(least[place], min(widths[place], widths[place] - (sum(widths) - room)))
    sides = [str.rjust if number else str.ljust for number in numbers]
    found = []
    for row in [list(header), *cells]:
        lines = [wrapped(cell, size) for cell, size in zip(row, widths, strict=True)]
        found += _side_by_side(lines, widths, sides)
    return found


def columns_apart(header: Sequence[str], columns: Sequence[Sequence[str]], width: int) -> list[list[str]]:
    """Tables of numbers under each other, as many of `columns` side by side as fit; each begins with the first column.

    Names in the header may hold line breaks: what stands behind one begins a line.
    """
    sizes = [
        max(_longest_word([name]), min(HEADER, max(map(len, name.split("\n")))), *(len(cell) for cell in column))
        for name, column in zip(header, columns, strict=True)
    ]
    found, start = [], 1
    while start < len(columns):
        end, used = start, sizes[0]
        while end < len(columns) and (end == start or used + len(GAP) + sizes[end] <= width):
            used += len(GAP) + sizes[end]
            end += 1
        here = [0, *range(start, end)]
        widths, sides = [sizes[place] for place in here], [str.rjust] * len(here)
        names = [wrapped(header[place], sizes[place]) for place in here]
        tall = max(map(len, names))
        lines = _side_by_side([[""] * (tall - len(one)) + one for one in names], widths, sides)
        for row in zip(*(columns[place] for place in here), strict=True):
            lines += _side_by_side([[cell] for cell in row], widths, sides)
        found.append(lines)
        start = end
    return found


def _side_by_side(blocks: Sequence[list[str]], widths: Sequence[int], sides: Sequence) -> list[str]:
    """Blocks of lines beside each other, each as wide as told."""
    return [
        GAP.join(side(part, size) for part, size, side in zip(line, widths, sides, strict=True)).rstrip()
        for line in zip_longest(*blocks, fillvalue="")
    ]


def _paragraphs(header, rows, width) -> list[str]:
    """A paragraph a row: what names it, what stands between under its name, then the last cell, which is text."""
    lead = 1 if len({row[0] for row in rows}) == len(rows) or len(header) < 3 else 2
    found = [f"{' '.join(header[:lead])}: {', '.join(header[lead:])}", ""]
    for row in rows:
        between = zip(header[lead:-1], row[lead:-1], strict=True)
        told = "; ".join(f"{name} {cell}" for name, cell in between if cell)
        found.append("  ".join(row[:lead]))
        found += [f"    {line}" for text in (told, row[-1]) if text for line in wrapped(text, width - 4)]
    return found


def _longest_word(cells) -> int:
    return max((len(word) for cell in cells for word in cell.split()), default=0)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return cell in ("", "-")
    return True
