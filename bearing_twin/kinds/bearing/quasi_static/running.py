"""A run from equilibria: the ring turns as driven, the balls go round in one cage, every output is a static answer."""

import math

import numpy as np

from bearing_twin.errors import IntegrationError, SceneError, Stopped
from bearing_twin.kinds.bearing.outputs import Outputs, channels
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.quasi_static.channels import write_channels
from bearing_twin.kinds.bearing.quasi_static.chunk import Course, Instants, State, equilibria, new_instants
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts, limits_used
from bearing_twin.kinds.bearing.quasi_static.in_motion import in_motion, turn_of_scene
from bearing_twin.kinds.bearing.quasi_static.newton import FOUND
from bearing_twin.kinds.bearing.quasi_static.ring_balance import PLACES
from bearing_twin.kinds.bearing.quasi_static.settled import Turn
from bearing_twin.kinds.bearing.quasi_static.statics import (
    azimuths_of,
    load_line,
    setting_of,
    support_of,
    weighed_solver,
)
from bearing_twin.kinds.bearing.quasi_static.surroundings import TAKEN
from bearing_twin.kinds.bearing.quasi_static.turn_table import NO_TABLE, without_shares
from bearing_twin.kinds.energy import STORED
from bearing_twin.numerics.rotation import quaternion_product
from bearing_twin.numerics.statuses import STOPPED
from bearing_twin.report import BESIDE, Choice
from bearing_twin.stopping import SIGNALLED

MOVING = (
    "goal_speed", "loads", "speed", "angle", "elapsed", "solved", "settling", "_changed", "_stored", "_first_stored",
    "_gross", "_worked", "_lost", "_tables", "_turn", "_turned_at",
)  # fmt: skip
NEAR = 0.02  # relative: speeds nearer than this have one friction while they only pass
SAME = 1e-9  # relative: instants nearer than this are one


