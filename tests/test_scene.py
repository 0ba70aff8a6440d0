"""Scenes: YAML in, frozen dataclasses out, and back; impossible bearings and hostile files are refused."""

import functools
import json
import math
import os
import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import yaml

from bearing_twin.base.errors import SceneError, StudyError
from bearing_twin.base.parameters import describe
from bearing_twin.base.paths import share_path
from bearing_twin.base.yaml_files import GREATEST_FILE
from bearing_twin.contact.materials import MATERIALS
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.sections import RunSettings, resolved_run
from bearing_twin.run.scene import (
    choose,
    load_scene,
    open_scene,
    parse_scene,
    read_scene,
    scene_names,
    unreached_keys,
)
from bearing_twin.uq.inputs import value_at
from bearing_twin.uq.study import load_study


def refusal(function, *arguments):
    with pytest.raises(SceneError) as caught:
        function(*arguments)
    return str(caught.value)


@pytest.mark.parametrize("name", scene_names())
def test_every_scene_reads_back_from_its_resolved_dump(name):
    scene = load_scene(name)
    assert scene.name == name
    assert scene.description
    again = parse_scene(yaml.safe_dump(scene.resolved()), "elsewhere")
    assert again == scene
    assert parse_scene(scene.resolved(), "elsewhere") == scene


def test_a_path_a_text_path_and_a_name_give_the_same_scene():
    path = Path(share_path("config", "scenes", "bearing_6203.yaml"))
    assert load_scene(path) == load_scene(str(path)) == load_scene("bearing_6203")


def test_overrides_change_one_key_each_in_order():
    scene = load_scene("bearing_6203", ["contact.normal=volumetric", "drive.offset=[0, -1e-6, 0]", "geometry.balls = 7",
                                        "materials.ball=silicon_nitride", "materials.ball.density=3.2e3"])  # fmt: skip
    parameters = scene.parameters
    assert parameters.contact.normal == "volumetric"
    assert parameters.drive.offset == (0.0, -1e-6, 0.0)
    assert parameters.geometry.balls == 7
    assert parameters.materials.ball.young_modulus == MATERIALS["silicon_nitride"].young_modulus
    assert parameters.materials.ball.density == 3200.0
    assert parameters.materials.inner_ring == MATERIALS["steel"]


def test_a_key_given_twice_must_have_one_value():
    assert load_scene("bearing_6203", ["drive.speed=1e2", "drive.speed = 100.0"]).parameters.drive.speed == 100.0
    overrides = ["run.duration=0.1", "run.duration=100ms", "run.duration=1e-1 s", "geometry.ball_diameter=6.746 mm"]
    assert load_scene("bearing_6203", [*overrides, "geometry.ball_diameter=6.746e-3"]).parameters.run.duration == 0.1
    for duration in ("100", "0.1 min", "0.1 mm"):
        with pytest.raises(SceneError, match="keep one of them"):
            load_scene("bearing_6203", ["run.duration=100ms", f"run.duration={duration}"])
    with pytest.raises(SceneError, match=r"drive\.speed is given as '100' and as '200'; keep one of them"):
        load_scene("bearing_6203", ["drive.speed=100", "run.duration=0.1", "drive.speed=200"])


def test_a_description_names_what_was_changed():
    """A picture of two spheres at 30 m/s had the title that they meet at 20 m/s."""
    shipped = load_scene("two_spheres").description
    changed = load_scene("two_spheres", ["motion.first_velocity=30", "run.duration=1e-5"]).description
    assert changed == f"{shipped}, with motion.first_velocity=30"
    assert load_scene("two_spheres", ["run.duration=1e-5"]).description == shipped


def test_long_and_many_overrides_are_shortened_where_they_are_named():
    with pytest.raises(SceneError) as caught:
        load_scene("bearing_6203", [f"run.duration={'a' * 100_000}"])
    assert len(str(caught.value)) < 500
    with pytest.raises(SceneError) as caught:
        load_scene("bearing_6203", ["run.duration=0.1"] * 5000 + ["run.duration=-1"])
    assert len(str(caught.value)) < 2000


