"""A study: a scene, which of its numbers are uncertain and how, and what is asked about it."""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import contextlib
import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import NamedTuple

import numpy as np
from scipy.stats.distributions import rv_frozen

from bearing_twin.base.errors import SceneError, StudyError
from bearing_twin.base.messages import is_text
from bearing_twin.base.parameters import choice, echo, plain, quantity, read, read_number, section, unknown
from bearing_twin.base.yaml_files import LONGEST_DESCRIPTION, LONGEST_NAME, STUDIES
from bearing_twin.run.scene import Scene, listed_overrides, open_scene, parse_scene
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


@dataclass(frozen=True)
class Stop:
    """When the ensemble is large enough; without a tolerance it takes all its samples. See `stopping`."""

    statistic: str = choice("mean", STATISTICS, "whose 95 % interval must become narrow")
    probability: float = quantity(0.95, "1", "of the quantile, for statistic: quantile", above=0.0, below=1.0)
    tolerance: float = quantity(0.0, "its unit", "greatest half width of the interval; 0 = none", at_least=0.0)
    relative_tolerance: float = quantity(0.0, "1", "the same as a share of the statistic; 0 = none", at_least=0.0)
    minimum: int = quantity(200, "1", "samples before the first look", at_least=2)


@dataclass(frozen=True)
class Settings:
    """The keys of a study that are plain numbers and words."""

    method: str = choice("auto", PROPAGATION_METHODS, "auto = change of variable where it applies, else ensemble")
    sampler: str = choice("random", tuple(SAMPLERS), "where the unit cube is sampled")
    samples: int = quantity(2000, "1", "realisations, at most", at_least=1, at_most=GREATEST_SAMPLES)
    seed: int = quantity(1, "1", "of every random choice", at_least=0, at_most=GREATEST_SEED)
    batch: int = quantity(100, "1", "samples between looks at the convergence", at_least=1, at_most=1_000_000)
    workers: int = quantity(0, "1", "processes that simulate; 0 = one a processor", at_least=0, at_most=512)
    memory: float = quantity(2e9, "B", "refuse a study that needs more", above=0.0)
    time_limit: float = quantity(
        0.0, "s", "end after so long with what is done, so that numbers depend on the machine; 0 = none", at_least=0.0
    )
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

    `scene` is the scene's plain data with what it leaves to be chosen still open; `given` maps each input's key to
    what the file says of it, `also` to further keys that take the same value; `joint` draws them. `densities` maps
    quantities to the values at which their density is asked for.
    """

    name: str
    description: str
    scene: dict
    given: dict
    also: dict[str, tuple[str, ...]]
    correlation: tuple[tuple[str, str, float], ...]
    quantities: tuple[str, ...]
    histories: tuple[str, ...]
    densities: dict[str, tuple[float, ...]]
    sweep: tuple[str, tuple[float, ...]] | None
    stop_quantity: str
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
        """Rows of (inputs + 2) further samples for Sobol indices, as many as the sampler makes of those asked for."""
        asked = self.settings.sensitivity
        return rounded(self.settings.sampler, asked) if asked else 0

    @property
    def targets(self) -> tuple[tuple[str, ...], ...]:
        """For each input the keys of the scene that take its value."""
        return tuple((one.key, *self.also.get(one.key, ())) for one in self.inputs)

    def scene_at(self, values: Iterable[float]) -> Scene:
        """The scene with these values of the inputs; raises SceneError where there is none."""
        return parse_scene(placed(self.scene, self.targets, values), "a realisation")

    def at(self, value: float) -> "Study":
        """The study at one value of its sweep, without what would be too much of: histories and the count of modes."""
        settings = dataclasses.replace(self.settings, modality="no")
        scene = put(self.scene, self.sweep[0], value)
        return dataclasses.replace(self, scene=scene, sweep=None, histories=(), settings=settings)

    def resolved(self) -> dict:
        """All keys as plain data, the scene in full; `parse_study` of it gives an equal study."""
        settings = plain(self.settings)
        settings["stop"] = {"quantity": self.stop_quantity, **settings["stop"]}
        inputs = {
            key: {**given, "also": list(self.also[key])} if key in self.also else given
            for key, given in self.given.items()
        }
        return {
            "name": self.name,
            "description": self.description,
            "scene": self.scene,
            "inputs": inputs,
            "correlation": [list(row) for row in self.correlation],
            "quantities": list(self.quantities),
            "histories": list(self.histories),
            "densities": {name: list(values) for name, values in self.densities.items()},
            **({"sweep": {self.sweep[0]: list(self.sweep[1])}} if self.sweep else {}),
            "executor": self.executor,
            **settings,
        }


# When an ensemble is large enough: the 95 % interval of a named statistic, looked at in batches, twice in a row.
#
# Looking often and stopping at the first narrow interval favours lucky looks: the interval at such a moment covers less
# than 95 %. Against that (1) there is a least number of samples before the first look, (2) looks are spaced by a batch,
# later by a fifth of the samples so far, and (3) the interval must be narrow at two looks in a row. The looks are at
# the same numbers of samples whatever the number of workers, and whether a study was continued or not.
#
# A half width tells how far sampling may be off, not whether the model is right.

GROWTH = 0.2  # of the samples so far, between later looks
IN_A_ROW = 2


class StopRule(NamedTuple):
    """The greatest half width of a statistic of a quantity: absolute, or relative to the estimate; 0 = no bound."""

    quantity: str
    statistic: str
    probability: float
    tolerance: float
    relative_tolerance: float

    @property
    def bounds(self) -> bool:
        """Whether there is anything to stop for."""
        return self.tolerance > 0.0 or self.relative_tolerance > 0.0

    @property
    def asked(self) -> str | float:
        """The statistic as `statistics.estimate` takes it."""
        return self.probability if self.statistic == "quantile" else self.statistic

    def satisfied(self, estimate: float, half_width: float) -> bool:
        """Whether one look found the interval narrow enough; never for a NaN."""
        return half_width <= max(self.tolerance, self.relative_tolerance * abs(estimate))

    @property
    def watched(self) -> str:
        """The statistic and its quantity in words: `std of contact_duration`."""
        what = f"{self.probability:g} quantile" if self.statistic == "quantile" else self.statistic
        return f"{what} of {self.quantity}"

    def text(self) -> str:
        """The rule in words, for reports."""
        bound = f"{self.tolerance:g}" if self.tolerance else f"{100.0 * self.relative_tolerance:g} % of it"
        return f"the half width of the 95 % interval of the {self.watched} is at most {bound}"


def rule_of(stop: Stop, quantity: str) -> StopRule:
    """The rule of a study."""
    return StopRule(quantity, stop.statistic, stop.probability, stop.tolerance, stop.relative_tolerance)


def looks(samples: int, batch: int, minimum: int, sampler: str) -> Iterator[int]:
    """Increasing numbers of samples at which the statistics are looked at; the last is `samples`.

    Interleaved Sobol sequences are balanced only at REPLICATES times a power of two, so they are looked at there.
    """
    if sampler == "sobol":
        size = REPLICATES
        while size < samples:
            if size >= minimum:
                yield size
            size *= 2
    elif sampler == "random":
        size = batch
        while size < samples:
            if size >= minimum:
                yield size
            size += batch * max(1, round(GROWTH * size / batch))
    # a latin hypercube is one sample of its whole size: parts of it are no hypercubes
    yield samples


# The inputs of a study file: which numbers of the scene are uncertain, and whether the scene allows their values.


def read_inputs(free, scene, problems):
    """(given, also, joint, correlation) of a study file's inputs; what is wrong is added to `problems`."""
    kind, table = scene["kind"], free.get("inputs")
    if not isinstance(table, Mapping) or not table:
        problems.append("inputs must map keys of the scene to distributions, one at least")
        table = {}
    given, also, inputs, taken = {}, {}, [], {}
    for key, told in table.items():
        try:
            checked_key(kind, key)
            told, more = _split(key, told, kind)
            one = read_input(key, told)
            for target in (key, *more):
                if target in taken:
                    raise StudyError(f"input {key}: {target} already follows the input {taken[target]}")
                taken[target] = key
                check_support(kind, target, one)
        except StudyError as error:
            problems.append(str(error))
            continue
        given[key] = told
        if more:
            also[key] = more
        inputs.append(one)
    correlation = _correlation(free.get("correlation", ()), problems)
    joint = None
    if not problems:
        try:
            joint = Joint(inputs, [((a, b), rho) for a, b, rho in correlation])
            medians = [float(one.ppf(0.5)) for one in inputs]
            parse_scene(placed(scene, [(one.key, *also.get(one.key, ())) for one in inputs], medians), "at the medians")
        except (SceneError, StudyError) as error:
            problems.append(str(error))
    return given, also, joint, correlation


