"""Two bodies that bounce as the compiled core moves them (`core/bodies/two_bodies.cpp`).

Numbers in, motion, outputs and records of contacts back. An ellipsoid on a plane is such a pair.
"""

import copy
import math

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.sample import Channel, Columns, layout_of
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact.elasticity import elasticity, hertz_coefficient
from bearing_twin.contact.friction import patch_by
from bearing_twin.contact.laws import LAWS, damping_for_restitution, steady_ratio
from bearing_twin.contact.materials import compliance
from bearing_twin.core import FLAG, INTEGER, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bodies.derived import (
    bodies_at_start,
    longest_creep_step,
    mass_of,
    rigid_numbers,
    shortest_contact,
    size_of,
    start_curvatures,
    start_points,
    tracking_of,
)
from bearing_twin.kinds.bodies.parameters import OVERLAP, EllipsoidOnPlaneScene
from bearing_twin.kinds.error_estimates import TOLERANCE
from bearing_twin.methods import FULL, NOT_FINITE, OK, REASONS, STALLED, STOPPED, TOO_DEEP, UNTRACKED
from bearing_twin.shapes import quaternion_from_vector, rotation_matrix

SHORTEST_FLIGHT = 1e-4  # of the shortest contact: lift-offs and touches shorter than that are passed
RECORDS = 256  # completed in one call of the core
TIME, STEP, IN_CONTACT, DRIFT, WRITTEN, CONSTRAINT_ERROR = range(6)
"""Of the clock: seconds, the next step, whether in contact, greatest drift of a quaternion's norm, outputs written,
greatest distance [m] of the opposing points from meeting their equations at the end of a step."""
STATES, ENTRIES, RECORD = 46, 6, 20  # numbers of a state, of the clock and of the record of a contact
BEGAN = 1
FRICTION_IMPULSE = slice(13, 16)
"""Of ContactRecord: begin of the contact [s], impulse of friction (3,) [N s]."""
MOVING = ("state", "clock", "record", "counts", "_last", "_ended", "_touched", "_now")  # what `advance` changes
SNAPSHOT = ("state", "clock", "record", "counts", "_last")  # of a snapshot
COUNTED = ("steps", "rejections", "evaluations", "touches")
PROPORTIONAL, STEADY, STEADY_RATIO = range(3)  # DampingLaw of core/contact/laws.hpp
FINEST, COARSEST = 1e-12, 1e-10
"""The least tolerance of a step, and the greatest at which the tolerance, and not the contact's own time, sets it."""
FLAT = 1e-8
"""Both, of a superellipsoid: below it steps follow the errors of the overlap's sums, whose terms are not smooth."""
OF_ELLIPSOID = 1e-3  # tolerance of a step over that of contacts (`tests/test_impact_error.py`)
OF_PAIR, OF_SQUARE = 1e-2, 1e2
"""The same of two bodies, and over its square: where a load begins or ends, which no polynomial follows, errors go with
the root of a step's tolerance (`tests/test_impact_error.py`)."""
BODIES_AT, UNKNOWNS = (0, 19), slice(34, 42)  # of a state


FAILURES = {
    NOT_FINITE: "the state is not finite any more; lower the speeds, tighten wanted.tolerance or shorten solver.step",
    STALLED: "ever shorter steps are needed; loosen wanted.tolerance, or raise contact.friction_regularisation",
    TOO_DEEP: "the bodies are pressed into each other by half the least size; stiffen them or slow them down",
    UNTRACKED: "the opposing points are no contact of the chosen law: the surfaces are flat or conform there; "
    "use contact.normal: overlap, lower speeds, or other shapes",
}
OVERLAP_LOST = (
    "the overlap leaves the region around the opposing points, or they are lost: the surfaces conform, or the impact "
    "is too hard; use lower speeds, stiffer bodies, or other shapes"
)


def core_bodies(parameters, law: str) -> tuple[np.ndarray, np.ndarray]:
    """Both bodies as the core takes them, with the elastic law `law`: numbers, points of friction's quadrature."""
    contact, modulus, by_overlap, frozen = parameters.contact, parameters.modulus, law == OVERLAP, 0.0
    compliances = [compliance(body.material) for body in parameters.bodies]
    sink = compliances[0] / sum(compliances)  # the first body's share
    numbers = [number for body in bodies_at_start(parameters) for number in rigid_numbers(body)]
    numbers += [*parameters.gravity, sink, size_of(parameters), tracking_of(parameters), by_overlap]
    if not by_overlap and not LAWS[law].follows and not LAWS[law].measured:
        frozen = hertz_coefficient(*start_curvatures(parameters), modulus)
    number = 0.0 if by_overlap else LAWS[law].number(contact, frozen)
    patch, points = patch_by(contact.friction, float(contact.friction_coefficient))
    numbers += [*elasticity("hertz" if by_overlap else law, modulus, number), *_damping(contact)]
    return np.array([*numbers, float(contact.friction_regularisation), *patch], float), points


