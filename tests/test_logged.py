"""A run on its way into a log that ends before it: its figures are shown, and why the log is incomplete."""

import errno
import json
import os
import re
from types import SimpleNamespace

import pytest
from processes import forked
from runs import full_after, no_room

from bearing_twin.command.cli import BAD_INPUT, DONE, DOUBTFUL, main
from bearing_twin.log.raw_log import recover
from bearing_twin.log.run_log import LogWriter, read_log, write_log
from bearing_twin.log.stream import MessageStream, choice_record
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import Run, simulate

LONG = ("bearing_6203", "--set", "run.output_rate=4000", "--duration", "0.3")  # a log of 5 MB
SMALL = 3_000_000  # bytes
FOR_MACHINES = {"compute_s", "real_time_factor"}


@pytest.fixture(scope="module")
def whole():
    """Figures of the run where nobody logs it."""
    done = forked(lambda: main(["simulate", *LONG, "--json"]))
    return reported(done)


def reported(done) -> dict:
    return {key: value for key, value in json.loads(done.stdout).items() if key not in FOR_MACHINES}


def test_a_run_whose_log_has_no_room_goes_on_to_its_end(whole, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = forked(lambda: main(["simulate", *LONG, "--out", "run.mcap", "--json"]), largest_file=SMALL)
    assert done.returncode == BAD_INPUT
    assert reported(done) == whole
    (line,) = re.findall("^bearing_twin: the log is.*", done.stderr, re.MULTILINE)
    assert "the log is incomplete: run.mcap cannot grow (File too large): " in line
    assert "run.mcap cannot grow" in done.stderr.partition("the run goes on without it")[0]
    samples = list(read_log("run.mcap"))
    assert 0 < len(samples) < whole["samples"]


def test_a_run_that_breaks_off_and_whose_log_cannot_be_ended_tells_both(tmp_path, monkeypatch, run_cli):
    monkeypatch.chdir(tmp_path)
    write = os.pwritev
    full = lambda file, parts, offset: (no_room if offset > 10_000 else write)(file, parts, offset)  # noqa: E731
    monkeypatch.setattr(os, "pwritev", full)
    overrides = ("rings.inner.change.time=0.0105", "rings.inner.change.load=[0, -7e5, 0]", "cage.kind=none")
    options = [f"--set={override}" for override in overrides]
    out, error = run_cli("simulate", "bearing_6203_rig_400N", *options, "--out", "run.mcap", code=BAD_INPUT)
    assert "failed: overload" in out
    for sentence in ("the log is incomplete: run.mcap cannot grow", "a load of", "bearing_twin explain failure_"):
        assert sentence in " ".join(error.split())


@pytest.mark.parametrize("out", ["run.mcap", "bag"])
@pytest.mark.parametrize("written", [0, 1])
def test_a_run_whose_log_has_no_room_to_begin_goes_on_without_it(out, written, whole, tmp_path, monkeypatch, run_cli):
    """Neither the head of its file nor, behind that, its scene."""
    monkeypatch.chdir(tmp_path)
    full_after(written, monkeypatch)
    out, error = run_cli("simulate", *LONG, "--out", out, "--json", code=BAD_INPUT)
    assert reported(SimpleNamespace(stdout=out)) == whole
    (line,) = re.findall("^bearing_twin: there is no log: .*", error, re.MULTILINE)
    assert line.count("No space left on device") == line.count("(") == line.count(".mcap") == 1
    assert "the run goes on without it" in error
    assert not list(tmp_path.iterdir())


def test_a_log_that_cannot_be_begun_ends_the_command_before_anything_is_computed(tmp_path, monkeypatch, run_cli):
    def broken(*_):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "pwritev", broken)
    out, error = run_cli("simulate", *LONG, "--out", tmp_path / "run.mcap", code=BAD_INPUT)
    assert not out
    assert "run.mcap cannot be written (Input/output error); give another place for the log" in error
    assert "log is incomplete" not in error
    assert not list(tmp_path.iterdir())


SHORT = load_scene("two_spheres", ["motion.first_velocity=0.1", "run.duration=2e-4", "run.output_rate=1e6"])
ENDS = "the log ends at 99 µs of the 200 µs that its scene simulates"


@pytest.fixture
def cut_short(tmp_path, monkeypatch):
    """The log of a run that Ctrl-C ends after 100 outputs."""
    monkeypatch.chdir(tmp_path)
    blocks = Run.blocks

    def interrupted(run):
        for block in blocks(run):
            yield block.part(0, 100)
            raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Run, "blocks", interrupted)
        with pytest.raises(KeyboardInterrupt):
            write_log(simulate(SHORT), "run.mcap")
    return "run.mcap"


@pytest.mark.parametrize(
    "arguments", [["report"], ["verify"], ["view"], ["export", "--to", "csv"]], ids=lambda command: command[0]
)
def test_the_log_of_an_interrupted_run_is_distinguished_from_a_finished_one(arguments, cut_short, capsys, run_json):
    command, *continued = arguments
    recover(cut_short, "saved.mcap")
    write_log(simulate(SHORT), "whole.mcap")
    for path, code in ((cut_short, DOUBTFUL), ("saved.mcap", DOUBTFUL), ("whole.mcap", DONE)):
        out = ["--out", f"tables_{path}"] if command == "export" else []
        assert main([command, path, *continued, *out, "--strict", "--force"]) == code
        assert capsys.readouterr().err.lower().count(ENDS) == (code == DOUBTFUL)
        if command in ("report", "verify") and code == DOUBTFUL:
            report = run_json(command, path)
            assert (report["log_ends_s"], report["scene_ends_s"]) == pytest.approx((9.9e-5, 2e-4))


def test_the_log_of_a_node_may_end_before_its_scene(tmp_path):
    """Its user ends it, or resets it; it tells of itself as a run does."""
    run = simulate(SHORT)
    stream, block = MessageStream(run.scene, choice=run.choice), run.simulation.advance(100)
    with LogWriter(tmp_path / "run.mcap", run.scene, choice_record(run.choice)) as log:
        log.write_messages((*stream.messages(block), *stream.flush()))
        log.note_report(run.report.record())
    log = read_log(tmp_path / "run.mcap")
    assert len(list(log)) == 100
    assert log.cut_short is None


def test_the_log_of_a_run_that_failed_says_so_alone(cut_short):
    """That it ends there is no second doubt."""
    log = read_log(cut_short)
    assert log.cut_short is None  # not read yet
    assert len(list(log)) == 100
    assert log.cut_short.scene_ends == pytest.approx(2e-4)
    log.report = {"failure": "at 1e-4 s: a number that is not finite", "failure_at_s": 1e-4}
    assert log.cut_short is None
