"""Studies of uq_node, without ROS: reading a goal, running its study with a log, and the answer."""

import contextlib
import dataclasses
import itertools
import math
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from bearing_twin.base.errors import BearingTwinError, LogError, StudyError, echo
from bearing_twin.base.paths import file_name, restrict_reading
from bearing_twin.base.process import processor_count
from bearing_twin.base.report import json_text
from bearing_twin.kinds.rules import ON
from bearing_twin.log.study_log import StudyLog
from bearing_twin.nodes.node_parameters import ALLOW_INVALID, NOT_ALLOWED
from bearing_twin.uq.run import Progress, memory_needed, refuse_too_large, run_study
from bearing_twin.uq.study import Study, load_study, parse_study, study_names

LONGEST_TEXT = 60_000  # characters of a study in a goal: any such text is read in less than a second
MOST_OVERRIDES, LONGEST_OVERRIDE = 1000, 10_000
SUCCEEDED, ABORTED, CANCELLED = "succeeded", "aborted", "cancelled"
FEEDBACK_PERIOD = 0.1  # s


class Goal(NamedTuple):
    """A request: name, path or YAML text of a study, and overrides; `samples` and `seed` 0 = those of the study."""

    study: str
    overrides: tuple[str, ...] = ()
    samples: int = 0
    seed: int = 0


class GoalAnswer(NamedTuple):
    """End of a goal (SUCCEEDED, ABORTED or CANCELLED), a sentence about it, and the result, if any.

    `problem` is a sentence for the operator of the node, empty if all is well.
    """

    state: str
    message: str
    summary: str = ""
    log: str = ""
    stopped_because: str = ""
    problem: str = ""


def aborted(error: Exception) -> GoalAnswer:
    """The answer to a goal that an error ended."""
    reason = str(error) if isinstance(error, BearingTwinError) else f"{type(error).__name__}: {error}"
    return GoalAnswer(ABORTED, reason, stopped_because=f"failed: {reason}", problem=reason)


def feedback_of(goal: Goal, study: Study, progress: Progress) -> dict[str, int | float | str]:
    """Progress as the fields of the action's feedback: in requested samples, without NaN.

    A study with a sweep, with an expansion or with sensitivity indices does another number of runs than the requested
    samples: `done` is then the same share of the samples as of the runs. Before the first statistic is known its name
    is empty, and estimate and half width are 0; an unknown half width is infinite.
    """
    total = goal.samples or study.settings.samples
    done = progress.done if progress.total == total else int(total * progress.done / max(progress.total, 1))
    name, estimate, half_width = "", 0.0, 0.0
    if math.isfinite(progress.estimate):
        name = " at ".join(filter(None, (study.settings.stop.watched, progress.at)))
        estimate = float(progress.estimate)
        half_width = math.inf if math.isnan(progress.half_width) else float(progress.half_width)
    counts = {"done": min(done, total), "total": total, "seconds_left": float(progress.seconds_left)}
    return counts | {"quantity": name, "estimate": estimate, "half_width": half_width}


def study_of(goal: Goal, folders: Iterable[str] = ()) -> Study:
    """The study of a goal: text with several lines or in braces is YAML, all else a name or a path.

    Files, including those that a study names, are read only below `folders`. Raises BearingTwinError.
    """
    if len(goal.study) > LONGEST_TEXT:
        raise StudyError(f"the study has {len(goal.study)} characters, more than {LONGEST_TEXT}; put it into a file")
    if len(goal.overrides) > MOST_OVERRIDES or any(len(override) > LONGEST_OVERRIDE for override in goal.overrides):
        raise StudyError(f"overrides must be at most {MOST_OVERRIDES}, each of {LONGEST_OVERRIDE} characters at most")
    overrides = [override for override in goal.overrides if override]
    overrides += [f"{key}={value}" for key, value in (("samples", goal.samples), ("seed", goal.seed)) if value]
    text = goal.study.strip()
    with restrict_reading(folders, "the folders of the node's parameter study_folders"):
        if not text:
            raise StudyError(f"which study? give a name, a path or YAML; legal: {', '.join(study_names())}")
        if "\n" in text or text.startswith("{"):
            return parse_study(goal.study, "study goal", overrides)
        return load_study(text, overrides)


