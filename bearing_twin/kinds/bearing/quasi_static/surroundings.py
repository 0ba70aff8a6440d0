"""What acts on a ball that goes round, as in `forces.equations`, at many azimuths at once."""

import threading
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.parameters import viscous_terms
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts, contacts_at
from bearing_twin.kinds.bearing.quasi_static.opening import opening_of
from bearing_twin.kinds.bearing.quasi_static.ring_balance import PLACES

STILL = (0.0,) * 5  # a ring that stands where it is
UNKNOWNS = 5  # of a ball at one azimuth: place (2), spin (3)


class _Taken(threading.local):
    """How often what acts on a ball was evaluated in this thread to find how balls move."""

    evaluations = 0


TAKEN = _Taken()


class Acting(NamedTuple):
    """What acts on a ball at some azimuths (K,), lists of inner and outer raceway.

    `normals` (K, 3) point to the raceway outwards of the ball's centre on both, `viscous` (K,) [N] are what viscous
    terms add to loads, `friction` (K, 3) [N], `moment` (K, 3) [N m] that of both; of `contacts` loads without viscous
    terms and places count.
    """

    normals: list[np.ndarray]
    viscous: list[np.ndarray]
    friction: list[np.ndarray]
    moment: np.ndarray
    contacts: Contacts

    def normal_of(self, side: int, load: np.ndarray) -> np.ndarray:
        """The push of a raceway on the ball (K, 3) [N] at these loads (K,)."""
        return ((1.0 - 2.0 * side) * load)[:, None] * self.normals[side]

    def force(self) -> np.ndarray:
        """The whole force on the ball (K, 3) [N]."""
        loads = (self.contacts.load[:, side] + self.viscous[side] for side in range(2))
        return sum(self.normal_of(side, load) + self.friction[side] for side, load in enumerate(loads))


class Surroundings:
    """What acts on a ball at azimuths [rad] (K,), the ring at `coordinates` (5,), with this gravity [m/s^2].

    `rates` (5,) [m/s], [rad/s] are those of the ring's coordinates.
    """

    def __init__(self, parameters, setting, coordinates, azimuths: np.ndarray, gravity=(0.0, 0.0, 0.0), rates=STILL):
        self.setting, self.coordinates = setting, np.asarray(coordinates, float)
        self.at_rest = setting._replace(speed=0.0)
        self.directions = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
        self.opening = opening_of(setting, *self.directions.T, self.coordinates)
        self.axis = np.stack([-self.opening.along, -self.opening.across, np.ones(len(azimuths))], axis=1)
        contact = parameters.contact
        self.friction, self.smooth = contact.friction_coefficient, contact.friction_regularisation
        self.viscous = viscous_terms(contact)
        self.weight = setting.ball_mass * self._turned(gravity)
        self.moves, self.tilts = self._turned(rates[:3]), self._turned((*rates[3:], 0.0))
        self.inertia = 0.4 * setting.ball_mass * setting.ball_radius**2

    def _turned(self, vector) -> np.ndarray:
        """A vector (3,) along the ball's radius, way and axis (K, 3)."""
        (cosine, sine), (x, y, z) = self.directions.T, vector
        return np.stack([x * cosine + y * sine, y * cosine - x * sine, np.full(len(cosine), z)], axis=1)

    def wrench(self, motion: np.ndarray, orbit) -> Acting:
        """What acts on balls in this motion (K, 7): place, its rates [m/s] and spin; orbit speeds (K,) [rad/s]."""
        setting, opening = self.setting, self.opening
        TAKEN.evaluations += len(motion)
        place = np.zeros((len(motion), PLACES))
        place[:, :2] = motion[:, :2]
        contacts = contacts_at(self.at_rest, self.directions, self.coordinates, place)
        distance = setting.outer.locus_radius + motion[:, 0]
        low = motion[:, 1] - self.coordinates[2]
        cosine, sine = np.cos(contacts.angle), np.sin(contacts.angle)
        nothing = np.zeros(len(motion))
        # where the ring's meridian plane leans against the ball's, at the ball's own distance and height
        lean = -(cosine[:, 0] * (opening.aside - low * opening.across) / distance + sine[:, 0] * opening.across)
        normals = [np.stack([cosine[:, i], (lean, nothing)[i], sine[:, i]], axis=1) for i in range(2)]
        from_ring = np.stack([distance - opening.outwards, -opening.aside, low], axis=1)
        velocity = np.stack([motion[:, 2], distance * orbit, motion[:, 3]], axis=1)
        by_load, by_stiffness = self.viscous
        viscous, friction, moment = [], [], np.zeros((len(motion), 3))
        for i, (sign, raceway) in enumerate(((-1.0, setting.inner), (1.0, setting.outer))):
            load, approach = contacts.load[:, i], contacts.approach[:, i]
            arm = (sign * (setting.ball_radius - 0.5 * approach))[:, None] * normals[i]
            slip = velocity + np.cross(motion[:, 4:], arm)
            if i == 0:
                slip -= self.moves + np.cross(setting.speed * self.axis + self.tilts, from_ring + arm)
            rate = sign * (slip * normals[i]).sum(axis=1)
            slip -= (sign * rate)[:, None] * normals[i]
            stiffness = np.divide(raceway.law.power * load, approach, out=np.zeros_like(load), where=load > 0.0)
            damped = np.maximum(load + (by_load * load + by_stiffness * stiffness) * rate, 0.0)
            resisted = self.friction * damped / np.sqrt(self.smooth**2 + (slip * slip).sum(axis=1))
            viscous.append(damped - load)
            friction.append(-resisted[:, None] * slip)
            moment += np.cross(arm, friction[-1])
        return Acting(normals, viscous, friction, moment, contacts)

    def balance(self, motion: np.ndarray, orbit) -> np.ndarray:
        """What is left (K, 6): forces (radial, axial), moments, the moment along the orbit; without accelerations."""
        found, setting = self.wrench(motion, orbit), self.setting
        force = found.force() + self.weight
        distance = setting.outer.locus_radius + motion[:, 0]
        turned = self.inertia * orbit
        left = np.empty((len(motion), 6))
        left[:, 0] = force[:, 0] + setting.ball_mass * distance * orbit * orbit
        left[:, 1] = force[:, 2]
        left[:, 2:5] = found.moment
        left[:, 2] += turned * motion[:, 5]
        left[:, 3] -= turned * motion[:, 4]
        left[:, 5] = distance * force[:, 1]
        return left
