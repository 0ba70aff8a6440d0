"""A stage of balls that meet only in ring and cage, solved in two passes over the lanes.

The first pass takes what is known and eliminates the balls, the border is solved, the second brings its answer back to
the balls. It does for one stage what `linear_system` does step by step where balls touch, too; in two large loops,
because each pass over the lanes costs more than what is reckoned in it.
"""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.jacobian import integral_answers, lane_linear, put_integrals
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_VELOCITY,
    AXIS_DISTANCE,
    BALL_BY_BORDER,
    BALL_TILE,
    BORDER_BY_BALL,
    BORDER_TILE,
    CAGE,
    DISSIPATED,
    DRIVE_WORK,
    FACTOR_RADIUS,
    FACTOR_VELOCITY,
    HEIGHT,
    MOTION,
    PLACES,
    RADIAL_VELOCITY,
    SHARES,
    SPIN,
    VELOCITY,
    entry,
)
from bearing_twin.kinds.bearing.stepping.border import CAGE_SPEED
from bearing_twin.kinds.bearing.stepping.border_solve import (
    ball_solved,
    even_solved,
    mixed,
    outer_two,
    share,
    solve_corner,
)
from bearing_twin.kinds.bearing.stepping.border_system import (
    by_places,
    follow_even,
    follow_integral,
    follow_places,
    known_places,
    known_share,
)
from bearing_twin.numerics.block_solve import times
from bearing_twin.numerics.chain_solve import six
from bearing_twin.numerics.lanes import LANES, RIGHT, SOLUTION, add_sum, get, get_vector, put, put_vector
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import add, minus


@inlined
def _put_share(lanes, r, k, known, velocity, spin):
    """Writes what a ball does to coordinate r of the border: by what is known less by what it is solved to."""
    put(lanes, SHARES + r, k, known_share(lanes, r, k, known) - share(lanes, r, k, velocity, spin))


@inlined
def _eliminate(ring, g, numbers, lanes):
    """`_eliminate_balls` that go round by themselves."""
    places = six(numbers, at.SOLUTION)
    for k in range(LANES):
        linear, right = lane_linear(lanes, k), get_vector(lanes, RIGHT, k)
        radius = g * right[0]
        known = (radius, g * (right[1] + linear.angle_by_radius * radius), g * right[2])
        velocity = add(get_vector(lanes, RIGHT + VELOCITY, k), times(linear.vp, known))
        spin = add(get_vector(lanes, RIGHT + SPIN, k), times(linear.sp, known))
        velocity = add(velocity, by_places(ring, lanes, 0, k, places))
        spin = add(spin, by_places(ring, lanes, 3, k, places))
        velocity, spin = ball_solved(lanes, k, velocity, spin)
        put_vector(lanes, SOLUTION + AXIS_DISTANCE, k, known)
        put_vector(lanes, SOLUTION + VELOCITY, k, velocity)
        put_vector(lanes, SOLUTION + SPIN, k, spin)
        for r in range(at.ring_places(ring)):
            _put_share(lanes, r, k, known, velocity, spin)
        _put_share(lanes, CAGE, k, known, velocity, spin)


@inlined
def _eliminate_even(ring, g, numbers, lanes):
    """`_eliminate` for balls that go round with an even cage: without their orbit angles and tangential velocities."""
    places = six(numbers, at.SOLUTION)
    for k in range(LANES):
        known = g * get(lanes, RIGHT + AXIS_DISTANCE, k), g * get(lanes, RIGHT + HEIGHT, k)
        radial = get(lanes, RIGHT + RADIAL_VELOCITY, k) + outer_two(lanes, entry(RADIAL_VELOCITY, 0), k, known)
        axial = get(lanes, RIGHT + AXIAL_VELOCITY, k) + outer_two(lanes, entry(AXIAL_VELOCITY, 0), k, known)
        turned = (
            outer_two(lanes, entry(SPIN, 0), k, known),
            outer_two(lanes, entry(SPIN + 1, 0), k, known),
            outer_two(lanes, entry(SPIN + 2, 0), k, known),
        )
        spin = add(get_vector(lanes, RIGHT + SPIN, k), turned)
        radial += mixed(ring, lanes, BALL_BY_BORDER, 1, k, places)
        axial += mixed(ring, lanes, BALL_BY_BORDER + 4 * PLACES, 1, k, places)
        spin = add(spin, by_places(ring, lanes, 3, k, places))
        velocity, spin = even_solved(lanes, k, (radial, axial), spin)
        put_vector(lanes, SOLUTION + AXIS_DISTANCE, k, (known[0], 0.0, known[1]))
        put_vector(lanes, SOLUTION + VELOCITY, k, (velocity[0], 0.0, velocity[1]))
        put_vector(lanes, SOLUTION + SPIN, k, spin)
        for r in range(at.ring_places(ring)):
            put(lanes, SHARES + r, k, _even_share(lanes, r, k, known, velocity, spin))
        put(lanes, SHARES + CAGE, k, _even_share(lanes, CAGE, k, known, velocity, spin))


