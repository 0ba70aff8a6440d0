"""Errors and lengths of steps: error scales of adaptive methods, stability limits of methods with fixed steps.

Error scales. The error of a load follows from that of its approach; that of friction, over mu N, from those of the
slip, over the speed of its regularisation, and of the load N. A ball that rings between its contacts at the rate w with
an amplitude v of its radial velocity is wrong by m w v in load; nothing stops it, so that the errors of many steps add
up, and a contact that carries little feels them most: without a share of its own, lift-off missed its tolerance in
friction 4 to 19 times, and with it 0.4 to 0.7 times. The lightest contact that errors of friction are judged by carries
LIGHT of the greatest load. Slip of a ball that carries less counts as much less (`light_approach`). Every impact on a
pocket changes a ball's speed along its orbit: there such errors count by the load (`weight_of_light` of
`core/bearing/elements.hpp`), else balls that carry next to nothing determine all steps.

Fixed steps. Two motions of a ball are fast. It rings between its contacts, x'' + c x' + w^2 x = 0, and its slip decays,
at the rate 5 mu N / (m v_s) between two contacts with the load N each. A method is stable where it damps both. `imex`
takes friction and damping implicitly, so that only w limits it: 2/w, the limit of leapfrog. Where friction limits it,
`rk4` beyond its limit still gives right loads, while friction is wrong. Where balls slide, `imex` has a limit by
friction, too. A slip s, in units of v_s, with friction f(s) = s/sqrt(1 + s^2) steps to s - z f/(1 + z f'/2), z = rate *
step. For z >= 3 sqrt(3) there is an s that steps to -s: slip then goes to and fro for ever, however long friction has
had to end it. Below, and for balls that roll from the start, it dies out.
"""

import cmath
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.elasticity import elastic
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.system import AXIS_DISTANCE, HEIGHT, RADIAL_VELOCITY, Bearing

APPROACH_SCALE = 1e-6  # m, the size of an elastic approach: errors of position count against it
STEP_SHARE = 0.2  # of the wanted accuracy, that one adaptive step may spend: `chart steppers`, docs/accuracy.md
LIGHT = 0.01  # of the greatest load
LOST_SHARE = 10.0  # of what the heaviest contact stores, at a tolerance of 1: a start from rest heats by that
# With these two, balls that ring and loaded rings keep their tolerance: `tests/test_error_scales.py`.
RINGING_SHARE = 0.08  # of what a ball that rings may err by: one step of a ball that has steps of its own
COMMON_SHARE = 4.0  # the same where balls step together; one ball rules their steps, and soon stops ringing
STRICTEST, LOOSEST = 0.1, 16.0  # of an error of radial velocity, over one of slip


def light_approach(bearing: Bearing, approaches: np.ndarray) -> float:
    """The approach [m] of an outer contact that bears LIGHT of the greatest load of `approaches` (N, 2)."""
    return max(float(approaches[:, 1].max()), APPROACH_SCALE) * LIGHT ** (1.0 / bearing.outer.law.power)


def error_scales(
    parameters: BearingScene, bearing: Bearing, start: np.ndarray, approaches: np.ndarray, together: bool
) -> np.ndarray:
    """Errors (MOTION + 1,) that a step of a ball may make at a tolerance of 1, for balls at `start` (N, COLUMNS).

    The last [J] is that of what is lost, LOST_SHARE of what the heaviest contact stores, at least at an approach of
    APPROACH_SCALE. Their `approaches` (N, 2) [m] are those there. Where balls step `together`, at the pace of the one
    with the shortest steps, errors of the others hardly add up.
    """
    speed, law = parameters.contact.friction_regularisation, bearing.outer.law
    radius, pitch = bearing.ball_radius, 0.5 * parameters.geometry.pitch_diameter
    unit = np.array([APPROACH_SCALE, APPROACH_SCALE / pitch, APPROACH_SCALE, *(speed,) * 3, *(speed / radius,) * 3])
    # The amplitude of the radial velocity with which the lightest contact is wrong by all its load.
    depth = max(light_approach(bearing, approaches), float(approaches[:, 1].min()))
    lightest = elastic(law.given, law.power, depth)
    ringing = lightest.load / math.sqrt(lightest.stiffness * bearing.ball_mass) / speed
    # By the contact angle an error of radial velocity is slip, too.
    outwards = start[:, AXIS_DISTANCE] - bearing.outer.locus_radius
    sine = float(np.abs(start[:, HEIGHT] / np.hypot(outwards, start[:, HEIGHT])).max())
    loosest = min(LOOSEST, 0.5 / max(sine, 1e-3)) if together else 1.0
    unit[RADIAL_VELOCITY] *= min(max((COMMON_SHARE if together else RINGING_SHARE) * ringing, STRICTEST), loosest)
    stored = elastic(law.given, law.power, max(float(approaches.max()), APPROACH_SCALE)).energy
    return STEP_SHARE * np.append(unit, LOST_SHARE * stored)


FIXED_STEP = ("rk4", "imex")
LEAST_APPROACH = 1e-6  # m: lighter contacts are taken as this one, for loads to come
STEPS_A_CONTACT = 16  # of a step that is chosen
FRICTION_SHARE = 0.5  # of the stability limit by friction and damping, of a step that is chosen
SHARP = 1e-6  # relative: how exactly a limit is found
ALIKE = 1e-9  # relative: balls whose rates differ by less are alike
TO_AND_FRO = 3.0 * math.sqrt(3.0) / 0.7  # the friction rate of a ball that slides on one raceway is 0.7 of the fastest


