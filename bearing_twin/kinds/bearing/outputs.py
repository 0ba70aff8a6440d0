"""What a bearing scene gives out: its channels, the wrenches, and the contact ellipses of published samples."""

import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.equations import (
    ball_position,
    ball_vector,
    in_ball_frame,
    inner_contact,
    meeting,
    outer_contact,
    pair_contact,
    touchable,
)
from bearing_twin.kinds.bearing.layout import DISSIPATED, DRIVE_WORK, GROSS_WORK, ORBIT_ANGLE, SPIN, VELOCITY
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.spot import with_spot
from bearing_twin.numerics.rotation import about_z, add, cross, dot, minus, quaternion_product, scaled
from bearing_twin.sample import Channel, Sample

INNER, OUTER = 0, 1


class Outputs(NamedTuple):
    """One array a channel, first axis = solver output; the fields are the channels of `channels`, in order."""

    orbit_angle: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    orientation: np.ndarray
    angular_velocity: np.ndarray
    roll_rate: np.ndarray
    raceway_force: np.ndarray
    raceway_torque: np.ndarray
    approach: np.ndarray
    normal_load: np.ndarray
    contact_angle: np.ndarray
    spin_rate: np.ndarray
    curvature_small: np.ndarray
    curvature_large: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    friction_force: np.ndarray
    slip: np.ndarray
    drilling_torque: np.ndarray
    inner_ring_angle: np.ndarray
    inner_ring_speed: np.ndarray
    inner_ring_offset: np.ndarray
    inner_ring_force: np.ndarray
    inner_ring_torque: np.ndarray
    outer_ring_force: np.ndarray
    outer_ring_torque: np.ndarray
    kinetic_energy: np.ndarray
    elastic_energy: np.ndarray
    potential_energy: np.ndarray
    drive_work: np.ndarray
    dissipated: np.ndarray
    gross_work: np.ndarray
    neighbour_approach: np.ndarray
    neighbour_load: np.ndarray
    neighbour_point: np.ndarray
    neighbour_normal: np.ndarray
    neighbour_friction: np.ndarray


@functools.cache
def channels(parameters: BearingScene) -> tuple[Channel, ...]:
    """The channels of a bearing with N balls; vectors in `bearing_link`, contact rows ball x (inner, outer)."""
    n = parameters.geometry.balls
    rows = (
        Channel("orbit_angle", "rad", (n,), "position of each ball around the axis, not wrapped"),
        Channel("position", "m", (n, 3), "ball centres"),
        Channel("velocity", "m/s", (n, 3), "of the ball centres"),
        Channel("orientation", "1", (n, 4), "quaternion x, y, z, w of the ball's axes"),
        Channel("angular_velocity", "rad/s", (n, 3), "of the balls"),
        Channel("roll_rate", "rad/s", (n,), "ball about its centre, relative to its orbit, about -z"),
        Channel("raceway_force", "N", (n, 3), "on the ball by both raceways"),
        Channel("raceway_torque", "N m", (n, 3), "on the ball by both raceways, about its centre"),
        Channel("approach", "m", (n, 2), "mutual approach, > 0 in contact"),
        Channel("normal_load", "N", (n, 2), "elastic and viscous part together, >= 0"),
        Channel(
            "contact_angle", "rad", (n, 2), "of the contact seen from the ball, against the radial plane, > 0 to +z"
        ),
        Channel("spin_rate", "rad/s", (n, 2), "ball minus ring, about the line from the ball's centre to the contact"),
        Channel("curvature_small", "1/m", (n, 2), "of the gap, P in z = P x^2 + Q y^2"),
        Channel("curvature_large", "1/m", (n, 2), "of the gap, Q in z = P x^2 + Q y^2"),
        Channel("point", "m", (n, 2, 3), "contact point"),
        Channel("normal", "1", (n, 2, 3), "direction of the normal load on the ball"),
        Channel("friction_force", "N", (n, 2, 3), "on the ball"),
        Channel("slip", "m/s", (n, 2, 3), "ball's surface relative to the raceway"),
        Channel("drilling_torque", "N m", (n, 2), "friction on the ball about the line from its centre to the contact"),
        Channel("inner_ring_angle", "rad", (), "not wrapped"),
        Channel("inner_ring_speed", "rad/s", (), "about +z"),
        Channel("inner_ring_offset", "m", (3,), "displacement of the inner ring's centre"),
        Channel("inner_ring_force", "N", (3,), "on the inner ring by the balls"),
        Channel("inner_ring_torque", "N m", (3,), "on the inner ring by the balls, about its centre"),
        Channel("outer_ring_force", "N", (3,), "on the outer ring by the balls"),
        Channel("outer_ring_torque", "N m", (3,), "on the outer ring by the balls, about its centre"),
        Channel("kinetic_energy", "J", (), "of all balls"),
        Channel("elastic_energy", "J", (), "of all contacts"),
        Channel("potential_energy", "J", (), "of gravity, zero at the bearing's centre"),
        Channel("drive_work", "J", (), "done on the balls by the inner ring since the start"),
        Channel("dissipated", "J", (), "by friction and contact damping since the start"),
        Channel("gross_work", "J", (), "as drive_work, the power at each contact counted by its magnitude"),
        Channel("neighbour_approach", "m", (n,), "of each ball and the next ahead, > 0 in contact; 0 where none is"),
        Channel("neighbour_load", "N", (n,), "normal load between each ball and the next ahead, >= 0"),
        Channel("neighbour_point", "m", (n, 3), "contact point of each ball with the next ahead; zeros when apart"),
        Channel("neighbour_normal", "1", (n, 3), "direction of that load on the ball; zeros when apart"),
        Channel("neighbour_friction", "N", (n, 3), "friction on the ball by the next ahead"),
    )
    if tuple(row.name for row in rows) != Outputs._fields:
        raise AssertionError("channels and Outputs name different quantities")
    return rows


