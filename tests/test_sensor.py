"""The accelerometer on the housing of a bearing: its equation, its samples in logs, what `spectrum` hears."""

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bearing_twin import SceneError, StudyError, load_scene, load_study, read_log, simulate, write_log
from bearing_twin.command import cli
from bearing_twin.log import cdr, stream
from bearing_twin.log.bag import LogReader

SPALLS = {"outer": "BPFO", "inner": "BPFI"}
OK, WARN, STALE = 0, 1, 3


def samples_of(stream) -> np.ndarray:
    """Time [s] and acceleration [m/s^2] of each sample of a run or a log."""
    return np.concatenate([one.records["acceleration"] for one in stream.blocks() if "acceleration" in one.records])


def health(log) -> list[tuple[int, int]]:
    """Level and time [s] of each message of the topic `health` in a log."""
    messages = LogReader(log).messages({"/bearing/health"})
    found = [cdr.deserialise(one.topic.ros_type, one.data) for one in messages]
    return [(one.status[0].level, one.header.stamp.sec) for one in found]


def test_the_housing_follows_its_equation_of_motion():
    changes = [
        "run.duration=0.02",
        "run.output_rate=12000",
        "sensor.noise=0",
        "sensor.direction=0,2,0",
        "solver.check=none",
    ]
    scene = load_scene("bearing_6205_spall_outer", changes)
    blocks = list(simulate(scene).blocks())
    found = np.concatenate([one.records["acceleration"] for one in blocks if "acceleration" in one.records])
    times = 1e-9 * np.concatenate([one.time_ns for one in blocks])
    force = np.concatenate([one.values["outer_ring_force"] for one in blocks])[:, 1]
    housing = scene.parameters.housing

    def acceleration(t, x, v):
        return (np.interp(t, times, force) - housing.damping * v - housing.stiffness * x) / housing.mass

    start = [force[0] / housing.stiffness, 0.0]
    moved = solve_ivp(
        lambda t, y: [y[1], acceleration(t, *y)], (0.0, times[-1]), start, t_eval=found[:, 0], rtol=1e-9, atol=1e-15,
        max_step=2e-5,
    )  # fmt: skip
    true = acceleration(found[:, 0], *moved.y)
    assert np.abs(true).max() > 1.0
    assert np.abs(found[:, 1] - true).max() < 2e-3 * np.abs(true).max()


def test_samples_come_at_their_own_rate_and_do_not_depend_on_how_a_run_is_cut(tmp_path, capsys):
    log, longer = tmp_path / "run.mcap", tmp_path / "longer.mcap"
    keys = ("--set", "sensor.rate=12300", "--set", "solver.check=none")
    scene = ("simulate", "bearing_6205_spall_outer", *keys)
    assert cli.main([*scene, "--duration", "0.3", "--out", str(log)]) == 0
    found = samples_of(read_log(log))
    assert len(found) == 3691
    assert found[:, 0] == pytest.approx(np.arange(3691) / 12300.0, abs=1e-12)
    capsys.readouterr()
    assert cli.main(["verify", str(log), "--json"]) == 0
    assert not any(json.loads(capsys.readouterr().out)["deviations"].values())
    waves = [
        cdr.deserialise(cdr.WAVEFORM, one.data) for one in LogReader(log).messages({"/bearing/records/acceleration"})
    ]
    assert np.array_equal(np.concatenate([one.samples for one in waves]), found[:, 1])
    assert {(one.samples.dtype.str, one.rate, one.unit) for one in waves} == {("<f4", 12300.0, "m/s^2")}
    firsts, lengths = zip(*((one.first_sequence, len(one.samples)) for one in waves), strict=True)
    assert list(firsts) == [0, *np.cumsum(lengths)[:-1]]
    assert all(1230 - 13 <= one <= 1230 + 13 for one in lengths[1:-1])
    stamps = [one.header.stamp.sec + 1e-9 * one.header.stamp.nanosec for one in waves]
    assert stamps == pytest.approx(np.array(firsts) / 12300.0, abs=1e-9)
    coarse = load_scene(
        "bearing_6205_spall_outer", [*keys[1::2], "run.duration=0.3", "run.output_rate=200", "run.publish_rate=50"]
    )
    assert samples_of(simulate(coarse)) == pytest.approx(found, abs=1e-3 * np.abs(found[:, 1]).max())
    assert cli.main([*scene, "--duration", "0.4", "--out", str(longer)]) == 0
    more = tmp_path / "more.mcap"
    assert cli.main(["simulate", str(log), "--continue", "0.1", "--out", str(more)]) == 0
    whole, rest = samples_of(read_log(longer)), samples_of(read_log(more))
    assert np.array_equal(rest, whole[-len(rest) :])
    assert 1230 <= len(rest) < 6000
    capsys.readouterr()


def test_a_waveform_is_no_longer_than_is_read(tmp_path, monkeypatch):
    """As of a scene whose outputs lie many seconds apart."""
    run = simulate(load_scene("bearing_6205_spall_outer", ["solver.check=none", "run.duration=0.05"]))
    monkeypatch.setattr(stream, "MOST_SAMPLES", 100)
    write_log(run, tmp_path / "run.mcap")
    found = LogReader(tmp_path / "run.mcap").messages({"/bearing/records/acceleration"})
    assert max(len(cdr.deserialise(cdr.WAVEFORM, one.data).samples) for one in found) == 100
    assert np.array_equal(samples_of(read_log(tmp_path / "run.mcap")), samples_of(run))


