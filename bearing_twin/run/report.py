"""The report on a run, a log or a node: figures, their errors by source, the status, and the picture."""

import copy
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import LogError
from bearing_twin.base.report import Choice, Report
from bearing_twin.base.sample import Block, BlockAligner, outputs_per_chunk, split_block
from bearing_twin.base.units import (
    LUBRICATED,
    greatest_error,
    is_negligible,
    label_and_unit,
    lubricated_label,
    readable_label,
    rounded_to_error,
    two_digits,
    with_unit,
)
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import ChannelFigures, Figures, Picture
from bearing_twin.kinds.error_estimates import (
    BEAM_THEORY,
    FRICTION_MODEL,
    LARGE,
    LATER,
    LAW,
    METHOD,
    NOT_MODELLED,
    Errors,
    ModelError,
    ModelErrors,
    UnknownErrors,
)
from bearing_twin.run.failure import logged_failure
from bearing_twin.run.second_run import NO_SECOND_RUN, Estimate, OutputError, estimate_of

WORDS = {LAW: "elastic law", BEAM_THEORY: "beam theory", FRICTION_MODEL: "friction model"}
WORDS[NOT_MODELLED] = "what is not modelled"
FAR = 10.0  # times the error of the method: where that of the model is greater, no ± is shown

DONE, DOUBTFUL, FAILED = "done", "doubtful", "failed"
STATUSES = {
    DONE: "what was wanted is within the tolerance, as far as errors are known",
    DOUBTFUL: "an output that was wanted is worse than the tolerance, or a model left its range; the flags say more",
    FAILED: "the run broke off, or its energy does not add up: its figures are no result",
}
"""Meaning of the first word of a report's status."""

THINNED = "the log is thinned: its figures are of the outputs kept, whose error is not known"
NO_SHARE = 1e-6  # of a figure: a smaller error of the model is not printed
ROUNDING = 1e-12  # of what is large in a unit: an error of a figure that is nearly 0
MADE_OF = {
    "N m": {"N": 1, "m": 1},
    "J": {"N": 1, "m": 1},
    "N m s": {"N": 1, "m": 1, "s": 1},
    "m/s": {"m": 1, "s": -1},
}
"""Units whose figures may all be nearly 0: what is large in them is the product of these powers of others."""


class Judgement(NamedTuple):
    """Consequences of errors: the status, sentences for the flags, and the keys that join the figures.

    `exceeded` are the sentences of outputs that miss the tolerance, which come before all other flags.
    """

    status: str
    exceeded: tuple[str, ...]
    flags: tuple[str, ...]
    keys: dict[str, Any]


