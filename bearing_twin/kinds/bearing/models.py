"""Models of a bearing scene: conditions that rules and ranges are about, the choice by rules, warnings of a scene."""

import math

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.units import CELSIUS
from bearing_twin.contact.elasticity import axis_ratio as ratio_of
from bearing_twin.contact.elasticity import coefficient_of, ellipse, hertz_coefficient
from bearing_twin.contact.friction import AUTO, FRICTIONS, POINT, roughness
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus, yield_pressure
from bearing_twin.contact.validity import pressure_warning, shoulder_warning
from bearing_twin.kinds.bearing.equilibrium import centrifugal_ratio, scene_equilibrium, solver_of, support_with_weight
from bearing_twin.kinds.bearing.geometry import leaves_raceway, nominal_curvatures, operating_geometry, squeezes
from bearing_twin.kinds.bearing.integrate import FIXED_STEP, LIGHT
from bearing_twin.kinds.bearing.lubricant import is_lubricated
from bearing_twin.kinds.bearing.rings import (
    COMMON_STEPS,
    FREE_RING,
    LOADS,
    POCKETS,
    PRESCRIBED,
    QUASI_STATIC,
    TORQUE,
    dimension_of,
    free_coordinates,
)
from bearing_twin.kinds.rules import (
    BEARING,
    FASTEST_CHANGE,
    SETTING,
    answers,
    drift,
    idle_step,
    least_of,
    left_by,
    pick,
    sentences,
)

LEAST_DAMPING = 2e-7  # s of relaxation time: contacts with less vibrate for long
SMOOTH = 0.03  # tolerance that the coarsest rule of points over a contact patch meets where spin is fast


def axis_ratio(parameters) -> float:
    """b/a of the narrower ellipse of the two nominal contacts."""
    return min(ratio_of(*pair) for pair in nominal_curvatures(parameters.geometry))


def slip_at_start(parameters) -> float:
    """Slip of the balls at the start, as a share of the speed of rolling."""
    return 1.0 if parameters.initial.motion == "rest" and parameters.drive.speed else 0.0


def ring_shift(parameters) -> float:
    """Distance [m] of the jump of the ring during the run."""
    return math.hypot(*parameters.drive.change.offset) if parameters.drive.change.time else 0.0


def relative_acceleration(parameters) -> float:
    """Acceleration of the scene's change of speed over the least speed [1/s]; 0 without a change."""
    drive = parameters.drive
    slowest = min(abs(drive.speed), abs(drive.speed + drive.change.speed))
    return drive.acceleration / max(slowest, 1.0) if drive.change.time and drive.change.speed else 0.0


def law_of_equilibria(parameters) -> str:
    """The law of a scene, for conditions that are known before it is chosen."""
    return "hertz" if parameters.contact.normal == AUTO else parameters.contact.normal


def centrifugal_share(parameters) -> float:
    """The greatest centrifugal load over the load on the inner raceway, at the start.

    Of balls with a tenth of the greatest load or more. Raises SceneError.
    """
    return centrifugal_ratio(scene_equilibrium(parameters, law_of_equilibria(parameters)).contacts, least=0.1)


def is_torque_driven_under_load(parameters) -> bool:
    """True if a torque turns an inner ring that follows loads."""
    return parameters.drive.kind == TORQUE and dimension_of(parameters) == FREE_RING


def moves_for_loads_alone(parameters) -> bool:
    """True if the inner ring moves with its mass although only loads are requested."""
    return dimension_of(parameters) == FREE_RING


def is_in_equilibrium(parameters) -> bool:
    """True if outputs are equilibria."""
    return dimension_of(parameters) == QUASI_STATIC


def needs_cage(parameters) -> bool:
    """True if balls in motion have clearance somewhere along their orbit."""
    if parameters.geometry.balls == 1:
        return False
    dimension = dimension_of(parameters)
    return dimension == FREE_RING or (dimension == PRESCRIBED and leaves_raceway(parameters))


def cannot_move_cage(parameters) -> bool:
    """True if balls need a cage that the scene's stepper cannot move."""
    return parameters.solver.stepper not in COMMON_STEPS and needs_cage(parameters)


