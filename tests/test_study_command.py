"""`bearing_twin study`: the JSON its readers rely on, what is refused and how, logs to go on from, the picture."""

import errno
import itertools
import json
import os
import re
import signal
import tracemalloc

import matplotlib.image
import numpy as np
import pytest

from bearing_twin.command.cli import BAD_INPUT, DONE, DOUBTFUL, INTERRUPTED, main
from bearing_twin.errors import BearingTwinError
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr
from bearing_twin.log.blocks import Gathered
from bearing_twin.log.samples import samples_message
from bearing_twin.log.study_log import StudyLog, read_study
from bearing_twin.sample import Channel
from bearing_twin.uq import picture
from bearing_twin.uq.picture import plot_study
from bearing_twin.uq.run import run_study
from bearing_twin.uq.sampling import SAMPLERS
from bearing_twin.uq.study_file import load_study, parse_study, study_names

QUICK = ["spheres_alpha_4e-5", "--set", "sweep=", "--set", "histories=[]"]


def asked(capsys, *words):
    assert main(["study", *map(str, words), "--json"]) == DONE
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    return json.loads(out)


def refused(capsys, *words):
    assert main(["study", *map(str, words), "--json"]) == BAD_INPUT
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("bearing_twin: ")
    assert "Traceback" not in err
    return err


def test_the_json_is_what_its_readers_rely_on(capsys):
    found = asked(capsys, *QUICK, "--samples", 1000, "--seed", 7)
    assert (found["samples"], found["seed"], found["failed"]) == (1000, 7, {})
    assert found["seconds"] > 0.0
    assert found["stopped_because"] == "all 1000 samples are done"
    assert set(found["quantities"]) == {"contact_duration", "peak_force"}
    one = found["quantities"]["contact_duration"]
    assert {"method", "mean", "std", "skewness", "quantiles", "half_width", "modality"} <= set(one)
    assert one["method"] == "ensemble"
    assert set(one["quantiles"]["0.05"]) == {"value", "low", "high"}
    assert {"modes", "p_value"} <= set(one["modality"])
    assert 0.0 < one["half_width"] < one["std"]
    assert asked(capsys, *QUICK, "--samples", 1000, "--seed", 7)["quantities"] == found["quantities"]
    assert asked(capsys, *QUICK, "--samples", 1000, "--seed", 8)["quantities"] != found["quantities"]


def test_an_input_is_changed_from_the_command_line(capsys):
    key = "inputs.contact.measured_alpha"
    found = asked(capsys, *QUICK, "--set", f"{key}.std=2e-5", "--set", "method=change_of_variable")
    assert found["quantities"]["contact_duration"]["std"] == pytest.approx(1.09856054e-5, rel=1e-8)
    assert "std 2e-05" in found["inputs"]["contact.measured_alpha"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "which study?"),
        (["spheres_alfa"], "did you mean spheres_alpha"),
        ([*QUICK, "--samples", "0"], "samples = 0 is out of range"),
        ([*QUICK, "--samples", "ten"], "must be a whole number"),
        ([*QUICK, "--workers", "-1"], "workers = -1 is out of range"),
        ([*QUICK, "--set", "quantities=[contact_time]"], "did you mean contact_duration?"),
        ([*QUICK, "--set", "inputs.contact.measured_alpha.std=-1e-5"], "std"),
        ([*QUICK, "--set", "memory=1e4"], "more than its memory"),
        ([*QUICK, "--plot", "x.pdf"], "give one that ends in .png"),
        ([*QUICK, "--out", "nowhere/x.mcap"], "does not exist"),
        ([*QUICK, "--resume", "nowhere.mcap"], "nowhere.mcap"),
        ([*QUICK, "--sampels", "3"], "did you mean --samples?"),
    ],
)
def test_bad_input_ends_with_one_sentence(words, sentence, capsys):
    assert sentence in refused(capsys, *words)


def test_doubts_make_three_with_strict(capsys):
    assert main(["study", *QUICK, "--samples", "50", "--strict"]) == DOUBTFUL
    assert "doubtful: at the mean inputs peak pressure" in capsys.readouterr().err


def test_a_person_sees_intervals_modes_and_why_it_stopped(capsys):
    words = ["--set", "stop.relative_tolerance=0.05", "--samples", "100000", "--set", "sensitivity=32"]
    assert main(["study", *QUICK, *words]) == DONE
    out = capsys.readouterr().out
    assert re.search(r"contact_duration +mean +6\d\.\d+ \[\S+, \S+\] +µs", out)
    assert "0.95 quantile" in out
    assert "contact_duration: " in out
    assert "at 2 looks in a row" in out
    assert re.search(r"contact_duration +contact.measured_alpha", out)


