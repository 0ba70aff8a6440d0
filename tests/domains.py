"""ROS domains for tests, each held by one process of this machine at a time, so that runs side by side never meet.

A domain is held by a TCP socket on the first of its own ports, on which ROS sends by UDP: it is free again when its
holder ends, however it ends.
"""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager

FIRST, COUNT = 2, 99  # ports of higher ones are those that Linux gives to anybody
_next = os.getpid() % COUNT


@contextmanager
def own_domain() -> Iterator[int]:
    """A domain that nobody else has; another one every time, for the last messages of a node outlive it."""
    global _next
    for _ in range(COUNT):
        domain = FIRST + _next
        _next = (_next + 1) % COUNT
        with socket.socket() as holder:
            try:
                holder.bind(("127.0.0.1", 7400 + 250 * domain))
            except OSError:
                continue
            yield domain
            return
    raise RuntimeError(f"{COUNT} ROS domains are all held: end other runs of tests")
