"""The subcommands, one table: what each takes, does and hands back. Imports are late, so that --help is quick."""

import contextlib
import math
import shutil
from pathlib import Path

from bearing_twin.base.errors import BearingTwinError, LogError
from bearing_twin.base.units import Limits
from bearing_twin.command import (
    bearing_command,
    chart_command,
    contact_command,
    explain_command,
    export_command,
    node_command,
    scene_commands,
    study_command,
    view_commands,
)
from bearing_twin.command.logged import ShownStream, ended
from bearing_twin.command.outcome import (
    Outcome,
    Subcommand,
    add_changes,
    doubts_of,
    failure_kept,
    new_log,
    number,
    overrides_of,
    picture_path,
    quantity,
)


def _of(module) -> Subcommand:
    """The subcommand of a module of its own."""
    return Subcommand(module.HELP, module.add_arguments, module.run, module.EXAMPLES)


def _simulate_arguments(parser):
    parser.add_argument("scene", help="name of a scene (see `bearing_twin scenes`), path of a YAML file, or a log")
    add_changes(parser, "change one key of the scene; may be repeated")
    parser.add_argument("--duration", metavar="SECONDS", help="the same as --set run.duration=SECONDS")
    longer = "with a log: continue its run for so long from the state at its end; figures are those of the continuation"
    parser.add_argument("--continue", dest="more", type=quantity("s"), metavar="SECONDS", help=longer)
    parser.add_argument("--out", metavar="LOG", help="write the run to this MCAP log")
    parser.add_argument(
        "--max-loss",
        metavar="SECONDS",
        default="0",
        help="with --out: how much of the log a crash may take along; 0 = a chunk, and the same bytes for the same run",
    )
    parser.add_argument(
        "--plot",
        metavar="PNG",
        help="draw the ball loads, the impact or the motion; of soft discs also a .gif that moves",
    )


def _simulate(arguments) -> Outcome:
    from bearing_twin.kinds import KINDS
    from bearing_twin.run.scene import load_scene

    max_loss = number("--max-loss", arguments.max_loss, "s", Limits(at_least=0.0, at_most=60.0))
    if max_loss and not arguments.out:
        raise BearingTwinError("--max-loss is of a log that is written: give --out, too")
    overrides, begun = overrides_of(arguments, duration="run.duration"), None
    if arguments.more is None:
        scene = load_scene(arguments.scene, overrides)
    else:
        if arguments.duration or not arguments.more > 0.0:
            raise BearingTwinError("--continue takes a time above 0, in place of --duration")
        from bearing_twin.log.run_log import read_log
        from bearing_twin.run.failure import continued

        begun = continued(read_log(arguments.scene), arguments.more, overrides)
        scene = begun.scene
    picture = picture_path(arguments.plot, KINDS[scene.kind].animated) if arguments.plot else None
    log = new_log(arguments.out) if arguments.out else None

    from bearing_twin.command.terminal import in_shown_units, progress, say
    from bearing_twin.run.scene import late_keys
    from bearing_twin.run.simulation import cost_of, simulate

    large = cost_of(scene).sentence(bool(log), shutil.disk_usage(log.parent).free if log else math.inf)
    if large:
        say(in_shown_units(f"{scene.name}: {large}"))
    with progress(f"simulating {scene.name}") as update:
        with progress(f"preparing {scene.name}; its kernels are compiled the first time on a machine"):
            run = simulate(scene, update, begun)
            for warning in (*late_keys(scene, scene.parameters.run.duration), *run.choice.warnings):
                say(in_shown_units(f"{scene.name}: {warning}"))
            compile_seconds = run.simulation.warm_up()
        drawing = ShownStream(run, bool(picture))
        incomplete, failure = ended(drawing, log, max_loss)
    problems = [incomplete] if incomplete else []
    if failure is not None:
        problems.append(failure_kept(failure, log.parent if log else Path()))
        if run.simulation.sequence < 0:  # nothing came before it
            raise BearingTwinError("; ".join(problems)) from failure
    report = run.report
    result = report.as_dict() | {"compile_s": compile_seconds} | ({"log": str(log)} if log and not incomplete else {})
    if picture:
        try:
            result["plot"] = drawing.write(picture, report)
        except BearingTwinError as error:  # the figures may be those of hours
            problems.append(str(error))
    return Outcome(result, list(report.flags) if report.failure else doubts_of(result), problem="; ".join(problems))


def _log_argument(parser):
    parser.add_argument("log", metavar="LOG", help="an MCAP log")


def _samples_arguments(parser):
    _log_argument(parser)
    parser.add_argument("--topic", metavar="TOPIC", help="of a log of several bearings: the samples of one of them")


def _verify_arguments(parser):
    _samples_arguments(parser)
    what = "simulated at most where a log begins late or has gaps; without it, what is long is refused"
    parser.add_argument("--before", type=quantity("s"), metavar="SECONDS", help=what)


