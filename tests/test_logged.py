"""A run on its way into a log that cannot grow: its figures are shown, and why the log is incomplete."""

import errno
import json
import os

import pytest
from forks import forked

from bearing_twin.command.cli import BAD_INPUT, main
from bearing_twin.log.mcap_log import read_log

LONG = ("bearing_6203", "--set", "run.output_rate=4000", "--duration", "0.3")  # a log of 5 MB
SMALL = 3_000_000  # bytes
FOR_MACHINES = {"compile_s", "compute_s", "real_time_factor"}


@pytest.fixture(scope="module")
def whole():
    """Figures of the run where nobody logs it."""
    done = forked(lambda: main(["simulate", *LONG, "--json"]))
    return told(done)


def told(done) -> dict:
    return {key: one for key, one in json.loads(done.stdout).items() if key not in FOR_MACHINES}


def test_a_run_whose_log_has_no_room_goes_on_to_its_end(whole, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = forked(lambda: main(["simulate", *LONG, "--out", "run.mcap", "--json"]), largest_file=SMALL)
    assert done.returncode == BAD_INPUT
    assert told(done) == whole
    (line,) = [one for one in done.stderr.splitlines() if one.startswith("bearing_twin: the log is")]
    assert "the log is incomplete: run.mcap cannot grow (File too large): " in line
    assert "run.mcap cannot grow" in done.stderr.partition("the run goes on without it")[0]
    samples = list(read_log("run.mcap"))
    assert 0 < len(samples) < whole["samples"]


def test_a_run_that_breaks_off_and_whose_log_cannot_be_ended_tells_both(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write = os.pwritev

    def full(file, parts, offset):
        if offset > 10_000:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(file, parts, offset)

    monkeypatch.setattr(os, "pwritev", full)
    words = ("rings.inner.change.time=0.0105", "rings.inner.change.load=[0, -7e5, 0]", "cage.kind=none")
    assert main(["simulate", "bearing_6203_rig_400N", *(f"--set={one}" for one in words), "--out", "run.mcap"]) == 2
    out, error = capsys.readouterr()
    assert "failed: overload" in out
    for sentence in ("the log is incomplete: run.mcap cannot grow", "a load of", "bearing_twin explain failure_"):
        assert sentence in " ".join(error.split())


def test_a_log_that_cannot_be_begun_ends_the_command_before_anything_is_computed(tmp_path, monkeypatch, capsys):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "pwritev", full)
    assert main(["simulate", *LONG, "--out", str(tmp_path / "run.mcap")]) == BAD_INPUT
    out, error = capsys.readouterr()
    assert not out
    assert "run.mcap cannot be written (" in error
    assert "log is incomplete" not in error
    assert not list(tmp_path.iterdir())
