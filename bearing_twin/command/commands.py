"""The table of subcommands: arguments, function, examples. Imports are late, so that --help is quick."""

import math
import shutil
from functools import partial
from pathlib import Path

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.command import (
    bearing_command,
    chart_command,
    contact_command,
    log_commands,
    node_command,
    scene_commands,
    spectrum_command,
    study_command,
    view_commands,
)
from bearing_twin.command.bearing_command import note_bare_speed
from bearing_twin.command.log_commands import DrawnStream, run_to_end
from bearing_twin.command.outcome import (
    Outcome,
    Subcommand,
    add_changes,
    add_verbose,
    new_log,
    overrides_of,
    picture_path,
    quantity,
    run_warnings,
)
from bearing_twin.command.terminal import in_shown_units, progress, say


def _simulate_arguments(parser):
    parser.add_argument("scene", help="name of a scene (see `bearing_twin scenes`), path of a YAML file, or a log")
    add_changes(parser, "change one key of the scene; may be repeated")
    parser.add_argument("--duration", metavar="SECONDS", help="the same as --set run.duration=SECONDS")
    longer = "with a log: continue its run for so long from the state at its end; figures are those of the continuation"
    parser.add_argument("--continue", dest="more", type=quantity("s"), metavar="SECONDS", help=longer)
    parser.add_argument("--out", metavar="LOG", help="write the run to this MCAP log")
    parser.add_argument(
        "--plot",
        metavar="PNG",
        help="draw the ball loads, the impact or the motion",
    )
    add_verbose(parser)


def _simulate(arguments) -> Outcome:
    from bearing_twin.run.scene import load_scene

    overrides, start = overrides_of(arguments, duration="run.duration"), None
    if arguments.more is None:
        scene = load_scene(arguments.scene, overrides)
    else:
        if arguments.duration or not arguments.more > 0.0:
            raise BearingTwinError("--continue takes a time above 0, in place of --duration")
        from bearing_twin.log.run_log import read_log
        from bearing_twin.run.failure import continuation

        start = continuation(read_log(arguments.scene), arguments.more, overrides)
        scene = start.scene
    note_bare_speed(scene, overrides)
    picture = picture_path(arguments.plot)
    log = new_log(arguments.out)

    from bearing_twin.command.results import show_report
    from bearing_twin.run.failure import failure_sentence
    from bearing_twin.run.scene import unreached_keys
    from bearing_twin.run.simulation import cost_of, simulate

    large = cost_of(scene).sentence(bool(log), shutil.disk_usage(log.parent).free if log else math.inf)
    if large:
        say(in_shown_units(f"{scene.name}: {large}"))
    with progress(f"simulating {scene.name}") as update:
        run = simulate(scene, update, start)
        for warning in (*unreached_keys(scene, scene.parameters.run.duration), *run.choice.warnings):
            say(in_shown_units(f"{scene.name}: {warning}"))
        drawing = DrawnStream(run, bool(picture))
        incomplete, failure = run_to_end(drawing, log)
    problems = [incomplete] if incomplete else []
    if failure is not None:
        problems.append(failure_sentence(failure, log.parent if log else Path()))
        if run.simulation.sequence < 0:  # nothing came before it
            raise BearingTwinError("; ".join(problems)) from failure
    report = run.report
    result = report.as_dict() | ({"log": str(log)} if log and not incomplete else {})
    if picture:
        try:
            result["plot"] = drawing.write(picture, report, arguments.plot_errors)
        except BearingTwinError as error:  # the figures may be those of hours
            problems.append(str(error))
    warnings = list(report.flags) if report.failure else run_warnings(result)
    show = partial(show_report, report, result, arguments.verbose)
    return Outcome(result, warnings, show, problem="; ".join(problems))


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
    "verify": log_commands.VERIFY,
    "report": log_commands.REPORT,
    "recover": log_commands.RECOVER,
    "export": log_commands.EXPORT,
    "explain": log_commands.EXPLAIN,
    "chart": chart_command.CHART,
    "contact": contact_command.CONTACT,
    "bearing": bearing_command.BEARING,
    "spectrum": spectrum_command.SPECTRUM,
    "study": study_command.STUDY,
    "node": node_command.NODE,
    "topics": scene_commands.TOPICS,
    "view": view_commands.VIEW,
    "layouts": view_commands.LAYOUTS,
    "watch": view_commands.WATCH,
    "scenes": scene_commands.SCENES,
}