def test_numbers_are_taken_with_their_units():
    """In overrides and in YAML; by the definitions of these units."""
    values = {
        "drive.speed": ("1750rpm", 1750.0 * math.pi / 30.0),
        "drive.offset": ("0,-9um,0.01 mm", (0.0, -9e-6, 1e-5)),
        "drive.tilt": ("[1 mrad, 0.05°]", (1e-3, math.pi / 3600.0)),
        "geometry.radial_clearance": ("13 µm", 13e-6),
        "geometry.inner_conformity": ("52 %", 0.52),
        "rings.inner.unbalance": ("50 g mm", 5e-5),
        "rings.inner.inertia": ("50 kg mm^2, 5e4 g mm²", (5e-5, 5e-5)),
        "rings.inner.support.stiffness": ("1 N/um, 2 kN/m, 0", (1e6, 2e3, 0.0)),
        "temperatures.inner_ring": ("60°C", 333.15),
        "fits.shaft.material.density": ("7.8 g/cm^3", 7800.0),
        "run.duration": ("1 min", 60.0),
    }
    texts = {key: text for key, (text, _) in values.items()}
    scene = read_scene(*open_scene("bearing_6203", [f"{key}={text}" for key, text in texts.items()]))
    for key, (_, value) in values.items():
        assert value_at(scene.resolved(), key) == pytest.approx(value, rel=1e-14), key
    nested = functools.reduce(lambda tree, key: put_in(tree, key.split("."), texts[key]), texts, {"kind": "bearing"})
    assert read_scene(yaml.safe_dump(nested), "x").parameters.rings == scene.parameters.rings


def put_in(tree, path, value):
    inner = put_in(tree.get(path[0], {}), path[1:], value) if path[1:] else value
    return {**tree, path[0]: inner}


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("contact.norml=hertz", "did you mean normal?"),
        ("contact.normal=hetz", "did you mean hertz?"),
        ("load=[0,-1,0]", "did you mean rings.inner.load"),
        ("drive.speed=1750 mm", "must be a number in rad/s"),
        ("geometry.balls=8 mm", "must be a whole number"),
        ("rings.inner.load=0,-3kN", "must be a list of 3 numbers in N"),
        ("temperatures.inner_ring=-300°C", "must be a number in K"),
        ("=3", "must look like"),
        ("gravity.x=3", "is no place in the list"),
        ("run.duration=", "has no value"),
        ("run.duration=1:30", "must be a number in s"),
        ("geometry.balls=[", "is not the YAML"),
        ("geometry.ball_diameter=.inf", "is not finite"),
        ("kind=bearing", "cannot change kind"),
    ],
)
def test_wrong_overrides_are_refused_with_the_reason(override, sentence):
    assert sentence in refusal(load_scene, "bearing_6203", [override])


def test_a_long_text_in_place_of_a_number_is_not_searched_for_a_unit():
    """Many digits before what is no unit took minutes to search."""
    assert "must be a number" in refusal(load_scene, "bearing_6203", ["drive.speed=" + "1" * 100_000 + "x" * 20])
    assert " is " not in refusal(load_scene, "bearing_6203", ["geometry.radial_clearance=" + "1" * 70 + "um"])


@pytest.mark.parametrize("kind", KINDS)
def test_a_key_of_an_earlier_version_is_refused_with_its_new_name(kind):
    for old, new in KINDS[kind].parameters.moved.items():
        section, _, name = old.partition(".")
        reported = refusal(parse_scene, {"kind": kind, section: {name or "coefficient": 1.0}}, "a scene")
        assert new in reported


