"""Many realisations at once: in this process by closed forms, in worker processes, or on a Dask cluster.

Workers are started afresh (spawn), so they share nothing with this process. They are stopped whatever happens: at the
end, on an exception or a signal here, when `cancelled` says so (killed, even while they integrate), and by
themselves when this process dies. The numbers do not depend on how many workers there are.
"""

import contextlib
import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

import numpy as np

from bearing_twin.errors import StudyError
from bearing_twin.kinds import KINDS
from bearing_twin.uq.realise import Realised, Task, joined, realise

LOOK = 0.05  # s between looks at `cancelled`
CLOSED_CHUNK = 16384  # numbers by closed forms between such looks, for a realisation without histories
INSTANT = 0.2  # of the time of such a realisation is what an instant of a history takes
BRIEF_CHUNK, RUN_CHUNK = 8, 1  # realisations a message to a worker, for impacts and for long runs
AHEAD, DASK_AHEAD = 16, 1000  # messages that wait: for each worker process, on a cluster
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
        self._workers, self._executor = workers or processors(), executor
        self._pool: Executor | None = None
        self._client = None
        self._idle = True

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        if self._pool is None:
            return
        if self._client is not None:
            self._pool.shutdown(wait=False)
            self._client.close()
        else:
            _end(self._pool, kill=not self._idle or exception[0] is not None)

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
        ahead = DASK_AHEAD if self._executor.startswith(DASK) else AHEAD * self._workers
        try:
            while (waiting or asked) and not self._cancelled():
                self._idle = False
                with _interrupts_kept_from_children():
                    while waiting and len(pending) < ahead:
                        asked.append(self._started().submit(realise, task, waiting.popleft()))
                        pending.add(asked[-1])
                come, pending = wait(pending, timeout=LOOK, return_when=FIRST_COMPLETED)
                for future in come:
                    _result(future)  # raises what went wrong, also with one that has others before it
                while asked and asked[0] not in pending:
                    ready.append(_result(asked.popleft()))
                if ready and time.monotonic() - handed > HANDED_OVER:
                    yield (part := joined(ready, self._task))
                    done += len(part.quantities)
                    ready, handed = [], time.monotonic()
                    tell(done)
        except StudyError:
            if ready:
                yield joined(ready, self._task)
            raise
        self._idle = not pending
        if self._client is not None:
            # Not those of a pool: its thread stumbles over cancelled futures when its processes are killed.
            for future in pending:
                future.cancel()
        if ready:
            yield (part := joined(ready, self._task))
            tell(done + len(part.quantities))

    def _started(self) -> Executor:
        if self._pool is None:
            if self._executor.startswith(DASK):
                self._client = _dask_client(self._executor.removeprefix(DASK))
                self._pool = self._client.get_executor(pure=False)
            else:
                context = multiprocessing.get_context("spawn")
                try:
                    self._pool = ProcessPoolExecutor(self._workers, context, _end_with_parent)
                except OSError as error:
                    raise StudyError(
                        f"worker processes cannot be started ({error.strerror}): the system lets none share memory or "
                        "have files open; on Linux make /dev/shm writable"
                    ) from error
        return self._pool


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _result(future) -> Realised:
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise StudyError(
            "a worker process died (no memory left, or killed from outside; a script must keep run_study behind "
            '`if __name__ == "__main__":`); try fewer workers'
        ) from error
    except OSError as error:  # of a Dask cluster: its scheduler or worker is gone
        raise StudyError(f"the cluster was lost ({error}); what is done is kept, go on from it") from error


def _end(pool: ProcessPoolExecutor, kill: bool) -> None:
    processes = list((pool._processes or {}).values())
    pool.shutdown(wait=not kill, cancel_futures=True)
    if kill:
        for process in processes:
            process.kill()
    for process in processes:
        process.join()


def _end_with_parent() -> None:
    """In a worker: end at once when the process that started it is gone, also in the middle of a realisation."""
    parent = multiprocessing.parent_process()

    def watch():
        multiprocessing.connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, name="parent watch", daemon=True).start()


@contextlib.contextmanager
def _interrupts_kept_from_children():
    """Processes started inside inherit a mask that blocks Ctrl-C: this process ends them, without their tracebacks."""
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


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
