"""What a run takes, told before it begins, and the time left while it goes on."""

import numpy as np
import pytest

from bearing_twin.command import terminal
from bearing_twin.command.cli import DONE, main
from bearing_twin.log.run_log import write_log
from bearing_twin.run import simulation as cost
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import cost_of, simulate


@pytest.mark.parametrize("balls", [8, 3])
def test_the_log_is_as_large_as_told(balls, tmp_path):
    pinned = ("run.duration=2", "solver.stepper=rodas4", "contact.normal=hertz", f"geometry.balls={balls}")
    scene = load_scene("bearing_6203", pinned)
    written = write_log(simulate(scene), tmp_path / "run.mcap")
    told = cost_of(scene)
    assert (told.outputs, told.sentence(True, np.inf)) == (written.samples, "")
    assert 0.8 < written.bytes / told.log_bytes < 1.25


def test_a_large_run_is_announced_before_it_begins(tmp_path, monkeypatch, capsys):
    told = cost_of(load_scene("bearing_6203", ["run.duration=86400"]))
    assert 3e11 < told.log_bytes < 6e11
    assert f"a log of about {told.log_bytes:.2g} B where 1e+09 B are free" in told.sentence(True, 1e9)
    monkeypatch.setattr(cost, "LARGE", 1e6)
    words = ["simulate", "bearing_6203", "--duration", "0.3", "--json"]
    assert main([*words, "--out", str(tmp_path / "run.mcap")]) == DONE
    assert "bearing_6203: 301 outputs, a log of about 1." in capsys.readouterr().err
    assert main(words) == DONE
    assert "a log" not in capsys.readouterr().err


def test_the_time_left_is_told(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(terminal.time, "monotonic", lambda: now[0])
    with terminal.progress("it") as update:
        for k in range(1, 101):
            now[0] += 2.0
            update(0.01 * k)
    said = capsys.readouterr().err.splitlines()
    assert said[:2] == ["it: 1 %", "it: about 3 min to go"]
    assert "it: 52 %, about 96 s left" in said
    assert said[-1] == "it: done in 200.0 s"
    with terminal.progress("short") as update:
        for share in (0.1, 0.5, 1.0):
            now[0] += 0.4
            update(share)
    assert "to go" not in capsys.readouterr().err
