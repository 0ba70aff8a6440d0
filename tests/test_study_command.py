"""`bearing_twin study`: the JSON its readers rely on, what is refused and how, logs to go on from, the picture."""

import dataclasses
import json
import re
import signal
import tracemalloc

import matplotlib.image
import numpy as np
import pytest
from runs import full_after

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.command.cli import BAD_INPUT, DOUBTFUL, INTERRUPTED
from bearing_twin.kinds import KINDS
from bearing_twin.log.study_log import StudyLog, read_study, write_study
from bearing_twin.uq.run import run_study
from bearing_twin.uq.sampling import SAMPLERS
from bearing_twin.uq.study import load_study, parse_study, study_names
from bearing_twin.view.study_page import study_document
from bearing_twin.view.study_picture import OPEN_END, convergence_path, plot_study, study_sheet

QUICK = ["spheres_alpha_4e-5", "--set", "sweep=", "--set", "histories=[]"]


def test_the_json_is_what_its_readers_rely_on(run_json):
    result = run_json("study", *QUICK, "--samples", 1000, "--seed", 7)
    assert (result["samples"], result["seed"], result["failed"]) == (1000, 7, {})
    assert result["seconds"] > 0.0
    assert result["stopped_because"] == "all 1000 samples are done"
    assert set(result["quantities"]) == {"contact_duration", "peak_force"}
    duration = result["quantities"]["contact_duration"]
    assert {"method", "mean", "std", "skewness", "quantiles", "half_width", "modality"} <= set(duration)
    assert duration["method"] == "ensemble"
    assert set(duration["quantiles"]["0.05"]) == {"value", "low", "high"}
    assert {"modes", "p_value"} <= set(duration["modality"])
    assert 0.0 < duration["half_width"] < duration["std"]
    assert run_json("study", *QUICK, "--samples", 1000, "--seed", 7)["quantities"] == result["quantities"]
    assert run_json("study", *QUICK, "--samples", 1000, "--seed", 8)["quantities"] != result["quantities"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "which study?"),
        (["spheres_alfa"], "did you mean spheres_alpha"),
        ([*QUICK, "--samples", "ten"], "must be a whole number"),
        ([*QUICK, "--workers", "-1"], "workers = -1 is out of range"),
        ([*QUICK, "--plot", "x.pdf"], "give one that ends in .png"),
        ([*QUICK, "--out", "nowhere/x.mcap"], "does not exist"),
        ([*QUICK, "--resume", "nowhere.mcap"], "nowhere.mcap"),
        ([*QUICK, "--sampels", "3"], "did you mean --samples?"),
    ],
)
def test_bad_input_ends_with_one_sentence(arguments, sentence, refused):
    assert sentence in refused("study", *arguments)


def test_a_person_sees_intervals_modes_why_it_stopped_and_warnings(run_cli):
    options = ["--set", "stop.relative_tolerance=0.05", "--samples", "100000", "--set", "sensitivity=32", "--strict"]
    out, err = run_cli("study", *QUICK, *options, code=DOUBTFUL)
    assert re.search(r"contact_duration +mean +6\d\.\d+ \[\S+, \S+\] +µs", out)
    assert re.search(r"0.95 quantile .* kN$", out, re.MULTILINE)
    assert re.search(r"contact_duration +contact.measured_alpha", out)
    assert re.search(r"contact_duration: error of the model ± \S+ µs", out)
    assert "at 2 checks in a row" in out
    assert "checked realisations: peak pressure" in err


def test_an_open_end_of_an_interval_is_explained_where_there_is_one(run_cli):
    few_samples, many_samples = (
        ["--set", "modality=no", "--set", "method=ensemble", "--samples", count] for count in ("16", "2000")
    )
    out = run_cli("study", *QUICK, *few_samples).out
    assert re.search(r"0.95 quantile +\S+ \[\S+, \?\]", out)
    assert "?: the samples are too few to bound" in out
    assert "?" not in run_cli("study", *QUICK, *many_samples).out


