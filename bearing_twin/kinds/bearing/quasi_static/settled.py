"""A ball whose axis of spin has settled: its motion repeats itself after every turn of a cage that all balls share.

Friction at a point does not resist drilling, so that an axis of spin goes on turning long after all else has come to
rest, until the moments on the ball are 0 over a turn: under thrust it is then parallel to the bearing's, with a load
across or a tilt somewhere between. Looked for is that motion itself, of the place p (radial, axial) and the spin w
(radial, along, axial) over the azimuth, with one orbit speed O, at azimuths between which both are sums of waves:

    m p'' = forces + m r O^2 e_r,   J (w' + O e_z x w) = moments,   0 = the mean moment along the orbit,

' = O d/d(azimuth). Contacts are as they are of balls that move (`forces.equations`): at the groove's true angle, with
viscous terms, and with friction along what slips. Newton's method finds the motion from that of rolling, first with
what the axis does in one turn alone, then over ever longer times.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.names import POINT
from bearing_twin.kinds.bearing.parameters import rubbing_by
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts, shared
from bearing_twin.kinds.bearing.quasi_static.friction_across import BEARS, balanced_on_the_way
from bearing_twin.kinds.bearing.quasi_static.statics import azimuths_of
from bearing_twin.kinds.bearing.quasi_static.surroundings import UNKNOWNS, Surroundings
from bearing_twin.kinds.bearing.quasi_static.turn_search import Search

# Azimuths of a turn, the more the sharper what happens on it; odd, so that no wave is lost. Where balls slide on part
# of their way the last two are needed, at which a motion is looked for from one at fewer alone: they cost a second.
COUNTS = (17, 33, 65, 129, 257)
SLIDING = 65
FINE = 1e-5  # of the greatest angle: what the shortest waves may be before more azimuths are taken
# Relative: what is off against balls that move, measured up to 3.4e-4. Where they slide on part of their way it is up
# to 2.5e-2, where the cage's speed varies as they pass, which one orbit speed leaves out.
OFF, OFF_SLIDING = 5e-4, 3e-2
NO_GRAVITY = (0.0, 0.0, 0.0)
COARSE = 1e-3  # and at the most azimuths
EVEN = 1e-9  # of the ball's radius: a ring that is less off the axis, or tilted, loads all balls alike


class Turn(NamedTuple):
    """What repeats itself: places [m] and spins [rad/s] (M, UNKNOWNS) at even azimuths, the `orbit` speed [rad/s].

    `why` says why there is none, "" where there is.
    """

    motion: np.ndarray
    orbit: float
    why: str = ""

    def at(self, azimuths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Motion and its derivative by the azimuth (K, UNKNOWNS) at these azimuths [rad] (K,)."""
        waves = np.fft.rfft(self.motion, axis=0) / len(self.motion)
        waves[1:] *= 2.0
        order = np.arange(len(waves))
        there = np.exp(1j * np.outer(azimuths, order))
        return (there @ waves).real, (there @ (1j * order[:, None] * waves)).real

    def whole(self, azimuths: np.ndarray) -> np.ndarray:
        """Places, their rates [m/s] and spins (K, 7) at these azimuths [rad] (K,)."""
        motion, changes = self.at(azimuths)
        return np.concatenate([motion[:, :2], self.orbit * changes[:, :2], motion[:, 2:]], axis=1)

    def quicker(self, times: float) -> "Turn":
        """As if the ring turned so many times as fast."""
        motion = self.motion.copy()
        motion[:, 2:] *= times
        return Turn(motion, self.orbit * times)

    def curve(self, azimuths: np.ndarray) -> np.ndarray:
        """The second derivative of the place by the azimuth (K, 2)."""
        waves = 2.0 * np.fft.rfft(self.motion[:, :2], axis=0) / len(self.motion)
        order = np.arange(len(waves))
        return (np.exp(1j * np.outer(azimuths, order)) @ (-(order[:, None] ** 2) * waves)).real


def no_turn(why: str) -> Turn:
    """That there is none, and why."""
    return Turn(np.zeros((0, UNKNOWNS)), math.nan, why)


def off_by(turn: Turn) -> float:
    """What loads and angles of equilibria in this motion are off, over the greatest: more where balls slide."""
    return OFF if len(turn.motion) < SLIDING else OFF_SLIDING


