"""Explicit Runge-Kutta steps, their control and what lies inside them, for any system whose state is a row of numbers.

A kind hands over functions; they and these are compiled into the kind's own kernels, so that nothing is called through
a pointer and the code is kept.
"""

import math

from bearing_twin.compiled import inlined, template
from bearing_twin.numerics.statuses import EVALUATIONS, REJECTIONS
from bearing_twin.numerics.steppers import next_step


@inlined
def copy_numbers(source, target):
    """Writes the numbers of one array into another; `target[:] = source` compiles texts of errors, too."""
    for n in range(len(source)):
        target[n] = source[n]


@template
def runge_kutta_step(method, rates, system, state, step, loaded, moving, work, out):
    """Writes the state `step` [s] later to `out`; returns the error as a root mean square in units of `work.scales`.

    `rates(system, state, loaded, slopes)` fills the slopes of the first `moving` numbers of a state; the others stay.
    `loaded` says whether bodies can press. `work` has room for `stages` (stages, len(state)) and a `trial` state. The
    error is zero for a method without an estimate.
    """
    stages = len(method.weights)
    for i in range(stages):
        copy_numbers(state, work.trial)
        for j in range(i):
            weight = step * method.a[i, j]
            if weight != 0.0:
                for n in range(moving):
                    work.trial[n] += weight * work.stages[j, n]
        rates(system, work.trial, loaded, work.stages[i])
    copy_numbers(state, out)
    fifth = third = 0.0
    for n in range(moving):
        change = wide = narrow = 0.0
        for i in range(stages):
            change += method.weights[i] * work.stages[i, n]
            wide += method.error[i] * work.stages[i, n]
            narrow += method.third[i] * work.stages[i, n]
        out[n] += step * change
        fifth += (wide / work.scales[n]) ** 2
        third += (narrow / work.scales[n]) ** 2
    if fifth == 0.0:
        return 0.0
    return step * fifth / math.sqrt((fifth + 0.01 * third) * moving)


@template
def longest_step(one_step, system, method, state, wanted, least, loaded, work, counts):
    """The longest step up to `wanted` [s] whose error is at most 1; returns (step, the next to try).

    `one_step(system, method, state, step, loaded, work, work.after)` takes one and returns its error. The step is
    negative where one of `least` [s] or shorter is still too long.
    """
    step = wanted
    while True:
        error = one_step(system, method, state, step, loaded, work, work.after)
        following = next_step(step, error, method.order)
        counts[EVALUATIONS] += len(work.stages)
        if error <= 1.0:
            return step, following
        counts[REJECTIONS] += 1
        if not step > least:
            return -1.0, step
        step = following