def test_spectrum_names_the_spalls_that_scenes_have(tmp_path, capsys):
    for (on, family), seconds in zip(SPALLS.items(), (2, 1), strict=True):
        log = tmp_path / f"{on}.mcap"
        words = ("--set", "solver.check=none", "--duration", str(seconds), "--out", str(log))
        assert cli.main(["simulate", f"bearing_6205_spall_{on}", *words]) == 0
        capsys.readouterr()
        assert cli.main(["spectrum", str(log), "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        lines = {one["name"]: one for one in found["lines"]}
        assert found["verdict"] == on
        assert lines[family]["off"] == pytest.approx(0.0, abs=3e-3)
        assert found["shaft_hz"] == pytest.approx(183.26 / (2 * np.pi))
        sides = [lines[f"{family}{sign}fs"]["over_noise_db"] for sign in "+-"]
        assert (min(sides) > 15.0) == (on == "inner")
        assert health(log) == [(STALE, 0), (WARN, 1), (WARN, 2)][: 1 + seconds]
    sound = tmp_path / "sound.mcap"
    scene = ("bearing_6205_spall_outer", "--set", "defects=[]", "--set", "solver.check=none", "--duration", "1")
    assert cli.main(["simulate", *scene, "--out", str(sound)]) == 0
    capsys.readouterr()
    assert cli.main(["spectrum", str(sound), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "nothing stands out"
    assert health(sound) == [(STALE, 0), (OK, 1)]


def test_a_run_its_log_and_spectrum_give_the_same_levels(tmp_path, capsys):
    log = tmp_path / "run.mcap"
    scene = ("bearing_6205_spall_inner", "--duration", "1", "--set", "solver.check=none")
    found = []
    for words in (("simulate", *scene, "--out", str(log)), ("report", str(log)), ("spectrum", str(log))):
        assert cli.main([*words, "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out))
    run, logged, spectrum = found
    level = {line["name"]: line["over_noise_db"] for line in spectrum["lines"]}
    assert level["BPFI"] > 20.0
    for figure, name in (("bpfo", "BPFO"), ("bpfi", "BPFI"), ("bsf", "2BSF")):
        assert run[f"{figure}_over_noise_db"] == logged[f"{figure}_over_noise_db"]
        assert run[f"{figure}_over_noise_db"] == pytest.approx(level[name], abs=1e-3)
    assert run["acceleration_rms_m_s2"] == pytest.approx(spectrum["rms"], rel=1e-6)


def test_the_study_of_detectability_goes_from_noise_to_a_line_that_stands_out():
    study = load_study("spall_detectability")
    lengths, levels = study.sweep[1], []
    for length in (lengths[0], lengths[-1]):
        run = simulate(study.at(length).scene_at([3, 10e-6]))
        assert all(len(block) for block in run.blocks())
        levels.append(run.report.figures["bpfo_over_noise_db"])
    assert levels[0] < 10.0 < 20.0 < levels[1]


def test_numbers_in_the_list_of_defects_are_reached_by_their_place():
    scene = load_scene("bearing_6205_spall_outer", ["defects.0.spall.length=0.3 mm", "defects.0.on=inner"])
    assert (scene.parameters.defects[0].spall.length, scene.parameters.defects[0].on) == (0.3e-3, "inner")
    study = {"scene": "bearing_6205_spall_outer", "set": ["sensor.rate=50 kHz"], "quantities": ["bpfo_over_noise"]}
    uniform = {"distribution": "uniform", "low": 1e-4, "high": 3e-4}
    inputs = {"defects.0.spall.length": {**uniform, "also": ["defects.0.spall.width"]}}
    spall = load_study({**study, "inputs": inputs}).scene_at([2e-4]).parameters.defects[0].spall
    assert (spall.length, spall.width) == (2e-4, 2e-4)
    for key in ("defects.1.spall.length", "defects.x.on", "defects.-1.on"):
        with pytest.raises(SceneError, match="place"):
            load_scene("bearing_6205_spall_outer", [f"{key}=1e-4"])
    for key in ("defects.1.spall.length", "defects.0.spall.length.0", "defects.0.on"):
        with pytest.raises(StudyError, match="defects"):
            load_study({**study, "inputs": {key: uniform}})
    with pytest.raises(StudyError, match="sensor"):
        load_study({**study, "scene": "bearing_6203", "set": [], "inputs": {"drive.speed": 100.0}})


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ("sensor.rate=2000", "at least"),
        ("sensor.rate=60000", "at most"),
        ("sensor.direction=0,0,0", "zero"),
        ("solver.stepper=imex", "rodas4"),
        ("housing.mass=0", "above 0"),
    ],
)
def test_a_sensor_that_cannot_hear_is_refused(change, word):
    with pytest.raises(SceneError, match=word):
        load_scene("bearing_6205_spall_outer", [change])
