"""The numbers of a scene by key path, such as `geometry.radial_clearance` or `drive.offset[1]`: what may be uncertain.

A path is split into words; a whole number is the place in a tuple. Values are put into the plain data of a scene
(one realisation, read and checked like any scene) or into its dataclass (arrays, for closed forms).
"""

import dataclasses
import functools
import re

from bearing_twin.errors import SceneError, StudyError
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.sections import ALIASES
from bearing_twin.parameters import Parameter, describe, echo, read_number, unknown
from bearing_twin.run.scene import Scene, checked, parse_scene, read_scene

_PLACE = re.compile(r"(.+)\[(\d+)\]")


@functools.cache
def numeric_keys(kind: str) -> dict[str, Parameter]:
    """Every number of a kind of scene by its key path; tuples give one key a place."""
    found = {}
    for row in describe(KINDS[kind].parameters):
        if row.type in ("number", "integer"):
            found[row.key] = row
        elif row.type.endswith(" numbers"):
            found |= {f"{row.key}[{place}]": row for place in range(len(row.default))}
    return found


def first_name(key):
    """A key by its first name, as `wanted.tolerance` for `solver.tolerance`, also before further words."""
    for other, first in ALIASES.items() if isinstance(key, str) else ():
        if key == other or key.startswith(f"{other}."):
            return first + key.removeprefix(other)
    return key


def checked_key(kind: str, key) -> str:
    """The first name of the key, if it is a number of that kind of scene; raises StudyError with the nearest one."""
    known, first = numeric_keys(kind), first_name(key)
    if first in known:
        return first
    raise StudyError(f"{echo(key)} is no number of a scene of kind {kind}; {unknown(key, known)}")


def words_of(key: str) -> tuple[str | int, ...]:
    """`drive.offset[1]` as ("drive", "offset", 1)."""
    place = _PLACE.fullmatch(key)
    words = (place.group(1) if place else key).split(".")
    return (*words, int(place.group(2))) if place else tuple(words)


def put(mapping: dict, key: str, value) -> dict:
    """A copy of a scene's plain data, shared but for the changed path, with the value at that key."""
    return _put(mapping, words_of(key), value)


def placed(scene: dict, targets, values) -> dict:
    """A scene's plain data with one value for each group of keys."""
    for keys, value in zip(targets, values, strict=True):
        for key in keys:
            scene = put(scene, key, float(value))
    return scene


def replaced(parameters, key: str, value):
    """A scene's dataclass with the value (a number or an array) at that key; nothing is checked."""
    return _replaced(parameters, words_of(key), value)


class Reader:
    """Scenes that differ in the numbers of their `targets` alone: what they have in common is read once.

    `scene` is the plain data of one, whose keys are all there.
    """

    def __init__(self, scene: dict, targets):
        self.scene, self.targets = scene, targets
        known = numeric_keys(scene["kind"])
        self._rows = [[(words_of(key), known[key]) for key in keys] for keys in targets]
        try:
            self._common: Scene | None = read_scene(scene, "a scene")
        except SceneError:  # a number that each realisation replaces
            self._common = None

    def at(self, values, origin: str) -> Scene:
        """As `parse_scene` of the `placed` values, to the bit, with its refusals."""
        if self._common is None:
            return parse_scene(placed(self.scene, self.targets, values), origin)
        parameters = self._common.parameters
        for rows, given in zip(self._rows, values, strict=True):
            for words, row in rows:
                value, problem = read_number(float(given), row.unit, row.bounds, integer=row.type == "integer")
                if problem:  # told with all others there are
                    return parse_scene(placed(self.scene, self.targets, values), origin)
                parameters = _replaced(parameters, words, value)
        return checked(dataclasses.replace(self._common, parameters=parameters), origin)


def value_at(mapping, key: str):
    """The value in a scene's plain data at that key."""
    for word in words_of(key):
        mapping = mapping[word]
    return mapping


def _put(holder, words, value):
    if not words:
        return value
    changed = holder.copy()
    changed[words[0]] = _put(holder[words[0]], words[1:], value)
    return changed


def _replaced(holder, words, value):
    if not words:
        return value
    if isinstance(holder, tuple):
        return (*holder[: words[0]], value, *holder[words[0] + 1 :])
    return dataclasses.replace(holder, **{words[0]: _replaced(getattr(holder, words[0]), words[1:], value)})
