"""Ensembles: the same numbers by any workers, cancel, no process left behind, failures counted, studies continued."""

import dataclasses
import math
import os
import signal
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from reference.impact import equation_14, power_load, strike
from runs import content_digest
from scipy import stats

import bearing_twin.uq.realisations
import bearing_twin.uq.result
from bearing_twin.base.errors import LogError, StudyError
from bearing_twin.log import cdr
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.run_log import write_log
from bearing_twin.log.study_log import REALISATIONS_TOPIC, SAMPLES_TOPIC, read_study, write_study
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.realisations import NEVER_MEET, has_closed_form, realise, task_of
from bearing_twin.uq.run import memory_needed, run_study
from bearing_twin.uq.statistics import estimate
from bearing_twin.uq.study import Study, load_study, parse_study
from bearing_twin.uq.workers import Ensemble

ALPHA = "contact.measured_alpha"
GAMMA = {"distribution": "gamma", "mean": 1.138e-4, "std": 2e-5}
SPHERES = {"scene": "two_spheres", "inputs": {ALPHA: GAMMA}, "quantities": ["contact_duration", "peak_force"]}
ENSEMBLE = {**SPHERES, "method": "ensemble", "modality": "no", "samples": 400}
LOSSY = {**ENSEMBLE, "set": ["contact.restitution=0.9"], "samples": 40}
LONG_RUN = {
    "scene": "bearing_6203_loose",
    "set": ["run.duration=20000"],  # minutes a realisation
    "inputs": {"geometry.radial_clearance": {"distribution": "uniform", "low": 6e-6, "high": 14e-6}},
    "quantities": ["cage_speed"],
    "samples": 8,
    "workers": 1,
}


def run(mapping, overrides=(), **options):
    return run_study(parse_study(mapping, "s", overrides), **options)


def digest(result, folder, name):
    path = folder / f"{name}.mcap"
    write_study(result, path, run_record=False)
    return path.read_bytes()


def by_form_and_run(task, *values):
    """Realisations by closed forms, and by simulating the same."""
    assert task.closed
    values = np.reshape(values, (-1, 1))
    return realise(task, values), realise(task._replace(closed=False), values)


def test_closed_forms_and_simulations_give_the_same_realisations():
    alpha = np.array([0.9e-4, 1.1e-4, 1.6e-4])
    by_form, by_run = by_form_and_run(task_of(parse_study(SPHERES, "s")), *alpha)
    np.testing.assert_allclose(by_form.quantities, by_run.quantities, rtol=1e-12)
    np.testing.assert_allclose(by_form.quantities[:, 0], alpha * 20.0**-0.2, rtol=1e-12)
    # the published invariant of every impact by Hertz: peak force x duration = 3.67909398 mu v
    np.testing.assert_allclose(by_form.quantities.prod(axis=1), 3.67909398 * 0.1129 * 20.0, rtol=3e-9)
    assert all(any("yield" in sentence for sentence in sentences) for sentences in by_run.warnings.values())


def test_discs_by_closed_form_are_those_of_the_scene():
    task, moduli = task_of(load_study("discs_small_10")), (4e9, 7e9)
    by_form, by_run = by_form_and_run(task, *moduli)
    np.testing.assert_allclose(by_form.quantities, by_run.quantities, rtol=1e-10)
    for modulus, quantities in zip(moduli, by_form.quantities, strict=True):
        truth = strike(equation_14(1.0, 2.0, modulus, 0.3), 2500.0 * math.pi, 10.0, 2e-2)
        assert quantities[task.quantities.index("contact_duration")] == pytest.approx(truth.duration, rel=1e-8)


def test_histories_by_closed_form_are_those_of_the_scene():
    task = task_of(parse_study({**SPHERES, "histories": ["normal_load"], "history_points": 50}, "s"))
    by_form, by_run = by_form_and_run(task, 1.0e-4, 1.3e-4)
    assert by_form.histories.shape == (2, 1, 50)
    np.testing.assert_allclose(by_form.histories, by_run.histories, atol=1e-6 * by_form.histories.max())
    coefficient = 1.25 * 0.1129 * (2.943275184324705 / 1.0e-4) ** 2.5  # alpha's definition, paper 3, eqs. (1), (2)
    truth = strike(power_load(coefficient), 0.1129, 20.0, 4e-4)
    exact = coefficient * np.maximum(truth.approach(task.instants), 0.0) ** 1.5
    exact[task.instants > truth.duration] = 0.0
    np.testing.assert_allclose(by_form.histories[0, 0], exact, atol=1e-7 * exact.max())


