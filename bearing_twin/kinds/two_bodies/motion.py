"""Two bodies as a run: made from the scene, moved on, and what was found."""

import math

import numpy as np

from bearing_twin.contact.damping import damping_for_restitution, steady_ratio
from bearing_twin.contact.elasticity import elasticity
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS, friction_number
from bearing_twin.contact.laws import LAWS
from bearing_twin.errors import IntegrationError, Stopped
from bearing_twin.kinds.ellipsoid.doubt import FINEST, finer_tolerance, wanted_errors
from bearing_twin.kinds.second_run import SHORT, WithSecondRun, is_watched
from bearing_twin.kinds.two_bodies import march, steps
from bearing_twin.kinds.two_bodies.derived import (
    modulus_of,
    rigid_of,
    shortest_contact,
    size_of,
    start_contact,
    start_unknowns,
    tracking_of,
)
from bearing_twin.kinds.two_bodies.figures import WATCH, PairFigures
from bearing_twin.kinds.two_bodies.outputs import channels, outputs_of
from bearing_twin.kinds.two_bodies.pair import BODY, COLUMNS, QUATERNION, UNKNOWNS, VELOCITY, Pair
from bearing_twin.kinds.two_bodies.parameters import OVERLAP, TwoBodiesScene
from bearing_twin.numerics.rotation import quaternion_from_vector, rotation_matrix
from bearing_twin.numerics.statuses import FULL, NOT_FINITE, OK, STALLED, STOPPED, TOO_DEEP
from bearing_twin.report import Choice
from bearing_twin.stopping import SIGNALLED

FLOOR = 1e-4  # of the shortest contact
SETTING = 1e-2  # tolerance of a step over that of contacts
RECORDS = 256  # completed in one call of the kernel
FAILURES = {
    NOT_FINITE: "the state is not finite any more; lower the speeds or tighten wanted.tolerance",
    TOO_DEEP: "the bodies are pressed into each other by a third of the least size; stiffen them or slow them down",
    STALLED: "ever shorter steps are needed; loosen wanted.tolerance, or raise contact.friction_regularisation",
    march.UNTRACKED: "the opposing points are no contact of the chosen law: the surfaces are flat or conform there; "
    "use contact.normal: overlap, lighter blows, or other shapes",
}
LEFT = (
    "the overlap leaves the region around the opposing points, or they are lost: the surfaces conform, or the blow "
    "is too hard; use lighter blows, stiffer bodies, or other shapes"
)


def pair_of(parameters: TwoBodiesScene, law: str) -> Pair:
    """The numbers of the equations of motion for a scene with the elastic law `law`."""
    contact, modulus = parameters.contact, modulus_of(parameters)
    frozen, over = 0.0, law == OVERLAP
    if not over and not LAWS[law].follows and not LAWS[law].measured:
        start = start_contact(parameters)
        frozen = hertz_coefficient(start.curvature_small, start.curvature_large, modulus)
    given = 0.0 if over else LAWS[law].number(contact, frozen)
    one, other = parameters.first.material, parameters.second.material
    compliance = [(1.0 - material.poisson_ratio**2) / material.young_modulus for material in (one, other)]
    steady = contact.restitution < 1.0 and contact.damping_law == "steady"
    chi = contact.damping
    if contact.restitution < 1.0 and not steady:
        chi = damping_for_restitution(contact.restitution, contact.restitution_speed)
    return Pair(
        a=rigid_of(parameters.first),
        b=rigid_of(parameters.second),
        gravity=tuple(float(part) for part in parameters.gravity),
        sink=compliance[0] / sum(compliance),
        size=float(size_of(parameters)),
        tracking=tracking_of(parameters),
        over_lens=over,
        law=elasticity("hertz" if over else law, modulus, given),
        damping=float(chi),
        relaxation_time=float(contact.relaxation_time),
        damping_ratio=steady_ratio(contact.restitution) if steady else 0.0,
        viscosity=float(contact.viscosity),
        friction=float(contact.friction_coefficient),
        regularisation=float(contact.friction_regularisation),
        rubbing=friction_number(contact.friction),
        over_spot=FRICTIONS[contact.friction].over_spot,
    )


