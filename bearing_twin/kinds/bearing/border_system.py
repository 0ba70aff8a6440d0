"""The part of ring and cage in the linear system of a step: their Jacobian, tiles, and what goes before and after.

Of an even cage the balls' Jacobian by orbit angle and tangential velocity is rewritten as one by the cage's angle and
speed (`_make_even`); all that follows is then the same for any cage and for a ring.
"""

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.border import CAGE_SPEED, applied_load
from bearing_twin.kinds.bearing.cage import pocket_answers
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BALL_TILE,
    BORDER_BY_BALL,
    BORDER_BY_BORDER,
    BORDER_PUSH,
    BORDER_TILE,
    CAGE,
    COLUMNS,
    CORNER_TILE,
    DRIVE_WORK,
    FACTOR_RADIUS,
    FACTOR_VELOCITY,
    LANE_RATES,
    LANES,
    LOST,
    MOTION,
    ORBIT_ANGLE,
    PLACES,
    RADIAL_VELOCITY,
    RIGHT,
    SOLUTION,
    SPIN,
    START,
    TANGENTIAL_VELOCITY,
    VELOCITY,
    WORK_DONE,
    entry,
    get,
    increase,
    put,
)
from bearing_twin.kinds.bearing.ring_gradient import ring_answers
from bearing_twin.numerics import chain_solve


@inlined
def _to_cage(numbers, angle, velocity, out, by_border, lanes):
    """Turns what a row says of orbit angle and tangential velocity over to the even cage.

    What it says of the ball's motion begins at row `angle` - ORBIT_ANGLE of `numbers`, of the border at `by_border` of
    `out`.
    """
    distance = angle - ORBIT_ANGLE + AXIS_DISTANCE
    for k in range(LANES):
        radius, speed = get(lanes, AXIS_DISTANCE, k), get(lanes, TANGENTIAL_VELOCITY, k)
        by_velocity = get(numbers, velocity, k)
        increase(numbers, distance, k, by_velocity * speed / radius)
        increase(out, by_border + CAGE, k, get(numbers, angle, k))
        increase(out, by_border + CAGE_SPEED, k, by_velocity * radius)
        put(numbers, angle, k, 0.0)
        put(numbers, velocity, k, 0.0)


@kernel
def _make_even(bearing, border, lanes, out):
    """Rewrites the Jacobian of balls by their own orbit angle and tangential velocity as one by the cage's."""
    acceleration, mass = border.rates[CAGE_SPEED], bearing.ball_mass
    last, stride = BORDER_BY_BALL + CAGE * MOTION, 2 * PLACES
    tangential = BALL_BY_BORDER + (TANGENTIAL_VELOCITY - VELOCITY) * stride
    # m r (a - w v_r) with v_t still free, less what the growing inertia takes of the acceleration
    for column in range(MOTION):
        for k in range(LANES):
            lever = mass * get(lanes, AXIS_DISTANCE, k)
            put(out, last + column, k, lever * get(lanes, entry(TANGENTIAL_VELOCITY, column), k))
            put(lanes, entry(TANGENTIAL_VELOCITY, column), k, 0.0)
            put(lanes, entry(ORBIT_ANGLE, column), k, 0.0)
    for k in range(LANES):
        radius, radial = get(lanes, AXIS_DISTANCE, k), get(lanes, RADIAL_VELOCITY, k)
        grown = get(lanes, LANE_RATES + TANGENTIAL_VELOCITY, k) - 2.0 * radius * acceleration
        increase(out, last + AXIS_DISTANCE, k, mass * grown)
        increase(out, last + RADIAL_VELOCITY, k, -mass * get(lanes, TANGENTIAL_VELOCITY, k))
        increase(out, last + TANGENTIAL_VELOCITY, k, -mass * radial)
    for i in range(stride):
        for k in range(LANES):
            lever = mass * get(lanes, AXIS_DISTANCE, k)
            put(out, BORDER_BY_BORDER + CAGE * stride + i, k, lever * get(out, tangential + i, k))
            put(out, tangential + i, k, 0.0)
    for rate in range(VELOCITY, COLUMNS):
        at = entry(rate, 0)
        _to_cage(
            lanes, at + ORBIT_ANGLE, at + TANGENTIAL_VELOCITY, out, BALL_BY_BORDER + (rate - VELOCITY) * stride, lanes
        )
    for i in range(PLACES):
        at = BORDER_BY_BALL + i * MOTION
        _to_cage(out, at + ORBIT_ANGLE, at + TANGENTIAL_VELOCITY, out, BORDER_BY_BORDER + i * stride, lanes)