def test_one_input_and_closed_forms_need_no_samples():
    result = run(SPHERES, ["sweep={motion.first_velocity: [100.0]}"])
    summary = result.as_dict()
    assert summary["samples"] == 0
    assert {row["method"] for row in summary["quantities"].values()} == {"change_of_variable"}
    exact = summary["quantities"]["contact_duration"]
    assert exact["mean"] == pytest.approx(6.25080949e-5, rel=1e-9)
    assert exact["std"] == pytest.approx(1.09856054e-5, rel=1e-8)
    quantiles = [exact["quantiles"][p]["value"] for p in ("0.05", "0.50", "0.95")]
    assert quantiles == pytest.approx([4.56005791e-5, 6.18657240e-5, 8.16071442e-5], rel=1e-8)
    assert exact["skewness"] == pytest.approx(0.35149, abs=5e-6)
    assert exact["modality"] == {"modes": 1, "p_value": None}
    for row in summary["sweep"]["studies"]:
        value = row["quantities"]["contact_duration"]["quantiles"]["0.50"]["value"]
        assert value == pytest.approx(6.18657240e-5 * (row["value"] / 20.0) ** -0.2, rel=1e-8)


def test_one_input_without_a_closed_form_takes_a_few_runs(quick_workers):
    """Paper 3, section 6: 10 to 50. By damping in proportion the contact time stays proportional to alpha, so gamma."""
    mapping = {**LOSSY, "method": "chaos", "quantities": ["contact_duration"], "workers": 1}
    result = run(mapping)
    duration = result.as_dict()["quantities"]["contact_duration"]
    assert (duration["method"], len(result.status)) == ("chaos", 0)
    assert int(result.summary["stopped_because"].split()[0]) <= 50
    assert duration["validation_error"] < 1e-4
    gamma = stats.gamma((1.138e-4 / 2e-5) ** 2)
    factor = duration["mean"] / gamma.mean()
    assert duration["std"] == pytest.approx(factor * gamma.std(), rel=1e-5)
    assert duration["skewness"] == pytest.approx(2.0 / gamma.std(), rel=1e-2)
    for p in ("0.05", "0.50", "0.95"):
        quantile = duration["quantiles"][p]
        assert quantile["value"] == pytest.approx(factor * gamma.ppf(float(p)), rel=1e-3)
        assert quantile["high"] - quantile["low"] > 2.0 * duration["validation_error"] * duration["std"]
    with pytest.raises(StudyError, match=r"needs a closed form.* choose the method chaos"):
        run({**mapping, "method": "change_of_variable"})


def test_the_same_seed_gives_the_same_bytes_by_one_and_two_workers_and_when_continued(tmp_path, quick_workers):
    less = {**LOSSY, "samples": 20, "checks": 0}
    by_two = run(less, ["workers=2"])
    by_one = run(less, ["workers=1"], start=run(less, ["samples=13", "workers=1"]))
    assert np.array_equal(by_one.quantities, by_two.quantities)
    assert digest(by_one, tmp_path, "one") == digest(by_two, tmp_path, "two")


@pytest.mark.parametrize("sampler", ["random", "sobol"])
def test_a_continued_study_is_one_study_and_knows_which_realisation_failed_of_what(sampler):
    inputs = {
        "disc.material.young_modulus": {"distribution": "uniform", "low": 1e4, "high": 1e6},
        "motion.first_velocity": {"distribution": "normal", "mean": 20.0, "std": 20.0},
    }
    soft = {**ENSEMBLE, "scene": "two_discs", "inputs": inputs, "set": ["solver.allow_invalid=on"]}  # out of range
    at_once, part = (run(soft, [f"sampler={sampler}", f"samples={count}"]) for count in (1024, 256))
    continued = run(soft, [f"sampler={sampler}", "samples=1024"], start=part)
    assert len(at_once.reasons) == 2
    assert any("cannot store the energy" in reason for reason in at_once.reasons)
    for name in ("values", "quantities", "status"):
        assert np.array_equal(getattr(at_once, name), getattr(continued, name), equal_nan=True)
    assert continued.reasons == at_once.reasons
    assert at_once.summary | {"seconds": 0.0} == continued.summary | {"seconds": 0.0}


