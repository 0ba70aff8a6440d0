"""The documentation is built, whole and for use without a network; the law of the tutorial works in a checkout."""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys

import pytest
from pages import ROOT, TUTORIALS, blocks

pytestmark = pytest.mark.environment


def test_the_pages_are_built_without_a_warning_and_without_a_network(tmp_path):
    if importlib.util.find_spec("sphinx") is None and not os.environ.get("CI"):
        pytest.skip("Sphinx is not installed: `make docs` installs it")
    words = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", ROOT / "docs", tmp_path]
    there = os.environ | {"PYTHONPATH": os.pathsep.join((str(ROOT), os.environ.get("PYTHONPATH", "")))}
    done = subprocess.run(words, env=there, capture_output=True, text=True, check=False)
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
    assert "The scene of that name or YAML file" in api


def placed(block, folder) -> bool:
    """Edits a file below the folder as the first line of a block says; False of blocks that are no edits."""
    head, _, code = block.text.partition("\n")
    found = re.fullmatch(r'(?:#|//) (\S+), (in place of|before|after) the line "(.+)"', head)
    if not found:
        return False
    path, where, begin = folder / found[1], found[2], found[3]
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    (place,) = (number for number, line in enumerate(lines) if line.startswith(begin))
    lines[place + (where == "after") : place + (where != "before")] = [code]
    path.write_text("".join(lines), encoding="utf-8")
    return True


def test_the_law_of_the_tutorial_is_a_law_of_the_checkout(tmp_path):
    """Its blocks go where they say; an elastic impact is as long as c^(-2/5), and its force as c^(2/5)."""
    for folder in ("bearing_twin", "config", "core"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__", "_core"))
    shutil.copy(ROOT / "package.xml", tmp_path)
    (page,) = (page for page in TUTORIALS if page.stem == "your_law")
    assert sum(placed(block, tmp_path) for block in blocks(page)) == 5
    for room in ("bearing", "shaft", "beam", "soft_discs"):  # no command below calls them: they need not be compiled
        for unit in (tmp_path / "core" / room).glob("*.cpp"):
            unit.unlink()
    subprocess.run([sys.executable, "core/build.py", "--flags=-O0"], cwd=tmp_path, check=True)

    there = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"PYTHONPATH": str(tmp_path)}

    def reported(*words):
        command = [sys.executable, "-m", "bearing_twin", *words, "--json"]
        return json.loads(subprocess.run(command, cwd=tmp_path, env=there, stdout=subprocess.PIPE, check=True).stdout)

    forces = [
        reported("simulate", "two_spheres", "--set", f"contact.normal={law}")["peak_force_n"]
        for law in ("coated", "hertz")
    ]
    assert forces[0] / forces[1] == pytest.approx(0.85**0.4, rel=1e-6)
    assert "coated" in json.dumps(reported("contact", "--bearing", "6203", "--race", "inner", "--load", "50"))
