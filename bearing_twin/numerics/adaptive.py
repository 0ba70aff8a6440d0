"""The loop of explicit methods for one system of few numbers that adapts its steps to errors and events.

As in `runge_kutta` a kind hands over functions, which are compiled into its own kernel. Outputs are steps of their own
from the start of the step they fall into, so that they have the order of the method, and a step that reaches beyond
what is asked for is left to the next call: neither touches the motion, which does not depend on how it is cut.
"""

import math

from bearing_twin.compiled import inlined, template
from bearing_twin.numerics.runge_kutta import copy_numbers, longest_step
from bearing_twin.numerics.statuses import FULL, NOT_FINITE, OK, STALLED, STEPS, STOPPED

TIME, STEP, CURSOR = 0, 1, 4
"""Of the clock: seconds, the next step, outputs written. Its entries 2, 3 and those from 5 on are the scene's."""

REPEAT = -1
"""What `end` returns, beside the statuses, for a step that is to be made again, of the clock's next length."""


@inlined
def all_finite(numbers):
    """True if every number of an array is finite."""
    finite = True
    for n in range(len(numbers)):
        finite = finite and math.isfinite(numbers[n])
    return finite


@template
def write_outputs_until(one_step, put_right, system, method, state, clock, end, times, states, loaded, work):
    """States at the output times up to `end` [s], each by a step of its own from the start of this one."""
    while clock[CURSOR] < len(times) and times[int(clock[CURSOR])] <= end:
        row = int(clock[CURSOR])
        one_step(system, method, state, times[row] - clock[TIME], loaded, work, states[row])
        put_right(system, states[row])
        clock[CURSOR] += 1.0


@template
def advance_adaptively(
    look, begin, one_step, end, put_right, accept,
    system, plan, method, state, clock, record, times, until, states, records, counts, work, stop,
):  # fmt: skip
    """Steps from the clock's time until `until` [s] lies in the next step; returns (status, records completed).

    `states` (outputs, numbers) receives the states at `times` [s], `records` (n, columns) each `record` (columns,) that
    is complete; `stop` (1,) is looked at before every step. The scene hands over

    `look(system, state)`: what it goes by at the end of a step;
    `begin(system, plan, state, clock, record, seen, counts, work)`: sets the error scales and returns (status, longest
    step [s], least one, whether bodies can press);
    `one_step` as in `longest_step`;
    `end(system, plan, method, state, clock, seen, step, loaded, counts, work)`: puts right what is in `work.after`,
    ends the step at an event, and returns (status or REPEAT, step, what `accept` wants to know of it);
    `put_right(system, state)`: the same for an output;
    `accept(system, plan, method, state, clock, record, seen, step, following, loaded, ended, counts, work)`: takes
    `work.after` as the state, the clock being at the step's end, sets the next step, and returns (status, seen, whether
    the record is complete).
    """
    completed, seen = 0, look(system, state)
    while True:
        if stop[0] != 0:
            return STOPPED, completed
        status, wanted, least, loaded = begin(system, plan, state, clock, record, seen, counts, work)
        if status != OK:
            return status, completed
        step, following = longest_step(one_step, system, method, state, wanted, least, loaded, work, counts)
        if step < 0.0:
            return STALLED, completed
        status, step, ended = end(system, plan, method, state, clock, seen, step, loaded, counts, work)
        if status == REPEAT:
            continue
        if status != OK:
            return status, completed
        if not all_finite(work.after):
            return NOT_FINITE, completed
        moment = clock[TIME] + step
        now = min(moment, until)
        write_outputs_until(one_step, put_right, system, method, state, clock, now, times, states, loaded, work)
        if moment > until:
            return OK, completed
        clock[TIME] = moment
        counts[STEPS] += 1
        status, seen, complete = accept(
            system, plan, method, state, clock, record, seen, step, following, loaded, ended, counts, work
        )
        if complete:
            copy_numbers(record, records[completed])
            completed += 1
            if completed == len(records):
                return FULL, completed
        if status != OK:
            return status, completed