@kernel
def border_jacobian(ring, pockets, bearing, drive, border, time, blocks):
    """How balls and border answer to each other, at the motion of the last `border_rates`, after the balls' own."""
    partners, own = border.partners, border.own
    for block in range(len(blocks)):
        lanes, out = blocks[block], border.blocks[block]
        out[:] = 0.0
        if len(ring) > 0:
            ring_answers(ring, bearing, lanes, out)
        if len(pockets) > 0:
            pocket_answers(pockets, bearing, lanes, out)
        if partners.even:
            _make_even(bearing, border, lanes, out)
        for i in range(PLACES):
            for row in range(BORDER_BY_BALL + i * MOTION, BORDER_BY_BALL + (i + 1) * MOTION):
                for k in range(LANES):
                    put(out, row, k, border.inverse[i] * get(out, row, k))
            for row in range(BORDER_BY_BORDER + i * 2 * PLACES, BORDER_BY_BORDER + (i + 1) * 2 * PLACES):
                for k in range(LANES):
                    put(out, row, k, border.inverse[i] * get(out, row, k))
    own[:] = 0.0
    for i in range(CAGE):
        own[i, i] = -border.inverse[i] * partners.stiffness[i]
        own[i, PLACES + i] = -border.inverse[i] * partners.damping[i]
    spin = partners.polar_inertia * (drive.speed + drive.acceleration * time)
    own[3, PLACES + 4] -= border.inverse[3] * spin
    own[4, PLACES + 3] += border.inverse[4] * spin


@kernel
def border_tiles(g, lanes, out):
    """Tiles of the linear system between the balls in `lanes` and the border, after the balls' own."""
    for c in range(PLACES):
        for r in range(6):
            ball, border = BALL_BY_BORDER + r * 2 * PLACES + c, BORDER_BY_BORDER + r * 2 * PLACES + c
            for k in range(LANES):
                put(out, BALL_TILE + 6 * c + r, k, -(get(out, ball + PLACES, k) + g * get(out, ball, k)))
                put(out, CORNER_TILE + 6 * c + r, k, -(get(out, border + PLACES, k) + g * get(out, border, k)))
    for r in range(PLACES):
        row = BORDER_BY_BALL + r * MOTION
        for k in range(LANES):
            turn_radius, turn_velocity = get(lanes, FACTOR_RADIUS, k), get(lanes, FACTOR_VELOCITY, k)
            angle = get(out, row + ORBIT_ANGLE, k)
            radial = get(out, row + VELOCITY, k) + g * get(out, row + AXIS_DISTANCE, k) + turn_radius * angle
            put(out, BORDER_TILE + r, k, -radial)
            put(out, BORDER_TILE + 6 + r, k, -(get(out, row + VELOCITY + 1, k) + turn_velocity * angle))
            put(out, BORDER_TILE + 12 + r, k, -(get(out, row + VELOCITY + 2, k) + g * get(out, row + 2, k)))
            put(out, BORDER_TILE + 18 + r, k, -get(out, row + SPIN, k))
            put(out, BORDER_TILE + 24 + r, k, -get(out, row + SPIN + 1, k))
            put(out, BORDER_TILE + 30 + r, k, -get(out, row + SPIN + 2, k))


