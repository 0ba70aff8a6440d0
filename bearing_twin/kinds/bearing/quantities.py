"""The figures of a bearing run by name: meanings, missing ones, quantities of studies."""

from bearing_twin.kinds.bearing.lubricant import is_lubricated
from bearing_twin.kinds.bearing.parameters import has_sensor
from bearing_twin.kinds.bearing.rings import BALLS, TORQUE, free_coordinates, moving_centre
from bearing_twin.kinds.contract import Quantity, figure_quantities

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
    "energy_closure": "energy gained (+) or lost (-) by the method over the run, as a share of the work moved, or of "
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
        f"{key}_{ring}{suffix}": f"{meaning.format(ring=ring)}, one value a ball"
        for key, suffix, meaning in (
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
        f"{key}_over_noise_db": f"level of the line {line} in the envelope spectrum over the median around it, {LAST}"
        for key, line in LINES.items()
    },
}
"""Meanings of the figures' keys, in their order."""


def missing(parameters, in_equilibrium: bool = False) -> dict[str, str]:
    """Reasons for missing figures, by their keys, of a run of equilibria or of motion.

    A ring that is held has its place and tilt from the scene; equilibria lose nothing, and their cage is no body.
    """
    free, moving = free_coordinates(parameters), moving_centre(parameters) and not in_equilibrium
    turned, cage = parameters.drive.kind == TORQUE, parameters.cage
    rolling = "equilibria know neither losses nor the motion of balls and cage; set model.dimension: prescribed or free"
    steady = "the scene prescribes the inner ring's speed, so that nothing runs it up; turn it by drive.kind: torque"
    held = "the scene holds the inner ring there, so that it is no result; free it with rings.inner.free"
    centred = "the cage's centre stays; move it by cage.guidance, with model.dimension: free"
    unheard = "the scene has no sensor; give it one by sensor.on: housing"
    rows = (
        (turned, "a torque turns the inner ring", "catalogue_drive_torque_nm"),
        (in_equilibrium and not is_lubricated(parameters), rolling, "dissipated_j", "drive_torque_nm"),
        (in_equilibrium, rolling, "friction_torque_nm", "cage_slip", "greatest_pocket_force_n"),
        (not turned, steady, "run_up_time_s"),
        (not any(free[:3]), held, "ring_displacement_m", "ring_displacement_range_m"),
        (not any(free[3:]), held, "misalignment_rad"),
        (cage.kind == "none", "the scene has no cage", "cage_slip", "greatest_pocket_force_n"),
        (not moving, centred, "cage_eccentricity_m", "cage_whirl_rad_s", "greatest_land_force_n"),
        (cage.guidance == BALLS, "no land guides the cage", "greatest_land_force_n"),
        (not has_sensor(parameters), unheard, "acceleration_rms_m_s2", *(f"{line}_over_noise_db" for line in LINES)),
    )
    return {key: why for absent, why, *keys in rows if absent for key in keys}


def _greatest(meaning: str, name: str, unit: str) -> Quantity:
    """The greatest size of the numbers of both raceways."""
    keys = tuple(f"{name}_{ring}_{unit}" for ring in ("inner", "outer"))
    return Quantity(keys, lambda *lists: max(abs(float(value)) for values in lists for value in values), meaning)


def quantities() -> dict[str, Quantity]:
    """Quantities of a bearing for studies."""
    return {
        "greatest_ball_load": _greatest("greatest load of any contact during the run", "greatest_normal_load", "n"),
        "greatest_pressure": _greatest("greatest Hertz pressure of any contact", "peak_pressure", "pa"),
        **figure_quantities("cage_speed_rad_s", "roll_rate_rad_s", "drive_torque_nm"),
        "speed_at_end": Quantity(("inner_ring_speed_at_end_rad_s",)),
        "dissipated_energy": Quantity(("dissipated_j",)),
        **figure_quantities("run_up_time_s", "ring_displacement_m", "misalignment_rad"),
        "greatest_contact_angle": _greatest(
            "greatest, to either side, of any contact at its greatest load", "contact_angle", "rad"
        ),
        **figure_quantities("acceleration_rms_m_s2", *(f"{line}_over_noise_db" for line in LINES)),
    }
