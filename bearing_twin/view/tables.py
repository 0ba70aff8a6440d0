"""Figures of a report as texts for pages and the terminal: labels, numbers in engineering units, errors."""

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
    """A figure as texts: its key, label and unit, its values, and its error, "" for none.

    `doubtful` is True for a number whose error is large; `length` of a list of more numbers than a vector has, else 0.
    """

    key: str
    words: str
    unit: str
    texts: list[str]
    error: str
    doubtful: bool
    length: int


def readable_figures(
    figures: Mapping[str, Any], result: Mapping[str, Any], unit_of: Readable = readable_label
) -> list[Figure]:
    """The figures but lists of events and nested mappings; `result` holds their errors, as the result of `--json`."""
    rows = []
    figures = {key: value for key, value in figures.items() if not isinstance(value, Mapping) and not is_events(value)}
    units = {unit: NOISE * size for unit, size in unit_sizes(figures).items() if unit}
    rounding = {key: units.get(label_and_unit(key)[1], 0.0) for key in figures}
    figures = {key: _without_rounding(value, rounding[key]) for key, value in figures.items()}
    errors = {
        key: _without_rounding(displayed_errors(result, key, _size(value)), rounding[key])
        for key, value in figures.items()
    }
    sizes = {key: max(_size(value), errors[key][1] or 0.0) for key, value in figures.items()}
    long = {key: unit_suffix(key) for key, value in figures.items() if _is_long(value)}
    for key, suffix in long.items():  # lists of one unit have one prefix
        sizes[key] = max(_size(figures[name]) for name, other_suffix in long.items() if other_suffix == suffix)
    for key, size in unit_choice_sizes(sizes).items():
        value, (limit, method_error), digits = figures[key], errors[key], digits_of(key)
        items = value if isinstance(value, (list, tuple)) else [value]
        label, unit, factor = unit_of(key, size)
        label = label_in_result(label, result.get("errors_unknown", {}))
        unit = unit if any(map(_is_number, items)) else ""
        has_error = bool(method_error) and _in_digits(method_error, _size(value), digits)
        error = two_digits(factor * method_error) if has_error else ""
        if 1 < len(items) <= AXES and all(map(_is_number, items)) and _size(items):  # a vector: parts of one size
            decimals = digits - 1 - math.floor(math.log10(factor * _size(items)))
            items = [round(factor * item, decimals) / factor for item in items]
            limit = limit and max(limit, 10.0 ** (1 - decimals) / factor)
        texts = [_residual(item) if key in RESIDUALS else value_text(item, factor, limit, digits) for item in items]
        doubtful = key in result.get("large_errors", ())
        rows.append(Figure(key, label, unit, texts, error, doubtful, len(items) if _is_long(value) else 0))
    return rows


def lists_by_length(figures: Iterable[Figure]) -> dict[int, list[Figure]]:
    """The long lists among figures, those of one length together."""
    groups: dict[int, list[Figure]] = {}
    for figure in figures:
        if figure.length:
            groups.setdefault(figure.length, []).append(figure)
    return groups


def readable_events(rows: list[Mapping[str, Any]], unit_of: Readable = readable_label) -> tuple[list, list[list[str]]]:
    """Words and unit of each column of a list of mappings with the same keys, and the rows as texts."""
    columns = {key: [row.get(key) for row in rows] for key in rows[0]}
    shown = [unit_of(key, _size(values)) for key, values in columns.items()]
    texts = [
        [value_text(value, factor) for value in column]
        for column, (*_, factor) in zip(columns.values(), shown, strict=True)
    ]
    return [(label, unit) for label, unit, _ in shown], [list(row) for row in zip(*texts, strict=True)]


def error_texts(result: Mapping[str, Any]) -> tuple[dict[str, str], list[str]]:
    """The errors of the requested outputs by their names, and sentences about errors that are not known."""
    rows = result.get("wanted_errors", {}).items()
    known = {output: output_error_text(row) for output, row in rows if row["error"] is not None}
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


def _without_rounding(value, limit: float):
    """A value or a list with 0 in the place of numbers up to `limit`."""
    if isinstance(value, (list, tuple)):
        return [_without_rounding(item, limit) for item in value]
    return 0.0 if isinstance(value, float) and abs(value) <= limit else value


def _residual(value: float | None) -> str:
    """A relative error of a balance in two digits."""
    return value_text(value) if value is None else two_digits(value if abs(value) > NOISE else 0.0)


def is_events(value) -> bool:
    """True for a list of mappings, with the same keys."""
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(item, Mapping) for item in value)


def _is_long(value) -> bool:
    """True for a list of more numbers than a vector has."""
    return isinstance(value, (list, tuple)) and len(value) > AXES and not isinstance(value[0], (list, tuple, str))


def _size(value) -> float:
    """The greatest magnitude of a value or of the numbers in a list; 0 where there is none."""
    items = value if isinstance(value, (list, tuple)) else [value]
    return float(max((abs(number) for number in items if _is_number(number)), default=0.0))


def _is_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _in_digits(error: float, size: float, digits: int) -> bool:
    """True for an error of at least the last of so many digits of a value of this size."""
    return not size or error >= 10.0 ** (math.floor(math.log10(size)) + 1 - digits)


def badge(text: str, name: str = "", sort: str = "") -> dict[str, str]:
    """A badge beside the title of a page."""
    return {"sort": sort, "name": name, "text": text}


def warning_badges(count: int) -> list[dict[str, str]]:
    """The badge with the number of warnings; none without warnings."""
    return [badge(f"{count} warning{'s' * (count > 1)}", sort="warning")] if count else []


def page_tables(
    figures: Mapping[str, Any], errors: Mapping[str, Any], meanings: Mapping[str, str]
) -> dict[str, list[dict[str, Any]]]:
    """The tables of a page: `figures` (a row each), `tables` (long lists side by side, then events), `errors`."""
    shown = readable_figures(figures, errors)
    rows = [
        {
            "words": figure.words,
            "value": ("; " if not figure.unit else ", ").join(figure.texts) or "none",
            "unit": figure.unit,
            "error": figure.error,
            "meaning": meanings.get(figure.key, ""),
        }
        for figure in shown
        if not figure.length
    ]
    tables: list[dict[str, Any]] = []
    for columns in lists_by_length(shown).values():
        header = [(figure.words, figure.unit, meanings.get(figure.key, "")) for figure in columns]
        cells = [list(row) for row in zip(*(figure.texts for figure in columns), strict=True)]
        list_errors = [figure.error for figure in columns]
        tables.append({"header": header, "rows": cells, "errors": list_errors if any(list_errors) else []})
    for key, events in figures.items():
        if is_events(events):
            header, cells = readable_events(events[:MOST_ROWS])
            title_end = f"; the first {MOST_ROWS} of {len(events)}" if len(events) > MOST_ROWS else ""
            heading = {"title": meanings.get(key, "") + title_end, "noun": key.replace("_", " ")}
            tables.append(heading | {"header": [(*column, "") for column in header], "rows": cells, "errors": []})
    return {"figures": rows, "tables": tables, "errors": error_notes(errors)}


def error_notes(errors: Mapping[str, Any]) -> list[str]:
    """Errors of the outputs requested to a tolerance, and those that are not known."""
    known, unknown = error_texts(errors)
    notes = [f"{output}: error {text}" for output, text in known.items()] + [
        f"Not in these errors: {sentence}" for sentence in unknown
    ]
    return [readable_sentence(sentence) for sentence in notes]