def is_without_friction(parameters) -> bool:
    """True if no friction is computed, or none is requested."""
    idle = parameters.wanted.outputs == LOADS or not parameters.contact.friction_coefficient
    return idle or is_in_equilibrium(parameters)


def is_too_narrow(parameters) -> bool:
    """True if the narrowest contact is beyond the range of friction over contact patches."""
    return axis_ratio(parameters) < least_of("contact.friction", "axis_ratio")


def no_contact_spins(parameters) -> bool:
    """True if no contact spins: nothing acts along the axis or tilts the inner ring, now or later."""
    ring, drive = parameters.rings.inner, parameters.drive
    loads = (*ring.load, *ring.moment), (*ring.change.load, *ring.change.moment), *(row[1:] for row in ring.table)
    axial_or_tilted = drive.offset[2], drive.changed_offset[2], *drive.tilt, parameters.gravity[2]
    return not any(axial_or_tilted) and not any(any(load[2:]) for load in loads)


def rim_speed(parameters) -> float:
    """Greatest speed [m/s] by spin at the rim of a contact patch, one raceway having all of the spin.

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
    if is_lubricated(parameters) or parameters.wanted.tolerance >= SMOOTH:
        return True
    return rim_speed(parameters) < parameters.contact.friction_regularisation


def balls_hit_pockets(parameters) -> bool:
    """True if balls collide with the pockets of a cage."""
    return parameters.cage.kind == POCKETS


def balls_may_hop(parameters) -> bool:
    """True if balls without load may hop between the raceways, as a torque turns the shaft and it may be slow."""
    return parameters.drive.kind == TORQUE


def light_balls_slide(parameters) -> bool:
    """True if balls that touch one raceway alone bounce and slide: between defects, or where contacts spin."""
    if parameters.defects:
        return True
    if dimension_of(parameters) != FREE_RING or no_contact_spins(parameters):
        return False
    load = inner_loads(parameters, law_of_equilibria(parameters))
    return bool(load.min() < LIGHT * load.max())


def contacts_vibrate(parameters) -> bool:
    """True if contacts vibrate: after a sudden change, by unbalance, or with hardly any damping."""
    ring, damping = parameters.rings.inner, parameters.contact.relaxation_time
    sudden = ring_shift(parameters) > 0.0 or relative_acceleration(parameters) > FASTEST_CHANGE
    changed = dimension_of(parameters) == FREE_RING and (ring.change.time or len(ring.table) or ring.unbalance)
    return bool(sudden or changed or 0.0 < damping < LEAST_DAMPING)


def rolls_steadily(parameters) -> bool:
    """True if every ball rolls from the start under a constant load, each with its own steps."""
    drive = parameters.drive
    alone = dimension_of(parameters) == PRESCRIBED and parameters.cage.kind == "none" and not leaves_raceway(parameters)
    steady = not (any(drive.offset[:2]) or any(drive.tilt) or drive.change.time or slip_at_start(parameters))
    return alone and steady and (parameters.contact.friction == POINT or no_contact_spins(parameters))


COLD = 173.15  # K, below all but cryogenic bearings


def temperature_warnings(parameters) -> list[str]:
    """Warnings of temperatures at which steel bearings hardly run: they may have been meant in °C."""
    temperatures = {
        name: getattr(parameters.temperatures, name) for name in ("reference", "inner_ring", "outer_ring", "balls")
    }
    cold = {name: value for name, value in temperatures.items() if 0.0 < value < COLD}
    return [
        f"temperatures.{name} = {value:g} K is {value - CELSIUS:g} °C: if °C was meant, give {value:g}°C"
        for name, value in cold.items()
    ]


def spacing_warnings(parameters, law: str) -> list[str]:
    """Warnings of a held ring that touches no ball, or of balls without a cage that leave a raceway."""
    if dimension_of(parameters) == PRESCRIBED and not touches_at_rest(parameters):
        return [
            "the inner ring stands where it touches no ball, so that nothing loads or drives them: move it by "
            "drive.offset by more than the clearance, or free it under a load (rings.inner.load, model.dimension)"
        ]
    return list(filter(None, [cage_needed(parameters, law)]))


def touches_at_rest(parameters) -> bool:
    """True if a held ring squeezes balls somewhere at rest; a tilted one counts as doing so."""
    return any(parameters.drive.tilt) or any(near > 0.0 for near, _ in squeezes(parameters))


def inner_loads(parameters, law: str) -> np.ndarray:
    """Loads (N,) [N] of the balls on the inner raceway at the start, under loads and weights; raises SceneError."""
    return solver_of(parameters, law).solve(support_with_weight(parameters)).contacts.load[:, 0]


def falling_ball_warnings(parameters, law: str) -> list[str]:
    """Warnings of a ring so slow that balls without load at the start fall off the outer raceway.

    That is at the top of their orbit, if their weight exceeds their centrifugal load at the speed of rolling.
    """
    geometry = parameters.geometry
    orbit = math.sqrt(math.hypot(*parameters.gravity[:2]) / (0.5 * geometry.pitch_diameter))
    limit = orbit / (0.5 * (1.0 - geometry.ball_diameter / geometry.pitch_diameter))
    if abs(parameters.drive.speed) >= limit or inner_loads(parameters, law).min() > 0.0:
        return []
    return [
        f"below {limit:.3g} rad/s the weight of balls exceeds their centrifugal load: unloaded balls fall off the "
        "outer raceway and bounce between the rings, which amplifies errors: values at one instant may miss the "
        "tolerance, means meet it"
    ]


def mend_of_method(parameters, choice) -> str:
    """Advice that reduces the error of the integration method."""
    if falling_ball_warnings(parameters, choice.law):
        return "no tolerance corrects the motion of bouncing balls at one instant: take means, or turn the ring faster"
    if choice.stepper == QUASI_STATIC:
        return f"set model.dimension: {'free' if any(free_coordinates(parameters)) else 'prescribed'}, whose balls move"
    if choice.stepper in FIXED_STEP:
        return "halve solver.step, or set solver.stepper: rodas4"
    if cage_needed(parameters, choice.law):
        return "set cage.kind: even, as balls that collide amplify every error"
    stepper_advice = "" if choice.stepper in ("rodas4", "auto") else "solver.stepper: rodas4, or "
    return f"set {stepper_advice}a tenth of wanted.tolerance"


def cage_needed(parameters, law: str) -> str:
    """Warning that balls without a cage bunch up, as some leave a raceway on their orbit; "" where they do not."""
    if parameters.cage.kind != "none" or parameters.geometry.balls == 1:
        return ""
    is_held = dimension_of(parameters) == PRESCRIBED
    if not (leaves_raceway(parameters) if is_held else inner_loads(parameters, law).min() == 0.0):
        return ""
    return (
        "balls leave the inner raceway on part of their orbit, and no cage spaces them: within about 0.1 s they bunch "
        "up, and their orbit speed is no longer that of rolling; set cage.kind: even"
    )


def law_error(parameters, law: str, curvature_small, curvature_large, load) -> np.ndarray | None:
    """Relative error of each contact's load (N, 2) against exact Hertz at these curvatures [1/m]; above 0: too stiff.

    0 where there is no load; None for a measured law, whose error is unknown.
    """
    if law not in LAWS or LAWS[law].measured:
        return None
    errors, carry = np.zeros_like(load), load > 0.0
    for side, nominal in enumerate(nominal_curvatures(parameters.geometry)):
        frozen, loaded = hertz_coefficient(*nominal, 1.0), carry[:, side]
        curvatures = curvature_small[loaded, side], curvature_large[loaded, side]
        errors[loaded, side] = coefficient_of(law, *curvatures, 1.0, frozen) / hertz_coefficient(*curvatures, 1.0) - 1.0
    return errors


def nominal_law_error(law: str, parameters) -> float:
    """Greatest relative load error of a law against exact Hertz at a bearing's two nominal contacts; 0 if measured."""
    curvatures = (np.broadcast_to(values, (1, 2)) for values in np.transpose(nominal_curvatures(parameters.geometry)))
    errors = law_error(parameters, law, *curvatures, np.ones((1, 2)))
    return 0.0 if errors is None else float(np.abs(errors).max())


