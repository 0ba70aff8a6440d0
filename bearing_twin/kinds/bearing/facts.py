"""Numbers and conditions of a bearing scene that rules and ranges of models are about, known before it runs."""

import math

from bearing_twin.contact.ellipse import axis_ratio as ratio_of
from bearing_twin.contact.ellipse import ellipse, hertz_coefficient
from bearing_twin.contact.friction import POINT
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.kinds.bearing.clearance import leaves_raceway, operating_geometry
from bearing_twin.kinds.bearing.drive import TORQUE
from bearing_twin.kinds.bearing.rings import (
    COMMON_STEPS,
    FREE_RING,
    LOADS,
    POCKETS,
    PRESCRIBED,
    QUASI_STATIC,
    dimension_of,
)
from bearing_twin.kinds.bearing.start import nominal_curvatures
from bearing_twin.kinds.bearing.still import share_at_start
from bearing_twin.kinds.ranges import FASTEST_CHANGE, least_of

LEAST_DAMPING = 2e-7  # s of relaxation time: contacts with less ring for long
SMOOTH = 0.03  # tolerance that the coarsest rule of points over a contact patch meets where spin is fast


def axis_ratio(parameters) -> float:
    """b/a of the narrower ellipse of the two nominal contacts."""
    return min(ratio_of(*pair) for pair in nominal_curvatures(parameters.geometry))


def slip_at_start(parameters) -> float:
    """What the balls lack of rolling at the start, as a share of it."""
    return 1.0 if parameters.initial.motion == "rest" and parameters.drive.speed else 0.0


def ring_shift(parameters) -> float:
    """How far [m] the ring jumps under way."""
    return math.hypot(*parameters.drive.change.offset) if parameters.drive.change.time else 0.0


def relative_acceleration(parameters) -> float:
    """Acceleration of the scene's change of speed over the least speed [1/s]; 0 where none comes."""
    drive = parameters.drive
    slowest = min(abs(drive.speed), abs(drive.speed + drive.change.speed))
    return drive.acceleration / max(slowest, 1.0) if drive.change.time and drive.change.speed else 0.0


def centrifugal_share(parameters) -> float:
    """The greatest centrifugal load over the load on the inner raceway, at the start, of balls that matter.

    Those are balls with a tenth of the greatest load or more. Raises SceneError.
    """
    law = parameters.contact.normal
    return share_at_start(parameters, "hertz" if law == "auto" else law, least=0.1)


def turned_under_load(parameters) -> bool:
    """True if a torque turns an inner ring that follows loads."""
    return parameters.drive.kind == TORQUE and dimension_of(parameters) == FREE_RING


def moves_for_loads(parameters) -> bool:
    """True if the inner ring moves with its mass although nothing but loads is wanted."""
    return dimension_of(parameters) == FREE_RING


def in_equilibrium(parameters) -> bool:
    """True if outputs are equilibria."""
    return dimension_of(parameters) == QUASI_STATIC


def wants_cage(parameters) -> bool:
    """True if balls that move have clearance on their way round, and their stepper moves a cage."""
    if parameters.geometry.balls == 1 or parameters.solver.stepper not in COMMON_STEPS:
        return False
    dimension = dimension_of(parameters)
    return dimension == FREE_RING or (dimension == PRESCRIBED and leaves_raceway(parameters))


def without_friction(parameters) -> bool:
    """True if no friction is computed, or none is wanted."""
    idle = parameters.wanted.outputs == LOADS or not parameters.contact.friction_coefficient
    return idle or in_equilibrium(parameters)


def too_narrow(parameters) -> bool:
    """True if the narrowest contact is beyond the range of friction over contact patches."""
    return axis_ratio(parameters) < least_of("contact.friction", "axis_ratio")


def rim_speed(parameters) -> float:
    """Greatest speed [m/s] by spin at the rim of a contact patch, one raceway taking all of the spin.

    Of a ring that is held: its offset gives the contact angle and, by Hertz, the major semi-axis.
    """
    geometry, drive, materials = operating_geometry(parameters), parameters.drive, parameters.materials
    free = (geometry.inner_conformity + geometry.outer_conformity - 1.0) * geometry.ball_diameter
    speed, fastest = max(abs(drive.speed), abs(drive.speed + drive.change.speed)), 0.0
    modulus = effective_modulus(materials.ball, materials.inner_ring)
    for x, y, axial in (drive.offset, drive.changed_offset):
        across = free - 0.5 * geometry.radial_clearance + math.hypot(x, y)
        distance = math.hypot(across, axial)
        approach = 0.5 * (distance - free)
        if approach > 0.0:
            small, large = nominal_curvatures(geometry)[0]
            load = hertz_coefficient(small, large, modulus) * approach**1.5
            fastest = max(fastest, ellipse(small, large, modulus, load).semi_major * speed * abs(axial) / distance)
    return fastest


def spins_slowly(parameters) -> bool:
    """True if the coarsest rule of points over the contact patch is fine enough."""
    slow = rim_speed(parameters) < parameters.contact.friction_regularisation
    return slow or parameters.wanted.tolerance >= SMOOTH


def collides(parameters) -> bool:
    """True if balls collide with the pockets of a cage."""
    return parameters.cage.kind == POCKETS


def hops(parameters) -> bool:
    """True if balls without load may hop between the raceways, as a torque turns the shaft and it may be slow."""
    return parameters.drive.kind == TORQUE


def rings(parameters) -> bool:
    """True if contacts ring: after a sudden change of ring or load, by an unbalance, or with hardly any damping."""
    drive, ring, damping = parameters.drive, parameters.rings.inner, parameters.contact.relaxation_time
    sudden = ring_shift(parameters) > 0.0 or relative_acceleration(parameters) > FASTEST_CHANGE
    changed = dimension_of(parameters) == FREE_RING and (ring.change.time or len(ring.table) or ring.unbalance)
    return bool(sudden or changed or 0.0 < damping < LEAST_DAMPING) and drive.kind != TORQUE


def rolls_steadily(parameters) -> bool:
    """True if every ball rolls from the start under a load that stays, each with steps of its own."""
    drive = parameters.drive
    alone = dimension_of(parameters) == PRESCRIBED and parameters.cage.kind == "none" and not leaves_raceway(parameters)
    steady = not (any(drive.offset[:2]) or any(drive.tilt) or drive.change.time or slip_at_start(parameters))
    return alone and steady and parameters.contact.friction == POINT
