"""Cost of a run, stated before it begins, and the time left while it goes on."""

import sys
import time

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
    reported = cost_of(scene)
    assert (reported.outputs, reported.sentence(True, np.inf)) == (written.samples, "")
    assert 0.8 < written.bytes / reported.log_bytes < 1.25


def test_a_large_run_is_announced_before_it_begins(tmp_path, monkeypatch, capsys):
    reported = cost_of(load_scene("bearing_6203", ["run.duration=86400"]))
    assert 3e11 < reported.log_bytes < 6e11
    assert f"a log of about {reported.log_bytes:.2g} B where 1e+09 B are free" in reported.sentence(True, 1e9)
    monkeypatch.setattr(cost, "LARGE", 1e6)
    words = ["simulate", "bearing_6203", "--duration", "0.3", "--json"]
    assert main([*words, "--out", str(tmp_path / "run.mcap")]) == DONE
    assert "bearing_6203: 301 outputs, a log of about 1." in capsys.readouterr().err
    assert main(words) == DONE
    assert "a log" not in capsys.readouterr().err


def test_the_time_left_is_told():
    now = [0.0]
    work = terminal.Progress("it", lambda: now[0])
    now[0] = 7.0
    assert work.line() == "it: 7 s so far"
    for k in range(1, 53):
        now[0] += 2.0
        work.update(0.01 * k)
    assert work.line().startswith("it: ━━━━━━━━━━━━····")
    assert work.line().endswith(" 52 %, 96 s left")


@pytest.mark.parametrize("terminal_there", [True, False])
def test_progress_is_shown_after_a_second_on_one_line_of_a_terminal(terminal_there, monkeypatch, capsys):
    monkeypatch.setattr(terminal, "SLOW", 0.1)
    monkeypatch.setattr(terminal, "REFRESH", 0.01)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal_there)
    with terminal.progress("it") as update:
        update(0.5)
        time.sleep(0.5)
    said = capsys.readouterr().err
    assert said.count("it: ━") > 1 if terminal_there else said.count("it: ━") == 1
    assert said.count("\n") == (1 if terminal_there else 2)
    assert "it: done in " in said
    monkeypatch.undo()
    with terminal.progress("short") as update:
        update(1.0)
    assert capsys.readouterr().err == ""
