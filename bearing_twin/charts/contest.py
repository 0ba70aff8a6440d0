"""The engine of all charts: problems, methods and their settings in; a table, a picture and sentences out.

A chart is a table of problems, each a row: a `Problem`, or a `scenes.SceneProblem`. Every run is a `Row`: its error
against a reference far tighter than what is judged, its CPU seconds, or why there is no result. A run that exceeds the
limit of CPU seconds is stopped. The table of a chart has the same columns for all, and says what its numbers were made
with. A paper is a chart whose parts are the sheets of its figures.
"""

import contextlib
import csv
import ctypes
import dataclasses
import datetime
import functools
import importlib.metadata
import itertools
import math
import platform
import signal
import subprocess
import time
import timeit
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin import __version__
from bearing_twin.base.errors import BearingTwinError, CoreError, SceneError, echo, legal_hint
from bearing_twin.base.paths import draft_file
from bearing_twin.base.units import prefixed_unit, two_digits
from bearing_twin.methods import STEPPER_FACTS
from bearing_twin.pictures import (
    STYLE,
    Axis,
    Line,
    Panel,
    Sheet,
    curves_of,
    figure_of,
    in_rows,
    legend_entries,
    line_style,
    save,
)

LIMIT = 60.0  # CPU seconds of a run unless the user says otherwise
LEAST_TIMED, REPEATS, LONG = 0.05, 3, 3.0  # CPU seconds and number of repeats of a timing; what takes LONG is done once
LEAST_ERROR, GREATEST_ERROR = 1e-12, 3.0  # of the axis of errors: smaller ones stand at its start, failures at its end
MOST_ENTRIES = 10  # entries of a common legend
WITHOUT_RESULT = ", no result"  # behind the name of a method
CROSS = {"marker": "x", "markersize": 9, "markeredgewidth": 2.5, "linestyle": ""}
HALF_DECADE = math.sqrt(10.0)
REQUESTED_STYLE = {"color": STYLE["soft"], "linewidth": 1.2, "linestyle": ":"}
DONE, REFUSED, FAILED, STOPPED = "done", "refused", "failed", "stopped"
MADE = "made"  # the last column: software with its commit, libraries, processor, day
LIBRARIES = "numpy", "scipy"


@dataclasses.dataclass(frozen=True)
class Row:
    """One run of a chart.

    `setting` is the number a method is tuned by (a tolerance, a step, a size), `across` a number that the problem is
    varied by; NaN where there is none. `error` is relative, infinite without a result. `seconds` are CPU seconds,
    `spread` the range of the middle half of their repeats over the median. `command` repeats the run.
    `more` holds further columns of the chart, by name with unit. The names of the fields are keys of `chart --json`.
    """

    problem: str
    method: str
    setting: float = math.nan
    across: float = math.nan
    error: float = math.inf
    seconds: float = math.nan
    spread: float = math.nan
    evaluations: float = math.nan
    status: str = FAILED
    reason: str = ""
    command: str = ""
    more: dict[str, Any] = dataclasses.field(default_factory=dict)

    def value(self, column: str) -> float:
        """A column of the table, also one of the chart's own."""
        return getattr(self, column) if column in COLUMNS else self.more[column]


COLUMNS = tuple(field.name for field in dataclasses.fields(Row) if field.name != "more")


def write_table(rows: Sequence[Row], path: Path) -> None:
    """Writes rows as comma-separated values; raises BearingTwinError where that is impossible."""
    further = list(dict.fromkeys(name for row in rows for name in row.more))
    header = [*COLUMNS, *further]
    write_rows(
        path,
        header,
        ([_cell(({**vars(row), **row.more}).get(name, "")) for name in header] for row in rows),
    )


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Iterable]) -> None:
    """Writes a header and rows with the column `made`, whole or not at all; raises BearingTwinError where it cannot."""
    try:
        with draft_file(path) as draft, draft.open("w", newline="", encoding="utf-8") as stream:
            table = csv.writer(stream)
            table.writerow([*header, MADE])
            table.writerows([*row, provenance()] for row in rows)
    except OSError as error:
        raise BearingTwinError(f"{path} cannot be written ({error.strerror}); give another folder") from error


def _cell(value: Any) -> Any:
    return f"{value:.9g}" if isinstance(value, float) else value


def processor() -> str:
    """The processor's name."""
    cpus = Path("/proc/cpuinfo")
    lines = cpus.read_text().splitlines() if cpus.exists() else ()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


