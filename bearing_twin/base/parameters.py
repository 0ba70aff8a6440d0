"""Parameters as data: dataclass fields that carry unit, help and limits, and a reader that reports every mistake.

A scene file is read into frozen dataclasses whose fields are made by `quantity`, `choice`, `section`, `text` and
`number_table`; the same declarations give the defaults, the checks, the list of keys and the node parameters.
"""

import csv
import dataclasses
import functools
import math
import os
import re
import stat
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from bearing_twin.base.errors import LONGEST_ECHO, SceneError, echo, legal_hint
from bearing_twin.base.paths import READABLE
from bearing_twin.base.units import NO_LIMITS, UNITS, Limits, accepted_units, si_value, units_in_other_case, with_unit

NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")
LONGEST_NUMBER = 64
WHY_SIZES = ", for sizes beyond belong to no bearing, ball or beam, and their products leave double precision"
EXAMPLES, LONGEST_TEXT = 3, 1000  # examples of a free text in lists of keys; characters of one at most


class Parameter(NamedTuple):
    """A key: `type` is number, integer, "3 numbers", table, text, words, free text or the class of a section."""

    key: str
    type: str
    default: Any
    unit: str
    help: str
    limits: str
    bounds: Limits
    options: tuple[str, ...]


def quantity(default, unit, help, *, above=None, below=None, at_least=None, at_most=None, less=""):
    """A number (int or float, as the default is) or a tuple of floats of the default's length, in `unit`.

    The numbers of a tuple may have units of their own, as "1, m, rad".
    Without an upper bound that of its unit holds (see `units.Unit`), and if it is positive the least size, too.
    `less` is the reason why values below `at_least` are refused.
    """
    limits, row = Limits(above, below, at_least, at_most, less=less), UNITS.get(unit)
    if row is not None and below is None and at_most is None:
        limits = limits._replace(greatest=row.greatest)
    if row is not None and 0.0 in (above, at_least):
        limits = limits._replace(least=row.least)
    metadata = {"unit": unit, "help": help, "limits": limits}
    return dataclasses.field(default=default, metadata=metadata)


def choice(default, options, help, refused=None, widest=False, aliases=None):
    """One of `options`: names, or a function without arguments that returns them, called at their first use.

    `refused` maps names that a user may try to the reasons why they are not legal. A scene that keeps the default
    never reads the options, so that they can come from a table that is slow to import. With `widest` a list of names
    is legal, too, and read as the first of them in `options`, which includes all options behind it. `aliases` maps
    names of earlier versions to those of today.
    """
    metadata = {"options": _lazy_options(options), "help": help, "refused": refused or {}, "widest": widest}
    metadata["aliases"] = aliases or {}
    return dataclasses.field(default=default, metadata=metadata)


def _lazy_options(options):
    return functools.cache(lambda: tuple(options() if callable(options) else options))


def text(default, help, options=(), stands_for_section=False):
    """Text of one line, or an integer read as text; `options` (names, or a function) are examples.

    As an override, one that `stands_for_section` replaces all earlier keys of its section.
    """
    metadata = {"options": _lazy_options(options), "help": help, "open": True, "stands_for_section": stands_for_section}
    return dataclasses.field(default=default, metadata=metadata)


def section(cls, default_name=None, names=None, default=None):
    """A nested dataclass; with `names` (a table name -> instance) one of those names is legal, too.

    `default` is an instance with the defaults of this section.
    """
    metadata = {"section": cls, "names": names or {}, "default_name": default_name}
    named = cls if default_name is None else lambda: names[default_name]
    return dataclasses.field(default_factory=named if default is None else lambda: default, metadata=metadata)


def read_strict(cls, mapping, origin):
    """Build `cls` from a mapping, defaults filled in; raises SceneError listing every problem with what is legal."""
    instance, problems = read(cls, mapping)
    raise_problems(origin, problems)
    return instance


def read(cls, mapping, explain=lambda path: None) -> tuple[Any, list[str]]:
    """An instance as by `read_strict`, with defaults where there are problems, and the problems.

    `explain(path)` may return a sentence on a key that does not exist.
    """
    problems = _Problems(explain)
    return _read_section(cls, mapping, "", problems, cls()), list(problems)


class _Problems(list):
    """The sentences so far, and the function that explains unknown keys."""

    def __init__(self, explain):
        super().__init__()
        self.explain = explain


