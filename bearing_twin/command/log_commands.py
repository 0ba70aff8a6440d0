"""The subcommands `verify`, `report`, `recover`, `export`, `explain`; and runs on their way into a log and a picture.

Imports are late, so that --help is quick.
"""

import argparse
import math
from pathlib import Path
from typing import NamedTuple

from bearing_twin.base.errors import BearingTwinError, IntegrationError, LogError
from bearing_twin.base.units import Limits
from bearing_twin.command import study_command
from bearing_twin.command.outcome import (
    RUN,
    Outcome,
    Subcommand,
    add_verbose,
    new_file,
    new_log,
    picture_path,
    quantity,
    run_warnings,
)
from bearing_twin.command.terminal import progress, say, show_rows, show_text, with_progress


class DrawnStream:
    """A run or log whose blocks are added to its picture, if there is one, while they are iterated once."""

    def __init__(self, stream, with_picture: bool = False):
        self._stream, self._blocks = stream, None
        self._picture = None
        if with_picture:
            from bearing_twin.run.report import picture_of

            self._picture = picture_of(stream)

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def blocks(self):
        """The remaining blocks: a later call continues where an earlier one stopped."""
        self._blocks = self._blocks or self._drawn_blocks()
        return self._blocks

    def _drawn_blocks(self):
        for block in self._stream.blocks():
            if self._picture is not None:
                self._picture.add(block)
            yield block

    def write(self, path, report, errors: bool = False) -> str:
        """Draw the picture of the blocks so far, with `errors` those of the figures of the report below."""
        from bearing_twin.run.report import figure_errors

        with progress(f"drawing {path}"):
            return str(self._picture.write(path, figure_errors(report) if errors else ()))


class RunEnd(NamedTuple):
    """End of a run: the reason why its log is incomplete, or "", and the error that ended the run, or None."""

    incomplete: str
    failure: IntegrationError | None


def run_to_end(run: DrawnStream, log: Path | None) -> RunEnd:
    """Run to the end, into a new `log` if one is given; on a full disk the run continues without it.

    Raises LogError where no log can be begun for another reason, before anything is computed.
    """
    incomplete = ""
    try:
        if log:
            incomplete = _write_log(run, log)
        for _ in run.blocks():
            pass
    except IntegrationError as error:
        return RunEnd(incomplete, error)
    return RunEnd(incomplete, run.failure)


def _write_log(run: DrawnStream, log: Path) -> str:
    from bearing_twin.log.mcap_write import FullDisk
    from bearing_twin.log.run_log import write_log

    try:
        write_log(run, log)
    except LogError as error:
        has_begun = run.simulation.sequence >= 0
        if not has_begun and not isinstance(error, FullDisk):
            raise
        sentence = f"{'the log is incomplete' if has_begun else 'there is no log'}: {error}"
        if run.simulation.sequence + 1 < run.outputs and run.failure is None:
            say(f"{sentence}; the run goes on without it")
        return sentence
    return ""


def _log_argument(parser):
    parser.add_argument("log", metavar="LOG", help="an MCAP log")


def _samples_arguments(parser):
    _log_argument(parser)
    parser.add_argument("--topic", metavar="TOPIC", help="of a log of several bearings: the samples of one of them")


def _one_run_arguments(parser):
    _samples_arguments(parser)
    parser.add_argument("--run", **RUN)


def _verify(arguments) -> Outcome:
    from bearing_twin.command.results import show_result
    from bearing_twin.log.run_log import read_log
    from bearing_twin.log.study_log import STUDY_RECORD
    from bearing_twin.run.verify import verify

    with progress("simulating the scene of the log again") as update:
        log = read_log(arguments.log, True, arguments.topic, last_run=True, run=arguments.run)
        if STUDY_RECORD in log.metadata:
            raise LogError("that is the log of a study, and runs alone are verified; report and study --resume read it")
        if log.begins_s:
            say(
                f"the log begins at {log.begins_s:.6g} s: the run up to there is simulated first, compared with nothing"
            )
        verification = verify(log, lambda time: update(time / log.seconds))
    result = {"log": str(arguments.log)} | verification.as_dict() | _thinning(log)
    differences = verification.differences()
    count = f"{len(verification.deviations)}, {f'{len(differences)} not the same' if differences else 'all the same'}"
    hidden = {
        "deviations",
        "records_not_as_many",
        *(("greatest_deviation",) if differences else ()),
    }  # each of them is shown
    shown = {key: value for key, value in result.items() if key not in hidden} | {"channels": count}
    shown |= {"deviation of": differences} if differences else {}
    return Outcome(
        result, [*log.notes, *filter(None, [log.run_note]), *verification.warnings()], lambda: show_result(shown)
    )


def _thinning(log) -> dict[str, float]:
    """The rate of outputs of a thinned log; empty for another."""
    return {"kept_outputs_hz": log.kept_rate} if log.kept_rate else {}


