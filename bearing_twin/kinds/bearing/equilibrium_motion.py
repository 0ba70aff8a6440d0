"""A run of equilibria: the ring turns as driven, the balls orbit in one cage, every output is an equilibrium."""

from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.report import Choice
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.core import INTEGER, INTEGERS, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.defects import defect_numbers
from bearing_twin.kinds.bearing.equilibrium import (
    FOUND,
    OF_BALL,
    OF_CONTACTS,
    STOP,
    STOPPED,
    CommandedBearing,
    azimuths_of,
    contacts_in,
    controlled,
    limits_used,
    setting_of,
    weighed_solver,
    weighed_support,
)
from bearing_twin.kinds.bearing.friction_torque import contact_losses
from bearing_twin.kinds.bearing.lubricant import lubricated
from bearing_twin.kinds.bearing.outputs import Rows, empty_outputs
from bearing_twin.kinds.bearing.parameters import BearingScene

MOVING = (
    "goal_speed", "loads", "speed", "angle", "elapsed", "solved", "_changed", "_stored", "_first_stored",
    "_gross", "_lost", "_power",
)  # fmt: skip
SAME = 1e-9  # relative: instants nearer than this are one
LEFT = 1e-12  # of the loads, or of their moments: sums of forces that are less are what the solution leaves of nothing


class Course(NamedTuple):
    """Prescribed motion at the instants (T,): seconds since the one before, the ring's turn [rad] and speed [rad/s].

    `held` (T, 5) [m, rad] are the coordinates of the ring, of which `free` (5,) follow `wanted` (5,) [N, N m].
    """

    step: np.ndarray
    turn: np.ndarray
    speed: np.ndarray
    held: np.ndarray
    free: np.ndarray
    wanted: np.ndarray


class State(NamedTuple):
    """State between instants: azimuth of ball 0, orbit over ring speed (2,); ring, balls, attitudes."""

    cage: np.ndarray
    q: np.ndarray
    place: np.ndarray
    attitude: np.ndarray


class Instants(NamedTuple):
    """Equilibria at instants (T, ...): azimuth of ball 0, orbit, ring, load, balls' places, attitudes, contacts."""

    azimuth: np.ndarray
    orbit: np.ndarray
    q: np.ndarray
    load: np.ndarray
    place: np.ndarray
    attitude: np.ndarray
    contacts: np.ndarray


_run = Function(
    "core_equilibrium_run",
    INTEGER,
    (REALS, REALS, REAL, INTEGER, INTEGER, *(REALS,) * 4, INTEGERS, REALS, STOP, *(REALS_OUT,) * 11, INTEGERS_OUT),
)


