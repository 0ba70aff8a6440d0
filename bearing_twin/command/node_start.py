"""`bearing_twin node start`: this process becomes a node of the package, as after `ros2 run bearing_twin NODE`."""

import os
import sys
from collections.abc import Sequence

from bearing_twin.errors import BearingTwinError
from bearing_twin.spelling import ROS_ARGS, echo, unknown

NODES = ("sim_node", "recorder_node", "replay_node", "uq_node", "watch_node")


def words_of(node: str, words: Sequence[str]) -> list[str]:
    """The words after the name of Python; `--ros-args` is put in where it was left out. Raises BearingTwinError."""
    if node not in NODES:
        raise BearingTwinError(f"{echo(node)} is no node of this package; {unknown(node, NODES)}")
    rest = list(words)
    if rest and rest[0] != ROS_ARGS and not {"-h", "--help"} & set(rest):
        rest.insert(0, ROS_ARGS)
    return ["-m", "bearing_twin.nodes.entry", node, *rest]


def replace_by_node(node: str, words: Sequence[str]):
    """Never returns: signals, exit code and output are the node's own."""
    command = [sys.executable, *words_of(node, words)]
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(command[0], command)
