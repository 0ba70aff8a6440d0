"""The executables of the package: each imports its node and turns what a user can cause into one sentence.

All is imported inside: ROS may be missing, and a signal that comes meanwhile ends the process quietly.
"""

import importlib
import os
import signal
import sys
from functools import partial


def _run(name: str) -> int:
    """Runs an executable; returns the exit code."""
    for number in (signal.SIGINT, signal.SIGTERM):  # until the node takes them over, there is nothing to lose
        signal.signal(number, lambda *_: os._exit(0))
    from bearing_twin import pipes

    pipes.prepare()
    return pipes.while_read(lambda: _said(name))


def _said(name: str) -> int:
    """The exit code of a node, with one sentence where it cannot run."""
    from bearing_twin.errors import BearingTwinError, missing_package
    from bearing_twin.nodes.middleware import repair_soon
    from bearing_twin.pipes import leave
    from bearing_twin.processors import one_processor

    one_processor()
    try:
        repair_soon()
        importlib.import_module("bearing_twin.nodes.messages")  # says in one sentence what is missing, if anything is
        node = importlib.import_module(f"bearing_twin.nodes.{name}")
        if hasattr(node, "PARAMETERS") and {"-h", "--help"} & set(sys.argv[1:]):
            from bearing_twin.nodes.node_parameters import help_of

            print(help_of(name, node.__doc__.partition("\n\n")[0].replace("\n", " "), node.PARAMETERS))
            return 0
        code = node.main()
        if hasattr(node, "PARAMETERS"):
            leave(code)
        return code
    except BearingTwinError as error:
        print(f"{name}: {error}", file=sys.stderr)
    except ModuleNotFoundError as error:
        print(f"{name}: {missing_package(error)}", file=sys.stderr)
    return 2


sim_node = partial(_run, "sim_node")
recorder_node = partial(_run, "recorder_node")
replay_node = partial(_run, "replay_node")
uq_node = partial(_run, "uq_node")
watch_node = partial(_run, "watch_node")
demo = partial(_run, "demo")

if __name__ == "__main__":
    sys.exit(_run(sys.argv.pop(1)))
