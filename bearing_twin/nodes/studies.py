"""Studies on request, one at a time behind a short queue: what uq_node thinks, without ROS and without a thread.

A request waits from the moment it is accepted. It is read (`read`), runs in its turn (`turn`), and gets an answer in
any case: of its study, of what makes it no study, or that it was called off. Reading and running take as long as they
take, each in a thread of its own; everything else returns at once and may be called from any thread.
"""

import contextlib
import dataclasses
import itertools
import math
import tempfile
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from bearing_twin.base.errors import BearingTwinError, LogError, StudyError
from bearing_twin.base.parameters import echo
from bearing_twin.base.paths import file_name, only_below
from bearing_twin.base.process import usable
from bearing_twin.base.report import json_text
from bearing_twin.kinds.ranges import ON
from bearing_twin.log.study_log import INPUT, QUANTITY, StudyLog
from bearing_twin.nodes.node_parameters import ALLOW_INVALID, NOT_ALLOWED
from bearing_twin.run.scene import refuse_another
from bearing_twin.uq.result import StudyResult
from bearing_twin.uq.run import Progress, memory_needed, refuse_too_large, run_study
from bearing_twin.uq.study import Study, load_study, parse_study, rule_of, study_names

LONGEST_TEXT = 60_000  # characters of a study in a goal: under a second to read, whatever is in it
MOST_OVERRIDES, LONGEST_OVERRIDE = 1000, 10_000
SUCCEEDED, ABORTED, CANCELLED = "succeeded", "aborted", "cancelled"


class Goal(NamedTuple):
    """What was asked: name, path or YAML text of a study, and changes; `samples` and `seed` 0 = as the study says."""

    study: str
    overrides: tuple[str, ...] = ()
    samples: int = 0
    seed: int = 0


class GoalAnswer(NamedTuple):
    """How a request ended (SUCCEEDED, ABORTED or CANCELLED), the sentence about it, and what there is of a result.

    `problem` is what whoever looks after the node should know of, empty where all is well.
    """

    state: str
    message: str
    summary: str = ""
    log: str = ""
    stopped_because: str = ""
    problem: str = ""


class Request:
    """A goal on its way; its `answer` is there once `finished` is set.

    `called_off()` tells whether whoever asked has cancelled it. `begin()` is called once, when it starts to run, or
    else when it has got its answer without. `tell(progress, statistic)` is called while it runs, ten times a second at
    most; see `feedback_of`.
    """

    def __init__(
        self,
        goal: Goal,
        called_off: Callable[[], bool] = lambda: False,
        begin: Callable[[], None] = lambda: None,
        tell: Callable[[Progress, str], None] = lambda progress, statistic: None,
    ):
        self.goal, self.called_off, self.tell = goal, called_off, tell
        self.study: Study | None = None
        self.answer: GoalAnswer | None = None
        self.since_ns = 0  # monotonic time at which it began to wait
        self.finished = threading.Event()
        self._begin, self._begun = begin, False

    def begin(self) -> None:
        """Says that its turn has come; the second time nothing."""
        if not self._begun:
            self._begun = True
            self._begin()


def feedback_of(goal: Goal, study: Study, progress: Progress) -> tuple[Progress, str]:
    """(progress as feedback, name of the watched statistic): in samples as the goal asked for them, without NaN.

    A study with a sweep, with an expansion or with shares of variance does another number of runs than samples were
    asked for: `done` is then the same share of the samples as is done of the runs. Before the first look at the samples
    the name is empty, and estimate and half width are 0; a half width that cannot be told is infinite.
    """
    total = goal.samples or study.settings.samples
    done = progress.done if progress.total == total else int(total * progress.done / max(progress.total, 1))
    counted = progress._replace(done=min(done, total), total=total)
    if not math.isfinite(progress.estimate):
        return counted._replace(estimate=0.0, half_width=0.0), ""
    known = not math.isnan(progress.half_width)
    name = " at ".join(filter(None, (_watched(study), progress.at)))
    return counted._replace(half_width=progress.half_width if known else math.inf), name


def _watched(study: Study) -> str:
    return rule_of(study.settings.stop, study.stop_quantity).watched


