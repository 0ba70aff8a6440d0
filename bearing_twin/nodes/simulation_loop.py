"""A simulation as a paced stream of messages that takes commands: what sim_node thinks, without ROS or clocks."""

import math
from collections.abc import Callable, Container
from contextlib import contextmanager
from pathlib import Path

from bearing_twin.errors import BearingTwinError, Interrupted
from bearing_twin.kinds.contract import Command
from bearing_twin.nodes.pacing import FASTEST, PacedStream, Pacer, StreamPace, Timed
from bearing_twin.spelling import echo


class Commands:
    """Counts of commands, and the time at which a load becomes stale; `load_timeout_ns` 0 = never.

    A load holds until the next. One that is not followed by another within the timeout, in simulated time from the
    output it began after, is stale: the scene's own load acts again, and that is said until a new load comes.
    """

    def __init__(self, load_timeout_ns: int = 0, frame_prefix: str = ""):
        self.taken = self.refused = 0
        self._timeout, self._prefix = load_timeout_ns, frame_prefix
        self._last, self._told = "", 0
        self.forget_load()

    def forget_load(self) -> None:
        """The scene's own load acts, as at the start."""
        self._stale_at: int | None = None
        self._source = "the scene"
        self.load_is_stale = False

    @contextmanager
    def counted(self, name: str):
        """Counts what happens within as a command on the topic `name`, taken or, by BearingTwinError, refused."""
        try:
            yield
        except BearingTwinError as error:
            self.refused += 1
            self._last = f"{name} refused: {error}"
            raise BearingTwinError(self._last) from error
        self.taken += 1

    def check_frame(self, message, frame: str) -> None:
        """Raises BearingTwinError unless a message with a header is in `frame`, or names no frame at all."""
        given = message.header.frame_id if hasattr(message, "header") else ""
        if given and given != f"{self._prefix}{frame}":
            raise BearingTwinError(f"its frame is {echo(given)}, but it is taken in {self._prefix}{frame} alone")

    def note_load(self, time_ns: int) -> None:
        """A load acts from the output after `time_ns` on."""
        self.forget_load()
        self._source = "command/load"
        if self._timeout:
            self._stale_at = max(time_ns, 0) + self._timeout

    def fresh_outputs(self, time_ns: int, period_ns: int) -> float:
        """How many outputs after `time_ns` the load holds for; infinite where it does not grow stale."""
        return math.inf if self._stale_at is None else max(0, math.ceil((self._stale_at - time_ns) / period_ns))

    def let_go(self) -> None:
        """The load is stale."""
        self.forget_load()
        self.load_is_stale = True

    def doubt(self) -> str:
        """What to warn of: a stale load, and refusals since this was asked last; "" if nothing."""
        new, self._told = self.refused - self._told, self.refused
        words = [
            f"command/load is stale, {self._timeout * 1e-9:g} s without another: the scene's own load acts"
            if self.load_is_stale
            else "",
            f"{new} refused, the last: {self._last}" if new else "",
        ]
        return "; ".join(word for word in words if word)

    def numbers(self) -> dict[str, object]:
        """For diagnostics."""
        return {"commands_taken": self.taken, "commands_refused": self.refused, "last_refusal": self._last or "-"} | {
            "load_from": self._source
        }


MOST_LOGS = 1000  # of one node; each takes 0.1 MB at least


class RunLogs:
    """Opens the logs of runs 0, 1, 2 ... beside `path` (empty: none), and says how much room all take.

    `open_log(path)` gives a log with `problem`, `dropped` and `bytes`.
    """

    def __init__(self, path: str, open_log: Callable[[Path], object]):
        self._path, self._open = path, open_log
        self._newest: list = []  # the last two: a log is opened before the one before is completed
        self._bytes_before = self._dropped_before = 0
        self.count = 0
        self.doubt = ""  # why the run is not logged

    def begin(self, run: int):
        """The log of a run, None where there are too many already; raises LogError, and is then as it was."""
        if not self._path:
            return None
        if self.count >= MOST_LOGS:
            self.doubt = f"not logged: the node has begun {self.count} logs; start it again for more"
            return None
        log = self._open(log_path(self._path, run))
        for gone in self._newest[:-1]:
            self._bytes_before += gone.bytes
            self._dropped_before += gone.dropped
        self._newest = [*self._newest[-1:], log]
        self.count += 1
        return log

    @property
    def problem(self) -> str:
        """Why the last log cannot grow, empty while it can."""
        return self._newest[-1].problem if self._newest else ""

    @property
    def dropped(self) -> int:
        """Messages of all runs for which there was no room."""
        return self._dropped_before + sum(one.dropped for one in self._newest)

    @property
    def bytes(self) -> int:
        """Size of all logs."""
        return self._bytes_before + sum(one.bytes for one in self._newest)


