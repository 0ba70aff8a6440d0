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
    OF_CONTACTS,
    STOP,
    STOPPED,
    CommandedBearing,
    azimuths_of,
    contacts_in,
    controlled_equilibrium,
    limit_ratios,
    solver_under_gravity,
    support_with_weight,
)
from bearing_twin.kinds.bearing.friction_torque import contact_losses
from bearing_twin.kinds.bearing.lubricant import is_lubricated
from bearing_twin.kinds.bearing.outputs import Rows, empty_outputs
from bearing_twin.kinds.bearing.parameters import BearingScene

SAME = 1e-9  # relative: nearer instants are equal
NEGLIGIBLE = 1e-12  # of the loads, or of their moments: smaller sums of forces are rounding
INNER = np.array([1.0, 0.0])  # of the contacts of a ball, inner and outer


class State(NamedTuple):
    """State between instants: azimuth of ball 0, orbit over ring speed (2,); ring, balls' attitudes."""

    cage: np.ndarray
    q: np.ndarray
    attitude: np.ndarray


class Instants(NamedTuple):
    """Equilibria at instants (T, ...): azimuth of ball 0, orbit, ring, load, balls' positions, attitudes, contacts."""

    azimuth: np.ndarray
    orbit: np.ndarray
    q: np.ndarray
    load: np.ndarray
    ball: np.ndarray
    attitude: np.ndarray
    contacts: np.ndarray


_run = Function(
    "core_equilibrium_run",
    INTEGER,
    (REALS, REALS, REAL, INTEGER, INTEGER, *(REALS,) * 4, INTEGERS, REALS, STOP, *(REALS_OUT,) * 10, INTEGERS_OUT),
)


def write_channels(setting, gravity, instants: Instants, speeds, angles, out: Rows) -> None:
    """Fill `out` from `instants`, the ring at `speeds` [rad/s] and `angles` [rad] (T,).

    Names and meanings are those of runs that integrate the motion of the balls. Sums of forces and moments that vanish
    are 0. Friction is that across the grooves, which gyroscopic moments need; slip is that of balls in one cage, which
    carries the forces along the orbit of the inner contacts of an eccentric ring. Works and losses stay 0.
    """
    contacts, balls = contacts_in(instants.contacts), instants.ball.shape[1]
    azimuth = instants.azimuth[:, None] + azimuths_of(balls, 0.0)
    cosine, sine, orbit = np.cos(azimuth), np.sin(azimuth), instants.orbit[:, None]

    def vectors(radial, tangential, axial) -> np.ndarray:
        """Vectors (T, N, ..., 3) in the bearing's axes: parts along a ball's radius, its orbit and the axis."""
        over = (..., None) if np.ndim(radial) > 2 else ...
        parts = cosine[over] * radial - sine[over] * tangential, sine[over] * radial + cosine[over] * tangential, axial
        return np.stack(np.broadcast_arrays(*parts), axis=-1)

    distance = setting.outer.locus_radius + instants.ball[..., 0]
    position = vectors(distance, 0.0, instants.ball[..., 1])
    velocity, spin = vectors(0.0, distance * orbit, 0.0), vectors(contacts.pitch, 0.0, orbit - contacts.roll)
    # component along the orbit of the direction to the inner groove's centre
    x, y, _, tilt_x, tilt_y = (column[:, None] for column in instants.q.T)
    eccentric = 2.0 / setting.pitch_diameter * (y * cosine - x * sine)
    n_r, n_z = np.cos(contacts.angle), np.sin(contacts.angle)
    tilted = tilt_x * cosine + tilt_y * sine
    lean = -(n_r * eccentric[..., None] + n_z * tilted[..., None]) * INNER
    scale = (1.0 - 2.0 * INNER) / np.sqrt(1.0 + lean * lean)
    outward = vectors(scale * n_r, scale * lean, scale * n_z)  # from the ball to the raceway
    friction = vectors(-contacts.friction * n_z, 0.0, contacts.friction * n_r)
    force = friction - contacts.load[..., None] * outward
    arm = (setting.ball_radius - 0.5 * contacts.approach)[..., None] * outward
    point = position[:, :, None] + arm
    offset, turning = point - INNER[:, None] * instants.q[:, None, None, :3], speeds[:, None, None] * INNER
    raceway = np.stack([-turning * offset[..., 1], turning * offset[..., 0], np.zeros_like(contacts.load)], axis=-1)
    relative = velocity[:, :, None] + np.cross(spin[:, :, None], arm) - raceway
    on_ball, on_all = contacts.load.sum(axis=2)[..., None], contacts.load.sum(axis=(1, 2))[:, None]
    stored = contacts.load * np.maximum(contacts.approach, 0.0) / (setting.inner.law.power + 1.0)
    rotation = 0.4 * setting.ball_radius**2 * (spin**2).sum(-1)
    for name, values in {
        **{name: getattr(contacts, name) for name in ("approach", "curvature_small", "curvature_large")},
        "normal_load": contacts.load,
        "contact_angle": contacts.angle,
        "roll_rate": contacts.roll,
        "orbit_angle": azimuth,
        "position": position,
        "velocity": velocity,
        "angular_velocity": spin,
        "orientation": instants.attitude,
        "point": point,
        "normal": -outward,
        "friction_force": friction,
        "spin_rate": (spin[:, :, None] * outward).sum(-1) - turning * outward[..., 2],
        "slip": relative - (relative * outward).sum(-1)[..., None] * outward,
        "raceway_force": force.sum(2),
        "raceway_torque": np.cross(arm, force).sum(2),
        "outer_ring_force": -force[:, :, 1].sum(1),
        "outer_ring_torque": -np.cross(point, force)[:, :, 1].sum(1),
        "inner_ring_force": -instants.load[:, :3],
        "inner_ring_offset": instants.q[:, :3],
        "inner_ring_angle": angles,
        "inner_ring_speed": speeds,
        "inner_ring_tilt": instants.q[:, 3:],
        "cage_angle": instants.azimuth,
        "cage_speed": instants.orbit,
        "elastic_energy": stored.sum(axis=(1, 2)),
        "kinetic_energy": 0.5 * setting.ball_mass * ((velocity**2).sum(-1) + rotation).sum(1),
        "potential_energy": -setting.ball_mass * (position @ np.array(gravity)).sum(1),
    }.items():
        out[name][:] = values
    out.inner_ring_torque[:, :2] = -instants.load[:, 3:]
    if balls > 1:
        between = np.linalg.norm(np.roll(position, -1, axis=1) - position, axis=-1)
        out.neighbour_approach[:] = 2.0 * setting.ball_radius - between
    lever = 0.5 * setting.pitch_diameter
    for values, size in (
        (out.raceway_force, on_ball),
        (out.raceway_torque, setting.ball_radius * on_ball),
        (out.inner_ring_force, on_all),
        (out.outer_ring_force, on_all),
        (out.inner_ring_torque, lever * on_all),
        (out.outer_ring_torque, lever * on_all),
    ):
        values[np.abs(values) <= NEGLIGIBLE * size] = 0.0


