"""What a bearing gives out as rows of all channels, out of lanes: LANES pairs of an output and a ball at a time."""

from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.equations import RingDrive
from bearing_twin.kinds.bearing.forces.handing import handed, taken
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    BORDER_MOTION,
    PLACES,
    RING_SPEED,
    SHAFT_ANGLE,
    SHAFT_SPEED,
)
from bearing_twin.kinds.bearing.output_lanes import (
    ANGLE_OUT,
    ELASTIC,
    INNER_FORCE,
    OUTPUT_ROWS,
    OWN_ORIENTATION,
    fill_outputs,
)
from bearing_twin.kinds.bearing.output_pairs import neighbour_gaps, write_pairs
from bearing_twin.numerics.lanes import COLUMNS, LANES, first_of, new_lanes, put
from bearing_twin.numerics.lean import lean_kernel

DRIVE_TORQUE = 16  # columns after the ring's angle
ONE, TWO, THREE, FOUR, EIGHT = np.array([1, 2, 3, 4, 8], dtype=np.uint64)
ZERO = np.int64(0)  # for a plain one numba would compile `_spread` anew


class RowPlaces(NamedTuple):
    """Where numbers stand in a row of all channels: those of ball k in own channel i at `first[i] + k width[i]`.

    `sums` over the balls begin at `shared`.
    """

    first: np.ndarray
    width: np.ndarray
    ring: int
    shared: int
    sums: int
    neighbours: int
    position: int
    force: int


@inlined
def _load(states, orientations, begin, last, lanes):
    """Copies the balls of all lanes out of flat arrays, one after the other from number `begin` on, up to `last`."""
    for k in range(LANES):
        pair = min(begin + k, last)
        for column in range(COLUMNS):
            put(lanes, AXIS_DISTANCE + column, k, states[np.uint64(pair * COLUMNS + column)])
        for part in range(4):
            put(lanes, OWN_ORIENTATION + part, k, orientations[np.uint64(4 * pair + part)])


@inlined
def _eight(numbers, first):
    """Eight numbers read before any is written: one instruction each way."""
    low = numbers[first], numbers[first + ONE], numbers[first + TWO], numbers[first + THREE]
    first += FOUR
    return *low, numbers[first], numbers[first + ONE], numbers[first + TWO], numbers[first + THREE]


@lean_kernel
def _spread(places, lanes, first, count, ball, begin, out):
    """Writes `count` lanes from `first` on, balls of one output from number `ball` on, into its row of all channels.

    The row begins at `begin` in the flat `out`. Their shares are added ball by ball; ball 0 begins.
    """
    source = first_of(ANGLE_OUT)
    for i in range(len(places.first)):
        width = places.width[i]
        place, there = np.uint64(begin + places.first[i] + ball * width), np.uint64(source + first * width)
        source += first_of(width)
        if np.uint64(count) == EIGHT:
            for _ in range(width):
                a, b, c, d, e, f, g, h = _eight(lanes, there)
                out[place], out[place + ONE], out[place + TWO], out[place + THREE] = a, b, c, d
                place, there = place + FOUR, there + EIGHT
                out[place], out[place + ONE], out[place + TWO], out[place + THREE] = e, f, g, h
                place += FOUR
        else:
            for number in range(np.uint64(count * width)):
                out[place + number] = lanes[there + number]
    for i in range(places.sums):
        place, there = np.uint64(begin + places.shared + i), np.uint64(first_of(INNER_FORCE + i) + first)
        total = out[place] if ball > 0 else -0.0  # to which any number is added to the bit
        if np.uint64(count) == EIGHT:
            a, b, c, d, e, f, g, h = _eight(lanes, there)
            total = total + a + b + c + d + e + f + g + h
        else:
            for k in range(np.uint64(count)):
                total += lanes[there + k]
        out[place] = total


@inlined
def _put_ring(ring, borders, sample, lanes, k):
    """Gives a lane the place and motion of a ring that tilts or moves."""
    if len(ring) > 0:
        for i in range(2 * PLACES):
            put(lanes, BORDER_MOTION + i, k, borders[sample, i])


