"""The JSON Schema of scenes, drawn from the dataclasses that read them, so that editors complete and check YAML files.

It says what each key may hold alone. What keys must be together (`Kind.check`) only the reader knows.
"""

import math
from typing import Any

from bearing_twin.kinds import KINDS
from bearing_twin.kinds.sections import ALIASES
from bearing_twin.parameters import LONGEST_NUMBER, NUMBER, Parameter, describe
from bearing_twin.shelf import LONGEST_DESCRIPTION, LONGEST_NAME
from bearing_twin.units import NO_LIMITS, Limits, with_unit

DIALECT = "https://json-schema.org/draft/2020-12/schema"
WORDS_OF_LIMITS = {
    "above": "exclusiveMinimum",
    "below": "exclusiveMaximum",
    "at_least": "minimum",
    "at_most": "maximum",
}
NAME = {"type": "string", "minLength": 1, "maxLength": LONGEST_NAME, "pattern": r"\S", "description": "on one line"}
DESCRIPTION = {"type": "string", "maxLength": LONGEST_DESCRIPTION, "description": "what it shows"}


def number_schema(limits: Limits = NO_LIMITS, whole: bool = False) -> dict:
    """The schema of a number; text such as 1e-6 counts, as YAML 1.1 reads it, and then its limits are not checked."""
    given = limits._asdict()
    bounds = {word: given[name] for name, word in WORDS_OF_LIMITS.items() if given[name] is not None}
    if limits.greatest < math.inf:
        bounds["maximum"] = limits.greatest
        if not {"minimum", "exclusiveMinimum"} & bounds.keys():
            bounds["minimum"] = -limits.greatest
    written = {"pattern": rf"^\s*{NUMBER.pattern}\s*$", "maxLength": LONGEST_NUMBER}
    return {"type": ["integer" if whole else "number", "string"], **bounds, **written}


def parameter_schema(row: Parameter) -> dict:
    """The schema of one key; `row` as `describe` gives it."""
    told = {"description": f"{row.help}{with_unit(row.unit) and f' [{row.unit}]'}", "default": _plain(row.default)}
    if row.type == "table":
        lines = {"type": "array", "items": {"type": "array", "items": number_schema()}}
        return told | {"anyOf": [lines, {"type": "string"}]}
    if row.type == "free text":
        return told | {"type": ["string", "integer"], "examples": list(row.options)}
    if row.type == "text":
        return told | {"enum": list(row.options)}
    if row.type == "words":
        word = {"enum": list(row.options)}
        return told | {"anyOf": [word, {"type": "array", "items": word, "minItems": 1}]}
    if row.options:
        return told | {"anyOf": [{"enum": list(row.options)}, object_schema()]}
    if row.type.endswith(" numbers"):
        size = len(row.default)
        return told | {"type": "array", "items": number_schema(row.bounds), "minItems": size, "maxItems": size}
    return told | number_schema(row.bounds, row.type == "integer")


def section_schema(cls: type) -> dict:
    """The schema of a parameter dataclass: an object with its keys and sections and no others."""
    root = object_schema()
    for row in describe(cls):
        *sections, key = row.key.split(".")
        holder = root
        for word in sections:
            holder = _keys_of(holder["properties"].setdefault(word, object_schema()))
        holder["properties"][key] = parameter_schema(row)
    return root


def scene_schema(kind: str) -> dict:
    """The schema of scenes of one kind."""
    found = section_schema(KINDS[kind].parameters)
    head = {"kind": {"const": kind, "description": KINDS[kind].help}, "name": NAME, "description": DESCRIPTION}
    found["properties"] = head | found["properties"]
    found["required"] = ["kind"]
    twice = []
    for other, first in ALIASES.items():
        (section, key), (home, name) = other.split("."), first.split(".")
        places = [found["properties"].get(word, {}).get("properties", {}) for word in (section, home)]
        if places[0] and name in places[1]:
            places[0][key] = places[1][name] | {"description": f"another name of {first}"}
            given = {section: {"required": [key]}, home: {"required": [name]}}
            twice.append({"not": {"properties": given, "required": [section, home]}})
    return found | ({"allOf": twice} if twice else {})


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


def _keys_of(schema: dict) -> dict:
    """The object in the schema of a section, which may also be given by a name."""
    return schema["anyOf"][1] if "anyOf" in schema else schema


def _plain(value):
    return list(value) if isinstance(value, tuple) else value
