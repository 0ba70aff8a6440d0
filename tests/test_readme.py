"""The README's Python examples run as they stand, and its commands and paths exist."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from bearing_twin.command.commands import COMMANDS
from bearing_twin.run.scene import scene_names
from bearing_twin.uq.study_file import study_names

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


@pytest.mark.parametrize("example", EXAMPLES, ids=range(len(EXAMPLES)))
def test_examples_run(example, tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", example], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def test_every_scene_and_command_of_the_readme_exists():
    assert len(EXAMPLES) >= 3
    for name in scene_names():
        assert f"`{name}`" in README, f"the README's table of scenes has no row for {name}"
    for name in study_names():
        assert f"`{name}`" in README, f"the README's table of studies has no row for {name}"
    for word in re.findall(r"^bearing_twin (\w+)", README, flags=re.MULTILINE):
        assert word in COMMANDS
    for link in re.findall(r"\]\(([^)]+)\)", README):
        assert (ROOT / link).exists(), f"the README links to {link}"
