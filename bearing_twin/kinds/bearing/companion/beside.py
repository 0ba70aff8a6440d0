"""Stretches of a bearing run integrated again beside it, with a tighter tolerance: single balls, or all together."""

from functools import partial

import numpy as np

from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.bearing.companion.departures import all_start, room, starts
from bearing_twin.kinds.bearing.companion.deviations import Found, Part, drive_later
from bearing_twin.kinds.bearing.companion.windows import Window
from bearing_twin.kinds.bearing.meeting_parts import PartBalls, integrate_alone
from bearing_twin.kinds.bearing.outputs import empty_outputs, outputs_alone, write_outputs
from bearing_twin.kinds.bearing.stepping.integrate import Chunk, check, integrated
from bearing_twin.kinds.bearing.stepping.rosenbrock import ChunkTask, rosenbrock_chunk
from bearing_twin.numerics.statuses import OK, STEPS
from bearing_twin.numerics.steppers import ROSENBROCK
from bearing_twin.numerics.stretches import Stretches

METHOD = "rodas4"  # of the companion, whatever the run's
TIGHTER = 0.3  # of the run's tolerance: what the companion errs by itself is as great a share, and is added


def some_beside(part: Part, group: list[Window], scales, last=None, until: float | None = None) -> list[Found | None]:
    """Windows of single balls side by side, from the run's states; None for one that fails.

    Where the drive accelerates they begin together. A single one may go on from the `last` of the companion. `until`
    [s] in the part they go on, without it to the ends of the windows.
    """
    begins = [part.start(one.begin) for one in group]
    instants = [part.times[one.begin + 1 : one.begin + 1 + one.length] for one in group]
    instants = [those - begin for those, begin in zip(instants, begins, strict=True)]
    ends = [float(those[-1]) for those in instants] if until is None else [until - begin for begin in begins]
    lengths = np.array([one.length for one in group])
    after, times = np.cumsum(lengths), np.concatenate(instants)
    begun, borders = starts(part, group)
    moving = begun if last is None else tuple(array.copy() for array in last[:4])
    results, drive, bearing = room(len(times), 1, moving[3], borders[0]), part.drive_from(begins[0]), part.bearing
    task = ChunkTask(ROSENBROCK[METHOD], bearing, drive, times, max(ends), TIGHTER * scales)
    own = Stretches(np.array(ends), after - lengths, after, np.zeros_like(lengths))
    if rosenbrock_chunk(task, (), np.arange(len(group)), *moving[:3], results, own) != OK:
        return [None] if len(group) == 1 else [some_beside(part, [one], scales, None, until)[0] for one in group]
    held = np.repeat(borders, lengths, axis=0)
    out, found = outputs_alone(bearing, drive, times, results.states, results.orientations, held), []
    for place, steps in enumerate(own.taken.tolist()):
        rows = slice(own.first[place], own.after[place])
        ended = (*(array[place : place + 1] for array in moving), borders[0])
        found.append(Found(out.rows(rows), results.states[rows], ended, steps))
    return found


def _integrate(bearing, drive, partners, scales, moving, results, near, begin, times, duration, filled) -> np.ndarray:
    """Moves all balls on from `begin` [s] of a window; see `integrate_alone`."""
    states, orientations, border = filled
    into = results._replace(states=states, orientations=orientations, border=border)
    chunk = Chunk(bearing, drive_later(drive, begin), partners, near, times, duration, 0.0, scales)
    check(integrated(METHOD, chunk, moving[:3], into), begin, results.failure)
    return results.pointer


def all_beside(parameters, part: Part, window: Window, scales, last=None, until: float | None = None) -> Found | None:
    """All balls with ring and cage in one window, as `some_beside`; None if that fails."""
    start, length, near = part.start(window.begin), window.length, part.near
    times = part.times[window.begin + 1 : window.begin + 1 + length] - start
    if last is None:
        balls_begin, border = all_start(part, window.begin, length)
        moving = (*balls_begin, border)
    else:
        moving = tuple(array.copy() for array in last)
    moving[2][:] = moving[2].min()
    results, partners = room(length, len(near), moving[3], moving[4]), part.partners
    partners = partners._replace(load=partners.load + start * partners.load_rate, scales=TIGHTER * partners.scales)
    drive = part.drive_from(start)
    duration = float(times[-1]) if until is None else until - start
    filled = results.states, results.orientations, results.border
    go_on = partial(_integrate, part.bearing, drive, partners, TIGHTER * scales, moving, results)
    try:
        if partners.active:
            go_on(near, 0.0, times, duration, filled)
        else:
            balls = PartBalls(part.bearing.ball_radius, np.zeros_like(near), list(moving))
            integrate_alone(go_on, balls, times, duration, filled)
    except IntegrationError:
        return None
    out = empty_outputs(parameters, length)
    write_outputs(parameters, part.bearing, partners, drive, times, *filled, out.numbers, 0)
    return Found(out, results.states, moving, int(results.counts[STEPS]))
