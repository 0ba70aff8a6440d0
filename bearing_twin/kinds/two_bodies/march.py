"""The motion of two bodies: what the loop of steps does with contacts, and their records (`numerics.adaptive`)."""

import math

from bearing_twin.compiled import kernel, template
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
from bearing_twin.numerics.adaptive import STEP, TIME, advance_adaptively
from bearing_twin.numerics.events import crossing, greatest_within, landing_step, look_at_top
from bearing_twin.numerics.runge_kutta import copy_numbers
from bearing_twin.numerics.statuses import EVALUATIONS, OK, TOO_DEEP
from bearing_twin.shapes.tracking import FOUND

COUNTS = 3  # of those of `numerics.statuses`
IN_CONTACT, DRIFT, OFF, CLOCK = 2, 3, 5, 6
"""Of the clock beside those of `numerics.adaptive`: whether in contact, greatest drift of a quaternion's norm and
greatest distance [m] of the opposing points from meeting their equations at the end of a step; all."""

(
    ENDED, BEGAN, PEAK_LOAD, PEAK_APPROACH, PEAK_SMALL, PEAK_LARGE, PEAK_COEFFICIENT, PEAK_MAJOR, PEAK_MINOR,
    PEAK_PRESSURE, SPEED_IN, SPEED_OUT, IMPULSE, RUB_X, RUB_Y, RUB_Z, DEEPEST_APPROACH,
    LOAD_BEFORE, LOAD_LAST, LAST_STEP, RECORD,
) = range(21)  # fmt: skip
"""Of a contact: times [s], greatest load with what it had there, speeds [m/s], impulses [N s], greatest
approach [m]; the rest: room."""

UNLOADED = 1e-6  # of the load at the start of a step: what is left of it where it ends
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
def _touch_after(pair, state, length, counts, work):
    """The contact `length` [s] after `state`, by a step of its own whose end is in `work.spare`."""
    one_step(pair, METHOD, state, length, True, work, work.spare)
    finish(pair, work.spare)
    counts[EVALUATIONS] += len(METHOD.weights)
    return touch_now(pair, work.spare)


@template
def _load_at(what, back, place):
    """The load [N] `place` [s] after the last step began, seen from where the step before did, `back` [s] before."""
    pair, record, counts, work = what
    touch = _touch_after(pair, work.before, back + place, counts, work)
    keep_peak(touch, record)
    return touch.normal_load


@kernel
def note_peak(pair, step, touch, record, counts, work):
    """Where the loads at the ends of the last two steps and between them show a peak, the load at its top.

    `work.before` is the start of the step before the last, `touch` the contact at the end of the last, of `step` [s].
    """
    what, trail = (pair, record, counts, work), record[LOAD_BEFORE : LAST_STEP + 1]
    look_at_top(_load_at, what, trail, step, touch.normal_load, record[PEAK_LOAD], PEAK_ROUNDS)


@template
def _approach_at(what, place):
    """The approach [m] and its rate [m/s] `place` [s] after the step began."""
    pair, counts, work = what
    touch = _touch_after(pair, work.now, place, counts, work)
    return touch.approach, touch.approach_rate


@kernel
def note_depth(pair, step, before, touch, record, counts, work):
    """Keeps the greatest approach of a contact over the step from `work.now`: damping puts it after the load's."""
    ends = (before.approach, before.approach_rate), (touch.approach, touch.approach_rate)
    what, deepest = (pair, counts, work), record[DEEPEST_APPROACH]
    record[DEEPEST_APPROACH] = greatest_within(_approach_at, what, step, ends[0], ends[1], deepest)