@functools.cache
def provenance() -> str:
    """Software with its commit (a + where files differ from it), libraries, processor, and day."""
    root, commit = Path(__file__).parents[2], ""
    if (root / ".git").exists():
        git = ["git", "-C", str(root), "describe", "--always", "--dirty=+", "--exclude=*"]
        try:
            commit = " " + subprocess.run(git, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            commit = ""
    libraries = (f"{name} {importlib.metadata.version(name)}" for name in LIBRARIES)
    ours = f"bearing_twin {__version__}{commit}"
    return "; ".join([ours, *libraries, processor(), str(datetime.date.today())])


class Options(NamedTuple):
    """Options of a chart: problems by name (empty: all), progress, limit of CPU seconds of a run, size."""

    problems: tuple[str, ...] = ()
    update: Callable[[float], None] = lambda share: None
    limit: float = LIMIT
    quick: bool = False


class ChartFiles(NamedTuple):
    """A chart as files, the sentences that read it, and its rows."""

    reading: list[str]
    pictures: list[str]
    tables: list[str]
    rows: list[Row]


def selected_names(requested: Iterable[str], known: Iterable[str]) -> list[str]:
    """The requested names, in their order, all for none; raises BearingTwinError for one that is not known."""
    requested, known = set(requested), list(known)
    for name in requested - set(known):
        raise BearingTwinError(f"{echo(name)} is not a part of this chart; {legal_hint(name, known)}")
    return [name for name in known if not requested or name in requested]


class Stopped(BaseException):
    """A run has exceeded its limit of CPU seconds."""


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises Stopped within it after so many CPU seconds of this process; 0 = never.

    Where the system has no such clock (Windows) nothing is limited.
    """
    if not hasattr(signal, "setitimer") or not seconds:
        yield
        return

    passed = False

    def stop(*_):
        nonlocal passed
        passed = True
        raise Stopped

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    except ctypes.ArgumentError as error:  # of whatever is raised while ctypes converts an argument
        if passed:
            raise Stopped from error
        raise
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def timed(work: Callable[[], Any], times: float = 1.0) -> tuple[Any, dict[str, float]]:
    """The result of `work`; its CPU `seconds` over `times`, the median of repeats, and their `spread`.

    The first run may import, so that it counts only where it takes long.
    """
    start = time.process_time()
    result = work()
    first = time.process_time() - start
    if first > LONG:
        return result, {"seconds": first / times, "spread": math.nan}
    timer = timeit.Timer(work, timer=time.process_time)
    number = 1
    # Doubled, for with a limit set the clock may tick more coarsely than one run takes.
    while timer.timeit(number) < LEAST_TIMED:
        number *= 2
    low, middle, high = np.quantile(timer.repeat(REPEATS, number), (0.25, 0.5, 0.75)).tolist()
    return result, {"seconds": middle / number / times, "spread": (high - low) / middle if middle > 0.0 else math.nan}


def by_method(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Rows by method."""
    rows_by_method: dict[str, list[Row]] = {}
    for row in rows:
        rows_by_method.setdefault(row.method, []).append(row)
    return rows_by_method


def rows_of(rows: Iterable[Row], problem: str, *status: str) -> list[Row]:
    """The rows of a problem, of those with this status only where it is given."""
    return [row for row in rows if row.problem == problem and (not status or row.status in status)]


def cheapest(rows: Iterable[Row], requested_error: float) -> Row | None:
    """The cheapest of these runs within the requested error; None if there is none."""
    good = (row for row in rows if row.status == DONE and row.error <= requested_error)
    return min(good, key=lambda row: row.seconds, default=None)


class MethodStyle(NamedTuple):
    """Label of a method, and the number of its colour."""

    label: str
    colour: int


Styles = Mapping[str, MethodStyle]
PanelRows = list[list[Panel]]


def method_styles(rows: Iterable[Row], labels: Mapping[str, str]) -> Styles:
    """The style of each method: one with a label has the colour of its number among them, others have the free ones."""
    fixed = {method: MethodStyle(label, index) for index, (method, label) in enumerate(labels.items())}
    methods = by_method(rows)
    used = {style.colour for method, style in fixed.items() if method in methods}
    free = (index for index in itertools.count() if index not in used)
    return {method: fixed.get(method) or MethodStyle(method, next(free)) for method in methods}


def curve(name: str, index: int, points, failed_points=()) -> list[Line]:
    """A method in the colour of that number: a line through points (x, y), crosses at those without a result."""
    style = line_style(index)
    parts = [Line(name, *(np.reshape(points, (-1, 2)).T), style | {"marker": "o", "markersize": 5})]
    if failed_points:
        cross = {**CROSS, "color": style["color"]}
        parts.append(Line(name + WITHOUT_RESULT, *np.transpose(failed_points), cross, False))
    return parts


def curves(rows: Iterable[Row], styles: Styles, x, y, cross=None) -> list[Line]:
    """A curve a method through (x(row), y(row)) of its results, a cross at `cross(row)`, if given, for the others.

    Results whose y is NaN are left out, smaller ones than LEAST_ERROR raised.
    """
    parts = []
    for method, runs in by_method(rows).items():
        good = sorted(
            (x(row), max(y(row), LEAST_ERROR)) for row in runs if row.status == DONE and not math.isnan(y(row))
        )
        crosses = [cross(row) for row in runs if row.status != DONE] if cross else []
        parts += curve(*styles[method], good, crosses)
    return parts


def error_against_cost(contest: "Contest", rows: list[Row], styles: Styles) -> PanelRows:
    """A panel a problem: error across, CPU time up, crosses at the right edge where there is no result."""
    known = [row.error for row in rows if row.status == DONE and row.error > 0.0]
    least = max(LEAST_ERROR, min(known, default=LEAST_ERROR) / 3.0)
    beyond = 10.0 if any(row.status != DONE for row in rows) else 1.0
    edge = max(min(beyond * max(known, default=1.0), GREATEST_ERROR), contest.requested_error)
    across = Axis(contest.error, log=True, limits=(0.5 * least, 2.0 * edge))
    indices = {method: index for index, method in enumerate(styles)}

    def panel(title: str, runs: list[Row]) -> Panel:
        costs = [row.seconds for row in runs if row.seconds > 0.0] or [1.0]
        middle = math.sqrt(min(costs) * max(costs))  # at least a decade, so that noise does not look like a difference
        ends = min(0.8 * min(costs), middle / HALF_DECADE), max(1.25 * max(costs), middle * HALF_DECADE)
        parts = curves(
            runs,
            styles,
            lambda row: max(row.error, least),
            lambda row: row.seconds,
            lambda row: (edge, row.seconds if row.seconds > 0.0 else min(costs) * 1.3 ** indices[row.method]),
        )
        limit = Line(f"error of {contest.requested_error:g}", [contest.requested_error] * 2, ends, REQUESTED_STYLE)
        return Panel(title, across, Axis(contest.cost, "s", log=True, limits=ends), [*parts, limit])

    panels = [panel(*pair) for pair in contest.by_title(rows)]
    return in_rows(panels, 2 if len(panels) in (2, 4) else 3)


def panels_over(
    contest: "Contest", rows: list[Row], styles: Styles, across: Axis, columns: Mapping[str, Axis]
) -> PanelRows:
    """A row of panels a problem: columns of the rows, by name with their axis, over `across`."""

    def panel(title: str, runs: list[Row], column: str, up: Axis) -> Panel:
        cross = None if column == "seconds" else lambda row: (row.across, 1.0)
        return Panel(
            title, across, up, curves(runs, styles, lambda row: row.across, lambda row: row.value(column), cross)
        )

    return [[panel(*pair, *column) for column in columns.items()] for pair in contest.by_title(rows)]


def cost_comparison(contest: "Contest", rows: list[Row]) -> list[str]:
    """Which methods have the requested error, their CPU time over the least of each problem, and these least times."""
    shares: dict[str, list[float]] = {}
    never: dict[str, list[str]] = {}
    least = []
    for title, runs in contest.by_title(rows):
        groups = by_method(runs)
        best = {method: cheapest(group, contest.requested_error) for method, group in groups.items()}
        costs = {method: row.seconds for method, row in best.items() if row}
        if costs:
            least.append(f"{title} {time_text(min(costs.values()))}")
        for method in groups:
            if method in costs:
                shares.setdefault(method, []).append(costs[method] / min(costs.values()))
            else:
                never.setdefault(method, []).append(title)
    condition = f" for errors up to {contest.requested_error:g}" if math.isfinite(contest.requested_error) else ""
    ratios = (
        f"{method} {range_text(method_shares)}"
        for method, method_shares in sorted(shares.items(), key=lambda pair: max(pair[1]))
    )
    sentences = (
        [f"{contest.cost}{condition}, relative to the least of each problem: {'; '.join(ratios)}."] if shares else []
    )
    sentences += [f"The least: {'; '.join(least)}."] if least else []
    return sentences + ([f"Not accurate enough at any setting: {with_problems(never)}."] if never else [])


def time_text(value: float) -> str:
    """A time in words, two digits."""
    factor, unit = prefixed_unit(value, "s")
    return f"{two_digits(factor * value)} {unit}"


def range_text(values: Sequence[float]) -> str:
    """The least and the greatest of some numbers in words, two digits."""
    return " to ".join(dict.fromkeys((two_digits(min(values)), two_digits(max(values)))))


def with_problems(titles: Mapping[str, Sequence[str]]) -> str:
    """Methods in words, each with the problems that it stands with."""
    return "; ".join(f"{method} ({'; '.join(titles_of_method)})" for method, titles_of_method in titles.items())


def confirmation(rows: Iterable[Row], reference_methods: Iterable[str]) -> list[str]:
    """A sentence on how near methods other than the `reference_methods` come to the references."""
    nearest: dict[str, float] = {}
    for row in rows if reference_methods else ():
        if row.method not in reference_methods and row.status == DONE:
            nearest[row.problem] = min(row.error, nearest.get(row.problem, math.inf))
    worst = max(nearest.values(), default=0.0)
    return [f"Methods of other families confirm the references within {worst:.1g}."] if nearest else []


def failure_sentences(contest: "Contest", rows: Iterable[Row]) -> list[str]:
    """A sentence on the runs that failed or were stopped; what is refused is in the picture alone."""
    lost: dict[str, list[str]] = {}
    for title, runs in contest.by_title(rows, FAILED, STOPPED):
        for method in by_method(runs):
            lost.setdefault(method, []).append(title)
    return [f"Failed or stopped at some settings: {with_problems(lost)}."] if lost else []


class Problem(NamedTuple):
    """A problem of a chart.

    `entries(quick)` gives methods with setting and across. `judge(method, setting, across)` gives error, seconds, ...
    and further columns by name; it raises BearingTwinError where there is no result.
    """

    title: str
    entries: Callable[[bool], Iterable[tuple[str, float, float]]]
    judge: Callable[[str, float, float], dict[str, Any]]

    def command(self, method: str, setting: float, across: float) -> str:
        """The command that repeats a run: none."""
        return ""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Contest:
    """A chart of runs.

    `problems` by name: each a `Problem`, or what has its attributes. `panels(contest, rows, styles)` draws the rows,
    `read(contest, rows)` says what they show. `labels` are names of methods in the picture, and their order is that of
    the colours. Costs are compared at `requested_error`; `reference_methods` are those of the reference's own family.
    """

    title: str
    problems: Mapping[str, Any]
    panels: Callable[["Contest", list[Row], Styles], PanelRows] = error_against_cost
    read: Callable[["Contest", list[Row]], Iterable[str]] = cost_comparison
    labels: Mapping[str, str] = dataclasses.field(default_factory=lambda: {name: name for name in STEPPER_FACTS})
    error: str = "relative error"
    cost: str = "CPU time of a run"
    requested_error: float = 1e-3
    reference_methods: tuple[str, ...] = ()

    def by_title(self, rows: Iterable[Row], *status: str) -> list[tuple[str, list[Row]]]:
        """The title and the rows of each problem that has rows, as of `rows_of`."""
        rows = list(rows)
        pairs = ((problem.title, rows_of(rows, name, *status)) for name, problem in self.problems.items())
        return [pair for pair in pairs if pair[1]]

    def run(self, name: str, *entry, limit: float = 0.0) -> Row:
        """One run of a problem as a row, also where it fails; raises CoreError where nothing can run."""
        problem = self.problems[name]
        row = Row(name, *entry, command=problem.command(*entry))
        try:
            with limited(limit), np.errstate(all="ignore"):
                measured = problem.judge(*entry)
        except CoreError:
            raise
        except SceneError as error:
            return dataclasses.replace(row, status=REFUSED, reason=str(error))
        except Stopped:
            reason = f"stopped after {limit:g} CPU seconds"
            return dataclasses.replace(row, status=STOPPED, seconds=limit, reason=reason)
        except (BearingTwinError, ArithmeticError, ValueError) as error:
            return dataclasses.replace(row, status=FAILED, reason=str(error) or type(error).__name__)
        columns = {name: measured.pop(name) for name in COLUMNS if name in measured}
        if not math.isfinite(columns["error"]):
            columns |= {"error": math.inf, "status": FAILED, "reason": columns.get("reason", "not finite")}
        return dataclasses.replace(row, **{"status": DONE, **columns}, more=measured)

    def measure(self, options: Options) -> list[Row]:
        """All runs, problem by problem and method by method."""
        names = selected_names(options.problems, self.problems)
        tasks = [(name, *entry) for name in names for entry in self.problems[name].entries(options.quick)]
        rows = []
        for task in tasks:
            rows.append(self.run(*task, limit=options.limit))
            options.update(len(rows) / len(tasks))
        return rows

    def sheet(self, rows: list[Row]) -> Sheet:
        """The picture of rows."""
        panels = self.panels(self, rows, method_styles(rows, self.labels))
        crosses = any(part.name.endswith(WITHOUT_RESULT) for line in panels for panel in line for part in panel.parts)
        sheet = Sheet(self.title, panels, "crosses: no result" if crosses else "", [])
        sheet.shared_legend = len(legend_entries(sheet)) <= MOST_ENTRIES
        return sheet

    def reading(self, rows: list[Row]) -> list[str]:
        """Sentences that read the rows."""
        return [
            *self.read(self, rows),
            *confirmation(rows, self.reference_methods),
            *failure_sentences(self, rows),
        ]

    def files(self, folder: Path, name: str, options: Options) -> list[Path]:
        """Picture and table."""
        return [folder / f"{name}.png", folder / f"{name}.csv"]

    def make(self, folder: Path, name: str, options: Options) -> ChartFiles:
        """Runs the chart and writes picture and table."""
        rows = self.measure(options)
        picture, table = self.files(folder, name, options)
        write_table(rows, table)
        save(figure_of(self.sheet(rows), provenance()), picture)
        return ChartFiles(self.reading(rows), [str(picture)], [str(table)], rows)


def write_curves(sheet: Sheet, path: Path) -> None:
    """Every curve as comma-separated values, SI; raises BearingTwinError where that is impossible."""
    rows = (
        (panel.title, name, *(f"{axis.name} [{axis.unit}]" for axis in (panel.x, panel.y)), f"{x:.10g}", f"{y:.10g}")
        for line in sheet.rows
        for panel in line
        for part in panel.parts
        for name, across, up in curves_of(part)
        for x, y in zip(across, up, strict=True)
    )
    write_rows(path, ["panel", "curve", "x_is", "y_is", "x", "y"], rows)


class Figures(NamedTuple):
    """A sheet: the figures of the paper on it, and the function that makes it; `make(quick)` is coarse if quick."""

    figures: tuple[int, ...]
    make: Callable[[bool], Sheet]


@dataclasses.dataclass(frozen=True)
class Paper:
    """The sheets of a paper by name; a sheet is also found by the number of a figure on it."""

    sheets: dict[str, Figures]

    @property
    def problems(self) -> dict[str, str]:
        """Names of sheets and numbers of figures, with the sheet they stand on."""
        numbers = {str(figure): name for name, row in self.sheets.items() for figure in row.figures}
        return {name: name for name in self.sheets} | numbers

    def selected(self, options: Options) -> list[str]:
        """The requested sheets; raises BearingTwinError for an unknown one."""
        return [*dict.fromkeys(self.problems[name] for name in selected_names(options.problems, self.problems))]

    def files(self, folder: Path, name: str, options: Options) -> list[Path]:
        """Picture, table of curves and sentences of each requested sheet."""
        return [
            folder / f"{name}_{part}.{ending}" for part in self.selected(options) for ending in ("png", "csv", "txt")
        ]

    def make(self, folder: Path, name: str, options: Options) -> ChartFiles:
        """Draws the requested sheets: picture, table of curves and sentences of each."""
        made, parts = ChartFiles([], [], [], []), self.selected(options)
        paths = iter(self.files(folder, name, options))
        for index, name_of_sheet in enumerate(parts, start=1):
            sheet = self.sheets[name_of_sheet].make(options.quick)
            picture, table, reading = next(paths), next(paths), next(paths)
            write_curves(sheet, table)
            reading.write_text("".join(f"{sentence}\n" for sentence in sheet.reading), encoding="utf-8")
            made.pictures.append(str(save(figure_of(sheet, provenance()), picture)))
            made.tables.append(str(table))
            made.reading.extend(sheet.reading)
            options.update(index / len(parts))
        return made
