"""The executables of the package: each imports its node, and reports errors of the user in one sentence.

All is imported inside: ROS may be missing, and a signal that comes meanwhile ends the process quietly.
"""

import contextlib
import importlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from bearing_twin.base.errors import ROS_ARGS, BearingTwinError
from bearing_twin.base.paths import share_path


def _run(executable: str) -> int:
    """Runs an executable, given as "module:class of the node"; returns the exit code."""
    for number in (signal.SIGINT, signal.SIGTERM):  # until the node handles them, there is nothing to lose
        signal.signal(number, lambda *_: os._exit(0))
    from bearing_twin.base import process

    process.prepare_streams()
    return process.run_while_read(lambda: _exit_code(*executable.split(":")))


def _exit_code(name: str, work: str) -> int:
    """The exit code, with one sentence where the executable cannot run.

    Of a node 0 when it is done or a signal ended it, 2 where it cannot do its work; of the demonstration its own.
    """
    from bearing_twin.base.errors import missing_package
    from bearing_twin.base.process import exit_process, limit_blas_threads

    limit_blas_threads()
    try:
        frequent_heartbeats()
        importlib.import_module("bearing_twin.nodes.messages")  # raises in one sentence where ROS is missing
        module = importlib.import_module(f"bearing_twin.nodes.{name}")
        if name == "demo":
            return getattr(module, work)()
        if {"-h", "--help"} & set(sys.argv[1:]):
            from bearing_twin.nodes.node_parameters import help_text

            print(help_text(name, module.__doc__.partition("\n\n")[0].replace("\n", " "), module.PARAMETERS))
            return 0
        from bearing_twin.nodes.base_node import run

        code = run(name, getattr(module, work))
        exit_process(code)
        return code
    except BearingTwinError as error:
        print(f"{name}: {error}", file=sys.stderr)
    except ModuleNotFoundError as error:
        print(f"{name}: {missing_package(error)}", file=sys.stderr)
    return 2


sim_node = partial(_run, "sim_node:SimNode")
recorder_node = partial(_run, "recorder_node:RecorderNode")
replay_node = partial(_run, "replay_node:ReplayNode")
uq_node = partial(_run, "uq_node:UqNode")
watch_node = partial(_run, "watch_node:WatchNode")
demo = partial(_run, "demo:main")

PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"  # read by Fast DDS 2, which Jazzy has, when a process makes its first node
OF_THE_FOLDER = "DEFAULT_FASTRTPS_PROFILES.xml"  # read where a node starts


def frequent_heartbeats() -> None:
    """Sets heartbeats of Fast DDS publishers to ten a second, unless the user gave profiles.

    Of a message that went astray subscribers of Fast DDS learn by that alone, every 3 s by default: by then a publisher
    of 1000 messages a second has let go of it. Raises BearingTwinError where the file of the profile is missing.
    """
    if PROFILES not in os.environ and not Path(OF_THE_FOLDER).exists():
        os.environ[PROFILES] = str(share_path("config", "fastdds.xml"))


GRACE = 60.0  # s a node has to end after SIGINT, before it is killed
LAST_LINES = 3  # lines of a node's output that an error repeats


class ProcessError(BearingTwinError):
    """A node ended too early or failed; the message names its output and the next step."""


class NodeProcess(subprocess.Popen):
    """A process with its output in the file `output`."""

    def __init__(self, name: str, command: Sequence[str], output: Path):
        self.name, self.output = name, output
        with output.open("wb") as file:
            super().__init__(command, stdout=file, stderr=subprocess.STDOUT)

    def check(self, may_end: bool = False) -> None:
        """Raises ProcessError if the process failed, or ended though it may not."""
        code = self.poll()
        if code is None or (code == 0 and may_end):
            return
        how = f"was ended by signal {signal.Signals(-code).name}" if code < 0 else f"ended early with code {code}"
        lines = self.output.read_text(encoding="utf-8", errors="replace").splitlines()[-LAST_LINES:]
        last = "".join(f"\n  {line}" for line in lines) or " nothing"
        raise ProcessError(
            f"{self.name} {how}. Its last lines:{last}\n"
            f"Its output is in {self.output}. Correct the cause named there, or try again."
        )


@contextlib.contextmanager
def started(name: str, command: Sequence[str], folder: Path) -> Iterator[NodeProcess]:
    """A process with its output in `folder`; it ends with the body of the `with` statement."""
    node = NodeProcess(name, command, folder / f"{name}.txt")
    try:
        yield node
    finally:
        node.send_signal(signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            node.wait(GRACE)
        if node.poll() is None:
            node.kill()
            node.wait()


def node_command(name: str, parameters: dict) -> list[str]:
    """The command line that starts a node of this package with these parameters."""
    assignments = [f"{key}:={json.dumps(value, default=str)}" for key, value in parameters.items()]
    command = [sys.executable, "-m", "bearing_twin.nodes.entry", name, ROS_ARGS]
    return [*command, *(part for assignment in assignments for part in ("-p", assignment))]


if __name__ == "__main__":
    sys.exit(globals()[sys.argv.pop(1)]())
