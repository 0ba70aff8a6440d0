"""Study files: what they hold, what their overrides change, what is refused and in which words."""

import dataclasses
import math

import pytest
import yaml
from runs import reported

from bearing_twin.base.errors import SceneError, StudyError
from bearing_twin.base.parameters import describe, element_at, plain
from bearing_twin.kinds import KINDS
from bearing_twin.run.report import BLOCK_OUTPUTS
from bearing_twin.run.scene import load_scene
from bearing_twin.run.simulation import simulate
from bearing_twin.uq.inputs import numeric_keys, put, quantities_of, value_at
from bearing_twin.uq.run import run_study
from bearing_twin.uq.study import load_study, parse_study, study_names

ALPHA = "contact.measured_alpha"
GAMMA = {"distribution": "gamma", "mean": 1.138e-4, "std": 2e-5}
QUICK_SCENES = {
    "bearing_6203": ["run.duration=0.01"],
    "ellipsoid_tumbling": [],
    "shaft_two_6203": ["run.duration=0.01", "run.output_rate=1000", "solver.companion=off"],
    "soft_discs_mean": ["mesh.divisions=8", "mesh.order=2"],
    "sphere_on_beam": [],
    "two_bodies_groove": ["run.duration=0.02"],
    "two_discs": [],
    "two_spheres": [],
}
TWO = {key: {"distribution": "uniform", "low": 0.01, "high": 0.02} for key in ("first.radius", "second.radius")}
PLAIN = {"scene": "two_spheres", "inputs": {ALPHA: GAMMA}, "quantities": ["contact_duration"]}


def refusal(changes=None, overrides=()):
    with pytest.raises(StudyError) as caught:
        parse_study({**PLAIN, **(changes or {})}, "s", overrides)
    return str(caught.value)


@pytest.mark.parametrize("name", study_names())
def test_every_study_reads_back_from_its_resolved_dump(name):
    study = load_study(name)
    assert study.description
    assert study.name == name
    assert parse_study(study.resolved(), "elsewhere") == study
    assert parse_study(yaml.safe_dump(study.resolved()), "elsewhere") == study
    assert set(study.resolved()["scene"]) == {"name", "kind", "description", *vars(KINDS[study.kind].parameters())}


def test_overrides_reach_the_study_its_inputs_and_its_scene():
    study = load_study(
        "spheres_alpha_2e-5",
        ["samples=10", "stop.relative_tolerance=1e-2", f"inputs.{ALPHA}.std=4e-5", "motion.first_velocity=50"],
    )
    assert study.settings.samples == 10
    assert study.settings.stop.relative_tolerance == 0.01
    assert study.inputs[0].std == pytest.approx(4e-5)
    assert study.scene["motion"]["first_velocity"] == 50
    replaced = parse_study(PLAIN, "s", [f"inputs.{ALPHA}={{distribution: uniform, low: 1e-4, high: 2e-4}}"])
    assert (replaced.inputs[0].low, replaced.inputs[0].high) == (1e-4, 2e-4)
    inputs = "{first.radius: {distribution: uniform, low: 0.01, high: 0.02}}"
    assert [source.key for source in parse_study(PLAIN, "s", [f"inputs={inputs}"]).inputs] == ["first.radius"]


def test_values_of_an_input_may_have_its_unit():
    for text, number in (
        ({"distribution": "uniform", "low": "19 mm", "high": "1.91cm"}, {"low": 19e-3, "high": 1.91e-2}),
        ({"distribution": "empirical", "values": ["19mm", 0.02]}, {"values": [0.019, 0.02]}),
        ({"know": {"low": "19 mm", "high": 0.0191}}, {"know": {"low": 19e-3, "high": 0.0191}}),
    ):
        written, number = (
            parse_study({**PLAIN, "inputs": {"first.radius": specification}}, "s")
            for specification in (text, text | number)
        )
        assert written == number
    assert "'19 kg'" in refusal({"inputs": {"first.radius": "19 kg"}})
    swelling = {"temperature": {"distribution": "normal", "mean": 300.0, "std": "5 °C"}}
    assert "std" in refusal({"scene": "6205", "quantities": ["cage_speed"], "inputs": swelling})


def test_another_scene_by_override_is_read_before_its_keys_are():
    study = parse_study(
        {**PLAIN, "inputs": {"sphere.radius": {"distribution": "uniform", "low": 0.009, "high": 0.011}}},
        "s",
        ["scene=sphere_on_beam", "blow.point=0.4"],
    )
    assert (study.kind, study.scene["blow"]["point"]) == ("sphere_on_beam", 0.4)


def test_keys_that_follow_an_input_take_its_value():
    study = load_study("bearing_6203_tolerances")
    scene = study.scene_at([source.mean * 1.01 if "modulus" in source.key else source.mean for source in study.inputs])
    materials = scene.parameters.materials
    assert materials.ball.young_modulus == pytest.approx(1.01 * 2.075e11)
    assert materials.ball == materials.inner_ring == materials.outer_ring