def _report_arguments(parser):
    _one_run_arguments(parser)
    parser.add_argument("--plot", metavar="PNG", help="draw the ball loads")
    add_verbose(parser)


def _report(arguments) -> Outcome:
    from bearing_twin.command.results import show_report
    from bearing_twin.log.run_log import read_log
    from bearing_twin.log.study_log import STUDY_RECORD
    from bearing_twin.run.report import report_of

    picture = picture_path(arguments.plot)
    stream = read_log(arguments.log, True, arguments.topic, last_run=True, run=arguments.run)
    if STUDY_RECORD in stream.metadata:
        return study_command.report(arguments.log, picture)
    watched = DrawnStream(stream, bool(picture))
    report, missing = report_of(stream, with_progress(watched.blocks(), stream.seconds, f"reading {stream.path}"))
    result = report.as_dict() | {"log": str(arguments.log), "missing_outputs": missing, **stream.losses}
    result |= ({"begins_s": stream.begins_s} if stream.begins_s else {}) | _thinning(stream)
    result |= stream.cut_short.as_dict() if stream.cut_short else {}
    if picture:
        result["plot"] = watched.write(picture, report, arguments.plot_errors)
    result |= {"messages_foreign": sum(stream.foreign.values())} if stream.foreign else {}
    return Outcome(
        result, stream.warnings + run_warnings(result), lambda: show_report(report, result, arguments.verbose)
    )


def _recover_arguments(parser):
    _log_argument(parser)
    parser.add_argument("out", metavar="OUT", help="the new log")


def _recover(arguments) -> Outcome:
    from bearing_twin.log.raw_log import recover

    with progress(f"reading what is left of {arguments.log}"):
        recovered = recover(arguments.log, new_log(arguments.out, arguments.log))
    return Outcome({"log": str(arguments.out)} | recovered._asdict(), list(recovered.problems))


EXPORTS = ("csv", "parquet", "netcdf")


def _export_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `export` to its parser."""
    _samples_arguments(parser)
    parser.add_argument("--to", required=True, choices=EXPORTS, help="csv needs nothing, the others the extra export")
    parser.add_argument(
        "--out",
        required=True,
        metavar="PATH",
        help="of netcdf a file; of csv and parquet a folder with a file for each group of channels, or, where there is "
        "but one group, a file with that ending",
    )


def _export(arguments: argparse.Namespace) -> Outcome:
    """Write the files; outputs missing from the log are a warning. Raises BearingTwinError."""
    from bearing_twin.log.export import export_log

    def watch(blocks, stream):
        duration = stream.scene.parameters.run.duration if stream.scene else math.inf
        return with_progress(blocks, duration or math.inf, f"exporting {arguments.log}")

    new_file(arguments.out, arguments.log)
    exported = export_log(arguments.log, arguments.to, arguments.out, arguments.topic, watch)
    result = {"log": arguments.log, "to": arguments.to, "rows": exported.rows, "files": list(exported.files)}
    return Outcome(result | {"missing_outputs": exported.missing}, list(exported.warnings))


def _explain_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `explain` to its parser."""
    parser.add_argument(
        "failure", metavar="SCENE|FILE", help="a scene, or the file that a failed run left, failure_<date>_<time>.json"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="of a scene: change one of its keys"
    )
    share, text = (
        quantity("1", Limits(above=0.0, below=1.0)),
        "wanted.tolerance of the continuation (default: a tenth of that of the run)",
    )
    parser.add_argument("--tolerance", type=share, metavar="SHARE", help=text)
    text = "end of the continuation (default: the end of the scene, or after its duration once more)"
    parser.add_argument("--until", type=quantity("s", Limits(above=0.0)), metavar="SECONDS", help=text)
    parser.add_argument("--out", metavar="LOG", help="write the continuation to this MCAP log")
    parser.add_argument("--stop", action="store_true", help="describe the failure, without a continuation")


def _explain(arguments: argparse.Namespace) -> Outcome:
    """The reasons for a scene's models; of a failure, its cause, and a run that continues."""
    from bearing_twin.run.failure import read_failure, with_duration

    if not arguments.failure.endswith(".json"):
        return _explain_scene(arguments)
    if (path := Path(arguments.failure)).exists() and not path.is_file():
        raise BearingTwinError(f"{path} is no file; give the one that a failed run left")
    failure = read_failure(arguments.failure)
    log = new_log(arguments.out)
    result = {
        "failure": failure.sentence,
        "reason": failure.reason or "unknown",
        "at_s": failure.seconds,
        "body": failure.body or "unknown",
        "contact": failure.contact or "unknown",
        "last_good_s": failure.good_seconds,
        "last_good": {name: value for name, value, _ in failure.body_rows()},
    }
    warnings, incomplete = [], ""
    if not arguments.stop:
        scene = failure.with_tighter_tolerance(arguments.tolerance)
        continued, warnings, incomplete = _continue_run(
            failure, with_duration(scene, _end_time(failure, scene, arguments.until)), log
        )
        result |= continued
    return Outcome(result, warnings, lambda: _show_failure(result, failure), problem=incomplete)


