"""Examples: short, told in the docs, and each runs and draws its picture."""

import runpy
from pathlib import Path

import matplotlib
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
MOST_LINES = 40
NEEDS_ROS = {"live"}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_draws(example, tmp_path, monkeypatch, capsys):
    if example.stem in NEEDS_ROS:
        import ros  # noqa: F401  (skips where ROS is missing)
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")
    runpy.run_path(str(example), run_name="__main__")
    matplotlib.pyplot.close("all")
    assert capsys.readouterr().out.strip()
    picture = matplotlib.image.imread(tmp_path / f"{example.stem}.png")
    assert 600 <= picture.shape[1] <= 1000
    colours = np.unique(np.round(picture.reshape(-1, picture.shape[-1]), 2), axis=0)
    assert len(colours) > 20


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_in_the_docs(example):
    assert len(example.read_text(encoding="utf-8").splitlines()) <= MOST_LINES
    page = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
    assert f"{{literalinclude}} ../examples/{example.name}" in page
    assert f"](examples/{example.stem}.png)" in page
    assert (ROOT / "docs" / "examples" / f"{example.stem}.png").stat().st_size < 120_000
