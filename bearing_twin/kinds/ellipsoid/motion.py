"""An ellipsoid on a plane as a run: made from its scene, moved on, and what it found."""

import math

import numpy as np

from bearing_twin.contact.damping import damping_for_restitution, steady_ratio
from bearing_twin.contact.elasticity import elasticity
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS, friction_number
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import Material
from bearing_twin.errors import IntegrationError, Stopped
from bearing_twin.kinds.ellipsoid.chunk import (
    BEGAN,
    CLOCK,
    DRIFT,
    IN_CONTACT,
    RECORD,
    RECORDED,
    STEP,
    TIME,
    advance,
)
from bearing_twin.kinds.ellipsoid.derived import (
    ellipsoid_mass,
    modulus_of,
    principal_inertia,
    shortest_contact,
    start_gap,
    start_orientation,
)
from bearing_twin.kinds.ellipsoid.doubt import FINEST, finer_tolerance, wanted_errors
from bearing_twin.kinds.ellipsoid.equations import COLUMNS, Ellipsoid, begin_shape, pose_of
from bearing_twin.kinds.ellipsoid.figures import WATCH, EllipsoidFigures
from bearing_twin.kinds.ellipsoid.outputs import channels, outputs_of
from bearing_twin.kinds.ellipsoid.parameters import EllipsoidOnPlaneScene
from bearing_twin.kinds.ellipsoid.steps import COUNTS, EVALUATIONS, REJECTIONS, STEPS, Plan, Work
from bearing_twin.kinds.second_run import WithSecondRun, is_watched
from bearing_twin.numerics.dop853 import DOP853
from bearing_twin.numerics.statuses import FULL, NOT_FINITE, OK, STALLED, STOPPED, TOO_DEEP
from bearing_twin.numerics.steppers import RK4
from bearing_twin.report import Choice
from bearing_twin.shapes.surfaces import ellipsoid_reach
from bearing_twin.stopping import SIGNALLED

FLOOR = 1e-4  # of the shortest contact
SETTING = 1e-3  # tolerance of a step over that of contacts
KEPT = ("state", "clock", "record", "counts")  # what a motion goes on from
RECORDS = 256  # completed in one call of the kernel


def ellipsoid_of(parameters: EllipsoidOnPlaneScene, law: str) -> Ellipsoid:
    """The numbers of the equations of motion for a scene with the elastic law `law`."""
    contact, gap = parameters.contact, start_gap(parameters)
    modulus = modulus_of(parameters)
    frozen = hertz_coefficient(gap.curvature_small, gap.curvature_large, modulus)
    compliances = [_compliance(one.material) for one in (parameters.body, parameters.plane)]
    steady = contact.restitution < 1.0 and contact.damping_law == "steady"
    chi = contact.damping
    if contact.restitution < 1.0 and not steady:
        chi = damping_for_restitution(contact.restitution, contact.restitution_speed)
    return Ellipsoid(
        semi_axes=tuple(float(axis) for axis in parameters.body.semi_axes),
        mass=ellipsoid_mass(parameters.body),
        inertia=principal_inertia(parameters.body),
        gravity=-float(parameters.gravity[2]),
        sink=compliances[0] / sum(compliances),
        law=elasticity(law, modulus, LAWS[law].number(contact, frozen)),
        damping=float(chi),
        relaxation_time=float(contact.relaxation_time),
        damping_ratio=steady_ratio(contact.restitution) if steady else 0.0,
        viscosity=float(contact.viscosity),
        friction=float(contact.friction_coefficient),
        regularisation=float(contact.friction_regularisation),
        rubbing=friction_number(contact.friction),
        over_spot=FRICTIONS[contact.friction].over_spot,
    )


def setting_of(parameters) -> float:
    """The tolerance of a step: errors of bounces add up, and grow where a body tumbles."""
    return max(SETTING * float(parameters.wanted.tolerance), FINEST)


def plan_of(parameters: EllipsoidOnPlaneScene, stepper: str) -> Plan:
    """How a scene is stepped."""
    axes, shortest = parameters.body.semi_axes, shortest_contact(parameters)
    low, high = float(min(axes)), float(max(axes))
    fixed = (parameters.solver.step or shortest / 64.0) if stepper == "rk4" else 0.0
    return Plan(
        method=RK4 if stepper == "rk4" else DOP853,
        tolerance=setting_of(parameters),
        fixed=float(fixed),
        spread=high * high / low - low * low / high,
        lean=(high * high - low * low) / (2.0 * low),
        floor=FLOOR * shortest,
    )


