"""The figures of a bearing run by name: what each is, which a scene lacks, and which a study may ask for."""

import math

from bearing_twin.kinds.bearing.lubricant import lubricated
from bearing_twin.kinds.bearing.parameters import has_sensor
from bearing_twin.kinds.bearing.rings import BALLS, TORQUE, free_coordinates, moving_centre
from bearing_twin.kinds.contract import Quantity, read_off

HALF = "over the second half of the run"
LATE = f"mean {HALF}"
PEAK = "at the contact's greatest load"
LAST = "over the last 10 s of the run; none without a sensor, or of less than 20 turns of the shaft"
LINES = {"bpfo": "at BPFO (outer raceway)", "bpfi": "at BPFI (inner raceway)", "bsf": "at twice BSF (ball)"}
MEANINGS = {
    "inner_ring_speed_at_end_rad_s": "of the inner ring, at the end",
    "run_up_time_s": "until 99 % of the change of the inner ring's speed over the run was first made; none where its "
    "speed is prescribed",
    "cage_speed_rad_s": f"of the balls about the axis, {LATE}",
    "cage_speed_theory_rad_s": f"of balls that roll without slip at the contact angles found, {LATE}",
    "roll_rate_rad_s": f"of the balls about their own axes, {LATE}",
    "roll_rate_theory_rad_s": f"of balls that roll without slip at the contact angles found, {LATE}",
    "energy_closure": "energy gained (+) or lost (-) by the numbers over the run, as a share of the work moved, or of "
    "wanted.tolerance times what is stored where that is more; unknown where a torque drives a ring over defects",
    "drive_work_j": "work of the drive and of the loads on a ring with mass since the start, at the end",
    "dissipated_j": "energy lost in the contacts since the start, at the end; none from dry equilibria",
    "drive_torque_nm": f"that turns the inner ring, without lubricant against dry contacts' friction alone, {LATE}: "
    "work over angle, less that of loads; none from dry equilibria",
    "catalogue_drive_torque_nm": "friction torque of a greased bearing under the mean force on its ring, by Palmgren's "
    f"rule, within about 50 %, {HALF}; none at rest or where a torque drives",
    "ring_displacement_m": f"of the inner ring's centre, {LATE}; none of a ring that is held",
    "misalignment_rad": f"of the inner ring about x and y, {LATE}; none where tilts are held",
    "ring_force_n": f"on the inner ring by the balls, {LATE}",
    "ring_moment_nm": f"on the inner ring by the balls about x and y, {LATE}",
    "ring_displacement_range_m": f"greatest minus least displacement, {HALF}; none of a ring that is held",
    "ring_force_range_n": f"greatest minus least force of the balls, {HALF}",
    **{
        f"{key}_{ring}{suffix}": f"{words.format(ring=ring)}, one value a ball"
        for key, suffix, words in (
            ("normal_load", "_n", f"load on the {{ring}} raceway, {LATE}"),
            ("greatest_normal_load", "_n", "load on the {ring} raceway, greatest of all outputs"),
            ("contact_angle", "_rad", f"on the {{ring}} raceway, {PEAK}, > 0 where the ring is pushed along +z"),
            ("semi_major", "_m", f"of the ellipse on the {{ring}} raceway, {PEAK}"),
            ("semi_minor", "_m", f"of the ellipse on the {{ring}} raceway, {PEAK}"),
            ("peak_pressure", "_pa", f"on the {{ring}} raceway, {PEAK}"),
            ("share_without_contact", "", "share of the outputs without a load on the {ring} raceway, whole run"),
        )
        for ring in ("inner", "outer")
    },
    "cage_slip": "1 - cage_speed / cage_speed_theory; none without a cage",
    "greatest_pocket_force_n": "of the cage on a ball along its orbit, greatest of all outputs; none without a cage",
    "cage_eccentricity_m": f"distance of the cage's centre from the axis, {LATE}; none where it stays centred",
    "cage_whirl_rad_s": f"of the cage's centre round the axis, about +z, {LATE}; none where it stays centred",
    "greatest_land_force_n": "of the land on the cage, greatest of all outputs; none without guidance by a land",
    "friction_torque_nm": f"of each ball, not the bearing's: the friction of its raceways about its "
    f"centre, {LATE}; none from equilibria",
    "acceleration_rms_m_s2": f"of the sensor's samples, {LAST}",
    **{
        f"{key}_over_noise_db": f"level of the line {words} in the envelope spectrum over the median around it, {LAST}"
        for key, words in LINES.items()
    },
}
"""Meanings of the figures' keys, in their order."""
FIGURES_OF = {
    "lubricated": ("catalogue_drive_torque_nm",),
    "losses": ("dissipated_j", "drive_torque_nm"),
    "friction": ("friction_torque_nm",),
    "run-up": ("run_up_time_s",),
    "displacement": ("ring_displacement_m", "ring_displacement_range_m"),
    "tilt": ("misalignment_rad",),
    "cage": ("cage_slip", "greatest_pocket_force_n"),
    "centre": ("cage_eccentricity_m", "cage_whirl_rad_s"),
    "land": ("greatest_land_force_n",),
    "sensor": ("acceleration_rms_m_s2", *(f"{key}_over_noise_db" for key in LINES)),
}


def missing(parameters, in_equilibrium: bool) -> frozenset[str]:
    """Keys of figures whose part a scene does not have; a run is one of equilibria or not.

    A ring that is held has its place and tilt from the scene; equilibria lose nothing, and their cage is no body.
    """
    free, moving = free_coordinates(parameters), moving_centre(parameters)
    there = {
        "lubricated": parameters.drive.kind != TORQUE,
        "losses": not in_equilibrium or lubricated(parameters),
        "friction": not in_equilibrium,
        "run-up": parameters.drive.kind == TORQUE,
        "displacement": any(free[:3]),
        "tilt": any(free[3:]),
        "cage": parameters.cage.kind != "none" and not in_equilibrium,
        "centre": moving and not in_equilibrium,
        "land": moving and not in_equilibrium and parameters.cage.guidance != BALLS,
        "sensor": has_sensor(parameters),
    }
    return frozenset(key for part, keys in FIGURES_OF.items() if not there[part] for key in keys)


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


def _unheard(parameters) -> str:
    """A sensor is needed."""
    return "the scene has no sensor; give it one by sensor.on: housing" if not has_sensor(parameters) else ""


def quantities() -> dict[str, Quantity]:
    """Quantities that a study may ask of a bearing."""
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
        "acceleration_rms": Quantity(
            "m/s^2", "of the sensor's samples, last 10 s", read_off("acceleration_rms_m_s2"), missing=_unheard
        ),
        **{
            f"{name}_over_noise": Quantity(
                "dB",
                f"level of the line {words} in the envelope spectrum over the median around it, last 10 s",
                read_off(f"{name}_over_noise_db"),
                missing=_unheard,
            )
            for name, words in LINES.items()
        },
    }