def possible_scene(free, scene: dict, origin: str) -> dict:
    """The scene's plain data; where it is impossible so, with medians of inputs and the first value of the sweep.

    Raises SceneError where it is impossible with them, too. What is wrong with inputs and sweep is told elsewhere.
    """
    try:
        parse_scene(scene, origin)
    except SceneError:
        scene = _begun(free, scene)
        parse_scene(scene, origin)
    return scene


def _begun(free, scene: dict) -> dict:
    kind, inputs, sweep = scene["kind"], free.get("inputs"), free.get("sweep")
    for key, told in inputs.items() if isinstance(inputs, Mapping) else ():
        with contextlib.suppress(StudyError):
            told, more = _split(checked_key(kind, key), told, kind)
            scene = placed(scene, [(key, *more)], [read_input(key, told).ppf(0.5)])
    for key, values in sweep.items() if isinstance(sweep, Mapping) else ():
        if isinstance(values, (list, tuple)) and values:
            with contextlib.suppress(StudyError):
                scene = put(scene, checked_key(kind, key), values[0])
    return scene


def _split(key, told, kind):
    """What is told of an input, as plain data, and the further keys that follow it."""
    try:
        if isinstance(told, rv_frozen):
            told = as_mapping(told)
        elif isinstance(told, Mapping) and isinstance(told.get("distribution"), rv_frozen):
            told = as_mapping(told["distribution"]) | {
                word: one for word, one in told.items() if word != "distribution"
            }
    except ValueError as error:
        raise StudyError(f"input {key}: {error}") from None
    if not isinstance(told, Mapping):
        return told, ()
    more = told.get("also", ())
    if isinstance(more, str):
        more = (more,)
    if not isinstance(more, (list, tuple)):
        raise StudyError(f"input {key}: also = {echo(more)} must be a list of further keys that take the same value")
    return {word: value for word, value in told.items() if word != "also"}, tuple(
        checked_key(kind, one) for one in more
    )


