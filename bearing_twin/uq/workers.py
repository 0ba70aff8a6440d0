"""Many realisations at once: in this process by closed forms, in worker processes, or on a Dask cluster.

Worker processes always stop: at the end, on an exception or a signal in this process, when `cancelled()` is true, and
by themselves when this process dies. The numbers do not depend on how many workers there are.
"""

import atexit
import contextlib
import multiprocessing
import os
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from concurrent import futures
from concurrent.futures import FIRST_COMPLETED, Future
from multiprocessing.connection import Connection, wait

import numpy as np

from bearing_twin.base.errors import StudyError
from bearing_twin.base.process import processor_count
from bearing_twin.kinds import KINDS
from bearing_twin.uq.realisations import Realised, Task, joined, load, realise

POLL = 0.05  # s between calls of `cancelled`
CLOSED_CHUNK = 16384  # numbers by closed forms between such calls, for a realisation without histories
INSTANT = 0.2  # of the time of such a realisation is what an instant of a history takes
BRIEF_CHUNK, RUN_CHUNK = 8, 1  # realisations a message to a worker, for impacts and for long runs
DASK_MESSAGES_AHEAD = 1000  # messages under way on a cluster
YIELD_PERIOD = 0.2  # s after which finished realisations are yielded at the latest
DASK = "dask://"
DASK_PATIENCE = 10  # s that a scheduler has to answer


class Ensemble:
    """Evaluates realisations of one task; a context manager that leaves no process behind.

    `cancelled()` is called every POLL seconds. `workers` processes are started when first needed, or `executor` names
    a Dask scheduler (`dask://host:port`), whose workers must have this package. Raises StudyError where that fails.
    """

    def __init__(self, task: Task, workers: int, executor: str, cancelled: Callable[[], bool]):
        self._task, self._cancelled = task, cancelled
        self._workers, self._executor = workers or processor_count(), executor
        self._pool: Workers | Cluster | None = None

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        if self._pool is not None:
            self._pool.end()

    def evaluate(
        self, values: np.ndarray, report: Callable[[int], None] = lambda done: None, task: Task | None = None
    ) -> Realised:
        """The realisations at `values` (n, d); fewer, from the first on, when cancelled. `report` gets their number.

        `task` takes the place of the ensemble's own. Raises StudyError when a worker dies.
        """
        return joined(list(self.parts(values, report, task or self._task)), self._task)

    def parts(
        self, values: np.ndarray, report: Callable[[int], None] = lambda done: None, task: Task | None = None
    ) -> Iterator[Realised]:
        """The same, piece after piece in order, as they come; `report` counts a piece when the next is requested.

        So what is reported as done has been stored, however the study ends.
        """
        return (self._in_this_process if self._task.closed else self._by_workers)(values, report, task or self._task)

    def _in_this_process(self, values, report, task):
        instants = len(self._task.histories) * self._task.points
        size = max(1, round(CLOSED_CHUNK / (1.0 + INSTANT * instants)))
        for start in range(0, len(values), size):
            if self._cancelled():
                return
            part = realise(task, values[start : start + size])
            yield part
            report(start + len(part.quantities))

    def _by_workers(self, values, report, task):
        size = BRIEF_CHUNK if KINDS[self._task.scene["kind"]].brief else RUN_CHUNK
        waiting = deque(values[start : start + size] for start in range(0, len(values), size))
        submitted, pending, ready, count, yielded_at = deque(), set(), [], 0, time.monotonic()
        try:
            while (waiting or submitted) and not self._cancelled():
                while waiting and len(pending) < self._capacity(len(waiting)):
                    submitted.append(self._running_pool().submit(task, waiting.popleft()))
                    pending.add(submitted[-1])
                done_futures, pending = self._pool.wait(pending, POLL)
                for future in done_futures:
                    future.result()  # raises its error, also before those of earlier messages have come
                while submitted and submitted[0] not in pending:
                    ready.append(submitted.popleft().result())
                if ready and time.monotonic() - yielded_at > YIELD_PERIOD:
                    yield (part := joined(ready, self._task))
                    count += len(part.quantities)
                    ready, yielded_at = [], time.monotonic()
                    report(count)
        except StudyError:
            if ready:
                yield joined(ready, self._task)
            raise
        if ready:
            yield (part := joined(ready, self._task))
            report(count + len(part.quantities))

    def _capacity(self, waiting: int) -> int:
        """Number of messages that may be under way: none waits for a busy worker while others are idle."""
        if self._executor.startswith(DASK):
            return DASK_MESSAGES_AHEAD
        return MESSAGES_AHEAD * self._workers if waiting > self._workers else self._workers

    def _running_pool(self):
        if self._pool is None:
            on_cluster = self._executor.startswith(DASK)
            self._pool = Cluster(self._executor.removeprefix(DASK)) if on_cluster else Workers(self._workers)
        return self._pool


class Cluster:
    """The workers of a Dask cluster, used as `Workers`; raises StudyError where it cannot be reached, or is lost."""

    def __init__(self, address: str):
        self._client = _dask_client(address)
        self._pool = self._client.get_executor(pure=False)
        self._pending: set[Future] = set()

    def submit(self, task: Task, values: np.ndarray) -> Future:
        """The realisations at `values` (n, d), by any worker."""
        return self._pool.submit(realise, task, values)

    def wait(self, pending: set[Future], timeout: float) -> tuple[set[Future], set[Future]]:
        """Those that came within `timeout` [s], and those that did not."""
        done, self._pending = futures.wait(pending, timeout, FIRST_COMPLETED)
        for future in done:
            if isinstance(error := future.exception(), OSError):  # its scheduler or worker is gone
                raise StudyError(f"the cluster was lost ({error}); what is done is kept, go on from it") from error
        return done, self._pending

    def end(self) -> None:
        """Leaves the cluster and cancels realisations that have not begun."""
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


