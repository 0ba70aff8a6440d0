"""What balls that touch add to the linear system of a step: tiles, and what goes before and after a solution."""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.layout import (
    AHEAD,
    AHEAD_BY_OWN,
    AXIS_DISTANCE,
    DISSIPATED,
    LOWER,
    MEETS,
    MOTION,
    OWN,
    OWN_BY_AHEAD,
    SPIN,
    TANGENTIAL_VELOCITY,
    UPPER,
    VELOCITY,
    get_part,
)
from bearing_twin.kinds.bearing.forces.pairs import LOSS, SECOND_HALF
from bearing_twin.numerics.block_solve import behind, negative, plus, times
from bearing_twin.numerics.lanes import LANES, get, get_vector, increase, increase_vector, put_tile_part
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import dot


@inlined
def _put_tile(lanes, first, source, k, g, turning):
    """Writes minus the answers from row `source` on as a tile by velocity and spin alone."""
    for row in range(0, 6, 3):
        at = source + row * MOTION
        by_velocity = plus(get_part(lanes, at + VELOCITY, k), behind(get_part(lanes, at, k), g, turning))
        put_tile_part(lanes, first, row, 0, k, negative(by_velocity))
        put_tile_part(lanes, first, row, 3, k, negative(get_part(lanes, at + SPIN, k)))


@inlined
def _turning(g, lanes, ball, k):
    """How the orbit angle of the ball from row `ball` on follows its velocities (`block_solve.Factors`)."""
    inverse = 1.0 / (get(lanes, ball + AXIS_DISTANCE, k) + 1e-300)
    return (-g * g * get(lanes, ball + TANGENTIAL_VELOCITY, k) * inverse * inverse, g * inverse)


@lean_kernel
def pair_tiles(g, lanes):
    """Fills UPPER and LOWER, how a ball's velocity and spin answer to the next one's, and the other way round."""
    for k in range(LANES):
        _put_tile(lanes, UPPER, OWN_BY_AHEAD, k, g, _turning(g, lanes, AHEAD, k))
        _put_tile(lanes, LOWER, AHEAD_BY_OWN, k, g, _turning(g, lanes, OWN, k))


@inlined
def _known_by(answers, k, source, place):
    """What three rows of answers from `source` on make of a known change of place."""
    return times(get_part(answers, source, k), place)


@inlined
def _place_ahead(pairs, place):
    """Block and lane of the ball ahead of the one at a place."""
    following = (place + 1) % pairs.count
    return following // LANES, following % LANES


@lean_kernel
def add_known(pairs, blocks, row):
    """Adds what known changes of position, in the first rows from `row` on, do to the neighbours' right-hand sides.

    Ball by ball, for most contacts are open.
    """
    for place in range(pairs.count):
        answers, own, k = pairs.blocks[place // LANES], blocks[place // LANES], place % LANES
        if not get(answers, MEETS, k) > 0.0:
            continue
        block, j = _place_ahead(pairs, place)
        ahead = blocks[block]
        here, there = get_vector(own, row + AXIS_DISTANCE, k), get_vector(ahead, row + AXIS_DISTANCE, j)
        increase_vector(own, row + VELOCITY, k, _known_by(answers, k, OWN_BY_AHEAD, there))
        increase_vector(own, row + SPIN, k, _known_by(answers, k, OWN_BY_AHEAD + SECOND_HALF, there))
        increase_vector(ahead, row + VELOCITY, j, _known_by(answers, k, AHEAD_BY_OWN, here))
        increase_vector(ahead, row + SPIN, j, _known_by(answers, k, AHEAD_BY_OWN + SECOND_HALF, here))


@lean_kernel
def add_losses(g, pairs, blocks, row):
    """Adds g times the loss by the motion of the ball ahead to the row of losses of the motions from `row` on."""
    first = OWN_BY_AHEAD + LOSS * MOTION
    for place in range(pairs.count):
        answers, own, k = pairs.blocks[place // LANES], blocks[place // LANES], place % LANES
        if not get(answers, MEETS, k) > 0.0:
            continue
        block, j = _place_ahead(pairs, place)
        ahead = blocks[block]
        loss = (
            dot(get_vector(answers, first, k), get_vector(ahead, row + AXIS_DISTANCE, j))
            + dot(get_vector(answers, first + VELOCITY, k), get_vector(ahead, row + VELOCITY, j))
            + dot(get_vector(answers, first + SPIN, k), get_vector(ahead, row + SPIN, j))
        )
        increase(own, row + DISSIPATED, k, g * loss)
