"""What a study may use in uq_node, whatever its goal says, and where it is logged."""

import contextlib
import dataclasses
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from bearing_twin.errors import LogError, StudyError
from bearing_twin.kinds.ranges import ON
from bearing_twin.log.study_log import INPUT, QUANTITY
from bearing_twin.nodes.node_parameters import ALLOW_INVALID, NOT_ALLOWED
from bearing_twin.parameters import echo
from bearing_twin.paths import file_name
from bearing_twin.processors import usable
from bearing_twin.uq.run import memory_needed, refuse_too_large
from bearing_twin.uq.study import Study

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
    """Raises LogError where no log can be put into `folder`; what is missing is made for the trial and taken away."""
    made: list[Path] = []
    try:
        if folder.exists() and not folder.is_dir():
            raise LogError(f"log_folder {folder} is a file; give a folder, or nothing for no logs")
        for one in reversed([folder, *folder.parents]):
            if not one.exists():
                one.mkdir()
                made.append(one)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise LogError(
            f"log_folder {folder} cannot be made or written ({error.strerror}); give another, or nothing for no logs"
        ) from error
    finally:
        with contextlib.suppress(OSError):  # another process may have put something there
            for one in reversed(made):
                one.rmdir()


def without_log(error: LogError | OSError) -> str:
    """What is told of a study whose log could not be made or written."""
    system = isinstance(error, OSError)
    reason = f"{error.filename or 'its file'} cannot be written ({error.strerror})" if system else error
    return f"there is no log of it, because {reason}"


def free_path(folder: Path, study: str, date: str) -> Path:
    """Where to log a study: `<study>_<date>.mcap`, with a number where that is taken."""
    stem = f"{file_name(study)}_{date}"
    path, number = folder / f"{stem}.mcap", 1
    while path.exists():
        number += 1
        path = folder / f"{stem}_{number}.mcap"
    return path
