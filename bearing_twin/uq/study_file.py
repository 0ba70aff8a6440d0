"""Study files: strict YAML in, a checked `Study` out, with every problem named at once and the nearest legal word."""

import dataclasses
from collections.abc import Iterable, Mapping

from bearing_twin.errors import SceneError, StudyError
from bearing_twin.parameters import Limits, echo, read, unknown
from bearing_twin.scene import open_scene, parse_scene
from bearing_twin.shelf import LONGEST_DESCRIPTION, LONGEST_NAME, Shelf
from bearing_twin.uq.inputs import Input, Joint, read_input
from bearing_twin.uq.quantities import QUANTITIES, quantity_of
from bearing_twin.uq.scene_keys import checked_key, numeric_keys, put, value_at
from bearing_twin.uq.study import Settings, Study, placed

STUDIES = Shelf("study", "studies", StudyError)
FREE_KEYS = (
    "name", "description", "scene", "set", "inputs", "correlation", "quantities", "histories", "sweep", "executor",
)  # fmt: skip
GREATEST_SWEEP = 1000


def study_names() -> list[str]:
    """Names of the studies that come with the package, sorted."""
    return STUDIES.names()


def load_study(name_or_path, overrides: Iterable[str] = ()) -> Study:
    """The study of that name or YAML file; raises StudyError naming every problem.

    Overrides are `samples=500`, `stop.tolerance=1e-7`, `inputs.<key>.std=4e-5`, or a key of the scene such as
    `motion.first_velocity=50`.
    """
    path = STUDIES.find(name_or_path)
    return parse_study(STUDIES.read_text(path), f"study {path.name}", overrides)


def parse_study(text_or_mapping, origin: str, overrides: Iterable[str] = ()) -> Study:
    """The study in a YAML text or a mapping; `origin` names it in errors and, without a `name` key, is its name."""
    mapping = STUDIES.load(text_or_mapping, origin) if isinstance(text_or_mapping, str) else text_or_mapping
    if not isinstance(mapping, Mapping) or "scene" not in mapping:
        raise StudyError(f"{origin} has no key `scene`; start it with `scene: two_spheres` or another scene")
    mapping = dict(mapping)
    try:
        for_scene, for_study = _sorted_overrides(overrides)
        scene = _open(mapping, for_scene)
        for override in for_study:
            _apply(mapping, scene["kind"], override)
        problems: list[str] = []
        study = _read(mapping, scene, origin, problems)
    except (SceneError, StudyError) as error:
        raise StudyError(f"{origin}: {error}") from error
    if problems:
        listed = problems[0] if len(problems) == 1 else "\n".join(("", *(f"  {one}" for one in problems)))
        raise StudyError(f"{origin}: {listed}" if len(problems) == 1 else f"{origin} has {len(problems)} problems:{listed}")
    return study


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

    kind = scene["kind"]
    quantities = _quantities(free.get("quantities"), kind, problems)
    given, also, joint, correlation = _inputs(free, scene, problems)
    return Study(
        _text(free.get("name", origin.removeprefix("study ").removesuffix(".yaml")), "name", LONGEST_NAME, problems),
        _text(free.get("description", ""), "description", LONGEST_DESCRIPTION, problems).strip(),
        scene,
        given,
        also,
        correlation,
        quantities,
        _histories(free.get("histories", ()), scene, problems),
        _sweep(free.get("sweep"), scene, given, also, problems),
        _stop_quantity(stop_quantity, settings, quantities, kind, problems),
        _executor(free.get("executor", "processes"), problems),
        settings,
        joint,
    )


def _sorted_overrides(overrides):
    """(for the scene, for the study): the first word of a study's override is a key of studies."""
    names = {*FREE_KEYS, *(item.name for item in dataclasses.fields(Settings))}
    for_scene, for_study = [], []
    for override in overrides:
        key, equals, _ = override.partition("=")
        word = key.partition(".")[0].strip()
        if not equals or not word:
            raise StudyError(f"override {echo(override)} must look like samples=500 or motion.first_velocity=50")
        (for_study if word in names else for_scene).append(override)
    return for_scene, for_study


def _open(mapping, for_scene) -> dict:
    given, changes = mapping["scene"], mapping.get("set", [])
    if not isinstance(changes, (list, tuple)) or not all(isinstance(one, str) for one in changes):
        raise StudyError(f"set = {echo(changes)} must be a list of texts such as motion.first_velocity=50")
    if not isinstance(given, (str, Mapping)):
        raise StudyError(f"scene = {echo(given)} must be the name of a scene, a path, or a scene's keys and values")
    scene, origin = open_scene(given, (*changes, *for_scene))
    parse_scene(scene, origin)
    return scene