def check_support(kind: str, key: str, one: Input) -> None:
    """Raises StudyError where the input takes values that the scene forbids with a probability above IMPOSSIBLE."""
    row = numeric_keys(kind)[key]
    if row.type == "integer" and not one.whole:
        raise StudyError(
            f"input {key} takes whole numbers; give it the distribution fixed, discrete or empirical with such values"
        )
    limits = row.bounds.of_physics
    if one.has_density:
        ends = [next((end for end in pair if end is not None), far) for pair, far in (
            ((limits.above, limits.at_least), -np.inf), ((limits.below, limits.at_most), np.inf))]  # fmt: skip
        outside = one.outside(*ends)
    else:
        outside = float(not all(limits.allow(end) for end in (one.low, one.high)))
    if outside > IMPOSSIBLE:
        raise StudyError(
            f"input {key}: {one.distribution_name.replace('_', ' ')} takes values from {one.low:g} to {one.high:g}, "
            f"but {key} must be {row.bounds.text()}; give one inside, such as uniform, beta or truncated_normal"
            + (f" (a probability of {outside:.2g} lies outside)" if one.has_density else "")
        )


def _correlation(given, problems):
    if not isinstance(given, (list, tuple)):
        problems.append(f"correlation = {echo(given)} must be a list of [key, key, value]")
        return ()
    rows = []
    for row in given:
        if isinstance(row, (list, tuple)) and len(row) == 3 and all(isinstance(key, str) for key in row[:2]):
            rows.append((*map(first_name, row[:2]), row[2]))
        else:
            problems.append(f"correlation: {echo(row)} must be [key, key, value]")
    return tuple(rows)


