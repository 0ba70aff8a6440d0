"""Many realisations at once: in this process by closed forms, in worker processes, or on a Dask cluster.

Worker processes are stopped whatever happens: at the end, on an exception or a signal here, when `cancelled` says so,
and by themselves when this process dies. The numbers do not depend on how many workers there are.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait

import numpy as np

from bearing_twin.errors import StudyError
from bearing_twin.kinds import KINDS
from bearing_twin.processors import usable
from bearing_twin.uq.realise import Realised, Task, joined, realise
from bearing_twin.uq.workers import AHEAD, Workers

LOOK = 0.05  # s between looks at `cancelled`
CLOSED_CHUNK = 16384  # numbers by closed forms between such looks, for a realisation without histories
INSTANT = 0.2  # of the time of such a realisation is what an instant of a history takes
BRIEF_CHUNK, RUN_CHUNK = 8, 1  # realisations a message to a worker, for impacts and for long runs
DASK_AHEAD = 1000  # messages under way on a cluster
HANDED_OVER = 0.2  # s in which at least what is done is handed over
DASK = "dask://"
DASK_PATIENCE = 10  # s until a scheduler that does not answer is taken for none


class Ensemble:
    """Evaluates realisations of one task; a context manager that leaves no process behind.

    `cancelled()` is asked every LOOK seconds. `workers` processes are started when first needed, or `executor` names
    a Dask scheduler (`dask://host:port`), whose workers must have this package. Raises StudyError where that fails.
    """

    def __init__(self, task: Task, workers: int, executor: str, cancelled: Callable[[], bool]):
        self._task, self._cancelled = task, cancelled
        self._workers, self._executor = workers or usable(), executor
        self._pool: Workers | Cluster | None = None

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        if self._pool is not None:
            self._pool.end()

    def evaluate(
        self, values: np.ndarray, tell: Callable[[int], None] = lambda done: None, task: Task | None = None
    ) -> Realised:
        """The realisations at `values` (n, d); fewer, from the first on, when cancelled. `tell` gets how many are done.

        `task` takes the place of the ensemble's own. Raises StudyError when a worker dies.
        """
        return joined(list(self.parts(values, tell, task or self._task)), self._task)

    def parts(
        self, values: np.ndarray, tell: Callable[[int], None] = lambda done: None, task: Task | None = None
    ) -> Iterator[Realised]:
        """The same, piece after piece in order, as they come; `tell` counts a piece when the next is asked for.

        So what is told of as done is kept, however the study ends.
        """
        return (self._here if self._task.closed else self._by_workers)(values, tell, task or self._task)

    def _here(self, values, tell, task):
        instants = len(self._task.histories) * self._task.points
        size = max(1, round(CLOSED_CHUNK / (1.0 + INSTANT * instants)))
        for start in range(0, len(values), size):
            if self._cancelled():
                return
            part = realise(task, values[start : start + size])
            yield part
            tell(start + len(part.quantities))

    def _by_workers(self, values, tell, task):
        size = BRIEF_CHUNK if KINDS[self._task.scene["kind"]].brief else RUN_CHUNK
        waiting = deque(values[start : start + size] for start in range(0, len(values), size))
        asked, pending, ready, done, handed = deque(), set(), [], 0, time.monotonic()
        try:
            while (waiting or asked) and not self._cancelled():
                while waiting and len(pending) < self._room(len(waiting)):
                    asked.append(self._started().submit(task, waiting.popleft()))
                    pending.add(asked[-1])
                come, pending = self._pool.wait(pending, LOOK)
                for future in come:
                    future.result()  # raises what went wrong, also with one that has others before it
                while asked and asked[0] not in pending:
                    ready.append(asked.popleft().result())
                if ready and time.monotonic() - handed > HANDED_OVER:
                    yield (part := joined(ready, self._task))
                    done += len(part.quantities)
                    ready, handed = [], time.monotonic()
                    tell(done)
        except StudyError:
            if ready:
                yield joined(ready, self._task)
            raise
        if ready:
            yield (part := joined(ready, self._task))
            tell(done + len(part.quantities))

    def _room(self, waiting: int) -> int:
        """How many messages may be under way: none waits for a busy worker while others have nothing to do."""
        if self._executor.startswith(DASK):
            return DASK_AHEAD
        return AHEAD * self._workers if waiting > self._workers else self._workers

    def _started(self):
        if self._pool is None:
            on_cluster = self._executor.startswith(DASK)
            self._pool = Cluster(self._executor.removeprefix(DASK)) if on_cluster else Workers(self._workers)
        return self._pool


class Cluster:
    """The workers of a Dask cluster, asked as `Workers` are; raises StudyError where it cannot be, or is lost."""

    def __init__(self, address: str):
        self._client = _dask_client(address)
        self._pool = self._client.get_executor(pure=False)
        self._pending: set[Future] = set()

    def submit(self, task: Task, values: np.ndarray) -> Future:
        """The realisations at `values` (n, d), by any worker."""
        return self._pool.submit(realise, task, values)

    def wait(self, pending: set[Future], timeout: float) -> tuple[set[Future], set[Future]]:
        """Those that came within `timeout` [s], and those that did not."""
        come, self._pending = wait(pending, timeout, FIRST_COMPLETED)
        for future in come:
            if isinstance(error := future.exception(), OSError):  # its scheduler or worker is gone
                raise StudyError(f"the cluster was lost ({error}); what is done is kept, go on from it") from error
        return come, self._pending

    def end(self) -> None:
        """Leaves the cluster; what nobody has begun is not begun any more."""
        for future in self._pending:
            future.cancel()
        self._pool.shutdown(wait=False)
        self._client.close()


def _dask_client(address: str):
    try:
        from distributed import Client
    except ImportError as error:
        raise StudyError(
            "executor dask:// needs the package distributed; install it (pip install distributed), or use "
            "executor: processes"
        ) from error
    try:
        return Client(f"tcp://{address}", timeout=DASK_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise StudyError(f"there is no Dask scheduler at {address} ({error}); start one, or use processes") from error
