"""What points to the errors of a bearing run, ball by ball and output by output."""

import math
from collections.abc import Mapping

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.companion.deviations import Part, lengths
from bearing_twin.kinds.bearing.companion.windows import ALL, LEAST_STEPS, PLACE, Window, place_of
from bearing_twin.kinds.bearing.stepping.pointing import OF_FORCE, OF_TORQUE, STEPS_IN
from bearing_twin.kinds.doubt import Dearest

POINTERS, SLIDING = 3, 2  # error of force, error of torque, friction over load, see `pointers`; place of the last
MOST = 2  # windows looked at for each, whatever the length of the run, unless later ones exceed them
ALWAYS = POINTERS * MOST * LEAST_STEPS  # steps of those windows together
ALIKE = 0.8  # of what points most: a ball with as much may be looked at in place of those that others point to
EVEN = 0.3  # of the steps that any takes: balls that take so many each move alike


def pointers(part: Part, least: float) -> tuple[np.ndarray, np.ndarray]:
    """What points to errors, of force [N], torque over N, friction over N (POINTERS, balls or 1, outputs), and steps.

    Over no less than the `least` load [N]. The third is by how much an error of slip changes friction, where a ball
    neither slides, as friction is then known, nor rolls, as errors of slip are then forgotten. Balls that are coupled
    have one row, and in place of it how much an error of force [m/s^2] changes friction, over load [N].
    """
    load, pointer, together = part.load, part.pointer if len(part.pointer) else bends(part.out), part.partners.active
    grids = np.zeros((POINTERS, 1 if together else load.shape[1], len(load)))
    if together:
        _point_together(pointer, load, part.friction, least, grids[:, 0])
        return grids, pointer[..., STEPS_IN].max(axis=0)[None]
    _point_alone(pointer, load, part.friction, float(part.bearing.friction_coefficient), least, grids)
    return grids, np.ascontiguousarray(pointer[..., STEPS_IN])


@kernel
def _point_alone(pointer, load, friction, coefficient, least, grids):
    """Fills the `grids` (POINTERS, balls, outputs) of balls on their own."""
    for ball in range(len(pointer)):
        for output in range(len(load)):
            inner, outer = load[output, ball]
            slides = max(friction[output, ball, 0] / max(inner, least), friction[output, ball, 1] / max(outer, least))
            if coefficient > 0.0:
                share = min(slides / coefficient, 1.0)
                rest = 1.0 - share * share
                slides *= rest * math.sqrt(rest)  # the slope of friction over slip, in units of that at rest
            grids[0, ball, output] = pointer[ball, output, OF_FORCE]
            grids[1, ball, output] = pointer[ball, output, OF_TORQUE] / max(inner + outer, least)
            grids[SLIDING, ball, output] = slides


@kernel
def _point_together(pointer, load, friction, least, grids):
    """Fills the `grids` (POINTERS, outputs) of balls that are coupled, with what is greatest of all balls."""
    for output in range(len(load)):
        for ball in range(len(pointer)):
            inner, outer = load[output, ball]
            values, force = grids[:, output], pointer[ball, output, OF_FORCE]
            values[0] = max(values[0], force)
            values[1] = max(values[1], pointer[ball, output, OF_TORQUE] / max(inner + outer, least))
            for side in range(2):
                bears = max(load[output, ball, side], least)
                # What an error of force does to friction: most where a contact that slides bears little, as behind a
                # lift-off.
                felt = force / (load[output, ball, side] if load[output, ball, side] > 0.0 else bears)
                values[SLIDING] = max(values[SLIDING], friction[output, ball, side] / bears * felt)


@kernel
def _foremost(grids, points, places):
    for one in range(len(grids)):
        grid, mine, where, last = grids[one], points[one], places[one], points.shape[1] - 1
        for row in range(len(grid)):
            for cell in range(grid.shape[1]):
                value, at = grid[row, cell], last
                if not value > mine[last]:  # a NaN is none
                    continue
                while at > 0 and value > mine[at - 1]:
                    mine[at], where[at] = mine[at - 1], where[at - 1]
                    at -= 1
                mine[at], where[at] = value, row * grid.shape[1] + cell


def foremost(grids: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` greatest numbers of each of the `grids` (n, rows, outputs), the greatest first, and where they stand.

    Both (n, count), the second in a flat grid; of equal numbers the first comes first. Where there are fewer, -inf.
    """
    points, places = np.full((len(grids), count), -np.inf), np.zeros((len(grids), count), np.int64)
    _foremost(grids, points, places)
    return points, places


def dearest(row: np.ndarray, balls: int) -> Dearest:
    """What the row of WINDOW with most steps of a ball took, in a bearing of so many balls."""
    steps = int(row[PLACE["steps"]]) * (balls if row[PLACE["ball"]] < 0 else 1)
    return Dearest(steps, place_of(row), balls, ALWAYS)


def spare(best: np.ndarray, tops: list[float]) -> float:
    """How many times greater errors of force and torque would still be less than the `best`, which were looked at.

    `tops` are the greatest that each pointer says.
    """
    seen = zip(best[:SLIDING], tops[:SLIDING], strict=True)
    return min(float(least.min()) / max(top, 1e-300) for least, top in seen)


def bends(out: Mapping[str, np.ndarray]) -> np.ndarray:
    """How much force and torque on each ball bend at each output, and steps there: what a method without errors has.

    (balls, outputs, POINTED); a bend is the greater of the changes at both ends, LEAST_STEPS the steps.
    """
    found = []
    for array in (out["raceway_force"], out["raceway_torque"]):
        change = lengths(np.diff(array, axis=0, prepend=array[:1], append=array[-1:]))
        found.append(np.maximum(change[1:], change[:-1]).T)
    return np.stack([*found, np.full(found[0].shape, float(LEAST_STEPS))], axis=-1)


def one_for_all(windows: list[Window], grids: np.ndarray, steps: np.ndarray) -> list[Window]:
    """One window of a ball through the whole part in place of several, where that takes fewer steps and shows as much.

    `grids` and `steps` are of `pointers`, which must point to that ball nearly as much as to any.
    """
    if len(windows) < 2 or any(one.ball == ALL for one in windows):
        return windows
    like = np.min([np.ones(len(steps)), *(grid.max(axis=1) / grid.max() for grid in grids if grid.any())], axis=0)
    ball, taken = int(np.argmax(like)), 0.0
    for one in windows:
        taken += float(steps[one.ball, one.begin + 1 : one.begin + 1 + one.length].sum())
    each = steps.sum(axis=1)
    alike = like[ball] >= ALIKE and each.min() >= EVEN * each.max()
    return [Window(ball, -1, steps.shape[1])] if alike and each[ball] < taken else windows