def test_an_open_end_of_an_interval_is_explained_where_there_is_one(capsys):
    few, many = (["--set", "modality=no", "--set", "method=ensemble", "--samples", count] for count in ("16", "2000"))
    assert main(["study", *QUICK, *few]) == DONE
    out = capsys.readouterr().out
    assert re.search(r"0.95 quantile +\S+ \[\S+, \?\]", out)
    assert "?: the samples are too few to bound" in out
    assert main(["study", *QUICK, *many]) == DONE
    assert "?" not in capsys.readouterr().out


def test_a_study_goes_on_from_its_log(capsys, tmp_path, quick_workers):
    first, second = tmp_path / "first.mcap", tmp_path / "second.mcap"
    asked(capsys, *QUICK, "--samples", 500, "--out", first)
    found = asked(capsys, *QUICK, "--samples", 1500, "--resume", first, "--out", second)
    assert found["log"] == str(second)
    whole = asked(capsys, *QUICK, "--samples", 1500)
    assert found["quantities"] == whole["quantities"]
    assert np.array_equal(read_study(second).values[:500], read_study(first).values)
    assert "exists" in refused(capsys, *QUICK, "--out", second)


def test_the_list_names_every_study_and_quantity(capsys):
    found = asked(capsys, "--list")
    studies = [load_study(name) for name in study_names()]
    listed = [{"name": one.name, "scene": one.scene["name"], "description": one.description} for one in studies]
    assert found["studies"] == listed
    assert {(one["kind"], one["quantity"]) for one in found["quantities"]} == {
        (kind, name) for kind, row in KINDS.items() for name in row.quantities_of()
    }
    assert main(["study", "--list"]) == DONE
    assert "greatest_ball_load" in capsys.readouterr().out


def test_polynomial_chaos_and_sobol_indices_agree(capsys, quick_workers):
    key = "inputs.motion.first_velocity={distribution: uniform, low: 10, high: 30}"
    two = [*QUICK, "--set", key]
    chaos = asked(capsys, *two, "--set", "method=chaos")["quantities"]["contact_duration"]
    drawn = asked(capsys, *two, "--set", "sensitivity=2048", "--set", "sampler=sobol")["quantities"]["contact_duration"]
    assert (chaos["method"], drawn["method"]) == ("chaos", "ensemble")
    assert chaos["validation_error"] < 1e-3
    assert chaos["mean"] == pytest.approx(drawn["mean"], rel=1e-3)
    assert chaos["std"] == pytest.approx(drawn["std"], rel=1e-2)
    for name in ("contact.measured_alpha", "motion.first_velocity"):
        for order in ("first", "total"):
            found = drawn["sobol"][name][order]
            assert found["low"] < found["value"] < found["high"]
            assert found["value"] == pytest.approx(chaos["sobol"][name][order]["value"], abs=0.02)


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize("samples", [128, 1024])
def test_a_study_says_which_of_its_intervals_hold_too_little(sampler, samples, capsys):
    """A lognormal contact time, as that of `bearing_twin chart coverage`: std and skewness are held in 15 to 92 %."""
    wide = "inputs.contact.measured_alpha={distribution: lognormal, mean_log: -9.1, std_log: 1.0}"
    words = [*QUICK, "--set", wide, "--set", f"sampler={sampler}", "--samples", samples, "--set", "companions=0"]
    found = asked(capsys, *words)["quantities"]["contact_duration"]
    assert {"std", "skewness"} <= set(found["unsafe"]) <= {"mean", "std", "skewness"}
    main(["study", *map(str, words)])
    out = " ".join(capsys.readouterr().out.split())
    *first, last = found["unsafe"]
    assert f"contact_duration: the intervals of {', '.join(first)} and {last} are unsafe: few samples far out" in out
    calm = asked(capsys, *QUICK, "--set", f"sampler={sampler}", "--samples", samples, "--set", "companions=0")
    assert "mean" not in calm["quantities"]["contact_duration"]["unsafe"]


