"""Figures of a report for people, on pages and in the terminal: words, numbers in the units they read, errors."""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from bearing_twin.base.units import (
    digits_of,
    greatest_error,
    label_and_unit,
    label_in_result,
    readable_label,
    readable_sentence,
    rounded_to_error,
    two_digits,
    unit_choice_sizes,
    unit_suffix,
)
from bearing_twin.run.report import displayed_errors, output_error_text, unit_sizes

AXES = 3  # lists of so many numbers at most are vectors
DIGITS = 5
NOISE = 1e-10  # of what is large in a unit: less is 0
RESIDUALS = ("energy_closure", "greatest_energy_gain", "force_balance", "quaternion_drift")  # figures that are errors
MOST_ROWS = 200
Readable = Callable[[str, float], tuple[str, str, float]]  # words, unit and factor of a key with values up to a size


class Figure(NamedTuple):
    """A figure for people: its key, words and unit, its values as texts, and its error as a text, "" for none.

    `doubtful` is True for a number whose error is large; `length` of a list of more numbers than a vector has, else 0.
    """

    key: str
    words: str
    unit: str
    texts: list[str]
    error: str
    doubtful: bool
    length: int


def figures_for_people(
    figures: Mapping[str, Any], result: Mapping[str, Any], unit_of: Readable = readable_label
) -> list[Figure]:
    """The figures but lists of events and nested mappings; `result` holds their errors, as the result of `--json`."""
    found = []
    figures = {key: one for key, one in figures.items() if not isinstance(one, Mapping) and not is_events(one)}
    units = {unit: NOISE * size for unit, size in unit_sizes(figures).items() if unit}
    rounding = {key: units.get(label_and_unit(key)[1], 0.0) for key in figures}
    figures = {key: _without_rounding(one, rounding[key]) for key, one in figures.items()}
    errors = {
        key: _without_rounding(displayed_errors(result, key, _size(one)), rounding[key]) for key, one in figures.items()
    }
    sizes = {key: max(_size(value), errors[key][1] or 0.0) for key, value in figures.items()}
    long = {key: unit_suffix(key) for key, value in figures.items() if _is_long(value)}
    for key, suffix in long.items():  # those of one unit in one
        sizes[key] = max(_size(figures[other]) for other, one in long.items() if one == suffix)
    for key, size in unit_choice_sizes(sizes).items():
        value, (most, own), digits = figures[key], errors[key], digits_of(key)
        several = value if isinstance(value, (list, tuple)) else [value]
        words, unit, factor = unit_of(key, size)
        words = label_in_result(words, result.get("errors_unknown", {}))
        unit = unit if any(map(_is_number, several)) else ""
        error = two_digits(factor * own) if own and _in_digits(own, _size(value), digits) else ""
        if 1 < len(several) <= AXES and all(map(_is_number, several)) and _size(several):  # a vector: parts of one size
            places = digits - 1 - math.floor(math.log10(factor * _size(several)))
            several = [round(factor * one, places) / factor for one in several]
            most = most and max(most, 10.0 ** (1 - places) / factor)
        texts = [_residual(one) if key in RESIDUALS else value_text(one, factor, most, digits) for one in several]
        doubtful = key in result.get("large_errors", ())
        found.append(Figure(key, words, unit, texts, error, doubtful, len(several) if _is_long(value) else 0))
    return found


def lists_by_length(figures: Iterable[Figure]) -> dict[int, list[Figure]]:
    """The long lists among figures, those of one length together."""
    found: dict[int, list[Figure]] = {}
    for one in figures:
        if one.length:
            found.setdefault(one.length, []).append(one)
    return found


def events_for_people(
    rows: list[Mapping[str, Any]], unit_of: Readable = readable_label
) -> tuple[list, list[list[str]]]:
    """Words and unit of each column of a list of mappings with the same keys, and the rows as texts."""
    columns = {key: [row.get(key) for row in rows] for key in rows[0]}
    shown = [unit_of(key, _size(values)) for key, values in columns.items()]
    texts = [[value_text(one, factor) for one in of] for of, (*_, factor) in zip(columns.values(), shown, strict=True)]
    return [(words, unit) for words, unit, _ in shown], [list(row) for row in zip(*texts, strict=True)]


