"""Results as tables: a run's loads and figures first, then its status; all that is known of it with --verbose."""

import math
from collections.abc import Iterator, Mapping
from contextvars import ContextVar
from dataclasses import dataclass, field

from bearing_twin.base.report import Report, plain_json
from bearing_twin.base.units import (
    LUBRICATED,
    greatest_error,
    known_digits,
    named,
    of_films,
    readable,
    sizes_for_units,
    two_digits,
    unit_suffix,
)
from bearing_twin.command.terminal import (
    SI,
    columns_apart,
    in_shown_units,
    named_values,
    show_rows,
    show_text,
    width_of_terminal,
)

FILMS: ContextVar[bool] = ContextVar("films", default=False)  # whether contacts of the result shown have films
ERROR = "_error"  # behind a figure's key: what is not known of it
BEYOND_DIGITS = 5e-7  # of a value: an error below it is beyond the six digits shown
AXES = 3  # lists of so many numbers at most are vectors


def show_report(report: Report, result: Mapping, verbose: bool = False) -> None:
    """Print what a run or a log gave: loads and figures first, then the status and the errors of outputs.

    Parameters
    ----------
    report : Report
        The report itself.
    result : mapping
        The object of `--json`: the report with what the command adds, such as the path of a log.
    verbose : bool
        Print every column and key, as why the model was chosen, costs, and errors of the model.
    """
    result = plain_json(result)
    if verbose:
        show_result(result)
        return
    of_report = report.as_dict().keys()
    shown = {key: result[key] for key in report.figures} | {
        key: one for key, one in result.items() if key not in of_report
    }
    errors = {key: one for key, one in _errors_apart(result)[1].items() if key in shown}
    values = _Values.of(result, shown, errors)
    duration = in_shown_units(f"{report.simulated_seconds:.6g} s")
    show_text(f"{report.scene or 'log'}: {duration}, law {report.law}, stepper {report.stepper}")
    left_out = values.show_columns(everything=False)
    show_text()
    values.show_single()
    values.show_events()
    show_text()
    rows = [("status", report.status), *_errors_of_outputs(result)]
    if report.compute_seconds > 0.0:
        computed = in_shown_units(f"{report.compute_seconds:.3g} s")
        rows.append(("computed in", f"{computed}, {report.real_time_factor:.2g} times real time"))
    show_text("\n".join(named_values(rows, width_of_terminal())))
    more = "further columns, " if left_out else ""
    show_text(f"with --verbose: {more}why this model, costs, errors of the model")


def _errors_of_outputs(result: Mapping) -> list[tuple[str, str]]:
    from bearing_twin.run.report import promise_in_words

    wanted = result.get("wanted_errors", {}).items()
    return [(f"error of {output}", promise_in_words(one)) for output, one in wanted if one["error"] is not None]


def show_result(result: Mapping) -> None:
    """Print a result on standard output: values and short lists first, then a table for each group of longer ones."""
    values = _Values.of(result, *_errors_apart(result))
    values.show_single()
    values.show_events()
    values.show_columns()


@dataclass(frozen=True)
class _Values:
    """What is shown of a result: `single` values, `columns` by their length, `events` (mappings with equal keys)."""

    whole: Mapping
    errors: Mapping
    sizes: Mapping[str, float]
    single: list[tuple[str, str]] = field(default_factory=list)
    columns: dict[int, dict[str, list]] = field(default_factory=dict)
    events: dict[str, list[Mapping]] = field(default_factory=dict)

    @classmethod
    def of(cls, whole: Mapping, shown: Mapping, errors: Mapping) -> "_Values":
        from bearing_twin.run.report import shown_errors

        FILMS.set(LUBRICATED in (whole.get("errors_unknown") or ()))
        found = cls(whole, errors, _sizes(shown, errors))
        for key, value in _flat(shown):
            first = value[0] if isinstance(value, (list, tuple)) and value else None
            if isinstance(first, Mapping):
                found.events[key] = value
            elif first is not None and not isinstance(first, (list, tuple, str)) and len(value) > AXES:
                found.columns.setdefault(len(value), {})[key] = value
            elif isinstance(value, (list, tuple)) and (first is None or isinstance(first, (list, tuple, str))):
                found.single.append((named(key)[0], "\n".join(map(_text, value)) or "none"))
            else:
                found.single.append(_named_value(key, value, shown_errors(whole, key), found.sizes[key]))
        return found

    def show_single(self) -> None:
        """Print the single values."""
        show_text("\n".join(named_values(self.single, width_of_terminal())))

    def show_events(self) -> None:
        """Print a table for each list of events."""
        for key, rows in self.events.items():
            _show_events(named(key)[0], [dict(_flat(row)) for row in rows])

    def show_columns(self, everything: bool = True) -> bool:
        """Print the tables of longer lists, or of each length as many columns as fit; True if some were left out."""
        from bearing_twin.run.report import shown_errors

        left = False
        for length, lists in self.columns.items():
            header = ["mode" if "natural_frequencies_hz" in lists else "ball"]
            cells, shown = [[str(row) for row in range(length)]], []
            for key, values in lists.items():
                words, unit, factor = _readable(key, self.sizes[key])
                header.append(f"{words}\n{unit or '-'}")
                most, own = shown_errors(self.whole, key)
                cells.append([_text(value, factor, most) for value in values])
                shown.append(two_digits(factor * own) if _in_digits(own, values) else "")
            if any(shown):
                for column, error in zip(cells, ["±", *shown], strict=True):
                    column.append(error)
            tables = columns_apart(header, cells, width_of_terminal())
            for lines in tables if everything else tables[:1]:
                show_text("\n".join(["", *(line for line in lines if line.strip() != "±")]))
            left = left or (len(tables) > 1 and not everything)
        return left