@pytest.mark.parametrize(
    ("overrides", "sentence"),
    [
        (["geometry.balls=14"], "at most 13 do"),
        (["geometry.ball_diameter=0.03", "geometry.balls=1"], "leaves no inner raceway"),
        (["geometry.ball_diameter=15", "geometry.pitch_diameter=65"], "in m, above 0 and at most 1"),
        (["geometry.outer_conformity=3.0"], "must be below 2.61"),
        (["wanted.tolerance=1e-14"], "at least 1e-10"),
        (["ratings.dynamic=1e-300"], "too small, below 1e-09"),
        (["geometry.radial_clearance=-2e-4"], "between -0.00013492 and 0.00026984"),
        (["geometry.radial_clearance=2.8e-4"], "geometry.radial_clearance"),
        (["drive.offset=[1e-4, 1e-4, 0]"], "its length must be below 0.00013192"),
        (["run.publish_rate=2000"], "cannot exceed run.output_rate"),
        (["run.duration=86400", "run.output_rate=1e8"], "outputs is too many"),
        (["materials.ball.poisson_ratio=0.5"], "below 0.5"),
    ],
)
def test_impossible_bearings_are_refused_with_the_limit(overrides, sentence):
    assert sentence in refusal(load_scene, "bearing_6203", overrides)


def test_all_problems_of_a_file_are_reported_together():
    text = "kind: bearing\ndescription: 5\ngeometry: {bals: 8, ball_diameter: -1}\nrun: 3\nfoo: {}\n"
    message = refusal(parse_scene, text, "scene t.yaml")
    assert message.splitlines()[0] == "scene t.yaml has 5 problems:"
    for word in ("description", "geometry.bals", "geometry.ball_diameter", "run", "foo"):
        assert f"\n  {word} " in message


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "start it with `kind: bearing`"),
        ("geometry: {}", "has no key `kind`"),
        ("kind: baering", "did you mean bearing?"),
        ('kind: bearing\ndescription: "half \\ud800"', "all of UTF-8"),
        ("kind: bearing\ngeometry:\n  balls: 8\n  balls: 9", "is there twice at line 4"),
        ("a: &a [1]\nb: *a", "aliases are not allowed"),
        ("kind: bearing\ngeometry: {<<: {balls: 9}}", "<< is not a key"),
        ("[" * 5000, "nested deeper"),
        ("a: " + "9" * 5000, "`kind`"),
        ("? [1]\n: 2", "a key must be a word"),
        ("!!python/object/apply:os.system [ls]", "could not determine a constructor"),
        ("a: \x07", "special characters"),
    ],
)
def test_texts_that_are_no_scene_are_refused_in_one_sentence(text, sentence):
    message = refusal(parse_scene, text, "scene t")
    assert sentence in message
    assert message.startswith("scene t")
    assert len(message.splitlines()) == 1


GROOVES = 0.04 * 6.746e-3  # m: of a 6203, (f_i + f_o - 1) D, which the centres of both grooves lie apart on a ball


def angular(degrees, axial, *radial):
    """A 6203 with the clearance that makes this contact angle, its inner ring moved by `axial` of the free travel."""
    angle = math.radians(degrees)
    clearance = 2.0 * GROOVES * (1.0 - math.cos(angle))
    offset = [*(radial or (0.0, 0.0)), axial * GROOVES * math.sin(angle)]
    return [f"geometry.radial_clearance={clearance!r}", f"drive.offset={offset!r}"]


def squeezed(overrides):
    """Greatest approach [m] of a ball's two contacts together, all places on its way round tried."""
    key, value = overrides[0].split("=")
    assert key == "geometry.radial_clearance"
    x, y, z = json.loads(overrides[1].split("=")[1])
    azimuths = np.linspace(0.0, 2.0 * math.pi, 100_001)
    across = GROOVES - 0.5 * float(value) + x * np.cos(azimuths) + y * np.sin(azimuths)
    return np.max(np.hypot(across, z)) - GROOVES


