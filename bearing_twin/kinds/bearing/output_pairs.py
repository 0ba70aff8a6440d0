"""What a bearing gives out of contacts between neighbouring balls; most often there are none."""

import math

from bearing_twin.kinds.bearing.forces.equations import neighbour_angle, pair_contact, touchable
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, ORBIT_ANGLE
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rotation import about_z, add, scaled


@lean_kernel
def neighbour_gaps(bearing, state, position, row, approach, near):
    """Writes the approach of each ball and the next ahead; marks the pairs that touch, returns whether any does."""
    balls, touching = bearing.balls, False
    for k in range(balls):
        j, near[k] = k + 1 if k + 1 < balls else 0, False
        row[approach + k] = 0.0
        if balls > 2 or (balls == 2 and neighbour_angle(state, k, 1) <= math.pi):
            x = row[position + 3 * j] - row[position + 3 * k]
            y = row[position + 3 * j + 1] - row[position + 3 * k + 1]
            z = row[position + 3 * j + 2] - row[position + 3 * k + 2]
            depth = 2.0 * bearing.ball_radius - math.sqrt(x * x + y * y + z * z)
            row[approach + k], near[k] = depth, depth > 0.0
            touching = touching or near[k]
    return touching


@lean_kernel
def write_pairs(bearing, state, near, elastic, load, row):
    """Writes the contacts of balls that touch: loads, then points, normals and friction of all balls; their energy."""
    balls = bearing.balls
    for k in range(balls):
        for side in (1, -1):
            if touchable(bearing, near, k, side):
                pair = pair_contact(bearing, state, k, side)
                row[elastic] += pair.energy
                if side > 0:
                    angle = state[k, ORBIT_ANGLE]
                    cosine, sine = math.cos(angle), math.sin(angle)
                    local = (state[k, AXIS_DISTANCE], 0.0, state[k, AXIS_DISTANCE + 2])
                    point = about_z(cosine, sine, add(local, pair.arm))
                    normal = about_z(cosine, sine, scaled(-1.0, pair.normal))
                    friction = about_z(cosine, sine, pair.friction)
                    row[load + k] = pair.normal_load
                    for axis in range(3):
                        place = load + balls + 3 * k + axis
                        row[place] = point[axis]
                        row[place + 3 * balls] = normal[axis]
                        row[place + 6 * balls] = friction[axis]
