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

from bearing_twin.base.errors import SceneError, StudyError, echo, is_text, legal_hint
from bearing_twin.base.parameters import choice, plain, quantity, read, section, text
from bearing_twin.base.units import si_value
from bearing_twin.base.yaml_files import LONGEST_DESCRIPTION, LONGEST_NAME, STUDIES
from bearing_twin.run.scene import Scene, check_overrides, open_scene, parse_scene
from bearing_twin.uq.distributions import as_mapping, require
from bearing_twin.uq.inputs import (
    Input,
    Joint,
    checked_key,
    numeric_keys,
    present_name,
    put,
    quantities_of,
    quantity_of,
    read_input,
    value_at,
    with_inputs,
)
from bearing_twin.uq.sampling import GREATEST_SAMPLES, GREATEST_SEED, REPLICATES, SAMPLERS, rounded

PROPAGATION_METHODS = ("auto", "change_of_variable", "ensemble", "chaos")
STATISTICS = ("mean", "std", "quantile")


# When an ensemble is large enough: the 95 % interval of a statistic is narrow at two checks in a row.
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
    def estimated(self) -> str | float:
        """The statistic as `statistics.estimate` takes it: its name, or the probability of the quantile."""
        return self.probability if self.statistic == "quantile" else self.statistic

    @property
    def watched(self) -> str:
        """The statistic and its quantity in words: `std of contact_duration`."""
        statistic = f"{self.probability:g} quantile" if self.statistic == "quantile" else self.statistic
        return f"{statistic} of {self.quantity}"

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
    """The keys of a study that are plain numbers and names."""

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

    `scene` is the scene's plain data with automatic choices still open; `distributions` maps each input's key to its
    distribution as in the file, `targets` are for each input the keys of the scene that take its value; `joint` draws
    the values.
    """

    name: str
    description: str
    scene: dict
    distributions: dict
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
        return [float(source.ppf(0.5)) for source in self.inputs]

    @property
    def quantity_units(self) -> dict[str, str]:
        """Unit of each quantity by its name."""
        return {name: quantity_of(self.kind, name).unit for name in self.quantities}

    def scene_at(self, values: Iterable[float]) -> Scene:
        """The scene with these values of the inputs; raises SceneError where there is none."""
        return parse_scene(with_inputs(self.scene, self.targets, values), "a realisation")

    def at_sweep_value(self, value: float) -> "Study":
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
            "inputs": self.distributions,
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
FORMER_KEYS = {"companions": "checks"}  # of earlier versions
REMOVED_KEYS = {
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
    problems = _Problems()
    try:
        mapping = _by_present_names("the study", mapping, lambda key: FORMER_KEYS.get(key, key))
        for name in ("inputs", "sweep"):
            if isinstance(mapping.get(name), Mapping):
                mapping[name] = _by_present_names(name, mapping[name], present_name)
        study = _read(mapping, *_override(mapping, check_overrides(overrides)), origin, problems)
    except (SceneError, StudyError) as error:
        if not problems:
            raise StudyError(f"{origin}: {error}") from error
    if len(problems) == 1:
        raise StudyError(f"{origin}: {problems[0]}")
    if problems:
        raise StudyError(f"{origin} has {len(problems)} problems:\n" + "\n".join(f"  {row}" for row in problems))
    return study


class _Problems(list):
    """Problems of a study, one sentence each."""

    def collect(self, read: Callable, default: Any, *arguments) -> Any:
        """The value that `read` returns; the default where it raises, whose reason is kept."""
        try:
            return read(*arguments)
        except (SceneError, StudyError) as error:
            self.append(str(error))
            return default


def _by_present_names(where: str, mapping: Mapping, present_name) -> dict:
    """A mapping with the present names of its keys; raises StudyError where a key also has a former name."""
    renamed = {}
    for key, value in mapping.items():
        name = present_name(key)
        require(name not in renamed, f"{where} has {name} twice, by its present and its former name; keep one of them")
        renamed[name] = value
    return renamed


def _override(mapping: dict, overrides) -> tuple[dict, str]:
    """The scene's plain data and its name in errors; overrides of the study change `mapping`.

    The first part of its key decides whether an override is of the study or of the scene; one that names another scene
    comes first.
    """
    study_keys, top_keys = (*FREE_KEYS, *SETTINGS, *FORMER_KEYS), {}
    for override in overrides:
        key, equals, _ = override.partition("=")
        top_keys[override] = key.partition(".")[0].strip()
        require(
            equals and top_keys[override],
            f"override {echo(override)} must look like samples=500 or motion.first_velocity=50",
        )
        if top_keys[override] in ("scene", "set"):
            _set_override(mapping, None, override)
    legal = (*study_keys, *_open_scene(mapping, ())[0])
    for override, top_key in top_keys.items():
        if top_key in REMOVED_KEYS:
            raise StudyError(REMOVED_KEYS[top_key])
        if top_key not in legal:
            hint = legal_hint(top_key, legal)
            raise StudyError(f"override {echo(override)}: {echo(top_key)} is no key of the study or its scene; {hint}")
    opened = _open_scene(mapping, [override for override, top_key in top_keys.items() if top_key not in study_keys])
    for override, top_key in top_keys.items():
        if top_key in study_keys and top_key not in ("scene", "set"):
            _set_override(mapping, opened[0]["kind"], override)
    return opened


def _open_scene(mapping, overrides) -> tuple[dict, str]:
    """(plain data of the scene, its name in errors); its inputs are not put in, so it may be impossible without."""
    scene, changes = mapping["scene"], mapping.get("set", [])
    require(
        isinstance(changes, (list, tuple)) and all(isinstance(change, str) for change in changes),
        f"set = {echo(changes)} must be a list of texts such as motion.first_velocity=50",
    )
    changed_keys, overridden = (
        [present_name(text.partition("=")[0].strip()) for text in texts] for texts in (changes, overrides)
    )
    if twice := {key for key in changed_keys if changed_keys.count(key) > 1}:
        raise StudyError(f"set gives {min(twice)} twice; keep one of them")
    require(
        isinstance(scene, (str, int, Mapping)) and not isinstance(scene, bool),
        f"scene = {echo(scene)} must be the name of a scene, a path, or a scene's keys and values",
    )
    changes = [change for change, key in zip(changes, changed_keys, strict=True) if key not in overridden]
    return open_scene(scene, (*changes, *overrides))


def _set_override(mapping, kind, override) -> None:
    """Puts the value of an override at its path in the study's plain data."""
    key, _, text = override.partition("=")
    path = key.strip().split(".")
    path[0] = FORMER_KEYS.get(path[0], path[0])
    if path[0] == "inputs" and len(path) > 1:
        known = numeric_keys(kind)
        name = present_name(key.strip().partition(".")[2])
        inputs = [known_key for known_key in known if name == known_key or name.startswith(f"{known_key}.")]
        if not inputs:
            raise StudyError(
                f"override {echo(override)}: {echo(name)} is no number of the scene; {legal_hint(name, known)}"
            )
        longest = max(inputs, key=len)
        path = ["inputs", longest, *filter(None, name.removeprefix(longest).split("."))]
    holder = mapping
    for step in path[:-1]:
        inner = holder.get(step, {})
        require(isinstance(inner, Mapping), f"override {echo(override)}: {step} is a value and has no keys of its own")
        holder[step] = holder = dict(inner)
    holder[path[-1]] = STUDIES.load(text, f"override {echo(override)}")