def test_shares_of_the_variance_whose_intervals_hold_too_little_say_so(capsys):
    """Alpha and the speed are lognormal, and so is their product."""
    key = "distribution: lognormal, std_log: 1.0"
    words = [*QUICK, "--set", f"inputs.contact.measured_alpha={{{key}, mean_log: -9.1}}"]
    words += ["--set", f"inputs.motion.first_velocity={{{key}, mean_log: 2.0}}", "--set", "sensitivity=64"]
    shares = asked(capsys, *words, "--samples", 64)["quantities"]["peak_force"]["sobol"]
    assert all(share["unsafe"] for one in shares.values() for share in one.values())
    main(["study", *map(str, words), "--samples", "64"])
    out = " ".join(capsys.readouterr().out.split())
    assert "peak_force: the interval of its share from motion.first_velocity is unsafe: few rows far out decide" in out


def test_the_picture_has_ink_and_its_title(tmp_path, capsys):
    path = tmp_path / "study.png"
    found = asked(capsys, "spheres_alpha_4e-5", "--set", "sweep=", "--plot", path)
    assert found["plot"] == str(path)
    pixels = matplotlib.image.imread(path)[..., :3]
    assert pixels.shape[1] == 1600
    assert 0.005 < np.mean(pixels.mean(axis=2) < 0.8) < 0.4


def test_a_distribution_without_samples_has_a_picture(tmp_path, capsys, quick_pictures):
    path = tmp_path / "exact.png"
    asked(capsys, *QUICK, "--set", "method=change_of_variable", "--plot", path)
    assert path.stat().st_size > 20_000


def test_pictures_of_little_and_of_nothing(tmp_path, quick_pictures):
    speeds = {"motion.first_velocity": {"distribution": "uniform", "low": -3.0, "high": 6.0}}
    mapping = {"scene": "two_spheres", "inputs": speeds, "quantities": ["peak_force", "impulse"], "modality": "no"}
    few = run_study(parse_study({**mapping, "method": "ensemble", "samples": 3}, "few"))
    assert plot_study(few, tmp_path / "few.png").stat().st_size > 10_000
    with pytest.raises(BearingTwinError):
        plot_study(few, tmp_path / "nowhere" / "few.png")


def test_numbers_below_a_panel_stand_apart_and_what_is_not_drawn_is_named(tmp_path, monkeypatch, quick_workers):
    """Five quantities of eight samples, which are looked at once."""
    drawn = []
    monkeypatch.setattr(picture, "finish", lambda figure, title, footer, path, **_: drawn.append((figure, footer)))
    speeds = {"motion.first_velocity": {"distribution": "uniform", "low": 5.0, "high": 15.0}}
    names = ["peak_force", "contact_duration", "greatest_approach", "impulse", "restitution"]
    mapping = {"scene": "two_spheres", "inputs": speeds, "quantities": names, "modality": "no", "companions": 0}
    plot_study(run_study(parse_study({**mapping, "method": "ensemble", "samples": 8}, "few")), tmp_path / "few.png")
    ((figure, footer),) = drawn
    assert footer.endswith("not drawn: restitution")
    figure.draw_without_rendering()
    for axis in figure.axes:
        shown = [tick.get_window_extent() for tick in axis.get_xticklabels()]
        assert all(one.x1 < next_one.x0 for one, next_one in itertools.pairwise(shown)), axis.get_xlabel()
    *_, convergence = figure.axes
    assert convergence.containers, "of one look the interval is a bar"
    assert all(float(tick).is_integer() for tick in convergence.get_xticks())


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


def test_the_log_of_a_study_is_reported_as_the_command_did(capsys, tmp_path, quick_pictures):
    log = tmp_path / "study.mcap"
    found = asked(capsys, *QUICK, "--samples", 200, "--out", log)
    assert main(["report", str(log), "--json", "--plot", str(tmp_path / "study.png")]) == DONE
    again = json.loads(capsys.readouterr().out)
    assert again["quantities"] == found["quantities"]
    assert matplotlib.image.imread(again["plot"]).shape[0] > 300
    for words, sentence in (("verify", "that is the log of a study"), ("simulate", "is a log, no scene")):
        assert main([words, str(log)]) == BAD_INPUT
        assert sentence in capsys.readouterr().err