@pytest.mark.parametrize("overrides", [[], ["contact.restitution=0.9"]])
def test_a_number_that_the_scene_wants_may_be_uncertain(overrides, quick_workers):
    """The law asks for a measured alpha, which the scene alone has not; by closed forms, and by simulating."""
    scene, settings = (
        {"kind": "two_spheres", "contact": {"normal": "measured"}},
        [*overrides, "samples=6", "workers=1", "modality=no", "checks=0"],
    )
    left_open = run_study(parse_study(PLAIN, "s", settings)).as_dict()["quantities"]["contact_duration"]
    for changes, law in (({}, ["contact.normal=measured"]), ({"scene": scene}, [])):
        study = parse_study({**PLAIN, **changes}, "s", [*settings, *law])
        assert study.scene_at([2e-4]).parameters.contact.normal == "measured"
        duration = run_study(study).as_dict()["quantities"]["contact_duration"]
        assert duration["mean"] == pytest.approx(left_open["mean"], rel=1e-12)
        assert duration["quantiles"]["0.50"] == pytest.approx(left_open["quantiles"]["0.50"], rel=1e-12)


def test_keys_may_have_their_other_names():
    """solver.tolerance is another name of wanted.tolerance, in scenes and so in inputs, sweeps and overrides."""
    low, high = {"distribution": "uniform", "low": 1e-9, "high": 1e-7}, {"distribution": "fixed", "value": 0.01}
    joint = {"correlation": [["solver.tolerance", "first.radius", 0.0]]}
    for name in ("solver.tolerance", "wanted.tolerance"):
        study = parse_study(
            {**PLAIN, **joint, "inputs": {name: low, "first.radius": high}}, "s", [f"inputs.{name}.high=0.05"]
        )
        assert study.resolved()["inputs"]["wanted.tolerance"] == {**low, "high": 0.05}
        assert study.correlation == (("wanted.tolerance", "first.radius", 0.0),)
        swept = parse_study({**PLAIN, "sweep": {name: [1e-8, 1e-7]}}, "s")
        assert swept.sweep == ("wanted.tolerance", (1e-8, 1e-7))
    both_names = {"solver.tolerance": low, "wanted.tolerance": low}
    assert "inputs has wanted.tolerance twice" in refusal({"inputs": both_names}, [])


def test_a_number_that_the_scene_wants_may_be_swept():
    sweep = {"sweep": {ALPHA: [1e-4, 2e-4]}, "inputs": {"first.radius": {"distribution": "fixed", "value": 0.01}}}
    study = parse_study({**PLAIN, **sweep}, "s", ["contact.normal=measured"])
    assert study.sweep == (ALPHA, (1e-4, 2e-4))
    assert "measured_alpha" in refusal({"inputs": sweep["inputs"]}, ["contact.normal=measured"])


@pytest.mark.parametrize(
    ("changes", "overrides", "message"),
    [
        ({}, ["samples=0"], "samples = 0 is out of range; must be a whole number, at least 1"),
        ({}, ["sample=10"], "'sample' is no key of the study or its scene; did you mean sampler or samples?"),
        ({}, ["motion.first_velocity=-1"], "the bodies never meet"),
        ({}, [f"inputs.{ALPHA}x.std=1e-5"], "did you mean contact.measured_alpha?"),
        ({"quantities": ["peak_force", "peak_force"]}, [], "names something twice"),
        ({"inputs": {}}, [], "one at least"),
        ({"scene": 3.5}, [], "must be the name of a scene"),
        ({"stop": {"quantity": "peak_force"}}, [], "'peak_force' is not among the study's quantities"),
        ({"stop": {"tolerance": 1e-6, "relative_tolerance": 0.1}}, [], "keep one"),
        ({"histories": ["velocity"]}, [], "is no channel of one number"),
        ({"densities": {"contact_duration": [6e-5]}}, [], "from result.sample(quantity)"),
        ({"time_limit": 3.0}, [], "timeout -s INT"),
        ({"sweep": {"motion.first_velocity": []}}, [], "a list of 1 to"),
        ({"sweep": {"motion.first_velocity": [10.0, -10.0]}}, [], "the bodies never meet"),
        ({"sweep": {ALPHA: [1e-4]}}, [], "is an uncertain input already"),
        ({"correlation": [[ALPHA, "first.radius", 0.5]]}, [], "is no input"),
        ({"inputs": TWO, "correlation": [[*TWO, 0.5]]}, ["sensitivity=16"], "sensitivity is for independent inputs"),
    ],
)
def test_what_is_wrong_is_said_with_what_is_legal(changes, overrides, message):
    assert message in refusal(changes, overrides)