def _read(mapping, scene, scene_origin, origin, problems: _Problems) -> Study:
    """The study; errors are added to `problems`, and then the result must not be used."""
    kind, legal = scene["kind"], (*FREE_KEYS, *SETTINGS)
    problems += [
        REMOVED_KEYS.get(key) or f"{echo(key)} is not a key of a study; {legal_hint(key, legal)}"
        for key in mapping
        if key not in legal
    ]
    settings, setting_problems = read(Settings, {key: mapping[key] for key in SETTINGS if key in mapping})
    problems += setting_problems
    if settings.method == "chaos" and mapping.get("histories"):
        problems.append("histories are sampled, which the method chaos does not do; leave them out, or use ensemble")
    if settings.stop.tolerance and settings.stop.relative_tolerance:
        problems.append("stop.tolerance and stop.relative_tolerance say the same thing twice; keep one")

    inputs, distributions, targets = [], {}, []
    specifications = mapping.get("inputs")
    if not (isinstance(specifications, Mapping) and specifications):
        problems.append("inputs must map keys of the scene to distributions, one at least")
        specifications = {}
    for key, specification in specifications.items():
        targeted = [target for group in targets for target in group]
        if (row := problems.collect(_input, None, kind, key, specification, targeted)) is not None:
            inputs.append(row[0])
            distributions[key] = row[1]
            targets.append(row[2])
    correlation = problems.collect(_correlation, (), mapping.get("correlation", ()))
    joint, sweep = problems.collect(Joint, None, inputs, correlation), mapping.get("sweep")
    if joint and not joint.independent and settings.sensitivity:
        problems.append("sensitivity is for independent inputs; leave it or the correlation out")
    at_medians = with_inputs(scene, targets, [float(source.ppf(0.5)) for source in inputs])
    for key, values in sweep.items() if isinstance(sweep, Mapping) else ():
        with contextlib.suppress(StudyError, LookupError, TypeError):
            at_medians = put(at_medians, checked_key(kind, key), values[0])
    possible = parse_scene(at_medians, scene_origin)
    try:
        parse_scene(scene, scene_origin)
    except SceneError:  # it lacks a number that an input or the sweep gives
        scene = at_medians

    quantities = problems.collect(_quantities, (), mapping.get("quantities"), kind)
    for name in quantities:
        problems.collect(_check_quantity, None, name, kind, possible.parameters)
    stop = settings.stop
    if not stop.quantity:
        stop = dataclasses.replace(stop, quantity="".join(quantities[:1]))
    if stop.quantity not in quantities and quantities:
        hint = legal_hint(stop.quantity, quantities)
        problems.append(f"stop.quantity = {echo(stop.quantity)} is not among the study's quantities; {hint}")
    executor = mapping.get("executor", "processes")
    if not isinstance(executor, str) or (executor != "processes" and not executor.startswith("dask://")):
        problems.append(f"executor = {echo(executor)} must be processes, or dask://host:port of a Dask scheduler")
    name = mapping.get("name", origin.removeprefix("study ").removesuffix(".yaml"))
    return Study(
        problems.collect(_text, "", name, "name", LONGEST_NAME),
        problems.collect(_text, "", mapping.get("description", ""), "description", LONGEST_DESCRIPTION).strip(),
        scene,
        distributions,
        tuple(targets),
        correlation,
        quantities,
        problems.collect(_histories, (), mapping.get("histories", ()), possible),
        problems.collect(_sweep, None, sweep, at_medians, targets),
        executor,
        dataclasses.replace(settings, stop=stop),
        joint,
    )