@pytest.mark.parametrize("direction", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.6, -0.4, 2.0), (0.0, 3.0, -1.0)])
@pytest.mark.parametrize("clearance", [-6e-6, 5e-5])
def test_an_offset_that_squeezes_a_ball_too_much_is_refused_and_the_longest_told(direction, clearance):
    def scene(length):
        offset = [length * component / math.hypot(*direction) for component in direction]
        return [f"geometry.radial_clearance={clearance!r}", f"drive.offset={offset!r}"]

    message = refusal(load_scene, "bearing_6203", scene(6e-4))
    reported = float(re.search(r"squeezes a ball by (\S+) m", message).group(1))
    assert reported == pytest.approx(squeezed(scene(6e-4)), rel=1e-3)
    longest = float(re.search(r"its length must be below (\S+) m", message).group(1))
    assert squeezed(scene(longest)) == pytest.approx(0.02 * 6.746e-3, rel=1e-3)
    assert "length must be below" in refusal(load_scene, "bearing_6203", scene(1.001 * longest))
    load_scene("bearing_6203", scene(0.999 * longest))


@pytest.mark.parametrize("case", [(59.9, 1.05), (59, 1.2), (58, -1.1)])
def test_a_contact_on_the_edge_of_the_groove_is_refused_with_its_angle(case):
    overrides = angular(*case)
    message = refusal(load_scene, "bearing_6203", overrides)
    reported = re.search(r"an angle of (\S+) degrees, on the edge of the grooves; at most 60 degrees", message).group(1)
    angle = math.radians(case[0])
    assert float(reported) == pytest.approx(math.degrees(math.atan(abs(case[1]) * math.tan(angle))), abs=0.06)


def test_yaml_traps_are_read_as_they_look():
    scene = parse_scene("{kind: bearing, geometry: {balls: 08, ball_diameter: 5e-3}, drive: {speed: -1.5E+2}}", "trap")
    assert scene.parameters.geometry.balls == 8
    assert scene.parameters.geometry.ball_diameter == 0.005
    assert scene.parameters.drive.speed == -150.0


def test_an_unknown_scene_names_the_nearest_and_all():
    message = refusal(load_scene, "baering6203")
    assert "did you mean bearing_6203?" in message
    assert all(name in message for name in scene_names())


def test_unusable_paths_are_refused_in_one_sentence_each(tmp_path):
    (tmp_path / "binary.yaml").write_bytes(bytes(range(256)))
    (tmp_path / "zero.yaml").write_bytes(b"kind: bearing\0")
    (tmp_path / "large.yaml").write_text("#" * (GREATEST_FILE + 1))
    (tmp_path / "loop.yaml").symlink_to("loop.yaml")
    cases = {
        tmp_path: "is a directory",
        tmp_path / "none.yaml": "there is no scene file",
        tmp_path / "binary.yaml": "is not UTF-8 text",
        tmp_path / "zero.yaml": "is a binary file",
        tmp_path / "large.yaml": "is larger than",
        tmp_path / "loop.yaml": "there is no scene file",
        "x" * 5000: "there is no scene",
        "a\0b": "there is no scene",
        "": "there is no scene",
    }
    for path, sentence in cases.items():
        message = refusal(load_scene, path)
        assert sentence in message
        assert len(message.splitlines()) == 1


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every file")
def test_an_unreadable_file_is_refused(tmp_path):
    path = tmp_path / "secret.yaml"
    path.write_text("kind: bearing")
    path.chmod(0)
    assert "cannot be read" in refusal(load_scene, path)


@pytest.mark.parametrize("kind", KINDS)
def test_a_number_of_any_size_is_taken_or_refused_in_one_sentence(kind):
    """Speeds of 1e200 m/s or a gravity of 1e308 m/s^2 overflow somewhere later; so do balls of 1e-300 m."""
    for row in describe(KINDS[kind].parameters):
        if row.options or row.type == "text":
            continue
        ends = {bound for bound in row.bounds if isinstance(bound, (int, float)) and math.isfinite(bound)}
        for size in ends | {-bound for bound in ends} | {1e300, -1e300, 1e-300}:
            value = [size] * int(row.type[0]) if row.type.endswith("numbers") else size
            section, _, key = row.key.rpartition(".")
            mapping = {key: value}
            for name in reversed(section.split(".") if section else []):
                mapping = {name: mapping}
            with suppress(SceneError):
                parse_scene({"kind": kind, "name": "extreme", **mapping}, "extreme")


