"""README and docs: examples run, commands are executed, names and links exist, tables are those of the code."""

import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest
from doc_tables import PAGES, ROOT, TABLES, names_in, written
from pages import TUTORIALS, without_code
from size import words_by_hand

from bearing_twin.base.yaml_files import SCENES
from bearing_twin.charts import CHARTS, chart_of
from bearing_twin.command import cli
from bearing_twin.command.node_command import NODES
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.bearing.catalogue import read_entries
from bearing_twin.log.stream import topics
from bearing_twin.run.scene import load_scene, parse_scene, scene_names
from bearing_twin.uq.study import load_study, parse_study, study_names

pytestmark = pytest.mark.usefixtures("pictures_once")

TEXTS = {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in PAGES}
MOST_WORDS = 1000
SHORT, FEW = 0.01, 128  # s of a bearing's run, samples of a study: enough to see that a command works
TO_CUT = 0.2  # s of a run whose log is then cut off, and must hold something that can be saved
WRITTEN = {
    "docs/logs.md": {"whole.mcap", "run_folder", "layouts", "again.png"}
}  # files that the commands of a page write
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", flags=re.DOTALL | re.MULTILINE)


def blocks(language):
    """(page, text) of every block of code in that language."""
    return [
        (page, text)
        for page, page_text in TEXTS.items()
        for block_language, text in _BLOCK.findall(page_text)
        if block_language == language
    ]


def lines(first_words):
    """(page, line without its comment) of the shell commands that begin with those words."""
    commands = [(page, line.split("  #")[0].strip()) for page, text in blocks("bash") for line in text.splitlines()]
    return [(page, line) for page, line in commands if line.startswith(first_words)]


EXAMPLES = blocks("python")


