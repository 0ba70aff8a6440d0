"""The loop of methods that step all bodies of a scene together, with one step size, so that instants are ends of steps.

Explicit and implicit-explicit methods differ in a step, not in this. As in `runge_kutta` a kind hands over functions,
which are compiled into its own kernel.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import template
from bearing_twin.numerics.statuses import OK, REJECTIONS, STALLED, STEPS, STOPPED
from bearing_twin.numerics.steppers import LEAST_STEP, NOTHING, next_step

# Orientations need fewer steps than the contacts do; a state that cannot be right is looked for now and then and at
# every instant given out.
TURN_EVERY, CHECK_EVERY = 8, 64


class Pace(NamedTuple):
    """How long steps are: at most `longest` [s], the first one where an error estimate of this `order` adapts them.

    Without an estimate `order` is 0 and steps between two instants are equal; `counted` from the first of these, or
    from where each begins, which differs by rounding.
    """

    longest: float
    order: int
    counted: bool


@template
def advance_together(
    one_step, whose, move_on, turn, keep, check, scene, pace, times, duration, bodies, state, orientation, results
):
    """Steps so many bodies over `duration` [s] through the `times` [s]; returns (status, the next step's size [s]).

    The scene hands over `one_step(scene, time, step, begun)`, which returns its error in units of the tolerance, 0
    without an estimate, where `begun` is false the first time; `whose(scene)`, which returns the body with that error;
    `move_on(scene, fresh)`, which takes its end as the next start, `fresh` after an instant; `turn(scene, seconds,
    step, steps)`, which turns the bodies over what was done since they were turned last; `keep(scene, state,
    orientation)`, which writes both; and `check(scene, time, state, failure)`, which returns a status. `results` has
    `states` and `orientations` of the instants, `counts`, `failure` and `stop`.
    """
    time, wanted, begun = 0.0, pace.longest, False
    for instant in range(len(times) + 1):
        goal = times[instant] if instant < len(times) else duration
        begin = turned_at = time
        done, turned, step = 0, 0, wanted
        while goal - time > NOTHING * duration:
            if results.stop[0] != 0:
                return STOPPED, wanted
            if done == 0 or not pace.counted:  # once for equal steps, which are short
                step = (goal - time) / max(1.0, math.ceil((goal - time) / wanted - 1e-9))
            error = one_step(scene, time, step, begun)
            begun = True
            if pace.order > 0:
                wanted = next_step(step, error, pace.order)
            if not error <= 1.0:
                results.counts[REJECTIONS] += bodies
                if wanted < LEAST_STEP:
                    results.failure[0], results.failure[1] = time, whose(scene)
                    return STALLED, wanted
                continue
            results.counts[STEPS] += bodies
            last = goal - time - step < NOTHING * duration
            move_on(scene, done == 0)
            done += 1
            following = goal if last else time + step
            time = begin + done * step if pace.counted else following
            if done % TURN_EVERY == 0 or last:
                turn(scene, time - turned_at, step, done - turned)
                turned_at, turned = time, done
            if done % CHECK_EVERY == 0 or last:
                keep(scene, state, orientation)
                status = check(scene, time, state, results.failure)
                if status != OK:
                    return status, wanted
        if instant < len(times):
            keep(scene, results.states[instant], results.orientations[instant])
    return OK, wanted
