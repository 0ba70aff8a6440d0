"""The inputs of a study file: which numbers of the scene are uncertain, and whether the scene allows their values."""

import contextlib
from collections.abc import Mapping

from bearing_twin.errors import SceneError, StudyError
from bearing_twin.parameters import echo
from bearing_twin.run.scene import parse_scene
from bearing_twin.units import Limits
from bearing_twin.uq.inputs import Input, Joint, read_input
from bearing_twin.uq.scene_keys import checked_key, first_name, numeric_keys, placed, put


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
            joint = Joint(inputs, {(a, b): rho for a, b, rho in correlation} or None)
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
    """Raises StudyError where the input can take values that the scene's limits for that key forbid.

    A bound that is itself forbidden may be the end of a continuous distribution: it has probability 0.
    """
    row = numeric_keys(kind)[key]
    values = getattr(one.distribution, "values", None)
    if row.type == "integer" and (values is None or any(value != round(value) for value in values)):
        raise StudyError(
            f"input {key} takes whole numbers; give it the distribution fixed or empirical with such values"
        )
    limits, points = row.bounds.of_physics, (one.low, one.high)
    if one.has_density:
        limits = Limits(at_least=_either(limits.above, limits.at_least), at_most=_either(limits.below, limits.at_most))
    if not all(limits.allow(point) for point in points):
        raise StudyError(
            f"input {key}: {one.distribution_name.replace('_', ' ')} takes values from {one.low:g} to {one.high:g}, "
            f"but {key} must be {row.bounds.text()}; give one inside, such as uniform, beta or truncated_normal"
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
            rows.append((*map(first_name, row[:2]), row[2]))
        else:
            problems.append(f"correlation: {echo(row)} must be [key, key, value]")
    return tuple(rows)