def raise_problems(origin: str, problems: list[str]) -> None:
    """Raise one SceneError naming all `problems` of `origin`, or return when there are none."""
    if len(problems) == 1:
        raise SceneError(f"{origin}: {problems[0]}")
    if problems:
        raise SceneError(
            f"{origin} has {len(problems)} problems:\n" + "\n".join(f"  {problem}" for problem in problems)
        )


def describe(cls) -> list[Parameter]:
    """All keys of a parameter dataclass, sections before their keys, in declared order."""
    return list(_describe(cls, cls(), ""))


def plain(value):
    """A parameter dataclass, or a value of one, as nested dicts, lists, numbers and text, for YAML and JSON."""
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return value


def names_at(cls, path: Iterable[str]) -> Mapping[str, Any]:
    """The named instances of the section at a key path; empty when it has none."""
    return _metadata_at(cls, path).get("names", {})


def element_at(cls, path: Iterable[str]) -> tuple[type | None, int]:
    """The class of the elements of the list at a key path, and their greatest number; None where there is no list."""
    metadata = _metadata_at(cls, path)
    return metadata.get("element"), metadata.get("most", 0)


def stands_for_section(cls, path: Iterable[str]) -> bool:
    """True where the text at a key path replaces its section."""
    return _metadata_at(cls, path).get("stands_for_section", False)


def _metadata_at(cls, path):
    metadata = {}
    for name in path:
        fields = {field.name: field for field in dataclasses.fields(cls)} if cls else {}
        metadata = fields[name].metadata if name in fields else {}
        cls = metadata.get("section")
    return metadata


def read_number(entry, unit="", limits=NO_LIMITS, *, integer=False) -> tuple[Any, str | None]:
    """(value in SI, None), or (None, the fault).

    A text may hold a number, as YAML 1.1 reads 1e-6 as text, or a number with its `unit`, such as 3000rpm.
    """
    kind = "a whole number" if integer else "a number"
    legal = f"must be {kind}{with_unit(unit) and ' in' + with_unit(unit)}"
    if limits.text():
        legal += f", {limits.text()}"
    if isinstance(entry, str) and len(entry) <= LONGEST_NUMBER and NUMBER.fullmatch(entry.strip()):
        entry = float(entry) if not entry.strip().lstrip("+-").isdigit() else int(entry)
    if isinstance(entry, str) and (value := si_value(entry, unit)) is not None:
        entry = value
    if isinstance(entry, bool) or not isinstance(entry, (int, float)):
        units = accepted_units(unit) if isinstance(entry, str) else ()
        similar = units_in_other_case(entry, unit) if units else []
        legal += f"; write {' or '.join(similar)}, as upper and lower case differ" if similar else ""
        return None, f"{legal}; units that are read: {', '.join(units)}" if units[1:] else legal
    try:
        value = float(entry)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        return None, f"is not finite; {legal}"
    if integer and value != int(value):
        return None, legal
    if not limits.allow(value):
        fault = f"too small, below {limits.least:g}" if 0.0 < abs(value) < limits.least else "out of range"
        fault = limits.less if limits.less and 0.0 < value < limits.at_least else fault
        return None, f"is {fault}; {legal}{WHY_SIZES if limits.without_sizes.allow(value) else ''}"
    return (int(value) if integer else value), None


def _read_section(cls, mapping, path, problems, defaults):
    fields = {field.name: field for field in dataclasses.fields(cls)}
    if not isinstance(mapping, Mapping):
        problems.append(
            f"{path or 'the scene'} must hold keys and values, not {echo(mapping)}; {legal_hint('', fields)}"
        )
        return defaults
    values = {}
    for key, entry in mapping.items():
        full_key = f"{path}.{key}" if path else str(key)
        if key not in fields:
            explanation = problems.explain(full_key[:LONGEST_ECHO])
            problems.append(explanation or f"{full_key[:LONGEST_ECHO]} is not a key; {legal_hint(key, fields)}")
            continue
        values[key] = _read_field(fields[key], entry, full_key, problems, getattr(defaults, key))
    return dataclasses.replace(defaults, **values)


