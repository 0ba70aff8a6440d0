"""When the model of a running simulation is looked at again, and what came of it."""

from collections import Counter
from collections.abc import Mapping

import numpy as np

from bearing_twin.kinds.contract import Kind
from bearing_twin.report import Choice, Rechosen
from bearing_twin.run.foretold import Account

APART_NS = 100_000_000  # from one look to the next, however many commands come


class Looks:
    """Looks at the model of one run: after a command, and once what was commanded is reached.

    `told` says what was switched last and why, or why not; "" where nothing else was ever chosen. From `since_ns` on
    the present choice is in use. `account` has what was foretold.
    """

    def __init__(self, kind: Kind, parameters, choice: Choice, motion):
        self.told, self.since_ns = "", 0
        self._left: Counter[str] = Counter()
        self._kind, self._parameters = kind, parameters
        self._last = Rechosen(choice, motion)
        self._from, self._commanded = 0, False
        self.account = Account(choice.predicted)
        self._notes: Mapping[str, np.ndarray] = {}
        self._noted: Mapping[str, np.ndarray] = {}

    def commanded(self, given: bool) -> None:
        """A command has come. `given`: something of the block computed last was given out, and its records with it."""
        self._commanded = self._kind.rechosen is not None
        if not given:
            self._notes, self._noted = self._noted, {}

    def again(self, time_ns: int, load: tuple, choice: Choice, motion) -> tuple[Choice, object]:
        """The choice and the motion from `time_ns` on, `load` being commanded; the same where no look is due."""
        if time_ns < self._from or not (self._commanded or self._last.settled()):
            return choice, motion
        self._commanded, self._from = False, time_ns + APART_NS
        self._last = found = self._kind.rechosen(self._parameters, choice, motion, load)
        self.since_ns = time_ns if found.choice != choice else self.since_ns
        self.told, self._notes = found.told or self.told, {**self._notes, **found.records}
        self._left.update(found.left)
        if found.choice.predicted != choice.predicted or found.motion is not motion:
            self.account.goes_on(found.choice.predicted, 1e-9 * time_ns, self.costs(found.motion))
        return found.choice, found.motion

    def costs(self, motion) -> dict[str, int]:
        """Costs of the run so far, `motion` being in use: also those of motions that it was switched from."""
        own = motion.costs()
        return own | {name: count + own.get(name, 0) for name, count in self._left.items()}

    def notes(self) -> dict[str, np.ndarray]:
        """Records of switches for the block that is computed now."""
        self._noted, self._notes = self._notes, {}
        return dict(self._noted)