# Study files: strict YAML in, a checked `Study` out, with every problem named at once and the nearest legal word.

IMPOSSIBLE = 1e-12  # probability of values outside what a scene allows that is neglected
FREE_KEYS = (
    "name", "description", "scene", "set", "inputs", "correlation", "quantities", "histories", "densities", "sweep",
    "executor",
)  # fmt: skip
GREATEST_SWEEP = 1000
OTHER_NAMES = {"companions": "checks"}  # keys of earlier versions


def study_names() -> list[str]:
    """Names of the studies that come with the package, sorted."""
    return STUDIES.names()


def load_study(name_or_path: str | PathLike | Mapping, overrides: Iterable[str] = ()) -> Study:
    """The study of that name or YAML file, or of its plain data; raises StudyError naming every problem.

    Overrides are `samples=500`, `stop.tolerance=1e-7`, `inputs.<key>.std=4e-5`, or a key of the scene such as
    `motion.first_velocity=50`.
    """
    if isinstance(name_or_path, Mapping):
        return parse_study(name_or_path, f"study {name_or_path.get('name', 'without a name')}", overrides)
    path = STUDIES.find(name_or_path)
    return parse_study(STUDIES.read_text(path), f"study {path.name}", overrides)


def parse_study(text_or_mapping: str | Mapping, origin: str, overrides: Iterable[str] = ()) -> Study:
    """The study in a YAML text or a mapping; `origin` names it in errors and, without a `name` key, is its name."""
    mapping = STUDIES.load(text_or_mapping, origin) if isinstance(text_or_mapping, str) else text_or_mapping
    if not isinstance(mapping, Mapping) or "scene" not in mapping:
        raise StudyError(f"{origin} has no key `scene`; start it with `scene: two_spheres` or another scene")
    mapping = dict(mapping)
    problems: list[str] = []
    try:
        for word in ("inputs", "sweep"):
            if isinstance(mapping.get(word), Mapping):
                mapping[word] = _by_first_names(word, mapping[word])
        for other, first in OTHER_NAMES.items():
            if other in mapping and first in mapping:
                raise StudyError(f"{other} is another name of {first}, which is given too; keep one of them")
            if other in mapping:
                mapping[first] = mapping.pop(other)
        parts = (one.partition("=") for one in listed_overrides(overrides))
        listed = ["".join((OTHER_NAMES.get(key.strip(), key), *rest)) for key, *rest in parts]
        for_scene, for_study = _sorted_overrides(mapping, listed)
        scene, scene_origin = _open(mapping, for_scene)
        for override in for_study:
            _apply(mapping, scene["kind"], override)
        scene = possible_scene(mapping, scene, scene_origin)
        study = _read(mapping, scene, origin, problems)
    except (SceneError, StudyError) as error:
        raise StudyError(f"{origin}: {error}") from error
    if len(problems) == 1:
        raise StudyError(f"{origin}: {problems[0]}")
    if problems:
        raise StudyError(f"{origin} has {len(problems)} problems:\n" + "\n".join(f"  {one}" for one in problems))
    return study


def _by_first_names(word: str, given: Mapping) -> dict:
    """What is told of keys, by their first names; raises StudyError where one key is given by both of its names."""
    found = {}
    for key, told in given.items():
        if (first := first_name(key)) in found:
            raise StudyError(f"{word}: {key} is another name of a key that is given too; keep one of them")
        found[first] = told
    return found


