"""Scenes: one strict SI YAML file each, read into frozen dataclasses, and back into a resolved dump; their models."""

import copy
import dataclasses
import functools
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import Any

import yaml

from bearing_twin.base.errors import MOST_NAMED, MOST_NEAR, SceneError, echo, is_text, legal_hint, shorten
from bearing_twin.base.parameters import (
    describe,
    names_at,
    plain,
    raise_problems,
    read,
    read_number,
    stands_for_section,
)
from bearing_twin.base.report import Choice, parse_json
from bearing_twin.base.sample import Channel, Table
from bearing_twin.base.units import UNITS
from bearing_twin.base.yaml_files import LONGEST_DESCRIPTION, LONGEST_NAME, SCENES
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.bearing.catalogue import catalogue_scenes
from bearing_twin.kinds.rules import OUTSIDE, allowed, left_by
from bearing_twin.kinds.sections import ALIASES, FORMER_VALUES, damped_twice
from bearing_twin.run.second_run import record_tables

DESIGNATION = re.compile(r"[A-Za-z]{0,6}[ -]{0,3}\d{2,6}(?![\w./ -]*\.ya?ml)[\w./ -]{0,40}")  # as SKF 6205-2RS/C3
LONGEST_YAML = 30_000  # characters of a scene as JSON, beyond which its text is that: YAML takes 40 times the time
LONGEST_LOGGED = 8_000_000  # characters of a scene in a log
MOST_LOGGED_VALUES = 360_000  # commas in one, enough for a table of `parameters.MOST_ROWS`: a second to read
UNDESCRIBED = ("run", "solver", "wanted")  # sections of which a description says nothing
SWITCHES = {"true": "on", "false": "off"}  # other words for these, as YAML has them
MARK = Channel(OUTSIDE, "1", (), "1: a model asked for is outside its range; see solver.allow_invalid")
YAML_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # Python's own takes longer than 0.3 s of a settled bearing