def test_another_study_is_not_continued():
    part = run(ENSEMBLE)
    for override in ("seed=2", f"inputs.{ALPHA}.std=3e-5", "motion.first_velocity=30", "quantities=[peak_force]"):
        with pytest.raises(StudyError, match="run this one from the beginning"):
            run(ENSEMBLE, ["samples=500", override], start=part)
    cube = run(ENSEMBLE, ["sampler=latin_hypercube"])
    with pytest.raises(StudyError, match="cannot be continued"):
        run(ENSEMBLE, ["sampler=latin_hypercube", "samples=500"], start=cube)


def test_the_stop_rule_wants_two_narrow_intervals_in_a_row():
    rule = ["stop.quantity=contact_duration", "stop.statistic=std", "stop.relative_tolerance=0.05", "samples=100000"]
    result = run(ENSEMBLE, rule)
    path = result.summary["convergence"]
    half, value = np.array(path["half_width"]), np.array(path["estimate"])
    narrow = half <= 0.05 * value
    assert narrow[-2:].all()
    assert not (narrow[:-2] & narrow[1:-1]).any()
    assert path["samples"][-1] == result.summary["samples"] == len(result.status) < 10000
    assert result.summary["stopped_because"].startswith("the half width of the 95 % interval of the std")
    assert half[-1] == result.summary["quantities"]["contact_duration"]["half_width"]
    again = estimate(result.sample("contact_duration")[: path["samples"][-2]], "std")
    assert (again.value, again.half_width) == (value[-2], half[-2])


def test_realisations_that_fail_are_counted_with_their_reason(quick_workers):
    speeds = {"motion.first_velocity": {"distribution": "normal", "mean": 1.0, "std": 1.0}}
    for lossy in ([], ["contact.restitution=0.9", "samples=24", "workers=1"]):
        result = run({**ENSEMBLE, "inputs": speeds}, lossy)
        summary, never = result.as_dict(), result.values[:, 0] <= 0.0
        assert sum(summary["failed"].values()) == never.sum() > 0
        assert summary["failed_share"] == pytest.approx(never.mean(), rel=1e-12)
        assert len(summary["failed"]) == 1
        assert "never meet" in next(iter(summary["failed"]))
        assert np.array_equal(result.status > 0, never)
        assert np.array_equal(np.isnan(result.quantities).all(axis=1), never)
        assert any("failed; the statistics are those of the others" in doubt for doubt in result.doubts)
    assert NEVER_MEET in next(iter(summary["failed"]))


def test_a_study_too_large_is_refused_with_the_estimate():
    study = parse_study({**ENSEMBLE, "histories": ["normal_load"]}, "s", ["samples=10000000"])
    assert memory_needed(study) > 1.6e10
    with pytest.raises(
        StudyError, match=r"would need 2\.\d+e\+10 B for 10000000 samples, more than its memory = 2e\+09 B"
    ):
        run_study(study)
    with pytest.raises(StudyError, match="or raise it"):
        run(ENSEMBLE, ["memory=1e3"])


@pytest.mark.parametrize(
    ("settings", "fewer", "least"),
    [
        # just above a power of two, where most is needed
        ({"samples": 100, "sampler": "sobol", "sensitivity": 5_000}, {"sensitivity": 16}, 0.5),
        # held once while drawn, joined and looked at
        ({"samples": 8192, "histories": ["normal_load"], "history_points": 200}, {"samples": 100}, 0.7),
    ],
)
def test_the_memory_of_a_study_is_what_was_estimated(settings, fewer, least):
    """A study with less has imported everything."""
    run({**ENSEMBLE, **settings, **fewer})
    study = parse_study({**ENSEMBLE, **settings}, "s")
    tracemalloc.start()
    result = run_study(study)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert least * memory_needed(study) < peak < memory_needed(study)
    assert not result.histories.size or result.histories.nbytes < peak < 1.8 * result.histories.nbytes


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"inputs": {ALPHA: GAMMA, "motion.first_velocity": {"distribution": "uniform", "low": 1, "high": 2}}},
            "one uncertain input, not 2; choose the method ensemble",
        ),
        ({"inputs": {ALPHA: {"distribution": "empirical", "values": [1e-4, 2e-4]}}}, "no density"),
    ],
)
def test_a_change_of_variable_that_does_not_fit_is_refused(changes, message):
    with pytest.raises(StudyError, match=message):
        run({**SPHERES, **changes, "method": "change_of_variable"})


