"""Integration of a part of a chunk by any stepper, and errors and lengths of its steps.

Steppers move balls alone, balls that may touch, or all with ring, cage and shaft. Methods of SciPy, for reference,
integrate the same equations.

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
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.coefficients import EXPLICIT, ROSENBROCK
from bearing_twin.contact.elasticity import elastic
from bearing_twin.core import (
    FLAG,
    FLAGS,
    FLAGS_OUT,
    INTEGER,
    INTEGERS_OUT,
    REAL,
    REALS,
    REALS_OUT,
    Function,
)
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.system import (
    AXIAL_SPIN,
    AXIS_DISTANCE,
    COLUMNS,
    HEIGHT,
    MOTION,
    RADIAL_SPIN,
    RADIAL_VELOCITY,
    TANGENTIAL_SPIN,
    TANGENTIAL_VELOCITY,
    Bearing,
    CoupledBodies,
    RingDrive,
    method_numbers,
    numbers_of,
    numbers_of_bodies,
    runge_kutta_numbers,
)
from bearing_twin.methods import (
    EVALUATIONS,
    JACOBIANS,
    NOT_FINITE,
    NOTHING,
    OK,
    REASONS,
    STALLED,
    STEPPER_FACTS,
    STEPS,
    STOPPED,
    TOO_DEEP,
)
from bearing_twin.shapes import turned

REFERENCE_SHARE = 1e-4  # of the scales, for SciPy's methods, whose only use here is to be right
SCIPY = {"dop853": "DOP853", "radau": "Radau"}
FAILURES = {
    NOT_FINITE: "is not finite any more; shorten solver.step or use solver.stepper: rodas4",
    TOO_DEEP: "has run through a raceway; check the loads, or shorten solver.step",
    STALLED: "needs ever shorter steps; loosen wanted.tolerance or raise contact.friction_regularisation",
}

_integrate = Function(
    "core_integrate",
    INTEGER,
    (
        *(REALS, REALS, INTEGER, *(REALS,) * 6, REAL, REAL, INTEGER, REALS, FLAG, INTEGER, FLAGS),
        *(*(REALS_OUT,) * 8, INTEGERS_OUT, REALS_OUT),
    ),
)
IMEX, RUNGE_KUTTA, LINEARLY_IMPLICIT = range(3)  # Family of core/bearing/balls.cpp
NO_NUMBERS = np.zeros(0)
_all_rates = Function("core_all_rates", None, (REALS, REALS, REAL, REAL, INTEGER, FLAGS, REALS_OUT, REALS_OUT))
_add_stored = Function("core_add_stored", None, (REALS, REALS, INTEGER, FLAGS, REAL, INTEGER, REALS_OUT))


class Chunk(NamedTuple):
    """A part of a chunk that is integrated by one call.

    `near` (N,) says which balls may touch the next ahead; `step` [s] is that of methods with fixed steps, `scales`
    (MOTION + 1,) are the errors of a step of the others; a `stop` (1,) that is not 0 ends it before the next step.
    Moved on in place are `state` (N, COLUMNS), `orientation` (N, 4), the balls' `steps` (N,) [s], the states of laws
    `carried` (N, CARRIED_COLUMNS), and `body_state` (BODY_COLUMNS,), that of ring, cage and shaft; outputs are filled
    in at `times` (n,) [s] within `duration`. `counts` (4,) are added to; `failure` (2,) is time and ball.
    """

    bearing: Bearing
    drive: RingDrive
    bodies: CoupledBodies
    near: np.ndarray
    times: np.ndarray
    duration: float
    step: float
    scales: np.ndarray
    stop: np.ndarray
    state: np.ndarray
    orientation: np.ndarray
    steps: np.ndarray
    carried: np.ndarray
    body_state: np.ndarray
    states: np.ndarray
    orientations: np.ndarray
    body_states: np.ndarray
    counts: np.ndarray
    failure: np.ndarray


def rates(bearing, ring_speed: float, near: np.ndarray, state: np.ndarray, ring_angle: float = 0.0) -> np.ndarray:
    """Rates (N, COLUMNS) of all balls in a state (N, COLUMNS); near[k] says whether ball k may touch the next ahead.

    Losses take in what contacts of balls store.
    """
    found = np.empty_like(state)
    _all_rates(*numbers_of(bearing), float(ring_speed), float(ring_angle), len(state), near, state, found)
    return found


def integrated(stepper: str, chunk: Chunk) -> int:
    """Integrates a chunk; returns its status."""
    if stepper == "imex":  # its losses are of first order: those of damping, which are less than what contacts store
        return _by_core(stepper, chunk)
    _stored(1.0, chunk, chunk.state)
    status = _by_scipy(SCIPY[stepper], chunk) if stepper in SCIPY else _by_core(stepper, chunk)
    _stored(-1.0, chunk, chunk.state)
    _stored(-1.0, chunk, chunk.states)
    return status


def _stored(share: float, chunk: Chunk, states: np.ndarray) -> None:
    """Adds a share of what contacts of neighbours store [J] to losses in states (..., N, COLUMNS), in place."""
    if np.count_nonzero(chunk.near):  # in a fifth of the time of `any`
        count = states.size // chunk.state.size
        _add_stored(*numbers_of(chunk.bearing), len(chunk.near), chunk.near, share, count, states)


def _by_core(stepper: str, chunk: Chunk) -> int:
    family, numbers = IMEX, NO_NUMBERS
    if stepper in EXPLICIT:
        family, numbers = RUNGE_KUTTA, runge_kutta_numbers(stepper)
    elif stepper in ROSENBROCK:
        family, numbers = LINEARLY_IMPLICIT, method_numbers(stepper)
    bodies = chunk.bodies
    return _integrate(
        *(*numbers_of(chunk.bearing), family, numbers, numbers_of_bodies(chunk.bearing, bodies)),
        *(bodies.load, bodies.load_rate, np.array(chunk.drive, float), chunk.scales, chunk.step, chunk.duration),
        *(len(chunk.times), chunk.times, chunk.stop, len(chunk.state), chunk.near),
        *(chunk.state, chunk.orientation, chunk.steps, chunk.carried, chunk.body_state),
        *(chunk.states, chunk.orientations, chunk.body_states, chunk.counts, chunk.failure),
    )


def check(status: int, elapsed: float, failure: np.ndarray) -> None:
    """Raises Stopped or IntegrationError for a status that is not OK of what began at `elapsed` [s]."""
    if status == STOPPED:
        raise Stopped(f"the computation was stopped at {elapsed:.9g} s")
    if status != OK:
        seconds, body = elapsed + failure[0], f"ball {int(failure[1])}"
        raise IntegrationError(f"at {seconds:.9g} s {body} {FAILURES[status]}", REASONS[status], seconds, body)


# Where balls have steps of their own, only those that may soon meet share steps, and only for a while: balls that share
# a step go at the pace of the one with the shortest, and repeat their steps where one lands, so that 20 ms of balls
# that hop cost 15 times as much.
NEAR = 0.05  # gap / ball radius below which two balls may meet
MET = 0.5 * NEAR  # the same of balls that came together
SOON = 1e-3  # s for which balls that may meet are integrated together before the next look
LONGER, SHORTER = 2.0, 0.25  # of stretches in which none may meet: after one in which none did, and after another
EVERYWHERE = 1e9  # m: a gap that no two balls that can meet exceed

_mark_near = Function("core_mark_near", None, (REAL, REALS, INTEGER, REAL, REAL, FLAGS_OUT))
_mark_met = Function("core_mark_met", INTEGER, (REAL, REALS, INTEGER, REALS, INTEGER, REAL, FLAGS_OUT))
_time_apart = Function("core_time_apart", REAL, (REAL, REALS, INTEGER, REAL))


def time_apart(ball_radius: float, state: np.ndarray) -> float:
    """Seconds for which no two balls come nearer than NEAR, by their present speeds."""
    return _time_apart(ball_radius, state, len(state), NEAR * ball_radius)


def mark_near(ball_radius: float, state: np.ndarray, ahead: float, near: np.ndarray, reach: float = 0.0) -> None:
    """Sets `near` (N,) where two may come closer than `reach` [m], else NEAR, within `ahead` [s]."""
    _mark_near(ball_radius, state, len(state), reach or NEAR * ball_radius, ahead, near)


def mark_met(ball_radius: float, state: np.ndarray, states: np.ndarray, near: np.ndarray) -> bool:
    """Sets `near` (N,) for those who have met, now or in `states` (instants, N, ...); whether any was not set."""
    return bool(_mark_met(ball_radius, state, len(state), states, len(states), MET * ball_radius, near))


def instants_in(times: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Those `times` [s] of a chunk, within rounding of its part from `begin` to `end`, as counted from its begin."""
    return np.minimum(times - begin, end - begin)