def motion(parameters: EllipsoidOnPlaneScene, choice: Choice):
    """The ellipsoid in motion, with a finer one beside it unless the scene wants none."""
    own = EllipsoidMotion(parameters, choice)
    if not is_watched(parameters):
        return own
    finer = EllipsoidMotion(parameters, choice._replace(stepper="dop853"))
    finer.plan = finer.plan._replace(tolerance=finer_tolerance(own.plan.tolerance))

    def figures():
        return EllipsoidFigures(parameters, choice)

    return WithSecondRun((own, finer), channels(parameters), figures, WATCH, wanted_errors, parameters)


class EllipsoidMotion:
    """The ellipsoid in motion: `advance` integrates one chunk and returns its outputs; `records` are its contacts."""

    def __init__(self, parameters: EllipsoidOnPlaneScene, choice: Choice):
        self.parameters, self.stop = parameters, SIGNALLED
        self.body, self.plan = ellipsoid_of(parameters, choice.law), plan_of(parameters, choice.stepper)
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
        self._ended: list[np.ndarray] = []  # contacts since records were taken
        self._touched = -math.inf  # begin [s] of the last touch recorded
        self._work = Work(np.zeros((len(self.plan.method.weights), COLUMNS)), *(np.zeros(COLUMNS) for _ in range(4)))
        self._now = 0.0

    def first_outputs(self):
        """The outputs at the present instant."""
        return outputs_of(self.body, self.state[None].copy(), float(self.clock[DRIFT]))

    def advance(self, times: np.ndarray, duration: float):
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError."""
        due, until = self._now + np.asarray(times, float), self._now + duration
        states, finished = np.empty((len(due), COLUMNS)), np.empty((RECORDS, RECORD))
        self.clock[-1] = 0.0
        status = FULL
        while status == FULL:
            status, count = advance(
                self.body, self.plan, self.state, self.clock, due, until, states, self.record, finished, self.counts,
                self._work, self.stop,
            )  # fmt: skip
            self._ended.extend(finished[:count].copy())
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {self.clock[TIME]:.9g} s")
        if status != OK:
            reasons = {
                NOT_FINITE: "the state is not finite any more; lower the speeds or shorten solver.step",
                TOO_DEEP: "the body is pressed in by half its shortest semi-axis; stiffen it or lower the fall",
                STALLED: "ever shorter steps are needed; loosen wanted.tolerance, or raise "
                "contact.friction_regularisation",
            }
            raise IntegrationError(f"at {self.clock[TIME]:.9g} s {reasons[status]}")
        self._now = until
        return outputs_of(self.body, states, float(self.clock[DRIFT]))

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        arrays = {name: getattr(self, name).tolist() for name in KEPT}
        fixed = {"fixed_step": self.plan.fixed} if self.plan.fixed else {}
        return arrays | fixed | {"touched": self._touched if math.isfinite(self._touched) else None, "now": self._now}

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; raises KeyError, TypeError or ValueError for one of another scene."""
        self.reset()
        for name in KEPT:
            array, given = getattr(self, name), np.array(kept[name], float)
            if given.shape != array.shape:
                raise ValueError(name)
            array[...] = given
        longest = self.plan.fixed if self.plan.fixed and self.clock[IN_CONTACT] else math.inf
        self.clock[STEP] = np.nanmin([self.clock[STEP], longest])  # plain data have no infinity
        if not np.isfinite(self.state).all():
            raise ValueError("state")
        self._touched = -math.inf if kept["touched"] is None else float(kept["touched"])
        self._now = float(kept["now"])

    def take_records(self) -> dict[str, np.ndarray]:
        """The touches and the ends of contacts since the last call."""
        began = [row[BEGAN] for row in self._ended] + ([self.record[BEGAN]] if self.clock[IN_CONTACT] else [])
        began = [time for time in began if time > self._touched]
        ended = np.array([row[list(RECORDED)] for row in self._ended]).reshape(-1, len(RECORDED))
        self._ended = []
        self._touched = max(began, default=self._touched)
        return {"touch": np.array(began).reshape(-1, 1), "contact": ended}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps and evaluations of the rates."""
        return {
            "steps": int(self.counts[STEPS]),
            "rejections": int(self.counts[REJECTIONS]),
            "evaluations": int(self.counts[EVALUATIONS]),
        }


def start_state(body: Ellipsoid, height: float, orientation, velocity, angular_velocity) -> np.ndarray:
    """The state (COLUMNS,) of an ellipsoid whose lowest point is `height` [m] above the plane; SI, fixed axes."""
    state = np.zeros(COLUMNS)
    state[3:7], state[7:10] = orientation, velocity
    pose = pose_of(body, state)
    turn = np.array([pose.x, pose.y, [-one for one in pose.down]])
    state[10:13] = turn @ (np.array(body.inertia) * (turn.T @ np.array(angular_velocity)))
    state[2] = height + ellipsoid_reach(body.semi_axes, pose.down)[0]
    begin_shape(body, state)
    return state


def _compliance(material: Material) -> float:
    return (1.0 - material.poisson_ratio**2) / material.young_modulus
