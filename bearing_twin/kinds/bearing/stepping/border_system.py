"""The part of ring and cage in the linear system of a step: their Jacobian, and what goes before and after a solution.

Of an even cage the balls' Jacobian by orbit angle and tangential velocity is rewritten as one by the cage's angle and
speed (`_make_even`); all that follows is then the same for any cage and for a ring. Loops over lanes are innermost and
of one statement a row, so that they become vector instructions.
"""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.cage import pocket_answers
from bearing_twin.kinds.bearing.forces.land import follow_land, land_answers
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_VELOCITY,
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BALL_TILE,
    BORDER_BY_BALL,
    BORDER_BY_BORDER,
    CAGE,
    DISSIPATED,
    DRIVE_WORK,
    LAND_WORK,
    LINEARISED,
    LOST,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    POWER_SIGN,
    RADIAL_VELOCITY,
    SHARES,
    SPIN,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    WORK_DONE,
    entry,
)
from bearing_twin.kinds.bearing.forces.moving_cage_answers import moving_pocket_answers
from bearing_twin.kinds.bearing.stepping.border import CAGE_SPEED, border_load, leave_out_spares, unbalance_pulls
from bearing_twin.kinds.bearing.stepping.border_solve import mixed, of_cage
from bearing_twin.numerics.chain_solve import six
from bearing_twin.numerics.lanes import (
    LANE_RATES,
    LANES,
    RIGHT,
    SOLUTION,
    START,
    add_sum,
    get,
    get_vector,
    increase,
    increase_vector,
    multiply_rows,
    put,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import dot, scaled


@inlined
def to_cage(row, by_border, lanes, k):
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
    acceleration, mass = border.numbers[at.RATES + CAGE_SPEED], bearing.ball_mass
    last, stride = BORDER_BY_BALL + CAGE * MOTION, 2 * PLACES
    tangential = BALL_BY_BORDER + (TANGENTIAL_VELOCITY - VELOCITY) * stride
    for k in range(LANES):
        # m r (a - w v_r) with v_t still free, less what the growing inertia takes of the acceleration
        radius, radial = get(lanes, AXIS_DISTANCE, k), get(lanes, RADIAL_VELOCITY, k)
        lever = mass * radius
        for column in range(MOTION):
            put(lanes, last + column, k, lever * get(lanes, entry(TANGENTIAL_VELOCITY, column), k))
            put(lanes, entry(TANGENTIAL_VELOCITY, column), k, 0.0)
            put(lanes, entry(ORBIT_ANGLE, column), k, 0.0)
        grown = get(lanes, LANE_RATES + TANGENTIAL_VELOCITY, k) - 2.0 * radius * acceleration
        increase(lanes, last + AXIS_DISTANCE, k, mass * grown)
        increase(lanes, last + RADIAL_VELOCITY, k, -mass * get(lanes, TANGENTIAL_VELOCITY, k))
        increase(lanes, last + TANGENTIAL_VELOCITY, k, -mass * radial)
        for i in range(stride):
            put(lanes, BORDER_BY_BORDER + CAGE * stride + i, k, lever * get(lanes, tangential + i, k))
            put(lanes, tangential + i, k, 0.0)
        to_cage(entry(RADIAL_VELOCITY, 0), BALL_BY_BORDER, lanes, k)
        for rate in range(AXIAL_VELOCITY, LINEARISED):
            to_cage(entry(rate, 0), BALL_BY_BORDER + (rate - VELOCITY) * stride, lanes, k)
        for i in range(at.ring_places(border.ring)):
            to_cage(BORDER_BY_BALL + i * MOTION, BORDER_BY_BORDER + i * stride, lanes, k)
        to_cage(BORDER_BY_BALL + CAGE * MOTION, BORDER_BY_BORDER + CAGE * stride, lanes, k)


@lean_kernel
def _own_jacobian(drive, numbers, time):
    """What the border's accelerations answer to its own motion without the balls."""
    for i in range(2 * PLACES * PLACES):
        numbers[at.OWN + i] = 0.0
    for i in range(CAGE):
        inverse, own = numbers[at.INVERSE + i], at.OWN + i * 2 * PLACES + i
        numbers[own] = -inverse * numbers[at.STIFFNESS + i]
        numbers[own + PLACES] = -inverse * numbers[at.DAMPING + i]
    spin = numbers[at.POLAR_INERTIA] * (drive.speed + drive.acceleration * time)
    numbers[at.OWN + 3 * 2 * PLACES + PLACES + 4] -= numbers[at.INVERSE + 3] * spin
    numbers[at.OWN + 4 * 2 * PLACES + PLACES + 3] += numbers[at.INVERSE + 4] * spin


@inlined
def _sum_row(ring, numbers, r, lanes):
    """Adds up how place r of the border answers, and divides it by its inertia."""
    inverse, row = numbers[at.INVERSE + r], BORDER_BY_BALL + r * MOTION
    multiply_rows(lanes, row, row + MOTION, inverse)
    for c in range(at.ring_places(ring)):
        _sum_entry(numbers, inverse, r, c, lanes)
    _sum_entry(numbers, inverse, r, CAGE, lanes)


@inlined
def _sum_entry(numbers, inverse, r, c, lanes):
    row, own = BORDER_BY_BORDER + r * 2 * PLACES + c, at.OWN + r * 2 * PLACES + c
    add_sum(numbers, own, inverse, lanes, row)
    add_sum(numbers, own + PLACES, inverse, lanes, row + PLACES)


@lean_kernel
def border_jacobian(pockets, bearing, drive, border, time, blocks):
    """How balls and border answer to each other, at the motion of the last `border_rates`; after that of balls."""
    numbers = border.numbers
    for block in range(len(blocks)):
        lanes = blocks[block]
        pocket_answers(pockets, bearing, lanes)
        moving_pocket_answers(pockets, bearing, lanes)
        if border.even:
            _make_even(bearing, border, lanes)
    leave_out_spares(border.count, blocks, BORDER_BY_BALL, BALL_TILE - BORDER_BY_BALL)
    _own_jacobian(drive, numbers, time)
    if len(border.land) > 0:
        land_answers(border.land, drive.speed + drive.acceleration * time, numbers)
    for block in range(len(blocks)):
        for r in range(at.ring_places(border.ring)):
            _sum_row(border.ring, numbers, r, blocks[block])
        _sum_row(border.ring, numbers, CAGE, blocks[block])


@inlined
def known_places(ring, g, numbers):
    """What is known of the border before a stage: changes of its places, and the right-hand side of its velocities."""
    for i in range(2 * PLACES):
        numbers[at.SOLUTION + i] = 0.0  # of places that are not met
    for i in range(at.ring_places(ring)):
        numbers[at.SOLUTION + i] = g * numbers[at.RIGHT + i]
    numbers[at.SOLUTION + CAGE] = g * numbers[at.RIGHT + CAGE]
    for i in range(at.ring_places(ring)):
        _know_velocity(ring, numbers, i)
    _know_velocity(ring, numbers, CAGE)


@inlined
def _know_velocity(ring, numbers, i):
    """The right-hand side of the velocity of place i."""
    total, own = numbers[at.RIGHT + PLACES + i], at.OWN + i * 2 * PLACES
    for j in range(at.ring_places(ring)):
        total += numbers[own + j] * numbers[at.SOLUTION + j]
    numbers[at.SOLUTION + PLACES + i] = total + numbers[own + CAGE] * numbers[at.SOLUTION + CAGE]


@inlined
def known_share(lanes, r, k, known):
    """What the changes of a ball's position that are `known` do to coordinate r of the border."""
    return dot(get_vector(lanes, BORDER_BY_BALL + r * MOTION, k), known)


@inlined
def by_places(ring, lanes, first, k, places):
    """What changes of the border's places do to three rates of a ball, from the one `first` after VELOCITY on."""
    row = BALL_BY_BORDER + first * 2 * PLACES
    return (
        mixed(ring, lanes, row, 1, k, places),
        mixed(ring, lanes, row + 2 * PLACES, 1, k, places),
        mixed(ring, lanes, row + 4 * PLACES, 1, k, places),
    )


@lean_kernel
def border_known(g, border, blocks):
    """What is known before a stage is solved: of the border, and added to the balls; after the balls' own."""
    numbers, ring = border.numbers, border.ring
    known_places(ring, g, numbers)
    places = six(numbers, at.SOLUTION)
    for block in range(len(blocks)):
        lanes = blocks[block]
        for k in range(LANES):
            known = get_vector(lanes, SOLUTION, k)
            for r in range(at.ring_places(ring)):
                put(lanes, SHARES + r, k, known_share(lanes, r, k, known))
            put(lanes, SHARES + CAGE, k, known_share(lanes, CAGE, k, known))
            increase_vector(lanes, SOLUTION + VELOCITY, k, by_places(ring, lanes, 0, k, places))
            increase_vector(lanes, SOLUTION + SPIN, k, by_places(ring, lanes, 3, k, places))
        for r in range(at.ring_places(ring)):
            add_sum(numbers, at.SOLUTION + PLACES + r, 1.0, lanes, SHARES + r)
        add_sum(numbers, at.SOLUTION + PLACES + CAGE, 1.0, lanes, SHARES + CAGE)


@inlined
def follow_places(g, drive, time, border):
    """The border's places and integrals by its velocities."""
    numbers, ring = border.numbers, border.ring
    work, lost = numbers[at.RIGHT + WORK_DONE], numbers[at.RIGHT + LOST]
    numbers[at.SOLUTION + CAGE] += g * numbers[at.SOLUTION + CAGE_SPEED]
    if len(ring) > 0:
        pulls = unbalance_pulls(numbers[at.UNBALANCE], numbers[at.PHASE], drive, time)
        for i in range(at.ring_places(ring)):
            numbers[at.SOLUTION + i] += g * numbers[at.SOLUTION + PLACES + i]
            change = numbers[at.FREE + i] * numbers[at.SOLUTION + PLACES + i]
            work += border_load(pulls, numbers, time, i) * change
            lost += 2.0 * numbers[at.DAMPING + i] * numbers[at.BEGIN + PLACES + i] * change
    numbers[at.SOLUTION + WORK_DONE], numbers[at.SOLUTION + LOST] = g * work, g * lost
    numbers[at.SOLUTION + LAND_WORK] = 0.0  # a step made again, whose numbers were not finite, leaves them here
    if len(border.land) > 0:
        follow_land(border.land, g, numbers)


@inlined
def follow_integral(ring, lanes, integral, k, places, speeds):
    """What the border's changes do to the rate of an integral of a ball that has a row in the Jacobian."""
    row = BALL_BY_BORDER + (integral - VELOCITY) * 2 * PLACES
    return mixed(ring, lanes, row, 1, k, places) + mixed(ring, lanes, row + PLACES, 1, k, speeds)


@inlined
def follow_even(lanes, k, places, speeds, speed):
    """Orbit angle and tangential velocity of a ball that goes round with an even cage at `speed`."""
    radius, grown = get(lanes, START + AXIS_DISTANCE, k), get(lanes, SOLUTION + AXIS_DISTANCE, k)
    return of_cage(places), radius * of_cage(speeds) + speed * grown


@lean_kernel
def border_follow(g, drive, time, border, blocks):
    """The border's places and integrals by its velocities, those of the balls that follow, and their integrals."""
    numbers, ring = border.numbers, border.ring
    follow_places(g, drive, time, border)
    places, speeds = six(numbers, at.SOLUTION), six(numbers, at.SOLUTION + PLACES)
    for block in range(len(blocks)):
        lanes = blocks[block]
        for k in range(LANES):
            work = follow_integral(ring, lanes, DRIVE_WORK, k, places, speeds)
            lost = follow_integral(ring, lanes, DISSIPATED, k, places, speeds)
            increase_vector(lanes, SOLUTION + DRIVE_WORK, k, scaled(g, (work, lost, get(lanes, POWER_SIGN, k) * work)))
        if border.even:
            speed = numbers[at.BEGIN + CAGE_SPEED]
            for k in range(LANES):
                angle, tangential = follow_even(lanes, k, places, speeds, speed)
                put(lanes, SOLUTION + ORBIT_ANGLE, k, angle)
                put(lanes, SOLUTION + TANGENTIAL_VELOCITY, k, tangential)


@lean_kernel
def still_balls(border, blocks):
    """Takes from the right-hand sides what an even cage leaves no freedom for."""
    if border.even:
        for block in range(len(blocks)):
            for k in range(LANES):
                put(blocks[block], RIGHT + ORBIT_ANGLE, k, 0.0)
                put(blocks[block], RIGHT + TANGENTIAL_VELOCITY, k, 0.0)