def _about_z(cosine, sine, radial, tangential, axial) -> np.ndarray:
    """Vectors (..., 3) in the bearing's axes of parts along a ball's radius, along its orbit, and along the axis."""
    parts = cosine * radial - sine * tangential, sine * radial + cosine * tangential, axial
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def write_channels(setting, gravity, found: Instants, speeds, angles, out: Rows) -> None:
    """Fills `out` from `found`, the ring at `speeds` [rad/s] and `angles` [rad] (T,).

    Names and meanings are those of runs whose balls move by themselves. Sums of forces and moments that come to nothing
    are 0. Friction is that across the grooves, which gyroscopic moments need; slip is that of balls in one cage, which
    carries what the inner contacts of a ring that is off the axis push along the orbit. Works and losses are left at 0.
    """
    contacts, balls = contacts_in(found.contacts), found.place.shape[1]
    azimuth = found.azimuth[:, None] + azimuths_of(balls, 0.0)
    cosine, sine, orbit = np.cos(azimuth), np.sin(azimuth), found.orbit[:, None]
    distance = setting.outer.locus_radius + found.place[..., 0]
    position = _about_z(cosine, sine, distance, 0.0, found.place[..., 1])
    velocity = _about_z(cosine, sine, 0.0, distance * orbit, 0.0)
    spin = _about_z(cosine, sine, contacts.pitch, 0.0, orbit - contacts.roll)
    # how far the pull of the inner groove's centre points along the orbit
    x, y, _, tilt_x, tilt_y = (column[:, None] for column in found.q.T)
    beside = 2.0 / setting.pitch_diameter * (y * cosine - x * sine)
    inner = contacts.angle[..., 0]
    lean = -(np.cos(inner) * beside + np.sin(inner) * (tilt_x * cosine + tilt_y * sine))
    carried = contacts.load.sum(axis=(1, 2))[:, None]
    pressed = contacts.load.sum(axis=2)[..., None]
    for side, (sign, leans) in enumerate(((-1.0, lean), (1.0, np.zeros_like(lean)))):
        load, approach, angle = (one[..., side] for one in (contacts.load, contacts.approach, contacts.angle))
        n_r, n_z, across = np.cos(angle), np.sin(angle), contacts.friction[..., side]
        scale = sign / np.sqrt(1.0 + leans * leans)
        outward = _about_z(cosine, sine, scale * n_r, scale * leans, scale * n_z)  # from the ball to the raceway
        friction = _about_z(cosine, sine, -across * n_z, 0.0, across * n_r)
        arm = (setting.ball_radius - 0.5 * approach)[..., None] * outward
        point = position + arm
        turning = speeds[:, None] if side == 0 else np.zeros((len(speeds), 1))
        about = point - found.q[:, None, :3] if side == 0 else point
        along = np.stack([-turning * about[..., 1], turning * about[..., 0], np.zeros_like(load)], axis=-1)
        relative = velocity + np.cross(spin, arm) - along
        force = friction - load[..., None] * outward
        out.spin_rate[..., side] = (spin * outward).sum(-1) - turning * outward[..., 2]
        out.point[..., side, :], out.normal[..., side, :] = point, -outward
        out.friction_force[..., side, :] = friction
        out.slip[..., side, :] = relative - (relative * outward).sum(-1)[..., None] * outward
        out.elastic_energy[:] += (load * np.maximum(approach, 0.0)).sum(1) / (setting.inner.law.power + 1.0)
        out.raceway_force[:] += force
        out.raceway_torque[:] += np.cross(arm, force)
        if side == 1:
            out.outer_ring_force[:] = -force.sum(1)
            out.outer_ring_torque[:] = -np.cross(point, force).sum(1)
    for name in ("approach", "curvature_small", "curvature_large"):
        getattr(out, name)[:] = getattr(contacts, name)
    out.normal_load[:], out.contact_angle[:] = contacts.load, contacts.angle
    out.orbit_angle[:], out.roll_rate[:], out.orientation[:] = azimuth, contacts.roll, found.attitude
    out.position[:], out.velocity[:], out.angular_velocity[:] = position, velocity, spin
    if balls > 1:
        between = np.linalg.norm(np.roll(position, -1, axis=1) - position, axis=-1)
        out.neighbour_approach[:] = 2.0 * setting.ball_radius - between
    turned_by = 0.4 * setting.ball_radius**2 * (spin**2).sum(-1)
    out.kinetic_energy[:] = 0.5 * setting.ball_mass * ((velocity**2).sum(-1) + turned_by).sum(1)
    out.potential_energy[:] = -setting.ball_mass * (position @ np.array(gravity)).sum(1)
    out.inner_ring_angle[:], out.inner_ring_speed[:] = angles, speeds
    out.inner_ring_offset[:], out.inner_ring_tilt[:] = found.q[:, :3], found.q[:, 3:]
    out.inner_ring_force[:], out.inner_ring_torque[:, :2] = -found.load[:, :3], -found.load[:, 3:]
    out.cage_angle[:], out.cage_speed[:] = found.azimuth, found.orbit
    lever = 0.5 * setting.pitch_diameter
    for values, size in (
        (out.raceway_force, pressed),
        (out.raceway_torque, setting.ball_radius * pressed),
        (out.inner_ring_force, carried),
        (out.outer_ring_force, carried),
        (out.inner_ring_torque, lever * carried),
        (out.outer_ring_torque, lever * carried),
    ):
        values[np.abs(values) <= LEFT * size] = 0.0