def study_of(goal: Goal, folders: Iterable[str] = ()) -> Study:
    """The study a goal asks for: text with several lines or in braces is YAML, all else a name or a path.

    Files, also those that a study names, are read only below `folders`. Raises BearingTwinError with a sentence for
    what makes none.
    """
    with only_below(folders, "the folders of the node's parameter study_folders"):
        return _study_of(goal)


def _study_of(goal: Goal) -> Study:
    if len(goal.study) > LONGEST_TEXT:
        raise StudyError(f"the study has {len(goal.study)} characters, more than {LONGEST_TEXT}; put it into a file")
    if len(goal.overrides) > MOST_OVERRIDES or any(len(one) > LONGEST_OVERRIDE for one in goal.overrides):
        raise StudyError(f"overrides must be at most {MOST_OVERRIDES}, each of {LONGEST_OVERRIDE} characters at most")
    overrides = [one for one in goal.overrides if one]
    given = {key: value for key, value in (("samples", goal.samples), ("seed", goal.seed)) if value}
    for key, value in given.items():
        refuse_another(key, value, overrides)
    overrides += [f"{key}={value}" for key, value in given.items()]
    text = goal.study.strip()
    if not text:
        raise StudyError(f"which study? give a name, a path or YAML; legal: {', '.join(study_names())}")
    if "\n" in text or text.startswith("{"):
        return parse_study(goal.study, "study goal", overrides)
    return load_study(text, overrides)


MESSAGE, DESCRIBED = 80, 40  # bytes: of a realisation's message in a log; of a number in it, beside its name


class StudyLimits(NamedTuple):
    """The node's limits: `memory` [B] and `samples` of a study, `workers` (0 = one a processor), `time_limit` [s].

    `log_quota` [B] is what all logs in their folder may take together, `executors` where a study may run. 0 = no limit.
    `allow_invalid`: whether a study may let models run outside their ranges.
    """

    memory: float = 2e9
    workers: int = 0
    time_limit: float = 0.0
    samples: int = 0
    log_quota: float = 0.0
    executors: Sequence[str] = ("processes",)
    allow_invalid: bool = False

    def bounded(self, study: Study) -> Study:
        """The study with as many workers as it may have; raises StudyError where it asks for what it may not."""
        if study.executor not in self.executors:
            # Whoever answers at a scheduler's address can have code run here.
            raise StudyError(
                f"executor = {echo(study.executor)} is not among the node's parameter executors; "
                f"legal: {', '.join(self.executors)}"
            )
        if study.scene.get("solver", {}).get(ALLOW_INVALID) == ON and not self.allow_invalid:
            raise StudyError(f"study {study.name} has solver.{ALLOW_INVALID}: on, {NOT_ALLOWED}")
        if self.samples and study.settings.samples > self.samples:
            raise StudyError(
                f"study {study.name} asks for {study.settings.samples} samples, more than the node's parameter "
                f"samples = {self.samples}; ask for fewer"
            )
        refuse_too_large(study)
        needed = memory_needed(study)
        if needed > self.memory:
            raise StudyError(
                f"study {study.name} would need {needed:.3g} B, more than the node's parameter memory = "
                f"{self.memory:.3g} B; ask for fewer samples, histories or history_points"
            )
        most = self.workers or usable()
        workers = min(study.settings.workers or most, most)
        return dataclasses.replace(study, settings=dataclasses.replace(study.settings, workers=workers))

    def refuse_full(self, folder: Path, study: Study) -> None:
        """Raises LogError where the logs in `folder` and that of this study would take more than `log_quota`."""
        if not self.log_quota:
            return
        there = sum(path.stat().st_size for path in folder.glob("*.mcap"))
        if there + log_bytes(study) > self.log_quota:
            raise LogError(
                f"the logs in {folder} take {there:.3g} B and that of this study up to {log_bytes(study):.3g} B, "
                f"together more than the node's parameter log_quota = {self.log_quota:.3g} B; move some away"
            )