class QuasiStaticMotion(CommandedBearing):
    """A bearing whose outputs are equilibria: no inertia but that of the orbits, no history but the cage's angle.

    `goal_speed` [rad/s] is approached at the drive's acceleration; `loads` [N, N m] (5,) act on the free coordinates.
    """

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters, self.law, self.stop = parameters, choice.law, SIGNALLED
        self.support = support_with_weight(parameters)
        azimuths = azimuths_of(parameters.geometry.balls, 0.0)
        solver = solver_under_gravity(parameters, choice.law, parameters.drive.speed, azimuths)
        self._start, self.setting = controlled_equilibrium(parameters, solver, self.support), solver.setting
        load = float(self._start.contacts.load.max())
        self._defects = defect_numbers(parameters, load) if parameters.defects else np.zeros(1)
        self._seat = self.setting.numbers(parameters.gravity)
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        balls = self.parameters.geometry.balls
        half, zero = -np.pi * np.arange(balls) / balls, np.zeros(balls)
        attitude = np.stack([zero, zero, np.sin(half), np.cos(half)], axis=1)
        self.state = State(np.zeros(2), self._start.coordinates.copy(), attitude)
        self.goal_speed = self.speed = float(self.parameters.drive.speed)
        self.loads, self.solved, self._changed = self.support.loads, 0, False
        self.angle = self.elapsed = self._gross = self._lost = 0.0
        self._stored = self._first_stored = self._power = None
        self._keep()

    def _keep(self) -> None:
        """Keep the attributes for `take_back`; none is changed in place."""
        self._before = {name: value for name, value in vars(self).items() if name != "_before"}

    def take_back(self) -> None:
        """Back to before the last `advance`."""
        vars(self).update(self._before)

    def set_load(self, force, moment) -> None:
        """Set the loads on the inner ring [N], [N m], checked by `check_load`; None for both: those of the scene."""
        loads = None if force is None else (*map(float, force), *map(float, moment))[:5]
        self.loads = support_with_weight(self.parameters, loads).loads

    def take_records(self) -> dict[str, np.ndarray]:
        """Empty: a bearing has no records beside its outputs."""
        return {}

    def costs(self) -> dict[str, int]:
        """Equilibria of the ring solved so far."""
        return {"equilibria": self.solved}

    def first_outputs(self) -> Rows:
        """The outputs at the present instant."""
        return self._outputs(np.zeros(1))

    def advance(self, times: np.ndarray, duration: float) -> Rows:
        """The outputs at `times` [s] from now, moved on by `duration` [s]; raises IntegrationError."""
        if self._stored is None:
            self.first_outputs()
        self._keep()
        instants = np.asarray(times, dtype=float)
        if not len(instants) or duration > instants[-1] * (1.0 + SAME):
            instants = np.append(instants, duration)
        out = self._outputs(instants)
        self.elapsed += duration
        return Rows(out.layout, out.numbers[: len(times)])

    def _drive(self, instants) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Speed, angle and held coordinates (T, 5) of the ring at `instants` [s] from now; moves the drive on."""
        drive, change = self.parameters.drive, self.parameters.drive.change
        due = change.time - self.elapsed if change.time > 0.0 and not self._changed else np.inf
        times, speeds = [0.0], [self.speed]  # between which the speed is linear

        def approach(goal: float, until: float) -> None:
            remaining = goal - speeds[-1]
            end = min(times[-1] + abs(remaining) / drive.acceleration, until)
            reached = end < until
            gained = np.sign(remaining) * drive.acceleration * (end - times[-1])
            speeds.append(goal if reached else speeds[-1] + gained)
            times.append(end)

        held = np.tile(np.array(self.support.held), (len(instants), 1))
        held[(instants >= due) | self._changed, :3] += change.offset
        approach(self.goal_speed, due)
        if due <= instants[-1]:
            self._changed, self.goal_speed = True, self.goal_speed + change.speed
            times.append(max(due, times[-1]))
            speeds.append(speeds[-1])
            approach(self.goal_speed, np.inf)
        speed = np.interp(instants, times, speeds)
        if min(speeds) == max(speeds):
            angle = self.angle + self.speed * instants
        else:
            knots = np.union1d(times, instants)
            linear = np.interp(knots, times, speeds)
            turned = np.cumsum(0.5 * (linear[1:] + linear[:-1]) * np.diff(knots))
            angle = self.angle + np.append(0.0, turned)[np.searchsorted(knots, instants)]
        return speed, angle, held

    def _outputs(self, instants) -> Rows:
        """Outputs at `instants` [s] from now; raises IntegrationError at the first without a legal equilibrium.

        Between two instants the balls orbit by the cage's share of the ring's turn at the first, and turn about
        their own axes as at the second.
        """
        speed, angle, held = self._drive(instants)
        count, balls, failed = len(instants), self.parameters.geometry.balls, np.zeros(1, np.int64)
        shapes = (), (), (5,), (5,), (balls, 2), (balls, 4), (balls, OF_CONTACTS)
        solved, step = Instants(*(np.zeros((count, *shape)) for shape in shapes)), np.diff(instants, prepend=0.0)
        free, state = np.array(self.support.free, np.int64), State(*(array.copy() for array in self.state))
        status = _run(
            *(self._seat, self._defects, self.angle, balls, count, step, np.diff(angle, prepend=self.angle), speed),
            *(held, free, np.where(free, self.loads, 0.0), self.stop, *state, *solved, failed),
        )
        seconds = self.elapsed + float(instants[int(failed[0]) : int(failed[0]) + 1].sum())
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
        contacts = contacts_in(solved.contacts)
        ratios = limit_ratios(self.setting.ball_radius, contacts.load, contacts.approach, contacts.angle)
        illegal = np.maximum(*ratios) > 1.0
        if illegal.any():
            row, ball = np.argwhere(illegal)[0]
            seconds = self.elapsed + float(instants[row])
            sentence = f"at {seconds:.9g} s ball {ball} is squeezed too hard, or leaves the grooves; lower the load"
            raise IntegrationError(sentence, "too deep", seconds, f"ball {ball}")
        self.speed, self.angle, self.solved, self.state = float(speed[-1]), float(angle[-1]), self.solved + count, state
        out = empty_outputs(self.parameters, count)
        out.numbers[:] = 0.0
        write_channels(self.setting, self.parameters.gravity, solved, speed, angle, out)
        power = np.zeros(count)
        if is_lubricated(self.parameters):
            losses = contact_losses(self.parameters, contacts, speed)
            power = losses.power.sum(axis=(1, 2, 3))
            out.film_thickness[:], out.film_ratio[:] = losses.thickness, losses.ratio
            out.drive_torque[:] = np.divide(power, speed, out=np.zeros_like(power), where=speed != 0.0)
            out.inner_ring_torque[:, 2] = -out.drive_torque
        self._write_work(out, step, power)
        return out

    def _write_work(self, out: Rows, step: np.ndarray, power: np.ndarray) -> None:
        """Works: energy that balls gain, and losses of lubricated contacts, which are linear between outputs."""
        before = self._power if self._power is not None else power[0]
        lost = 0.5 * step * (power + np.append(before, power[:-1]))
        out.dissipated[:] = self._lost + lost.cumsum()
        self._lost, self._power = float(out.dissipated[-1]), float(power[-1])
        stored = out.kinetic_energy + out.elastic_energy + out.potential_energy
        if self._stored is None:
            self._stored = self._first_stored = stored[0]
        out.drive_work[:] = stored - self._first_stored + out.dissipated
        gross = (np.abs(np.diff(stored, prepend=self._stored)) + lost).cumsum()
        out.gross_work[:] = self._gross + gross
        self._gross, self._stored = float(out.gross_work[-1]), stored[-1]
