"""The channels of a bearing run from equilibria: the same names and meanings as when the balls move by themselves."""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.quasi_static.opening import leaning, opening_of
from bearing_twin.numerics.rotation import about_z, add, cross, dot, minus, scaled

LEFT = 1e-12  # of the loads, or of their moments: sums of forces that are less are what the solution leaves of nothing


@inlined
def _set(array, row, k, vector):
    for axis in range(3):
        array[row, k, axis] = vector[axis]


@inlined
def _set_side(array, row, k, side, vector):
    for axis in range(3):
        array[row, k, side, axis] = vector[axis]


@inlined
def _add(array, row, vector, sign):
    for axis in range(3):
        array[row, axis] += sign * vector[axis]


@inlined
def _settle(array, row, scale):
    """Makes numbers 0 that are nothing beside what was added up to them."""
    for axis in range(3):
        if abs(array[row, axis]) <= LEFT * scale:
            array[row, axis] = 0.0


@inlined
def _settle_ball(array, row, k, scale):
    for axis in range(3):
        if abs(array[row, k, axis]) <= LEFT * scale:
            array[row, k, axis] = 0.0


@inlined
def _write_contact(setting, found, out, row, k, side, cosine, sine, lean, position, velocity, spin, centre, ring_speed):
    """Writes one contact; returns the force on the ball and its arm, in `bearing_link`.

    `lean` is how far the pull of the groove's centre points along the orbit.
    """
    contacts = found.contacts
    load, approach = contacts.load[row, k, side], contacts.approach[row, k, side]
    sign = -1.0 if side == 0 else 1.0
    angle = contacts.angle[row, k, side]
    n_r, n_z = math.cos(angle), math.sin(angle)
    towards = scaled(sign / math.sqrt(1.0 + lean * lean), (n_r, lean, n_z))
    outward = about_z(cosine, sine, towards)  # from the ball to the raceway
    across = contacts.friction[row, k, side]
    friction = about_z(cosine, sine, (-across * n_z, contacts.along[row, k, side], across * n_r))
    arm = scaled(setting.ball_radius - 0.5 * approach, outward)
    point = add(position, arm)
    about = minus(point, centre)
    relative = minus(add(velocity, cross(spin, arm)), (-ring_speed * about[1], ring_speed * about[0], 0.0))
    out.approach[row, k, side] = approach
    out.normal_load[row, k, side] = load
    out.contact_angle[row, k, side] = angle
    out.curvature_small[row, k, side] = contacts.curvature_small[row, k, side]
    out.curvature_large[row, k, side] = contacts.curvature_large[row, k, side]
    out.spin_rate[row, k, side] = dot(spin, outward) - ring_speed * outward[2]
    _set_side(out.point, row, k, side, point)
    _set_side(out.normal, row, k, side, scaled(-1.0, outward))
    _set_side(out.friction_force, row, k, side, friction)
    _set_side(out.slip, row, k, side, minus(relative, scaled(dot(relative, outward), outward)))
    out.elastic_energy[row] += load * max(approach, 0.0) / (setting.inner.law.power + 1.0)
    return add(scaled(-load, outward), friction), arm


@inlined
def _write_ball(setting, gravity, found, out, row, k, angle, ring_speed, centre):
    """Writes ball k and its contacts; adds its share of the outer ring's loads and of the energies."""
    contacts, orbit = found.contacts, found.orbit[row]
    cosine, sine = math.cos(angle), math.sin(angle)
    distance = setting.outer.locus_radius + found.place[row, k, 0]
    position = about_z(cosine, sine, (distance, 0.0, found.place[row, k, 1]))
    velocity = about_z(cosine, sine, (0.0, distance * orbit, 0.0))
    roll = contacts.roll[row, k]
    spin = about_z(cosine, sine, (contacts.pitch[row, k], 0.0, orbit - roll))
    middle = (0.0, 0.0, 0.0)
    lean = leaning(opening_of(setting, cosine, sine, found.q[row]), contacts.angle[row, k, 0])
    inner, inner_arm = _write_contact(
        setting, found, out, row, k, 0, cosine, sine, lean, position, velocity, spin, centre, ring_speed
    )
    outer, outer_arm = _write_contact(
        setting, found, out, row, k, 1, cosine, sine, 0.0, position, velocity, spin, middle, 0.0
    )
    out.orbit_angle[row, k], out.roll_rate[row, k] = angle, roll
    _set(out.position, row, k, position)
    _set(out.velocity, row, k, velocity)
    _set(out.angular_velocity, row, k, spin)
    _set(out.raceway_force, row, k, add(inner, outer))
    _set(out.raceway_torque, row, k, add(cross(inner_arm, inner), cross(outer_arm, outer)))
    pressed = contacts.load[row, k, 0] + contacts.load[row, k, 1]
    _settle_ball(out.raceway_force, row, k, pressed)
    _settle_ball(out.raceway_torque, row, k, setting.ball_radius * pressed)
    for part in range(4):
        out.orientation[row, k, part] = found.attitude[row, k, part]
    _add(out.outer_ring_force, row, outer, -1.0)
    _add(out.outer_ring_torque, row, cross(add(position, outer_arm), outer), -1.0)
    mass, radius = setting.ball_mass, setting.ball_radius
    out.kinetic_energy[row] += 0.5 * mass * (dot(velocity, velocity) + 0.4 * radius * radius * dot(spin, spin))
    out.potential_energy[row] -= mass * dot(gravity, position)


@kernel
def write_channels(setting, gravity, found, speeds, angles, out):
    """Fills `out` (`outputs.Outputs`) from `found` (`chunk.Instants`), the ring at `speeds` [rad/s] and `angles` [rad].

    Sums of forces and moments that come to nothing are 0. Friction is that across the grooves; slip is that of balls in
    one cage, which bears what the inner contacts of a ring that is off the axis push along the orbit. Works and losses
    are left at 0.
    """
    balls = out.orbit_angle.shape[1]
    for row in range(len(speeds)):
        centre = (found.q[row, 0], found.q[row, 1], found.q[row, 2])
        for k in range(balls):
            angle = found.azimuth[row] + 2.0 * math.pi * k / balls
            _write_ball(setting, gravity, found, out, row, k, angle, speeds[row], centre)
        for k in range(balls):
            if balls > 1:
                square = 0.0
                for axis in range(3):
                    between = out.position[row, (k + 1) % balls, axis] - out.position[row, k, axis]
                    square += between * between
                out.neighbour_approach[row, k] = 2.0 * setting.ball_radius - math.sqrt(square)
        out.inner_ring_angle[row], out.inner_ring_speed[row] = angles[row], speeds[row]
        for axis in range(3):
            out.inner_ring_offset[row, axis] = centre[axis]
            out.inner_ring_force[row, axis] = -found.load[row, axis]
        out.cage_angle[row], out.cage_speed[row] = found.azimuth[row], found.orbit[row]
        for axis in range(2):
            out.inner_ring_tilt[row, axis] = found.q[row, 3 + axis]
            out.inner_ring_torque[row, axis] = -found.load[row, 3 + axis]
        carried = 0.0
        for k in range(balls):
            carried += found.contacts.load[row, k, 0] + found.contacts.load[row, k, 1]
        lever = 0.5 * setting.pitch_diameter
        _settle(out.inner_ring_force, row, carried)
        _settle(out.inner_ring_torque, row, lever * carried)
        _settle(out.outer_ring_force, row, carried)
        _settle(out.outer_ring_torque, row, lever * carried)