def _read(mapping, scene, origin, problems):
    """The study; what is wrong is added to `problems`, and then the result is not to be used."""
    names = [item.name for item in dataclasses.fields(Settings)]
    for key in [key for key in mapping if key not in (*FREE_KEYS, *names)]:
        problems.append(f"{echo(key)} is not a key of a study; {unknown(key, (*FREE_KEYS, *names))}")
    free = {key: mapping[key] for key in FREE_KEYS if key in mapping}
    plain_keys = {key: value for key, value in mapping.items() if key in names}
    stop = plain_keys.get("stop", {})
    stop_quantity = None
    if isinstance(stop, Mapping):
        stop_quantity = stop.get("quantity")
        plain_keys["stop"] = {key: value for key, value in stop.items() if key != "quantity"}
    settings, found = read(Settings, plain_keys)
    problems += found

    if settings.method == "chaos" and free.get("histories"):
        problems.append("histories are sampled, which the method chaos does not do; leave them out, or use ensemble")
    quantities = _quantities(free.get("quantities"), scene, problems)
    given, also, joint, correlation = read_inputs(free, scene, problems)
    return Study(
        _text(free.get("name", origin.removeprefix("study ").removesuffix(".yaml")), "name", LONGEST_NAME, problems),
        _text(free.get("description", ""), "description", LONGEST_DESCRIPTION, problems).strip(),
        scene,
        given,
        also,
        correlation,
        quantities,
        _histories(free.get("histories", ()), scene, problems),
        _densities(free.get("densities", {}), quantities, problems),
        _sweep(free.get("sweep"), scene, given, also, problems),
        _stop_quantity(stop_quantity, settings, quantities, problems),
        _executor(free.get("executor", "processes"), problems),
        settings,
        joint,
    )


def _sorted_overrides(mapping, overrides):
    """(for the scene, for the study) by their first words; those that name another scene are obeyed at once."""
    of_study = (*FREE_KEYS, *(item.name for item in dataclasses.fields(Settings)))
    words = {override: override.partition("=")[0].partition(".")[0].strip() for override in overrides}
    for override, word in words.items():
        if "=" not in override or not word:
            raise StudyError(f"override {echo(override)} must look like samples=500 or motion.first_velocity=50")
        if word in ("scene", "set"):
            _apply(mapping, None, override)
    of_scene = tuple(_open(mapping, ())[0])
    for_scene, for_study = [], []
    for override, word in words.items():
        if word not in of_study + of_scene:
            hint = unknown(word, of_study + of_scene)
            raise StudyError(f"override {echo(override)}: {echo(word)} is no key of the study or its scene; {hint}")
        if word not in ("scene", "set"):
            (for_study if word in of_study else for_scene).append(override)
    return for_scene, for_study


def _open(mapping, for_scene) -> tuple[dict, str]:
    """(plain data of the scene, what errors call it); its inputs are not put in, so it may be impossible without."""
    given, changes = mapping["scene"], mapping.get("set", [])
    if not isinstance(changes, (list, tuple)) or not all(isinstance(one, str) for one in changes):
        raise StudyError(f"set = {echo(changes)} must be a list of texts such as motion.first_velocity=50")
    changed = [first_name(one.partition("=")[0].strip()) for one in changes]
    if twice := {key for key in changed if changed.count(key) > 1}:
        raise StudyError(f"set gives {min(twice)} twice; keep one of them")
    if not isinstance(given, (str, int, Mapping)) or isinstance(given, bool):
        raise StudyError(f"scene = {echo(given)} must be the name of a scene, a path, or a scene's keys and values")
    return open_scene(given, (*changes, *for_scene))


def _apply(mapping, kind, override):
    key, _, text = override.partition("=")
    words = key.strip().split(".")
    if words[0] == "inputs" and len(words) > 1:
        known = numeric_keys(kind)
        rest = first_name(key.strip().partition(".")[2])
        inner = max((one for one in known if rest == one or rest.startswith(f"{one}.")), key=len, default=None)
        if inner is None:
            raise StudyError(
                f"override {echo(override)}: {echo(rest)} is no number of the scene; {unknown(rest, known)}"
            )
        words = ["inputs", inner, *(rest[len(inner) + 1 :].split(".") if rest != inner else ())]
    holder = mapping
    for word in words[:-1]:
        inner = holder.get(word, {})
        if not isinstance(inner, Mapping):
            raise StudyError(f"override {echo(override)}: {word} is a value and has no keys of its own")
        holder[word] = dict(inner)
        holder = holder[word]
    holder[words[-1]] = STUDIES.load(text, f"override {echo(override)}")


