"""Impacts are runs like any other: samples by channel, blocks, reports, resets, resolved scenes."""

import dataclasses
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from bearing_twin.command.cli import BAD_INPUT, DONE, DOUBTFUL, main
from bearing_twin.command.logged import ShownStream
from bearing_twin.errors import BearingTwinError, LogError
from bearing_twin.kinds.impact.figures import CONTACT
from bearing_twin.kinds.impact.picture import draw_force
from bearing_twin.log.mcap_log import read_log, write_log
from bearing_twin.pictures.peaks import LABEL
from bearing_twin.run.fidelity import choose
from bearing_twin.run.passes import simulate
from bearing_twin.run.picture import picture_of, plot
from bearing_twin.run.scene import load_scene, parse_scene
from bearing_twin.run.simulation import Simulation
from bearing_twin.run.verification import verify
from bearing_twin.sample import joined
from bearing_twin.units import prefixed

pytestmark = pytest.mark.usefixtures("quick_pictures")

SCENES = (
    "two_spheres", "two_discs", "sphere_on_beam", "sphere_on_beam_long", "sphere_on_beam_drop_50mm",
    "sphere_on_beam_drop_600mm", "sphere_on_beam_drop_50mm_shear",
)  # fmt: skip
KEYS = {"peak_force_n", "contact_duration_s", "contacts", "restitution", "energy_closure", "flags", "status"}
BEAM_KEYS = {"peak_deflection_m", "peak_stress_pa"}