def test_progress_tells_the_estimate_and_the_seconds_left_of_all_values_of_a_sweep():
    reported = []
    run({**ENSEMBLE, "sweep": {"motion.first_velocity": [2.0, 5.0]}}, ["samples=500"], progress=reported.append)
    done = [progress.done for progress in reported]
    assert done == sorted(done)
    assert done[-1] == reported[-1].total == 1500
    assert all((progress.seconds_left > 0.0) == (progress.done < progress.total) for progress in reported)
    values = "", "motion.first_velocity = 2", "motion.first_velocity = 5"
    assert tuple(dict.fromkeys(progress.at for progress in reported)) == values
    widths = [progress.half_width for progress in reported if not progress.at and np.isfinite(progress.half_width)]
    assert widths[-1] < widths[0]


@pytest.mark.parametrize("way", ["closed", "by workers"])
def test_what_is_reported_as_done_is_stored(way, monkeypatch, quick_workers):
    """So a node that is ended after its first feedback leaves a log of it."""
    monkeypatch.setattr("bearing_twin.uq.workers.YIELD_PERIOD", 0.0)
    stored, reported = [0], []
    study = ENSEMBLE if way == "closed" else {**LOSSY, "sampler": "latin_hypercube", "samples": 32, "workers": 1}
    result = run(
        study,
        progress=lambda progress: reported.append((progress.done, stored[0])),
        keep=lambda values, *_: stored.append(stored.pop() + len(values)),
    )
    assert reported
    assert all(done <= stored_then for done, stored_then in reported)
    assert reported[-1][0] == stored[0] == len(result.status)


def test_cancel_ends_workers_in_the_middle_of_a_realisation(quick_workers):
    result = run(LONG_RUN, cancelled=lambda: max(map(computed, children()), default=0.0) > 0.2)
    assert result.summary["samples"] == 0
    assert result.summary["stopped_because"] == "cancelled"
    assert children() == []


def test_an_exception_in_between_leaves_no_process(quick_workers):
    reported = []

    def tell(_):
        reported.append(children())
        raise ZeroDivisionError

    short = parse_study(LONG_RUN, "s", ["set=[run.duration=0.01]"])
    with pytest.raises(ZeroDivisionError), Ensemble(task_of(short), 1, "processes", lambda: False) as ensemble:
        ensemble.evaluate(np.full((8, 1), 1e-5), tell)
    assert len(reported[0]) == 1
    assert children() == []


def test_a_worker_that_dies_ends_the_study_with_what_is_done(quick_workers):
    killed = []

    def watch(progress):
        if progress.done >= 8 and not killed:
            killed.extend(children())
            os.kill(killed[0], signal.SIGKILL)

    quick = ["set=[run.duration=0.01, run.output_rate=1000]", "samples=64", "batch=8", "stop.minimum=8"]
    result = run(LONG_RUN, quick, progress=watch)
    assert len(killed) == 1
    assert 8 <= result.summary["samples"] < 64
    assert result.summary["stopped_because"].startswith("failed: a worker process died")
    assert any("a worker process died" in doubt for doubt in result.doubts)
    assert children() == []


@pytest.mark.environment
def test_a_script_that_guards_nothing_is_told_so(tmp_path):
    script = tmp_path / "naked.py"
    lines = (
        "import threading, time",
        "threading.Thread(target=time.sleep, args=(600,), daemon=True).start()",  # beside which nothing is forked
        f"mapping = { {**LOSSY, 'workers': 1}!r}",
        "from bearing_twin import parse_study, run_study",
        "run_study(parse_study(mapping, 's'))",
    )
    script.write_text("\n".join(lines), encoding="utf-8")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 1
    assert 'behind `if __name__ == "__main__":`' in done.stderr


