"""What a figure is worth: errors by source kept apart and added, and the status that follows from what was promised."""

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from bearing_twin.base.report import Choice
from bearing_twin.base.units import greatest_error, known_digits, named, two_digits, with_unit
from bearing_twin.kinds.doubt import FRICTION_MODEL, LARGE, LATER, LAW, LEFT_OUT, METHOD, Errors, Promise
from bearing_twin.run.second_run import Estimate, NoEstimate

WORDS = {LAW: "elastic law", FRICTION_MODEL: "friction model", LEFT_OUT: "what is not modelled"}
FAR = 10.0  # times the error of the method: where that of the model is greater, no ± is shown

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


class Judgement(NamedTuple):
    """What follows from errors: the status, sentences for the flags, and the keys that join the figures."""

    status: str
    flags: tuple[str, ...]
    keys: dict[str, Any]


def judged(
    errors: Errors, estimate: Estimate | NoEstimate, figures: Mapping[str, Any], status: str, choice: Choice
) -> Judgement:
    """The judgement of a run with these model errors, error estimate and figures, whose own status was this.

    The error of a figure is that of the method alone, None where it is not known; errors of the model stand beside.
    """
    by_source = {key: {METHOD: one} for key, one in estimate.of_figures(figures).items()}
    for key, parts in errors.figures.items():
        by_source.setdefault(key, {}).update(parts)
    keys, known, large = {}, {}, {}
    sizes = functools.cache(functools.partial(_sizes, figures))  # found once, if at all
    for figure, parts in by_source.items():
        if figure not in figures or figures[figure] is None or not parts:
            continue
        parts = {source: _beyond_rounding(one, figure, figures[figure], sizes) for source, one in parts.items()}
        keys[f"{figure}_error"] = parts.get(METHOD)
        known[figure] = {source: one for source, one in parts.items() if not _unknown(one)}
        for source, one in known[figure].items():
            spared = greatest(one) <= errors.spared.get(figure, 0.0)
            if exceeds(figures[figure], one) and not spared:
                large.setdefault(figure, source)
    keys["errors_by_source"] = {figure: parts for figure, parts in known.items() if parts}
    keys["model_errors"] = {
        source: of for source in WORDS if (of := {key: one[source] for key, one in known.items() if source in one})
    }
    promises = errors.promises or _promises(errors, estimate, choice)
    keys["wanted_errors"] = {one.output: _told(one) for one in promises}
    keys["errors_unknown"] = ({METHOD: estimate.note} if estimate.note else {}) | dict(errors.notes)
    horizon = errors.horizon if estimate.horizon is None else estimate.horizon
    if horizon is not None:
        keys["horizon_s"] = horizon
    broken = [one for one in promises if one.broken]
    flags = [_sentence(one, horizon) for one in broken]
    named_ones = {figure: source for figure, source in large.items() if errors.told_by.get(figure) not in large}
    if named_ones:
        mends = {METHOD: estimate.smaller} | dict(errors.mends)
        cures = "; ".join(filter(None, (mends.get(source) for source in dict.fromkeys(named_ones.values()))))
        said = "; ".join(_said(one, figures[one], known[one][source], source) for one, source in named_ones.items())
        told = f"the error is over {100.0 * LARGE:g} % of the figure: {said}"
        flags.append(f"{told}; to mend it: {cures}" if cures else told)
    outputs = dict.fromkeys(one.output for one in broken)
    doubtful = [*(("model outside its range",) if choice.outside else ()), *outputs]
    if doubtful and status == DONE:
        status = f"{DOUBTFUL}: {', '.join(doubtful)}"
    return Judgement(status, tuple(flags), keys)


def _promises(errors: Errors, estimate: Estimate | NoEstimate, choice: Choice) -> list[Promise]:
    """The requested outputs with the error of the method, and of the model where that is known."""
    found = []
    for name, one in estimate.of_outputs().items():
        where = f"at {one.when:.6g} s" if one.error is not None and one.error > estimate.tolerance else ""
        mend = LATER if estimate.horizon is not None else estimate.smaller
        numbers = one.norm, one.error, estimate.tolerance
        found.append(Promise(name, *numbers, where, mend, one.until, errors.outputs.get(name, ())))
    return found


