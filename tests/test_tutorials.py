"""Tutorials: every command and program in them runs, page by page; what needs nodes runs in the journeys."""

import contextlib
import io
import re

import pytest
from pages import ROOT, TUTORIALS, blocks, without_code, words_of

from bearing_twin.command import cli

pytestmark = pytest.mark.usefixtures("quick_pictures")

ON_THE_MACHINE = (
    "make ",
    "source ",
    "python ",
)  # run by the journeys (tests/test_journeys.py), as lines that need nodes
FEWER = re.compile(r"\b(samples[:=] ?|sensitivity=)\d+")  # realisations, which take longer than what is done with them
EDITS = "your_law"  # run by tests/test_docs.py


@pytest.mark.parametrize("page", [one for one in TUTORIALS if one.stem != EDITS], ids=lambda page: page.stem)
def test_a_tutorial_runs_from_top_to_bottom(page, tmp_path, monkeypatch, capsys, quick_workers):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("bearing_twin.uq.workers.usable", lambda: 1)
    ran = 0
    for block in blocks(page):
        text = FEWER.sub(r"\g<1>12", block.text)
        if block.file:
            (tmp_path / block.file).write_text(text, encoding="utf-8")
            if block.language == "python":
                compile(block.text, block.file, "exec")
        elif block.language == "python":
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                exec(compile(text, str(page), "exec"), {})
            assert said.getvalue().strip()
        elif block.language == "bash":
            ran += sum(follow(line, capsys) for line in block.lines)
    assert ran


def follow(line, capsys) -> bool:
    """Runs a line where no node is needed for it; one for the parser alone counts not."""
    if line.startswith(ON_THE_MACHINE):
        return False
    assert line.startswith("bearing_twin "), line
    words = words_of(FEWER.sub(r"\g<1>12", line))
    cli._parsers(words[0])[0].parse_args(words)
    if words[0] == "node":
        return False
    if words[0] == "study" and "--list" not in words:
        words.append("--workers=1")  # starting another process takes longer than so few samples
    assert cli.main(words) == cli.DONE, (line, capsys.readouterr().err)
    assert capsys.readouterr().out.strip(), line
    return True


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_links_of_tutorials_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", without_code(page))
    assert all((page.parent / link).exists() for link in links if "://" not in link), links


def test_every_tutorial_is_in_the_index():
    index = (ROOT / "docs" / "tutorials" / "index.md").read_text(encoding="utf-8")
    assert {page.stem for page in TUTORIALS} <= set(re.findall(r"^(\w+)$", index, flags=re.MULTILINE))
