"""What a study may ask of a bearing; nothing here compiles."""

import math

from bearing_twin.kinds.bearing.drive import TORQUE
from bearing_twin.kinds.bearing.rings import free_coordinates
from bearing_twin.kinds.contract import Quantity, read_off


def _of_both(*keys: str):
    """The greatest size of the numbers in the lists at these keys."""
    return lambda figures: max(abs(float(value)) for key in keys for value in figures[key])


def _held(first: int, after: int):
    """Of a ring that is held along all these coordinates its place is what the scene says, and no result."""
    say = "the scene holds the inner ring there, so that it is no result; free it with rings.inner.free"
    return lambda parameters: "" if any(free_coordinates(parameters)[first:after]) else say


def _prescribed(parameters) -> str:
    """Nothing runs up to a prescribed speed."""
    say = "the scene prescribes the inner ring's speed, so that nothing runs it up; turn it by drive.kind: torque"
    return "" if parameters.drive.kind == TORQUE else say


def quantities() -> dict[str, Quantity]:
    """What a study may ask of a bearing."""
    return {
        "greatest_ball_load": Quantity(
            "N",
            "greatest load of any contact during the run",
            _of_both("greatest_normal_load_inner_n", "greatest_normal_load_outer_n"),
        ),
        "greatest_pressure": Quantity(
            "Pa",
            "greatest Hertz pressure of any contact",
            _of_both("peak_pressure_inner_pa", "peak_pressure_outer_pa"),
        ),
        "cage_speed": Quantity(
            "rad/s", "mean speed of the balls about the axis, second half of the run", read_off("cage_speed_rad_s")
        ),
        "roll_rate": Quantity("rad/s", "mean, second half of the run", read_off("roll_rate_rad_s")),
        "drive_torque": Quantity(
            "N m", "that turns the inner ring, mean of the second half of the run", read_off("drive_torque_nm")
        ),
        "speed_at_end": Quantity("rad/s", "of the inner ring", read_off("inner_ring_speed_at_end_rad_s")),
        "run_up_time": Quantity(
            "s",
            "until 99 % of the change of the inner ring's speed was made",
            read_off("run_up_time_s"),
            missing=_prescribed,
        ),
        "dissipated_energy": Quantity("J", "lost in the contacts during the run", read_off("dissipated_j")),
        "ring_displacement": Quantity(
            "m",
            "of the inner ring's centre from the middle, mean of the second half of the run",
            read_off("ring_displacement_m", lambda vector: math.hypot(*vector)),
            missing=_held(0, 3),
        ),
        "misalignment": Quantity(
            "rad",
            "of the inner ring, mean of the second half of the run",
            read_off("misalignment_rad", lambda vector: math.hypot(*vector)),
            missing=_held(3, 5),
        ),
        "greatest_contact_angle": Quantity(
            "rad",
            "of any contact at its greatest load, to either side",
            _of_both("contact_angle_inner_rad", "contact_angle_outer_rad"),
        ),
    }
