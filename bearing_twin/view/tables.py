"""Figures of a report as rows for people: words, number with a readable prefix, unit, error, meaning."""

import math
from collections.abc import Mapping
from typing import Any

from bearing_twin.units import named, prefixed

ERROR = "_error"
AXES = 3  # lists of so many numbers at most are vectors
DIGITS = 5


def figure_rows(
    figures: Mapping[str, Any], errors: Mapping[str, Any], meanings: Mapping[str, str]
) -> list[dict[str, str]]:
    """One row a figure of one number, one text or a short vector, with `<figure>_error` of `errors`."""
    rows = []
    for key, value in figures.items():
        if _of_balls(value) or isinstance(value, Mapping):
            continue
        words, unit = named(key)
        text, unit, factor = _shown(value, unit)
        rows.append(
            {
                "words": words,
                "value": text,
                "unit": unit,
                "error": _error(errors.get(f"{key}{ERROR}"), factor),
                "meaning": meanings.get(key, ""),
            }
        )
    return rows


def ball_tables(
    figures: Mapping[str, Any], errors: Mapping[str, Any], meanings: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Figures that are lists of as many numbers, side by side: `header` (words, unit, meaning), `rows`, `errors`."""
    by_length: dict[int, dict[str, list]] = {}
    for key, value in figures.items():
        if _of_balls(value):
            by_length.setdefault(len(value), {})[key] = value
    tables = []
    for columns in by_length.values():
        header, filled, greatest = [], [], []
        for key, values in columns.items():
            words, unit = named(key)
            factor, unit = _prefix(values, unit)
            header.append((words, unit, meanings.get(key, "")))
            filled.append([_number(value, factor) for value in values])
            greatest.append(_error(errors.get(f"{key}{ERROR}"), factor))
        rows = [list(row) for row in zip(*filled, strict=True)]
        tables.append({"header": header, "rows": rows, "errors": greatest if any(greatest) else []})
    return tables


def error_notes(errors: Mapping[str, Any]) -> list[str]:
    """What a report says of outputs that were wanted to a tolerance, and of what its errors leave out."""
    told = [
        f"{output} are off by {one['error']:.2g} {one['norm']}, wanted {one['tolerance']:g} {one['where']}".rstrip()
        for output, one in errors.get("wanted_errors", {}).items()
        if one["error"] is not None
    ]
    return told + [f"Not in these errors: {name}: {text}" for name, text in errors.get("errors_unknown", {}).items()]


def _error(error, factor: float) -> str:
    """An error, of several the greatest, in the unit of its figure."""
    if error is None:
        return ""
    return f"{factor * (max(error) if isinstance(error, (list, tuple)) else error):.2g}"


def _of_balls(value) -> bool:
    """Whether it is a list of more numbers than a vector has."""
    several = isinstance(value, (list, tuple)) and len(value) > AXES
    return several and not isinstance(value[0], (list, tuple, str, Mapping))


def _shown(value, unit: str) -> tuple[str, str, float]:
    """(text, unit with prefix, factor)."""
    if isinstance(value, (list, tuple)) and any(isinstance(one, (list, tuple, str, Mapping)) for one in value):
        return "; ".join(map(str, value)) or "none", unit, 1.0
    several = list(value) if isinstance(value, (list, tuple)) else [value]
    factor, unit = _prefix(several, unit)
    return ", ".join(_number(one, factor) for one in several) or "none", unit, factor


def _prefix(values, unit: str) -> tuple[float, str]:
    sizes = [abs(one) for one in values if isinstance(one, float) and math.isfinite(one)]
    return prefixed(max(sizes), unit) if sizes else (1.0, unit)


def _number(value, factor: float) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value * factor + 0.0:.{DIGITS}g}" if math.isfinite(value) else "-"
    return str(value)
