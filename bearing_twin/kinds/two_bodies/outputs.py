"""What one sample of two bodies holds, computed from their state."""

import numpy as np

from bearing_twin.base.sample import Channel, Columns, layout_of
from bearing_twin.kinds.bouncing import CoreBodies
from bearing_twin.kinds.two_bodies.compiled import write_outputs
from bearing_twin.kinds.two_bodies.parameters import TwoBodiesScene


def _of_body(prefix: str, which: str) -> tuple[Channel, ...]:
    return (
        Channel(f"{prefix}position", "m", (3,), f"of the {which} body's centre, fixed axes"),
        Channel(f"{prefix}orientation", "1", (4,), f"unit quaternion (x, y, z, w) of the {which} body's axes"),
        Channel(f"{prefix}velocity", "m/s", (3,), f"of the {which} body's centre"),
        Channel(f"{prefix}angular_velocity", "rad/s", (3,), f"of the {which} body, in fixed axes"),
        Channel(f"{prefix}angular_momentum", "kg m^2/s", (3,), f"of the {which} body about its centre; 0 if held"),
    )


CHANNELS = (
    *_of_body("", "first"),
    *_of_body("second_", "second"),
    Channel("approach", "m", (), "of the opposing points; negative = gap"),
    Channel("normal_load", "N", (), "on the first body, against normal, at contact_point"),
    Channel("friction_force", "N", (3,), "on the first body, at contact_point"),
    Channel("drilling_torque", "N m", (), "friction of the spot on the first body about normal"),
    Channel("spin_rate", "rad/s", (), "first body minus second, about normal"),
    Channel("contact_point", "m", (3,), "where the forces act; between the bodies while there is a gap"),
    Channel("normal", "1", (3,), "outward of the first body at its opposing point"),
    Channel("slip", "m/s", (3,), "velocity of the first body against the second there, across the normal"),
    Channel("major_axis", "1", (3,), "direction of the longer axis of the contact"),
    Channel(
        "semi_major", "m", (), "of the contact ellipse; of an overlap its half-width over the root of 2, as of a circle"
    ),
    Channel("semi_minor", "m", (), "the same across; both are zero without load"),
    Channel("peak_pressure", "Pa", (), "by Hertz; of an overlap three times the load over its area, as of a circle"),
    Channel("curvature_small", "1/m", (), "of the gap, P in z = P x^2 + Q y^2; zero where it is flat"),
    Channel("curvature_large", "1/m", (), "of the gap, Q in z = P x^2 + Q y^2"),
    Channel("in_contact", "1", (), "1 where the approach is above zero, else 0"),
    Channel("kinetic_energy", "J", (), "of the free bodies, of their centres' motion and of the turning about them"),
    Channel("potential_energy", "J", (), "of the free bodies, zero with their centres at the origin"),
    Channel("elastic_energy", "J", (), "stored in the contact"),
    Channel("dissipated_viscous", "J", (), "by the viscous part of the normal load since the start"),
    Channel("dissipated_friction", "J", (), "by friction since the start"),
    Channel("held_work", "J", (), "done on held bodies since the start"),
    Channel("gross_work", "J", (), "the same with each moment's work counted by its size"),
    Channel("quaternion_drift", "1", (), "greatest drift of a quaternion's norm in a step so far, before it is undone"),
    Channel(
        "tracking_error", "m", (), "most by which opposing points missed their equations at a step's end so far; "
        "differential: before they are put right",
    ),
)  # fmt: skip
LAYOUT = layout_of(CHANNELS)
SPENT = ("dissipated_viscous", "dissipated_friction", "held_work")


def channels(parameters: TwoBodiesScene) -> tuple[Channel, ...]:
    """What one sample of this scene holds."""
    return CHANNELS


def outputs_of(pair: CoreBodies, states: np.ndarray, drift: float, off: float) -> Columns:
    """All channels of states (n, COLUMNS); `drift` and `off` are the last two."""
    rows = np.empty((len(states), LAYOUT.width))
    write_outputs(*pair, len(states), np.ascontiguousarray(states), rows.shape[1], rows)
    rows[:, -2:] = drift, off
    return Columns(LAYOUT, rows)
