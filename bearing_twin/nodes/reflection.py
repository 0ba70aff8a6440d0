"""Messages of any type as plain data and back, by what their classes say of their fields."""

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rosidl_parser.definition import AbstractGenericString, AbstractNestedType, BasicType, NamespacedType

from bearing_twin.errors import BearingTwinError
from bearing_twin.nodes.interfaces import interface
from bearing_twin.parameters import echo, read_number, unknown

FLOATS = ("float", "double", "long double")


class MessageError(BearingTwinError):
    """A message cannot be made of what was given."""


def plain(message, most: int | None = None) -> Any:
    """A message as mappings, lists, numbers and text; of arrays longer than `most`, if given, the first ones and ..."""
    if hasattr(message, "get_fields_and_field_types"):
        return {name: plain(getattr(message, name), most) for name in message.get_fields_and_field_types()}
    if isinstance(message, bytes):
        return message[0] if len(message) == 1 else list(message)
    if isinstance(message, (array, np.ndarray, list, tuple)):
        kept = message if most is None else message[:most]
        values = kept.tolist() if hasattr(kept, "tolist") else [plain(one, most) for one in kept]
        return values if len(kept) == len(message) else [*values, "..."]
    return message


def filled(message_class: type, data: Any, where: str = "") -> Any:
    """A message of this class with the fields that `data` names, the others at their defaults.

    Raises MessageError with the field and what it must be. A whole number is accepted where a real one is meant.
    """
    if data is None:
        data = {}
    if not isinstance(data, Mapping):
        such = ", ".join(f"{name}: ..." for name in message_class.get_fields_and_field_types())
        raise MessageError(
            f"{where or message_class.__name__} = {echo(data)} must be fields with values, as {{{such}}}"
        )
    types = dict(zip(message_class.get_fields_and_field_types(), message_class.SLOT_TYPES, strict=True))
    fields = {}
    for name, value in data.items():
        if name not in types:
            raise MessageError(f"{where or message_class.__name__} has no field {echo(name)}; {unknown(name, types)}")
        fields[name] = _value(types[name], value, f"{where}.{name}" if where else str(name))
    try:
        return message_class(check_fields=True, **fields)
    except AssertionError as error:
        raise MessageError(f"{where or message_class.__name__}: {error}") from error


def _value(kind, given: Any, where: str) -> Any:
    """What a field of this type takes, made of `given`."""
    if isinstance(kind, NamespacedType):
        return filled(interface(f"{'/'.join(kind.namespaces)}/{kind.name}", kind.namespaces[-1]), given, where)
    if isinstance(kind, AbstractNestedType):
        if not isinstance(given, Sequence) or isinstance(given, str):
            raise MessageError(f"{where} = {echo(given)} must be a list")
        return [_value(kind.value_type, one, f"{where}[{place}]") for place, one in enumerate(given)]
    if isinstance(kind, AbstractGenericString):
        return given if isinstance(given, str) else _refused(where, given, "text; put it into quotes")
    if isinstance(kind, BasicType) and kind.typename == "boolean":
        return given if isinstance(given, bool) else _refused(where, given, "true or false")
    real = kind.typename in FLOATS
    number, problem = read_number(given, integer=not real)
    if problem and not (real and isinstance(given, float)):  # a message may hold what a scene may not: nan and inf
        raise MessageError(f"{where} = {echo(given)} {problem}")
    if kind.typename == "octet":
        return bytes([number]) if 0 <= number < 256 else _refused(where, given, "between 0 and 255")
    return float(given) if problem else number


def _refused(where: str, given: Any, legal: str):
    raise MessageError(f"{where} = {echo(given)} must be {legal}")
