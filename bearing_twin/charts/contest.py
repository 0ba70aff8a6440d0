"""The engine of all charts: problems, methods and their settings in; a table, a picture and sentences out.

A chart is a table of problems, each a row. Every run is a `Row`: its error against a reference far tighter than what is
judged, its CPU seconds, or why there is no result. Runs are shared by two processes; one that exceeds the limit of CPU
seconds is stopped. What is finished is kept beside the picture until all is done, so that an interrupted chart
continues; kept rows of other sources are not used.
"""

import contextlib
import dataclasses
import hashlib
import json
import math
import multiprocessing
import signal
import time
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, CoreError, SceneError
from bearing_twin.base.parameters import echo, unknown
from bearing_twin.base.process import usable
from bearing_twin.base.units import prefixed, two_digits
from bearing_twin.charts import chart_of
from bearing_twin.charts.panels import Axis, Line, Panel, Sheet, curve, draw, labels
from bearing_twin.charts.rows import DONE, FAILED, REFUSED, STOPPED, Row, read_table, write_table
from bearing_twin.pictures.style import STYLE

LIMIT, WORKERS = 60.0, 2  # CPU seconds of a run unless the user says otherwise; processes side by side
ENOUGH, REPEATS, LONG = 0.15, 3, 3.0  # CPU seconds and repeats of a timing; beyond LONG it is done once more only
UNSURE = 0.1  # spread of a cost beyond which it is reported
LEAST, GREATEST = 1e-12, 3.0  # of the axis of errors: smaller ones stand at its start, failures at its end
MOST = 10  # entries of a common legend
OWN = ("error", "seconds", "spread", "evaluations", "status", "reason")  # of a row, as a judge may give them
DECADE = math.sqrt(10.0)
WANTED_LOOK = {"color": STYLE["soft"], "linewidth": 1.2, "linestyle": ":"}

Entry = tuple[str, str, float, float]  # problem, method, setting, across


class Asked(NamedTuple):
    """Options of a chart: problems by name (empty: all), progress, processes (0: this one), limit [s], size."""

    problems: tuple[str, ...] = ()
    update: Callable[[float], None] = lambda share: None
    workers: int = WORKERS
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

    def measure(self, name: str, asked: Asked, unfinished: Path | None = None) -> list[Row]:
        """All runs, problem by problem and method by method; those in the file `unfinished` are not repeated."""
        names = wanted_of(asked.problems, self.problems)
        tasks = [(problem, *one) for problem in names for one in self.entries(problem, asked.quick)]
        kept = Kept(unfinished)
        waiting = [task for task in tasks if repr(task) not in kept.rows]
        for task, row in _answers(name, self, waiting, asked):
            kept.put(repr(task), row)
            asked.update(len(kept.rows) / len(tasks))
        kept.drop()
        return [kept.rows[repr(task)] for task in tasks]

    def sheet(self, rows: list[Row]) -> Sheet:
        """The picture of rows."""
        lost = any(row.status != DONE for row in rows)
        sheet = Sheet(self.title, self.panels(self, rows), "crosses: no result" if lost else "", [])
        sheet.key = len(labels(sheet)) <= MOST
        return sheet

    def reading(self, rows: list[Row]) -> list[str]:
        """Sentences that read the rows."""
        return [*self.read(self, rows), *found_again(rows, self.own), *without_result(rows), *unsure(rows)]

    def make(self, folder: Path, name: str, asked: Asked) -> Made:
        """Runs the chart and writes picture and table."""
        rows = self.measure(name, asked, folder / f"{name}.unfinished")
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


def _answers(name, contest, tasks, asked) -> Iterator[tuple[Entry, Row]]:
    """Every task with its row, as they come."""
    if not asked.workers or len(tasks) < 2:
        yield from ((task, contest.run(task, asked.limit)) for task in tasks)
        return
    spawn = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(asked.workers, usable()), spawn, signal.signal, (signal.SIGINT, signal.SIG_IGN))
    try:
        futures = {pool.submit(_run, name, task, asked.limit): task for task in tasks}
        for future in as_completed(futures):
            yield futures[future], future.result()
    except BrokenProcessPool as error:
        raise BearingTwinError("a process of the chart was ended by the system; its words stand above") from error
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in multiprocessing.active_children():
            child.kill()


def _run(name: str, task: Entry, limit: float) -> Row:
    return chart_of(name).run(task, limit)


