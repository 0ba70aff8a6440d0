"""Logs that the program wrote before kinds had rows: other words in their scenes, and no topics for records."""

from pathlib import Path

import numpy as np
import pytest

from bearing_twin import read_log, simulate, write_log
from bearing_twin.command import cli
from bearing_twin.kinds import KINDS
from bearing_twin.run.report import report_of
from bearing_twin.run.verify import verify

EARLIER = Path(__file__).parent / "earlier"
OF_A_SENSOR = EARLIER / "records_of_a_sensor.mcap"  # whose samples are SampleBlocks of times and values
LOGS = sorted(set(EARLIER.glob("*.mcap")) - {OF_A_SENSOR})
RECORDED_TODAY = [path for path in LOGS if path.stem != "bearing_6203"]  # whose kinds make figures of records
NEAR = 1e-6  # of the greatest of a channel, or the tolerance wanted: methods have changed


def named(path):
    return path.stem


@pytest.mark.parametrize("path", LOGS, ids=named)
def test_a_log_without_records_is_read_and_its_scene_simulated_again(path):
    log = read_log(path)
    blocks = list(log.blocks())
    assert not log.has_records
    assert sum(map(len, blocks)) == log.scene.outputs
    greatest = {
        channel.name: max(np.abs(block.values[channel.name]).max() for block in blocks) for channel in log.channels
    }
    again = verify(log)
    assert again.lacks
    differences, near = again.deviations, max(NEAR, log.scene.parameters.wanted.tolerance)
    assert set(differences) == set(greatest)
    near = {name: near * max(size, 1.0) for name, size in greatest.items()}
    if "bending_stress" in near:  # wanted.tolerance is of forces and times: stresses take more modes
        near["bending_stress"] *= 10.0
    far = {name: deviation for name, deviation in differences.items() if deviation > near[name]}
    assert not far


@pytest.mark.parametrize("path", RECORDED_TODAY, ids=named)
def test_a_report_on_it_gives_no_figure_another_meaning(path, run_cli):
    log = read_log(path)
    report, _ = report_of(log)
    plain = {form.format(channel.name) for channel in log.channels for form in ("greatest_{}", "{}_at_end")}
    for key in report.figures.keys() & KINDS[log.scene.kind].meanings_of().keys():
        assert not any(key.startswith(name) for name in plain), "drawn from a channel, its name of another meaning"
    assert report.samples == log.scene.outputs
    run_cli("report", path, "--json")


def test_a_bearing_of_the_first_version_whose_ring_has_no_tilt_is_reported_drawn_and_viewed(tmp_path, run_json):
    log = EARLIER / "bearing_6203.mcap"
    report = run_json("report", log, "--plot", tmp_path / "run.png")
    assert report["greatest_normal_load_inner_n"] == pytest.approx([48.5] * 8, abs=0.01)
    assert report["ring_force_n"] == pytest.approx([0.0, -0.048, -14.228], abs=1e-3)
    assert run_json("view", log, "--out", tmp_path / "page.html")["bytes"] > 1e5


def test_scenes_in_them_have_the_words_of_today():
    parameters = {path.stem: read_log(path).scene.parameters for path in LOGS}
    assert parameters["two_spheres"].first.material.yield_strength == pytest.approx(1.6e9 / 1.6)
    assert parameters["sphere_on_beam"].beam.theory == "euler"
    assert parameters["ellipsoid_rocking"].contact.friction_coefficient == pytest.approx(0.15)
    assert parameters["bearing_6203"].wanted.tolerance == pytest.approx(1e-3)


def test_samples_of_a_sensor_in_sample_blocks_are_those_of_a_waveform(tmp_path, run_json):
    """The sensor is filtered against aliasing since, and its housing acts back on the balls: the levels differ."""
    log = read_log(OF_A_SENSOR)
    samples = np.concatenate([block.records["acceleration"][:, 1] for block in log.blocks()])
    assert np.array_equal(samples, samples.astype(np.float32))
    assert 0.0 < verify(log).deviations["acceleration"] < 2.0 * np.abs(samples).max()
    write_log(simulate(log.scene), tmp_path / "now.mcap")
    for command, *same in (("spectrum", "rate_hz", "rms"), ("report", "acceleration_rms_m_s2")):
        earlier, today = (run_json(command, path) for path in (OF_A_SENSOR, tmp_path / "now.mcap"))
        assert earlier[same[-1]] == pytest.approx(samples.std(), rel=1e-6)
        assert [earlier[key] for key in same] == pytest.approx([today[key] for key in same], rel=0.3)
        for report in (earlier, today):
            assert report.get("verdict", "outer") == "outer"
            assert report.get("bpfo_over_noise_db", 99.0) > 16.0  # dB: the line of the spall stands out
    assert cli.main(["view", str(OF_A_SENSOR), "--out", str(tmp_path / "page.html")]) == 0
