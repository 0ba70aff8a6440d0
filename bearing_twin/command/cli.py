"""The command line: a result goes to standard output, as text or with --json as one JSON object.

Progress, warnings and errors go to standard error.

Exit code 0: done; 2: bad input, said in one sentence; 3: done, but with a loss or outside validity, with --strict;
130: interrupted; 143 and 129: ended by SIGTERM and SIGHUP.
"""

import argparse
import contextlib
import os
import re
import signal
import sys
import textwrap
from typing import NoReturn

from bearing_twin import __version__
from bearing_twin.base.errors import (
    BearingTwinError,
    echo,
    escape_controls,
    import_optional,
    legal_hint,
    missing_package,
)
from bearing_twin.base.process import (
    exit_process,
    limit_blas_threads,
    name_standard_output,
    prepare_streams,
    relax_garbage_collection,
    run_while_read,
    signal_of,
    signals_as_exceptions,
)

_NEGATIVE = re.compile(r"-([\d.,]|$)")
DONE, BAD_INPUT, DOUBTFUL, INTERRUPTED = 0, 2, 3, 130
KEYS_OF_OPTIONS = {  # options of other commands: what sets the same in a scene
    "--load": "rings.inner.load=0,-2kN,0",
    "--speed": "drive.speed=3000rpm",
    "--clearance": "geometry.radial_clearance=10um",
}
COMPLETING = "_ARGCOMPLETE"  # the shell sets it where it wants completions
REMOVED = {  # commands, options and words of earlier versions: what there is in their place
    "completion": 'type eval "$(register-python-argcomplete bearing_twin)" in the shell instead',
    "--markdown": "docs/topics.md has these tables",
    "--before": "verify simulates from the start to where the log begins, however long that takes",
    "--max-loss": "use bearing_twin.write_log(run, path, max_loss=...) in Python",
    "--mp4": "give --gif FILE.gif",
    "--shapes": "simulate the scene; all laws at its curvatures: --curvature-small and --curvature-large",
    "rerun": "open the log itself, as rerun run.mcap",
    "--schema": "bearing_twin scenes --keys lists every key with its limits",
    "--read": "read the CSV files that chart writes",
}
WARNINGS_SHOWN = 3  # warnings without --verbose


class _Help(argparse.RawDescriptionHelpFormatter):
    """Examples as they stand, within 80 columns."""

    def __init__(self, prog):
        super().__init__(prog, max_help_position=26, width=80)


class _Parser(argparse.ArgumentParser):
    def parse_known_args(self, args=None, namespace=None):
        return super().parse_known_args(_join_negative_values(sys.argv[1:] if args is None else args), namespace)

    def _check_value(self, action, value):
        if action.choices is None or value in action.choices:
            return
        if value in REMOVED:
            raise BearingTwinError(f"{value} was removed: {REMOVED[value]}")
        name = "/".join(action.option_strings) or action.metavar or action.dest
        raise BearingTwinError(f"{name} {echo(value)} is not known; {legal_hint(value, action.choices)}")

    def error(self, message):
        raise BearingTwinError(f"{message}; see {self.prog} --help")


def program() -> NoReturn:
    """The executable: `main`, after which the process ends at once."""
    prepare_streams()
    relax_garbage_collection()
    os.environ["MPLBACKEND"] = "agg"  # pictures go to files; a notebook's shell names one that need not be there
    sys.stdout.reconfigure(errors="backslashreplace")  # a terminal without µ
    try:
        code = main()
    except SystemExit as end:  # --help, or a signal
        code = end.code or DONE
    exit_process(code)


def main(argv=None) -> int:
    """Run one subcommand and return the exit code; never a traceback for what a user can cause."""
    limit_blas_threads()
    return run_while_read(lambda: _exit_code(sys.argv[1:] if argv is None else list(argv)))