class StudyLimits(NamedTuple):
    """The node's limits: `memory` [B] and `samples` of a study, `workers` (0 = one a processor), `time_limit` [s].

    `log_quota` [B] limits the size of the logs in their folder before another one, `executors` where a study may run.
    0 = no limit. `allow_invalid`: whether a study may let models run outside their ranges.
    """

    memory: float = 2e9
    workers: int = 0
    time_limit: float = 0.0
    samples: int = 0
    log_quota: float = 0.0
    executors: Sequence[str] = ("processes",)
    allow_invalid: bool = False

    def bounded(self, study: Study) -> Study:
        """The study with as many workers as it may have; raises StudyError beyond the limits."""
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
                f"samples = {self.samples}; request fewer"
            )
        refuse_too_large(study)
        needed = memory_needed(study)
        if needed > self.memory:
            raise StudyError(
                f"study {study.name} would need {needed:.3g} B, more than the node's parameter memory = "
                f"{self.memory:.3g} B; request fewer samples, histories or history_points"
            )
        limit = self.workers or processor_count()
        workers = min(study.settings.workers or limit, limit)
        return dataclasses.replace(study, settings=dataclasses.replace(study.settings, workers=workers))

    def refuse_full(self, folder: Path) -> None:
        """Raises LogError where the logs in `folder` take more than `log_quota`."""
        size = sum(path.stat().st_size for path in folder.glob("*.mcap"))
        if self.log_quota and size > self.log_quota:
            raise LogError(
                f"the logs in {folder} take {size:.3g} B, more than the node's parameter log_quota = "
                f"{self.log_quota:.3g} B; move some away"
            )


