"""What one sample of an ellipsoid on a plane holds, computed from its state."""

import math

import numpy as np

from bearing_twin.base.sample import Channel, Columns, layout_of
from bearing_twin.compiled import kernel
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.kinds.ellipsoid.equations import COLUMNS, RUBBED, VISCOUS, Ellipsoid, pose_of, touch_of
from bearing_twin.kinds.ellipsoid.parameters import EllipsoidOnPlaneScene
from bearing_twin.numerics.rotation import dot

CHANNELS = (
    Channel("position", "m", (3,), "of the centre, fixed axes, z up from the plane"),
    Channel("orientation", "1", (4,), "unit quaternion (x, y, z, w) from the body's axes to the fixed ones"),
    Channel("velocity", "m/s", (3,), "of the centre"),
    Channel("angular_velocity", "rad/s", (3,), "in fixed axes"),
    Channel("angular_momentum", "kg m^2/s", (3,), "about the centre, in fixed axes"),
    Channel("approach", "m", (), "of the lowest point to the plane; negative = gap"),
    Channel("normal_load", "N", (), "on the body, upward, at contact_point"),
    Channel("friction_force", "N", (3,), "on the body, at contact_point"),
    Channel("drilling_torque", "N m", (), "friction of the spot on the body about z; zero for friction at a point"),
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
    """What one sample of this scene holds."""
    return CHANNELS


@kernel
def energies(body, state, lowest):
    """Kinetic, potential (zero with the centre at height `lowest` [m]) and elastic energy [J]."""
    pose = pose_of(body, state)
    velocity, momentum = (state[7], state[8], state[9]), (state[10], state[11], state[12])
    kinetic = 0.5 * (body.mass * dot(velocity, velocity) + dot(momentum, pose.spin))
    potential = body.mass * body.gravity * (state[2] - lowest)
    touch = touch_of(body, state, pose)
    return kinetic, potential, touch.elastic_energy


@kernel
def write_row(body, lowest, state, row):
    """Writes all channels of one state but the last, side by side in their order."""
    pose, norm = pose_of(body, state), 0.0
    touch = touch_of(body, state, pose)
    spot = ellipse(touch.curvature_small, touch.curvature_large, body.law.modulus, touch.normal_load)
    for i in range(3, 7):
        norm += state[i] * state[i]
    row[0], row[1], row[2] = state[0], state[1], state[2]
    for i in range(3, 7):
        row[i] = state[i] / math.sqrt(norm)
    for i in range(3):
        row[7 + i], row[10 + i], row[13 + i] = state[7 + i], pose.spin[i], state[10 + i]
    row[16], row[17] = touch.approach, touch.normal_load
    row[18], row[19], row[20], row[21] = touch.friction_x, touch.friction_y, 0.0, touch.drilling_torque
    for i in range(3):
        row[22 + i] = state[i] + touch.arm[i]
        row[28 + i] = touch.major_axis[i]
    row[25], row[26], row[27] = touch.slip_x, touch.slip_y, 0.0
    row[31], row[32], row[33] = spot.semi_major, spot.semi_minor, spot.peak_pressure
    row[34] = 1.0 if touch.approach > 0.0 else 0.0
    row[35], row[36], row[37] = energies(body, state, lowest)
    row[38], row[39] = state[VISCOUS], state[RUBBED]


@kernel
def write_rows(body, lowest, states, rows):
    """As `write_row` for states (n, COLUMNS) into rows (n, width)."""
    for n in range(len(states)):
        write_row(body, lowest, states[n], rows[n])


def outputs_of(body: Ellipsoid, states: np.ndarray, drift: float) -> Columns:
    """All channels of states (n, COLUMNS); `drift` is the last."""
    rows = np.empty((len(states), LAYOUT.width))
    write_rows(body, min(body.semi_axes), states.reshape(-1, COLUMNS), rows)
    rows[:, -1] = drift
    return Columns(LAYOUT, rows)
