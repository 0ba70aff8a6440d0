"""The bodies that meet all balls, inner ring and cage: their state, what moves them, and their part of a step.

They are the border of the linear system. A state holds six places (the ring's centre x, y, z [m] and tilt about x and
y [rad], the cage's angle [rad]), their velocities, and integrals that only listen [J]: the work of the loads on
the ring, and what its support loses. All is in `bearing_link`. A cage whose centre moves has it in the places of the
tilt, which such a ring does not have, and a third integral, the drive's work through its land (`land`, `moving_cage`).
Where a torque turns the ring (`shaft`), its angle, its speed and the torque's work follow.

Ring: M dv/dt = load + weight - sum of what the balls do - D v - K (q - rest), and about its axes, with the speed W of
the drive, I_t d2(theta_x) + I_p W d(theta_y) = M_x, I_t d2(theta_y) - I_p W d(theta_x) = M_y (small tilts).

Even cage: ball j stands at psi_c + 2 pi j / Z and goes round at the cage's speed w, so its tangential velocity is r w.
What holds it there is eliminated by the balance of angular momentum about the axis,
(J_c + sum m r^2) dw/dt = sum r (F_t - 2 m v_r w): the orbit speed follows from what acts on the balls.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.equations import Bearing
from bearing_twin.kinds.bearing.forces.land import add_land, land_moment
from bearing_twin.kinds.bearing.forces.layout import (
    AXIAL_PUSH,
    AXIS_DISTANCE,
    BORDER,
    BORDER_PUSH,
    CAGE,
    LOST,
    ORBIT_ANGLE,
    PLACES,
    POCKET,
    RADIAL_VELOCITY,
    SHAFT_ANGLE,
    SHAFT_SPEED,
    SHAFT_WORK,
    SHARES,
    TANGENTIAL_VELOCITY,
    WORK_DONE,
)
from bearing_twin.kinds.bearing.forces.ring_seat import LevelMotion, RingMotion
from bearing_twin.numerics.lanes import LANE_RATES, LANES, add_sum, get, put, with_sum
from bearing_twin.numerics.lean import lean_kernel

CAGE_SPEED = PLACES + CAGE


class Partners(NamedTuple):
    """What meets all balls in a part of a chunk: numbers (PLACES,) of ring and cage, in SI.

    `ring` is empty where the ring is held: kernels then know the cage alone. It has one number where the ring does not
    tilt and the cage's centre stays, whose places kernels then leave out, else two. `land` is empty where the cage
    stays centred, else what guides it (`land.Land`). `shaft` is empty where the ring's speed is prescribed, else what
    a torque turns (`shaft.Shaft`). `free` is 1 where a place follows its loads, else 0. `load` grows by `load_rate` a
    second, in the cage's place the torque on the shaft; `unbalance` [kg m] turns with the ring, `phase` [rad] ahead.
    `scales` (2 PLACES + 1,) are the errors a step may make, the last of the shaft's speed; `light` [m] is as
    `error_scales.light_approach` says.
    """

    ring: tuple
    active: bool
    even: bool
    varying: bool
    land: tuple
    shaft: tuple
    free: np.ndarray
    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    rest: np.ndarray
    weight: np.ndarray
    load: np.ndarray
    load_rate: np.ndarray
    polar_inertia: float
    unbalance: float
    phase: float
    scales: np.ndarray
    light: float


class Border(NamedTuple):
    """Ring and cage in a step of so many balls: `numbers` (NUMBERS,) as `border_rows` names them.

    `ring`, `active`, `even`, `varying`, `land` and `shaft` are those of the `Partners`.
    """

    ring: tuple
    active: bool
    even: bool
    varying: bool
    land: tuple
    shaft: tuple
    count: int
    numbers: np.ndarray


@kernel
def new_border(partners, count, state):
    """Room for so many balls, holding `state` (BORDER,)."""
    numbers = np.zeros(at.NUMBERS)
    for i in range(BORDER):
        numbers[at.NOW + i] = numbers[at.BEGIN + i] = state[i]
    for i in range(PLACES):
        numbers[at.FREE + i], numbers[at.MASS + i] = partners.free[i], partners.mass[i]
        numbers[at.STIFFNESS + i], numbers[at.DAMPING + i] = partners.stiffness[i], partners.damping[i]
        numbers[at.REST + i], numbers[at.WEIGHT + i] = partners.rest[i], partners.weight[i]
        numbers[at.LOAD + i], numbers[at.LOAD_RATE + i] = partners.load[i], partners.load_rate[i]
        if partners.free[i] > 0.0:
            numbers[at.INVERSE + i] = 1.0 / partners.mass[i]
    for i in range(2 * PLACES):
        if partners.free[i % PLACES] > 0.0:
            numbers[at.INVERSE_SCALES + i] = 1.0 / partners.scales[i]
    numbers[at.POLAR_INERTIA], numbers[at.UNBALANCE] = partners.polar_inertia, partners.unbalance
    numbers[at.PHASE], numbers[at.LIGHT] = partners.phase, partners.light
    if len(partners.shaft) > 0:
        numbers[at.TURNS], numbers[at.INVERSE_SCALES + SHAFT_SPEED] = 1.0, 1.0 / partners.scales[2 * PLACES]
    given = partners.ring, partners.active, partners.even, partners.varying, partners.land, partners.shaft
    return Border(*given, count, numbers)


@inlined
def _ring_at(ring, numbers, first):
    """The motion of a ring whose places and velocities begin at `first`."""
    speeds = first + PLACES
    velocity = (numbers[speeds], numbers[speeds + 1], numbers[speeds + 2])
    if len(ring) == 1:
        return LevelMotion(velocity)
    rates = (numbers[speeds + 3], numbers[speeds + 4])
    return RingMotion((numbers[first + 3], numbers[first + 4]), velocity, rates)


@inlined
def bearing_at(ring, bearing, border, first):
    """The bearing with its ring where the border's state from `first` on has it; `ring` is the bearing's."""
    if len(ring) == 0:
        return bearing
    numbers = border.numbers
    return Bearing(
        bearing.balls,
        bearing.ball_radius,
        bearing.ball_mass,
        bearing.ball_inertia,
        bearing.inner,
        bearing.outer,
        (numbers[first], numbers[first + 1], numbers[first + 2]),
        bearing.gravity,
        bearing.damping,
        bearing.relaxation_time,
        bearing.friction_coefficient,
        bearing.friction_regularisation,
        bearing.pair_coefficient,
        bearing.raceway_friction,
        bearing.spot,
        _ring_at(ring, numbers, first),
        bearing.pockets,
    )


@lean_kernel
def put_pockets(bearing, balls, blocks):
    """Gives every lane the angle from the cage to the pocket of its ball."""
    for block in range(len(blocks)):
        for k in range(LANES):
            number = balls[min(LANES * block + k, len(balls) - 1)]
            put(blocks[block], POCKET, k, 2.0 * math.pi * number / bearing.balls)


@lean_kernel
def follow_cage(border, first, blocks, row):
    """Puts balls of an even cage, whose state begins at `row`, as the border's state at `first` has the cage."""
    if border.even:
        angle, speed = border.numbers[first + CAGE], border.numbers[first + CAGE_SPEED]
        for block in range(len(blocks)):
            lanes = blocks[block]
            for k in range(LANES):
                put(lanes, row + ORBIT_ANGLE, k, angle + get(lanes, POCKET, k))
                put(lanes, row + TANGENTIAL_VELOCITY, k, speed * get(lanes, row + AXIS_DISTANCE, k))