@kernel
def border_corner(g, border, tile):
    """Fills the tile (36,) of the border by itself."""
    for c in range(PLACES):
        for r in range(PLACES):
            total = (1.0 / g if r == c else 0.0) - border.own[r, PLACES + c] - g * border.own[r, c]
            for place in range(border.count):
                total += get(border.blocks[place // LANES], CORNER_TILE + 6 * c + r, place % LANES)
            tile[6 * c + r] = total


@kernel
def border_known(g, border, blocks):
    """What is known before a stage is solved: of the border, and added to the balls; after the balls' own."""
    solution, right = border.solution, border.right
    for i in range(PLACES):
        solution[i] = g * right[i]
        solution[PLACES + i] = right[PLACES + i]
        for j in range(PLACES):
            solution[PLACES + i] += border.own[i, j] * (g * right[j])
    for block in range(len(blocks)):
        lanes, out = blocks[block], border.blocks[block]
        for r in range(PLACES):
            by_ball, by_border = BORDER_BY_BALL + r * MOTION, BORDER_BY_BORDER + r * 2 * PLACES
            for k in range(LANES):
                total = 0.0
                for axis in range(3):
                    total += get(out, by_ball + axis, k) * get(lanes, SOLUTION + axis, k)
                for i in range(PLACES):
                    total += get(out, by_border + i, k) * solution[i]
                put(lanes, BORDER_PUSH + r, k, total)
        for r in range(6):
            row = BALL_BY_BORDER + r * 2 * PLACES
            for k in range(LANES):
                total = 0.0
                for i in range(PLACES):
                    total += get(out, row + i, k) * solution[i]
                increase(lanes, SOLUTION + VELOCITY + r, k, total)
    for place in range(border.count):
        for r in range(PLACES):
            solution[PLACES + r] += get(blocks[place // LANES], BORDER_PUSH + r, place % LANES)


@kernel
def border_follow(g, drive, time, border, blocks):
    """The border's places and integrals by its velocities, those of the balls that follow, and their integrals."""
    partners, solution = border.partners, border.solution
    for i in range(PLACES):
        solution[i] += g * solution[PLACES + i]
    work, lost = border.right[WORK_DONE], border.right[LOST]
    for i in range(CAGE):
        change = partners.free[i] * solution[PLACES + i]
        work += applied_load(partners, drive, time, i) * change
        lost += 2.0 * partners.damping[i] * border.start[PLACES + i] * change
    solution[WORK_DONE], solution[LOST] = g * work, g * lost
    for block in range(len(blocks)):
        lanes, out = blocks[block], border.blocks[block]
        for integral in range(DRIVE_WORK, COLUMNS):
            row = BALL_BY_BORDER + (integral - VELOCITY) * 2 * PLACES
            for k in range(LANES):
                total = 0.0
                for i in range(2 * PLACES):
                    total += get(out, row + i, k) * solution[i]
                increase(lanes, SOLUTION + integral, k, g * total)
        if partners.even:
            speed = border.start[CAGE_SPEED]
            for k in range(LANES):
                radius, grown = get(lanes, START + AXIS_DISTANCE, k), get(lanes, SOLUTION + AXIS_DISTANCE, k)
                put(lanes, SOLUTION + ORBIT_ANGLE, k, solution[CAGE])
                put(lanes, SOLUTION + TANGENTIAL_VELOCITY, k, radius * solution[CAGE_SPEED] + speed * grown)


@kernel
def still_balls(border, blocks):
    """Takes from the right-hand sides what an even cage leaves no freedom for."""
    if border.partners.even:
        for block in range(len(blocks)):
            for k in range(LANES):
                put(blocks[block], RIGHT + ORBIT_ANGLE, k, 0.0)
                put(blocks[block], RIGHT + TANGENTIAL_VELOCITY, k, 0.0)


@inlined
def _copy(lanes, row, k, tile):
    for i in range(chain_solve.SIDE * chain_solve.SIDE):
        tile[i] = get(lanes, row + i, k)


@kernel
def put_border_tiles(g, border, chain):
    """Puts the border's tiles into the system, as its last block."""
    tiles, block = chain.tiles, chain.border - 1
    border_corner(g, border, tiles[chain_solve.corner_tile(chain, block, block)])
    for place in range(border.count):
        out, k = border.blocks[place // LANES], place % LANES
        if place == chain.bodies:
            _copy(out, BALL_TILE, k, tiles[chain_solve.corner_tile(chain, 0, block)])
            _copy(out, BORDER_TILE, k, tiles[chain_solve.corner_tile(chain, block, 0)])
        else:
            _copy(out, BALL_TILE, k, tiles[chain_solve.column_tile(chain, place, block)])
            _copy(out, BORDER_TILE, k, tiles[chain_solve.row_tile(chain, block, place)])
