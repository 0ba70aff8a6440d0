"""Rows of numbers of LANES elements side by side, reached by name, so that loops over elements are vector instructions.

An array of rows is flat: its rows lie at fixed distances, which a compiler knows.
"""

from bearing_twin.compiled import inlined

LANES = 16  # elements computed side by side
GROUP = 4  # nodes taken together in the loops over lanes
XX, XY, YX, YY = range(4)  # rows of a gradient or of a stress
ENERGY, LEAST_DET, LEAST_STRAIN = range(3)  # rows of what is found
GRADIENT_SIZE, FOUND_SIZE, GROUP_SIZE = 4 * LANES, 3 * LANES, 2 * GROUP * LANES


@inlined
def get(rows, row, k):
    """The number in `row` of lane k."""
    return rows[row * LANES + k]


@inlined
def put(rows, row, k, value):
    """Writes the number in `row` of lane k."""
    rows[row * LANES + k] = value


@inlined
def increase(rows, row, k, value):
    """Adds to the number in `row` of lane k."""
    rows[row * LANES + k] += value


@inlined
def lessen(rows, row, k, value):
    """Keeps the lesser of the number in `row` of lane k and `value`."""
    rows[row * LANES + k] = min(rows[row * LANES + k], value)


@inlined
def of_row(rows, row):
    """All lanes of `row`."""
    return rows[row * LANES : (row + 1) * LANES]


@inlined
def of_group(rows, group):
    """The rows of x and y of the nodes of a group."""
    return rows[group * GROUP_SIZE : (group + 1) * GROUP_SIZE]