@inlined
def leave_out_spares(count, blocks, row, rows):
    """Puts zeros into so many rows from `row` on of lanes that repeat the last ball, so that sums leave them out."""
    if count % LANES != 0:
        last = blocks[count // LANES]
        for place in range(row, row + rows):
            for k in range(count % LANES, LANES):
                put(last, place, k, 0.0)


@inlined
def _pulls(ball_mass, lanes):
    """Of an even cage's balls r (F_t - 2 m v_r w) [N m] and m r^2 [kg m^2]."""
    for k in range(min(LANES, len(lanes))):  # LANES, which LLVM must not know, as in `spot.over_spots`
        radius = get(lanes, AXIS_DISTANCE, k)
        turning = get(lanes, TANGENTIAL_VELOCITY, k) * get(lanes, RADIAL_VELOCITY, k) / radius
        lever = ball_mass * radius
        put(lanes, BORDER_PUSH + CAGE, k, lever * (get(lanes, LANE_RATES + TANGENTIAL_VELOCITY, k) - turning))
        put(lanes, SHARES, k, lever * radius)


@inlined
def unbalance_pulls(unbalance, phase, drive, time):
    """Force (2,) [N] of an unbalance along x and y at `time` [s] into the part."""
    if unbalance == 0.0:
        return 0.0, 0.0
    angle = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time) + phase
    speed = drive.speed + drive.acceleration * time
    force = unbalance * speed * speed
    return force * math.cos(angle), force * math.sin(angle)


