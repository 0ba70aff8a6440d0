"""An action server that counts the goals which were sent to it and never came, and takes the others in order."""

import threading
from collections import deque
from collections.abc import Callable

from rclpy.action import ActionServer

from bearing_twin.nodes.recording import Sequences


class Arrivals:
    """Counts goals that never arrived, by the numbers which the middleware of whoever asks gives requests, from 1 on.

    It does not tell whose number it is: of several clients at a time nothing can be said, and `known` is False from
    then on. What was sent before the first that arrived is not counted: the server may not have been there.
    """

    def __init__(self):
        self.known = True
        self._numbers = Sequences()

    @property
    def lost(self) -> int:
        """Goals so far that did not arrive."""
        return self._numbers.lost

    def saw(self, number: int, clients: int) -> int:
        """Notes a goal; returns how many were lost just before it, 0 where nobody knows."""
        self.known = self.known and clients <= 1
        return self._numbers.saw(number, 1) if self.known else 0


class Rush:
    """Counts goals that were answered so fast after each other that whoever asked may have missed the answer.

    A client keeps KEPT answers, as rclpy does by default, and gives up older ones that it has not taken within PERIOD.
    No node learns which, so those beyond are in doubt.
    """

    KEPT, PERIOD = 10, 2.0  # s

    def __init__(self):
        self.doubted = 0
        self._times: deque[float] = deque(maxlen=self.KEPT)

    def saw(self, now: float) -> bool:
        """Notes a goal that is answered at `now` [s]; returns whether its answer, or one just before, is in doubt."""
        full = len(self._times) == self.KEPT and now - self._times[0] < self.PERIOD
        self._times.append(now)
        self.doubted += full
        return full


class InOrder:
    """Hands things to `take` in the order in which places were given out, whichever is there first; from any thread."""

    def __init__(self, take: Callable):
        self._take, self._lock = take, threading.Lock()
        self._there: dict[int, object] = {}
        self._given = self._next = 0

    def place(self) -> int:
        """The next place."""
        with self._lock:
            self._given += 1
            return self._given - 1

    def put(self, place: int, thing) -> None:
        """Says what stands at a place: None for nothing."""
        with self._lock:
            self._there[place] = thing
            while self._next in self._there:
                thing = self._there.pop(self._next)
                self._next += 1
                if thing is not None:
                    self._take(thing)


class CountedActionServer(ActionServer):
    """As rclpy's; `arrived(number)` is told the number of every goal that is taken, from the executor's thread.

    What `accepted(goal_handle)` makes of a goal is handed to `take` in the order in which goals arrived: rclpy answers
    before it hands a goal over, and threads may pass each other.
    """

    def __init__(self, *arguments, arrived: Callable[[int], None], accepted: Callable, take: Callable, **options):
        self._made: dict[bytes, object] = {}
        self._order = InOrder(take)
        options["handle_accepted_callback"] = lambda handle: self._made.update({_key(handle): accepted(handle)})
        super().__init__(*arguments, **options)
        self._arrived = arrived

    def take_data(self):
        """What is ready, as of rclpy's, with the place of a goal."""
        taken = super().take_data()
        if "goal" in taken:
            taken["place"] = self._order.place()
            self._arrived(taken["goal"][0].sequence_number)
        return taken

    async def execute(self, taken_data):
        """As of rclpy's; a goal has its place whether it is accepted or not."""
        try:
            await super().execute(taken_data)
        finally:
            if "goal" in taken_data:
                self._order.put(taken_data["place"], self._made.pop(_key(taken_data["goal"][1]), None))


def _key(goal) -> bytes:
    return bytes(goal.goal_id.uuid)
