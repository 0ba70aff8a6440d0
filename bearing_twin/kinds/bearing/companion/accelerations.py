"""Accelerations of balls, read off how their motion changes from output to output, and how well these are known."""

from bearing_twin.compiled import inlined
from bearing_twin.numerics.rotation import add, minus, scaled

SAME = 1e-6  # of an interval between outputs: those that differ by less are alike


@inlined
def changes(before, state, later, first, past, following):
    """How fast three numbers from `first` on change, of second order; at the last output from the one before."""
    one = scaled(1.0 / past, minus(three(state, first), three(before, first)))
    if following == 0.0:
        return one
    uneven = minus(scaled(1.0 / following, minus(three(later, first), three(state, first))), one)
    return add(one, scaled(past / (past + following), uneven))


@inlined
def better(states, now, ball, first, change, step):
    """What fourth order would add to a `change` over even steps [s], from two outputs to either side."""
    far = scaled(0.25 / step, minus(three(states[now + 2, ball], first), three(states[now - 2, ball], first)))
    return scaled(1.0 / 3.0, minus(change, far))


@inlined
def bends(states, now, ball, first, step):
    """How far three numbers from `first` on are from a cubic over even steps [s], as rates: 0 where all is smooth."""
    middle = three(states[now, ball], first)
    near = add(three(states[now - 1, ball], first), three(states[now + 1, ball], first))
    far = add(three(states[now - 2, ball], first), three(states[now + 2, ball], first))
    return scaled(1.0 / step, add(minus(far, scaled(4.0, near)), scaled(6.0, middle)))


@inlined
def even(times, now, last):
    """Whether two outputs to either side of one are evenly apart."""
    if now < 2 or now > last - 2:
        return False
    step, unlike = times[now] - times[now - 1], 0.0
    for other in (now - 1, now + 1, now + 2):
        unlike = max(unlike, abs(times[other] - times[other - 1] - step))
    return unlike <= SAME * step


@inlined
def three(numbers, first):
    """Three numbers from `first` on."""
    return numbers[first], numbers[first + 1], numbers[first + 2]