def judge_errors(
    errors: Errors, estimate: Estimate, figures: Mapping[str, Any], status: str, choice: Choice
) -> Judgement:
    """The judgement of a run with these model errors, error estimate and figures, whose own status was this.

    The error of a figure is that of the method alone, None where it is not known; errors of the model stand beside.
    """
    keys, known, large = {}, {}, {}
    method, sizes = estimate.of_figures(figures), unit_sizes(figures)
    for figure in dict.fromkeys((*method, *errors.figures)):
        parts = ({METHOD: method[figure]} if figure in method else {}) | dict(errors.figures.get(figure, {}))
        if figures.get(figure) is None or not parts:
            continue
        keys[f"{figure}_error"] = parts.get(METHOD)
        known[figure] = {source: one for source, one in parts.items() if not _unknown(one)}
        most = max(map(max_magnitude, known[figure].values()), default=0.0)
        if is_negligible(max_magnitude(figures[figure]), most):
            continue
        unit = label_and_unit(figure)[1]
        share = estimate.tolerance if unit == "J" else ROUNDING  # works: beside what all loads would do over all ways
        enough = max(errors.negligible.get(figure, 0.0), share * sizes.get(unit, 0.0))
        for source, one in known[figure].items():
            if is_large_error(figures[figure], one, unit) and not max_magnitude(one) <= enough:
                large.setdefault(figure, source)
    keys["large_errors"] = dict(large)
    keys["errors_by_source"] = {figure: parts for figure, parts in known.items() if parts}
    keys["model_errors"] = {
        source: of for source in WORDS if (of := {key: one[source] for key, one in known.items() if source in one})
    }
    outputs = {name: (one, errors.outputs.get(name, ())) for name, one in estimate.of_outputs().items()}
    keys["wanted_errors"] = {name: _output_keys(*one, estimate.tolerance) for name, one in outputs.items()}
    keys["errors_unknown"] = ({METHOD: estimate.note} if estimate.note else {}) | dict(errors.notes)
    if estimate.horizon is not None:
        keys["horizon_s"] = estimate.horizon
    exceeded = {name: said for name, one in outputs.items() if (said := _exceeded(name, *one, estimate))}
    flags = ()
    large = {figure: source for figure, source in large.items() if errors.integral_of.get(figure) not in large}
    if large:
        mends = {METHOD: estimate.smaller} | dict(errors.mends)
        cures = "; ".join(filter(None, (mends.get(source) for source in dict.fromkeys(large.values()))))
        films = LUBRICATED in errors.notes
        said = "; ".join(_said(one, figures[one], known[one][source], source, films) for one, source in large.items())
        sentence = f"the error is over {100.0 * LARGE:g} % of the figure: {said}"
        flags = (f"{sentence}; to mend it: {cures}" if cures else sentence,)
    doubtful = [*(("model outside its range",) if choice.outside else ()), *exceeded]
    if doubtful and status == DONE:
        status = f"{DOUBTFUL}: {', '.join(doubtful)}"
    return Judgement(status, tuple(exceeded.values()), flags, keys)


def _when(output: OutputError, tolerance: float) -> str:
    """When the error of an output was greatest, where it exceeds the tolerance."""
    return f"at {output.when:.6g} s" if output.error is not None and output.error > tolerance else ""


def _output_keys(output: OutputError, model: tuple[ModelError, ...], tolerance: float) -> dict[str, Any]:
    """The keys of `wanted_errors` of one output."""
    keys = {"norm": output.norm, "error": output.error, "tolerance": tolerance, "where": _when(output, tolerance)}
    keys |= {"model_errors": {one.source: one.error for one in model}} if model else {}
    return keys if output.until is None else keys | {"error_up_to_horizon": output.until}


def _exceeded(name: str, output: OutputError, model: tuple[ModelError, ...], estimate: Estimate) -> str:
    """A sentence on the errors of an output that exceed the tolerance, as NaN does, and their remedies; "" for none."""
    tolerance, said = estimate.tolerance, []
    if output.error is not None and not output.error <= tolerance:
        when = _when(output, tolerance)
        where = f" ({when})" if when else ""
        if output.until:
            where += f", {output.until:.2g} up to {estimate.horizon:.6g} s"
        mend = estimate.smaller if estimate.horizon is None else LATER
        said.append(
            f"{name}: the error of the method is {output.error:.2g} {output.norm}{where}, more than the requested "
            f"{tolerance:g}: {mend}"
        )
    said += [
        f"{name}: the error by {WORDS.get(one.source, one.source)} is {one.error:.2g} {output.norm}, more than the "
        f"requested {tolerance:g}{': ' if one.mend else ''}{one.mend}"
        for one in model
        if not one.error <= tolerance
    ]
    return "; ".join(said)


def displayed_errors(result: Mapping[str, Any], figure: str, size: float) -> tuple[float | None, float | None]:
    """Of a figure of this size in a table: the error that sets its digits, and that behind its ±, None for none.

    The latter is the method's, and not printed where that of the model is far greater, as it would suggest too high an
    accuracy. A figure that is 0 within its greatest error has that.
    """
    method = greatest_error(result.get(f"{figure}_error"))
    models = (greatest_error(of.get(figure)) for of in result.get("model_errors", {}).values())
    known = [one for one in (method, *models) if one is not None]
    most = max(known, default=None)
    if is_negligible(size, most):
        return most, most
    return most, None if method is None or most > FAR * method else method