def test_the_list_names_every_study_and_quantity(run_json, run_cli):
    listing = run_json("study", "--list")
    studies = [load_study(name) for name in study_names()]
    listed = [{"name": study.name, "scene": study.scene["name"], "description": study.description} for study in studies]
    assert listing["studies"] == listed
    assert {(row["kind"], row["quantity"]) for row in listing["quantities"]} == {
        (kind, name) for kind, row in KINDS.items() for name in row.quantities_of()
    }
    assert "greatest_ball_load" in run_cli("study", "--list").out


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_a_study_says_which_of_its_intervals_hold_too_little(sampler, run_json, run_cli):
    """A lognormal contact time, as that of `bearing_twin chart coverage`: few points far out decide."""
    wide = "inputs.contact.measured_alpha={distribution: lognormal, mean_log: -9.1, std_log: 1.0}"
    arguments = [*QUICK, "--set", wide, "--set", f"sampler={sampler}", "--samples", 128, "--set", "checks=0"]
    duration = run_json("study", *arguments)["quantities"]["contact_duration"]
    assert {"std"} <= set(duration["unsafe"]) <= {"mean", "std"}
    assert duration["skewness_interval"] == [None, None]
    out = " ".join(run_cli("study", *arguments).out.split())
    assert "std" in re.search(r"the intervals? of (.*?) (?:is|are) unsafe", out).group(1)
    calm = run_json("study", *QUICK, "--set", f"sampler={sampler}", "--samples", 128, "--set", "checks=0")
    assert "mean" not in calm["quantities"]["contact_duration"]["unsafe"]


def test_pictures_of_little_and_of_nothing(tmp_path, pictures_once):
    speeds = {"motion.first_velocity": {"distribution": "uniform", "low": -3.0, "high": 6.0}}
    mapping = {"scene": "two_spheres", "inputs": speeds, "quantities": ["peak_force", "impulse"], "modality": "no"}
    few = run_study(parse_study({**mapping, "method": "ensemble", "samples": 3}, "few"))
    assert plot_study(few, tmp_path / "few.png").stat().st_size > 10_000
    with pytest.raises(BearingTwinError):
        plot_study(few, tmp_path / "nowhere" / "few.png")


def panels_of(result):
    """The panels of the picture of a result by their titles."""
    sheet = study_sheet(result, result.study.quantities, result.study.histories)
    return {panel.title: panel for row in sheet.rows for panel in row}


def parts_of(panel, name):
    """What a panel draws under a name."""
    return [part for part in panel.parts if part.name == name]


def spheres(*overrides):
    """A quick study of the spheres that samples."""
    quick = ("sweep=", "histories=[]", "modality=no", "checks=0", "method=ensemble")
    return run_study(load_study(QUICK[0], [*quick, *overrides]))


CONVERGENCE = "Convergence of contact duration"


def test_the_interval_of_the_convergence_is_that_of_the_table():
    """It is not symmetric: 19.6 to 28.3 µs about 21.8 µs; of one look it is a bar."""
    for count in (200, 400):
        result = spheres(f"samples={count}")
        ((drawn,), ends) = (
            parts_of(panels_of(result)[CONVERGENCE], "95 % interval"),
            result.summary["quantities"]["contact_duration"]["std_interval"],
        )
        assert (list(drawn.y) if count == 200 else [drawn.low[-1], drawn.high[-1]]) == pytest.approx(ends, rel=1e-9)
    path = result.summary["convergence"]
    half = [path.pop(key) and path["half_width"][-1] for key in ("low", "high")]  # as an earlier version wrote it
    *_, (low, high) = zip(*convergence_path(result.summary)[2:], strict=True)
    assert (path["estimate"][-1] - low, high - path["estimate"][-1]) == pytest.approx(half, rel=1e-9)


def test_open_intervals_of_quantiles_and_units_are_the_same_in_picture_table_and_view(tmp_path, quick_workers, run_cli):
    result = run_study(load_study("bearing_6203_tolerances", ["samples=12", "workers=1", "run.duration=0.01"]))
    panels, document = panels_of(result), study_document(result)
    table = run_cli("report", write_study(result, tmp_path / "study.mcap")).out
    viewed = {statistics["title"]: {row["unit"] for row in statistics["rows"]} for statistics in document["statistics"]}
    units = {"greatest_ball_load": ("N", 1.0), "greatest_pressure": ("MPa", 1e-6), "cage_speed": ("rpm", 30.0 / np.pi)}
    for name, (unit, factor) in units.items():
        title = name.replace("_", " ").capitalize()
        panel = panels[title]
        assert panel.x.shown == pytest.approx((unit, factor))
        assert viewed[title] == {unit, ""}
        assert re.search(rf"{name} +mean .* {unit}$", table, re.MULTILINE)
        (low, high), (first, *_, last) = panel.x.limits, parts_of(panel, OPEN_END)
        quantiles = result.summary["quantities"][name]["quantiles"]
        assert (*first.x, *last.x) == (low, quantiles["0.05"]["high"], quantiles["0.95"]["low"], high)
    assert not parts_of(panels_of(spheres("samples=200"))["Contact duration"], OPEN_END)