def _apply(mapping, kind, override):
    key, _, text = override.partition("=")
    words = key.strip().split(".")
    if words[0] == "inputs":
        known = numeric_keys(kind)
        rest = key.strip().partition(".")[2]
        inner = max((one for one in known if rest == one or rest.startswith(f"{one}.")), key=len, default=None)
        if inner is None:
            raise StudyError(f"override {echo(override)}: {echo(rest)} is no number of the scene; {unknown(rest, known)}")
        words = ["inputs", inner, *(rest[len(inner) + 1 :].split(".") if rest != inner else ())]
    holder = mapping
    for word in words[:-1]:
        inner = holder.get(word, {})
        if not isinstance(inner, Mapping):
            raise StudyError(f"override {echo(override)}: {word} is a value and has no keys of its own")
        holder[word] = dict(inner)
        holder = holder[word]
    holder[words[-1]] = STUDIES.load(text, f"override {echo(override)}")


def _inputs(free, scene, problems):
    """(given, also, joint, correlation) of the inputs."""
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
            joint = Joint(inputs, {(a, b): rho for a, b, rho in correlation} or None)
            medians = [float(one.ppf(0.5)) for one in inputs]
            parse_scene(placed(scene, [(one.key, *also.get(one.key, ())) for one in inputs], medians), "at the medians")
        except (SceneError, StudyError) as error:
            problems.append(str(error))
    return given, also, joint, correlation


def _split(key, told, kind):
    """What is told of an input, as plain data, and the further keys that follow it."""
    if not isinstance(told, Mapping):
        return told, ()
    more = told.get("also", ())
    if isinstance(more, str):
        more = (more,)
    if not isinstance(more, (list, tuple)):
        raise StudyError(f"input {key}: also = {echo(more)} must be a list of further keys that take the same value")
    return {word: value for word, value in told.items() if word != "also"}, tuple(checked_key(kind, one) for one in more)


def check_support(kind: str, key: str, one: Input) -> None:
    """Raises StudyError where the input can take values that the scene's limits for that key forbid.

    A bound that is itself forbidden may be the end of a continuous distribution: it has probability 0.
    """
    row = numeric_keys(kind)[key]
    values = getattr(one.distribution, "values", None)
    if row.type == "integer" and (values is None or any(value != round(value) for value in values)):
        raise StudyError(f"input {key} takes whole numbers; give it the distribution fixed or empirical with such values")
    limits, points = row.bounds, (one.low, one.high)
    if one.has_density:
        limits = Limits(at_least=_either(limits.above, limits.at_least), at_most=_either(limits.below, limits.at_most))
    if not all(limits.allow(point) for point in points):
        raise StudyError(
            f"input {key}: {one.distribution_name.replace('_', ' ')} takes values from {one.low:g} to {one.high:g}, but "
            f"{key} must be {row.bounds.text()}; give a distribution inside, such as uniform, beta or truncated_normal"
        )


def _either(one, other):
    return other if one is None else one


def _correlation(given, problems):
    if not isinstance(given, (list, tuple)):
        problems.append(f"correlation = {echo(given)} must be a list of [key, key, value]")
        return ()
    rows = []
    for row in given:
        if isinstance(row, (list, tuple)) and len(row) == 3 and all(isinstance(key, str) for key in row[:2]):
            rows.append(tuple(row))
        else:
            problems.append(f"correlation: {echo(row)} must be [key, key, value]")
    return tuple(rows)


def _quantities(given, kind, problems):
    known = tuple(QUANTITIES.get(kind, ()))
    if given is None:
        problems.append(f"quantities is missing: what shall be found out? legal: {', '.join(known)}")
        return ()
    names = _words(given, "quantities", problems)
    for name in names:
        try:
            quantity_of(kind, name)
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


def _stop_quantity(given, settings, quantities, kind, problems):
    stop = settings.stop
    if stop.tolerance and stop.relative_tolerance:
        problems.append("stop.tolerance and stop.relative_tolerance say the same thing twice; keep one")
    if given is None:
        return quantities[0] if quantities else ""
    if given not in quantities:
        problems.append(f"stop.quantity = {echo(given)} is not among the study's quantities; {unknown(given, quantities)}")
    return given


def _executor(given, problems):
    if not isinstance(given, str) or (given != "processes" and not given.startswith("dask://")):
        problems.append(f"executor = {echo(given)} must be processes, or dask://host:port of a Dask scheduler")
        return "processes"
    return given


def _text(given, key, longest, problems):
    if not isinstance(given, str) or len(given) > longest or (key == "name" and not given.strip()):
        problems.append(f"{key} = {echo(given)} must be text of at most {longest} characters")
        return ""
    return given