SMOOTHING = 2.5  # tuned: power by which the error of a sum over points falls as spin at the rim becomes slow


def rule_error(contact, ratio: float, rim: float) -> float:
    """Greatest error of friction over contact patches, over its limit, and over the torque of pure spin.

    Parameters
    ----------
    contact
        The section `contact` of a scene.
    ratio : float
        b/a of the contact ellipse; errors are those found for 0.1 and above.
    rim : float
        Speed by spin [m/s] at the ends of the ellipse: what is slow against the regularisation is smooth, and n points
        round a ring resolve it. Within a factor of 3 of `bearing_twin chart friction` where the error is above 1e-4.
    """
    model = FRICTIONS[contact.friction]
    share = rim / contact.friction_regularisation
    return model.error / (1.0 + (model.rule.spokes / share) ** SMOOTHING) if share > 0.0 else 0.0


def _coarse_points(parameters, friction: str) -> list[str]:
    """Warning of a scene's rule of points over the contact patch that is too coarse for its spin."""
    if parameters.contact.friction == AUTO or not FRICTIONS[friction].over_patch or is_without_friction(parameters):
        return []
    error = rule_error(parameters.contact, axis_ratio(parameters), rim_speed(parameters))
    if error <= parameters.wanted.tolerance:
        return []
    adequate = pick(BEARING, "contact.friction", parameters).value
    return [
        f"contact.friction = {friction} has an error of up to {error:.2g} of mu N where balls spin as fast as here, "
        f"more than wanted.tolerance = {parameters.wanted.tolerance:g}; auto takes {adequate}"
    ]


