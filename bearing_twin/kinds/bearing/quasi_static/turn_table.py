"""What the settled motion of balls (`settled`) does to them and to the ring, as a table over the azimuth.

A ball and the ring are in balance with that as with weights, wherever on its way the ball is.
"""

import math

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts, contacts_at
from bearing_twin.kinds.bearing.quasi_static.ring_balance import PLACES, ring_loads

LOOKS = 128  # azimuths at which a ball is looked at on its way round
BEARS = 1e-2  # of the greatest load: a ball that bears less is about to leave a raceway

# Columns of a table, one row a look, that of a ball at an azimuth [N]; pairs are inner and outer raceway. Friction on
# the ball by both (radial, axial), its sizes along t, and along the orbit; the ball's inertia (radial, axial); orbit
# speed, roll and pitch [rad/s] as of `Contacts`, the centrifugal load, the moment about the radius that holds the ring
# against friction along the orbit [N m], the ring's speed [rad/s] at which all this is so, and what viscous terms add
# to loads, in PUSHED too.
PUSHED, SIZE, ALONG, INERTIA, ORBIT, ROLL, PITCH, HEAVY, HOLDING, SPEED, VISCOUS, SIZES = np.cumsum(
    (0, 4, 2, 2, 2, 1, 1, 1, 1, 1, 1, 2)
).tolist()

NO_TABLE = np.zeros((0, SIZES))  # of balls whose axes are those of rolling


def balanced_on_the_way(setting, coordinates, azimuths: np.ndarray, weights=None) -> tuple[np.ndarray, Contacts]:
    """Places (M, PLACES) and contacts of a ball in balance at these azimuths [rad].

    `weights` (M, 2) [N], radial and axial, act on it as well, its own does not. The ring stands at `coordinates` (5,).
    """
    directions = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    place = np.full((len(azimuths), PLACES), np.nan)
    weights = np.zeros((len(azimuths), 2)) if weights is None else weights
    ring_loads(setting, directions, coordinates, place, weights, np.zeros(5), np.zeros((5, 5)))
    return place, contacts_at(setting, directions, coordinates, place)


@kernel
def friction_at(table, azimuth, k, rows):
    """Fills row k of `rows` (N, SIZES) with the friction at an azimuth [rad]."""
    place = azimuth / (2.0 * math.pi) * len(table)
    first = math.floor(place)
    part, one = place - first, int(first) % len(table)
    two = (one + 1) % len(table)
    for i in range(SIZES):
        rows[k, i] = table[one, i] + part * (table[two, i] - table[one, i])


@kernel
def add_ring_friction(setting, directions, rows, load):
    """Adds to `load` (5,) [N, N m] what holds the ring against this friction (N, SIZES) on the balls."""
    for k in range(len(rows)):
        cosine, sine = directions[k, 0], directions[k, 1]
        moment = setting.arm * rows[k, 1] - setting.lever * rows[k, SIZE]
        load[0] += cosine * rows[k, 0] - sine * rows[k, ALONG]
        load[1] += sine * rows[k, 0] + cosine * rows[k, ALONG]
        load[2] += rows[k, 1]
        load[3] += sine * moment + cosine * rows[k, HOLDING]
        load[4] += sine * rows[k, HOLDING] - cosine * moment


@kernel
def put_friction(contacts, rows):
    """Puts friction (N, SIZES) into `contacts`, and turns it in `rows` to where these contacts are."""
    for k in range(len(rows)):
        for side in range(2):
            size, angle = rows[k, SIZE + side], contacts.angle[k, side]
            contacts.friction[k, side] = size
            push, sine, cosine = (1.0 - 2.0 * side) * rows[k, VISCOUS + side], math.sin(angle), math.cos(angle)
            rows[k, 2 * side], rows[k, 2 * side + 1] = push * cosine - size * sine, push * sine + size * cosine


@kernel
def pass_speed(rows, speed):
    """Makes of `rows` (N, SIZES) those at a speed [rad/s] nearby."""
    for k in range(len(rows)):
        quicker = speed / rows[k, SPEED]
        for place in (INERTIA, INERTIA + 1, HEAVY):
            rows[k, place] *= quicker * quicker
        for place in (ORBIT, ROLL, PITCH):
            rows[k, place] *= quicker
        rows[k, SPEED] = speed


@kernel
def put_settled(contacts, rows):
    """Puts into `contacts` how balls move, their friction along the orbit and viscous terms."""
    for k in range(len(rows)):
        contacts.orbit[k], contacts.roll[k], contacts.pitch[k] = rows[k, ORBIT], rows[k, ROLL], rows[k, PITCH]
        contacts.centrifugal[k] = rows[k, HEAVY]
        for side in range(2):
            contacts.along[k, side] = rows[k, ALONG + side]
            contacts.load[k, side] += rows[k, VISCOUS + side]


def without_shares(setting):
    """The numbers of a balance whose friction is given, all of it."""
    return setting._replace(share_inner=0.0, share_outer=0.0)
