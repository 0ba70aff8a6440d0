"""ROS domains for tests, each held by one process of this machine at a time, and forks of a process of tests.

A domain is held by a TCP socket on the first of its own ports, on which ROS sends by UDP: it is free again when its
holder ends, however it ends. Processes forked by tests do not collect what is left of threads of nodes: a fork has none
of them and would crash. Importing this is enough, for every fork of the process that does.
"""

import gc
import os
import resource
import socket
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

FIRST, COUNT = 2, 99  # ports of higher domains are those that Linux gives to anybody
FIRST_PORT, PORTS = 7400, 250  # of domain 0, and how many each domain has
_next = os.getpid() % COUNT


@contextmanager
def own_domain() -> Iterator[int]:
    """A domain in which nobody else on this machine is; another one each time, for last messages outlive a node."""
    global _next
    for _ in range(COUNT):
        domain = FIRST + _next
        _next = (_next + 1) % COUNT
        with socket.socket() as holder:
            try:
                holder.bind(("127.0.0.1", FIRST_PORT + PORTS * domain))
            except OSError:
                continue
            if domain not in {(port - FIRST_PORT) // PORTS for port in _bound_ports()}:
                yield domain
                return
    raise RuntimeError(f"{COUNT} ROS domains are all in use: end what runs in some")


def _bound_ports() -> list[int]:
    """The UDP ports in use, where the system reports them."""
    tables = (Path("/proc/net") / name for name in ("udp", "udp6"))
    rows = [row.split() for table in tables if table.exists() for row in table.read_text().splitlines()[1:]]
    return [int(row[1].rpartition(":")[2], 16) for row in rows]


os.register_at_fork(after_in_child=gc.freeze)


def forked(call: Callable[[], int | None], largest_file: int | None = None) -> subprocess.CompletedProcess:
    """Code and output of `call` in a fork of this process, which has imported what it needs.

    Its files grow to `largest_file` [bytes] at most, as on a disk that becomes full. Not for what has threads that a
    fork lacks, as those of Arrow and Rerun.
    """
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as error:
        child = os.fork()
        if not child:
            code, (_, hard) = 1, resource.getrlimit(resource.RLIMIT_FSIZE)
            try:
                sys.stdout, sys.stderr = out, error
                for number, stream in ((1, out), (2, error)):
                    os.dup2(stream.fileno(), number)
                sys.dont_write_bytecode = True  # nothing notices where a file of it is cut off
                if largest_file is not None:
                    resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, hard))
                code = call() or 0
            except BaseException:
                traceback.print_exc()
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))  # for what is said of it
                out.flush()
                error.flush()
                os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        out.seek(0)
        error.seek(0)
        return subprocess.CompletedProcess((), code, out.read(), error.read())
