"""The motion of the shaft step by step, by a linearly implicit method: its contacts are stiff.

A step that reaches beyond what is asked for is kept, with its interpolant, so that a run does not depend on how it is
cut. Steps end where drive or load change. Outputs have balls of their own: looking at a motion does not touch it.
"""

import math

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import COORDINATES
from bearing_twin.kinds.shaft.course import CoursePart, whirl_of
from bearing_twin.kinds.shaft.outputs import write_row
from bearing_twin.kinds.shaft.rotor import (
    BEARING_WORK,
    DISSIPATED,
    LOAD_WORK,
    RATE,
    STATE,
    jacobian,
    rates,
)
from bearing_twin.numerics.rosenbrock_step import dense_terms, rosenbrock_step
from bearing_twin.numerics.runge_kutta import longest_step
from bearing_twin.numerics.statuses import EVALUATIONS, OK, REJECTIONS, STALLED, STEPS, STOPPED, TOO_DEEP
from bearing_twin.numerics.steppers import rosenbrock_dense

COUNTS = 3
BEGAN, TIME, STEP, PHASE, CURSOR, GROSS, GROSS_BEFORE, CLOCK = range(8)
"""Of the clock: begin and end [s] of the step kept, next step [s], part of the course, outputs written, work of
loads and bearings with each step's counted by its size [J], and that at the begin of the step kept."""

START, END, THIRD, FOURTH, KEPT = range(5)  # rows of the step kept: states at its ends, and its interpolant
NEAR = 1e-3  # of a step: no shorter one is left before a part of the course ends
LOAD, GROWTH, PART = 4, 4 + COORDINATES, 4 + 2 * COORDINATES  # of a row of the course: see `CoursePart`
SHORTEST, LONGEST = range(2)  # of the bounds of steps [s]
SLOPES = 2  # rates for the explicit change with time, beside those of the stages


@kernel
def _one_step(system, method, state, step, time, work, out):
    return rosenbrock_step(method, rates, jacobian, system, time, state, step, work)


@kernel
def _keep_step(method, work, kept):
    """The ends of the step just taken, and its interpolant."""
    for n in range(STATE):
        kept[START, n], kept[END, n] = kept[END, n], work.after[n]
    dense_terms(method, work, kept[THIRD], kept[FOURTH])


@inlined
def _part_of(course, phase):
    """That part of the course."""
    row = course[phase]
    return CoursePart(row[0], row[1], row[2], row[3], row[LOAD:GROWTH], row[GROWTH:PART])


@kernel
def _works(system, clock, kept):
    """The works [J] of loads, of bearings and of damping in the step kept, each by its size, added up."""
    rotor, part, _, _ = system
    steady = weight = 0.0
    for i in range(COORDINATES):
        begin, end = whirl_of(rotor, part, clock[BEGAN], i)[0], whirl_of(rotor, part, clock[TIME], i)[0]
        moved = end - begin + kept[END, i] - kept[START, i]
        steady += rotor.steady[i] * moved
        weight += rotor.weight[i] * moved
    loads, bearings = kept[END, LOAD_WORK] - kept[START, LOAD_WORK], kept[END, BEARING_WORK] - kept[START, BEARING_WORK]
    return abs(loads + steady) + abs(bearings + steady + weight) + abs(kept[END, DISSIPATED] - kept[START, DISSIPATED])


@inlined
def _state_at(clock, kept, time, state):
    """Fills the state at `time` [s] of the step kept, beside the whirl; returns the gross work there."""
    lasts = clock[TIME] - clock[BEGAN]
    share = (time - clock[BEGAN]) / lasts if lasts > 0.0 else 1.0
    for n in range(STATE):
        state[n] = rosenbrock_dense(share, kept[START, n], kept[END, n], kept[THIRD, n], kept[FOURTH, n])
    return clock[GROSS_BEFORE] + share * (clock[GROSS] - clock[GROSS_BEFORE])


@kernel
def begin_again(clock, kept, time, state):
    """Drops what of the step kept lies beyond `time` [s]: the motion goes on from there; `state` (STATE,) is room."""
    gross = _state_at(clock, kept, time, state)
    kept[START] = state
    kept[END] = state
    clock[BEGAN] = clock[TIME] = time
    clock[GROSS_BEFORE] = clock[GROSS] = gross


@kernel
def write_outputs(rotor, course, shown, clock, kept, times, rows):
    """Writes the outputs at those of the `times` [s] that the step kept reaches; `shown` is what they are computed in.

    That is (balls, moment, state) of their own. Returns TOO_DEEP at the first whose contacts leave their
    limits, else OK.
    """
    phase = int(clock[PHASE])
    balls, moment, state = shown
    system = (rotor, _part_of(course, phase), balls, moment)
    while clock[CURSOR] < len(times) and times[int(clock[CURSOR])] <= clock[TIME]:
        cursor = int(clock[CURSOR])
        gross = _state_at(clock, kept, times[cursor], state)
        for i in range(COORDINATES):
            place, rate, _ = whirl_of(rotor, system[1], times[cursor], i)
            state[i] += place
            state[RATE + i] += rate
        if write_row(system, times[cursor], state, gross, rows[cursor]) > 1.0:
            clock[TIME] = times[cursor]
            return TOO_DEEP
        clock[CURSOR] += 1.0
    return OK


@kernel
def advance(rotor, course, method, work, moved, shown, clock, kept, counts, times, until, bounds, furthest, rows, stop):
    """Steps until one reaches `until` [s], and writes the outputs at `times` [s] to `rows`; returns a status.

    `course` (parts, PART) holds the parts from that of the step kept on. `moved` is (balls, moment) of the motion,
    `shown` as of `write_outputs`. Steps are within `bounds` (2,) [s] and end within `furthest` (5,); `stop` (1,) is
    looked at before each.
    """
    while True:
        status = write_outputs(rotor, course, shown, clock, kept, times, rows)
        if status != OK or clock[TIME] >= until:
            return status
        if stop[0] != 0:
            return STOPPED
        time, phase = clock[TIME], int(clock[PHASE])
        if phase + 1 < len(course) and time >= course[phase + 1, 0]:
            phase += 1
            clock[PHASE] = phase
        ends = course[phase + 1, 0] if phase + 1 < len(course) else math.inf
        wanted = min(clock[STEP], bounds[LONGEST])
        reaches = time + (1.0 + NEAR) * wanted >= ends
        system = (rotor, _part_of(course, phase), moved[0], moved[1])
        rejected, cut = counts[REJECTIONS], ends - time if reaches else wanted
        step, following = longest_step(_one_step, system, method, kept[END], cut, bounds[SHORTEST], time, work, counts)
        rejections = counts[REJECTIONS] - rejected
        counts[EVALUATIONS] += SLOPES * (rejections + (step > 0.0))
        if step < 0.0:
            return STALLED
        for n in range(COORDINATES):
            if not abs(work.after[n]) <= furthest[n]:
                clock[TIME] = time + step
                return TOO_DEEP
        counts[STEPS] += 1
        _keep_step(method, work, kept)
        arrived = reaches and rejections == 0
        clock[BEGAN], clock[TIME] = time, ends if arrived else time + step
        clock[STEP] = max(wanted, following) if arrived else following
        clock[GROSS_BEFORE] = clock[GROSS]
        clock[GROSS] += _works(system, clock, kept)
