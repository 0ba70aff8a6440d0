"""A ring that is thrown across its clearance, and what that makes of errors: by a more exact motion from before it.

Each blow of such a ring against its balls makes an error grow, by as much as no window shows and nobody knows before.
Much of it was made by steps before the throw, in what direction nobody can guess. So a more exact motion sets out in
what the run went through as long before as its ring rings (`earlier`), and is at the throw where the run should be. It
goes on until the ring lies, the last ball has landed, and what the run is off fades: a ring may still knock to and fro
then, and before it balls that hop make errors grow as well, which need not be known where the run is off too far
already. Its difference from the run is all that the run is off: by what it had from before, and by its steps. No window
of all balls says more.
"""

from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.companion.beside import TIGHTER, all_beside
from bearing_twin.kinds.bearing.companion.deviations import Found, Part, deviations, lengths
from bearing_twin.kinds.bearing.companion.earlier import Earlier, ringing_time
from bearing_twin.kinds.bearing.companion.redoing import CARRIED
from bearing_twin.kinds.bearing.companion.windows import ALL, Window, carries
from bearing_twin.kinds.bearing.parameters import LOADS, BearingScene
from bearing_twin.sample import Columns

FAR = 4  # times as long as a ring falls and knocks it is followed, and as long again where ...
FADED = 1.0 / 3.0  # ... in the last third of that it is off by more than this share of the most


def unheld(part: Part) -> np.ndarray:
    """Whether contacts leave more than half of a ring's load unheld (outputs,): half way from resting to falling."""
    at, partners = np.asarray(part.times)[:, None], part.partners
    load = (partners.load + partners.weight + at * partners.load_rate)[:, :3]
    return 2.0 * lengths(load + part.out["inner_ring_force"]) > lengths(load)


def thrown(part: Part) -> bool:
    """Whether a ring is thrown across its clearance: some ball then touches neither raceway at an output.

    A ball may also hop on the outer raceway while the ring lies still, or slides round. So at some output the ring's
    load must be `unheld`, too.
    """
    return part.flies and bool(unheld(part).any())


class Throw(NamedTuple):
    """What such a motion showed: errors, as behind `tolerance` in a row of WINDOW, in which window, what was found."""

    errors: np.ndarray
    window: Window
    found: Found

    @property
    def load(self) -> float:
        """The error of load [N]."""
        return float(self.errors[0])

    @property
    def friction(self) -> float:
        """The error of friction, over mu N."""
        return float(self.errors[1])

    def over(self, parameters, greatest: float) -> float:
        """The greatest error of what is wanted, over the tolerance; `greatest` load [N] so far."""
        friction = 0.0 if parameters.wanted.outputs == LOADS else self.friction
        return max(self.load / greatest, friction) / parameters.wanted.tolerance


class Witness:
    """A more exact motion beside a part in which a ring is thrown, from `last` (as `Found.last`) on, where it begins.

    `steps` were taken until then. It goes on as far as it is asked for, with the `scales` of the run's steps.
    """

    def __init__(self, last: tuple[np.ndarray, ...], steps: int, scales: np.ndarray):
        self.last, self.steps, self.scales = last, steps, scales
        self._seen: list[Found] = []

    def beside(self, parameters, part: Part, greatest: float) -> Throw | None:
        """What it shows of a run through the part; None where it breaks off. `greatest` load [N] so far."""
        reached, end, told = sum(len(one.states) for one in self._seen), len(part.times), 0
        until = max(min(FAR * (1 + int(np.flatnonzero(unheld(part))[-1])), end), reached)
        while True:
            if until > reached:
                window = Window(ALL, reached - 1, until - reached)
                found = all_beside(parameters, part, window, self.scales, self.last)
                if found is None:
                    return None
                self._seen.append(found)
                self.last, self.steps, reached = found.last, self.steps + found.steps, until
            whole, found = Window(ALL, -1, until), _joined(self._seen)._replace(steps=self.steps)
            errors = np.abs(deviations(part, whole, found, greatest))
            throw = Throw(errors / (1.0 - TIGHTER), whole, found)
            enough = throw.over(parameters, greatest) > CARRIED or not part.in_flight[until:].any()
            if until == end or (enough and _faded(part, whole, found, (until - told) // 3, greatest, errors)):
                return throw
            told, until = until, min(2 * until, end)


class Throws:
    """Goes beside a run through the parts in which its ring is thrown; `earlier` is what it went through before."""

    def __init__(self, parameters: BearingScene):
        self.parameters = parameters
        self.earlier = Earlier(parameters.geometry.balls)
        self._witness: Witness | None = None

    def passed(self, part: Part, greatest: float) -> None:
        """Takes in a part that the run went through; `greatest` load [N] so far."""
        self.earlier.passed(part, ringing_time(self.parameters, part.bearing, greatest))

    def through(self, part: Part, scales: np.ndarray, again: bool, greatest: float) -> tuple[Throw | None, int]:
        """What a more exact motion shows of a part, from before it on, and its steps; None of one without a throw.

        None as well where it breaks off. Where the part is done `again`, the motion beside the go before is a witness
        still, unless that go was off by so much that this may itself be off by more than is wanted.
        """
        self.passed(part, greatest)
        if not carries(self.parameters) or not thrown(part):
            return None, 0
        spent, kept = 0, self._witness if again else None
        if kept:
            witness, spent = kept, -kept.steps
        else:
            begun = self.earlier.beside(part, scales)
            witness = begun and Witness(*begun, scales)
        found = witness and witness.beside(self.parameters, part, greatest)
        self._witness = witness if found and (kept or found.over(self.parameters, greatest) <= CARRIED) else None
        return found, spent + witness.steps if witness else 0


def _joined(seen: list[Found]) -> Found:
    """What was found in stretches one behind the other, as of one."""
    out, states = (np.concatenate(those) for those in ([one.out.numbers for one in seen], [one.states for one in seen]))
    return Found(Columns(seen[-1].out.layout, out), states, seen[-1].last, sum(one.steps for one in seen))


def _faded(part: Part, window: Window, found: Found, last: int, greatest: float, errors: np.ndarray) -> bool:
    """Whether at so many `last` outputs of a window the run is off by much less than by these `errors`."""
    if not last:
        return False
    found = found._replace(out=found.out.rows(slice(-last, None)), states=found.states[-last:])
    window = window._replace(begin=window.begin + window.length - last, length=last)
    return bool((np.array(deviations(part, window, found, greatest)[:2]) <= FADED * errors[:2]).all())