def log_bytes(study: Study) -> float:
    """The size of a study's log at most [B]: every realisation with its numbers, before they are packed.

    Its inputs and quantities stand in a block and, with their names and units, in a message of its own.
    """
    shown = [f"{INPUT}{one.key}" for one in study.inputs] + [f"{QUANTITY}{name}" for name in study.quantities]
    columns = len(shown) + 3 + len(study.histories) * study.settings.history_points
    message = MESSAGE + sum(len(name) + DESCRIBED for name in shown)
    return (8.0 * columns + message) * study.settings.samples


def refuse_unwritable(folder: Path) -> None:
    """Raises LogError where no log can be put into `folder`, or where that cannot be made."""
    there = next(one for one in (folder, *folder.absolute().parents) if one.exists())
    if not there.is_dir():
        raise LogError(f"log_folder {folder} is a file, or leads through one; give a folder, or nothing for no logs")
    try:
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise LogError(
            f"log_folder {folder} cannot be made or written ({error.strerror}); give another, or nothing for no logs"
        ) from error


def without_log(error: LogError | OSError) -> str:
    """The sentence about a study whose log could not be made or written."""
    system = isinstance(error, OSError)
    reason = f"{error.filename or 'its file'} cannot be written ({error.strerror})" if system else error
    return f"there is no log of it, because {reason}"


def free_path(folder: Path, study: str, date: str) -> Path:
    """Where to log a study: `<study>_<date>.mcap`, with a number where that is taken."""
    stem = f"{file_name(study)}_{date}"
    names = (
        f"{stem}{suffix}.mcap" for suffix in itertools.chain([""], (f"_{number}" for number in itertools.count(2)))
    )
    return next(folder / name for name in names if not (folder / name).exists())


QUEUE = 4  # studies that may wait for the one that runs
PROGRESS_PERIOD_NS = 100_000_000
LONGEST_READ_NS = 30_000_000_000  # after which a goal that is still not read is answered
LONGEST_END_NS = 250_000_000  # after a cancel, until whoever asked is answered, whatever the study still does
LONGEST_SILENCE_NS = 60_000_000_000  # without progress of the study that runs, after which the node says so


