"""Steps of an ellipsoid on a plane: flight to the next touch, contact to the next separation, nothing stepped over.

In flight the approach bends at most by  B = g + w^2 (spread + 2 lean)  (w: greatest angular velocity at this angular
momentum), so from a gap it stays one until h + h' t + B t^2/2 = 0, and so on from there: quadratic convergence to the
touch, which is known to a few roundings of the height. In contact a step is at most a sixth of 1/sqrt(k/m) at the
greatest stiffness ahead, some 24 a bounce, more in one that lasts; separation is the zero of the approach as a function of the last step's
length. Outputs are steps of their own from the start of the step they fall into, so they do not touch the motion.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.motion.steppers import Explicit, next_step
from bearing_twin.scenes.ellipsoid_on_plane import (
    COLUMNS,
    MOMENTUM,
    POSITION,
    QUATERNION,
    SHAPE,
    VELOCITY,
    VISCOUS,
    begin_shape,
    ellipsoid_rates,
    finish_shape,
    gap_of,
    pose_of,
    touch_of,
)

OK, FULL, NOT_FINITE, TOO_DEEP, STALLED = range(5)
STEPS, REJECTIONS, EVALUATIONS, TOUCHES = range(4)
COUNTS = 4

TIME, STEP, IN_CONTACT, DRIFT, CURSOR = range(5)
CLOCK = 5
"""Of the clock: seconds, next step, whether in contact, greatest drift of the quaternion's norm, outputs written."""

(
    BEGAN, ENDED, PEAK_LOAD, PEAK_APPROACH, PEAK_SMALL, PEAK_LARGE, SPEED_IN, SPEED_OUT,
    IMPULSE_X, IMPULSE_Y, IMPULSE_Z, LOAD_BEFORE, LOAD_LAST, LAST_STEP,
) = range(14)  # fmt: skip
RECORD = 14
"""Of a contact: times [s], peak load [N] with approach and curvatures there, speeds [m/s], impulse [N s]; work room."""

FIRST_STEP = 1e-6  # of the contact time expected: loads begin as t^1.5, viscous ones as t^0.25, which no method likes
RESOLUTION = 1.0 / 6.0  # of 1/sqrt(k/m), in a bounce; its contact lasts 4 of them
LASTING, RESTING = 20.0, 2.0  # of 1/sqrt(k/m): beyond the first a contact is no bounce; the error control sets the step
LONGEST_FLIGHT = 1.0  # s a step
FLIGHT_TURN = 0.02  # rad a step of a fixed-step method in flight
DEEPEST = 0.5  # of the shortest semi-axis
ROUNDING = 1e-15  # of the body's size: gaps below are none


class Plan(NamedTuple):
    """How to step: an `Explicit` method, its tolerance, its fixed step in contact [s] (0 = adaptive).

    `spread` and `lean` [m] bound how fast the body's extent downwards bends when it turns, `floor` [s] is the shortest
    step: lift-offs and touches shorter than that are passed.
    """

    method: Explicit
    tolerance: float
    fixed: float
    spread: float
    lean: float
    floor: float


class Work(NamedTuple):
    """Arrays to work in: stages (stages, COLUMNS), a trial state, the state after a step and that before the last."""

    stages: np.ndarray
    trial: np.ndarray
    after: np.ndarray
    before: np.ndarray
    scales: np.ndarray


@kernel
def one_step(body, plan, state, step, loaded, work, out):
    """Writes the state `step` [s] later, in contact (`loaded`) or flight; returns the error estimate in units of `work.scales` (0 = fixed step)."""
    method = plan.method
    stages = len(method.b)
    for i in range(stages):
        work.trial[:] = state
        for j in range(i):
            weight = step * method.a[i, j]
            if weight != 0.0:
                for n in range(COLUMNS):
                    work.trial[n] += weight * work.stages[j, n]
        ellipsoid_rates(body, work.trial, loaded, work.stages[i])
    out[:] = state
    fifth = third = 0.0
    for n in range(COLUMNS):
        change = wide = narrow = 0.0
        for i in range(stages):
            change += method.b[i] * work.stages[i, n]
            wide += method.fifth[i] * work.stages[i, n]
            narrow += method.third[i] * work.stages[i, n]
        out[n] += step * change
        fifth += (wide / work.scales[n]) ** 2
        third += (narrow / work.scales[n]) ** 2
    if fifth == 0.0:
        return 0.0
    return step * fifth / math.sqrt((fifth + 0.01 * third) * COLUMNS)


