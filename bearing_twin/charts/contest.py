"""Contests of methods: one format for what came out, one runner with a limit of cost that can be resumed.

A chart of contests is a list of `Job`s, each a function of a module in `charts/` with its arguments. The runner calls
them in processes of their own, two at a time. A contestant that goes on for longer than the limit of CPU seconds is
stopped by the system, whatever it does, and is told as such. What is finished is kept beside the picture until all is
done, so that a chart that was interrupted goes on where it was; kept answers of other sources are not used.
"""

import contextlib
import dataclasses
import functools
import hashlib
import importlib
import json
import math
import multiprocessing
import signal
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.charts.table import DONE, FAILED, REFUSED, STOPPED, Row
from bearing_twin.errors import BearingTwinError, SceneError
from bearing_twin.processors import usable
from bearing_twin.run.simulation import COMPILING

LIMIT = 20.0  # CPU seconds that a contestant may take, unless a chart says otherwise
WORKERS = 2


class Job(NamedTuple):
    """A function "module:name", the module in `charts/` or a full name, and its arguments: words, numbers, lists."""

    function: str
    arguments: tuple

    @property
    def key(self) -> str:
        """What tells it from others."""
        return json.dumps([self.function, *self.arguments])


class Made(NamedTuple):
    """What a contest gives: sentences that read it, its pictures, its tables, and every run."""

    reading: list[str]
    pictures: list[str]
    tables: list[str]
    rows: list[Row]


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Within it this process ends, without a word, once it has taken so many CPU seconds more; 0 = no limit.

    What compiling takes does not count. Where it is on, Linux counts the process's time in ticks of 10 ms;
    `time.thread_time` stays as fine as ever.
    Where the system has no such clock (Windows), nothing is limited.
    """
    if not hasattr(signal, "setitimer") or not seconds:
        yield
        return
    from numba.core import event

    class Pause(event.Listener):
        """The clock stands while a kernel is compiled or loaded."""

        depth, left = 0, 0.0

        def on_start(self, _):
            self.left = self.left if self.depth else signal.setitimer(signal.ITIMER_PROF, 0.0)[0]
            self.depth += 1

        def on_end(self, _):
            self.depth -= 1
            if not self.depth:
                signal.setitimer(signal.ITIMER_PROF, self.left)

    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        with event.install_listener(COMPILING, Pause()):
            yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def tried(row: Row, work: Callable[[], dict], limit: float) -> Row:
    """The row with what `work` gives for its fields, or why it has failed."""
    try:
        with limited(limit), np.errstate(all="ignore"):
            return row.but(status=DONE, **work())
    except SceneError as error:
        return row.but(status=REFUSED, reason=str(error))
    except BearingTwinError as error:
        return row.but(status=FAILED, reason=str(error))
    except (ArithmeticError, ValueError) as error:
        return row.but(status=FAILED, reason=f"{type(error).__name__}: {error}")


def judged(row: Row, work: Callable[[], dict], limit: float) -> Row:
    """As `tried`; a row of errors that are not finite has failed, too."""
    found = tried(row, work, limit)
    if found.status != DONE:
        return found
    errors = found.load_error, 0.0 if math.isnan(found.friction_error) else found.friction_error
    return found if all(map(math.isfinite, errors)) else found.but(status=FAILED, reason="not finite")


@functools.cache
def sources() -> str:
    """A digest of the package's own text: answers of other sources are not taken for those of these."""
    package, digest = Path(__file__).resolve().parent.parent, hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


