"""Cost of `watch`: `python bench/watch_cost.py`, per cent of a core of sim_node and of watch_node.

The scene runs in real time; first nobody looks, then one viewer, then nobody again. Of a few spans in turn the least is
given, because what else runs on the machine only adds.
"""

import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from urllib.request import urlopen

from bearing_twin.nodes.entry import node_command, started

SCENE = "bearing_6203_loose"
SPAN, ROUNDS = 6.0, 3  # s of each measurement, and how many there are
SETTLING = 3.0  # s until a viewer that has left is noticed
PATIENCE = 300.0  # s


def processor_seconds(process: subprocess.Popen) -> float:
    """CPU time of a process so far [s]."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def shares(nodes) -> list[float]:
    """Per cent of a core that each node takes, over one span."""
    before, began = [processor_seconds(node) for node in nodes], time.monotonic()
    time.sleep(SPAN)
    passed = time.monotonic() - began
    return [100.0 * (processor_seconds(node) - old) / passed for node, old in zip(nodes, before, strict=True)]


def address(node) -> str:
    """Where watch_node serves, once it says so."""
    end = time.monotonic() + PATIENCE
    while not (match := re.search(r"shown at (http://\S+/)", node.output.read_text(errors="replace"))):
        node.check()
        if time.monotonic() > end:
            sys.exit(f"watch_node says nothing; see {node.output}")
        time.sleep(0.2)
    return match[1]


def main() -> None:
    rows = {"nobody": [], "one viewer": []}
    with tempfile.TemporaryDirectory() as folder:
        simulation = started("sim_node", node_command("sim_node", {"scene": SCENE}), Path(folder))
        watch = started("watch_node", node_command("watch_node", {"port": 0, "patience": PATIENCE}), Path(folder))
        with simulation as sim_node, watch as watch_node:
            url, nodes = address(watch_node), (sim_node, watch_node)
            for _ in range(ROUNDS):
                time.sleep(SETTLING)
                rows["nobody"].append(shares(nodes))
                events = urlopen(f"{url}events", timeout=PATIENCE)
                threading.Thread(target=lambda answer=events: [None for _ in answer], daemon=True).start()
                time.sleep(1.0)
                rows["one viewer"].append(shares(nodes))
                events.fp.raw._sock.shutdown(2)  # its reader waits in the answer: closing it here would wait too
    print(f"{SCENE} in real time, {len(os.sched_getaffinity(0))} processors; per cent of one:")
    least = {who: [min(column) for column in zip(*spans, strict=True)] for who, spans in rows.items()}
    for who, (simulating, watching) in least.items():
        print(f"  {who:12} sim_node {simulating:5.1f}   watch_node {watching:5.1f}")
    added = sum(least["one viewer"]) - sum(least["nobody"])
    print(f"  one viewer adds {added:.1f}, of it {least['one viewer'][0] - least['nobody'][0]:.1f} in sim_node")


if __name__ == "__main__":
    main()
