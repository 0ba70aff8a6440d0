"""From a bearing scene to its equations, its start, and its motion chunk by chunk, by any of the steppers."""

import functools

import numpy as np
from scipy.integrate import DOP853, Radau

from bearing_twin.errors import IntegrationError, SceneError, Stopped
from bearing_twin.kinds.bearing.equations import RingDrive, mark_near, time_apart
from bearing_twin.kinds.bearing.explicit import explicit_chunk
from bearing_twin.kinds.bearing.imex import imex_chunk
from bearing_twin.kinds.bearing.layout import CARRIED_COLUMNS, DRIVE_WORK, GROSS_WORK, ORBIT_ANGLE
from bearing_twin.kinds.bearing.linear_system import new_coupling
from bearing_twin.kinds.bearing.outputs import Outputs, empty_outputs, outputs_of, write_outputs
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.quasi_static.running import QuasiStaticMotion
from bearing_twin.kinds.bearing.rings import QUASI_STATIC
from bearing_twin.kinds.bearing.rosenbrock import ChunkTask, groups_of, rosenbrock_chunk
from bearing_twin.kinds.bearing.scipy_chunk import scipy_chunk
from bearing_twin.kinds.bearing.start import Rates, bearing_of, fastest_rates, stable_step, start_state
from bearing_twin.kinds.bearing.steps import JACOBIANS, RATES, REJECTIONS, STEPS, Results
from bearing_twin.numerics.statuses import NOT_FINITE, OK, STALLED, STOPPED, TOO_DEEP
from bearing_twin.numerics.steppers import EXPLICIT, ROSENBROCK
from bearing_twin.report import Choice
from bearing_twin.stopping import SIGNALLED

NEAR = 0.05  # gap / ball radius below which two balls may meet within a chunk
FIRST_STEP = 1e-6  # s, of adaptive steppers at the start and where the ring's acceleration changes
SAME = 1e-9  # relative: accelerations nearer than this differ by rounding alone
APPROACH_SCALE = 1e-6  # m, the size of an elastic approach: errors of position count against it
STEP_SHARE = 0.2  # share of the wanted accuracy that one adaptive step may spend
REFERENCE_SHARE = 1e-4  # the same for SciPy's methods, whose only use here is to be right
FAILURES = {
    NOT_FINITE: ("not finite", "is not finite any more; shorten solver.step or use solver.stepper: rodas4"),
    TOO_DEEP: ("too deep", "has run through a raceway; check the loads, or shorten solver.step"),
    STALLED: (
        "stalled",
        "needs ever shorter steps; loosen wanted.tolerance or raise contact.friction_regularisation",
    ),
}
FIXED_STEP = ("rk4", "imex")
LONGEST_TOGETHER = 0.02  # s for which balls are integrated together before the next look at who may meet
TOGETHER = 0.05  # share of that time, or of what is left of a chunk: balls that may meet sooner are integrated together
EVERYWHERE = 1e9  # m: a gap that no two balls that can meet exceed
SHORTEST_PART = 1e-9  # share of a chunk: parts shorter than this are none
SCIPY = {"dop853": DOP853, "radau": Radau}


def bearing_motion(parameters: BearingScene, choice: Choice):
    """What moves a bearing by the chosen model: equilibria, or balls by their equations of motion."""
    return (QuasiStaticMotion if choice.stepper == QUASI_STATIC else BearingMotion)(parameters, choice)