def _explain_scene(arguments: argparse.Namespace) -> Outcome:
    """The rules that applied to a scene, by key, and the warnings of its choice."""
    from bearing_twin.kinds.rules import answers
    from bearing_twin.run.scene import choose, load_scene

    scene = load_scene(arguments.failure, arguments.set)
    warnings = choose(scene).warnings
    rows = [
        {
            "key": key,
            "value": answer.value,
            "why": answer.sentence,
            "when": answer.rule.when if answer.rule else "the scene specifies it",
        }
        for key, answer in answers(scene.kind, scene.parameters).items()
    ]

    def show():
        show_rows(
            ("key", "value", "because", "rule"),
            ((row["key"], str(row["value"]), row["why"], row["when"]) for row in rows),
        )

    return Outcome({"scene": scene.name, "choices": rows, "warnings": list(warnings)}, list(warnings), show)


def _end_time(failure, scene, until: float | None) -> float:
    """End of the run [s]: a node may have failed beyond the end of its scene."""
    duration, begin = scene.parameters.run.duration, _start_time(failure, scene)
    if until is not None and until <= begin:
        raise BearingTwinError(f"--until {until:g} must be later than {begin:.9g} s, where the run goes on")
    return until or (duration if duration > begin else begin + duration)


def _start_time(failure, scene) -> float:
    return max(failure.sequence, 0) * 1e-9 * scene.output_period_ns


def _continue_run(failure, scene, log) -> tuple[dict, list[str], str]:
    """Result, warnings, and the reason why the log is incomplete."""
    from bearing_twin.run.failure import write_failure
    from bearing_twin.run.simulation import simulate

    second_failure = ""
    with progress(f"going on with {scene.name}") as update:
        run = simulate(scene, update, failure)
        incomplete, error = run_to_end(DrawnStream(run), log)
        if error is not None:
            path = write_failure(error, log.parent if log else Path())
            second_failure = f"it fails again {error}" + (f"; see bearing_twin explain {path}" if path else "")
    report = None if second_failure else run.report
    wanted, solver = (getattr(scene.parameters, name, None) for name in ("wanted", "solver"))
    continued = {
        "continued_from_s": _start_time(failure, scene),
        "continued_to_s": 1e-9 * max(run.simulation.time_ns, 0),
        "tolerance": getattr(wanted, "tolerance", None),
        "step_s": getattr(solver, "step", None),
        "status": second_failure or report.status,
        **({"log": str(log)} if log and not (second_failure or incomplete) else {}),
    }
    warnings = (
        [second_failure] if second_failure else [*report.flags, *([report.status] if report.status != "done" else [])]
    )
    return continued, warnings, incomplete


def _show_failure(result, failure) -> None:
    from bearing_twin.command.results import show_result

    show_result({key: value for key, value in result.items() if key != "last_good"})
    if failure.values:
        show_text(f"\nlast good output, {failure.good_seconds:.9g} s, {failure.body or 'all bodies'}:")
        show_rows(
            ("channel", "value", "unit"), ((name, f"{value:.6g}", unit) for name, value, unit in failure.body_rows())
        )


VERIFY = Subcommand(
    "simulate the scene of a log again and compare every number",
    _one_run_arguments,
    _verify,
    ("bearing_twin verify run.mcap",),
)
REPORT = Subcommand(
    "figures of the log of a run or a study, without simulating",
    _report_arguments,
    _report,
    ("bearing_twin report run.mcap", "bearing_twin report run.mcap --plot run.png --json"),
)
RECOVER = Subcommand(
    "copy the readable part of a damaged log into a new one",
    _recover_arguments,
    _recover,
    ("bearing_twin recover cut.mcap saved.mcap",),
)
EXPORT = Subcommand(
    "convert the log of a run or a study to tables (CSV, Parquet) or a data set (NetCDF) with units and axes",
    _export_arguments,
    _export,
    (
        "bearing_twin export run.mcap --to csv --out run_tables",
        "bearing_twin export run.mcap --to netcdf --out run.nc",
        "bearing_twin export study.mcap --to parquet --out study.parquet",
    ),
)
EXPLAIN = Subcommand(
    "why models are chosen for a scene; or where and why a run failed, and its continuation at a tighter tolerance",
    _explain_arguments,
    _explain,
    (
        "bearing_twin explain bearing_6203",
        "bearing_twin explain failure_20261122_101500.json",
        "bearing_twin explain failure.json --tolerance 1e-6 --out on.mcap",
    ),
)
