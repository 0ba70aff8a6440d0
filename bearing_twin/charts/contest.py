"""The engine of all charts: problems, methods and their settings in; a table, a picture and sentences out.

A chart is a table of problems, each a row. Every run is a `Row`: its error against a reference far tighter than what is
judged, its CPU seconds, or why there is no result. A run that exceeds the limit of CPU seconds is stopped. A paper is a
chart whose parts are the sheets of its figures.
"""

import contextlib
import dataclasses
import math
import signal
import time
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, CoreError, SceneError
from bearing_twin.base.parameters import echo, unknown
from bearing_twin.base.units import prefixed, two_digits
from bearing_twin.charts.panels import NO_RESULT, Axis, Line, Panel, Sheet, curve, draw, labels, write_curves
from bearing_twin.charts.rows import DONE, FAILED, REFUSED, STOPPED, Row, read_table, write_table
from bearing_twin.pictures import STYLE

LIMIT = 60.0  # CPU seconds of a run unless the user says otherwise
ENOUGH, REPEATS, LONG = 0.15, 3, 3.0  # CPU seconds and repeats of a timing; what takes LONG is done once
UNSURE = 0.1  # spread of a cost beyond which it is reported
LEAST, GREATEST = 1e-12, 3.0  # of the axis of errors: smaller ones stand at its start, failures at its end
MOST = 10  # entries of a common legend
OWN = ("error", "seconds", "spread", "evaluations", "status", "reason")  # of a row, as a judge may give them
DECADE = math.sqrt(10.0)
WANTED_LOOK = {"color": STYLE["soft"], "linewidth": 1.2, "linestyle": ":"}

Entry = tuple[str, str, float, float]  # problem, method, setting, across


class Options(NamedTuple):
    """Options of a chart: problems by name (empty: all), progress, limit of CPU seconds of a run, size."""

    problems: tuple[str, ...] = ()
    update: Callable[[float], None] = lambda share: None
    limit: float = LIMIT
    quick: bool = False


class Made(NamedTuple):
    """A chart as files, the sentences that read it, and its rows."""

    reading: list[str]
    pictures: list[str]
    tables: list[str]
    rows: list[Row]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Contest:
    """A chart of runs.

    `problems`: title by name. `entries(problem, quick)` gives methods with setting and across. `judge(problem, method,
    setting, across)` gives error, seconds, ... and further columns by name; it raises BearingTwinError where there is
    no result. `panels(contest, rows)` draws the rows, `read(contest, rows)` says what they show. `wanted` is the error
    at which costs are compared, `own` are methods of the reference's own family.
    """

    title: str
    problems: Mapping[str, str]
    entries: Callable[[str, bool], Iterable[tuple[str, float, float]]]
    judge: Callable[[str, str, float, float], dict[str, Any]]
    command: Callable[[str, str, float, float], str] = lambda *entry: ""
    panels: Callable[["Contest", list[Row]], list[list[Panel]]] = lambda contest, rows: error_against_cost(
        contest, rows
    )
    read: Callable[["Contest", list[Row]], Iterable[str]] = lambda contest, rows: best_of(contest, rows)
    error: str = "relative error"
    cost: str = "CPU time of a run"
    wanted: float = 1e-3
    own: tuple[str, ...] = ()

    def run(self, entry: Entry, limit: float = 0.0) -> Row:
        """One run as a row, whatever comes of it; raises CoreError where nothing can run."""
        row = Row(*entry, command=self.command(*entry))
        try:
            with limited(limit), np.errstate(all="ignore"):
                found = self.judge(*entry)
        except CoreError:
            raise
        except SceneError as error:
            return dataclasses.replace(row, status=REFUSED, reason=str(error))
        except Stopped:
            reason = f"stopped after {limit:g} CPU seconds"
            return dataclasses.replace(row, status=STOPPED, seconds=limit, reason=reason)
        except (BearingTwinError, ArithmeticError, ValueError) as error:
            return dataclasses.replace(row, status=FAILED, reason=str(error) or type(error).__name__)
        own = {name: found.pop(name) for name in OWN if name in found}
        if not math.isfinite(own["error"]):
            own |= {"error": math.inf, "status": FAILED, "reason": own.get("reason", "not finite")}
        return dataclasses.replace(row, **{"status": DONE, **own}, more=found)

    def measure(self, options: Options) -> list[Row]:
        """All runs, problem by problem and method by method."""
        names = wanted_of(options.problems, self.problems)
        tasks = [(problem, *one) for problem in names for one in self.entries(problem, options.quick)]
        rows = []
        for task in tasks:
            rows.append(self.run(task, options.limit))
            options.update(len(rows) / len(tasks))
        return rows

    def sheet(self, rows: list[Row]) -> Sheet:
        """The picture of rows."""
        sheet = Sheet(self.title, self.panels(self, rows), "", [])
        names = [name for line in sheet.rows for panel in line for part in panel.parts for name, *_ in part.curves()]
        sheet.footer = "crosses: no result" if any(name.endswith(NO_RESULT) for name in names) else ""
        sheet.key = len(labels(sheet)) <= MOST
        return sheet

    def reading(self, rows: list[Row]) -> list[str]:
        """Sentences that read the rows."""
        return [*self.read(self, rows), *found_again(rows, self.own), *without_result(rows), *unsure(rows)]

    def make(self, folder: Path, name: str, options: Options) -> Made:
        """Runs the chart and writes picture and table."""
        rows = self.measure(options)
        picture, table = folder / f"{name}.png", folder / f"{name}.csv"
        write_table(rows, table)
        draw(self.sheet(rows), picture)
        return Made(self.reading(rows), [str(picture)], [str(table)], rows)

    def read_again(self, folder: Path, name: str) -> list[str]:
        """Sentences that read the table of an earlier run; raises OSError or ValueError where there is none."""
        return self.reading(read_table(folder / f"{name}.csv"))


