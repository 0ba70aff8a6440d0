"""What a bearing gives out, computed in lanes: LANES pairs of an output and a ball side by side.

Rows hold one ball's numbers in the order of the channels of `outputs`, so that they are spread over a row of the
matrix of all channels by two lists, `Places`. Contacts are those of the equations of motion themselves
(`equations.raceway_contact`), with friction over the spots where the scene has it.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.equations import (
    give_coefficients,
    lane_position,
    raceway_contact,
    ring_contact,
)
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BORDER_MOTION,
    DISSIPATED,
    DRIVE_WORK,
    GIVEN_INNER,
    GIVEN_OUTER,
    GROSS_WORK,
    LANE_ROWS,
    ORBIT_ANGLE,
    PLACES,
    RING_SPEED,
    SHAFT_ANGLE,
    SHAFT_SPEED,
    SPIN,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.ring_seat import ring_in_lane
from bearing_twin.kinds.bearing.forces.spot import find_means, lane_answers
from bearing_twin.kinds.bearing.output_pairs import neighbour_gaps, write_pairs
from bearing_twin.numerics.lanes import (
    COLUMNS,
    LANES,
    get,
    get_quaternion,
    get_vector,
    new_lanes,
    put,
    put_quaternion,
    put_vector,
)
from bearing_twin.numerics.rotation import (
    about_z,
    add,
    arctangent,
    cosine_sine,
    cross,
    dot,
    minus,
    quaternion_product,
    scaled,
)

INNER, OUTER = np.arange(2)  # no constants to Numba, which would compile what takes a side once for each
OWN_WIDTHS = (1, 3, 3, 4, 3, 1, 3, 3, 2, 2, 2, 2, 2, 2, 6, 6, 6, 6, 2)  # of the channels with a ball's own numbers
SHARED_WIDTHS = (3, 3, 3, 3, 1, 1, 1, 1, 1, 1)  # of those that are sums over the balls

(
    ANGLE_OUT, POSITION_OUT, VELOCITY_OUT, ORIENTATION_OUT, SPIN_OUT, ROLL_OUT, FORCE_OUT, TORQUE_OUT, APPROACH_OUT,
    LOAD_OUT, CONTACT_ANGLE_OUT, SPIN_RATE_OUT, SMALL_OUT, LARGE_OUT, POINT_OUT, NORMAL_OUT, FRICTION_OUT, SLIP_OUT,
    DRILLING_OUT, INNER_FORCE, INNER_TORQUE, OUTER_FORCE, OUTER_TORQUE, KINETIC, ELASTIC, POTENTIAL, WORK, LOST, GROSS,
    OWN_ORIENTATION, ENERGIES, OUTPUT_ROWS,
) = LANE_ROWS + np.cumsum((0, *OWN_WIDTHS, *SHARED_WIDTHS, 4, 2))  # fmt: skip
DRIVE_TORQUE = 16  # columns after the ring's angle
OWN_ROWS, SHARED_ROWS = sum(OWN_WIDTHS), sum(SHARED_WIDTHS)


class Places(NamedTuple):
    """Where numbers stand in a row of all channels: own number i of ball k at `first[i] + k step[i]`, and the rest."""

    first: np.ndarray
    step: np.ndarray
    ring: int
    shared: int
    neighbours: int
    position: int
    force: int


@inlined
def _note(contact, side, lanes, k):
    """Keeps what outputs need of a contact, in the ball's frame; `point` holds the arm until it is turned."""
    put(lanes, APPROACH_OUT + side, k, contact.approach)
    put(lanes, LOAD_OUT + side, k, contact.normal_load)
    put(lanes, SPIN_RATE_OUT + side, k, contact.spin_rate)
    put(lanes, SMALL_OUT + side, k, contact.curvature_small)
    put(lanes, LARGE_OUT + side, k, contact.curvature_large)
    put(lanes, DRILLING_OUT + side, k, contact.drilling)
    put(lanes, ENERGIES + side, k, contact.energy)
    put_vector(lanes, POINT_OUT + 3 * side, k, contact.arm)
    put_vector(lanes, NORMAL_OUT + 3 * side, k, contact.normal)
    put_vector(lanes, FRICTION_OUT + 3 * side, k, contact.friction)
    put_vector(lanes, SLIP_OUT + 3 * side, k, contact.slip)


