"""Channels of an ellipsoid on a plane, computed from its state."""

import numpy as np

from bearing_twin.base.sample import Channel, Columns, layout_of
from bearing_twin.kinds.bouncing import CoreBodies
from bearing_twin.kinds.ellipsoid.compiled import write_outputs
from bearing_twin.kinds.ellipsoid.parameters import EllipsoidOnPlaneScene

CHANNELS = (
    Channel("position", "m", (3,), "of the centre, fixed axes, z up from the plane"),
    Channel("orientation", "1", (4,), "unit quaternion (x, y, z, w) from the body's axes to the fixed ones"),
    Channel("velocity", "m/s", (3,), "of the centre"),
    Channel("angular_velocity", "rad/s", (3,), "in fixed axes"),
    Channel("angular_momentum", "kg m^2/s", (3,), "about the centre, in fixed axes"),
    Channel("approach", "m", (), "of the lowest point to the plane; negative = gap"),
    Channel("normal_load", "N", (), "on the body, upward, at contact_point"),
    Channel("friction_force", "N", (3,), "on the body, at contact_point"),
    Channel("drilling_torque", "N m", (), "spin friction moment on the body about z; zero for friction at a point"),
    Channel("contact_point", "m", (3,), "where the forces act; below the body while there is a gap"),
    Channel("slip", "m/s", (3,), "velocity of the body there along the plane"),
    Channel("major_axis", "1", (3,), "direction of the longer axis of the contact ellipse"),
    Channel("semi_major", "m", (), "of the contact ellipse; zero without load"),
    Channel("semi_minor", "m", (), "of the contact ellipse; zero without load"),
    Channel("peak_pressure", "Pa", (), "at the middle of the contact ellipse"),
    Channel("in_contact", "1", (), "1 where the approach is above zero, else 0"),
    Channel("kinetic_energy", "J", (), "of the centre's motion and of the turning about it"),
    Channel("potential_energy", "J", (), "zero where the centre is as low as an undeformed body can be"),
    Channel("elastic_energy", "J", (), "stored in the contact"),
    Channel("dissipated_viscous", "J", (), "by the viscous part of the normal load since the start"),
    Channel("dissipated_friction", "J", (), "by friction since the start"),
    Channel(
        "quaternion_drift", "1", (), "greatest drift of the quaternion's norm in a step so far, before it is undone"
    ),
)
LAYOUT = layout_of(CHANNELS)


def channels(parameters: EllipsoidOnPlaneScene) -> tuple[Channel, ...]:
    """Channels of a sample of this scene."""
    return CHANNELS


def outputs_of(body: CoreBodies, states: np.ndarray, drift: float) -> Columns:
    """All channels of states (n, COLUMNS); `drift` is the last."""
    rows = np.empty((len(states), LAYOUT.width))
    write_outputs(*body, len(states), np.ascontiguousarray(states), LAYOUT.width, rows)
    rows[:, -1] = drift
    return Columns(LAYOUT, rows)