def test_what_cannot_be_said_of_so_few_samples_is_said_once(run_cli):
    out, err = run_cli("study", *QUICK, "--samples", "2")
    assert re.search(r"0.50 quantile .* µs$", out, re.MULTILINE)  # as of many samples
    text = " ".join(out.split())
    assert text.count("all quantities: no std, skewness or modality, because 2 samples are too few") == 1
    assert (text.count("too few"), text.count("unsafe"), err.count("yield")) == (2, 1, 2)  # one says what ? is


SWEPT = ["samples=50", "modality=no", "checks=0", "histories=[]"]


def test_the_table_says_where_in_its_sweep_it_is_and_has_the_sweep(run_json, run_cli):
    arguments = ["spheres_alpha_4e-5", *(argument for override in SWEPT for argument in ("--set", override))]
    studies = run_json("study", *arguments)["sweep"]["studies"]
    out = run_cli("study", *arguments).out
    assert out.startswith("at motion.first_velocity = 20 m/s, as in the scene; the sweep of it is below\n")
    title, _, *rows = out[out.index("sweep of motion") :].splitlines()
    assert title == "sweep of motion.first_velocity [m/s]"
    for first, name, factor, unit in ((0, "contact_duration", 1e6, "µs"), (7, "peak_force", 1e-3, "kN")):
        for row, study in zip(rows[first : first + 7], studies, strict=True):
            value, mean, low, high, *_ = map(float, re.findall(r"[\d.]+", row.removeprefix(name)))
            quantity = study["quantities"][name]
            assert (value, row.split()[-1]) == (study["value"], unit)
            assert (mean, low, high) == pytest.approx(
                [factor * x for x in (quantity["mean"], *quantity["mean_interval"])], 0.05
            )


def test_the_picture_has_the_sweep_and_where_the_other_panels_are_in_it():
    result = run_study(load_study("spheres_alpha_4e-5", SWEPT))
    panels = panels_of(result)
    panel, studies = panels["Peak force over the sweep"], result.summary["sweep"]["studies"]
    (mean,), (marker,) = parts_of(panel, "mean"), parts_of(panel, "value of the other panels")
    assert mean.x == [study["value"] for study in studies]
    assert mean.y.tolist() == [study["quantities"]["peak_force"]["mean"] for study in studies]
    assert marker.x == [20.0, 20.0]
    assert (panel.x.log, panel.y.log, panels["Contact duration over the sweep"].y.log) == (True, True, False)
    assert study_document(result)["badges"][0]["text"] == "motion.first_velocity = 20 m/s"


@pytest.mark.parametrize("name", [name for name in study_names() if name.startswith("bearing")])
def test_a_bearing_is_studied_by_worker_processes(name, quick_workers):
    result = run_study(load_study(name, ["samples=6", "workers=1", "stop.minimum=4", "run.duration=0.01", "batch=2"]))
    summary = result.as_dict()
    assert summary["failed"] == {}
    assert summary["convergence"]["samples"] == [4, 6]
    load = result.sample("greatest_ball_load")
    assert 0.0 < load.min() < load.max() < 500.0
    # the tighter the clearance, the greater the load
    assert np.corrcoef(result.values[:, 1], load)[0, 1] < -0.8
    theory = 0.5 * 183.26 * (1.0 - 6.746 / 28.5)
    assert result.sample("cage_speed") == pytest.approx(theory, rel=0.2)


