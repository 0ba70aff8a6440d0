"""Report of an equilibrium: loads, contact ellipses, stiffness, lives, frequencies, warnings; curves over a sweep."""

import math
from collections.abc import Callable, Iterable

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.base.units import two_digits
from bearing_twin.contact.validity import gathered
from bearing_twin.kinds.bearing.equilibrium import (
    Equilibrium,
    EquilibriumSolver,
    Support,
    ellipses_of,
    equilibrium_error,
    load_weighted_mean,
    loose_directions,
)
from bearing_twin.kinds.bearing.equilibrium_motion import NEGLIGIBLE
from bearing_twin.kinds.bearing.friction_torque import catalogue_torque, torque_answer
from bearing_twin.kinds.bearing.geometry import clearance_parts
from bearing_twin.kinds.bearing.model_error import SIDES, model_errors
from bearing_twin.kinds.bearing.models import contact_flags, temperature_warnings
from bearing_twin.kinds.bearing.ratings import (
    equivalent_loads,
    limiting_speeds,
    lives_of,
    ratings_of,
    speed_warning,
)
from bearing_twin.vibration import fault_frequencies

NO_TORQUE = "an equilibrium has no friction; catalogue_drive_torque_nm is Palmgren's estimate with grease"
STRIBECK = 5.0  # greatest load of a ball over the mean load of all under a radial load (Stribeck 1901; Harris)
FLAGGED = 2e-2  # of the greatest load: a greater difference of loads of balls in motion is flagged


def frequencies_of(contacts, balls: int, speed: float) -> dict[str, float]:
    """Fault frequencies [Hz] of balls that roll in one cage: over outer and inner ring, cage, ball about its axis.

    The cage's speed is the mean of the orbit speeds by load; a defect of a ball strikes a raceway at twice `ball_spin`.
    """
    cage = load_weighted_mean(contacts, contacts.orbit)
    spin = load_weighted_mean(contacts, np.hypot(contacts.roll, contacts.pitch))
    return fault_frequencies(cage, spin, balls, speed)


def answer_of(parameters, law: str, solver: EquilibriumSolver, support: Support, equilibrium: Equilibrium) -> dict:
    """Results of `bearing_twin bearing`: SI units at the end of each key, a list has one entry a ball.

    `ring_force_n` and `ring_moment_nm` are those of the balls on the inner ring, about its centre; `stiffness` is
    d(external load)/d(coordinate) in the order x, y, z, theta_x, theta_y.
    """
    geometry, contacts = parameters.geometry, equilibrium.contacts
    touching = contacts.load > 0.0
    ellipses = ellipses_of(parameters, contacts)
    columns = {
        "normal_load": ("n", contacts.load),
        "contact_angle": ("rad", np.where(touching, contacts.angle, 0.0)),
        "peak_pressure": ("pa", ellipses[2]),
        "semi_major": ("m", ellipses[0]),
        "semi_minor": ("m", ellipses[1]),
    }
    ratings = ratings_of(parameters)
    total, arm = float(contacts.load.sum()), 0.5 * geometry.pitch_diameter
    force = _without_rounding(-equilibrium.loads[:3], total)
    lives = lives_of(parameters, ratings, force, *contacts.load.T)
    dynamic, static = equivalent_loads(geometry, force)
    clearance, loose = clearance_parts(parameters), loose_directions(equilibrium, support, solver.scales)
    shift, tilt = equilibrium.coordinates[:3], equilibrium.coordinates[3:]
    motion = max(np.linalg.norm(shift), arm * np.linalg.norm(tilt))
    root = np.sqrt(np.abs(np.diagonal(equilibrium.stiffness)))
    return {
        "ring_displacement_m": _without_rounding(shift, motion),
        "misalignment_rad": _without_rounding(tilt, motion / arm),
        "ring_force_n": force,
        "ring_moment_nm": _without_rounding(-equilibrium.loads[3:], arm * total),
        "ball_azimuth_rad": equilibrium.azimuths.tolist(),
        **{
            f"{name}_{race}_{unit}": values[:, side].tolist()
            for name, (unit, values) in columns.items()
            for side, race in enumerate(SIDES)
        },
        "centrifugal_load_n": contacts.centrifugal.tolist(),
        "stiffness": _without_rounding(equilibrium.stiffness, np.outer(root, root)),
        "basic_dynamic_rating_n": ratings.dynamic,
        "basic_static_rating_n": ratings.static,
        "equivalent_dynamic_load_n": dynamic,
        "equivalent_static_load_n": static,
        "basic_life_mrev": lives.basic,
        "reference_life_mrev": lives.reference,
        "static_safety": lives.static_safety,
        "drive_torque_nm": None,
        "catalogue_drive_torque_nm": catalogue_torque(parameters, ratings.static, force, parameters.drive.speed),
        "not_computed": {"drive_torque_nm": NO_TORQUE},
        "limiting_speed_rad_s": limiting_speeds(geometry),
        **torque_answer(parameters, contacts, ratings.static, force),
        "fault_frequencies_hz": frequencies_of(contacts, geometry.balls, parameters.drive.speed),
        "clearance_m": clearance._asdict(),
        "model_errors": model_errors(parameters, law, solver, support, equilibrium),
        "unbalanced_n": equilibrium.residual,
        "flags": flags_of(parameters, contacts, loose, ellipses[2].max(), lives.static_safety, dynamic),
    }


