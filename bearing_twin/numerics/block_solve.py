"""The linear system of a linearly implicit step for one body with three positions, three velocities and three spins.

W = I/g - J with g = h gamma. Positions follow from velocities alone, so they are eliminated by hand; what is left is
solved in blocks of 3 x 3. Everything is straight-line arithmetic on tuples: inside a loop over bodies it becomes vector
instructions. No pivoting between blocks: I/g and what resists motion make the diagonal blocks regular.
"""

from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.numerics.rotation import add, cross, dot, minus, scaled


class Linear(NamedTuple):
    """The Jacobian of one body, blocks of 3 x 3 as rows: how velocity (v) and spin (s) rates answer to position (p).

    `angle_by_radius` and `angle_by_velocity` are the two entries of d(orbit rate) that are not zero.
    """

    angle_by_radius: float
    angle_by_velocity: float
    vp: tuple
    vv: tuple
    vs: tuple
    sp: tuple
    sv: tuple
    ss: tuple


class Factors(NamedTuple):
    """What `factorise_body` leaves for `solve_body`: how the orbit angle follows the velocities, and four blocks."""

    turning: tuple
    inverse: tuple
    coupling: tuple
    below: tuple
    schur: tuple


@inlined
def times(matrix, vector):
    """Matrix (three rows) times vector."""
    return (dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector))


@inlined
def combined(vector, rows):
    """Row vector times matrix."""
    return add(add(scaled(vector[0], rows[0]), scaled(vector[1], rows[1])), scaled(vector[2], rows[2]))


@inlined
def product(a, b):
    """Matrix times matrix."""
    return (combined(a[0], b), combined(a[1], b), combined(a[2], b))


@inlined
def scaled_block(factor, block):
    """factor * block, 3 x 3."""
    return (scaled(factor, block[0]), scaled(factor, block[1]), scaled(factor, block[2]))


@inlined
def plus(a, b):
    """Sum of two 3 x 3 matrices."""
    return (add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2]))


@inlined
def minus_block(a, b):
    """Difference of two 3 x 3 matrices."""
    return (minus(a[0], b[0]), minus(a[1], b[1]), minus(a[2], b[2]))


@inlined
def negative(matrix):
    """-matrix, 3 x 3."""
    return scaled_block(-1.0, matrix)


@inlined
def inverse(rows):
    """Inverse of a 3 x 3 matrix by its adjugate; not finite when it is singular."""
    first, second, third = cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])
    one = 1.0 / dot(rows[0], first)
    return (
        (one * first[0], one * second[0], one * third[0]),
        (one * first[1], one * second[1], one * third[1]),
        (one * first[2], one * second[2], one * third[2]),
    )


@inlined
def behind(block, g, turning):
    """A block of position columns as columns of velocity: g of the velocity's own, and the orbit angle's detour."""
    return (
        (block[0][0] * g + block[0][1] * turning[0], block[0][1] * turning[1], block[0][2] * g),
        (block[1][0] * g + block[1][1] * turning[0], block[1][1] * turning[1], block[1][2] * g),
        (block[2][0] * g + block[2][1] * turning[0], block[2][1] * turning[1], block[2][2] * g),
    )


@inlined
def _less(diagonal, block):
    """diagonal I - block."""
    return (
        (diagonal - block[0][0], -block[0][1], -block[0][2]),
        (-block[1][0], diagonal - block[1][1], -block[1][2]),
        (-block[2][0], -block[2][1], diagonal - block[2][2]),
    )


@inlined
def factorise_motion(g, vv, vs, sv, ss):
    """Factors of I/g - J where nothing answers to positions: three blocks for `solve_motion`."""
    velocities = inverse(_less(1.0 / g, vv))
    coupling = product(velocities, vs)  # of the sign that adds
    return velocities, coupling, inverse(_less(1.0 / g, plus(ss, product(sv, coupling))))


@inlined
def solve_motion(velocities, coupling, below, schur, velocity, spin):
    """Velocities and spins from their right-hand sides; `below` is how spins answer to velocities, the rest factors."""
    push = times(velocities, velocity)
    spins = times(schur, add(spin, times(below, push)))
    return add(push, times(coupling, spins)), spins


@inlined
def factorise_body(linear, g):
    """Factors of W for one body; `g` = h gamma [s]."""
    turning = (g * g * linear.angle_by_radius, g * linear.angle_by_velocity)
    below = plus(linear.sv, behind(linear.sp, g, turning))
    velocity = plus(linear.vv, behind(linear.vp, g, turning))
    velocities, coupling, schur = factorise_motion(g, velocity, linear.vs, below, linear.ss)
    return Factors(turning=turning, inverse=velocities, coupling=coupling, below=below, schur=schur)


@inlined
def solve_body(linear, factors, g, position, velocity, spin):
    """Solves W x = right for the right-hand sides of position, velocity and spin; returns x in the same three parts."""
    radius = g * position[0]
    known = (radius, g * (position[1] + linear.angle_by_radius * radius), g * position[2])
    push, turning = add(velocity, times(linear.vp, known)), add(spin, times(linear.sp, known))
    blocks = factors.inverse, factors.coupling, factors.below, factors.schur
    velocities, spins = solve_motion(*blocks, push, turning)
    turn = factors.turning
    positions = (
        known[0] + g * velocities[0],
        known[1] + turn[0] * velocities[0] + turn[1] * velocities[1],
        known[2] + g * velocities[2],
    )
    return positions, velocities, spins
