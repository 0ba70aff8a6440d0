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


def test_the_law_of_the_tutorial_is_a_law_of_the_checkout(tmp_path):
    """Its blocks go where they say; an elastic impact is as long as c^(-2/5), and its force as c^(2/5)."""
    for folder in ("bearing_twin", "config"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "package.xml", tmp_path)
    laws = tmp_path / "bearing_twin" / "contact" / "laws.py"
    (page,) = (page for page in TUTORIALS if page.stem == "your_law")
    text, placed = laws.read_text(encoding="utf-8"), 0
    for block in blocks(page):
        head, _, code = block.text.partition("\n")
        if found := re.fullmatch(r'# laws\.py, before "(.+)"', head):
            anchor = found[1].encode().decode("unicode_escape")
            assert text.count(anchor) == 1
            text, placed = text.replace(anchor, code + anchor), placed + 1
    assert placed == 2
    laws.write_text(text, encoding="utf-8")

    there = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"PYTHONPATH": str(tmp_path)}

    def told(*words):
        command = [sys.executable, "-m", "bearing_twin", *words, "--json"]
        return json.loads(subprocess.run(command, cwd=tmp_path, env=there, stdout=subprocess.PIPE, check=True).stdout)

    forces = [
        told("simulate", "two_spheres", "--set", f"contact.normal={law}")["peak_force_n"] for law in ("coated", "hertz")
    ]
    assert forces[0] / forces[1] == pytest.approx(0.85**0.4, rel=1e-6)
    assert "coated" in json.dumps(told("contact", "--bearing", "6203", "--race", "inner", "--load", "50"))
