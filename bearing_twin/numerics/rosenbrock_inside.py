"""What lies inside a Rosenbrock step of bodies in lanes: weighted sums of its stages, and its interpolant."""

from bearing_twin.compiled import inlined, kernel
from bearing_twin.numerics import lanes as at
from bearing_twin.numerics.lanes import COLUMNS, STATE_SPAN, get, put
from bearing_twin.numerics.lean import lean_kernel
from bearing_twin.numerics.steppers import five, rosenbrock_dense


@inlined
def mixed_stages(weights, lanes, column, k):
    """The weighted sum of the earlier stages in one column; k may run on, as for `get`."""
    return (
        weights[0] * get(lanes, at.FIRST_STAGE + column, k)
        + weights[1] * get(lanes, at.SECOND_STAGE + column, k)
        + weights[2] * get(lanes, at.THIRD_STAGE + column, k)
        + weights[3] * get(lanes, at.FOURTH_STAGE + column, k)
        + weights[4] * get(lanes, at.FIFTH_STAGE + column, k)
    )


@lean_kernel
def dense_terms(weights, lanes, k, dense):
    """Fills the two terms of one lane's interpolant, `third` and `fourth`, by the method's dense weights."""
    third, fourth = five(weights[0]), five(weights[1])
    for column in range(COLUMNS):
        dense.third[column] = mixed_stages(third, lanes, column, k)
        dense.fourth[column] = mixed_stages(fourth, lanes, column, k)


@lean_kernel
def take_terms(weights, lanes):
    """Fills THIRD and FOURTH, the two terms of every lane's interpolant, by the method's dense weights."""
    third, fourth = five(weights[0]), five(weights[1])
    for i in range(STATE_SPAN):
        put(lanes, at.THIRD, i, mixed_stages(third, lanes, 0, i))
        put(lanes, at.FOURTH, i, mixed_stages(fourth, lanes, 0, i))


@inlined
def inside(fraction, lanes, column, k):
    """One column of a lane's state at `fraction` of its step, after `take_terms`."""
    start, end = get(lanes, at.START + column, k), get(lanes, at.END + column, k)
    return rosenbrock_dense(fraction, start, end, get(lanes, at.THIRD + column, k), get(lanes, at.FOURTH + column, k))


@kernel
def interpolate(dense, fraction, out):
    """The state (COLUMNS,) at `fraction` of a dense step."""
    for column in range(COLUMNS):
        out[column] = rosenbrock_dense(
            fraction, dense.start[column], dense.end[column], dense.third[column], dense.fourth[column]
        )
