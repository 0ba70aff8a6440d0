"""The rows of balls side by side in lanes, by name: what `numerics.lanes` leaves to the scene.

A lane's state begins at AXIS_DISTANCE; other states begin elsewhere (START, END, LANE_RATES, ...), and their columns
are reached as START + VELOCITY.
"""

import numpy as np

from bearing_twin.compiled import inlined
from bearing_twin.numerics.lanes import (
    AFTER_METHOD,
    COLUMNS,
    LANE_RATES,
    LANES,
    METHOD_ROWS,
    get_vector,
    put_vector,
    rows,
)

# Columns of a ball's state, and rows of the state in lanes. Velocity and angular velocity: radial, tangential, axial.
AXIS_DISTANCE, ORBIT_ANGLE, HEIGHT, RADIAL_VELOCITY, TANGENTIAL_VELOCITY, AXIAL_VELOCITY = np.arange(6)
RADIAL_SPIN, TANGENTIAL_SPIN, AXIAL_SPIN, DRIVE_WORK, DISSIPATED, GROSS_WORK = np.arange(6, 12)
VELOCITY, SPIN = RADIAL_VELOCITY, RADIAL_SPIN
MOTION = 9  # the columns before this one are the motion; the rest only listen
LINEARISED = GROSS_WORK  # rates before it have rows in a Jacobian; it answers as DRIVE_WORK, by the power's sign
MOTION_SPAN = MOTION * LANES

# Bodies that meet all balls, the inner ring and the cage: places (the ring's centre, its tilt about x and y, the cage's
# angle), the velocities of these, and integrals that only listen: work of what acts on the ring, what is lost, and the
# work of the drive through the land that guides a cage.
PLACES = 6
RING_X, RING_Y, RING_Z, TILT_X, TILT_Y, CAGE = np.arange(PLACES)
CAGE_X, CAGE_Y = TILT_X, TILT_Y  # a cage whose centre moves has its places there, and the ring does not tilt
WORK_DONE, LOST, LAND_WORK = 12, 13, 14
SHAFT_ANGLE, SHAFT_SPEED, SHAFT_WORK = 15, 16, 17  # of a shaft that a torque turns: angle, speed, work of the torque
BORDER = 18

# What the rates need besides the motion: speed of the ring, load coefficients, what a law carries (see `carried`),
# motion of ring and cage, the cage's angle to the ball's pocket, place and velocity of its centre; what a ball does to
# ring and cage, and to the ring about its axis; and what friction over the spots works with.
RING_SPEED, GIVEN_INNER, GIVEN_OUTER, CARRIED_INNER, CARRIED_OUTER, BORDER_MOTION, POCKET = rows(
    COLUMNS, 1, 1, 1, 4, 4, 2 * PLACES
)
CENTRE, BORDER_PUSH, AXIAL_PUSH, _BEFORE = rows(POCKET + 1, 4, PLACES, 1)
_SPOT_ROWS, LANE_ROWS = rows(LANE_RATES + COLUMNS, 32)
CARRIED_COLUMNS = 8
# The motion in a spot's frame, its semi-axes, three means over it, and the part of many points in these (see
# `contact.spot_rules`), each in two rows, inner contacts and outer ones: 16 numbers side by side become vector
# instructions there, 8 do not. Then what is left of the contact: distance of the ball from the ring's axis, the minor
# axis, radial and axial part of the normal, from the ball's centre to the contact, and the greatest friction.
SPOTS = 2 * LANES
SLIP_MAJOR, SLIP_MINOR, SPIN_RATE, SEMI_MAJOR, SEMI_MINOR, ALONG, ACROSS, MOMENT, MANY = _SPOT_ROWS + 2 * np.arange(9)
AXIS_GAP, MINOR_X, MINOR_Y, NORMAL_RADIAL, NORMAL_AXIAL, LEVER, LIMIT = _SPOT_ROWS + 18 + 2 * np.arange(7)

# The slopes of the given coefficients; the Jacobian, see `entry`; the sign of the drive's power there; the orientation
# at a step's start and at its end.
GIVEN_SLOPE_INNER, GIVEN_SLOPE_OUTER, JACOBIAN, POWER_SIGN, ORIENTATION, TURNED, _SHARED = rows(
    LANE_ROWS, 1, 1, LINEARISED * MOTION, 1, 4, 4
)
JACOBIAN_END = ORIENTATION

