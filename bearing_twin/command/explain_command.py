"""`explain`: why models of a scene were chosen; what made a run fail, and how it continues at a tighter tolerance."""

import argparse
from pathlib import Path

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.units import Limits
from bearing_twin.command.log_commands import ShownStream, ended
from bearing_twin.command.outcome import Outcome, new_log, number
from bearing_twin.command.terminal import progress, show_rows, show_text

HELP = "why a scene gets its models; what made a run fail, which then continues at a tighter tolerance"
EXAMPLES = (
    "bearing_twin explain bearing_6203",
    "bearing_twin explain failure_20261122_101500.json",
    "bearing_twin explain failure.json --tolerance 1e-6 --out on.mcap",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `explain` to its parser."""
    parser.add_argument(
        "failure", metavar="SCENE|FILE", help="a scene, or the file that a failed run left, failure_<date>_<time>.json"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="of a scene: change one of its keys"
    )
    parser.add_argument("--tolerance", metavar="SHARE", help="wanted.tolerance to go on with; a tenth by default")
    parser.add_argument(
        "--until", metavar="SECONDS", help="where to end; by default where the scene ends, or as much after the failure"
    )
    parser.add_argument("--out", metavar="LOG", help="write what follows to this MCAP log")
    parser.add_argument("--stop", action="store_true", help="only say what happened")


def run(arguments: argparse.Namespace) -> Outcome:
    """The reasons for a scene's models; of a failure, its cause, and a run that continues."""
    from bearing_twin.run.failure import read_failure, shortened

    if not arguments.failure.endswith(".json"):
        return _reasons(arguments)
    if (path := Path(arguments.failure)).exists() and not path.is_file():
        raise BearingTwinError(f"{path} is no file; give the one that a failed run left")
    failure = read_failure(arguments.failure)
    log = new_log(arguments.out) if arguments.out else None
    given, ends = arguments.tolerance, arguments.until
    tolerance = None if given is None else number("--tolerance", given, "1", Limits(above=0.0, below=1.0))
    until = None if ends is None else number("--until", ends, "1", Limits(above=0.0, at_most=1e6))
    result = {
        "failure": failure.sentence,
        "reason": failure.reason or "unknown",
        "at_s": failure.seconds,
        "body": failure.body or "unknown",
        "contact": failure.contact or "unknown",
        "last_good_s": failure.good_seconds,
        "last_good": {name: value for name, value, _ in failure.about_body()},
    }
    warnings, incomplete = [], ""
    if not arguments.stop:
        scene = failure.tightened(tolerance)
        continued, warnings, incomplete = _continued(failure, shortened(scene, _end(failure, scene, until)), log)
        result |= continued
    return Outcome(result, warnings, lambda: _show(result, failure), problem=incomplete)


def _reasons(arguments: argparse.Namespace) -> Outcome:
    """The rules that applied to a scene, by key, and the warnings of its choice."""
    from bearing_twin.kinds.rules import answers
    from bearing_twin.run.scene import choose, load_scene

    scene = load_scene(arguments.failure, arguments.set)
    warnings = choose(scene).warnings
    rows = [
        {
            "key": key,
            "value": one.value,
            "why": one.sentence,
            "when": one.rule.when if one.rule else "the scene specifies it",
        }
        for key, one in answers(scene.kind, scene.parameters).items()
    ]

    def show():
        show_rows(
            ("key", "value", "because", "rule"),
            ((one["key"], str(one["value"]), one["why"], one["when"]) for one in rows),
        )

    return Outcome({"scene": scene.name, "choices": rows, "warnings": list(warnings)}, list(warnings), show)


def _end(failure, scene, until: float | None) -> float:
    """End of the run [s]: a node may have failed beyond the end of its scene."""
    duration, begin = scene.parameters.run.duration, _begin(failure, scene)
    if until is not None and until <= begin:
        raise BearingTwinError(f"--until {until:g} must be later than {begin:.9g} s, where the run goes on")
    return until or (duration if duration > begin else begin + duration)


def _begin(failure, scene) -> float:
    return max(failure.sequence, 0) * 1e-9 * scene.output_period_ns


def _continued(failure, scene, log) -> tuple[dict, list[str], str]:
    """Result, warnings, and the reason why the log is incomplete."""
    from bearing_twin.run.failure import write_failure
    from bearing_twin.run.simulation import simulate

    again = ""
    with progress(f"going on with {scene.name}") as update:
        run = simulate(scene, update, failure)
        incomplete, broken = ended(ShownStream(run), log)
        if broken is not None:
            left = write_failure(broken, log.parent if log else Path())
            again = f"it fails again {broken}" + (f"; see bearing_twin explain {left}" if left else "")
    report = None if again else run.report
    wanted, solver = (getattr(scene.parameters, name, None) for name in ("wanted", "solver"))
    continued = {
        "continued_from_s": _begin(failure, scene),
        "continued_to_s": 1e-9 * max(run.simulation.time_ns, 0),
        "tolerance": getattr(wanted, "tolerance", None),
        "step_s": getattr(solver, "step", None),
        "status": again or report.status,
        **({"log": str(log)} if log and not (again or incomplete) else {}),
    }
    warnings = [again] if again else [*report.flags, *([report.status] if report.status != "done" else [])]
    return continued, warnings, incomplete


def _show(result, failure) -> None:
    from bearing_twin.command.results import show_result

    show_result({key: value for key, value in result.items() if key != "last_good"})
    if failure.values:
        show_text(f"\nlast good output, {failure.good_seconds:.9g} s, {failure.body or 'all bodies'}:")
        show_rows(
            ("channel", "value", "unit"), ((name, f"{value:.6g}", unit) for name, value, unit in failure.about_body())
        )
