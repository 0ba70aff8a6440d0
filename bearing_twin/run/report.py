"""The report on a run, a log or a node: figures, their errors by source, the status, and the picture."""

import copy
import functools
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from bearing_twin.base.errors import LogError
from bearing_twin.base.report import Choice, Report
from bearing_twin.base.sample import Aligned, Block, cut, outputs_at_once
from bearing_twin.base.units import greatest_error, known_digits, named, readable, two_digits, with_unit
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import ChannelFigures, Facts, Figures, Picture
from bearing_twin.kinds.error_estimates import (
    FRICTION_MODEL,
    LARGE,
    LATER,
    LAW,
    LEFT_OUT,
    METHOD,
    Errors,
    ModelErrors,
    Promise,
    UnknownErrors,
)
from bearing_twin.run.failure import failure_in
from bearing_twin.run.second_run import Estimate, NoEstimate, estimate_of

WORDS = {LAW: "elastic law", FRICTION_MODEL: "friction model", LEFT_OUT: "what is not modelled"}
FAR = 10.0  # times the error of the method: where that of the model is greater, no ± is shown

DONE, DOUBTFUL, FAILED = "done", "doubtful", "failed"
STATUSES = {
    DONE: "what was wanted is within the tolerance, as far as errors are known",
    DOUBTFUL: "an output that was wanted is worse than the tolerance, or a model left its range; the flags say more",
    FAILED: "the run broke off, or its energy does not add up: its figures are no result",
}
"""Meaning of the first word of a report's status."""

ROUNDING = 1e-12  # of what is large in a unit: an error of a figure that is nearly 0
MADE_OF = {
    "N m": {"N": 1, "m": 1},
    "J": {"N": 1, "m": 1},
    "N m s": {"N": 1, "m": 1, "s": 1},
    "m/s": {"m": 1, "s": -1},
}
"""Units whose figures may all be nearly 0: what is large in them is the product of these powers of others."""


class Judgement(NamedTuple):
    """Consequences of errors: the status, sentences for the flags, and the keys that join the figures."""

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
        sentence = f"the error is over {100.0 * LARGE:g} % of the figure: {said}"
        flags.append(f"{sentence}; to mend it: {cures}" if cures else sentence)
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


def shown_errors(result: Mapping[str, Any], figure: str) -> tuple[float | None, float | None]:
    """Of a figure in a table: the error that says how many digits it has, and that behind its ±, None for none.

    The latter is the method's, and left out where that of the model is far greater: it would promise too much.
    """
    method = greatest_error(result.get(f"{figure}_error"))
    models = (greatest_error(of.get(figure)) for of in result.get("model_errors", {}).values())
    known = [one for one in (method, *models) if one is not None]
    most = max(known, default=None)
    return most, None if method is None or most > FAR * method else method


def model_errors_in_words(result: Mapping[str, Any]) -> list[str]:
    """The errors of the model in a report, one line a source: its greatest over a figure."""
    lines = []
    for source, of in result.get("model_errors", {}).items():
        sizes = {key: greatest(result[key]) for key in of if result.get(key) is not None}
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
    """True for a number or a list of numbers."""
    values = value if isinstance(value, list) else [value]
    return bool(values) and all(isinstance(one, (int, float)) for one in values)


def failed(failure: Mapping[str, Any]) -> str:
    """The status of a run that broke off, by what `run.failure.failure_keys` says of it."""
    return f"{FAILED}: {failure.get('failure_reason', 'broken off')}"


def exceeds(value, error) -> bool:
    """True for an error above a tenth of its figure; of a list, of its greatest value."""
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
    """The greatest size of a figure in this unit, by `_sizes` or by MADE_OF."""
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
    result = {"norm": promise.norm, "error": promise.error, "tolerance": promise.tolerance, "where": promise.where}
    result |= {"model_errors": {one.source: one.error for one in promise.model}} if promise.model else {}
    return result if promise.before is None else result | {"error_up_to_horizon": promise.before}


def promise_in_words(result: Mapping[str, Any]) -> str:
    """A row of `wanted_errors` whose error is known: by how much, what was requested, and where."""
    parts = [f"{two_digits(result['error'])} {result['norm']}, requested {result['tolerance']:g}", result["where"]]
    if (before := result.get("error_up_to_horizon")) is not None:
        parts.append(f"{two_digits(before)} up to the horizon")
    return "; ".join(part for part in parts if part)


def _sentence(promise: Promise, horizon: float | None) -> str:
    """A sentence: tolerance requested, errors, and remedy."""
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


BLOCK_OUTPUTS = 50  # outputs at most in the blocks that figures are made of