@dataclass(frozen=True)
class Scene:
    """A scene, complete and checked: `parameters` is the dataclass of its `kind`, all SI."""

    name: str
    kind: str
    description: str
    parameters: Any

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels of one sample of this scene, in order; last a mark, where a model runs outside its range."""
        return tuple(KINDS[self.kind].channels(self.parameters)) + (MARK,) * self.marked

    @property
    def tables(self) -> tuple[Table, ...]:
        """Tables of what a run of this scene records between outputs."""
        return record_tables(KINDS[self.kind], self.parameters)

    @property
    def allows_invalid(self) -> bool:
        """True where a specified model may run outside its range."""
        return allowed(self.parameters)

    @property
    def marked(self) -> bool:
        """True where a model runs outside its range, so that every output is marked."""
        return self.allows_invalid and bool(self.outside)

    @functools.cached_property
    def outside(self) -> tuple[str, ...]:
        """One sentence for each range of a specified model that the scene leaves, as far as it is known before."""
        return left_by(self.parameters)

    @property
    def output_period_ns(self) -> int:
        """Nanoseconds between two outputs."""
        return max(1, round(1e9 / self.parameters.run.output_rate))

    @property
    def outputs(self) -> int:
        """Number of outputs of the whole run, the one at time zero included."""
        return int(1e9 * self.parameters.run.duration // self.output_period_ns) + 1

    @functools.cached_property
    def text(self) -> str:
        """`resolved` as YAML; as JSON where it holds a long table."""
        resolved = self.resolved()
        quick = json.dumps(resolved)
        return quick if len(quick) > LONGEST_YAML else yaml.dump(resolved, Dumper=YAML_DUMPER, sort_keys=False)

    def resolved(self) -> dict:
        """All keys with defaults filled in, as plain data; `parse_scene` of its YAML gives an equal scene."""
        head = {"name": self.name, "kind": self.kind, "description": self.description}
        return head | plain(self.parameters)


def scene_names() -> list[str]:
    """Names of the scenes that come with the package, sorted."""
    return SCENES.names()


def load_scene(name_or_path: str | PathLike | Mapping, overrides: Iterable[str] = ()) -> Scene:
    """A scene by its name, its file or its plain data, checked and complete.

    Parameters
    ----------
    name_or_path : str, path or mapping
        Name of a shipped scene, designation of a bearing such as "6308", path of a YAML file, or the keys of a scene.
    overrides : list of str
        Keys and values that replace those of the scene, such as `contact.normal=volumetric` or `drive.speed=3000rpm`:
        numbers in SI, or with their unit.

    Returns
    -------
    Scene
        `parameters` are the values of all keys [SI], `channels` what each output of a run holds, `resolved()` the keys
        as plain data.

    Raises
    ------
    SceneError
        Naming every problem: a name that is none, keys that are not known, values out of range or in contradiction.

    Examples
    --------
    >>> import bearing_twin
    >>> bearing_twin.load_scene("6308", ["drive.speed=3000rpm"]).parameters.drive.speed
    314.159265358979
    """
    return parse_scene(*_read_source(name_or_path, overrides))


def open_scene(source, overrides: Iterable[str] = ()) -> tuple[dict, str]:
    """The mapping of a scene and its origin, for `parse_scene`: as `load_scene`, but automatic keys are not yet chosen.

    `source` is a name, a path or a scene's plain data. Numbers may contradict each other: some may be replaced.
    """
    mapping, origin = _read_source(source, overrides)
    return read_scene(mapping, origin).resolved(), origin


def check_overrides(overrides: Iterable[str]) -> tuple[str, ...]:
    """The overrides; raises SceneError for what is no list of texts, and for two values of one key."""
    legal = isinstance(overrides, Iterable) and not isinstance(overrides, (str, bytes, Mapping))
    texts = tuple(overrides) if legal else ()
    if not legal or not all(isinstance(override, str) for override in texts):
        raise SceneError(f"overrides {echo(overrides)} must be a list of texts such as ['run.duration=0.1']")
    values = {}
    for override in texts:
        key, equals, text = (part.strip() for part in override.partition("="))
        earlier = values.setdefault(ALIASES.get(key, key), text) if equals else text
        if not _equal_values(earlier, text):
            raise SceneError(f"{key} is given as {echo(earlier)} and as {echo(text)}; keep one of them")
    return texts


def _equal_values(first: str, second: str) -> bool:
    """True for one word or switch, and for numbers that are equal in some unit, as 0.1 and 100ms."""
    if SWITCHES.get(first.lower(), first) == SWITCHES.get(second.lower(), second):
        return True
    numbers = ([read_number(text, unit)[0] for text in (first, second)] for unit in UNITS)
    return any(None not in pair and math.isclose(*pair) for pair in numbers)


def has_override(overrides: Iterable[str], key: str) -> bool:
    """True where one of the overrides gives this key."""
    return any(override.partition("=")[0].strip() == key for override in overrides)


def parse_scene(text_or_mapping: str | Mapping, origin: str) -> Scene:
    """The scene in a YAML text or a mapping.

    Parameters
    ----------
    text_or_mapping : str or mapping
        The keys of a scene, in SI or with units.
    origin : str
        Names the text in errors; without a key `name` it is the name of the scene.

    Returns
    -------
    Scene
        As by `load_scene`.

    Raises
    ------
    SceneError
        Naming every problem.
    """
    return check_scene(read_scene(text_or_mapping, origin), origin)


def check_scene(scene: Scene, origin: str) -> Scene:
    """A scene of `read_scene`, checked, its automatic choices made; raises SceneError."""
    raise_problems(origin, scene.parameters.check())
    return dataclasses.replace(scene, parameters=scene.parameters.resolve())


def read_logged_scene(text: str, origin: str) -> Scene:
    """The scene in a log, YAML or JSON, also in the words of an earlier version."""
    return parse_scene(upgrade_scene(_mapping_of(_from_json(text, origin), origin), origin), origin)


def upgrade_scene(scene: Mapping, origin: str) -> dict:
    """The plain data of a scene in a log in today's words, from those of an earlier version."""
    mapping = _canonical(scene)
    return KINDS[_kind_of(mapping, origin)].parameters.upgraded(mapping)


def _from_json(text: str, origin: str):
    """The data in a text of JSON, or a text that is none, to be read as YAML."""
    if not text.startswith("{"):
        return text
    if len(text) > LONGEST_LOGGED or text.count(",") > MOST_LOGGED_VALUES:
        raise SceneError(f"{origin} is longer than {LONGEST_LOGGED} characters or {MOST_LOGGED_VALUES} values")
    try:
        return parse_json(text)
    except ValueError:
        return text


