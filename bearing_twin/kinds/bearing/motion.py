"""Motion of a bearing chunk by chunk, by any of the steppers."""

import math
from copy import copy
from functools import cached_property, partial
from operator import attrgetter

import numpy as np

from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError
from bearing_twin.base.report import Choice
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.kinds.bearing.accelerometer import ACCELERATION, ROOM, Accelerometer
from bearing_twin.kinds.bearing.defects import defect_numbers
from bearing_twin.kinds.bearing.equilibrium import OVERLOAD, CommandedBearing, check_load
from bearing_twin.kinds.bearing.equilibrium_motion import QuasiStaticMotion
from bearing_twin.kinds.bearing.integrate import (
    NEAR,
    Chunk,
    PartBalls,
    PartRoom,
    Results,
    check,
    instants_in,
    integrate_alone,
    integrate_in_common,
    integrated,
    time_apart,
)
from bearing_twin.kinds.bearing.outputs import Rows, empty_outputs, write_outputs
from bearing_twin.kinds.bearing.parameters import BearingScene, as_chosen, has_sensor
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, keeps_apart
from bearing_twin.kinds.bearing.start import caged_start, settled_start, start_orientation, start_state
from bearing_twin.kinds.bearing.step_control import (
    FIXED_STEP,
    Rates,
    error_scales,
    fastest_rates,
    light_approach,
    stable_step,
    step_at_start,
    too_long,
)
from bearing_twin.kinds.bearing.system import (
    CARRIED_COLUMNS,
    DRIVE_WORK,
    GROSS_WORK,
    PLACES,
    SHAFT_ANGLE,
    SHAFT_SPEED,
    CoupledBodies,
    RingDrive,
    RingLoading,
    approaches,
    bearing_of,
    border_scales,
    coupled_bodies_of,
    outside_loads,
)
from bearing_twin.numerics.methods import EVALUATIONS, JACOBIANS, REJECTIONS, STEPS
from bearing_twin.numerics.steppers import ROSENBROCK

MOVING = ("state", "orientation", "steps", "carried", "border")  # arrays that a chunk moves on
ARRAYS = (*MOVING, "_load", "_load_rate")
LISTS = {"commanded": (0, 5), "commanded_torque": (0, 1), "drive": (3,), "offset": (3,)}  # how many numbers each may be


FIRST_STEP = 1e-6  # s, of adaptive steppers at the start and where the ring's acceleration changes
SAME = 1e-9  # relative: accelerations nearer than this differ by rounding alone
REPLACED = (
    "drive",
    "goal_speed",
    "bearing",
    "step",
    "elapsed",
    "_acceleration",
    "_changed",
    "_load",
    "_load_rate",
    "heard",
)
LONGEST_TOGETHER = 0.02  # s for which balls are integrated together before the next look at who may meet
TOGETHER = 0.05  # share of that time, or of what is left of a chunk: balls that may meet sooner are integrated together
LONGEST = 0.4  # s asked for in one go: of balls alone, or round a ring with mass in a cage that keeps them apart
KEPT = attrgetter(*MOVING, "counts", *REPLACED)  # what `take_back` needs
SHORTEST_PART = 1e-9  # share of a chunk: parts shorter than this are none