def _damping(contact) -> list[float]:
    """The numbers of the core's Damping, from the section `contact`."""
    if contact.restitution < 1.0 and contact.damping_law == "steady":
        return [STEADY_RATIO, steady_ratio(contact.restitution), 0.0]
    if contact.viscosity > 0.0:
        return [STEADY, contact.viscosity, 0.0]
    if contact.restitution < 1.0:
        damping = damping_for_restitution(contact.restitution, contact.restitution_speed)
        return [PROPORTIONAL, damping, contact.relaxation_time]
    return [PROPORTIONAL, contact.damping, contact.relaxation_time]


def setting_of(parameters, choice) -> float:
    """The tolerance of a step: errors of bounces add up, and grow where a body tumbles."""
    tolerance = float(parameters.wanted.tolerance)
    setting = choice.setting
    if math.isnan(setting):
        pair = min(OF_PAIR * tolerance, max(OF_SQUARE * tolerance**2, FINEST / TOLERANCE))
        setting = OF_ELLIPSOID * tolerance if isinstance(parameters, EllipsoidOnPlaneScene) else pair
    return max(setting, limits_of(parameters)[0])


def limits_of(parameters) -> tuple[float, float]:
    """The least tolerance of a step, and the greatest at which the tolerance sets it."""
    flat = any(body.shape == "superellipsoid" for body in parameters.bodies)
    return (FLAT, FLAT) if flat else (FINEST, COARSEST)


_MOVED = (*(REALS_OUT,) * 4, REAL, INTEGER, REALS, FLAG, REALS_OUT, INTEGER, REALS_OUT, INTEGERS_OUT, INTEGERS_OUT)
_advance = Function("core_two_bodies_advance", INTEGER, (REALS, REALS, REALS, *_MOVED))
_write = Function("core_two_bodies_outputs", None, (REALS, REALS, INTEGER, REALS, INTEGER, REALS_OUT))
"""Functions of the core that move bodies on until an instant [s], and write the channels of states.

Arguments of the first: bodies, plan, state, clock, record, state at the start of the last step, the instant; number
and times [s] of outputs, the flag that stops it, their states; room for records of contacts that have ended, their
number; counts. Of the second: bodies; number, states; width, rows.
"""


_ENERGIES = (
    Channel("elastic_energy", "J", (), "stored in the contact"),
    Channel("dissipated_viscous", "J", (), "by the viscous part of the normal load since the start"),
    Channel("dissipated_friction", "J", (), "by friction since the start"),
)

ELLIPSOID_CHANNELS = (
    Channel("position", "m", (3,), "of the centre, fixed axes, z up from the plane"),
    Channel("orientation", "1", (4,), "unit quaternion (x, y, z, w) from the body's axes to the fixed ones"),
    Channel("velocity", "m/s", (3,), "of the centre"),
    Channel("angular_velocity", "rad/s", (3,), "in fixed axes"),
    Channel("angular_momentum", "kg m^2/s", (3,), "about the centre, in fixed axes"),
    Channel("approach", "m", (), "of the lowest point to the plane; negative = gap"),
    Channel("normal_load", "N", (), "on the body, upward, at contact_point"),
    Channel("friction_force", "N", (3,), "on the body, at contact_point"),
    Channel("drilling_torque", "N m", (), "spin friction moment on the body about z; zero for friction at a point"),
    Channel("contact_point", "m", (3,), "where the forces act; below the body while there is a gap"),
    Channel("slip", "m/s", (3,), "velocity of the body there along the plane"),
    Channel("major_axis", "1", (3,), "direction of the longer axis of the contact ellipse"),
    Channel("semi_major", "m", (), "of the contact ellipse; zero without load"),
    Channel("semi_minor", "m", (), "of the contact ellipse; zero without load"),
    Channel("peak_pressure", "Pa", (), "at the middle of the contact ellipse"),
    Channel("in_contact", "1", (), "1 where the approach is above zero, else 0"),
    Channel("kinetic_energy", "J", (), "of the centre's motion and of the turning about it"),
    Channel("potential_energy", "J", (), "zero where the centre is as low as an undeformed body can be"),
    *_ENERGIES,
    Channel(
        "quaternion_drift", "1", (), "greatest drift of the quaternion's norm in a step so far, before it is undone"
    ),
)