def choose(parameters) -> Choice:
    """Law, dimension, friction and stepper; raises SceneError where a scene has no equilibrium to start from."""
    choices = answers(BEARING, parameters)
    law, dimension = choices["contact.normal"].value, choices["model.dimension"].value
    error, tolerance, warnings = nominal_law_error(law, parameters), parameters.wanted.tolerance, []
    if error > tolerance:
        warnings.append(
            f"the law {law} differs by {100 * error:.2g} % from exact Hertz here, more than the tolerance of "
            f"{100 * tolerance:.2g} %; contact.normal: hertz costs no more"
        )
    warnings += [*drift(law), *temperature_warnings(parameters)]
    if dimension == QUASI_STATIC:
        for key in ("cage.kind", "contact.friction", "solver.stepper", SETTING):
            choices.pop(key)
        if parameters.model.dimension == AUTO:
            warnings += left_by(parameters, ("model.dimension", dimension))
        if parameters.solver.stepper != AUTO:
            warnings.append("solver.stepper does nothing in a run from equilibria, which has no steps")
        return Choice(law, QUASI_STATIC, error, sentences(choices), tuple(warnings))
    stepper, friction = choices["solver.stepper"].value, choices["contact.friction"].value
    warnings += spacing_warnings(parameters, law)
    warnings += [*idle_step(parameters.solver.step, stepper, FIXED_STEP), *roughness(FRICTIONS[friction])]
    warnings += [*_coarse_points(parameters, friction), *falling_ball_warnings(parameters, law)]
    friction_name = friction if parameters.contact.friction == AUTO else ""
    setting = choices[SETTING].value if parameters.solver.stepper == AUTO else math.nan
    if parameters.solver.stepper != AUTO:
        choices.pop(SETTING)
    return Choice(law, stepper, error, sentences(choices), tuple(warnings), setting, friction=friction_name)


PERMANENT_PRESSURE = 4.2e9  # Pa; ISO 76: beyond it a ball bearing keeps a dent of 1e-4 ball diameters


def contact_flags(parameters, pressure: float, angles, loads) -> tuple[str | None, ...]:
    """Warnings of contacts: greatest pressure [Pa], outer angles (N,) [rad], inner loads (N,) [N]."""
    materials = parameters.materials
    dents = f"peak pressure {pressure:.3g} Pa is beyond 4.2e+09 Pa: raceways keep permanent indentations (ISO 76)"
    return (
        pressure_warning(pressure, yield_pressure(materials.ball, materials.inner_ring, materials.outer_ring)),
        dents if pressure > PERMANENT_PRESSURE else None,
        shoulder_warning(parameters.geometry.contact_angle, angles, loads),
    )
