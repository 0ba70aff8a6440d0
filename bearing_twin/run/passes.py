"""A scene in, a stream of samples and a report out."""

from collections.abc import Callable, Iterator, Mapping
from os import PathLike
from typing import Any

from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError
from bearing_twin.base.messages import no_progress
from bearing_twin.base.report import Choice, Report
from bearing_twin.base.sample import Block, Sample
from bearing_twin.run.dataset import dataset_of
from bearing_twin.run.failure import Failure
from bearing_twin.run.scene import Scene, load_scene
from bearing_twin.run.simulation import Simulation


class Run:
    """A pass through a scene from start to end; iterate it for `Sample`s or its `blocks()`, then read `report`.

    With a `failure` it goes on from the last good state of that run.
    """

    def __init__(self, scene: Scene, progress: Callable[[float], None] | None = None, failure: Failure | None = None):
        self.scene, self.simulation = scene, Simulation(scene)
        self.channels = self.simulation.channels
        self._progress, self._failure, self._passes = progress, failure, 0

    @property
    def choice(self) -> Choice:
        """Law and stepper in use, and why."""
        return self.simulation.choice

    @property
    def report(self) -> Report:
        """The report on what has been iterated so far; raises BearingTwinError before the first output."""
        return self.simulation.report()

    @property
    def failure(self) -> IntegrationError | None:
        """What broke the run off, if anything did."""
        return self.simulation.failure

    @property
    def outputs(self) -> int:
        """Number of outputs of the whole run, the one at time zero included."""
        return self.scene.outputs

    def blocks(self) -> Iterator[Block]:
        """The run in blocks of up to 400 outputs, whole chunks of the integration, from the start or the failure.

        A pass that is gone on with after another has begun raises BearingTwinError.
        """
        self._passes += 1
        number = self._passes
        if self._failure is None:
            self.simulation.reset()
        else:
            self.simulation.resume(self._failure)
        done, total = self.simulation.sequence + 1, self.outputs
        while done < total:
            if number != self._passes:
                raise BearingTwinError("the run has been begun anew meanwhile; make a run for each pass by `simulate`")
            chunk = self.simulation.chunk_outputs  # a run that goes on with a failure may begin inside one
            block = self.simulation.advance(min(chunk - done % chunk, total - done))
            done += len(block)
            if self._progress:
                self._progress(done / total)
            yield block

    def __iter__(self) -> Iterator[Sample]:
        for block in self.blocks():
            yield from block

    def __reduce__(self):
        raise BearingTwinError("a run cannot be copied or sent: take its scene, report, blocks or log")

    def to_xarray(self) -> Any:
        """The whole run, computed now, as an `xarray.Dataset` (extra `export`); see `dataset_of`."""
        return dataset_of(self)


def simulate(
    scene: Scene | str | PathLike | Mapping,
    progress: Callable[[float], None] | None = None,
    failure: Failure | None = None,
) -> Run:
    """A run of the scene, or of that by its name, path or plain data; nothing is computed before it is iterated.

    `progress` is called with the share done after each block. It goes on from the last good state of a `failure`.
    """
    if progress is not None and not callable(progress):
        raise SceneError(no_progress(progress, "load_scene"))
    return Run(scene if isinstance(scene, Scene) else load_scene(scene), progress, failure)