# The implicit-explicit method: angular velocity in the ball's frame where the balls were turned last, and the sum of it
# after each step since.
FIRST_SPIN, SPIN_SUM, IMEX_ROWS = rows(_SHARED, 3, 3)

# Rosenbrock methods: what `factorise_body` leaves.
FACTOR_RADIUS, FACTOR_VELOCITY, FACTOR_INVERSE, FACTOR_COUPLING, FACTOR_BELOW, FACTOR_SCHUR, _END = rows(
    _SHARED, 1, 1, 9, 9, 9, 9
)
assert max(_BEFORE - LANE_RATES, _END - METHOD_ROWS) <= 0, "numerics.lanes leaves the scene too few rows"
ROSENBROCK_ROWS = AFTER_METHOD
SYSTEM = FACTOR_INVERSE  # coupled balls: what is left of 1/g - J without positions, column after column

# Balls that may touch, in an array of their own: nine numbers of a ball and of the next ahead, whether they may touch,
# what to add to the angle between them, whether they do touch; what they do to the rates of either (velocity, spin, the
# integrals) and how that answers to either's motion; and two tiles of the linear system without positions, column after
# column.
OWN, AHEAD, MAY_TOUCH, ROUND, MEETS, OWN_PUSH, AHEAD_PUSH, _ANSWERS = rows(0, MOTION, MOTION, 1, 1, 1, 8, 6)
OWN_BY_OWN, OWN_BY_AHEAD, AHEAD_BY_OWN, AHEAD_BY_AHEAD, UPPER, LOWER, PAIR_ROWS = rows(
    _ANSWERS, *(8 * MOTION,) * 2, *(6 * MOTION,) * 2, 36, 36
)

# How ball and border (ring and cage) answer to each other, after the rows of Rosenbrock methods: rates of a ball from
# VELOCITY on by the border's places and velocities, the border's accelerations by a ball's motion and by its own, all
# row after row; two tiles of the linear system without positions, column after column; what goes into sums; and how
# fast a ball comes to go forward in its pocket.
ANSWERING = LINEARISED - VELOCITY
BALL_BY_BORDER, BORDER_BY_BALL, BORDER_BY_BORDER, BALL_TILE, BORDER_TILE, SHARES, CLOSING, BORDERED_ROWS = rows(
    ROSENBROCK_ROWS, ANSWERING * 2 * PLACES, PLACES * MOTION, 2 * PLACES * PLACES, 36, 36, PLACES, 1
)
# A shaft that a torque turns: rates of a ball from VELOCITY on by its speed; its acceleration by a ball's motion, by
# places and velocities of the border and by its speed; and what a ball's state comes to for its speed in a stage. Then
# the rates at a step's start, kept for one that is made again.
BALL_BY_SHAFT, SHAFT_BY_BALL, SHAFT_BY_BORDER, SHAFT_OWN, SHAFT_ANSWER, FIRST_RATES, COUPLED_ROWS = rows(
    BORDERED_ROWS, COLUMNS - VELOCITY, MOTION, 2 * PLACES, 1, COLUMNS, COLUMNS
)


@inlined
def entry(rate, column):
    """The row that holds the Jacobian's entry d(rate)/d(column), both columns of the state."""
    return JACOBIAN + rate * MOTION + column


@inlined
def get_part(lanes, first, k):
    """The 3 x 3 part of a matrix of MOTION columns of lane k whose first entry stands in row `first`."""
    return (
        get_vector(lanes, first, k),
        get_vector(lanes, first + MOTION, k),
        get_vector(lanes, first + 2 * MOTION, k),
    )


@inlined
def put_part(lanes, first, k, block):
    """Writes the 3 x 3 part of a matrix of MOTION columns of lane k whose first entry stands in row `first`."""
    put_vector(lanes, first, k, block[0])
    put_vector(lanes, first + MOTION, k, block[1])
    put_vector(lanes, first + 2 * MOTION, k, block[2])


@inlined
def get_jacobian_block(lanes, rate, column, k):
    """The 3 x 3 block of lane k's Jacobian whose first entry is (rate, column)."""
    return get_part(lanes, entry(rate, column), k)


@inlined
def put_jacobian_block(lanes, rate, column, k, block):
    """Writes the 3 x 3 block of lane k's Jacobian whose first entry is (rate, column)."""
    put_part(lanes, entry(rate, column), k, block)
