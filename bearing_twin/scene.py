"""Scenes: one strict SI YAML file each, read into frozen dataclasses, and back into a resolved dump."""

import dataclasses
import importlib
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar, NamedTuple

import yaml

from bearing_twin.errors import SceneError
from bearing_twin.parameters import echo, names_at, plain, raise_problems, read, unknown
from bearing_twin.paths import share_path
from bearing_twin.sample import Channel
from bearing_twin.scenes import beam_parameters, bearing_parameters, pair_parameters

GREATEST_FILE = 1_000_000  # bytes
GREATEST_DEPTH = 20
LONGEST_NAME = 100
LONGEST_DESCRIPTION = 10_000


def _as_given(parameters):
    return parameters


class Kind(NamedTuple):
    """What a scene's `kind` stands for; `module` (imported when needed: it compiles) has `channels(parameters)`.

    `resolve` replaces what a checked scene leaves to be chosen, once, so that all who read it see the same numbers.
    """

    parameters: type
    check: Callable[[Any], list[str]]
    module: str
    resolve: Callable[[Any], Any] = _as_given


KINDS = {
    "bearing": Kind(
        bearing_parameters.BearingScene,
        bearing_parameters.check,
        "bearing_twin.scenes.bearing_outputs",
        bearing_parameters.resolve,
    ),
    "two_spheres": Kind(
        pair_parameters.TwoSpheresScene,
        pair_parameters.check_spheres,
        "bearing_twin.scenes.two_spheres",
        pair_parameters.resolve,
    ),
    "two_discs": Kind(
        pair_parameters.TwoDiscsScene,
        pair_parameters.check_discs,
        "bearing_twin.scenes.two_discs",
        pair_parameters.resolve,
    ),
    "sphere_on_beam": Kind(
        beam_parameters.SphereOnBeamScene,
        beam_parameters.check_beam,
        "bearing_twin.scenes.sphere_on_beam",
        beam_parameters.resolve,
    ),
}


