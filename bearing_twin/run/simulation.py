"""A scene in motion, advanced as far as somebody asks."""

import time
from functools import partial

import numpy as np
from numba.core import event

from bearing_twin.base.errors import BearingTwinError, IntegrationError, Interrupted, SceneError
from bearing_twin.base.report import Report
from bearing_twin.base.sample import Block, Columns, joined, layout_of, side_by_side
from bearing_twin.base.stopping import SIGNALLED, Halt, heeding_signals
from bearing_twin.kinds import KINDS
from bearing_twin.run.broken import Broken, state_of, up_to_break
from bearing_twin.run.chunks import CHUNK_NS, COMMANDING_NS, chunk_end, chunk_outputs
from bearing_twin.run.commanded import Commanded
from bearing_twin.run.failure import Failure, placed, told_of
from bearing_twin.run.fidelity import choose
from bearing_twin.run.gathering import Gathering
from bearing_twin.run.health import Health, worst_contact
from bearing_twin.run.scene import Scene
from bearing_twin.run.second_run import CheckedMotion, estimate_of, has_second_run

COMPILING = "numba:compiler_lock"  # held while a kernel is compiled or loaded


class Simulation(Commanded):
    """A scene in motion, advanced as far as somebody asks; the numbers do not depend on how it is cut.

    Integration runs in compiled code that releases the GIL, in chunks that end before sequence numbers divisible by
    their length, which is shorter for a while after a command. Commands take effect after the last output given out:
    what was computed ahead is computed again. A run that breaks off gives out what comes before, then raises.
    A long chunk ends with the error Stopped by `halt`, else by a signal; interrupted, it is computed again.
    """

    def __init__(self, scene: Scene, halt: Halt | None = None):
        self.scene, self._halt = scene, halt or Halt(SIGNALLED)
        self.kind = KINDS[scene.kind]
        self.choice = choose(scene)
        self.channels, self.output_period_ns = scene.channels, scene.output_period_ns
        self._layout = layout_of(self.channels[:-1] if scene.marked else self.channels)  # of a motion's own outputs
        self._solved_seconds, self._motion = 0.0, None
        self.reset()
        longest = getattr(self._motion, "longest_chunk", None) or 1e-9 * CHUNK_NS
        self.chunk_outputs = chunk_outputs(scene, round(1e9 * longest))

    def _new_motion(self):
        made_of = self.scene.parameters, self.choice
        if has_second_run(self.kind, *made_of):
            motion = CheckedMotion(self.kind, *made_of, self._layout.channels)
        else:
            motion = self.kind.motion(*made_of)
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
        self._pending = self._given = None  # blocks: computed and not given out yet; given out last
        self._chunk_first: int | None = None  # number of the first output of the chunk computed last
        self._commanded_until = 0  # number of an output: those before it follow a command closely
        made_of = self.scene.parameters, self.choice
        writers = self.kind.figures_of(*made_of), self.choice, self.kind.doubt(*made_of)
        self._gathering = Gathering(*writers, estimate_of(self.kind, *made_of))
        self._compute_seconds = self._solved_seconds
        self._health, self._good = Health(self.kind, self.channels), None
        self._forget_failure()

    def _forget_failure(self) -> None:
        self._broken: Broken | None = None  # nothing comes behind `_pending`
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
            raise SceneError("the failed run does not fit its scene and first model; simulate it again") from error
        begun = self._block(failure.sequence, self._motion.first_outputs())
        self._health.check(begun)
        self._pending, self._good = begun.part(1, 1), begun[0]
        self.sequence, self.time_ns = failure.sequence, int(begun.time_ns[0])

    def warm_up(self) -> float:
        """Compiles what this scene needs (or loads it from the cache) and returns the seconds it took.

        What is known when it is solved is solved here, once: that counts as computing.
        """
        start, compiling = time.perf_counter(), []
        if self.kind.known_when_solved:
            with event.install_timer(COMPILING, compiling.append):
                self._begun()
            return sum(compiling, 0.0)
        period = 1e-9 * self.output_period_ns
        with heeding_signals():
            self._new_motion().advance(np.array([min(period, 1e-6)]), min(period, 1e-6))
        return time.perf_counter() - start

    def _to_last_output(self) -> None:
        """Puts the motion back to the last output given out: what was computed ahead is computed again."""
        self._commanded_until = self.sequence + 1 + COMMANDING_NS // self.output_period_ns
        ahead = self._pending is not None and self._chunk_first is not None
        ahead = ahead and (len(self._pending) or self._broken is not None)
        self._forget_failure()
        given = self._pending.first_sequence - self._chunk_first if ahead else 1
        if ahead:
            self._motion.take_back()
            self._pending = self._pending.part(0, 0)
            self._good = self._given[-1]  # what was computed beyond it never came to be
            if given:
                times = 1e-9 * self.output_period_ns * np.arange(1, given + 1)
                self._motion.advance(times, times[-1])

    def advance(self, outputs: int) -> Block:
        """The next solver outputs, fewer where the run breaks off or was interrupted.

        Raises IntegrationError or Interrupted where there is none.
        """
        parts, missing = [], outputs
        while missing > 0:
            pending = self._begun()
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
        self._given = block = joined(parts)
        self.sequence, self.time_ns = block.first_sequence + len(block) - 1, int(block.time_ns[-1])
        self._gathering.add(block)
        return block

    def _begun(self) -> Block:
        """The outputs computed and not given out; the first of a run are those at its start."""
        if self._pending is None:
            start, compiling = time.perf_counter(), []
            with event.install_timer(COMPILING, compiling.append), heeding_signals():
                self._pending = self._block(0, self._motion.first_outputs())
            self._health.check(self._pending)
            self._good = self._pending[0]
            seconds = max(0.0, time.perf_counter() - start - sum(compiling))
            self._compute_seconds += seconds
            if self.kind.known_when_solved:
                self._solved_seconds += seconds
        return self._pending

    def _block(self, first: int, arrays) -> Block:
        numbers = arrays.numbers if isinstance(arrays, Columns) else side_by_side(self._layout, arrays, len(arrays[0]))
        numbers = np.column_stack([numbers, np.ones(len(numbers))]) if self.scene.marked else numbers
        time_ns = np.arange(first, first + len(numbers), dtype=np.int64) * self.output_period_ns
        return Block(self.channels, first, time_ns, numbers, self._motion.take_records())

    def _compute_chunk(self, first: int) -> None:
        """Puts the outputs up to the end of a chunk into `_pending`; those before where the run breaks off."""
        if self._broken is not None:
            raise self._failed(self._broken) from self._broken.error
        start, here = time.perf_counter(), (first - 1) * self.output_period_ns
        until = chunk_end(self.scene, first, self.chunk_outputs, first < self._commanded_until)
        times = 1e-9 * self.output_period_ns * np.arange(1, until - first + 1)
        state, block = state_of(self._motion), None
        try:
            block = self._advanced(first, times)
            self._health.check(block)
        except IntegrationError as error:
            begun = Broken(error, first - 1 if state is not None else -1, state)
            made = partial(self._sound, first)
            block, self._broken = up_to_break(self._motion, made, first, times, 1e-9 * here, begun, block)
        if block is not None and len(block):
            self._pending, self._chunk_first, self._good = block, first, block[len(block) - 1]
        self._compute_seconds += time.perf_counter() - start

    def _advanced(self, first: int, times: np.ndarray) -> Block:
        with heeding_signals(), self._halt.interruptible(self._motion):
            arrays = self._motion.advance(times, times[-1])
        return self._block(first, arrays)

    def _sound(self, first: int, times: np.ndarray) -> Block:
        block = self._advanced(first, times)
        self._health.check(block)
        return block

    def _failed(self, broken: Broken) -> IntegrationError:
        """The error with the time of the last output given out, and all that is needed to look into it."""
        error, *going_on = broken
        contact = error.contact or worst_contact(self.kind, self._good, self.channels, error.body)
        self.failure = placed(error, 1e-9 * self.time_ns, contact, self.scene, self._good, *going_on)
        return self.failure

    def report(self, last: bool = False) -> Report:
        """What the run cost and how far to trust it, up to the last output given out; the `last` one of a run."""
        if self.sequence < 0:
            raise BearingTwinError("nothing has been computed yet: iterate the run, or its blocks(), before its report")
        given = self.sequence + 1  # outputs computed but not given out took their share of the seconds
        share = given / (given + len(self._pending)) if self._pending is not None else 0.0
        costs = self._motion.costs()
        failure = None if self.failure is None else told_of(self.failure)
        return self._gathering.report(self.scene.name, share * self._compute_seconds, costs, last, failure)