class BearingMotion(CommandedBearing):
    """The bearing in motion: `advance` integrates one chunk and returns its outputs.

    `given` is the tolerance that steps are made by; `counts` holds steps, rejections, evaluations of a ball's rates
    and Jacobians so far.
    """

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters = parameters = as_chosen(parameters, choice)
        self.bearing = self._bearing = bearing_of(parameters, choice.law)
        self.stepper, self.law, self.stop = choice.stepper, choice.law, SIGNALLED
        self._loading, self._instants = RingLoading(parameters), PartRoom()
        self._loading.with_torque(0.0)  # where that never jumps, it is found here for all starts
        bodies = coupled_bodies_of(parameters)
        self._apart = keeps_apart(parameters.cage, parameters.geometry, 2.0 * NEAR * self.bearing.ball_radius)
        self.longest_chunk = LONGEST if not bodies.active or (self._apart and bodies.ring) else None
        if self.bearing.ring:
            start, self._start_border = settled_start(parameters, choice.law, bodies)
        else:
            start = start_state(self.bearing, parameters.drive.speed, parameters.initial.motion)
            start, self._start_border = caged_start(start, bodies, parameters.drive.speed)
        if parameters.defects:
            if any(one.on == "ball" for one in parameters.defects) and choice.stepper not in ROSENBROCK:
                raise SceneError(
                    f"{choice.stepper} does not follow defects of balls; use solver.stepper: rodas4, or auto"
                )
            depth, raceway = max(max(approaches(self.bearing, row)) for row in start), self.bearing.outer.law
            numbers = defect_numbers(parameters, raceway.given * max(depth, 0.0) ** raceway.power)
            self.bearing = self._bearing = self.bearing._replace(defects=tuple(numbers.tolist()))
        self.given = parameters.wanted.tolerance if math.isnan(choice.setting) else choice.setting
        scales = self.given * error_scales(parameters, self.bearing, start, bodies.active)
        light = light_approach(self.bearing, start) if self.bearing.pockets else 0.0
        self.bodies = bodies._replace(scales=border_scales(parameters, scales), light=light)
        self.scales, self._start, self._start_orientation = scales, start, start_orientation(start)
        self.step, self._finer = parameters.solver.step, choice.finer
        if choice.stepper in FIXED_STEP:
            step, problem = step_at_start(parameters, self.rates, choice.stepper)
            if problem:
                raise SceneError(problem.sentence)
            self.step = self._fixed(step)
        self._start_step = self.step
        self.accelerometer = Accelerometer(parameters) if has_sensor(parameters) else None
        self.reset()

    @cached_property
    def rates(self) -> Rates:
        """The fastest rates to be expected from the start."""
        return fastest_rates(self._bearing, self._start)

    def reset(self) -> None:
        """Back to the start."""
        self.state, self.border = self._start.copy(), self._start_border.copy()
        self.loading, self.orientation = copy(self._loading), self._start_orientation.copy()
        self.drive, self.step = RingDrive(0.0, float(self.parameters.drive.speed), 0.0), self._start_step
        self.goal_speed = float(self.parameters.drive.speed)
        self.bearing = self._bearing
        self.steps = np.full(self.bearing.balls, FIRST_STEP)
        self.carried = np.zeros((self.bearing.balls, CARRIED_COLUMNS))
        self._acceleration = 0.0
        self.elapsed, self.heard, self._samples = 0.0, (), []
        self._load = self._load_rate = np.zeros(PLACES)
        self._changed = self.parameters.drive.change.time == 0.0
        self.counts = np.zeros(4, np.int64)
        self._keep()

    def _keep(self) -> None:
        """Keeps what `take_back` needs."""
        kept, arrays = KEPT(self), len(MOVING) + 1
        self._before = *(one.copy() for one in kept[:arrays]), *kept[arrays:]

    def take_back(self) -> None:
        """Back to before the last `advance`."""
        vars(self).update(zip((*MOVING, "counts", *REPLACED), self._before, strict=True))
        self._samples = []
        self._keep()

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        loading = self.loading
        arrays = {name: getattr(self, name).tolist() for name in (*ARRAYS, "counts")}
        arrays["commanded"] = loading.load.tolist() if loading.commanded else []
        arrays["commanded_torque"] = [loading.torque] if loading.torque_commanded else []
        rest = {"drive": list(self.drive), "goal_speed": self.goal_speed, "offset": list(self.bearing.offset)}
        heard = {"heard": list(self.heard)} if self.accelerometer else {}
        fixed = {"fixed_step": self.step} if self.stepper in FIXED_STEP else {}
        moving = {"elapsed": self.elapsed, "changed": self._changed, "acceleration": self._acceleration}
        return arrays | rest | fixed | moving | heard

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; raises KeyError, TypeError or ValueError for one of another bearing."""
        self.reset()
        for name, lengths in LISTS.items():
            numbers = np.array(kept[name], float)
            if numbers.ndim != 1 or len(numbers) not in lengths or not np.isfinite(numbers).all():
                raise ValueError(name)
        if kept["commanded"]:
            self.loading.set(kept["commanded"][:3], kept["commanded"][3:])
        for torque in kept["commanded_torque"]:
            self.loading.set_torque(torque)
        self._load, self._load_rate = self._load.copy(), self._load_rate.copy()
        for name in ARRAYS:
            array, given = getattr(self, name), np.array(kept[name], float)
            if given.shape != array.shape or not np.isfinite(given).all():
                raise ValueError(name)
            array[...] = given
        if not (self.steps > 0.0).all():
            raise ValueError("steps")
        self.counts[:] = kept["counts"]
        if self.accelerometer and kept.get("heard"):
            count, *filtered = map(float, kept["heard"])
            self.heard = (int(count), *filtered[:2])
        self.drive = RingDrive(*map(float, kept["drive"]))
        self.goal_speed, self.elapsed = float(kept["goal_speed"]), float(kept["elapsed"])
        self._changed, self._acceleration = kept["changed"], float(kept["acceleration"])
        self.bearing = self._bearing._replace(offset=tuple(map(float, kept["offset"])))
        self._keep()

    def take_records(self) -> dict[str, np.ndarray]:
        """The samples of the sensor since the last call; all else stands in the outputs."""
        taken, self._samples = self._samples, []
        return {ACCELERATION.name: np.concatenate(taken)} if taken else {}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps, evaluations of one ball's rates, and Jacobians, summed over the balls."""
        return {
            "ball_steps": int(self.counts[STEPS]),
            "ball_rejections": int(self.counts[REJECTIONS]),
            "ball_rates": int(self.counts[EVALUATIONS]),
            "ball_jacobians": int(self.counts[JACOBIANS]),
        }

    def first_outputs(self) -> Rows:
        """The outputs at the present instant."""
        out = empty_outputs(self.parameters, 1)
        now = np.zeros(1), self.state[None], self.orientation[None], self.border[None]
        write_outputs(self.parameters, self.bearing, self._bodies(), self.drive, *now, out.numbers, 0)
        return out

    def advance(self, times: np.ndarray, duration: float) -> Rows:
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError.

        A new goal speed is approached at the drive's acceleration; the scene's change of the drive comes at its time.
        """
        if not math.isfinite(np.vdot(self.border, self.border)):  # as quick as can be, for every chunk
            sentence = "the state of the inner ring or the cage is not finite; reset, and lower the load"
            raise IntegrationError(sentence, "not finite", self.elapsed, "inner ring")
        if not math.isfinite(np.vdot(self.state, self.state)):
            ball = int(np.abs(self.state).max(axis=1).argmax())  # the first that is no number, if any
            sentence = f"the state of ball {ball} is not finite; reset, and shorten solver.step"
            raise IntegrationError(sentence, "not finite", self.elapsed, f"ball {ball}")
        self._keep()
        out = empty_outputs(self.parameters, len(times))
        begin, cursor = 0.0, 0
        while cursor < len(times) or begin < duration:
            self._change_drive()
            end = min(duration, begin + self._until_next(duration - begin))
            last = end >= duration * (1.0 - SHORTEST_PART)
            end = duration if last else end
            until = len(times) if last else int(np.searchsorted(times, end, side="right"))
            self._part(instants_in(times[cursor:until], begin, end), end - begin, out, cursor)
            begin, cursor = end, until
        return out

    def _until_next(self, duration):
        """Seconds for which the drive accelerates evenly and, unless that is very short, balls stay apart."""
        missing = self.goal_speed - self.drive.speed
        pieces = [duration]
        if not self._apart:
            apart = time_apart(self.bearing.ball_radius, self.state, NEAR * self.bearing.ball_radius)
            together = min(duration, LONGEST_TOGETHER)
            pieces.append(0.99 * apart if apart > TOGETHER * together else together)
        jump = self.loading.until_next(self.elapsed) if self.bodies.active else 0.0
        if jump > SHORTEST_PART * duration:
            pieces.append(jump)
        if missing != 0.0:
            pieces.append(abs(missing) / self.parameters.drive.acceleration)
        if not self._changed:
            pieces.append(self.parameters.drive.change.time - self.elapsed)
        return max(min(pieces), SHORTEST_PART * duration)

    def _change_drive(self):
        """Makes the scene's change when its time has come: a new goal speed, and the inner ring shifted at once.

        What the shift does to the contacts' energy is work of the drive, booked on ball 0.
        """
        change = self.parameters.drive.change
        if self._changed or self.elapsed < change.time * (1.0 - SHORTEST_PART):
            return
        self._changed = True
        self.goal_speed += change.speed
        before = self.first_outputs().elastic_energy[0]
        self.bearing = self.bearing._replace(offset=tuple(np.add(self.bearing.offset, change.offset).tolist()))
        self.border[:3] += change.offset
        work = self.first_outputs().elastic_energy[0] - before
        self.state[0, DRIVE_WORK] += work
        self.state[0, GROSS_WORK] += abs(work)
        if self.stepper in FIXED_STEP:
            self._follow()

    def _follow(self):
        """After a jump: a step that was chosen is chosen anew where contacts have grown stiffer, a given one judged."""
        rates = fastest_rates(self.bearing, self.state)
        if not self.parameters.solver.step:
            self.step = min(self.step, self._fixed(stable_step(rates, self.stepper)))
        if problem := too_long(self.step, rates, self.stepper):
            sentence = f"at {self.elapsed:.9g} s {problem.sentence}"
            raise IntegrationError(sentence, "step too long", self.elapsed, problem.body)

    def _fixed(self, step: float) -> float:
        """The step [s] of a fixed-step method: of a second run a part of that which fits between two outputs."""
        if self._finer == 1.0:
            return step
        period = 1.0 / self.parameters.run.output_rate
        return period / math.ceil(period / step) / self._finer

    def set_load(self, force, moment) -> None:
        """New loads on a ring with mass [N], [N m] from now on, or the scene's own where both are None.

        They are taken as `check_load` let them pass.
        """
        self.loading = self.loading.loaded(self.parameters, force, moment)

    def set_torque(self, torque: float) -> None:
        """Has this torque [N m] turn the shaft from now on, in place of the scene's."""
        self.loading.set_torque(torque)

    def _bodies(self):
        """Ring and cage with the loads from now to their next jump."""
        if not self.bodies.active:
            return self.bodies
        load, rate = self.loading.with_torque(self.elapsed)
        return self.bodies._replace(load=load, load_rate=rate)

    def _part(self, times, duration, out, first):
        """Integrates over a part of constant acceleration and writes its outputs from row `first` on."""
        missing = self.goal_speed - self.drive.speed
        limit = self.parameters.drive.acceleration * duration
        change = min(limit, max(-limit, missing))
        drive = RingDrive(self.drive.angle, self.drive.speed, change / duration)
        if abs(drive.acceleration - self._acceleration) > SAME * self.parameters.drive.acceleration:
            # Slip answers within microseconds: a step carried over from before would pass over the bend.
            self.steps = np.minimum(self.steps, FIRST_STEP)
            self._acceleration = drive.acceleration
        bodies = self._bodies()
        load, rate = bodies.load, bodies.load_rate
        if bodies.active and load is not self._load:  # as it is where it never jumps
            if np.any(np.abs(load - self._load) > SAME * np.abs(load)) or np.any(rate != self._load_rate):
                self.steps = np.minimum(self.steps, FIRST_STEP)
            self._load, self._load_rate = load + duration * rate if rate.any() else load, rate
        wanted, sampled = times, np.zeros(0)
        if self.accelerometer:
            sampled = self.accelerometer.times(self.heard, self.elapsed, self.elapsed + duration)
            times = np.sort(np.concatenate([times, np.clip(sampled - self.elapsed, 0.0, duration)]), kind="stable")
        filled = self._instants.empty(len(times), self.bearing.balls)
        moving = [getattr(self, name) for name in MOVING]
        near = np.zeros(self.bearing.balls, np.bool_)
        balls, integrate = PartBalls(self.bearing.ball_radius, near, moving), partial(self._integrate, bodies, drive)
        if bodies.active or self._apart:
            integrate_in_common(integrate, balls, times, duration, filled, self._apart, bodies.even)
        else:
            integrate_alone(integrate, balls, times, duration, filled)
        if self.accelerometer:
            self._listen(bodies, drive, times, filled, sampled)
            rows = np.searchsorted(times, wanted)
            times, filled = wanted, tuple(one[rows] for one in filled)
        write_outputs(self.parameters, self.bearing, bodies, drive, times, *filled, out.numbers, first)
        check_speed(self.parameters, bodies, self.elapsed, times, filled[2])
        self.elapsed += duration
        if bodies.shaft:
            self.drive = RingDrive(*self.border[[SHAFT_ANGLE, SHAFT_SPEED]].tolist(), 0.0)
            self.goal_speed = self.drive.speed
            return
        angle = drive.angle + duration * (drive.speed + 0.5 * drive.acceleration * duration)
        # The goal itself once it is reached, so that no rounding keeps an acceleration alive.
        reached = abs(missing) <= limit * (1.0 + SHORTEST_PART)
        self.drive = RingDrive(angle, self.goal_speed if reached else drive.speed + change, 0.0)

    def _listen(self, bodies, drive, times, filled, sampled) -> None:
        """Takes the samples of the sensor at `sampled` [s] of the run, from the states at `times` of a part."""
        rows, forces = np.searchsorted(times, np.clip(sampled - self.elapsed, 0.0, None)), []
        rows = np.minimum(rows, len(times) - 1)
        for part in (rows[begin : begin + ROOM] for begin in range(0, len(rows), ROOM)):
            out = empty_outputs(self.parameters, len(part))
            now = times[part], *(one[part] for one in filled)
            write_outputs(self.parameters, self.bearing, bodies, drive, *now, out.numbers, 0)
            forces.append(out.outer_ring_force.copy())
        if forces:
            self.heard, found = self.accelerometer.heard(self.heard, sampled, np.concatenate(forces))
            self._samples.append(found)

    def _integrate(self, bodies, drive, near, begin, times, duration, filled):
        drive, elapsed = drive_later(drive, begin) if begin else drive, self.elapsed + begin
        failure, (states, orientations, borders) = np.zeros(2), filled
        borders[:] = self.border
        results = Results(states, orientations, self.counts, failure, self.stop, self.carried, borders, self.border)
        chunk = Chunk(self.bearing, drive, bodies, near, times, duration, self.step, self.scales)
        moving = self.state, self.orientation, self.steps
        try:
            check(integrated(self.stepper, chunk, moving, results), elapsed, failure)
        except IntegrationError as error:
            raise explained(error, self.parameters, self.law, chunk, elapsed) from None