@pytest.mark.parametrize(("publish_rate", "output_rate"), [(1e6, 1e6), (3e3, 9e3), (3e4, 3e4)])
def test_outputs_are_a_whole_multiple_of_a_publish_rate_that_stands_alone(publish_rate, output_rate):
    """About ten in a millisecond are chosen; a rate far above that is taken once."""
    run = resolved_run(RunSettings(duration=1e-3, publish_rate=publish_rate), outputs=10)
    assert (run.output_rate, run.publish_rate) == (output_rate, publish_rate)


@pytest.mark.parametrize(
    ("read", "name", "sentence"),
    [
        (load_scene, "spheres_alpha_4e-5", "is a study, not a scene; `bearing_twin study` runs it"),
        (load_study, "bearing_6203", "is a scene, not a study; `bearing_twin simulate` runs it"),
    ],
)
def test_a_study_is_no_scene_and_is_told_as_one(read, name, sentence):
    with pytest.raises((SceneError, StudyError), match=sentence):
        read(name)


@pytest.mark.parametrize(
    ("name", "override", "keys"),
    [
        ("bearing_6203", "drive.change={time: 0.2, speed: 10}", ["drive.change.time = 0.2 s"]),
        ("bearing_6203", "drive.change={time: 0.1, speed: 10}", []),
        ("bearing_6203", "drive.speed=100", []),
        (
            "bearing_6203_rig_400N",
            "rings.inner.change={time: 0.5, load: [0, -1, 0]}",
            ["rings.inner.change.time = 0.5 s"],
        ),
        ("bearing_6203_rig_400N", "rings.inner.table=[[0, 0, 0, 0, 0, 0], [9, 0, 1, 0, 0, 0]]", []),
        (
            "bearing_6203_rig_400N",
            "rings.inner.table=[[0, 0, 0, 0, 0, 0], [0.3, 0, 1, 0, 0, 0], [9, 0, 1, 0, 0, 0]]",
            ["what rings.inner.table says after 0.3 s"],
        ),
        (
            "bearing_6203_run_up",
            "drive.torque_table=[[0.2, 0], [0.3, 0.001]]",
            ["what drive.torque_table says after 0.2 s"],
        ),
    ],
)
def test_what_comes_only_after_the_end_of_a_run_is_named(name, override, keys):
    scene = load_scene(name, ["run.duration=0.1", override])
    reported = unreached_keys(scene, 0.1)
    assert reported == [f"{key} is beyond the end of the run at 0.1 s: nothing of that happens" for key in keys]
    assert not unreached_keys(scene, math.inf)


@pytest.mark.parametrize(
    ("name", "changes", "sentence"),
    [
        ("two_spheres", ["first.mass=0.2258", "first.radius=19"], "first.mass = 0.2258 kg is 1e-09 times"),
        ("sphere_on_beam", ["sphere.mass=1e-5"], "sphere.mass = 1e-05 kg is 0.0003 times"),
        ("ellipsoid_tumbling", ["body.mass=100"], "body.mass = 100 kg is 4.2e\\+02 times"),
        ("two_bodies_ellipsoid", ["first.mass=1e-9"], "first.mass = 1e-09 kg is"),
        ("two_spheres", ["first.mass=0.2258"], ""),
    ],
)
def test_a_mass_that_size_and_density_contradict_is_a_warning(name, changes, sentence):
    warnings = [warning for warning in choose(load_scene(name, changes)).warnings if "size and density" in warning]
    assert len(warnings) == bool(sentence)
    assert re.search(sentence, "".join(warnings))
