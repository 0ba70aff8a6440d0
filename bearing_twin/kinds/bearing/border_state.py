"""Copies of the state of ring and cage and of its rates, number by number: slices might want room of their own."""

from bearing_twin.compiled import inlined
from bearing_twin.kinds.bearing.layout import BORDER


@inlined
def copy_border(source, target):
    """Copies a state, or its rates."""
    for i in range(BORDER):
        target[i] = source[i]


@inlined
def border_slope(share, border):
    """Turns the rates kept in `slope`, that share of a step later, into h times their explicit change with time."""
    for i in range(BORDER):
        border.slope[i] = (border.slope[i] - border.rates[i]) / share
