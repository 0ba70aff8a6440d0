"""A ball whose axis of spin has settled: its motion repeats itself after every turn of a cage that all balls share.

Friction at a point does not resist drilling, so that an axis of spin goes on turning long after all else has come to
rest, until the moments on the ball are 0 over a turn: under thrust it is then parallel to the bearing's, with a load
across or a tilt somewhere between. Looked for is that motion itself, of the place p (radial, axial) and the spin w
(radial, along, axial) over the azimuth, at azimuths between which both are sums of waves, with the one orbit speed O of
balls in one cage, which varies as they pass (`passing_waves`):

    m p'' = forces + m r O^2 e_r,   J (w' + O e_z x w) = moments,   (m r^2 O + J_c O/Z)' = the moment along the orbit,

' = O d/d(azimuth), the last in sum over the Z balls, J_c being the inertia of the cage. Contacts are as they are of
balls that move (`forces.equations`): at the groove's true angle, with viscous terms, and with friction along what
slips. Newton's method finds the motion from that of rolling, first at one even orbit speed and with what the axis does
in one turn alone, then over ever longer times.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.names import POINT
from bearing_twin.kinds.bearing.parameters import rubbing_by
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts, shared
from bearing_twin.kinds.bearing.quasi_static.statics import azimuths_of
from bearing_twin.kinds.bearing.quasi_static.surroundings import STILL, UNKNOWNS, Surroundings
from bearing_twin.kinds.bearing.quasi_static.turn_search import Search, parted, passing_waves
from bearing_twin.kinds.bearing.quasi_static.turn_table import BEARS, LOOKS, balanced_on_the_way, without_shares

# Azimuths of a turn, the more the sharper what happens on it; odd, so that no wave is lost. Where balls slide on part
# of their way the last two are needed, at which a motion is looked for from one at fewer alone: they cost a second.
COUNTS = (17, 33, 65, 129, 257)
SLIDING = 65
SHARP_LOOKS = 1024  # azimuths of a table where balls slide on part of their way
# Of the greatest angle: what the shortest waves may be before more azimuths are taken, of up to SLIDING and beyond.
FINE, FINER = 1e-5, 1e-6
# Relative: what is off against balls that move, measured up to 3e-4, and 2e-2 where so many azimuths are too few.
OFF, OFF_SHARP = 5e-4, 3e-2
LEAVING = tuple(f"a ball {bears} next to nothing on part of its way" for bears in ("bears", "comes to bear"))
NO_GRAVITY = (0.0, 0.0, 0.0)
COARSE = 1e-3  # and at the most azimuths
FEW = 6  # rounds of balance and orbit speed: each leaves a tenth
EVEN = 1e-7  # of the ball's radius: a ring that is less off the axis, or tilted, loads all balls alike


class Turn(NamedTuple):
    """What repeats itself: places [m] and spins [rad/s] (M, UNKNOWNS) at even azimuths, the mean `orbit` speed [rad/s].

    `swing` (2 J,) [rad/s] are the waves of that speed, which repeat themselves as one of so many balls comes to where
    the next was (`passing_waves`). `why` says why there is no such motion, "" where there is.
    `ring` (5,) is where the ring stands in it, None where that is not known. `apart` is what loads with axes of rolling
    are off, over the greatest, where balls were moved and there is no such motion. `taken` is how often what acts on a
    ball was evaluated for the equilibrium in which a scene begins, with all that was tried; 0 of others.
    """

    motion: np.ndarray
    orbit: float
    why: str = ""
    swing: np.ndarray = np.zeros(0)
    balls: int = 1
    ring: np.ndarray | None = None
    apart: float = 0.0
    taken: int = 0

    @property
    def ring_speed(self) -> float:
        """How fast the ring's centre moves as balls pass [m/s]: next to nothing where all bear load."""
        return 0.0

    @property
    def looks(self) -> int:
        """The azimuths of its table: more where balls slide on part of their way."""
        return LOOKS if len(self.motion) < SLIDING else SHARP_LOOKS

    def standing(self, coordinates) -> np.ndarray:
        """How the ring, at `coordinates` (5,), stands and moves while a ball passes, rows (1, 10)."""
        return np.array([(*coordinates, *STILL)])

    def inertia(self, mass: float, heavy: np.ndarray, _, azimuths: np.ndarray) -> np.ndarray:
        """That of a ball of this mass [kg], radial and axial (K, 2) [N], `heavy` (K,) being the centrifugal load."""
        swing = mass * self.accelerations(azimuths)
        return np.stack([heavy - swing[:, 0], -swing[:, 1]], axis=1)

    def at(self, azimuths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Motion and its derivative by the azimuth (K, UNKNOWNS) at these azimuths [rad] (K,)."""
        waves = np.fft.rfft(self.motion, axis=0) / len(self.motion)
        waves[1:] *= 2.0
        order = np.arange(len(waves))
        there = np.exp(1j * np.outer(azimuths, order))
        return (there @ waves).real, (there @ (1j * order[:, None] * waves)).real

    def pace(self, azimuths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The orbit speed [rad/s] and its derivative by the azimuth, each (K,)."""
        speeds = np.append(self.orbit, self.swing)
        waves, changes = passing_waves(azimuths, self.balls, len(self.swing) // 2)
        return waves @ speeds, changes @ speeds

    def whole(self, azimuths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places, their rates [m/s] and spins (K, 7), and orbit speeds (K,), at these azimuths [rad] (K,)."""
        (motion, changes), (orbit, _) = self.at(azimuths), self.pace(azimuths)
        return np.concatenate([motion[:, :2], orbit[:, None] * changes[:, :2], motion[:, 2:]], axis=1), orbit

    def quicker(self, times: float) -> "Turn":
        """As if the ring turned so many times as fast."""
        motion = self.motion.copy()
        motion[:, 2:] *= times
        return self._replace(motion=motion, orbit=self.orbit * times, swing=self.swing * times)

    def accelerations(self, azimuths: np.ndarray) -> np.ndarray:
        """Those of the place in its meridian plane (K, 2) [m/s^2]."""
        waves = 2.0 * np.fft.rfft(self.motion[:, :2], axis=0) / len(self.motion)
        order, (orbit, change) = np.arange(len(waves)), self.pace(azimuths)
        curve = (np.exp(1j * np.outer(azimuths, order)) @ (-(order[:, None] ** 2) * waves)).real
        return orbit[:, None] * (orbit[:, None] * curve + change[:, None] * self.at(azimuths)[1][:, :2])


def no_turn(why: str, apart: float = 0.0) -> Turn:
    """That there is none, and why."""
    return Turn(np.zeros((0, UNKNOWNS)), math.nan, why, apart=apart)


def off_by(turn: Turn) -> float:
    """What loads and angles of equilibria in this motion are off, over the greatest: more where it is not resolved."""
    return OFF if _resolved(turn) else OFF_SHARP


def _resolved(turn: Turn) -> bool:
    """Whether the azimuths are enough for this motion."""
    return _sharpness(turn) <= (FINE if len(turn.motion) < SLIDING else FINER)


def settled_turn(
    parameters, setting, coordinates, near: Turn | None = None, gravity=NO_GRAVITY, passing: bool = False
) -> Turn:
    """The motion of balls whose axes have settled, the ring at `coordinates` (5,), or why there is none.

    It is looked for from `near` first, one that was found with the ring nearby. The balls have no weight but where
    `gravity` [m/s^2] is given. At a speed that is only `passing` it is looked for next to `near`, and not sharply.
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
        return no_turn(LEAVING[0])
    counts = (1,) if _even(setting, coordinates) and not any(gravity[:2]) else COUNTS
    sharp_near = near is not None and len(near.motion) > SLIDING
    if sharp_near:
        counts = counts[counts.index(len(near.motion)) :]
    if passing:
        counts = tuple(one for one in counts if one <= SLIDING) or counts[:1]
    turn, sharp = near, math.inf
    for count in counts:
        given = parameters, setting, coordinates, count, float(contacts.load.max()), gravity
        found = None if turn is None else _from(turn, Search(*given), count > SLIDING and not passing)
        if found is None and passing:
            return no_turn("none is found next to that at the speed before")
        if found is None and count == 1:
            found = Search(*given).again(_parallel(setting, coordinates, place, contacts))
        if found is None and count > SLIDING:
            break
        if found is None:
            found = _first(Search(*given, passing=0), place, contacts)
            if found is not None:
                found = _from(_turn_of(parameters, found, count), Search(*given), True)
        if found is None:  # what is sharp needs more azimuths
            continue
        turn = _turn_of(parameters, found, count)
        sharp = _sharpness(turn)
        if _resolved(turn):
            break
    if sharp == math.inf:
        if sharp_near:
            return settled_turn(parameters, setting, coordinates, None, gravity)
        return no_turn("no motion is found that repeats itself turn by turn")
    if not sharp <= COARSE:
        return no_turn("balls slide on part of their way")
    if not _least_load(parameters, setting, coordinates, turn) > least:
        return no_turn(LEAVING[1])
    return turn


def _least_load(parameters, setting, coordinates, turn: Turn) -> float:
    """The least load [N] that a ball bears on its way in this motion."""
    azimuths = azimuths_of(len(turn.motion), 0.0)
    acting = Surroundings(parameters, setting, coordinates, azimuths)
    return float(acting.wrench(*turn.whole(azimuths)).contacts.load.min())


def _even(setting, coordinates) -> bool:
    """Whether the ring stands so that all balls are loaded alike."""
    x, y, _, *tilt = coordinates
    return max(abs(x), abs(y), *(setting.arm * abs(one) for one in tilt)) <= EVEN * setting.ball_radius


def _from(turn: Turn, search: Search, far: bool) -> np.ndarray | None:
    """The unknowns of a turn from this one, which is nearby; if it is `far`, over ever longer times as well."""
    begin = _unknowns(turn, search)
    found = search.again(begin)
    return search.further(begin) if found is None and far else found


def _unknowns(turn: Turn, search: Search) -> np.ndarray:
    """The unknowns of a search in this motion."""
    speeds = np.zeros(search.waves.shape[1])
    known = np.append(turn.orbit, turn.swing)[: len(speeds)]
    speeds[: len(known)] = known
    return np.append(turn.at(azimuths_of(search.count, 0.0))[0].ravel(), speeds)


def _turn_of(parameters, unknowns: np.ndarray, count: int) -> Turn:
    """The motion of these unknowns of a search at so many azimuths."""
    motion, speeds = parted(unknowns, count)
    return Turn(motion, float(speeds[0]), "", speeds[1:], parameters.geometry.balls)


def _first(search: Search, place: np.ndarray, contacts: Contacts) -> np.ndarray | None:
    """The unknowns of a turn from rolling, or from an axis parallel to the bearing's, balls in balance being here."""
    motion = np.zeros((len(place), UNKNOWNS))
    motion[:, :2] = place[:, :2]
    orbit = float(shared(contacts, contacts.orbit))
    rolling = float(shared(contacts, contacts.pitch)), orbit - float(shared(contacts, contacts.roll))
    for motion[:, 2], motion[:, 4] in (rolling, (0.0, math.copysign(math.hypot(*rolling), rolling[1]))):
        found = search.found(_unknowns(Turn(motion, orbit), search))
        if found is not None:
            return found
    return None


def _parallel(setting, coordinates, place: np.ndarray, contacts: Contacts) -> np.ndarray:
    """The unknowns of a turn of balls that are all loaded alike, by this place and contacts in rolling.

    Their axes are parallel to the bearing's, no contact slips, and the balls are in balance without friction.
    """
    still, azimuths = without_shares(setting)._replace(speed=0.0), np.zeros(1)
    for _ in range(FEW):
        inner, outer = (setting.ball_radius - 0.5 * contacts.approach[0]) * np.cos(contacts.angle[0])  # of the axis
        middle = setting.outer.locus_radius + place[0, 0]
        orbit = setting.speed * (1.0 - inner / middle) * outer / (inner + outer)
        pull = setting.ball_mass * middle * orbit * orbit
        place, contacts = balanced_on_the_way(still, coordinates, azimuths, np.array([[pull, 0.0]]))
    return np.append(place[0, :2], [0.0, 0.0, -orbit * middle / outer, orbit])


def _sharpness(turn: Turn) -> float:
    """How large the two shortest waves of the place are, over the ball's distance from the groove's centre."""
    if len(turn.motion) == 1:
        return 0.0
    waves = np.abs(np.fft.rfft(turn.motion[:, :2], axis=0)) * 2.0 / len(turn.motion)
    return float(waves[-2:].max() / np.linalg.norm(turn.motion[:, :2], axis=1).min())
