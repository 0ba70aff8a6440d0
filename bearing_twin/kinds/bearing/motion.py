"""Motion of a bearing chunk by chunk, by any of the steppers, and the states from which it starts."""

import math
from functools import cached_property, partial

import numpy as np

from bearing_twin.base.errors import BearingTwinError, IntegrationError, SceneError
from bearing_twin.base.report import Choice
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.coefficients import ROSENBROCK
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.accelerometer import ACCELERATION, INSTANTS, Accelerometer
from bearing_twin.kinds.bearing.defects import defect_numbers
from bearing_twin.kinds.bearing.equilibrium import (
    OVERLOAD,
    CommandedBearing,
    EquilibriumSolver,
    Support,
    azimuths_of,
    check_load,
    load_weighted_mean,
    solver_under_gravity,
    support_with_weight,
)
from bearing_twin.kinds.bearing.equilibrium_motion import QuasiStaticMotion
from bearing_twin.kinds.bearing.integrate import (
    FIXED_STEP,
    NEAR_GAP,
    Chunk,
    Rates,
    check_status,
    error_scales,
    fastest_rates,
    instants_in,
    integrate_alone,
    integrate_chunk,
    integrate_in_common,
    light_approach,
    stable_step,
    step_at_start,
    step_problem,
    time_separated,
)
from bearing_twin.kinds.bearing.outputs import Rows, empty_outputs, outer_ring_forces, write_outputs
from bearing_twin.kinds.bearing.parameters import BearingScene, has_sensor, with_chosen_friction
from bearing_twin.kinds.bearing.rings import QUASI_STATIC, separates_balls
from bearing_twin.kinds.bearing.system import (
    AXIS_DISTANCE,
    BODY_COLUMNS,
    CAGE,
    CAGE_SPEED,
    CAGE_X,
    CARRIED_COLUMNS,
    COLUMNS,
    DRIVE_WORK,
    GROSS_WORK,
    HEIGHT,
    HOUSING_POSITION,
    HOUSING_SPEED,
    NO_LAND,
    ORBIT_ANGLE,
    POSITIONS,
    SHAFT_ANGLE,
    SHAFT_SPEED,
    SPIN,
    TANGENTIAL_VELOCITY,
    Bearing,
    CoupledBodies,
    RingDrive,
    RingLoading,
    bearing_of,
    body_scales,
    coupled_bodies_of,
    numbers_of,
)
from bearing_twin.methods import EVALUATIONS, JACOBIANS, REJECTIONS, STEPS

MOVING = ("state", "orientation", "steps", "carried", "body_state")  # arrays that a chunk changes
ARRAYS = (*MOVING, "_load", "_load_rate", "counts")
SAVED_AS = {"body_state": "border"}  # names in snapshots, as earlier versions have them
KEPT = (*ARRAYS, "drive", "goal_speed", "bearing", "step", "elapsed", "_acceleration", "_changed", "sensor_state")
LISTS = {"commanded": (0, 5), "commanded_torque": (0, 1), "drive": (3,), "offset": (3,)}  # legal lengths
COSTS = {"ball_steps": STEPS, "ball_rejections": REJECTIONS, "ball_rates": EVALUATIONS, "ball_jacobians": JACOBIANS}

FIRST_STEP = 1e-6  # s, of adaptive steppers at the start and where the ring's acceleration changes
SAME = 1e-9  # relative: accelerations nearer than this differ by rounding alone
LONGEST_TOGETHER = 0.02  # s for which balls are integrated together before their gaps are checked
TOGETHER = 0.05  # share of that time, or of the rest of a chunk: balls that may meet sooner are integrated together
LONGEST_CHUNK = 0.4  # s of one chunk: of balls alone, or of a ring with mass whose balls a cage separates
SHORTEST_PART = 1e-9  # share of a chunk: shorter parts are rounding
TOO_FAST = "too fast"  # reason of an error

_place_balls = Function("core_place_balls", INTEGER, (REALS, REALS, REAL, INTEGER, INTEGER, REALS_OUT))


def start_state(bearing: Bearing, inner_speed: float, motion: str) -> np.ndarray:
    """State (N, COLUMNS) at the start: balls evenly spaced, resting between the raceways, rolling or not moving.

    Raises SceneError when a ball has no rest between the raceways.
    """
    state = np.zeros((bearing.balls, COLUMNS))
    if not _place_balls(*numbers_of(bearing), float(inner_speed), motion == "rolling", len(state), state):
        raise SceneError(
            "the balls find no rest between the raceways; check radial_clearance, drive.offset and the speed"
        )
    return state


