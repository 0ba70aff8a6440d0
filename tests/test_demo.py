"""`make demo`, shortened: three nodes as processes, nothing lost, and the files it names."""

import os
import re
import subprocess
import sys
from pathlib import Path

import ros  # noqa: F401  (skips where ROS is missing)

from bearing_twin.log.mcap_log import read_log


def test_the_demo_ends_with_a_table_a_log_and_a_picture(tmp_path):
    result = subprocess.run(
        [sys.executable, "-m", "bearing_twin.nodes.entry", "demo", "--duration", "1", "--out", str(tmp_path)],
        env=os.environ | {"ROS_DOMAIN_ID": str(10 + os.getpid() % 90), "COLUMNS": "80"},
        capture_output=True,
        text=True,
        timeout=3600,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert "samples lost: 0 live, 0 recorded, 0 replayed" in result.stdout
    rows = re.findall(r"^│\s*(\d)│.*│\s*(\d+)│\s*(\d+\.\d)│\s*(\d+)│$", result.stdout, re.MULTILINE)
    assert [int(ball) for ball, *_ in rows] == list(range(8))
    assert {(int(wrenches), int(lost)) for _, wrenches, _, lost in rows} == {(101, 0)}
    log = Path(re.search(r"^log: +(.+)$", result.stdout, re.MULTILINE)[1])
    picture = Path(re.search(r"^picture: +(.+)$", result.stdout, re.MULTILINE)[1])
    assert [sample.sequence for sample in read_log(log)] == list(range(1001))
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert all(len(line) <= 80 for line in result.stdout.splitlines() if line.startswith(("│", "┃")))