@kernel
def _contacts(bearing, lanes):
    """Both contacts of every lane, with friction at a point if any."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        position = lane_position(lanes, k)
        velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
        place, ring = ring_in_lane(bearing.ring, bearing.offset, lanes, k)
        speed, given = get(lanes, RING_SPEED, k), get(lanes, GIVEN_INNER, k)
        inner = ring_contact(ring, bearing, given, place, cosine, sine, speed, position, velocity, spin)
        given = get(lanes, GIVEN_OUTER, k)
        outer = raceway_contact(bearing, bearing.outer, given, (0.0, 0.0, 0.0), 0.0, position, velocity, spin)
        _note(inner, INNER, lanes, k)
        _note(outer, OUTER, lanes, k)


@kernel
def _add_spots(spot, bearing, lanes):
    """Friction over the spots of every lane, where the bearing's `spot` is not empty."""
    if len(spot) > 0:
        find_means(spot, bearing, lanes)
        for k in range(LANES):
            inner, outer, _ = lane_answers(spot[0], bearing, lanes, k)
            put(lanes, DRILLING_OUT + INNER, k, inner.drilling)
            put(lanes, DRILLING_OUT + OUTER, k, outer.drilling)
            put_vector(lanes, FRICTION_OUT + 3 * INNER, k, inner.friction)
            put_vector(lanes, FRICTION_OUT + 3 * OUTER, k, outer.friction)


@inlined
def _turn_contact(side, cosine, sine, local, centre, lanes, k):
    """Turns a contact into fixed axes; force and torque on the ball about its centre, and on the ring about its own."""
    arm, normal = get_vector(lanes, POINT_OUT + 3 * side, k), get_vector(lanes, NORMAL_OUT + 3 * side, k)
    friction, slip = get_vector(lanes, FRICTION_OUT + 3 * side, k), get_vector(lanes, SLIP_OUT + 3 * side, k)
    drilling = scaled(get(lanes, DRILLING_OUT + side, k), normal)
    load = get(lanes, LOAD_OUT + side, k)
    force = about_z(cosine, sine, add(scaled(-load, normal), friction))
    torque = about_z(cosine, sine, add(cross(arm, friction), drilling))
    point = about_z(cosine, sine, add(local, arm))
    in_plane = math.sqrt(normal[0] * normal[0] + normal[1] * normal[1])
    put(lanes, CONTACT_ANGLE_OUT + side, k, arctangent(normal[2] / in_plane))
    put_vector(lanes, POINT_OUT + 3 * side, k, point)
    put_vector(lanes, NORMAL_OUT + 3 * side, k, about_z(cosine, sine, scaled(-1.0, normal)))
    put_vector(lanes, FRICTION_OUT + 3 * side, k, about_z(cosine, sine, friction))
    put_vector(lanes, SLIP_OUT + 3 * side, k, about_z(cosine, sine, slip))
    reaction = add(cross(minus(point, centre), force), about_z(cosine, sine, drilling))
    return force, torque, scaled(-1.0, reaction)


@kernel
def _turn(bearing, lanes):
    """Turns every lane's ball and contacts from the ball's frame into fixed axes, and sums up its shares."""
    for k in range(LANES):
        angle = get(lanes, ORBIT_ANGLE, k)
        cosine, sine = cosine_sine(angle)
        half_cosine, half_sine = cosine_sine(0.5 * angle)
        local = lane_position(lanes, k)
        velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
        position = about_z(cosine, sine, local)
        quaternion = quaternion_product((0.0, 0.0, half_sine, half_cosine), get_quaternion(lanes, OWN_ORIENTATION, k))
        place, _ = ring_in_lane(bearing.ring, bearing.offset, lanes, k)
        inner, inner_torque, inner_reaction = _turn_contact(INNER, cosine, sine, local, place, lanes, k)
        outer, outer_torque, outer_reaction = _turn_contact(OUTER, cosine, sine, local, (0.0, 0.0, 0.0), lanes, k)
        motion = bearing.ball_mass * dot(velocity, velocity) + bearing.ball_inertia * dot(spin, spin)
        put(lanes, ANGLE_OUT, k, angle)
        put_vector(lanes, POSITION_OUT, k, position)
        put_vector(lanes, VELOCITY_OUT, k, about_z(cosine, sine, velocity))
        put_quaternion(lanes, ORIENTATION_OUT, k, quaternion)
        put_vector(lanes, SPIN_OUT, k, about_z(cosine, sine, spin))
        put(lanes, ROLL_OUT, k, velocity[1] / local[0] - spin[2])
        put_vector(lanes, FORCE_OUT, k, add(inner, outer))
        put_vector(lanes, TORQUE_OUT, k, add(inner_torque, outer_torque))
        put_vector(lanes, INNER_FORCE, k, scaled(-1.0, inner))
        put_vector(lanes, INNER_TORQUE, k, inner_reaction)
        put_vector(lanes, OUTER_FORCE, k, scaled(-1.0, outer))
        put_vector(lanes, OUTER_TORQUE, k, outer_reaction)
        put(lanes, KINETIC, k, 0.5 * motion)
        put(lanes, ELASTIC, k, get(lanes, ENERGIES + INNER, k) + get(lanes, ENERGIES + OUTER, k))
        put(lanes, POTENTIAL, k, -bearing.ball_mass * dot(bearing.gravity, position))
        put(lanes, WORK, k, get(lanes, DRIVE_WORK, k))
        put(lanes, LOST, k, get(lanes, DISSIPATED, k))
        put(lanes, GROSS, k, get(lanes, GROSS_WORK, k))