def _read_field(item, entry, path, problems, default):
    """The value of one field, or its default after adding to `problems`."""
    metadata = item.metadata
    entry = entry.tolist() if hasattr(entry, "tolist") else entry  # numbers of NumPy, as a sweep in Python has them
    if entry is None:
        problems.append(f"{path} has no value; leave the key out for its default")
        return default
    if "section" in metadata:
        return _read_named_section(metadata, entry, path, problems, default)
    if "open" in metadata:
        return _read_text(entry, path, problems, default)
    if "options" in metadata:
        if metadata["widest"] and isinstance(entry, (list, tuple)) and entry:
            names = [_read_option(item, name, f"{path}[{index}]", problems) for index, name in enumerate(entry)]
            return min(names, key=metadata["options"]().index)
        return _read_option(item, entry, path, problems)
    if "columns" in metadata:
        rows, problem = metadata["read"](entry, metadata["columns"])
        if problem:
            problems.append(f"{path}{problem}")
        return rows
    if isinstance(item.default, tuple):
        return _read_tuple(item, entry, path, problems)
    value, problem = read_number(entry, metadata["unit"], metadata["limits"], integer=isinstance(item.default, int))
    if problem:
        problems.append(f"{path} = {echo(entry)} {problem}")
        return default
    return value


def _read_option(item, entry, path, problems):
    options = item.metadata["options"]
    name = ("off", "on")[entry] if isinstance(entry, bool) and item.default in ("off", "on") else entry
    if isinstance(name, str):
        name = item.metadata["aliases"].get(name, name)
        if name == item.default or name in options():
            return name
    reason = item.metadata["refused"].get(entry) if isinstance(entry, str) else None
    problems.append(f"{path} = {echo(entry)} {reason or f'is not known; {legal_hint(entry, options())}'}")
    return item.default


def _read_text(entry, path, problems, default):
    if isinstance(entry, int) and not isinstance(entry, bool):
        entry = str(entry)
    if isinstance(entry, str) and entry.isprintable() and len(entry) <= LONGEST_TEXT:
        return entry
    problems.append(f"{path} = {echo(entry)} must be text of at most {LONGEST_TEXT} characters on one line")
    return default


def _read_named_section(metadata, entry, path, problems, default):
    names = metadata["names"]
    if names and isinstance(entry, str):
        if entry in names:
            return names[entry]
        problems.append(f"{path} = {echo(entry)} is not known; {legal_hint(entry, names)}, or its values as keys")
        return default
    return _read_section(metadata["section"], entry, path, problems, default)


def _read_tuple(item, entries, path, problems):
    length, original = len(item.default), entries
    entries = entries.strip("[] ").split(",") if isinstance(entries, str) else entries  # 0,-2kN,0
    if not isinstance(entries, (list, tuple)) or len(entries) != length:
        unit = with_unit(item.metadata["unit"])
        problems.append(f"{path} = {echo(original)} must be a list of {length} numbers{unit and ' in' + unit}")
        return item.default
    values, units = [], item.metadata["unit"].split(", ")
    for index, entry in enumerate(entries):
        value, problem = read_number(entry, units[index % len(units)], item.metadata["limits"])
        if problem:
            problems.append(f"{path}[{index}] = {echo(entry)} {problem}")
        values.append(value)
    return item.default if None in values else tuple(values)


def _describe(cls, instance, path):
    for item in dataclasses.fields(cls):
        key = f"{path}.{item.name}" if path else item.name
        metadata = item.metadata
        value = getattr(instance, item.name)
        if "section" in metadata:
            names = tuple(metadata["names"])
            if names:
                help = "one of the named ones, or its values as keys"
                kind = metadata["section"].__name__.lower()
                yield Parameter(key, kind, metadata["default_name"], "", help, ", ".join(names), NO_LIMITS, names)
            yield from _describe(metadata["section"], value, key)
        elif "columns" in metadata:
            limits = "rows of " + ", ".join(f"{name} [{unit}]" for name, unit in metadata["columns"])
            yield Parameter(key, metadata.get("kind", "table"), value, "", metadata["help"], limits, NO_LIMITS, ())
        elif "options" in metadata:
            options = metadata["options"]()
            kind, legal = "words" if metadata.get("widest") else "text", ", ".join(options)
            if "open" in metadata:
                kind, legal = "free text", f"such as {', '.join(options[:EXAMPLES])}" if options else ""
            yield Parameter(key, kind, value, "", metadata["help"], legal, NO_LIMITS, options)
        else:
            limits, unit = metadata["limits"], metadata["unit"]
            kind = "integer" if isinstance(value, int) else "number"
            kind = f"{len(value)} numbers" if isinstance(value, tuple) else kind
            yield Parameter(key, kind, value, unit, metadata["help"], limits.text(), limits, ())


