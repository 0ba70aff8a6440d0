"""A reader's shells for tests: lines one after the other, and nodes that run on in shells of their own."""

import contextlib
import os
import signal
import subprocess
from pathlib import Path

from pages import NODE, ROOT

PATIENCE = 1800.0  # s for one line: a busy machine is slow
LASTING = (NODE, "bearing_twin watch")  # lines that run until Ctrl-C, in a shell of their own


class Shell:
    """Lines run one after the other in one folder, in the shell of `env.bash`; nodes run on in shells of their own."""

    def __init__(self, folder: Path):
        self.folder, self.nodes, self.said = folder, [], {}
        kept = ("HOME", "PATH", "XDG_CACHE_HOME", "LANG", "ROS_DOMAIN_ID")
        keep = {key: os.environ[key] for key in kept if key in os.environ}
        self.environment = keep | {"MPLBACKEND": "Agg", "COLUMNS": "80"}

    def run(self, line: str) -> str:
        """The line's standard output; fails the test where it ends with another code than 0."""
        words = ["bash", "-c", f"source {ROOT}/env.bash; export PYTHONPATH={ROOT}:$PYTHONPATH; {line}"]
        if line.startswith(LASTING):
            with (self.folder / f"node_{len(self.nodes)}.txt").open("wb") as said:
                self.nodes.append(
                    subprocess.Popen(
                        words, cwd=self.folder, env=self.environment, stdout=said, stderr=said, start_new_session=True
                    )
                )
            return ""
        done = subprocess.run(
            words, cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}\n{self.words_of_nodes()}"
        return done.stdout

    def words_of_nodes(self) -> str:
        return "".join(path.read_text(errors="replace") for path in sorted(self.folder.glob("node_*.txt")))

    def end(self) -> None:
        """Ctrl-C for every node; each has to end by itself, without a failure."""
        for node in self.nodes:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(node.pid, signal.SIGINT)
        codes = [node.wait(timeout=PATIENCE) for node in self.nodes]
        assert set(codes) <= {0}, f"{codes}\n{self.words_of_nodes()}"
        self.nodes.clear()
