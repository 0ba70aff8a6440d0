"""The right-hand side of a bearing, put together: raceways by whatever law and friction, and balls that touch."""

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elasticity import looked_up
from bearing_twin.kinds.bearing.forces.cage import add_pockets
from bearing_twin.kinds.bearing.forces.equations import give_coefficients, rates_of_raceways
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, LANE_ROWS, RING_SPEED
from bearing_twin.kinds.bearing.forces.moving_cage import add_moving_pockets
from bearing_twin.kinds.bearing.forces.pairs import add_pairs, new_pairs
from bearing_twin.kinds.bearing.forces.ring_seat import put_still_ring
from bearing_twin.kinds.bearing.forces.spot import rates_with_spots
from bearing_twin.numerics.lanes import LANE_RATES, LANES, from_blocks, into_blocks, new_blocks, put


@inlined
def rates_in_lanes(bearing, lanes):
    """`raceway_rates` by whatever law and friction, and what the pockets of a cage do; put into its caller."""
    if looked_up(bearing.inner.law):
        give_coefficients(bearing, lanes)
    if len(bearing.spot) == 0:
        rates_of_raceways(bearing, lanes)
    add_others(bearing, lanes)


@inlined
def add_others(bearing, lanes):
    """Adds to the rates of raceways what pockets do; friction over the spots finds the rates of raceways anew."""
    rates_with_spots(bearing.spot, bearing, lanes)
    add_pockets(bearing.pockets, bearing, lanes)
    add_moving_pockets(bearing.pockets, bearing, lanes)


@kernel
def lane_rates(bearing, lanes):
    """`rates_in_lanes` as a function of its own; to call it in each stage of a step made runs of balls 6 % slower."""
    rates_in_lanes(bearing, lanes)


@inlined
def put_ring_speed(drive, time, lanes):
    """Gives all lanes the inner ring's speed at `time` [s]."""
    speed = drive.speed + drive.acceleration * time
    for k in range(LANES):
        put(lanes, RING_SPEED, k, speed)


@inlined
def block_rates(bearing, drive, pairs, time, blocks):
    """Rates of all balls at `time` [s] in the lanes of `blocks`, which hold their motion and what the law carries."""
    for block in range(len(blocks)):
        lanes = blocks[block]
        put_ring_speed(drive, time, lanes)
        put_still_ring(bearing.ring, bearing, lanes)
        rates_in_lanes(bearing, lanes)
    if pairs.touching:
        add_pairs(bearing, pairs, blocks, blocks, LANE_RATES)


@kernel
def bearing_rates(bearing, drive, near, time, state, rates):
    """d(state)/dt of all balls at `time` [s], one row a ball, with nothing carried; `near` as for `new_pairs`."""
    blocks = new_blocks(len(state), LANE_ROWS)
    into_blocks(state, blocks, AXIS_DISTANCE)
    block_rates(bearing, drive, new_pairs(near, np.arange(len(state)), 1.0), time, blocks)
    from_blocks(blocks, LANE_RATES, rates)
