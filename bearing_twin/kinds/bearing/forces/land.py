"""The land of a ring that guides a cage: contact of two round surfaces in the plane across the axis.

The cage's centre is off the ring's by e, no further than the radial clearance c but for the approach p = |e| - c. Along
n = e/|e| the land pushes the cage back with N = k (p + T a dp/dt) >= 0, a = p / (p + ONSET) as in the pockets. They
touch at R n from the ring's centre, R the land's radius, on the outer ring's land, at -R n on the inner's. Friction
acts there, smoothed as on the raceways, against the slip of the cage's surface on the land's. What the cage gains of
momentum and angular momentum the ring loses; what a ring that turns does by friction, its drive does.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.cage import ONSET, wall_load
from bearing_twin.kinds.bearing.forces.layout import CAGE, CAGE_X, CAGE_Y, LAND_WORK, LOST, PLACES
from bearing_twin.numerics.lean import lean_kernel

NO_LAND = math.inf  # the clearance of a cage that balls alone guide


class Land(NamedTuple):
    """The land of the outer ring (`side` 1) or the inner (-1): radius and radial clearance [m], stiffness [N/m], ...

    Relaxation time [s], friction, and the slip [m/s] below which friction is smoothed.
    """

    side: float
    radius: float
    clearance: float
    stiffness: float
    relaxation_time: float
    friction: float
    smoothing: float


class Touch(NamedTuple):
    """What a land does: force (2,) [N] on the cage, torque [N m] on the cage and on the ring about their own centres.

    Energy stored [J] and loss [W].
    """

    force: tuple[float, float]
    cage_torque: float
    ring_torque: float
    energy: float
    dissipation: float


@inlined
def _speed_along(land, off, apart, normal, moving, cage_speed, ring_speed):
    """Slip of the cage's surface on the land's where they touch, along z x n."""
    across = normal[0] * moving[1] - normal[1] * moving[0]
    return across + cage_speed * apart - land.side * land.radius * ring_speed


@inlined
def touch(land, off, moving, cage_speed, ring_speed):
    """The contact of a cage whose centre is `off` the land's by that much [m] (2,) and `moving` from it [m/s]."""
    distance = math.sqrt(off[0] * off[0] + off[1] * off[1])
    depth = distance - land.clearance
    if not depth > 0.0:
        return Touch((0.0, 0.0), 0.0, 0.0, 0.0, 0.0)
    normal = (off[0] / distance, off[1] / distance)
    rate = normal[0] * moving[0] + normal[1] * moving[1]
    elastic, load = wall_load(land, depth, rate)
    apart = land.side * land.radius - distance  # from the cage's centre to where they touch
    slip = _speed_along(land, off, apart, normal, moving, cage_speed, ring_speed)
    drag = -land.friction * load * slip / math.sqrt(slip * slip + land.smoothing * land.smoothing)
    return Touch(
        force=(-load * normal[0] - drag * normal[1], -load * normal[1] + drag * normal[0]),
        cage_torque=apart * drag,
        ring_torque=-land.side * land.radius * drag,
        energy=0.5 * elastic * depth,
        dissipation=(load - elastic) * rate - drag * slip,
    )