def test_an_error_nobody_foresaw_is_the_failure_of_one_realisation(monkeypatch):
    task = task_of(parse_study(LOSSY, "s"))
    calls = []

    def simulate(scene):
        calls.append(scene)
        if len(calls) == 2:
            raise ZeroDivisionError("float division by zero")
        return from_the_library(scene)

    from_the_library = bearing_twin.uq.realisations.simulate
    monkeypatch.setattr("bearing_twin.uq.realisations.simulate", simulate)
    realised = realise(task, np.full((3, 1), 1e-4))
    assert realised.failures == {1: "ZeroDivisionError: float division by zero"}
    assert np.isfinite(realised.quantities).all(axis=1).tolist() == [True, False, True]


def test_a_log_gives_the_study_back(tmp_path):
    speeds = {"motion.first_velocity": {"distribution": "normal", "mean": 3.0, "std": 2.0}, ALPHA: GAMMA}
    mapping = {**ENSEMBLE, "inputs": speeds, "histories": ["normal_load", "approach"], "history_points": 30}
    result = run(mapping, ["history_duration=1e-4"])
    path = write_study(result, tmp_path / "study.mcap")
    again = read_study(path)
    assert again.study == result.study
    for name in ("values", "quantities", "histories", "status"):
        assert np.array_equal(getattr(again, name), getattr(result, name), equal_nan=True), name
    assert again.status.dtype == result.status.dtype
    assert again.reasons == result.reasons
    assert again.as_dict() == result.as_dict()
    assert run(mapping, ["history_duration=1e-4"], start=again).summary["samples"] == 400
    with pytest.raises(LogError, match="exists"):
        write_study(result, path)
    first, second = (write_study(result, tmp_path / name, run_record=False) for name in ("one.mcap", "other.mcap"))
    assert content_digest(first) == content_digest(second)


def test_realisations_stand_at_the_time_of_their_arrival_and_are_numbered(tmp_path):
    before = time.time_ns()
    result = run(ENSEMBLE)
    times, single = [], []
    for message in raw_messages(write_study(result, tmp_path / "study.mcap")):
        assert message.publish_time == message.log_time
        if message.topic.name == REALISATIONS_TOPIC:
            realisation = cdr.deserialise(cdr.REALISATION, message.data)
            assert realisation.header.stamp.sec * 10**9 + realisation.header.stamp.nanosec == message.log_time
            assert [*realisation.name] == ["input " + ALPHA, *(f"quantity {name}" for name in result.study.quantities)]
            single.append((realisation.number, message.log_time, realisation.failed, realisation.value.tolist()))
        elif message.topic.name == SAMPLES_TOPIC:
            block = cdr.deserialise(cdr.SAMPLE_BLOCK, message.data)
            assert block.first_sequence == len(times)
            times += block.time_ns.tolist()
            assert times[-1] == message.log_time
    numbers, arrivals, failed, values = zip(*single, strict=True)
    assert [*numbers] == [*range(len(result.status))]
    assert [*arrivals] == times == sorted(set(times))
    assert before <= times[0] <= times[-1] <= time.time_ns()
    assert [*failed] == (result.status > 0).tolist()
    assert np.array_equal(values, np.hstack((result.values, result.quantities)), equal_nan=True)


def test_a_study_without_samples_comes_back_from_its_log_and_a_log_of_something_else_does_not(tmp_path):
    result = run(SPHERES)
    again = read_study(write_study(result, tmp_path / "exact.mcap"))
    assert again.as_dict() == result.as_dict()
    assert again.values.shape == (0, 1)
    write_log(simulate(load_scene("two_spheres", ["run.output_rate=5e5"])), tmp_path / "run.mcap")
    with pytest.raises(LogError, match="holds no study"):
        read_study(tmp_path / "run.mcap")


