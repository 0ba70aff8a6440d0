"""The contract of every kind of scene, by the public face alone: one scene a kind, from the run to page and study."""

import contextlib
import io
import json
from collections import namedtuple

import numpy as np
import pytest
from matplotlib.image import imread

from bearing_twin import load_scene, load_study, read_log, run_study
from bearing_twin.command.cli import BAD_INPUT, DONE, main
from bearing_twin.kinds import SHIPPED
from bearing_twin.log.bag import raw_messages
from bearing_twin.nodes.replay_node import ReplayLoop
from bearing_twin.run.verify import verify

# A short scene in which a contact begins, its channel of loads, and what a study of it varies and asks for.
Case = namedtuple("Case", "scene overrides loads uncertain quantity begins", defaults=(True,))
SHORT, BALLS = ("run.duration=0.02",), ("geometry.radial_clearance", "greatest_ball_load")
RUBBER = ("disc.material.young_modulus", "peak_force")
CASES = {
    "bearing": Case("bearing_6203_loose", SHORT, "normal_load", *BALLS),
    "bearing_free": Case("bearing_6203_rig_400N", SHORT, "normal_load", *BALLS),
    "bearing_quasi_static": Case("bearing_6203_load_and_speed", SHORT, "normal_load", *BALLS),
    # its balls stay on the raceways: a step of the load is what happens
    "shaft": Case(
        "shaft_step_load", (*SHORT, "shaft.change={time: 0.002, load: [0, -900, 0]}"), "right_normal_load",
        "shaft.mass", "vibration", begins=False,
    ),
    "two_spheres": Case("two_spheres", (), "normal_load", "motion.first_velocity", "peak_force"),
    "two_discs": Case("two_discs", (), "normal_load", *RUBBER),
    "sphere_on_beam": Case("sphere_on_beam", ("run.output_rate=1e5",), "normal_load", "blow.speed", "peak_force"),
    "soft_discs": Case("soft_discs_mean", ("mesh.divisions=8", "mesh.order=2"), "normal_load", *RUBBER),
    "ellipsoid_on_plane": Case(
        "ellipsoid_rocking", ("run.duration=0.05", "start.height=1e-3"), "normal_load", "start.height", "peak_force"
    ),
    "two_bodies": Case("two_bodies_groove", SHORT, "normal_load", "first.radius", "peak_force"),
}  # fmt: skip
OF_THE_LOG = {"missing_outputs"}  # keys of what only a log can know


def changes(case):
    return [argument for override in case.overrides for argument in ("--set", override)]


@pytest.fixture(scope="module", params=CASES)
def case(request):
    return CASES[request.param]


@pytest.fixture(scope="module")
def simulated(case, tmp_path_factory):
    """The case's run: its log, and what `simulate --json` printed."""
    log, output = tmp_path_factory.mktemp("run") / "run.mcap", io.StringIO()
    with contextlib.redirect_stdout(output):
        assert main(["simulate", case.scene, *changes(case), "--out", str(log), "--json"]) == DONE
    return log, json.loads(output.getvalue())


@pytest.fixture(scope="module")
def ran(simulated):
    return simulated[0]


def test_every_kind_has_its_case():
    shipped = set(SHIPPED)
    assert {load_scene(case.scene).kind for case in CASES.values()} == shipped


def test_something_happens_in_the_run(case, ran):
    log = read_log(ran)
    loads = np.concatenate([block.values[case.loads] for block in log.blocks()])
    loads = loads.reshape(len(loads), -1)
    assert np.ptp(loads, axis=0).max() > 0.1 * loads.max()
    assert bool(np.any((loads[1:] > 0.0) & (loads[:-1] == 0.0))) is case.begins


def test_a_run_and_its_log_report_the_same_to_the_bit(simulated, run_json):
    log, run = simulated
    reported = run_json("report", log)
    assert set(run) <= set(reported)
    assert set(reported) - set(run) == OF_THE_LOG
    assert reported["missing_outputs"] == 0
    common = set(run) & set(reported)
    # repr tells apart all that differs by a bit, and finds NaN equal to itself
    assert {key: repr(run[key]) for key in common} == {key: repr(reported[key]) for key in common}


