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
    package, found = manifest
    warnings = []
    found.validate(warnings)
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
    names = [re.split(r"[<>=]", one)[0] for one in setup_words["install_requires"]]
    assert set(names) == set(ROSDEP)
    assert {ROSDEP[name] for name in names} <= {one.name for one in manifest[1].exec_depends}


def test_what_a_workspace_adds_is_part_of_what_is_required(setup_words):
    required = {re.split(r"[<>=]", one)[0]: one for one in setup_words["install_requires"]}
    lines = (ROOT / "requirements" / "workspace.txt").read_text(encoding="utf-8").splitlines()
    added = [line for line in lines if line and not line.startswith("#") and not line.startswith("numpy")]
    assert all(required[re.split(r"[<>=]", line)[0]] == line for line in added)


def test_the_pythons_are_those_of_the_classifiers(setup_words):
    minors = {one.rpartition("3.")[2] for one in setup_words["classifiers"] if ":: 3." in one}
    assert minors == {"10", "11", "12", "13"}
    assert setup_words["python_requires"] == ">=3.10,<3.14"


# What ament_copyright asks of a repository, which PyPI has not; `reuse lint` of `make lint` judges the files


def tracked(*endings):
    """Files of the checkout that git knows, or all where there is no git, with these endings."""
    done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    names = (
        done.stdout.splitlines()
        if done.returncode == 0 and done.stdout
        else [
            str(one.relative_to(ROOT))
            for folder in ("bearing_twin", "msg_schemas", "tests")
            for one in (ROOT / folder).rglob("*")
        ]
    )
    return [ROOT / name for name in names if name.endswith(endings) and (ROOT / name).is_file()]


def test_the_licence_is_whole_and_every_package_names_it(manifest):
    package, found = manifest
    text = (ROOT / "LICENSE").read_text(encoding="utf-8")
    for part in ("Apache License", "Version 2.0, January 2004", "9. Accepting Warranty", "END OF TERMS AND CONDITIONS"):
        assert part in text
    assert found.licenses[0].file == "LICENSE"
    for path in tracked("package.xml"):
        assert package.parse_package(str(path)).licenses == ["Apache-2.0"], path
    contributing = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert " ".join(contributing.split("~~~")[1].split()) in " ".join(text.split())
    assert (ROOT / "LICENSES" / "Apache-2.0.txt").read_text(encoding="utf-8") == text


def test_files_of_others_stand_beside_their_licences_and_nowhere_else():
    foreign = ROOT / "bearing_twin" / "view" / "libraries"
    reported = (foreign / "LICENSES.txt").read_text(encoding="utf-8")
    assert {"three.js", "uPlot"} == set(re.findall(r"^([\w.]+) \d+\.\d+\.\d+$", reported, flags=re.MULTILINE))
    assert reported.count("Permission is hereby granted") == reported.count("WITHOUT WARRANTY") == 2
    rows = re.findall(r'path = "(.*)"\n.*Text = "(.*)"\n.*"(.*)"', (ROOT / "REUSE.toml").read_text(encoding="utf-8"))
    assert rows[0][0] == "**"
    assert {row[2] for row in rows[1:]} == {"MIT"}
    covered = [path for pattern, holder, _ in rows[1:] if holder in reported for path in ROOT.glob(pattern)]
    assert {*covered} == {*foreign.iterdir()} - {foreign / "LICENSES.txt", foreign / "three_entry.js"}
    others = re.compile(r"copyright\s+(\(c\)|©|\d{4})|SPDX-License-Identifier|licensed under", re.IGNORECASE)
    for path in tracked(".py", ".js", ".css", ".msg", ".srv", ".action", ".cmake", ".bash", ".html"):
        if foreign not in path.parents and path != Path(__file__):
            assert not others.search(path.read_text(encoding="utf-8")), f"{path} carries the licence of somebody else"
