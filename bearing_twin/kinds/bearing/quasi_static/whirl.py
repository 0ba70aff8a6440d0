"""Whether a ring with mass stays in an equilibrium of settled balls, or whirls away from it.

Friction along the grooves answers a ring that moves aside by a force across, so that the derivative K of its loads by
its place is not symmetric, and small motions q of the ring,

    M q'' + (G + D) q' + K q = 0,

may grow: M its mass and inertia, G what its spin does to tilts, D what contacts damp. K is that of balls that have
settled wherever the ring is, by differences; D is the balance's stiffness by the relaxation time of the contacts.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.names import AUTO
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.controls import SETTLED
from bearing_twin.kinds.bearing.parameters import viscous_terms
from bearing_twin.kinds.bearing.quasi_static.in_motion import in_motion, scene_in_motion
from bearing_twin.kinds.bearing.quasi_static.settled import SLIDING
from bearing_twin.kinds.bearing.quasi_static.shares import control_of
from bearing_twin.kinds.bearing.quasi_static.statics import Support, solver_of, support_of
from bearing_twin.kinds.bearing.quasi_static.surroundings import TAKEN

STEPS = np.array([2e-8] * 3 + [2e-6] * 2)  # m and rad: of differences
GROWS = 1e-3  # of a motion's frequency: a rate that is less may be the error of all this


class Whirl(NamedTuple):
    """The motion of a ring that grows fastest: its rate [1/s] and its frequency [Hz]."""

    rate: float
    frequency: float

    @property
    def grows(self) -> bool:
        """Whether it takes the ring away."""
        return self.rate > GROWS * 2.0 * np.pi * self.frequency


def whirl_of(parameters, law: str) -> tuple[Whirl | None, int]:
    """How a ring leaves the equilibrium in which a scene begins; None where a coordinate that is free has no mass.

    Also None where axes do not settle, or balls slide on part of their way: nothing is known there. With it how often
    what acts on a ball was evaluated for it, beside what `scene_in_motion` took.
    """
    support, ring = support_of(parameters), parameters.rings.inner
    masses = np.array([ring.mass] * 3 + [ring.inertia[0]] * 2)
    free = np.array(support.free, np.bool_)
    if not free.any() or not masses[free].all():
        return None, 0
    taken, before = 0, TAKEN.evaluations
    try:
        begin, asked = scene_in_motion(parameters, law), control_of(parameters)
        # Friction takes the ring away even where it changes next to nothing, and axes left to themselves do not settle.
        parameters = replace(parameters, model=replace(parameters.model, control=SETTLED))
        if asked == AUTO and not begin.turn.why and not len(begin.turn.motion):
            begin = scene_in_motion(parameters, law)
            taken = begin.turn.taken
        before = TAKEN.evaluations
        if not 0 < len(begin.turn.motion) <= SLIDING:
            return None, taken
        solver = solver_of(parameters, law)
        stiffness = _stiffness(parameters, solver, begin, free)
    except SceneError:
        return None, taken + TAKEN.evaluations - before
    taken += TAKEN.evaluations - before
    spun = np.zeros((5, 5))
    spun[3, 4] = ring.inertia[1] * parameters.drive.speed
    spun[4, 3] = -spun[3, 4]
    damping = _relaxation(parameters, solver.setting.inner.law.power, begin.found) * begin.found.stiffness
    kept = np.ix_(free, free)
    count, inverse = int(free.sum()), 1.0 / masses[free][:, None]
    motion = np.zeros((2 * count, 2 * count))
    motion[:count, count:] = np.eye(count)
    motion[count:, :count] = -inverse * stiffness[kept]
    motion[count:, count:] = -inverse * (spun + damping)[kept]
    values = np.linalg.eigvals(motion)
    fastest = values[values.real.argmax()]
    return Whirl(float(fastest.real), float(abs(fastest.imag) / (2.0 * np.pi))), taken


def _stiffness(parameters, solver, begin, free: np.ndarray) -> np.ndarray:
    """The derivative (5, 5) of the loads that hold the ring by its free coordinates, balls settled everywhere."""
    slopes = np.zeros((5, 5))
    for column in np.flatnonzero(free):
        sides = []
        for step in (STEPS[column], -STEPS[column]):
            place = begin.found.coordinates.copy()
            place[column] += step
            held = Support((False,) * 5, (0.0,) * 5, tuple(place))
            found = in_motion(parameters, solver, held, begin.turn)
            if found.turn.why or not len(found.turn.motion):
                raise SceneError("no settled motion nearby")
            sides.append(found.found.loads)
        slopes[:, column] = (sides[0] - sides[1]) / (2.0 * STEPS[column])
    return slopes


def _relaxation(parameters, power: float, found) -> float:
    """What contacts damp over their stiffness [s], the mean by load of a law with this power of the approach."""
    by_load, by_stiffness = viscous_terms(parameters.contact)
    load, approach = found.contacts.load, np.maximum(found.contacts.approach, 0.0)
    return float(by_stiffness + by_load * np.average(approach, weights=load) / power)