PAIR_CHANNELS = (
    *(
        channel
        for prefix, which in (("", "first"), ("second_", "second"))
        for channel in (
            Channel(f"{prefix}position", "m", (3,), f"of the {which} body's centre, fixed axes"),
            Channel(f"{prefix}orientation", "1", (4,), f"unit quaternion (x, y, z, w) of the {which} body's axes"),
            Channel(f"{prefix}velocity", "m/s", (3,), f"of the {which} body's centre"),
            Channel(f"{prefix}angular_velocity", "rad/s", (3,), f"of the {which} body, in fixed axes"),
            Channel(
                f"{prefix}angular_momentum", "kg m^2/s", (3,), f"of the {which} body about its centre; 0 if held"
            ),
        )
    ),
    Channel("approach", "m", (), "of the opposing points; negative = gap"),
    Channel("normal_load", "N", (), "on the first body, against normal, at contact_point"),
    Channel("friction_force", "N", (3,), "on the first body, at contact_point"),
    Channel("drilling_torque", "N m", (), "spin friction moment on the first body about normal"),
    Channel("spin_rate", "rad/s", (), "first body minus second, about normal"),
    Channel("contact_point", "m", (3,), "where the forces act; between the bodies while there is a gap"),
    Channel("normal", "1", (3,), "outward of the first body at its opposing point"),
    Channel("slip", "m/s", (3,), "velocity of the first body against the second there, across the normal"),
    Channel("major_axis", "1", (3,), "direction of the longer axis of the contact"),
    Channel(
        "semi_major", "m", (), "of the contact ellipse; of an overlap its half-width over the root of 2, as of a circle"
    ),
    Channel("semi_minor", "m", (), "the same across; both are zero without load"),
    Channel("peak_pressure", "Pa", (), "by Hertz; of an overlap three times the load over its area, as of a circle"),
    Channel("curvature_small", "1/m", (), "of the gap, P in z = P x^2 + Q y^2; zero where it is flat"),
    Channel("curvature_large", "1/m", (), "of the gap, Q in z = P x^2 + Q y^2"),
    Channel("in_contact", "1", (), "1 where the approach is above zero, else 0"),
    Channel("kinetic_energy", "J", (), "of the free bodies, of their centres' motion and of the turning about them"),
    Channel("potential_energy", "J", (), "of the free bodies, zero with their centres at the origin"),
    *_ENERGIES,
    Channel("held_work", "J", (), "done on held bodies since the start"),
    Channel("gross_work", "J", (), "the same with each moment's work counted by its size"),
    Channel("quaternion_drift", "1", (), "greatest drift of a quaternion's norm in a step so far, before it is undone"),
    Channel(
        "tracking_error", "m", (), "most by which opposing points missed their equations at a step's end so far; "
        "differential: before their correction",
    ),
)  # fmt: skip