def _read_source(source, overrides: Iterable[str]) -> tuple[dict, str]:
    """The plain data of a scene as given, with its overrides, and where it comes from."""
    if isinstance(source, Integral) and not isinstance(source, bool):
        source = str(source)  # a designation, as YAML and columns of a table have it
    if isinstance(source, Mapping):
        text, origin = source, f"scene {source.get('name', 'without a name')}"
    elif (entry := _catalogue_scene(source)) is not None:
        text, origin = entry, f"bearing {entry['name']}"
    else:
        path = SCENES.find(source, also=catalogue_scenes)
        text, origin = SCENES.read_text(path), f"scene {path.name}"
    overrides = check_overrides(overrides)
    mapping = _canonical(_mapping_of(text, origin))
    mapping.setdefault("name", Path(origin.removeprefix("scene ")).stem)
    kind = _kind_of(mapping, origin)
    for override in overrides:
        _apply_override(KINDS[kind].parameters, mapping, override)
    shown = [shorten(override) for override in overrides[:MOST_NAMED]]
    omitted = [f"and {len(overrides) - MOST_NAMED} more"] if len(overrides) > MOST_NAMED else []
    changes = [override for override in shown if override.partition(".")[0].strip() not in UNDESCRIBED]
    if changes and isinstance(mapping.get("description"), str):
        mapping["description"] += f", with {', '.join(changes)}"
    origin = " ".join((origin, *(("with",) if overrides else ()), *shown, *omitted))
    if not isinstance(source, Mapping):  # of data all keys may stand there, whoever gave them
        raise_problems(origin, damped_twice(mapping.get("contact")))
    return mapping, origin


def _catalogue_scene(source) -> dict | None:
    """The scene that a name of the catalogue of bearings stands for; names of scene files come first."""
    if (
        not isinstance(source, str)
        or not (source.isalnum() or DESIGNATION.fullmatch(source))
        or source in SCENES.names()
    ):
        return None
    scenes = catalogue_scenes()
    if source not in scenes:  # which also reads designations that it does not list
        return None
    return scenes[source]


def _mapping_of(text_or_mapping, origin: str) -> dict:
    mapping = SCENES.load(text_or_mapping, origin) if isinstance(text_or_mapping, str) else text_or_mapping
    if not isinstance(mapping, Mapping):
        raise SceneError(f"{origin} holds no keys; start it with `kind: bearing`")
    return dict(mapping)


def _kind_of(mapping: Mapping, origin: str) -> str:
    if "kind" not in mapping:
        raise SceneError(f"{origin} has no key `kind`; legal: {', '.join(KINDS)}")
    kind = mapping["kind"]
    if not isinstance(kind, str) or kind not in KINDS:
        raise SceneError(f"{origin}: kind = {echo(kind)} is not known; {legal_hint(kind, KINDS)}")
    return kind


def _canonical(mapping: dict) -> dict:
    """The mapping with today's names of keys and values; a key under both names stays, to be refused."""
    mapping = copy.deepcopy(mapping)
    for alias, target in ALIASES.items():
        section, key = alias.split(".")
        home, name = target.split(".")
        if isinstance(mapping.get(section), dict) and key in mapping[section]:
            new = mapping.setdefault(home, {})
            if isinstance(new, dict) and name not in new:
                new[name] = mapping[section].pop(key)
    for path, values in FORMER_VALUES.items():
        section, key = path.split(".")
        home = mapping.get(section)
        if isinstance(home, dict) and isinstance(home.get(key), (str, bool)):
            home[key] = values.get(home[key], home[key])
    return mapping


def _key_explanation(kind: str):
    """A function that explains a key that a kind does not take."""
    moved = KINDS[kind].parameters.moved

    def explain(path: str) -> str | None:
        if path in moved:
            return f"{path} is not a key any more; use {moved[path]}"
        if path in ALIASES:
            return f"{path} is another name of {ALIASES[path]}, which is given too; keep one of them"
        if renamed := [f"for {old} use {moved[old]}" for old in moved if old.startswith(f"{path}.")]:
            return f"{path} is not a key any more; {'; '.join(renamed)}"
        return _keys_by_last_name(KINDS[kind].parameters, path)

    return explain


def _keys_by_last_name(parameters: type, path: str) -> str | None:
    """Keys that end in a word given without its section; None where no key does, or a section is near."""
    keys = [parameter.key for parameter in describe(parameters)]
    matches = [
        key for key in keys if "." in key and path in (key.rpartition(".")[2], *key.rpartition(".")[2].split("_"))
    ]
    if "." in path or not matches:
        return None
    matches.sort(key=lambda key: (key.count("."), not key.endswith(f".{path}")))
    return f"{path} is not a key by itself; did you mean {' or '.join(matches[:MOST_NEAR])}?"


