"""The JSON Schema of scene files and study files together: `bearing_twin scenes --schema`."""

from typing import Any

from bearing_twin.kinds import KINDS
from bearing_twin.run.schema import (
    DESCRIPTION,
    DIALECT,
    NAME,
    number_schema,
    object_schema,
    scene_schemas,
    section_schema,
)
from bearing_twin.shelf import SCENES
from bearing_twin.units import NO_LIMITS, Limits
from bearing_twin.uq.distributions import DISTRIBUTIONS, LIMITS
from bearing_twin.uq.knowledge import FORMS
from bearing_twin.uq.scene_keys import numeric_keys
from bearing_twin.uq.study import Settings
from bearing_twin.uq.study_file import GREATEST_SWEEP

ONE_OR_MORE = {"type": ["string", "array"], "minLength": 1, "minItems": 1, "uniqueItems": True}


def schema() -> dict[str, Any]:
    """The schema whose root takes a scene of any kind, told by its `kind`, or a study, told by its `scene`."""
    return {
        "$schema": DIALECT,
        "title": "a scene or a study of bearing_twin",
        "type": "object",
        "if": {"required": ["scene"]},
        "then": {"$ref": "#/$defs/study"},
        "else": {"$ref": "#/$defs/scene"},
        "$defs": scene_schemas() | {"input": input_schema(), "study": study_schema()},
    }


def study_schema() -> dict[str, Any]:
    """The schema of studies; inputs, sweep and quantities are those of the scene's kind where it can be told."""
    found = section_schema(Settings)
    found["properties"]["stop"]["properties"]["quantity"] = {
        "type": "string",
        "description": "whose statistic; the first of quantities unless said",
    }
    numbers = {"type": "array", "minItems": 1, "maxItems": GREATEST_SWEEP, "items": number_schema()}
    pair = [{"type": "string"}, {"type": "string"}, number_schema(Limits(above=-1.0, below=1.0))]
    found["properties"] = {
        "name": NAME,
        "description": DESCRIPTION,
        "scene": {
            "description": "name of a scene, path of its file, or its keys",
            "if": {"type": "object"},
            "then": {"$ref": "#/$defs/scene"},
            "else": {"type": "string"},
        },
        "set": _told(
            "changes of the scene, such as motion.first_velocity=50",
            type="array",
            items={"type": "string", "pattern": "="},
        ),
        "inputs": _told(
            "keys of the scene and what is known of them",
            type="object",
            minProperties=1,
            additionalProperties={"$ref": "#/$defs/input"},
        ),
        "correlation": _told(
            "[key, key, value]: of the normal scores of two inputs",
            type="array",
            items={"type": "array", "prefixItems": pair, "minItems": 3, "maxItems": 3},
        ),
        "quantities": _told("what shall be found out", items={"type": "string"}, **ONE_OR_MORE),
        "histories": _told("channels of one number, over time", items={"type": "string"}, type=["string", "array"]),
        "densities": _told(
            "quantities and the values at which their density is asked for",
            type="object",
            additionalProperties=numbers,
        ),
        "sweep": _told(
            "one key of the scene and its values",
            type="object",
            minProperties=1,
            maxProperties=1,
            additionalProperties=numbers,
        ),
        "executor": _told(
            "where realisations run", type="string", pattern="^(processes$|dask://)", default="processes"
        ),
    } | found["properties"]
    found["required"] = ["scene", "inputs", "quantities"]
    names = {kind: [head["name"] for head in SCENES.heads() if head["kind"] == kind] for kind in KINDS}
    return found | {"allOf": [_of_kind(kind, names[kind]) for kind in KINDS]}


def input_schema() -> dict[str, Any]:
    """The schema of an input: a number, a named distribution by one of its forms, or what is known."""
    also = {"type": ["string", "array"], "items": {"type": "string"}, "description": "further keys of the same value"}
    ways = []
    for name, row in DISTRIBUTIONS.items():
        for form in row.forms:
            head = {"distribution": {"const": name, "description": row.help}, "also": also}
            ways.append(_exactly(form, head, ("distribution",)))
    facts = []
    for form in FORMS:
        # `positive: false` says nothing, so it may stand anywhere
        facts.append(_exactly(form - {"positive"}, {"positive": {"const": "positive" in form}}, form & {"positive"}))
    known = _told("the distribution of greatest entropy follows", anyOf=facts)
    ways.append(_exactly((), {"know": known, "also": also}, ("know",)))
    return {"if": {"type": "object"}, "then": {"anyOf": ways}, "else": number_schema()}


def _exactly(form, head: dict, required) -> dict:
    """An object with numbers at the words of `form`, all of them, beside `head`."""
    found = object_schema()
    found["properties"] = head | {word: _parameter(word) for word in sorted(form)}
    found["required"] = [*sorted(required), *sorted(form)]
    return found


def _parameter(word: str) -> dict:
    if word == "values":
        return {"type": "array", "minItems": 1, "items": number_schema()}
    return number_schema(LIMITS.get(word, NO_LIMITS))


def _of_kind(kind: str, names: list[str]) -> dict:
    """What a study whose scene is of that kind may name."""
    keys = {"propertyNames": {"enum": list(numeric_keys(kind))}}
    quantity = {"enum": list(KINDS[kind].quantities_of())}
    own = {"properties": {"kind": {"const": kind}}, "required": ["kind"]}
    scene = {"if": {"type": "object"}, "then": own, "else": {"enum": names}}
    asked = {"if": {"type": "string"}, "then": quantity, "else": {"items": quantity}}
    return {
        "if": {"properties": {"scene": scene}},
        "then": {"properties": {"inputs": keys, "sweep": keys, "quantities": asked}},
    }


def _told(description: str, **schema) -> dict:
    return {"description": description, **schema}