def shown_errors(told: Mapping[str, Any], figure: str) -> tuple[float | None, float | None]:
    """Of a figure in a table: the error that says how many digits it has, and that behind its ±, None for none.

    The latter is the method's, and left out where that of the model is far greater: it would promise too much.
    """
    method = greatest_error(told.get(f"{figure}_error"))
    models = (greatest_error(of.get(figure)) for of in told.get("model_errors", {}).values())
    known = [one for one in (method, *models) if one is not None]
    most = max(known, default=None)
    return most, None if method is None or most > FAR * method else method


def model_errors_in_words(told: Mapping[str, Any]) -> list[str]:
    """The errors of the model in a report, one line a source: its greatest over a figure."""
    lines = []
    for source, of in told.get("model_errors", {}).items():
        sizes = {key: greatest(told[key]) for key in of if told.get(key) is not None}
        shares = {key: greatest(of[key]) / size for key, size in sizes.items() if size > 0.0}
        if not max(shares.values(), default=0.0) > 0.0:
            continue
        figure = max(shares, key=shares.__getitem__)
        most = f"{100.0 * shares[figure]:.2g} %" if shares[figure] < 1.0 else "more than all"
        lines.append(f"{WORDS.get(source, source)}: up to {most} of a figure ({named(figure)[0]})")
    return lines


def _unknown(error) -> bool:
    return error is None or (isinstance(error, list) and None in error)


def _is_numbers(value) -> bool:
    """Whether a figure is a number or a list of some."""
    values = value if isinstance(value, list) else [value]
    return bool(values) and all(isinstance(one, (int, float)) for one in values)


def failed(failure: Mapping[str, Any]) -> str:
    """The status of a run that broke off, by what `run.failure.told_of` says of it."""
    return f"{FAILED}: {failure.get('failure_reason', 'broken off')}"


def exceeds(value, error) -> bool:
    """Whether an error is over a tenth of its figure; of a list, of its greatest value."""
    scale, worst = greatest(value), greatest(error)
    return not worst <= LARGE * scale


def _beyond_rounding(error, figure: str, value, sizes: Callable[[], dict[str, float]]):
    """The error of a figure; 0 for one that is large beside the figure and rounding beside others of its unit."""
    if _unknown(error):
        return error
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


def _told(promise: Promise) -> dict[str, Any]:
    told = {"norm": promise.norm, "error": promise.error, "tolerance": promise.tolerance, "where": promise.where}
    told |= {"model_errors": {one.source: one.error for one in promise.model}} if promise.model else {}
    return told if promise.before is None else told | {"error_up_to_horizon": promise.before}


def promise_in_words(told: Mapping[str, Any]) -> str:
    """A row of `wanted_errors` whose error is known: by how much, what was requested, and where."""
    parts = [f"{two_digits(told['error'])} {told['norm']}, requested {told['tolerance']:g}", told["where"]]
    if (before := told.get("error_up_to_horizon")) is not None:
        parts.append(f"{two_digits(before)} up to the horizon")
    return "; ".join(part for part in parts if part)


def _sentence(promise: Promise, horizon: float | None) -> str:
    """What was requested, what the errors are, and what would reduce them."""
    said = []
    if promise.exceeded:
        where = f" ({promise.where})" if promise.where else ""
        if promise.before is not None:
            where += f", {promise.before:.2g} up to {horizon:.6g} s"
        said.append(
            f"{promise.output}: the error of the method is {promise.error:.2g} {promise.norm}{where}, more than the "
            f"requested {promise.tolerance:g}: {promise.mend}"
        )
    for one in promise.model:
        if not one.error <= promise.tolerance:
            said.append(
                f"{promise.output}: the error by {WORDS.get(one.source, one.source)} is {one.error:.2g} "
                f"{promise.norm}, more than the requested {promise.tolerance:g}{': ' if one.mend else ''}{one.mend}"
            )
    return "; ".join(said)
