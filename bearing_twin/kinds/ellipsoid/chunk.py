"""A chunk of the motion of an ellipsoid on a plane: what the loop of steps does with contacts (`numerics.adaptive`)."""

import math

from bearing_twin.compiled import inlined, kernel, template
from bearing_twin.kinds.ellipsoid.equations import (
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
    contact_scales,
    expected_approach,
    fill,
    flight_scales,
    greatest_spin,
    landed,
    one_step,
    safe_flight,
)
from bearing_twin.numerics.adaptive import REPEAT, STEP, TIME, advance_adaptively
from bearing_twin.numerics.events import greatest_within, landing_step, look_at_top
from bearing_twin.numerics.runge_kutta import copy_numbers
from bearing_twin.numerics.statuses import EVALUATIONS, OK, TOO_DEEP

IN_CONTACT, DRIFT = 2, 3
CLOCK = 5
"""Of the clock beside those of `numerics.adaptive`: in contact, greatest drift of the quaternion's norm; all."""

(
    BEGAN, ENDED, PEAK_LOAD, PEAK_APPROACH, PEAK_SMALL, PEAK_LARGE, PEAK_COEFFICIENT, SPEED_IN, SPEED_OUT,
    IMPULSE_X, IMPULSE_Y, IMPULSE_Z, DEEPEST_APPROACH, LOAD_BEFORE, LOAD_LAST, LAST_STEP,
) = range(16)  # fmt: skip
RECORD = 16
"""Of a contact: times [s], peak load [N] with approach, curvatures and law's coefficient there, speeds [m/s], impulse
[N s] (velocities at the touch until it ends), greatest approach [m]; the rest is work room."""

RECORDED = (
    ENDED, BEGAN, PEAK_LOAD, PEAK_APPROACH, PEAK_SMALL, PEAK_LARGE, PEAK_COEFFICIENT, SPEED_IN, SPEED_OUT,
    IMPULSE_X, IMPULSE_Y, IMPULSE_Z, DEEPEST_APPROACH,
)  # fmt: skip
"""What is given out of a contact that has ended, in the order of the table `figures.CONTACT`."""

FIRST_STEP = 1e-6  # of the contact time expected: loads begin as t^1.5, viscous ones as t^0.25, which no method likes
LONGEST_FLIGHT = 1.0  # s a step
FLIGHT_TURN = 0.02  # rad a step of a fixed-step method in flight
DEEPEST = 0.5  # of the shortest semi-axis


@kernel
def keep_peak(touch, record):
    """Takes a load into the record if it is the greatest so far."""
    if touch.normal_load > record[PEAK_LOAD]:
        record[PEAK_LOAD], record[PEAK_APPROACH] = touch.normal_load, touch.approach
        record[PEAK_SMALL], record[PEAK_LARGE] = touch.curvature_small, touch.curvature_large
        record[PEAK_COEFFICIENT] = touch.coefficient


@template
def _load_at(what, back, place):
    """The load [N] `place` [s] after `state`, or before it, from where the step began that was `back` [s] long."""
    body, plan, state, record, counts, work = what
    if place >= 0.0:
        one_step(body, plan.method, state, place, True, work, work.spare)
    else:
        one_step(body, plan.method, work.before, back + place, True, work, work.spare)
    counts[EVALUATIONS] += len(plan.method.weights)
    touch = touch_of(body, work.spare, pose_of(body, work.spare))
    keep_peak(touch, record)
    return touch.normal_load


@kernel
def note_peak(body, plan, state, step, record, counts, work):
    """Keeps the greatest load of a contact: where three ends of steps show a peak, the load at their parabola's top.

    `state` is the start of the step whose end is in `work.after`; `work.before` the start of the step before.
    """
    load = touch_of(body, work.after, pose_of(body, work.after)).normal_load
    trail = record[LOAD_BEFORE : LAST_STEP + 1]
    look_at_top(_load_at, (body, plan, state, record, counts, work), trail, step, load, record[PEAK_LOAD], 1)
    keep_peak(touch_of(body, state, pose_of(body, state)), record)