@inlined
def _write_ring(ring, border, row, first):
    """Writes offset, tilt, velocity and rate of the tilt of such a ring from column `first` on."""
    if len(ring) > 0:
        for i in range(5):
            row[first + i] = border[i]
            row[first + 5 + i] = border[PLACES + i]


@inlined
def _write_balls(bearing, drive, times, states, orientations, borders, turned, places, lanes, width, out, first):
    """`write_rows` of all that is a ball's own, and sums over the balls; states, orientations and `out` are flat."""
    balls, sample, ball = bearing.balls, ZERO, ZERO
    total = len(times) * balls
    for done in range(0, total, LANES):
        now, next_ball, count = sample, ball, min(LANES, total - done)
        for k in range(LANES):
            speed = borders[sample, SHAFT_SPEED] if turned else drive.speed + drive.acceleration * times[sample]
            put(lanes, RING_SPEED, k, speed)
            _put_ring(bearing.ring, borders, sample, lanes, k)
            if done + k + 1 < total:
                ball += 1
                if ball == balls:
                    sample, ball = sample + 1, ZERO
        _load(states, orientations, done, total - 1, lanes)
        fill_outputs(bearing, lanes)
        lane = ZERO
        while lane < count:
            together = min(count - lane, balls - next_ball)
            _spread(places, lanes, lane, together, next_ball, (first + now) * width, out)
            lane, now, next_ball = lane + together, now + 1, ZERO


@inlined
def _write_rest(bearing, drive, times, states, borders, turned, places, near, out, first):
    """`write_rows` of all else: the ring, the drive, what acts between balls."""
    for sample in range(len(times)):
        row, time = out[first + sample], times[sample]
        row[places.ring] = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time)
        row[places.ring + 1] = drive.speed + drive.acceleration * time
        if turned:
            row[places.ring], row[places.ring + 1] = borders[sample, SHAFT_ANGLE], borders[sample, SHAFT_SPEED]
        for axis in range(3):
            row[places.ring + 2 + axis] = bearing.offset[axis]
        for column in range(places.ring + 5, places.shared):
            row[column] = 0.0
        row[places.ring + DRIVE_TORQUE] = -row[places.shared + 5]
        _write_ring(bearing.ring, borders[sample], row, places.ring + 2)
        for column in range(places.neighbours + bearing.balls, len(row)):
            row[column] = 0.0
        if neighbour_gaps(bearing, states[sample], places.position, row, places.neighbours, near):
            elastic = places.shared + ELASTIC - INNER_FORCE
            write_pairs(bearing, states[sample], near, elastic, places.neighbours + bearing.balls, row)


@lean_kernel
def _write(given, moving, times, states, one_by_one, borders, turned, where, near, lanes, out, flat, first):
    """`write_rows` of what is handed over without names and with room; flat are states, orientations, and `out`."""
    bearing, drive, places, width = taken(given), RingDrive(*moving), RowPlaces(*where), out.shape[1]
    _write_balls(bearing, drive, times, *one_by_one, borders, turned, places, lanes, width, flat, first)
    _write_rest(bearing, drive, times, states, borders, turned, places, near, out, first)


def write_rows(bearing, drive, times, states, orientations, borders, turned, places, out, first) -> None:
    """Fills `out` from row `first` on with the states (count, N, columns), orientations (count, N, 4) at `times` [s].

    They are of N balls, however many the bearing has.

    `borders` (count, BORDER) are those of ring and cage, where the bearing's `ring` is not empty. `times`
    count from the instant the drive's angle and speed belong to; where a ring is `turned` by a torque, they are those
    of the border.
    """
    one_by_one = states.reshape(-1), orientations.reshape(-1)
    balls = states.shape[1]
    near, lanes = np.zeros(balls, np.bool_), new_lanes(OUTPUT_ROWS)
    at = times, states, one_by_one, borders, turned
    _write(handed(bearing, balls), tuple(drive), *at, tuple(places), near, lanes, out, out.reshape(-1), first)
