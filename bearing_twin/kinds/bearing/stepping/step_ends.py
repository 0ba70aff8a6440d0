"""The end of a Rosenbrock step of the balls in lanes: state, orientation, error, and the dense output inside it."""

import math

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.equations import outer_approach
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    HEIGHT,
    MOTION,
    ORBIT_ANGLE,
    ORIENTATION,
    POCKET,
    SPIN,
    TANGENTIAL_VELOCITY,
    TURNED,
    VELOCITY,
)
from bearing_twin.kinds.bearing.stepping.border_solve import of_cage
from bearing_twin.kinds.bearing.stepping.stage_places import border_state
from bearing_twin.kinds.bearing.stepping.steps import lane_spin, spin_in_frame
from bearing_twin.numerics.lanes import (
    END,
    ERROR,
    LANES,
    SOLUTION,
    START,
    STEP,
    from_lane,
    get,
    get_quaternion,
    get_vector,
    put,
    put_quaternion,
)
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rosenbrock_inside import mixed_stages
from bearing_twin.numerics.rotation import turned
from bearing_twin.numerics.steppers import five, rosenbrock_dense

LEAST_FELT = 0.1  # of errors along the groove: how much they count of a ball that bears next to nothing


@inlined
def _inverse(scales, first):
    return (1.0 / scales[first], 1.0 / scales[first + 1], 1.0 / scales[first + 2])


@inlined
def _squares(errors, inverse):
    """The sum of the squares of three errors in units of the scales."""
    one, two, three = errors[0] * inverse[0], errors[1] * inverse[1], errors[2] * inverse[2]
    return one * one + two * two + three * three


@inlined
def _middle(third, fourth, lanes, column, k):
    """A column of the state in the middle of a step."""
    start, end = get(lanes, START + column, k), get(lanes, END + column, k)
    terms = mixed_stages(third, lanes, column, k), mixed_stages(fourth, lanes, column, k)
    return rosenbrock_dense(0.5, start, end, terms[0], terms[1])


@inlined
def _middle_spin(third, fourth, lanes, k):
    """`lane_spin` in the middle of a step."""
    spin = (
        _middle(third, fourth, lanes, SPIN, k),
        _middle(third, fourth, lanes, SPIN + 1, k),
        _middle(third, fourth, lanes, SPIN + 2, k),
    )
    speed = _middle(third, fourth, lanes, TANGENTIAL_VELOCITY, k)
    return spin_in_frame(_middle(third, fourth, lanes, AXIS_DISTANCE, k), speed, spin)


@lean_kernel
def finish_lanes(border, scales, dense, lanes):
    """What an even cage makes of the end of steps, orientations there by the middle of interpolants, and errors.

    An error is the root mean square of the last stage, in units of the scales.
    """
    third, fourth, there = five(dense[0]), five(dense[1]), border_state(border, at.FINISH)
    first, second, last = _inverse(scales, 0), _inverse(scales, VELOCITY), _inverse(scales, SPIN)
    for k in range(LANES):
        if len(border) > 0:
            places, speeds, even, _, _ = there
            angle, speed = get(lanes, END + ORBIT_ANGLE, k), get(lanes, END + TANGENTIAL_VELOCITY, k)
            angle = of_cage(places) + get(lanes, POCKET, k) if even else angle
            put(lanes, END + ORBIT_ANGLE, k, angle)
            speed = of_cage(speeds) * get(lanes, END + AXIS_DISTANCE, k) if even else speed
            put(lanes, END + TANGENTIAL_VELOCITY, k, speed)
        errors = _squares(get_vector(lanes, SOLUTION, k), first)
        errors += _squares(get_vector(lanes, SOLUTION + VELOCITY, k), second)
        errors += _squares(get_vector(lanes, SOLUTION + SPIN, k), last)
        put(lanes, ERROR, k, math.sqrt(errors / MOTION))
        result = turned(
            get_quaternion(lanes, ORIENTATION, k),
            lane_spin(lanes, START, k),
            _middle_spin(third, fourth, lanes, k),
            lane_spin(lanes, END, k),
            get(lanes, STEP, k),
        )
        put_quaternion(lanes, TURNED, k, result)


@lean_kernel
def weigh_light(pockets, bearing, border, scales, lanes):
    """Puts the errors of steps where those along the groove count less, the less a ball bears; after `finish_lanes`.

    Where there are no `pockets`, it does nothing. See `error_scales.light_approach`.
    """
    if len(pockets) > 0:
        first, second, last = _inverse(scales, 0), _inverse(scales, VELOCITY), _inverse(scales, SPIN)
        light = border.numbers[at.LIGHT]
        for k in range(LANES):
            begin = outer_approach(bearing, get(lanes, START + AXIS_DISTANCE, k), get(lanes, START + HEIGHT, k))
            end = outer_approach(bearing, get(lanes, END + AXIS_DISTANCE, k), get(lanes, END + HEIGHT, k))
            share = min(max(max(begin, end) / light, 0.0), 1.0)
            felt = max(share * math.sqrt(share), LEAST_FELT)  # the load, nearly
            place, speed = get_vector(lanes, SOLUTION, k), get_vector(lanes, SOLUTION + VELOCITY, k)
            errors = _squares((place[0], felt * place[1], place[2]), first)
            errors += _squares((speed[0], felt * speed[1], felt * speed[2]), second)
            errors += felt * felt * _squares(get_vector(lanes, SOLUTION + SPIN, k), last)
            put(lanes, ERROR, k, math.sqrt(errors / MOTION))


@lean_kernel
def dense_ends(lanes, k, dense):
    """Fills the start and the end of one lane's dense step."""
    from_lane(lanes, START, k, dense.start)
    from_lane(lanes, END, k, dense.end)