def integrate_in_common(
    integrate: Callable, radius: float, moving, times: np.ndarray, duration: float, filled, apart: bool, even: bool
) -> None:
    """Integrates a part of balls that share steps with a ring or a cage, or that are kept `apart`.

    Where two met that were not near, which no `even` cage lets them, once more with all near. See `integrate_alone`.
    """
    before, near = [one.copy() for one in moving], np.zeros(len(moving[0]), np.bool_)
    if not apart:
        mark_near(radius, moving[0], duration, near)
    integrate(near, 0.0, times, duration, filled)
    if even or not mark_met(radius, moving[0], filled[0], near):
        return
    _put_back(moving, before)
    mark_near(radius, moving[0], 0.0, near, EVERYWHERE)
    integrate(near, 0.0, times, duration, filled)


def _put_back(moving, before) -> None:
    for one, kept in zip(moving, before, strict=True):
        one[:] = kept


def integrate_alone(integrate: Callable, radius: float, moving, times: np.ndarray, duration: float, filled) -> None:
    """Integrates a part of balls that act on each other only where they touch.

    `integrate(near, begin, times, duration, filled)` moves the arrays `moving`, the state (N, ...) first, on over
    `duration` [s] from `begin` [s] of the part and fills the arrays of `filled` at `times` [s] from there. A stretch in
    which two met that were not near is done again, shorter or with them near. Raises what `integrate` raises.
    """
    first, begin, ahead = 0, 0.0, duration
    met = np.zeros(len(moving[0]), np.bool_)
    while begin < duration:
        left, near = duration - begin, met.copy()
        mark_near(radius, moving[0], min(SOON, left), near)
        near |= met
        length = min(SOON if near.any() else ahead, left)
        ends = length >= left - NOTHING * duration
        long, length = length > SOON, left if ends else length  # the last one may be longer than SOON by rounding
        last = len(times) if ends else int(np.searchsorted(times, begin + length, side="right"))
        before, into = [one.copy() for one in moving], tuple(one[first:last] for one in filled)
        integrate(near, begin, instants_in(times[first:last], begin, begin + length), length, into)
        found = near.copy()
        if mark_met(radius, moving[0], into[0], found):
            _put_back(moving, before)
            # Found late in a long stretch: up to there they are alone.
            met, ahead = (met, max(SHORTER * length, SOON)) if long else (found, ahead)
            continue
        met, ahead = np.zeros_like(met), max(LONGER * length, SOON)
        first, begin = last, duration if ends else begin + length