def _input(kind: str, key: str, specification, targeted) -> tuple[Input, Any, tuple[str, ...]]:
    """(the input, its distribution as plain data, keys that take its value), none of them `targeted` by an input."""
    checked_key(kind, key)
    frozen, followers = specification, ()
    if isinstance(specification, Mapping):
        frozen, followers = specification.get("distribution"), specification.get("also", ())
        followers = (followers,) if isinstance(followers, str) else followers
        require(
            isinstance(followers, (list, tuple)),
            f"input {key}: also = {echo(followers)} must be a list of further keys that take the same value",
        )
        specification = {name: value for name, value in specification.items() if name != "also"}
    if isinstance(frozen, rv_frozen):
        try:
            specification = {**(specification if isinstance(specification, Mapping) else {}), **as_mapping(frozen)}
        except StudyError as error:
            raise StudyError(f"input {key}: {error}") from None
    specification = _in_si(specification, numeric_keys(kind)[key].unit)
    targets = (key, *(checked_key(kind, follower) for follower in followers))
    source = read_input(key, specification)
    for index, target in enumerate(targets):
        require(target not in (*targeted, *targets[:index]), f"input {key}: {target} already follows an input")
        _check_support(kind, target, source)
    return source, {**specification, "also": list(targets[1:])} if followers else specification, targets


IN_THE_INPUTS_UNIT = "low", "high", "mean", "std", "mode", "value", "values", "x", "loc", "scale", "know"


