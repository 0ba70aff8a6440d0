"""What a bearing gives out, computed in lanes: LANES pairs of an output and a ball side by side.

They stand in the order of the channels of `outputs`, and within a channel ball after ball, so that `output_rows` copies
them as they are. Contacts are those of the equations of motion themselves (`equations.raceway_contact`), with friction
over the spots where the scene has it.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.equations import (
    ON_AXIS,
    give_coefficients,
    lane_position,
    raceway_contact,
    ring_contact,
)
from bearing_twin.kinds.bearing.forces.layout import (
    DISSIPATED,
    DRIVE_WORK,
    GIVEN_INNER,
    GIVEN_OUTER,
    GROSS_WORK,
    LANE_ROWS,
    ORBIT_ANGLE,
    RING_SPEED,
    SPIN,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.ring_seat import moment_on, ring_in_lane
from bearing_twin.kinds.bearing.forces.spot import (
    INNER_SPOTS,
    OUTER_SPOTS,
    find_means,
    keep_spots,
    kept_answer,
)
from bearing_twin.numerics.lanes import (
    LANES,
    get,
    get_quaternion,
    get_vector,
    put,
    put_beside,
    put_vector,
    put_vector_beside,
)
from bearing_twin.numerics.lean import lean_kernel
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

# The channels of a ball as a row of all channels has them, ball after ball (`put_beside`); then, in rows of their own,
# the orientation in the ball's frame, the orbit angle's cosine and sine, of both contacts, in that frame, what is to be
# turned, and force and torque of both on the ball, turned; and at last the shares in sums. A loop is vector code if it
# writes channels of one width and only rows that are far from these, as LLVM sees that they are others.
(
    ANGLE_OUT, POSITION_OUT, VELOCITY_OUT, ORIENTATION_OUT, SPIN_OUT, ROLL_OUT, FORCE_OUT, TORQUE_OUT, APPROACH_OUT,
    LOAD_OUT, CONTACT_ANGLE_OUT, SPIN_RATE_OUT, SMALL_OUT, LARGE_OUT, POINT_OUT, NORMAL_OUT, FRICTION_OUT, SLIP_OUT,
    DRILLING_OUT, OWN_ORIENTATION, COSINE, SINE, ENERGIES, LOADS, DRILLINGS, LOCAL_ARMS, LOCAL_NORMALS,
    LOCAL_FRICTIONS, LOCAL_SLIPS, FORCES, TORQUES, INNER_FORCE, INNER_TORQUE, OUTER_FORCE, OUTER_TORQUE, KINETIC,
    ELASTIC, POTENTIAL, WORK, LOST, GROSS, OUTPUT_ROWS,
) = LANE_ROWS + np.cumsum((0, *OWN_WIDTHS, 4, 1, 1, 2, 2, 2, 6, 6, 6, 6, 3, 3, *SHARED_WIDTHS))  # fmt: skip


@inlined
def _note(contact, side, lanes, k):
    """Keeps what outputs need of a contact, in the ball's frame."""
    put_beside(lanes, APPROACH_OUT, 2, side, k, contact.approach)
    put_beside(lanes, SPIN_RATE_OUT, 2, side, k, contact.spin_rate)
    put_beside(lanes, SMALL_OUT, 2, side, k, contact.curvature_small)
    put_beside(lanes, LARGE_OUT, 2, side, k, contact.curvature_large)
    put_beside(lanes, LOAD_OUT, 2, side, k, contact.normal_load)
    put_beside(lanes, DRILLING_OUT, 2, side, k, contact.drilling)
    normal = contact.normal
    in_plane = math.sqrt(normal[0] * normal[0] + normal[1] * normal[1])
    outwards = (2 * side - 1) * normal[2] + 0.0  # along the line of contact, away from the axis; no -0
    put_beside(lanes, CONTACT_ANGLE_OUT, 2, side, k, arctangent(outwards / in_plane))
    put(lanes, ENERGIES + side, k, contact.energy)
    put(lanes, LOADS + side, k, contact.normal_load)
    put(lanes, DRILLINGS + side, k, contact.drilling)
    put_vector(lanes, LOCAL_ARMS + 3 * side, k, contact.arm)
    put_vector(lanes, LOCAL_NORMALS + 3 * side, k, normal)
    put_vector(lanes, LOCAL_FRICTIONS + 3 * side, k, contact.friction)
    put_vector(lanes, LOCAL_SLIPS + 3 * side, k, contact.slip)