def _supported(solver: EquilibriumSolver, support: Support, bodies: CoupledBodies):
    """The equilibrium with the springs of the support, whose force is found by Newton's method."""
    equilibrium = solver.solve(support)
    stiffness, free = bodies.stiffness[:CAGE], np.array(support.free, np.bool_)
    if not np.any(stiffness * free):
        return equilibrium
    loads, pull = np.array(support.loads), np.zeros(5)
    for _ in range(30):
        defect = stiffness * (equilibrium.coordinates - bodies.rest[:CAGE]) - pull
        if np.abs(defect[free]).max() <= 1e-9 * np.abs(loads).max():
            return equilibrium
        compliance = np.linalg.inv(equilibrium.stiffness[np.ix_(free, free)])
        pull[free] += np.linalg.solve(np.eye(len(compliance)) + stiffness[free, None] * compliance, defect[free])
        equilibrium = solver.solve(support._replace(loads=tuple(loads - pull)))
    return equilibrium


def start_in_equilibrium(parameters: BearingScene, law: str, bodies: CoupledBodies) -> tuple[np.ndarray, np.ndarray]:
    """State of balls (N, COLUMNS), of ring and cage (BODY_COLUMNS,) in balance, the balls rolling unless at rest.

    Balls of a cage share one orbit speed, the mean of what the loaded ones roll with. Raises SceneError where there is
    no equilibrium.
    """
    balls, speed = parameters.geometry.balls, parameters.drive.speed
    azimuths = azimuths_of(balls, 0.0)
    solver = solver_under_gravity(parameters, law, speed, azimuths)
    support = support_with_weight(parameters, RingLoading(parameters).load.at(0.0)[0])
    equilibrium = _supported(solver, support, bodies)
    state, body_state = np.zeros((balls, COLUMNS)), np.zeros(BODY_COLUMNS)
    body_state[:CAGE] = equilibrium.coordinates
    if bodies.land:
        body_state[CAGE_X:CAGE] = _cage_at_rest(bodies, body_state)
    state[:, AXIS_DISTANCE] = solver.setting.outer.locus_radius + equilibrium.positions[:, 0]
    state[:, ORBIT_ANGLE], state[:, HEIGHT] = azimuths, equilibrium.positions[:, 1]
    if parameters.initial.motion == "rolling":
        contacts = equilibrium.contacts
        cage_speed = load_weighted_mean(contacts, contacts.orbit)
        orbit = np.full(balls, cage_speed) if bodies.free[CAGE] else contacts.orbit
        state[:, TANGENTIAL_VELOCITY] = state[:, AXIS_DISTANCE] * orbit
        state[:, SPIN], state[:, SPIN + 2] = contacts.pitch, orbit - contacts.roll
        body_state[CAGE_SPEED] = cage_speed if bodies.free[CAGE] else 0.0
    return state, body_state


def _cage_at_rest(bodies: CoupledBodies, body_state: np.ndarray) -> np.ndarray:
    """Centre of a cage at rest in its land under its weight [m] (2,); the land's centre without weight or land."""
    land, weight = bodies.land, bodies.weight[CAGE_X:CAGE]
    middle = body_state[:2] if land.side < 0.0 else np.zeros(2)
    size = float(np.hypot(*weight))
    if size == 0.0 or land.clearance == NO_LAND:
        return middle
    return middle + (land.clearance + size / land.stiffness) * weight / size


def start_in_cage(state: np.ndarray, bodies: CoupledBodies) -> tuple[np.ndarray, np.ndarray]:
    """The start of balls with a held ring, in a cage that orbits with their mean speed."""
    body_state = np.zeros(BODY_COLUMNS)
    if bodies.free[CAGE]:
        body_state[CAGE_SPEED] = np.mean(state[:, TANGENTIAL_VELOCITY] / state[:, AXIS_DISTANCE])
        state[:, TANGENTIAL_VELOCITY] = state[:, AXIS_DISTANCE] * body_state[CAGE_SPEED]
    return state, body_state


