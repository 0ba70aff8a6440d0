"""The accelerometer on the housing of a bearing: its equation, its samples in logs, what `spectrum` hears."""

import contextlib
import io
import json

import numpy as np
import pytest
from runs import run_all
from scipy.signal import lsim, lti

from bearing_twin import SceneError, StudyError, load_scene, load_study, read_log, simulate, write_log
from bearing_twin.command import cli
from bearing_twin.kinds import KINDS
from bearing_twin.log import cdr, stream
from bearing_twin.log.bag import LogReader
from bearing_twin.run.scene import choose
from bearing_twin.vibration.envelope import spectrum_of

SPALLS = {"outer": "BPFO", "inner": "BPFI"}
OK, WARN, STALE = 0, 1, 3
LINE_IS_THERE = 10.0  # dB over the noise, docs/vibration.md


def samples_of(source) -> np.ndarray:
    """Time [s] and acceleration [m/s^2] of each sample of a run or a log."""
    return np.concatenate(
        [block.records["acceleration"] for block in source.blocks() if "acceleration" in block.records]
    )


def health(log) -> list[tuple[int, int]]:
    """Level and time [s] of each message of the topic `health` in a log."""
    messages = LogReader(log).messages({"/bearing/health"})
    statuses = [cdr.deserialise(message.topic.ros_type, message.data) for message in messages]
    return [(message.status[0].level, message.header.stamp.sec) for message in statuses]


HELD = ("model.dimension=prescribed", "rings.inner.load=0,0,0", "drive.offset=0,-2e-5,0")


@pytest.mark.parametrize("ring", [(), HELD], ids=["moving rings", "held rings"])
def test_the_housing_follows_its_equation_of_motion(ring):
    """In the pass band of the sensor's filter, up to 0.4 of the rate."""
    run = "run.duration=0.2", "run.output_rate=100000", "solver.check=none"
    sensor = "sensor.noise=0", "sensor.direction=0,2,0", "housing.damping=2e4"
    scene = load_scene("bearing_6205_spall_outer", [*run, *sensor, *ring])
    _, block = run_all(scene)
    samples, times = block.records["acceleration"][:-1], 1e-9 * block.time_ns[:-1]
    force = block.values["outer_ring_force"][:-1, 1]
    housing = scene.parameters.housing
    system = lti([1.0, 0.0, 0.0], [housing.mass, housing.damping, housing.stiffness])
    _, true, _ = lsim(system, force - force[0], times)  # from rest under the first force
    expected, measured = (
        np.abs(np.fft.rfft(values * np.hanning(len(values)))[:960]) / (0.5 * len(values))
        for values in (true, samples[:, 1])
    )
    band = (np.arange(960) > 20) & (expected > 0.01 * expected.max())  # every 5 Hz
    assert expected.max() > 1.0
    assert np.count_nonzero(band) > 100
    assert measured[band] == pytest.approx(expected[band], rel=0.02, abs=2e-3 * expected.max())


def offsets(*changes) -> np.ndarray:
    """Displacement [m] of the inner ring along y, and the energy made by the numbers over the work."""
    report, block = run_all("bearing_6205_spall_outer", "solver.check=none", *changes)
    assert abs(report.figures["energy_closure"]) < 5e-5
    return block.values["inner_ring_offset"][:, 1]


def test_the_outer_ring_moves_with_its_housing_as_a_held_one_where_that_is_heavy():
    brief = "run.duration=0.02", "run.output_rate=10000", "wanted.tolerance=1e-6"
    held, moving = offsets("sensor.on=none", *brief), offsets(*brief)
    assert offsets("housing.mass=1e9", *brief) == pytest.approx(held, abs=1e-6 * np.ptp(held))
    assert np.abs(moving - held).max() > 0.1 * np.ptp(held)