def _in_si(specification, unit: str):
    """The specification of an input, with texts such as 5um in SI; but no deviation of a temperature."""
    if isinstance(specification, str):
        value = si_value(specification, unit)
        return specification if value is None else value
    if isinstance(specification, Mapping):
        converted = [name for name in IN_THE_INPUTS_UNIT if not (name == "std" and unit == "K")]
        return {name: _in_si(value, unit) if name in converted else value for name, value in specification.items()}
    if isinstance(specification, (list, tuple)):
        return [_in_si(value, unit) for value in specification]
    return specification


def _check_support(kind: str, key: str, source: Input) -> None:
    """Raises StudyError where the input takes values that the scene forbids with a probability above IMPOSSIBLE."""
    row = numeric_keys(kind)[key]
    require(
        row.type != "integer" or source.is_whole,
        f"input {key} takes whole numbers; give it the distribution fixed, discrete or empirical with such values",
    )
    limits = row.bounds.without_sizes
    if source.has_density:
        low = next((end for end in (limits.above, limits.at_least) if end is not None), -np.inf)
        high = next((end for end in (limits.below, limits.at_most) if end is not None), np.inf)
        outside = source.outside(low, high)
    else:
        outside = float(not (limits.allow(source.low) and limits.allow(source.high)))
    require(
        outside <= IMPOSSIBLE,
        f"input {key}: {source.distribution_name.replace('_', ' ')} takes values from {source.low:g} to "
        f"{source.high:g}, but {key} must be {row.bounds.text()}; give one inside, such as uniform, beta or "
        "truncated_normal" + (f" (a probability of {outside:.2g} lies outside)" if source.has_density else ""),
    )


def _correlation(rows) -> tuple:
    require(isinstance(rows, (list, tuple)), f"correlation = {echo(rows)} must be a list of [key, key, value]")
    for row in rows:
        require(
            isinstance(row, (list, tuple)) and len(row) == 3 and all(isinstance(key, str) for key in row[:2]),
            f"correlation: {echo(row)} must be [key, key, value]",
        )
    return tuple((*map(present_name, row[:2]), row[2]) for row in rows)


def _quantities(names, kind) -> tuple[str, ...]:
    require(names, f"quantities names nothing: name one at least; legal: {', '.join(quantities_of(kind))}")
    return _names(names, "quantities")


def _check_quantity(name, kind, parameters) -> None:
    reasons = parameters.missing_figures()
    for key in quantity_of(kind, name).keys:
        require(key not in reasons, f"quantities: {name}: {reasons.get(key)}")


def _histories(names, scene: Scene) -> tuple[str, ...]:
    names = _names(names, "histories")
    channels = [channel.name for channel in scene.channels if channel.shape == ()] if names else ()
    for name in names:
        require(name in channels, f"histories: {echo(name)} is no channel of one number; {legal_hint(name, channels)}")
    return names


def _names(names, key) -> tuple[str, ...]:
    names = (names,) if isinstance(names, str) else names
    require(
        isinstance(names, (list, tuple)) and all(isinstance(name, str) for name in names),
        f"{key} = {echo(names)} must be a list of names",
    )
    require(len(set(names)) == len(names), f"{key} names something twice")
    return tuple(names)


def _sweep(sweep, scene, targets) -> tuple[str, tuple[float, ...]] | None:
    if sweep is None:
        return None
    require(
        isinstance(sweep, Mapping) and len(sweep) == 1,
        f"sweep = {echo(sweep)} must map one key of the scene to a list of values",
    )
    ((key, values),) = sweep.items()
    checked_key(scene["kind"], key)
    require(not any(key in keys for keys in targets), f"sweep: {key} is an uncertain input already")
    require(
        isinstance(values, (list, tuple)) and 1 <= len(values) <= GREATEST_SWEEP,
        f"sweep: {key} must have a list of 1 to {GREATEST_SWEEP} values",
    )
    scenes = [parse_scene(put(scene, key, value), f"sweep {key} = {echo(value)}") for value in values]
    return key, tuple(float(value_at(swept.resolved(), key)) for swept in scenes)


def _text(text, key, longest) -> str:
    require(
        is_text(text, longest) and (key != "name" or text.strip()),
        f"{key} = {echo(text)} must be text of at most {longest} characters, all of UTF-8",
    )
    return text
