"""Tests in processes side by side: `--side-by-side 2`. Each is a fork of the one that has imported and collected all.

A fork takes a file whole when it has nothing left to do, so that tests share what their file's fixtures made. What
becomes of each test it tells the first process, which judges, prints and counts as if it had run it. Where a fork ends
in the middle of a test, that test has failed, and another fork goes on with the next.
"""

import contextlib
import itertools
import mmap
import multiprocessing
import os
import signal
import traceback
import warnings
from collections.abc import Iterator
from multiprocessing import connection

import domains
import pytest
import starts

NOTHING = -1  # in place of the number of a test
_NUMBER = 4  # bytes of one, in the pipe of files


class SideBySide:
    """The loop over tests in `count` forks."""

    def __init__(self, config: pytest.Config, count: int):
        self.config, self.count = config, count
        # Of all processes: whether to stop; of each fork: the test that it runs, and the one that it will run next.
        self._shared = memoryview(mmap.mmap(-1, 8 * (1 + 2 * count))).cast("q")
        self._running: dict[connection.Connection, tuple[int, int]] = {}  # (number, pid) of forks by what they tell

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        """Runs all tests; None where there is nothing to run, which pytest's own loop knows to tell."""
        if session.testsfailed or self.config.option.collectonly:
            return None
        self._session, items = session, session.items
        self._files = {
            group[0]: group[-1] + 1
            for group in (list(one) for _, one in itertools.groupby(range(len(items)), lambda k: items[k].path))
        }
        self._taken, waiting = os.pipe()
        for first in self._files:
            os.write(waiting, first.to_bytes(_NUMBER, "little"))
        os.close(waiting)
        self.config._tmp_path_factory.getbasetemp()  # one folder, in which each fork has its own
        try:
            for number in range(self.count):
                self._fork(number, NOTHING)
            while self._running:
                for pipe in connection.wait(list(self._running)):
                    self._hear(pipe)
                self._shared[0] = bool(session.shouldfail or session.shouldstop)
        finally:
            for pipe, (_, pid) in self._running.items():
                os.kill(pid, signal.SIGINT)
                os.waitpid(pid, 0)
                pipe.close()
            os.close(self._taken)
        if session.shouldfail:
            raise session.Failed(session.shouldfail)
        if session.shouldstop:
            raise session.Interrupted(session.shouldstop)
        return True

    def _hear(self, pipe: connection.Connection) -> None:
        """Hands on what a fork tells, and sees to its end."""
        with contextlib.suppress(EOFError, ConnectionResetError):
            for name, words in pipe.recv():
                if name == "failed":
                    raise RuntimeError(words)
                if name == "pytest_runtest_logreport":
                    words["report"] = self.config.hook.pytest_report_from_serializable(
                        config=self.config, data=words["report"]
                    )
                hook = getattr(self.config.hook, name)
                hook.call_historic(kwargs=words) if hook.is_historic() else hook(**words)
            return
        number, pid = self._running.pop(pipe)
        pipe.close()
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        now, following = self._shared[1 + 2 * number : 3 + 2 * number]
        if now == NOTHING:
            return
        item = self._session.items[now]
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        said = f"the process of this test ended in the middle of it, by {how}"
        report = pytest.TestReport(item.nodeid, item.location, {}, "failed", said, "call")
        self.config.hook.pytest_runtest_logreport(report=report)
        self._fork(number, following)

    def _fork(self, number: int, first: int) -> None:
        """Starts a fork that begins with the test `first` and goes on to the end of its file."""
        self.config.get_terminal_writer().flush()
        here, there = multiprocessing.Pipe(duplex=False)
        self._shared[1 + 2 * number] = NOTHING
        pid = os.fork()
        if pid:
            there.close()
            self._running[here] = number, pid
            return
        here.close()
        try:
            self._become(number, there)
            self._work(number, first)
        except (BrokenPipeError, KeyboardInterrupt):
            pass  # nobody hears it, or wants to
        except BaseException:
            there.send([("failed", traceback.format_exc())])
        finally:
            for one in starts.STEM:
                one.end()
            os._exit(0)

    def _become(self, number: int, pipe: connection.Connection) -> None:
        """Takes from a fork what is of the first process alone: what it prints, files of captured streams, folders."""
        plugins = self.config.pluginmanager
        teller = _Teller(self.config, pipe, plugins.unregister(name="terminalreporter")._tw)
        plugins.register(teller, "terminalreporter")
        teller.told.clear()  # warnings of before the fork
        for name in ("terminalprogress", "names of what fails"):
            if plugins.has_plugin(name):
                plugins.unregister(name=name)
        captured = plugins.get_plugin("capturemanager")
        captured.stop_global_capturing()
        captured.start_global_capturing()
        factory = self.config._tmp_path_factory
        factory._basetemp = factory.getbasetemp() / str(os.getpid())
        factory._basetemp.mkdir()
        domains.begin_at(number / self.count)

    def _tests(self, first: int) -> Iterator[int]:
        """The tests of a fork: what is left of one file, then files that no other has taken."""
        if first != NOTHING:
            yield from range(first, min(end for end in self._files.values() if end > first))
        while said := os.read(self._taken, _NUMBER):
            begin = int.from_bytes(said, "little")
            yield from range(begin, self._files[begin])

    def _work(self, number: int, first: int) -> None:
        items, chosen = self._session.items, self._tests(first)
        following = next(chosen, NOTHING)
        while (now := following) != NOTHING and not self._shared[0]:
            following = next(chosen, NOTHING)
            self._shared[1 + 2 * number], self._shared[2 + 2 * number] = now, following
            after = items[following] if following != NOTHING else None
            self.config.hook.pytest_runtest_protocol(item=items[now], nextitem=after)
        self._session._setupstate.teardown_exact(None)  # where others stopped it
        self._shared[1 + 2 * number] = NOTHING


class _Teller:
    """In place of what prints, tells the first process what became of a test when it is over."""

    def __init__(self, config: pytest.Config, pipe: connection.Connection, writer):
        self._config, self._pipe, self.told = config, pipe, []
        self._tw = writer  # where stacks are printed when time is out

    def pytest_runtest_logreport(self, report):
        data = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        self.told.append(("pytest_runtest_logreport", {"report": data}))

    def pytest_runtest_logfinish(self, nodeid, location):
        self.told.append(("pytest_runtest_logfinish", {"nodeid": nodeid, "location": location}))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self):
        done = yield
        self._pipe.send(self.told)
        self.told = []
        return done

    def pytest_warning_recorded(self, warning_message, when, nodeid, location):
        one = warning_message
        text = f"{one.category.__name__}: {one.message}"  # classes of tests are not known by name elsewhere
        plain = warnings.WarningMessage(text, Warning, one.filename, one.lineno)
        words = {"warning_message": plain, "when": when, "nodeid": nodeid, "location": location}
        self.told.append(("pytest_warning_recorded", words))