@kernel
def _load(states, orientations, sample, ball, lanes):
    """Copies the balls of all lanes, number `ball[k]` of `sample[k]`, into them."""
    for column in range(COLUMNS):
        for k in range(LANES):
            put(lanes, AXIS_DISTANCE + column, k, states[sample[k], ball[k], column])
    for part in range(4):
        for k in range(LANES):
            put(lanes, OWN_ORIENTATION + part, k, orientations[sample[k], ball[k], part])


@kernel
def _spread(places, lanes, count, ball, begin, out):
    """Writes the first `count` lanes into rows of all channels and adds their shares, ball by ball; ball 0 begins.

    `begin[k]` is where the row of lane k begins in the flat `out`. Row after row of the lanes, whose numbers follow
    each other.
    """
    first, step = places.first, places.step
    for i in range(OWN_ROWS):
        at, apart = first[i], step[i]
        for k in range(count):
            out[begin[k] + at + ball[k] * apart] = get(lanes, ANGLE_OUT + i, k)
    for i in range(SHARED_ROWS):
        total = out[begin[0] + places.shared + i]
        for k in range(count):
            share = get(lanes, INNER_FORCE + i, k)
            total = share if ball[k] == 0 else total + share
            out[begin[k] + places.shared + i] = total


@inlined
def _put_ring(ring, borders, sample, lanes, k):
    """Gives a lane the place and motion of a ring that tilts or moves."""
    if len(ring) > 0:
        for i in range(2 * PLACES):
            put(lanes, BORDER_MOTION + i, k, borders[sample, i])


@inlined
def _write_ring(ring, border, row, first):
    """Writes offset, tilt, velocity and rate of the tilt of such a ring from column `first` on."""
    if len(ring) > 0:
        for i in range(5):
            row[first + i] = border[i]
            row[first + 5 + i] = border[PLACES + i]


@kernel
def write_rows(bearing, drive, times, states, orientations, borders, turned, places, out, first):
    """Fills `out` from row `first` on with the states (count, N, columns), orientations (count, N, 4) at `times` [s].

    `borders` (count, BORDER) are those of ring and cage, where the bearing's `ring` is not empty. `times`
    count from the instant the drive's angle and speed belong to; where a ring is `turned` by a torque, they are those
    of the border.
    """
    balls, lanes, flat = bearing.balls, new_lanes(OUTPUT_ROWS), out.reshape(-1)
    sample, ball, begin = np.zeros((3, LANES), np.int64)
    total, width = len(times) * balls, out.shape[1]
    for done in range(0, total, LANES):
        for k in range(LANES):
            pair = min(done + k, total - 1)
            sample[k], ball[k] = pair // balls, pair % balls
            begin[k] = (first + sample[k]) * width
            speed = borders[sample[k], SHAFT_SPEED] if turned else drive.speed + drive.acceleration * times[sample[k]]
            put(lanes, RING_SPEED, k, speed)
            _put_ring(bearing.ring, borders, sample[k], lanes, k)
        _load(states, orientations, sample, ball, lanes)
        give_coefficients(bearing, lanes)
        _contacts(bearing, lanes)
        _add_spots(bearing.spot, bearing, lanes)
        _turn(bearing, lanes)
        _spread(places, lanes, min(LANES, total - done), ball, begin, flat)
    near = np.zeros(balls, np.bool_)
    for sample in range(len(times)):
        row, time = out[first + sample], times[sample]
        row[places.ring] = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time)
        row[places.ring + 1] = drive.speed + drive.acceleration * time
        if turned:
            row[places.ring], row[places.ring + 1] = borders[sample, SHAFT_ANGLE], borders[sample, SHAFT_SPEED]
        for axis in range(3):
            row[places.ring + 2 + axis] = bearing.offset[axis]
        for column in range(places.ring + 5, places.shared):
            row[column] = 0.0
        row[places.ring + DRIVE_TORQUE] = -row[places.shared + 5]
        _write_ring(bearing.ring, borders[sample], row, places.ring + 2)
        for column in range(places.neighbours + balls, len(row)):
            row[column] = 0.0
        if neighbour_gaps(bearing, states[sample], places.position, row, places.neighbours, near):
            elastic = places.shared + ELASTIC - INNER_FORCE
            write_pairs(bearing, states[sample], near, elastic, places.neighbours + balls, row)