@inlined
def _even_share(lanes, r, k, known, velocity, spin):
    """What `_put_share` writes, of a ball that goes round with an even cage."""
    tile = BORDER_TILE + r
    found = get(lanes, tile, k) * velocity[0]
    found += get(lanes, tile + 12, k) * velocity[1] + get(lanes, tile + 18, k) * spin[0]
    found += get(lanes, tile + 24, k) * spin[1]
    return outer_two(lanes, BORDER_BY_BALL + r * MOTION, k, known) - (found + get(lanes, tile + 30, k) * spin[2])


@lean_kernel
def _eliminate_balls(g, border, lanes):
    """Takes what is known of a stage, solves for the balls' velocities and spins, and takes these from the border."""
    ring, numbers = border.ring, border.numbers
    if border.even:
        _eliminate_even(ring, g, numbers, lanes)
    else:
        _eliminate(ring, g, numbers, lanes)
    for r in range(at.ring_places(ring)):
        add_sum(numbers, at.SOLUTION + PLACES + r, 1.0, lanes, SHARES + r)
    add_sum(numbers, at.SOLUTION + PLACES + CAGE, 1.0, lanes, SHARES + CAGE)


@inlined
def _answer(ring, lanes, row, k, speeds):
    """What the border's velocities do to three of a ball's, from `row` of its tile on."""
    return (
        mixed(ring, lanes, BALL_TILE + row, 6, k, speeds),
        mixed(ring, lanes, BALL_TILE + row + 1, 6, k, speeds),
        mixed(ring, lanes, BALL_TILE + row + 2, 6, k, speeds),
    )


@lean_kernel
def _follow_border(g, border, lanes):
    """The balls' velocities and spins once the border's are known, and what follows from them."""
    ring, numbers, even = border.ring, border.numbers, border.even
    places, speeds = six(numbers, at.SOLUTION), six(numbers, at.SOLUTION + PLACES)
    cage_speed = numbers[at.BEGIN + CAGE_SPEED]
    for k in range(LANES):
        velocity = minus(get_vector(lanes, SOLUTION + VELOCITY, k), _answer(ring, lanes, 0, k, speeds))
        spin = minus(get_vector(lanes, SOLUTION + SPIN, k), _answer(ring, lanes, 3, k, speeds))
        turn = get(lanes, FACTOR_RADIUS, k) * velocity[0] + get(lanes, FACTOR_VELOCITY, k) * velocity[1]
        position = add(get_vector(lanes, SOLUTION, k), (g * velocity[0], turn, g * velocity[2]))
        work, lost = integral_answers(lanes, k, position, velocity, spin)
        work += follow_integral(ring, lanes, DRIVE_WORK, k, places, speeds)
        lost += follow_integral(ring, lanes, DISSIPATED, k, places, speeds)
        put_integrals(g, lanes, k, work, lost)
        put(lanes, SOLUTION + AXIS_DISTANCE, k, position[0])
        angle, along = follow_even(lanes, k, places, speeds, cage_speed)
        turn, along = angle if even else position[1], along if even else velocity[1]
        put_vector(lanes, SOLUTION, k, (position[0], turn, position[2]))
        put_vector(lanes, SOLUTION + VELOCITY, k, (velocity[0], along, velocity[2]))
        put_vector(lanes, SOLUTION + SPIN, k, spin)


@inlined
def solve_apart(g, drive, time, border, blocks):
    """Solves W k = right for one stage of ring, cage, and balls that touch no other."""
    known_places(border.ring, g, border.numbers)
    for block in range(len(blocks)):
        _eliminate_balls(g, border, blocks[block])
    solve_corner(border)
    follow_places(g, drive, time, border)
    for block in range(len(blocks)):
        _follow_border(g, border, blocks[block])