def _show_events(title: str, rows: list[dict]) -> None:
    """A table of mappings with the same keys, a row each."""
    units = {key: _readable(key, _size([row.get(key) for row in rows])) for key in rows[0]}
    header = [f"{words} [{unit}]" if unit else words for words, unit, _ in units.values()]
    show_text(f"\n{title}")
    show_rows(header, ([_text(row.get(key), units[key][2]) for key in units] for row in rows))


def show_quantities(result: Mapping) -> None:
    """Print single values of a result as a table of quantity, value and unit; lists of numbers side by side."""
    rows = []
    for key, value in result.items():
        words, unit, factor = _readable(key, _size(value))
        shown = "  ".join(_text(one, factor) for one in value) if isinstance(value, list) else _text(value, factor)
        rows.append((words, shown, unit))
    show_rows(("quantity", "value", "unit"), rows)


def _readable(key: str, size: float) -> tuple[str, str, float]:
    """(words, unit, factor into that unit) of a key with values to `size`: SI with --si, else what engineers read."""
    words, *shown = (*named(key), 1.0) if SI.get() else readable(key, size)
    return (of_films(words) if FILMS.get() else words, *shown)


def _sizes(result: Mapping, errors: Mapping) -> dict[str, float]:
    """The size by which the unit of each key is chosen: of a vector its error counts too."""
    sizes = {}
    for key, value in _flat(result):
        long = isinstance(value, (list, tuple)) and len(value) > AXES
        sizes[key] = max(_size(value), 0.0 if long else _size(greatest_error(errors.get(key))))
    return sizes_for_units(sizes)


def _size(values) -> float:
    """The greatest magnitude of a value or of the numbers in a list; 0 where there is none."""
    several = values if isinstance(values, (list, tuple)) else [values]
    return float(max((abs(one) for one in several if _is_finite_number(one)), default=0.0))


def _in_digits(error: float | None, value) -> bool:
    """True for an error that the digits shown of a value can tell, or one of 0."""
    if error is None:
        return False
    return error > BEYOND_DIGITS * _size(value) if error else _size(value) > 0.0


def _is_finite_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _named_value(key: str, value, errors: tuple, size: float) -> tuple[str, str]:
    """The words of a key and its value for people, with its error, and marked where that is large.

    `errors` are those of `run.doubt.shown_errors`.
    """
    from bearing_twin.run.report import exceeds

    numbers, (most, worst) = list(value) if isinstance(value, (list, tuple)) else [value], errors
    words, unit, factor = _readable(key, size)
    shown = ", ".join(_text(one, factor, most) for one in numbers)
    shown += f" ± {two_digits(factor * worst)}" if value is not None and _in_digits(worst, value) else ""
    shown = f"{shown} {unit}".rstrip() if any(map(_is_finite_number, numbers)) else shown
    large = most is not None and value is not None and any(map(_is_finite_number, numbers)) and exceeds(value, most)
    return words, f"{shown} (doubtful)" if large else shown


def _errors_apart(result: Mapping) -> tuple[dict, dict]:
    """The result without the errors of its figures, which join them in the table, and these; parts stay in --json."""
    from bearing_twin.run.report import model_errors_in_words, promise_in_words

    errors = {key.removesuffix(ERROR): value for key, value in result.items() if key.endswith(ERROR)}
    errors = {key: value for key, value in errors.items() if key in result}
    hidden = {f"{key}{ERROR}" for key in errors} | {"errors_by_source"}
    errors = {key: value for key, value in errors.items() if value is not None}
    known = {output: one for output, one in result.get("wanted_errors", {}).items() if one["error"] is not None}
    shown = {f"error of {output}": promise_in_words(one) for output, one in known.items()}
    notes = [f"{name}: {sentence}" for name, sentence in result.get("errors_unknown", {}).items()]
    hidden |= {"wanted_errors", "errors_unknown"}
    if "errors_by_source" in result:  # of a run
        hidden |= {"model_errors"}
        shown |= {"model errors": model} if (model := model_errors_in_words(result)) else {}
    rest = {key: value for key, value in result.items() if key not in hidden}
    return rest | shown | ({"not included in these errors": notes} if notes else {}), errors


def _flat(result: Mapping, prefix: str = "", suffix: str = "") -> Iterator[tuple[str, object]]:
    """Values of nested mappings by keys joined; the unit of an outer key ends those within that have none."""
    for key, value in result.items():
        own = unit_suffix(key)
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key.removesuffix(own)}_", own or suffix)
        else:
            yield f"{prefix}{key}{'' if own else suffix}", value


def _text(value, factor: float = 1.0, error: float | None = None) -> str:
    if value is None or isinstance(value, bool):
        return {None: "-", True: "yes", False: "no"}[value]
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_text, value))
    if not isinstance(value, (int, float)) or (isinstance(value, int) and factor == 1.0):
        return in_shown_units(str(value))
    return known_digits(factor * value, None if error is None else factor * error)