def model_error_lines(result: Mapping[str, Any]) -> list[str]:
    """The errors of the model in a report, one line a source: its greatest over a figure."""
    lines = []
    for source, of in result.get("model_errors", {}).items():
        sizes = {key: max_magnitude(result[key]) for key in of if result.get(key) is not None}
        shares = {key: max_magnitude(of[key]) / size for key, size in sizes.items() if size > 0.0}
        if not max(shares.values(), default=0.0) > NO_SHARE:
            continue
        figure = max(shares, key=shares.__getitem__)
        words, unit = label_and_unit(figure)
        size, share = f"{two_digits(max_magnitude(of[figure]))} {unit}", shares[figure]
        lines.append(f"{WORDS[source]}: up to {f'{100.0 * share:.2g} %' if share < 1.0 else size} ({words})")
    return lines


def _unknown(error) -> bool:
    return error is None or (isinstance(error, list) and None in error)


def failed_status(failure: Mapping[str, Any]) -> str:
    """The status of a run that broke off, by what `run.failure.failure_keys` says of it."""
    return f"{FAILED}: {failure.get('failure_reason', 'broken off')}"


def is_large_error(value, error, unit: str) -> bool:
    """True for an error above a tenth of its figure, of the greatest of a list, and of the amplitude of a level."""
    allowed = 20.0 * math.log10(1.0 + LARGE) if unit == "dB" else LARGE * max_magnitude(value)
    return not max_magnitude(error) <= allowed


def unit_sizes(figures: Mapping[str, Any]) -> dict[str, float]:
    """The greatest size of a run's figures by unit, also by MADE_OF; 1 rad at least."""
    sizes = {"rad": 1.0}
    for key, value in figures.items():
        values = value if isinstance(value, list) else [value]
        if values and all(isinstance(one, (int, float)) and math.isfinite(one) for one in values):
            unit = label_and_unit(key)[1]
            sizes[unit] = max(sizes.get(unit, 0.0), max_magnitude(values))
    made = {
        unit: math.prod(sizes[one] ** power for one, power in powers.items())
        for unit, powers in MADE_OF.items()
        if all(sizes.get(one) for one in powers)
    }
    return sizes | {unit: max(size, sizes.get(unit, 0.0)) for unit, size in made.items()}


def max_magnitude(value) -> float:
    """The greatest magnitude of a number or of a list, 0 of an empty one; NaN where one is."""
    return float(np.abs(value).max(initial=0.0))


def _said(figure: str, value, error, source: str, films: bool) -> str:
    """One figure whose error is large, and its greatest source; `films`: of contacts with them."""
    words, unit = label_and_unit(figure)
    words = lubricated_label(words) if films else words
    off = max_magnitude(error)
    size = rounded_to_error(max_magnitude(value), off, 2)
    return f"{words} {size} ± {two_digits(off)}{with_unit(unit)}, mostly {WORDS.get(source, source)}"


def output_error_text(result: Mapping[str, Any]) -> str:
    """A row of `wanted_errors` whose error is known: by how much, what was requested, and where."""
    parts = [f"{two_digits(result['error'])} {result['norm']}, requested {result['tolerance']:g}", result["where"]]
    if before := result.get("error_up_to_horizon"):
        parts.append(f"{two_digits(before)} up to the horizon")
    return "; ".join(part for part in parts if part)


BLOCK_OUTPUTS = 50  # outputs at most in the blocks that figures are made of


