"""Ring and cage in a step: where their numbers stand in the one array they live in, by name.

One array, because Numba hands every array of a named tuple from kernel to kernel as seven numbers: with an array for
each of these, handing them over took half the time of a step. Stretches of WIDTH numbers hold a state or its like, the
last of them zero, so that loops over WIDTH become vector instructions.
"""

import numpy as np

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.layout import PLACES
from bearing_twin.numerics.steppers import MOST_STAGES

WIDTH = 24  # numbers kept for BORDER of them

# States: where the rates are taken, at a step's start, at its end. The rates' explicit change with time, the rates; a
# stage's right-hand side, and what it solves to; the terms of the interpolant; 1 / what a step may err by; the stages.
NOW, BEGIN, FINISH, SLOPE, RATES, RIGHT, SOLUTION, THIRD, FOURTH, INVERSE_SCALES, STAGES = WIDTH * np.arange(11)

# Of each place: whether it is free, its mass, its support, weight, load and growth of the load; of the ring, the rest.
FREE, MASS, STIFFNESS, DAMPING, REST, WEIGHT, LOAD, LOAD_RATE = STAGES + WIDTH * MOST_STAGES + PLACES * np.arange(8)
POLAR_INERTIA, UNBALANCE, PHASE, LIGHT, LAND_CLOSING, ERROR = LOAD_RATE + PLACES + np.arange(6)

# The inverse of each place's inertia; the Jacobian of the border's accelerations by its own places and velocities, row
# after row; what the elimination of the balls leaves of the linear system, column after column; and how what is lost at
# the land of a cage, and the drive's work there, answer to places and velocities.
INVERSE = ERROR + 1
OWN = INVERSE + PLACES
CORNER = OWN + PLACES * 2 * PLACES
LAND_LOSS = CORNER + PLACES * PLACES
LAND_POWER = LAND_LOSS + 2 * PLACES

# Of a shaft that a torque turns: 1 where there is one; how the torque of the inner ring's land answers to places and
# velocities; the rates of the border by the shaft's speed, and by its angle; its acceleration by places and velocities,
# and by its speed; what the border comes to for its speed in a stage; and the inverse of what elimination leaves.
TURNS = LAND_POWER + 2 * PLACES
LAND_TURN = TURNS + 1
BY_SHAFT = LAND_TURN + 2 * PLACES
BY_ANGLE = BY_SHAFT + WIDTH
SHAFT_ROW = BY_ANGLE + WIDTH
SHAFT_BY_SPEED = SHAFT_ROW + 2 * PLACES
SHAFT_SOLVED = SHAFT_BY_SPEED + 1
SHAFT_PIVOT = SHAFT_SOLVED + WIDTH

# The rates at a step's start, kept for one that is made again.
FIRST_RATES = SHAFT_PIVOT + 1
NUMBERS = FIRST_RATES + WIDTH


@inlined
def ring_places(ring):
    """How many places balls meet besides the cage's angle, the first of PLACES; `ring` is that of the `Partners`."""
    if len(ring) == 0:
        return 0
    if len(ring) == 1:
        return 3
    return 5