GREATEST_FILE = 16_000_000  # bytes
MOST_ROWS = 50_000  # under a second to read


def number_table(columns, help, over_time=True):
    """Rows of numbers of `columns` (name, unit), by default (). `over_time`: the first column is an increasing time.

    It is given as a list of rows, or as the name of a CSV file of rows, with or without a header of names and units in
    brackets. The file is read at once, from the working directory, and the scene then holds its rows.
    """
    read = functools.partial(read_table, over_time=over_time)
    return dataclasses.field(default=(), metadata={"columns": tuple(columns), "help": help, "read": read})


def read_table(entry, columns, over_time=True) -> tuple[tuple, str]:
    """(rows, "") of a `number_table`, or ((), the end of a sentence about the first faulty row)."""
    column_names = ", ".join(f"{name} [{unit}]" for name, unit in columns)
    legal = f"must be rows of {column_names}, or the name of a CSV file of them"
    if isinstance(entry, str):
        path, (entry, problem) = entry, _read_csv(entry)
        if not problem and entry and len(entry[-1]) == 1 < len(columns):
            problem = "numbers are parted by commas, and have a point before their decimals"
        elif not problem and entry and all(read_number(cell)[1] for cell in entry[0]):
            problem = _header_fault(entry.pop(0), columns)
        if not problem and not entry:
            problem = "it holds no row"
        if problem:
            return (), f" = {echo(path)} {legal}: {problem}"
    if not isinstance(entry, (list, tuple)):
        return (), f" = {echo(entry)} {legal}"
    if len(entry) > MOST_ROWS:
        return (), f" has {len(entry)} rows, more than {MOST_ROWS}; leave some out, for it is straight between them"
    rows = []
    for number, row in enumerate(entry):
        if not isinstance(row, (list, tuple)) or len(row) != len(columns):
            return (), f"[{number}] = {echo(row)} {legal}: {len(columns)} numbers a row, none left out"
        values = []
        for cell, (name, unit) in zip(row, columns, strict=True):
            value, problem = read_number(cell, unit)
            if problem:
                return (), f"[{number}]: {name} = {cell!r} {problem}"
            values.append(float(value))
        if over_time and rows and values[0] <= rows[-1][0]:
            return (), f"[{number}]: time must grow from row to row; {values[0]:g} s follows {rows[-1][0]:g} s"
        rows.append(tuple(values))
    return tuple(rows), ""


def _header_fault(header, columns) -> str:
    """The fault in the header of a file, another unit or order of columns; empty without one."""
    names = [name for name, _ in columns]
    for number, (cell, (name, unit)) in enumerate(zip(header, columns, strict=False), start=1):
        written_name, _, written_unit = cell.replace("(", "[").replace(")", "]").partition("[")
        written_unit = re.sub(r"[\s.*·]", "", written_unit.rstrip("] "))
        if written_unit and written_unit != unit.replace(" ", ""):
            return f"column {number} is named {echo(cell)}, and is {name} in {unit}"
        if (written_name := written_name.strip().lower()) != name and written_name in names:
            return f"column {number} is named {echo(cell)}, and is {name}: the order is {', '.join(names)}"
    return ""


def _read_csv(path: str) -> tuple[list, str]:
    """(rows of text of a CSV file, "") or ([], the fault); nothing is read on behalf of peers."""
    if READABLE.get() is not None:
        return [], "files are not read for this; give the rows"
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode) or status.st_size > GREATEST_FILE:
            return [], f"it is no file of at most {GREATEST_FILE} bytes"
        with open(path, newline="", encoding="utf-8-sig") as file:  # spreadsheets begin such a file with a mark
            return [row for row in csv.reader(file) if row], ""
    except UnicodeDecodeError:
        return [], "it is not UTF-8 text; save it as CSV in UTF-8"
    except (OSError, ValueError, csv.Error) as error:
        folder = "" if os.path.isabs(path) else f", looked for in {os.getcwd()}"
        return [], f"{getattr(error, 'strerror', None) or error}{folder}"