def drive_later(drive: RingDrive, start: float) -> RingDrive:
    """The drive `start` [s] later, while it accelerates evenly."""
    angle, speed, acceleration = drive
    return RingDrive(angle + start * (speed + 0.5 * acceleration * start), speed + acceleration * start, acceleration)


def bearing_motion(parameters: BearingScene, choice: Choice):
    """The motion of a bearing by the chosen model: equilibria, or balls by their equations of motion."""
    return (QuasiStaticMotion if choice.stepper == QUASI_STATIC else BearingMotion)(parameters, choice)


TOO_FAST = "too fast"  # reason of an error


def explained(error: IntegrationError, parameters, law: str, chunk: Chunk, begin: float) -> IntegrationError:
    """`error` of a chunk that began at `begin` [s], or one that names the load on a ring with mass, time and limit.

    The load counts with the ring's unbalance, at the beginning of the chunk, else at the error.
    """
    if not chunk.bodies.ring or not error.seconds >= begin:
        return error
    for into in (0.0, error.seconds - begin):
        load, seconds = outside_loads(chunk.bodies, chunk.drive, into), begin + into
        try:
            check_load(parameters, law, chunk.drive.speed + chunk.drive.acceleration * into, load[:3], load[3:])
        except BearingTwinError as limit:
            return IntegrationError(f"at {seconds:.9g} s {limit}", OVERLOAD, seconds, "inner ring")
    return error


def check_speed(parameters, bodies: CoupledBodies, begin, times, borders) -> None:
    """Raises IntegrationError at the first of the `times` (n,) [s] at which a shaft that a torque turns is too fast.

    They count from `begin` [s]; `borders` (n, BORDER) are those of the `bodies` then.
    """
    if not bodies.shaft:
        return
    limit, speeds = parameters.drive.greatest_speed, borders[:, SHAFT_SPEED]
    beyond = ~(np.abs(speeds) <= limit)
    if beyond.any():
        seconds, speed = begin + float(times[beyond.argmax()]), float(speeds[beyond.argmax()])
        sentence = (
            f"at {seconds:.9g} s the inner ring turns at {speed:.6g} rad/s, beyond drive.greatest_speed = {limit:g} "
            "rad/s: nothing holds the torque; lower it, or add drive.damping"
        )
        raise IntegrationError(sentence, TOO_FAST, seconds, "inner ring")