@inlined
def _change(land, off, moving, cage_speed, ring_speed, shift, push, faster):
    """How a touch changes with a `shift` of `off`, a `push` of `moving` and a cage that much `faster`.

    Force (2,), torques on cage and ring, loss.
    """
    distance = math.sqrt(off[0] * off[0] + off[1] * off[1])
    depth = distance - land.clearance
    if not depth > 0.0:
        return (0.0, 0.0), 0.0, 0.0, 0.0
    normal, relaxation = (off[0] / distance, off[1] / distance), land.relaxation_time
    rate, share = normal[0] * moving[0] + normal[1] * moving[1], 1.0 / (depth + ONSET)
    across = normal[0] * moving[1] - normal[1] * moving[0]
    out = normal[0] * shift[0] + normal[1] * shift[1]
    turn = (normal[0] * shift[1] - normal[1] * shift[0]) / distance  # of the normal
    rate_change = normal[0] * push[0] + normal[1] * push[1] + across * turn
    across_change = normal[0] * push[1] - normal[1] * push[0] - rate * turn
    elastic, stiff = land.stiffness * depth, land.stiffness * out
    load = elastic + land.stiffness * relaxation * rate * depth * share
    more = stiff + land.stiffness * relaxation * share * (rate_change * depth + rate * out * ONSET * share)
    if load <= 0.0:
        load = more = 0.0
    apart = land.side * land.radius - distance
    slip = _speed_along(land, off, apart, normal, moving, cage_speed, ring_speed)
    slip_change = across_change + faster * apart - cage_speed * out
    inverse = 1.0 / math.sqrt(slip * slip + land.smoothing * land.smoothing)
    direction = slip * inverse
    bend = land.smoothing * land.smoothing * inverse * inverse * inverse * slip_change
    drag, drag_change = -land.friction * load * direction, -land.friction * (more * direction + load * bend)
    force = (
        -more * normal[0] - drag_change * normal[1] + (load * normal[1] - drag * normal[0]) * turn,
        -more * normal[1] + drag_change * normal[0] - (load * normal[0] + drag * normal[1]) * turn,
    )
    loss = (more - stiff) * rate + (load - elastic) * rate_change - drag_change * slip - drag * slip_change
    return force, apart * drag_change - out * drag, -land.side * land.radius * drag_change, loss


@inlined
def carried_by_ring(land):
    """1 where the land is the inner ring's and moves with it, else 0."""
    return 1.0 if land.side < 0.0 else 0.0


@inlined
def _against(land, numbers, first):
    """Place of the cage's centre against the land's, or its velocity: those in `numbers` from `first` on."""
    ring = carried_by_ring(land)
    return (
        numbers[first + CAGE_X] - ring * numbers[first],
        numbers[first + CAGE_Y] - ring * numbers[first + 1],
    )


@inlined
def touch_at(land, numbers, first, speed):
    """The touch in a state that begins at `first`, with the inner ring at `speed` [rad/s]."""
    speed, moving = carried_by_ring(land) * speed, _against(land, numbers, first + PLACES)
    return touch(land, _against(land, numbers, first), moving, numbers[first + PLACES + CAGE], speed)


@lean_kernel
def add_land(land, speed, numbers):
    """Adds to the forces on cage and ring, before they are divided by inertia, and to what is lost and done."""
    if len(land) > 0:
        found, ring, forces = touch_at(land, numbers, at.NOW, speed), carried_by_ring(land), at.RATES + PLACES
        numbers[forces + CAGE_X] += found.force[0]
        numbers[forces + CAGE_Y] += found.force[1]
        numbers[forces + CAGE] += found.cage_torque
        numbers[forces] -= ring * found.force[0]
        numbers[forces + 1] -= ring * found.force[1]
        numbers[at.RATES + LOST] += found.dissipation
        numbers[at.RATES + LAND_WORK] = -ring * speed * found.ring_torque


@inlined
def land_moment(land, numbers, speed):
    """The land's torque on the inner ring [N m] in the state `NOW`; 0 without one, or where the outer ring has it."""
    if len(land) > 0:
        return carried_by_ring(land) * touch_at(land, numbers, at.NOW, speed).ring_torque
    return 0.0


@inlined
def _put_column(land, speed, numbers, column, change):
    """Adds one column of answers to the border's own Jacobian and to those of its integrals."""
    force, cage_torque, ring_torque, loss = change
    ring, stride, own = carried_by_ring(land), 2 * PLACES, at.OWN + column
    numbers[own] -= ring * numbers[at.INVERSE] * force[0]
    numbers[own + stride] -= ring * numbers[at.INVERSE + 1] * force[1]
    numbers[own + CAGE_X * stride] += numbers[at.INVERSE + CAGE_X] * force[0]
    numbers[own + CAGE_Y * stride] += numbers[at.INVERSE + CAGE_Y] * force[1]
    numbers[own + CAGE * stride] += numbers[at.INVERSE + CAGE] * cage_torque
    numbers[at.LAND_LOSS + column] = loss
    numbers[at.LAND_POWER + column] = -ring * speed * ring_torque
    numbers[at.LAND_TURN + column] = ring * ring_torque