class QuasiStaticMotion:
    """A bearing whose every output is an equilibrium: no inertia but that of the orbits, no history but the cage's way.

    `goal_speed` [rad/s] is approached at the drive's acceleration; `loads` [N, N m] (5,) act on the free coordinates.
    """

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters = parameters
        self.setting = setting_of(parameters, choice.law, parameters.drive.speed)
        self.support = support_of(parameters)
        azimuths = azimuths_of(parameters.geometry.balls, 0.0)
        solver = weighed_solver(parameters, self.setting, azimuths)
        self._start = solver.solve(self.support)
        self._first_turn = turn_of_scene(parameters, choice.law)
        self._gravity = tuple(map(float, parameters.gravity))
        self._longest, self.stop = solver.longest, SIGNALLED
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        balls = self.parameters.geometry.balls
        place = np.zeros((balls, PLACES))
        place[:] = np.nan
        half = -np.pi * np.arange(balls) / balls
        zero = np.zeros(balls)
        attitude = np.stack([zero, zero, np.sin(half), np.cos(half)], axis=1)
        self.state = State(np.zeros(2), self._start.coordinates.copy(), place, attitude)
        self.goal_speed = self.speed = float(self.parameters.drive.speed)
        self.loads = self.support.loads
        self.angle = self.elapsed = 0.0
        self.solved = self.settling = 0
        self._changed = False
        self._tables, self._turn, self._turned_at = {}, None, 0.0
        self._stored = self._first_stored = None
        self._gross = self._worked = self._lost = 0.0  # the last two: of balls that moved by themselves before
        self._before = None
        self._keep()

    @property
    def changed(self) -> bool:
        """Whether the scene's change of the drive has come, or there is none."""
        return self._changed or not self.parameters.drive.change.time

    def go_on_from(self, here, goal_speed: float, elapsed: float, changed: bool) -> None:
        """Goes on at `elapsed` [s] from the outputs `here` of moving balls, which are spaced evenly from now on.

        What that does to their energy is work of the drive. `changed`: the scene's change of the drive has come, or
        there is none.
        """
        balls = self.parameters.geometry.balls
        first = float((here.orbit_angle[0] - azimuths_of(balls, 0.0)).mean())
        half = -0.5 * azimuths_of(balls, first)
        back = np.stack([0.0 * half, 0.0 * half, np.sin(half), np.cos(half)], axis=1)
        for own, turn, now in zip(self.state.attitude, back, here.orientation[0], strict=True):
            own[:] = quaternion_product(tuple(turn), tuple(now))
        self.state.cage[0] = first
        self.goal_speed, self.elapsed = goal_speed, elapsed
        self.speed, self.angle = float(here.inner_ring_speed[0]), float(here.inner_ring_angle[0])
        self._changed = changed and self.parameters.drive.change.time > 0.0
        self.first_outputs()
        stored = sum(float(getattr(here, name)[0]) for name in STORED)
        gained = self._stored - stored
        self._gross, self._lost = float(here.gross_work[0]) + abs(gained), float(here.dissipated[0])
        self._worked = float(here.drive_work[0]) + gained
        self._keep()

    def _keep(self) -> None:
        """Keeps what `take_back` needs."""
        kept = {name: value for name, value in vars(self).items() if name in MOVING}
        self._before = State(*(values.copy() for values in self.state)), kept

    def take_back(self) -> None:
        """Back to before the last `advance`."""
        state, kept = self._before
        self.state = State(*(values.copy() for values in state))
        vars(self).update(kept)

    def set_load(self, force, moment) -> None:
        """New loads on the inner ring [N], [N m] from now on, or the scene's own where both are None.

        They are taken as `operating.check_load` let them pass.
        """
        self.loads = self.support.loads if force is None else (*map(float, force), *map(float, moment))[:5]

    def take_records(self) -> dict[str, np.ndarray]:
        """None: the outputs of a bearing say all."""
        return {}

    def costs(self) -> dict[str, int]:
        """Equilibria of the ring solved so far, and evaluations of what acts on a ball, to find how balls move."""
        return {"equilibria": self.solved} | ({BESIDE: self.settling} if self.settling else {})

    def first_outputs(self) -> Outputs:
        """The outputs at the present instant."""
        course, angle = self._course(np.zeros(1))
        return self._outputs(course, angle)

    def advance(self, times: np.ndarray, duration: float) -> Outputs:
        """The outputs at `times` [s] from now, moved on by `duration` [s]; raises IntegrationError."""
        if self._stored is None:
            self.first_outputs()
        self._keep()
        instants = np.asarray(times, dtype=float)
        if not len(instants) or duration > instants[-1] * (1.0 + SAME):
            instants = np.append(instants, duration)
        course, angle = self._course(instants)
        out = self._outputs(course, angle)
        self.elapsed += duration
        return Outputs(*(values[: len(times)] for values in out))

    def _course(self, instants) -> tuple[Course, np.ndarray]:
        """What is prescribed at `instants` [s] from now, and the ring's angle there; moves the drive on."""
        drive, change = self.parameters.drive, self.parameters.drive.change
        begin, speed, angle, parts = 0.0, self.speed, self.angle, []
        free = np.array(self.support.free, np.bool_)
        wanted = np.where(free, self.loads, 0.0)
        if speed == self.goal_speed and (self._changed or change.time == 0.0):
            return self._even_course(instants, free, wanted)
        # knots: the goal changes once, and each speed is approached evenly until it is there
        when = change.time - self.elapsed if change.time > 0.0 and not self._changed else np.inf
        speeds, angles = np.empty(len(instants)), np.empty(len(instants))
        for row, instant in enumerate(instants):
            while begin < instant or begin == when:
                if begin >= when:
                    self.goal_speed += change.speed
                    self._changed, when = True, np.inf
                end = min(instant, when)
                missing = self.goal_speed - speed
                ramp = min(abs(missing) / drive.acceleration, end - begin)
                gained = np.sign(missing) * drive.acceleration * ramp
                reached = ramp >= abs(missing) / drive.acceleration * (1.0 - SAME)
                angle += (speed + 0.5 * gained) * ramp
                speed = self.goal_speed if reached else speed + gained
                angle += speed * (end - begin - ramp)
                begin = end
            speeds[row], angles[row] = speed, angle
            parts.append(self._changed)
        held = np.tile(np.asarray(self.support.held), (len(instants), 1))
        held[np.array(parts), :3] += change.offset
        turn = np.diff(angles, prepend=self.angle)
        steps = np.diff(instants, prepend=0.0)
        self.speed, self.angle = speed, angle
        return Course(steps, turn, speeds, held, free, wanted), angles

    def _even_course(self, instants, free, wanted) -> tuple[Course, np.ndarray]:
        """As `_course`, where the ring turns evenly and nothing changes any more."""
        held = np.array(self.support.held)
        if self._changed:
            held[:3] += self.parameters.drive.change.offset
        steps = np.diff(instants, prepend=0.0)
        angles = self.angle + self.speed * instants
        self.angle = float(angles[-1])
        count = len(instants)
        course = Course(steps, self.speed * steps, np.full(count, self.speed), np.tile(held, (count, 1)), free, wanted)
        return course, angles

    def _outputs(self, course: Course, angle) -> Outputs:
        found = new_instants(len(angle), self.parameters.geometry.balls)
        status, instant = self._solve(course, found)
        seconds = self.elapsed + float(course.step[: instant + 1].sum())
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {seconds:.9g} s")
        if status != FOUND:
            raise IntegrationError(
                f"at {seconds:.9g} s the inner ring finds no balance; lower the load, or see bearing_twin bearing for "
                "the greatest there is",
                "no balance",
                seconds,
                "inner ring",
            )
        self._refuse_illegal(found, course)
        self.solved += len(angle)
        count = len(angle)
        out = Outputs(*(np.zeros((count, *channel.shape)) for channel in channels(self.parameters)))
        write_channels(self.setting, self._gravity, found, course.speed, angle, out)
        self._write_work(out)
        return out

    def _table(self, speed: float, held) -> np.ndarray:
        """What settled balls are in balance with at this speed [rad/s], the ring's held coordinates being these (5,).

        Of speeds that only pass, that of the nearest power of 1 + NEAR.
        """
        if speed not in (self.parameters.drive.speed, self.goal_speed, 0.0):
            speed = math.copysign((1.0 + NEAR) ** round(math.log(abs(speed)) / math.log1p(NEAR)), speed)
        key = speed, tuple(self.loads), tuple(held.tolist())
        if key not in self._tables:
            setting = self.setting._replace(speed=speed)
            support = self.support._replace(loads=self.loads, held=key[2])
            azimuths = azimuths_of(self.parameters.geometry.balls, load_line(support))
            passing, near = speed not in (self.parameters.drive.speed, self.goal_speed), self._turn
            if not passing:  # as in a run that begins with it
                near = self._first_turn if speed == self.parameters.drive.speed else None
            elif isinstance(near, Turn):
                near = near.quicker(speed / self._turned_at)
            solver, before = weighed_solver(self.parameters, setting, azimuths), TAKEN.evaluations
            try:
                table, turn = in_motion(self.parameters, solver, support, near, not passing)[1:]
            except SceneError:  # the run says so where it comes there
                table = NO_TABLE
            else:
                self._turn, self._turned_at = (turn if len(turn.motion) else None), speed
            self.settling += TAKEN.evaluations - before
            self._tables = dict([*self._tables.items()][-1:]) | {key: table}
        return self._tables[key]

    def _solve(self, course: Course, found) -> tuple[int, int]:
        """Fills `found` by `equilibria`, from one table to the next."""
        begin, count, gravity = 0, len(course.turn), self._gravity
        tables = [self._table(float(s), h) for s, h in zip(course.speed, course.held, strict=True)]
        while begin < count:
            end = begin + 1
            while end < count and tables[end] is tables[begin]:
                end += 1
            part = slice(begin, end)
            some = Course(*(v[part] for v in course[:4]), course.free, course.wanted)
            out = Instants(*(v[part] for v in found[:-1]), Contacts(*(v[part] for v in found.contacts)))
            setting = without_shares(self.setting) if len(tables[begin]) else self.setting
            numbers = setting, gravity, tables[begin], some, self.state, self._longest, out, self.stop
            status, instant = equilibria(*numbers)
            if status != FOUND:
                return status, begin + instant
            begin = end
        return FOUND, count

    def _refuse_illegal(self, found, course) -> None:
        """Raises IntegrationError at the first output whose contacts bear too much or leave the grooves."""
        contacts = found.contacts
        bad = np.maximum(*limits_used(self.setting, contacts.load, contacts.approach, contacts.angle)) > 1.0
        if bad.any():
            row, ball = np.argwhere(bad)[0]
            seconds = self.elapsed + float(course.step[: row + 1].sum())
            sentence = f"at {seconds:.9g} s ball {ball} is squeezed too hard, or leaves the grooves; lower the load"
            raise IntegrationError(sentence, "too deep", seconds, f"ball {ball}")

    def _write_work(self, out: Outputs) -> None:
        """What the balls hold more than at the start came through the inner ring: nothing is lost in an equilibrium."""
        stored = out.kinetic_energy + out.elastic_energy + out.potential_energy
        if self._stored is None:
            self._stored = self._first_stored = stored[0]
        out.drive_work[:] = self._worked + stored - self._first_stored
        out.dissipated[:] = self._lost
        gross = np.abs(np.diff(stored, prepend=self._stored)).cumsum()
        out.gross_work[:] = self._gross + gross
        self._gross, self._stored = float(out.gross_work[-1]), stored[-1]
