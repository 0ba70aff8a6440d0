"""A chunk of the motion of an ellipsoid on a plane: steps taken, contacts kept, outputs written.

Outputs are steps of their own from the start of the step they fall into, and a step that reaches beyond the chunk is
left to the next one, so neither touches the motion.
"""

import math

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.ellipsoid.equations import (
    COLUMNS,
    QUATERNION,
    begin_shape,
    finish_shape,
    gap_of,
    pose_of,
    touch_of,
)
from bearing_twin.kinds.ellipsoid.steps import (
    ROUNDING,
    TOUCHES,
    adaptive_step,
    contact_scales,
    expected_approach,
    flight_scales,
    greatest_spin,
    landed,
    one_step,
    safe_flight,
    separation,
)
from bearing_twin.numerics.events import parabola_top
from bearing_twin.numerics.statuses import EVALUATIONS, FULL, NOT_FINITE, OK, STALLED, STEPS, STOPPED, TOO_DEEP

TIME, STEP, IN_CONTACT, DRIFT, CURSOR = range(5)
CLOCK = 5
"""Of the clock: seconds, next step, whether in contact, greatest drift of the quaternion's norm, outputs written."""

(
    BEGAN, ENDED, PEAK_LOAD, PEAK_APPROACH, PEAK_SMALL, PEAK_LARGE, PEAK_COEFFICIENT, SPEED_IN, SPEED_OUT,
    IMPULSE_X, IMPULSE_Y, IMPULSE_Z, LOAD_BEFORE, LOAD_LAST, LAST_STEP,
) = range(15)  # fmt: skip
RECORD = 15
"""Of a contact: times [s], peak load [N] with approach, curvatures and law's coefficient there, speeds [m/s], impulse
[N s] (velocities at the touch until it ends); the rest is work room."""

RECORDED = (
    ENDED, BEGAN, PEAK_LOAD, PEAK_APPROACH, PEAK_SMALL, PEAK_LARGE, PEAK_COEFFICIENT, SPEED_IN, SPEED_OUT,
    IMPULSE_X, IMPULSE_Y, IMPULSE_Z,
)  # fmt: skip
"""What is given out of a contact that has ended, in the order of the table `figures.CONTACT`."""

FIRST_STEP = 1e-6  # of the contact time expected: loads begin as t^1.5, viscous ones as t^0.25, which no method likes
LONGEST_FLIGHT = 1.0  # s a step
FLIGHT_TURN = 0.02  # rad a step of a fixed-step method in flight
DEEPEST = 0.5  # of the shortest semi-axis


@kernel
def note_peak(body, plan, state, step, record, counts, work, spare):
    """Keeps the greatest load of a contact: where three ends of steps show a peak, the load at their parabola's top.

    `state` is the start of the step whose end is in `work.after`; `work.before` the start of the step before.
    """
    load = touch_of(body, work.after, pose_of(body, work.after)).normal_load
    first, middle, back = record[LOAD_BEFORE], record[LOAD_LAST], record[LAST_STEP]
    if middle >= first and middle > load and middle > 0.9 * record[PEAK_LOAD] and back > 0.0:
        top = parabola_top(-back, 0.0, step, first, middle, load)
        if top >= 0.0:
            one_step(body, plan.method, state, top, True, work, spare)
        else:
            one_step(body, plan.method, work.before, back + top, True, work, spare)
        counts[EVALUATIONS] += len(plan.method.weights)
        keep_peak(touch_of(body, spare, pose_of(body, spare)), record)
    keep_peak(touch_of(body, state, pose_of(body, state)), record)
    record[LOAD_BEFORE], record[LOAD_LAST], record[LAST_STEP] = middle, load, step


@kernel
def keep_peak(touch, record):
    """Takes a load into the record if it is the greatest so far."""
    if touch.normal_load > record[PEAK_LOAD]:
        record[PEAK_LOAD], record[PEAK_APPROACH] = touch.normal_load, touch.approach
        record[PEAK_SMALL], record[PEAK_LARGE] = touch.curvature_small, touch.curvature_large
        record[PEAK_COEFFICIENT] = touch.coefficient


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
        clock[STEP] = max(FIRST_STEP * 2.943 * expected_approach(body, touch) / speed, plan.floor)


@kernel
def end_contact(body, state, clock, record):
    """Completes the record: `state` is that of the separation."""
    touch = touch_of(body, state, pose_of(body, state))
    record[ENDED], record[SPEED_OUT] = clock[TIME], -touch.approach_rate
    record[IMPULSE_X] = body.mass * (state[7] - record[IMPULSE_X])
    record[IMPULSE_Y] = body.mass * (state[8] - record[IMPULSE_Y])
    record[IMPULSE_Z] = body.mass * (state[9] - record[IMPULSE_Z] + body.gravity * (record[ENDED] - record[BEGAN]))
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
        one_step(body, plan.method, state, times[row] - clock[TIME], loaded, work, spare)
        states[row] = spare
        clock[CURSOR] += 1.0


@kernel
def advance(body, plan, state, clock, times, until, states, record, records, counts, work, stop):
    """Steps from the clock's time until `until` [s] lies in the next step; returns (status, contacts completed).

    `states` (outputs, COLUMNS) receives the states at `times` [s]; completed contacts go to `records`. A step that
    reaches beyond `until` is not taken, so the motion does not depend on how it is cut. Looks at `stop` (1,) before
    every step.
    """
    completed, spare = 0, np.empty(COLUMNS)
    shortest = min(body.semi_axes[0], min(body.semi_axes[1], body.semi_axes[2]))
    while True:
        if stop[0] != 0:
            return STOPPED, completed
        if clock[IN_CONTACT] == 0.0 and landed(body, state):
            begin_contact(body, plan, state, clock, record)
            counts[TOUCHES] += 1
        contact = clock[IN_CONTACT] > 0.0
        if contact:
            longest = contact_scales(body, plan, state, clock[TIME] - record[BEGAN], work)
            wanted = min(clock[STEP], plan.fixed if plan.fixed > 0.0 else longest)
        else:
            flight_scales(plan, work)
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