@lean_kernel
def _contacts(bearing, lanes):
    """Both contacts of every lane, with friction at a point, or their spots: channels of one and of two numbers."""
    for k in range(LANES):
        cosine, sine = cosine_sine(get(lanes, ORBIT_ANGLE, k))
        position = lane_position(lanes, k)
        velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
        place, ring = ring_in_lane(bearing.ring, bearing.offset, lanes, k)
        speed, given = get(lanes, RING_SPEED, k), get(lanes, GIVEN_INNER, k)
        inner = ring_contact(ring, bearing, given, place, cosine, sine, speed, position, velocity, spin)
        given = get(lanes, GIVEN_OUTER, k)
        outer = raceway_contact(bearing, bearing.outer, given, ON_AXIS, 0.0, position, velocity, spin)
        put(lanes, ANGLE_OUT, k, get(lanes, ORBIT_ANGLE, k))
        put(lanes, ROLL_OUT, k, velocity[1] / position[0] - spin[2])
        put(lanes, COSINE, k, cosine)
        put(lanes, SINE, k, sine)
        _note(inner, INNER, lanes, k)
        _note(outer, OUTER, lanes, k)
        keep_spots(bearing.spot, inner, outer, about_z(cosine, -sine, place), position, lanes, k)


@lean_kernel
def _add_spots(spot, bearing, lanes):
    """Friction over the spots of every lane, where the bearing's `spot` is not empty."""
    if len(spot) > 0:
        find_means(spot, bearing, lanes)
        for k in range(LANES):
            inner, outer = kept_answer(0.0, lanes, INNER_SPOTS + k), kept_answer(0.0, lanes, OUTER_SPOTS + k)
            put_beside(lanes, DRILLING_OUT, 2, INNER, k, inner.drilling)
            put_beside(lanes, DRILLING_OUT, 2, OUTER, k, outer.drilling)
            put(lanes, DRILLINGS + INNER, k, inner.drilling)
            put(lanes, DRILLINGS + OUTER, k, outer.drilling)
            put_vector(lanes, LOCAL_FRICTIONS + 3 * INNER, k, inner.friction)
            put_vector(lanes, LOCAL_FRICTIONS + 3 * OUTER, k, outer.friction)


@inlined
def _turn_contact(side, cosine, sine, local, centre, lanes, k):
    """Turns a contact into fixed axes; force and torque on the ball about its centre, and on the ring about its own."""
    arm, normal = get_vector(lanes, LOCAL_ARMS + 3 * side, k), get_vector(lanes, LOCAL_NORMALS + 3 * side, k)
    friction, slip = get_vector(lanes, LOCAL_FRICTIONS + 3 * side, k), get_vector(lanes, LOCAL_SLIPS + 3 * side, k)
    drilling = scaled(get(lanes, DRILLINGS + side, k), normal)
    force = about_z(cosine, sine, add(scaled(-get(lanes, LOADS + side, k), normal), friction))
    torque = about_z(cosine, sine, add(cross(arm, friction), drilling))
    point = about_z(cosine, sine, add(local, arm))
    put_vector_beside(lanes, POINT_OUT, 6, 3 * side, k, point)
    put_vector_beside(lanes, NORMAL_OUT, 6, 3 * side, k, about_z(cosine, sine, scaled(-1.0, normal)))
    put_vector_beside(lanes, FRICTION_OUT, 6, 3 * side, k, about_z(cosine, sine, friction))
    put_vector_beside(lanes, SLIP_OUT, 6, 3 * side, k, about_z(cosine, sine, slip))
    reaction = add(cross(minus(point, centre), force), about_z(cosine, sine, drilling))
    return force, torque, scaled(-1.0, reaction)


