"""The channels of a bearing run from equilibria: the same names and meanings as when the balls move by themselves."""

import numpy as np

from bearing_twin.kinds.bearing.outputs import Outputs, empty_outputs, outputs_of
from bearing_twin.kinds.bearing.quasi_static.chunk import Course, Instants
from bearing_twin.kinds.bearing.quasi_static.forces import Setting

RINGS = ("inner", "outer")


def _vectors(azimuth):
    """Unit vectors (T, N, 3) of every ball: radial, tangential, axial."""
    c, s, zero = np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)
    return np.stack([c, s, zero], -1), np.stack([-s, c, zero], -1), np.stack([zero, zero, zero + 1.0], -1)


def _column(values):
    return values[..., None]


def channels_of(parameters, setting: Setting, course: Course, angle: np.ndarray, found: Instants) -> Outputs:
    """The channels at the instants `found`; `angle` [rad] (T,) is the inner ring's. Works and losses are left at 0.

    Friction carries the gyroscopic moment alone. Slip is that of balls in one cage on both raceways.
    """
    count, balls = found.place.shape[:2]
    matrix, contacts = empty_outputs(parameters, count), found.contacts
    matrix[:] = 0.0
    out = outputs_of(parameters, matrix)
    azimuth = found.azimuth[:, None] + 2.0 * np.pi * np.arange(balls) / balls
    radial, across, axial = _vectors(azimuth)
    distance, height = setting.outer.locus_radius + found.place[..., 0], found.place[..., 1]
    orbit, speed = found.orbit[:, None], course.speed[:, None]
    out.orbit_angle[:] = azimuth
    out.position[:] = _column(distance) * radial + _column(height) * axial
    out.velocity[:] = _column(distance * orbit) * across
    out.orientation[:] = found.attitude
    out.angular_velocity[:] = _column(contacts.pitch) * radial + _column(orbit - contacts.roll) * axial
    out.roll_rate[:] = contacts.roll
    for name in ("approach", "curvature_small", "curvature_large"):
        getattr(out, name)[:] = getattr(contacts, name)
    out.normal_load[:] = contacts.load
    out.inner_ring_offset[:] = found.q[:, :3]
    ring_spins = (_column(speed) * axial, 0.0 * axial)
    centres = (found.q[:, None, :3], 0.0)
    forces = []
    for side, sign in ((0, -1.0), (1, 1.0)):
        c, s = np.cos(contacts.angle[..., side]), np.sin(contacts.angle[..., side])
        outward = sign * (_column(c) * radial + _column(s) * axial)  # from the ball to the raceway
        along = _column(-s) * radial + _column(c) * axial
        arm = _column(setting.ball_radius - 0.5 * contacts.approach[..., side]) * outward
        point, normal = out.position + arm, -outward
        friction = _column(contacts.friction[..., side]) * along
        ring = np.cross(ring_spins[side], point - centres[side])
        relative = out.velocity + np.cross(out.angular_velocity, arm) - ring
        out.point[:, :, side], out.normal[:, :, side], out.friction_force[:, :, side] = point, normal, friction
        out.slip[:, :, side] = relative - _column((relative * outward).sum(-1)) * outward
        out.spin_rate[:, :, side] = ((out.angular_velocity - ring_spins[side]) * outward).sum(-1)
        out.contact_angle[:, :, side] = sign * contacts.angle[..., side]
        forces.append(_column(contacts.load[..., side]) * normal + friction)
        out.raceway_torque[:] += np.cross(arm, friction)
    out.raceway_force[:] = forces[0] + forces[1]
    out.inner_ring_angle[:], out.inner_ring_speed[:] = angle, course.speed
    out.inner_ring_force[:], out.inner_ring_torque[:, :2] = -found.load[:, :3], -found.load[:, 3:]
    out.outer_ring_force[:] = -forces[1].sum(axis=1)
    out.outer_ring_torque[:] = -np.cross(out.point[:, :, 1], forces[1]).sum(axis=1)
    _write_energies(parameters, setting, out)
    if balls > 1:
        gap = np.linalg.norm(np.roll(out.position, -1, axis=1) - out.position, axis=-1) - 2.0 * setting.ball_radius
        out.neighbour_approach[:] = -gap
    return out


def _write_energies(parameters, setting, out) -> None:
    mass = setting.ball_mass
    inertia = 0.4 * mass * setting.ball_radius**2
    square = mass * (out.velocity**2).sum(-1) + inertia * (out.angular_velocity**2).sum(-1)
    out.kinetic_energy[:] = 0.5 * square.sum(-1)
    power = setting.inner.law.power
    out.elastic_energy[:] = (out.normal_load * np.maximum(out.approach, 0.0)).sum((1, 2)) / (power + 1.0)
    out.potential_energy[:] = -mass * (out.position @ np.asarray(parameters.gravity)).sum(-1)