class Rates(NamedTuple):
    """The fastest rates of a state [1/s]: contact resonance w, friction creep, damping c; the shortest contact [s].

    `ringing` and `creeping` are the balls that have the first two, the first of those that are alike.
    """

    contact: float
    friction: float
    damping: float
    shortest_contact: float
    ringing: int = 0
    creeping: int = 0


class TooLong(NamedTuple):
    """Problem of a step that is too long, and its body."""

    sentence: str
    body: str


def _grip(inner: float, outer: float) -> float:
    """Fastest decay of slip times m v_s/mu [N] for the loads [N] of two contacts that lie opposite on a ball.

    The greater root for the ball's sliding and its turning, 2.5 times easier, which unequal loads couple: 5 N for two
    loads N, 3.5 N for one.
    """
    both, apart = inner + outer, inner - outer
    return 0.5 * (3.5 * both + math.sqrt(2.25 * both**2 + 10.0 * apart**2))


def fastest_rates(bearing: Bearing, approaches: np.ndarray) -> Rates:
    """The fastest rates to be expected of balls with these approaches (N, 2) [m].

    A ball between two contacts rings with both stiffnesses, which are greatest where it is squeezed evenly. The
    shortest contact is half a period of the contact resonance.
    """
    inner, outer = bearing.inner.law, bearing.outer.law
    stiffness, viscous, grip, ringing, creeping = 0.0, 0.0, 0.0, 0, 0
    for k, depths in enumerate(np.maximum(approaches, 0.0).tolist()):
        middle = max(LEAST_APPROACH, 0.5 * sum(depths))
        both = elastic(inner.given + outer.given, inner.power, middle)
        loads = (elastic(law.given, law.power, depth).load for law, depth in zip((inner, outer), depths, strict=True))
        held = max(_grip(0.5 * both.load, 0.5 * both.load), _grip(*loads))
        ringing = k if both.stiffness > (1.0 + ALIKE) * stiffness else ringing
        creeping = k if held > (1.0 + ALIKE) * grip else creeping
        stiffness, viscous, grip = max(stiffness, both.stiffness), max(viscous, both.load), max(grip, held)
    friction = bearing.friction_coefficient * grip / (bearing.friction_regularisation * bearing.ball_mass)
    contact = math.sqrt(stiffness / bearing.ball_mass)
    damping = (bearing.damping * viscous + bearing.relaxation_time * stiffness) / bearing.ball_mass
    return Rates(contact, friction, damping, math.pi / contact, ringing, creeping)


def _growth_of_rk4(z: complex) -> float:
    """Amplification factor of the classical Runge-Kutta method at z = rate * step."""
    return abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))))


def _limit_along(rate: complex) -> float:
    """The longest step of rk4 [s] at which what moves at this rate [1/s] does not grow; infinite at rate 0."""
    if rate == 0.0:
        return math.inf
    low, high, unit = 0.0, 1.0, 1.0 / abs(rate)
    while _growth_of_rk4(high * unit * rate) <= 1.0:
        low, high = high, 1.1 * high
    while high - low > SHARP * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _growth_of_rk4(middle * unit * rate) <= 1.0 else (low, middle)
    return low * unit


def stability_limits(rates: Rates, stepper: str, slides: bool = True) -> tuple[float, float]:
    """The longest stable steps [s] of a fixed-step method: by what rings in the contacts, and by what creeps.

    `slides` says whether a ball may slide on a raceway, as it does from rest and after a jump of the ring.
    """
    if stepper == "imex":
        return 2.0 / rates.contact, TO_AND_FRO / rates.friction if slides and rates.friction else math.inf
    root = cmath.sqrt(0.25 * rates.damping**2 - rates.contact**2)
    ringing = (-0.5 * rates.damping + root, -0.5 * rates.damping - root)
    return min(map(_limit_along, ringing)), _limit_along(complex(-rates.friction))


def stable_step(rates: Rates, stepper: str, slides: bool = True) -> float:
    """A step [s] for a method with fixed steps: STEPS_A_CONTACT, and well inside its stability limit."""
    return min(rates.shortest_contact / STEPS_A_CONTACT, FRICTION_SHARE * min(stability_limits(rates, stepper, slides)))


def too_long(step: float, rates: Rates, stepper: str, slides: bool = True) -> TooLong | None:
    """Problem of a step [s] of a fixed-step method in a state with these rates, or None."""
    ringing, creeping = stability_limits(rates, stepper, slides)
    if step <= min(ringing, creeping):
        return None
    advice = f"use {stable_step(rates, stepper, slides):.2g} s or less, or solver.stepper: rodas4"
    if ringing < creeping:
        body = f"ball {rates.ringing}"
        why = f"is too long: {body} rings between its contacts at {rates.contact:.2g} rad/s, where {stepper} is stable"
    else:
        body = f"ball {rates.creeping}"
        why = f"is unstable: friction answers at {rates.friction:.2g} /s on {body}, where {stepper} is right"
    return TooLong(f"solver.step = {step:g} s {why} up to {min(ringing, creeping):.3g} s; {advice}", body)


def step_at_start(parameters, rates: Rates, stepper: str) -> tuple[float, TooLong | None]:
    """The step [s] of a scene by a fixed-step method, given or stable, and what is wrong with it.

    `rates` are those of its start, where balls may slide if they are at rest.
    """
    slides = parameters.initial.motion == "rest"
    step = parameters.solver.step or stable_step(rates, stepper, slides)
    return step, too_long(step, rates, stepper, slides)
