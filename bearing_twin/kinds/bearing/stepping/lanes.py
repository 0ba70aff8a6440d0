"""One Rosenbrock step of many balls side by side, alone or coupled: their rates, their linear system, their errors."""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.forces import border_rows as at
from bearing_twin.kinds.bearing.forces.jacobian import rates_and_ring_jacobian
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, FIRST_RATES
from bearing_twin.kinds.bearing.forces.pairs import add_pairs, look_ahead
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
from bearing_twin.kinds.bearing.stepping.flight import by_themselves
from bearing_twin.kinds.bearing.stepping.landings import weigh_landings
from bearing_twin.kinds.bearing.stepping.linear_system import (
    couple_jacobians,
    factorise_alone,
    factorise_together,
    solve_alone,
)
from bearing_twin.kinds.bearing.stepping.shaft import factorise_shaft, shaft_answers, solve_with_shaft, turning
from bearing_twin.kinds.bearing.stepping.stage_places import place_stage, place_start
from bearing_twin.kinds.bearing.stepping.step_ends import finish_lanes, weigh_light
from bearing_twin.numerics.lanes import ERROR, LANE_RATES, STATE_SPAN, STEP, TIME, begins_again, get, put
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.rosenbrock import SLOPE_STEP, rosenbrock_stages


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
def _keep_first(lanes):
    """Keeps the rates of a step's start; rows that were arguments would cost the loop its vectors."""
    for i in range(STATE_SPAN):
        put(lanes, FIRST_RATES, i, get(lanes, LANE_RATES, i))


@lean_kernel
def _take_first(lanes):
    """Takes the rates that `_keep_first` kept."""
    for i in range(STATE_SPAN):
        put(lanes, LANE_RATES, i, get(lanes, FIRST_RATES, i))


@inlined
def _rates(task, coupling, stage, alpha, blocks):
    """The rates of balls, ring and cage in a stage; in the first with the Jacobians of balls.

    There a step that is made again takes those kept.
    """
    again = stage == 0 and begins_again(coupling, blocks)
    bearing, border, method, time = task.bearing, border_of(coupling), task.method, _moment(alpha, blocks)
    if len(coupling) > 0:
        if stage > 0:
            border_stage_state(method.a[stage], coupling.border.numbers)
        else:
            copy_state(coupling.border.numbers, at.BEGIN, at.NOW)
    now = turning(border, task.drive, time, at.NOW)
    for block in range(len(blocks)):
        if stage > 0:
            place_stage(border, now, alpha, method.a[stage], blocks[block])
        else:
            place_start(method.gamma, border, now, alpha, blocks[block])
        if again:
            _take_first(blocks[block])
        elif stage == 0:
            rates_and_ring_jacobian(bearing.ring, border, bearing, blocks[block])
        else:
            rates_in_lanes(bearing, blocks[block])
    if len(coupling) > 0:
        if again:
            copy_state(coupling.border.numbers, at.FIRST_RATES, at.RATES)
            if coupling.pairs.touching:  # their linear system asks for the motion, too
                look_ahead(coupling.pairs, blocks, AXIS_DISTANCE)
        else:
            _couple(bearing, now, time, coupling, blocks)
        if stage < 0:
            copy_state(coupling.border.numbers, at.RATES, at.SLOPE)
        if stage == 0:
            copy_state(coupling.border.numbers, at.RATES, at.FIRST_RATES)
            for block in range(len(blocks)):
                _keep_first(blocks[block])


@inlined
def _couple(bearing, drive, time, coupling, blocks):
    """Adds to the rates of balls alone what couples them, and fills those of ring and cage."""
    if coupling.pairs.touching:
        add_pairs(bearing, coupling.pairs, blocks, blocks, LANE_RATES)
    if coupling.border.active:
        border_rates(bearing, drive, coupling.border, time, blocks)


@inlined
def _linearise(task, coupling, varies, blocks):
    """What couples the balls in the Jacobian where the steps start, and the factors."""
    bearing, time = task.bearing, _moment(0.0, blocks)
    if len(coupling) > 0:
        if varies:
            border_slope(SLOPE_STEP, coupling.border.numbers)
        drive = turning(coupling.border, task.drive, time, at.NOW)
        if not begins_again(coupling, blocks):
            couple_jacobians(bearing.pockets, bearing, drive, time, coupling, blocks)
            shaft_answers(coupling.border.shaft, drive, bearing, time, coupling, blocks)
        factorise_together(coupling, blocks)
        factorise_shaft(coupling.border.shaft, drive, time, coupling, blocks)
    else:
        for block in range(len(blocks)):
            factorise_alone(blocks[block])


@inlined
def _solve(task, coupling, stage, blocks):
    """Solves for a stage after its right-hand side, and keeps that of the border."""
    if len(coupling) > 0:
        method, numbers, time = task.method, coupling.border.numbers, _moment(0.0, blocks)
        border_right(method.c[stage], method.d[stage], get(blocks[0], STEP, 0), numbers)
        drive = turning(coupling.border, task.drive, time, at.BEGIN)
        solve_with_shaft(coupling.border.shaft, drive, time, coupling, blocks)
        border_keep(stage, numbers)
    else:
        for block in range(len(blocks)):
            solve_alone(blocks[block])


@inlined
def rosenbrock_step(task, coupling, blocks):
    """One step of every lane from START to END with TURNED, and its error; `coupling` is empty for balls alone."""
    border, method = border_of(coupling), task.method
    varies = task.drive.acceleration != 0.0
    if len(coupling) > 0:
        varies = varies or coupling.border.varying
    rosenbrock_stages(_rates, _linearise, _solve, task, coupling, method, varies, blocks)
    if len(coupling) > 0:
        border_finish(method.dense, coupling.border.numbers)
    for block in range(len(blocks)):
        finish_lanes(border, task.scales, method.dense, blocks[block])
        weigh_light(task.bearing.pockets, task.bearing, border, task.scales, blocks[block])
        if by_themselves(coupling):
            weigh_landings(task.bearing, task.scales, blocks[block])
    if len(coupling) > 0:
        put(blocks[0], ERROR, 0, max(get(blocks[0], ERROR, 0), coupling.border.numbers[at.ERROR]))
