"""What a figure is worth: errors by source kept apart and added, and the status that follows from what was promised."""

import functools
import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from bearing_twin.kinds.doubt import LARGE, Dearest, Errors, Promise
from bearing_twin.units import known_digits, named, two_digits, with_unit

DONE, DOUBTFUL, FAILED = "done", "doubtful", "failed"
STATUSES = {
    DONE: "what was wanted is within the tolerance, as far as errors are known",
    DOUBTFUL: "an output that was wanted is worse than the tolerance, or a model left its range; the flags say more",
    FAILED: "the run broke off, or its energy does not add up: its figures are no result",
}
"""What the first word of a report's status means."""

ROUNDING = 1e-12  # of what is large in a unit: an error of a figure that is nearly 0
MADE_OF = {
    "N m": {"N": 1, "m": 1},
    "J": {"N": 1, "m": 1},
    "N m s": {"N": 1, "m": 1, "s": 1},
    "m/s": {"m": 1, "s": -1},
}
"""Units whose figures may all be nearly 0: what is large in them is the product of these powers of others."""
MUCH = 0.35  # of a run's steps: a companion that took more says why
SHORT_RUN = "the run is short"


class Judgement(NamedTuple):
    """What follows from errors: the status, sentences for the flags, and the keys that join the figures."""

    status: str
    flags: tuple[str, ...]
    keys: dict[str, Any]


def judged(
    errors: Errors,
    figures: Mapping[str, Any],
    status: str,
    outside: tuple[str, ...] = (),
    predicted: Mapping[str, float | str] | None = None,
    errorless: Collection[str] = (),
) -> Judgement:
    """The judgement of a run with these errors and figures whose own status was this, and models outside ranges.

    What a choice `predicted` is told beside what came out. Figures without error that are not `errorless` are named.
    """
    keys, totals, large = {}, {}, {}
    sizes = functools.cache(functools.partial(_sizes, figures))  # found once, if at all
    for figure, parts in errors.figures.items():
        if figure not in figures or figures[figure] is None or not parts:
            continue
        totals[figure] = _beyond_rounding(_added(list(parts.values())), figure, figures[figure], sizes)
        keys[f"{figure}_error"] = totals[figure]
        spared = greatest(totals[figure]) <= errors.spared.get(figure, 0.0)
        if exceeds(figures[figure], totals[figure]) and not spared:
            large[figure] = max(parts, key=lambda name: greatest(parts[name]))
    kept = {figure: dict(errors.figures[figure]) for figure in totals}
    keys["errors_by_source"] = kept
    keys["wanted_errors"] = {one.output: _told(one, predicted or {}) for one in errors.promises}
    keys["errors_unknown"] = dict(errors.notes)
    if errors.figures and (unknown := _without_error(figures, {*totals, *errorless})):
        keys["errors_unknown"]["figures"] = f"nothing is known of the error of {', '.join(unknown)}"
    if errors.horizon is not None:
        keys["horizon_s"] = errors.horizon
    broken = [one for one in errors.promises if one.broken]
    flags = [_sentence(one, errors.horizon) for one in broken]
    named_ones = {figure: source for figure, source in large.items() if errors.told_by.get(figure) not in large}
    if named_ones:
        cures = "; ".join(filter(None, (errors.mends.get(source) for source in dict.fromkeys(named_ones.values()))))
        said = "; ".join(_said(one, figures[one], totals[one], source) for one, source in named_ones.items())
        told = f"the error is over {100.0 * LARGE:g} % of the figure: {said}"
        flags.append(f"{told}; to mend it: {cures}" if cures else told)
    doubtful = [*(("model outside its range",) if outside else ()), *(one.output for one in broken)]
    if doubtful and status == DONE:
        status = f"{DOUBTFUL}: {', '.join(doubtful)}"
    return Judgement(status, tuple(flags), keys)


def _without_error(figures: Mapping[str, Any], known: Collection[str]) -> list[str]:
    """Names of figures that are numbers and not `known`."""
    left = {key: value for key, value in figures.items() if key not in known}
    return [named(key)[0] for key, value in left.items() if _is_numbers(value)]


def _is_numbers(value) -> bool:
    """Whether a figure is a number or a list of some."""
    values = value if isinstance(value, list) else [value]
    return bool(values) and all(isinstance(one, (int, float)) for one in values)


def failed(failure: Mapping[str, Any]) -> str:
    """The status of a run that broke off, by what `run.failure.told_of` says of it."""
    return f"{FAILED}: {failure.get('failure_reason', 'broken off')}"


