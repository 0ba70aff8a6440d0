"""Where within a step something happens: between a place before it and one after it, and at the top of a curve."""

from bearing_twin.compiled import inlined, template
from bearing_twin.numerics.statuses import EVALUATIONS

MOST_LOOKS = 100  # of regula falsi
CLOSE = 4e-16  # share of a step that is no shorter
TOP_LOOKS = 2  # at a number where its rate changes its sign
NEAR_GREATEST, SAME_TOP = 0.9, 1e-3  # tuned: of the greatest value so far; of the span between the places about a top


@template
def landing_step(value, one_step, scene, method, state, step, nearest, work, counts):
    """Length [s] of the step at whose end `value(scene, state)` has just changed its sign; its end is in `work.after`.

    By regula falsi with Illinois' weights, each look at the value being a step; `work.after` has that of `step`, where
    the sign has changed. A value not above `nearest` is as good as zero.
    """
    first = value(scene, state)
    low, value_low, high, value_high = 0.0, first, step, value(scene, work.after)
    side, length, before = 0, step, False
    for _ in range(MOST_LOOKS):
        length = (low * value_high - high * value_low) / (value_high - value_low)
        if not low < length < high:
            length = 0.5 * (low + high)
        one_step(scene, method, state, length, True, work, work.after)
        counts[EVALUATIONS] += len(method.weights)
        found = value(scene, work.after)
        before = (found > 0.0) == (first > 0.0)
        if before:
            low, value_low = length, found
            value_high = 0.5 * value_high if side == 1 else value_high
            side = 1
        else:
            high, value_high = length, found
            value_low = 0.5 * value_low if side == -1 else value_low
            side = -1
            if abs(found) <= nearest or high - low <= CLOSE * step:
                break
    if before:
        length = high
        one_step(scene, method, state, high, True, work, work.after)
    return length


@template
def greatest_within(look, what, step, start, end, greatest):
    """The greater of `greatest` and the most that a number comes to in a step [s], by the zero of its rate.

    `start` and `end` are (value, rate) at the ends; `look(what, place)` is that `place` [s] after the start. Looks are
    by regula falsi; what the last one is still off the top goes with the square of its rate.
    """
    greatest = max(greatest, start[0], end[0])
    if not start[1] > 0.0 > end[1] or max(start[0], end[0]) < NEAR_GREATEST * greatest:
        return greatest
    low, rise, high, fall = 0.0, start[1], step, end[1]
    for _ in range(TOP_LOOKS):
        place = (rise * high - fall * low) / (rise - fall)
        value, rate = look(what, place)
        bend = (rise - fall) / (high - low)
        greatest = max(greatest, value + 0.5 * rate * rate / bend)
        if rate > 0.0:
            low, rise = place, rate
        else:
            high, fall = place, rate
        if rate == 0.0 or not low < high:
            break
    return greatest


@inlined
def parabola_top(low, at, high, first, middle, last):
    """Where, from `low` to `high`, the parabola through three values is greatest; the `middle` one is the greatest."""
    rise, fall = (middle - first) / (at - low), (middle - last) / (high - at)
    top = at + 0.5 * (rise * (high - at) - fall * (at - low)) / (rise + fall)
    return min(max(top, low), high)


@template
def look_at_top(look, what, trail, step, last, greatest, rounds):
    """Where three ends of steps show a top not far below the `greatest` so far, looks at it so many times.

    `trail` (3,) has the values at both ends of the step before the last and its length [s]; it is moved on to the last,
    of `step` [s] with the value `last` at its end. `look(what, back, place)` is the value `place` [s] after the start
    of the last step, the one before being `back` long. Every look is at the parabola's top through the three places
    about the greatest value.
    """
    first, middle, back = trail[0], trail[1], trail[2]
    trail[0], trail[1], trail[2] = middle, last, step
    if middle >= first and middle > last and middle > NEAR_GREATEST * greatest and back > 0.0:
        low, at, high = -back, 0.0, step
        for _ in range(rounds):
            top = parabola_top(low, at, high, first, middle, last)
            found = look(what, back, top)
            if found <= middle or abs(top - at) <= SAME_TOP * (high - low):
                break
            if top > at:
                low, first = at, middle
            else:
                high, last = at, middle
            at, middle = top, found
