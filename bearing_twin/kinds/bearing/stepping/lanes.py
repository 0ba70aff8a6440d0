"""One Rosenbrock step of many balls side by side, alone or coupled.

Balls stand in blocks of lanes. Balls alone have a step size each and are solved one by one; coupled ones, which
`linear_system` says more about, have one step size for all and are solved together. All else is the same.
"""

import math

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.jacobian import lane_jacobian, ring_jacobian
from bearing_twin.kinds.bearing.forces.layout import (
    COLUMNS,
    ERROR,
    FIRST_STAGE,
    INVERSE_STEP,
    LANE_RATES,
    RIGHT,
    SLOPE,
    SOLUTION,
    STATE_SPAN,
    STEP,
    TIME,
    get,
    put,
    put_from,
)
from bearing_twin.kinds.bearing.forces.pairs import add_pairs
from bearing_twin.kinds.bearing.forces.rates import rates_in_lanes
from bearing_twin.kinds.bearing.stepping.border import border_rates
from bearing_twin.kinds.bearing.stepping.border_step import (
    border_finish,
    border_keep,
    border_right,
    border_slope,
    border_stage_state,
    copy_state,
)
from bearing_twin.kinds.bearing.stepping.linear_system import (
    couple_jacobians,
    factorise_alone,
    factorise_together,
    solve_alone,
)
from bearing_twin.kinds.bearing.stepping.shaft import factorise_shaft, solve_with_shaft, turning
from bearing_twin.kinds.bearing.stepping.stage_places import mixed_stages, place_stage, place_start
from bearing_twin.kinds.bearing.stepping.step_ends import finish_lanes, weigh_light
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.steppers import five

# Share of the step over which the rates' explicit change with time is taken: at 1e-3 the order fell from 4 to 2.
SLOPE_STEP = 1e-6


@inlined
def _add_coupled(coupling, bearing, drive, alpha, blocks):
    """Adds what balls do to each other, and finds the rates of the border."""
    if coupling.pairs.touching:
        add_pairs(bearing, coupling.pairs, blocks, blocks, LANE_RATES)
    if coupling.border.active:
        border_rates(bearing, drive, coupling.border, _moment(alpha, blocks), blocks)


@inlined
def border_of(coupling):
    """The border, or nothing where balls are alone."""
    if len(coupling) > 0:
        return coupling.border
    return ()


@inlined
def _moment(alpha, blocks):
    """The time of coupled balls, `alpha` steps ahead."""
    return get(blocks[0], TIME, 0) + alpha * get(blocks[0], STEP, 0)


@lean_kernel
def _loads_vary(coupling):
    """Whether what acts on the ring changes with time."""
    if len(coupling) > 0:
        return coupling.border.varying
    return False


@lean_kernel
def _keep_rates(border, blocks):
    """Keeps the rates of balls, ring and cage for `_take_slope`."""
    for block in range(len(blocks)):
        lanes = blocks[block]
        for i in range(STATE_SPAN):
            put(lanes, SLOPE, i, get(lanes, LANE_RATES, i))
    if len(border) > 0:
        copy_state(border.numbers, at.RATES, at.SLOPE)


@lean_kernel
def _take_slope(lanes):
    for i in range(STATE_SPAN):
        put(lanes, SLOPE, i, (get(lanes, SLOPE, i) - get(lanes, LANE_RATES, i)) / SLOPE_STEP)


@lean_kernel
def _stage_right(c, d, lanes):
    """The right-hand side of a stage from its rates."""
    weights = five(c)
    for i in range(STATE_SPAN):
        known = get(lanes, LANE_RATES, i) + d * get(lanes, SLOPE, i)
        put(lanes, RIGHT, i, known + mixed_stages(weights, lanes, 0, i) * get(lanes, INVERSE_STEP, i))