def companion_cost(costs: Mapping[str, int], dearest: Dearest | None) -> dict[str, Any]:
    """The companion's share of a bearing run's steps, and in words what took it where it is more than MUCH."""
    steps, taken = costs.get("ball_steps", 0), costs.get("companion_ball_steps", 0)
    if not steps or not taken:
        return {}
    told = {"companion_share": taken / steps}
    if dearest is None or not dearest.steps or taken <= MUCH * steps:
        return told
    each = steps / dearest.balls
    why = f"its dearest stretch, {dearest.place}, took {dearest.steps} of its {taken} steps of balls"
    if MUCH * each < dearest.least:
        why = f"{SHORT_RUN}, {each:.0f} steps of a ball; the windows that any run has take about {dearest.least}"
    return told | {"companion_reason": f"the companion took {100.0 * taken / steps:.0f} % of the run's steps: {why}"}


def exceeds(value, error) -> bool:
    """Whether an error is over a tenth of its figure; of a list, of its greatest value."""
    scale, worst = greatest(value), greatest(error)
    return not worst <= LARGE * scale


def _beyond_rounding(error, figure: str, value, sizes: Callable[[], dict[str, float]]):
    """The error of a figure; 0 for one that is large beside the figure and rounding beside others of its unit."""
    rounding = ROUNDING * _size(named(figure)[1], sizes()) if exceeds(value, error) else -1.0
    if not greatest(error) <= rounding:  # nor is a NaN
        return error
    return [0.0] * len(error) if isinstance(error, list) else 0.0


def _sizes(figures: Mapping[str, Any]) -> dict[str, float]:
    """The greatest of a run's figures by unit; 1 rad at least."""
    sizes = {"rad": 1.0}
    for key, value in figures.items():
        values = value if isinstance(value, list) else [value]
        if not (_is_numbers(value) and all(map(math.isfinite, values))):
            continue
        its = named(key)[1]
        sizes[its] = max(sizes.get(its, 0.0), greatest(values))
    return sizes


def _size(unit: str, sizes: Mapping[str, float]) -> float:
    """What is large in this unit, by `_sizes`: the greatest of it, or what MADE_OF says."""
    powers = MADE_OF.get(unit, {})
    known = powers and all(sizes.get(one) for one in powers)
    made = math.prod(sizes[one] ** power for one, power in powers.items()) if known else 0.0
    return max(sizes.get(unit, 0.0), made)


def _added(parts: list):
    """The sum of errors of several sources: numbers, or lists of equal length."""
    lists = [part for part in parts if isinstance(part, list)]
    if not lists:
        return math.fsum(parts)
    rows = [part if isinstance(part, list) else [part] * len(lists[0]) for part in parts]
    return [math.fsum(column) for column in zip(*rows, strict=True)]


def greatest(value) -> float:
    """The greatest magnitude of a number or of a list, 0 of an empty one; NaN where one is."""
    values = [value] if isinstance(value, (int, float)) else list(value)
    return math.nan if any(math.isnan(one) for one in values) else max(map(abs, values), default=0.0)


def _said(figure: str, value, error, source: str) -> str:
    """One figure whose error is large, and its greatest source."""
    words, unit = named(figure)
    off = greatest(error)
    size = known_digits(greatest(value), off, 2)
    return f"{words} {size} ± {two_digits(off)}{with_unit(unit)}, mostly {source.replace('_', ' ')}"


def _told(promise: Promise, predicted: Mapping[str, float | str]) -> dict[str, Any]:
    told = {"norm": promise.norm, "error": promise.error, "tolerance": promise.tolerance, "where": promise.where}
    before = predicted.get(f"{promise.output.removesuffix('s')}_error")
    told |= {"predicted": before} if isinstance(before, float) else {}  # a log may say anything
    told |= {} if promise.may is None else {"may_be": promise.may}
    return told if promise.before is None else told | {"error_up_to_horizon": promise.before}


def promise_in_words(told: Mapping[str, Any]) -> str:
    """A row of `wanted_errors` whose error is known: by how much, what was wanted and predicted, and where."""
    foretold = f", predicted {two_digits(told['predicted'])}" if "predicted" in told else ""
    most = f" (may be {two_digits(told['may_be'])})" if "may_be" in told else ""
    parts = [f"{two_digits(told['error'])}{most} {told['norm']}, wanted {told['tolerance']:g}{foretold}", told["where"]]
    if (before := told.get("error_up_to_horizon")) is not None:
        parts.append(f"{two_digits(before)} up to the horizon")
    return "; ".join(part for part in parts if part)


def _sentence(promise: Promise, horizon: float | None) -> str:
    """What was wanted, what came out, and what would mend it."""
    where = f" ({promise.where})" if promise.where else ""
    if promise.before is not None:
        where += f", by {promise.before:.2g} up to {horizon:.6g} s"
    verb = "are" if promise.output.endswith("s") else "is"
    most = f", which may be {promise.may:.2g}, " if promise.error <= promise.tolerance else ", "
    return (
        f"{promise.output} {verb} off by {promise.error:.2g} {promise.norm}{where}{most}more than the wanted "
        f"{promise.tolerance:g}: {promise.mend}"
    )
