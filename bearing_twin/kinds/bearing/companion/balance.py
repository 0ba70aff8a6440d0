"""What loads are off at outputs inside long steps, read off the balance of forces there.

Where a step is longer than a ball takes to swing between its raceways, the ball is in balance with them, and its
acceleration is known from how its velocity changes from output to output. An interpolant between the ends of such a
step misses that balance: what is left over of the forces on the ball is what its loads are off, to 1 % or so. Nothing
is integrated for it. No window shows it so: its own start lies on an interpolant.
"""

import numpy as np

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


def off_balance(part: Part, moves: bool, here: np.ndarray) -> np.ndarray:
    """How far loads (n, balls) [N] are off at outputs number `here` (n,), the greater one of a ball.

    It is 0 where this says nothing, as where a ring moves with its balls: they swing with it for longer than a step.
    """
    outputs, balls = part.load.shape[:2]
    nothing = np.zeros((len(here), balls))
    if moves or not len(part.pointer) or outputs < 2:
        return nothing
    behind, ahead = np.maximum(here - 1, 0), np.minimum(here + 1, outputs - 1)
    bears = np.ones((len(here), balls), bool)
    if not part.all_bear or part.near.any():
        carried = (part.load > 0.0).all(axis=-1)
        if part.near.any():
            touched = part.out["neighbour_load"] != 0.0
            carried &= ~(touched | np.roll(touched, 1, axis=1))
        bears = carried[behind] & carried[here] & carried[ahead]
        if not bears.any():
            return nothing
    out, load, states = part.out, part.load[here], part.filled[0][here]
    mass = part.bearing.ball_mass
    powers = np.array([part.bearing.inner.law.power, part.bearing.outer.law.power])
    approach = out["approach"][here]
    stiffness = powers * load / np.where(approach > 0.0, approach, np.inf)
    times, rate = np.concatenate([[0.0], part.times]), np.sqrt(stiffness.sum(axis=-1) / mass)  # rad/s of a swing
    past, next_one = (times[one + 1] - times[one] for one in (here, ahead))  # s to the output, and from it to the next
    for one, lasts in ((here, past), (ahead, next_one)):
        bears &= rate * lasts[:, None] >= SWING * part.pointer[:, one, STEPS_IN].T
    last = (ahead == here)[:, None]
    velocity = states[..., VELOCITY]
    before = np.where((here == 0)[:, None], part.begun[0][None, :, VELOCITY], part.filled[0][behind, :, VELOCITY])
    rise = (velocity - before) / past[:, None]
    later = (part.filled[0][ahead, :, VELOCITY] - velocity) / next_one[:, None]
    share = (past / (past + next_one))[:, None]
    changes = np.where(last, rise, share * later + (1.0 - share) * rise)  # of second order between unlike intervals
    turned, speed = states[..., ORBIT_ANGLE], states[..., TANGENTIAL_VELOCITY]
    outwards = np.cos(turned), np.sin(turned)
    force = out["raceway_force"]
    along = sum(one * force[here, ..., axis] for axis, one in enumerate(outwards))
    pulled = sum(one * part.bearing.gravity[axis] for axis, one in enumerate(outwards))
    left = along + mass * (pulled + speed * speed / states[..., AXIS_DISTANCE] - changes)
    leant = np.cos(out["contact_angle"][here])
    shares = stiffness * leant
    taken = shares.max(axis=-1) / np.where(bears, (shares * leant).sum(axis=-1), np.inf)
    return np.abs(left) * taken


def between_steps(parameters: BearingScene, part: Part, tolerance: float) -> np.ndarray:
    """A row of WINDOW with what loads are off between steps; none where nothing is."""
    off = float(off_balance(part, dimension_of(parameters) == FREE_RING, in_longest_steps(part)).max(initial=0.0))
    rows = np.zeros((int(off > 0.0), len(WINDOW.columns)))
    rows[:, : PLACE["friction"]] = part.elapsed + part.duration, part.elapsed, BETWEEN, 0.0, tolerance, off
    return rows