@kernel
def fill(array, first, count, value):
    """Sets `count` entries from `first`."""
    for i in range(first, first + count):
        array[i] = value


@kernel
def expected_approach(touch):
    """Greatest approach [m] from here on by Hertz's impact, about: what the scales of a step follow."""
    spent = (1.25 * touch.effective_mass * touch.approach_rate**2 / touch.coefficient) ** 0.4
    return max(touch.approach, 0.0) + spent


@kernel
def contact_scales(body, plan, state, lasted, work):
    """Sets the error scales from the contact ahead; returns the longest step [s] for one that has `lasted` [s]."""
    touch = touch_of(body, state, pose_of(body, state))
    ahead = expected_approach(touch)
    size = max(body.semi_axes[0], max(body.semi_axes[1], body.semi_axes[2]))
    rate = math.sqrt(1.5 * touch.coefficient * math.sqrt(ahead) / touch.effective_mass)
    speed = ahead * rate
    fill(work.scales, POSITION, 3, max(plan.tolerance * ahead, ROUNDING * (abs(state[2]) + size)))
    fill(work.scales, QUATERNION, 4, max(plan.tolerance * ahead / size, ROUNDING))
    fill(work.scales, VELOCITY, 3, max(plan.tolerance * speed, ROUNDING * size * rate))
    fill(work.scales, MOMENTUM, 3, max(plan.tolerance * speed, ROUNDING * size * rate) * body.mass * size)
    fill(work.scales, VISCOUS, 2, max(plan.tolerance * speed, ROUNDING * size * rate) * body.mass * speed)
    fill(work.scales, SHAPE, 3, 10.0 * max(plan.tolerance, ROUNDING))
    return (RESOLUTION if lasted * rate < LASTING else RESTING) / rate


@kernel
def flight_scales(body, plan, work):
    """Sets the error scales of flight, where only the orientation has an error."""
    fill(work.scales, 0, COLUMNS, math.inf)
    fill(work.scales, QUATERNION, 4, plan.tolerance)


@kernel
def greatest_spin(body, state):
    """No angular velocity [rad/s] is greater at this angular momentum."""
    momentum = math.sqrt(state[10] ** 2 + state[11] ** 2 + state[12] ** 2)
    return momentum / min(body.inertia[0], min(body.inertia[1], body.inertia[2]))


@kernel
def safe_flight(body, plan, state):
    """Time [s] in which no touch is possible from a state in flight; inf where there is none for ever."""
    approach, rate = gap_of(body, state)
    gap = max(-approach, 0.0)
    bend = body.gravity + greatest_spin(body, state) ** 2 * (plan.spread + 2.0 * plan.lean)
    if bend == 0.0:
        return gap / rate if rate > 0.0 else math.inf
    root = math.sqrt(rate * rate + 2.0 * bend * gap)
    return 2.0 * gap / (root + rate) if rate > 0.0 else max((root - rate) / bend, plan.floor)


@kernel
def landed(body, state):
    """Whether the gap is closed, or so nearly that no number can tell, and not opening."""
    approach, rate = gap_of(body, state)
    size = max(body.semi_axes[0], max(body.semi_axes[1], body.semi_axes[2]))
    return approach > 0.0 or (rate > 0.0 and approach >= -ROUNDING * (abs(state[2]) + size))


@kernel
def adaptive_step(body, plan, state, wanted, loaded, counts, work):
    """Takes the longest step up to `wanted` [s] that meets the tolerance; returns (step, the next to try, error)."""
    step = wanted
    while True:
        error = one_step(body, plan, state, step, loaded, work, work.after)
        counts[EVALUATIONS] += len(plan.method.b)
        if error <= 1.0:
            return step, next_step(step, error, plan.method.order) if plan.fixed == 0.0 else math.inf
        counts[REJECTIONS] += 1
        if not step > 1e-9 * plan.floor:
            return -1.0, step
        step = next_step(step, error, plan.method.order)


