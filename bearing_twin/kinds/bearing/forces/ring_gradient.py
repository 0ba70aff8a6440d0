"""How the contact with a ring that is tilted or moves answers to the ball's motion and to the ring's.

The contact depends on what `ring_seat.seen_from` gives, with A the inverse of 1 + theta x: d' = A (p - c),
A (v - v_c - w x d') and A (s - w). `contact_gradient` differentiates it there; here the ring's displacement, tilt and
velocities are put in by the chain rule, in the axes of the ball's frame.
"""

from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces.equations import RacewayContact, brought_back
from bearing_twin.kinds.bearing.forces.gradient import Gradient, contact_gradient
from bearing_twin.kinds.bearing.forces.layout import (
    BALL_BY_BORDER,
    BORDER_BY_BALL,
    BORDER_BY_BORDER,
    DISSIPATED,
    DRIVE_WORK,
    MOTION,
    PLACES,
    SPIN,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.ring_seat import RingSeat, seat_of, seen_from
from bearing_twin.numerics.block_solve import combined, minus_block, negative, plus, product, times
from bearing_twin.numerics.lanes import put, put_vector
from bearing_twin.numerics.rotation import about_z, add, cross, dot, minus, scaled

UP = (0.0, 0.0, 1.0)


class Answer(NamedTuple):
    """How something answers, axes of the ball's frame: matrices for a vector, rows for a number.

    By the ball's place, velocity and spin, by a turn of the ring about its centre and by the rate of it; by the ring's
    place and velocity it is the opposite of `place` and `velocity`. `angle` is the answer to the orbit angle. Where the
    ring's axis stays z, `turn` and `rate` are empty.
    """

    place: tuple
    velocity: tuple
    spin: tuple
    turn: tuple
    rate: tuple
    angle: tuple


class Seated(NamedTuple):
    """A contact with a seated ring and the answers of force, torque, power and loss; `offset` is d'."""

    contact: RacewayContact
    seat: RingSeat
    offset: tuple
    force: Answer
    torque: Answer
    power: Answer
    loss: Answer


@inlined
def skew(a):
    """The matrix of a x (.)."""
    return ((0.0, -a[2], a[1]), (a[2], 0.0, -a[0]), (-a[1], a[0], 0.0))


@inlined
def _transposed(a):
    return ((a[0][0], a[1][0], a[2][0]), (a[0][1], a[1][1], a[2][1]), (a[0][2], a[1][2], a[2][2]))


@inlined
def _vector_answer(seat, d, u, w, value, by_place, by_velocity, by_spin):
    """The answer of a vector `value` whose derivatives by what is seen from the ring, d, u and w, are given."""
    if len(seat) == 2:  # of a ring whose axis stays z
        angle = add(times(by_place, cross(UP, seat.centre)), times(by_velocity, cross(UP, seat.velocity)))
        return Answer(by_place, by_velocity, by_spin, (), (), angle)
    axes, back = seat.axes, _transposed(seat.axes)
    velocity, spin = product(product(back, by_velocity), axes), product(product(back, by_spin), axes)
    alone = product(product(back, by_place), axes)
    place = minus_block(alone, product(velocity, product(skew(seat.turning), axes)))
    levers = plus(product(place, skew(d)), plus(product(velocity, skew(u)), product(spin, skew(w))))
    turn = minus_block(levers, product(back, skew(value)))
    rate = minus_block(product(velocity, skew(d)), spin)
    # A turn of the ball's frame moves the ring in it, the other way round.
    angle = add(times(place, cross(UP, seat.centre)), times(velocity, cross(UP, seat.velocity)))
    angle = minus(angle, add(times(turn, cross(UP, seat.tilt)), times(rate, cross(UP, seat.turning))))
    return Answer(place, velocity, spin, turn, rate, angle)


@inlined
def number_answer(seat, d, u, w, by_place, by_velocity, by_spin):
    """The answer of a number."""
    if len(seat) == 2:
        ahead = dot(by_place, cross(UP, seat.centre)) + dot(by_velocity, cross(UP, seat.velocity))
        return Answer(by_place, by_velocity, by_spin, (), (), ahead)
    velocity, spin = combined(by_velocity, seat.axes), combined(by_spin, seat.axes)
    place = combined(minus(by_place, cross(velocity, seat.turning)), seat.axes)
    turn = scaled(-1.0, add(cross(d, place), add(cross(u, velocity), cross(w, spin))))
    rate = minus(cross(velocity, d), spin)
    ahead = dot(place, cross(UP, seat.centre)) + dot(velocity, cross(UP, seat.velocity))
    angle = ahead - dot(turn, cross(UP, seat.tilt)) - dot(rate, cross(UP, seat.turning))
    return Answer(place, velocity, spin, turn, rate, angle)


@inlined
def seated_gradient(ring, bearing, given, slope, place, cosine, sine, speed, position, velocity, spin):
    """The contact with the inner ring at `place` in motion `ring`, and how it answers."""
    seat = seat_of(ring, place, cosine, sine)
    offset, relative, against = seen_from(seat, position, velocity, spin)
    middle, across = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    found, by = contact_gradient(bearing, bearing.inner, given, slope, middle, across, speed, offset, relative, against)
    contact = brought_back(seat, found)
    return Seated(
        contact=contact,
        seat=seat,
        offset=offset,
        force=_vector_answer(seat, offset, relative, against, contact.force, by.force_p, by.force_v, by.force_s),
        torque=_vector_answer(seat, offset, relative, against, contact.torque, by.torque_p, by.torque_v, by.torque_s),
        power=number_answer(seat, offset, relative, against, by.power_p, by.power_v, by.power_s),
        loss=number_answer(seat, offset, relative, against, by.loss_p, by.loss_v, by.loss_s),
    )


@inlined
def _by_ball(answer):
    """The matrix by axis distance, orbit angle and height."""
    place, angle = answer.place, answer.angle
    return (
        (place[0][0], angle[0], place[0][2]),
        (place[1][0], angle[1], place[1][2]),
        (place[2][0], angle[2], place[2][2]),
    )


@inlined
def of_ball(found):
    """The part of a seated contact's answers that a ball's own motion makes."""
    power, loss = found.power, found.loss
    return Gradient(
        force_p=_by_ball(found.force),
        force_v=found.force.velocity,
        force_s=found.force.spin,
        torque_p=_by_ball(found.torque),
        torque_v=found.torque.velocity,
        torque_s=found.torque.spin,
        power_p=(power.place[0], power.angle, power.place[2]),
        power_v=power.velocity,
        power_s=power.spin,
        loss_p=(loss.place[0], loss.angle, loss.place[2]),
        loss_v=loss.velocity,
        loss_s=loss.spin,
    )


@inlined
def inner_gradient(ring, bearing, given, slope, place, cosine, sine, speed, position, velocity, spin):
    """`contact_gradient` of a ball with the inner ring at `place`; `ring` is the bearing's."""
    if len(ring) == 0:
        centre = about_z(cosine, -sine, place)
        by_angle = (-centre[1], centre[0], 0.0)
        return contact_gradient(bearing, bearing.inner, given, slope, centre, by_angle, speed, position, velocity, spin)
    found = seated_gradient(ring, bearing, given, slope, place, cosine, sine, speed, position, velocity, spin)
    return found.contact, of_ball(found)


@inlined
def _rows(block):
    """Three rows of a matrix that may be empty."""
    if len(block) == 0:
        return ((), (), ())
    return block


@inlined
def _put_columns(lanes, row, stride, k, cosine, sine, size, answer):
    """Writes how a vector, three rows from `row` on, answers to the ring's places and velocities in fixed axes."""
    place, turn, velocity, rate = answer.place, _rows(answer.turn), answer.velocity, _rows(answer.rate)
    _put_turned_row(lanes, row, k, cosine, sine, size, place[0], turn[0], velocity[0], rate[0])
    _put_turned_row(lanes, row + stride, k, cosine, sine, size, place[1], turn[1], velocity[1], rate[1])
    _put_turned_row(lanes, row + 2 * stride, k, cosine, sine, size, place[2], turn[2], velocity[2], rate[2])


@inlined
def _put_turned_row(lanes, at, k, cosine, sine, size, place, turn, velocity, rate):
    """Writes one row of answers to a ball's place and velocity as answers to the ring's."""
    shift, push = about_z(cosine, sine, place), about_z(cosine, sine, velocity)
    put_vector(lanes, at, k, scaled(-size, shift))
    put_vector(lanes, at + PLACES, k, scaled(-size, push))
    if len(turn) > 0:
        tilt, faster = about_z(cosine, sine, turn), about_z(cosine, sine, rate)
        put(lanes, at + 3, k, size * tilt[0])
        put(lanes, at + 4, k, size * tilt[1])
        put(lanes, at + PLACES + 3, k, size * faster[0])
        put(lanes, at + PLACES + 4, k, size * faster[1])


@inlined
def put_number(lanes, at, k, cosine, sine, sign, answer):
    """Writes how a number answers to the ring's places and velocities, times `sign`, from row `at` on."""
    _put_turned_row(lanes, at, k, cosine, sine, sign, answer.place, answer.turn, answer.velocity, answer.rate)


@inlined
def _reaction(cosine, sine, answer):
    """The opposite of a matrix whose answer is turned from the ball's frame into fixed axes, which may be empty."""
    if len(answer) == 0:
        return ((), (), ())
    block = negative(answer)
    return (
        minus(scaled(cosine, block[0]), scaled(sine, block[1])),
        add(scaled(sine, block[0]), scaled(cosine, block[1])),
        block[2],
    )


@inlined
def _put_reaction_row(lanes, i, k, cosine, sine, place, turn, velocity, spin, rate, angle):
    """Writes how component i of what acts on the ring, in fixed axes, answers to a ball's motion and to the ring's."""
    row = BORDER_BY_BALL + i * MOTION
    put_vector(lanes, row, k, (place[0], angle, place[2]))
    put_vector(lanes, row + VELOCITY, k, velocity)
    put_vector(lanes, row + SPIN, k, spin)
    at = BORDER_BY_BORDER + i * 2 * PLACES
    _put_turned_row(lanes, at, k, cosine, sine, 1.0, place, turn, velocity, rate)


@inlined
def _put_reaction(lanes, first, all_three, k, cosine, sine, value, answer):
    """Writes how a force or moment on the ring, the opposite of `value`, answers: all three components, or x and y.

    From coordinate `first` of the border on; `value` and `answer` are in the ball's frame and on the ball.
    """
    place, velocity = _reaction(cosine, sine, answer.place), _reaction(cosine, sine, answer.velocity)
    spin = _reaction(cosine, sine, answer.spin)
    turn, rate = _reaction(cosine, sine, answer.turn), _reaction(cosine, sine, answer.rate)
    angle = about_z(cosine, sine, scaled(-1.0, add(answer.angle, cross(UP, value))))
    _put_reaction_row(lanes, first, k, cosine, sine, place[0], turn[0], velocity[0], spin[0], rate[0], angle[0])
    _put_reaction_row(lanes, first + 1, k, cosine, sine, place[1], turn[1], velocity[1], spin[1], rate[1], angle[1])
    if all_three:
        _put_reaction_row(lanes, first + 2, k, cosine, sine, place[2], turn[2], velocity[2], spin[2], rate[2], angle[2])


@inlined
def _moment(found):
    """The moment on the ball about the ring's centre, and how it answers: N = d' x F + T."""
    d, force, torque, seat = found.offset, found.force, found.torque, found.seat
    lever, pull = skew(d), found.contact.force
    moved = negative(product(skew(pull), seat.axes))  # by a displacement of the ball, what d' x F takes of d'
    ahead = add(cross(UP, seat.centre), cross(cross(UP, seat.tilt), d))
    answer = Answer(
        place=plus(plus(product(lever, force.place), torque.place), moved),
        velocity=plus(product(lever, force.velocity), torque.velocity),
        spin=plus(product(lever, force.spin), torque.spin),
        turn=plus(plus(product(lever, force.turn), torque.turn), product(moved, lever)),
        rate=plus(product(lever, force.rate), torque.rate),
        angle=add(add(cross(d, force.angle), torque.angle), times(moved, ahead)),
    )
    return add(cross(d, pull), found.contact.torque), answer


@inlined
def put_answers(bearing, found, lanes, k, cosine, sine):
    """Writes how a ball and a ring that moves answer to each other's motion, by the contact `found`; none of a cage.

    Forces and moments on the ring are not yet divided by its inertia. Friction acts at a point.
    """
    stride = 2 * PLACES
    _put_columns(lanes, BALL_BY_BORDER, stride, k, cosine, sine, 1.0 / bearing.ball_mass, found.force)
    _put_columns(lanes, BALL_BY_BORDER + 3 * stride, stride, k, cosine, sine, 1.0 / bearing.ball_inertia, found.torque)
    put_number(lanes, BALL_BY_BORDER + (DRIVE_WORK - VELOCITY) * stride, k, cosine, sine, 1.0, found.power)
    put_number(lanes, BALL_BY_BORDER + (DISSIPATED - VELOCITY) * stride, k, cosine, sine, 1.0, found.loss)
    _put_reaction(lanes, 0, True, k, cosine, sine, found.contact.force, found.force)
    _put_moment(found.seat, found, lanes, k, cosine, sine)


@inlined
def _put_moment(seat, found, lanes, k, cosine, sine):
    """Writes how the moment on a ring that may tilt answers; `seat` is that of what was `found`."""
    if len(seat) > 2:
        value, answer = _moment(found)
        _put_reaction(lanes, 3, False, k, cosine, sine, value, answer)