def wanted_of(words: Iterable[str], known: Iterable[str]) -> list[str]:
    """The requested names, in their order, all for none; raises BearingTwinError for one that is not known."""
    words, known = set(words), list(known)
    for word in words - set(known):
        raise BearingTwinError(f"{echo(word)} is not a part of this chart; {unknown(word, known)}")
    return [name for name in known if not words or name in words]


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

    def stop(*_):
        raise Stopped

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def timed(work: Callable[[], Any], times: float = 1.0) -> tuple[Any, dict[str, float]]:
    """The result of `work`; its CPU `seconds` over `times`, the median of repeats, and their `spread`.

    The first run may import, so that it counts only where it takes long.
    """
    start = time.process_time()
    found = work()
    first = time.process_time() - start
    if first > LONG:
        return found, {"seconds": first / times, "spread": math.nan}
    spans, count = [_span(work, 1)], 1
    if spans[0] < ENOUGH:
        count = math.ceil(0.2 * ENOUGH / max(spans[0], 1e-4))  # a busy machine may measure nothing
        spans = [_span(work, count)]
    while (len(spans) < REPEATS and count * sum(spans) < LONG) or count * sum(spans) < ENOUGH:
        spans.append(_span(work, count))
    low, middle, high = np.quantile(spans, (0.25, 0.5, 0.75)).tolist()
    spread = (high - low) / middle if len(spans) >= REPEATS and middle > 0.0 else math.nan
    return found, {"seconds": middle / times, "spread": spread}


def _span(work, count) -> float:
    start = time.process_time()
    for _ in range(count):
        work()
    return (time.process_time() - start) / count


