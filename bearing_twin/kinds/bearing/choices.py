"""Switches of the model while a bearing runs, as they are recorded, told and found again in a log."""

from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.motions import COUPLED, motions_of, unmeasured
from bearing_twin.kinds.bearing.parameters import LOADS
from bearing_twin.kinds.bearing.rings import PRESCRIBED, QUASI_STATIC, dimension_of
from bearing_twin.numerics.names import stepper_names
from bearing_twin.report import Choice
from bearing_twin.sample import Channel, Table

GREATEST_JUMP = 0.01  # of the greatest load: where loads would jump by more, the model stays
CHOICE = Table(
    "choice",
    (
        Channel("time", "s", (), "when the model was looked at again, after a command"),
        Channel("speed", "rad/s", (), "of the inner ring then"),
        Channel("goal", "rad/s", (), "speed that the inner ring goes to"),
        Channel("before", "1", (), "stepper in use: its number in `solver.stepper`, from 1; 0 = equilibria"),
        Channel("stepper", "1", (), "the same, of what was chosen"),
        Channel("setting", "1", (), "tolerance that the chosen stepper is given"),
        Channel("jump", "1", (), "greatest change of a load by the switch, over the greatest load"),
    ),
    "another model was chosen in a running scene; it was taken unless loads would have jumped by more than 0.01",
    needed=False,
)


def may_switch(parameters) -> bool:
    """Whether a command can make another choice of a scene: of the stepper by tables, of the dimension for loads alone.

    A ring that follows loads has but one dimension, and what no table holds one stepper.
    """
    if dimension_of(parameters) != PRESCRIBED:
        return False
    still = parameters.model.dimension == "auto" and parameters.wanted.outputs == LOADS
    alone = not unmeasured(parameters) and not set(COUPLED).intersection(motions_of(parameters))
    return still or (parameters.solver.stepper == "auto" and alone)


class Switch(NamedTuple):
    """A row of CHOICE: `before` and `stepper` are names."""

    time: float
    speed: float
    goal: float
    before: str
    stepper: str
    setting: float
    jump: float

    @property
    def taken(self) -> bool:
        """Whether the model was switched; a NaN jumps too far."""
        return self.jump <= GREATEST_JUMP

    def row(self) -> np.ndarray:
        """As numbers, (1, columns)."""
        names = (QUASI_STATIC, *stepper_names())
        numbers = self._replace(before=names.index(self.before), stepper=names.index(self.stepper))
        return np.array([numbers], float)

    def sentence(self) -> str:
        """What was switched, when and why."""
        where = "" if self.stepper == QUASI_STATIC else f" at a tolerance of {self.setting:g}"
        chosen, jumped = f"{self.stepper}{where}", f"{100.0 * self.jump:.2g} % of the greatest"
        why = f"at {self.speed:.6g} rad/s"
        if self.goal != self.speed:
            why = f"told to go from {self.speed:.6g} to {self.goal:.6g} rad/s"
        former = self.before if self.before != self.stepper else "the former one"  # of tolerances
        if self.taken:
            return f"from {self.time:.9g} s on {chosen} in place of {former}, {why}; loads jumped by {jumped}"
        return (
            f"at {self.time:.9g} s {chosen} would have been taken in place of {former}, {why}; loads would have "
            f"jumped by {jumped}, more than {100.0 * GREATEST_JUMP:g} %, so {former} stayed"
        )


def switches_of(rows: np.ndarray) -> list[Switch]:
    """The switches in rows of CHOICE; rows of other versions, or that name no stepper there is, are left out."""
    names, found = (QUASI_STATIC, *stepper_names()), []
    for row in rows:
        if len(row) == len(CHOICE.columns) and all(0 <= one < len(names) for one in row[3:5]):
            time, speed, goal, before, stepper, setting, jump = map(float, row)
            found.append(Switch(time, speed, goal, names[int(before)], names[int(stepper)], setting, jump))
    return found


class Switches:
    """Switches of a run, in memory that does not grow: how many, the last that was `taken`, the last `refused`."""

    def __init__(self):
        self.taken: Switch | None = None
        self.refused: Switch | None = None
        self.counts = [0, 0]
        self.steppers: set[str] = set()

    def add(self, rows: np.ndarray) -> None:
        """Takes rows of CHOICE in."""
        for one in switches_of(rows):
            self.counts[one.taken] += 1
            if one.taken:
                self.taken = one
                self.steppers |= {one.before, one.stepper}
            else:
                self.refused = one

    def after(self, choice: Choice) -> Choice:
        """The choice of the start, as it became by the switches that were taken."""
        if self.taken is None:
            return choice
        reason = f"{choice.reason}; {self._told(self.taken)}"
        return choice._replace(stepper=self.taken.stepper, setting=self.taken.setting, reason=reason)

    @property
    def doubt(self) -> str | None:
        """What to say where a model stayed that would not have been chosen; None where none did."""
        return self.refused and self._told(self.refused)

    def _told(self, switch: Switch) -> str:
        count = self.counts[switch.taken]
        return switch.sentence() + (f" (the last of {count} times)" if count > 1 else "")
