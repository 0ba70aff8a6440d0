"""Where within a step something happens: between a place before it and one after it, and at the top of a curve."""

from bearing_twin.compiled import inlined, template

MOST_HALVINGS = 100


@template
def halved(before, what, longest, width):
    """Halves 0 to `longest` about an event until `width` is left; returns (last before it, first after, last tried).

    `before(what, place)` says whether a place lies before the event; 0 does and `longest` does not.
    """
    low, high, middle = 0.0, longest, 0.5 * longest
    for _ in range(MOST_HALVINGS):
        middle = 0.5 * (low + high)
        if before(what, middle):
            low = middle
        else:
            high = middle
        if not high - low > width:
            break
    return low, high, middle


@inlined
def parabola_top(low, at, high, first, middle, last):
    """Where, from `low` to `high`, the parabola through three values is greatest; the `middle` one is the greatest."""
    rise, fall = (middle - first) / (at - low), (middle - last) / (high - at)
    top = at + 0.5 * (rise * (high - at) - fall * (at - low)) / (rise + fall)
    return min(max(top, low), high)