def test_the_log_of_a_study_is_reported_as_the_command_did(tmp_path, pictures_once, run_json, refused):
    log = tmp_path / "study.mcap"
    result = run_json("study", *QUICK, "--samples", 200, "--out", log)
    again = run_json("report", log, "--plot", tmp_path / "study.png")
    assert again["quantities"] == result["quantities"]
    assert matplotlib.image.imread(again["plot"]).shape[0] > 300
    for command, sentence in (("verify", "that is the log of a study"), ("simulate", "is a log, no scene")):
        assert sentence in refused(command, log)


def test_a_study_is_saved_as_it_goes_and_goes_on_after_a_crash(tmp_path, run_json, refused, run_cli):
    """What a crash leaves is recovered and gone on from, with the numbers of one run, whoever described its scene."""
    arguments = [*QUICK, "--set", "method=ensemble", "--set", "batch=100", "--set", "modality=no", "--seed", 7]
    overrides = [argument for argument in map(str, arguments[1:]) if "=" in argument]
    study, crashed = load_study(QUICK[0], [*overrides, "seed=7", "samples=500"]), tmp_path / "crashed.mcap"
    study = dataclasses.replace(study, scene=study.scene | {"description": "as an earlier version has it"})
    with StudyLog(study, tmp_path / "going.mcap", max_loss=0.0) as log:

        def keep(*columns):
            log.add(*columns)
            if log._written == 300:
                log._log.flush()
                crashed.write_bytes((tmp_path / "going.mcap").read_bytes())

        log.finish(run_study(study, keep=keep))
    run_cli("recover", crashed, tmp_path / "saved.mcap")
    assert len(read_study(tmp_path / "saved.mcap", unfinished=True).values) == 300
    assert "go on with" in refused("report", tmp_path / "saved.mcap")
    resumed = run_json(
        "study", *arguments, "--samples", 500, "--resume", tmp_path / "saved.mcap", "--out", tmp_path / "all.mcap"
    )
    at_once = read_study(tmp_path / "going.mcap")
    continued = read_study(tmp_path / "all.mcap")
    assert resumed["quantities"] == at_once.summary["quantities"]
    assert (continued.values.tobytes(), continued.quantities.tobytes()) == (
        at_once.values.tobytes(),
        at_once.quantities.tobytes(),
    )


def test_what_a_log_of_a_study_holds_is_held_once(tmp_path):
    """As it is read: a second time a block of it, and the eighth that is kept ready for more."""
    study = load_study("spheres_alpha_4e-5", ["histories=[approach]"])
    count, points = 24_000, study.settings.history_points
    numbers = np.arange(count * points) % 7.0
    columns = [np.ones((count, len(names))) for names in (study.inputs, study.quantities)]
    with StudyLog(study, tmp_path / "long.mcap", max_loss=0.0) as log:
        log.add(*columns, numbers.reshape(count, 1, points), *np.zeros((2, count)), [], [])
    read_study(tmp_path / "long.mcap", unfinished=True)  # what it imports does not count
    tracemalloc.start()
    result = read_study(tmp_path / "long.mcap", unfinished=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.array_equal(result.histories.ravel(), numbers)
    assert (result.values.shape, result.quantities.shape) == tuple(names.shape for names in columns)
    assert peak < 1.6 * numbers.nbytes


@pytest.mark.parametrize("from_write", [0, 5])
def test_a_full_disk_takes_no_result_along(from_write, tmp_path, monkeypatch, run_cli):
    full_after(from_write, monkeypatch)
    arguments = [
        "study",
        *QUICK,
        "--samples",
        "500",
        "--set",
        "modality=no",
        "--out",
        str(tmp_path / "s.mcap"),
        "--json",
    ]
    out, err = run_cli(*arguments, code=BAD_INPUT)
    assert json.loads(out)["samples"] == 500
    assert "No space left on device" in err


def test_a_study_stopped_by_ctrl_c_draws_no_picture(tmp_path, monkeypatch, run_cli):
    """Drawing took seconds more."""

    def interrupted(study, progress, cancelled, start, keep):
        signal.raise_signal(signal.SIGINT)
        return run_study(study, progress, cancelled, start, keep)

    monkeypatch.setattr("bearing_twin.uq.run.run_study", interrupted)
    picture = tmp_path / "x.png"
    assert f"{picture} is not drawn" in run_cli("study", *QUICK, "--plot", picture, code=INTERRUPTED).err
    assert not picture.exists()