def of_methods(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Rows by method; the place of a method gives its colour, the same in all panels."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.method, []).append(row)
    return found


def of_problem(rows: Iterable[Row], problem: str, *status: str) -> list[Row]:
    """The rows of a problem, of those with this status only where it is given."""
    return [row for row in rows if row.problem == problem and (not status or row.status in status)]


def curves(rows: Iterable[Row], order: list[str], x, y, lost=lambda row: None, marker: str = "o") -> list[Line]:
    """A curve a method through (x(row), y(row)) of its results, a cross at `lost(row)`, if any, for the others.

    Its colour is that of its place in `order`. Results whose y is NaN are left out, smaller ones than LEAST raised.
    """
    parts = []
    for method, mine in of_methods(rows).items():
        good = sorted((x(row), max(y(row), LEAST)) for row in mine if row.status == DONE and not math.isnan(y(row)))
        crosses = [place for row in mine if row.status != DONE and (place := lost(row))]
        parts += curve(method, good, order.index(method), crosses, marker)
    return parts


def error_against_cost(contest: Contest, rows: list[Row], only: Container[str] = ()) -> list[list[Panel]]:
    """A panel a problem, or of `only` some: error across, CPU time up, crosses at the right edge for failures."""
    methods, rows = [*of_methods(rows)], [row for row in rows if not only or row.problem in only]
    known = [row.error for row in rows if row.status == DONE and row.error > 0.0]
    least = max(LEAST, min(known, default=LEAST) / 3.0)
    edge = min(10.0 * max(known, default=1.0), GREATEST)
    across = Axis(contest.error, log=True, limits=(0.5 * least, 2.0 * edge))

    def panel(title: str, here: list[Row]) -> Panel:
        costs = [row.seconds for row in here if row.seconds > 0.0] or [1.0]
        middle = math.sqrt(min(costs) * max(costs))  # a decade at least, lest noise look like a difference
        ends = min(0.8 * min(costs), middle / DECADE), max(1.25 * max(costs), middle * DECADE)
        parts = curves(
            here,
            methods,
            lambda row: max(row.error, least),
            lambda row: row.seconds,
            lambda row: (edge, row.seconds if row.seconds > 0.0 else min(costs) * 1.3 ** methods.index(row.method)),
        )
        limit = Line("", [contest.wanted] * 2, ends, WANTED_LOOK, False)
        return Panel(title, across, Axis(contest.cost, "s", log=True, limits=ends), [limit, *parts])

    pairs = ((title, of_problem(rows, name)) for name, title in contest.problems.items())
    panels = [panel(title, here) for title, here in pairs if here]
    return in_rows(panels, 2 if len(panels) in (2, 4) else 3)


def in_rows(panels: list[Panel], columns: int) -> list[list[Panel]]:
    """Panels side by side, so many in a row."""
    return [panels[first : first + columns] for first in range(0, len(panels), columns)]


def over_across(contest: Contest, rows: list[Row], axis: Axis, columns: Mapping[str, str]) -> list[list[Panel]]:
    """A row of panels a problem: columns of the rows over `across`, by name with their title, then the CPU time."""
    order = [*of_methods(rows)]

    def panel(title: str, mine: list[Row], column: str, words: str) -> Panel:
        parts = curves(mine, order, lambda row: row.across, lambda row: row.more[column], lambda row: (row.across, 1.0))
        return Panel(title, axis, Axis(words, log=True), parts)

    lines = []
    for name, title in contest.problems.items():
        if mine := of_problem(rows, name):
            costs = curves(mine, order, lambda row: row.across, lambda row: row.seconds)
            cost = Panel(title, axis, Axis(contest.cost, "s", log=True), costs)
            lines.append([*(panel(title, mine, *column) for column in columns.items()), cost])
    return lines


def cheapest(rows: Iterable[Row], problem: str, method: str, wanted: float) -> Row | None:
    """The cheapest run of a method within the requested error; None if there is none."""
    good = (row for row in of_problem(rows, problem, DONE) if row.method == method and row.error <= wanted)
    return min(good, key=lambda row: row.seconds, default=None)


def best_of(contest: Contest, rows: list[Row]) -> list[str]:
    """A sentence a problem: the CPU time at which each method has the requested error, the cheapest first."""
    sentences = []
    for name, title in contest.problems.items():
        methods = of_methods(of_problem(rows, name))
        found = {method: cheapest(rows, name, method, contest.wanted) for method in methods}
        good = sorted((row for row in found.values() if row), key=lambda row: row.seconds)
        words = ", ".join(f"{row.method} {seconds(row.seconds)}" for row in good) or "none"
        never = ", ".join(method for method, row in found.items() if not row)
        if methods:
            text = f"{title}: {contest.cost} at an error of {contest.wanted:g}: {words}"
            sentences.append(text + (f"; at no setting: {never}." if never else "."))
    return sentences


def seconds(value: float) -> str:
    """A time in words, two digits."""
    factor, unit = prefixed(value, "s")
    return f"{two_digits(factor * value)} {unit}"


def found_again(rows: Iterable[Row], own: Iterable[str]) -> list[str]:
    """A sentence on how near methods other than the reference's `own` come to it: a check of the reference."""
    nearest: dict[str, Row] = {}
    for row in sorted(rows if own else (), key=lambda row: row.error):
        if row.method not in own and row.status == DONE:
            nearest.setdefault(row.problem, row)
    words = ", ".join(f"{name} to {row.error:.1g} ({row.method})" for name, row in nearest.items())
    return [f"References found again by other methods: {words}."] if words else []


def without_result(rows: Iterable[Row]) -> list[str]:
    """A sentence on the runs that were refused, failed or were stopped."""
    words = dict.fromkeys(f"{row.method} on {row.problem} ({row.status})" for row in rows if row.status != DONE)
    return [f"Without a result: {', '.join(words)}."] if words else []


def unsure(rows: Iterable[Row]) -> list[str]:
    """A sentence on costs whose repeats lie far apart."""
    wide = sorted((row for row in rows if row.spread > UNSURE), key=lambda row: row.spread)
    words = (f"{len(wide)}, the widest {row.method} on {row.problem} ({row.spread:.0%})" for row in wide[-1:])
    return [f"Costs whose repeats lie over {UNSURE:.0%} apart: {one}." for one in words]


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

    def make(self, folder: Path, name: str, options: Options) -> Made:
        """Draws the requested sheets: picture, table of curves and sentences of each."""
        made = Made([], [], [], [])
        wanted = dict.fromkeys(self.problems[one] for one in wanted_of(options.problems, self.problems))
        for place, part in enumerate(wanted, start=1):
            sheet = self.sheets[part].make(options.quick)
            picture, table, reading = (folder / f"{name}_{part}.{ending}" for ending in ("png", "csv", "txt"))
            write_curves(sheet, table)
            reading.write_text("\n".join(sheet.reading) + "\n", encoding="utf-8")
            made.pictures.append(str(draw(sheet, picture)))
            made.tables.append(str(table))
            made.reading.extend(sheet.reading)
            options.update(place / len(wanted))
        return made

    def read_again(self, folder: Path, name: str) -> list[str]:
        """The sentences of the sheets that were made in a folder; raises OSError where there are none."""
        found = [folder / f"{name}_{sheet}.txt" for sheet in self.sheets]
        found = [one for one in found if one.is_file()] or found[:1]
        return [line for one in found for line in one.read_text(encoding="utf-8").splitlines()]
