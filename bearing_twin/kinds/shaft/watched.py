"""A shaft with a finer motion of it beside it, both of which take commands."""

from types import MappingProxyType

import numpy as np

from bearing_twin.kinds.second_run import HEAD, SHARE, WithSecondRun

REPLACED = (
    *("_now", "_followed", "_kept", "_told", "_following", "_records", "_first", "_row", "_left_with", "_figures"),
    *("_short", "_times", "_earlier", "_changed"),
)
"""What an `advance` replaces, but for what it adds to figures."""
SHORT = 300  # steps of the finer motion in a short run, and after a change
MOST = 20  # changes after which the finer motion always follows anew for a while; later ones as it has steps to spare


class WatchedShaft(WithSecondRun):
    """As `WithSecondRun`, of motions that go back by a chunk when they are told something within it.

    A finer motion that was left follows anew, from where the first one is, when speed or load change: errors of figures
    are then those it had and what is found anew.
    """

    def _begin(self) -> None:
        super()._begin()
        self._short, self._times, self._earlier = SHORT, 0, 0.0
        self._before, self._changed = MappingProxyType({}), False

    @property
    def seconds(self) -> float:
        """Simulated time so far [s]."""
        return self._motion.seconds

    @property
    def goal_speed(self) -> float:
        """The speed [rad/s] that the shaft is told to go to."""
        return self._motion.goal_speed

    @goal_speed.setter
    def goal_speed(self, speed: float) -> None:
        self._motion.goal_speed = self._finer.goal_speed = speed
        self._changed = True

    def set_load(self, force, moment) -> None:
        """New loads at `shaft.load_place` [N], [N m] from now on, or the scene's own where both are None."""
        self._motion.set_load(force, moment)
        self._finer.set_load(force, moment)
        self._changed = True

    def advance(self, times: np.ndarray, duration: float):
        """Moves both on; the outputs are the first one's.

        What goes back and is made again is asked for its end alone: figures are gathered of all outputs until then.
        """
        rate = self._parameters.run.output_rate
        outputs = round(duration * rate)
        again = len(times) == 1 and times[0] == duration and outputs > 1
        every = np.arange(1, outputs + 1) / rate if again else times
        self._before = {name: getattr(self, name) for name in REPLACED}
        self._figures = tuple(figures.copy() for figures in self._figures)
        if not self._following and (self._changed or self._motion.changes(duration)):
            self._follow_anew()
        found = super().advance(every, duration)
        self._changed = False
        return found.rows(slice(-1, None)) if again else found

    def _follow_anew(self) -> None:
        steps, own = self._finer.costs()["steps"], self._motion.costs()["steps"]
        if self._times >= MOST and steps > SHARE * own:
            return
        self._times += 1
        self._short = steps + SHORT if self._times <= MOST else self._short
        if self._row is not None:
            self._earlier = self._row_at(self._now)[self._errors]
        self._finer.go_on_from(self._motion)
        self._figures = self._figures[0], self._figures[0].copy()
        self._following, self._told = True, 0.0

    @property
    def _errors(self) -> slice:
        """Where a row has the errors of figures."""
        return slice(len(HEAD) + len(self._watch.outputs), None)

    def _compare(self, until: float) -> None:
        super()._compare(until)
        self._row[self._errors] += self._earlier

    def take_back(self) -> None:
        """Back to before the last `advance`: what that found is in no figure."""
        super().take_back()
        vars(self).update(self._before)
