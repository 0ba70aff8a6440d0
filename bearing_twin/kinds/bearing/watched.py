"""A bearing in motion that is watched by a companion, and integrated again where that finds it off too far.

Each part of a chunk is verified at the windows the companion looks at. Where it makes an output that is wanted off by
more than a third of the tolerance (`redoing`), it is done again with a tighter setting, and the windows that failed are
looked at again, whatever points to them then. The setting gets rougher again after some parts whose windows are off by
much less, or where all points to smaller errors than those had; what was too rough once is never tried again. Where
errors of earlier parts grew, as balls bounced or met, or are carried on by a ring, the whole chunk is done again. Where
a tighter setting finds the same, the motion itself is that sensitive: the error is told, and the setting goes back.
Beyond the run's horizon steps are made for statistics alone.
"""

import math

import numpy as np

from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.bearing.companion import redoing
from bearing_twin.kinds.bearing.companion.balance import SURE, between_steps
from bearing_twin.kinds.bearing.companion.companion import Companion
from bearing_twin.kinds.bearing.companion.deviations import Part
from bearing_twin.kinds.bearing.companion.earlier import ringing_time
from bearing_twin.kinds.bearing.companion.growth import EVER
from bearing_twin.kinds.bearing.companion.inherited import NOTHING, all_of_it, carried_on, remembered
from bearing_twin.kinds.bearing.companion.windows import ALL, APART, INHERITED, PLACE, WINDOW, bumps, carries, unseen
from bearing_twin.kinds.bearing.error_scales import STEP_SHARE
from bearing_twin.kinds.bearing.motion import BearingMotion
from bearing_twin.kinds.bearing.parameters import LEAST_TOLERANCE
from bearing_twin.kinds.bearing.snapshots import MOVING
from bearing_twin.kinds.bearing.stepping.pointing import POINTED
from bearing_twin.kinds.bearing.stepping.step_limits import FIXED_STEP
from bearing_twin.numerics.statuses import STEPS
from bearing_twin.numerics.steppers import ROSENBROCK, STEPPER_FACTS

SHORT = 0.02  # s: the first part of a run, those after it are longer each, so that little is done again ...
LONGER = (2.0, 1.5)  # ... by so many times; with a ring that carries on what it is off, where more is done again
DOUBLED = 40  # times: beyond any chunk, and far from the end of floats, which a node reaches within minutes
BEGUN = "drive", "goal_speed", "elapsed", "_acceleration", "_load", "_load_rate", "_inherited"  # what a part changes
VERIFIABLE = 10.0 * LEAST_TOLERANCE  # the least tolerance to which a companion can be tighter


