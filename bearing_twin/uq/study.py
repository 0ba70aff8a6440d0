"""Studies: a scene, the distributions of its uncertain numbers, the requested quantities, and when sampling ends."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import contextlib
import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from scipy.stats.distributions import rv_frozen

from bearing_twin.base.errors import SceneError, StudyError, is_text
from bearing_twin.base.parameters import choice, echo, legal_hint, plain, quantity, read, section, text
from bearing_twin.base.units import si_value
from bearing_twin.base.yaml_files import LONGEST_DESCRIPTION, LONGEST_NAME, STUDIES
from bearing_twin.kinds import KINDS
from bearing_twin.run.scene import Scene, check_overrides, open_scene, parse_scene
from bearing_twin.uq.distributions import as_mapping
from bearing_twin.uq.inputs import (
    Input,
    Joint,
    checked_key,
    first_name,
    numeric_keys,
    placed,
    put,
    quantities_of,
    quantity_of,
    read_input,
    value_at,
)
from bearing_twin.uq.sampling import GREATEST_SAMPLES, GREATEST_SEED, REPLICATES, SAMPLERS, rounded

PROPAGATION_METHODS = ("auto", "change_of_variable", "ensemble", "chaos")
STATISTICS = ("mean", "std", "quantile")


# When an ensemble is large enough: the 95 % interval of a named statistic, checked in batches, twice in a row.
#
# Checking often and stopping at the first narrow interval favours lucky checks: the interval at such a moment covers
# less than 95 %. Against that (1) there is a least number of samples before the first check, (2) checks are spaced by a
# batch, later by a fifth of the samples so far, and (3) the interval must be narrow at two checks in a row. They are at
# the same numbers of samples whatever the number of workers, and whether a study was continued or not.

GROWTH = 0.2  # of the samples so far, between later checks
IN_A_ROW = 2


@dataclass(frozen=True)
class Stop:
    """When the ensemble is large enough; without a tolerance it takes all its samples."""

    statistic: str = choice("mean", STATISTICS, "whose 95 % interval must become narrow")
    probability: float = quantity(0.95, "1", "of the quantile, for statistic: quantile", above=0.0, below=1.0)
    tolerance: float = quantity(0.0, "its unit", "greatest half width of the interval; 0 = none", at_least=0.0)
    relative_tolerance: float = quantity(0.0, "1", "the same as a share of the statistic; 0 = none", at_least=0.0)
    minimum: int = quantity(200, "1", "samples before the first check", at_least=2)
    quantity: str = text("", "whose statistic; the first of quantities unless said")

    @property
    def of(self) -> str | float:
        """The statistic as `statistics.estimate` takes it."""
        return self.probability if self.statistic == "quantile" else self.statistic

    @property
    def watched(self) -> str:
        """The statistic and its quantity in words: `std of contact_duration`."""
        return f"{f'{self.of:g} quantile' if self.statistic == 'quantile' else self.of} of {self.quantity}"

    def satisfied(self, estimate: float, half_width: float) -> bool:
        """True for an interval that is narrow enough; never without a tolerance, or for a NaN."""
        bound = max(self.tolerance, self.relative_tolerance * abs(estimate))
        return bool(self.tolerance or self.relative_tolerance) and half_width <= bound

    def text(self) -> str:
        """The rule in words, for reports."""
        bound = f"{self.tolerance:g}" if self.tolerance else f"{100.0 * self.relative_tolerance:g} % of it"
        return f"the half width of the 95 % interval of the {self.watched} is at most {bound}"


def checkpoints(samples: int, batch: int, minimum: int, sampler: str) -> Iterator[int]:
    """Increasing numbers of samples at which the stop rule is checked; the last is `samples`.

    Interleaved Sobol sequences are balanced only at REPLICATES times a power of two; a latin hypercube is one sample of
    its whole size.
    """
    size = {"sobol": REPLICATES, "random": batch}.get(sampler, samples)
    while size < samples:
        if size >= minimum:
            yield size
        size += size if sampler == "sobol" else batch * max(1, round(GROWTH * size / batch))
    yield samples


@dataclass(frozen=True)
class Settings:
    """The keys of a study that are plain numbers and words."""

    method: str = choice("auto", PROPAGATION_METHODS, "auto = change of variable where it applies, else ensemble")
    sampler: str = choice("random", tuple(SAMPLERS), "where the unit cube is sampled")
    samples: int = quantity(2000, "1", "realisations, at most", at_least=1, at_most=GREATEST_SAMPLES)
    seed: int = quantity(1, "1", "of every random choice", at_least=0, at_most=GREATEST_SEED)
    batch: int = quantity(100, "1", "samples between checks of the convergence", at_least=1, at_most=1_000_000)
    workers: int = quantity(0, "1", "processes that simulate; 0 = one a processor", at_least=0, at_most=512)
    memory: float = quantity(2e9, "B", "refuse a study that needs more", above=0.0)
    history_points: int = quantity(200, "1", "instants of each history", at_least=2, at_most=100_000)
    history_duration: float = quantity(
        0.0, "s", "of histories, and then of every run; 0 = that of the scene at its median inputs", at_least=0.0
    )
    degree: int = quantity(0, "1", "of polynomial chaos; 0 = until its error is 1e-4", at_least=0, at_most=12)
    modality: str = choice("yes", ("yes", "no"), "whether modes are counted, with a bootstrap")
    sensitivity: int = quantity(
        0, "1", "rows of (inputs + 2) further samples for Sobol indices; 0 = none", at_least=0, at_most=50_000
    )
    checks: int = quantity(
        5,
        "1",
        "realisations that a second run checks, for the error of the model; 0 = none",
        at_least=0,
        at_most=1000,
    )
    stop: Stop = section(Stop)


@dataclass(frozen=True)
class Study:
    """A study, complete and checked.

    `scene` is the scene's plain data with automatic choices still open; `given` maps each input's key to its
    distribution as in the file, `targets` are for each input the keys of the scene that take its value; `joint` draws
    them.
    """

    name: str
    description: str
    scene: dict
    given: dict
    targets: tuple[tuple[str, ...], ...] = field(compare=False)
    correlation: tuple[tuple[str, str, float], ...]
    quantities: tuple[str, ...]
    histories: tuple[str, ...]
    sweep: tuple[str, tuple[float, ...]] | None
    executor: str
    settings: Settings
    joint: Joint = field(compare=False, repr=False)

    @property
    def kind(self) -> str:
        """Kind of the scene."""
        return self.scene["kind"]

    @property
    def inputs(self) -> tuple[Input, ...]:
        """The uncertain inputs, in the order of the file."""
        return self.joint.inputs

    @property
    def sensitivity_rows(self) -> int:
        """Rows of (inputs + 2) further samples for Sobol indices, as many as the sampler needs."""
        rows = self.settings.sensitivity
        return rounded(self.settings.sampler, rows) if rows else 0

    @property
    def medians(self) -> list[float]:
        """The medians of the inputs."""
        return [float(one.ppf(0.5)) for one in self.inputs]

    @property
    def quantity_units(self) -> dict[str, str]:
        """Unit of each quantity by its name."""
        return {name: quantity_of(self.kind, name).unit for name in self.quantities}

    def scene_at(self, values: Iterable[float]) -> Scene:
        """The scene with these values of the inputs; raises SceneError where there is none."""
        return parse_scene(placed(self.scene, self.targets, values), "a realisation")

    def at(self, value: float) -> "Study":
        """The study at one value of its sweep, without histories and the count of modes."""
        settings = dataclasses.replace(self.settings, modality="no")
        scene = put(self.scene, self.sweep[0], value)
        return dataclasses.replace(self, scene=scene, sweep=None, histories=(), settings=settings)

    def resolved(self) -> dict:
        """All keys as plain data, the scene in full; `parse_study` of it gives an equal study."""
        return {
            "name": self.name,
            "description": self.description,
            "scene": self.scene,
            "inputs": self.given,
            "correlation": [list(row) for row in self.correlation],
            "quantities": list(self.quantities),
            "histories": list(self.histories),
            **({"sweep": {self.sweep[0]: list(self.sweep[1])}} if self.sweep else {}),
            "executor": self.executor,
            **plain(self.settings),
        }


# Study files: strict YAML in, a checked `Study` out; a problem of each key is named, with the nearest legal word.

IMPOSSIBLE = 1e-12  # probability of values outside what a scene allows that is neglected
FREE_KEYS = (
    "name", "description", "scene", "set", "inputs", "correlation", "quantities", "histories", "sweep",
    "executor",
)  # fmt: skip
SETTINGS = tuple(item.name for item in dataclasses.fields(Settings))
GREATEST_SWEEP = 1000
OTHER_NAMES = {"companions": "checks"}  # keys of earlier versions
GONE = {
    "densities": "densities was removed; estimate them from result.sample(quantity), as by scipy.stats.gaussian_kde",
    "time_limit": "time_limit was removed; end the study by Ctrl-C, as `timeout -s INT 60 bearing_twin study ...` does",
}


def study_names() -> list[str]:
    """Names of the studies that come with the package, sorted."""
    return STUDIES.names()


def load_study(name_or_path: str | PathLike | Mapping, overrides: Iterable[str] = ()) -> Study:
    """A study by its name, its file or its plain data, checked and complete.

    Parameters
    ----------
    name_or_path : str, path or mapping
        Name of a shipped study, path of a YAML file, or the keys of a study.
    overrides : list of str
        Such as `samples=500`, `stop.tolerance=1e-7`, `inputs.<key>.std=4e-5`, or a key of the scene:
        `motion.first_velocity=50`.

    Returns
    -------
    Study
        For `run_study`.

    Raises
    ------
    StudyError
        Naming every problem.
    """
    if isinstance(name_or_path, Mapping):
        return parse_study(name_or_path, f"study {name_or_path.get('name', 'without a name')}", overrides)
    path = STUDIES.find(name_or_path)
    return parse_study(STUDIES.read_text(path), f"study {path.name}", overrides)


def parse_study(text_or_mapping: str | Mapping, origin: str, overrides: Iterable[str] = ()) -> Study:
    """The study in a YAML text or a mapping.

    Parameters
    ----------
    text_or_mapping : str or mapping
        The keys of a study.
    origin : str
        Names the text in errors; without a key `name` it is the name of the study.
    overrides : list of str
        As for `load_study`.

    Returns
    -------
    Study
        As by `load_study`.

    Raises
    ------
    StudyError
        Naming every problem.
    """
    mapping = STUDIES.load(text_or_mapping, origin) if isinstance(text_or_mapping, str) else text_or_mapping
    if not isinstance(mapping, Mapping) or "scene" not in mapping:
        raise StudyError(f"{origin} has no key `scene`; start it with `scene: two_spheres` or another scene")
    mapping, problems = dict(mapping), _Problems()
    try:
        for word in ("inputs", "sweep"):
            if isinstance(mapping.get(word), Mapping):
                mapping[word] = _by_first_names(word, mapping[word])
        for other, first in OTHER_NAMES.items():
            if other in mapping and first in mapping:
                raise StudyError(f"{other} is another name of {first}, which is given too; keep one of them")
            if other in mapping:
                mapping[first] = mapping.pop(other)
        study = _read(mapping, *_overridden(mapping, check_overrides(overrides)), origin, problems)
    except (SceneError, StudyError) as error:
        if not problems:
            raise StudyError(f"{origin}: {error}") from error
    if len(problems) == 1:
        raise StudyError(f"{origin}: {problems[0]}")
    if problems:
        raise StudyError(f"{origin} has {len(problems)} problems:\n" + "\n".join(f"  {one}" for one in problems))
    return study


class _Problems(list):
    """Problems of a study, one sentence each."""

    def of(self, read: Callable, default: Any, *given) -> Any:
        """The value that `read` returns; the default where it raises, whose reason is kept."""
        try:
            return read(*given)
        except (SceneError, StudyError) as error:
            self.append(str(error))
            return default


def _require(condition, reason: str) -> None:
    if not condition:
        raise StudyError(reason)


def _by_first_names(word: str, given: Mapping) -> dict:
    """A mapping of keys by their first names; raises StudyError where one key is given by both of its names."""
    found = {}
    for key, value in given.items():
        _require(
            (first := first_name(key)) not in found,
            f"{word}: {key} is another name of a key that is given too; keep one of them",
        )
        found[first] = value
    return found


def _overridden(mapping: dict, overrides) -> tuple[dict, str]:
    """The scene's plain data and its name in errors; overrides of the study change `mapping`.

    An override belongs to the study or to the scene by its first word; one that names another scene comes first.
    """
    of_study, words = (*FREE_KEYS, *SETTINGS, *OTHER_NAMES), {}
    for override in overrides:
        key, equals, _ = override.partition("=")
        words[override] = key.partition(".")[0].strip()
        _require(
            equals and words[override],
            f"override {echo(override)} must look like samples=500 or motion.first_velocity=50",
        )
        if words[override] in ("scene", "set"):
            _apply(mapping, None, override)
    legal = (*of_study, *_open(mapping, ())[0])
    for override, word in words.items():
        if word in GONE:
            raise StudyError(GONE[word])
        if word not in legal:
            hint = legal_hint(word, legal)
            raise StudyError(f"override {echo(override)}: {echo(word)} is no key of the study or its scene; {hint}")
    opened = _open(mapping, [one for one, word in words.items() if word not in of_study])
    for override, word in words.items():
        if word in of_study and word not in ("scene", "set"):
            _apply(mapping, opened[0]["kind"], override)
    return opened


def _open(mapping, for_scene) -> tuple[dict, str]:
    """(plain data of the scene, its name in errors); its inputs are not put in, so it may be impossible without."""
    given, changes = mapping["scene"], mapping.get("set", [])
    _require(
        isinstance(changes, (list, tuple)) and all(isinstance(one, str) for one in changes),
        f"set = {echo(changes)} must be a list of texts such as motion.first_velocity=50",
    )
    changed = [first_name(one.partition("=")[0].strip()) for one in changes]
    if twice := {key for key in changed if changed.count(key) > 1}:
        raise StudyError(f"set gives {min(twice)} twice; keep one of them")
    _require(
        isinstance(given, (str, int, Mapping)) and not isinstance(given, bool),
        f"scene = {echo(given)} must be the name of a scene, a path, or a scene's keys and values",
    )
    overridden = {first_name(one.partition("=")[0].strip()) for one in for_scene}
    kept = [one for one, key in zip(changes, changed, strict=True) if key not in overridden]
    return open_scene(given, (*kept, *for_scene))


def _apply(mapping, kind, override):
    key, _, text = override.partition("=")
    words = key.strip().split(".")
    words[0] = OTHER_NAMES.get(words[0], words[0])
    if words[0] == "inputs" and len(words) > 1:
        known = numeric_keys(kind)
        rest = first_name(key.strip().partition(".")[2])
        inner = max((one for one in known if rest == one or rest.startswith(f"{one}.")), key=len, default=None)
        if inner is None:
            raise StudyError(
                f"override {echo(override)}: {echo(rest)} is no number of the scene; {legal_hint(rest, known)}"
            )
        words = ["inputs", inner, *(rest[len(inner) + 1 :].split(".") if rest != inner else ())]
    holder = mapping
    for word in words[:-1]:
        inner = holder.get(word, {})
        _require(isinstance(inner, Mapping), f"override {echo(override)}: {word} is a value and has no keys of its own")
        holder[word] = holder = dict(inner)
    holder[words[-1]] = STUDIES.load(text, f"override {echo(override)}")


def _read(mapping, scene, scene_origin, origin, problems: _Problems) -> Study:
    """The study; what is wrong is added to `problems`, and then the result is not to be used."""
    kind, legal = scene["kind"], (*FREE_KEYS, *SETTINGS)
    problems += [
        GONE.get(key) or f"{echo(key)} is not a key of a study; {legal_hint(key, legal)}"
        for key in mapping
        if key not in legal
    ]
    settings, found = read(Settings, {key: mapping[key] for key in SETTINGS if key in mapping})
    problems += found
    if settings.method == "chaos" and mapping.get("histories"):
        problems.append("histories are sampled, which the method chaos does not do; leave them out, or use ensemble")
    if settings.stop.tolerance and settings.stop.relative_tolerance:
        problems.append("stop.tolerance and stop.relative_tolerance say the same thing twice; keep one")

    inputs, given, targets = [], {}, []
    table = problems.of(_table, {}, mapping.get("inputs"))
    for key, value in table.items():
        if (one := problems.of(_input, None, kind, key, value, [key for keys in targets for key in keys])) is not None:
            inputs.append(one[0])
            given[key] = one[1]
            targets.append(one[2])
    correlation = problems.of(_correlation, (), mapping.get("correlation", ()))
    joint, sweep = problems.of(Joint, None, inputs, correlation), mapping.get("sweep")
    if joint and not joint.independent and settings.sensitivity:
        problems.append("sensitivity is for independent inputs; leave it or the correlation out")
    at_medians = placed(scene, targets, [float(one.ppf(0.5)) for one in inputs])
    for key, values in sweep.items() if isinstance(sweep, Mapping) else ():
        with contextlib.suppress(StudyError, LookupError, TypeError):
            at_medians = put(at_medians, checked_key(kind, key), values[0])
    possible = parse_scene(at_medians, scene_origin)
    try:
        parse_scene(scene, scene_origin)
    except SceneError:  # it lacks a number that an input or the sweep gives
        scene = at_medians

    quantities = problems.of(_quantities, (), mapping.get("quantities"), kind)
    for name in quantities:
        problems.of(_quantity, None, name, kind, possible.parameters)
    stop = (
        settings.stop
        if settings.stop.quantity
        else dataclasses.replace(settings.stop, quantity="".join(quantities[:1]))
    )
    if stop.quantity not in quantities and quantities:
        hint = legal_hint(stop.quantity, quantities)
        problems.append(f"stop.quantity = {echo(stop.quantity)} is not among the study's quantities; {hint}")
    executor = mapping.get("executor", "processes")
    if not isinstance(executor, str) or (executor != "processes" and not executor.startswith("dask://")):
        problems.append(f"executor = {echo(executor)} must be processes, or dask://host:port of a Dask scheduler")
    name = mapping.get("name", origin.removeprefix("study ").removesuffix(".yaml"))
    return Study(
        problems.of(_text, "", name, "name", LONGEST_NAME),
        problems.of(_text, "", mapping.get("description", ""), "description", LONGEST_DESCRIPTION).strip(),
        scene,
        given,
        tuple(targets),
        correlation,
        quantities,
        problems.of(_histories, (), mapping.get("histories", ()), possible),
        problems.of(_sweep, None, sweep, at_medians, targets),
        executor,
        dataclasses.replace(settings, stop=stop),
        joint,
    )


def _table(given) -> Mapping:
    _require(isinstance(given, Mapping) and given, "inputs must map keys of the scene to distributions, one at least")
    return given


def _input(kind: str, key: str, given, taken) -> tuple[Input, Any, tuple[str, ...]]:
    """(the input, its distribution as plain data, keys that take its value); `taken` by inputs before it."""
    checked_key(kind, key)
    frozen, more = given, ()
    if isinstance(given, Mapping):
        frozen, more = given.get("distribution"), given.get("also", ())
        more = (more,) if isinstance(more, str) else more
        _require(
            isinstance(more, (list, tuple)),
            f"input {key}: also = {echo(more)} must be a list of further keys that take the same value",
        )
        given = {word: value for word, value in given.items() if word != "also"}
    if isinstance(frozen, rv_frozen):
        try:
            given = {**(given if isinstance(given, Mapping) else {}), **as_mapping(frozen)}
        except StudyError as error:
            raise StudyError(f"input {key}: {error}") from None
    given = _in_si(given, numeric_keys(kind)[key].unit)
    targets = (key, *(checked_key(kind, one) for one in more))
    one = read_input(key, given)
    for place, target in enumerate(targets):
        _require(target not in (*taken, *targets[:place]), f"input {key}: {target} already follows an input")
        _check_support(kind, target, one)
    return one, {**given, "also": list(targets[1:])} if more else given, targets


IN_THE_INPUTS_UNIT = "low", "high", "mean", "std", "mode", "value", "values", "x", "loc", "scale", "know"


def _in_si(given, unit: str):
    """The specification of an input, with texts such as 5um in SI; but no deviation of a temperature."""
    if isinstance(given, str):
        value = si_value(given, unit)
        return given if value is None else value
    if isinstance(given, Mapping):
        words = [word for word in IN_THE_INPUTS_UNIT if not (word == "std" and unit == "K")]
        return {word: _in_si(one, unit) if word in words else one for word, one in given.items()}
    return [_in_si(one, unit) for one in given] if isinstance(given, (list, tuple)) else given


def _check_support(kind: str, key: str, one: Input) -> None:
    """Raises StudyError where the input takes values that the scene forbids with a probability above IMPOSSIBLE."""
    row = numeric_keys(kind)[key]
    _require(
        row.type != "integer" or one.whole,
        f"input {key} takes whole numbers; give it the distribution fixed, discrete or empirical with such values",
    )
    limits = row.bounds.without_sizes
    if one.has_density:
        low = next((end for end in (limits.above, limits.at_least) if end is not None), -np.inf)
        high = next((end for end in (limits.below, limits.at_most) if end is not None), np.inf)
        outside = one.outside(low, high)
    else:
        outside = float(not (limits.allow(one.low) and limits.allow(one.high)))
    _require(
        outside <= IMPOSSIBLE,
        f"input {key}: {one.distribution_name.replace('_', ' ')} takes values from {one.low:g} to {one.high:g}, "
        f"but {key} must be {row.bounds.text()}; give one inside, such as uniform, beta or truncated_normal"
        + (f" (a probability of {outside:.2g} lies outside)" if one.has_density else ""),
    )


def _correlation(given) -> tuple:
    _require(isinstance(given, (list, tuple)), f"correlation = {echo(given)} must be a list of [key, key, value]")
    for row in given:
        _require(
            isinstance(row, (list, tuple)) and len(row) == 3 and all(isinstance(key, str) for key in row[:2]),
            f"correlation: {echo(row)} must be [key, key, value]",
        )
    return tuple((*map(first_name, row[:2]), row[2]) for row in given)


def _quantities(given, kind) -> tuple[str, ...]:
    _require(given, f"quantities names nothing: name one at least; legal: {', '.join(quantities_of(kind))}")
    return _words(given, "quantities")


def _quantity(name, kind, parameters) -> None:
    why = KINDS[kind].missing(parameters)
    for key in quantity_of(kind, name).keys:
        _require(key not in why, f"quantities: {name}: {why.get(key)}")


def _histories(given, scene: Scene) -> tuple[str, ...]:
    names = _words(given, "histories")
    channels = [one.name for one in scene.channels if one.shape == ()] if names else ()
    for name in names:
        if name not in channels:
            raise StudyError(f"histories: {echo(name)} is no channel of one number; {legal_hint(name, channels)}")
    return names


def _words(given, key) -> tuple[str, ...]:
    given = (given,) if isinstance(given, str) else given
    _require(
        isinstance(given, (list, tuple)) and all(isinstance(one, str) for one in given),
        f"{key} = {echo(given)} must be a list of names",
    )
    _require(len(set(given)) == len(given), f"{key} names something twice")
    return tuple(given)


def _sweep(given, scene, targets) -> tuple[str, tuple[float, ...]] | None:
    if given is None:
        return None
    _require(
        isinstance(given, Mapping) and len(given) == 1,
        f"sweep = {echo(given)} must map one key of the scene to a list of values",
    )
    ((key, values),) = given.items()
    checked_key(scene["kind"], key)
    _require(not any(key in keys for keys in targets), f"sweep: {key} is an uncertain input already")
    _require(
        isinstance(values, (list, tuple)) and 1 <= len(values) <= GREATEST_SWEEP,
        f"sweep: {key} must have a list of 1 to {GREATEST_SWEEP} values",
    )
    parsed = [parse_scene(put(scene, key, value), f"sweep {key} = {echo(value)}") for value in values]
    return key, tuple(float(value_at(one.resolved(), key)) for one in parsed)


def _text(given, key, longest) -> str:
    _require(
        is_text(given, longest) and (key != "name" or given.strip()),
        f"{key} = {echo(given)} must be text of at most {longest} characters, all of UTF-8",
    )
    return given
