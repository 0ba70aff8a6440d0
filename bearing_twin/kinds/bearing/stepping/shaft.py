"""A shaft that a torque turns: its state beside ring and cage, and its part of the linear system of a step.

J dw/dt = T(t) - c w + the moments of balls and cage about the ring's axis. But for an unbalance nothing depends on the
angle. In a step the speed w is one more unknown, eliminated last: W x + C w = r and R x + D w = s are solved as
w = (s - R z) / (D - R y) with W y = C, W z = r, x = z - y w, whatever W is made of: a ring that is held or moves,
cages, balls that touch.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.equations import RingDrive
from bearing_twin.kinds.bearing.forces.land import answer_to_spin
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BALL_BY_SHAFT,
    CAGE,
    LOST,
    MOTION,
    PLACES,
    SHAFT_ANGLE,
    SHAFT_ANSWER,
    SHAFT_BY_BALL,
    SHAFT_BY_BORDER,
    SHAFT_OWN,
    SHAFT_SPEED,
    SHAFT_WORK,
    SHARES,
    SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    WORK_DONE,
)
from bearing_twin.kinds.bearing.forces.shaft_gradient import put_shaft_answers
from bearing_twin.kinds.bearing.forces.spot_jacobian import add_spot_turning
from bearing_twin.kinds.bearing.stepping.border import leave_out_spares
from bearing_twin.kinds.bearing.stepping.border_system import to_cage
from bearing_twin.kinds.bearing.stepping.linear_system import solve_together
from bearing_twin.numerics.lanes import (
    COLUMNS,
    GAIN,
    LANES,
    RIGHT,
    SOLUTION,
    STATE_SPAN,
    add_sum,
    clear_rows,
    get,
    get_vector,
    increase,
    multiply_rows,
    put,
    with_sum,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import dot


class Shaft(NamedTuple):
    """Moment of inertia [kg m^2] of all that turns with the inner ring, and viscous damping [N m s] of its speed."""

    inertia: float
    damping: float


@inlined
def turning(border, drive, time, first):
    """The drive at `time` [s]: as prescribed, or as the shaft turns in the border's state at `first`."""
    if len(border) > 0:
        return _turned(border.shaft, border.numbers, drive, time, first)
    return drive


@inlined
def _turned(shaft, numbers, drive, time, first):
    if len(shaft) > 0:
        speed = numbers[first + SHAFT_SPEED]
        return RingDrive(numbers[first + SHAFT_ANGLE] - time * speed, speed, 0.0)
    return drive


@lean_kernel
def _to_even(bearing, lanes):
    """Turns what shaft and balls of an even cage are to each other over to the cage; its share goes into SHARES."""
    for k in range(LANES):
        to_cage(SHAFT_BY_BALL, SHAFT_BY_BORDER, lanes, k)
        lever = bearing.ball_mass * get(lanes, AXIS_DISTANCE, k)
        put(lanes, SHARES + CAGE, k, lever * get(lanes, BALL_BY_SHAFT + TANGENTIAL_VELOCITY - VELOCITY, k))


@lean_kernel
def _add_unbalance(drive, time, numbers):
    """How the force of an unbalance, and its power, answer to the shaft's speed and angle."""
    size, angle = numbers[at.UNBALANCE], drive.angle + time * drive.speed + numbers[at.PHASE]
    along, across, speed = size * math.cos(angle), size * math.sin(angle), drive.speed
    by_speed = (2.0 * speed * along, 2.0 * speed * across)
    by_angle = (-speed * speed * across, speed * speed * along)
    for i in range(2):
        inverse, moving = numbers[at.INVERSE + i], numbers[at.FREE + i] * numbers[at.NOW + PLACES + i]
        numbers[at.BY_SHAFT + PLACES + i] += inverse * by_speed[i]
        numbers[at.BY_ANGLE + PLACES + i] = inverse * by_angle[i]
        numbers[at.BY_SHAFT + WORK_DONE] += moving * by_speed[i]
        numbers[at.BY_ANGLE + WORK_DONE] += moving * by_angle[i]


@inlined
def shaft_answers(shaft, drive, bearing, time, coupling, blocks):
    """How a shaft that a torque turns and all else answer to each other, after `border_jacobian`."""
    if len(shaft) > 0:
        _find_answers(shaft, drive, bearing, coupling.border, time, blocks)


@lean_kernel
def _find_answers(shaft, drive, bearing, border, time, blocks):
    """`shaft_answers` where there is such a shaft."""
    numbers, inverse = border.numbers, 1.0 / shaft.inertia
    for block in range(len(blocks)):
        lanes = blocks[block]
        clear_rows(lanes, SHARES, SHARES + PLACES)
        put_shaft_answers(bearing.ring, bearing, lanes)
        add_spot_turning(bearing.spot, bearing, lanes)
        if border.even:
            _to_even(bearing, lanes)
    leave_out_spares(border.count, blocks, SHAFT_BY_BALL, MOTION + 2 * PLACES + 1)
    leave_out_spares(border.count, blocks, SHARES, PLACES)
    for i in range(at.WIDTH):
        numbers[at.BY_SHAFT + i] = numbers[at.BY_ANGLE + i] = 0.0
    for i in range(2 * PLACES):
        numbers[at.SHAFT_ROW + i] = 0.0
    own = -shaft.damping
    for block in range(len(blocks)):
        lanes = blocks[block]
        own = with_sum(own, 1.0, lanes, SHAFT_OWN)
        multiply_rows(lanes, SHAFT_BY_BALL, SHAFT_BY_BORDER, inverse)
        for i in range(PLACES):
            add_sum(numbers, at.BY_SHAFT + PLACES + i, numbers[at.INVERSE + i], lanes, SHARES + i)
        for i in range(2 * PLACES):
            add_sum(numbers, at.SHAFT_ROW + i, inverse, lanes, SHAFT_BY_BORDER + i)
    own += answer_to_spin(border.land, drive.speed, numbers)
    for i in range(2 * PLACES):
        numbers[at.SHAFT_ROW + i] += inverse * numbers[at.LAND_TURN + i]
    numbers[at.SHAFT_BY_SPEED] = inverse * own
    spin = numbers[at.POLAR_INERTIA]
    numbers[at.BY_SHAFT + PLACES + 3] -= numbers[at.INVERSE + 3] * spin * numbers[at.NOW + PLACES + 4]
    numbers[at.BY_SHAFT + PLACES + 4] += numbers[at.INVERSE + 4] * spin * numbers[at.NOW + PLACES + 3]
    _add_unbalance(drive, time, numbers)


