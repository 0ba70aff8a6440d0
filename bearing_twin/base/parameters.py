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
SOME, LONGEST_TEXT = 3, 1000  # examples of a free text; letters of one that a file may hold


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
    Without an upper bound the greatest size of its unit holds (see `units.Unit`), and the least if none is below 0.
    `less` says why nothing below `at_least` is taken.
    """
    limits, row = Limits(above, below, at_least, at_most, less=less), UNITS.get(unit)
    if row is not None and below is None and at_most is None:
        limits = limits._replace(greatest=row.greatest)
    if row is not None and 0.0 in (above, at_least):
        limits = limits._replace(least=row.least)
    metadata = {"unit": unit, "help": help, "limits": limits}
    return dataclasses.field(default=default, metadata=metadata)


def choice(default, options, help, refused=None, widest=False, aliases=None):
    """One word out of `options`, words or a function of nothing that gives them, called when they are first wanted.

    `refused` maps words one may well ask for to why they are not among them. A scene that keeps the default asks for
    no options, so that a table which is slow to import can be their source. With `widest` a list of words is taken,
    too, as the one that stands first in `options`: each of these holds all that stand behind it. `aliases` maps
    words of earlier versions to those they are read as.
    """
    metadata = {"options": _late(options), "help": help, "refused": refused or {}, "widest": widest}
    metadata["aliases"] = aliases or {}
    return dataclasses.field(default=default, metadata=metadata)


def _late(options):
    return functools.cache(lambda: tuple(options() if callable(options) else options))


def text(default, help, options=(), stands_for_section=False):
    """Text of one line, or a whole number taken as text; `options` (words, or a function) are those one may expect.

    One that `stands_for_section` takes, as an override, the place of all keys that its section was given before.
    """
    metadata = {"options": _late(options), "help": help, "open": True, "stands_for_section": stands_for_section}
    return dataclasses.field(default=default, metadata=metadata)


def section(cls, default_name=None, names=None, default=None):
    """A nested dataclass; with `names` (a table name -> instance) it may also be given as one of those names.

    `default` is an instance that holds the defaults of the place where the section stands.
    """
    metadata = {"section": cls, "names": names or {}, "default_name": default_name}
    named = cls if default_name is None else lambda: names[default_name]
    return dataclasses.field(default_factory=named if default is None else lambda: default, metadata=metadata)


def read_strict(cls, mapping, where):
    """Build `cls` from a mapping, defaults filled in; raises SceneError listing every problem with what is legal."""
    instance, problems = read(cls, mapping)
    raise_problems(where, problems)
    return instance


def read(cls, mapping, explain=lambda path: None) -> tuple[Any, list[str]]:
    """An instance as by `read_strict`, and its problems: where there are problems the defaults stand in.

    `explain(path)` may give a better sentence for a key that is not there than that it is not there.
    """
    problems = _Problems(explain)
    return _read_section(cls, mapping, "", problems, cls()), list(problems)


class _Problems(list):
    """The sentences so far, and what explains unknown keys."""

    def __init__(self, explain):
        super().__init__()
        self.explain = explain


def raise_problems(where: str, problems: list[str]) -> None:
    """Raise one SceneError naming all `problems` of `where`, or return when there are none."""
    if len(problems) == 1:
        raise SceneError(f"{where}: {problems[0]}")
    if problems:
        raise SceneError(f"{where} has {len(problems)} problems:\n" + "\n".join(f"  {problem}" for problem in problems))


def describe(cls) -> list[Parameter]:
    """All keys of a parameter dataclass, sections before their keys, in declared order."""
    return list(_describe(cls, cls(), ""))


def plain(instance) -> dict:
    """A parameter dataclass as nested dicts, lists, numbers and text, as YAML and JSON hold them."""
    result = {}
    for item in dataclasses.fields(instance):
        value = getattr(instance, item.name)
        if dataclasses.is_dataclass(value):
            value = plain(value)
        elif isinstance(value, tuple):
            value = [list(row) if isinstance(row, tuple) else _plain_row(row) for row in value]
        result[item.name] = value
    return result


def _plain_row(row):
    return plain(row) if dataclasses.is_dataclass(row) else row


def names_at(cls, words: Iterable[str]) -> Mapping[str, Any]:
    """The table of names the section at that key path may be given by; empty when it has none."""
    return _metadata_at(cls, words).get("names", {})


def element_at(cls, words: Iterable[str]) -> tuple[type | None, int]:
    """The class of the elements of the list at that key path, and how many it may hold; None where there is no list."""
    metadata = _metadata_at(cls, words)
    return metadata.get("element"), metadata.get("most", 0)


def stands_for_section(cls, words: Iterable[str]) -> bool:
    """True where the text at that key path stands for its whole section."""
    return _metadata_at(cls, words).get("stands_for_section", False)


def _metadata_at(cls, words):
    metadata = {}
    for word in words:
        fields = {item.name: item for item in dataclasses.fields(cls)} if cls else {}
        metadata = fields[word].metadata if word in fields else {}
        cls = metadata.get("section")
    return metadata


def read_number(given, unit="", limits=NO_LIMITS, *, integer=False) -> tuple[Any, str | None]:
    """(value in SI, None), or (None, what is wrong).

    A text counts as a number, for YAML 1.1 reads 1e-6 as one, and so does a number with its `unit`, as 3000rpm.
    """
    kind = "a whole number" if integer else "a number"
    legal = f"must be {kind}{with_unit(unit) and ' in' + with_unit(unit)}"
    if limits.text():
        legal += f", {limits.text()}"
    if isinstance(given, str) and len(given) <= LONGEST_NUMBER and NUMBER.fullmatch(given.strip()):
        given = float(given) if not given.strip().lstrip("+-").isdigit() else int(given)
    if isinstance(given, str) and (value := si_value(given, unit)) is not None:
        given = value
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        units = accepted_units(unit) if isinstance(given, str) else ()
        meant = units_in_other_case(given, unit) if units else []
        legal += f"; write {' or '.join(meant)}, as upper and lower case differ" if meant else ""
        return None, f"{legal}; units that are read: {', '.join(units)}" if units[1:] else legal
    try:
        value = float(given)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        return None, f"is not finite; {legal}"
    if integer and value != int(value):
        return None, legal
    if not limits.allow(value):
        fault = f"too small, below {limits.least:g}" if 0.0 < abs(value) < limits.least else "out of range"
        fault = limits.less if limits.less and 0.0 < value < limits.at_least else fault
        return None, f"is {fault}; {legal}{WHY_SIZES if limits.of_physics.allow(value) else ''}"
    return (int(value) if integer else value), None


def _read_section(cls, mapping, path, problems, defaults):
    fields = {item.name: item for item in dataclasses.fields(cls)}
    if not isinstance(mapping, Mapping):
        problems.append(
            f"{path or 'the scene'} must hold keys and values, not {echo(mapping)}; {legal_hint('', fields)}"
        )
        return defaults
    values = {}
    for key, given in mapping.items():
        full = f"{path}.{key}" if path else str(key)
        if key not in fields:
            why = problems.explain(full[:LONGEST_ECHO])
            problems.append(why or f"{full[:LONGEST_ECHO]} is not a key; {legal_hint(key, fields)}")
            continue
        values[key] = _read_field(fields[key], given, full, problems, getattr(defaults, key))
    return dataclasses.replace(defaults, **values)


def _read_field(item, given, path, problems, default):
    """The value of one field, or its default after adding to `problems`."""
    metadata = item.metadata
    given = given.tolist() if hasattr(given, "tolist") else given  # numbers of NumPy, as a sweep in Python has them
    if given is None:
        problems.append(f"{path} has no value; leave the key out for its default")
        return default
    if "section" in metadata:
        return _read_named(metadata, given, path, problems, default)
    if "open" in metadata:
        return _read_text(given, path, problems, default)
    if "options" in metadata:
        if metadata["widest"] and isinstance(given, (list, tuple)) and given:
            words = [_read_word(item, word, f"{path}[{index}]", problems) for index, word in enumerate(given)]
            return min(words, key=metadata["options"]().index)
        return _read_word(item, given, path, problems)
    if "columns" in metadata:
        rows, problem = metadata["read"](given, metadata["columns"])
        if problem:
            problems.append(f"{path}{problem}")
        return rows
    if isinstance(item.default, tuple):
        return _read_tuple(item, given, path, problems)
    value, problem = read_number(given, metadata["unit"], metadata["limits"], integer=isinstance(item.default, int))
    if problem:
        problems.append(f"{path} = {echo(given)} {problem}")
        return default
    return value


def _read_word(item, given, path, problems):
    options = item.metadata["options"]
    word = ("off", "on")[given] if isinstance(given, bool) and item.default in ("off", "on") else given
    if isinstance(word, str):
        word = item.metadata["aliases"].get(word, word)
        if word == item.default or word in options():
            return word
    reason = item.metadata["refused"].get(given) if isinstance(given, str) else None
    problems.append(f"{path} = {echo(given)} {reason or f'is not known; {legal_hint(given, options())}'}")
    return item.default


def _read_text(given, path, problems, default):
    if isinstance(given, int) and not isinstance(given, bool):
        given = str(given)
    if isinstance(given, str) and given.isprintable() and len(given) <= LONGEST_TEXT:
        return given
    problems.append(f"{path} = {echo(given)} must be text of at most {LONGEST_TEXT} characters on one line")
    return default


def _read_named(metadata, given, path, problems, default):
    names = metadata["names"]
    if names and isinstance(given, str):
        if given in names:
            return names[given]
        problems.append(f"{path} = {echo(given)} is not known; {legal_hint(given, names)}, or its values as keys")
        return default
    return _read_section(metadata["section"], given, path, problems, default)


def _read_tuple(item, given, path, problems):
    length, original = len(item.default), given
    given = given.strip("[] ").split(",") if isinstance(given, str) else given  # 0,-2kN,0
    if not isinstance(given, (list, tuple)) or len(given) != length:
        unit = with_unit(item.metadata["unit"])
        problems.append(f"{path} = {echo(original)} must be a list of {length} numbers{unit and ' in' + unit}")
        return item.default
    values, units = [], item.metadata["unit"].split(", ")
    for index, one in enumerate(given):
        value, problem = read_number(one, units[index % len(units)], item.metadata["limits"])
        if problem:
            problems.append(f"{path}[{index}] = {echo(one)} {problem}")
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
                kind, legal = "free text", f"such as {', '.join(options[:SOME])}" if options else ""
            yield Parameter(key, kind, value, "", metadata["help"], legal, NO_LIMITS, options)
        else:
            limits, unit = metadata["limits"], metadata["unit"]
            kind = "integer" if isinstance(value, int) else "number"
            kind = f"{len(value)} numbers" if isinstance(value, tuple) else kind
            yield Parameter(key, kind, value, unit, metadata["help"], limits.text(), limits, ())


GREATEST_FILE = 16_000_000  # bytes
MOST_ROWS = 50_000  # under a second to read


def number_table(columns, help, over_time=True):
    """Rows of numbers, one each of `columns` (name, unit); () where none. `over_time`: the first are s, increasing.

    Given as a list of rows, or as the name of a CSV file of rows, whose first may hold names with units in brackets: it
    is read at once, from the working directory, and its rows stand in the scene from then on.
    """
    read = functools.partial(read_table, over_time=over_time)
    return dataclasses.field(default=(), metadata={"columns": tuple(columns), "help": help, "read": read})


def read_table(given, columns, over_time=True) -> tuple[tuple, str]:
    """(rows, "") of a `number_table`, or ((), the tail of a sentence about the first row that is wrong)."""
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
    """The fault in the first row of a file, which names its columns: another unit or order; or nothing."""
    names = [name for name, _ in columns]
    for number, (cell, (name, unit)) in enumerate(zip(header, columns, strict=False), start=1):
        word, _, given = cell.replace("(", "[").replace(")", "]").partition("[")
        given = re.sub(r"[\s.*·]", "", given.rstrip("] "))
        if given and given != unit.replace(" ", ""):
            return f"column {number} is named {echo(cell)}, and is {name} in {unit}"
        if (word := word.strip().lower()) != name and word in names:
            return f"column {number} is named {echo(cell)}, and is {name}: the order is {', '.join(names)}"
    return ""


def _rows_of(name: str) -> tuple[list, str]:
    """(rows of text of a CSV file, "") or ([], what is wrong); nothing is read on behalf of peers."""
    if READABLE.get() is not None:
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
