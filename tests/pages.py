"""Pages of the docs for tests: their blocks of code, copies of the checkout, and a reader's shells."""

import contextlib
import os
import re
import shlex
import shutil
import signal
import subprocess
from functools import partial
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
TUTORIALS = sorted(page for page in (ROOT / "docs" / "tutorials").glob("*.md") if page.stem != "index")
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", flags=re.DOTALL | re.MULTILINE)
_FILE = re.compile(r"# (\w+\.(?:yaml|py))$")
NODE = "bearing_twin node start "


class Block(NamedTuple):
    """One block of code: its language and text; the name of the file that it is, if it is one."""

    language: str
    text: str
    file: str | None

    @property
    def lines(self) -> list[str]:
        """The shell lines, without comments behind them."""
        commands = (line.split("  #")[0].strip() for line in self.text.splitlines())
        return [line for line in commands if line and not line.startswith("#")]


def blocks(page: Path) -> list[Block]:
    """All blocks of a page, in order."""
    return [
        Block(language, text, match[1] if (match := _FILE.match(text.splitlines()[0])) else None)
        for language, text in _BLOCK.findall(page.read_text(encoding="utf-8"))
        if text.strip()
    ]


def copied_sources(folder: Path) -> Path:
    """A copy of the checkout in a new folder, without what builds and set-ups leave in its top folder."""
    generated = {"build", "install", "log", "demo"}
    copytree = partial(shutil.copytree, ignore=shutil.ignore_patterns("__pycache__"))
    folder.mkdir(parents=True)
    for path in ROOT.iterdir():
        if path.name not in generated and not path.name.startswith(".") and path.suffix != ".egg-info":
            (copytree if path.is_dir() else shutil.copy)(path, folder / path.name)
    return folder


def without_code(page: Path) -> str:
    """The prose of a page."""
    return _BLOCK.sub("", page.read_text(encoding="utf-8"))


def words_of(line: str) -> list[str]:
    """The words after `bearing_twin` of a command; what a shell would do with `>` is left out."""
    return shlex.split(line.partition(" > ")[0])[1:]


PATIENCE = 1800.0  # s for one line: a busy machine is slow
LASTING = (NODE, "bearing_twin watch")  # lines that run until Ctrl-C, in a shell of their own


class Shell:
    """Lines run one after the other in one folder, in the shell of `env.bash`; nodes run on in shells of their own."""

    def __init__(self, folder: Path):
        self.folder, self.nodes, self.said = folder, [], {}
        names = ("HOME", "PATH", "XDG_CACHE_HOME", "LANG", "ROS_DOMAIN_ID")
        keep = {key: os.environ[key] for key in names if key in os.environ}
        self.environment = keep | {"MPLBACKEND": "Agg", "COLUMNS": "80"}

    def run(self, line: str) -> str:
        """The line's standard output; fails the test where it ends with another code than 0."""
        command = ["bash", "-c", f"source {ROOT}/env.bash; export PYTHONPATH={ROOT}:$PYTHONPATH; {line}"]
        if line.startswith(LASTING):
            with (self.folder / f"node_{len(self.nodes)}.txt").open("wb") as output:
                self.nodes.append(
                    subprocess.Popen(
                        command,
                        cwd=self.folder,
                        env=self.environment,
                        stdout=output,
                        stderr=output,
                        start_new_session=True,
                    )
                )
            return ""
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
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