def test_the_log_verifies(ran, run_json):
    report = run_json("verify", ran)
    assert report["greatest_deviation"] == 0.0
    assert report["samples"] > 10


def test_a_number_that_was_changed_is_found(case, ran, monkeypatch):
    log, shift = read_log(ran), 1e-9
    blocks = list(log.blocks())
    blocks[-1].values[case.loads][-1] += shift
    monkeypatch.setattr(log, "blocks", lambda: iter(blocks))
    assert verify(log).deviations[case.loads] == pytest.approx(shift, rel=1e-3)


def test_a_replay_gives_the_bytes_of_the_log(ran):
    """By its own clock and at its own pace, each message when it is due; without ROS."""
    played, now = [], 0
    loop = ReplayLoop(ran, played.append, rate=0.5)
    while not loop.finished:
        now = max(now + 1, loop.turn(now) or 0)
    logged = list(raw_messages(ran))
    assert [(message.topic, bytes(message.cdr)) for message in played] == [
        (message.topic.name, bytes(message.data)) for message in logged
    ]
    assert now == pytest.approx(2 * (logged[-1].log_time - logged[0].log_time), abs=1e3)


def test_the_topics_of_the_scene_are_those_of_its_log(case, ran, tmp_path, run_json):
    scene = tmp_path / "scene.yaml"
    scene.write_text(read_log(ran).scene.text)
    listed = run_json("topics", scene)["topics"]
    names = {topic["topic"]: topic["type"] for topic in listed}
    logged = {message.topic.name: message.topic.ros_type for message in raw_messages(ran)}
    assert set(logged) <= set(names)
    assert {f"/{load_scene(case.scene).kind}/{name}" for name in ("scene", "samples")} <= set(logged)
    assert all(names[name] == ros_type.replace("/msg/", "/") for name, ros_type in logged.items())
    assert all(topic["meaning"] for topic in listed)


def test_the_run_has_a_page(case, ran, tmp_path):
    page = tmp_path / "run.html"
    assert main(["view", str(ran), "--out", str(page)]) == DONE
    text = page.read_text(encoding="utf-8")
    assert text.lower().startswith("<!doctype html>")
    assert case.scene in text
    assert "http://" not in text.replace("http://www.w3.org", "")  # nothing is fetched


def test_the_run_has_a_picture(ran, tmp_path, run_cli):
    picture = tmp_path / "run.png"
    output = run_cli("report", ran, "--plot", picture)
    assert "not drawn" not in output.err
    pixels = imread(picture)[..., :3]
    drawn = np.ptp(pixels, axis=-1) > 0.3  # in colour: curves and bodies, not axes and letters
    for half in (*np.array_split(drawn, 2, axis=0), *np.array_split(drawn, 2, axis=1)):
        assert half.mean() > 1e-3


def test_a_study_of_a_few_realisations(case, quick_workers):
    value = load_scene(case.scene).parameters
    for name in case.uncertain.split("."):
        value = getattr(value, name)
    inputs = {case.uncertain: {"distribution": "uniform", "low": 0.99 * value, "high": 1.01 * value}}
    study = {"scene": case.scene, "set": list(case.overrides), "inputs": inputs, "quantities": [case.quantity]}
    of_method = {"method": "ensemble", "samples": 4, "sampler": "random", "workers": 1}
    report = run_study(load_study(study | of_method, ["seed=3"])).as_dict()
    assert (report["samples"], report["failed"]) == (4, {})
    quantity = report["quantities"][case.quantity]
    assert quantity["mean"] > 0.0
    assert 0.0 < quantity["std"] < 0.5 * quantity["mean"]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [("nonsense.key=1", "nonsense"), ("run.duration=never", "run.duration"), ("run.duration=-1", "run.duration")],
)
def test_a_key_or_value_that_is_none_is_refused(case, change, sentence, run_cli):
    out, err = run_cli("simulate", case.scene, "--set", change, code=BAD_INPUT)
    assert out == ""
    assert sentence in err
    assert "Traceback" not in err
