"""Models asked for outside their ranges: refused, or run and marked; and that the ranges are true."""

import json
import math

import numpy as np
import pytest

from bearing_twin import read_log
from bearing_twin.base.errors import SceneError, StudyError
from bearing_twin.charts.laws import hardest
from bearing_twin.command.cli import DOUBTFUL
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.rules import FASTEST_CHANGE, RANGES
from bearing_twin.log.bag import raw_messages
from bearing_twin.log.cdr import deserialise
from bearing_twin.log.raw_log import recover
from bearing_twin.log.run_log import write_log
from bearing_twin.nodes.studies import Goal, StudyLimits, study_of
from bearing_twin.run.scene import choose, load_scene, scene_names
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import load_study, study_names

ON = "solver.allow_invalid=on"
CLOSE = "geometry.inner_conformity=0.501"
STILL = "model.dimension=quasi_static"
LATER = "drive.change={time: 0.01, speed: 100.0}"
SLOWER = "drive.change={time: 0.01, speed: -160.0}"
CASES = {
    ("contact.normal", "axis_ratio"): (
        ("bearing_6203", "contact.normal=volumetric"),
        ("bearing_6203", "contact.normal=volumetric", CLOSE),
    ),
    ("contact.normal", "coefficient_change"): (
        ("ellipsoid_on_plane", "contact.normal=constant"),
        ("ellipsoid_rocking", "contact.normal=constant"),
    ),
    ("contact.normal", "greatest_exponent"): (
        ("two_bodies_superellipsoid", "contact.normal=hertz", "first.exponents=[2.0, 2.0]"),
        ("two_bodies_superellipsoid", "contact.normal=hertz"),
    ),
    ("contact.normal", "thickness_over_radius"): (("two_discs",), ("two_discs", "disc.thickness=0.5")),
    ("contact.normal", "speed_share"): (
        ("two_discs", "motion.first_velocity=300"),
        ("two_discs", "motion.first_velocity=500"),
    ),
    ("contact.friction", "axis_ratio"): (
        ("bearing_6203", "contact.friction=spot"),
        ("bearing_6203", "contact.friction=spot", CLOSE),
    ),
    ("model.dimension", "slip_at_start"): (
        ("bearing_6203", STILL),
        ("bearing_6203", STILL, "initial.motion=rest"),
    ),
    ("model.dimension", "ring_shift"): (
        ("bearing_6203", STILL, LATER),
        ("bearing_6203", STILL, "drive.change={time: 0.01, offset: [0, 0, 1e-6]}"),
    ),
    ("model.dimension", "relative_acceleration"): (
        ("bearing_6203", STILL, LATER),
        ("bearing_6203", STILL, SLOWER, "drive.acceleration=1e5"),  # beyond for the speed that it ends with alone
    ),
    ("model.dimension", "centrifugal_share"): (
        ("bearing_6203_fast", STILL),
        ("bearing_6203_fast", STILL, "drive.speed=6000"),
    ),
    ("beam.theory", "shear_share"): (("sphere_on_beam",), ("sphere_on_beam", "beam.span=0.05")),
    ("formulation", "speed_share"): (
        ("soft_discs_mean", "formulation=linear", "motion.first_velocity=0.1"),
        ("soft_discs_mean", "formulation=linear"),
    ),
    ("plane", "thickness_over_radius"): (
        ("soft_discs_mean", "plane=stress"),
        ("soft_discs_fast", "plane=stress"),
    ),
    ("mesh.integration", "poisson_ratio_in_strain"): (
        ("soft_discs_mean", "mesh.integration=full"),
        ("soft_discs_mean", "mesh.integration=full", "disc.material.poisson_ratio=0.49"),
    ),
}
"""Of each row of RANGES: a scene within, and one beyond."""


def ran(name, *overrides):
    run = simulate(load_scene(name, overrides))
    return run, list(run.blocks())


def test_every_range_has_a_scene_on_either_side_and_a_fact_of_its_kind():
    assert set(CASES) == {(row.key, row.fact) for row in RANGES}
    assert {row.fact for row in RANGES} == {fact for kind in KINDS.values() for fact in kind.parameters.facts}