def empty_outputs(parameters: BearingScene, count: int) -> Outputs:
    """Room for `count` solver outputs."""
    return Outputs(*(np.zeros((count, *channel.shape)) for channel in channels(parameters)))


@inlined
def _store(array, row, k, side, vector):
    for axis in range(3):
        array[row, k, side, axis] = vector[axis]


@inlined
def _write_contact(out, row, k, side, contact, position, cosine, sine):
    out.approach[row, k, side] = contact.approach
    out.normal_load[row, k, side] = contact.normal_load
    out.spin_rate[row, k, side] = contact.spin_rate
    out.drilling_torque[row, k, side] = contact.drilling
    out.curvature_small[row, k, side] = contact.curvature_small
    out.curvature_large[row, k, side] = contact.curvature_large
    normal = contact.normal
    out.contact_angle[row, k, side] = math.atan2(normal[2], math.sqrt(normal[0] ** 2 + normal[1] ** 2))
    _store(out.point, row, k, side, about_z(cosine, sine, add(position, contact.arm)))
    _store(out.normal, row, k, side, about_z(cosine, sine, scaled(-1.0, normal)))
    _store(out.friction_force, row, k, side, about_z(cosine, sine, contact.friction))
    _store(out.slip, row, k, side, about_z(cosine, sine, contact.slip))


@inlined
def _react(force_sum, torque_sum, row, centre, point, force, drilling):
    """Adds the reaction to `force` at `point` and torque `drilling` on a ball to a ring's, about its centre."""
    torque = add(cross(minus(point, centre), force), drilling)
    for axis in range(3):
        force_sum[row, axis] -= force[axis]
        torque_sum[row, axis] -= torque[axis]


@inlined
def _write_neighbour(out, row, k, pair, position, cosine, sine):
    """Writes the contact of ball k with the next ahead."""
    point = about_z(cosine, sine, add(position, pair.arm))
    normal = about_z(cosine, sine, scaled(-1.0, pair.normal))
    friction = about_z(cosine, sine, pair.friction)
    out.neighbour_load[row, k] = pair.normal_load
    for axis in range(3):
        out.neighbour_point[row, k, axis] = point[axis]
        out.neighbour_normal[row, k, axis] = normal[axis]
        out.neighbour_friction[row, k, axis] = friction[axis]


