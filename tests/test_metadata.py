"""Descriptions of the package agree: setup.py, package.xml, citation, changelog, and keys that rosdep knows."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import bearing_twin

ROOT = Path(__file__).resolve().parent.parent
ROSDEP = {  # what pip calls it: the key of rosdep that brings it (rosdistro, rosdep/python.yaml, August 2026)
    "setuptools": "python3-setuptools",
    "numpy": "python3-numpy",
    "scipy": "python3-scipy",
    "matplotlib": "python3-matplotlib",
    "PyYAML": "python3-yaml",
    "mcap": "mcap-ros2-support",
    "lz4": "mcap-ros2-support",
    "zstandard": "mcap-ros2-support",
    "rosbags": "python3-rosbags-pip",
    "rich": "python3-rich",
}


@pytest.fixture(scope="module")
def setup_words():
    """Fields of setup.py: name, version, python_requires, install_requires and classifiers."""
    program = (
        "import setuptools, json, runpy; said = {}; setuptools.setup = lambda **words: said.update(words); "
        "runpy.run_path('setup.py'); "
        "print(json.dumps({k: v for k, v in said.items() if k != 'data_files'}, default=str))"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    return yaml.safe_load(done.stdout)


@pytest.fixture(scope="module")
def manifest():
    package = pytest.importorskip("catkin_pkg.package")
    return package, package.parse_package(str(ROOT / "package.xml"))


def test_the_manifest_is_valid(manifest):
    package, manifest_of_package = manifest
    warnings = []
    manifest_of_package.validate(warnings)
    assert warnings == []
    messages = package.parse_package(str(ROOT / "msg_schemas" / "package.xml"))
    messages.validate(warnings)
    assert warnings == []


def test_versions_and_licences_agree(setup_words):
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changelog = re.search(r"^## ([\d.]+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    texts = [(ROOT / name).read_text(encoding="utf-8") for name in ("package.xml", "msg_schemas/package.xml")]
    versions = [re.search(r"<version>([^<]+)</version>", text)[1] for text in texts]
    assert {setup_words["version"], *versions, str(citation["version"]), changelog[1]} == {bearing_twin.__version__}
    licences = [re.search(r"<license[^>]*>([^<]+)</license>", text)[1] for text in texts]
    assert {citation["license"], *licences} == {setup_words["license"]}
    assert {"cff-version", "message", "title", "authors"} <= set(citation)


def test_rosdep_can_bring_what_pip_would(setup_words, manifest):
    names = [re.split(r"[<>=]", requirement)[0] for requirement in setup_words["install_requires"]]
    assert set(names) == set(ROSDEP)
    assert {ROSDEP[name] for name in names} <= {dependency.name for dependency in manifest[1].exec_depends}


def test_what_a_workspace_adds_is_part_of_what_is_required(setup_words):
    required = {re.split(r"[<>=]", requirement)[0]: requirement for requirement in setup_words["install_requires"]}
    lines = (ROOT / "requirements" / "workspace.txt").read_text(encoding="utf-8").splitlines()
    added = [line for line in lines if line and not line.startswith("#") and not line.startswith("numpy")]
    assert all(required[re.split(r"[<>=]", line)[0]] == line for line in added)


def test_the_pythons_are_those_of_the_classifiers(setup_words):
    minors = {classifier.rpartition("3.")[2] for classifier in setup_words["classifiers"] if ":: 3." in classifier}
    assert minors == {"10", "11", "12", "13"}
    assert setup_words["python_requires"] == ">=3.10,<3.14"