@kernel
def separation(body, plan, state, step, counts, work):
    """Length [s] of the step at whose end the bodies part, between contact at its start and a gap after `step`.

    Regula falsi with Illinois' weights on the approach; the state there is left in `work.after`.
    """
    low, high = 0.0, step
    approach_low, _ = gap_of(body, state)
    approach_high, _ = gap_of(body, work.after)
    side, length = 0, step
    for _ in range(100):
        length = (low * approach_high - high * approach_low) / (approach_high - approach_low)
        if not low < length < high:
            length = 0.5 * (low + high)
        one_step(body, plan, state, length, True, work, work.after)
        counts[EVALUATIONS] += len(plan.method.b)
        approach, _ = gap_of(body, work.after)
        if approach > 0.0:
            low, approach_low = length, approach
            approach_high = 0.5 * approach_high if side == 1 else approach_high
            side = 1
        else:
            high, approach_high = length, approach
            approach_low = 0.5 * approach_low if side == -1 else approach_low
            side = -1
        if approach <= 0.0 and (approach >= -ROUNDING * (abs(state[2]) + 1e-3) or high - low <= 4e-16 * step):
            break
    if approach > 0.0:
        length = high
        one_step(body, plan, state, high, True, work, work.after)
    return length


@kernel
def note_peak(body, plan, state, step, record, counts, work, spare):
    """Keeps the greatest load of a contact: where three ends of steps show a peak, the load at their parabola's top.

    `state` is the start of the step whose end is in `work.after`; `work.before` the start of the step before.
    """
    load = touch_of(body, work.after, pose_of(body, work.after)).normal_load
    first, middle, back = record[LOAD_BEFORE], record[LOAD_LAST], record[LAST_STEP]
    if middle >= first and middle > load and middle > 0.9 * record[PEAK_LOAD] and back > 0.0:
        rise, fall = (middle - first) / back, (load - middle) / step
        top = 0.5 * (rise * step + fall * back) / (rise - fall)
        top = min(max(top, -back), step)
        if top >= 0.0:
            one_step(body, plan, state, top, True, work, spare)
        else:
            one_step(body, plan, work.before, back + top, True, work, spare)
        counts[EVALUATIONS] += len(plan.method.b)
        keep_peak(touch_of(body, spare, pose_of(body, spare)), record)
    keep_peak(touch_of(body, state, pose_of(body, state)), record)
    record[LOAD_BEFORE], record[LOAD_LAST], record[LAST_STEP] = middle, load, step


@kernel
def keep_peak(touch, record):
    """Takes a load into the record if it is the greatest so far."""
    if touch.normal_load > record[PEAK_LOAD]:
        record[PEAK_LOAD], record[PEAK_APPROACH] = touch.normal_load, touch.approach
        record[PEAK_SMALL], record[PEAK_LARGE] = touch.curvature_small, touch.curvature_large


@kernel
def begin_contact(body, plan, state, clock, record):
    """Opens the record of a contact at this state; the next step suits its onset."""
    begin_shape(body, state)
    touch = touch_of(body, state, pose_of(body, state))
    record[:] = 0.0
    record[BEGAN], record[ENDED], record[SPEED_IN] = clock[TIME], math.nan, touch.approach_rate
    record[IMPULSE_X], record[IMPULSE_Y], record[IMPULSE_Z] = state[7], state[8], state[9]
    clock[IN_CONTACT] = 1.0
    speed = max(touch.approach_rate, 1e-300)
    if plan.fixed > 0.0:
        clock[STEP] = plan.fixed
    else:
        clock[STEP] = max(FIRST_STEP * 2.943 * expected_approach(touch) / speed, plan.floor)


