"""A kind of scene that nobody knew before passes every command: one file and its row are all it takes."""

import math

import numpy as np
import pytest
import toy_kind

from bearing_twin.kinds import KINDS
from bearing_twin.log.run_log import read_log
from bearing_twin.log.stream import topics
from bearing_twin.run.scene import load_scene, parse_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import parse_study

SCENE = "kind: toy\nstart: 0.02\nbody: {mass: 2.0, stiffness: 800.0, damping: 4.0}\n"
DECAY = 1.0  # 1/s: half the damping over the mass
RATE = math.sqrt(399.0)  # rad/s: stiffness over mass, less the decay squared


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "swing.yaml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def test_the_house_knows_it_as_any_other():
    assert KINDS["toy"] is toy_kind.KIND
    assert [topic.full_name for topic in topics(parse_scene(SCENE, "swing"))] == ["/toy/scene", "/toy/samples"]


def test_it_runs_from_python(scene):
    run = simulate(load_scene(scene, ["run.duration=0.5"]))
    samples = list(run)
    assert len(samples) == run.outputs == 501
    time = np.array([1e-9 * sample.time_ns for sample in samples])
    swing = np.cos(RATE * time) + DECAY / RATE * np.sin(RATE * time)
    assert [sample["position"] for sample in samples] == pytest.approx(0.02 * np.exp(-DECAY * time) * swing, abs=1e-12)
    report = run.report
    assert (report.status, report.flags, report.samples) == ("done", (), 501)
    assert set(report.figures) == set(toy_kind.KIND.meanings_of())
    assert report.figures["position_at_end_m"] == samples[-1]["position"]
    assert report.figures["greatest_velocity_m_s"] == max(abs(float(sample["velocity"])) for sample in samples)
    assert report.costs["evaluations"] >= 501


def test_its_log_is_reported_to_the_bit_verified_and_drawn(scene, tmp_path, run_json):
    log, picture = tmp_path / "swing.mcap", tmp_path / "run.png"
    simulated, reported = run_json("simulate", scene, "--out", log), run_json("report", log, "--plot", picture)
    own = ("plot", "missing_outputs")
    assert simulated == {key: one for key, one in reported.items() if key not in own}
    assert picture.read_bytes().startswith(b"\x89PNG")
    verified = run_json("verify", log)
    names = [channel.name for channel in toy_kind.CHANNELS]
    assert (verified["samples"], verified["deviations"]) == (1001, dict.fromkeys(names, 0.0))
    assert read_log(log).channels == toy_kind.CHANNELS


def test_its_table_its_keys_and_its_figures_are_shown(scene, run_json, run_cli):
    captured = run_cli("simulate", scene)
    assert "position at end" in captured.out + captured.err
    keys = [row["key"] for row in run_json("scenes", "--keys")["keys"] if row["kind"] == "toy"]
    assert keys[:5] == ["body.mass", "body.stiffness", "body.damping", "start", "run.duration"]
    figures = {row["figure"]: row for row in run_json("scenes", "--figures")["figures"] if row["kind"] == "toy"}
    velocity = figures["greatest_velocity_m_s"]
    assert (velocity["unit"], velocity["meaning"]) == ("m/s", "of the body, greatest magnitude")


def test_its_mistakes_are_named(scene, refused):
    for change, words in (
        ("body.damping=90", "stay below 80 N s/m"),
        ("body.masss=1", "did you mean mass?"),
        ("run.duration=-1", "run.duration"),
    ):
        assert words in refused("simulate", scene, "--set", change)


@pytest.mark.environment
def test_a_study_of_it_runs_in_workers_that_never_heard_of_it(scene):
    study = {
        "scene": str(scene),
        "inputs": {"body.stiffness": {"distribution": "uniform", "low": 600.0, "high": 1000.0}},
        "quantities": ["position_at_end", "greatest_velocity"],
        "histories": ["position"],
        "history_duration": 0.5,
        "samples": 8,
        "workers": 1,
    }
    result = run_study(parse_study(study, "swings")).as_dict()
    assert (result["samples"], result["failed"]) == (8, {})
    quickest = 0.02 * math.sqrt(1000.0 / 2.0)
    assert 0.7 * quickest < result["quantities"]["greatest_velocity"]["mean"] < quickest
    assert -0.02 < result["quantities"]["position_at_end"]["mean"] < 0.02