@kernel
def note(clock, step, before, touch, start, state, record):
    """Opens or closes the record of a contact where the step did; returns whether one has ended.

    `start` and `state` are those at both ends of the step, `before` and `touch` their contacts: what the step in which
    bodies touch brings is of the contact, too, where damping answers at once.
    """
    if touch.approach > 0.0:
        if clock[IN_CONTACT] == 0.0:
            share = 0.0
            if before.approach <= 0.0 < step:
                share = crossing(step, before.approach, before.approach_rate, touch.approach, touch.approach_rate)
            clock[IN_CONTACT] = 1.0
            record[:] = 0.0
            record[BEGAN] = clock[TIME] - (1.0 - share) * step
            record[SPEED_IN] = before.approach_rate
            record[IMPULSE] = start[LOAD_IMPULSE]
            for i in range(3):
                record[RUB_X + i] = start[RUB_IMPULSE + i]
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


@template
def _put_right(pair, state):
    finish(pair, state)


@template
def _begin(pair, plan, state, clock, record, touch, counts, work):
    """How far the next step may go: in flight never into a contact but by the shortest step, which may press."""
    loaded, least = touch.approach > 0.0, 1e-6 * plan.floor
    if touch.kind != FOUND:
        return UNTRACKED, 0.0, least, loaded
    step = flight_step(pair, plan, state)
    if not loaded and step > plan.floor:
        flight_scales(pair, plan, work.scales)
        return OK, step, least, False
    lasted = clock[TIME] - record[BEGAN] if clock[IN_CONTACT] > 0.0 else 0.0
    longest = contact_scales(pair, plan, touch, lasted, work.scales)
    return OK, min(clock[STEP], longest) if loaded else plan.floor, least, True


@template
def _held(pair, state):
    """What is left of the load [N] at the end of a step that is put right; below zero where nothing is."""
    finish(pair, state)
    return touch_now(pair, state).held


@template
def _end(pair, plan, method, state, clock, touch, step, loaded, counts, work):
    """Puts the end of a step right; returns (status, step, (drift, how far the points were off, the contact there)).

    A step in which the load ends, ends there: what follows is another motion, and no step is smooth across a corner.
    """
    (drift, off), after = finish(pair, work.after), touch_now(pair, work.after)
    if loaded and touch.normal_load > 0.0 and after.held < 0.0:
        nearest = UNLOADED * touch.normal_load
        step = landing_step(_held, one_step, pair, method, state, step, nearest, work, counts)
        (drift, off), after = finish(pair, work.after), touch_now(pair, work.after)
    return OK, step, (drift, off, after)


@template
def _accept(pair, plan, method, state, clock, record, before, step, following, loaded, found, counts, work):
    """Takes the step, and opens or completes the record of a contact where it has begun or ended."""
    copy_numbers(state, work.now)
    copy_numbers(work.after, state)
    drift, off, touch = found
    if carries(pair.law) and touch.curvature_small > FLAT * touch.curvature_large:
        carry_on(pair.law, state[CARRIED:COLUMNS], touch.curvature_small / touch.curvature_large)
    if touch.approach > DEEPEST * pair.size:
        return TOO_DEEP, touch, False
    clock[DRIFT], clock[OFF] = max(clock[DRIFT], drift), max(clock[OFF], off)
    clock[STEP] = following if touch.approach > 0.0 and loaded else math.inf
    ended = note(clock, step, before, touch, work.now, state, record)
    if clock[IN_CONTACT] > 0.0:
        note_peak(pair, step, touch, record, counts, work)
        note_depth(pair, step, before, touch, record, counts, work)
    copy_numbers(work.now, work.before)
    return OK, touch, ended


@kernel
def advance(pair, plan, state, clock, times, until, states, record, records, counts, work, stop):
    """`advance_adaptively` of two bodies: returns (status, contacts completed), which are in `records`.

    The step in contact begins and ends by itself: bodies can press unless it is sure to be flight.
    """
    return advance_adaptively(
        touch_now, _begin, one_step, _end, _put_right, _accept,
        pair, plan, METHOD, state, clock, record, times, until, states, records, counts, work, stop,
    )  # fmt: skip
