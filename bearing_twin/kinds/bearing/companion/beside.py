"""Stretches of a bearing run integrated again beside it, with a tighter tolerance: single balls, or all together."""

import numpy as np

from bearing_twin.kinds.bearing.companion.departures import room, starts
from bearing_twin.kinds.bearing.companion.deviations import Found, Part
from bearing_twin.kinds.bearing.companion.meetings import meetings, pairs_in
from bearing_twin.kinds.bearing.companion.windows import Window
from bearing_twin.kinds.bearing.outputs import empty_outputs, outputs_alone, write_outputs
from bearing_twin.kinds.bearing.stepping.integrate import Chunk, integrated
from bearing_twin.kinds.bearing.stepping.rosenbrock import ChunkTask, rosenbrock_chunk
from bearing_twin.numerics.statuses import OK, STEPS
from bearing_twin.numerics.steppers import ROSENBROCK

METHOD = "rodas4"  # of the companion, whatever the run's
TIGHTER = 0.3  # of the run's tolerance: what the companion errs by itself is as great a share, and is added


def some_beside(part: Part, group: list[Window], scales, last=None, until: float | None = None) -> Found | None:
    """Single balls side by side, from the run's states or from the `last` of the companion; None if one fails.

    `until` [s] in the part they go on, without it to the end of the windows.
    """
    first, count = group[0], len(group)
    start, length = part.start(first.begin), first.length
    times = part.times[first.begin + 1 : first.begin + 1 + length] - start
    begun, borders = starts(part, group)
    moving = begun if last is None else tuple(array.copy() for array in last[:4])
    results = room(length, count, moving[3], borders[0])
    drive, bearing = part.drive_from(start), part.bearing
    duration = float(times[-1]) if until is None else until - start
    task = ChunkTask(ROSENBROCK[METHOD], bearing, drive, times, duration, TIGHTER * scales)
    if rosenbrock_chunk(task, (), np.arange(count), *moving[:3], results) != OK:
        return None
    out = outputs_alone(bearing, drive, times, results.states, results.orientations, borders)
    return Found(out, results.states, (*moving, borders[0]), int(results.counts[STEPS]))


def all_beside(parameters, part: Part, window: Window, scales, last=None, until: float | None = None) -> Found | None:
    """As `some_beside`, of all balls with ring and cage in one window."""
    start, length, balls = part.start(window.begin), window.length, len(part.near)
    times = part.times[window.begin + 1 : window.begin + 1 + length] - start
    moving, borders = starts(part, [Window(ball, window.begin, length) for ball in range(balls)])
    moving = (*moving, borders[0].copy()) if last is None else tuple(array.copy() for array in last)
    moving[2][:] = moving[2].min()
    results, partners = room(length, balls, moving[3], moving[4]), part.partners
    partners = partners._replace(load=partners.load + start * partners.load_rate, scales=TIGHTER * partners.scales)
    drive = part.drive_from(start)
    duration = float(times[-1]) if until is None else until - start
    near = part.near if partners.active else pairs_in(window, meetings(part))
    chunk = Chunk(part.bearing, drive, partners, near, times, duration, 0.0, TIGHTER * scales)
    if integrated(METHOD, chunk, moving[:3], results) != OK:
        return None
    out = empty_outputs(parameters, length)
    filled = results.states, results.orientations, results.border
    write_outputs(parameters, part.bearing, partners, drive, times, *filled, out.numbers, 0)
    return Found(out, results.states, moving, int(results.counts[STEPS]))