class Kept:
    """Rows that are finished, in a file of lines; without a path they are in memory alone."""

    def __init__(self, path: Path | None):
        self.path, self.rows = path, {}
        if path is None:
            return
        with contextlib.suppress(OSError, ValueError, TypeError):
            head, *lines = path.read_text(encoding="utf-8").splitlines()
            for line in lines if head == sources() else ():
                key, cells = json.loads(line)
                self.rows[key] = Row(**cells)
        if not self.rows:
            self._write(sources(), "w")

    def put(self, key: str, row: Row) -> None:
        """Keeps one more."""
        self.rows[key] = row
        self._write(json.dumps([key, dataclasses.asdict(row)]), "a")

    def drop(self) -> None:
        """Forgets the file: all is done."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def _write(self, line: str, how: str) -> None:
        if self.path is None:
            return
        try:
            with self.path.open(how, encoding="utf-8") as stream:
                stream.write(line + "\n")
        except OSError as error:
            raise BearingTwinError(f"{self.path} cannot be written ({error.strerror}); give another folder") from error


def sources() -> str:
    """A digest of the package's text: rows of other sources are not used."""
    package, digest = Path(__file__).resolve().parent.parent, hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


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

    The first run is not timed: it may import.
    """
    found = work()
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


def error_against_cost(contest: Contest, rows: list[Row], only: Container[str] = ()) -> list[list[Panel]]:
    """A panel a problem, or of `only` some: error across, CPU time up, crosses at the right edge for failures."""
    methods, rows = [*of_methods(rows)], [row for row in rows if not only or row.problem in only]
    panels, known = [], [row.error for row in rows if row.status == DONE and row.error > 0.0]
    least = max(LEAST, min(known, default=LEAST) / 3.0)
    edge = min(10.0 * max(known, default=1.0), GREATEST)
    across = Axis(contest.error, log=True, limits=(0.5 * least, 2.0 * edge))
    for name, title in contest.problems.items():
        if not (here := of_problem(rows, name)):
            continue
        costs = [row.seconds for row in here if row.seconds > 0.0] or [1.0]
        middle = math.sqrt(min(costs) * max(costs))  # a decade at least, lest noise look like a difference
        ends = min(0.8 * min(costs), middle / DECADE), max(1.25 * max(costs), middle * DECADE)
        up = Axis(contest.cost, "s", log=True, limits=ends)
        parts = [Line("", [contest.wanted] * 2, ends, WANTED_LOOK, False)]
        for method, mine in of_methods(here).items():
            number, mine = methods.index(method), sorted(mine, key=lambda row: row.setting)
            good = [(max(row.error, least), row.seconds) for row in mine if row.status == DONE]
            high = min(costs) * 1.3**number
            lost = [(edge, row.seconds if row.seconds > 0.0 else high) for row in mine if row.status != DONE]
            parts += curve(method, good, number, lost)
        panels.append(Panel(title, across, up, parts))
    return in_rows(panels, 2 if len(panels) in (2, 4) else 3)


def in_rows(panels: list[Panel], columns: int) -> list[list[Panel]]:
    """Panels side by side, so many in a row."""
    return [panels[first : first + columns] for first in range(0, len(panels), columns)]


def over_across(contest: Contest, rows: list[Row], axis: Axis, columns: Mapping[str, str]) -> list[list[Panel]]:
    """A row of panels a problem: columns of the rows over `across`, by name with their title, then the CPU time."""
    lines = []
    for name, title in contest.problems.items():
        mine, line = of_problem(rows, name), []
        for column, words in {**columns, "seconds": contest.cost}.items() if mine else ():
            parts, up = [], Axis(words, "s" if column == "seconds" else "1", log=True)
            for number, method in enumerate(of_methods(rows)):
                ours = [row for row in mine if row.method == method]
                good = [(row.across, row.more.get(column, row.seconds)) for row in ours if row.status == DONE]
                lost = [(row.across, 1.0) for row in ours if row.status != DONE and column != "seconds"]
                parts += curve(method, sorted((x, max(y, LEAST)) for x, y in good if y == y), number, lost)
            line.append(Panel(title, axis, up, parts))
        lines += [line] if line else []
    return lines


def cheapest(rows: Iterable[Row], problem: str, method: str, wanted: float) -> Row | None:
    """The cheapest run of a method within the requested error; None if there is none."""
    good = (row for row in of_problem(rows, problem, DONE) if row.method == method and row.error <= wanted)
    return min(good, key=lambda row: row.seconds, default=None)


def best_of(contest: Contest, rows: list[Row]) -> list[str]:
    """A sentence a problem: the CPU time at which each method has the requested error, the cheapest first."""
    sentences = []
    for name, title in contest.problems.items():
        mine = of_methods(of_problem(rows, name))
        found = {method: cheapest(rows, name, method, contest.wanted) for method in mine}
        good = sorted((method for method in mine if found[method]), key=lambda method: found[method].seconds)
        never = [method for method in mine if not found[method]]
        if mine:
            words = ", ".join(f"{method} {seconds(found[method].seconds)}" for method in good) or "none"
            text = f"{title}: {contest.cost} at an error of {contest.wanted:g}: {words}"
            sentences.append(text + (f"; at no setting: {', '.join(never)}." if never else "."))
    return sentences


def seconds(value: float) -> str:
    """A time in words, two digits."""
    factor, unit = prefixed(value, "s")
    return f"{two_digits(factor * value)} {unit}"


def found_again(rows: Iterable[Row], own: Iterable[str]) -> list[str]:
    """A sentence on how near methods other than the reference's `own` come to it: a check of the reference."""
    nearest: dict[str, tuple[float, str]] = {}
    for row in rows if own else ():
        if row.method not in own and row.error < nearest.get(row.problem, (math.inf, ""))[0]:
            nearest[row.problem] = row.error, row.method
    words = ", ".join(f"{problem} to {error:.1g} ({method})" for problem, (error, method) in nearest.items())
    return [f"References found again by other methods: {words}."] if words else []


def without_result(rows: Iterable[Row]) -> list[str]:
    """A sentence on the runs that were refused, failed or were stopped."""
    lost = [row for row in rows if row.status != DONE]
    words = ", ".join(dict.fromkeys(f"{row.method} on {row.problem} ({row.status})" for row in lost))
    return [f"Without a result: {words}."] if lost else []


def unsure(rows: Iterable[Row]) -> list[str]:
    """A sentence on costs whose repeats lie far apart."""
    wide = [row for row in rows if row.spread > UNSURE]
    if not wide:
        return []
    worst = max(wide, key=lambda row: row.spread)
    words = f"{worst.method} on {worst.problem} ({worst.spread:.0%})"
    return [f"Costs whose repeats lie over {UNSURE:.0%} apart: {len(wide)}, the widest {words}."]
