"""Integration of a part of a chunk by any stepper, and errors and lengths of its steps.

Steppers move balls alone, balls that may touch, or all with ring, cage and shaft. Methods of SciPy, for reference,
integrate the same equations.

Error scales. The error of a load follows from that of its approach; that of friction, over mu N, from those of the
slip, over the speed of its regularisation, and of the load N. A ball that vibrates between its contacts at the rate w
with an amplitude v of its radial velocity has an error of m w v in load. This vibration is hardly damped, so that the
errors of many steps add up, and they matter most for light contacts: without a scale of the radial velocity, runs with
lift-off missed their tolerance in friction 4 to 19 times, with it 0.4 to 0.7 times. The lightest contact whose friction
counts carries LIGHT of the greatest load. Slip of a ball that carries less counts as much less (`light_approach`).
Every impact on a pocket changes a ball's speed along its orbit: there such errors count by the load
(`groove_error_weight` of `core/bearing/elements.hpp`), else balls that carry next to nothing determine all steps.

Fixed steps. Two motions of a ball are fast: vibration between its contacts, x'' + c x' + w^2 x = 0, and decay of slip,
at the rate 5 mu N / (m v_s) between two contacts with the load N each. A method is stable where it damps both. `imex`
takes friction and damping implicitly, so that only w limits it: 2/w, the limit of leapfrog. `rk4` beyond its limit by
friction still gives right loads, but wrong friction. Where balls slide, `imex` has a limit by friction, too. A slip s,
in units of v_s, with friction f(s) = s/sqrt(1 + s^2) steps to s - z f/(1 + z f'/2), z = rate * step. For z >= 3 sqrt(3)
there is an s that steps to -s, so that slip never ends. Below, and for balls that roll from the start, it decays.
"""

import cmath
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, SceneError, Stopped
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
from bearing_twin.shapes import rotate_by_step

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
    """Rates (N, COLUMNS) of all balls in a state (N, COLUMNS); near[k] says whether ball k may touch the next ahead."""
    derivative = np.empty_like(state)
    _all_rates(*numbers_of(bearing), float(ring_speed), float(ring_angle), len(state), near, state, derivative)
    return derivative


def integrate_chunk(stepper: str, chunk: Chunk) -> int:
    """Integrate a chunk and return its status."""
    return _by_scipy(SCIPY[stepper], chunk) if stepper in SCIPY else _by_core(stepper, chunk)


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


def check_status(status: int, elapsed: float, failure: np.ndarray) -> None:
    """Raise Stopped or IntegrationError for the status of an integration from `elapsed` [s] on, unless it is OK."""
    if status == STOPPED:
        raise Stopped(f"the computation was stopped at {elapsed:.9g} s")
    if status != OK:
        seconds, body = elapsed + failure[0], f"ball {int(failure[1])}"
        raise IntegrationError(f"at {seconds:.9g} s {body} {FAILURES[status]}", REASONS[status], seconds, body)


# If each ball has its own steps, only those that may soon meet share steps, and only for a while: balls in common steps
# take the shortest, and repeat their steps when one lands, so that 20 ms of balls that hop cost 15 times as much.
NEAR_GAP = 0.05  # gap / ball radius below which two balls may meet
MEETING_GAP = 0.5 * NEAR_GAP  # the same of balls that met
SOON = 1e-3  # s for which balls that may meet are integrated together before their gaps are checked
LONGER, SHORTER = 2.0, 0.25  # factors of the length of a stretch after one without a meeting, and after one with
EVERYWHERE = 1e9  # m: greater than all gaps

_mark_near = Function("core_mark_near", None, (REAL, REALS, INTEGER, REAL, REAL, FLAGS_OUT))
_mark_met = Function("core_mark_met", INTEGER, (REAL, REALS, INTEGER, REALS, INTEGER, REAL, FLAGS_OUT))
_time_apart = Function("core_time_apart", REAL, (REAL, REALS, INTEGER, REAL))


def time_separated(ball_radius: float, state: np.ndarray) -> float:
    """Seconds for which no two balls come nearer than NEAR_GAP, by their present speeds."""
    return _time_apart(ball_radius, state, len(state), NEAR_GAP * ball_radius)


