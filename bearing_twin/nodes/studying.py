"""Studies on request, one at a time behind a short queue: what uq_node thinks, without ROS and without a thread.

A request waits from the moment it is accepted. It is read (`read`), runs in its turn (`turn`), and gets an answer in
any case: of its study, of what makes it no study, or that it was called off. Reading and running take as long as they
take, each in a thread of its own; everything else returns at once and may be called from any thread.
"""

import contextlib
import math
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable
from pathlib import Path

from bearing_twin.errors import BearingTwinError, LogError
from bearing_twin.log.study_log import StudyLog
from bearing_twin.nodes.study_goal import ABORTED, CANCELLED, SUCCEEDED, GoalAnswer, Request, study_of, told
from bearing_twin.nodes.study_limits import StudyLimits, free_path, refuse_unwritable, without_log
from bearing_twin.report import json_text
from bearing_twin.uq.drawing import Progress
from bearing_twin.uq.result import StudyResult
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import Study

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
        request.tell(*told(request.goal, request.study, progress))

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
            path = free_path(Path(self._log_folder), study.name, time.strftime("%Y%m%d_%H%M%S"))
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
