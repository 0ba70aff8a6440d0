"""The bodies that meet all balls, inner ring and cage: their state, what moves them, and their part of a step.

They are the border of the linear system. A state holds six places (the ring's centre x, y, z [m] and tilt about x and
y [rad], the cage's angle [rad]), their velocities, and two integrals that only listen [J]: the work of the loads on
the ring, and what its support loses. All is in `bearing_link`.

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
from bearing_twin.kinds.bearing.equations import Bearing
from bearing_twin.kinds.bearing.layout import (
    AXIS_DISTANCE,
    BORDER,
    BORDER_MOTION,
    BORDER_PUSH,
    CAGE,
    LANE_RATES,
    LANES,
    LOST,
    ORBIT_ANGLE,
    PLACES,
    POCKET,
    RADIAL_VELOCITY,
    SHARES,
    TANGENTIAL_VELOCITY,
    WORK_DONE,
    get,
    put,
    sum_of,
)
from bearing_twin.kinds.bearing.ring_seat import RingMotion
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.steppers import MOST_STAGES, rosenbrock_dense

CAGE_SPEED = PLACES + CAGE


class Partners(NamedTuple):
    """What meets all balls in a part of a chunk: numbers (PLACES,) of ring and cage, in SI.

    `ring` is empty where the ring is held: kernels then know the cage alone. `free` is 1 where a place follows its
    loads, else 0. `load` grows by `load_rate` a second; `unbalance` [kg m] turns with the ring, `phase` [rad] ahead of
    it. `scales` (2 PLACES,) are the errors a step may make.
    """

    ring: tuple
    active: bool
    even: bool
    varying: bool
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


class Border(NamedTuple):
    """Room for a Rosenbrock step of ring and cage: arrays (BORDER,), `stages` (stages, BORDER).

    `own` (PLACES, 2 PLACES) is the Jacobian of the border's accelerations by its own motion, `inverse` (PLACES,) of
    their inertia, `error` (1,) that of the step; `corner` (PLACES * PLACES,) is what the elimination of the balls
    leaves of the linear system.
    """

    partners: Partners
    count: int
    start: np.ndarray
    end: np.ndarray
    now: np.ndarray
    slope: np.ndarray
    rates: np.ndarray
    right: np.ndarray
    solution: np.ndarray
    third: np.ndarray
    fourth: np.ndarray
    stages: np.ndarray
    own: np.ndarray
    inverse: np.ndarray
    error: np.ndarray
    corner: np.ndarray


@kernel
def new_border(partners, count, state):
    """Room for so many balls, holding `state` (BORDER,)."""
    rooms = np.zeros((9, BORDER))
    rooms[0] = state
    return Border(
        partners, count, rooms[0], rooms[1], rooms[2], rooms[3], rooms[4], rooms[5], rooms[6], rooms[7],
        rooms[8], np.zeros((MOST_STAGES, BORDER)), np.zeros((PLACES, 2 * PLACES)), np.zeros(PLACES), np.zeros(1),
        np.zeros(PLACES * PLACES),
    )  # fmt: skip


@inlined
def bearing_at(ring, bearing, state):
    """The bearing with its ring where the `state` (2 PLACES or more,) of the border has it; `ring` is the bearing's."""
    if len(ring) == 0:
        return bearing
    return Bearing(
        bearing.balls,
        bearing.ball_radius,
        bearing.ball_mass,
        bearing.ball_inertia,
        bearing.inner,
        bearing.outer,
        (state[0], state[1], state[2]),
        bearing.gravity,
        bearing.damping,
        bearing.relaxation_time,
        bearing.friction_coefficient,
        bearing.friction_regularisation,
        bearing.pair_coefficient,
        bearing.raceway_friction,
        bearing.spot,
        RingMotion(
            (state[3], state[4]),
            (state[PLACES], state[PLACES + 1], state[PLACES + 2]),
            (state[PLACES + 3], state[PLACES + 4]),
        ),
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
def put_border(border, blocks):
    """Gives all lanes the motion of ring and cage, as the border has it `now`."""
    if border.partners.active:
        for block in range(len(blocks)):
            for i in range(2 * PLACES):
                for k in range(LANES):
                    put(blocks[block], BORDER_MOTION + i, k, border.now[i])


@lean_kernel
def follow_cage(border, state, blocks, row):
    """Puts balls of an even cage, whose state begins at `row`, where `state` has the cage."""
    if border.partners.even:
        for block in range(len(blocks)):
            lanes = blocks[block]
            for k in range(LANES):
                put(lanes, row + ORBIT_ANGLE, k, state[CAGE] + get(lanes, POCKET, k))
                put(lanes, row + TANGENTIAL_VELOCITY, k, state[CAGE_SPEED] * get(lanes, row + AXIS_DISTANCE, k))


@lean_kernel
def leave_out_spares(count, blocks, row, rows):
    """Puts zeros into so many rows from `row` on of lanes that repeat the last ball, so that sums leave them out."""
    if count % LANES != 0:
        last = blocks[count // LANES]
        for at in range(row, row + rows):
            for k in range(count % LANES, LANES):
                put(last, at, k, 0.0)


@lean_kernel
def _pulls(bearing, lanes):
    """Of an even cage's balls r (F_t - 2 m v_r w) [N m] and m r^2 [kg m^2]."""
    for k in range(LANES):
        radius = get(lanes, AXIS_DISTANCE, k)
        turning = get(lanes, TANGENTIAL_VELOCITY, k) * get(lanes, RADIAL_VELOCITY, k) / radius
        lever = bearing.ball_mass * radius
        put(lanes, BORDER_PUSH + CAGE, k, lever * (get(lanes, LANE_RATES + TANGENTIAL_VELOCITY, k) - turning))
        put(lanes, SHARES, k, lever * radius)


@inlined
def applied_load(partners, drive, time, i):
    """What acts on the ring from outside along coordinate i at `time` [s] into the part, weight left out [N, N m]."""
    found = partners.load[i] + time * partners.load_rate[i]
    if i < 2 and partners.unbalance != 0.0:
        angle = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time) + partners.phase
        speed = drive.speed + drive.acceleration * time
        found += partners.unbalance * speed * speed * (math.cos(angle) if i == 0 else math.sin(angle))
    return found


@lean_kernel
def border_rates(bearing, drive, border, time, blocks):
    """Fills `border.rates` at the state `border.now`, from the pushes and rates of the balls in `blocks`."""
    partners, state, rates = border.partners, border.now, border.rates
    inertia = partners.mass[CAGE]
    for block in range(len(blocks)):
        if partners.even:
            _pulls(bearing, blocks[block])
    leave_out_spares(border.count, blocks, BORDER_PUSH, PLACES)
    if partners.even:
        leave_out_spares(border.count, blocks, SHARES, 1)
        for block in range(len(blocks)):
            inertia += sum_of(blocks[block], SHARES)
    first = 0 if len(partners.ring) > 0 else CAGE
    rates[:] = 0.0
    for i in range(first, PLACES):
        rates[i] = state[PLACES + i]
        for block in range(len(blocks)):
            rates[PLACES + i] += sum_of(blocks[block], BORDER_PUSH + i)
        border.inverse[i] = partners.free[i] / (inertia if i == CAGE else partners.mass[i])
    if len(partners.ring) > 0:
        _load_ring(partners, drive, time, state, rates)
    for i in range(first, PLACES):
        rates[PLACES + i] *= border.inverse[i]


@lean_kernel
def _load_ring(partners, drive, time, state, rates):
    """Adds to the forces on the ring, and fills the rates of work done and lost."""
    spin = partners.polar_inertia * (drive.speed + drive.acceleration * time)
    rates[PLACES + 3] -= spin * state[PLACES + 4]
    rates[PLACES + 4] += spin * state[PLACES + 3]
    for i in range(CAGE):
        load, speed = applied_load(partners, drive, time, i), state[PLACES + i]
        drag = partners.damping[i] * speed
        rates[PLACES + i] += load + partners.weight[i] - drag - partners.stiffness[i] * (state[i] - partners.rest[i])
        rates[WORK_DONE] += partners.free[i] * load * speed
        rates[LOST] += partners.free[i] * drag * speed


@lean_kernel
def border_stage_state(a, border):
    """The state at which a stage takes its rates: `now`, and `end` after the last."""
    for i in range(BORDER):
        total = border.start[i]
        for j in range(len(a)):
            total += a[j] * border.stages[j, i]
        border.now[i] = border.end[i] = total


@lean_kernel
def border_right(c, d, step, border):
    """The right-hand side of a stage."""
    for i in range(BORDER):
        total = border.rates[i] + d * border.slope[i]
        for j in range(len(c)):
            total += c[j] * border.stages[j, i] / step
        border.right[i] = total


@lean_kernel
def border_keep(stage, border):
    """Stores the solution as a stage's, as `lanes` does."""
    for i in range(BORDER):
        value = border.solution[i]
        border.stages[stage, i] = value if abs(value) < math.inf else 0.0


@lean_kernel
def border_finish(dense, border):
    """The end of the step, its error in units of the scales, and the terms of its interpolant."""
    partners, total, count = border.partners, 0.0, 0.0
    for i in range(BORDER):
        border.end[i] += border.solution[i]
        border.third[i] = border.fourth[i] = 0.0
        for j in range(dense.shape[1]):
            border.third[i] += dense[0, j] * border.stages[j, i]
            border.fourth[i] += dense[1, j] * border.stages[j, i]
    for i in range(2 * PLACES):
        ratio, free = border.solution[i] / partners.scales[i], partners.free[i % PLACES]
        total += free * ratio * ratio
        count += free
    border.error[0] = math.sqrt(total / max(count, 1.0))


@lean_kernel
def border_inside(border, fraction, out):
    """The state (BORDER,) of ring and cage at `fraction` of the step."""
    for i in range(BORDER):
        out[i] = rosenbrock_dense(fraction, border.start[i], border.end[i], border.third[i], border.fourth[i])
