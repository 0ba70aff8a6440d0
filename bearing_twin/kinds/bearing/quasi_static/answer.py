"""A bearing in balance as numbers for people and programs: loads, ellipses, stiffness, lives, frequencies, doubts."""

import math

import numpy as np

from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.materials import yield_pressure
from bearing_twin.contact.validity import gathered, groove_doubt, pressure_doubt, shoulder_doubt
from bearing_twin.kinds.bearing.clearance import clearance_of
from bearing_twin.kinds.bearing.controls import SETTLED
from bearing_twin.kinds.bearing.figures import PERMANENT_PRESSURE
from bearing_twin.kinds.bearing.forces.drilling import SIDES
from bearing_twin.kinds.bearing.quasi_static.channels import LEFT
from bearing_twin.kinds.bearing.quasi_static.contacts import shared
from bearing_twin.kinds.bearing.quasi_static.statics import Equilibrium, EquilibriumSolver, Support, loose_directions
from bearing_twin.kinds.bearing.quasi_static.worth import errors_of, spots_of
from bearing_twin.kinds.bearing.ratings import equivalent_loads, lives_of, palmgren_torque, ratings_of

NO_TORQUE = "an equilibrium has no friction; catalogue_drive_torque_nm is Palmgren's estimate with grease"
FLAGGED = 2e-2  # of the greatest load: what balls that move differ by at most unflagged


def frequencies_of(contacts, balls: int, speed: float) -> dict[str, float]:
    """Fault frequencies [Hz] of balls that roll in one cage: over outer and inner ring, cage, ball about itself.

    The cage's speed is the mean of the orbit speeds by load; a spot on a ball strikes a raceway at twice `ball_spin`.
    """
    cage, spin = (shared(contacts, values) for values in (contacts.orbit, np.hypot(contacts.roll, contacts.pitch)))
    return _frequencies(cage, spin, balls, speed)


def rolling_frequencies(geometry, speed: float) -> dict[str, float]:
    """As `frequencies_of`, of balls without load that roll at the nominal contact angle.

    Cage w (1 - g)/2 and spin w d_m (1 - g^2)/(2 D), g = D cos a/d_m (Harris, Rolling Bearing Analysis, chapter 8).
    """
    ratio = geometry.ball_diameter * math.cos(geometry.contact_angle) / geometry.pitch_diameter
    spin = 0.5 * speed * geometry.pitch_diameter / geometry.ball_diameter * (1.0 - ratio**2)
    return _frequencies(0.5 * speed * (1.0 - ratio), spin, geometry.balls, speed)


def _frequencies(cage: float, spin: float, balls: int, speed: float) -> dict[str, float]:
    turn = 0.5 / math.pi
    return {
        "bpfo": abs(balls * cage * turn),
        "bpfi": abs(balls * (speed - cage) * turn),
        "ftf": abs(cage * turn),
        "ball_spin": abs(spin * turn),
    }