@pytest.mark.parametrize(
    ("key", "reported", "expected"),
    [
        (ALPHA, {"distribution": "normal", "mean": 1e-4, "std": 1.5e-5}, "takes values from -inf to inf"),
        ("first.material.poisson_ratio", {"distribution": "uniform", "low": 0.2, "high": 0.6}, "below 0.5"),
        ("contact.restitution", {"distribution": "empirical", "values": [0.5, 1.1]}, "at most 1"),
        (
            ALPHA,
            {"distribution": "uniform", "low": 1e-4, "high": 2e-4, "also": ["first.mas"]},
            "did you mean first.mass?",
        ),
        (ALPHA, {"distribution": "uniform", "low": 1e-4, "high": 2e-4, "also": [ALPHA]}, "already follows"),
    ],
)
def test_distributions_must_stay_inside_the_limits_of_the_scene(key, reported, expected):
    message = refusal({"inputs": {key: reported}})
    assert expected in message
    assert key in message


def test_a_forbidden_bound_may_be_the_end_of_a_density_but_no_value():
    uniform = {"distribution": "uniform", "low": 0.0, "high": 0.5}
    assert parse_study({**PLAIN, "inputs": {"first.material.poisson_ratio": uniform}}, "s").inputs[0].high == 0.5


def test_whole_numbers_take_only_whole_values():
    bearing = {**PLAIN, "scene": "bearing_6203", "quantities": ["cage_speed"]}
    nine = {"geometry.balls": {"distribution": "empirical", "values": [7, 8, 9]}}
    assert parse_study({**bearing, "inputs": nine}, "s").scene_at([9]).parameters.geometry.balls == 9
    for wrong in ({"distribution": "uniform", "low": 7, "high": 9}, {"distribution": "empirical", "values": [7.5]}):
        assert "whole numbers" in refusal({**bearing, "inputs": {"geometry.balls": wrong}})


def test_all_problems_of_a_file_come_together():
    message = refusal({"quantities": ["peak"], "method": "x", "inputs": {"first.radus": 1.0}, "colour": "red"})
    assert "4 problems" in message
    assert all(word in message for word in ("'peak'", "'x'", "'first.radus'", "'colour'"))


@pytest.mark.parametrize("text", ["", "[1, 2]", "scene: [", "samples: 3", "scene: {kind: bearing, x: 1}"])
def test_texts_that_are_no_study_are_refused_in_words(text):
    with pytest.raises((StudyError, SceneError)) as caught:
        parse_study(text, "s")
    assert "s" in str(caught.value)


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_every_number_of_a_scene_can_be_put_and_replaced(kind):
    cls = KINDS[kind].parameters
    lists = {row.key: element_at(cls, [row.key]) for row in describe(cls) if row.type == "list"}
    parameters = cls(**{key: (element(),) * greatest_length for key, (element, greatest_length) in lists.items()})
    scene = {"kind": kind, **yaml.safe_load(yaml.safe_dump(plain(parameters)))}
    for key, row in numeric_keys(kind).items():
        assert row.unit
        assert value_at(put(scene, key, 0.125), key) == 0.125
        changed = put(parameters, key, 0.125)
        assert value_at(plain(changed), key) == 0.125
        assert changed != parameters or value_at(scene, key) == 0.125


def test_the_last_report_is_the_report():
    run = simulate(load_scene("bearing_6203_loose", ["run.duration=0.03", "run.output_rate=3000"]))
    assert sum(len(block) for block in run.blocks()) % BLOCK_OUTPUTS
    before = run.report
    assert dataclasses.replace(run.simulation.report(last=True), compute_seconds=before.compute_seconds) == before


@pytest.mark.parametrize("name", QUICK_SCENES)
def test_every_quantity_of_a_kind_is_a_number_of_its_report(name):
    scene, report = load_scene(name), reported(name, *QUICK_SCENES[name])
    for quantity, row in quantities_of(scene.kind).items():
        known = math.isfinite(row.figure(report.figures))
        assert known == (not set(row.keys) & set(scene.parameters.missing_figures())), quantity


@pytest.mark.parametrize(
    ("free", "refused"),
    [
        ("none", {"ring_displacement", "misalignment", "run_up_time"}),
        ("displacement", {"misalignment", "run_up_time"}),
        ("all", {"run_up_time"}),
    ],
)
def test_a_quantity_that_the_scene_prescribes_is_refused(free, refused):
    names = ["ring_displacement", "misalignment", "run_up_time"]
    scene = {"kind": "bearing", "model": {"dimension": "quasi_static"}, "rings": {"inner": {"free": free}}}
    message = refusal({"scene": scene, "inputs": {}, "quantities": names})
    assert {name for name in names if f"quantities: {name}: the scene " in message} == refused