def test_a_log_of_a_version_with_other_keys_is_read(tmp_path, monkeypatch):
    result, resolved = run(SPHERES), Study.resolved
    further_keys = {"densities": {"contact_duration": [6e-5]}, "time_limit": 3.0}
    with monkeypatch.context() as earlier:
        earlier.setattr(Study, "resolved", lambda study: resolved(study) | further_keys)
        path = write_study(result, tmp_path / "earlier.mcap")
        assert read_study(path).study == result.study
        speed = {"blow.speed": {"distribution": "uniform", "low": 1.0, "high": 2.0}}
        beam = {"scene": "sphere_on_beam", "inputs": speed, "quantities": ["peak_force"]}
        of_beam = parse_study(beam, "a study")
        further_keys["scene"] = of_beam.scene | {"solver": of_beam.scene["solver"] | {"static_tail": "contact"}}
        summary = result.summary | {"quantities": {"peak_force": {}}}
        path = write_study(dataclasses.replace(result, study=of_beam, summary=summary), tmp_path / "beam.mcap")
    assert read_study(path).study.scene == of_beam.scene


def test_dask_says_what_is_missing_or_wrong(monkeypatch):
    monkeypatch.setattr("bearing_twin.uq.workers.DASK_PATIENCE", 0.5)
    with pytest.raises(StudyError, match="no Dask scheduler at localhost:1 "):
        run(LOSSY, ["executor=dask://localhost:1"])
    monkeypatch.setitem(sys.modules, "distributed", None)  # as if it were not installed
    with pytest.raises(StudyError, match="needs the package distributed"):
        run(LOSSY, ["executor=dask://localhost:1"])


@pytest.mark.environment
def test_dask_workers_give_the_same_numbers(tmp_path):
    """On a cluster that listens on this machine's own address alone; nothing of study and cluster stays behind."""
    import dask  # here, for the import takes a second
    import distributed

    host, before = "127.0.0.1", set(children())
    with (
        dask.config.set({"temporary-directory": str(tmp_path)}),
        distributed.LocalCluster(1, threads_per_worker=1, host=host, dashboard_address=f"{host}:0") as cluster,
    ):
        address = cluster.scheduler_address.removeprefix("tcp://")
        result = run(LOSSY, [f"executor=dask://{address}"])
        ours = [name for name in cluster.scheduler.clients if name.startswith("Client")]
        assert wait_for(lambda: not [name for name in ours if name in cluster.scheduler.clients], 60.0)
    assert np.array_equal(result.quantities, run(LOSSY, ["workers=1"]).quantities)
    wait_for(lambda: set(children()) <= before, 60.0)


def stat_of(pid) -> list[str]:
    """Fields of a process in /proc from its state on: state, parent, group, session, ...; empty without it."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return []


def living(field: int, value: int) -> list[int]:
    """Pids of the living processes with this value of a field of `stat_of`."""
    stats_by_pid = {int(entry.name): stat_of(entry.name) for entry in Path("/proc").glob("[0-9]*")}
    return [pid for pid, fields in stats_by_pid.items() if fields and fields[0] != "Z" and int(fields[field]) == value]


def children(parent=None) -> list[int]:
    """Pids of living children of a process, but for the tracker of multiprocessing, which lives on."""
    return [pid for pid in living(1, parent or os.getpid()) if "resource_tracker" not in command_of(pid)]


def command_of(pid) -> str:
    try:
        return Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8")
    except OSError:
        return ""


def computed(pid) -> float:
    """CPU time of a process [s]; that of one forked to compute begins with its task."""
    return int((stat_of(pid) or [0] * 12)[11]) / os.sysconf("SC_CLK_TCK")


def wait_for(condition, seconds):
    until = time.monotonic() + seconds
    while not (result := condition()):
        assert time.monotonic() < until, "the condition was not met"
        time.sleep(0.05)
    return result


def test_closed_forms_are_used_only_where_they_describe_the_scene():
    def closed(overrides, names=("contact_duration",), varied=()):
        study = parse_study(SPHERES, "s", overrides)
        return has_closed_form("two_spheres", study.scene_at([1e-4]).parameters, names, varied=varied)

    assert closed([])
    assert not closed(["contact.restitution=0.9"])
    assert not closed(["solver.stepper=rk4"])
    assert not closed([], ("restitution",))
    assert not closed([], varied=("contact.restitution",))