class Kept:
    """Answers that are finished, in a file of lines beside the picture; without a path they are in memory alone."""

    def __init__(self, path: Path | None):
        self.path, self.answers = path, {}
        if path is None:
            return
        with contextlib.suppress(OSError, ValueError):
            head, *lines = path.read_text(encoding="utf-8").splitlines()
            if json.loads(head) == sources():
                for line in lines:
                    with contextlib.suppress(ValueError):  # the last line of an interrupted run
                        self.answers.update([json.loads(line)])
        if not self.answers:
            self._write(json.dumps(sources()), "w")

    def put(self, key: str, answer) -> None:
        """Keeps one more."""
        self.answers[key] = answer
        self._write(json.dumps([key, answer]), "a")

    def drop(self) -> None:
        """Forgets the file: all is done."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def _write(self, line, how):
        if self.path is None:
            return
        try:
            with self.path.open(how, encoding="utf-8") as stream:
                stream.write(line + "\n")
        except OSError as error:
            raise BearingTwinError(f"{self.path} cannot be written ({error.strerror}); give another folder") from error


class Asked(NamedTuple):
    """What is asked of a contest: which problems, by how many processes, with which limit of CPU seconds for a run."""

    problems: tuple[str, ...]
    update: Callable[[float], None]
    workers: int
    limit: float
    kept: Kept


def _serve(pipe) -> None:
    """The other process: answers tasks until its pipe closes. Ctrl-C is for the parent, which ends this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(EOFError):
        while True:
            function, arguments = pipe.recv()
            pipe.send(call(function, arguments))


def call(function: str, arguments) -> Any:
    """The answer to a task, in this process, as plain data."""
    module, name = function.split(":")
    module = module if "." in module else f"bearing_twin.charts.{module}"
    return _plain(getattr(importlib.import_module(module), name)(*arguments))


def _plain(answer):
    if dataclasses.is_dataclass(answer):
        return list(dataclasses.astuple(answer))
    return list(map(_plain, answer)) if isinstance(answer, tuple | list) else answer


class _Worker:
    """One process with the task it is at."""

    def __init__(self):
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other,), daemon=True)
        self.process.start()
        other.close()
        self.task: Job | None = None

    def give(self, task: Job) -> None:
        self.task = task
        self.pipe.send((task.function, task.arguments))

    def end(self) -> None:
        self.pipe.close()
        self.process.kill()
        self.process.join()


def answers_of(
    tasks: Iterable[Job],
    kept: Kept,
    update: Callable[[float], None] = lambda share: None,
    workers: int = WORKERS,
) -> list:
    """The answers to all tasks in their order, None where one was stopped for its cost; raises what a worker meets.

    `workers` processes share the work; none: all is done in this one, without a limit.
    """
    tasks = list(tasks)
    waiting = [task for task in reversed(tasks) if task.key not in kept.answers]
    total = max(len(tasks), 1)
    if not workers:
        while waiting:
            task = waiting.pop()
            kept.put(task.key, call(*task))
            update(1.0 - len(waiting) / total)
        return [kept.answers[task.key] for task in tasks]
    busy, idle = {}, []
    try:
        while waiting or busy:
            while waiting and len(busy) < workers:
                worker = idle.pop() if idle else _Worker()
                busy[worker.pipe] = worker
                worker.give(waiting.pop())
            for pipe in wait(list(busy)):
                worker = busy[pipe]
                kept.put(worker.task.key, _received(worker))
                del busy[pipe]
                if worker.process.is_alive():
                    idle.append(worker)
                else:
                    worker.end()
                update(1.0 - (len(waiting) + len(busy)) / total)
    finally:
        for worker in (*busy.values(), *idle):
            worker.end()
    return [kept.answers[task.key] for task in tasks]


def _received(worker):
    """What a worker answers; None where the system has stopped it for its cost."""
    try:
        return worker.pipe.recv()
    except EOFError:
        worker.process.join()
        if hasattr(signal, "SIGPROF") and worker.process.exitcode == -signal.SIGPROF:
            return None
        raise BearingTwinError(
            f"a process of the chart ended with {worker.process.exitcode} at {worker.task.key}; its words stand above"
        ) from None


def rows_of(tasks: list[Job], answers: list, blank: Callable[[Job], Row], limit: float = LIMIT) -> list[Row]:
    """The answers, of a row or of several, as rows of the class that `blank` gives.

    A task that was stopped is that row with the cost it was stopped at.
    """
    rows = []
    for task, answer in zip(tasks, answers, strict=True):
        row = blank(task)
        if answer is None:
            rows.append(row.but(status=STOPPED, seconds=limit, reason=f"stopped after {limit:g} CPU seconds"))
        else:
            rows += [type(row)(*one) for one in (answer if isinstance(answer[0], list) else [answer])]
    return rows


def processors() -> int:
    """How many contests run side by side here."""
    return min(WORKERS, usable())
