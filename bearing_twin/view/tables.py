"""Figures of a report as rows for people: words, number with a readable prefix, unit, error, meaning."""

import math
from collections.abc import Mapping
from typing import Any

from bearing_twin.units import named, prefixed

ERROR = "_error"
AXES = 3  # lists of so many numbers at most are vectors
DIGITS = 5


def figure_rows(figures: Mapping[str, Any], meanings: Mapping[str, str]) -> list[dict[str, str]]:
    """One row a figure of one number, one text or a short vector; `<figure>_error` joins the row of its figure."""
    rows = []
    for key, value in figures.items():
        if _is_error(key, figures) or _of_balls(value) or isinstance(value, Mapping):
            continue
        words, unit = named(key)
        text, unit = _shown(value, unit)
        error = figures.get(f"{key}{ERROR}")
        beside = "" if error is None else " ".join(_shown(error, named(key)[1])).strip()
        rows.append({"words": words, "value": text, "unit": unit, "error": beside, "meaning": meanings.get(key, "")})
    return rows


def ball_tables(figures: Mapping[str, Any], meanings: Mapping[str, str]) -> list[dict[str, Any]]:
    """Figures that are lists of as many numbers, side by side: `header` of (words, unit, meaning) and `rows`."""
    by_length: dict[int, dict[str, list]] = {}
    for key, value in figures.items():
        if _of_balls(value) and not _is_error(key, figures):
            by_length.setdefault(len(value), {})[key] = value
    tables = []
    for columns in by_length.values():
        header, filled = [], []
        for key, values in columns.items():
            words, unit = named(key)
            factor, unit = _prefix(values, unit)
            header.append((words, unit, meanings.get(key, "")))
            filled.append([_number(value, factor) for value in values])
        tables.append({"header": header, "rows": [list(row) for row in zip(*filled, strict=True)]})
    return tables


def _is_error(key, figures) -> bool:
    return key.endswith(ERROR) and key.removesuffix(ERROR) in figures


def _of_balls(value) -> bool:
    """Whether it is a list of more numbers than a vector has."""
    return (
        isinstance(value, (list, tuple)) and len(value) > AXES and not isinstance(value[0], (list, tuple, str, Mapping))
    )


def _shown(value, unit: str) -> tuple[str, str]:
    if isinstance(value, (list, tuple)) and any(isinstance(one, (list, tuple, str, Mapping)) for one in value):
        return "; ".join(map(str, value)) or "none", unit
    several = list(value) if isinstance(value, (list, tuple)) else [value]
    factor, unit = _prefix(several, unit)
    return ", ".join(_number(one, factor) for one in several) or "none", unit


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
