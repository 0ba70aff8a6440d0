"""Examples: short, named in the docs, and each runs and draws its picture."""

import contextlib
import io
import runpy
import subprocess
import sys
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
import starts
from PIL import Image

from bearing_twin.command import cli
from bearing_twin.command.node_command import words_of

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
MOST_LINES = 40
NEEDS_ROS = {"live"}


def answered(run):
    """`subprocess.run`, but commands of this package are answered by this process: starting another takes seconds."""

    def asked(words, **more):
        if words[0] != "bearing_twin":
            return run(words, **more)
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            code = cli.main(words[1:])
        assert code == cli.DONE or not more.get("check")
        return subprocess.CompletedProcess(words, code, said.getvalue(), "")

    return asked


def node_at_once(words):
    """`bearing_twin node start` as the process that it becomes, which has imported what it needs."""
    assert words[:3] == ["bearing_twin", "node", "start"]
    return starts.Forking([sys.executable, *words_of(words[3], words[4:])])


def covers_a_curve(axes):
    """True if the legend of these axes, drawn already, lies over a point of one of their lines."""
    legend = axes.get_legend()
    if legend is None:
        return False
    box = legend.get_window_extent()
    points = [line.get_transform().transform(line.get_xydata()) for line in axes.get_lines()]
    return bool(points) and box.count_contains(np.concatenate(points)) > 0


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_draws(example, tmp_path, monkeypatch, capsys, quick_workers):
    if example.stem in NEEDS_ROS:
        import ros  # noqa: F401  (skips where ROS is missing)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(subprocess, "run", answered(subprocess.run))
    monkeypatch.setattr(subprocess, "Popen", node_at_once)
    monkeypatch.setattr("bearing_twin.uq.workers.usable", lambda: 1)
    matplotlib.use("Agg")
    runpy.run_path(str(example), run_name="__main__")
    hidden = [axes for one in map(plt.figure, plt.get_fignums()) for axes in one.axes if covers_a_curve(axes)]
    plt.close("all")
    assert not hidden, "a legend lies over a curve"
    assert capsys.readouterr().out.strip()
    picture = np.asarray(Image.open(tmp_path / f"{example.stem}.png").convert("RGBA"))
    assert 600 <= picture.shape[1] <= 1000
    assert len(np.unique(picture.view("u4"))) > 20, "colours, four bytes each"


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_in_the_docs(example):
    assert len(example.read_text(encoding="utf-8").splitlines()) <= MOST_LINES
    page = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
    assert f"{{literalinclude}} ../examples/{example.name}" in page
    assert f"](examples/{example.stem}.png)" in page
    assert (ROOT / "docs" / "examples" / f"{example.stem}.png").stat().st_size < 120_000
