"""The part of ring and cage in the linear system of a step: their Jacobian, and what goes before and after a solution.

Of an even cage the balls' Jacobian by orbit angle and tangential velocity is rewritten as one by the cage's angle and
speed (`_make_even`); all that follows is then the same for any cage and for a ring. Loops over lanes are innermost and
of one statement a row, so that they become vector instructions.
"""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.border import CAGE_SPEED, applied_load, leave_out_spares
from bearing_twin.kinds.bearing.border_solve import mixed, six
from bearing_twin.kinds.bearing.cage import pocket_answers
from bearing_twin.kinds.bearing.layout import (
    AXIAL_VELOCITY,
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BALL_TILE,
    BORDER_BY_BALL,
    BORDER_BY_BORDER,
    CAGE,
    COLUMNS,
    DRIVE_WORK,
    LANE_RATES,
    LANES,
    LOST,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    RADIAL_VELOCITY,
    RIGHT,
    SHARES,
    SOLUTION,
    START,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    WORK_DONE,
    clear_rows,
    entry,
    get,
    get_vector,
    increase,
    multiply_rows,
    put,
    sum_of,
)
from bearing_twin.kinds.bearing.ring_gradient import ring_answers
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import dot


@inlined
def _to_cage(row, by_border, lanes, k):
    """Turns what a row of answers says of orbit angle and tangential velocity over to the even cage.

    What it says of the ball's motion begins at `row`, of the border at `by_border`.
    """
    radius, speed = get(lanes, AXIS_DISTANCE, k), get(lanes, TANGENTIAL_VELOCITY, k)
    by_velocity = get(lanes, row + TANGENTIAL_VELOCITY, k)
    increase(lanes, row + AXIS_DISTANCE, k, by_velocity * speed / radius)
    increase(lanes, by_border + CAGE, k, get(lanes, row + ORBIT_ANGLE, k))
    increase(lanes, by_border + CAGE_SPEED, k, by_velocity * radius)
    put(lanes, row + ORBIT_ANGLE, k, 0.0)
    put(lanes, row + TANGENTIAL_VELOCITY, k, 0.0)


@lean_kernel
def _make_even(bearing, border, lanes):
    """Rewrites the Jacobian of balls by their own orbit angle and tangential velocity as one by the cage's."""
    acceleration, mass = border.rates[CAGE_SPEED], bearing.ball_mass
    last, stride = BORDER_BY_BALL + CAGE * MOTION, 2 * PLACES
    tangential = BALL_BY_BORDER + (TANGENTIAL_VELOCITY - VELOCITY) * stride
    # m r (a - w v_r) with v_t still free, less what the growing inertia takes of the acceleration
    for k in range(LANES):
        lever = mass * get(lanes, AXIS_DISTANCE, k)
        for column in range(MOTION):
            put(lanes, last + column, k, lever * get(lanes, entry(TANGENTIAL_VELOCITY, column), k))
            put(lanes, entry(TANGENTIAL_VELOCITY, column), k, 0.0)
            put(lanes, entry(ORBIT_ANGLE, column), k, 0.0)
    for k in range(LANES):
        radius, radial = get(lanes, AXIS_DISTANCE, k), get(lanes, RADIAL_VELOCITY, k)
        grown = get(lanes, LANE_RATES + TANGENTIAL_VELOCITY, k) - 2.0 * radius * acceleration
        increase(lanes, last + AXIS_DISTANCE, k, mass * grown)
        increase(lanes, last + RADIAL_VELOCITY, k, -mass * get(lanes, TANGENTIAL_VELOCITY, k))
        increase(lanes, last + TANGENTIAL_VELOCITY, k, -mass * radial)
    for k in range(LANES):
        lever = mass * get(lanes, AXIS_DISTANCE, k)
        for i in range(stride):
            put(lanes, BORDER_BY_BORDER + CAGE * stride + i, k, lever * get(lanes, tangential + i, k))
            put(lanes, tangential + i, k, 0.0)
    for k in range(LANES):
        _to_cage(entry(RADIAL_VELOCITY, 0), BALL_BY_BORDER, lanes, k)
        for rate in range(AXIAL_VELOCITY, DRIVE_WORK):
            _to_cage(entry(rate, 0), BALL_BY_BORDER + (rate - VELOCITY) * stride, lanes, k)
    for k in range(LANES):
        for rate in range(DRIVE_WORK, COLUMNS):
            _to_cage(entry(rate, 0), BALL_BY_BORDER + (rate - VELOCITY) * stride, lanes, k)
    if len(border.partners.ring) > 0:
        for k in range(LANES):
            for i in range(CAGE):
                _to_cage(BORDER_BY_BALL + i * MOTION, BORDER_BY_BORDER + i * stride, lanes, k)
    for k in range(LANES):
        _to_cage(BORDER_BY_BALL + CAGE * MOTION, BORDER_BY_BORDER + CAGE * stride, lanes, k)


