"""The JSON Schema of scene files and study files together: `bearing_twin scenes --schema`.

It is drawn from the dataclasses that read them, so that editors complete and check YAML files, and says what each key
may hold alone. What keys must be together (`Kind.check`) only the reader knows.
"""

import math
import re
from typing import Any

from bearing_twin.base.parameters import LONGEST_NUMBER, NUMBER, Parameter, describe
from bearing_twin.base.units import NO_LIMITS, Limits, with_unit
from bearing_twin.base.yaml_files import LONGEST_DESCRIPTION, LONGEST_NAME, SCENES
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.sections import ALIASES
from bearing_twin.uq.distributions import DISTRIBUTIONS, FORMS, LIMITS, LISTS, SCIPY
from bearing_twin.uq.inputs import numeric_keys
from bearing_twin.uq.study import GREATEST_SWEEP, OTHER_NAMES, Settings

DIALECT = "https://json-schema.org/draft/2020-12/schema"
WORDS_OF_LIMITS = {
    "above": "exclusiveMinimum",
    "below": "exclusiveMaximum",
    "at_least": "minimum",
    "at_most": "maximum",
}
UNIT = r"([A-Za-zµμ°%/][A-Za-zµμ°/^²³·* \d.-]{0,15})?"
"""Behind a number, as in 3000rpm, 13 um, 60 °C; whether it fits the key is not checked."""
NAME = {"type": "string", "minLength": 1, "maxLength": LONGEST_NAME, "pattern": r"\S", "description": "on one line"}
DESCRIPTION = {"type": "string", "maxLength": LONGEST_DESCRIPTION, "description": "what it shows"}
ONE_OR_MORE = {"type": ["string", "array"], "minLength": 1, "minItems": 1, "uniqueItems": True}


def schema() -> dict[str, Any]:
    """The schema whose root takes a scene of any kind, known by its `kind`, or a study, known by its `scene`."""
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
    """The schema of studies; inputs, sweep and quantities are those of the scene's kind where it is known."""
    found = section_schema(Settings)
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
        "set": _described(
            "changes of the scene, such as motion.first_velocity=50",
            type="array",
            items={"type": "string", "pattern": "="},
        ),
        "inputs": _described(
            "keys of the scene and what is known of them",
            type="object",
            minProperties=1,
            additionalProperties={"$ref": "#/$defs/input"},
        ),
        "correlation": _described(
            "[key, key, value]: of the normal scores of two inputs",
            type="array",
            items={"type": "array", "prefixItems": pair, "minItems": 3, "maxItems": 3},
        ),
        "quantities": _described("the requested quantities", items={"type": "string"}, **ONE_OR_MORE),
        "histories": _described(
            "channels of one number, over time", items={"type": "string"}, type=["string", "array"]
        ),
        "sweep": _described(
            "one key of the scene and its values",
            type="object",
            minProperties=1,
            maxProperties=1,
            additionalProperties=numbers,
        ),
        "executor": _described(
            "where realisations run", type="string", pattern="^(processes$|dask://)", default="processes"
        ),
    } | found["properties"]
    for other, first in OTHER_NAMES.items():
        found["properties"][other] = found["properties"][first] | {"description": f"another name of {first}"}
    found["required"] = ["scene", "inputs", "quantities"]
    names = {kind: [head["name"] for head in SCENES.heads() if head["kind"] == kind] for kind in KINDS}
    return found | {"allOf": [_of_kind(kind, names[kind]) for kind in KINDS]}


def input_schema() -> dict[str, Any]:
    """The schema of an input: a number, a named distribution by one of its forms, or what is known."""
    also = {"type": ["string", "array"], "items": {"type": "string"}, "description": "further keys of the same value"}
    scipy = {"distribution": {"type": "string", "pattern": rf"^{re.escape(SCIPY)}\w+$"}, "also": also}
    ways = [
        {"type": "object", "properties": scipy, "required": ["distribution"], "additionalProperties": number_schema()}
    ]
    for name, row in DISTRIBUTIONS.items():
        for form in row.forms:
            head = {"distribution": {"const": name, "description": row.help}, "also": also}
            ways.append(_exactly(form, head, ("distribution",)))
    facts = []
    for form in FORMS:
        # `positive: false` says nothing, so it may stand anywhere
        facts.append(_exactly(form - {"positive"}, {"positive": {"const": "positive" in form}}, form & {"positive"}))
    known = _described("the distribution of greatest entropy follows", anyOf=facts)
    ways.append(_exactly((), {"know": known, "also": also}, ("know",)))
    return {"if": {"type": "object"}, "then": {"anyOf": ways}, "else": number_schema()}


def _exactly(form, head: dict, required) -> dict:
    """An object with numbers at the words of `form`, all of them, and `head`."""
    found = object_schema()
    found["properties"] = head | {word: _parameter(word) for word in sorted(form)}
    found["required"] = [*sorted(required), *sorted(form)]
    return found


