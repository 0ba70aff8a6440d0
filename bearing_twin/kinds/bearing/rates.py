"""The right-hand side of a bearing, put together: raceways by whatever law and friction, and balls that touch."""

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.equations import add_pair_rates, give_coefficients, raceway_rates
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    LANE_RATES,
    LANES,
    MOTION,
    RING_SPEED,
    from_lane,
    into_lane,
    put,
)
from bearing_twin.kinds.bearing.spot import add_spots


@kernel
def lane_rates(bearing, lanes):
    """`raceway_rates` by whatever law and friction."""
    give_coefficients(bearing, lanes)
    raceway_rates(bearing, lanes)
    add_spots(bearing.spot, bearing, lanes)


@inlined
def put_ring_speed(drive, time, lanes):
    """Gives all lanes the inner ring's speed at `time` [s]."""
    speed = drive.speed + drive.acceleration * time
    for k in range(LANES):
        put(lanes, RING_SPEED, k, speed)


@kernel
def fill_lanes(drive, time, state, balls, first, lanes):
    """Puts the motion of up to LANES of the balls numbered in `balls`, from place `first` on, into lanes; how many.

    Lanes left over repeat the last ball. The ring's speed is that at `time` [s].
    """
    count = min(LANES, len(balls) - first)
    for k in range(LANES):
        into_lane(state[balls[first + min(k, count - 1)], :MOTION], lanes, AXIS_DISTANCE, k)
    put_ring_speed(drive, time, lanes)
    return count


@kernel
def bearing_rates(bearing, drive, near, time, state, balls, rates, lanes):
    """d(state)/dt at `time` [s] of the balls numbered in `balls`; `lanes` is room to work in."""
    for first in range(0, len(balls), LANES):
        count = fill_lanes(drive, time, state, balls, first, lanes)
        lane_rates(bearing, lanes)
        for k in range(count):
            from_lane(lanes, LANE_RATES, k, rates[balls[first + k]])
    for ball in balls:
        add_pair_rates(bearing, near, state, ball, rates)