def mark_near(ball_radius: float, state: np.ndarray, ahead: float, near: np.ndarray, reach: float = 0.0) -> None:
    """Set `near` (N,) where two may come closer than `reach` [m], by default NEAR_GAP, within `ahead` [s]."""
    _mark_near(ball_radius, state, len(state), reach or NEAR_GAP * ball_radius, ahead, near)


def mark_met(ball_radius: float, state: np.ndarray, states: np.ndarray, near: np.ndarray) -> bool:
    """Set `near` (N,) for balls that have met, now or in `states` (instants, N, ...); True if any was not set."""
    return bool(_mark_met(ball_radius, state, len(state), states, len(states), MEETING_GAP * ball_radius, near))


def instants_in(times: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Times [s] of a chunk in its part from `begin` to `end` [s], counted from the part's begin."""
    return np.minimum(times - begin, end - begin)


def integrate_in_common(
    integrate: Callable, radius: float, moving, times: np.ndarray, duration: float, filled, separated: bool, even: bool
) -> None:
    """Integrate a part of balls that share steps with a ring or a cage, or that are kept `separated`.

    It is repeated with all balls near if two met that were not, which an `even` cage prevents. See `integrate_alone`.
    """
    before, near = [array.copy() for array in moving], np.zeros(len(moving[0]), np.bool_)
    if not separated:
        mark_near(radius, moving[0], duration, near)
    integrate(near, 0.0, times, duration, filled)
    if even or not mark_met(radius, moving[0], filled[0], near):
        return
    _restore(moving, before)
    mark_near(radius, moving[0], 0.0, near, EVERYWHERE)
    integrate(near, 0.0, times, duration, filled)


def _restore(moving, before) -> None:
    for array, saved in zip(moving, before, strict=True):
        array[:] = saved


def integrate_alone(integrate: Callable, radius: float, moving, times: np.ndarray, duration: float, filled) -> None:
    """Integrate a part of balls that act on each other only by contact.

    `integrate(near, begin, times, duration, filled)` moves the arrays `moving`, the state (N, ...) first, on over
    `duration` [s] from `begin` [s] of the part and fills the arrays of `filled` at `times` [s] from there. A stretch in
    which two met that were not near is repeated, shorter or with them near. Raises what `integrate` raises.
    """
    first, begin, ahead = 0, 0.0, duration
    met = np.zeros(len(moving[0]), np.bool_)
    while begin < duration:
        remaining, near = duration - begin, met.copy()
        mark_near(radius, moving[0], min(SOON, remaining), near)
        near |= met
        length = min(SOON if near.any() else ahead, remaining)
        ends = length >= remaining - NOTHING * duration
        long, length = length > SOON, remaining if ends else length  # the last one may be longer than SOON by rounding
        last = len(times) if ends else int(np.searchsorted(times, begin + length, side="right"))
        before, filled_part = [array.copy() for array in moving], tuple(array[first:last] for array in filled)
        integrate(near, begin, instants_in(times[first:last], begin, begin + length), length, filled_part)
        now_met = near.copy()
        if mark_met(radius, moving[0], filled_part[0], now_met):
            _restore(moving, before)
            # In a long stretch the meeting may be late: repeat a shorter one first.
            met, ahead = (met, max(SHORTER * length, SOON)) if long else (now_met, ahead)
            continue
        met, ahead = np.zeros_like(met), max(LONGER * length, SOON)
        first, begin = last, duration if ends else begin + length


def _by_scipy(name: str, chunk: Chunk) -> int:
    """Integrate a chunk of all balls together by a solver of SciPy; raises Stopped if it is interrupted."""
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
        # Finite differences by the integrals, on which nothing depends, may overflow.
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
    for count, cost in ((STEPS, method.nfev // 12), (EVALUATIONS, method.nfev), (JACOBIANS, method.njev)):
        chunk.counts[count] += cost * len(chunk.state)
    return OK


def _turn_all(dense, begin, end, start, orientation, out):
    middle, last = (dense(t).reshape(start.shape) for t in (0.5 * (begin + end), end))
    out[:] = rotate_by_step(orientation, *map(_relative_spin, (start, middle, last)), end - begin)


def _relative_spin(state):
    """Angular velocities (N, 3) [rad/s] of balls (N, COLUMNS) against the frame that turns with each about the axis."""
    axial = state[:, AXIAL_SPIN] - state[:, TANGENTIAL_VELOCITY] / state[:, AXIS_DISTANCE]
    return np.stack([state[:, RADIAL_SPIN], state[:, TANGENTIAL_SPIN], axial], axis=1)


# Errors and lengths of steps.

APPROACH_SCALE = 1e-6  # m, the size of an elastic approach: errors of position count against it
STEP_SHARE = 0.2  # of the requested accuracy, for one adaptive step: `chart steppers`, docs/accuracy.md
LIGHT = 0.01  # of the greatest load
LOST_SHARE = 10.0  # of what the heaviest contact stores, at a tolerance of 1: a start from rest heats by that
# With these two, vibrating balls and loaded rings meet their tolerance: `tests/core/algorithms/test_error_scales.py`.
RINGING_SHARE = 0.08  # of the error of a ball that vibrates: one step of a ball with its own steps
COMMON_SHARE = 4.0  # the same in common steps, which one ball determines whose vibration soon ends
STRICTEST, LOOSEST = 0.1, 16.0  # of an error of radial velocity, over one of slip


def light_approach(bearing: Bearing, approaches: np.ndarray) -> float:
    """The approach [m] of an outer contact that carries LIGHT of the greatest load of `approaches` (N, 2)."""
    return max(float(approaches[:, 1].max()), APPROACH_SCALE) * LIGHT ** (1.0 / bearing.outer.law.power)


def error_scales(
    parameters: BearingScene, bearing: Bearing, start: np.ndarray, approaches: np.ndarray, together: bool
) -> np.ndarray:
    """Errors (MOTION + 1,) that a step of a ball may make at a tolerance of 1, for balls at `start` (N, COLUMNS).

    The last [J] is that of dissipated energy, LOST_SHARE of what the heaviest contact stores, at least at an approach
    of APPROACH_SCALE. `approaches` (N, 2) [m] are those at the start. In common steps (`together`), of the length of
    the shortest, errors of the other balls hardly add up.
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
LEAST_APPROACH = 1e-6  # m: of contacts that may be loaded later
STEPS_A_CONTACT = 16  # of an automatic step
FRICTION_SHARE = 0.5  # of the stability limit by friction and damping, of an automatic step
LIMIT_ACCURACY = 1e-6  # relative, of stability limits
EQUAL_RATES = 1e-9  # relative: balls whose rates differ by less have equal ones
SLIP_CYCLE = 3.0 * math.sqrt(3.0) / 0.7  # the friction rate of a ball that slides on one raceway is 0.7 of the fastest


class Rates(NamedTuple):
    """The fastest rates of a state [1/s]: contact resonance w, friction creep, damping c; the shortest contact [s].

    `ringing` and `creeping` are the balls that have the first two, the first of those with equal rates.
    """

    contact: float
    friction: float
    damping: float
    shortest_contact: float
    ringing: int = 0
    creeping: int = 0


def _greatest_slip_decay(inner: float, outer: float) -> float:
    """Fastest decay of slip times m v_s/mu [N] for the loads [N] of two opposite contacts of a ball.

    The greater root for sliding and rotation of the ball, which unequal loads couple: 5 N for two loads N, 3.5 N for
    one.
    """
    total, difference = inner + outer, inner - outer
    return 0.5 * (3.5 * total + math.sqrt(2.25 * total**2 + 10.0 * difference**2))


def fastest_rates(bearing: Bearing, approaches: np.ndarray) -> Rates:
    """The fastest rates to be expected of balls with these approaches (N, 2) [m].

    A ball between two contacts vibrates with the sum of their stiffnesses, which is greatest for equal approaches. The
    shortest contact is half a period of the contact resonance.
    """
    inner, outer = bearing.inner.law, bearing.outer.law
    stiffness, viscous, grip, ringing, creeping = 0.0, 0.0, 0.0, 0, 0
    for k, depths in enumerate(np.maximum(approaches, 0.0).tolist()):
        middle = max(LEAST_APPROACH, 0.5 * sum(depths))
        even = elastic(inner.given + outer.given, inner.power, middle)
        loads = (elastic(law.given, law.power, depth).load for law, depth in zip((inner, outer), depths, strict=True))
        friction_load = max(_greatest_slip_decay(0.5 * even.load, 0.5 * even.load), _greatest_slip_decay(*loads))
        ringing = k if even.stiffness > (1.0 + EQUAL_RATES) * stiffness else ringing
        creeping = k if friction_load > (1.0 + EQUAL_RATES) * grip else creeping
        stiffness, viscous, grip = max(stiffness, even.stiffness), max(viscous, even.load), max(grip, friction_load)
    friction = bearing.friction_coefficient * grip / (bearing.friction_regularisation * bearing.ball_mass)
    contact = math.sqrt(stiffness / bearing.ball_mass)
    damping = (bearing.damping * viscous + bearing.relaxation_time * stiffness) / bearing.ball_mass
    return Rates(contact, friction, damping, math.pi / contact, ringing, creeping)


def _growth_of_rk4(z: complex) -> float:
    """Amplification factor of the classical Runge-Kutta method at z = rate * step."""
    return abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))))


def _rk4_limit(rate: complex) -> float:
    """The longest step of rk4 [s] at which a motion of this rate [1/s] does not grow; infinite at rate 0."""
    if rate == 0.0:
        return math.inf
    stable, unstable, time_scale = 0.0, 1.0, 1.0 / abs(rate)
    while _growth_of_rk4(unstable * time_scale * rate) <= 1.0:
        stable, unstable = unstable, 1.1 * unstable
    while unstable - stable > LIMIT_ACCURACY * unstable:
        middle = 0.5 * (stable + unstable)
        stable, unstable = (middle, unstable) if _growth_of_rk4(middle * time_scale * rate) <= 1.0 else (stable, middle)
    return stable * time_scale


def stability_limits(rates: Rates, stepper: str, may_slide: bool = True) -> tuple[float, float]:
    """The longest stable steps [s] of a fixed-step method: by contact resonance, and by decay of slip.

    `may_slide` says whether a ball may slide on a raceway, as it does from rest and after a jump of the ring.
    """
    if stepper == "imex":
        return 2.0 / rates.contact, SLIP_CYCLE / rates.friction if may_slide and rates.friction else math.inf
    root = cmath.sqrt(0.25 * rates.damping**2 - rates.contact**2)
    ringing = (-0.5 * rates.damping + root, -0.5 * rates.damping - root)
    return min(map(_rk4_limit, ringing)), _rk4_limit(complex(-rates.friction))


def stable_step(rates: Rates, stepper: str, may_slide: bool = True) -> float:
    """A step [s] for a method with fixed steps: STEPS_A_CONTACT, and well below its stability limit."""
    return min(
        rates.shortest_contact / STEPS_A_CONTACT, FRICTION_SHARE * min(stability_limits(rates, stepper, may_slide))
    )


def step_problem(step: float, rates: Rates, stepper: str, may_slide: bool = True) -> tuple[str, str]:
    """Problem of a step [s] of a fixed-step method in a state with these rates, and its body; "" if there is none."""
    ringing, creeping = stability_limits(rates, stepper, may_slide)
    if step <= min(ringing, creeping):
        return "", ""
    advice = f"use {stable_step(rates, stepper, may_slide):.2g} s or less, or solver.stepper: rodas4"
    if ringing < creeping:
        body = f"ball {rates.ringing}"
        why = f"is too long: {body} rings between its contacts at {rates.contact:.2g} rad/s, where {stepper} is stable"
    else:
        body = f"ball {rates.creeping}"
        why = f"is unstable: friction answers at {rates.friction:.2g} /s on {body}, where {stepper} is right"
    return f"solver.step = {step:g} s {why} up to {min(ringing, creeping):.3g} s; {advice}", body


def step_at_start(parameters, rates: Rates, stepper: str) -> float:
    """The step [s] of a scene by a fixed-step method, its own or a stable one; raises SceneError if it is too long.

    `rates` are those at the start, where balls may slide if they are at rest.
    """
    may_slide = parameters.initial.motion == "rest"
    step = parameters.solver.step or stable_step(rates, stepper, may_slide)
    problem, _ = step_problem(step, rates, stepper, may_slide)
    if problem:
        raise SceneError(problem)
    return step
