"""Two bodies as a run: made from the scene, moved on, and what was found."""

import math

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.contact.elasticity import elasticity
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bouncing import FINEST, FLOOR, BouncingMotion, CoreBodies, contact_numbers
from bearing_twin.kinds.error_estimates import TOLERANCE
from bearing_twin.kinds.two_bodies import compiled
from bearing_twin.kinds.two_bodies.compiled import BODY, COLUMNS, QUATERNION, UNKNOWNS, VELOCITY
from bearing_twin.kinds.two_bodies.derived import (
    modulus_of,
    rigid_of,
    shortest_contact,
    size_of,
    start_contact,
    start_unknowns,
    tracking_of,
)
from bearing_twin.kinds.two_bodies.outputs import outputs_of
from bearing_twin.kinds.two_bodies.parameters import FIRST, OVERLAP, SECOND, TwoBodiesScene
from bearing_twin.numerics.rotation import quaternion_from_vector, rotation_matrix
from bearing_twin.numerics.statuses import NOT_FINITE, STALLED, TOO_DEEP, UNTRACKED

# Tolerance of a step over that of contacts, and over its square: where a load begins or ends, which no polynomial
# follows, errors go with the root of a step's tolerance (`tests/test_impact_doubt.py`).
SETTING, OF_SQUARE = 1e-2, 1e2
FAILURES = {
    NOT_FINITE: "the state is not finite any more; lower the speeds or tighten wanted.tolerance",
    TOO_DEEP: "the bodies are pressed into each other by a third of the least size; stiffen them or slow them down",
    STALLED: "ever shorter steps are needed; loosen wanted.tolerance, or raise contact.friction_regularisation",
    UNTRACKED: "the opposing points are no contact of the chosen law: the surfaces are flat or conform there; "
    "use contact.normal: overlap, lighter blows, or other shapes",
}
FAILURES_OF_OVERLAP = FAILURES | {
    UNTRACKED: "the overlap leaves the region around the opposing points, or they are lost: the surfaces "
    "conform, or the blow is too hard; use lighter blows, stiffer bodies, or other shapes"
}


def pair_of(parameters: TwoBodiesScene, law: str) -> CoreBodies:
    """The numbers of the equations of motion for a scene with the elastic law `law`."""
    contact, modulus = parameters.contact, modulus_of(parameters)
    frozen, over = 0.0, law == OVERLAP
    if not over and not LAWS[law].follows and not LAWS[law].measured:
        start = start_contact(parameters)
        frozen = hertz_coefficient(start.curvature_small, start.curvature_large, modulus)
    given = 0.0 if over else LAWS[law].number(contact, frozen)
    return compiled.pair_numbers(
        rigid_of(parameters.first),
        rigid_of(parameters.second),
        gravity=parameters.gravity,
        size=size_of(parameters),
        tracking=tracking_of(parameters),
        by_overlap=over,
        law=elasticity("hertz" if over else law, modulus, given),
        contact=contact_numbers(contact, parameters.first.material, parameters.second.material),
        friction=contact.friction,
    )


def start_state(parameters: TwoBodiesScene) -> np.ndarray:
    """The state (COLUMNS,) of both bodies at the start."""
    state = np.zeros(COLUMNS)
    for first, one in ((0, parameters.first), (BODY, parameters.second)):
        quaternion = quaternion_from_vector(one.turn)
        turn = rotation_matrix(quaternion)
        state[first : first + 3], state[first + QUATERNION : first + VELOCITY] = one.position, quaternion
        state[first + VELOCITY : first + VELOCITY + 3] = one.velocity
        momentum = turn @ (np.array(rigid_of(one).inertia) * (turn.T @ np.array(one.angular_velocity)))
        state[first + VELOCITY + 3 : first + BODY] = momentum
    state[UNKNOWNS : UNKNOWNS + 8] = start_unknowns(parameters)
    return state


def setting_of(parameters: TwoBodiesScene, choice: Choice) -> float:
    """The tolerance of a step."""
    wanted = float(parameters.wanted.tolerance)
    chosen = min(SETTING * wanted, max(OF_SQUARE * wanted**2, FINEST / TOLERANCE))
    return max(chosen if math.isnan(choice.setting) else choice.setting, FINEST)


class TwoBodiesMotion(BouncingMotion):
    """Two bodies in motion: `advance` integrates one chunk and returns its outputs; the records are their contacts."""

    core, bodies = compiled, (FIRST, SECOND)

    def __init__(self, parameters: TwoBodiesScene, choice: Choice):
        pair = pair_of(parameters, choice.law)
        self._start = start_state(parameters)
        plan = np.array([setting_of(parameters, choice), FLOOR * shortest_contact(parameters)])
        super().__init__(pair, plan, FAILURES_OF_OVERLAP if choice.law == OVERLAP else FAILURES)

    def reset(self) -> None:
        """Back to the start, where they may touch already."""
        super().reset()
        compiled.open_record(self.body, self.plan, self.state, self.clock, self.record, self.counts)

    def start(self) -> np.ndarray:
        """The state (COLUMNS,) at the start."""
        return self._start.copy()

    def outputs(self, states: np.ndarray):
        """The outputs at states (n, COLUMNS)."""
        return outputs_of(self.body, states, self.clock[compiled.DRIFT], self.clock[compiled.OFF])

    def contacts(self, records: np.ndarray) -> np.ndarray:
        """The rows of contacts that have ended; of the impulse of friction its magnitude."""
        rubbed = [np.linalg.norm(row) for row in records[:, compiled.RUB_X : compiled.DEEPEST_APPROACH]]
        return np.column_stack([records[:, : compiled.RUB_X], rubbed, records[:, compiled.DEEPEST_APPROACH]])
