"""ROS domains for tests, each held by one process of this machine at a time, so that runs side by side never meet.

A domain is held by a TCP socket on the first of its own ports, on which ROS sends by UDP: it is free again when its
holder ends, however it ends.
"""

import os
import socket
from collections.abc import Iterator
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
    """The UDP ports that are in use, where the system tells."""
    tables = (Path("/proc/net") / name for name in ("udp", "udp6"))
    rows = [row.split() for table in tables if table.exists() for row in table.read_text().splitlines()[1:]]
    return [int(row[1].rpartition(":")[2], 16) for row in rows]