def test_a_study_is_saved_as_it_goes_and_goes_on_after_a_crash(tmp_path, capsys):
    """What a crash leaves is recovered and gone on from, with the numbers of one run."""
    words = [*QUICK, "--set", "method=ensemble", "--set", "batch=100", "--set", "modality=no", "--seed", 7]
    overrides = [word for word in map(str, words[1:]) if "=" in word]
    study, crashed = load_study(QUICK[0], [*overrides, "seed=7", "samples=500"]), tmp_path / "crashed.mcap"
    with StudyLog(study, tmp_path / "going.mcap", max_loss=0.0) as log:

        def keep(*columns):
            log.add(*columns)
            if log._written == 300:
                log._log.flush()
                crashed.write_bytes((tmp_path / "going.mcap").read_bytes())

        log.finish(run_study(study, keep=keep))
    assert main(["recover", str(crashed), str(tmp_path / "saved.mcap")]) == DONE
    capsys.readouterr()
    assert len(read_study(tmp_path / "saved.mcap", unfinished=True).values) == 300
    assert "go on with" in refused_report(tmp_path / "saved.mcap", capsys)
    found = asked(capsys, *words, "--samples", 500, "--resume", tmp_path / "saved.mcap", "--out", tmp_path / "all.mcap")
    whole = read_study(tmp_path / "going.mcap")
    rest = read_study(tmp_path / "all.mcap")
    assert found["quantities"] == whole.summary["quantities"]
    assert (rest.values.tobytes(), rest.quantities.tobytes()) == (whole.values.tobytes(), whole.quantities.tobytes())


def test_what_a_log_of_a_study_holds_is_held_once(tmp_path):
    """As it is read: a second time a block of it, and the eighth that is kept ready for more."""
    study = load_study("spheres_alpha_4e-5", ["histories=[approach]"])
    count, points = 24_000, study.settings.history_points
    numbers = np.arange(count * points) % 7.0
    columns = [np.ones((count, len(one))) for one in (study.inputs, study.quantities)]
    with StudyLog(study, tmp_path / "long.mcap", max_loss=0.0) as log:
        log.add(*columns, numbers.reshape(count, 1, points), *np.zeros((2, count)), [], [])
    tracemalloc.start()
    found = read_study(tmp_path / "long.mcap", unfinished=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.array_equal(found.histories.ravel(), numbers)
    assert (found.values.shape, found.quantities.shape) == tuple(one.shape for one in columns)
    assert peak < 1.6 * numbers.nbytes


def test_blocks_of_a_study_that_do_not_fit_together_are_refused():
    """A block without a channel has zeros there; one that is wider than those before is no part of the study."""
    columns = Gathered(["a", "b"], ["c"])
    for first, values, message in (
        (0, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], {"a": 1, "c": 1, "b": 1}),
        (2, [[7.0, 8.0]], {"a": 1, "b": 1}),
    ):
        channels = tuple(Channel(name, "1", (width,), "") for name, width in message.items())
        times = np.arange(len(values), dtype=np.int64)
        data = samples_message(channels, first, times, np.array(values))
        columns.add(cdr.deserialise(cdr.SAMPLE_BLOCK, data))
    both, single = columns.arrays()
    assert both.tolist() == [[1.0, 3.0], [4.0, 6.0], [7.0, 8.0]]
    assert single.tolist() == [[2.0], [5.0], [0.0]]
    wide = samples_message((Channel("c", "1", (2,), ""),), 3, np.arange(1), np.ones((1, 2)))
    with pytest.raises(ValueError, match="2 numbers a row where there were 1"):
        columns.add(cdr.deserialise(cdr.SAMPLE_BLOCK, wide))


def refused_report(path, capsys):
    assert main(["report", str(path)]) == BAD_INPUT
    return capsys.readouterr().err


@pytest.mark.parametrize("from_write", [0, 3, 5])
def test_a_full_disk_takes_no_result_along(from_write, tmp_path, monkeypatch, capsys):
    write, calls = os.pwritev, []

    def full(*arguments):
        calls.append(arguments)
        if len(calls) > from_write:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(*arguments)

    monkeypatch.setattr(os, "pwritev", full)
    words = ["study", *QUICK, "--samples", "500", "--set", "modality=no", "--out", str(tmp_path / "s.mcap"), "--json"]
    assert main(words) == BAD_INPUT
    out, err = capsys.readouterr()
    assert json.loads(out)["samples"] == 500
    assert "No space left on device" in err


def test_a_study_stopped_by_ctrl_c_draws_no_picture(capsys, tmp_path, monkeypatch):
    """Drawing took seconds more."""

    def interrupted(study, progress, cancelled, start, keep):
        signal.raise_signal(signal.SIGINT)
        return run_study(study, progress, cancelled, start, keep)

    monkeypatch.setattr("bearing_twin.uq.run.run_study", interrupted)
    picture = tmp_path / "x.png"
    assert main(["study", *QUICK, "--plot", str(picture)]) == INTERRUPTED
    assert f"{picture} is not drawn" in capsys.readouterr().err
    assert not picture.exists()