@inlined
def _write_ball(bearing, near, inner_centre, inner_speed, state, k, orientation, out, row):
    """Writes ball k and its two contacts; adds its share of energies and ring reactions."""
    local, centre = ball_position(state, k), in_ball_frame(state, k, inner_centre)
    inner = inner_contact(bearing, centre, inner_speed, state, k)
    inner = with_spot(bearing.spot, bearing, centre, inner_speed, local, inner)
    outer = outer_contact(bearing, state, k)
    outer = with_spot(bearing.spot, bearing, (0.0, 0.0, 0.0), 0.0, local, outer)
    angle = state[k, ORBIT_ANGLE]
    cosine, sine = math.cos(angle), math.sin(angle)
    velocity, spin = ball_vector(state, k, VELOCITY), ball_vector(state, k, SPIN)
    orbit_rate = velocity[1] / local[0]
    position = about_z(cosine, sine, local)
    fixed_velocity, fixed_spin = about_z(cosine, sine, velocity), about_z(cosine, sine, spin)
    inner_force, outer_force = about_z(cosine, sine, inner.force), about_z(cosine, sine, outer.force)
    torque = about_z(cosine, sine, add(inner.torque, outer.torque))
    turn = (0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle))
    own = (orientation[k, 0], orientation[k, 1], orientation[k, 2], orientation[k, 3])
    quaternion = quaternion_product(turn, own)
    out.orbit_angle[row, k] = angle
    for axis in range(3):
        out.position[row, k, axis] = position[axis]
        out.velocity[row, k, axis] = fixed_velocity[axis]
        out.angular_velocity[row, k, axis] = fixed_spin[axis]
        out.raceway_force[row, k, axis] = inner_force[axis] + outer_force[axis]
        out.raceway_torque[row, k, axis] = torque[axis]
    for part in range(4):
        out.orientation[row, k, part] = quaternion[part]
    out.roll_rate[row, k] = orbit_rate - spin[2]
    _write_contact(out, row, k, INNER, inner, local, cosine, sine)
    _write_contact(out, row, k, OUTER, outer, local, cosine, sine)
    inner_point = about_z(cosine, sine, add(local, inner.arm))
    outer_point = about_z(cosine, sine, add(local, outer.arm))
    inner_drilling = about_z(cosine, sine, scaled(inner.drilling, inner.normal))
    outer_drilling = about_z(cosine, sine, scaled(outer.drilling, outer.normal))
    middle = (0.0, 0.0, 0.0)
    _react(out.inner_ring_force, out.inner_ring_torque, row, inner_centre, inner_point, inner_force, inner_drilling)
    _react(out.outer_ring_force, out.outer_ring_torque, row, middle, outer_point, outer_force, outer_drilling)
    energy = inner.energy + outer.energy
    if touchable(bearing, near, k, 1):
        pair = pair_contact(bearing, state, k, 1)
        energy += pair.energy
        _write_neighbour(out, row, k, pair, local, cosine, sine)
    if touchable(bearing, near, k, -1):
        energy += pair_contact(bearing, state, k, -1).energy
    out.elastic_energy[row] += energy
    out.kinetic_energy[row] += 0.5 * (
        bearing.ball_mass * dot(velocity, velocity) + bearing.ball_inertia * dot(spin, spin)
    )
    out.potential_energy[row] -= bearing.ball_mass * dot(bearing.gravity, position)
    out.drive_work[row] += state[k, DRIVE_WORK]
    out.dissipated[row] += state[k, DISSIPATED]
    out.gross_work[row] += state[k, GROSS_WORK]


@kernel
def write_outputs(bearing, drive, times, states, orientations, out, first):
    """Fills `out` from row `first` with the states (count, N, columns) and orientations (count, N, 4) at `times` [s].

    `times` count from the instant the drive's angle and speed belong to. Sums start from zero in each row.
    """
    near = np.zeros(bearing.balls, np.bool_)
    for sample in range(len(times)):
        row = first + sample
        for k in range(bearing.balls):
            gap, _ = meeting(bearing, states[sample], k)
            near[k] = gap < 0.0
            out.neighbour_approach[row, k] = -gap if gap < math.inf else 0.0
        time = times[sample]
        speed = drive.speed + drive.acceleration * time
        out.inner_ring_speed[row] = speed
        out.inner_ring_angle[row] = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time)
        for axis in range(3):
            out.inner_ring_offset[row, axis] = bearing.offset[axis]
        for k in range(bearing.balls):
            _write_ball(bearing, near, bearing.offset, speed, states[sample], k, orientations[sample], out, row)


@kernel
def _ellipses(moduli, small, large, load, semi_major, semi_minor, pressure):
    for k in range(load.shape[0]):
        for side in range(2):
            if load[k, side] > 0.0:
                found = ellipse(small[k, side], large[k, side], moduli[side], load[k, side])
                semi_major[k, side] = found.semi_major
                semi_minor[k, side] = found.semi_minor
                pressure[k, side] = found.peak_pressure


def ellipses(moduli, small, large, load) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Semi-axes [m] and peak pressures [Pa], each (N, 2), of contacts (ball, raceway); `moduli` are the races' E*."""
    found = np.zeros_like(load), np.zeros_like(load), np.zeros_like(load)
    _ellipses(moduli, small, large, load, *found)
    return found


def contact_details(parameters: BearingScene, sample: Sample) -> dict[str, np.ndarray]:
    """`in_contact` (N, 2), `semi_major`, `semi_minor` [m], `peak_pressure` [Pa] (N, 2) and `major_axis` (N, 2, 3).

    By Hertz from curvatures and normal load, whatever the elastic law. The major axis lies in the meridian plane,
    across the groove; computed only for samples that are published.
    """
    load = sample["normal_load"]
    materials = parameters.materials
    moduli = (
        effective_modulus(materials.ball, materials.inner_ring),
        effective_modulus(materials.ball, materials.outer_ring),
    )
    semi_major, semi_minor, pressure = ellipses(moduli, sample["curvature_small"], sample["curvature_large"], load)
    normal = sample["normal"]
    axis = np.array([0.0, 0.0, 1.0]) - normal[..., 2:] * normal
    return {
        "in_contact": sample["approach"] > 0.0,
        "semi_major": semi_major,
        "semi_minor": semi_minor,
        "peak_pressure": pressure,
        "major_axis": axis / np.linalg.norm(axis, axis=-1, keepdims=True),
    }
