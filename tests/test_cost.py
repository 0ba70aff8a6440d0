"""Cost of a run, stated before it begins, and the time left while it goes on."""

import sys

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


@pytest.mark.parametrize("terminal_there", [True, False])
def test_progress_is_shown_on_a_terminal_alone(terminal_there, monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal_there)
    monkeypatch.setenv("TERM", "xterm")
    with terminal.progress("a work") as update, terminal.progress("its part") as part:
        update(0.5)
        part(0.25)
        terminal.say("a sentence")
    out, err = capsys.readouterr()
    assert out == ""
    assert "a sentence\n" in err
    for words in ("a work", "50%"):
        assert (words in err) == terminal_there
