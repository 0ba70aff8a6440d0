"""`make demo`, shortened: three nodes as processes, nothing lost, and the files it names."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import ros  # noqa: F401  (skips where ROS is missing)

from bearing_twin.log.run_log import read_log
from bearing_twin.nodes import demo


@pytest.mark.environment
def test_the_demo_ends_with_a_table_a_log_and_a_picture(tmp_path):
    result = subprocess.run(
        [sys.executable, "-m", "bearing_twin.nodes.entry", "demo", "--duration", "1", "--out", str(tmp_path)],
        env=os.environ | {"COLUMNS": "80"},
        capture_output=True,
        text=True,
        timeout=3600,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert "samples lost: 0 live, 0 recorded, 0 replayed" in result.stdout
    rows = re.findall(r"^│\s*(\d)│.*│\s*(\d+)│\s*(\d+)│$", result.stdout, re.MULTILINE)
    assert [int(ball) for ball, *_ in rows] == list(range(8))
    assert {(int(wrenches), int(lost)) for _, wrenches, lost in rows} == {(101, 0)}
    log = Path(re.search(r"^log: +(.+)$", result.stdout, re.MULTILINE)[1])
    picture = Path(re.search(r"^picture: +(.+)$", result.stdout, re.MULTILINE)[1])
    page = Path(re.search(r"^browser: +(.+)$", result.stdout, re.MULTILINE)[1])
    assert "<title>bearing_6203_load_and_speed" in page.read_text(encoding="utf-8")
    assert len(result.stdout.partition("browser:")[2].splitlines()) == 4  # the path, and what to look at
    assert [sample.sequence for sample in read_log(log)] == list(range(1001))
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert all(len(line) <= 80 for line in result.stdout.splitlines() if line.startswith(("│", "┃")))


def test_a_part_that_fails_names_its_output_and_what_to_do(tmp_path, here, monkeypatch, quick_starts):
    right = demo.node_command
    monkeypatch.setattr(demo, "node_command", lambda name, wanted: right(name, {**wanted, "no_such_parameter": 1}))
    done = here("demo", "--out", str(tmp_path))
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    named = re.search(r"Its output is in (\S+_node\.txt)\. Correct the cause named there, or try again", done.stderr)
    assert "_node: " in Path(named[1]).read_text()


def test_a_scene_that_is_no_bearing_is_refused(tmp_path, here):
    done = here("demo", "--scene", "two_spheres", "--out", str(tmp_path))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "two_spheres is no bearing" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("given", ["0", "10", "99", None])
def test_the_demo_has_a_domain_of_its_own(monkeypatch, given):
    monkeypatch.setattr(demo.os, "environ", {} if given is None else {"ROS_DOMAIN_ID": given})
    for process in range(90):
        monkeypatch.setattr(demo.os, "getpid", lambda process=process: process)
        demo._keep_to_itself()
        assert demo.os.environ["ROS_DOMAIN_ID"] != (given or "0")
        assert 10 <= int(demo.os.environ["ROS_DOMAIN_ID"]) <= 100
        demo.os.environ.pop("ROS_DOMAIN_ID")
        if given is not None:
            demo.os.environ["ROS_DOMAIN_ID"] = given