@pytest.mark.parametrize("case", CASES, ids=" ".join)
def test_a_model_asked_for_beyond_its_range_is_refused_with_range_number_and_another(case):
    [row] = [candidate for candidate in RANGES if (candidate.key, candidate.fact) == case]
    (within, *differs), (beyond, *overrides) = CASES[case]
    assert not any(row.words in sentence for sentence in load_scene(within, differs).outside)
    choose(load_scene(within, differs))
    scene = load_scene(beyond, overrides)
    [stated] = [sentence for sentence in scene.outside if row.words in sentence and sentence.startswith(row.key)]
    value = scene.parameters.facts[row.fact](scene.parameters)
    assert not row.least <= value <= row.greatest
    assert f"is {value:.3g}" in stated
    assert row.limits in stated
    assert row.instead in stated
    with pytest.raises(SceneError) as refused:
        choose(scene)
    assert stated in str(refused.value)
    assert "--allow-invalid (solver.allow_invalid: on)" in str(refused.value)
    assert stated in choose(load_scene(beyond, [*overrides, ON])).outside


def test_what_is_left_to_be_chosen_is_never_outside():
    for beyond, *overrides in (
        ("bearing_6203", CLOSE),
        ("sphere_on_beam", "beam.theory=auto", "beam.span=0.05"),
        ("two_discs", "contact.normal=auto", "disc.thickness=0.5"),
    ):
        assert load_scene(beyond, overrides).outside == ()


def test_no_shipped_scene_or_study_leaves_a_range():
    assert [name for name in scene_names() if load_scene(name).outside] == []
    for name in study_names():
        study = load_study(name)
        assert study.scene_at([float(distribution.ppf(0.5)) for distribution in study.inputs]).outside == (), name


QUICK = {
    "bearing_6203": ("contact.normal=volumetric", CLOSE, "run.duration=0.005"),
    "ellipsoid_rocking": ("contact.normal=constant", "run.duration=0.02"),
    "two_bodies_superellipsoid": ("contact.normal=hertz", "run.duration=0.02"),
    "two_discs": ("disc.thickness=0.5", "run.output_rate=5000"),
    "sphere_on_beam": ("beam.span=0.05", "wanted.tolerance=1e-3", "run.output_rate=40000"),
    "soft_discs_mean": ("formulation=linear", "mesh.divisions=8", "mesh.order=2", "run.output_rate=500"),
}


@pytest.mark.parametrize("name", QUICK)
def test_what_runs_all_the_same_is_marked_in_every_output_and_never_done(name):
    run, blocks = ran(name, *QUICK[name], ON)
    assert run.channels[-1].name == "outside_range"
    assert all((block.values["outside_range"] == 1.0).all() for block in blocks)
    report = run.report
    assert report.status.startswith("doubtful: model outside its range")
    assert report.flags[: len(report.outside)] == report.outside == run.scene.outside
    assert report.as_dict()["outside_range"] == list(report.outside)


def test_command_and_log_say_the_same(tmp_path, run_json, refused):
    command = ("simulate", "two_discs", "--set", "disc.thickness=0.5")
    assert "outside its range" in refused(*command)
    log = str(tmp_path / "run.mcap")
    stated = run_json(*command, "--allow-invalid", "--strict", "--out", log, code=DOUBTFUL)
    reported = run_json("report", log)
    for key in ("status", "flags", "outside_range"):
        assert reported[key] == stated[key]
    assert run_json("verify", log)["deviations"]["outside_range"] == 0.0
    assert {float(sample["outside_range"]) for sample in read_log(log)} == {1.0}
    refused("bearing", "bearing_6203", "--set", "contact.normal=volumetric", "--set", CLOSE)
    answer = run_json(
        "bearing", "bearing_6203", "--set", "contact.normal=volumetric", "--set", CLOSE, "--allow-invalid"
    )
    assert set(answer["outside_range"]) <= set(answer["flags"])


@pytest.mark.parametrize("name", ["bearing_6203", "two_discs"])
def test_every_message_of_it_is_marked(name, tmp_path):
    """At each stamp of a wrench `outside_range` says why, `contacts` say it of their law, the log of every topic."""
    run = simulate(load_scene(name, (*QUICK[name], ON)))
    write_log(run, path := tmp_path / "run.mcap")
    seen: dict[str, list] = {}
    for topic, log_time, _, data in raw_messages(path):
        assert topic.metadata["outside_range"] == "; ".join(run.scene.outside)
        seen.setdefault(topic.name.rpartition("/")[2], []).append((log_time, topic.ros_type, data))
    assert {stamp for stamp, _, _ in seen["wrench"]} == {stamp for stamp, _, _ in seen["outside_range"]}
    for stamp, ros_type, data in seen["outside_range"]:
        array = deserialise(ros_type, data)
        assert 10**9 * array.header.stamp.sec + array.header.stamp.nanosec == stamp
        assert tuple(status.message for status in array.status) == run.scene.outside
        assert {status.level for status in array.status} == {1}
    for _, ros_type, data in seen["contacts"]:
        assert deserialise(ros_type, data).law == f"{run.choice.law} (outside_range)"
    recover(path, saved := tmp_path / "saved.mcap")
    assert all(topic.metadata["outside_range"] for topic, *_ in raw_messages(saved))
    assert read_log(path).choice.outside == run.scene.outside