def errors_in_words(result: Mapping[str, Any]) -> tuple[dict[str, str], list[str]]:
    """The errors of the requested outputs by their names, and sentences about errors that are not known."""
    wanted = result.get("wanted_errors", {}).items()
    known = {output: output_error_text(one) for output, one in wanted if one["error"] is not None}
    return known, [f"{name}: {text}" for name, text in result.get("errors_unknown", {}).items()]


def value_text(value, factor: float = 1.0, error=None, digits: int = DIGITS) -> str:
    """One value: a number times `factor` to the digits that its error, in its own unit, allows; a list of several."""
    if value is None or isinstance(value, bool):
        return {None: "-", True: "yes", False: "no"}[value]
    if isinstance(value, (list, tuple)):
        return ", ".join(map(value_text, value))
    if not isinstance(value, (int, float)) or (isinstance(value, int) and factor == 1.0):
        return str(value)
    return rounded_to_error(value * factor, None if error is None else factor * greatest_error(error), digits)


def _without_rounding(value, least: float):
    """A value or a list with 0 in the place of numbers up to `least`."""
    if isinstance(value, (list, tuple)):
        return [_without_rounding(one, least) for one in value]
    return 0.0 if isinstance(value, float) and abs(value) <= least else value


def _residual(value: float | None) -> str:
    """A relative error of a balance in two digits."""
    return value_text(value) if value is None else two_digits(value if abs(value) > NOISE else 0.0)


def is_events(value) -> bool:
    """True for a list of mappings, with the same keys."""
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(one, Mapping) for one in value)


def _is_long(value) -> bool:
    """True for a list of more numbers than a vector has."""
    return isinstance(value, (list, tuple)) and len(value) > AXES and not isinstance(value[0], (list, tuple, str))


def _size(value) -> float:
    """The greatest magnitude of a value or of the numbers in a list; 0 where there is none."""
    several = value if isinstance(value, (list, tuple)) else [value]
    return float(max((abs(one) for one in several if _is_number(one)), default=0.0))


def _is_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _in_digits(error: float, size: float, digits: int) -> bool:
    """True for an error of at least the last of so many digits of a value of this size."""
    return not size or error >= 10.0 ** (math.floor(math.log10(size)) + 1 - digits)


def tables_of_page(
    figures: Mapping[str, Any], errors: Mapping[str, Any], meanings: Mapping[str, str]
) -> dict[str, list[dict[str, Any]]]:
    """The tables of a page: `figures` (a row each), `tables` (long lists side by side, then events), `errors`."""
    shown = figures_for_people(figures, errors)
    rows = [
        {
            "words": one.words,
            "value": ("; " if not one.unit else ", ").join(one.texts) or "none",
            "unit": one.unit,
            "error": one.error,
            "meaning": meanings.get(one.key, ""),
        }
        for one in shown
        if not one.length
    ]
    tables: list[dict[str, Any]] = []
    for columns in lists_by_length(shown).values():
        header = [(one.words, one.unit, meanings.get(one.key, "")) for one in columns]
        cells = [list(row) for row in zip(*(one.texts for one in columns), strict=True)]
        greatest = [one.error for one in columns]
        tables.append({"header": header, "rows": cells, "errors": greatest if any(greatest) else []})
    for key, events in figures.items():
        if is_events(events):
            header, cells = events_for_people(events[:MOST_ROWS])
            more = f"; the first {MOST_ROWS} of {len(events)}" if len(events) > MOST_ROWS else ""
            named = {"title": meanings.get(key, "") + more, "noun": key.replace("_", " ")}
            tables.append(named | {"header": [(*one, "") for one in header], "rows": cells, "errors": []})
    return {"figures": rows, "tables": tables, "errors": error_notes(errors)}


def error_notes(errors: Mapping[str, Any]) -> list[str]:
    """Errors of the outputs requested to a tolerance, and those that are not known."""
    known, unknown = errors_in_words(errors)
    notes = [f"{output}: error {text}" for output, text in known.items()] + [
        f"Not in these errors: {one}" for one in unknown
    ]
    return [readable_sentence(one) for one in notes]
