"""Simulation of a scene: advanced as far as requested, or run from start to end."""

import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import BearingTwinError, IntegrationError, Interrupted, SceneError, echo, progress_error
from bearing_twin.base.report import Choice, Report
from bearing_twin.base.sample import Block, Columns, Sample, join_blocks, layout_of, outputs_per_chunk, stack_channels
from bearing_twin.base.stopping import SIGNALLED, Halt, signal_flag
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import OperatingPoint
from bearing_twin.run.failure import (
    Breakdown,
    Failure,
    deepest_contact,
    failure_keys,
    outputs_before_failure,
    recorded_error,
    snapshot_of,
)
from bearing_twin.run.health import Health
from bearing_twin.run.report import ReportBuilder
from bearing_twin.run.scene import Scene, choose, load_scene
from bearing_twin.run.second_run import CheckedMotion, estimate_of, has_second_run

CHUNK_OUTPUTS = 400  # integrate at most so many outputs in one go, so that memory stays small ...
CHUNK_NS = 50_000_000  # ... and so much simulated time, for which commands wait, or `longest_chunk`
COMMANDED_NS, COMMANDING_NS = 20_000_000, 1_000_000_000  # in one go after a command, for so long


def chunk_outputs(scene: Scene, longest_ns: int) -> int:
    """The number of outputs of a chunk, of at most `longest_ns` of simulated time."""
    return max(1, min(CHUNK_OUTPUTS, outputs_per_chunk(scene.channels), longest_ns // scene.output_period_ns))


def chunk_end(scene: Scene, first: int, chunk: int, commanded: bool) -> int:
    """Number of the output before which the chunk ends that begins with `first`: a multiple of `chunk` outputs.

    It is shorter after a recent command (`commanded`).
    """
    if commanded:
        chunk = min(chunk, chunk_outputs(scene, COMMANDED_NS))
    until = first - first % chunk + chunk
    if first < scene.outputs < until:
        until = scene.outputs  # what lies beyond the end of the scene is seldom requested
    return until


LARGE = 1e9  # bytes of log or memory from which on a run is announced
COPIES = 4  # of a chunk of outputs: as computed, cut, encoded, packed
PACKED = 0.8  # size of a log's samples on disk as a share of their numbers, measured with bearing_6203
MESSAGES = 1.1  # size of a log with its other topics over its samples alone


class Cost(NamedTuple):
    """Outputs of a run, bytes of a log of all of them, and bytes of memory beyond those of any run."""

    outputs: int
    log_bytes: float
    memory_bytes: float

    def sentence(self, with_log: bool, free_bytes: float) -> str:
        """A warning of a large log, with the room on the disk, or of much memory; empty where neither is."""
        large = []
        if with_log and self.log_bytes > min(LARGE, free_bytes):
            large.append(f"a log of about {self.log_bytes:.2g} B where {free_bytes:.2g} B are free")
        if self.memory_bytes > LARGE:
            large.append(f"about {self.memory_bytes:.2g} B of memory")
        return f"{self.outputs} outputs, {' and '.join(large)}" if large else ""


def cost_of(scene: Scene) -> Cost:
    """Cost of a run of the scene, from its channels and their rate."""
    row = 8.0 * sum(channel.width for channel in scene.channels)
    together = min(CHUNK_OUTPUTS, scene.outputs)
    return Cost(scene.outputs, scene.outputs * row * PACKED * MESSAGES, COPIES * together * row)


class Simulation:
    """A scene in motion, advanced as far as requested; the numbers do not depend on the numbers of outputs requested.

    Integration runs in the core, in parallel with other threads, in chunks that end before sequence numbers divisible
    by their length, which is shorter for a while after a command. Commands take effect after the last output given
    out: outputs computed ahead are computed again. A run that breaks off returns all earlier outputs, then raises.
    A long chunk is stopped by `halt`, or by a signal, with the error Stopped; interrupted, it is computed again.
    """

    def __init__(self, scene: Scene, halt: Halt | None = None):
        self.scene, self._halt = scene, halt or Halt(SIGNALLED)
        self.kind = KINDS[scene.kind]
        self.choice = choose(scene)
        self.channels, self.output_period_ns = scene.channels, scene.output_period_ns
        self._layout = layout_of(self.channels[:-1] if scene.marked else self.channels)  # of a motion's own outputs
        self._motion = None
        self.reset()
        longest = getattr(self._motion, "longest_chunk", None) or 1e-9 * CHUNK_NS
        self.chunk_outputs = chunk_outputs(scene, round(1e9 * longest))

    def _new_motion(self):
        model = self.scene.parameters, self.choice
        if has_second_run(self.kind, *model):
            motion = CheckedMotion(self.kind, *model, self._layout.channels)
        else:
            motion = self.kind.motion(*model)
        if hasattr(motion, "stop"):
            motion.stop = self._halt.flag
        return motion

    def reset(self) -> None:
        """Back to the start: the next output is number 0 at time 0, the speed is the scene's."""
        if self._motion is None:
            self._motion = self._new_motion()
        else:
            self._motion.reset()
        self._load = None, None  # commanded; None = the scene's own
        self.sequence, self.time_ns = -1, -self.output_period_ns
        self._pending = self._last_block = None  # blocks: computed and not given out yet; given out last
        self._chunk_first: int | None = None  # number of the first output of the chunk computed last
        self._commanded_until = 0  # number of an output: those before it follow a command closely
        model = self.scene.parameters, self.choice
        writers = self.kind.figures_of(*model), self.choice, self.kind.model_errors(*model)
        self._gathering = ReportBuilder(*writers, estimate_of(self.kind, *model))
        self._compute_seconds = 0.0
        self._health, self._last_good = Health(self.kind, self.channels), None
        self._forget_failure()

    def _forget_failure(self) -> None:
        self._breakdown: Breakdown | None = None  # nothing comes behind `_pending`
        self.failure: IntegrationError | None = None  # what was raised for it

    def resume(self, failure: Failure) -> None:
        """Back to the last good state of a run that failed; to the start where there is none.

        Raises SceneError for a state that is not of this scene, or not of the model that it begins with.
        """
        self.reset()
        if failure.state is None:
            return
        try:
            self._motion.resume(failure.state)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            fault = "the state to go on from does not fit its scene and first model; it may be of an earlier version"
            raise SceneError(f"{fault}: simulate the scene again") from error
        start = self._block(failure.sequence, self._motion.first_outputs())
        self._health.check(start)
        self._pending, self._last_good = start.part(1, 1), start[0]
        self.sequence, self.time_ns = failure.sequence, int(start.time_ns[0])

    def _rewind(self) -> None:
        """Return the motion to the last output given out: outputs ahead of it are computed again."""
        self._commanded_until = self.sequence + 1 + COMMANDING_NS // self.output_period_ns
        ahead = self._pending is not None and self._chunk_first is not None
        ahead = ahead and (len(self._pending) or self._breakdown is not None)
        self._forget_failure()
        output_count = self._pending.first_sequence - self._chunk_first if ahead else 1
        if ahead:
            self._motion.take_back()
            self._pending = self._pending.part(0, 0)
            self._last_good = self._last_block[-1]  # what was computed beyond it never came to be
            if output_count:
                times = 1e-9 * self.output_period_ns * np.arange(1, output_count + 1)
                self._motion.advance(times, times[-1])

    def advance(self, outputs: int) -> Block:
        """The next solver outputs, fewer where the run breaks off or was interrupted.

        Raises IntegrationError or Interrupted where there is none.
        """
        parts, missing = [], outputs
        while missing > 0:
            pending = self._computed()
            if not len(pending):
                try:
                    self._compute_chunk(pending.first_sequence)
                except (Interrupted, IntegrationError):
                    if not parts:
                        raise
                    break
                continue
            take = min(len(pending), missing)
            parts.append(pending.part(0, take))
            self._pending = pending.part(take, len(pending))
            missing -= take
        self._last_block = block = join_blocks(parts)
        self.sequence, self.time_ns = block.first_sequence + len(block) - 1, int(block.time_ns[-1])
        self._gathering.add(block)
        return block

    def set_speed(self, speed: float) -> str:
        """New goal [rad/s] for the speed of inner ring or shaft, approached at the drive's acceleration from now on.

        Returns a warning of a speed above the limiting one, "" for others. Raises BearingTwinError, and changes
        nothing, where the load is not carried at this speed, or a torque turns it.
        """
        self._refuse_without("check_drive", "speed")
        warning = self._motion.check_drive("speed", float(speed), self._load)
        self._rewind()
        self._motion.goal_speed = float(speed)
        return warning

    def set_torque(self, torque: float) -> None:
        """New torque [N m] on the inner ring about +z; raises BearingTwinError where the speed is prescribed."""
        self._refuse_without("check_drive", "torque")
        self._motion.check_drive("torque", float(torque), self._load)
        self._rewind()
        self._motion.set_torque(float(torque))

    def set_load(self, force, moment) -> None:
        """New force (3,) [N] and moment (2,) or (3,) [N m] on the inner ring or the shaft, from now on.

        None for both: the scene's own. Raises BearingTwinError, and changes nothing, for what the scene cannot carry.
        """
        if force is not None:
            self._refuse_without("check_load", "load")
            self._motion.check_load(force, moment)
        self._rewind()
        self._load = force, moment
        self._motion.set_load(force, moment)

    def operating_point(self) -> tuple[Sample, OperatingPoint]:
        """The last output given out, or the first, with loads and stiffness there; raises BearingTwinError."""
        self._refuse_without("operating_point", "stiffness")
        sample = (self._computed() if self._last_block is None else self._last_block)[-1]
        return sample, self._motion.operating_point(sample)

    def _refuse_without(self, method: str, noun: str) -> None:
        if not hasattr(self._motion, method):
            raise BearingTwinError(f"a scene of the kind {self.kind.name} has no {noun}; a bearing has")

    def _computed(self) -> Block:
        """The outputs computed and not given out; the first of a run are those at its start."""
        if self._pending is None:
            start = time.perf_counter()
            with signal_flag():
                self._pending = self._block(0, self._motion.first_outputs())
            self._health.check(self._pending)
            self._last_good = self._pending[0]
            self._compute_seconds += time.perf_counter() - start
        return self._pending

    def _block(self, first: int, arrays) -> Block:
        numbers = (
            arrays.numbers if isinstance(arrays, Columns) else stack_channels(self._layout, arrays, len(arrays[0]))
        )
        numbers = np.column_stack([numbers, np.ones(len(numbers))]) if self.scene.marked else numbers
        time_ns = np.arange(first, first + len(numbers), dtype=np.int64) * self.output_period_ns
        return Block(self.channels, first, time_ns, numbers, self._motion.take_records())

    def _compute_chunk(self, first: int) -> None:
        """Compute the outputs up to the end of a chunk into `_pending`, or up to where the run breaks off."""
        if self._breakdown is not None:
            raise self._recorded_failure(self._breakdown) from self._breakdown.error
        start, start_ns = time.perf_counter(), (first - 1) * self.output_period_ns
        until = chunk_end(self.scene, first, self.chunk_outputs, first < self._commanded_until)
        times = 1e-9 * self.output_period_ns * np.arange(1, until - first + 1)
        state, block = snapshot_of(self._motion), None
        self._chunk_state = first - 1, state
        try:
            block = self._advance_motion(first, times)
            self._health.check(block)
        except IntegrationError as error:
            restart = Breakdown(error, first - 1 if state is not None else -1, state)
            compute = partial(self._checked_chunk, first)
            block, self._breakdown = outputs_before_failure(
                self._motion, compute, first, times, 1e-9 * start_ns, restart, block
            )
        if block is not None and len(block):
            self._pending, self._chunk_first, self._last_good = block, first, block[len(block) - 1]
        self._compute_seconds += time.perf_counter() - start

    def _advance_motion(self, first: int, times: np.ndarray) -> Block:
        with signal_flag(), self._halt.interruptible(self._motion):
            arrays = self._motion.advance(times, times[-1])
        return self._block(first, arrays)

    def _checked_chunk(self, first: int, times: np.ndarray) -> Block:
        block = self._advance_motion(first, times)
        self._health.check(block)
        return block

    def _recorded_failure(self, broken: Breakdown) -> IntegrationError:
        """The error with the time of the last output given out, and the record of the failure."""
        error, *restart = broken
        contact = error.contact or deepest_contact(self.kind, self._last_good, self.channels, error.body)
        self.failure = recorded_error(error, 1e-9 * self.time_ns, contact, self.scene, self._last_good, *restart)
        return self.failure

    @property
    def state(self) -> tuple[int, dict] | None:
        """Number of an output and the state of the motion there, to continue from; None of a motion without one.

        It is the last one at the end of a whole chunk: after a chunk that the end of a scene cuts short steps differ.
        """
        if self._pending is None or len(self._pending) or self._breakdown is not None or self._chunk_first is None:
            return None
        at_chunk_end = (self.sequence + 1) % self.chunk_outputs == 0
        sequence, state = (self.sequence, snapshot_of(self._motion)) if at_chunk_end else self._chunk_state
        return None if state is None else (sequence, state)

    def report(self, last: bool = False) -> Report:
        """The report up to the last output given out: figures, errors, cost; the `last` one of a run."""
        if self.sequence < 0:
            raise BearingTwinError("nothing has been computed yet: iterate the run, or its blocks(), before its report")
        outputs = self.sequence + 1  # outputs computed but not given out took their share of the seconds
        share = outputs / (outputs + len(self._pending)) if self._pending is not None else 0.0
        costs = self._motion.costs()
        failure = None if self.failure is None else failure_keys(self.failure)
        return self._gathering.report(self.scene.name, share * self._compute_seconds, costs, last, failure)


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
        """The error that ended the run, if one did."""
        return self.simulation.failure

    @property
    def state(self) -> tuple[int, dict] | None:
        """See `Simulation.state`."""
        return self.simulation.state

    @property
    def begins(self) -> int:
        """Number of the first output, above 0 for a run that continues another."""
        return self._failure.sequence + 1 if self._failure and self._failure.state is not None else 0

    @property
    def outputs(self) -> int:
        """Number of outputs of the whole run, the one at time zero included."""
        return self.scene.outputs

    def blocks(self) -> Iterator[Block]:
        """The run in blocks of up to 400 outputs, whole chunks of the integration, from the start or the failure.

        Continuing a pass after another has begun raises BearingTwinError.
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

    def __repr__(self) -> str:
        model = f"{self.choice.law} and {self.choice.stepper}"
        return (
            f"Run of {self.scene.name}: {self.outputs} outputs in {self.scene.parameters.run.duration:.6g} s by {model}"
        )

    def __reduce__(self):
        raise BearingTwinError("a run cannot be copied or sent: take its scene, report, blocks or log")

    def to_xarray(self) -> Any:
        """The whole run, computed now, as an `xarray.Dataset` (extra `export`); see `dataset_of`."""
        from bearing_twin.run.dataset import dataset_of

        return dataset_of(self)


def simulate(
    scene: Scene | str | PathLike | Mapping,
    progress: Callable[[float], None] | None = None,
    failure: Failure | None = None,
) -> Run:
    """A run of a scene; nothing is computed before it is iterated.

    Parameters
    ----------
    scene : Scene, str, path or mapping
        A scene, or what `load_scene` takes.
    progress : function, optional
        Called with the share done, up to 1, after each block.
    failure : Failure, optional
        The run starts from the last good state of a run that failed (`run.failure.read_failure`), or from the end of
        that in a log (`run.failure.continuation`).

    Returns
    -------
    Run
        Iterated it gives one `Sample` an output, `blocks()` many outputs at once: `sample["normal_load"]` is an array
        of the shape, unit and frame that the channel of that name in `channels` states. `report` has the figures with
        their SI units and the error estimates, `to_xarray()` the whole run.

    Raises
    ------
    SceneError
        For a scene that cannot be used.
    IntegrationError
        While iterating, where the integration breaks off: `reason`, `seconds`, `body` and `contact` say where.

    Examples
    --------
    >>> import bearing_twin
    >>> run = bearing_twin.simulate("two_spheres")
    >>> max(float(sample["normal_load"]) for sample in run) > 1e5  # N
    True
    """
    if progress is not None and not callable(progress):
        raise SceneError(progress_error(progress, "load_scene"))
    if failure is not None and not isinstance(failure, Failure):
        raise SceneError(f"failure = {echo(failure)} must be a Failure, as read_failure gives it")
    return Run(scene if isinstance(scene, Scene) else load_scene(scene), progress, failure)
