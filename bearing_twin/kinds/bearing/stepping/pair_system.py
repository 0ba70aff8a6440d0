"""What balls that touch add to the linear system of a step: tiles, and what goes before and after a solution."""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.layout import (
    AHEAD,
    AHEAD_BY_OWN,
    AHEAD_PUSH,
    AXIS_DISTANCE,
    DISSIPATED,
    LOWER,
    MOTION,
    OWN,
    OWN_BY_AHEAD,
    OWN_PUSH,
    SPIN,
    TANGENTIAL_VELOCITY,
    UPPER,
    VELOCITY,
    get_part,
)
from bearing_twin.kinds.bearing.forces.pairs import LOSS, SECOND_HALF, add_pushes, look_ahead
from bearing_twin.numerics.block_solve import behind, negative, plus, times
from bearing_twin.numerics.lanes import LANES, get, get_vector, increase, put, put_tile_part, put_vector
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
def _by_place(lanes, first, k, ball):
    """What three rows of answers from `first` on make of the positions of the ball from row `ball` on."""
    return times(get_part(lanes, first, k), get_vector(lanes, ball + AXIS_DISTANCE, k))


@lean_kernel
def add_known(pairs, blocks, row):
    """Adds what known changes of position, in the first rows from `row` on, do to the neighbours' right-hand sides."""
    look_ahead(pairs, blocks, row, VELOCITY)
    for block in range(len(blocks)):
        lanes = pairs.blocks[block]
        for k in range(LANES):
            put_vector(lanes, OWN_PUSH, k, _by_place(lanes, OWN_BY_AHEAD, k, AHEAD))
            put_vector(lanes, OWN_PUSH + 3, k, _by_place(lanes, OWN_BY_AHEAD + SECOND_HALF, k, AHEAD))
            put(lanes, OWN_PUSH + LOSS, k, 0.0)
            put_vector(lanes, AHEAD_PUSH, k, _by_place(lanes, AHEAD_BY_OWN, k, OWN))
            put_vector(lanes, AHEAD_PUSH + 3, k, _by_place(lanes, AHEAD_BY_OWN + SECOND_HALF, k, OWN))
    add_pushes(pairs, blocks, row + VELOCITY)


@lean_kernel
def add_losses(g, pairs, blocks, row):
    """Adds g times the loss by the motion of the ball ahead to the row of losses of the motions from `row` on."""
    look_ahead(pairs, blocks, row, MOTION)
    for block in range(len(blocks)):
        here, there = pairs.blocks[block], blocks[block]
        for k in range(LANES):
            first = OWN_BY_AHEAD + LOSS * MOTION
            loss = (
                dot(get_vector(here, first, k), get_vector(here, AHEAD + AXIS_DISTANCE, k))
                + dot(get_vector(here, first + VELOCITY, k), get_vector(here, AHEAD + VELOCITY, k))
                + dot(get_vector(here, first + SPIN, k), get_vector(here, AHEAD + SPIN, k))
            )
            put(here, OWN_PUSH + LOSS, k, g * loss)
        for k in range(LANES):
            increase(there, row + DISSIPATED, k, get(here, OWN_PUSH + LOSS, k))