def _exit_code(argv) -> int:
    """The exit code, with one sentence for what a user can cause."""
    try:
        with signals_as_exceptions():
            return _main(argv)
    except BearingTwinError as error:
        print(f"bearing_twin: {escape_controls(str(error))}", file=sys.stderr)
        return BAD_INPUT
    except ModuleNotFoundError as error:
        print(f"bearing_twin: {missing_package(error)}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("bearing_twin: interrupted", file=sys.stderr)
        return INTERRUPTED
    except SystemExit as end:
        number = signal_of(end)
        if number in (signal.SIGTERM, signal.SIGHUP):
            with contextlib.suppress(OSError):  # the terminal may be gone
                print(f"bearing_twin: ended by {signal.Signals(number).name}", file=sys.stderr)
        raise
    except BrokenPipeError:
        raise  # see `run_while_read`
    except OSError as error:
        print(f"bearing_twin: {error.filename or 'a file'} cannot be used ({error.strerror or error})", file=sys.stderr)
        return BAD_INPUT


def _main(argv) -> int:
    # Late: a signal meanwhile finds its handler.
    from bearing_twin.command.commands import COMMANDS

    if argv[:1] == ["help"]:
        argv = [*argv[1:2], "--help"]
    command = next((argument for argument in argv if not argument.startswith("-")), None)
    parser, subparsers = parsers(None if COMPLETING in os.environ else command)
    if COMPLETING in os.environ:
        import_optional("argcomplete", "completion").autocomplete(parser)  # ends the program
    if not argv:
        parser.print_help(sys.stderr)
        return BAD_INPUT
    if command is not None and command not in COMMANDS:
        if command in REMOVED:
            raise BearingTwinError(f"{command} was removed: {REMOVED[command]}")
        raise BearingTwinError(f"{echo(command)} is not a subcommand; {legal_hint(command, COMMANDS)}")
    arguments, unknown_arguments = parser.parse_known_args(argv)
    if unknown_arguments:
        _refuse_unknown(unknown_arguments, subparsers[arguments.command])
    _refuse_empty(arguments, subparsers[arguments.command])
    from bearing_twin.command.outcome import FORCE
    from bearing_twin.command.terminal import SI, in_shown_units

    units, force = SI.set(arguments.si or arguments.json), FORCE.set(arguments.force)
    try:
        outcome = COMMANDS[arguments.command].run(arguments)
        _present(outcome, arguments)
        if outcome.problem:
            raise BearingTwinError(in_shown_units(outcome.problem))
    finally:
        SI.reset(units)
        FORCE.reset(force)
    return DOUBTFUL if outcome.warnings and arguments.strict else DONE


def _present(outcome, arguments) -> None:
    """Print the result on standard output and the warnings on standard error."""
    from bearing_twin.command.terminal import in_shown_units

    with name_standard_output():
        if outcome.result is None:
            pass  # it was printed as it came
        elif arguments.json:
            from bearing_twin.base.report import json_text

            sys.stdout.write(json_text(outcome.result) + "\n")
        else:
            _show(outcome, arguments.si)
        sys.stdout.flush()
    warnings = [f"bearing_twin: warning: {escape_controls(in_shown_units(warning))}" for warning in outcome.warnings]
    complete = arguments.json or getattr(arguments, "verbose", True)  # commands without --verbose show all
    for line in warnings if complete else _first_warnings(warnings):
        print(line, file=sys.stderr)


def _first_warnings(warnings: list[str]) -> list[str]:
    """The first of the warnings, and how many more there are."""
    omitted = len(warnings) - WARNINGS_SHOWN
    return warnings if omitted <= 0 else [*warnings[:WARNINGS_SHOWN], f"bearing_twin: {omitted} more with --verbose"]


def _show(outcome, si: bool) -> None:
    if outcome.show and not (si and outcome.engineering):
        outcome.show()
        return
    from bearing_twin.base.report import json_data
    from bearing_twin.command.results import show_result

    show_result(json_data(outcome.result))


def parsers(only: str | None = None):
    """The parser and those of its commands by name; with `only` one, the others know no arguments."""
    from bearing_twin.command.commands import COMMANDS

    parser = _Parser(prog="bearing_twin", description="Digital twin of a ball bearing.", allow_abbrev=False)
    parser.add_argument("--version", action="version", version=f"bearing_twin {__version__}")
    group = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    subparsers = {}
    for name, command in COMMANDS.items():
        sub = group.add_parser(
            name,
            help=command.help,
            description=textwrap.fill(command.help, 78),
            formatter_class=_Help,
            allow_abbrev=False,
        )
        subparsers[name] = sub
        if only not in (None, name):
            continue
        command.arguments(sub)
        examples = "\n  ".join(["examples:", *command.examples])
        sub.epilog = "\n\n".join(part for part in (sub.epilog, examples) if part)
        sub.add_argument("--json", action="store_true", help="print the result as one JSON object, in SI units")
        sub.add_argument("--si", action="store_true", help="print tables in SI units instead of engineering units")
        sub.add_argument("--force", action="store_true", help="replace files that exist")
        sub.add_argument("--strict", action="store_true", help="exit with 3 if the result is doubtful or incomplete")
    return parser, subparsers


def _join_negative_values(argv) -> list[str]:
    """The words with values that begin with a minus, such as -,-1000,0 or -1e-3, tied to the option before them."""
    joined = []
    for argument in argv:
        if joined and joined[-1].startswith("--") and "=" not in joined[-1] and _NEGATIVE.match(argument):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


def _refuse_empty(arguments, subparser):
    """A path of no letters would be passed over, or be the folder itself: a script's variable has no value."""
    for action in subparser._actions:
        if getattr(arguments, action.dest, None) == "" and action.default != "":
            name = "/".join(action.option_strings) or action.metavar or action.dest
            advice = ", or leave it out" if action.option_strings else ""
            raise BearingTwinError(f"{name} is empty; give it a value{advice}")


def _refuse_unknown(unknown_arguments, subparser):
    if not unknown_arguments[0].startswith("-"):
        raise BearingTwinError(f"{echo(unknown_arguments[0])} is one word too many; see {subparser.prog} --help")
    options = [name for action in subparser._actions for name in action.option_strings if name.startswith("--")]
    option = unknown_arguments[0].partition("=")[0]  # without the value, which `_join_negative_values` tied to it
    if option in options:
        raise BearingTwinError(f"options go behind the command: {subparser.prog} ... {option}")
    if option in REMOVED:
        raise BearingTwinError(f"{option} was removed: {REMOVED[option]}")
    if option in KEYS_OF_OPTIONS and "--set" in options:
        raise BearingTwinError(
            f"{echo(option)} is not an option of {subparser.prog}; set a key of the scene "
            f"instead, as --set {KEYS_OF_OPTIONS[option]}"
        )
    raise BearingTwinError(f"{echo(option)} is not an option of {subparser.prog}; {legal_hint(option, options)}")
