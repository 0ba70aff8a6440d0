"""How far equilibria are off balls that move by themselves, as far as that is known before a run."""

import functools
from typing import NamedTuple

from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import Contacts
from bearing_twin.kinds.bearing.quasi_static.equilibrium import scene_equilibrium

EQUILIBRIA = (  # what is known of a run from them
    "equilibria are solved to rounding; the error of loads is what balls that move differ by; friction is none"
)


class Still(NamedTuple):
    """Balls in equilibrium: the centrifugal load over that on the inner raceway, and the relative error of loads."""

    share: float
    error: float


def still_error(share: float) -> float:
    """Relative error of equilibria in load, the centrifugal load being this share of that on the inner raceway.

    A bound on what `bearing_twin chart dimensions` measures of a 6203 up to a share of 1.4.
    """
    return max(1e-4, 0.04 * share * share)


def centrifugal_share(contacts: Contacts, least: float = 1e-3) -> float:
    """The greatest centrifugal load over the load on the inner raceway; 0 where no ball carries.

    Of the balls that carry more than `least` of the greatest load: one at the end of the load zone has any share.
    """
    load = contacts.load[:, 0]
    carry = load > least * load.max()
    return float((contacts.centrifugal[carry] / load[carry]).max()) if carry.any() and load.max() > 0.0 else 0.0


def share_at_start(parameters, law: str, least: float = 1e-3) -> float:
    """`centrifugal_share` with the scene's own load, or the ring where its drive holds it; raises SceneError."""
    return centrifugal_share(scene_equilibrium(parameters, law).contacts, least)


@functools.lru_cache(4)
def still_at_start(parameters, law: str) -> Still:
    """`Still` with the scene's own load, or the ring where its drive holds it; raises SceneError."""
    share = share_at_start(parameters, law)
    return Still(share, still_error(share))
