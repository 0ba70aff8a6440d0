"""A simulation as a paced stream of messages that takes commands: the work of sim_node without ROS or clocks."""

import math
import threading
from collections import Counter, deque
from collections.abc import Callable, Container
from pathlib import Path

from bearing_twin.base.errors import BearingTwinError, IntegrationError, Interrupted, echo
from bearing_twin.kinds.contract import Command
from bearing_twin.log.stream import MessageStream
from bearing_twin.nodes.pacing import LAG_SHOWN, PacedStream, Timed
from bearing_twin.run.simulation import Simulation

CHUNK_NS = 20_000_000  # of outputs computed together: a command acts within this time
LONGEST_STEP = 10.0  # s
SHORTFALL = 0.95  # of the requested pace, below which the loop warns
REPORT_NS = 1_000_000_000  # of simulated time between reports of the run's errors
GREATEST_SPEED = 10_000.0  # rad/s, beyond what any bearing of these sizes survives
WAITING = 8  # commands of one topic, of which the last legal one is carried out


class Commands:
    """Commands that wait, their counts, and the time at which a load becomes stale; `load_timeout_ns` 0 = never.

    A load holds until the next. One that is not followed by another within the timeout, in simulated time from the
    output it began after, is stale: the scene's own load acts again, and a warning stands until a new load comes.
    """

    def __init__(self, load_timeout_ns: int = 0, frame_prefix: str = ""):
        self.counts = Counter(taken=0, refused=0, superseded=0)
        self.refusals: deque[str] = deque(maxlen=WAITING)  # to be logged
        self.speed_warning = ""  # the first, to be logged
        self.prefix = frame_prefix
        self._waiting: dict[Command, deque] = {}
        self._lock = threading.Lock()
        self._timeout, self._last, self._reported = load_timeout_ns, "-", 0
        self.note_load(None)

    @property
    def waiting(self) -> bool:
        """True if a command is to be carried out."""
        return bool(self._waiting)

    def offer(self, command: Command, message) -> None:
        """Lets a message of the topic `command` wait; from any thread."""
        with self._lock:
            queue = self._waiting.setdefault(command, deque(maxlen=WAITING))
            self.counts["superseded"] += len(queue) == WAITING
            queue.append(message)

    def carry_out(self, execute: Callable[[Command, object], None]) -> None:
        """Carries out the last command of each topic that `execute` does not refuse; earlier ones are superseded."""
        with self._lock:
            waiting, self._waiting = self._waiting, {}
        for command, queue in waiting.items():
            while queue:
                try:
                    execute(command, queue.pop())
                    break
                except BearingTwinError as error:
                    self.refusals.append(str(error))
            self.counts["superseded"] += len(queue)

    def refused(self, name: str, error: Exception) -> BearingTwinError:
        """Counts a refused command on the topic `name`; returns the error to raise."""
        self.counts["refused"] += 1
        self._last = f"{name} refused: {error if isinstance(error, BearingTwinError) else repr(error)}"
        return BearingTwinError(self._last)

    def note_load(self, time_ns: int | None, stale: bool = False) -> None:
        """A commanded load acts from the output after `time_ns` on; None: the scene's own acts, the last is `stale`."""
        self._stale = stale
        self._source = "the scene" if time_ns is None else "command/load"
        self._stale_at = max(time_ns, 0) + self._timeout if self._timeout and time_ns is not None else None

    def fresh_outputs(self, time_ns: int, period_ns: int) -> float:
        """Number of outputs after `time_ns` for which the load holds; infinite if it does not become stale."""
        return math.inf if self._stale_at is None else max(0, math.ceil((self._stale_at - time_ns) / period_ns))

    def warning(self) -> str:
        """A stale load, and refusals since the last call; "" if nothing."""
        new, self._reported = self.counts["refused"] - self._reported, self.counts["refused"]
        stale = f"command/load is stale, {self._timeout * 1e-9:g} s without another: the scene's load acts"
        sentences = stale if self._stale else "", f"{new} refused, the last: {self._last}" if new else ""
        return "; ".join(filter(None, sentences))

    def numbers(self) -> dict[str, object]:
        """For diagnostics."""
        counts = {f"commands_{key}": count for key, count in self.counts.items()}
        return {**counts, "last_refusal": self._last, "load_from": self._source}