class QuasiStaticMotion(CommandedBearing):
    """A bearing whose every output is an equilibrium: no inertia but that of the orbits, no history but the cage's way.

    `goal_speed` [rad/s] is approached at the drive's acceleration; `loads` [N, N m] (5,) act on the free coordinates.
    """

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters, self.law = parameters, choice.law
        self.setting = setting_of(parameters, choice.law, parameters.drive.speed)
        self.support = weighed_support(parameters)
        azimuths = azimuths_of(parameters.geometry.balls, 0.0)
        solver = weighed_solver(parameters, self.setting, azimuths)
        self._start = controlled(parameters, solver, self.support)
        self.setting, self._defects = solver.setting, np.zeros(1)
        if parameters.defects:
            load = float(self._start.contacts.load.max())
            self._defects = defect_numbers(parameters, load)
        self._seat, self.stop = self.setting.numbers(parameters.gravity), SIGNALLED
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        balls = self.parameters.geometry.balls
        place = np.full((balls, OF_BALL), np.nan)
        half = -np.pi * np.arange(balls) / balls
        zero = np.zeros(balls)
        attitude = np.stack([zero, zero, np.sin(half), np.cos(half)], axis=1)
        self.state = State(np.zeros(2), self._start.coordinates.copy(), place, attitude)
        self.goal_speed = self.speed = float(self.parameters.drive.speed)
        self.loads = self.support.loads
        self.angle = self.elapsed = 0.0
        self.solved = 0
        self._changed = False
        self._stored = self._first_stored = None
        self._gross = self._lost = 0.0
        self._power: float | None = None
        self._before = None
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

        They are taken as `check_load` let them pass.
        """
        given = None if force is None else (*map(float, force), *map(float, moment))[:5]
        self.loads = weighed_support(self.parameters, given).loads

    def take_records(self) -> dict[str, np.ndarray]:
        """None: the outputs of a bearing say all."""
        return {}

    def costs(self) -> dict[str, int]:
        """Equilibria of the ring solved so far."""
        return {"equilibria": self.solved}

    def first_outputs(self) -> Rows:
        """The outputs at the present instant."""
        course, angle = self._course(np.zeros(1))
        return self._outputs(course, angle)

    def advance(self, times: np.ndarray, duration: float) -> Rows:
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
        return Rows(out.layout, out.numbers[: len(times)])

    def _course(self, instants) -> tuple[Course, np.ndarray]:
        """Prescribed motion at `instants` [s] from now, and the ring's angle there; moves the drive on."""
        drive, change, count = self.parameters.drive, self.parameters.drive.change, len(instants)
        due = change.time - self.elapsed if change.time > 0.0 and not self._changed else np.inf
        times, speeds = [0.0], [self.speed]  # between which the speed is straight

        def approach(goal: float, until: float) -> None:
            reached = times[-1] + abs(goal - speeds[-1]) / drive.acceleration
            if reached < until:
                times.append(reached)
                speeds.append(goal)
            elif until < np.inf:
                gained = np.sign(goal - speeds[-1]) * drive.acceleration * (until - times[-1])
                speeds.append(speeds[-1] + gained)
                times.append(until)

        changed = (instants >= due) | self._changed
        approach(self.goal_speed, due)
        if due <= instants[-1]:
            self._changed, self.goal_speed = True, self.goal_speed + change.speed
            times.append(max(due, times[-1]))
            speeds.append(speeds[-1])
            approach(self.goal_speed, np.inf)
        speed = np.interp(instants, times, speeds)
        steps = np.diff(instants, prepend=0.0)
        if min(speeds) == max(speeds):
            angles, turn = self.angle + self.speed * instants, self.speed * steps
        else:
            knots = np.union1d(times, instants)
            straight = np.interp(knots, times, speeds)
            turned = np.cumsum(0.5 * (straight[1:] + straight[:-1]) * np.diff(knots))
            angles = self.angle + np.append(0.0, turned)[np.searchsorted(knots, instants)]
            turn = np.diff(angles, prepend=self.angle)
        held = np.tile(np.array(self.support.held), (count, 1))
        held[changed, :3] += change.offset
        self.speed, self.angle = float(speed[-1]), float(angles[-1])
        free = np.array(self.support.free, np.int64)
        return Course(steps, turn, speed, held, free, np.where(free, self.loads, 0.0)), angles

    def _outputs(self, course: Course, angle) -> Rows:
        """Outputs at the instants of a course; raises IntegrationError at the first without an equilibrium.

        Between two instants the balls orbit by the cage's share of the ring's turn at the first, and turn about
        themselves as at the second.
        """
        count, balls, first = len(angle), self.parameters.geometry.balls, np.zeros(1, np.int64)
        shapes = (), (), (5,), (5,), (balls, 2), (balls, 4), (balls, OF_CONTACTS)
        found = Instants(*(np.zeros((count, *shape)) for shape in shapes))
        before = float(angle[0] - course.turn[0])
        status = _run(
            *(self._seat, self._defects, before, balls, count, *course, self.stop, *self.state, *found, first)
        )
        instant = int(first[0])
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
        self.solved += count
        out = empty_outputs(self.parameters, count)
        out.numbers[:] = 0.0
        write_channels(self.setting, self.parameters.gravity, found, course.speed, angle, out)
        self._write_work(out, course, self._losses(out, found, course.speed))
        return out

    def _losses(self, out: Rows, found: Instants, speed: np.ndarray) -> np.ndarray:
        """Power [W] (T,) that lubricated contacts take; writes films, and the torque of the drive against them."""
        if not lubricated(self.parameters):
            return np.zeros(len(speed))
        losses = contact_losses(self.parameters, contacts_in(found.contacts), speed)
        power = losses.power.sum(axis=(1, 2, 3))
        out.film_thickness[:], out.film_ratio[:] = losses.thickness, losses.ratio
        out.drive_torque[:] = np.divide(power, speed, out=np.zeros_like(power), where=speed != 0.0)
        out.inner_ring_torque[:, 2] = -out.drive_torque
        return power

    def _refuse_illegal(self, found, course) -> None:
        """Raises IntegrationError at the first output whose contacts bear too much or leave the grooves."""
        contacts = contacts_in(found.contacts)
        bad = np.maximum(*limits_used(self.setting.ball_radius, contacts.load, contacts.approach, contacts.angle)) > 1.0
        if bad.any():
            row, ball = np.argwhere(bad)[0]
            seconds = self.elapsed + float(course.step[: row + 1].sum())
            sentence = f"at {seconds:.9g} s ball {ball} is squeezed too hard, or leaves the grooves; lower the load"
            raise IntegrationError(sentence, "too deep", seconds, f"ball {ball}")

    def _write_work(self, out: Rows, course: Course, power: np.ndarray) -> None:
        """Works: energy that balls gain, and losses of lubricated contacts, come through the inner ring.

        Losses are straight between outputs.
        """
        before = self._power if self._power is not None else power[0]
        lost = 0.5 * course.step * (power + np.append(before, power[:-1]))
        out.dissipated[:] = self._lost + lost.cumsum()
        self._lost, self._power = float(out.dissipated[-1]), float(power[-1])
        stored = out.kinetic_energy + out.elastic_energy + out.potential_energy
        if self._stored is None:
            self._stored = self._first_stored = stored[0]
        out.drive_work[:] = stored - self._first_stored + out.dissipated
        gross = (np.abs(np.diff(stored, prepend=self._stored)) + lost).cumsum()
        out.gross_work[:] = self._gross + gross
        self._gross, self._stored = float(out.gross_work[-1]), stored[-1]
