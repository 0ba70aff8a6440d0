"""Friction across the grooves on balls that go round in one cage, and the equilibrium that holds it.

A ball is in balance with friction F + g along t_i and F - g along t_o, g = M_g/D (`ball_balance`). With the ball's
place p and the velocity u of the inner raceway under it, its contacts slip, in sum by S = p' . (t_i + t_o) - u . t_i,
and as the ball turns about its tangent until both resist alike, S = -F (1/c_i + 1/c_o) - g (1/c_i - 1/c_o), with
c = mu Q/sqrt(s^2 + slip^2). F moves the ball, by A (t_i + t_o) F with the compliance A of its balance: its place lags
(`moving_balls` has this in short).

u is the spin of a ring off the axis or tilted. Where its meridian plane leans against the ball's, the inner contact
lies beside the latter, and what the ball drills against the ring is slip across as well. Slips along the grooves, which
take from c, are those of balls that share one orbit speed, at which they push a cage without friction neither way. The
axes of spin are those of rolling, and carry the gyroscopic moment that the balance has.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.kinds.bearing.quasi_static.ball_balance import balance_at
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts, contacts_at, shared
from bearing_twin.kinds.bearing.quasi_static.opening import opening_of
from bearing_twin.kinds.bearing.quasi_static.ring_balance import PLACES, ring_loads
from bearing_twin.kinds.bearing.quasi_static.statics import azimuths_of

LOOKS = 128  # azimuths at which a ball is looked at on its way round
TURNS = 12  # after which a lag and the orbit speed repeat themselves at the latest
STEADY = 1e-7  # relative: what an orbit speed may change in the last turn
PASSES = 3  # over one look, for what friction takes from its own coefficient
SAME = 1e-9  # rad: contact angles that vary by less on the way are one
BEARS = 1e-2  # of the greatest load: a ball that bears less is about to leave a raceway

# Columns of a table of friction, one row a look, that of a ball at an azimuth [N]; pairs are inner and outer raceway.
# Friction on the ball by both (radial, axial), its sizes along t, and along the orbit. Of balls whose axes have settled
# (`in_motion`) also what else acts on the ball (radial, axial), its inertia; orbit speed, roll and pitch [rad/s] as of
# `Contacts`, the centrifugal load, the moment about the radius that holds the ring against friction along the orbit
# [N m], the ring's speed [rad/s] at which all this is so, and what viscous terms add to loads, in PUSHED too.
PUSHED, SIZE, ALONG, INERTIA, ORBIT, ROLL, PITCH, HEAVY, HOLDING, SPEED, VISCOUS, SIZES = np.cumsum(
    (0, 4, 2, 2, 2, 1, 1, 1, 1, 1, 1, 2)
).tolist()

NO_FRICTION = np.zeros((0, SIZES))


@kernel
def _write_way(setting, directions, q, place, contacts, way):
    """Fills `way` (LOOKS, 14): opening, compliance of the place (rows first), and the inner raceway under the ball.

    That is: its velocity across over the ring's speed, how far the contact lies aside, the ring's displacement along
    the radius, the ball's distance from the axis, both arms, the tilt along the orbit, the ball's height.
    """
    for k in range(len(directions)):
        opening = opening_of(setting, directions[k, 0], directions[k, 1], q)
        a, b, c, d = balance_at(setting, opening.radial, opening.axial, place[k, 0], place[k, 1], 0.0, 0.0).left_p
        inverse = -1.0 / (a * d - b * c) if a * d != b * c else 0.0
        arm = setting.ball_radius - 0.5 * max(contacts.approach[k, 0], 0.0)
        n_r, n_z = math.cos(contacts.angle[k, 0]), math.sin(contacts.angle[k, 0])
        radius, height = setting.outer.locus_radius + place[k, 0], place[k, 1] - q[2]
        low = height - arm * n_z
        way[k, 0], way[k, 1] = opening.radial, opening.axial
        way[k, 2], way[k, 3], way[k, 4], way[k, 5] = d * inverse, -b * inverse, -c * inverse, a * inverse
        leans, sideways = opening.across, opening.aside
        way[k, 6] = (radius - arm * n_r) * leans * n_r - (sideways - low * leans) * n_z
        way[k, 7] = arm * (n_r * sideways / radius + (n_z - n_r * height / radius) * leans)
        way[k, 8], way[k, 9], way[k, 10] = opening.outwards, radius, arm
        way[k, 11] = setting.ball_radius - 0.5 * max(contacts.approach[k, 1], 0.0)
        way[k, 12], way[k, 13] = opening.along, height


@inlined
def _along(setting, row, orbit, moved_r, moved_z, place_r, place_z, c_i, c_o, drilling):
    """Slips along the inner and the outer groove [m/s], as both resist alike, their sum in forces [N] and its slope.

    `drilling` [rad/s] is the ball's turning about the outer normal; the slope is by the orbit speed.
    """
    outer_r, outer_z = place_r + moved_r, place_z + moved_z
    inner_r, inner_z = row[0] - outer_r, row[1] - outer_z
    outer, inner = math.sqrt(outer_r**2 + outer_z**2), math.sqrt(inner_r**2 + inner_z**2)
    sine = (outer_z * inner_r - outer_r * inner_z) / (inner * outer)  # of the angle between both contacts
    cosine = math.sqrt(1.0 - sine * sine)
    arm_i, arm_o, radius = row[10], row[11], row[9] + moved_r
    low = row[13] + moved_z - arm_i * inner_z / inner
    ring = setting.speed * (low * row[12] + radius - arm_i * inner_r / inner - row[8])
    whole = c_o * arm_o * arm_o + c_i * arm_i * arm_i * cosine
    roll = (c_i * arm_i * (orbit * radius - arm_i * drilling * sine - ring) - c_o * arm_o * orbit * radius) / whole
    slip_o = orbit * radius + arm_o * roll
    slip_i = orbit * radius - arm_i * (roll * cosine + drilling * sine) - ring
    return slip_i, slip_o, -c_o * slip_o, -c_o * radius * (1.0 + arm_o * (c_i * arm_i - c_o * arm_o) / whole)


@kernel
def _turn(setting, mu, smooth, way, place, contacts, spin, orbit, late, out):
    """Once round: fills `out` (LOOKS,), friction F [N]; gives the force along the grooves and its slope, summed.

    `late` (8,): by how much the ball was late at the last look and the one before (radial, axial), and slips there,
    across and along, inner and outer. Rates are those of a parabola through three looks. `spin` is the ball's
    (radial, axial) [rad/s].
    """
    looks, total, slope = len(way), 0.0, 0.0
    side = 1 if orbit > 0.0 else -1
    rate = 1.5 * looks * abs(orbit) / (2.0 * math.pi)
    for i in range(looks):
        k = (side * i) % looks
        one, two = (k - side) % looks, (k - 2 * side) % looks
        row = way[k]
        i_r, i_z = math.cos(contacts.angle[k, 0]), math.sin(contacts.angle[k, 0])
        o_r, o_z = math.cos(contacts.angle[k, 1]), math.sin(contacts.angle[k, 1])
        across_r, across_z = -i_z - o_z, i_r + o_r
        by_r, by_z = row[2] * across_r + row[3] * across_z, row[4] * across_r + row[5] * across_z
        moved_r = place[k, 0] - (4.0 * (place[one, 0] + late[0]) - place[two, 0] - late[2]) / 3.0
        moved_z = place[k, 1] - (4.0 * (place[one, 1] + late[1]) - place[two, 1] - late[3]) / 3.0
        driven = setting.speed * row[6] - (spin[0] * i_r + (spin[1] - setting.speed) * i_z) * row[7]
        driven -= rate * (moved_r * across_r + moved_z * across_z)
        soft = rate * (by_r * across_r + by_z * across_z)
        drilling = spin[0] * o_r + spin[1] * o_z
        force, pushed, by_orbit = 0.0, 0.0, 0.0
        for _ in range(PASSES):
            c_i = mu * contacts.load[k, 0] / math.sqrt(smooth * smooth + late[4] * late[4] + late[6] * late[6])
            c_o = mu * contacts.load[k, 1] / math.sqrt(smooth * smooth + late[5] * late[5] + late[7] * late[7])
            g = contacts.friction[k, 0]
            force = (driven - g * (1.0 / c_i - 1.0 / c_o)) / (1.0 / c_i + 1.0 / c_o + soft)
            late[4], late[5] = -(force + g) / c_i, -(force - g) / c_o
            late[6], late[7], pushed, by_orbit = _along(
                setting, row, orbit, by_r * force, by_z * force, place[k, 0], place[k, 1], c_i, c_o, drilling
            )
        late[2], late[3], late[0], late[1] = late[0], late[1], by_r * force, by_z * force
        out[k] = force
        total, slope = total + pushed, slope + by_orbit
    return total, slope


@kernel
def _settle(setting, mu, smooth, way, place, contacts, spin, orbit, out):
    """Turns until friction (`out`) and the orbit speed [rad/s] of all balls repeat themselves."""
    late = np.zeros(8)
    for turn in range(TURNS):
        total, slope = _turn(setting, mu, smooth, way, place, contacts, spin, orbit, late, out)
        step = -total / slope
        orbit += step
        if turn > 1 and abs(step) <= STEADY * abs(orbit):
            break


def balanced_on_the_way(setting, coordinates, azimuths: np.ndarray, weights=None) -> tuple[np.ndarray, Contacts]:
    """Places (M, PLACES) and contacts of a ball in balance at these azimuths [rad].

    `weights` (M, 2) [N], radial and axial, act on it as well; its own is left out.
    The ring stands at `coordinates` (5,).
    """
    directions = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    place = np.full((len(azimuths), PLACES), np.nan)
    weights = np.zeros((len(azimuths), 2)) if weights is None else weights
    ring_loads(setting, directions, coordinates, place, weights, np.zeros(5), np.zeros((5, 5)))
    return place, contacts_at(setting, directions, coordinates, place)


def friction_on_the_way(parameters, setting, coordinates) -> np.ndarray:
    """Friction across the grooves on a ball (LOOKS, SIZES) [N] from +x on, the ring at `coordinates` (5,).

    It holds the gyroscopic moment of `setting`. Empty at rest, without friction, for friction over spots, where no
    contact angle changes, where a ball leaves a raceway on its way, and where its gyroscopic moment makes it slide.
    """
    contact = parameters.contact
    if setting.speed == 0.0 or contact.friction_coefficient == 0.0 or FRICTIONS[contact.friction].over_spot:
        return NO_FRICTION
    azimuths = azimuths_of(LOOKS, 0.0)
    place, contacts = balanced_on_the_way(setting, coordinates, azimuths)
    if contacts.load.min() <= BEARS * contacts.load.max() or np.ptp(contacts.angle, axis=0).max() <= SAME:
        return NO_FRICTION
    if (np.abs(contacts.friction) >= contact.friction_coefficient * contacts.load).any():
        return NO_FRICTION
    way, force = np.zeros((LOOKS, 14)), np.zeros(LOOKS)
    directions = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    _write_way(setting, directions, coordinates, place, contacts, way)
    orbit = float(shared(contacts, contacts.orbit))
    spin = np.array([contacts.pitch.mean(), orbit - contacts.roll.mean()])
    numbers = contact.friction_coefficient, contact.friction_regularisation
    _settle(setting, *numbers, way, place, contacts, spin, orbit, force)
    if not np.isfinite(force).all():
        return NO_FRICTION
    across = np.stack([-np.sin(contacts.angle), np.cos(contacts.angle)], axis=2)
    moved = np.einsum("kij,kj->ki", way[:, 2:6].reshape(-1, 2, 2), across.sum(axis=1) * force[:, None])
    outer = place[:, :2] + moved
    angles = [np.arctan2(one[:, 1], one[:, 0]) for one in (way[:, :2] - outer, outer)]
    sizes = force[:, None] + contacts.friction
    forces = [
        size[:, None] * np.stack([-np.sin(a), np.cos(a)], axis=1) for a, size in zip(angles, sizes.T, strict=True)
    ]
    return np.concatenate([*forces, sizes, np.zeros((LOOKS, SIZES - ALONG))], axis=1)


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
            contacts.friction[k, side], contacts.along[k, side] = size, rows[k, ALONG + side]
            push, sine, cosine = (1.0 - 2.0 * side) * rows[k, VISCOUS + side], math.sin(angle), math.cos(angle)
            rows[k, 2 * side], rows[k, 2 * side + 1] = push * cosine - size * sine, push * sine + size * cosine


@kernel
def settled_by(table):
    """Whether a table is one of balls whose axes have settled, which go round."""
    return len(table) > 0 and table[0, ORBIT] != 0.0


@kernel
def pass_speed(rows, speed):
    """Makes of `rows` (N, SIZES) of balls whose axes have settled those at a speed [rad/s] nearby."""
    for k in range(len(rows)):
        quicker = speed / rows[k, SPEED]
        for place in (INERTIA, INERTIA + 1, HEAVY):
            rows[k, place] *= quicker * quicker
        for place in (ORBIT, ROLL, PITCH):
            rows[k, place] *= quicker
        rows[k, SPEED] = speed


@kernel
def put_settled(contacts, rows):
    """Puts into `contacts` how balls whose axes have settled move, their friction along the orbit and viscous terms."""
    for k in range(len(rows)):
        contacts.orbit[k], contacts.roll[k], contacts.pitch[k] = rows[k, ORBIT], rows[k, ROLL], rows[k, PITCH]
        contacts.centrifugal[k] = rows[k, HEAVY]
        for side in range(2):
            contacts.along[k, side] = rows[k, ALONG + side]
            contacts.load[k, side] += rows[k, VISCOUS + side]


def without_shares(setting):
    """The numbers of a balance whose friction is given, all of it."""
    return setting._replace(share_inner=0.0, share_outer=0.0)