@pytest.mark.parametrize("example", [text for _, text in EXAMPLES], ids=[page for page, _ in EXAMPLES])
def test_examples_run(example, tmp_path, monkeypatch, capsys, quick_workers):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0}, raising=False)
    exec(compile(example, "<example>", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


def test_the_readme_is_short():
    assert words_by_hand()["README.md"] <= MOST_WORDS


@pytest.mark.parametrize("page", TEXTS)
def test_tables_are_those_of_the_code(page):
    assert TEXTS[page] == written(TEXTS[page]), "write them again: python tests/doc_tables.py"


def test_every_table_stands_somewhere():
    assert {name for text in TEXTS.values() for name in names_in(text)} == set(TABLES)


def anchors(text):
    heads = re.findall(r"^#+ (.+)$", _BLOCK.sub("", text), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head).strip().lower().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", [*TEXTS, "CONTRIBUTING.md", *(str(page.relative_to(ROOT)) for page in TUTORIALS)])
def test_links_lead_somewhere(page):
    text = without_code(ROOT / page)
    for link in re.findall(r"\]\(([^)]+)\)", text):
        if "://" in link:
            continue  # of others
        path, _, anchor = link.partition("#")
        target = (ROOT / page).parent / path if path else ROOT / page
        assert target.exists(), f"{page} links to {link}"
        assert not anchor or anchor in anchors(target.read_text(encoding="utf-8")), f"{page} links to {link}"


# Commands


def shorten(arguments, short=SHORT):
    """The arguments of a shorter command, and whether it is run or only parsed."""
    command = arguments[0]
    parsed = cli.parsers(command)[0].parse_args(arguments)
    if command == "node":
        return arguments, False  # tests/test_journeys.py runs them
    if command == "simulate":
        overrides = [*parsed.set, *([f"run.duration={parsed.duration}"] if parsed.duration else [])]
        scene = load_scene(parsed.scene, overrides)
        key = "--set=run.duration" if any("run.duration=" in override for override in parsed.set) else "--duration"
        less = ["--set=mesh.divisions=8"] if scene.kind == "soft_discs" else []
        return [*arguments, *less, *([f"{key}={short}"] if scene.parameters.run.duration > short else [])], True
    if command == "study" and parsed.study:
        study = load_study(parsed.study, parsed.set)
        closed = KINDS[study.kind].parameters().closed_form() is not None
        return [*arguments, f"--samples={FEW}", "--workers=1", *ends_of_sweep(study)], closed
    if command == "view" and not parsed.source.endswith(".mcap"):
        if not (parsed.study or parsed.source in study_names()):
            return [*arguments, f"--duration={SHORT}"], not parsed.gif
        study = load_study(parsed.source, parsed.set)
        closed = KINDS[study.kind].parameters().closed_form() is not None
        return [*arguments, f"--set=samples={FEW}", "--set=workers=1", *ends_of_sweep(study)], closed
    if command == "bearing" and parsed.sweep:
        return [re.sub(r"^(\w+=[^:]+:[^:]+):\d+$", r"\1:3", argument) for argument in arguments], True
    if command == "chart":
        known = chart_of(parsed.chart).problems if parsed.problem else ()
        assert set(parsed.problem or ()) <= set(known)
        return arguments, parsed.list
    return arguments, command not in ("spectrum", "watch")  # the first reads records that a user has


def ends_of_sweep(study):
    """An override that reduces the sweep of a study to its ends."""
    if study.sweep is None:
        return []
    key, values = study.sweep
    return [f"--set=sweep={{{key}: {[values[0], values[-1]]}}}"]


@pytest.mark.parametrize("page", sorted({page for page, _ in lines("bearing_twin ")}))
def test_commands_work(page, tmp_path, monkeypatch, capsys, quick_workers):
    """In the order of the page, in one folder: a log that one line writes is there for the next."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs" / "charts").mkdir(parents=True)
    mine = [line for command_page, line in lines(("bearing_twin ", "head ")) if command_page == page]
    short = TO_CUT if any(line.startswith("head") for line in mine) else SHORT
    for line in mine:
        if line.startswith("head"):
            subprocess.run(line, shell=True, check=True)
            *_, log, _, cut_log = line.split()
            assert Path(cut_log).stat().st_size < Path(log).stat().st_size
            continue
        arguments, run = shorten(shlex.split(line.partition(" > ")[0])[1:], short)
        if run:
            assert cli.main(arguments) == cli.DONE, (line, capsys.readouterr().err)
            assert capsys.readouterr().out.strip(), line
    written_files = {path.name for path in tmp_path.iterdir()}
    assert WRITTEN.get(page, set()) <= written_files
    assert {Path(name).suffix for name in written_files} >= ({".mcap"} if "--out run" in TEXTS[page] else set())


def test_files_shown_are_read():
    shown = blocks("yaml")
    assert len(shown) >= 2
    for _, text in shown:
        data = SCENES.load(text, "shown")
        catalogue = all(isinstance(row, dict) and "bore" in row for row in data.values())
        read = read_entries if catalogue else parse_study if "scene" in data else parse_scene
        read(data, "shown")


def test_charts_and_make_targets_exist():
    named = {shlex.split(line)[2] for _, line in lines("bearing_twin chart")}
    assert {"all", "--list"} <= named <= {*CHARTS, "all", "--list"}
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for _, line in lines("make "):
        assert re.search(rf"^{line.split()[1]}:", makefile, flags=re.MULTILINE), line


def test_nodes_topics_and_launch_files_exist():
    setup = (ROOT / "setup.py").read_text(encoding="utf-8")
    known = {topic.full_name for name in scene_names() for topic in topics(load_scene(name))}
    commands = {f"{kind.namespace}/{command.name}" for kind in KINDS.values() for command in kind.commands()}
    for _, line in lines("ros2 run"):
        assert f'"{line.split()[3]} = ' in setup, line
    for _, line in lines("ros2 launch"):
        assert (ROOT / "launch" / line.split()[3]).is_file(), line
    for _, line in lines("bearing_twin node start"):
        assert line.split()[3] in NODES, line
    for _, line in lines("bearing_twin node topic"):
        (topic,) = (word for word in line.split() if word.startswith("/"))
        assert topic in known | commands, line