@kernel
def end_contact(body, state, clock, record):
    """Completes the record: `state` is that of the separation."""
    touch = touch_of(body, state, pose_of(body, state))
    record[ENDED], record[SPEED_OUT] = clock[TIME], -touch.approach_rate
    record[IMPULSE_X] = body.mass * (state[7] - record[IMPULSE_X])
    record[IMPULSE_Y] = body.mass * (state[8] - record[IMPULSE_Y])
    record[IMPULSE_Z] = body.mass * (
        state[9] - record[IMPULSE_Z] + body.gravity * (record[ENDED] - record[BEGAN])
    )
    clock[IN_CONTACT], clock[STEP] = 0.0, math.inf


@kernel
def commit(body, state, step, clock, counts, work):
    """Takes the step: the quaternion is brought back to unit length, its drift kept."""
    if clock[IN_CONTACT] > 0.0:
        finish_shape(body, work.after)
    norm = math.sqrt(work.after[3] ** 2 + work.after[4] ** 2 + work.after[5] ** 2 + work.after[6] ** 2)
    clock[DRIFT] = max(clock[DRIFT], abs(norm - 1.0))
    for i in range(QUATERNION, QUATERNION + 4):
        work.after[i] /= norm
    work.before[:] = state
    state[:] = work.after
    clock[TIME] += step
    counts[STEPS] += 1


@kernel
def write_outputs_until(body, plan, state, clock, end, times, states, work, spare):
    """States at the output times up to `end` [s], each by a step of its own from the start of this one."""
    loaded = clock[IN_CONTACT] > 0.0
    while clock[CURSOR] < len(times) and times[int(clock[CURSOR])] <= end:
        row = int(clock[CURSOR])
        one_step(body, plan, state, times[row] - clock[TIME], loaded, work, spare)
        states[row] = spare
        clock[CURSOR] += 1.0


@kernel
def advance(body, plan, state, clock, times, until, states, record, records, counts, work):
    """Steps from the clock's time until `until` [s] lies in the next step; returns (status, contacts completed).

    `states` (outputs, COLUMNS) receives the states at `times` [s]; completed contacts go to `records`. A step that
    reaches beyond `until` is not taken, so the motion does not depend on how it is cut.
    """
    completed, spare = 0, np.empty(COLUMNS)
    shortest = min(body.semi_axes[0], min(body.semi_axes[1], body.semi_axes[2]))
    while True:
        if clock[IN_CONTACT] == 0.0 and landed(body, state):
            begin_contact(body, plan, state, clock, record)
            counts[TOUCHES] += 1
        contact = clock[IN_CONTACT] > 0.0
        if contact:
            longest = contact_scales(body, plan, state, clock[TIME] - record[BEGAN], work)
            wanted = min(clock[STEP], plan.fixed if plan.fixed > 0.0 else longest)
        else:
            flight_scales(body, plan, work)
            wanted = min(clock[STEP], min(safe_flight(body, plan, state), LONGEST_FLIGHT))
            if plan.fixed > 0.0:
                wanted = min(wanted, FLIGHT_TURN / max(greatest_spin(body, state), 1e-9))
        step, following = adaptive_step(body, plan, state, wanted, contact, counts, work)
        if step < 0.0:
            return STALLED, completed
        ended = False
        if contact:
            approach, _ = gap_of(body, work.after)
            if approach <= 0.0:
                ended = True
                start, _ = gap_of(body, state)
                if start > ROUNDING * (abs(state[2]) + shortest):
                    step = separation(body, plan, state, step, counts, work)
                elif step > plan.floor:
                    clock[STEP] = 0.25 * step  # a touch that leaves at once: find out how long it lasts
                    continue
            if approach > DEEPEST * shortest:
                return TOO_DEEP, completed
        if not np.all(np.isfinite(work.after)):
            return NOT_FINITE, completed
        end = clock[TIME] + step
        if end > until:
            write_outputs_until(body, plan, state, clock, until, times, states, work, spare)
            return OK, completed
        write_outputs_until(body, plan, state, clock, end, times, states, work, spare)
        if contact:
            note_peak(body, plan, state, step, record, counts, work, spare)
        commit(body, state, step, clock, counts, work)
        clock[STEP] = following
        if ended:
            end_contact(body, state, clock, record)
            records[completed] = record
            completed += 1
            if completed == len(records):
                return FULL, completed