class BearingMotion(CommandedBearing):
    """The bearing in motion: `advance` integrates one chunk and returns its outputs.

    `step_tolerance` is the tolerance of the steps; `counts` holds steps, rejections, evaluations of a ball's rates
    and Jacobians so far.
    """

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters = parameters = with_chosen_friction(parameters, choice)
        self.bearing = self._bearing = bearing_of(parameters, choice.law)
        self.stepper, self.law, self.stop = choice.stepper, choice.law, SIGNALLED
        self.bodies = bodies = coupled_bodies_of(parameters)
        reach = 2.0 * NEAR_GAP * self.bearing.ball_radius
        self._separated = separates_balls(parameters.cage, parameters.geometry, reach)
        quick = not has_sensor(parameters) and (not bodies.active or (self._separated and bodies.ring))
        self.longest_chunk = LONGEST_CHUNK if quick else None
        if self.bearing.ring:
            start, body_state = start_in_equilibrium(parameters, choice.law, bodies)
        else:
            start = start_state(self.bearing, parameters.drive.speed, parameters.initial.motion)
            start, body_state = start_in_cage(start, bodies)
        if bodies.shaft:
            body_state[SHAFT_SPEED] = parameters.drive.speed
        half, zero = -0.5 * start[:, ORBIT_ANGLE], np.zeros(len(start))
        attitude = np.stack((zero, zero, np.sin(half), np.cos(half)), axis=1)  # turned back by the orbit angle
        self._start, self._start_orientation, self._start_bodies = start, attitude, body_state
        self.step = self._start_step = parameters.solver.step
        self._finer, self.accelerometer = choice.finer, None
        self.reset()
        first = self.first_outputs()
        self._approaches = approaches = first.approach[0]
        if parameters.defects:
            if any(defect.on == "ball" for defect in parameters.defects) and choice.stepper not in ROSENBROCK:
                raise SceneError(
                    f"{choice.stepper} does not follow defects of balls; use solver.stepper: rodas4, or auto"
                )
            law = self.bearing.outer.law
            numbers = defect_numbers(parameters, law.given * max(approaches[:, 1].max(), 0.0) ** law.power)
            self._bearing = self._bearing._replace(defects=tuple(numbers.tolist()))
        self.step_tolerance = parameters.wanted.tolerance if math.isnan(choice.setting) else choice.setting
        self.scales = self.step_tolerance * error_scales(parameters, self.bearing, start, approaches, bodies.active)
        light = light_approach(self.bearing, approaches) if self.bearing.pockets else 0.0
        housing = bodies.housing and bodies.housing._replace(load=-first.outer_ring_force[0] @ bodies.housing.direction)
        self.bodies = bodies._replace(scales=body_scales(parameters, self.scales), light=light, housing=housing)
        if choice.stepper in FIXED_STEP:
            self.step = self._fixed(step_at_start(parameters, self.rates, choice.stepper))
        self._start_step = self.step
        self.accelerometer = Accelerometer(parameters, self.bodies.housing) if has_sensor(parameters) else None
        self.reset()

    @cached_property
    def rates(self) -> Rates:
        """The fastest rates to be expected from the start."""
        return fastest_rates(self._bearing, self._approaches)

    def reset(self) -> None:
        """Back to the start."""
        self.state, self.body_state = self._start.copy(), self._start_bodies.copy()
        self.orientation, self.loading = self._start_orientation.copy(), RingLoading(self.parameters)
        self.drive, self.step = RingDrive(0.0, float(self.parameters.drive.speed), 0.0), self._start_step
        self.goal_speed, self.bearing = self.drive.speed, self._bearing
        self.steps = np.full(self.bearing.balls, FIRST_STEP)
        self.carried = np.zeros((self.bearing.balls, CARRIED_COLUMNS))
        self._acceleration = self.elapsed = 0.0
        self.sensor_state, self._samples = (), []
        self._load, self._load_rate = np.zeros(POSITIONS), np.zeros(POSITIONS)
        self._changed = self.parameters.drive.change.time == 0.0
        self.counts = np.zeros(4, np.int64)
        self._keep()

    def _keep(self) -> None:
        """Keep the state for `take_back`."""
        self._before = {name: getattr(self, name) for name in KEPT}
        self._before |= {name: self._before[name].copy() for name in ARRAYS}

    def take_back(self) -> None:
        """Back to before the last `advance`."""
        vars(self).update(self._before)
        self._samples = []
        self._keep()

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        loading = self.loading
        return {
            **{SAVED_AS.get(name, name): getattr(self, name).tolist() for name in ARRAYS},
            "commanded": loading.load.steady.tolist() if loading.load.commanded else [],
            "commanded_torque": loading.torque.steady.tolist() if loading.torque_commanded else [],
            "drive": list(self.drive),
            "goal_speed": self.goal_speed,
            "offset": list(self.bearing.offset),
            **({"fixed_step": self.step} if self.stepper in FIXED_STEP else {}),
            "elapsed": self.elapsed,
            "changed": self._changed,
            "acceleration": self._acceleration,
            **({"heard": list(self.sensor_state)} if self.accelerometer else {}),
        }

    def resume(self, snapshot: dict) -> None:
        """Resume from a `snapshot`; raises KeyError, TypeError or ValueError for that of another bearing."""
        self.reset()
        for name in (*LISTS, *ARRAYS):
            values = np.array(snapshot[SAVED_AS.get(name, name)], float)
            if name == "body_state":  # of logs before housings moved
                values = np.pad(values, (0, max(BODY_COLUMNS - len(values), 0)))
            legal = [(length,) for length in LISTS[name]] if name in LISTS else [getattr(self, name).shape]
            if values.shape not in legal or not np.isfinite(values).all():
                raise ValueError(name)
            if name in ARRAYS:
                getattr(self, name)[...] = values
        if snapshot["commanded"]:
            self.loading.set(snapshot["commanded"][:3], snapshot["commanded"][3:])
        for torque in snapshot["commanded_torque"]:
            self.loading.set_torque(torque)
        if not (self.steps > 0.0).all():
            raise ValueError("steps")
        if self.accelerometer and snapshot.get("heard"):
            self.sensor_state = self.accelerometer.restored(snapshot["heard"], float(snapshot["elapsed"]))
        self.drive = RingDrive(*map(float, snapshot["drive"]))
        self.goal_speed, self.elapsed = float(snapshot["goal_speed"]), float(snapshot["elapsed"])
        self._changed, self._acceleration = snapshot["changed"], float(snapshot["acceleration"])
        self.bearing = self._bearing._replace(offset=tuple(map(float, snapshot["offset"])))
        self._keep()

    def take_records(self) -> dict[str, np.ndarray]:
        """The samples of the sensor since the last call."""
        samples, self._samples = self._samples, []
        return {ACCELERATION.name: np.concatenate(samples)} if samples else {}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps, evaluations of one ball's rates, and Jacobians, summed over the balls."""
        return {name: int(self.counts[number]) for name, number in COSTS.items()}

    def first_outputs(self) -> Rows:
        """The outputs at the present instant."""
        out = empty_outputs(self.parameters, 1)
        now = self.state[None], self.orientation[None], self.body_state[None]
        self._write(self._bodies(), self.drive, np.zeros(1), now, out.numbers)
        return out

    def _write(self, bodies: CoupledBodies, drive: RingDrive, times, motion, rows: np.ndarray) -> None:
        """Write outputs at `times` [s] from the drive's instant: `motion` as of `allocate`."""
        write_outputs(self.parameters, self.bearing, bodies, drive, times, *motion, rows)

    def advance(self, times: np.ndarray, duration: float) -> Rows:
        """Integrate `duration` [s] and return the outputs at `times` [s] from now; raises IntegrationError.

        A new goal speed is approached at the drive's acceleration; the scene's change of the drive comes at its time.
        """
        if not math.isfinite(np.vdot(self.body_state, self.body_state)):  # the fastest check, made for every chunk
            sentence = "the state of the inner ring or the cage is not finite; reset, and lower the load"
            raise IntegrationError(sentence, "not finite", self.elapsed, "inner ring")
        if not math.isfinite(np.vdot(self.state, self.state)):
            ball = int(np.abs(self.state).max(axis=1).argmax())  # the first NaN, if any
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
            next_cursor = len(times) if last else int(np.searchsorted(times, end, side="right"))
            self._part(instants_in(times[cursor:next_cursor], begin, end), end - begin, out.numbers[cursor:next_cursor])
            begin, cursor = end, next_cursor
        return out

    def _until_next(self, duration):
        """Seconds for which the drive accelerates evenly and, unless that is very short, balls do not meet."""
        pieces = [duration]
        if not self._separated:
            separated = time_separated(self.bearing.ball_radius, self.state)
            together = min(duration, LONGEST_TOGETHER)
            pieces.append(0.99 * separated if separated > TOGETHER * together else together)
        if self.bodies.active:
            pieces.append(self.loading.until_next(self.elapsed))
        if self.goal_speed != self.drive.speed:
            pieces.append(abs(self.goal_speed - self.drive.speed) / self.parameters.drive.acceleration)
        if not self._changed:
            pieces.append(self.parameters.drive.change.time - self.elapsed)
        return max(min(pieces), SHORTEST_PART * duration)

    def _change_drive(self):
        """Apply the scene's change at its time: a new goal speed, and a shift of the inner ring.

        The change of the contacts' energy by the shift is work of the drive, added to that of ball 0.
        """
        change = self.parameters.drive.change
        if self._changed or self.elapsed < change.time * (1.0 - SHORTEST_PART):
            return
        self._changed = True
        self.goal_speed += change.speed
        before = self.first_outputs().elastic_energy[0]
        self.bearing = self.bearing._replace(offset=tuple(np.add(self.bearing.offset, change.offset).tolist()))
        self.body_state[:3] += change.offset
        after = self.first_outputs()
        work = after.elastic_energy[0] - before
        self.state[0, DRIVE_WORK] += work
        self.state[0, GROSS_WORK] += abs(work)
        if self.stepper in FIXED_STEP:  # an automatic step may shorten, that of the scene is checked
            rates = fastest_rates(self.bearing, after.approach[0])
            if not self.parameters.solver.step:
                self.step = min(self.step, self._fixed(stable_step(rates, self.stepper)))
            problem, body = step_problem(self.step, rates, self.stepper)
            if problem:
                raise IntegrationError(f"at {self.elapsed:.9g} s {problem}", "step too long", self.elapsed, body)

    def _fixed(self, step: float) -> float:
        """The step [s] of a fixed-step method; in a second run a fraction of one that divides an output's period."""
        if self._finer == 1.0:
            return step
        period = 1.0 / self.parameters.run.output_rate
        return period / math.ceil(period / step) / self._finer

    def set_load(self, force, moment) -> None:
        """Set the loads on a ring with mass [N], [N m], checked by `check_load`; None for both: those of the scene."""
        self.loading.set(force, moment)

    def set_torque(self, torque: float) -> None:
        """Set a constant torque [N m] on the shaft."""
        self.loading.set_torque(torque)

    def _bodies(self) -> CoupledBodies:
        """Ring and cage with the loads from now to their next jump."""
        if not self.bodies.active:
            return self.bodies
        load, rate = self.loading.at(self.elapsed)
        return self.bodies._replace(load=load, load_rate=rate)

    def allocate(self, count: int) -> tuple[np.ndarray, ...]:
        """States (count, N, COLUMNS), orientations (count, N, 4) and bodies (count, BODY_COLUMNS), all NaN."""
        balls = self.bearing.balls
        return tuple(np.full((count, *shape), math.nan) for shape in ((balls, COLUMNS), (balls, 4), (BODY_COLUMNS,)))

    def _part(self, times, duration, rows):
        """Integrate a part of constant acceleration and write its outputs."""
        goal, limit = self.goal_speed, self.parameters.drive.acceleration * duration
        change = min(limit, max(-limit, goal - self.drive.speed))
        drive, bodies = self.drive._replace(acceleration=change / duration), self._bodies()
        # Slip changes within microseconds after a jump, which a long step would pass over.
        jump = abs(drive.acceleration - self._acceleration) > SAME * self.parameters.drive.acceleration
        self._acceleration = drive.acceleration if jump else self._acceleration
        if bodies.active and bodies.load is not self._load:  # the same object for constant loads
            jump |= bool(np.any(np.abs(bodies.load - self._load) > SAME * np.abs(bodies.load)))
            jump |= bool(np.any(bodies.load_rate != self._load_rate))
            grows, self._load_rate = bodies.load_rate.any(), bodies.load_rate
            self._load = bodies.load + duration * bodies.load_rate if grows else bodies.load
        if jump:
            self.steps = np.minimum(self.steps, FIRST_STEP)
        instants, sample_times = times, np.zeros(0)
        if self.accelerometer:
            sample_times = self.accelerometer.times(self.sensor_state, self.elapsed, self.elapsed + duration)
            sampled = np.clip(sample_times - self.elapsed, 0.0, duration)
            instants = np.sort(np.concatenate([times, sampled]), kind="stable")
        filled, moving = self.allocate(len(instants)), [getattr(self, name) for name in MOVING]
        integrate = partial(self._integrate, bodies, drive)
        arguments = integrate, self.bearing.ball_radius, moving, instants, duration, filled
        if bodies.active or self._separated:
            integrate_in_common(*arguments, self._separated, bodies.even)
        else:
            integrate_alone(*arguments)
        if self.accelerometer:
            self._listen(bodies, drive, instants, filled, sample_times)
            rows_of_outputs = np.searchsorted(instants, times)
            filled = tuple(array[rows_of_outputs] for array in filled)
        self._write(bodies, drive, times, filled, rows)
        self._check_speed(times, filled[2])
        self.elapsed += duration
        if bodies.shaft:
            self.drive = RingDrive(*self.body_state[[SHAFT_ANGLE, SHAFT_SPEED]].tolist(), 0.0)
            self.goal_speed = self.drive.speed
            return
        # Exactly the goal once it is reached, since rounding would leave an acceleration.
        reached = abs(goal - self.drive.speed) <= limit * (1.0 + SHORTEST_PART)
        speed = goal if reached else self.drive.speed + change
        self.drive = drive.later(duration)._replace(speed=speed, acceleration=0.0)

    def _listen(self, bodies, drive, times, filled, sample_times) -> None:
        """Samples of the sensor at `sample_times` [s] of the run, by the states at `times` of a part."""
        rows = np.searchsorted(times, np.clip(sample_times - self.elapsed, 0.0, None))
        rows, forces = np.minimum(rows, len(times) - 1), np.zeros((len(rows), 3))
        for begin in range(0, len(rows), INSTANTS):
            part = rows[begin : begin + INSTANTS]
            motion = (array[part] for array in filled)
            forces[begin : begin + INSTANTS] = outer_ring_forces(
                self.parameters, self.bearing, bodies, drive, times[part], *motion
            )
        housing = filled[2][rows, HOUSING_POSITION : HOUSING_SPEED + 1]
        self.sensor_state, samples = self.accelerometer.samples(self.sensor_state, sample_times, forces, housing)
        if len(samples):
            self._samples.append(samples)

    def _integrate(self, bodies, drive, near, begin, times, duration, filled):
        filled[2][:] = self.body_state
        moving = [getattr(self, name) for name in MOVING]
        chunk = Chunk(
            *(self.bearing, drive.later(begin), bodies, near, times, duration, self.step, self.scales, self.stop),
            *(*moving, *filled, self.counts, np.zeros(2)),
        )
        elapsed = self.elapsed + begin
        try:
            check_status(integrate_chunk(self.stepper, chunk), elapsed, chunk.failure)
        except IntegrationError as error:
            raise self._explained(error, chunk, elapsed) from None

    def _explained(self, error: IntegrationError, chunk: Chunk, begin: float) -> IntegrationError:
        """The error of a chunk from `begin` [s] on; for a load on a ring with mass beyond its limit, one that names it.

        The load includes the ring's unbalance; it is checked at the beginning of the chunk, then at the error.
        """
        bodies = chunk.bodies
        if not bodies.ring or not error.seconds >= begin:
            return error
        for passed in (0.0, error.seconds - begin):
            drive, loads = chunk.drive.later(passed), (bodies.load + passed * bodies.load_rate)[:CAGE]
            loads[:2] += bodies.unbalance * drive.speed**2 * np.array([math.cos(drive.angle), math.sin(drive.angle)])
            loads = np.where(bodies.free[:CAGE] > 0.0, loads, 0.0)
            try:
                check_load(self.parameters, self.law, drive.speed, loads[:3], loads[3:])
            except BearingTwinError as limit:
                seconds = begin + passed
                return IntegrationError(f"at {seconds:.9g} s {limit}", OVERLOAD, seconds, "inner ring")
        return error

    def _check_speed(self, times, body_states) -> None:
        """Raise IntegrationError at the first of the `times` [s] from now at which the shaft turns too fast."""
        if not self.bodies.shaft:
            return
        limit, speeds = self.parameters.drive.greatest_speed, body_states[:, SHAFT_SPEED]
        beyond = ~(np.abs(speeds) <= limit)
        if beyond.any():
            seconds, speed = self.elapsed + float(times[beyond.argmax()]), float(speeds[beyond.argmax()])
            sentence = (
                f"at {seconds:.9g} s the inner ring turns at {speed:.6g} rad/s, beyond drive.greatest_speed = "
                f"{limit:g} rad/s: nothing holds the torque; lower it, or add drive.damping"
            )
            raise IntegrationError(sentence, TOO_FAST, seconds, "inner ring")


def bearing_motion(parameters: BearingScene, choice: Choice):
    """The motion of a bearing by the chosen model: equilibria, or balls by their equations of motion."""
    return (QuasiStaticMotion if choice.stepper == QUASI_STATIC else BearingMotion)(parameters, choice)
