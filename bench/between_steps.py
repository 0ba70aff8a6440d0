"""Methods between explicit and implicit ones, as `between.py` runs them: tables, and steps in lanes.

With J, the exact derivatives of a ball's rates by its velocity and spin at the start of a step, the rates are J y and a
rest. Additive Runge-Kutta pairs take the rest by an explicit table, and J y by an implicit one, whose stages one Newton
iteration solves exactly; a W-method keeps its order whatever J is. A step costs one J, one factorisation of 6 x 6 and a
solution a stage. Lanes, loop of steps, what is given out and the norm are the product's.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.forces.equations import RingDrive
from bearing_twin.kinds.bearing.forces.handing import taken
from bearing_twin.kinds.bearing.forces.layout import (
    AXIS_DISTANCE,
    FACTOR_COUPLING,
    FACTOR_INVERSE,
    FACTOR_SCHUR,
    MOTION,
    ROSENBROCK_ROWS,
    SPIN,
    VELOCITY,
)
from bearing_twin.kinds.bearing.forces.rates import rates_in_lanes
from bearing_twin.kinds.bearing.forces.resistance import lane_resistance, rates_and_resistance
from bearing_twin.kinds.bearing.stepping import rosenbrock as product
from bearing_twin.kinds.bearing.stepping.stage_places import place_stage, place_start
from bearing_twin.kinds.bearing.stepping.step_ends import finish_lanes
from bearing_twin.kinds.bearing.stepping.steps import Results, new_dense_step
from bearing_twin.numerics import lanes as at
from bearing_twin.numerics.block_solve import factorise_motion, solve_motion
from bearing_twin.numerics.lanes import get, get_vector, put, put_vector
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rosenbrock import IDLE, _keep_stage, advance_lanes, fill_lanes
from bearing_twin.numerics.rosenbrock_inside import mixed_stages
from bearing_twin.numerics.rotation import scaled
from bearing_twin.numerics.steppers import MOST_STAGES, five
from bearing_twin.numerics.stretches import Stretches

RATES = ROSENBROCK_ROWS  # where h times the rates of stages stand, a row set each


def lower(*rows) -> np.ndarray:
    """A square matrix from the rows of its lower triangle."""
    return np.array([(*row, *(0.0,) * (len(rows) - len(row))) for row in rows])


class Pair(NamedTuple):
    """Tables of a method: `explicit` for the rest, `implicit` for J y, both with `weights`; those of its estimate."""

    explicit: np.ndarray
    implicit: np.ndarray
    weights: np.ndarray
    embedded: np.ndarray
    order: int


_G4, _B4 = 1 / 4, (82889 / 524892, 0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4)
ARK4 = Pair(  # Kennedy and Carpenter, Applied Numerical Mathematics 44 (2003) 139: ARK4(3)6L[2]SA
    explicit=lower(
        (),
        (1 / 2,),
        (13861 / 62500, 6889 / 62500),
        (-116923316275 / 2393684061468, -2731218467317 / 15368042101831, 9408046702089 / 11113171139209),
        (-451086348788 / 2902428689909, -2682348792572 / 7519795681897, 12662868775082 / 11960479115383,
         3355817975965 / 11060851509271),
        (647845179188 / 3216320057751, 73281519250 / 8382639484533, 552539513391 / 3454668386233,
         3354512671639 / 8306763924573, 4040 / 17871),
    ),
    implicit=lower(
        (),
        (_G4, _G4),
        (8611 / 62500, -1743 / 31250, _G4),
        (5012029 / 34652500, -654441 / 2922500, 174375 / 388108, _G4),
        (15267082809 / 155376265600, -71443401 / 120774400, 730878875 / 902184768, 2285395 / 8070912, _G4),
        _B4,
    ),
    weights=np.array(_B4),
    embedded=np.array((4586570599 / 29645900160, 0, 178811875 / 945068544, 814220225 / 1159782912,
                       -3700637 / 11593932, 61727 / 225920)),
    order=4,
)  # fmt: skip

_G3 = 1767732205903 / 4055673282236
_B3 = (1471266399579 / 7840856788654, -4482444167858 / 7529755066697, 11266239266428 / 11593286722821, _G3)
ARK3 = Pair(  # the same: ARK3(2)4L[2]SA
    explicit=lower(
        (),
        (2.0 * _G3,),
        (5535828885825 / 10492691773637, 788022342437 / 10882634858940),
        (6485989280629 / 16251701735622, -4246266847089 / 9704473918619, 10755448449292 / 10357097424841),
    ),
    implicit=lower((), (_G3, _G3), (2746238789719 / 10658868560708, -640167445237 / 6845629431997, _G3), _B3),
    weights=np.array(_B3),
    embedded=np.array((2756255671327 / 12835298489170, -10771552573575 / 22201958757719,
                       9247589265047 / 10645013368117, 2193209047091 / 5459859503100)),
    order=3,
)  # fmt: skip
_GW = 0.43586652150845900
_BW = (0.24212380706095346, -1.2232505839045147, 1.5452602553351020, _GW)
ROS34PW2 = Pair(  # Rang and Angermann, BIT 45 (2005) 761: a W-method, here alpha and gamma
    explicit=lower((), (0.87173304301691801,), (0.84457060015369423, -0.11299064236484185), (0.0, 0.0, 1.0)),
    implicit=lower(
        (_GW,),
        (-0.87173304301691801, _GW),
        (-0.90338057013044082, 0.054180672388095326, _GW),
        (_BW[0], _BW[1], 0.54526025533510214, _GW),
    ),
    weights=np.array(_BW),
    embedded=np.array((0.37810903145819369, -0.096042292212423178, 0.5, 0.21793326075422950)),
    order=3,
)


class Between(NamedTuple):
    """A `Pair` as steps are made by it: stage i takes its rates F at y + sum `a` S, then solves for its own S.

    (I/(h gamma) - J) S = (sum `right` h F + sum `c` S) / h; end and error are sums of `ends` h F and of `moves` S.
    `dense` are the weights of `finish_lanes`, which gets the two terms of its interpolant in the first two stages.
    """

    gamma: float
    a: np.ndarray
    alpha: np.ndarray
    right: np.ndarray
    c: np.ndarray
    ends: np.ndarray
    moves: np.ndarray
    last: np.ndarray
    solved: int
    dense: np.ndarray
    order: int
    lands: bool = False


def _filled(matrix, columns) -> np.ndarray:
    matrix = np.atleast_2d(matrix)
    return np.hstack([matrix, np.zeros((len(matrix), columns))])[:, :columns]


def between(pair: Pair) -> Between:
    """The method of a pair, whose first stage an additive one takes explicitly and a W-method solves for."""
    explicit, implicit, stages = pair.explicit, pair.implicit, len(pair.weights)
    gamma, weights = implicit[-1, -1], np.array([pair.weights, pair.weights - pair.embedded])
    if implicit[0, 0]:  # a W-method, in the transformed form of Hairer and Wanner, section IV.7
        inverse = np.linalg.inv(implicit)
        a, right, c = explicit @ inverse, np.eye(stages), np.eye(stages) / gamma - inverse
        ends, moves, solved = 0.0 * weights, weights @ inverse, stages
    else:  # S is the state of the next stage; what J makes of the states before follows from S and F
        further = np.tril(implicit - explicit, -1)
        known = further @ np.linalg.inv(gamma * np.eye(stages) + further)
        a, right = np.eye(stages, k=-1), ((np.eye(stages) - known) @ explicit)[1:] / gamma
        c, ends, moves, solved = known[1:, 1:] / gamma, weights, 0.0 * weights, stages - 1
    unit, few = np.eye(MOST_STAGES), MOST_STAGES - 1
    return Between(
        gamma=float(gamma),
        a=_filled(a, few),
        alpha=explicit.sum(axis=1),
        right=_filled(right, MOST_STAGES),
        c=_filled(c, few),
        ends=_filled(ends, MOST_STAGES),
        moves=_filled(moves, few),
        last=unit[stages - 1],
        solved=solved,
        dense=unit[:2, :few],
        order=pair.order,
    )


METHODS = {"ARK4(3)6L": between(ARK4), "ARK3(2)4L": between(ARK3), "ROS34PW2": between(ROS34PW2)}


@inlined
def _six(weights):
    return (weights[0], weights[1], weights[2], weights[3], weights[4], weights[5])


@inlined
def _mixed(weights, lanes, i):
    """The weighted sum of h times the rates of stages."""
    total = weights[0] * get(lanes, RATES, i)
    for stage in range(1, MOST_STAGES):
        total += weights[stage] * get(lanes, RATES + stage * at.COLUMNS, i)
    return total


@lean_kernel
def _keep_rates(stage, lanes):
    """Keeps h times the rates of a stage; one that is not finite as zero, as the product does with solutions."""
    row = RATES + stage * at.COLUMNS
    for i in range(at.STATE_SPAN):
        value = get(lanes, at.SLOPE, i) * get(lanes, at.LANE_RATES, i)
        at.put_from(lanes, row, i, value if abs(value) < np.inf else 0.0)


@lean_kernel
def _factorise(lanes):
    """Factors of I/(h gamma) - J of every lane, J by velocity and spin alone; and h [s] in the rows of SLOPE."""
    for k in range(at.LANES):
        velocities, coupling, schur = factorise_motion(get(lanes, at.GAIN, k), *lane_resistance(lanes, k))
        at.put_block(lanes, FACTOR_INVERSE, k, velocities)
        at.put_block(lanes, FACTOR_COUPLING, k, coupling)
        at.put_block(lanes, FACTOR_SCHUR, k, schur)
        for column in range(at.COLUMNS):
            put(lanes, at.SLOPE + column, k, get(lanes, at.STEP, k))


@inlined
def _put_right(right, c, lanes):
    of_rates, of_stages = _six(right), five(c)
    for i in range(at.STATE_SPAN):
        known = _mixed(of_rates, lanes, i) + mixed_stages(of_stages, lanes, 0, i)
        put(lanes, at.RIGHT, i, known * get(lanes, at.INVERSE_STEP, i))


@inlined
def _explicitly(row, lanes, k):
    """What three columns are solved to that answer to nothing."""
    put_vector(lanes, at.SOLUTION + row, k, scaled(get(lanes, at.GAIN, k), get_vector(lanes, at.RIGHT + row, k)))


@lean_kernel
def _solve(right, c, lanes):
    """The right-hand side of a stage, and its solution."""
    _put_right(right, c, lanes)
    for k in range(at.LANES):
        inverse, coupling = at.get_block(lanes, FACTOR_INVERSE, k), at.get_block(lanes, FACTOR_COUPLING, k)
        below, schur = lane_resistance(lanes, k)[2], at.get_block(lanes, FACTOR_SCHUR, k)
        force, torque = get_vector(lanes, at.RIGHT + VELOCITY, k), get_vector(lanes, at.RIGHT + SPIN, k)
        velocity, spin = solve_motion(inverse, coupling, below, schur, force, torque)
        put_vector(lanes, at.SOLUTION + VELOCITY, k, velocity)
        put_vector(lanes, at.SOLUTION + SPIN, k, spin)
        _explicitly(AXIS_DISTANCE, lanes, k)
        _explicitly(MOTION, lanes, k)  # the integrals


@lean_kernel
def _take_end(ends, moves, last, lanes):
    """END, the error in SOLUTION, and in two stages the cubic between both ends, by the first rates and the last."""
    end, move, rates = _six(ends[0]), five(moves[0]), _six(last)
    error, off = _six(ends[1]), five(moves[1])
    for i in range(at.STATE_SPAN):
        change, first = _mixed(end, lanes, i) + mixed_stages(move, lanes, 0, i), get(lanes, RATES, i)
        put(lanes, at.SOLUTION, i, _mixed(error, lanes, i) + mixed_stages(off, lanes, 0, i))
        put(lanes, at.END, i, get(lanes, at.START, i) + change)
        put(lanes, at.FIRST_STAGE, i, first - change)
        put(lanes, at.SECOND_STAGE, i, 2.0 * change - first - _mixed(rates, lanes, i))


@inlined
def _one_step(run, coupling, blocks):
    """One step of every lane from START to END with its error; balls are alone."""
    task, method, lanes = run.task, run.task.method, blocks[0]
    bearing = task.bearing
    for stage in range(len(method.alpha)):
        if stage == 0:
            place_start(method.gamma, (), task.drive, 0.0, lanes)
            rates_and_resistance(bearing.spot, bearing.ring, bearing, lanes)
            _factorise(lanes)
        else:
            place_stage((), task.drive, method.alpha[stage], method.a[stage], lanes)
            rates_in_lanes(bearing, lanes)
        _keep_rates(stage, lanes)
        if stage < method.solved:
            _solve(method.right[stage], method.c[stage], lanes)
            _keep_stage(stage, lanes)
    _take_end(method.ends, method.moves, method.last, lanes)
    finish_lanes((), task.scales, method.dense, lanes)


@lean_kernel
def _advance(run, stretches, balls, steps, results, held, cursor, blocks):
    fill_lanes(product._begin, run, (), stretches, balls, steps, held, cursor, blocks)
    return advance_lanes(
        product._cut, _one_step, product._landing, product._accept_all, product._give_out, product._accept,
        product._end, product._begin,
        run, (), run.task.method, stretches, balls, steps, held, cursor, results, blocks,
    )  # fmt: skip


@kernel
def advance_between(bearing, drive, method, times, duration, scales, own, balls, state, orientation, steps, results):
    """As the product's `rosenbrock_chunk` of balls alone, whose bearing, drive, method and so on come without names."""
    task = product.ChunkTask(Between(*method), taken(bearing), RingDrive(*drive), times, duration, scales)
    stretches, filled, held = Stretches(*own), Results(*results), np.full(at.LANES, IDLE)
    run = product.ChunkWork(task, stretches, state, orientation, filled, new_dense_step())
    blocks = at.new_blocks(1, RATES + MOST_STAGES * at.COLUMNS)
    return _advance(run, stretches, balls, steps, filled, held, np.zeros_like(held), blocks)
