"""Impacts are runs like any other: samples by channel, blocks, reports, resets, resolved scenes."""

import dataclasses
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from bearing_twin.command.cli import BAD_INPUT, DONE, DOUBTFUL, main
from bearing_twin.command.logged import ShownStream
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds.impact.figures import CONTACT
from bearing_twin.log.mcap_log import read_log, write_log
from bearing_twin.run.passes import simulate
from bearing_twin.run.scene import load_scene
from bearing_twin.run.verification import verify
from bearing_twin.sample import joined

pytestmark = pytest.mark.usefixtures("quick_pictures")


def test_a_run_that_ends_early_says_so():
    run = simulate(load_scene("two_spheres", ["run.duration=3.0e-5"]))
    list(run)
    assert any("before the contact does" in flag for flag in run.report.flags)


@pytest.mark.parametrize(
    "lossy",
    [
        ["contact.restitution=0.7", "contact.damping_law=hunt_crossley", "contact.restitution_speed=0.01"],
        ["contact.damping=30.0"],
        ["contact.restitution=0.08", "contact.damping_law=steady"],
    ],
)
def test_a_run_whose_duration_is_left_open_outlasts_a_contact_that_loses_most(lossy):
    """At 1 m/s; with no loss these spheres part after 0.114 ms."""
    run = simulate(load_scene("two_spheres", ["motion.first_velocity=1.0", "solver.companion=off", *lossy]))
    list(run)
    assert not any("before the contact does" in flag for flag in run.report.flags)
    assert run.report.figures["restitution"] < 0.1
    assert run.report.figures["contact_duration_s"] < run.report.simulated_seconds < 3.0e-3


def test_overrides_come_before_what_is_left_to_be_chosen():
    slow = load_scene("two_spheres", ["motion.first_velocity=0.02"])
    ratio = slow.parameters.run.duration / load_scene("two_spheres").parameters.run.duration
    assert ratio == pytest.approx(1000.0**0.2, rel=1e-3)
    assert load_scene("two_spheres", ["run.duration=1.0e-4"]).parameters.run.duration == 1e-4


def test_a_force_that_is_assumed_never_reports_success():
    run = simulate(load_scene("sphere_on_beam", ["solver.stepper=sinusoidal"]))
    list(run)
    assert run.report.status == "failed: energy"
    assert math.isfinite(run.report.figures["peak_stress_pa"])


def test_a_picture_that_cannot_be_written_takes_no_figure_along(tmp_path, monkeypatch, capsys):
    def refuse(*_):
        raise BearingTwinError("the disk is full")

    monkeypatch.setattr(ShownStream, "write", refuse)
    assert main(["simulate", "two_spheres", "--plot", str(tmp_path / "a.png"), "--json"]) == BAD_INPUT
    told, error = capsys.readouterr()
    assert json.loads(told)["peak_force_n"] > 0.0
    assert "plot" not in json.loads(told)
    assert error.strip().endswith("bearing_twin: the disk is full")


def logged(run, block, path):
    """The log of a run that gave out this block."""
    made = SimpleNamespace(scene=run.scene, choice=run.choice, blocks=lambda: iter([block]), report=run.report)
    return read_log(write_log(made, path).path)


def test_verify_looks_at_what_happened_between_outputs_too(tmp_path, capsys):
    """A record that was altered by 1 uN, and one that is not there."""
    run = simulate("two_spheres")
    whole = joined(list(run.blocks()))
    rows = whole.records["contact"]
    altered = rows + 1e-6 * np.array([channel.name == "peak_force" for channel in CONTACT.columns])
    for name, contacts, deviation in (("same", rows, 0.0), ("altered", altered, 1e-6), ("none", rows[:0], np.inf)):
        path = tmp_path / f"{name}.mcap"
        log = logged(run, dataclasses.replace(whole, records=whole.records | {"contact": contacts}), path)
        assert verify(log).greatest == pytest.approx(deviation, rel=1e-3)
        assert main(["verify", str(path), "--strict"]) == (DOUBTFUL if deviation else DONE)
        out, error = capsys.readouterr()
        assert ("all the same" in out) == (name == "same") != ("where speed or load were commanded" in error)
        assert ("deviates by up to 1e-06 (records of contact, SI) from" in error) == (name == "altered")
        assert ("e-06, the greatest of its columns in SI" in out) == (name == "altered")
        assert ("the log has more or fewer records of contact than a new run" in error) == (name == "none")
        assert ("deviation of contact  more or fewer records than in a new run" in out) == (name == "none")
        assert main(["verify", str(path), "--json"]) == DONE
        found = json.loads(capsys.readouterr().out)
        assert found.get("records_not_as_many") == (["contact"] if name == "none" else None)


def test_what_happens_at_an_output_is_read_with_that_output(tmp_path, monkeypatch):
    """Also with the last one of a message."""
    monkeypatch.setattr("bearing_twin.log.stream.LARGEST_BLOCK", 8000)
    run = simulate("two_spheres")
    whole = joined(list(run.blocks()))
    end = next(logged(run, whole, tmp_path / "first.mcap").blocks()).time_ns[-1]
    rows = whole.records["contact"].copy()
    rows[:, 0] = 1e-9 * end
    moved = dataclasses.replace(whole, records={"contact": rows})
    first, *others = logged(run, moved, tmp_path / "second.mcap").blocks()
    assert first.time_ns[-1] == end
    assert np.array_equal(first.records["contact"], rows)
    assert others
    assert not any(len(block.records["contact"]) for block in others)
