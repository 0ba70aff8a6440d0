"""The JSON Schema takes every shipped file and refuses what the reader refuses, for scenes and for studies."""

import json
import math
import re

import jsonschema
import pytest
import toy_kind  # noqa: F401 - a kind the schema must know as any other

from bearing_twin.base.errors import BearingTwinError
from bearing_twin.base.parameters import NUMBER, describe
from bearing_twin.base.yaml_files import SCENES, STUDIES
from bearing_twin.kinds import KINDS
from bearing_twin.run.scene import parse_scene, scene_names
from bearing_twin.uq.distributions import DISTRIBUTIONS, FORMS
from bearing_twin.uq.schema import schema
from bearing_twin.uq.study import parse_study, study_names

SCHEMA = schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
FILES = [*((SCENES, name) for name in scene_names()), *((STUDIES, name) for name in study_names())]
STUDY = "scene: two_spheres\ninputs: {motion.first_velocity: {distribution: uniform, low: 1, high: 2}}\nquantities: "


def as_editors_read(value):
    """The same with 1e-6 as a number, which YAML 1.2 makes of it."""
    if isinstance(value, dict):
        return {key: as_editors_read(one) for key, one in value.items()}
    if isinstance(value, list):
        return [as_editors_read(one) for one in value]
    return float(value) if isinstance(value, str) and NUMBER.fullmatch(value) else value


def read(text):
    data = SCENES.load(text, "text")
    return parse_study(data, "text") if isinstance(data, dict) and "scene" in data else parse_scene(data, "text")


def test_it_is_a_schema_and_printed_as_one(typed):
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    for words in ((), ("--json",)):
        assert json.loads(typed("scenes", "--schema", *words).out) == json.loads(json.dumps(SCHEMA))


@pytest.mark.parametrize(("shelf", "name"), FILES, ids=[name for _, name in FILES])
def test_shipped_files_are_valid(shelf, name):
    data = shelf.load(shelf.read_text(shelf.find(name)), name)
    VALIDATOR.validate(data)
    VALIDATOR.validate(as_editors_read(data))


@pytest.mark.parametrize("name", scene_names())
def test_a_resolved_scene_is_valid(name):
    VALIDATOR.validate(parse_scene(SCENES.read_text(SCENES.find(name)), name).resolved())


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_is_there_with_default_unit_and_limits(kind):
    properties = SCHEMA["$defs"][f"scene_{kind}"]
    for row in describe(KINDS[kind].parameters):
        found = properties
        for word in row.key.split("."):
            found = found.get("anyOf", [None, found])[1]["properties"][word]
        assert found["description"].startswith(row.help)
        assert row.unit in found["description"] or row.unit == "1"
        assert found["default"] == (list(row.default) if isinstance(row.default, tuple) else row.default)
        reported = {word: one for word, one in found.get("items", found).items() if re.search("inimum|aximum", word)}
        assert ("type" in found and not row.options) == bool(reported)
        ends = [one for one in (*row.bounds[:4], row.bounds.greatest, -row.bounds.greatest) if one is not None]
        for number in {2.0 * one for one in ends} | {one + shift for one in ends for shift in (-1e-3, 0.0, 1e-3)}:
            if reported and math.isfinite(number):
                assert jsonschema.Draft202012Validator(reported).is_valid(number) == row.bounds._replace(
                    least=0.0
                ).allow(number)


RIGHT = [
    "kind: toy\nstart: 1e-3\n",
    "kind: bearing\nsolver: {tolerance: 1e-4}\n",
    "kind: bearing\nmaterials: {ball: silicon_nitride, inner_ring: {density: 7800}}\n",
    "kind: bearing\ngeometry: {balls: 7.0}\n",
    "kind: bearing\nwanted: {outputs: [loads], tolerance: 0.01}\n",
    STUDY + "peak_force",
    STUDY + "[peak_force]\nstop: {quantity: peak_force, tolerance: 1.0}",
    "scene: {kind: two_discs}\ninputs: {disc.radius: 1}\nquantities: [impulse]\nsweep: {motion.gap: [0, 1e-6]}\n",
]


@pytest.mark.parametrize("text", RIGHT)
def test_what_the_reader_takes_is_valid(text):
    read(text)
    VALIDATOR.validate(SCENES.load(text, "text"))