class PairMotion:
    """Two bodies in motion: `advance` integrates one chunk and returns its outputs; the records are their contacts."""

    channels = PAIR_CHANNELS
    last = DRIFT, CONSTRAINT_ERROR  # entries of the clock that are the last of the core's channels

    def __init__(self, parameters, choice, fixed: float = 0.0):
        self.parameters, self.stop, self.fixed = parameters, SIGNALLED, fixed
        self.failures = FAILURES | ({UNTRACKED: OVERLAP_LOST} if choice.law == OVERLAP else {})
        self.body, floor = core_bodies(parameters, choice.law), SHORTEST_FLIGHT * shortest_contact(parameters)
        self.plan = np.array([choice.stepper == "rk4", setting_of(parameters, choice), fixed, floor])
        self._layout = layout_of(PAIR_CHANNELS)
        self.reset()

    def start(self) -> np.ndarray:
        """The state at the start."""
        state = np.zeros(STATES)
        for first, body in zip(BODIES_AT, bodies_at_start(self.parameters), strict=True):
            turn = rotation_matrix(quaternion := quaternion_from_vector(body.turn))
            momentum = turn @ (rigid_numbers(body)[1:4] * (turn.T @ np.array(body.angular_velocity)))
            state[first : first + 13] = *body.position, *quaternion, *body.velocity, *momentum
        state[UNKNOWNS] = start_points(self.parameters)[2]
        return state

    def reset(self) -> None:
        """Back to the start."""
        self.state, self.clock = self.start(), np.zeros(ENTRIES)
        self.clock[STEP] = math.inf
        self.record, self.counts = np.zeros(RECORD), np.zeros(len(COUNTED), np.int64)
        self._ended: list[np.ndarray] = []  # contacts since records were taken
        self._touched = -math.inf  # begin [s] of the last touch recorded
        self._last = np.zeros_like(self.state)  # the state at the start of the last step
        self._now = 0.0
        self.keep()

    def keep(self) -> None:
        """Keeps what `take_back` needs."""
        self._saved = copy.deepcopy({name: getattr(self, name) for name in MOVING})

    def take_back(self) -> None:
        """Back to the last `keep`, as before the last `advance`."""
        vars(self).update(copy.deepcopy(self._saved))

    def outputs(self, states: np.ndarray) -> Columns:
        """All channels of states (n, states)."""
        rows = np.empty((len(states), self._layout.width))
        _write(*self.body, len(states), np.ascontiguousarray(states), self._layout.width, rows)
        rows[:, -len(self.last) :] = self.clock[list(self.last)]
        return Columns(self._layout, rows)

    def first_outputs(self):
        """The outputs at the present instant."""
        return self.outputs(self.state[None].copy())

    def advance(self, times: np.ndarray, duration: float):
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError."""
        self.keep()
        due, until = np.ascontiguousarray(self._now + np.asarray(times, float)), self._now + duration
        states, finished = np.empty((len(due), len(self.state))), np.empty((RECORDS, RECORD))
        status, completed = FULL, np.zeros(1, np.int64)
        self.clock[WRITTEN] = 0.0
        while status == FULL:
            status = _advance(
                *(*self.body, self.plan, self.state, self.clock, self.record, self._last, until),
                *(len(due), due, self.stop, states, RECORDS, finished, completed, self.counts),
            )
            self._ended.extend(finished[: completed[0]].copy())
        seconds = float(self.clock[TIME])
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {seconds:.9g} s")
        if status != OK:
            sentence = f"at {seconds:.9g} s {self.failures[status]}"
            raise IntegrationError(sentence, REASONS[status], seconds, *self.parameters.names)
        self._now = until
        return self.outputs(states)

    def take_records(self) -> dict[str, np.ndarray]:
        """Begins and ends of contacts since the last call."""
        rows = [*self._ended, self.record] if self.clock[IN_CONTACT] else self._ended
        began = [row[BEGAN] for row in rows if row[BEGAN] > self._touched]
        ended = self.contacts(np.array(self._ended).reshape(-1, RECORD))
        self._ended = []
        self._touched = max(began, default=self._touched)
        return {"touch": np.array(began).reshape(-1, 1), "contact": ended}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps, evaluations of the rates, and the number of contacts."""
        return dict(zip(COUNTED, self.counts.tolist(), strict=False))

    def contacts(self, records: np.ndarray) -> np.ndarray:
        """The rows of contacts that have ended; of the impulse of friction its magnitude."""
        size = np.linalg.norm(records[:, FRICTION_IMPULSE], axis=1)
        return np.column_stack([records[:, : FRICTION_IMPULSE.start], size, records[:, FRICTION_IMPULSE.stop]])

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        arrays = {name: getattr(self, name).tolist() for name in SNAPSHOT}
        return arrays | {"touched": self._touched if math.isfinite(self._touched) else None, "now": self._now}

    def resume(self, snapshot: dict) -> None:
        """To a state that `snapshot` gave; raises KeyError, TypeError or ValueError for one of another scene."""
        self.reset()
        for name in SNAPSHOT:
            array, values = getattr(self, name), np.array(snapshot[name], float)
            if values.shape != array.shape:
                raise ValueError(name)
            array[...] = values
        self.clock[STEP] = np.nanmin([self.clock[STEP], math.inf])  # plain data have no infinity
        self._touched = -math.inf if snapshot["touched"] is None else float(snapshot["touched"])
        self._now = float(snapshot["now"])
        if not (np.isfinite(self.state).all() and 0.0 <= self.clock[TIME] <= self._now):
            raise ValueError("state")


class EllipsoidMotion(PairMotion):
    """An ellipsoid on a plane in motion."""

    channels = ELLIPSOID_CHANNELS
    recorded = (0, 1, 2, 3, 4, 5, 6, 10, 11, 13, 14, 12, 16)
    """Columns of ContactRecord in `figures.BOUNCE`."""

    def __init__(self, parameters: EllipsoidOnPlaneScene, choice):
        fixed, self.layout = 0.0, layout_of(ELLIPSOID_CHANNELS)
        if choice.stepper == "rk4":  # its step in contact [s]
            fixed = parameters.solver.step
            fixed = fixed or min(shortest_contact(parameters) / 64.0, 0.5 * longest_creep_step(parameters))
        body, self._taken = parameters.body, [column for name in self.layout.fields for column in columns_of(name)]
        self._lowest = mass_of(body) * -parameters.gravity[2] * min(body.semi_axes)
        super().__init__(parameters, choice, fixed)

    def outputs(self, states: np.ndarray) -> Columns:
        """All channels of states (n, states): about the vertical, and with the potential energy of the fall."""
        columns = Columns(self.layout, np.take(super().outputs(states).numbers, self._taken, axis=1))
        columns["drilling_torque"][:] = 0.0 - columns["drilling_torque"]  # the pair's normal points down
        columns["potential_energy"][:] -= self._lowest
        return columns

    def contacts(self, records: np.ndarray) -> np.ndarray:
        return records[:, self.recorded]


def columns_of(name: str) -> range:
    """The columns of a channel of two bodies."""
    columns, _ = layout_of(PAIR_CHANNELS).fields[name]
    return range(columns.start, columns.stop)