@dataclass(frozen=True)
class Scene:
    """A scene, complete and checked: `parameters` is the dataclass of its `kind`, all SI."""

    name: str
    kind: str
    description: str
    parameters: Any

    @property
    def model(self) -> ModuleType:
        """The module of this scene's kind: its channels, wrenches and contact details."""
        return importlib.import_module(KINDS[self.kind].module)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What one sample of this scene holds, in order."""
        return tuple(self.model.channels(self.parameters))

    def resolved(self) -> dict:
        """All keys with defaults filled in, as plain data; `parse_scene` of its YAML gives an equal scene."""
        head = {"name": self.name, "kind": self.kind, "description": self.description}
        return head | plain(self.parameters)


def scene_names() -> list[str]:
    """Names of the scenes that come with the package, sorted."""
    return sorted(path.stem for path in Path(share_path("config", "scenes")).glob("*.yaml"))


def load_scene(name_or_path, overrides: Iterable[str] = ()) -> Scene:
    """The scene of that name or YAML file, with overrides such as `contact.normal=volumetric`; raises SceneError."""
    path = _find(name_or_path)
    overrides = tuple(overrides)
    scene = _parse(_read_text(path), f"scene {path.name}")
    if not overrides:
        return _resolve(scene)
    mapping = scene.resolved()
    for override in overrides:
        _apply(KINDS[scene.kind].parameters, mapping, override)
    return parse_scene(mapping, f"scene {path.name} with {' '.join(overrides)}")


def parse_scene(text_or_mapping, origin: str) -> Scene:
    """The scene in a YAML text or a mapping; `origin` names it in errors and, without a `name` key, is its name."""
    return _resolve(_parse(text_or_mapping, origin))


def _resolve(scene: Scene) -> Scene:
    return dataclasses.replace(scene, parameters=KINDS[scene.kind].resolve(scene.parameters))


def _parse(text_or_mapping, origin: str) -> Scene:
    """The scene as given, checked, with what it leaves to be chosen still open: overrides come before choices."""
    mapping = _load_yaml(text_or_mapping, origin) if isinstance(text_or_mapping, str) else text_or_mapping
    if not isinstance(mapping, Mapping):
        raise SceneError(f"{origin} holds no keys; start it with `kind: bearing`")
    mapping = dict(mapping)
    if "kind" not in mapping:
        raise SceneError(f"{origin} has no key `kind`; legal: {', '.join(KINDS)}")
    kind = mapping.pop("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        raise SceneError(f"{origin}: kind = {echo(kind)} is not known; {unknown(kind, KINDS)}")
    name = mapping.pop("name", Path(origin.removeprefix("scene ")).stem)
    description = mapping.pop("description", "")
    parameters, problems = read(KINDS[kind].parameters, mapping)
    if not isinstance(name, str) or not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        problems.append(f"name = {echo(name)} must be text of 1 to {LONGEST_NAME} characters on one line")
    if not isinstance(description, str) or len(description) > LONGEST_DESCRIPTION:
        problems.append(f"description = {echo(description)} must be text of at most {LONGEST_DESCRIPTION} characters")
    raise_problems(origin, problems)
    raise_problems(origin, KINDS[kind].check(parameters))
    return Scene(name, kind, description.strip(), parameters)


def _find(name_or_path) -> Path:
    text = str(name_or_path)
    named = re.fullmatch(r"[\w-]+", text)
    if named and text in scene_names():
        return Path(share_path("config", "scenes", f"{text}.yaml"))
    path = Path(text)
    looks_like_a_path = (
        isinstance(name_or_path, Path) or "/" in text or "\\" in text or text.endswith((".yaml", ".yml"))
    )
    try:
        if path.is_dir() and looks_like_a_path:
            raise SceneError(
                f"{echo(text)} is a directory; give a scene file in it, or a name: {', '.join(scene_names())}"
            )
        if path.exists() and not path.is_dir():
            return path
    except (OSError, ValueError):  # too long, or a null byte
        pass
    if looks_like_a_path:
        raise SceneError(
            f"there is no scene file {echo(text)}; give the path of one, or a name: {', '.join(scene_names())}"
        )
    raise SceneError(f"there is no scene {echo(text)}; {unknown(text, scene_names())}, or the path of a YAML file")


def _read_text(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            content = stream.read(GREATEST_FILE + 1)
    except OSError as error:
        raise SceneError(f"{path} cannot be read ({error.strerror}); check its permissions") from error
    if len(content) > GREATEST_FILE:
        raise SceneError(f"{path} is larger than {GREATEST_FILE} bytes, so it is no scene; give a YAML file")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"{path} is not UTF-8 text; give a YAML file") from error
    if "\0" in text:
        raise SceneError(f"{path} is a binary file; give a YAML file")
    return text


def _apply(parameters: type, mapping: dict, override: str) -> None:
    key, equals, text = override.partition("=")
    words = [word.strip() for word in key.split(".")]
    if not equals or not all(words):
        raise SceneError(f"override {echo(override)} must look like contact.normal=volumetric")
    if words[0] in ("name", "kind", "description"):
        raise SceneError(f"override {echo(override)} cannot change {words[0]}; write a scene file for that")
    for depth, word in enumerate(words[:-1], start=1):
        inner = mapping.setdefault(word, {})
        names = names_at(parameters, words[:depth])
        if isinstance(inner, str) and inner in names:
            inner = mapping[word] = plain(names[inner])
        if not isinstance(inner, dict):
            raise SceneError(f"override {echo(override)}: {word} is a value and has no keys of its own")
        mapping = inner
    mapping[words[-1]] = _load_yaml(text, f"override {echo(override)}")


class _StrictLoader(yaml.SafeLoader):
    """YAML without what surprises: no aliases, merges, duplicate keys, deep nesting, 010 = 8, 1:30 = 90, yes = true."""

    yaml_implicit_resolvers: ClassVar[dict] = {}
    depth = 0

    def compose_node(self, parent, index):
        if self.check_event(yaml.AliasEvent):
            raise yaml.composer.ComposerError(None, None, "aliases are not allowed", self.peek_event().start_mark)
        self.depth += 1
        if self.depth > GREATEST_DEPTH:
            problem = f"it is nested deeper than {GREATEST_DEPTH} levels"
            raise yaml.composer.ComposerError(None, None, problem, self.peek_event().start_mark)
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise yaml.constructor.ConstructorError(None, None, "a key must be a word", key.start_mark)
            if key.value in seen:
                problem = f"the key {echo(key.value)} is there twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


def _implicit(tag: str, pattern: str, first: str) -> None:
    _StrictLoader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(pattern), list(first) if first else [""])


_implicit("bool", r"^(?:true|True|TRUE|false|False|FALSE)$", "tTfF")
_implicit("int", r"^[-+]?(?:0|[1-9][0-9]{0,17})$", "-+0123456789")
_implicit("float", r"^[-+]?(?:[0-9]{1,64}\.[0-9]{0,64}(?:[eE][-+][0-9]{1,4})?)$", "-+0123456789")
_implicit("float", r"^[-+]?\.(?:inf|Inf|INF|nan|NaN|NAN)$", "-+.")
_implicit("null", r"^(?:~|null|Null|NULL)$", "~nN")
_implicit("null", r"^$", "")


def _load_yaml(text: str, origin: str):
    try:
        return yaml.load(text, Loader=_StrictLoader)
    except yaml.YAMLError as error:
        problem = getattr(error, "problem", None) or getattr(error, "reason", None) or "it cannot be parsed"
        if problem.startswith("but") and getattr(error, "context", None):
            problem = f"{error.context}, {problem}"
        mark = getattr(error, "problem_mark", None)
        place = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        raise SceneError(f"{origin} is not the YAML of a scene: {problem}{place}") from error
    except (ValueError, RecursionError) as error:
        raise SceneError(f"{origin} is not the YAML of a scene: {error}") from error
