"""Windows of a bearing run that a companion integrates again: where they lie, and what is recorded of them."""

from bisect import bisect_left, bisect_right
from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.rings import EVEN, FREE_RING, POCKETS, QUASI_STATIC, dimension_of
from bearing_twin.sample import Channel, Table

ALL = -1  # in place of the number of a ball
APART = -2  # the same: all of them, in a copy of the run that starts apart by what it is off
INHERITED = -3  # the same: all of them, by what they are off from before any window
UNKNOWN = -4  # the same: all of them, after meetings that nobody looked at, where such make errors grow
BETWEEN = -5  # the same: all of them, at outputs inside steps, by the balance of forces there
BESIDE = -6  # the same: all of them, of what goes beside a run whose balls bump: with all that the run inherits
WHOSE = {
    ALL: "all balls together",
    APART: "a copy that starts apart by what the run is off, before balls meet",
    INHERITED: "what balls and ring are off from before",
    UNKNOWN: "meetings of balls that no copy looked at",
    BETWEEN: "outputs inside steps",
    BESIDE: "all balls together, with what bumps carry on",
}
LEAST_STEPS = 10  # of the run in a window
SLID = 3.0  # times that: as far back a window of a ball that slides begins, see `since_begun`
BUMPING = 30.0  # times what windows see of balls that bump into each other or a cage: they miss 90 to 98 %

WINDOW = Table(
    "companion",
    (
        Channel("time", "s", (), "end of the window"),
        Channel("begin", "s", (), "of the window"),
        Channel("ball", "1", (), "-1 = all, -2 = apart, -3 = inherited, -4 = unknown, -5 = inside, -6 = with bumps"),
        Channel("steps", "1", (), "of a ball that the companion took"),
        Channel("tolerance", "1", (), "that the run had in this piece"),
        Channel("load", "N", (), "error of a load on a raceway"),
        Channel("friction", "1", (), "error of friction, over what it could be: mu N of a contact, mu N R of a ball"),
        Channel("torque", "N m", (), "error of the raceways' torque on a ball"),
        Channel("contact_angle", "rad", (), "error of a contact angle"),
        Channel("orbit_angle", "rad", (), "how far a ball is off its way round at the end"),
        Channel("orbit_speed", "rad/s", (), "error of a ball's speed about the axis"),
        Channel("roll_rate", "rad/s", (), "error of a ball's roll rate"),
        Channel("drive_torque", "N m", (), "error of the drive's work on a ball (mean of all), over the angle turned"),
        Channel("loss", "W", (), "error of the power lost at a ball (mean of all), mean over the window"),
        Channel("ring_displacement", "m", (), "error of the place of the inner ring's centre"),
        Channel("ring_force", "N", (), "error of the force of the balls on the inner ring"),
        Channel("mean_torque", "N m", (), "error of the mean torque of the raceways on a ball, with its sign"),
    ),
    "a window of the run that a companion with a tighter tolerance integrated again; greatest errors in it",
    needed=False,
)
PLACE = {column.name: place for place, column in enumerate(WINDOW.columns)}


def is_watched(parameters) -> bool:
    """Whether a companion goes with the run of a scene."""
    return parameters.solver.companion == "on" and dimension_of(parameters) != QUASI_STATIC


def bumps(parameters) -> bool:
    """Whether balls bump into a cage: what the motion is off grows with each bump."""
    return parameters.cage.kind == POCKETS


def carries(parameters) -> bool:
    """Whether a ring moves with its balls, which do not bump: what it is off it carries on until that is damped."""
    return dimension_of(parameters) == FREE_RING and not bumps(parameters)


def unseen(parameters) -> float:
    """How many times what a window of all balls sees the motion may be off: by what they inherit from before it.

    Balls that an even cage alone couples inherit no more than those on their own; what a moving ring makes them
    inherit has rows of its own (`inherited`).
    """
    coupled = carries(parameters) or parameters.cage.kind == EVEN
    return BUMPING if bumps(parameters) or not coupled else 1.0


def place_of(row) -> str:
    """Whose window a row of WINDOW is, from when to when."""
    ball = int(row[PLACE["ball"]])
    return f"{WHOSE.get(ball, f'ball {ball}')}, {row[PLACE['begin']]:.6g} s to {row[0]:.6g} s"


class Window(NamedTuple):
    """Outputs `begin` + 1 to `begin` + `length` of a part, for one ball, or for all where `ball` is -1."""

    ball: int
    begin: int
    length: int


def steps_before(steps: np.ndarray) -> list[float]:
    """Steps (outputs,) before each output and before the end, by those in each."""
    return [0.0, *np.cumsum(steps).tolist()]  # steps are whole numbers: their sums are exact in any order


def window_at(ball: int, cell: int, before: list[float]) -> Window:
    """The window of LEAST_STEPS that ends one output behind `cell`; at the beginning of a part it grows forwards.

    `before` is that of `steps_before`.
    """
    outputs = len(before) - 1
    end = min(cell + 2, outputs)
    begin = max(bisect_right(before, before[end] - LEAST_STEPS, 0, cell + 1) - 1, 0)
    enough = bisect_left(before, before[begin] + LEAST_STEPS)
    end = max(end, min(enough, outputs))
    return Window(ball, begin - 1, end - begin)


def since_begun(window: Window, before: list[float]) -> Window:
    """The window of a ball that slides, from where its part begins if that is at most SLID times the least steps.

    What its slip is off adds up while it slides, and is not seen from where the run has got to. `before` is that of
    `steps_before`.
    """
    end = window.begin + 1 + window.length
    return Window(window.ball, -1, end) if before[end] <= SLID * LEAST_STEPS else window


def steps_in(window: Window, row: int, steps: np.ndarray) -> float:
    """Steps that the run took in a window, by `steps` (balls or 1, outputs) in that row, or in all."""
    inside = slice(window.begin + 1, window.begin + 1 + window.length)
    return float(steps[slice(None) if window.ball == ALL else slice(row, row + 1), inside].sum())


def off_by(rows: np.ndarray, greatest: float, loads_alone: bool = False) -> float:
    """The greatest error in a row of WINDOW, or rows: of load over the `greatest` [N], and of friction if it counts."""
    if not len(rows):
        return 0.0
    found = rows[..., PLACE["load"] : PLACE["torque"]]
    load, friction = (found if rows.ndim == 1 else found.max(axis=0)).tolist()
    load /= greatest
    return load if loads_alone else max(load, friction)


def within(window: Window, other: Window) -> bool:
    """Whether another window of the same ball holds all of this one."""
    ends = window.begin + window.length <= other.begin + other.length
    return window.ball == other.ball and window.begin >= other.begin and ends


def overlap(window: Window, other: Window) -> bool:
    """Whether two windows have an output in common, of whatever balls."""
    return window.begin < other.begin + other.length and other.begin < window.begin + window.length