@lean_kernel
def land_answers(land, speed, numbers):
    """Adds to the border's own Jacobian how the land answers, with the inner ring at `speed` [rad/s]."""
    if len(land) > 0:
        ring, turning = carried_by_ring(land), numbers[at.NOW + PLACES + CAGE]
        off, moving = _against(land, numbers, at.NOW), _against(land, numbers, at.NOW + PLACES)
        surface, nothing = ring * speed, (0.0, 0.0)
        for i in range(2):
            unit = (1.0, 0.0) if i == 0 else (0.0, 1.0)
            back = (-ring * unit[0], -ring * unit[1])
            change = _change(land, off, moving, turning, surface, unit, nothing, 0.0)
            _put_column(land, speed, numbers, CAGE_X + i, change)
            change = _change(land, off, moving, turning, surface, back, nothing, 0.0)
            _put_column(land, speed, numbers, i, change)
            change = _change(land, off, moving, turning, surface, nothing, unit, 0.0)
            _put_column(land, speed, numbers, PLACES + CAGE_X + i, change)
            change = _change(land, off, moving, turning, surface, nothing, back, 0.0)
            _put_column(land, speed, numbers, PLACES + i, change)
        change = _change(land, off, moving, turning, surface, nothing, nothing, 1.0)
        _put_column(land, speed, numbers, PLACES + CAGE, change)


@inlined
def _answer_to_spin(land, speed, numbers):
    ring, turning = carried_by_ring(land), numbers[at.NOW + PLACES + CAGE]
    off, moving = _against(land, numbers, at.NOW), _against(land, numbers, at.NOW + PLACES)
    distance = math.sqrt(off[0] * off[0] + off[1] * off[1])
    if ring == 0.0 or not distance > land.clearance:
        return 0.0
    surface = -land.side * land.radius / distance  # a cage that moves along the land by this slips as much
    push = (-surface * off[1], surface * off[0])
    force, cage_torque, ring_torque, loss = _change(land, off, moving, turning, speed, (0.0, 0.0), push, 0.0)
    first = at.BY_SHAFT + PLACES
    for i in range(2):
        numbers[first + i] -= numbers[at.INVERSE + i] * force[i]
        numbers[first + CAGE_X + i] += numbers[at.INVERSE + CAGE_X + i] * force[i]
    numbers[first + CAGE] += numbers[at.INVERSE + CAGE] * cage_torque
    numbers[at.BY_SHAFT + LOST] += loss
    numbers[at.BY_SHAFT + LAND_WORK] -= speed * ring_torque + touch_at(land, numbers, at.NOW, speed).ring_torque
    return ring_torque


@lean_kernel
def answer_to_spin(land, speed, numbers):
    """Adds how cage and ring answer through the land to the inner ring's `speed`, where a torque turns that.

    Returns how the torque on the ring answers [N m s].
    """
    if len(land) > 0:
        return _answer_to_spin(land, speed, numbers)
    return 0.0


@lean_kernel
def follow_land(land, g, numbers):
    """Adds to what is lost, and finds the drive's work through the land, once places and velocities are solved for."""
    if len(land) > 0:
        loss, work = 0.0, numbers[at.RIGHT + LAND_WORK]
        for i in range(2 * PLACES):
            loss += numbers[at.LAND_LOSS + i] * numbers[at.SOLUTION + i]
            work += numbers[at.LAND_POWER + i] * numbers[at.SOLUTION + i]
        numbers[at.SOLUTION + LOST] += g * loss
        numbers[at.SOLUTION + LAND_WORK] = g * work
