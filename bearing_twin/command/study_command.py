"""The subcommand `study`: an ensemble with its statistics. Imports are late, so that --help is quick."""

import argparse
import contextlib
import signal
import threading
from functools import partial

from bearing_twin.base.errors import LogError, StudyError
from bearing_twin.base.report import json_text
from bearing_twin.base.units import two_digits
from bearing_twin.command.outcome import Outcome, Subcommand, add_changes, new_log, overrides_of, picture_path
from bearing_twin.command.terminal import progress, say, show_paragraph, show_rows, show_text, shown_unit

SWEPT = ("mean", "std")  # statistics that the table of a sweep has
OPEN_END = "?"  # in an interval: no end on this side
OPEN_NOTE = f"{OPEN_END}: the samples are too few to bound the interval on this side; take more"


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `study` to its parser."""
    parser.add_argument("study", nargs="?", help="name of a study (see --list), or path of a YAML file")
    parser.add_argument("--list", action="store_true", help="list the studies and the quantities of each kind of scene")
    add_changes(parser, "change a key of the study, of an input (inputs.KEY.std=4e-5) or of the scene")
    parser.add_argument("--samples", metavar="N", help="the same as --set samples=N")
    parser.add_argument("--seed", metavar="S", help="the same as --set seed=S")
    parser.add_argument("--workers", metavar="N", help="the same as --set workers=N; 0 = one a processor")
    parser.add_argument("--resume", metavar="LOG", help="continue with the samples of this log")
    parser.add_argument("--out", metavar="LOG", help="write result and samples to this MCAP log")
    parser.add_argument("--plot", metavar="PNG", help="draw distributions and convergence")


def _run(arguments: argparse.Namespace) -> Outcome:
    """Run one study; raises StudyError where it is not possible, KeyboardInterrupt after Ctrl-C."""
    if arguments.list:
        return _list()
    if arguments.study is None:
        raise StudyError("which study? give its name or a path; `bearing_twin study --list` lists them")
    picture = picture_path(arguments.plot)
    from bearing_twin.log.mcap_write import FullDisk
    from bearing_twin.log.study_log import StudyLog, read_study
    from bearing_twin.uq.run import run_study
    from bearing_twin.uq.study import load_study

    study = load_study(arguments.study, overrides_of(arguments, samples="samples", seed="seed", workers="workers"))
    start = read_study(arguments.resume, unfinished=True) if arguments.resume else None
    log = new_log(arguments.out, arguments.resume)
    cancelled = threading.Event()
    result = problem = writer = None
    try:
        with contextlib.ExitStack() as stack:
            try:
                writer = stack.enter_context(StudyLog(study, log)) if log else None
            except FullDisk as error:
                problem = error
                say(f"there is no log: {error}; the study goes on without it")
            with _cancel_on_ctrl_c(cancelled), progress(f"study {study.name}") as update:
                keep = writer.add if writer else None
                result = run_study(study, lambda state: update(state.done / state.total), cancelled, start, keep)
            if writer:
                writer.finish(result)
    except LogError as error:  # the result is there: it is shown before anything is said of its log
        if result is None:
            raise
        problem = error
    written = {"log": str(log)} if log and not problem else {}
    if picture and not cancelled.is_set():  # which takes seconds
        from bearing_twin.view.study_picture import plot_study

        written["plot"] = str(plot_study(result, picture))
    summary = result.as_dict() | written
    if cancelled.is_set() or problem:
        show_text(json_text(summary)) if arguments.json else show(summary)
    if problem:
        raise problem
    if cancelled.is_set():
        undrawn = f"; {picture} is not drawn" if picture else ""
        say(f"stopped by Ctrl-C with {summary['samples']} of {study.settings.samples} samples done{undrawn}")
        raise KeyboardInterrupt
    return Outcome(summary, list(result.doubts), lambda: show(summary))


STUDY = Subcommand(
    "distributions of the results of a scene with uncertain inputs, with confidence intervals",
    _add_arguments,
    _run,
    (
        "bearing_twin study --list",
        "bearing_twin study spheres_alpha_4e-5 --plot study.png",
        "bearing_twin study bearing_6203_tolerances --samples 200 --out study.mcap",
    ),
)


def report(log, picture) -> Outcome:
    """The result in the log of a study, with its picture if one is requested."""
    from bearing_twin.log.study_log import read_study, reading_study
    from bearing_twin.uq.result import sweep_of

    with reading_study(log):
        result = read_study(log)
        # a log of an earlier version has no units
        swept = {"sweep": sweep_of(result)} if "sweep" in result.summary else {}
        summary = result.as_dict() | swept | {"log": str(log)}
        if picture:
            from bearing_twin.view.study_picture import plot_study

            summary["plot"] = str(plot_study(result, picture))
        return Outcome(summary, list(result.doubts), partial(reading_study(log)(show), summary))


@contextlib.contextmanager
def _cancel_on_ctrl_c(event):
    """The first Ctrl-C sets the event, so that what is done is kept; the second interrupts."""

    def first(number, frame):
        event.set()
        signal.signal(signal.SIGINT, previous)

    previous = None
    with contextlib.suppress(ValueError):  # not in the main thread
        previous = signal.signal(signal.SIGINT, first)
    try:
        yield
    finally:
        if previous is not None:
            signal.signal(signal.SIGINT, previous)


def _list() -> Outcome:
    from bearing_twin.base.yaml_files import STUDIES
    from bearing_twin.kinds import KINDS

    rows = [{name: head[name] for name in ("name", "scene", "description")} for head in STUDIES.headers()]
    quantities = [
        {"kind": kind, "quantity": name, "unit": row.unit, "meaning": row.meaning}
        for kind, entry in KINDS.items()
        for name, row in entry.quantities_of().items()
    ]

    def show():
        show_rows(("name", "scene", "description"), (row.values() for row in rows))
        show_text()
        show_rows(("kind", "quantity", "unit", "meaning"), (row.values() for row in quantities))

    return Outcome({"studies": rows, "quantities": quantities}, [], show)


def show(summary) -> None:
    """Print the summary of a study as tables."""
    from bearing_twin.uq.result import (
        SweepDescription,
        model_error_sentences,
        names_by_sentence,
        refusals,
        shares_of,
        size_of,
    )

    quantities = summary["quantities"]
    units = {name: shown_unit(quantity["unit"], size_of(quantity)) for name, quantity in quantities.items()}
    rows = [row for name, quantity in quantities.items() for row in _statistics(name, quantity, *units[name])]
    sweep = SweepDescription(summary["sweep"], shown_unit) if "sweep" in summary else None
    if sweep and sweep.in_scene:
        show_paragraph(f"at {sweep.in_scene}, as in the scene{'; the sweep of it is below' if sweep.values else ''}")
    show_rows(("quantity", "statistic", "value [95 % interval]", "unit"), rows)
    if any(OPEN_END in value for _, _, value, _ in rows):
        show_paragraph(OPEN_NOTE)
    if sweep and sweep.values:
        show_text(f"\nsweep of {sweep.label}")
        columns = ("quantity", "at", *(f"{key} [95 % interval]" for key in SWEPT), "unit")
        show_rows(columns, _sweep_rows(sweep.values, summary["sweep"]["studies"], units))
        show_text()
    if sweep and sweep.incomplete:
        show_paragraph(sweep.incomplete)
    for sentence in model_error_sentences(summary, shown_unit):
        show_paragraph(sentence)
    sources = [
        (
            name if not row_number else "",
            key,
            *(_interval(share["value"], (share["low"], share["high"])) for share in (shares["first"], shares["total"])),
        )
        for name, quantity in quantities.items()
        for row_number, (key, shares) in enumerate(shares_of(quantity).items())
    ]
    if sources:
        show_text()
        show_rows(("quantity", "share of its variance from", "alone", "in all"), sources)
    remarks = {name: [*refusals(row), *_remarks(row, *units[name])] for name, row in quantities.items()}
    for sentence, names in names_by_sentence(remarks).items():
        is_all = len(names) == len(quantities) > 1
        show_paragraph(f"{'all quantities' if is_all else ', '.join(names)}: {sentence}")
    for name, history in summary.get("histories", {}).items():
        show_paragraph(f"{name} over time: --json has the statistics of {history['realisations']} realisations")
    failed = sum(summary["failed"].values())
    show_paragraph(
        f"{summary['samples']} samples, {failed} failed, {summary['seconds']:.3g} s; {summary['stopped_because']}"
    )
    for reason, count in summary["failed"].items():
        show_paragraph(f"  {count} failed: {reason}")


def _statistics(name: str, quantity, unit: str, factor: float):
    """Rows of mean, deviation, skewness and quantiles."""
    for key in ("mean", "std", "skewness"):
        shown, scale = ("1", 1.0) if key == "skewness" else (unit, factor)
        value = _interval(quantity[key], quantity[f"{key}_interval"], scale)
        yield name if key == "mean" else "", key, value, shown
    for p, quantile in quantity["quantiles"].items():
        yield "", f"{p} quantile", _interval(quantile["value"], (quantile["low"], quantile["high"]), factor), unit


def _sweep_rows(values, studies, units):
    """A row for each quantity and value of a sweep."""
    for name, (unit, factor) in units.items():
        for row_number, (value, study) in enumerate(zip(values, studies, strict=True)):
            quantity = study["quantities"][name]
            cells = (_interval(quantity[key], quantity[f"{key}_interval"], factor) for key in SWEPT)
            yield name if not row_number else "", f"{value:.6g}", *cells, unit


def _remarks(quantity, unit: str, factor: float):
    """Sentences about a quantity: how exact, what is unsafe, modes."""
    from bearing_twin.uq.result import in_words, shares_of

    if quantity["unsafe"]:
        several = len(quantity["unsafe"]) > 1
        subject = f"interval{'s' if several else ''} of {in_words(quantity['unsafe'])} {'are' if several else 'is'}"
        yield f"the {subject} unsafe: a few extreme samples determine it; take more samples"
    if reason := quantity.get("sobol", {}).get("refused"):
        yield reason
    sources = shares_of(quantity).items()
    if unsafe := [key for key, shares in sources if any(share.get("unsafe") for share in shares.values())]:
        yield f"intervals of its shares from {in_words(unsafe)} are unsafe, as a few rows decide; raise sensitivity"
    if quantity["modality"]:
        yield _modes(quantity["modality"])


def _modes(modality) -> str:
    number = f"{modality['modes']} mode{'s' if modality['modes'] > 1 else ''}"
    if modality["p_value"] is None:
        return f"{number} of the exact density"
    return f"{number}; p = {two_digits(modality['p_value'])} for a single one (Silverman's test, level 0.05)"


def _interval(value, interval, factor: float = 1.0) -> str:
    """A number and its interval, to the second digit of what the interval leaves open."""
    from bearing_twin.base.units import rounded_to_error

    if value is None:
        return "-"
    ends = interval or (None, None)
    uncertainty = max((abs(factor * (end - value)) for end in ends if end is not None), default=0.0)
    digits = 6 if uncertainty else 4
    shown, low, high = (
        OPEN_END if end is None else rounded_to_error(factor * end, uncertainty, digits) for end in (value, *ends)
    )
    return shown if low == high == OPEN_END else f"{shown} [{low}, {high}]"
