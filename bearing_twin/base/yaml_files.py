"""The YAML files that come with the package, one folder of `config/` a kind, and the strict way they are read."""

import contextlib
import copy
import functools
import os
import re
import stat
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import yaml

from bearing_twin.base.errors import SceneError, StudyError, did_you_mean, echo, legal_hint, nearest
from bearing_twin.base.paths import READABLE, share_path, user_folder

GREATEST_FILE = 128_000  # bytes
LONGEST_CACHED = 10_000  # characters of a text whose data are kept
MOST_VALUES = 20_000  # of a file, groups counted too: half a second to read
GREATEST_DEPTH = 20
LONGEST_NAME = 100
LONGEST_DESCRIPTION = 10_000
SUFFIXES = (".yaml", ".yml")
_FIRST_GROUP = re.compile(r"^[\w.]+:[ \t]*(?:#.*)?$", re.MULTILINE)  # a key whose value follows on lines below


class FileKind(NamedTuple):
    """A kind of file: its name ("scene"), its folder in `config/`, and the class of the errors it raises."""

    noun: str
    folder: str
    error: type[Exception]

    def names(self) -> list[str]:
        """Names of the files that come with the package, sorted."""
        return sorted(path.stem for path in Path(share_path("config", self.folder)).glob("*.yaml"))

    def headers(self) -> Iterator[dict]:
        """Name and keys before the first group, unchecked, of each file that comes with the package.

        This is far quicker than reading whole files, which may be long.
        """
        for name in self.names():
            text = self.read_text(Path(share_path("config", self.folder, f"{name}.yaml")))
            end = _FIRST_GROUP.search(text)
            yield {"name": name, "description": "", **self.load(text[: end.start()] if end else text, name)}

    def load_all(self) -> Iterator[tuple[Any, str]]:
        """(plain data, origin) of each file that comes with the package, then of those of the user's own folder."""
        for path in sorted(Path(share_path("config", self.folder)).glob("*.yaml")) + self.user_files():
            yield self.load(self.read_text(path), str(path)), str(path)

    def user_files(self) -> list[Path]:
        """The user's own files of this kind, in `user_folder`, sorted."""
        return sorted(path for path in user_folder(self.folder).glob("*.y*ml") if path.suffix in SUFFIXES)

    def find(self, name_or_path, also: Callable[[], Iterable[str]] = tuple) -> Path:
        """The file of that name or path; raises `error` with the nearest name, or the nearest of `also()` if any is."""
        text = str(name_or_path)
        if re.fullmatch(r"[\w-]+", text) and text in self.names():
            return Path(share_path("config", self.folder, f"{text}.yaml"))
        path = Path(text)
        looks_like_a_path = isinstance(name_or_path, Path) or "/" in text or "\\" in text or text.endswith(SUFFIXES)
        if looks_like_a_path and READABLE.get() is not None:
            return self._permitted(text)
        try:
            if path.is_dir() and looks_like_a_path:
                raise self.error(f"{echo(text)} is a directory; give a {self.noun} file in it, or a name")
            if READABLE.get() is None and path.exists() and not path.is_dir():
                return path
        except (OSError, ValueError):  # too long, or a null byte
            pass
        if looks_like_a_path:
            hint = did_you_mean(path.stem, self.names())
            raise self.error(f"there is no {self.noun} file {echo(text)}; {hint}give the path of one, or a name")
        designation, near = text.rpartition("_")[2], nearest(text, self.names())
        if designation in (further_names := list(also())) and not any(designation in name for name in near):
            raise self.error(f"there is no {self.noun} {echo(text)}; did you mean {designation}, by its designation?")
        hint = did_you_mean(text, further_names)
        if not near and further_names and (hint or text[:1].isdigit()):
            catalogue = "`bearing_twin bearing --list` has the catalogue"
            raise self.error(f"there is no bearing or {self.noun} {echo(text)}; {hint}{catalogue}")
        for file_kind in (SCENES, STUDIES):
            if text in file_kind.names():
                raise self.error(f"{echo(text)} is a {file_kind.noun}, not a {self.noun}; {USED[file_kind.noun]}")
        hint = legal_hint(text, self.names())
        raise self.error(f"there is no {self.noun} {echo(text)}; {hint}, or the path of a YAML file")

    def _permitted(self, text: str) -> Path:
        """The file of that path if it may be read on behalf of peers; else raises `error`, always in the same words."""
        folders, called = READABLE.get()
        for folder in folders:
            with contextlib.suppress(OSError, ValueError):  # not there, too long, or a null byte
                path = Path(os.path.realpath(folder / text))
                if folder in path.parents and path.suffix in SUFFIXES and stat.S_ISREG(os.lstat(path).st_mode):
                    return path
        raise self.error(
            f"{echo(text)} is no {self.noun} file that may be read for this; give the {self.noun} itself as YAML, "
            f"a file below {called}, or a name: {', '.join(self.names())}"
        )

    def read_text(self, path: Path) -> str:
        """The file's text; raises `error` for a file that is none of text."""
        try:
            if path.is_fifo():  # it may never be written to
                raise self.error(f"{path} is a pipe; give the path of a file")
            with path.open("rb") as stream:
                content = stream.read(GREATEST_FILE + 1)
        except OSError as error:
            raise self.error(f"{path} cannot be read ({error.strerror}); check its permissions") from error
        if path.suffix == ".mcap":
            raise self.error(f"{path} is a log, no {self.noun}; verify, report, view, export or replay it")
        if len(content) > GREATEST_FILE:
            raise self.error(f"{path} is larger than {GREATEST_FILE} bytes, so it is no {self.noun}; give a YAML file")
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise self.error(f"{path} is not UTF-8 text; give a YAML file") from error
        if "\0" in text:
            raise self.error(f"{path} is a binary file; give a YAML file")
        return text

    def load(self, text: str, origin: str):
        """The plain data in a YAML text; raises `error` with line and column."""
        if len(text) > GREATEST_FILE:
            raise self.error(f"{origin} is longer than {GREATEST_FILE} characters, so it is no {self.noun}")
        try:
            return copy.deepcopy(_parsed(text)) if len(text) < LONGEST_CACHED else yaml.load(text, Loader=_StrictLoader)
        except yaml.YAMLError as error:
            problem = getattr(error, "problem", None) or getattr(error, "reason", None) or "it cannot be parsed"
            if problem.startswith("but") and getattr(error, "context", None):
                problem = f"{error.context}, {problem}"
            mark = getattr(error, "problem_mark", None)
            position = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
            raise self.error(f"{origin} is not the YAML of a {self.noun}: {problem}{position}") from error
        except (ValueError, RecursionError) as error:
            raise self.error(f"{origin} is not the YAML of a {self.noun}: {error}") from error