def test_a_housing_gives_way_to_its_load():
    """By F/k, from where the outer ring stands at the start."""
    load = "defects=[]", "rings.inner.change={time: 0.02, load: [0, -500, 0]}", "run.duration=0.2"
    soft = offsets(*load, "housing={mass: 5, stiffness: 1e7, damping: 2e4}")
    held = offsets(*load, "sensor.on=none")
    assert soft[0] == pytest.approx(held[0], abs=1e-9)
    assert np.mean((soft - held)[-len(held) // 4 :]) == pytest.approx(-500.0 / 1e7, rel=1e-2)


def test_samples_come_at_their_own_rate_and_do_not_depend_on_how_a_run_is_cut(tmp_path, run_json):
    log, longer = tmp_path / "run.mcap", tmp_path / "longer.mcap"
    keys = ("--set", "sensor.rate=12300", "--set", "solver.check=none")
    scene = ("simulate", "bearing_6205_spall_outer", *keys)
    assert cli.main([*scene, "--duration", "0.2", "--out", str(log)]) == 0
    samples = samples_of(read_log(log))
    assert len(samples) == 2461
    assert samples[:, 0] == pytest.approx(np.arange(2461) / 12300.0, abs=1e-12)
    assert not any(run_json("verify", log)["deviations"].values())
    messages = LogReader(log).messages({"/bearing/records/acceleration"})
    waveforms = [cdr.deserialise(cdr.WAVEFORM, message.data) for message in messages]
    assert np.array_equal(np.concatenate([message.samples for message in waveforms]), samples[:, 1])
    assert {(message.samples.dtype.str, message.rate, message.unit) for message in waveforms} == {
        ("<f4", 12300.0, "m/s^2")
    }
    firsts, lengths = zip(*((message.first_sequence, len(message.samples)) for message in waveforms), strict=True)
    assert list(firsts) == [0, *np.cumsum(lengths)[:-1]]
    assert all(1230 - 13 <= length <= 1230 + 13 for length in lengths[1:-1])
    stamps = [message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec for message in waveforms]
    assert stamps == pytest.approx(np.array(firsts) / 12300.0, abs=1e-9)
    rates = "run.duration=0.2", "run.output_rate=200", "run.publish_rate=50"
    coarse = load_scene("bearing_6205_spall_outer", [*keys[1::2], *rates])
    assert samples_of(simulate(coarse)) == pytest.approx(samples, abs=1e-3 * np.abs(samples[:, 1]).max())
    assert cli.main([*scene, "--duration", "0.3", "--out", str(longer)]) == 0
    continued = tmp_path / "more.mcap"
    assert cli.main(["simulate", str(log), "--continue", "0.1", "--out", str(continued)]) == 0
    all_samples, later_samples = samples_of(read_log(longer)), samples_of(read_log(continued))
    assert np.array_equal(later_samples, all_samples[-len(later_samples) :])
    assert 1230 <= len(later_samples) < 6000


def test_samples_go_on_from_a_snapshot_to_the_bit_and_afresh_from_one_of_an_older_version():
    scene = load_scene("bearing_6205_spall_outer", ["solver.check=none"])
    first, same, from_old = (KINDS[scene.kind].motion(scene.parameters, choose(scene)) for _ in range(3))
    first.advance(np.array([0.0]), 2.1e-5)  # between two samples
    first.take_records()
    snapshot = json.loads(json.dumps(first.snapshot()))
    same.resume(snapshot)
    from_old.resume(snapshot | {"heard": snapshot["heard"][:3], "border": snapshot["border"][:18]})
    samples = []
    for motion in (first, same, from_old):
        motion.advance(np.array([1e-2]), 1e-2)
        samples.append(motion.take_records()["acceleration"])
    assert np.array_equal(samples[0], samples[1])
    assert np.array_equal(samples[0][:, 0], samples[2][:, 0])
    assert len(samples[0]) == 120


def test_a_waveform_is_no_longer_than_is_read(tmp_path, monkeypatch):
    """As of a scene whose outputs lie many seconds apart."""
    run = simulate(load_scene("bearing_6205_spall_outer", ["solver.check=none", "run.duration=0.05"]))
    monkeypatch.setattr(stream, "MOST_SAMPLES", 100)
    write_log(run, tmp_path / "run.mcap")
    messages = LogReader(tmp_path / "run.mcap").messages({"/bearing/records/acceleration"})
    assert max(len(cdr.deserialise(cdr.WAVEFORM, message.data).samples) for message in messages) == 100
    assert np.array_equal(samples_of(read_log(tmp_path / "run.mcap")), samples_of(run))


def test_a_log_has_a_record_of_its_sensor_alone(tmp_path, refused):
    run = simulate(load_scene("bearing_6205_spall_outer", ["solver.check=none", "run.duration=0.01"]))
    write_log(run, tmp_path / "run.mcap")
    assert "leave out --key" in refused("spectrum", tmp_path / "run.mcap", "--key", "cage_speed")
    write_log(simulate(load_scene("bearing_6203", ["run.duration=0.01"])), tmp_path / "none.mcap")
    assert "its scene has no `sensor`" in refused("spectrum", tmp_path / "none.mcap")


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """Logs of a spall on the outer and on the inner raceway and of none, with what `simulate --json` printed."""
    folder, runs = tmp_path_factory.mktemp("played"), {}
    for name, seconds, scene in (
        ("outer", "2", ("bearing_6205_spall_outer",)),
        ("inner", "1", ("bearing_6205_spall_inner",)),
        ("sound", "1", ("bearing_6205_spall_outer", "--set", "defects=[]")),
    ):
        log, printed = folder / f"{name}.mcap", io.StringIO()
        options = ("--set", "solver.check=none", "--duration", seconds, "--out", str(log), "--json")
        with contextlib.redirect_stdout(printed):
            assert cli.main(["simulate", *scene, *options]) == 0
        runs[name] = log, json.loads(printed.getvalue())
    return runs


def test_spectrum_names_the_spalls_that_scenes_have(played, run_json):
    for ring, family in SPALLS.items():
        log, run = played[ring]
        spectrum = run_json("spectrum", log)
        lines = {line["name"]: line for line in spectrum["lines"]}
        assert spectrum["verdict"] == ring
        assert lines[family]["off"] == pytest.approx(0.0, abs=3e-3)
        assert spectrum["shaft_hz"] == pytest.approx(183.26 / (2 * np.pi))
        sides = [lines[f"{family}{sign}fs"]["over_noise_db"] for sign in "+-"]
        assert (min(sides) > 15.0) == (ring == "inner")
        assert health(log) == [(STALE, 0), (WARN, 1), (WARN, 2)][: 2 + (ring == "outer")]
        logged = run_json("report", log)
        for figure, name in (("bpfo", "BPFO"), ("bpfi", "BPFI"), ("bsf", "2BSF")):
            assert run[f"{figure}_over_noise_db"] == logged[f"{figure}_over_noise_db"]
            assert run[f"{figure}_over_noise_db"] == pytest.approx(lines[name]["over_noise_db"], abs=1e-3)
        assert run["acceleration_rms_m_s2"] == pytest.approx(spectrum["rms"], rel=1e-6)
    assert lines["BPFI"]["over_noise_db"] > 20.0
    sound, _ = played["sound"]
    assert run_json("spectrum", sound)["verdict"] == "nothing stands out"
    assert health(sound) == [(STALE, 0), (OK, 1)]


@pytest.mark.parametrize("options", [(), ("--topic", "/bearing/records/acceleration", "--bearing", "6205")])
def test_spectrum_of_a_log_without_an_end_is_of_what_is_in_it(options, played, tmp_path, run_cli):
    log, _ = played["outer"]
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(log.read_bytes()[: log.stat().st_size * 7 // 10])
    speed = ("--speed", "1750rpm") if options else ()
    out, err = run_cli("spectrum", cut, "--json", *options, *speed)
    assert 1.0 < json.loads(out)["seconds"] < 2.0
    assert json.loads(out)["verdict"] == "outer"
    assert "has no end" in err


def test_no_harmonics_are_folded_down(played):
    """Those of BPFO at the rate of samples, and at four times that: by their lines in the envelope."""
    log = read_log(played["outer"][0])
    samples, scene = samples_of(log)[:, 1], log.scene.parameters
    rate = scene.sensor.rate
    for band in ((1425.0, 2850.0), (2850.0, 5700.0)):
        spectrum = spectrum_of(samples, rate, scene.geometry, scene.drive.speed, band)
        bpfo = next(line for line in spectrum.lines if line.name == "BPFO")
        assert bpfo.over_noise_db > 40.0
        for multiple in (1, -1, 4, -4):
            folded = multiple * rate % bpfo.found_hz
            nearby = np.abs(spectrum.orders * spectrum.shaft_hz - folded) < 1.0  # Hz
            assert spectrum.level[nearby].max() < LINE_IS_THERE


def test_a_record_without_noise_has_the_speed_of_its_shaft_among_folded_lines():
    """At 25 kHz impacts leave multiples of 9.5 Hz, the third of which lies 2 % below the shaft's speed."""
    keys = "sensor.noise=0", "sensor.rate=25000", "solver.check=none", "run.duration=1"
    scene = load_scene("bearing_6205_spall_outer", keys)
    samples, speed = samples_of(simulate(scene))[:, 1], scene.parameters.drive.speed
    spectrum = spectrum_of(samples, scene.parameters.sensor.rate, scene.parameters.geometry, speed)
    bpfo = next(line for line in spectrum.lines if line.name == "BPFO")
    assert spectrum.verdict == "outer"
    assert spectrum.shaft_hz == pytest.approx(speed / (2 * np.pi), rel=1e-4)
    assert bpfo.off == pytest.approx(0.0, abs=2e-3)


def test_the_study_of_detectability_goes_from_noise_to_a_line_that_stands_out():
    study = load_study("spall_detectability")
    lengths, levels = study.sweep[1], []
    for length in (lengths[0], lengths[-1]):
        run = simulate(study.at_sweep_value(length).scene_at([3, 10e-6]))
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
    ("change", "message"),
    [
        ("sensor.rate=2000", "at least"),
        ("sensor.rate=60000", "at most"),
        ("sensor.direction=0,0,0", "zero"),
        ("solver.stepper=imex", "rodas4"),
        ("housing.mass=0", "above 0"),
    ],
)
def test_a_sensor_that_cannot_hear_is_refused(change, message):
    with pytest.raises(SceneError, match=message):
        load_scene("bearing_6205_spall_outer", [change])