def _by_scipy(name: str, chunk: Chunk) -> int:
    """Integrates a chunk of all balls together, by a SciPy solver's class; raises Stopped where it is to stop."""
    from scipy import integrate  # late: these methods are for charts and tests

    drive, times, shape = chunk.drive, chunk.times, chunk.state.shape
    scales = REFERENCE_SHARE * chunk.scales[:MOTION]

    def right_hand_side(time, flat):
        if chunk.stop[0] != 0:
            raise Stopped("the computation was stopped within a chunk")
        now, state = drive.later(time), np.ascontiguousarray(flat.reshape(shape))
        return rates(chunk.bearing, now.speed, chunk.near, state, now.angle).ravel()

    method = getattr(integrate, name)(
        right_hand_side,
        0.0,
        chunk.state.ravel().copy(),
        chunk.duration,
        rtol=2.3e-14,
        atol=np.tile(np.concatenate([scales, [1e-12] * (COLUMNS - MOTION)]), len(chunk.state)),
        first_step=min(1e-7, chunk.duration),
    )
    cursor = 0
    while method.status == "running":
        # SciPy probes the integrals, on which nothing depends, with ever greater increments.
        with np.errstate(over="ignore"):
            method.step()
        finite = np.isfinite(method.y.reshape(shape)).all(axis=1)
        if method.status == "failed" or not finite.all():
            fastest = np.abs(right_hand_side(method.t, method.y).reshape(shape)[:, :MOTION] / scales).max(axis=1)
            chunk.failure[:] = method.t, fastest.argmax() if finite.all() else finite.argmin()
            return NOT_FINITE if not finite.all() else STALLED
        dense = method.dense_output()
        start = dense(method.t_old).reshape(shape)
        while cursor < len(times) and times[cursor] <= method.t:
            _turn_all(dense, method.t_old, times[cursor], start, chunk.orientation, chunk.orientations[cursor])
            chunk.states[cursor] = dense(times[cursor]).reshape(shape)
            cursor += 1
        _turn_all(dense, method.t_old, method.t, start, chunk.orientation, chunk.orientation)
    chunk.state[:] = method.y.reshape(shape)
    for number, cost in ((STEPS, method.nfev // 12), (EVALUATIONS, method.nfev), (JACOBIANS, method.njev)):
        chunk.counts[number] += cost * len(chunk.state)
    return OK


def _turn_all(dense, begin, end, start, orientation, out):
    middle, last = (dense(t).reshape(start.shape) for t in (0.5 * (begin + end), end))
    out[:] = turned(orientation, *map(_spin_in_frame, (start, middle, last)), end - begin)


def _spin_in_frame(state):
    """Angular velocities (N, 3) [rad/s] of balls (N, COLUMNS) against the frame that turns with each about the axis."""
    axial = state[:, AXIAL_SPIN] - state[:, TANGENTIAL_VELOCITY] / state[:, AXIS_DISTANCE]
    return np.stack([state[:, RADIAL_SPIN], state[:, TANGENTIAL_SPIN], axial], axis=1)


# Errors and lengths of steps.

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


FIXED_STEP = tuple(name for name, facts in STEPPER_FACTS.items() if not facts.adaptive)
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