def log_path(path: str | Path, run: int) -> Path:
    """Where run 0, 1, 2 ... is logged: run.mcap, run_1.mcap, run_2.mcap ..."""
    path = Path(path)
    return path if run == 0 else path.with_name(f"{path.stem}_{run}{path.suffix}")


CHUNK_NS = 20_000_000  # handed over in one go: a command acts no further ahead than this
LONGEST_STEP = 10.0  # s
SILENCE_NS = 10_000_000  # between words on how far the stream has come, where nobody listens: each wakes the worker
SHORTFALL = 0.95  # of the wanted pace, below which the loop says so
LONG_NS = 2_000_000_000  # of computing one batch, from which on the loop says that nothing comes meanwhile
JUDGED_NS = 1_000_000_000  # of simulated time between looks at what the run is worth
GREATEST_SPEED = 10_000.0  # rad/s, beyond what any bearing of these sizes survives


class SimulationLoop:
    """Computes ahead by a chunk and delivers each message when it is due; every method runs in the worker's thread.

    `simulation` is a `Simulation`, `make_stream()` a new `MessageStream`, `deliver(timed)` sends one message.
    `open_log(run)` gives the log writer of run 0, 1 ... (a reset starts a new run) or None. `duration_ns` 0 = endless.
    A run that has ended begins again `repeat_ns` of wall time after it began, or at once where it took longer; below 0
    it waits for a reset. A repeat sends the same messages again, so it is not logged. `wanted()` gives the names of the
    topics that somebody listens to (None: all). `commands` keeps the account of what was commanded.
    """

    def __init__(
        self,
        simulation,
        make_stream: Callable,
        deliver: Callable[[Timed], None],
        factor: float | str = 1.0,
        duration_ns: int = 0,
        open_log: Callable[[int], object] = lambda run: None,
        repeat_ns: int = 0,
        wanted: Callable[[], Container[str]] | None = None,
        commands: Commands | None = None,
    ):
        self.simulation = simulation
        self.runs = 0
        self.commands = commands or Commands()
        self._make_stream = make_stream
        self._open_log = open_log
        self._wanted = wanted
        self._stream = make_stream()
        self._log = open_log(0)
        self._chunk = max(1, min(CHUNK_NS // simulation.output_period_ns, simulation.chunk_outputs))
        self._total = duration_ns // simulation.output_period_ns + 1 if duration_ns else None
        self._done = self._flushed = False
        self._repeat = repeat_ns
        self._began: int | None = None
        self._computing: int | None = None  # since when the turn under way
        self._earlier = StreamPace(0, 0, 0, 0)
        self._worth: dict[str, float | str] = {}
        self._judge_at = 0
        self.tells_time = False  # whether somebody is told every instant, also where no message is due
        self._silent_until = 0
        self.paced = PacedStream(self._next_batch, deliver, Pacer(factor))

    @property
    def time_ns(self) -> int:
        """Simulation time of the last message delivered."""
        return self.paced.position_ns

    @property
    def over(self) -> bool:
        """Whether everything was delivered and nothing more will come by itself or by a reset."""
        return self.paced.finished and not self._repeat

    def turn(self, now: int) -> int | None:
        """Does what is due at `now`; returns the wall time of the next turn, None when only a command can go on."""
        if self._began is None and not self.paced.paused:
            self._began = now
        self._computing = now
        try:
            wake_at = self.paced.turn(now)
        finally:
            self._computing = None
        if not self.paced.finished or self.over:
            return wake_at
        self.close()
        if self._repeat < 0 or self.paced.paused:
            return None
        due = self._began + self._repeat
        if now < due:
            return due
        self._begin_again(None)
        return now

    def look(self, now: int = 0) -> tuple[bool, str, dict[str, float | str]]:
        """Whether it cannot keep up, what it does, and its numbers since the last look; from any thread.

        `now` tells how long the outputs that are computed meanwhile have taken so far.
        """
        held = 0 if (since := self._computing) is None or now - since < LONG_NS else now - since
        pace, wanted = self.paced.pacer.pace(), float(self.paced.pacer.factor)
        factor, earlier = pace.real_time_factor(self._earlier), self._earlier
        self._earlier = pace
        slow = wanted > 0.0 and pace.running_ns > earlier.running_ns and factor < SHORTFALL * wanted and pace.behind
        if self.paced.paused:
            slow, message = False, "paused"
        elif self.paced.finished and not self.over:
            slow, message = False, "waiting for the next begin"
        elif held:
            slow, word = (True, "cannot keep up") if wanted else (False, "as fast as possible")
            message = f"{word}: the next outputs have taken {1e-9 * held:.0f} s so far"
        elif slow:
            message = f"cannot keep up: {factor:.3g} of {wanted:g} times real time"
        else:
            message = "running" if wanted else "running as fast as possible"
        numbers = {
            "real_time_factor": factor,
            "wanted_real_time_factor": wanted or FASTEST,
            "lag_s": (pace.lag_ns + (held if wanted else 0)) * 1e-9,
            "given_up_s": pace.slipped_ns * 1e-9,
            "simulation_time_s": self.time_ns * 1e-9,
            "outputs": self.simulation.sequence + 1,
            "runs": self.runs + 1,
            **self.commands.numbers(),
            **model(self.simulation),
            **self._worth,
        }
        return slow, message, numbers

    def doubt(self) -> str:
        """What whoever looks after the run should know of: that it is not worth what is wanted, and its commands."""
        status, said = str(self._worth.get("status", "")), ""
        if self.simulation.choice.outside:  # also before the run is judged
            said = "a model runs outside its range"
        elif status.startswith(("doubtful", "failed")):
            said = f"the run is {status}"
        return "; ".join(filter(None, (said, self.commands.doubt())))

    def pause(self, now: int, paused: bool) -> str:
        """Holds time or lets it go on; pausing twice is as good as once."""
        self.paced.pause(now, paused)
        return f"{'paused' if paused else 'running'} at {self.time_ns * 1e-9:.6f} s"

    def set_factor(self, now: int, factor: float | str) -> None:
        """Changes the pace, a multiple of real time or FASTEST."""
        self.paced.set_factor(now, factor)

    def obey(self, now: int, command: Command, message) -> None:
        """Carries out a message of the topic `command`; raises BearingTwinError, counted, where it is refused."""
        with self.commands.counted(command.name):
            self.commands.check_frame(message, command.frame)
            order, *arguments = command.order(message)
            getattr(self, order)(now, *arguments)

    def set_load(self, now: int, force, torque) -> None:
        """New load on the inner ring [N], [N m]; raises BearingTwinError where it cannot be carried."""
        self.simulation.set_load(force, torque)
        self.commands.note_load(self.simulation.time_ns)

    def operating_point(self, now: int):
        """The last output computed, and the ring's loads and stiffness there; raises BearingTwinError."""
        return self.simulation.operating_point()

    def set_speed(self, now: int, speed: float) -> None:
        """New goal for the speed of the inner ring [rad/s]; raises BearingTwinError when it is no possible speed."""
        check_speed(speed)
        self.simulation.set_speed(speed)

    def set_torque(self, now: int, torque: float) -> None:
        """New torque on the inner ring [N m]; raises BearingTwinError where the drive takes none."""
        self.simulation.set_torque(torque)

    def reset(self, now: int) -> str:
        """Back to time 0 and the scene's own speed; a log is completed and the next run goes to a new one."""
        log = self._open_log(self.runs + 1)  # before anything changes: where none can be opened, the run goes on
        self.close()
        self._begin_again(log)
        return f"run {self.runs} starts at 0 s"

    def _begin_again(self, log) -> None:
        self.runs += 1
        self.simulation.reset()
        self.commands.forget_load()
        self._stream = self._make_stream()
        self._log = log
        self._done = self._flushed = False
        self._began, self._judge_at, self._silent_until = None, 0, 0
        self.paced.restart()

    def step(self, now: int, seconds: float) -> str:
        """While paused: delivers `seconds` of simulated time, rounded up to whole outputs, as fast as it computes."""
        if not (math.isfinite(seconds) and 0.0 < seconds <= LONGEST_STEP):
            raise BearingTwinError(f"duration = {seconds} s must be above 0 and at most {LONGEST_STEP:g} s")
        if not self.paced.paused:
            raise BearingTwinError("the simulation is running: pause it before you step it")
        period = self.simulation.output_period_ns
        wanted = period * math.ceil((self.time_ns + max(1, round(seconds * 1e9))) / period)
        while self.simulation.time_ns < wanted and not self._done:
            self.paced.put(self._advance(min(self._chunk, (wanted - self.simulation.time_ns) // period)))
            self.paced.drain(self.simulation.time_ns)
        self.paced.drain(min(wanted, self.simulation.time_ns))
        return f"at {self.time_ns * 1e-9:.6f} s"

    def close(self) -> None:
        """Sends and logs the samples collected so far and completes the log; may be called twice."""
        log, self._log = self._log, None
        try:
            self.paced.drain()
            if not self._flushed:
                self._flushed = True
                for message in self._messages(self._stream.flush(), log):
                    self.paced.deliver(message)
        finally:
            if log is not None:
                if self.simulation.sequence >= 0:
                    log.note_report(self.simulation.report().record())
                log.close()

    def _next_batch(self) -> list[Timed] | None:
        if not self._done:
            # Up to the end of a chunk, so that what is published last is also what was computed last.
            # With the first output comes its chunk, whose computing would else make the pace late as soon as it begins.
            sequence = self.simulation.sequence
            return self._advance(1 + self._chunk if sequence < 0 else self._chunk - sequence % self._chunk)
        if not self._flushed:
            self._flushed = True
            return self._messages(self._stream.flush(), self._log)
        return None

    def _advance(self, outputs: int) -> list[Timed]:
        run = self.simulation
        if self._total is not None:
            outputs = min(outputs, self._total - run.sequence - 1)
        fresh = self.commands.fresh_outputs(run.time_ns, run.output_period_ns)
        if not fresh:
            run.set_load(None, None)
            self.commands.let_go()
        try:
            block = run.advance(min(outputs, fresh) if fresh else outputs)
        except Interrupted:  # by a command, which is obeyed between turns
            return []
        if run.time_ns >= self._judge_at:
            self._judge_at = run.time_ns + JUDGED_NS
            self._worth = worth(run.report())
        self._done = self._total is not None and self.simulation.sequence + 1 >= self._total
        # A log takes every topic; without one, nothing is made that nobody listens to.
        wanted = None if self._wanted is None or self._log is not None else self._wanted()
        return self._messages(self._stream.messages(block, wanted), self._log)

    def _messages(self, messages, log) -> list[Timed]:
        batch, last = [], None
        for topic, stamp_ns, cdr in messages:
            if log is not None:
                log.write(topic, stamp_ns, cdr)
            last = Timed(stamp_ns, topic.name, cdr)
            if cdr or stamp_ns >= self._silent_until:
                batch.append(last)
                self._silent_until = stamp_ns + (0 if self.tells_time else SILENCE_NS)
        # The end of a run is told whatever was told before.
        return [*batch, last] if self._done and last is not None and last not in batch[-1:] else batch


def check_speed(speed: float) -> None:
    """Raises BearingTwinError unless `speed` [rad/s] is finite and within +-GREATEST_SPEED."""
    if not (math.isfinite(speed) and abs(speed) <= GREATEST_SPEED):
        raise BearingTwinError(
            f"commanded speed {speed} rad/s is ignored: it must be finite and within +-{GREATEST_SPEED:g}"
        )


def model(simulation) -> dict[str, str]:
    """What a simulation says of the model in use, for diagnostics: which, why, and what to watch."""
    choice = simulation.choice
    words = {"law": choice.law, "stepper": choice.stepper, "choice_reason": choice.reason}
    words["outside_range"] = "; ".join(simulation.choice.outside) or "-"
    return words | {"choice_warnings": "; ".join(choice.warnings) or "-"}


def worth(report) -> dict[str, float | str]:
    """The status of a report for diagnostics, with the error of each requested output and the horizon."""
    wanted = report.errors.get("wanted_errors", {})
    known = {f"{output}_error": one["error"] for output, one in wanted.items() if one["error"] is not None}
    until = {"horizon_s": report.errors["horizon_s"]} if "horizon_s" in report.errors else {}
    return {"status": report.status, **known, **until}