def read_scene(text_or_mapping, origin: str) -> Scene:
    """A scene as by `parse_scene`, but neither checked nor with its automatic keys chosen (see `check_scene`)."""
    mapping = _canonical(_mapping_of(text_or_mapping, origin))
    kind = _kind_of(mapping, origin)
    del mapping["kind"]
    name = mapping.pop("name", Path(origin.removeprefix("scene ")).stem)
    description = mapping.pop("description", "")
    mapping, missing = KINDS[kind].parameters.completed(mapping)
    parameters, problems = read(KINDS[kind].parameters, mapping, _key_explanation(kind))
    problems = missing + problems
    if not isinstance(name, str) or not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        problems.append(f"name = {echo(name)} must be text of 1 to {LONGEST_NAME} characters on one line")
    if not is_text(description, LONGEST_DESCRIPTION):
        legal = f"text of at most {LONGEST_DESCRIPTION} characters, all of UTF-8"
        problems.append(f"description = {echo(description)} must be {legal}")
    raise_problems(origin, problems)
    return Scene(name, kind, description.strip(), parameters)


def _apply_override(parameters: type, mapping: dict, override: str) -> None:
    key, equals, text = override.partition("=")
    path = [name.strip() for name in key.split(".")]
    if not equals or not all(path):
        raise SceneError(f"override {echo(override)} must look like contact.normal=volumetric")
    if path[0] in ("name", "kind", "description"):
        raise SceneError(f"override {echo(override)} cannot change {path[0]}; write a scene file for that")
    path = ALIASES.get(".".join(path), ".".join(path)).split(".")
    for depth, name in enumerate(path[:-1], start=1):
        if isinstance(mapping, list):
            name = _list_index(mapping, name, override)
        inner = mapping[name] if isinstance(mapping, list) else mapping.setdefault(name, {})
        names = names_at(parameters, path[:depth])
        if isinstance(inner, str) and inner in names:
            inner = mapping[name] = plain(names[inner])
        if not isinstance(inner, (dict, list)):
            raise SceneError(f"override {echo(override)}: {name} is a value and has no keys of its own")
        mapping = inner
    last = _list_index(mapping, path[-1], override) if isinstance(mapping, list) else path[-1]
    if stands_for_section(parameters, path):
        mapping.clear()
    value = SCENES.load(text, f"override {echo(override)}")
    former = FORMER_VALUES.get(".".join(path), {})
    mapping[last] = former.get(value, value) if isinstance(value, (str, bool)) else value


def _list_index(items: list, text: str, override: str) -> int:
    """The place that a word of an override's key names in a list, counted from 0."""
    if not text.isdecimal() or int(text) >= len(items):
        legal = f"a number below {len(items)}" if items else "none, for it is empty"
        raise SceneError(f"override {echo(override)}: {echo(text)} is no place in the list; legal: {legal}")
    return int(text)


def choose(scene: Scene) -> Choice:
    """Law and stepper for a scene; raises SceneError where a bearing has no start, or a model leaves its range."""
    check_ranges(scene)
    return KINDS[scene.kind].choose(scene.parameters)._replace(outside=scene.outside)


def check_ranges(scene: Scene) -> None:
    """Raises SceneError where a specified model leaves its range, and the scene does not allow that."""
    if scene.outside and not scene.allows_invalid:
        fault = "; ".join(scene.outside)
        raise SceneError(
            f"scene {scene.name}: {fault}, or let it run all the same by --allow-invalid (solver.allow_invalid: on), "
            "which marks every output"
        )


def require_bearing(scene: Scene) -> Scene:
    """The scene of a bearing; raises SceneError for another kind."""
    if scene.kind != "bearing":
        problem = f"scene {scene.name} is no bearing but a {scene.kind}"
        raise SceneError(f"{problem}; give a designation, such as 6205, or a scene of kind bearing")
    return scene


def unreached_keys(scene: Scene, until: float) -> list[str]:
    """One sentence for each key of the scene with a time that a run of `until` [s] never comes to.

    Rows of a table count where the run ends before the row in front of them: between two it is straight.
    """
    return [
        f"{key} is beyond the end of the run at {until:g} s: nothing of that happens"
        for key in _unreached(scene.parameters, until, "")
    ]


def _unreached(section, until: float, path: str) -> Iterator[str]:
    for item in dataclasses.fields(section):
        value, key = getattr(section, item.name), f"{path}{item.name}"
        if dataclasses.is_dataclass(value):
            if item.name == "change" and value.time > until:
                yield f"{key}.time = {value.time:g} s"
            yield from _unreached(value, until, f"{key}.")
        elif item.metadata.get("columns", ())[:1] == (("time", "s"),):
            times = [row[0] for row in value]
            if unreached := sum(time >= until for time in times[:-1]):
                yield f"what {key} says after {times[-1 - unreached]:g} s"