def refuse_unwritable(folder: Path) -> None:
    """Raises LogError where `folder` cannot be made, or takes no file."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    try:
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        raise LogError(
            f"log_folder {folder} cannot be made or written ({error.strerror}); give another one, or none"
        ) from error


def log_problem(error: LogError | OSError) -> str:
    """The sentence about a study whose log could not be made or written."""
    system = isinstance(error, OSError)
    reason = f"{error.filename or 'its file'} cannot be written ({error.strerror})" if system else error
    return f"its log was not written: {reason}"


def free_path(folder: Path, study: str, date: str) -> Path:
    """Path of a new log in `folder`: `<study>_<date>.mcap`, with a number where that exists."""
    stem = f"{file_name(study)}_{date}"
    paths = (folder / f"{stem}{f'_{number}' if number > 1 else ''}.mcap" for number in itertools.count(1))
    return next(path for path in paths if not path.exists())


class Studies:
    """The studies of goals, run one after the other in the thread that calls `run`.

    Parameters
    ----------
    log_folder : str
        Folder for a log of every study; empty = none.
    limits : StudyLimits
        What a study may use, whatever it specifies itself.
    folders : iterable of str
        Folders in which files may be read for a goal.
    run_study, open_log : function
        Those of the library.
    clock : function
        Monotonic time [s].

    Raises
    ------
    LogError
        If `log_folder` cannot be made or written.
    """

    def __init__(
        self,
        log_folder: str = "",
        limits: StudyLimits = StudyLimits(),  # noqa: B008 - it cannot change
        folders: Iterable[str] = (),
        run_study: Callable = run_study,
        open_log: Callable = StudyLog,
        clock: Callable[[], float] = time.monotonic,
    ):
        if log_folder:
            refuse_unwritable(Path(log_folder))
        self._log_folder, self._limits, self._folders = log_folder, limits, tuple(folders)
        self._run_study, self._open_log, self._clock = run_study, open_log, clock
        self._running, self._progress, self._moved = "", None, 0.0
        self.closing = False  # ends the running study, with a log of its samples
        self._counts = Counter()
        self._problem = self._last_problem = ""  # of the last goal, and of the last goal that had one

    def read(self, goal: Goal) -> Study:
        """The study of a goal within the limits of the node; raises BearingTwinError."""
        return self._limits.bounded(study_of(goal, self._folders))

    def run(
        self,
        goal: Goal,
        study: Study,
        cancelled: Callable[[], bool] = lambda: False,
        tell: Callable[[dict], None] = lambda feedback: None,
    ) -> GoalAnswer:
        """The answer to a goal, once its study has ended; `tell` gets feedback, ten times a second at most."""
        self._running, self._progress, self._moved = study.name, None, self._clock()
        ends_at = self._moved + (self._limits.time_limit or math.inf)
        tell_at = -math.inf

        def update(progress: Progress) -> None:
            nonlocal tell_at
            self._progress, self._moved = progress, self._clock()
            if self._moved >= tell_at:
                tell_at = self._moved + FEEDBACK_PERIOD
                tell(feedback_of(goal, study, progress))

        def ends() -> bool:
            return self.closing or cancelled() or self._clock() > ends_at

        result, (log, path, no_log) = None, self._new_log(study)
        try:
            with contextlib.ExitStack() as stack:
                keep = {"keep": stack.enter_context(log).add} if log else {}
                result = self._run_study(study, update, ends, **keep)
                if log:
                    log.finish(result)
        except Exception as error:  # of any kind: the next study is served
            if result is None or not isinstance(error, (LogError, OSError)):
                _drop_empty(log, path)
                return aborted(error)
            path, no_log = "", log_problem(error)
        finally:
            self._running = ""
        summary = result.as_dict()
        state, because = SUCCEEDED, summary["stopped_because"]
        if cancelled():
            state, because = CANCELLED, CANCELLED
        elif self.closing:
            state, because = ABORTED, "the node was ended"
        elif self._clock() > ends_at and because == CANCELLED:
            state, because = ABORTED, f"the node's parameter time_limit = {self._limits.time_limit:g} s was reached"
        elif because.startswith("failed"):
            state = ABORTED
        path = path if state == SUCCEEDED else _drop_empty(log, path)
        failed = sum(summary["failed"].values())
        message = f"{summary['samples']} samples, {failed} failed, {summary['seconds']:.3g} s; {because}"
        if no_log:
            message += f"; {no_log}"
            summary["notes"] = [*summary["notes"], no_log]  # clients read the summary rather than the message
        problem = message if state == ABORTED else no_log
        summary |= {"log": path} if path else {}
        return GoalAnswer(state, message, json_text(summary), path, because, problem)

    def note(self, answer: GoalAnswer) -> None:
        """Counts an answer that was given."""
        self._counts[answer.state] += 1
        self._problem = answer.problem
        self._last_problem = answer.problem or self._last_problem

    def note_refusal(self, reason: str) -> None:
        """Counts a goal that was not accepted."""
        self._counts["refused"] += 1
        self._problem = self._last_problem = reason

    def status(self) -> tuple[str, str, dict]:
        """Current activity, problem of the last goal ("" if none), and numbers, for diagnostics."""
        study, progress = self._running, self._progress if self._running else None
        silence = self._clock() - self._moved if study else 0.0
        values = {
            "study": study,
            "done": progress.done if progress else 0,
            "total": progress.total if progress else 0,
            "seconds_left": float(progress.seconds_left) if progress else 0.0,
            "seconds_without_progress": silence,
            **{key: self._counts[key] for key in (SUCCEEDED, ABORTED, CANCELLED, "refused")},
            "last_error": self._last_problem,
        }
        return f"running {study}" if study else "idle", self._problem, values

    def _new_log(self, study: Study) -> tuple[StudyLog | None, str, str]:
        """Log, its absolute path, and why there is none; it is filled during the study, and so outlives a crash."""
        if not self._log_folder:
            return None, "", ""
        folder = Path(self._log_folder).resolve()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._limits.refuse_full(folder)
            path = free_path(folder, study.name, time.strftime("%Y%m%d_%H%M%S"))
            return self._open_log(study, path), str(path), ""
        except (BearingTwinError, OSError) as error:
            return None, "", log_problem(error)


def _drop_empty(log: StudyLog | None, path: str) -> str:
    """Removes a log without realisations; the path of one that has some."""
    if log is None or log.written:
        return path
    Path(path).unlink(missing_ok=True)
    return ""