def answer_of(parameters, law: str, solver: EquilibriumSolver, support: Support, found: Equilibrium) -> dict:
    """What `bearing_twin bearing` gives out: SI units at the end of each key, a list has one entry a ball.

    `ring_force_n` and `ring_moment_nm` are those of the balls on the inner ring, about its centre; `stiffness` is
    d(external load)/d(coordinate) in the order x, y, z, theta_x, theta_y.
    """
    geometry, contacts = parameters.geometry, found.contacts
    touching = contacts.load > 0.0
    spots = spots_of(parameters, contacts)
    columns = {
        "normal_load": ("n", contacts.load),
        "contact_angle": ("rad", np.where(touching, contacts.angle, 0.0)),
        "peak_pressure": ("pa", spots[2]),
        "semi_major": ("m", spots[0]),
        "semi_minor": ("m", spots[1]),
    }
    off = errors_of(parameters, law, solver, support, found, spots)
    ratings = ratings_of(parameters)
    carried, arm = float(contacts.load.sum()), 0.5 * geometry.pitch_diameter
    force = _settled(-found.loads[:3], carried)
    lives = lives_of(parameters, ratings, force, *contacts.load.T)
    dynamic, static = equivalent_loads(geometry, force)
    clearance = clearance_of(parameters)
    moved = max(np.linalg.norm(found.coordinates[:3]), arm * np.linalg.norm(found.coordinates[3:]))
    stiff = np.sqrt(np.abs(np.diagonal(found.stiffness)))
    return {
        "ring_displacement_m": _settled(found.coordinates[:3], moved),
        "misalignment_rad": _settled(found.coordinates[3:], moved / arm),
        "ring_force_n": force,
        "ring_moment_nm": _settled(-found.loads[3:], arm * carried),
        "ball_azimuth_rad": found.azimuths.tolist(),
        **{
            f"{name}_{race}_{unit}{end}": array[:, side].tolist()
            for name, (unit, values) in columns.items()
            for end, array in (("", values), ("_error", off.columns[name]))
            for side, race in enumerate(SIDES)
        },
        "centrifugal_load_n": contacts.centrifugal.tolist(),
        "stiffness": _settled(found.stiffness, np.outer(stiff, stiff)),
        "basic_dynamic_rating_n": ratings.dynamic,
        "basic_static_rating_n": ratings.static,
        "equivalent_dynamic_load_n": dynamic,
        "equivalent_static_load_n": static,
        "basic_life_mrev": lives.basic,
        "reference_life_mrev": lives.reference,
        "static_safety": lives.static_safety,
        "drive_torque_nm": None,
        "catalogue_drive_torque_nm": palmgren_torque(geometry, ratings.static, force, parameters.drive.speed),
        "not_computed": {"drive_torque_nm": NO_TORQUE},
        "fault_frequencies_hz": frequencies_of(contacts, geometry.balls, parameters.drive.speed),
        "clearance_m": clearance._asdict(),
        "ring_displacement_m_error": off.coordinates[:3].tolist(),
        "misalignment_rad_error": off.coordinates[3:].tolist(),
        "ring_force_n_error": off.ring_loads[:3].tolist(),
        "ring_moment_nm_error": off.ring_loads[3:].tolist(),
        "stiffness_error": off.stiffness.tolist(),
        "basic_life_mrev_error": off.lives.basic,
        "reference_life_mrev_error": off.lives.reference,
        "static_safety_error": off.lives.static_safety,
        "unbalanced_n": found.left,
        "flags": flags_of(parameters, solver, support, found, spots, lives.static_safety, off.rolling),
    }


def _settled(values, scale) -> list:
    """The values, without those that are nothing beside what was added up to them, and without -0."""
    return (np.where(np.abs(values) <= LEFT * scale, 0.0, values) + 0.0).tolist()


def flags_of(
    parameters, solver: EquilibriumSolver, support: Support, found: Equilibrium, spots, safety: float, rolling: float
) -> list[str]:
    """What is doubtful about an equilibrium, one sentence each; `rolling` is that of `Off`."""
    materials, contacts, geometry = parameters.materials, found.contacts, parameters.geometry
    pressure, widths = spots[2].max(), spots[0].max(axis=0)
    limit = yield_pressure(materials.ball, materials.inner_ring, materials.outer_ring)
    loose = loose_directions(found, support, solver.scales)
    friction = parameters.contact.friction_coefficient
    asked = FRICTIONS[parameters.contact.friction].over_spot or parameters.model.control == SETTLED
    held = contacts.load > 0.0
    slips = np.any(np.abs(contacts.friction)[held] > friction * contacts.load[held])
    return gathered(
        f"nothing holds the ring along {', '.join(loose)}: it may lie elsewhere too" if loose else None,
        pressure_doubt(pressure, limit),
        f"peak pressure {pressure:.3g} Pa is beyond 4.2e+09 Pa: real raceways keep dents"
        if pressure > PERMANENT_PRESSURE
        else None,
        f"static safety {safety:.2g} is below 1" if safety < 1.0 else None,
        groove_doubt(widths, 0.5 * geometry.ball_diameter, (geometry.inner_conformity, geometry.outer_conformity)),
        shoulder_doubt(geometry.contact_angle, contacts.angle[:, 1], contacts.load[:, 0]),
        "the gyroscopic moment of a ball needs more friction than contact.friction_coefficient gives: it slides"
        if slips
        else None,
        f"balls that move differ in load by up to {100.0 * rolling:.2g} % of the greatest, as their axes settle and as "
        f"those in one cage slip{'' if asked else ', which --control settled holds where there is such a motion'}"
        if rolling > FLAGGED
        else None,
    )