class Studies:
    """The studies that were asked for; at most one runs and QUEUE wait.

    `log_folder` gets a log of every study, empty = none. `limits` bound what a study may use, whatever it says itself;
    `folders` are those in which files may be read for a goal. `ended(answer)` is told of every answer. `run` and
    `open_log` are those of the library; `clock` gives monotonic time [ns].
    """

    def __init__(
        self,
        log_folder: str = "",
        limits: StudyLimits = StudyLimits(),  # noqa: B008 - it cannot change
        ended: Callable[[GoalAnswer], None] = lambda answer: None,
        folders: Iterable[str] = (),
        run: Callable = run_study,
        open_log: Callable = StudyLog,
        clock: Callable[[], int] = time.monotonic_ns,
    ):
        if log_folder:
            refuse_unwritable(Path(log_folder))
        self._log_folder, self._limits, self._folders = log_folder, limits, tuple(folders)
        self._ended, self._do, self._open_log, self._clock = ended, run, open_log, clock
        self._lock = threading.RLock()
        self._waiting: deque[Request] = deque()
        self._running: Request | None = None
        self._progress: Progress | None = None
        self._told: Progress | None = None
        self._next_word = self._moved = 0  # monotonic time [ns]
        self._called_off: int | None = None  # when the study that runs was first seen to be called off [ns]
        self._path = ""  # of its log
        self._closing = False
        self._counts = Counter()
        self._problem = self._last_problem = ""  # of the last request, and of the last that had one

    def refusal(self) -> str:
        """Why no further request can be taken now, or nothing; a refusal is counted."""
        with self._lock:
            reason = self._no_room()
            if reason:
                self._counts["refused"] += 1
                self._problem = self._last_problem = reason
            return reason

    def add(self, request: Request) -> None:
        """Lets a request wait; it is aborted where there has come to be no room."""
        with self._lock:
            reason = self._no_room()
            request.since_ns = self._clock()
            if not reason:
                self._waiting.append(request)
        if reason:
            self._abort(request, reason)

    def read(self, now: int, request: Request) -> None:
        """Makes a study of a waiting request's goal, or aborts it with the reason."""
        try:
            request.study = self._limits.bounded(study_of(request.goal, self._folders))
        except Exception as error:
            for one in self._taken(lambda waiting: waiting is request):
                self._abort(one, _sentence(error))

    def turn(self, now: int) -> int | None:
        """Runs the first of those that wait, if it has been read; returns when to be called again, None = when told."""
        with self._lock:
            if not self._waiting or self._waiting[0].study is None:
                return None
            request = self._running = self._waiting.popleft()
            self._progress = self._told = None
            self._next_word, self._moved = 0, self._clock()
            self._called_off, self._path = None, ""
        if request.called_off():
            self._cancel(request)
        else:
            self._finish(request, self._run(request))
        return now

    def look(self, now: int) -> None:
        """Tells of progress that had to wait; answers requests called off, or not read in time; call it at 10 Hz."""
        self._tell(now)
        self._let_go(now)
        for request in self._taken(lambda one: one.study is None and now - one.since_ns > LONGEST_READ_NS):
            self._abort(request, f"the goal could not be read within {LONGEST_READ_NS * 1e-9:.0f} s")
        for request in self._taken(lambda request: request.called_off()):
            self._cancel(request)

    def _let_go(self, now: int) -> None:
        """Answers a study that was called off and takes long to end, as one with millions of samples; it still ends."""
        with self._lock:
            request = self._running
            if request is None or not request.called_off():
                return
            self._called_off = now if self._called_off is None else self._called_off
            if now - self._called_off < LONGEST_END_NS:
                return
        done = "the study is still putting away what is done" + (f" in {self._path}" if self._path else "")
        self._reply(request, GoalAnswer(CANCELLED, f"cancelled; {done}", stopped_because=CANCELLED))

    def close(self) -> None:
        """Ends the study that runs within half a second, besides its statistics and log; aborts those that wait."""
        self._closing = True
        for request in self._taken(lambda request: True):
            self._abort(request, "the node was ended before the study could run")

    def abandon(self) -> None:
        """Answers the study that still runs, for whoever waits; nothing where it has ended."""
        with self._lock:
            request = self._running
        if request is not None:
            self._abort(request, "the node was ended and did not wait for the study")

    def status(self) -> tuple[str, str, dict]:
        """(what it does, what went wrong with the last request or nothing, figures) for diagnostics."""
        with self._lock:
            running, progress = self._running, self._progress
            silent = self._clock() - self._moved if running else 0
            study = running.study.name if running is not None and running.study is not None else ""
            values = {
                "study": study,
                "done": progress.done if progress else 0,
                "total": progress.total if progress else 0,
                "seconds_left": float(progress.seconds_left) if progress else 0.0,
                "seconds_without_progress": silent * 1e-9,
                "waiting": len(self._waiting),
                "queue": QUEUE,
                **{key: self._counts[key] for key in (SUCCEEDED, ABORTED, CANCELLED, "refused")},
                "last_error": self._last_problem,
            }
            stuck = (
                f"study {study} has made no progress for {silent * 1e-9:.0f} s; cancel it, or wait for its time_limit"
            )
            problem = stuck if silent > LONGEST_SILENCE_NS else self._problem
            return f"running {study}" if running else "idle", problem, values

    def _taken(self, which: Callable[[Request], bool]) -> list[Request]:
        """Those that wait and are meant, which then wait no more: whoever takes a request answers it."""
        with self._lock:
            taken = [request for request in self._waiting if which(request)]
            self._waiting = deque(request for request in self._waiting if request not in taken)
        return taken

    def _no_room(self) -> str:
        if self._closing:
            return "the node is ending and takes no more studies"
        if len(self._waiting) + (self._running is not None) > QUEUE:
            return f"a study runs and {QUEUE} wait for it, so there is no room: ask again when one has ended"
        return ""

    def _run(self, request: Request) -> GoalAnswer:
        def tell(progress: Progress) -> None:
            self._progress, self._moved = progress, self._clock()
            self._tell(self._clock())

        seconds = self._limits.time_limit
        limit = self._clock() + round(seconds * 1e9) if seconds else math.inf

        def ends() -> bool:
            # Once it has its answer, ROS holds a cancelled request for ended and no longer for called off.
            return self._closing or request.answer is not None or request.called_off() or self._clock() > limit

        result, (log, path, no_log) = None, self._new_log(request.study)
        self._path = path
        try:
            with contextlib.ExitStack() as stack:
                request.begin()
                keep = {"keep": stack.enter_context(log).add} if log else {}
                result = self._do(request.study, tell, ends, **keep)
                if log:
                    log.finish(result)
        except Exception as error:  # whatever it is, the next study is served
            if result is None or not isinstance(error, (LogError, OSError)):
                _drop_empty(log, path)
                reason = _sentence(error)
                return GoalAnswer(ABORTED, reason, stopped_because=f"failed: {reason}", problem=reason)
            path, no_log = "", without_log(error)
        return self._answer(request, result, self._clock() > limit, (log, path, no_log))

    def _tell(self, now: int) -> None:
        """Progress to whoever asked for the study, unless it is known or was told of too short a time ago."""
        with self._lock:
            request, progress = self._running, self._progress
            if request is None or request.answer or progress is self._told or now < self._next_word:
                return
            self._told, self._next_word = progress, now + PROGRESS_PERIOD_NS
        request.tell(*feedback_of(request.goal, request.study, progress))

    def _answer(self, request: Request, result: StudyResult, late: bool, logged: tuple) -> GoalAnswer:
        summary = result.as_dict()
        because = summary["stopped_because"]
        state = SUCCEEDED
        if request.answer is not None or request.called_off():
            state, because = CANCELLED, CANCELLED
        elif self._closing:
            state, because = ABORTED, "the node was ended"
        elif late and because == CANCELLED:
            state, because = ABORTED, f"the node's parameter time_limit = {self._limits.time_limit:g} s was reached"
        elif because.startswith("failed"):
            state = ABORTED
        writer, log, no_log = logged
        if state != SUCCEEDED:
            log = _drop_empty(writer, log)
        failed = sum(summary["failed"].values())
        message = f"{summary['samples']} samples, {failed} failed, {summary['seconds']:.3g} s; {because}"
        if no_log:
            message += f"; {no_log}"
            summary["notes"] = [*summary["notes"], no_log]  # whoever asked reads the summary, few the message
        problem = message if state == ABORTED else no_log
        return GoalAnswer(state, message, json_text(summary | ({"log": log} if log else {})), log, because, problem)

    def _new_log(self, study: Study) -> tuple[StudyLog | None, str, str]:
        """(log, its path, why there is none): filled as the study goes, so that what is done outlives the node."""
        if not self._log_folder:
            return None, "", ""
        try:
            Path(self._log_folder).mkdir(parents=True, exist_ok=True)
            self._limits.refuse_full(Path(self._log_folder), study)
            path = free_path(Path(self._log_folder).resolve(), study.name, time.strftime("%Y%m%d_%H%M%S"))
            return self._open_log(study, path), str(path), ""
        except (BearingTwinError, OSError) as error:
            return None, "", without_log(error)

    def _finish(self, request: Request, answer: GoalAnswer) -> None:
        with self._lock:
            if request is self._running:
                self._running = None
        self._reply(request, answer)

    def _reply(self, request: Request, answer: GoalAnswer) -> None:
        """Gives a request its answer, once."""
        with self._lock:
            if request.answer is not None:
                return
            self._counts[answer.state] += 1
            self._problem = answer.problem
            self._last_problem = answer.problem or self._last_problem
            request.answer = answer
        self._ended(answer)
        request.finished.set()
        request.begin()

    def _abort(self, request: Request, reason: str) -> None:
        self._finish(request, GoalAnswer(ABORTED, reason, problem=reason))

    def _cancel(self, request: Request) -> None:
        self._finish(request, GoalAnswer(CANCELLED, "cancelled while it waited", stopped_because=CANCELLED))


def _drop_empty(log: StudyLog | None, path: str) -> str:
    """Removes a log without realisations; the path of one that has some."""
    if log is None or log.written:
        return path
    Path(path).unlink(missing_ok=True)
    return ""


def _sentence(error: Exception) -> str:
    return str(error) if isinstance(error, BearingTwinError) else f"{type(error).__name__}: {error}"