def _verify(arguments) -> Outcome:
    from bearing_twin.command.terminal import progress, show_result
    from bearing_twin.log.run_log import read_log
    from bearing_twin.log.study_log import is_study
    from bearing_twin.run.verify import verify

    if is_study(arguments.log):
        raise LogError("that is the log of a study, and runs alone are verified; report and study --resume read it")
    with progress("simulating the scene of the log again") as update:
        log = read_log(arguments.log, allow_gaps=True, topic=arguments.topic, last_run=True)
        if log.restart:
            raise LogError(f"the run in this log {log.restart}; verify the log of one run")
        verification = verify(log, lambda time: update(time / log.seconds), _before_the_log, arguments.before)
    kept = {"kept_outputs_hz": log.kept_rate} if log.kept_rate else {}
    result = {"log": str(arguments.log)} | verification.as_dict() | kept
    off = verification.differences()
    count = f"{len(verification.deviations)}, {f'{len(off)} not the same' if off else 'all the same'}"
    hidden = {"deviations", "records_not_as_many", *(("greatest_deviation",) if off else ())}  # each of them is shown
    shown = {key: value for key, value in result.items() if key not in hidden} | {"channels": count}
    shown |= {"deviation of": off} if off else {}
    return Outcome(result, log.notes + verification.doubts(), lambda: show_result(shown))


@contextlib.contextmanager
def _before_the_log(seconds: float):
    from bearing_twin.command.terminal import progress, say

    say(f"the log begins at {seconds:.6g} s: the run up to there is simulated first, and compared with nothing")
    with progress(f"simulating the {seconds:.6g} s before the log") as update:
        yield update


def _report_arguments(parser):
    _samples_arguments(parser)
    parser.add_argument("--plot", metavar="PNG", help="draw the ball loads")


def _report(arguments) -> Outcome:
    from bearing_twin.command.terminal import with_progress
    from bearing_twin.log.run_log import read_log
    from bearing_twin.log.study_log import STUDY_RECORD
    from bearing_twin.run.report import report_of

    picture = picture_path(arguments.plot) if arguments.plot else None
    stream = read_log(arguments.log, allow_gaps=True, topic=arguments.topic, last_run=True)
    if STUDY_RECORD in stream.metadata:
        return study_command.report(arguments.log, picture)
    watched = ShownStream(stream, bool(picture))
    report, missing = report_of(stream, with_progress(watched.blocks(), stream.seconds, f"reading {stream.path}"))
    result = report.as_dict() | {"log": str(arguments.log), "missing_outputs": missing, **stream.losses}
    if stream.kept_rate:
        result["kept_outputs_hz"] = stream.kept_rate
    result |= stream.cut_short.as_dict() if stream.cut_short else {}
    if picture:
        result["plot"] = watched.write(picture, report)
    result |= {"messages_foreign": sum(stream.foreign.values())} if stream.foreign else {}
    doubts = stream.notes + ([stream.restart.told()] if stream.restart else [])
    doubts += [f"{missing} outputs are missing from the log"] if missing else []
    doubts += [stream.cut_short.told()] if stream.cut_short else []
    lost = {
        "messages_lost": "were lost on the way to the recorder",
        "messages_dropped": "were dropped on a full disk",
        "messages_unreadable": "are not read: sent as samples and none, or too large",
    }
    doubts += [f"{result[key]} messages {words}" for key, words in lost.items() if result.get(key)]
    if stream.kept_rate:
        doubts.append(
            f"the log holds {stream.kept_rate:g} outputs a second, not all: greatest and mean values are of those, and "
            "`verify` compares no others; a node logs all of them without full:=false"
        )
    return Outcome(result, doubts + doubts_of(result))


def _recover_arguments(parser):
    _log_argument(parser)
    parser.add_argument("out", metavar="OUT", help="the log to write what can be read into")


def _recover(arguments) -> Outcome:
    from bearing_twin.command.terminal import progress
    from bearing_twin.log.recover import recover

    with progress(f"reading what is left of {arguments.log}"):
        recovered = recover(arguments.log, new_log(arguments.out, arguments.log))
    return Outcome({"log": str(arguments.out)} | recovered._asdict(), list(recovered.problems))


COMMANDS = {
    "simulate": Subcommand(
        "integrate a scene, faster than real time",
        _simulate_arguments,
        _simulate,
        (
            "bearing_twin simulate bearing_6203",
            "bearing_twin simulate 6308 --set geometry.radial_clearance=-5e-6",
            "bearing_twin simulate bearing_6203_loose --out run.mcap --plot run.png",
        ),
    ),
    "verify": Subcommand(
        "simulate the scene of a log again and compare every number",
        _verify_arguments,
        _verify,
        ("bearing_twin verify run.mcap",),
    ),
    "report": Subcommand(
        "the figures of a log, of a run or of a study, without simulating",
        _report_arguments,
        _report,
        ("bearing_twin report run.mcap", "bearing_twin report run.mcap --plot run.png --json"),
    ),
    "recover": Subcommand(
        "copy what can be read of a damaged log into a new one",
        _recover_arguments,
        _recover,
        ("bearing_twin recover cut.mcap saved.mcap",),
    ),
    "export": _of(export_command),
    "explain": _of(explain_command),
    "chart": _of(chart_command),
    "compile": scene_commands.COMPILE,
    "contact": _of(contact_command),
    "bearing": _of(bearing_command),
    "study": _of(study_command),
    "node": node_command.NODE,
    "topics": scene_commands.TOPICS,
    "view": view_commands.VIEW,
    "layouts": view_commands.LAYOUTS,
    "watch": node_command.WATCH,
    "scenes": scene_commands.SCENES,
    "completion": scene_commands.COMPLETION,
}