SCENES = FileKind("scene", "scenes", SceneError)
STUDIES = FileKind("study", "studies", StudyError)
USED = {
    "scene": "`bearing_twin simulate` runs it, and a study names it by its key `scene`",
    "study": "`bearing_twin study` runs it",
}
BEARINGS = FileKind("bearing table", "bearings", SceneError)


class _StrictLoader(yaml.SafeLoader):
    """YAML without aliases, merges, duplicate keys, deep nesting, and without 010 = 8, 1:30 = 90, yes = true."""

    yaml_implicit_resolvers: ClassVar[dict] = {}
    depth = values = 0

    def compose_node(self, parent, index):
        self.depth += 1
        self.values += 1
        problem = ""
        if self.check_event(yaml.AliasEvent):
            problem = "aliases are not allowed"
        elif self.depth > GREATEST_DEPTH:
            problem = f"it is nested deeper than {GREATEST_DEPTH} levels"
        elif self.values > MOST_VALUES:
            problem = f"it holds more than {MOST_VALUES} values; a long table belongs into a CSV file"
        if problem:
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


@functools.lru_cache(maxsize=256)
def _parsed(text: str):
    """The plain data in a YAML text, cached: a node may read the same study many times, 10 ms each time."""
    return yaml.load(text, Loader=_StrictLoader)


def _implicit(tag: str, pattern: str, first: str) -> None:
    _StrictLoader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(pattern), list(first) if first else [""])


_implicit("bool", r"^(?:true|True|TRUE|false|False|FALSE)$", "tTfF")
_implicit("int", r"^[-+]?(?:0|[1-9][0-9]{0,17})$", "-+0123456789")
_implicit("float", r"^[-+]?(?:[0-9]{1,64}\.[0-9]{0,64}(?:[eE][-+][0-9]{1,4})?)$", "-+0123456789")
_implicit("float", r"^[-+]?\.(?:inf|Inf|INF|nan|NaN|NAN)$", "-+.")
_implicit("null", r"^(?:~|null|Null|NULL)$", "~nN")
_implicit("null", r"^$", "")