class WatchedMotion(BearingMotion):
    """As BearingMotion, with records of what a companion found."""

    def reset(self) -> None:
        """Back to the start, to the setting of the scene."""
        if not hasattr(self, "companion"):
            spent = STEP_SHARE * self.given
            self.companion = Companion(self.parameters, self.scales / spent)
            self._carries, self._bumps = carries(self.parameters), bumps(self.parameters)
            self._unseen = unseen(self.parameters)
            self._asked, self.setting = (self.scales, self.partners.scales), 1.0
        self.companion.reset()
        self._set(1.0)
        self._rows: list[np.ndarray] = []
        self._found: np.ndarray | None = None
        self._added = self._before_it = np.zeros((0, len(WINDOW.columns)))
        self._chunk_begun = self._part_begun = 0.0
        self._may_retake = self._first_go = self._eventful = self._thrown = False
        self._grown, self._sensitive, self._roughest, self._calm = 0.0, False, 1.0, 0
        self._inherited = NOTHING
        super().reset()

    def _set(self, setting: float) -> None:
        """Takes steps that spend this share of what the scene allows them."""
        scales, border = self._asked
        self.step *= (setting / self.setting) ** (1.0 / STEPPER_FACTS[self.stepper].order)
        self.scales, self.partners = setting * scales, self.partners._replace(scales=setting * border)
        self.setting = setting

    @property
    def tolerance(self) -> float:
        """What the present setting stands for."""
        return self.setting * self.given

    def _keep(self) -> None:
        super()._keep()
        self._known = self.companion.memory(), self.setting, self._roughest, self._calm, self._inherited

    def take_back(self) -> None:
        """Back to before the last `advance`, with what was known then."""
        memory, setting, self._roughest, self._calm, self._inherited = self._known
        self.companion.remember(memory)
        self._set(setting)
        self._rows = []
        super().take_back()

    def snapshot(self) -> dict:
        """The state as plain data; see `resume`."""
        known = {"companion": self.companion.memory(), "setting": self.setting, "sensitive": self._sensitive}
        known |= {"roughest": self._roughest, "calm_parts": self._calm, "inherited": list(self._inherited)}
        return super().snapshot() | known

    def resume(self, kept: dict) -> None:
        """To a state that `snapshot` gave; the setting is kept where the scene is the same."""
        super().resume(kept)
        if "companion" in kept:
            self.companion.remember(kept["companion"])
            self._set(redoing.setting_of(kept["setting"]))
            self._sensitive, self._calm = bool(kept["sensitive"]), int(kept["calm_parts"])
            self._roughest = redoing.setting_of(kept["roughest"])
            self._inherited = remembered(kept["inherited"])
            self._keep()

    def take_records(self) -> dict[str, np.ndarray]:
        """Windows of the companion since the last call."""
        rows, self._rows = self._rows, []
        return {WINDOW.name: np.concatenate(rows)} if rows else {}

    def take_rows(self, other: "WatchedMotion") -> None:
        """Takes over windows of another motion, which goes on as this one, that nobody has taken."""
        self._rows, other._rows = other._rows, []

    def costs(self) -> dict[str, int]:
        """As of BearingMotion, and the steps of the companion."""
        return super().costs() | {"companion_ball_steps": self.companion.steps}

    def advance(self, times, duration):
        """As of BearingMotion, once more with a tighter setting where errors grew too far from part to part.

        Bounces and meetings of balls make them grow. Where it does not help, it is not tried again in a run.
        """
        last, before, earlier, reached = math.inf, self.setting, self._rows.copy(), -math.inf
        self._chunk_begun = self.elapsed
        for attempt in range(1 + redoing.RETAKEN):
            self._grown, self._may_retake = 0.0, attempt < redoing.RETAKEN and not self._sensitive
            out, further = None, False
            try:
                out = super().advance(times, duration)
                worst, horizon = self._grown, self.companion.horizon
                further, reached = reached < horizon < EVER and not self.companion.diverged, horizon
            except redoing.CarriedOn as carried:
                worst, further, reached = carried.worst, carried.since > reached, carried.since
            except IntegrationError:
                if not attempt:
                    raise
                return self._given_up(earlier, before, times, duration)
            tight = self.setting
            kept = out is not None and worst <= redoing.CARRIED
            if kept or not self._may_retake or tight * self.given <= VERIFIABLE:
                break
            if worst >= redoing.HELPED * last and not further:
                back = max(tight, min(before, redoing.FUTILE))
                if out is None:
                    return self._given_up(earlier, back, times, duration)
                self._sensitive = True
                self._set(back)
                break
            last = worst
            self._retake(earlier, max(redoing.cut_by(worst) * tight, VERIFIABLE / self.given))
        return out

    def _given_up(self, rows, setting: float, times, duration):
        """The chunk with this setting, whatever it is off: tighter ones do not help in this run."""
        self._sensitive, self._may_retake = True, False
        self._retake(rows, setting)
        return super().advance(times, duration)

    def _retake(self, rows, setting: float) -> None:
        """Back to before a chunk, with another setting; what was spent counts, and what meetings make of an error."""
        spent, watching = self.counts.copy(), (self.companion.steps, self.companion.looked, self.companion.grew)
        self.take_back()
        self.counts[:], self._rows = spent, rows.copy()
        self.companion.steps, self.companion.looked, self.companion.grew = watching
        # A ring forgets in time what it was off, and may take longer steps again.
        self._roughest, self._calm = redoing.SPARED * self.setting if self._carries else setting, 0
        self._set(setting)

    def _part(self, times, duration, out, first) -> None:
        """As of BearingMotion, done again with a tighter setting where the companion finds it off too far."""
        arrays, others = {name: getattr(self, name).copy() for name in MOVING}, [getattr(self, name) for name in BEGUN]
        before_it, self._windows, begun = self.companion.inherited(), None, self.elapsed
        if not len(times):
            before = self.setting
            self._set(max(redoing.UNSEEN * before, min(before, VERIFIABLE / self.given)))
            super()._part(times, duration, out, first)
            self._set(before)
            return
        self._part_begun, spent, dear = begun, int(self.counts[STEPS]), 0
        within, lost = self.setting, self._lost
        if lost:
            self._set(redoing.BEYOND)
        # A ball that is followed since before is not bettered: a sign, no more, of a rough setting.
        before, worst, since = self.setting, math.inf, -math.inf if self.setting > redoing.FUTILE else self.elapsed
        for attempt in range(1 + redoing.REDONE):
            self._first_go = not attempt
            try:
                super()._part(times, duration, out, first)
            except IntegrationError:
                if not attempt:
                    raise
                # Nothing can be integrated as tightly: as before, which is known to be off.
                self._begin_again(arrays, others, before_it, before)
                super()._part(times, duration, out, first)
                break
            last, worst = worst, self._worst(since)
            dear = dear or redoing.MOST_SPENT * (self.counts[STEPS] - spent)
            eventful = self._eventful and not self._bumps  # whose errors no setting spares
            ends = redoing.enough(worst, attempt, eventful) or self.companion.diverged or lost
            ends, futile = ends or self.counts[STEPS] - spent > dear, attempt and worst >= redoing.HELPED * last
            if self._thrown and (ends or futile):  # steps before the part made what is left
                self._stop_carrying(self._added)
            if futile and not ends:
                self._set(max(self.setting, min(before, redoing.FUTILE)))
            if ends or futile:
                break
            before, cut = self.setting, redoing.cut_by(worst)
            self._roughest, self._calm = min(self._roughest, redoing.SPARED * before), 0
            self._begin_again(arrays, others, before_it, max(cut * self.setting, VERIFIABLE / self.given))
        if lost:
            self._set(within)
        rows, self._found = self._found, None
        stand = []
        if rows is not None and self.companion.unlooked < math.inf:
            stand = [all_of_it(self.elapsed, self.tolerance, *self.companion.unknown)]
        self._relax(rows if rows is None else rows[rows[:, PLACE["begin"]] >= begun])
        if rows is not None:
            rows = self.companion.go_beside(*self._looked_at, (self.state, self.border), rows)
            if not (self._bumps or lost):
                self._grown = max(self._grown, self.companion.off(redoing.carried(rows, begun)))
        stand += [] if rows is None or not len(rows) else [rows]
        self.companion.stands(stand)
        self._rows += stand

    @property
    def _lost(self) -> bool:
        """Whether a part begins beyond the run's horizon: its steps are for statistics alone."""
        return self._part_begun >= self.companion.horizon

    def _stop_carrying(self, carried: np.ndarray) -> None:
        """Ends a chunk that is off too far by what it carried into this part, in rows of WINDOW."""
        stops = self._may_retake and self._part_begun > self._chunk_begun and self.tolerance > VERIFIABLE
        if stops and not self._lost and self.companion.off(carried) > redoing.CARRIED and not self._bumps:
            raise redoing.CarriedOn(self.companion.off(self._before_it), self._part_begun)

    def _relax(self, rows: np.ndarray | None) -> None:
        """Takes longer steps again after PATIENT parts with such windows, or with none that was worth a look."""
        spare = self.companion.spare
        if rows is not None and len(rows):
            whole = rows[:, PLACE["ball"]] == ALL
            worst = max(self.companion.off(rows[~whole]), self._unseen * self.companion.off(rows[whole]))
            spare = redoing.CALM / max(worst, 1e-300)
        self._calm = self._calm + 1 if spare > redoing.NOTABLE else 0
        if self._calm > redoing.PATIENT and self.setting < self._roughest and not self._sensitive:
            self._set(min(self._roughest, min(spare, redoing.RELAXED) * self.setting))
            self._calm = 0

    def _begin_again(self, arrays, others, inherited, setting: float) -> None:
        """Back to the beginning of a part, with another setting."""
        vars(self).update(zip(BEGUN, others, strict=True))
        for name, array in arrays.items():
            getattr(self, name)[:] = array
        self.companion.inherit(inherited)
        self._set(setting)

    def _until_next(self, duration: float) -> float:
        longer = LONGER[self._carries] ** min(self.companion.parts, DOUBLED)
        return min(super()._until_next(duration), SHORT * longer)

    def _worst(self, since: float) -> float:
        """The greatest error found in this part over the wanted tolerance, of windows begun since then [s].

        0 where no tighter setting could be verified. What bumps make of an error says nothing of the setting.
        """
        if self._found is None or self.tolerance <= VERIFIABLE:
            return 0.0
        rows = self._added
        if self._bumps:
            rows = rows[rows[:, PLACE["ball"]] != INHERITED]
        rows = rows[(rows[:, PLACE["begin"]] >= since) & (rows[:, PLACE["ball"]] != APART)]
        return self.companion.off(redoing.weighed(rows, self._eventful, self._carries))

    def _pointer(self, instants: int) -> np.ndarray:
        """Room for what `pointing` notes, where the method does."""
        pointed = instants and self.stepper in ROSENBROCK and self.parameters.wanted.tolerance >= VERIFIABLE
        return np.zeros((self.bearing.balls, instants, POINTED)) if pointed else super()._pointer(instants)

    def _look(self, part: Part) -> None:
        """Has the companion look at a part; its windows are kept, for the case that the call is done again."""
        if self.parameters.wanted.tolerance < VERIFIABLE or not len(part.times):
            self.companion.throws.passed(part, self.companion.greatest_load)
            return
        if self._windows is None:
            self._windows = self.companion.windows(part)
        else:
            self._windows = self.companion.windows_again(part, self._windows)
        scales = self.scales if self.stepper not in FIXED_STEP and len(part.pointer) else self._asked[0]
        self._looked_at, self._eventful = (part, scales, self.tolerance), not part.all_bear
        throw, greatest = self.companion.throw(part, scales, not self._first_go), self.companion.greatest_load
        self._thrown = throw is not None
        found = self.companion.look(part, self._windows if throw is None else [], scales, self.tolerance)
        added, self._before_it = found, found[:0]
        if len(found) or self._carries:
            ringing, drift = ringing_time(self.parameters, self.bearing, greatest), self.companion.drift.angle.max()
            what = part, found, self.tolerance, ringing, drift, greatest, self.companion.apart, throw
            found, added, self._before_it, self._inherited = carried_on(self._inherited, *what)
        between = between_steps(self.parameters, part, self.tolerance, greatest)
        self._found = np.concatenate([found, between])
        self._added = np.concatenate([added, between]) if self.companion.off(between) > SURE else added
        if self._first_go:
            self._stop_carrying(self._before_it[:1])