STUDY = {
    "scene": {"kind": "two_discs", "contact": {"normal": "line"}, "disc": {"thickness": 0.5}},
    "inputs": {"disc.material.young_modulus": {"distribution": "uniform", "low": 1.9e11, "high": 2.1e11}},
    "quantities": ["peak_force"],
    "method": "ensemble",
    "samples": 8,
    "workers": 1,
}


@pytest.mark.parametrize("stepper", ["closed_form", "dop853"])
def test_a_study_is_refused_and_marked_as_its_scene_is(stepper, quick_workers):
    goal = Goal(json.dumps(STUDY), (f"solver.stepper={stepper}",))
    with pytest.raises(SceneError, match="outside its range"):
        run_study(study_of(goal))
    result = run_study(study_of(goal._replace(overrides=(*goal.overrides, ON))))
    assert any("outside its range" in doubt for doubt in result.doubts), result.doubts


def test_a_goal_cannot_allow_what_its_node_does_not():
    study = study_of(Goal(json.dumps(STUDY), (ON,)))
    with pytest.raises(StudyError, match="parameter allow_invalid = false forbids"):
        StudyLimits().bounded(study)
    assert StudyLimits(allow_invalid=True).bounded(study).scene["solver"]["allow_invalid"] == "on"


def test_the_volumetric_law_leaves_its_half_per_cent_where_its_range_says():
    [row] = [candidate for candidate in RANGES if candidate.models == ("volumetric",)]
    errors = []
    for conformity in (0.509, 0.508):
        scene = load_scene("bearing_6203", [f"geometry.inner_conformity={conformity}", "contact.normal=volumetric", ON])
        errors.append((scene.parameters.facts["axis_ratio"](scene.parameters), choose(scene).law_error))
    (near, small), (beyond, large) = errors
    assert 0.95 * row.least < beyond < row.least < near < 1.05 * row.least
    assert small < 0.005 < large


@pytest.mark.parametrize("name", [row.name for row in FRICTIONS.values() if row.over_patch])
def test_friction_over_narrow_spots_errs_little_more_than_over_those_of_bearings(name):
    [row] = [candidate for candidate in RANGES if candidate.key == "contact.friction"]
    worst = max(error for _, error in hardest(name, row.least, 8))
    assert worst < 1.4 * FRICTIONS[name].error


@pytest.mark.parametrize(
    ("rate", "least", "greatest"), [(FASTEST_CHANGE, 0.0, 1e-3), (10.0 * FASTEST_CHANGE, 0.1, 1.0)]
)
def test_balls_follow_a_change_of_speed_in_rolling_as_fast_as_is_said(rate, least, greatest):
    speed, begin = 183.26, 2e-3
    ends = begin + 1.0 / rate
    change = f"drive.acceleration={rate * speed}", f"drive.change={{time: {begin}, speed: {speed}}}"
    finely = f"run.duration={1.2 * ends}", "run.output_rate=1e5", "solver.companion=off"
    _, blocks = ran("bearing_6203", *change, *finely)
    rolled = np.concatenate([block.values["roll_rate"] / block.values["inner_ring_speed"][:, None] for block in blocks])
    assert least < np.abs(rolled / rolled[0] - 1.0).max() < greatest


def test_strains_are_small_up_to_the_speed_that_small_strains_are_for():
    [row] = [candidate for candidate in RANGES if candidate.models == ("linear",)]
    speed = row.greatest * math.sqrt(1e5 / 960.0)
    run, _ = ran("soft_discs_mean", "formulation=linear", f"motion.first_velocity={0.999 * speed}", "mesh.divisions=8",
                 "mesh.order=2", "solver.companion=off")  # fmt: skip
    assert 0.04 < 1.0 - run.report.figures["least_stretch"] < 0.05


def test_a_ball_at_the_end_of_the_load_zone_forbids_no_equilibria():
    """Its centrifugal load is more than its load, but a few newtons: a 6308 under 3 kN across and 0.5 kN along."""
    load = ["drive.speed=3000rpm", "rings.inner.load=[0,-3kN,500]", "model.dimension=quasi_static"]
    scene = load_scene("6308", [*load, "run.duration=0.002"])
    assert simulate(scene).choice.stepper == "quasi_static"
