"""One contact of a ball with a raceway in plain Python, from the formulas alone: what the compiled core is held to.

All vectors in the ball's frame, positions from the bearing's centre; a ring whose axis stays z. The force is on the
ball, half the approach inside its surface.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.contact.friction import FrictionLoads, patch_by
from bearing_twin.shapes import ball_in_groove


class RacewayContact(NamedTuple):
    """A contact; `spin_moment` [N m] is that of friction on the ball about `normal`, from the ball to the raceway."""

    approach: float
    approach_rate: float
    normal_load: float
    energy: float
    curvature_small: float
    curvature_large: float
    normal: np.ndarray
    arm: np.ndarray
    slip: np.ndarray
    spin_rate: float
    friction: np.ndarray
    spin_moment: float
    force: np.ndarray
    torque: np.ndarray
    drive_power: float
    axial_moment: float
    dissipation: float


def friction_by(
    name, normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation
) -> FrictionLoads:
    """Friction by the model of that name, as `Patch.friction`."""
    motion = slip_major, slip_minor, spin
    return patch_by(name, coefficient).friction(normal_load, semi_major, semi_minor, *motion, regularisation)


def about_z(cosine, sine, vector):
    """The vector turned about z by the angle of this cosine and sine."""
    x, y, z = vector
    return np.array([cosine * x - sine * y, sine * x + cosine * y, z])


def along_groove(terms, radial):
    """A bearing's polynomial where the contact's normal has this radial part."""
    return np.polynomial.polynomial.polyval(max(abs(radial) - 1.0, terms[-1]), terms[:-1])


def single_contact(bearing, raceway, centre, ring_speed, position, velocity, spin):
    """The contact with a raceway whose ring has its centre at `centre` and turns at `ring_speed`; friction at a point.

    Where friction is over the patch, there is none: `with_patch` adds it.
    """
    offset, velocity, spin = np.subtract(position, centre), np.asarray(velocity, float), np.asarray(spin, float)
    distance = np.hypot(offset[0], offset[1])
    where = ball_in_groove(distance, offset[2], bearing.ball_radius, raceway.locus_radius, raceway.groove_radius)
    in_plane = where.normal_radial / distance
    normal = np.array([in_plane * offset[0], in_plane * offset[1], where.normal_axial])
    arm = (bearing.ball_radius - 0.5 * where.approach) * normal
    point = offset + arm
    surface = ring_speed * np.array([-point[1], point[0], 0.0])
    relative = velocity + np.cross(spin, arm) - surface
    rate = relative @ normal
    slip = relative - rate * normal

    depth, power = max(where.approach, 0.0), raceway.law.power
    coefficient = along_groove(raceway.terms, where.normal_radial)
    elastic = coefficient * depth**power
    stiffness = power * coefficient * depth ** (power - 1.0) if depth > 0.0 else 0.0
    viscous = bearing.damping * elastic + bearing.relaxation_time * stiffness
    load = max(elastic + viscous * rate, 0.0)
    resistance = bearing.raceway_friction * load / np.sqrt(slip @ slip + bearing.friction_regularisation**2)
    friction = -resistance * slip
    force = friction - load * normal
    return RacewayContact(
        where.approach, rate, load, elastic * depth / (power + 1.0), where.curvature_small, where.curvature_large,
        normal, arm, slip, spin @ normal - ring_speed * normal[2], friction, 0.0, force, np.cross(arm, friction),
        force @ surface, point[0] * force[1] - point[1] * force[0],
        resistance * (slip @ slip) + (load - elastic) * rate,
    )  # fmt: skip


def with_patch(bearing, side, centre, ring_speed, position, contact):
    """The contact on the inner (0) or outer (1) raceway, with friction over its patch where the bearing has it."""
    if not bearing.patch:
        return contact
    coefficient, model, *axes = bearing.patch
    offset, normal = np.subtract(position, centre), np.asarray(contact.normal)
    out = np.array([offset[0], offset[1], 0.0]) / np.hypot(offset[0], offset[1])
    minor = np.cross([0.0, 0.0, 1.0], out)  # along the ring's circumference
    major = np.cross(minor, normal)
    radial, root = normal @ out, np.sqrt(max(contact.approach, 0.0))
    semi = [root * along_groove(terms, radial) for terms in axes[side]]
    slip = np.asarray(contact.slip) @ major, np.asarray(contact.slip) @ minor
    limit = coefficient * contact.normal_load
    found = friction_by(model, limit, *semi, *slip, contact.spin_rate, 1.0, bearing.friction_regularisation)
    friction = found.force_major * major + found.force_minor * minor
    point = offset + contact.arm
    surface = ring_speed * np.array([-point[1], point[0], 0.0])
    power = friction @ surface + found.torque * ring_speed * normal[2]
    loss = -(found.force_major * slip[0] + found.force_minor * slip[1] + found.torque * contact.spin_rate)
    return contact._replace(
        friction=friction,
        spin_moment=found.torque,
        force=contact.force + friction,
        torque=np.cross(contact.arm, friction) + found.torque * normal,
        drive_power=contact.drive_power + power,
        dissipation=contact.dissipation + loss,
    )
