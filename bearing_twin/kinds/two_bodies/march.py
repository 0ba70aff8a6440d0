"""The motion of two bodies step by step, the records of their contacts, and what is given out.

Outputs are steps of their own from the start of the step they fall into, and a step that reaches beyond the chunk is
left to the next one: neither touches the motion.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elasticity import carries
from bearing_twin.kinds.two_bodies.equations import carry_on
from bearing_twin.kinds.two_bodies.pair import CARRIED, COLUMNS, FLAT, LOAD_IMPULSE, RUB_IMPULSE
from bearing_twin.kinds.two_bodies.steps import (
    METHOD,
    contact_scales,
    finish,
    flight_scales,
    flight_step,
    one_step,
    touch_now,
)
from bearing_twin.numerics.events import halved, parabola_top
from bearing_twin.numerics.runge_kutta import hermite, longest_step
from bearing_twin.numerics.statuses import EVALUATIONS, FULL, NOT_FINITE, OK, STALLED, STEPS, STOPPED, TOO_DEEP
from bearing_twin.shapes.tracking import FOUND

COUNTS = 3  # of those of `numerics.statuses`
TIME, STEP, IN_CONTACT, DRIFT, OFF, CURSOR, CLOCK = range(7)
"""Of the clock: seconds, next step, whether in contact, greatest drift of a quaternion's norm and greatest distance [m]
of the opposing points from meeting their equations at the end of a step, outputs written."""

(
    ENDED, BEGAN, PEAK_LOAD, PEAK_APPROACH, PEAK_SMALL, PEAK_LARGE, PEAK_COEFFICIENT, PEAK_MAJOR, PEAK_MINOR,
    PEAK_PRESSURE, SPEED_IN, SPEED_OUT, IMPULSE, RUB_X, RUB_Y, RUB_Z, LOAD_BEFORE, LOAD_LAST, LAST_STEP, RECORD,
) = range(20)  # fmt: skip
"""Of a contact: times [s], greatest load with what it had there, speeds [m/s], impulses [N s]; the rest: room."""

PEAK_ROUNDS = 3  # parabolas through the greatest load, each about the top of the one before

DEEPEST = 0.3  # of the bodies' size
UNTRACKED = 8
"""A status beside those of `numerics.statuses`: the opposing points found are no contact of the two bodies."""


@kernel
def keep_peak(touch, record):
    """Takes a load into the record if it is the greatest so far."""
    if touch.normal_load > record[PEAK_LOAD]:
        record[PEAK_LOAD], record[PEAK_APPROACH] = touch.normal_load, touch.approach
        record[PEAK_SMALL], record[PEAK_LARGE] = touch.curvature_small, touch.curvature_large
        record[PEAK_COEFFICIENT], record[PEAK_PRESSURE] = touch.coefficient, touch.pressure
        record[PEAK_MAJOR], record[PEAK_MINOR] = touch.semi_major, touch.semi_minor


@kernel
def load_after(pair, state, step, work):
    """The contact `step` [s] after a state."""
    one_step(pair, METHOD, state, step, True, work, work.spare)
    finish(pair, work.spare)
    return touch_now(pair, work.spare)


@kernel
def note_peak(pair, step, touch, record, counts, work):
    """Where the loads at the ends of the last two steps and between them show a peak, the load at its top.

    `work.before` is the start of the step before the last, `touch` the contact at the end of the last, of `step` [s].
    """
    first, middle, last, back = record[LOAD_BEFORE], record[LOAD_LAST], touch.normal_load, record[LAST_STEP]
    record[LOAD_BEFORE], record[LOAD_LAST], record[LAST_STEP] = middle, last, step
    if not (middle >= first and middle > last and middle > 0.9 * record[PEAK_LOAD] and back > 0.0):
        return
    low, at, high = -back, 0.0, step
    for _ in range(PEAK_ROUNDS):
        top = parabola_top(low, at, high, first, middle, last)
        peak = load_after(pair, work.before, back + top, work)
        counts[EVALUATIONS] += len(METHOD.weights)
        keep_peak(peak, record)
        if peak.normal_load <= middle or abs(top - at) <= 1e-3 * (high - low):
            return
        if top > at:
            low, first = at, middle
        else:
            high, last = at, middle
        at, middle = top, peak.normal_load


@inlined
def _not_crossed(ends, share):
    step, before, before_rate, after, after_rate = ends
    return (hermite(share, step, before, before_rate, after, after_rate) > 0.0) == (before > 0.0)


@kernel
def crossing(step, before, before_rate, after, after_rate):
    """Share of a step at which the approach, a cubic with these ends and rates, changes its sign."""
    low, high, _ = halved(_not_crossed, (step, before, before_rate, after, after_rate), 1.0, 1e-14)
    return 0.5 * (low + high)


@kernel
def note(clock, step, before, touch, state, record):
    """Opens or closes the record of a contact where the step did; returns whether one has ended."""
    if touch.approach > 0.0:
        if clock[IN_CONTACT] == 0.0:
            share = 0.0
            if before.approach <= 0.0 < step:
                share = crossing(step, before.approach, before.approach_rate, touch.approach, touch.approach_rate)
            clock[IN_CONTACT] = 1.0
            record[:] = 0.0
            record[BEGAN] = clock[TIME] - (1.0 - share) * step
            record[SPEED_IN] = before.approach_rate
            record[IMPULSE] = state[LOAD_IMPULSE]
            for i in range(3):
                record[RUB_X + i] = state[RUB_IMPULSE + i]
        keep_peak(touch, record)
        return False
    if clock[IN_CONTACT] == 0.0:
        return False
    share = crossing(step, before.approach, before.approach_rate, touch.approach, touch.approach_rate)
    clock[IN_CONTACT] = 0.0
    record[ENDED], record[SPEED_OUT] = clock[TIME] - (1.0 - share) * step, -touch.approach_rate
    record[IMPULSE] = state[LOAD_IMPULSE] - record[IMPULSE]
    for i in range(3):
        record[RUB_X + i] = state[RUB_IMPULSE + i] - record[RUB_X + i]
    return True


@kernel
def write_outputs_until(pair, state, clock, end, times, states, loaded, work):
    """States at the output times up to `end` [s], each by a step of its own from the start of this one."""
    while clock[CURSOR] < len(times) and times[int(clock[CURSOR])] <= end:
        row = int(clock[CURSOR])
        one_step(pair, METHOD, state, times[row] - clock[TIME], loaded, work, states[row])
        finish(pair, states[row])
        clock[CURSOR] += 1.0


@kernel
def advance(pair, plan, state, clock, times, until, states, record, records, counts, work, stop):
    """Steps from the clock's time until `until` [s] lies in the next step; returns (status, contacts completed).

    `states` (outputs, COLUMNS) receives the states at `times` [s]; completed contacts go to `records`; `stop` (1,) is
    looked at before every step. The step in contact begins and ends by itself: `loaded` unless it is sure to be flight.
    """
    completed = 0
    touch = touch_now(pair, state)
    while True:
        if stop[0] != 0:
            return STOPPED, completed
        if touch.kind != FOUND:
            return UNTRACKED, completed
        loaded = touch.approach > 0.0
        step = flight_step(pair, plan, state)
        if loaded or step <= plan.floor:  # what may begin to press
            lasted = clock[TIME] - record[BEGAN] if clock[IN_CONTACT] > 0.0 else 0.0
            longest = contact_scales(pair, plan, touch, lasted, work.scales)
            step = min(clock[STEP], longest) if loaded else plan.floor
            loaded = True
        else:
            flight_scales(pair, plan, work.scales)
        least = 1e-6 * plan.floor
        step, following = longest_step(one_step, pair, METHOD, state, step, least, loaded, work, counts)
        if step < 0.0:
            return STALLED, completed
        drift, off = finish(pair, work.after)
        if not np.all(np.isfinite(work.after)):
            return NOT_FINITE, completed
        end = clock[TIME] + step
        write_outputs_until(pair, state, clock, min(end, until), times, states, loaded, work)
        if end > until:
            return OK, completed
        before = touch
        work.now[:] = state
        state[:] = work.after
        touch = touch_now(pair, state)
        if carries(pair.law) and touch.curvature_small > FLAT * touch.curvature_large:
            carry_on(pair.law, state[CARRIED:COLUMNS], touch.curvature_small / touch.curvature_large)
        if touch.approach > DEEPEST * pair.size:
            return TOO_DEEP, completed
        clock[TIME], clock[DRIFT], clock[OFF] = end, max(clock[DRIFT], drift), max(clock[OFF], off)
        clock[STEP] = following if touch.approach > 0.0 and loaded else math.inf
        counts[STEPS] += 1
        ended = note(clock, step, before, touch, state, record)
        if clock[IN_CONTACT] > 0.0:
            note_peak(pair, step, touch, record, counts, work)
        work.before[:] = work.now
        if ended:
            records[completed] = record
            completed += 1
            if completed == len(records):
                return FULL, completed
