"""A bearing in motion that is watched by a companion, and integrated again where that finds it off too far.

Each call of `advance` is verified at the windows the companion looks at. Where an output that is wanted is off by more
than SAFE of the tolerance, the call is done again with a tighter setting, which holds from then on: what was too rough
once is never tried again. The windows that failed are looked at again, whatever points to them then.
"""

import numpy as np

from bearing_twin.kinds.bearing.companion import Companion
from bearing_twin.kinds.bearing.deviations import Part
from bearing_twin.kinds.bearing.error_scales import STEP_SHARE
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.outputs import Rows
from bearing_twin.kinds.bearing.parameters import LEAST_TOLERANCE, BearingScene
from bearing_twin.kinds.bearing.pointing import POINTED
from bearing_twin.kinds.bearing.quasi_static.running import QuasiStaticMotion
from bearing_twin.kinds.bearing.rings import QUASI_STATIC
from bearing_twin.kinds.bearing.step_limits import FIXED_STEP
from bearing_twin.kinds.bearing.windows import PLACE, WINDOW, is_watched
from bearing_twin.numerics.steppers import ROSENBROCK, STEPPER_FACTS
from bearing_twin.report import Choice

SAFE = 0.5  # share of the tolerance that the windows looked at may be off: others may be worse
AIM = 0.25  # share of the tolerance that a tighter setting aims at
LEAST_CUT, MOST_CUT = 0.3, 0.01  # of the setting in one go
REDONE = 3  # times at most that a call is done again
VERIFIABLE = 10.0 * LEAST_TOLERANCE  # the least tolerance to which a companion can be tighter


def moving_by(parameters: BearingScene, choice: Choice):
    """What moves a bearing by the chosen model: equilibria, or balls by their equations of motion, watched or not."""
    if choice.stepper == QUASI_STATIC:
        return QuasiStaticMotion(parameters, choice)
    return (WatchedMotion if is_watched(parameters) else BearingMotion)(parameters, choice)


class WatchedMotion(BearingMotion):
    """As BearingMotion, with records of what a companion found."""

    def reset(self) -> None:
        """Back to the start, to the setting of the scene."""
        if not hasattr(self, "companion"):
            spent = STEP_SHARE * self.parameters.wanted.tolerance
            self.companion = Companion(self.parameters, self.scales / spent)
            self._asked = self.scales, self.step, self.partners.scales
        self.companion.reset()
        self._set(1.0)
        self._rows: list[np.ndarray] = []
        self._fresh: list[np.ndarray] = []
        self._again: dict[float, list] = {}
        super().reset()

    def ask(self, share: float) -> None:
        """Back to the start with a setting this many times looser; the tolerance that is kept stays."""
        scales, step, border = self._asked
        self._asked = share * scales, step, share * border
        self.reset()

    def _set(self, setting: float) -> None:
        """Takes steps that spend this share of what the scene allows them."""
        self.setting = setting
        scales, step, border = self._asked
        self.scales, self.partners = setting * scales, self.partners._replace(scales=setting * border)
        self.step = step * setting ** (1.0 / STEPPER_FACTS[self.stepper].order)

    def _follow(self) -> None:
        super()._follow()
        scales, _, border = self._asked
        self._asked = scales, self.step / self.setting ** (1.0 / STEPPER_FACTS[self.stepper].order), border

    @property
    def tolerance(self) -> float:
        """What the present setting stands for."""
        return self.setting * self.parameters.wanted.tolerance

    def _keep(self) -> None:
        super()._keep()
        self._known = self.companion.memory(), self.setting

    def take_back(self) -> None:
        """Back to before the last `advance`, with what was known then."""
        memory, setting = self._known
        self.companion.remember(memory)
        self._set(setting)
        self._rows, self._fresh = [], []
        super().take_back()

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        return super().snapshot() | {"companion": self.companion.memory(), "setting": self.setting}

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; the setting is kept where the scene is the same."""
        super().resume(kept)
        if "companion" in kept:
            self.companion.remember(kept["companion"])
            self._set(float(kept["setting"]))
            self._keep()

    def take_records(self) -> dict[str, np.ndarray]:
        """Windows of the companion since the last call."""
        rows, self._rows = self._rows, []
        return {WINDOW.name: np.concatenate(rows)} if rows else {}

    def costs(self) -> dict[str, int]:
        """As of BearingMotion, and the steps of the companion."""
        return super().costs() | {"companion_ball_steps": self.companion.steps}

    def advance(self, times: np.ndarray, duration: float) -> Rows:
        """As BearingMotion, done again with a tighter setting where the companion finds it off too far."""
        self._again = {}
        for _ in range(REDONE):
            self._fresh = []
            found = super().advance(times, duration)
            cut = self._cut()
            if cut == 1.0:
                break
            counts, steps, setting, again = self.counts.copy(), self.companion.steps, self.setting, self._again
            self.take_back()
            # What was in vain was computed all the same.
            self.counts[:], self.companion.steps = counts, steps
            self._again = again
            self._set(max(cut * setting, VERIFIABLE / self.parameters.wanted.tolerance))
        else:
            self._fresh = []
            found = super().advance(times, duration)
        self._rows.extend(row for row in self._fresh if len(row))
        return found

    def _cut(self) -> float:
        """By how much the setting is to be cut for what was found in this call; 1 where it will do."""
        rows = np.concatenate([*self._fresh, np.empty((0, len(WINDOW.columns)))])
        greatest = self.companion.greatest_load
        if not len(rows) or self.tolerance <= VERIFIABLE or greatest <= 0.0:
            return 1.0
        worst = max(rows[:, PLACE["load"]].max() / greatest, rows[:, PLACE["friction"]].max())
        wanted = self.parameters.wanted.tolerance
        if worst <= SAFE * wanted:
            return 1.0
        return min(LEAST_CUT, max(MOST_CUT, AIM * wanted / worst))

    def _pointer(self, instants: int) -> np.ndarray:
        """Room for what `pointing` notes, where the method does."""
        pointed = self.stepper in ROSENBROCK and self.parameters.wanted.tolerance >= VERIFIABLE
        return np.zeros((self.bearing.balls, instants, POINTED)) if pointed else super()._pointer(instants)

    def _look(self, part: Part) -> None:
        """Has the companion look at a part; its windows are kept, for the case that the call is done again."""
        if self.parameters.wanted.tolerance < VERIFIABLE or not len(part.times):
            return
        windows = self.companion.windows(part)
        known = self._again.setdefault(part.elapsed, [])
        known.extend(window for window in windows if window not in known)
        fixed = self.stepper in FIXED_STEP or not len(part.pointer)
        scales = self.scales if not fixed else self._asked[0]
        self._fresh.append(self.companion.look(part, known, scales, self.tolerance))
