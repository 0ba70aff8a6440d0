"""Results as tables: a run's loads and figures first, then its status; all that is known of it with --verbose."""

from collections.abc import Iterator, Mapping

from bearing_twin.base.report import Report, json_data
from bearing_twin.base.units import label_and_unit, readable_label, unit_suffix
from bearing_twin.command.terminal import (
    SI,
    in_shown_units,
    show_pairs,
    show_rows,
    show_text,
    split_columns,
)
from bearing_twin.run.report import model_error_lines
from bearing_twin.view.tables import (
    Figure,
    error_texts,
    is_events,
    lists_by_length,
    readable_events,
    readable_figures,
)

ERROR_SUFFIX = "_error"  # behind a figure's key: what is not known of it


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
    result = json_data(result)
    if verbose:
        show_result(result)
        return
    report_keys = report.as_dict().keys()
    added = {key: value for key, value in result.items() if key not in report_keys}
    shown = {key: result[key] for key in report.figures} | added
    figures, events = _readable_tables(shown, result)
    duration = in_shown_units(f"{report.simulated_seconds:.6g} s")
    model = f", law {report.law}, stepper {report.stepper}" if report.law else ""
    show_text(f"{report.scene or 'log without its scene'}: {duration}{model}")
    omitted = _show_columns(figures, everything=False)
    show_text()
    _show_single(figures)
    _show_events(events)
    show_text()
    rows = [("status", report.status)]
    rows += [(f"error of {output.replace('_', ' ')}", text) for output, text in error_texts(result)[0].items()]
    if report.compute_seconds > 0.0:
        computed = in_shown_units(f"{report.compute_seconds:.3g} s")
        rows.append(("computed in", f"{computed}, {report.real_time_factor:.2g} times real time"))
    show_pairs(rows)
    omitted_columns = "further columns, " if omitted else ""
    show_text(f"with --verbose: {omitted_columns}why this model, costs, errors of the model")


def show_result(result: Mapping) -> None:
    """Print a result on standard output: values and short lists first, then a table for each group of longer ones."""
    figures, events = _readable_tables(_with_errors(result), result)
    _show_single(figures)
    _show_events(events)
    _show_columns(figures)


def _readable_tables(shown: Mapping, result: Mapping) -> tuple[list[Figure], dict[str, list[Mapping]]]:
    """The figures and the lists of events among what is shown of a result."""
    flat = dict(_flat(shown))
    return readable_figures(flat, result, _readable_key), {
        key: value for key, value in flat.items() if is_events(value)
    }


def _show_single(figures: list[Figure]) -> None:
    rows = []
    for figure in figures:
        if figure.length:
            continue
        text = (", " if figure.unit or len(figure.texts) == 1 else "\n").join(figure.texts) or "none"
        text = text if figure.unit else in_shown_units(text)
        text += f" ± {figure.error}" if figure.error else ""
        rows.append((figure.words, f"{text} {figure.unit}".rstrip() + " (doubtful)" * figure.doubtful))
    show_pairs(rows)


def _show_events(events: Mapping[str, list[Mapping]]) -> None:
    """Print a table for each list of events."""
    for key, rows in events.items():
        header, cells = readable_events([dict(_flat(row)) for row in rows], _readable_key)
        show_text(f"\n{label_and_unit(key)[0]}")
        show_rows([f"{label} [{unit}]" if unit else label for label, unit in header], cells)


def _show_columns(figures: list[Figure], everything: bool = True) -> bool:
    """Print the tables of longer lists, or of each length as many columns as fit; True if some were left out."""
    omitted = False
    for length, columns in lists_by_length(figures).items():
        header = ["mode" if any(figure.key == "natural_frequencies_hz" for figure in columns) else "ball"]
        header += [f"{figure.words}\n{figure.unit or '-'}" for figure in columns]
        cells = [[str(row) for row in range(length)], *(list(figure.texts) for figure in columns)]
        if any(figure.error for figure in columns):
            for column, error in zip(cells, ["±", *(figure.error for figure in columns)], strict=True):
                column.append(error)
        tables = split_columns(header, cells)
        for lines in tables if everything else tables[:1]:
            show_text("\n".join(["", *(line for line in lines if line.strip() != "±")]))
        omitted = omitted or (len(tables) > 1 and not everything)
    return omitted


def show_quantities(result: Mapping) -> None:
    """Print single values of a result as a table of quantity, value and unit; lists of numbers side by side."""
    figures = readable_figures(result, {}, _readable_key)
    show_rows(
        ("quantity", "value", "unit"), ((figure.words, "  ".join(figure.texts), figure.unit) for figure in figures)
    )


def _readable_key(key: str, size: float) -> tuple[str, str, float]:
    """(words, unit, factor into that unit) of a key with values to `size`: SI with --si, else what engineers read."""
    return (*label_and_unit(key), 1.0) if SI.get() else readable_label(key, size)


def _with_errors(result: Mapping) -> dict:
    """The result without the errors of its figures, which are shown beside them; parts stay in --json."""
    errors = {key for key in result if key.endswith(ERROR_SUFFIX) and key.removesuffix(ERROR_SUFFIX) in result}
    hidden = errors | {"errors_by_source", "large_errors", "wanted_errors", "errors_unknown"}
    hidden |= {"flags"} if "status" in result else set()  # printed as warnings
    hidden |= set() if result.get("warnings") else {"warnings"}
    known, notes = error_texts(result)
    shown = {f"error of {output.replace('_', ' ')}": text for output, text in known.items()}
    if "errors_by_source" in result:  # of a run
        hidden |= {"model_errors"}
        shown |= {"model errors": model} if (model := model_error_lines(result)) else {}
    visible = {key: value for key, value in result.items() if key not in hidden}
    return visible | shown | ({"not included in these errors": notes} if notes else {})


def _flat(result: Mapping, prefix: str = "", suffix: str = "") -> Iterator[tuple[str, object]]:
    """Values of nested mappings by keys joined; the unit of an outer key ends those within that have none."""
    for key, value in result.items():
        own_suffix = unit_suffix(key)
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key.removesuffix(own_suffix)}_", own_suffix or suffix)
        else:
            yield f"{prefix}{key}{'' if own_suffix else suffix}", value