@lean_kernel
def _of_solution(numbers, blocks):
    """What the changes that SOLUTION holds of all but the shaft do to its acceleration."""
    found = 0.0
    for i in range(2 * PLACES):
        found += numbers[at.SHAFT_ROW + i] * numbers[at.SOLUTION + i]
    for block in range(len(blocks)):
        lanes = blocks[block]
        for k in range(LANES):
            place = dot(get_vector(lanes, SHAFT_BY_BALL, k), get_vector(lanes, SOLUTION, k))
            velocity = dot(get_vector(lanes, SHAFT_BY_BALL + VELOCITY, k), get_vector(lanes, SOLUTION + VELOCITY, k))
            spin = dot(get_vector(lanes, SHAFT_BY_BALL + SPIN, k), get_vector(lanes, SOLUTION + SPIN, k))
            put(lanes, SHARES, k, place + velocity + spin)
        found = with_sum(found, 1.0, lanes, SHARES)
    return found


@lean_kernel
def _eliminate(drive, time, coupling, blocks):
    """Solves for what all else comes to by the shaft's speed, and eliminates it."""
    numbers, g = coupling.border.numbers, get(blocks[0], GAIN, 0)
    for i in range(at.WIDTH):
        numbers[at.RIGHT + i] = numbers[at.BY_SHAFT + i] + g * numbers[at.BY_ANGLE + i]
    for block in range(len(blocks)):
        lanes = blocks[block]
        clear_rows(lanes, RIGHT, RIGHT + VELOCITY)
        for row in range(COLUMNS - VELOCITY):
            for k in range(LANES):
                put(lanes, RIGHT + VELOCITY + row, k, get(lanes, BALL_BY_SHAFT + row, k))
    solve_together(drive, time, coupling, blocks)
    for i in range(at.WIDTH):
        numbers[at.SHAFT_SOLVED + i] = numbers[at.SOLUTION + i]
    for block in range(len(blocks)):
        for i in range(STATE_SPAN):
            put(blocks[block], SHAFT_ANSWER, i, get(blocks[block], SOLUTION, i))
    numbers[at.SHAFT_PIVOT] = 1.0 / (1.0 / g - numbers[at.SHAFT_BY_SPEED] - _of_solution(numbers, blocks))


@inlined
def factorise_shaft(shaft, drive, time, coupling, blocks):
    """The shaft's part of the linear system, after `factorise_together`; `shaft` is the border's."""
    if len(shaft) > 0:
        _eliminate(drive, time, coupling, blocks)


@inlined
def solve_with_shaft(shaft, drive, time, coupling, blocks):
    """`solve_together`, with the shaft where a torque turns one; `shaft` is the border's."""
    if len(shaft) > 0:
        _know_angle(get(blocks[0], GAIN, 0), coupling.border.numbers)
    solve_together(drive, time, coupling, blocks)
    if len(shaft) > 0:
        _follow(shaft, time, coupling, blocks)


@lean_kernel
def _know_angle(g, numbers):
    """Adds to the right-hand side of ring and cage what is known of the shaft's angle before a stage is solved."""
    known = g * numbers[at.RIGHT + SHAFT_ANGLE]
    for i in range(SHAFT_ANGLE):
        numbers[at.RIGHT + i] += known * numbers[at.BY_ANGLE + i]


@lean_kernel
def _follow(shaft, time, coupling, blocks):
    """The shaft's change in a stage, and what all else changes with it."""
    numbers, g = coupling.border.numbers, get(blocks[0], GAIN, 0)
    speed = numbers[at.SHAFT_PIVOT] * (numbers[at.RIGHT + SHAFT_SPEED] + _of_solution(numbers, blocks))
    for block in range(len(blocks)):
        for i in range(STATE_SPAN):
            increase(blocks[block], SOLUTION, i, speed * get(blocks[block], SHAFT_ANSWER, i))
    for i in range(SHAFT_ANGLE):
        numbers[at.SOLUTION + i] += speed * numbers[at.SHAFT_SOLVED + i]
    drag = 2.0 * shaft.damping * numbers[at.BEGIN + SHAFT_SPEED]
    torque = numbers[at.LOAD + CAGE] + time * numbers[at.LOAD_RATE + CAGE]
    numbers[at.SOLUTION + LOST] += g * drag * speed
    numbers[at.SOLUTION + SHAFT_SPEED] = speed
    numbers[at.SOLUTION + SHAFT_ANGLE] = g * (numbers[at.RIGHT + SHAFT_ANGLE] + speed)
    numbers[at.SOLUTION + SHAFT_WORK] = g * (numbers[at.RIGHT + SHAFT_WORK] + torque * speed)