# Worker processes that compute realisations: each has a pipe of its own and answers in the order of the requests.
#
# Where this process has a single thread, a worker is a fork of it, which imports nothing; else, and on systems where a
# fork may lack the threads of system libraries, it is spawned. Each worker has a pipe of its own, which ends with it,
# also in the middle of an answer. The workers of ProcessPoolExecutor share one pipe: it waits for ever for the rest of
# such an answer (Python 3.10 to 3.13), and at the end of the interpreter for all that was submitted.

MESSAGES_AHEAD = 2  # messages for each worker: one under way, one that waits
HANDLED = signal.SIGTERM, signal.SIGHUP  # that this process may handle in a way that is not a worker's


class Workers:
    """Workers of one study, started by the first `submit`; killed by `end`, and with this process."""

    def __init__(self, workers: int):
        self._pipes: list[Connection] = []
        self._processes: list[multiprocessing.process.BaseProcess] = []
        self._pending = [deque[Future]() for _ in range(workers)]
        self._tasks: list[Task | None] = [None] * workers
        self._lock, self._interpreter_ends = threading.Lock(), False

    def _start(self, task, values):
        if start_method() == "fork":
            load(task, values)  # once, for all
        context = multiprocessing.get_context(start_method())
        atexit.register(self._end_with_interpreter)
        with _signals_kept_from_children():
            for _ in self._pending:
                own_end, worker_end = context.Pipe()
                self._pipes.append(own_end)
                with worker_end:  # closed in this process, so that the pipe of a dead worker ends
                    process = context.Process(target=_work, args=(worker_end,), daemon=True)
                    process.start()
                self._processes.append(process)

    def submit(self, task: Task, values: np.ndarray) -> Future:
        """The realisations at `values` (n, d), by the worker that has least to do; call `wait` for them to come.

        Raises StudyError where no process can be started, or one has died.
        """
        if not self._processes:
            try:
                with self._lock:
                    self._leave_if_interpreter_ends()
                    self._start(task, values[0])
            except OSError as error:
                raise StudyError(f"worker processes cannot be started ({error.strerror})") from error
        worker = min(range(len(self._pending)), key=lambda index: len(self._pending[index]))
        with self._worker_died():
            self._pipes[worker].send((task if self._tasks[worker] is not task else None, values))
        self._tasks[worker] = task
        self._pending[worker].append(future := Future())
        return future

    def wait(self, pending: set[Future], timeout: float) -> tuple[set[Future], set[Future]]:
        """Those that came within `timeout` [s], and those that did not; raises StudyError when a worker has died."""
        done = set()
        for pipe in wait(self._pipes, timeout):
            with self._worker_died():
                realised, error, trace = pipe.recv()
            done.add(future := self._pending[self._pipes.index(pipe)].popleft())
            if error is None:
                future.set_result(realised)
            else:
                error.__cause__ = RuntimeError(f"in a worker process:\n{trace}")
                future.set_exception(error)
        return done, pending - done

    def end(self) -> None:
        """Ends all processes, also in the middle of a realisation."""
        with self._lock:
            self._leave_if_interpreter_ends()
            atexit.unregister(self._end_with_interpreter)
            self._kill()
            for resource in (*self._processes, *self._pipes):
                resource.close()

    def _kill(self) -> None:
        for process in self._processes:
            process.kill()
        for process in self._processes:
            process.join()

    def _end_with_interpreter(self) -> None:
        """Ends the processes of a study in a daemon thread, which goes on meanwhile: its pipes stay open."""
        self._interpreter_ends = True
        with self._lock:
            self._kill()

    def _leave_if_interpreter_ends(self) -> None:
        """Ends this thread silently where the interpreter ends: no worker has died."""
        if self._interpreter_ends:
            raise SystemExit

    @contextlib.contextmanager
    def _worker_died(self):
        try:
            yield
        except (EOFError, OSError) as error:
            self._leave_if_interpreter_ends()
            raise StudyError(
                "a worker process died (no memory left, or killed from outside; a script must keep run_study behind "
                '`if __name__ == "__main__":`); try fewer workers'
            ) from error


def start_method() -> str:
    """The way to start a process here and now: `fork` on Linux where no other thread can hold a lock."""
    alone = sys.platform == "linux" and len(os.listdir("/proc/self/task")) == 1
    return "fork" if alone else "spawn"


@contextlib.contextmanager
def _signals_kept_from_children():
    """Processes started inside inherit a mask that blocks signals; none splits their start here.

    Ctrl-C stays blocked there: this process ends them, without their tracebacks.
    """
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, *HANDLED})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _work(pipe: Connection) -> None:
    """A worker: answers, and ends with the process that started it, also in the middle of a realisation."""
    signal.set_wakeup_fd(-1)
    for number in HANDLED:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, HANDLED)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _answer(pipe)


def _end_with_parent() -> None:
    wait([multiprocessing.parent_process().sentinel])
    os._exit(1)


def _answer(pipe: Connection) -> None:
    """Realisations (or an error with its traceback) for values, until the pipe is at its end.

    A pipe that is closed before all answers are read raises OSError instead of EOFError.
    """
    task = None
    with contextlib.suppress(EOFError, OSError):
        while True:
            new_task, values = pipe.recv()
            task = new_task or task
            try:
                answer = realise(task, values), None, ""
            except Exception as error:  # raised where the study runs
                answer = None, error, traceback.format_exc()
            pipe.send(answer)
