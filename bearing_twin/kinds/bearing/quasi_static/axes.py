"""What equilibria are off by as a ball's axis of spin is another than in rolling.

Equilibria take the orbit speed of rolling and let both contacts carry the gyroscopic moment M_g in given shares. Balls
that move do otherwise, once their axes have settled:

* Friction at a point does not resist drilling. The axis turns until it is parallel to the bearing's, M_g is 0, and the
  contacts roll at w (1 - gamma cos alpha_i) cos alpha_o/(cos alpha_i + cos alpha_o), gamma = D/d_m.
* Friction over a spot resists it. The axis stays near that of rolling, but the outer contact carries up to all of M_g.

The first holds exactly where all balls are loaded alike; where angles are small both are next to nothing.
"""

import numpy as np

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.controls import OUTER, SHARED
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts
from bearing_twin.kinds.bearing.quasi_static.moving_balls import angle_errors
from bearing_twin.kinds.bearing.quasi_static.response import Response, followed, pushed_by
from bearing_twin.kinds.bearing.quasi_static.shares import CONTROLS
from bearing_twin.kinds.bearing.quasi_static.statics import Equilibrium, EquilibriumSolver, Support
from bearing_twin.kinds.bearing.quasi_static.turn_table import (
    ALONG,
    HOLDING,
    SIZES,
    add_ring_friction,
    without_shares,
)

LITTLE = 0.1  # of the tolerance wanted: what settled axes may change at most where those of rolling are taken


def response_to_axes(parameters, solver: EquilibriumSolver, support: Support) -> Response | None:
    """The changes of an equilibrium once the balls' axes have settled; None where then nothing carries the load."""
    try:
        rolling = solver.solve(support)
        settled = _settled_solver(parameters, solver, rolling.contacts).solve(support)
    except SceneError:
        return None
    return Response(*(after - before for after, before in zip(_answers(settled), _answers(rolling), strict=True)))


def response_to_slip(parameters, solver: EquilibriumSolver, support: Support, found: Equilibrium) -> Response:
    """What friction along the grooves changes in an equilibrium `found` with axes as in rolling, in first order.

    Balls in one cage share one orbit speed W, where each by itself would roll at W_j, as its angles are. Both raceways
    then push it along its way by F alike, as its moment about its axis of spin is 0: slips F/c_i + F/c_o make up
    d_m (W_j - W), c = mu Q/s. At W the cage is pushed by nothing.
    """
    setting, contacts, friction = solver.setting, found.contacts, parameters.contact
    load, least = contacts.load, contacts.load.min(axis=1)
    whole = load.sum(axis=1)
    each = np.divide(load.prod(axis=1), whole, out=np.zeros_like(whole), where=whole > 0.0)
    each *= friction.friction_coefficient / friction.friction_regularisation * setting.pitch_diameter
    orbit = np.average(contacts.orbit, weights=each) if each.any() else 0.0
    force = each * (contacts.orbit - orbit)
    limit = np.maximum(friction.friction_coefficient * least, np.finfo(float).tiny)
    force /= np.sqrt(1.0 + (force / limit) ** 2)
    rows = np.zeros((len(force), SIZES))
    rows[:, ALONG], rows[:, HOLDING] = force, setting.lever * np.sin(contacts.angle[:, 0]) * force
    loads = np.zeros(5)
    add_ring_friction(setting, solver.directions, rows, loads)
    moved, ring = followed(solver, support, found, loads)
    return Response(*pushed_by(solver, found, np.zeros_like(load)).contacts(moved), moved, ring)


def loads_by_lag(parameters, solver: EquilibriumSolver, found: Equilibrium) -> np.ndarray:
    """What loads (N, 2) [N] of an equilibrium `found` are off where contact angles lag, at most.

    A ball beside its balance by e d, its angle off by e, is further by e^2 d/2 from either groove's centre, whose
    distance is d. Angles are told that are greatest within half a spacing, whose mean square is e^2/3.
    """
    setting, contacts = solver.setting, found.contacts
    reach = sum(raceway.groove_radius - setting.ball_radius for raceway in (setting.inner, setting.outer)) / 2.0
    less = reach * angle_errors(parameters, solver, found, lag_alone=True).max(axis=1) ** 2 / 3.0
    approach = np.maximum(contacts.approach, 0.0).sum(axis=1)
    part = np.divide(less, approach, out=np.zeros_like(less), where=contacts.load.min(axis=1) > 0.0)
    power = max(setting.inner.law.power, setting.outer.law.power)
    return contacts.load * np.minimum(power * part, 1.0)[:, None]


def left_by_rolling(parameters, solver: EquilibriumSolver, support: Support, found: Equilibrium) -> Response | None:
    """The greatest changes of an equilibrium `found` with axes as in rolling by what it leaves out: sums of sizes.

    None where nothing carries the load once axes have settled.
    """
    axes = response_to_axes(parameters, solver, support)
    if axes is None:
        return None
    slip = response_to_slip(parameters, solver, support, found)
    whole = Response(*(np.abs(one) + np.abs(other) for one, other in zip(axes, slip, strict=True)))
    return whole._replace(loads=whole.loads + loads_by_lag(parameters, solver, found))


def settling_matters(parameters, solver: EquilibriumSolver, support: Support, found: Equilibrium) -> bool:
    """Whether what an equilibrium `found` with axes as in rolling leaves out is much against the wanted tolerance.

    Of loads, of angles, and of what holds the ring where it is held.
    """
    greatest = float(found.contacts.load.max())
    if solver.setting.speed == 0.0 or greatest <= 0.0:
        return False
    left, little = left_by_rolling(parameters, solver, support, found), LITTLE * parameters.wanted.tolerance
    if left is None or max(left.loads.max(), (left.ring_loads / solver.scales).max()) > little * greatest:
        return True
    steepest = float(np.abs(found.contacts.angle).max())
    return bool(left.angles.max() > little * steepest)


def _answers(found: Equilibrium) -> tuple[np.ndarray, ...]:
    return found.contacts.load, found.contacts.angle, found.coordinates, found.loads


def _settled_solver(parameters, solver: EquilibriumSolver, contacts: Contacts) -> EquilibriumSolver:
    """The balance of balls whose axes have settled; `contacts` are those in rolling."""
    setting, weights = solver.setting, solver.weights
    if FRICTIONS[parameters.contact.friction].over_spot:
        inner, outer = CONTROLS[OUTER if setting.share_inner else SHARED]
        return EquilibriumSolver(setting._replace(share_inner=inner, share_outer=outer), solver.azimuths, weights)
    weights = weights.copy()
    weights[:, 0] += contacts.centrifugal * (_quicker(setting, contacts) ** 2 - 1.0)
    return EquilibriumSolver(without_shares(setting), solver.azimuths, weights)  # there is no gyroscopic moment


def _quicker(setting, contacts: Contacts) -> np.ndarray:
    """Orbit speeds (N,) about axes parallel to the bearing's, over those of rolling; 1 where a ball bears nothing."""
    inner, outer = np.cos(contacts.angle.T)
    gamma = 2.0 * setting.ball_radius / setting.pitch_diameter
    rolling = contacts.orbit * (inner + outer)
    parallel = setting.speed * (1.0 - gamma * inner) * outer
    return np.divide(parallel, rolling, out=np.ones(len(inner)), where=(contacts.load[:, 0] > 0.0) & (rolling != 0.0))
