"""Cost of nodes in real time: `python bench/node_cost.py`, per cent of a core of sim_node and of recorder_node.

The 6203 runs alone, then with a recorder that logs every message; of a few spans the least is given, because what else
runs on the machine only adds. What a recorder lost it counts itself: messages of all topics, and solver outputs.
"""

import math
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from watch_cost import PATIENCE, shares

from bearing_twin import load_scene, read_log
from bearing_twin.log.raw_log import RECORDING_RECORD
from bearing_twin.nodes.entry import node_command, started

RATES = ((100, 100), (1000, 100), (1000, 1000), (4000, 1000))  # outputs, and messages of a topic, a second
ROUNDS = 3
SETTLING = 4.0  # s
LATE = "cannot keep up"  # from the warning of sim_node when it falls behind real time


def wait_for_output(node, text: str) -> None:
    """Waits until the output of a node has `text`."""
    end = time.monotonic() + PATIENCE
    while text not in node.output.read_text(errors="replace"):
        node.check()
        if time.monotonic() > end:
            sys.exit(f"{node.output} does not have {text!r}")
        time.sleep(0.2)


def least(nodes) -> list[float]:
    """Per cent of a core of each node, the least of several spans."""
    time.sleep(SETTLING)
    return [min(column) for column in zip(*(shares(nodes) for _ in range(ROUNDS)), strict=True)]


class Cost(NamedTuple):
    """Per cent of a core of sim_node alone, recorded, of recorder_node; what was lost of how much; who fell behind."""

    alone: float
    recorded: float
    recorder: float
    messages_lost: int
    messages: int
    outputs_lost: int
    outputs: int
    late: bool

    @property
    def lost(self) -> float:
        """Messages and outputs that the recorder lost; infinite where sim_node fell behind."""
        return math.inf if self.late else float(self.messages_lost + self.outputs_lost)


def measured(outputs: int, messages: int, folder: Path) -> Cost:
    """Cost of the nodes at so many outputs, and messages of a topic, a second."""
    rates = [f"run.output_rate={outputs}", f"run.publish_rate={messages}"]
    scene, log = folder / f"{outputs}_{messages}.yaml", folder / f"{outputs}_{messages}.mcap"
    scene.write_text(load_scene("bearing_6203", rates).text, encoding="utf-8")
    recording = {"log": str(log)}
    with started("sim_node", node_command("sim_node", {"scene": str(scene)}), folder) as simulating:
        wait_for_output(simulating, "ready after")
        [alone] = least([simulating])
        with started("recorder_node", node_command("recorder_node", recording), folder) as recorder:
            recorded, recorder_share = least([simulating, recorder])
        late = LATE in simulating.output.read_text(errors="replace")
    recorded_run = read_log(log, allow_gaps=True)
    received = sum(map(len, recorded_run.blocks()))
    record = recorded_run.metadata[RECORDING_RECORD]
    lost = int(record["messages_lost"]), int(record["messages"]), recorded_run.missing, received
    return Cost(alone, recorded, recorder_share, *lost, late)


def main() -> None:
    print(f"bearing_6203 in real time, {len(os.sched_getaffinity(0))} processors; per cent of one:")
    print(f"{'outputs':>8}{'messages':>10}{'sim_node':>10}{'sim_node':>10}{'recorder':>10}{'lost':>18}{'lost':>16}")
    print(f"{'1/s':>8}{'1/s':>10}{'alone':>10}{'recorded':>10}{'':10}{'messages':>18}{'outputs':>16}")
    with tempfile.TemporaryDirectory() as folder:
        for outputs, messages in RATES:
            cost = measured(outputs, messages, Path(folder))
            shares = f"{cost.alone:10.1f}{cost.recorded:10.1f}{cost.recorder:10.1f}"
            lost = f"{f'{cost.messages_lost} of {cost.messages}':>18}{f'{cost.outputs_lost} of {cost.outputs}':>16}"
            print(f"{outputs:8}{messages:10}{shares}{lost}{'  fell behind' if cost.late else ''}", flush=True)


if __name__ == "__main__":
    main()
