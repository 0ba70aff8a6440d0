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
from bearing_twin.kinds.bearing.quasi_static.friction_across import without_shares
from bearing_twin.kinds.bearing.quasi_static.response import Response
from bearing_twin.kinds.bearing.quasi_static.shares import CONTROLS
from bearing_twin.kinds.bearing.quasi_static.statics import Equilibrium, EquilibriumSolver, Support


def response_to_axes(parameters, solver: EquilibriumSolver, support: Support) -> Response | None:
    """The changes of an equilibrium once the balls' axes have settled; None where then nothing carries the load."""
    try:
        rolling = solver.solve(support)
        settled = _settled_solver(parameters, solver, rolling.contacts).solve(support)
    except SceneError:
        return None
    return Response(*(after - before for after, before in zip(_answers(settled), _answers(rolling), strict=True)))


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