WRONG = [
    "name: nothing\n",
    "kind: gearbox\n",
    "kind: bearing\ncontacts: {}\n",
    "kind: bearing\ncontact: {norml: hertz}\n",
    "kind: bearing\ncontact: {normal: hertzian}\n",
    "kind: bearing\ncontact: {normal: johnson}\n",
    "kind: bearing\ncontact: {yield_pressure: 4.0e+9}\n",
    "kind: bearing\ncontact: {friction_coefficient: -0.1}\n",
    "kind: bearing\ngeometry: {inner_conformity: 0.5}\n",
    "kind: bearing\ngeometry: {balls: 7.5}\n",
    "kind: bearing\ngeometry: {balls: many}\n",
    "kind: bearing\ngeometry:\n",
    "kind: bearing\ngeometry: 6203\n",
    "kind: bearing\nmaterials: {ball: stel}\n",
    "kind: bearing\nmaterials: {ball: {poisson_ratio: 0.5}}\n",
    "kind: bearing\ndrive: {offset: [0.0, 0.0]}\n",
    "kind: bearing\ngravity: 9.81\n",
    "kind: two_spheres\nrun: {wanted: peaks}\n",
    "kind: two_spheres\nwanted: {outputs: []}\n",
    "kind: two_spheres\nwanted: {outputs: [peaks, loads]}\n",
    "kind: two_discs\nrun: {duration: true}\n",
    "kind: ellipsoid_on_plane\nfriction: {coefficient: 0.1}\n",
    "kind: toy\nstart: here\n",
    "kind: bearing\nname: ''\n",
    "scene: two_spheres\nquantities: [peak_force]\n",
    "scene: two_spheres\ninputs: {}\nquantities: [peak_force]\n",
    "scene: 3\ninputs: {motion.gap: 0}\nquantities: [peak_force]\n",
    "scene: two_spheres\ninputs: {geometry.balls: 8}\nquantities: [peak_force]\n",
    "scene: two_spheres\ninputs: {motion.first_velocity: fast}\nquantities: [peak_force]\n",
    "scene: {kind: two_spheres, motion: {speed: 3}}\ninputs: {motion.gap: 0}\nquantities: [peak_force]\n",
    "scene: two_spheres\ninputs: {motion.first_velocity: {distribution: uniform, mean: 1}}\nquantities: [peak_force]\n",
    "scene: two_spheres\ninputs: {motion.first_velocity: {know: {mean: 1, mode: 2}}}\nquantities: [peak_force]\n",
    "scene: two_spheres\ninputs: {motion.first_velocity: {distribution: normal, mean: 1, std: 0}}\nquantities: impulse",
    STUDY + "[]",
    STUDY + "[cage_speed]",
    STUDY + "[peak_force]\nsample: 100",
    STUDY + "[peak_force]\nsamples: 0",
    STUDY + "[peak_force]\nmethod: montecarlo",
    STUDY + "[peak_force]\nset: motion.gap",
    STUDY + "[peak_force]\nsweep: {motion.gap: []}",
    STUDY + "[peak_force]\nstop: {statistic: variance}",
    STUDY + "[peak_force]\nexecutor: cluster",
]


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_refused_by_schema_and_reader(text):
    with pytest.raises(BearingTwinError):
        read(text)
    with pytest.raises(jsonschema.ValidationError):
        VALIDATOR.validate(SCENES.load(text, "text"))


def test_it_knows_every_way_to_state_an_input():
    ways = SCHEMA["$defs"]["input"]["then"]["anyOf"]
    named = {(one["properties"]["distribution"]["const"], *sorted(one["required"])) for one in ways[1:-1]}
    assert named == {
        (name, *sorted(("distribution", *form))) for name, row in DISTRIBUTIONS.items() for form in row.forms
    }
    assert [set(one["required"]) for one in ways[-1]["properties"]["know"]["anyOf"]] == [set(form) for form in FORMS]


SAID = ("no source: ", "ISO", "paper")
OWN = ("contact.exponent", "contact.restitution")  # 1: as paper 3's bed of springs, and no loss


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_of_physics_that_are_there_by_default_say_where_they_come_from(kind):
    """Of contacts, cages, grooves and materials; sizes, speeds and loads are the user's scene."""
    for row in describe(KINDS[kind].parameters):
        about = row.key.startswith(("contact.", "cage.")) or row.key.endswith("conformity") or "material" in row.key
        if about and row.type == "number" and row.default and row.key not in OWN:
            assert any(word in row.help for word in SAID), row.key
