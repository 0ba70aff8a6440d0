"""The motion of an ellipsoid on a plane: made from its scene, integrated, with its records."""

import math

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.contact.elasticity import elasticity
from bearing_twin.contact.ellipse import hertz_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bouncing import FINEST, FLOOR, STEP, TIME, BouncingMotion, CoreBodies, contact_numbers
from bearing_twin.kinds.ellipsoid import compiled
from bearing_twin.kinds.ellipsoid.compiled import DRIFT, IN_CONTACT, RECORDED, start_state
from bearing_twin.kinds.ellipsoid.derived import (
    ellipsoid_mass,
    longest_creep_step,
    modulus_of,
    principal_inertia,
    shortest_contact,
    start_gap,
    start_orientation,
)
from bearing_twin.kinds.ellipsoid.outputs import outputs_of
from bearing_twin.kinds.ellipsoid.parameters import BODY, PLANE, EllipsoidOnPlaneScene
from bearing_twin.numerics.statuses import NOT_FINITE, STALLED, TOO_DEEP

SETTING = 1e-3  # tolerance of a step over that of contacts (`tests/test_impact_doubt.py`)
NEAR = 1e-6  # of the height of the centre: a gap within which a contact may still end
KEPT = ("state", "clock", "record", "counts")  # the state of a motion
FAILURES = {
    NOT_FINITE: "the state is not finite any more; lower the speeds or shorten solver.step",
    TOO_DEEP: "the body is pressed in by half its shortest semi-axis; stiffen it or lower the fall",
    STALLED: "ever shorter steps are needed; loosen wanted.tolerance, or raise contact.friction_regularisation",
}


def ellipsoid_of(parameters: EllipsoidOnPlaneScene, law: str) -> CoreBodies:
    """The numbers of the equations of motion for a scene with the elastic law `law`."""
    contact, gap, modulus = parameters.contact, start_gap(parameters), modulus_of(parameters)
    frozen = hertz_coefficient(gap.curvature_small, gap.curvature_large, modulus)
    return compiled.ellipsoid_numbers(
        parameters.body.semi_axes,
        ellipsoid_mass(parameters.body),
        principal_inertia(parameters.body),
        gravity=-float(parameters.gravity[2]),
        law=elasticity(law, modulus, LAWS[law].number(contact, frozen)),
        contact=contact_numbers(contact, parameters.body.material, parameters.plane.material),
        friction=contact.friction,
    )


def setting_of(parameters, choice: Choice) -> float:
    """The tolerance of a step: errors of bounces add up, and grow where a body tumbles."""
    chosen = SETTING * float(parameters.wanted.tolerance) if math.isnan(choice.setting) else choice.setting
    return max(chosen, FINEST)


def plan_of(parameters: EllipsoidOnPlaneScene, choice: Choice) -> np.ndarray:
    """The numbers of the integration of a scene, as the core reads them."""
    rk4, shortest, fixed = choice.stepper == "rk4", shortest_contact(parameters), 0.0
    if rk4:
        fixed = parameters.solver.step or min(shortest / 64.0, 0.5 * longest_creep_step(parameters))
    setting, axes = setting_of(parameters, choice), parameters.body.semi_axes
    return compiled.plan_numbers(rk4, setting, fixed, axes, FLOOR * shortest)


class EllipsoidMotion(BouncingMotion):
    """The ellipsoid in motion: `advance` integrates one chunk and returns its outputs; `records` are its contacts."""

    core, bodies = compiled, (BODY, PLANE)

    def __init__(self, parameters: EllipsoidOnPlaneScene, choice: Choice):
        self.parameters, plan = parameters, plan_of(parameters, choice)
        self.fixed = float(plan[compiled.FIXED])  # step of rk4 in contact [s]
        super().__init__(ellipsoid_of(parameters, choice.law), plan, FAILURES)

    def start(self) -> np.ndarray:
        """The state (COLUMNS,) at the start."""
        start = self.parameters.start
        return start_state(self.body, start.height, start_orientation(start), start.velocity, start.angular_velocity)

    def outputs(self, states: np.ndarray):
        """The outputs at states (n, COLUMNS)."""
        return outputs_of(self.body, states, float(self.clock[DRIFT]))

    def contacts(self, records: np.ndarray) -> np.ndarray:
        """The rows of contacts that have ended."""
        return records[:, RECORDED]

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        arrays = {name: getattr(self, name).tolist() for name in KEPT}
        fixed = {"fixed_step": self.fixed} if self.fixed else {}
        return arrays | fixed | {"touched": self._touched if math.isfinite(self._touched) else None, "now": self._now}

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; raises KeyError, TypeError or ValueError for one of another scene."""
        self.reset()
        for name in KEPT:
            array, given = getattr(self, name), np.array(kept[name], float)
            given = compiled.record_of(given) if name == "record" else given
            if given.shape != array.shape:
                raise ValueError(name)
            array[...] = given
        longest = self.fixed if self.fixed and self.clock[IN_CONTACT] else math.inf
        self.clock[STEP] = np.nanmin([self.clock[STEP], longest])  # plain data have no infinity
        if not np.isfinite(self.state).all():
            raise ValueError("state")
        self._touched = -math.inf if kept["touched"] is None else float(kept["touched"])
        self._now = float(kept["now"])
        reach = self.state[2] + float(self.first_outputs()["approach"][0])
        contact = self.clock[IN_CONTACT]
        # Of another time, or in a contact far from the plane, it would step for ever.
        inside = contact in (0.0, 1.0) and contact * (self.state[2] - reach) <= NEAR * reach
        if not (inside and 0.0 <= self.clock[TIME] <= self._now):
            raise ValueError("clock")
