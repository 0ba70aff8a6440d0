"""How far balls in balance are off balls that move: what is known of equilibria before a run, and of their friction."""

import functools
import math
from typing import NamedTuple

from bearing_twin.kinds.bearing.quasi_static.axes import left_by_rolling
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts
from bearing_twin.kinds.bearing.quasi_static.in_motion import KEPT, scene_in_motion
from bearing_twin.kinds.bearing.quasi_static.shares import begins_settled
from bearing_twin.kinds.bearing.quasi_static.statics import solver_of, support_of
from bearing_twin.kinds.bearing.quasi_static.whirl import whirl_of

EQUILIBRIA = (  # what is known of a run from them
    "equilibria are solved to rounding; the error of loads is what balls that move differ by; their friction is known "
    "where axes of spin have settled alone"
)
# Of the speed at which a ring follows passing balls, over that at which friction is smoothed: what friction is off,
# over mu N, as a ring with mass vibrates when balls enter the loaded zone. Measured against rings of 50 g: 0.2 to 0.4.
VIBRATES = 0.4


class Still(NamedTuple):
    """Balls in balance: the centrifugal load over that on the inner raceway, and the relative error of loads.

    `settled` says whether their axes of spin have, `friction` is what friction is off then, over mu N, `whirls` how the
    ring leaves them, "" where it does not. `taken`: how often what acts on a ball was evaluated to know how balls move.
    """

    share: float
    error: float
    settled: bool = False
    friction: float = math.nan
    whirls: str = ""
    taken: int = 0


def still_error(share: float) -> float:
    """Relative error of equilibria in load, the centrifugal load being this share of that on the inner raceway.

    A bound on what `bearing_twin chart dimensions` measures of a 6203 up to a share of 1.4, before and after the axes
    of spin have settled. At larger contact angles they do more: see `still_at_start`.
    """
    return max(1e-4, 0.04 * share * share)


def centrifugal_share(contacts: Contacts) -> float:
    """The greatest centrifugal load over the load on the inner raceway, of the balls that carry; 0 where none does."""
    load = contacts.load[:, 0]
    carry = load > 1e-3 * load.max()
    return float((contacts.centrifugal[carry] / load[carry]).max()) if carry.any() and load.max() > 0.0 else 0.0


def share_at_start(parameters, law: str) -> float:
    """`centrifugal_share` with the scene's own load, or the ring where its drive holds it; raises SceneError."""
    return centrifugal_share(solver_of(parameters, law).solve(support_of(parameters)).contacts)


@functools.lru_cache(KEPT)
def still_at_start(parameters, law: str) -> Still:
    """`Still` with the scene's own load, or the ring where its drive holds it; raises SceneError."""
    apart, taken = 0.0, 0
    if begins_settled(parameters):
        found, _, turn = scene_in_motion(parameters, law)
        taken = turn.taken
        if not math.isnan(found.settled):
            rubs = max(found.settled, VIBRATES * turn.ring_speed / parameters.contact.friction_regularisation)
            still = Still(centrifugal_share(found.contacts), found.settled, True, rubs, taken=taken)
            return _watched(parameters, law, still)
        apart = found.apart
    solver, support = solver_of(parameters, law), support_of(parameters)
    found = solver.solve(support)
    left, share = left_by_rolling(parameters, solver, support, found), centrifugal_share(found.contacts)
    greatest = float(found.contacts.load.max())
    rolling = float(left.loads.max()) / greatest if left and greatest > 0.0 else 0.0
    return _watched(parameters, law, Still(share, max(still_error(share), rolling, apart), taken=taken))


def _watched(parameters, law: str, still: Still) -> Still:
    """The same, with what is known of a ring that leaves its equilibrium: then nothing is known of loads."""
    whirl, taken = whirl_of(parameters, law)
    still = still._replace(taken=still.taken + taken)
    if whirl is None or not whirl.grows:
        return still
    told = (
        f"with its mass the inner ring leaves the equilibrium, as friction along the grooves makes it whirl at "
        f"{whirl.frequency:.3g} Hz, by exp({whirl.rate:.2g} t) at first"
    )
    return still._replace(error=1.0, friction=1.0, whirls=told)


def friction_of_equilibria(parameters, law: str) -> float | None:
    """What friction of a run from equilibria is off by, over mu N: it is known where axes of spin have settled."""
    still = still_at_start(parameters, law)
    return still.friction if still.settled else None
