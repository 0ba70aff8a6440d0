"""Documentation: tutorials run, examples draw, pages are built; lines that need nodes are run by the journeys."""

import contextlib
import importlib.util
import io
import json
import os
import re
import runpy
import shutil
import subprocess
import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from pages import ROOT, TUTORIALS, blocks, words_of
from PIL import Image

from bearing_twin.command import cli
from bearing_twin.command.node_command import node_arguments

ON_THE_MACHINE = ("make ", "source ", "python ")  # run by tests/test_journeys.py, as lines that need nodes
FEWER = re.compile(r"\b(samples[:=] ?|sensitivity=)\d+")  # realisations, which take longer than what is done with them
EDITS = "your_law"  # which the last test follows


@pytest.mark.parametrize("page", [page for page in TUTORIALS if page.stem != EDITS], ids=lambda page: page.stem)
def test_a_tutorial_runs_from_top_to_bottom(page, tmp_path, monkeypatch, capsys, quick_workers, pictures_once):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0}, raising=False)
    ran = 0
    for block in blocks(page):
        text = FEWER.sub(r"\g<1>12", block.text)
        if block.file:
            (tmp_path / block.file).write_text(text, encoding="utf-8")
            if block.language == "python":
                compile(block.text, block.file, "exec")
        elif block.language == "python":
            output = io.StringIO()
            with contextlib.redirect_stdout(output):
                exec(compile(text, str(page), "exec"), {})
            assert output.getvalue().strip()
        elif block.language == "bash":
            ran += sum(follow(line, capsys) for line in block.lines)
    assert ran


def follow(line, capsys) -> bool:
    """Runs a line where no node is needed for it; one for the parser alone counts not."""
    if line.startswith(ON_THE_MACHINE):
        return False
    assert line.startswith("bearing_twin "), line
    arguments = words_of(FEWER.sub(r"\g<1>12", line))
    cli.parsers(arguments[0])[0].parse_args(arguments)
    if arguments[0] == "node":
        return False
    if arguments[0] == "study" and "--list" not in arguments:
        arguments.append("--workers=1")  # starting another process takes longer than so few samples
    assert cli.main(arguments) == cli.DONE, (line, capsys.readouterr().err)
    assert capsys.readouterr().out.strip(), line
    return True


def test_every_tutorial_is_in_the_index():
    index = (ROOT / "docs" / "tutorials" / "index.md").read_text(encoding="utf-8")
    assert {page.stem for page in TUTORIALS} <= set(re.findall(r"^(\w+)$", index, flags=re.MULTILINE))


EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
MOST_LINES = 40
NEEDS_ROS = {"live"}


def answer_here(run):
    """`subprocess.run`, but commands of this package are answered by this process: starting another takes seconds."""

    def run_here(arguments, **options):
        if arguments[0] != "bearing_twin":
            return run(arguments, **options)
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            code = cli.main(arguments[1:])
        assert code == cli.DONE or not options.get("check")
        return subprocess.CompletedProcess(arguments, code, output.getvalue(), "")

    return run_here


PROGRAM = subprocess.Popen


def start_node_directly(arguments):
    """`bearing_twin node start` as the process that it becomes, which has imported what it needs."""
    assert arguments[:3] == ["bearing_twin", "node", "start"]
    return PROGRAM([sys.executable, *node_arguments(arguments[3], arguments[4:])])


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
    monkeypatch.setattr(subprocess, "run", answer_here(subprocess.run))
    monkeypatch.setattr(subprocess, "Popen", start_node_directly)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0}, raising=False)
    matplotlib.use("Agg")
    runpy.run_path(str(example), run_name="__main__")
    hidden = [axes for figure in map(plt.figure, plt.get_fignums()) for axes in figure.axes if covers_a_curve(axes)]
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


@pytest.mark.environment
def test_the_pages_are_built_without_a_warning_and_without_a_network(tmp_path):
    if importlib.util.find_spec("sphinx") is None and not os.environ.get("CI"):
        pytest.skip("Sphinx is not installed: `make docs` installs it")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", ROOT / "docs", tmp_path]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join((str(ROOT), os.environ.get("PYTHONPATH", "")))}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pages = list(tmp_path.rglob("*.html"))
    built = {page.relative_to(tmp_path).with_suffix("").as_posix() for page in pages}
    assert built >= {"index", "api", "reference", "examples", *(f"tutorials/{page.stem}" for page in TUTORIALS)}
    for page in pages:
        fetched = re.findall(
            r"""<(?:script|img|link)[^>]+(?:src|href)=["'](https?:[^"']+)""", page.read_text(encoding="utf-8")
        )
        assert fetched == [], page
    api = (tmp_path / "api.html").read_text(encoding="utf-8")
    assert "A scene by its name, its file or its plain data" in api


def apply_edit(block, folder) -> bool:
    """Edits a file below the folder as the first line of a block says; False of blocks that are no edits."""
    head, _, code = block.text.partition("\n")
    match = re.fullmatch(r'(?:#|//) (\S+), (in place of|before|after) the line "(.+)"', head)
    if not match:
        return False
    path, position, begin = folder / match[1], match[2], match[3]
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    (index,) = (number for number, line in enumerate(lines) if line.startswith(begin))
    lines[index + (position == "after") : index + (position != "before")] = [code]
    path.write_text("".join(lines), encoding="utf-8")
    return True


@pytest.mark.environment
def test_the_law_of_the_tutorial_is_a_law_of_the_checkout(tmp_path):
    """Its blocks go where they say; an elastic impact is as long as c^(-2/5), and its force as c^(2/5)."""
    for folder in ("bearing_twin", "config", "core"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__", "_core"))
    shutil.copy(ROOT / "package.xml", tmp_path)
    (page,) = (page for page in TUTORIALS if page.stem == "your_law")
    assert sum(apply_edit(block, tmp_path) for block in blocks(page)) == 5
    for room in ("bearing", "shaft", "beam", "soft_discs"):  # no command below calls them: they need not be compiled
        for unit in (tmp_path / "core" / room).glob("*.cpp"):
            unit.unlink()
    subprocess.run([sys.executable, "core/build.py", "--flags=-O0"], cwd=tmp_path, check=True)

    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {
        "PYTHONPATH": str(tmp_path)
    }

    def reported(*arguments):
        command = [sys.executable, "-m", "bearing_twin", *arguments, "--json"]
        return json.loads(
            subprocess.run(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, check=True).stdout
        )

    forces = [
        reported("simulate", "two_spheres", "--set", f"contact.normal={law}")["peak_force_n"]
        for law in ("coated", "hertz")
    ]
    assert forces[0] / forces[1] == pytest.approx(0.85**0.4, rel=1e-6)
    assert "coated" in json.dumps(reported("contact", "--bearing", "6203", "--race", "inner", "--load", "50"))