def natural_frequencies(stiffness, mass: float, tilts: tuple[bool, bool]) -> dict:
    """Undamped natural frequencies [Hz], rising, of a mass at the ring's centre on this stiffness; their directions.

    Parameters
    ----------
    stiffness
        (5, 5) as of `answer_of`, [N/m, N/rad, N m/rad].
    mass
        Of a body that does not turn [kg].
    tilts
        Which of the two tilts follow without inertia; the others are held.
    """
    matrix = np.asarray(stiffness)
    free = [3 + i for i in range(2) if tilts[i]]
    condensed, tilting = matrix[:3, :3], matrix[np.ix_(free, free)]
    if free:
        condensed = condensed - matrix[:3, free] @ np.linalg.pinv(tilting) @ matrix[free, :3]
    squares, modes = np.linalg.eigh(0.5 * (condensed + condensed.T) / mass)
    least = NEGLIGIBLE * np.abs(squares).max()  # below it nothing holds the mass
    frequencies = np.sqrt(np.where(squares > least, squares, 0.0)) / (2.0 * math.pi)
    return {
        "mass_kg": mass,
        "natural_frequencies_hz": frequencies.tolist(),
        "natural_directions": _without_rounding(modes.T, 1.0),
    }


def _without_rounding(values, scale) -> list:
    """The values, 0 where they are rounding of sums of size `scale`, and without -0."""
    return (np.where(np.abs(values) <= NEGLIGIBLE * scale, 0.0, values) + 0.0).tolist()


def flags_of(parameters, contacts, loose: list[str], pressure: float, safety: float, load: float) -> list[str]:
    """Warnings of an equilibrium with `loose_directions`, under an equivalent dynamic load [N], one sentence each."""
    greatest, usual = contacts.load[:, 0].max(), STRIBECK * load / parameters.geometry.balls
    friction = parameters.contact.friction_coefficient
    transient = equilibrium_error(contacts)
    slips = np.any((np.abs(contacts.friction) > friction * contacts.load) & (contacts.load > 0.0))
    return gathered(
        speed_warning(parameters.geometry, parameters.drive.speed),
        *temperature_warnings(parameters),
        f"nothing holds the ring along {', '.join(loose)}: its position there is arbitrary" if loose else None,
        f"static safety {safety:.2g} is below 1" if safety < 1.0 else None,
        f"a ball carries {greatest:.3g} N, where basic life assumes about {two_digits(usual)} N: interference, "
        "clearance or a tilt adds load, which static safety and the catalogue's torque ignore; reference life counts it"
        if greatest > 2.0 * usual
        else None,
        *contact_flags(parameters, pressure, contacts.angle[:, 1], contacts.load[:, 0]),
        "the gyroscopic moment of a ball needs more friction than contact.friction_coefficient gives: it slides"
        if slips
        else None,
        f"loads of balls in motion differ from this equilibrium by up to {two_digits(100.0 * transient)} % of the "
        "greatest load; `bearing_twin simulate` computes them"
        if transient > FLAGGED
        else None,
    )


EACH = ("ring_displacement_m", "misalignment_rad", "ring_force_n", "ring_moment_nm", "stiffness")
OPTIONAL = ("natural_frequencies_hz", "friction_torque_nm", "film_m", "lambda")
ALONE = ("basic_life_mrev", "reference_life_mrev", "static_safety")
GREATEST = ("normal_load_inner_n", "normal_load_outer_n", "contact_angle_inner_rad", "peak_pressure_inner_pa")


def curves_of(values: Iterable[float], solved: Callable[[float], dict]) -> dict:
    """Curves over `values`: lists with one entry a value, None where `solved(value)` raises SceneError.

    `greatest_<key>` is the greatest magnitude over the balls, `loaded_balls` counts those between both rings; `refused`
    holds the value and the reason of each that has no equilibrium.
    """
    curves = {key: [] for key in (*EACH, *ALONE, *OPTIONAL, *(f"greatest_{key}" for key in GREATEST), "loaded_balls")}
    refused = []
    for value in values:
        try:
            answer = solved(value)
        except SceneError as error:
            refused.append({"value": value, "reason": str(error)})
            row = dict.fromkeys(curves)
        else:
            row = {key: answer.get(key) for key in (*EACH, *ALONE, *OPTIONAL)}
            row |= {f"greatest_{key}": float(np.abs(answer[key]).max()) for key in GREATEST}
            row["loaded_balls"] = sum(load > 0.0 for load in answer["normal_load_inner_n"])
        for key, curve in curves.items():
            curve.append(row[key])
    if len(refused) == len(curves["stiffness"]):
        raise SceneError(f"no value of this sweep has an equilibrium; at the first: {refused[0]['reason']}")
    curves = {key: curve for key, curve in curves.items() if key not in OPTIONAL or any(curve)}
    return curves | {"refused": refused}
