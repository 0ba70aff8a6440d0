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


def _at_both(those: np.ndarray) -> np.ndarray:
    """Where it holds (outputs, balls) at an output and at those before and behind it."""
    both = those.copy()
    both[1:] &= those[:-1]
    both[:-1] &= those[1:]
    return both


def off_balance(part: Part, moves: bool) -> np.ndarray:
    """How far loads (outputs, balls) [N] are off, the greater one of a ball; 0 where this says nothing.

    That is where the ring moves with its balls, which has them swing with it for longer than a step.
    """
    load, out, states = part.load, part.out, part.filled[0]
    nothing = np.zeros(load.shape[:2])
    if moves or not len(part.pointer) or len(part.times) < 2:
        return nothing
    bears = (load > 0.0).all(axis=-1)
    if part.near.any():
        touched = out["neighbour_load"] != 0.0
        bears &= ~(touched | np.roll(touched, 1, axis=1))
    bears = _at_both(bears)
    if not bears.any():
        return nothing
    times, mass = np.concatenate([[0.0], part.times]), part.bearing.ball_mass
    powers = np.array([part.bearing.inner.law.power, part.bearing.outer.law.power])
    approach = out["approach"]
    stiffness = powers * load / np.where(approach > 0.0, approach, np.inf)
    swing = np.sqrt(stiffness.sum(axis=-1) / mass) * np.diff(times)[:, None]  # rad from output to output
    bears &= _at_both(swing >= SWING * part.pointer[:, :, STEPS_IN].T)
    velocity = np.concatenate([part.begun[0][None, :, VELOCITY], states[..., VELOCITY]])
    changes = np.gradient(velocity, times, axis=0)[1:]
    turned, speed = states[..., ORBIT_ANGLE], states[..., TANGENTIAL_VELOCITY]
    outwards = np.cos(turned), np.sin(turned)
    force = out["raceway_force"]
    along = sum(one * force[..., axis] for axis, one in enumerate(outwards))
    pulled = sum(one * part.bearing.gravity[axis] for axis, one in enumerate(outwards))
    left = along + mass * (pulled + speed * speed / states[..., AXIS_DISTANCE] - changes)
    leant = np.cos(out["contact_angle"])
    shares = stiffness * leant
    taken = shares.max(axis=-1) / np.where(bears, (shares * leant).sum(axis=-1), np.inf)
    return np.abs(left) * taken


def between_steps(parameters: BearingScene, part: Part, tolerance: float) -> np.ndarray:
    """A row of WINDOW with what loads are off between steps; none where nothing is."""
    off = float(off_balance(part, dimension_of(parameters) == FREE_RING).max(initial=0.0))
    rows = np.zeros((int(off > 0.0), len(WINDOW.columns)))
    rows[:, : PLACE["friction"]] = part.elapsed + part.duration, part.elapsed, BETWEEN, 0.0, tolerance, off
    return rows
