"""An ellipsoid on a plane as a run: made from its scene, moved on, and what it found."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.damping import damping_for_restitution, steady_ratio
from bearing_twin.contact.ellipse import ellipse, hertz_coefficient
from bearing_twin.contact.normal import CONSTANT, load_coefficient
from bearing_twin.contact.validity import gathered, law_doubt, pressure_doubt, wave_doubt, width_doubt
from bearing_twin.errors import IntegrationError
from bearing_twin.materials import Material
from bearing_twin.motion.steppers import DOP853, RK4
from bearing_twin.sample import Block, Found
from bearing_twin.scenes.ellipsoid_on_plane import COLUMNS, Ellipsoid, start_state
from bearing_twin.scenes.ellipsoid_outputs import outputs_of
from bearing_twin.scenes.ellipsoid_parameters import (
    DIFFERENTIAL,
    ELLIPSOID_LAWS,
    EllipsoidOnPlaneScene,
    ellipsoid_mass,
    modulus_of,
    principal_inertia,
    shortest_contact,
    start_gap,
    start_orientation,
    yield_strength,
)
from bearing_twin.scenes.ellipsoid_steps import (
    BEGAN,
    CLOCK,
    COUNTS,
    DRIFT,
    ENDED,
    EVALUATIONS,
    FULL,
    IMPULSE_X,
    IMPULSE_Y,
    IMPULSE_Z,
    IN_CONTACT,
    NOT_FINITE,
    OK,
    PEAK_APPROACH,
    PEAK_LARGE,
    PEAK_LOAD,
    PEAK_SMALL,
    RECORD,
    REJECTIONS,
    SPEED_IN,
    SPEED_OUT,
    STALLED,
    STEP,
    STEPS,
    TIME,
    TOO_DEEP,
    Plan,
    Work,
    advance,
)
from bearing_twin.scenes.impact import ENERGY_GAIN

FLOOR = 1e-4  # of the shortest contact
LISTED = 200  # contacts named one by one in a report
RECORDS = 256  # completed in one call of the kernel
NOTABLE = 0.01  # of the greatest load: lighter touches say nothing about waves in the body
GREATEST_DRIFT = 1e-6  # of a quaternion's norm in one step
ENERGIES = ("kinetic_energy", "potential_energy", "elastic_energy", "dissipated_viscous", "dissipated_friction")


def ellipsoid_of(parameters: EllipsoidOnPlaneScene, law: str) -> Ellipsoid:
    """The numbers of the equations of motion for a scene with the elastic law `law`."""
    contact, friction, gap = parameters.contact, parameters.friction, start_gap(parameters)
    modulus = modulus_of(parameters)
    compliances = [_compliance(one.material) for one in (parameters.body, parameters.plane)]
    steady = contact.restitution < 1.0 and contact.restitution_speed == 0.0
    chi = contact.damping
    if contact.restitution_speed > 0.0:
        chi = damping_for_restitution(contact.restitution, contact.restitution_speed)
    return Ellipsoid(
        semi_axes=tuple(float(axis) for axis in parameters.body.semi_axes),
        mass=ellipsoid_mass(parameters.body),
        inertia=principal_inertia(parameters.body),
        gravity=float(parameters.gravity),
        modulus=modulus,
        sink=compliances[0] / sum(compliances),
        law=ELLIPSOID_LAWS[law],
        constant=float(hertz_coefficient(gap.curvature_small, gap.curvature_large, modulus)),
        damping=float(chi),
        relaxation_time=float(contact.relaxation_time),
        damping_ratio=steady_ratio(contact.restitution) if steady else 0.0,
        viscosity=float(contact.viscosity),
        friction=float(friction.coefficient),
        regularisation=float(friction.regularisation),
        spot=friction.form == "spot",
    )


def plan_of(parameters: EllipsoidOnPlaneScene, stepper: str) -> Plan:
    """How a scene is stepped."""
    axes, shortest = parameters.body.semi_axes, shortest_contact(parameters)
    low, high = float(min(axes)), float(max(axes))
    fixed = (parameters.solver.step or shortest / 64.0) if stepper == "rk4" else 0.0
    return Plan(
        method=RK4 if stepper == "rk4" else DOP853,
        tolerance=float(parameters.solver.tolerance),
        fixed=float(fixed),
        spread=high * high / low - low * low / high,
        lean=(high * high - low * low) / (2.0 * low),
        floor=FLOOR * shortest,
    )


class EllipsoidMotion:
    """The ellipsoid in motion: `advance` integrates one chunk and returns its outputs; `records` are its contacts."""

    goal_speed = 0.0  # takes no commands

    def __init__(self, parameters: EllipsoidOnPlaneScene, law: str, stepper: str):
        self.parameters, self.law = parameters, law
        self.body, self.plan = ellipsoid_of(parameters, law), plan_of(parameters, stepper)
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        start = self.parameters.start
        self.state = start_state(
            self.body, start.height, start_orientation(start), start.velocity, start.angular_velocity
        )
        self.clock = np.zeros(CLOCK)
        self.clock[STEP] = math.inf
        self.record = np.zeros(RECORD)
        self.counts = np.zeros(COUNTS, np.int64)
        self.records: list[np.ndarray] = []
        self._work = Work(np.zeros((len(self.plan.method.b), COLUMNS)), *(np.zeros(COLUMNS) for _ in range(4)))
        self._now = 0.0

    def first_outputs(self):
        """The outputs at the present instant."""
        return outputs_of(self.body, self.state[None].copy())

    def advance(self, times: np.ndarray, duration: float):
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError."""
        due, until = self._now + np.asarray(times, float), self._now + duration
        states, finished = np.empty((len(due), COLUMNS)), np.empty((RECORDS, RECORD))
        self.clock[-1] = 0.0
        status = FULL
        while status == FULL:
            status, count = advance(
                self.body, self.plan, self.state, self.clock, due, until, states, self.record, finished, self.counts,
                self._work,
            )  # fmt: skip
            self.records.extend(finished[:count].copy())
        if status != OK:
            reasons = {
                NOT_FINITE: "the state is not finite any more; lower the speeds or shorten solver.step",
                TOO_DEEP: "the body is pressed in by half its shortest semi-axis; use a stiffer material or a lower fall",
                STALLED: "ever shorter steps are needed; loosen solver.tolerance or raise friction.regularisation",
            }
            raise IntegrationError(f"at {self.clock[TIME]:.9g} s {reasons[status]}")
        self._now = until
        return outputs_of(self.body, states)

    def statistics(self) -> "Books":
        """Empty books of energy and momentum."""
        return Books()

    def found(self, statistics: "Books") -> Found:
        """What the run found up to the last output given out."""
        contacts = self._contacts(statistics.until)
        figures = {
            "peak_force_n": max((one.peak_load for one in contacts), default=0.0),
            "contact_count": len(contacts),
            "contact_duration_s": math.fsum(one.duration for one in contacts),
            "contacts": [self._row(one) for one in contacts[:LISTED]],
            "restitution": contacts[0].restitution if contacts else None,
            "resting_since_s": contacts[-1].start if contacts and contacts[-1].open else None,
            "greatest_approach_m": max((one.approach for one in contacts), default=0.0),
            "peak_pressure_pa": max((self._ellipse(one).peak_pressure for one in contacts), default=0.0),
            **statistics.figures(),
            "quaternion_drift": float(self.clock[DRIFT]),
        }
        wrong = not max(abs(statistics.closure), statistics.gain) <= ENERGY_GAIN
        status = "failed: energy" if wrong else "done"
        return Found(figures, tuple(self._flags(contacts)), status)

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps and evaluations of the rates."""
        return {
            "steps": int(self.counts[STEPS]),
            "rejections": int(self.counts[REJECTIONS]),
            "evaluations": int(self.counts[EVALUATIONS]),
        }

    def _contacts(self, until):
        rows = [*self.records, self.record] if self.clock[IN_CONTACT] else self.records
        return [_bounce(row, until) for row in rows if row[BEGAN] <= until]

    def _ellipse(self, bounce):
        return ellipse(bounce.small, bounce.large, self.body.modulus, bounce.peak_load)

    def _row(self, bounce):
        return {
            "start_s": bounce.start,
            "duration_s": bounce.duration,
            "peak_force_n": bounce.peak_load,
            "impulse_ns": bounce.impulse,
            "friction_impulse_ns": bounce.friction_impulse,
            "restitution": bounce.restitution,
        }

    def _flags(self, contacts):
        """What in the contacts lies outside the theory, one sentence each."""
        loaded = [one for one in contacts if one.peak_load > 0.0]
        if not loaded:
            return []
        body, material = self.parameters.body, self.parameters.body.material
        hardest = max(loaded, key=lambda one: self._ellipse(one).peak_pressure)
        deepest = max(loaded, key=lambda one: one.approach)
        worst = max(loaded, key=lambda one: abs(self._law_error(one)))
        wide, spot = self._ellipse(deepest), self._ellipse(worst)
        heavy = NOTABLE * max(one.peak_load for one in loaded)
        shortest = min((one.duration for one in loaded if not one.open and one.peak_load > heavy), default=math.inf)
        flags = gathered(
            pressure_doubt(self._ellipse(hardest).peak_pressure, yield_strength(self.parameters.contact)),
            width_doubt(wide.semi_major, 0.5 / deepest.small),
            width_doubt(wide.semi_minor, 0.5 / deepest.large),
            law_doubt(self.law, self._law_error(worst), spot.semi_minor / spot.semi_major),
            wave_doubt(shortest, 2.0 * max(body.semi_axes), material.young_modulus, material.density),
        )
        if self.clock[DRIFT] > GREATEST_DRIFT:
            flags.append(
                f"the quaternion's norm drifted by {self.clock[DRIFT]:.2g} in one step before it was put right: "
                "tighten solver.tolerance"
            )
        return flags

    def _law_error(self, bounce):
        exact = hertz_coefficient(bounce.small, bounce.large, self.body.modulus)
        if self.body.law >= DIFFERENTIAL:  # what the carried states gave at the peak; a viscous part is not an error
            return 0.0
        constant = self.body.constant if self.body.law == CONSTANT else 0.0
        return load_coefficient(self.body.law, bounce.small, bounce.large, self.body.modulus, constant) / exact - 1.0


class Bounce(NamedTuple):
    """One contact: seconds, N, m, N s; `restitution` None where it has not ended by the last output."""

    start: float
    duration: float
    open: bool
    peak_load: float
    approach: float
    small: float
    large: float
    impulse: float | None
    friction_impulse: float | None
    restitution: float | None


def _bounce(row, until):
    ended = row[ENDED] <= until  # False for NaN too
    into, out = float(row[SPEED_IN]), float(row[SPEED_OUT])
    return Bounce(
        float(row[BEGAN]),
        float((row[ENDED] if ended else until) - row[BEGAN]),
        not ended,
        float(row[PEAK_LOAD]),
        float(row[PEAK_APPROACH]),
        float(row[PEAK_SMALL]),
        float(row[PEAK_LARGE]),
        float(row[IMPULSE_Z]) if ended else None,
        math.hypot(row[IMPULSE_X], row[IMPULSE_Y]) if ended else None,
        out / into if ended and into > 0.0 else None,
    )


def _compliance(material: Material) -> float:
    return (1.0 - material.poisson_ratio**2) / material.young_modulus


class Books:
    """Energy and momentum of the outputs given out."""

    def __init__(self):
        self.until, self.first, self.last, self.gain, self.scale = 0.0, {}, {}, 0.0, 0.0

    def add(self, block: Block) -> None:
        """Takes a block in."""
        stored = sum(block.values[name] for name in ENERGIES[:3])
        total = stored + sum(block.values[name] for name in ENERGIES[3:])
        if not self.first:
            self.first = self._instant(block, stored, total, 0)
        self.last = self._instant(block, stored, total, -1)
        self.scale = max(self.scale, float(stored.max()))
        if self.scale > 0.0:
            self.gain = max(self.gain, float(total.max() - self.first["total"]) / self.scale)
        self.until = 1e-9 * float(block.time_ns[-1])

    @staticmethod
    def _instant(block, stored, total, row):
        kept = {name: block.values[name][row] + 0.0 for name in ("velocity", "angular_momentum")}
        lost = {name: float(block.values[name][row]) for name in ENERGIES[3:]}
        return {"stored": float(stored[row]), "total": float(total[row]), **lost, **kept}

    def figures(self) -> dict:
        """Balances by SI-suffixed keys; velocities and angular momentum as changes since the first output."""
        velocity, turning = (self.last[name] - self.first[name] for name in ("velocity", "angular_momentum"))
        return {
            "energy_closure": self.closure,
            "greatest_energy_gain": self.gain,
            "energy_start_j": self.first["stored"],
            "energy_end_j": self.last["stored"],
            "dissipated_viscous_j": self.last["dissipated_viscous"],
            "dissipated_friction_j": self.last["dissipated_friction"],
            "velocity_change_x_m_s": float(velocity[0]),
            "velocity_change_y_m_s": float(velocity[1]),
            "angular_momentum_change_vertical_nms": float(turning[2]),
        }

    @property
    def closure(self) -> float:
        """Energy gained by the numbers, as a share of the greatest energy stored."""
        return (self.last["total"] - self.first["total"]) / self.scale if self.scale > 0.0 else 0.0