@pytest.mark.parametrize("name", SCENES)
def test_a_run_yields_its_samples_and_the_figures_of_the_impact(name):
    run = simulate(name)
    samples = list(run)
    assert len(samples) == run.outputs > 300
    assert [sample.sequence for sample in samples] == list(range(len(samples)))
    for sample in samples[:: len(samples) // 7]:
        for channel in run.channels:
            value = sample[channel.name]
            assert value.shape == channel.shape
            assert np.isfinite(value).all()
    report = json.loads(json.dumps(run.report.as_dict(), allow_nan=False))
    assert set(report) >= KEYS | (BEAM_KEYS if "beam" in name else set())
    law = name not in ("two_spheres", "sphere_on_beam_drop_50mm_shear", "sphere_on_beam_drop_600mm_shear")
    assert report["status"] == ("doubtful: peaks, forces" if law else "done")
    assert 0.0 < report["errors_by_source"]["peak_force_n"]["method"] < 1e-6 * report["peak_force_n"]
    assert abs(report["energy_closure"]) < 1e-6
    assert set(report["contacts"][0]) == {"start_s", "duration_s", "peak_force_n", "impulse_ns"}
    force = np.array([sample["normal_load"] for sample in samples])
    assert force.max() == pytest.approx(report["peak_force_n"], rel=5e-3)
    assert samples[0].time_ns == 0
    assert force[0] == force[-1] == 0.0
    last = report["contacts"][-1]
    assert 1e-9 * samples[-1].time_ns > last["start_s"] + last["duration_s"]


@pytest.mark.parametrize("name", ["two_spheres", "sphere_on_beam"])
def test_the_numbers_do_not_depend_on_how_the_run_is_cut(name):
    whole, cut = Simulation(load_scene(name)), Simulation(load_scene(name))
    block = whole.advance(300)
    pieces = [cut.advance(count) for count in (1, 99, 200)]
    for channel in whole.channels:
        joined = np.concatenate([piece.values[channel.name] for piece in pieces])
        assert np.array_equal(joined, block.values[channel.name])
    whole.reset()
    assert np.array_equal(whole.advance(300).matrix(), block.matrix())


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


@pytest.mark.parametrize("name", SCENES)
def test_a_resolved_scene_is_complete_and_reads_as_itself(name):
    scene = load_scene(name)
    run = scene.parameters.run
    assert min(run.duration, run.output_rate, run.publish_rate) > 0.0
    assert parse_scene(scene.resolved(), "log") == scene


def test_overrides_come_before_what_is_left_to_be_chosen():
    slow = load_scene("two_spheres", ["motion.first_velocity=0.02"])
    ratio = slow.parameters.run.duration / load_scene("two_spheres").parameters.run.duration
    assert ratio == pytest.approx(1000.0**0.2, rel=1e-3)
    assert load_scene("two_spheres", ["run.duration=1.0e-4"]).parameters.run.duration == 1e-4


def test_every_kind_can_be_chosen_for():
    for name in SCENES:
        assert choose(load_scene(name)).reason


def test_the_closed_form_is_chosen_when_it_says_all_that_is_wanted():
    assert choose(load_scene("two_spheres")).stepper == "closed_form"
    assert choose(load_scene("two_spheres", ["contact.restitution=0.8"])).stepper == "dop853"
    assert (
        choose(load_scene("two_spheres", ["contact.restitution=0.8", "wanted.outputs=peaks"])).stepper == "closed_form"
    )
    assert choose(load_scene("two_spheres", ["contact.measured_alpha=1.138e-4"])).law == "measured"


def test_a_force_that_is_assumed_never_reports_success():
    run = simulate(load_scene("sphere_on_beam", ["solver.stepper=sinusoidal"]))
    list(run)
    assert run.report.status == "failed: energy"
    assert math.isfinite(run.report.figures["peak_stress_pa"])


@pytest.mark.parametrize("name", ["two_spheres", "sphere_on_beam_drop_50mm"])
def test_the_command_line_prints_and_draws_an_impact(name, tmp_path, capsys):
    picture = tmp_path / "impact.png"
    assert main(["simulate", name, "--plot", str(picture), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert set(report) >= KEYS
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


@pytest.mark.parametrize("name", ["two_spheres", "sphere_on_beam_drop_50mm"])
def test_an_impact_is_logged_verified_and_reported_like_any_run(name, tmp_path, capsys):
    log = str(tmp_path / "impact.mcap")
    answers = []
    for words in (["simulate", name, "--out", log], ["verify", log], ["report", log]):
        assert main([*words, "--json"]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    simulated, verified, reported = answers
    assert verified["greatest_deviation"] == 0.0
    assert reported["missing_outputs"] == 0
    assert {key: reported[key] for key in simulated if key != "compile_s"} == {
        key: value for key, value in simulated.items() if key != "compile_s"
    }


def test_a_picture_needs_samples_and_a_place(tmp_path):
    with pytest.raises(LogError, match="no sample"):
        picture_of(simulate("two_spheres")).write(tmp_path / "empty.png")
    with pytest.raises(BearingTwinError, match="cannot be written"):
        plot(simulate("two_spheres"), tmp_path / "nowhere" / "impact.png")


def test_a_picture_that_cannot_be_written_takes_no_figure_along(tmp_path, monkeypatch, capsys):
    def refuse(*_):
        raise BearingTwinError("the disk is full")

    monkeypatch.setattr(ShownStream, "write", refuse)
    assert main(["simulate", "two_spheres", "--plot", str(tmp_path / "a.png"), "--json"]) == BAD_INPUT
    told, error = capsys.readouterr()
    assert json.loads(told)["peak_force_n"] > 0.0
    assert "plot" not in json.loads(told)
    assert error.strip().endswith("bearing_twin: the disk is full")


@pytest.mark.parametrize(("force", "unit", "peak"), [(4e7, "MN", "40"), (1.5e5, "kN", "150"), (12.0, "N", "12")])
def test_a_force_is_drawn_in_a_unit_that_people_read(force, unit, peak):
    axis, shape = Figure().add_subplot(), np.array([0.0, 0.5, 1.0, 0.5, 0.0])
    draw_force(axis, np.arange(5.0), {"normal_load": force * shape})
    assert (axis.get_ylabel(), axis.get_title(loc="left")) == (
        f"contact force [{unit}]",
        f"Contact force, peak {peak} {unit}",
    )
    assert axis.lines[0].get_ydata().max() == pytest.approx(float(peak))


@pytest.mark.parametrize("name", ["two_spheres", "sphere_on_beam_drop_600mm", "soft_discs_mean"])
def test_a_peak_that_outputs_pass_by_is_drawn_and_told(name):
    """At these outputs spheres and beam carry nothing."""
    run = simulate(load_scene(name, ("run.output_rate=3000", "run.publish_rate=3000", "solver.companion=off")))
    drawn, figure = picture_of(run), Figure()
    for block in run.blocks():
        drawn.add(block)
    drawn.draw(figure, drawn._values.arrays())
    axis, peak = figure.axes[0], run.report.figures["peak_force_n"]
    factor, unit = prefixed(peak, "N")
    assert axis.get_title(loc="left") == f"Contact force, peak {factor * peak:.5g} {unit}"
    [entry] = axis.get_legend().get_texts()
    assert entry.get_text() == LABEL
    _, end, highest = drawn.contacts()
    lines = [one for one in axis.lines if one.get_label() == LABEL]
    bars = [bar for one in axis.collections if hasattr(one, "get_segments") for bar in one.get_segments()]
    shown = np.concatenate([*(one.get_xydata() for one in lines), *bars])
    scale, _ = prefixed(1e-9 * block.time_ns[-1], "s")
    assert shown[:, 1].max() == pytest.approx(factor * peak) == pytest.approx(factor * highest.max())
    assert shown[:, 0].max() == pytest.approx(scale * end.max(), rel=0.1)
    assert not axis.lines[0].get_ydata().any() or name == "soft_discs_mean"


def test_of_many_outputs_no_peak_is_marked_and_the_record_is_told():
    axis, shape = Figure().add_subplot(), np.sin(np.linspace(0.0, math.pi, 50))
    draw_force(axis, np.linspace(0.0, 1.0, 50), {"normal_load": shape}, 1.0, np.array([[0.0], [1.0], [1.0]]))
    assert axis.get_legend() is None
    assert axis.get_title(loc="left") == "Contact force, peak 1 N"


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


@pytest.mark.parametrize(
    ("words", "approach", "velocity", "said"),
    [
        ([], "1 µm", "0.25 m/s", "by up to 0.25 m/s (velocity) from a new run"),
        (["--si"], "1e-06 m", "0.25 m/s", "by up to 0.25 m/s (velocity) from a new run"),
    ],
)
def test_verify_shows_deviations_with_their_units(words, approach, velocity, said, tmp_path, capsys):
    run = simulate("two_spheres")
    block = next(run.blocks())
    for name, off in (("approach", 1e-6), ("velocity", 0.25)):
        block.values[name][7] += off
    logged(run, block, tmp_path / "run.mcap")
    assert main(["verify", str(tmp_path / "run.mcap"), *words]) == DONE
    out, error = capsys.readouterr()
    rows = dict(line.split("  ", 1) for line in out.splitlines())
    assert rows["deviation of approach"].strip() == approach
    assert rows["deviation of velocity"].strip() == velocity
    assert "greatest deviation" not in rows
    assert said in " ".join(error.split())


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
