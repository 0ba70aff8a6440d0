"""Python programs started by tests without the second that imports take: forks of a process that has imported them.

Such a process has its number, streams, folder, environment, signals and exit code as any other, and is a child of the
tests. That programs import what they need themselves is what tests without this show.
"""

import ctypes
import gc
import importlib
import importlib.util
import json
import os
import runpy
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

IMPORTED = (
    "bearing_twin.command.cli", "bearing_twin.command.study_command", "bearing_twin.run.simulation",
    "bearing_twin.uq.run", "bearing_twin.log.run_log", "bearing_twin.kinds.bearing.motion",
    "bearing_twin.kinds.bodies.impact",
)  # fmt: skip
WITH_ROS = ("bearing_twin.nodes.sim_node", "bearing_twin.nodes.recorder_node", "bearing_twin.nodes.uq_node")
ROS = ("rclpy", "bearing_twin_msgs")
ADOPTS = 36  # PR_SET_CHILD_SUBREAPER of prctl(2)
READ_BY_IMPORTS = ("PYTHON", "XDG_", "RMW", "AMENT", "LD_")  # how such variables of the environment begin


def _adopt(whether: bool) -> None:
    """True if orphans of what this process started become its children."""
    ctypes.CDLL(None).prctl(ADOPTS, int(whether), 0, 0, 0)


def _read_by_imports(environment) -> dict[str, str]:
    return {key: value for key, value in environment.items() if key.startswith(READ_BY_IMPORTS)}


_Popen = subprocess.Popen


class Stem:
    """The process that has imported all, and forks."""

    def __init__(self):
        self._socket, there = socket.socketpair()
        with there:
            words, number = [sys.executable, __file__], there.fileno()
            self._process = _Popen([*words, str(number)], pass_fds=[number], start_new_session=True)
        self.number, self._read = self._process.pid, _read_by_imports(os.environ)

    def fits(self, words: list[str], environment: dict[str, str]) -> bool:
        """True for a program of Python, of which imports would have read nothing else."""
        return words[0] == sys.executable and _read_by_imports(environment) == self._read

    def start(self, streams: list[int], **asked) -> int:
        """The number of a process with these streams, a child of this one."""
        with tempfile.TemporaryFile() as request:
            request.write(json.dumps(asked).encode())
            request.flush()
            _adopt(True)
            try:
                socket.send_fds(self._socket, [b"1"], [request.fileno(), *streams])
                reported = self._socket.recv(4)
            finally:
                _adopt(False)
        if not reported:
            raise RuntimeError("the process that has imported all has ended")
        return int.from_bytes(reported, "little")

    def end(self) -> None:
        """Ends it."""
        self._socket.close()
        self._process.wait()


STEM: list[Stem] = []  # of this process, where it has begun


class Forking(_Popen):
    """As subprocess.Popen, by a fork where that can be."""

    def _execute_child(self, args, executable, preexec_fn, close_fds, pass_fds, cwd, env, *more):
        _, _, shell, *pipes = more[:9]
        words, environment = [os.fspath(one) for one in args], dict(os.environ if env is None else env)
        if not STEM:
            STEM.append(Stem())
        if shell or preexec_fn or pass_fds or not STEM[0].fits(words, environment):
            super()._execute_child(args, executable, preexec_fn, close_fds, pass_fds, cwd, env, *more)
            return
        ends = pipes[0], pipes[3], pipes[5]  # those of the child; -1 where it shares this process's stream
        streams = [number if end == -1 else end for number, end in enumerate(ends)]
        folder, session = os.fspath(cwd or os.getcwd()), bool(more[14])
        self.pid = STEM[0].start(streams, words=words[1:], environment=environment, folder=folder, session=session)
        self._child_created = True
        self._close_pipe_fds(*pipes)


def _become(request: dict, streams: list[int]) -> None:
    """A fork becomes the program that is asked for; returns where that has ended."""
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    sys.stdin, sys.stdout, sys.stderr = (os.fdopen(k, mode, closefd=False) for k, mode in enumerate(("r", "w", "w")))
    sys.stderr.reconfigure(line_buffering=True, errors="backslashreplace")
    if request["session"]:
        os.setsid()
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    words = request["words"]
    if words[0] == "-B":
        sys.dont_write_bytecode = bool(words.pop(0))
    if words[0] == "-c":
        sys.argv, sys.path[0] = ["-c", *words[2:]], ""
        exec(words[1], vars(sys.modules["__main__"]))
    elif words[0] == "-m":
        sys.argv, sys.path[0] = words[1:], os.getcwd()
        runpy.run_module(words[1], run_name="__main__", alter_sys=True)
    else:
        sys.argv, sys.path[0] = words, str(Path(words[0]).parent)
        runpy.run_path(words[0], run_name="__main__")


def _import_all() -> None:
    for name in (*IMPORTED, *(WITH_ROS if all(map(importlib.util.find_spec, ROS)) else ())):
        importlib.import_module(name)
    from bearing_twin.run.scene import load_scene
    from bearing_twin.run.simulation import simulate

    simulate(load_scene("bearing_6203", ["run.duration=1e-4"]))  # which loads the core
    gc.freeze()


def _serve(asking: socket.socket) -> None:
    """Forks as often as asked, until nobody can ask any more; returns in a fork that has ended as a program."""
    while True:
        said, numbers, *_ = socket.recv_fds(asking, 1, 4)
        if not said:
            return
        reported, tells = os.pipe()
        between = os.fork()
        if between:
            os.waitpid(between, 0)  # whose child is an orphan now, and the tests', who learn its number
            asking.send(os.read(reported, 4))
            for one in (*numbers, reported, tells):
                os.close(one)
            continue
        child = os.fork()
        if child:
            os.write(tells, child.to_bytes(4, "little"))
            os._exit(0)
        os.close(reported)
        os.close(tells)
        asking.close()
        with os.fdopen(numbers[0], "rb") as stream:
            stream.seek(0)
            request = json.load(stream)
        _become(request, list(numbers[1:]))
        return


if __name__ == "__main__":
    _import_all()
    _serve(socket.socket(fileno=int(sys.argv[1])))
