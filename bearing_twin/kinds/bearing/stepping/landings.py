"""What a step may be off by where a contact begins or ends in it, which its own error estimate may miss by chance.

Loads do not begin smoothly: viscous ones as the root of the approach. A step over such an instant errs by about what
the contact does to the ball in it. The estimate of a Rosenbrock method is as great, but passes through zero as the
instant moves through the step: of 400 landings one is off by some hundred times what it should be, and a ball that
bounces never forgets that. A contact beside one that bears load throughout is soon forgotten.
"""

import math

from bearing_twin.compiled import inlined
from bearing_twin.contact.elastic import elastic
from bearing_twin.kinds.bearing.forces.equations import inner_approach, outer_approach
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, HEIGHT, MOTION, VELOCITY
from bearing_twin.numerics.lanes import END, ERROR, LANES, RIGHT, START, STEP, get, get_vector, put, rows
from bearing_twin.numerics.lean import lean_kernel

# Of what a contact that begins or ends does to a ball's speed: a step errs by no less. From 0.1 to 0.5 landings err by
# 3 to 4 times what a step may, and steps are as many (`tests/test_bearing_physics.py`).
CHANCE = 0.1
BEGIN, FINISH, LEAST = rows(RIGHT, 1, 1)  # approaches at the outer raceway: nothing is to be solved any more


@inlined
def alone(coupling):
    """Not empty for balls that nothing couples."""
    if len(coupling) == 0:
        return (1.0,)
    return ()


@inlined
def _borne(bearing, law, begin, end, step):
    """Approaches [m] at both ends of a step; they bear load above 0: where a contact opens, earlier by what is viscous.

    The load is in proportion to approach + power * relaxation time * its rate, and never pulls.
    """
    lag = law.power * bearing.relaxation_time * min(end - begin, 0.0) / step
    return begin + lag, end + lag


@inlined
def _impulse(bearing, law, begin, end, step):
    """What the beginning of a contact in a step does to the speed of a ball in it [m/s], or would where one ends.

    0 where none does. Approaches at both ends [m].
    """
    before, after = _borne(bearing, law, begin, end, step)
    lasts = step / max(abs(end - begin), 1e-300)  # s/m
    if before <= 0.0 < after:
        pushes = elastic(law.given, law.power, end).load
        return pushes * (bearing.relaxation_time + end * lasts / (law.power + 1.0)) / bearing.ball_mass
    if after <= 0.0 < before:  # as if it pulled
        stiffness = elastic(law.given, law.power, end - after).stiffness
        return 0.5 * stiffness / law.power * after * after * lasts / bearing.ball_mass
    return 0.0


@lean_kernel
def _gaps(bearing, lanes):
    """Puts approaches at the outer raceway at both ends of steps, and the lesser of what is borne by.

    A loop by itself, which takes all lanes at once: a short one of known length LLVM would unroll before it looks.
    """
    for k in range(min(LANES, len(lanes))):
        begin = outer_approach(bearing, get(lanes, START + AXIS_DISTANCE, k), get(lanes, START + HEIGHT, k))
        end = outer_approach(bearing, get(lanes, END + AXIS_DISTANCE, k), get(lanes, END + HEIGHT, k))
        before, after = _borne(bearing, bearing.outer.law, begin, end, get(lanes, STEP, k))
        put(lanes, BEGIN, k, begin)
        put(lanes, FINISH, k, end)
        put(lanes, LEAST, k, min(before, after))


@lean_kernel
def weigh_landings(bearing, scales, lanes):
    """Lets steps in which a contact begins or ends err by no less than a share of what that does to the ball.

    Of balls that no ring and no cage couples, after `finish_lanes`; `scales` (MOTION,) are the errors that a step may
    make.
    """
    _gaps(bearing, lanes)
    per_scale = CHANCE / (scales[VELOCITY] * math.sqrt(MOTION))
    for k in range(LANES):
        # As nearly always: what the outer raceway bears throughout forgets errors. Lanes without a ball hold no
        # numbers, which compare as false.
        if not (get(lanes, LEAST, k) <= 0.0 and get(lanes, ERROR, k) <= 1.0):
            continue
        begin, end, step = get(lanes, BEGIN, k), get(lanes, FINISH, k), get(lanes, STEP, k)
        changes = _impulse(bearing, bearing.outer.law, begin, end, step)
        place, there = get_vector(lanes, START + AXIS_DISTANCE, k), get_vector(lanes, END + AXIS_DISTANCE, k)
        begin, end = inner_approach(bearing, *place), inner_approach(bearing, *there)
        changes = max(changes, _impulse(bearing, bearing.inner.law, begin, end, step))
        put(lanes, ERROR, k, max(get(lanes, ERROR, k), per_scale * changes))
