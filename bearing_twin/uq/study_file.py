"""Study files: strict YAML in, a checked `Study` out, with every problem named at once and the nearest legal word."""

import dataclasses
from collections.abc import Iterable, Mapping
from os import PathLike

from bearing_twin.errors import SceneError, StudyError
from bearing_twin.parameters import echo, read, read_number, unknown
from bearing_twin.run.scene import listed_overrides, open_scene, parse_scene
from bearing_twin.shelf import LONGEST_DESCRIPTION, LONGEST_NAME, STUDIES
from bearing_twin.spelling import is_text
from bearing_twin.uq.quantities import quantities_of, quantity_of
from bearing_twin.uq.scene_keys import checked_key, first_name, numeric_keys, put, value_at
from bearing_twin.uq.study import Settings, Study
from bearing_twin.uq.study_inputs import possible_scene, read_inputs

FREE_KEYS = (
    "name", "description", "scene", "set", "inputs", "correlation", "quantities", "histories", "densities", "sweep",
    "executor",
)  # fmt: skip
GREATEST_SWEEP = 1000


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
        for_scene, for_study = _sorted_overrides(mapping, listed_overrides(overrides))
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