class ReportBuilder:
    """A run's writers of figures, model errors and error estimate, empty at first, fed in pieces of any length.

    A writer whose attribute `in_stretches` is False gives the same to the bit for many pieces at once, and gets them.
    """

    def __init__(self, figures: Figures, choice: Choice, model_errors: ModelErrors, estimate: Estimate | None = None):
        self.choice, self.outputs, self.missing = choice, 0, 0
        self._writers = figures, model_errors, estimate or Estimate(unknown=NO_SECOND_RUN)
        self._length, self._aligned = 0, BlockAligner(0)
        self._last_ns, self._following = 0, None

    def add(self, block: Block) -> None:
        """Takes a block in; outputs missing before it are counted."""
        if self._following is not None:
            self.missing += max(block.first_sequence - self._following, 0)
        self._following = block.first_sequence + len(block)
        self.outputs += len(block)
        self._last_ns = int(block.time_ns[-1])
        if not self._length:
            self._length = min(BLOCK_OUTPUTS, outputs_per_chunk(block.channels))
            self._aligned = BlockAligner(self._length)
        for piece in self._aligned.add(block):
            for writer in self._writers:
                if getattr(writer, "in_stretches", True):
                    for one in split_block(piece, self._length):
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
            figures, model, estimate = copy.deepcopy(self._writers)
        for piece in self._aligned.remainder():
            for writer in (figures, model, estimate):
                writer.add(piece)
        choice, numbers = self.choice, figures.figures()
        errors = model.errors(numbers)
        status = failed_status(failure) if failure else figures.status()
        seconds = 1e-9 * self._last_ns
        judgement = judge_errors(errors, estimate, numbers, status, choice)
        return Report(
            scene=scene,
            law=self.choice.law,
            stepper=choice.stepper,
            choice_reason=choice.reason,
            warnings=self.choice.warnings,
            flags=(*self.choice.outside, *judgement.exceeded, *figures.flags(), *judgement.flags),
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
        estimate = Estimate(unknown=NO_SECOND_RUN)
    else:
        made_of = log.scene.parameters, log.choice
        figures, model, estimate = kind.figures_of(*made_of), kind.model_errors(*made_of), estimate_of(kind, *made_of)
    if log.kept_rate:
        estimate = Estimate(unknown=THINNED)
    gathering = ReportBuilder(figures, log.choice, model, estimate)
    for block in log.blocks() if blocks is None else blocks:
        gathering.add(block)
    said = log.report or {}
    report = gathering.report(log.scene.name if log.scene else "", *_cost(said), failure=logged_failure(said))
    return report, 0 if log.kept_rate else gathering.missing


def _cost(said: dict) -> tuple[float, dict[str, int]]:
    """Seconds and counts of a run as its log says them; NaN and none where it does not, as in a recording."""
    try:
        costs = {name: int(count) for name, count in said.get("costs", {}).items()}
        return float(said.get("compute_s", math.nan)), costs
    except (TypeError, ValueError, AttributeError, OverflowError):
        return math.nan, {}


MOST_ROWS = 30  # figures whose errors are drawn


def picture_of(stream) -> Picture:
    """An empty picture of a run or a log, by its kind; of a log without a scene, one drawn from its channels."""
    if stream.scene is None:
        from bearing_twin.kinds.picture import RunPicture

        return RunPicture(None, stream.choice)
    return KINDS[stream.scene.kind].picture(stream.scene, stream.choice)


def figure_errors(report: Report) -> list[tuple[str, dict[str, float]]]:
    """Rows of `pictures.draw_errors`: of figures that are not 0 and have an error, of lists the greatest of both."""
    rows = []
    for key, parts in report.errors.get("errors_by_source", {}).items():
        size, errors = (
            max_magnitude(report.figures[key]),
            {source: max_magnitude(part) for source, part in parts.items()},
        )
        whole = math.fsum(errors.values())
        if not 0.0 < size < math.inf or not whole > NO_SHARE * size:
            continue
        words, unit, factor = readable_label(key, size)
        number, error = rounded_to_error(factor * size, factor * whole), two_digits(factor * whole)
        text = f"{words}: {number} ± {error}{with_unit(unit)}"
        rows.append((text, {WORDS.get(source, source): part / size for source, part in errors.items() if part > 0.0}))
    return rows[:MOST_ROWS]


def plot(stream, path) -> Path:
    """Draws a run (which is then simulated) or a log to a PNG; returns its path. Raises BearingTwinError."""
    picture = picture_of(stream)
    for block in stream.blocks():
        picture.add(block)
    return picture.write(path)