@template
def _approach_at(what, place):
    """The approach [m] and its rate [m/s] `place` [s] after the step began."""
    body, plan, state, counts, work = what
    one_step(body, plan.method, state, place, True, work, work.spare)
    counts[EVALUATIONS] += len(plan.method.weights)
    return gap_of(body, work.spare)


@kernel
def note_depth(body, plan, state, step, record, counts, work):
    """Keeps the greatest approach of a contact over the step to `work.after`: damping puts it after the load's."""
    what, ends = (body, plan, state, counts, work), (gap_of(body, state), gap_of(body, work.after))
    record[DEEPEST_APPROACH] = greatest_within(_approach_at, what, step, ends[0], ends[1], record[DEEPEST_APPROACH])


@kernel
def begin_contact(body, plan, state, clock, record):
    """Opens the record of a contact at this state; the next step suits its onset."""
    begin_shape(body, state)
    touch = touch_of(body, state, pose_of(body, state))
    fill(record, 0, RECORD, 0.0)
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
def commit(body, state, clock, work):
    """Takes the step: the quaternion is brought back to unit length, its drift kept."""
    if clock[IN_CONTACT] > 0.0:
        finish_shape(body, work.after)
    norm = math.sqrt(work.after[3] ** 2 + work.after[4] ** 2 + work.after[5] ** 2 + work.after[6] ** 2)
    clock[DRIFT] = max(clock[DRIFT], abs(norm - 1.0))
    for i in range(QUATERNION, QUATERNION + 4):
        work.after[i] /= norm
    copy_numbers(state, work.before)
    copy_numbers(work.after, state)


@inlined
def _look(body, state):
    return 0.0


@template
def _put_right(body, state):
    """An output's quaternion is taken at unit length where it is given out."""


@inlined
def _approach(body, state):
    return gap_of(body, state)[0]


@template
def _begin(body, plan, state, clock, record, seen, counts, work):
    """Opens a contact where the body has landed; how far the next step may go."""
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
    return OK, wanted, 1e-9 * plan.floor, contact


@template
def _end(body, plan, method, state, clock, seen, step, loaded, counts, work):
    """Ends a step in contact where the bodies part; returns (status, step, whether they have)."""
    status, ended = OK, False
    if loaded:
        shortest = min(body.semi_axes[0], min(body.semi_axes[1], body.semi_axes[2]))
        approach = _approach(body, work.after)
        ended = approach <= 0.0
        if approach > DEEPEST * shortest:
            status = TOO_DEEP
        if ended:
            if _approach(body, state) > ROUNDING * (abs(state[2]) + shortest):
                nearest = ROUNDING * (abs(state[2]) + 1e-3)
                step = landing_step(_approach, one_step, body, method, state, step, nearest, work, counts)
            elif step > plan.floor:
                clock[STEP] = 0.25 * step  # a touch that leaves at once: find out how long it lasts
                status = REPEAT
    return status, step, ended


@template
def _accept(body, plan, method, state, clock, record, seen, step, following, loaded, ended, counts, work):
    """Takes the step, and completes the record of a contact that it has ended."""
    if loaded:
        note_peak(body, plan, state, step, record, counts, work)
        note_depth(body, plan, state, step, record, counts, work)
    commit(body, state, clock, work)
    clock[STEP] = following if plan.fixed == 0.0 else math.inf
    if ended:
        end_contact(body, state, clock, record)
    return OK, seen, ended


@kernel
def advance(body, plan, state, clock, times, until, states, record, records, counts, work, stop):
    """`advance_adaptively` of the ellipsoid: returns (status, contacts completed), which are in `records`."""
    return advance_adaptively(
        _look, _begin, one_step, _end, _put_right, _accept,
        body, plan, plan.method, state, clock, record, times, until, states, records, counts, work, stop,
    )  # fmt: skip