@lean_kernel
def _turn(bearing, lanes):
    """Turns every lane from the ball's frame into fixed axes: first contacts, then balls, then orientations."""
    for k in range(LANES):
        cosine, sine, local = get(lanes, COSINE, k), get(lanes, SINE, k), lane_position(lanes, k)
        place, ring = ring_in_lane(bearing.ring, bearing.offset, lanes, k)
        inner, inner_torque, inner_reaction = _turn_contact(INNER, cosine, sine, local, place, lanes, k)
        outer, outer_torque, outer_reaction = _turn_contact(OUTER, cosine, sine, local, (0.0, 0.0, 0.0), lanes, k)
        put_vector(lanes, FORCES, k, add(inner, outer))
        put_vector(lanes, TORQUES, k, add(inner_torque, outer_torque))
        put_vector(lanes, INNER_FORCE, k, scaled(-1.0, inner))
        at = about_z(cosine, sine, local)
        put_vector(lanes, INNER_TORQUE, k, moment_on(ring, place, at, inner, inner_torque, inner_reaction))
        put_vector(lanes, OUTER_FORCE, k, scaled(-1.0, outer))
        put_vector(lanes, OUTER_TORQUE, k, outer_reaction)
        put(lanes, ELASTIC, k, get(lanes, ENERGIES + INNER, k) + get(lanes, ENERGIES + OUTER, k))
    for k in range(LANES):
        cosine, sine = get(lanes, COSINE, k), get(lanes, SINE, k)
        velocity, spin = get_vector(lanes, VELOCITY, k), get_vector(lanes, SPIN, k)
        position = about_z(cosine, sine, lane_position(lanes, k))
        motion = bearing.ball_mass * dot(velocity, velocity) + bearing.ball_inertia * dot(spin, spin)
        put_vector_beside(lanes, POSITION_OUT, 3, 0, k, position)
        put_vector_beside(lanes, VELOCITY_OUT, 3, 0, k, about_z(cosine, sine, velocity))
        put_vector_beside(lanes, SPIN_OUT, 3, 0, k, about_z(cosine, sine, spin))
        put_vector_beside(lanes, FORCE_OUT, 3, 0, k, get_vector(lanes, FORCES, k))
        put_vector_beside(lanes, TORQUE_OUT, 3, 0, k, get_vector(lanes, TORQUES, k))
        put(lanes, KINETIC, k, 0.5 * motion)
        put(lanes, POTENTIAL, k, -bearing.ball_mass * dot(bearing.gravity, position))
        put(lanes, WORK, k, get(lanes, DRIVE_WORK, k))
        put(lanes, LOST, k, get(lanes, DISSIPATED, k))
        put(lanes, GROSS, k, get(lanes, GROSS_WORK, k))
    for k in range(LANES):
        cosine, sine = cosine_sine(0.5 * get(lanes, ORBIT_ANGLE, k))
        quaternion = quaternion_product((0.0, 0.0, sine, cosine), get_quaternion(lanes, OWN_ORIENTATION, k))
        put_vector_beside(lanes, ORIENTATION_OUT, 4, 0, k, quaternion)
        put_beside(lanes, ORIENTATION_OUT, 4, 3, k, quaternion[3])


@inlined
def fill_outputs(bearing, lanes):
    """What every lane's ball gives out, from its state, its orientation and what its rates need."""
    give_coefficients(bearing, lanes)
    _contacts(bearing, lanes)
    _add_spots(bearing.spot, bearing, lanes)
    _turn(bearing, lanes)