@lean_kernel
def _keep_stage(stage, lanes):
    """Stores the solution as a stage's; one that is not finite as zero, so that it cannot haunt the next attempt."""
    row = FIRST_STAGE + stage * COLUMNS
    for i in range(STATE_SPAN):
        value = get(lanes, SOLUTION, i)
        put_from(lanes, row, i, value if abs(value) < math.inf else 0.0)


@inlined
def _linearise(varies, coupling, bearing, drive, blocks):
    """The Jacobian and the explicit change with time where the steps start, after the rates, and the factors."""
    for block in range(len(blocks)):
        if varies:
            _take_slope(blocks[block])
        if len(coupling) > 0:
            ring_jacobian(bearing.ring, coupling.border, bearing, blocks[block])
        else:
            lane_jacobian(bearing.spot, bearing, blocks[block])
    if len(coupling) > 0:
        if varies:
            border_slope(SLOPE_STEP, coupling.border.numbers)
        couple_jacobians(bearing.pockets, bearing, drive, _moment(0.0, blocks), coupling, blocks)
        factorise_together(coupling, blocks)
        factorise_shaft(coupling.border.shaft, drive, bearing, _moment(0.0, blocks), coupling, blocks)
    else:
        for block in range(len(blocks)):
            factorise_alone(blocks[block])


@inlined
def _solve_stage(stage, method, coupling, drive, blocks):
    """Solves for a stage after its rates, and keeps it."""
    for block in range(len(blocks)):
        _stage_right(method.c[stage], method.d[stage], blocks[block])
    if len(coupling) > 0:
        border_right(method.c[stage], method.d[stage], get(blocks[0], STEP, 0), coupling.border.numbers)
        solve_with_shaft(coupling.border.shaft, drive, _moment(0.0, blocks), coupling, blocks)
        border_keep(stage, coupling.border.numbers)
    else:
        for block in range(len(blocks)):
            solve_alone(blocks[block])
    for block in range(len(blocks)):
        _keep_stage(stage, blocks[block])


@inlined
def _stage_of_border(stage, method, numbers):
    """Where ring and cage are in a stage; in the first, where they begin."""
    if stage > 0:
        border_stage_state(method.a[stage], numbers)


@inlined
def rosenbrock_step(coupling, bearing, drive, method, scales, blocks):
    """One step of every lane from START to END with TURNED, and its error; `coupling` is empty for balls alone."""
    varies, border = drive.acceleration != 0.0 or _loads_vary(coupling), border_of(coupling)
    if len(coupling) > 0:
        copy_state(coupling.border.numbers, at.BEGIN, at.NOW)
    # One loop, so that the code of the rates is here once. The stage before the first is the start a little later,
    # for the rates' explicit change with time: times h, as the method wants it, and zero at constant speed and load.
    for stage in range(-1 if varies else 0, len(method.alpha)):
        alpha = method.alpha[stage] if stage >= 0 else SLOPE_STEP
        if len(coupling) > 0:
            _stage_of_border(stage, method, coupling.border.numbers)
        now = turning(border, drive, _moment(alpha, blocks), at.NOW)
        for block in range(len(blocks)):
            if stage > 0:
                place_stage(border, now, alpha, method.a[stage], blocks[block])
            else:
                place_start(method.gamma, border, now, alpha, blocks[block])
            rates_in_lanes(bearing, blocks[block])
        if len(coupling) > 0:
            _add_coupled(coupling, bearing, now, alpha, blocks)
        if stage < 0:
            _keep_rates(border, blocks)
            continue
        if stage == 0:
            _linearise(varies, coupling, bearing, now, blocks)
        _solve_stage(stage, method, coupling, turning(border, drive, _moment(0.0, blocks), at.BEGIN), blocks)
    if len(coupling) > 0:
        border_finish(method.dense, coupling.border.numbers)
    for block in range(len(blocks)):
        finish_lanes(border, scales, method.dense, blocks[block])
        weigh_light(bearing.pockets, bearing, border, scales, blocks[block])
    if len(coupling) > 0:
        put(blocks[0], ERROR, 0, max(get(blocks[0], ERROR, 0), coupling.border.numbers[at.ERROR]))
