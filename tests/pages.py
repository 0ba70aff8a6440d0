"""Blocks of code in Markdown pages, and the tutorials run from top to bottom in one folder, as a reader does.

A block of YAML or Python whose first line is `# NAME.yaml` or `# NAME.py` is a file the reader writes.
"""

import re
import shlex
import shutil
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
        found = (line.split("  #")[0].strip() for line in self.text.splitlines())
        return [line for line in found if line and not line.startswith("#")]


def blocks(page: Path) -> list[Block]:
    """All blocks of a page, in order."""
    return [
        Block(language, text, found[1] if (found := _FILE.match(text.splitlines()[0])) else None)
        for language, text in _BLOCK.findall(page.read_text(encoding="utf-8"))
        if text.strip()
    ]


def copied_sources(folder: Path) -> Path:
    """A copy of the checkout in a new folder, without what builds and set-ups leave in its top folder."""
    left = {"build", "install", "log", "demo"}
    copytree = partial(shutil.copytree, ignore=shutil.ignore_patterns("__pycache__"))
    folder.mkdir(parents=True)
    for one in ROOT.iterdir():
        if one.name not in left and not one.name.startswith(".") and one.suffix != ".egg-info":
            (copytree if one.is_dir() else shutil.copy)(one, folder / one.name)
    return folder


def without_code(page: Path) -> str:
    """The prose of a page."""
    return _BLOCK.sub("", page.read_text(encoding="utf-8"))


def words_of(line: str) -> list[str]:
    """The words after `bearing_twin` of a command; what a shell would do with `>` is left out."""
    return shlex.split(line.partition(" > ")[0])[1:]
