"""The right-hand side of a bearing, put together: raceways by whatever law and friction, and balls that touch."""

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.equations import (
    LANE_RATES,
    LANES,
    MOTION,
    RING_SPEED,
    add_pair_rates,
    from_lane,
    give_coefficients,
    into_lane,
    raceway_rates,
)
from bearing_twin.kinds.bearing.spot import add_spots


@kernel
def lane_rates(bearing, lanes):
    """`raceway_rates` by whatever law and friction."""
    give_coefficients(bearing, lanes)
    raceway_rates(bearing, lanes)
    add_spots(bearing.spot, bearing, lanes)


@kernel
def bearing_rates(bearing, drive, near, time, state, balls, rates, lanes):
    """d(state)/dt at `time` [s] of the balls numbered in `balls`; `lanes` is room to work in."""
    for first in range(0, len(balls), LANES):
        count = min(LANES, len(balls) - first)
        for k in range(LANES):
            into_lane(state[balls[first + min(k, count - 1)], :MOTION], lanes, k)
            lanes[RING_SPEED * LANES + k] = drive.speed + drive.acceleration * time
        lane_rates(bearing, lanes)
        for k in range(count):
            from_lane(lanes[LANE_RATES * LANES :], k, rates[balls[first + k]])
    for ball in balls:
        add_pair_rates(bearing, near, state, ball, rates)