class BearingMotion:
    """The bearing in motion: `advance` integrates one chunk and returns its outputs.

    `counts` holds steps, rejections, evaluations of a ball's rates and Jacobians so far.
    """

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters = parameters
        self.bearing = self._bearing = bearing_of(parameters, choice.law)
        self.stepper = choice.stepper
        self.stop = SIGNALLED
        self._start = start_state(self.bearing, parameters.drive.speed, parameters.initial.motion)
        self.step = parameters.solver.step
        if choice.stepper in FIXED_STEP:
            self.step = self.step or stable_step(self.rates, choice.stepper)
            self._refuse_long_steps()
        # A load errs with its approach; friction, over mu N, by at most the error of the slip over this speed.
        speed = parameters.contact.friction_regularisation
        radius, pitch = self.bearing.ball_radius, 0.5 * parameters.geometry.pitch_diameter
        unit = [APPROACH_SCALE, APPROACH_SCALE / pitch, APPROACH_SCALE, *(speed,) * 3, *(speed / radius,) * 3]
        self.scales = parameters.wanted.tolerance * STEP_SHARE * np.array(unit)
        self.reset()

    @functools.cached_property
    def rates(self) -> Rates:
        """The fastest rates to be expected from the start."""
        return fastest_rates(self._bearing, self._start)

    def _refuse_long_steps(self):
        if self.step > self.rates.shortest_contact / 8.0:
            raise SceneError(
                f"solver.step = {self.step:g} s is too long: a contact can be as short as "
                f"{self.rates.shortest_contact:.2g} s and needs at least 8 steps; "
                f"use {self.rates.shortest_contact / 16.0:.2g} s or less, or solver.stepper: rodas4"
            )
        if self.stepper == "rk4" and self.step * self.rates.friction > 2.78:
            raise SceneError(
                f"solver.step = {self.step:g} s is unstable: friction answers at {self.rates.friction:.2g} /s and the "
                f"classical Runge-Kutta method holds to {2.78 / self.rates.friction:.2g} s; use a shorter step, "
                f"or solver.stepper: rodas4"
            )

    def reset(self) -> None:
        """Back to the start."""
        self.state = self._start.copy()
        self.orientation = np.zeros((self.bearing.balls, 4))
        self.orientation[:, 3] = np.cos(-0.5 * self.state[:, ORBIT_ANGLE])
        self.orientation[:, 2] = np.sin(-0.5 * self.state[:, ORBIT_ANGLE])
        self.drive = RingDrive(0.0, float(self.parameters.drive.speed), 0.0)
        self.goal_speed = float(self.parameters.drive.speed)
        self.bearing = self._bearing
        self.steps = np.full(self.bearing.balls, FIRST_STEP)
        self.carried = np.zeros((self.bearing.balls, CARRIED_COLUMNS))
        self._acceleration = 0.0
        self.elapsed = 0.0
        self._changed = self.parameters.drive.change.time == 0.0
        self.counts = np.zeros(4, np.int64)
        self._keep()

    def _keep(self) -> None:
        """Keeps what `take_back` needs."""
        arrays = tuple(one.copy() for one in (self.state, self.orientation, self.steps, self.carried, self.counts))
        rest = self.drive, self.goal_speed, self.bearing, self._acceleration, self.elapsed, self._changed
        self._before = arrays, rest

    def take_back(self) -> None:
        """Back to before the last `advance`."""
        (self.state, self.orientation, self.steps, self.carried, self.counts), rest = self._before
        self.drive, self.goal_speed, self.bearing, self._acceleration, self.elapsed, self._changed = rest
        self._keep()

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        arrays = {name: getattr(self, name).tolist() for name in ("state", "orientation", "steps", "counts")}
        rest = {"drive": list(self.drive), "goal_speed": self.goal_speed, "offset": list(self.bearing.offset)}
        fixed = {"fixed_step": self.step} if self.stepper in FIXED_STEP else {}
        moving = {"elapsed": self.elapsed, "changed": self._changed, "acceleration": self._acceleration}
        return arrays | rest | fixed | moving

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; raises KeyError, TypeError or ValueError for one of another bearing."""
        self.reset()
        for array, name in ((self.state, "state"), (self.orientation, "orientation"), (self.steps, "steps")):
            given = np.array(kept[name], float)
            if given.shape != array.shape or not np.isfinite(given).all():
                raise ValueError(name)
            array[...] = given
        if not (self.steps > 0.0).all():
            raise ValueError("steps")
        self.counts[:] = kept["counts"]
        self.drive = RingDrive(*map(float, kept["drive"]))
        self.goal_speed, self.elapsed, self._changed = (
            float(kept["goal_speed"]),
            float(kept["elapsed"]),
            kept["changed"],
        )
        self._acceleration = float(kept["acceleration"])
        self.bearing = self._bearing._replace(offset=tuple(map(float, kept["offset"])))
        self._keep()

    def take_records(self) -> dict[str, np.ndarray]:
        """None: the outputs of a bearing say all."""
        return {}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps, evaluations of one ball's rates, and Jacobians, summed over the balls."""
        return {
            "ball_steps": int(self.counts[STEPS]),
            "ball_rejections": int(self.counts[REJECTIONS]),
            "ball_rates": int(self.counts[RATES]),
            "ball_jacobians": int(self.counts[JACOBIANS]),
        }

    def first_outputs(self) -> Outputs:
        """The outputs at the present instant."""
        out = empty_outputs(self.parameters, 1)
        now = np.zeros(1), self.state[None], self.orientation[None]
        write_outputs(self.parameters, self.bearing, self.drive, *now, out, 0)
        return outputs_of(self.parameters, out)

    def advance(self, times: np.ndarray, duration: float) -> Outputs:
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError.

        A new goal speed is approached at the drive's acceleration; the scene's change of the drive comes at its time.
        """
        if not np.all(np.isfinite(self.state)):
            ball = int(np.argmin(np.isfinite(self.state).all(axis=1)))
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
            self._part(np.minimum(times[cursor:until] - begin, end - begin), end - begin, out, cursor)
            begin, cursor = end, until
        return outputs_of(self.parameters, out)

    def _until_next(self, duration):
        """Seconds for which the drive accelerates evenly and, unless that is very short, balls stay apart."""
        missing = self.goal_speed - self.drive.speed
        apart = time_apart(self.bearing, self.state, NEAR * self.bearing.ball_radius)
        together = min(duration, LONGEST_TOGETHER)
        pieces = [duration, 0.99 * apart if apart > TOGETHER * together else together]
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
        work = self.first_outputs().elastic_energy[0] - before
        self.state[0, DRIVE_WORK] += work
        self.state[0, GROSS_WORK] += abs(work)

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
        states = np.full((len(times), *self.state.shape), np.nan)
        orientations = np.full((len(times), *self.orientation.shape), np.nan)
        before = self.state.copy(), self.orientation.copy(), self.steps.copy(), self.carried.copy()
        near = np.zeros(self.bearing.balls, np.bool_)
        mark_near(self.bearing, self.state, NEAR * self.bearing.ball_radius, duration, near)
        self._integrate(drive, near, times, duration, states, orientations)
        after = np.zeros_like(near)
        mark_near(self.bearing, self.state, 0.5 * NEAR * self.bearing.ball_radius, 0.0, after)
        if np.any(after & ~near):
            # Balls came together that were integrated apart: once more, all together.
            self.state[:], self.orientation[:], self.steps[:], self.carried[:] = before
            mark_near(self.bearing, self.state, EVERYWHERE, 0.0, near)
            self._integrate(drive, near, times, duration, states, orientations)
        write_outputs(self.parameters, self.bearing, drive, times, states, orientations, out, first)
        angle = drive.angle + duration * (drive.speed + 0.5 * drive.acceleration * duration)
        # The goal itself once it is reached, so that no rounding keeps an acceleration alive.
        reached = abs(missing) <= limit * (1.0 + SHORTEST_PART)
        self.drive = RingDrive(angle, self.goal_speed if reached else drive.speed + change, 0.0)
        self.elapsed += duration

    def _integrate(self, drive, near, times, duration, states, orientations):
        moving = self.state, self.orientation
        failure = np.zeros(2)
        results = Results(states, orientations, self.counts, failure, self.stop, self.carried)
        chunk = self.bearing, drive, near, times, duration
        if self.stepper in ROSENBROCK:
            task = ChunkTask(
                method=ROSENBROCK[self.stepper],
                bearing=self.bearing,
                drive=drive,
                times=times,
                duration=duration,
                scales=self.scales,
            )
            status = self._rosenbrock(task, near, results)
        elif self.stepper in EXPLICIT:
            method = EXPLICIT[self.stepper]
            status = explicit_chunk(method, *chunk, self.step, self.scales, *moving, self.steps, results)
        elif self.stepper == "imex":
            status = imex_chunk(*chunk, self.step, *moving, results)
        else:
            scales = REFERENCE_SHARE * self.scales
            status = scipy_chunk(SCIPY[self.stepper], *chunk, scales, *moving, results)
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {self.elapsed:.9g} s")
        if status != OK:
            reason, advice = FAILURES[status]
            seconds, body = self.elapsed + failure[0], f"ball {int(failure[1])}"
            raise IntegrationError(f"at {seconds:.9g} s {body} {advice}", reason, seconds, body)

    def _rosenbrock(self, task, near, results):
        """One chunk: balls that touch no other side by side, then each group of balls that may touch.

        The rings' motion is prescribed, so a ball acts on another only where they touch.
        """
        moving = self.state, self.orientation, self.steps
        groups = [np.array(group, np.int64) for group in groups_of(near)]
        alone = [group for group in groups if len(group) == 1]
        status = rosenbrock_chunk(task, (), np.concatenate(alone), *moving, results) if alone else OK
        for group in groups:
            if status == OK and len(group) > 1:
                status = rosenbrock_chunk(task, new_coupling(near, group), group, *moving, results)
        return status
