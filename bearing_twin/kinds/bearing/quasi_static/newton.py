"""Five coordinates (x, y, z, theta_x, theta_y) in balance, each held or free under its load: Newton's method, guarded.

Whose they are, a ring's or a shaft's, says the function of loads that is handed over.
"""

import math

import numpy as np

from bearing_twin.compiled import kernel, template

COORDINATES = 5
MOST_STEPS, MOST_TRIALS, MOST_LOOKS = 80, 40, 300  # what is found takes 226 looks at all balls at most, most 50
EXACT = 1e-11  # of the loads: what is left of the balance
ENOUGH = 1e-10  # of the loads: as above, where no step improves any more
ROUNDING = 4e-15  # of the opening: what the place of a ball is known to
SOFT = 1e-9  # of the greatest stiffness: what is softer counts as not held
FOUND, NOTHING_CARRIES, TOO_MUCH = range(3)


@kernel
def _solved(matrix, right, free, scales, step):
    """The Newton step of the free coordinates by elimination; False where something does not hold the ring.

    Rows and columns are scaled by `scales` [1 or m] and taken by the greatest pivot on the diagonal, as the matrix is
    nearly symmetric and has no negative direction; a soft pivot is lifted: what nothing holds stays where it is.
    """
    n = 0
    index = np.empty(COORDINATES, np.int64)
    for i in range(COORDINATES):
        step[i] = 0.0
        if free[i]:
            index[n] = i
            n += 1
    a = np.empty((COORDINATES, COORDINATES + 1))
    greatest = 0.0
    for i in range(n):
        for j in range(n):
            a[i, j] = matrix[index[i], index[j]] / (scales[index[i]] * scales[index[j]])
        a[i, n] = right[index[i]] / scales[index[i]]
        greatest = max(greatest, abs(a[i, i]))
    if greatest == 0.0:
        return False
    held = True
    for i in range(n):
        best = i
        for r in range(i + 1, n):
            if a[r, r] > a[best, best]:
                best = r
        if best != i:
            index[i], index[best] = index[best], index[i]
            for j in range(n + 1):
                a[i, j], a[best, j] = a[best, j], a[i, j]
            for r in range(n):
                a[r, i], a[r, best] = a[r, best], a[r, i]
        if a[i, i] < SOFT * greatest:
            held = False
            a[i, i] = greatest
        for r in range(i + 1, n):
            factor = a[r, i] / a[i, i]
            for j in range(i, n + 1):
                a[r, j] -= factor * a[i, j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            a[i, n] -= a[i, j] * a[j, n]
        a[i, n] /= a[i, i]
        step[index[i]] = a[i, n] / scales[index[i]]
    return held


@kernel
def _missing(wanted, load, free, scales, left):
    """What is missing of the wanted loads of the free coordinates into `left`; its size [N]."""
    size = 0.0
    for i in range(COORDINATES):
        left[i] = wanted[i] - load[i] if free[i] else 0.0
        size = max(size, abs(left[i]) / scales[i])
    return size


@kernel
def _work(step, left):
    """Work of the missing loads along a step: positive while going on lowers the energy."""
    total = 0.0
    for i in range(COORDINATES):
        total += step[i] * left[i]
    return total


@kernel
def moved_along(q, step, factor, out):
    """Coordinates a part of a step further, into `out`."""
    for i in range(COORDINATES):
        out[i] = q[i] + factor * step[i]


@kernel
def _size(q, scales):
    """The greatest coordinate as a displacement [m]."""
    greatest = 0.0
    for i in range(COORDINATES):
        greatest = max(greatest, abs(q[i]) * scales[i])
    return greatest


@kernel
def _stiffest(stiffness, scales):
    """The greatest stiffness against a displacement [N/m]."""
    greatest = 0.0
    for i in range(COORDINATES):
        greatest = max(greatest, abs(stiffness[i, i]) / (scales[i] * scales[i]))
    return greatest


@template
def coordinates_in_balance(loads_at, system, scales, rounding, free, wanted, longest, q, load, stiffness):
    """Moves the free coordinates to where `wanted` (5,) loads them; (status, what is left [N], scale of the loads [N]).

    `loads_at(system, q, load, stiffness)` fills `load` (5,) [N, N m] that holds the coordinates at `q` (5,) and its
    derivative (5, 5), and gives the loads' scale. `q` is the start and the answer, `free` (5,) tells which coordinates
    are. `scales` (5,) [1 or m] make displacements of tilts, `rounding` [m] is what a place is known to. No coordinate
    goes further than `longest` [m] from the middle.
    """
    step, left, trial = np.empty(COORDINATES), np.empty(COORDINATES), np.empty(COORDINATES)
    scale = loads_at(system, q, load, stiffness)
    size = _missing(wanted, load, free, scales, left)
    asked = 0.0
    for i in range(COORDINATES):
        asked = max(asked, abs(wanted[i]) / scales[i] if free[i] else 0.0)
    cap, looks = 0.05 * longest, 0
    for _ in range(MOST_STEPS):
        if size <= EXACT * max(asked, 1e-3 * scale) or size <= rounding * _stiffest(stiffness, scales):
            break
        held = _solved(stiffness, left, free, scales, step)
        length = _size(step, scales)
        if _work(step, left) <= 0.0 or length == 0.0:
            # nothing resists: along what is missing
            for i in range(COORDINATES):
                step[i] = left[i] / (scales[i] * scales[i]) / size * cap
            held, length = False, cap
        if length > cap:
            for i in range(COORDINATES):
                step[i] *= cap / length
        begin = _work(step, left)
        before, factor, low, high = size, 1.0, 0.0, math.inf
        for _ in range(MOST_TRIALS):
            looks += 1
            moved_along(q, step, factor, trial)
            if _size(trial, scales) > longest:
                return TOO_MUCH, size, scale
            scale = loads_at(system, trial, load, stiffness)
            size = _missing(wanted, load, free, scales, left)
            work = _work(step, left)
            if size < 0.7 * before or abs(work) <= 0.3 * begin:
                break
            if work > 0.0:
                low = factor
                if held:
                    break
            else:
                high = factor
            factor = 2.0 * factor if high == math.inf else 0.5 * (low + high)
        stalled = size >= before
        for i in range(COORDINATES):
            q[i] = trial[i]
        if looks >= MOST_LOOKS or (stalled and size <= ENOUGH * max(asked, 1e-3 * scale)):
            break
    carried = abs(load[0]) + abs(load[1]) + abs(load[2]) + abs(load[3]) + abs(load[4])
    if size > max(1e-9 * max(asked, 1e-3 * scale), rounding * _stiffest(stiffness, scales)):
        return TOO_MUCH, size, scale
    any_free = free[0] or free[1] or free[2] or free[3] or free[4]
    if any_free and carried == 0.0 and stiffness[0, 0] == 0.0 and stiffness[2, 2] == 0.0:
        return NOTHING_CARRIES, size, scale
    return FOUND, size, scale