def settled_turn(parameters, setting, coordinates, near: Turn | None = None, gravity=NO_GRAVITY) -> Turn:
    """The motion of balls whose axes have settled, the ring at `coordinates` (5,), or why there is none.

    It is looked for from `near` first, one that was found with the ring nearby. The balls have no weight but where
    `gravity` [m/s^2] is given.
    """
    contact = rubbing_by(parameters, POINT).contact
    if setting.speed == 0.0:
        return no_turn("the ring stands still")
    if contact.friction_coefficient == 0.0:
        return no_turn("without friction they never settle")
    if FRICTIONS[contact.friction].over_spot:
        return no_turn("friction over spots resists drilling")
    place, contacts = balanced_on_the_way(setting, coordinates, azimuths_of(COUNTS[-1], 0.0))
    least = BEARS * contacts.load.max()
    if not contacts.load.min() > least:
        return no_turn("a ball bears next to nothing on part of its way")
    counts = (1,) if _even(setting, coordinates) and not any(gravity[:2]) else COUNTS
    sharp_near = near is not None and len(near.motion) > SLIDING
    if sharp_near:
        counts = counts[counts.index(len(near.motion)) :]
    turn, sharp = near, math.inf
    for count in counts:
        search = Search(parameters, setting, coordinates, count, float(contacts.load.max()), gravity)
        found = None if turn is None else search.again(_unknowns(turn, count))
        if found is None and count > SLIDING:
            break
        if found is None:
            found = _first(search, place, contacts)
        if found is None:  # what is sharp needs more azimuths
            continue
        turn = Turn(found[:-1].reshape(count, UNKNOWNS), float(found[-1]))
        sharp = _sharpness(turn)
        if sharp <= FINE:
            break
    if sharp == math.inf and sharp_near:
        return settled_turn(parameters, setting, coordinates, None, gravity)
    if sharp == math.inf:
        return no_turn("no motion is found that repeats itself turn by turn")
    if not sharp <= COARSE:
        return no_turn("balls slide on part of their way")
    if not _least_load(parameters, setting, coordinates, turn) > least:
        return no_turn("a ball comes to bear next to nothing on part of its way")
    return turn


def _least_load(parameters, setting, coordinates, turn: Turn) -> float:
    """The least load [N] that a ball bears on its way in this motion."""
    azimuths = azimuths_of(len(turn.motion), 0.0)
    acting = Surroundings(parameters, setting, coordinates, azimuths)
    return float(acting.wrench(turn.whole(azimuths), turn.orbit).contacts.load.min())


def _even(setting, coordinates) -> bool:
    """Whether the ring stands so that all balls are loaded alike."""
    x, y, _, *tilt = coordinates
    return max(abs(x), abs(y), *(setting.arm * abs(one) for one in tilt)) <= EVEN * setting.ball_radius


def _unknowns(turn: Turn, count: int) -> np.ndarray:
    """The unknowns of a search at so many azimuths in this motion."""
    return np.append(turn.at(azimuths_of(count, 0.0))[0].ravel(), turn.orbit)


def _first(search: Search, place: np.ndarray, contacts: Contacts) -> np.ndarray | None:
    """The unknowns of a turn from rolling, or from an axis parallel to the bearing's, balls in balance being here."""
    motion = np.zeros((len(place), UNKNOWNS))
    motion[:, :2] = place[:, :2]
    orbit = float(shared(contacts, contacts.orbit))
    rolling = float(shared(contacts, contacts.pitch)), orbit - float(shared(contacts, contacts.roll))
    for motion[:, 2], motion[:, 4] in (rolling, (0.0, math.copysign(math.hypot(*rolling), rolling[1]))):
        found = search.found(_unknowns(Turn(motion, orbit), search.count))
        if found is not None:
            return found
    return None


def _sharpness(turn: Turn) -> float:
    """How large the two shortest waves of the place are, over the ball's distance from the groove's centre."""
    if len(turn.motion) == 1:
        return 0.0
    waves = np.abs(np.fft.rfft(turn.motion[:, :2], axis=0)) * 2.0 / len(turn.motion)
    return float(waves[-2:].max() / np.linalg.norm(turn.motion[:, :2], axis=1).min())
