"""What loads are off at outputs inside long steps, read off the balance of forces there.

Where a step is longer than a ball takes to swing between its raceways, the ball is in balance with them, and its
acceleration is known from how its velocity changes from output to output. An interpolant between the ends of such a
step misses that balance: what is left over of the forces on the ball is what its loads are off, to 1 % or so. Nothing
is integrated for it. No window shows it so: its own start lies on an interpolant.
"""

import math

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.kinds.bearing.companion.deviations import Part
from bearing_twin.kinds.bearing.companion.windows import BETWEEN, PLACE, WINDOW
from bearing_twin.kinds.bearing.forces.layout import AXIS_DISTANCE, ORBIT_ANGLE, TANGENTIAL_VELOCITY, VELOCITY
from bearing_twin.kinds.bearing.parameters import BearingScene
from bearing_twin.kinds.bearing.rings import FREE_RING, dimension_of
from bearing_twin.kinds.bearing.stepping.pointing import STEPS_IN

SWING = 2.0 * np.pi  # rad: steps shorter than such a period are made for the swing itself, where nothing is in balance
SURE = 0.8  # of the tolerance: what is known so exactly is done again only above it
MOST = 100  # outputs of a part that are looked at: those in the longest steps, whose interpolants err most


def in_longest_steps(part: Part) -> np.ndarray:
    """Which outputs (MOST at most) are looked at."""
    if len(part.times) <= MOST or not len(part.pointer):
        return np.arange(len(part.times))
    return np.sort(np.argsort(part.pointer[..., STEPS_IN].min(axis=0), kind="stable")[:MOST])


@kernel
def _left_over(given, times, here, bears, load, approach, angle, force, states, begun, counts, off):
    """Fills `off` (n, balls) where `bears` and steps are long; `counts` (balls, T) are those of steps up to outputs.

    `load` to `force` have the outputs `here` (n,) alone, `states` and `counts` all.
    """
    mass, inner, outer, gravity_x, gravity_y = given
    last = len(times) - 1
    if last == 0:  # here and not before, so that a run of one output compiles what longer ones need
        return
    for row, now in enumerate(here):
        ahead = min(now + 1, last)
        past = times[now] - (times[now - 1] if now > 0 else 0.0)
        following = times[ahead] - (times[ahead - 1] if ahead > 0 else 0.0)
        share = past / (past + following)
        for ball in range(load.shape[1]):
            deep = approach[row, ball]
            one = inner * load[row, ball, 0] / deep[0] if deep[0] > 0.0 else 0.0
            two = outer * load[row, ball, 1] / deep[1] if deep[1] > 0.0 else 0.0
            swing = math.sqrt((one + two) / mass)  # rad/s
            long = swing * past >= SWING * counts[ball, now] and swing * following >= SWING * counts[ball, ahead]
            if not (bears[row, ball] and long):
                continue
            state = states[now, ball]
            before = states[now - 1, ball, VELOCITY] if now > 0 else begun[ball, VELOCITY]
            change = (state[VELOCITY] - before) / past
            if now < last:  # of second order between unlike intervals
                later = (states[ahead, ball, VELOCITY] - state[VELOCITY]) / following
                change = share * later + (1.0 - share) * change
            cosine, sine = math.cos(state[ORBIT_ANGLE]), math.sin(state[ORBIT_ANGLE])
            along = cosine * force[row, ball, 0] + sine * force[row, ball, 1]
            pulled = cosine * gravity_x + sine * gravity_y
            speed = state[TANGENTIAL_VELOCITY]
            left = along + mass * (pulled + speed * speed / state[AXIS_DISTANCE] - change)
            leant = math.cos(angle[row, ball, 0]), math.cos(angle[row, ball, 1])
            one, two = one * leant[0], two * leant[1]
            off[row, ball] = abs(left) * max(one, two) / (one * leant[0] + two * leant[1])


def off_balance(part: Part, moves: bool, here: np.ndarray) -> np.ndarray:
    """How far loads (n, balls) [N] are off at outputs number `here` (n,), the greater one of a ball.

    It is 0 where this says nothing, as where a ring moves with its balls: they swing with it for longer than a step.
    """
    outputs, balls = part.load.shape[:2]
    off = np.zeros((len(here), balls))
    if moves or not len(part.pointer):
        return off
    bears = np.ones((len(here), balls), bool)
    if not part.all_bear or part.near.any():
        carried = part.carried
        if part.near.any():
            touched = part.out["neighbour_load"] != 0.0
            carried = carried & ~(touched | np.roll(touched, 1, axis=1))
        bears = carried[np.maximum(here - 1, 0)] & carried[here] & carried[np.minimum(here + 1, outputs - 1)]
        if not bears.any():
            return off
    bearing, out = part.bearing, part.out
    given = bearing.ball_mass, bearing.inner.law.power, bearing.outer.law.power, *bearing.gravity[:2]
    # Copies of these rows are alike to a kernel, rows of one output and of many are not.
    channels = part.load[here], *(out[name][here] for name in ("approach", "contact_angle", "raceway_force"))
    moving = part.filled[0], part.begun[0], part.pointer[..., STEPS_IN]
    _left_over(tuple(map(float, given)), part.times, here, bears, *channels, *moving, off)
    return off


def between_steps(parameters: BearingScene, part: Part, tolerance: float) -> np.ndarray:
    """A row of WINDOW with what loads are off between steps; none where nothing is."""
    off = float(off_balance(part, dimension_of(parameters) == FREE_RING, in_longest_steps(part)).max(initial=0.0))
    rows = np.zeros((int(off > 0.0), len(WINDOW.columns)))
    rows[:, : PLACE["friction"]] = part.elapsed + part.duration, part.elapsed, BETWEEN, 0.0, tolerance, off
    return rows
