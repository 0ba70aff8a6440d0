"""Results of subcommands, options that several of them share, and paths they may write to."""

import argparse
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from pathlib import Path
from typing import NamedTuple

from bearing_twin.base.errors import BearingTwinError, echo
from bearing_twin.base.parameters import read_number
from bearing_twin.base.units import NO_LIMITS, Limits
from bearing_twin.command.terminal import show_rows


class Outcome(NamedTuple):
    """The result of a subcommand: the JSON object (None: already printed), warnings, a function that shows it or None.

    `engineering`: `show` knows engineering units only; with --si the result is shown as tables. `problem`: a sentence
    on why there is no more of the result; the exit code is then that of bad input.
    """

    result: dict | None
    warnings: list[str]
    show: Callable[[], None] | None = None
    engineering: bool = False
    problem: str = ""


class Subcommand(NamedTuple):
    """One subcommand; `examples` are whole lines as one would type them."""

    help: str
    arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], Outcome]
    examples: tuple[str, ...] = ()


def run_warnings(result) -> list[str]:
    """Warnings about a run, from its report as plain data."""
    from bearing_twin.run.report import FAILED

    status = str(result.get("status", "done"))
    warnings = [str(flag) for flag in result.get("flags", ())]
    if status == "failed: energy":
        gained = result["energy_closure"]
        verb = "grew" if gained > 0.0 else "was lost"
        warnings.append(
            f"energy {verb} by {100 * abs(gained):.2g} % of the work: shorten the step or tighten the tolerance"
        )
    elif "failure" in result:
        warnings.append(f"the run failed {result['failure']}")
    elif status.startswith(FAILED):
        warnings.append(status)
    return warnings


ALLOW_INVALID = (
    "--allow-invalid",
    {
        "dest": "set",
        "action": "append_const",
        "const": "solver.allow_invalid=on",
        "help": "run a specified model outside its range too; the same as --set solver.allow_invalid=on",
    },
)


RUN = {
    "type": int,
    "metavar": "N",
    "help": "of a recording that holds several runs: the N-th, 1 being the first (default: the last)",
}


def add_changes(parser: argparse.ArgumentParser, text: str) -> None:
    """Adds `--set`, which changes what `text` says, and the option that lets models run outside their ranges."""
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=text)
    parser.add_argument(ALLOW_INVALID[0], **ALLOW_INVALID[1])


def add_verbose(parser: argparse.ArgumentParser) -> None:
    """Adds `--verbose`, which shows all that is known of a run, and `--plot-errors`, which draws its errors."""
    text = "with --plot: draw the errors of the figures by source, below loads and motion"
    parser.add_argument("--plot-errors", action="store_true", help=text)
    text = "show every column, why the model was chosen, costs, and errors of the model"
    parser.add_argument("--verbose", action="store_true", help=text)


def overrides_of(arguments: argparse.Namespace, **keys: str) -> list[str]:
    """Overrides by `--set`, and by options that stand for a key, such as duration="run.duration".

    Raises SceneError where a key is given two values.
    """
    from bearing_twin.run.scene import check_overrides

    options = {key: value for option, key in keys.items() if (value := getattr(arguments, option)) is not None}
    return list(check_overrides([*arguments.set, *(f"{key}={value}" for key, value in options.items())]))


def listed(noun: str, header: tuple[str, ...], rows: Iterable[dict]) -> Outcome:
    """A list as a result: all of each row as JSON, the columns of `header` as a table."""
    rows = list(rows)

    def show():
        show_rows(header, ([row[name] for name in header] for row in rows))

    return Outcome({noun: rows}, [], show)


def quantity(unit: str, limits: Limits | None = None, integer: bool = False) -> Callable[[str], float]:
    """The type of an option whose value is a number in `unit`, or one with its unit, as `5kN`.

    Without `limits` inf and nan pass.
    """

    def read(text: str) -> float:
        if limits is None and text.strip().lower().lstrip("+-") in ("inf", "nan"):
            return float(text)
        value, problem = read_number(text, unit, limits or NO_LIMITS, integer=integer)
        if problem:
            raise argparse.ArgumentTypeError(f"{echo(text)} {problem}")
        return value if integer else float(value)

    return read


def number(option: str, text: str, unit: str = "", limits: Limits = NO_LIMITS) -> float:
    """A number within the text of an option; raises BearingTwinError naming the legal numbers."""
    value, problem = read_number(text, unit, limits)
    if problem:
        raise BearingTwinError(f"{option} {echo(text)} {problem}")
    return value


FORCE: ContextVar[bool] = ContextVar("force", default=False)  # with --force files that exist are replaced


def refuse_existing(path: Path) -> None:
    """Raises BearingTwinError for a path that exists, except a file with --force: the rule of all commands."""
    if path.exists() and not (FORCE.get() and path.is_file()):
        raise BearingTwinError(f"{path} exists and is not overwritten; give another name, or --force to replace a file")


def new_file(text, source=None) -> Path:
    """A path without a file: with --force a file is removed, unless it is the `source` that is read."""
    path = Path(text)
    refuse_existing(path)
    if path.exists():
        if source and path.samefile(source):
            raise BearingTwinError(f"{path} is the file that is read; give another name")
        path.unlink()
    return path


def new_log(text: str | None, source=None) -> Path | None:
    """The path of a new log, None without one; raises BearingTwinError where it is unusable."""
    from bearing_twin.log.raw_log import refuse_existing as refuse_log

    if text is None:
        return None
    path = new_file(text, source)
    refuse_log(path)
    return path


def picture_path(text: str | None) -> Path | None:
    """The path of a new picture, None without one; raises BearingTwinError for an unusable path."""
    if text and Path(text).suffix.lower() == ".gif":
        raise BearingTwinError(
            f"{Path(text)}: a picture does not move; give a name that ends in .png, or animate a run by "
            "bearing_twin view RUN --gif FILE"
        )
    return new_path(text, (".png",), "picture")


def new_path(text: str | None, suffixes: tuple[str, ...], noun: str, replaced: bool = False) -> Path | None:
    """The path of a new file with one of these suffixes, None without one; raises BearingTwinError if it is unusable.

    A file that exists is refused without --force, unless the command documents that it is `replaced`.
    """
    if text is None:
        return None
    path = Path(text)
    if path.suffix.lower() not in suffixes:
        raise BearingTwinError(f"{path} is not the name of a {noun}; give one that ends in {suffixes[0]}")
    if not path.parent.is_dir():
        raise BearingTwinError(f"{path.parent} is not a folder; make it first, or give another path")
    if not (replaced and path.is_file()):
        refuse_existing(path)
    return path
