"""The right-hand side of a bearing, put together: raceways by whatever law and friction, and balls that touch."""

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elasticity import in_lanes
from bearing_twin.kinds.bearing.cage import add_pockets
from bearing_twin.kinds.bearing.equations import give_coefficients, rates_of_raceways
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    COLUMNS,
    LANE_RATES,
    LANE_ROWS,
    LANES,
    MOTION_SPAN,
    RING_SPEED,
    STATE_SPAN,
    from_blocks,
    get,
    into_blocks,
    new_blocks,
    put,
)
from bearing_twin.kinds.bearing.moving_cage import add_moving_pockets
from bearing_twin.kinds.bearing.pairs import add_pairs, new_pairs
from bearing_twin.kinds.bearing.ring_seat import put_still_ring
from bearing_twin.kinds.bearing.spot import add_spots


@inlined
def rates_in_lanes(bearing, lanes):
    """`raceway_rates` by whatever law and friction, and what the pockets of a cage do; put into its caller."""
    if not in_lanes(bearing.inner.law):
        give_coefficients(bearing, lanes)
    rates_of_raceways(bearing, lanes)
    add_spots(bearing.spot, bearing, lanes)
    add_pockets(bearing.pockets, bearing, lanes)
    add_moving_pockets(bearing.pockets, bearing, lanes)


@kernel
def lane_rates(bearing, lanes):
    """`rates_in_lanes`, called by its callers."""
    rates_in_lanes(bearing, lanes)


@inlined
def put_ring_speed(drive, time, lanes):
    """Gives all lanes the inner ring's speed at `time` [s]."""
    speed = drive.speed + drive.acceleration * time
    for k in range(LANES):
        put(lanes, RING_SPEED, k, speed)


@kernel
def block_rates(bearing, drive, pairs, time, values, rates, lanes):
    """Rates of all balls at `time` [s] from `values`, both (blocks, STATE_SPAN or more).

    `lanes` (a row a block) hold what the law carries, and are room to work in.
    """
    for block in range(len(values)):
        room = lanes[block]
        for i in range(MOTION_SPAN):
            put(room, AXIS_DISTANCE, i, values[block, i])
        put_ring_speed(drive, time, room)
        put_still_ring(bearing.ring, bearing, room)
        lane_rates(bearing, room)
        for i in range(STATE_SPAN):
            rates[block, i] = get(room, LANE_RATES, i)
    if pairs.touching:
        add_pairs(bearing, pairs, values, rates, AXIS_DISTANCE)


@kernel
def bearing_rates(bearing, drive, near, time, state, rates):
    """d(state)/dt of all balls at `time` [s], one row a ball, with nothing carried; `near` as for `new_pairs`."""
    values = new_blocks(len(state), COLUMNS)
    found = np.zeros_like(values)
    into_blocks(state, values, AXIS_DISTANCE)
    pairs = new_pairs(near, np.arange(len(state)), 1.0)
    block_rates(bearing, drive, pairs, time, values, found, new_blocks(len(state), LANE_ROWS))
    from_blocks(found, AXIS_DISTANCE, rates)