@inlined
def outside_load(partners, drive, time, i):
    """What acts on the ring from outside along coordinate i at `time` [s] into the part, weight left out [N, N m].

    It is 0 where coordinate i is held.
    """
    if partners.free[i] == 0.0:
        return 0.0
    load = partners.load[i] + time * partners.load_rate[i]
    return load + unbalance_pulls(partners.unbalance, partners.phase, drive, time)[i] if i < 2 else load


@inlined
def border_load(pulls, numbers, time, i):
    """`applied_load` of the ring whose numbers these are; `pulls` is what its unbalance does."""
    load = numbers[at.LOAD + i] + time * numbers[at.LOAD_RATE + i]
    return load + pulls[i] if i < 2 else load


@inlined
def border_rates(bearing, drive, border, time, blocks):
    """Fills the border's rates at its state `NOW`, from the pushes and rates of the balls in `blocks`."""
    numbers = border.numbers
    inertia = numbers[at.MASS + CAGE]
    for block in range(len(blocks)):
        if border.even:
            _pulls(bearing.ball_mass, blocks[block])
    leave_out_spares(border.count, blocks, BORDER_PUSH, PLACES)
    if border.even:
        leave_out_spares(border.count, blocks, SHARES, 1)
    for i in range(at.WIDTH):
        numbers[at.RATES + i] = 0.0
    for i in range(at.ring_places(border.ring)):
        numbers[at.RATES + i] = numbers[at.NOW + PLACES + i]
    numbers[at.RATES + CAGE] = numbers[at.NOW + CAGE_SPEED]
    for block in range(len(blocks)):
        lanes = blocks[block]
        for i in range(at.ring_places(border.ring)):
            add_sum(numbers, at.RATES + PLACES + i, 1.0, lanes, BORDER_PUSH + i)
        add_sum(numbers, at.RATES + CAGE_SPEED, 1.0, lanes, BORDER_PUSH + CAGE)
        if border.even:
            inertia = with_sum(inertia, 1.0, lanes, SHARES)
    numbers[at.INVERSE + CAGE] = numbers[at.FREE + CAGE] / inertia
    if len(border.ring) > 0:
        _load_ring(border.ring, drive, time, numbers)
        if len(border.land) > 0:  # here, because even a call that does nothing takes time
            add_land(border.land, drive.speed + drive.acceleration * time, numbers)
    for i in range(at.ring_places(border.ring)):
        numbers[at.RATES + PLACES + i] *= numbers[at.INVERSE + i]
    numbers[at.RATES + CAGE_SPEED] *= numbers[at.INVERSE + CAGE]
    _turn_shaft(border.shaft, border.land, drive.speed, time, border.count, numbers, blocks)


@inlined
def _turn_shaft(shaft, land, speed, time, count, numbers, blocks):
    """Fills the rates of a shaft that turns at `speed` [rad/s]: J dw/dt = T - c w + what balls and land do."""
    if len(shaft) > 0:
        leave_out_spares(count, blocks, AXIAL_PUSH, 1)
        torque = numbers[at.LOAD + CAGE] + time * numbers[at.LOAD_RATE + CAGE]
        moment = torque - shaft.damping * speed + land_moment(land, numbers, speed)
        for block in range(len(blocks)):
            moment = with_sum(moment, 1.0, blocks[block], AXIAL_PUSH)
        numbers[at.RATES + SHAFT_ANGLE], numbers[at.RATES + SHAFT_SPEED] = speed, moment / shaft.inertia
        numbers[at.RATES + SHAFT_WORK] = torque * speed
        numbers[at.RATES + LOST] += shaft.damping * speed * speed


@inlined
def _load_ring(ring, drive, time, numbers):
    """Adds to the forces on the ring, and fills the rates of work done and lost."""
    speeds, forces = at.NOW + PLACES, at.RATES + PLACES
    if len(ring) > 1:
        spin = numbers[at.POLAR_INERTIA] * (drive.speed + drive.acceleration * time)
        numbers[forces + 3] -= spin * numbers[speeds + 4]
        numbers[forces + 4] += spin * numbers[speeds + 3]
    pulls = unbalance_pulls(numbers[at.UNBALANCE], numbers[at.PHASE], drive, time)
    for i in range(at.ring_places(ring)):
        load, speed, free = border_load(pulls, numbers, time, i), numbers[speeds + i], numbers[at.FREE + i]
        drag = numbers[at.DAMPING + i] * speed
        spring = numbers[at.STIFFNESS + i] * (numbers[at.NOW + i] - numbers[at.REST + i])
        numbers[forces + i] += load + numbers[at.WEIGHT + i] - drag - spring
        numbers[at.RATES + WORK_DONE] += free * load * speed
        numbers[at.RATES + LOST] += free * drag * speed