def _quantities(given, scene, problems):
    kind, parameters = scene["kind"], parse_scene(scene, "scene").parameters
    known = tuple(quantities_of(kind))
    if not given:
        problems.append(f"quantities names nothing: what shall be found out? legal: {', '.join(known)}")
        return ()
    names = _words(given, "quantities", problems)
    for name in names:
        try:
            row = quantity_of(kind, name)
            if reason := row.missing(parameters):
                problems.append(f"quantities: {name}: {reason}")
        except StudyError as error:
            problems.append(f"quantities: {error}")
    return names


def _histories(given, scene, problems):
    names = _words(given, "histories", problems)
    if names:
        channels = {c.name: c for c in parse_scene(scene, "scene").channels if c.shape == ()}
        for name in names:
            if name not in channels:
                problems.append(f"histories: {echo(name)} is no channel of one number; {unknown(name, channels)}")
    return names


def _densities(given, quantities, problems):
    """{quantity: values [SI]} at which densities are asked for."""
    if not isinstance(given, Mapping):
        problems.append(f"densities = {echo(given)} must map quantities to lists of values")
        return {}
    found = {}
    for name, values in given.items():
        values = values if isinstance(values, (list, tuple)) else (values,)
        read = [read_number(value) for value in values]
        if name not in quantities:
            problems.append(f"densities: {echo(name)} is not among the study's quantities; {unknown(name, quantities)}")
        elif not 1 <= len(read) <= GREATEST_SWEEP or any(problem for _, problem in read):
            problems.append(f"densities: {name} must have a list of 1 to {GREATEST_SWEEP} numbers")
        else:
            found[name] = tuple(float(value) for value, _ in read)
    return found


def _words(given, key, problems):
    given = (given,) if isinstance(given, str) else given
    if not isinstance(given, (list, tuple)) or not all(isinstance(one, str) for one in given):
        problems.append(f"{key} = {echo(given)} must be a list of names")
        return ()
    if len(set(given)) < len(given):
        problems.append(f"{key} names something twice")
    return tuple(given)


def _sweep(given, scene, inputs, also, problems):
    if given is None:
        return None
    if not isinstance(given, Mapping) or len(given) != 1:
        problems.append(f"sweep = {echo(given)} must map one key of the scene to a list of values")
        return None
    ((key, values),) = given.items()
    try:
        checked_key(scene["kind"], key)
        if key in inputs or any(key in more for more in also.values()):
            raise StudyError(f"sweep: {key} is an uncertain input already")
        if not isinstance(values, (list, tuple)) or not 1 <= len(values) <= GREATEST_SWEEP:
            raise StudyError(f"sweep: {key} must have a list of 1 to {GREATEST_SWEEP} values")
        numbers = []
        for value in values:
            parsed = parse_scene(put(scene, key, value), f"sweep {key} = {echo(value)}")
            numbers.append(float(value_at(parsed.resolved(), key)))
    except (SceneError, StudyError) as error:
        problems.append(str(error))
        return None
    return key, tuple(numbers)


def _stop_quantity(given, settings, quantities, problems):
    stop = settings.stop
    if stop.tolerance and stop.relative_tolerance:
        problems.append("stop.tolerance and stop.relative_tolerance say the same thing twice; keep one")
    if given is None:
        return quantities[0] if quantities else ""
    if given not in quantities:
        problems.append(
            f"stop.quantity = {echo(given)} is not among the study's quantities; {unknown(given, quantities)}"
        )
    return given


def _executor(given, problems):
    if not isinstance(given, str) or (given != "processes" and not given.startswith("dask://")):
        problems.append(f"executor = {echo(given)} must be processes, or dask://host:port of a Dask scheduler")
        return "processes"
    return given


def _text(given, key, longest, problems):
    if not is_text(given, longest) or (key == "name" and not given.strip()):
        problems.append(f"{key} = {echo(given)} must be text of at most {longest} characters, all of UTF-8")
        return ""
    return given