def log_path(path: str | Path, run: int) -> Path:
    """Path of the log of run 1, 2, 3 ...: run.mcap, run_2.mcap, run_3.mcap ..."""
    path = Path(path)
    return path if run == 1 else path.with_name(f"{path.stem}_{run}{path.suffix}")


class SimulationLoop(PacedStream):
    """A simulation that is computed ahead by a chunk, and whose messages are delivered when they are due.

    Every method runs in the worker's thread, except `status`. `run` counts from 1. A run that fails raises
    IntegrationError. One without an end that peers have changed, by commands or another scene, keeps it as `failure`
    instead and waits for a reset.

    Parameters
    ----------
    simulation : Simulation
    deliver : function
        Sends one `Timed` message.
    factor : float or str
        Multiple of real time, or FASTEST.
    duration_ns : int
        Simulated time of a run; 0 = endless.
    open_log : function
        Gives the log writer of a run by its number and simulation, or None. A reset begins the next run; a repeat sends
        the same messages again and is not logged.
    repeat_ns : int
        Wall time from one begin of a run to the next, 0 = once; below 0 a run that has ended waits for a reset.
    subscribed : function, optional
        Gives the names of the topics with subscribers, the only ones that are made where there is no log.
    commands : Commands, optional
    command_ns : int
        Shortest wall time between two times at which the waiting commands are carried out.
    """

    def __init__(
        self,
        simulation: Simulation,
        deliver: Callable[[Timed], None],
        factor: float | str = 1.0,
        duration_ns: int = 0,
        open_log: Callable[[int, Simulation], object] = lambda run, simulation: None,
        repeat_ns: int = 0,
        subscribed: Callable[[], Container[str]] | None = None,
        commands: Commands | None = None,
        command_ns: int = 0,
    ):
        super().__init__(deliver, factor)
        self.run = 1
        self.commands, self._command_ns, self.commands_at = commands or Commands(), command_ns, 0
        self._duration_ns, self._open_log, self._repeat, self._subscribed = duration_ns, open_log, repeat_ns, subscribed
        self._begin(simulation, open_log(1, simulation))

    def _begin(self, simulation: Simulation, log) -> None:
        self.simulation, self._log, period = simulation, log, simulation.output_period_ns
        self._stream = MessageStream(simulation.scene, choice=simulation.choice, frame_prefix=self.commands.prefix)
        self._chunk = max(1, min(CHUNK_NS // period, simulation.chunk_outputs))
        self._total = self._duration_ns // period + 1 if self._duration_ns else None
        self._done = self._flushed = False
        self.failure: IntegrationError | None = None
        self._began: int | None = None
        self._report_at = 0
        self._errors: dict[str, float | str] = {}
        self.restart()

    @property
    def over(self) -> bool:
        """True once everything was delivered and no further run can start."""
        return self.finished and not self._repeat and self.failure is None

    def turn(self, now: int) -> int | None:
        """Delivers what is due at `now`; returns the wall time of the next turn, None if it needs a command."""
        if now >= self.commands_at:
            self._execute_waiting(now)
        wake_at = self._run_on(now)
        if not self.commands.waiting:
            return wake_at
        return self.commands_at if wake_at is None else min(wake_at, self.commands_at)

    def _run_on(self, now: int) -> int | None:
        if self._began is None and not self.paused:
            self._began = now
        try:
            wake_at = super().turn(now)
        except IntegrationError as error:
            changed, ends = self.run > 1 or self.commands.counts["taken"], self._total is not None and not self._repeat
            if ends or not changed:
                raise
            self.failure, self._done, self.finished = error, True, True
            self._errors = errors_of(self.simulation.report())
        if not self.finished or self.over:
            return wake_at
        self.close()
        if self._repeat < 0 or self.paused or self.failure:
            return None
        if now < self._began + self._repeat:
            return self._began + self._repeat
        self._begin_again(self.simulation, None)
        return now

    def _execute_waiting(self, now: int) -> None:
        if self.commands.waiting:
            self.commands_at = now + self._command_ns
            self.commands.carry_out(self.execute)

    def status(self, now: int = 0) -> tuple[bool, str, dict[str, float | str]]:
        """Failure to keep up, state, and numbers since the last call; from any thread.

        `now` is the wall time [ns], by which outputs that are computed meanwhile may be late.
        """
        requested, numbers, slow = float(self.factor), self.progress(), False
        factor, lateness = numbers["real_time_factor"], self._late_s(now)
        numbers["lag_s"] = max(numbers["lag_s"], lateness)
        if self.failure:
            message = f"{self.failure}; the node waits for ~/reset"
        elif self.paused:
            message = "paused"
        elif self.finished and not self.over:
            message = "waiting for the next start"
        elif not self._started:
            message = "computing the first outputs"
        elif lateness > LAG_SHOWN or (numbers["lag_s"] > LAG_SHOWN and 0.0 < factor < SHORTFALL * requested):
            slow = True
            message = f"cannot keep up: {factor:.3g} of {requested:g} times real time, {numbers['lag_s']:.3g} s behind"
        else:
            message = "running" if requested else "running as fast as possible"
        choice = self.simulation.choice
        numbers |= {
            "simulation_time_s": self.position_ns * 1e-9,
            "outputs": self.simulation.sequence + 1,
            "runs": self.run,
            **self.commands.numbers(),
            "law": choice.law,
            "stepper": choice.stepper,
            "choice_reason": choice.reason,
            "outside_range": "; ".join(choice.outside) or "-",
            "choice_warnings": "; ".join(choice.warnings) or "-",
            **self._errors,
        }
        return slow, message, numbers

    def _late_s(self, now: int) -> float:
        """Time [s] since outputs that are still being computed should have been delivered."""
        if self._pending or self.paused or self.finished or not (self._started and self.factor):
            return 0.0
        due = self.due(self.position_ns + self._chunk * self.simulation.output_period_ns)
        return max(0, now - due) * 1e-9

    def warning(self) -> str:
        """A model outside its range or a doubtful run, and what `commands` warns of; "" if nothing."""
        status, model = str(self._errors.get("status", "")), ""
        if self.simulation.choice.outside:  # also before the run is judged
            model = "a model runs outside its range"
        elif not self.failure and status.startswith(("doubtful", "failed")):
            model = f"the run is {status}"
        return "; ".join(filter(None, (model, self.commands.warning())))

    # Commands; those of a kind name a method of the simulation

    def execute(self, command: Command, message) -> None:
        """Carries out a message of the topic `command`; raises BearingTwinError, counted, where it is refused."""
        header, frame = getattr(message, "header", None), f"{self.commands.prefix}{command.frame}"
        try:
            if header is not None and header.frame_id not in ("", frame):
                raise BearingTwinError(f"its frame is {echo(header.frame_id)}, and must be {frame}")
            order, *arguments = command.order(message)
            if order == "set_speed":
                check_speed(*arguments)
            warning = getattr(self.simulation, order)(*arguments)
        except Exception as error:  # any peer can send commands
            raise self.commands.refused(command.name, error) from error
        self.commands.counts["taken"] += 1
        self.commands.speed_warning = self.commands.speed_warning or warning or ""
        if order == "set_load":
            self.commands.note_load(self.simulation.time_ns)

    def operating_point(self, now: int):
        """The last output computed, and the ring's loads and stiffness there; raises BearingTwinError."""
        self._execute_waiting(now)
        return self.simulation.operating_point()

    def step(self, now: int, seconds: float) -> str:
        """While paused: delivers `seconds` of simulated time, rounded up to whole outputs, as fast as it computes."""
        if not (math.isfinite(seconds) and 0.0 < seconds <= LONGEST_STEP):
            raise BearingTwinError(f"duration = {seconds} s must be above 0 and at most {LONGEST_STEP:g} s")
        if not self.paused:
            raise BearingTwinError("the simulation is running: pause it before you step it")
        self._execute_waiting(now)
        period = self.simulation.output_period_ns
        requested = period * math.ceil((self.position_ns + max(1, round(seconds * 1e9))) / period)
        while self.simulation.time_ns < requested and not self._done:
            self._pending.extend(self._advance(min(self._chunk, (requested - self.simulation.time_ns) // period)))
            self.drain(self.simulation.time_ns)
        self.drain(min(requested, self.simulation.time_ns))
        return f"at {self.position_ns * 1e-9:.6f} s"

    def reset(self, now: int) -> str:
        """Back to time 0 and the scene's own speed; a log is completed and the next run goes to a new one."""
        return self.change(now, self.simulation)

    def change(self, now: int, simulation: Simulation) -> str:
        """Begins again with another simulation of the same topics; the log is completed, the run gets a new one."""
        log = self._open_log(self.run + 1, simulation)  # before anything changes: if it fails, the run continues
        self.close()
        self._begin_again(simulation, log)
        return f"run {self.run} starts at 0 s"

    def _begin_again(self, simulation: Simulation, log) -> None:
        self.run += 1
        simulation.reset()
        self.commands.note_load(None)
        self._begin(simulation, log)

    def close(self) -> None:
        """Sends and logs the samples collected so far and completes the log; may be called twice."""
        log, self._log = self._log, None
        try:
            self.drain()
            for message in self._flush(log):
                self.deliver(message)
        finally:
            if log is not None:
                if self.simulation.sequence >= 0:
                    log.note_report(self.simulation.report().record())
                log.close()

    # Outputs as messages

    def next_batch(self) -> list[Timed] | None:
        """The messages of the next chunk of outputs, the last ones at the end, None after it."""
        if self._done:
            return None if self._flushed else self._flush(self._log)
        # Up to the end of a chunk, so that the last published output is also the last computed one.
        # The first output comes with its chunk, whose computation would otherwise delay the pace from its start.
        sequence = self.simulation.sequence
        return self._advance(1 + self._chunk if sequence < 0 else self._chunk - sequence % self._chunk)

    def _flush(self, log) -> list[Timed]:
        flushed, self._flushed = self._flushed, True
        return [] if flushed else self._messages(self._stream.flush(), log)

    def _advance(self, outputs: int) -> list[Timed]:
        run = self.simulation
        if self._total is not None:
            outputs = min(outputs, self._total - run.sequence - 1)
        fresh = self.commands.fresh_outputs(run.time_ns, run.output_period_ns)
        if not fresh:
            run.set_load(None, None)
            self.commands.note_load(None, stale=True)
        try:
            block = run.advance(min(outputs, fresh) if fresh else outputs)
        except Interrupted:  # by a command, which is obeyed between turns
            return []
        if run.time_ns >= self._report_at:
            self._report_at = run.time_ns + REPORT_NS
            self._errors = errors_of(run.report())
        self._done = self._total is not None and run.sequence + 1 >= self._total
        # A log takes every topic; without one, only topics with subscribers are made.
        subscribed = None if self._subscribed is None or self._log is not None else self._subscribed()
        return self._messages(self._stream.messages(block, subscribed), self._log)

    def _messages(self, messages, log) -> list[Timed]:
        """The messages that have bytes, and the last one in any case, as its time is the end of the stream so far."""
        if log is not None:
            log.write_messages(messages)
        batch = [Timed(stamp_ns, topic.name, cdr) for topic, stamp_ns, cdr in messages]
        return [message for message in batch if message.cdr or message is batch[-1]]


def check_speed(speed: float) -> None:
    """Raises BearingTwinError unless `speed` [rad/s] is finite and within +-GREATEST_SPEED."""
    if not (math.isfinite(speed) and abs(speed) <= GREATEST_SPEED):
        raise BearingTwinError(f"commanded speed {speed} rad/s must be finite and within +-{GREATEST_SPEED:g}")


def errors_of(report) -> dict[str, float | str]:
    """The status of a report for diagnostics, with the error of each requested output and the horizon."""
    requested = report.errors.get("wanted_errors", {})
    errors = {output: estimate["error"] for output, estimate in requested.items()}
    known = {f"{output}_error": error for output, error in errors.items() if error is not None}
    until = {"horizon_s": report.errors["horizon_s"]} if "horizon_s" in report.errors else {}
    return {"status": report.status, **known, **until}