def _parameter(word: str) -> dict:
    if word in LISTS:
        return {"type": "array", "minItems": 1, "items": number_schema()}
    return number_schema(LIMITS.get(word, NO_LIMITS))


def _of_kind(kind: str, names: list[str]) -> dict:
    """Names that a study of a scene of that kind may use."""
    keys = {"propertyNames": {"enum": list(numeric_keys(kind))}}
    quantity = {"enum": list(KINDS[kind].quantities_of())}
    own = {"properties": {"kind": {"const": kind}}, "required": ["kind"]}
    scene = {"if": {"type": "object"}, "then": own, "else": {"enum": names}}
    wanted = {"if": {"type": "string"}, "then": quantity, "else": {"items": quantity}}
    return {
        "if": {"properties": {"scene": scene}},
        "then": {"properties": {"inputs": keys, "sweep": keys, "quantities": wanted}},
    }


def _described(description: str, **schema) -> dict:
    return {"description": description, **schema}


def number_schema(limits: Limits = NO_LIMITS, whole: bool = False) -> dict:
    """The schema of a number; text such as 1e-6 or 3000rpm counts, and then its limits are not checked."""
    given = limits._asdict()
    bounds = {word: given[name] for name, word in WORDS_OF_LIMITS.items() if given[name] is not None}
    if limits.greatest < math.inf:
        bounds["maximum"] = limits.greatest
        if not {"minimum", "exclusiveMinimum"} & bounds.keys():
            bounds["minimum"] = -limits.greatest
    written = {"pattern": rf"^\s*{NUMBER.pattern}\s*{UNIT}$", "maxLength": LONGEST_NUMBER}
    return {"type": ["integer" if whole else "number", "string"], **bounds, **written}


def parameter_schema(row: Parameter) -> dict:
    """The schema of one key; `row` as `describe` gives it."""
    found = {"description": f"{row.help}{with_unit(row.unit) and f' [{row.unit}]'}", "default": _plain(row.default)}
    if row.type == "table":
        lines = {"type": "array", "items": {"type": "array", "items": number_schema()}}
        return found | {"anyOf": [lines, {"type": "string"}]}
    if row.type == "list":
        return found | {"anyOf": [{"type": "array", "items": {"type": "object"}}]}
    if row.type == "free text":
        return found | {"type": ["string", "integer"], "examples": list(row.options)}
    if row.type == "text":
        return found | {"enum": list(row.options)}
    if row.type == "words":
        word = {"enum": list(row.options)}
        return found | {"anyOf": [word, {"type": "array", "items": word, "minItems": 1}]}
    if row.options:
        return found | {"anyOf": [{"enum": list(row.options)}, object_schema()]}
    if row.type.endswith(" numbers"):
        size = len(row.default)
        return found | {"type": "array", "items": number_schema(row.bounds), "minItems": size, "maxItems": size}
    return found | number_schema(row.bounds, row.type == "integer")


def section_schema(cls: type) -> dict:
    """The schema of a parameter dataclass: an object with its keys and sections and no others."""
    root = object_schema()
    for row in describe(cls):
        *sections, key = row.key.split(".")
        holder = root
        for word in sections:
            section = holder["properties"].setdefault(word, object_schema())
            holder = section["anyOf"][1] if "anyOf" in section else section  # which may also be given by a name
        holder["properties"][key] = parameter_schema(row)
    return root


def scene_schema(kind: str) -> dict:
    """The schema of scenes of one kind."""
    found = section_schema(KINDS[kind].parameters)
    head = {"kind": {"const": kind, "description": KINDS[kind].help}, "name": NAME, "description": DESCRIPTION}
    found["properties"] = head | found["properties"]
    found["required"] = ["kind"]
    for other, first in ALIASES.items():
        (section, key), (home, name) = other.split("."), first.split(".")
        places = [found["properties"].get(word, {}).get("properties", {}) for word in (section, home)]
        if places[0] and name in places[1]:
            places[0][key] = places[1][name] | {"description": f"another name of {first}"}
    return found


def scene_schemas() -> dict[str, Any]:
    """`$defs` of a schema: one entry a kind, `scene_<kind>`, and `scene`, which is any of them by its `kind`."""
    found = {f"scene_{kind}": scene_schema(kind) for kind in KINDS}
    found["scene"] = {
        "type": "object",
        "required": ["kind"],
        "properties": {"kind": {"enum": list(KINDS), "description": "what is simulated"}},
        "allOf": [
            {
                "if": {"properties": {"kind": {"const": kind}}, "required": ["kind"]},
                "then": {"$ref": f"#/$defs/scene_{kind}"},
            }
            for kind in KINDS
        ],
    }
    return found


def object_schema() -> dict:
    """An object with no keys yet."""
    return {"type": "object", "properties": {}, "additionalProperties": False}


def _plain(value):
    return list(value) if isinstance(value, tuple) else value
