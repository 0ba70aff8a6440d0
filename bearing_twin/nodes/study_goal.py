"""A goal of the action run_study without ROS: what is asked, the study it makes, and how it is answered."""

import math
import threading
from collections.abc import Callable, Iterable
from typing import NamedTuple

from bearing_twin.errors import StudyError
from bearing_twin.permission import only_below
from bearing_twin.run.scene import refuse_another
from bearing_twin.uq.drawing import Progress
from bearing_twin.uq.stopping import rule_of
from bearing_twin.uq.study import Study
from bearing_twin.uq.study_file import load_study, parse_study, study_names

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
    most; see `told`.
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


def told(goal: Goal, study: Study, progress: Progress) -> tuple[Progress, str]:
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