def start_state(parameters: TwoBodiesScene, pair: Pair) -> np.ndarray:
    """The state (COLUMNS,) of both bodies at the start."""
    state = np.zeros(COLUMNS)
    for first, one, rigid in ((0, parameters.first, pair.a), (BODY, parameters.second, pair.b)):
        quaternion = quaternion_from_vector(one.turn)
        turn = rotation_matrix(quaternion)
        state[first : first + 3], state[first + QUATERNION : first + VELOCITY] = one.position, quaternion
        state[first + VELOCITY : first + VELOCITY + 3] = one.velocity
        momentum = turn @ (np.array(rigid.inertia) * (turn.T @ np.array(one.angular_velocity)))
        state[first + VELOCITY + 3 : first + BODY] = momentum
    state[UNKNOWNS : UNKNOWNS + 8] = start_unknowns(parameters)
    return state


def motion(parameters: TwoBodiesScene, choice: Choice):
    """Two bodies in motion, with a finer motion of them beside it unless the scene wants none."""
    own = TwoBodiesMotion(parameters, choice)
    if not is_watched(parameters):
        return own
    finer = TwoBodiesMotion(parameters, choice)
    finer.plan = finer.plan._replace(tolerance=finer_tolerance(own.plan.tolerance))

    def figures():
        return PairFigures(parameters, choice)

    short = 0 if own.pair.over_lens else SHORT
    return WithSecondRun((own, finer), channels(parameters), figures, WATCH, wanted_errors, parameters, short)


class TwoBodiesMotion:
    """Two bodies in motion: `advance` integrates one chunk and returns its outputs; the records are their contacts."""

    def __init__(self, parameters: TwoBodiesScene, choice: Choice):
        self.pair, self.stop = pair_of(parameters, choice.law), SIGNALLED
        setting = max(SETTING * float(parameters.wanted.tolerance), FINEST)
        self.plan = steps.Plan(setting, FLOOR * shortest_contact(parameters))
        self._start = start_state(parameters, self.pair)
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        self.state, self.clock = self._start.copy(), np.zeros(march.CLOCK)
        self.clock[march.STEP] = math.inf
        self.record, self.counts = np.zeros(march.RECORD), np.zeros(march.COUNTS, np.int64)
        self._ended: list[np.ndarray] = []  # contacts since records were taken
        self._touched = -math.inf  # begin [s] of the last touch recorded
        stages = np.zeros((len(steps.METHOD.weights), COLUMNS))
        self._work = steps.Work(stages, *(np.zeros(COLUMNS) for _ in range(6)))
        self._now = 0.0
        touch = steps.touch_now(self.pair, self.state)
        if touch.approach > 0.0:
            march.note(self.pair, self.clock, 0.0, touch, touch, self.state, self.record)

    def _outputs(self, states):
        return outputs_of(self.pair, states, self.clock[march.DRIFT], self.clock[march.OFF])

    def first_outputs(self):
        """The outputs at the present instant."""
        return self._outputs(self.state[None].copy())

    def advance(self, times: np.ndarray, duration: float):
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError."""
        due, until = self._now + np.asarray(times, float), self._now + duration
        states, finished = np.empty((len(due), COLUMNS)), np.empty((RECORDS, march.RECORD))
        self.clock[march.CURSOR] = 0.0
        status = FULL
        try:
            while status == FULL:
                status, count = march.advance(
                    self.pair, self.plan, self.state, self.clock, due, until, states, self.record, finished,
                    self.counts, self._work, self.stop,
                )  # fmt: skip
                self._ended.extend(finished[:count].copy())
        except (np.linalg.LinAlgError, ZeroDivisionError):
            status = march.UNTRACKED
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {self.clock[march.TIME]:.9g} s")
        if status != OK:
            reason = LEFT if status == march.UNTRACKED and self.pair.over_lens else FAILURES[status]
            raise IntegrationError(f"at {self.clock[march.TIME]:.9g} s {reason}")
        self._now = until
        return self._outputs(states)

    def take_records(self) -> dict[str, np.ndarray]:
        """The touches and the ends of contacts since the last call."""
        going_on = [self.record[march.BEGAN]] if self.clock[march.IN_CONTACT] else []
        began = [time for time in [row[march.BEGAN] for row in self._ended] + going_on if time > self._touched]
        ended = [[*row[: march.RUB_X], np.linalg.norm(row[march.RUB_X : march.LOAD_BEFORE])] for row in self._ended]
        self._ended = []
        self._touched = max(began, default=self._touched)
        return {"touch": np.array(began).reshape(-1, 1), "contact": np.array(ended).reshape(-1, march.RUB_X + 1)}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps and evaluations of the rates."""
        return {
            "steps": int(self.counts[march.STEPS]),
            "rejections": int(self.counts[march.REJECTIONS]),
            "evaluations": int(self.counts[march.EVALUATIONS]),
        }