@lean_kernel
def _own_jacobian(drive, border, time):
    """What the border's accelerations answer to its own motion without the balls."""
    partners, own, inverse = border.partners, border.own, border.inverse
    own[:] = 0.0
    for i in range(CAGE):
        own[i, i] = -inverse[i] * partners.stiffness[i]
        own[i, PLACES + i] = -inverse[i] * partners.damping[i]
    spin = partners.polar_inertia * (drive.speed + drive.acceleration * time)
    own[3, PLACES + 4] -= inverse[3] * spin
    own[4, PLACES + 3] += inverse[4] * spin


@lean_kernel
def border_jacobian(ring, pockets, bearing, drive, border, time, blocks):
    """How balls and border answer to each other, at the motion of the last `border_rates`, after the balls' own."""
    partners, own, stride = border.partners, border.own, 2 * PLACES
    for block in range(len(blocks)):
        lanes = blocks[block]
        clear_rows(lanes, BALL_BY_BORDER, BALL_TILE)
        if len(ring) > 0 and len(partners.ring) > 0:
            ring_answers(ring, bearing, lanes)
        if len(pockets) > 0:
            pocket_answers(pockets, bearing, lanes)
        if partners.even:
            _make_even(bearing, border, lanes)
    leave_out_spares(border.count, blocks, BORDER_BY_BALL, BALL_TILE - BORDER_BY_BALL)
    _own_jacobian(drive, border, time)
    first = 0 if len(partners.ring) > 0 else CAGE
    for block in range(len(blocks)):
        lanes = blocks[block]
        for r in range(first, PLACES):
            inverse = border.inverse[r]
            at = BORDER_BY_BALL + r * MOTION
            multiply_rows(lanes, at, at + MOTION, inverse)
            for c in range(first, PLACES):
                at = BORDER_BY_BORDER + r * stride + c
                own[r, c] += inverse * sum_of(lanes, at)
                own[r, PLACES + c] += inverse * sum_of(lanes, at + PLACES)


@lean_kernel
def border_known(g, border, blocks):
    """What is known before a stage is solved: of the border, and added to the balls; after the balls' own."""
    solution, right = border.solution, border.right
    for i in range(PLACES):
        solution[i] = g * right[i]
    for i in range(PLACES):
        total = right[PLACES + i]
        for j in range(PLACES):
            total += border.own[i, j] * solution[j]
        solution[PLACES + i] = total
    places, ring = six(solution, 0), border.partners.ring
    for block in range(len(blocks)):
        lanes = blocks[block]
        for k in range(LANES):
            known = get_vector(lanes, SOLUTION, k)
            if len(ring) > 0:
                for r in range(CAGE):
                    put(lanes, SHARES + r, k, dot(get_vector(lanes, BORDER_BY_BALL + r * MOTION, k), known))
            put(lanes, SHARES + CAGE, k, dot(get_vector(lanes, BORDER_BY_BALL + CAGE * MOTION, k), known))
            for r in range(6):
                row = BALL_BY_BORDER + r * 2 * PLACES
                increase(lanes, SOLUTION + VELOCITY + r, k, mixed(ring, lanes, row, 1, k, places))
        for r in range(PLACES):
            solution[PLACES + r] += sum_of(lanes, SHARES + r)


@lean_kernel
def border_follow(g, drive, time, border, blocks):
    """The border's places and integrals by its velocities, those of the balls that follow, and their integrals."""
    partners, solution = border.partners, border.solution
    work, lost = border.right[WORK_DONE], border.right[LOST]
    for i in range(PLACES):
        solution[i] += g * solution[PLACES + i]
    if len(partners.ring) > 0:
        for i in range(CAGE):
            change = partners.free[i] * solution[PLACES + i]
            work += applied_load(partners, drive, time, i) * change
            lost += 2.0 * partners.damping[i] * border.start[PLACES + i] * change
    solution[WORK_DONE], solution[LOST] = g * work, g * lost
    places, speeds, ring = six(solution, 0), six(solution, PLACES), partners.ring
    for block in range(len(blocks)):
        lanes = blocks[block]
        for k in range(LANES):
            for integral in range(DRIVE_WORK, COLUMNS):
                row = BALL_BY_BORDER + (integral - VELOCITY) * 2 * PLACES
                found = mixed(ring, lanes, row, 1, k, places) + mixed(ring, lanes, row + PLACES, 1, k, speeds)
                increase(lanes, SOLUTION + integral, k, g * found)
        if partners.even:
            speed = border.start[CAGE_SPEED]
            for k in range(LANES):
                radius, grown = get(lanes, START + AXIS_DISTANCE, k), get(lanes, SOLUTION + AXIS_DISTANCE, k)
                put(lanes, SOLUTION + ORBIT_ANGLE, k, solution[CAGE])
                put(lanes, SOLUTION + TANGENTIAL_VELOCITY, k, radius * solution[CAGE_SPEED] + speed * grown)


@lean_kernel
def still_balls(border, blocks):
    """Takes from the right-hand sides what an even cage leaves no freedom for."""
    if border.partners.even:
        for block in range(len(blocks)):
            for k in range(LANES):
                put(blocks[block], RIGHT + ORBIT_ANGLE, k, 0.0)
                put(blocks[block], RIGHT + TANGENTIAL_VELOCITY, k, 0.0)