class Gathering:
    """A run's writers of figures, model errors and error estimate, empty at first, fed in pieces of any length.

    A writer whose attribute `in_stretches` is False gives the same to the bit for many pieces at once, and gets them.
    """

    def __init__(
        self, figures: Figures, choice: Choice, model_errors: ModelErrors, estimate: Estimate | NoEstimate | None = None
    ):
        self.choice, self.outputs, self.missing = choice, 0, 0
        self._writers = figures, model_errors, estimate or NoEstimate()
        self._length, self._aligned = 0, Aligned(0)
        self._last_ns, self._following = 0, None

    def add(self, block: Block) -> None:
        """Takes a block in; outputs missing before it are counted."""
        if self._following is not None:
            self.missing += max(block.first_sequence - self._following, 0)
        self._following = block.first_sequence + len(block)
        self.outputs += len(block)
        self._last_ns = int(block.time_ns[-1])
        if not self._length:
            self._length = min(BLOCK_OUTPUTS, outputs_at_once(block.channels))
            self._aligned = Aligned(self._length)
        for piece in self._aligned.add(block):
            for writer in self._writers:
                if getattr(writer, "in_stretches", True):
                    for one in cut(piece, self._length):
                        writer.add(one)
                else:
                    writer.add(piece)

    def report(
        self,
        scene: str,
        compute_seconds: float = 0.0,
        costs: Mapping[str, int] | None = None,
        last: bool = False,
        failure: dict[str, Any] | None = None,
    ) -> Report:
        """The report so far; raises LogError without an output. After the `last` one nothing more is taken in.

        `failure` says what broke the run off, which is then failed.
        """
        if not self.outputs:
            raise LogError("there is no sample in it; recover the log from the original, or simulate again")
        figures, model, estimate = self._writers
        if not last:
            # Parameters and a choice never change, and copying them took longer than all figures: the copy shares them.
            shared = [getattr(one, name, None) for one in self._writers for name in ("parameters", "choice")]
            figures, model, estimate = copy.deepcopy(self._writers, {id(one): one for one in shared})
        for piece in self._aligned.rest():
            for writer in (figures, model, estimate):
                writer.add(piece)
        choice, numbers = self.choice, figures.figures()
        errors = model.errors(numbers)
        status = failed(failure) if failure else figures.status()
        seconds = 1e-9 * self._last_ns
        judgement = judged(errors, estimate, numbers, status, choice)
        return Report(
            scene=scene,
            law=self.choice.law,
            stepper=choice.stepper,
            choice_reason=choice.reason,
            warnings=self.choice.warnings,
            flags=(*self.choice.outside, *figures.flags(), *judgement.flags),
            status=judgement.status,
            simulated_seconds=seconds,
            compute_seconds=compute_seconds,
            samples=self.outputs,
            costs=dict(costs or {}),
            figures=numbers,
            errors=judgement.keys,
            outside=self.choice.outside,
            failure=failure,
        )


def report_of(log, blocks: Iterable[Block] | None = None) -> tuple[Report, int]:
    """(report, outputs missing) of a log, whose `blocks` may be handed in; raises LogError without an output.

    Of a recording that holds no scene, and of a log without the records that its figures need (of an earlier version),
    every channel of one number is reported, but for figures that its kind makes of records. What a run cost, and what
    broke it off, is taken from the log's own record, where there is one.
    """
    kind = KINDS[log.scene.kind] if log.scene else None
    needed = kind is not None and any(table.needed for table in kind.records(log.scene.parameters))
    if kind is None or (needed and not log.has_records):
        taken = kind.meanings_of() if kind else ()
        figures, model = ChannelFigures(None, log.choice, log.channels, taken), UnknownErrors(None, log.choice)
        estimate = NoEstimate()
    else:
        made_of = log.scene.parameters, log.choice
        figures, model, estimate = kind.figures_of(*made_of), kind.model_errors(*made_of), estimate_of(kind, *made_of)
        if log.kept_rate:
            estimate = NoEstimate("the log is thinned: its figures are of the outputs kept, whose error is not known")
    gathering = Gathering(figures, log.choice, model, estimate)
    for block in log.blocks() if blocks is None else blocks:
        gathering.add(block)
    said = log.report or {}
    report = gathering.report(log.scene.name if log.scene else "", *_cost(said), failure=failure_in(said))
    return report, 0 if log.kept_rate else gathering.missing


def _cost(said: dict) -> tuple[float, dict[str, int]]:
    """Seconds and counts of a run as its log says them; NaN and none where it does not, as in a recording."""
    try:
        costs = {name: int(count) for name, count in said.get("costs", {}).items()}
        return float(said.get("compute_s", math.nan)), costs
    except (TypeError, ValueError, AttributeError, OverflowError):
        return math.nan, {}


MOST = 30  # rows in a picture


def picture_of(stream) -> Picture:
    """An empty picture of a run or a log, by its kind; of a log without a scene, one drawn from its channels."""
    scene, choice = stream.scene, stream.choice
    facts = Facts(scene, choice.law, choice.stepper)
    if scene is None:
        from bearing_twin.pictures.run import ChannelPicture

        return ChannelPicture(facts)
    return KINDS[scene.kind].picture(facts)


def figure_errors(report: Report) -> list:
    """Rows of the errors of a report's figures, for pictures: of figures that are not 0, lists by their greatest.

    Values have their signs; of several the least and the greatest are given, with the greatest of their errors.
    """
    from bearing_twin.pictures.panels import FigureError

    rows = []
    for key, parts in report.errors.get("errors_by_source", {}).items():
        value = report.figures[key]
        size = greatest(value)
        if not 0.0 < size < math.inf:
            continue
        errors = {source: greatest(part) for source, part in parts.items()}
        whole = math.fsum(errors.values())
        words, unit, factor = readable(key, max(size, whole) if math.isfinite(whole) else size)
        several = list(value) if isinstance(value, (list, tuple)) else [value]
        # Once where both ends read the same, as of one value.
        ends = dict.fromkeys(_value_text(one, factor, whole) for one in (min(several), max(several)))
        text = f"{' to '.join(ends)} ± {two_digits(factor * whole)}{with_unit(unit)}"
        many = f" ({len(several)} values)" if len(several) > 1 else ""
        shares = {source: error / size for source, error in errors.items() if error > 0.0}
        rows.append(FigureError(words + many, text, shares))
    return [row for row in rows if row.parts][:MOST]


def _value_text(value, factor: float, error: float) -> str:
    """One value in the unit that people read; a count stays whole."""
    return str(value) if isinstance(value, int) else known_digits(factor * value, factor * error)


def plot(stream, path) -> Path:
    """Draws a run (which is then simulated) or a log to a PNG; returns its path. Raises BearingTwinError."""
    picture = picture_of(stream)
    for block in stream.blocks():
        picture.add(block)
    return picture.write(path)
