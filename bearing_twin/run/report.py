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
    greatest_error,
    is_negligible,
    label_and_unit,
    label_in_result,
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

SOURCE_LABELS = {LAW: "elastic law", BEAM_THEORY: "beam theory", FRICTION_MODEL: "friction model"}
SOURCE_LABELS[NOT_MODELLED] = "what is not modelled"
DOMINANT = 10.0  # times the error of the method: where that of the model is greater, no ± is shown

DONE, DOUBTFUL, FAILED = "done", "doubtful", "failed"
STATUSES = {
    DONE: "the requested outputs are within the tolerance, as far as errors are known",
    DOUBTFUL: "a requested output misses the tolerance, or a model left its range; the flags say more",
    FAILED: "the run was aborted, or violates the energy balance: its figures are invalid",
}
"""Meaning of the first word of a report's status."""

THINNED = "the log is thinned: its figures are of the outputs kept, whose error is not known"
LEAST_SHARE = 1e-6  # of a figure: a smaller error of the model is not printed
ROUNDING = 1e-12  # of what is large in a unit: an error of a figure that is nearly 0
DERIVED_UNITS = {
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
    """The judgement of a run by its model errors, error estimate, figures, and the status by its figures.

    The error of a figure is that of the method alone, None where it is not known; errors of the model are listed apart.
    """
    keys, known, large = {}, {}, {}
    method, sizes = estimate.of_figures(figures), unit_sizes(figures)
    for figure in dict.fromkeys((*method, *errors.figures)):
        parts = ({METHOD: method[figure]} if figure in method else {}) | dict(errors.figures.get(figure, {}))
        if figures.get(figure) is None or not parts:
            continue
        keys[f"{figure}_error"] = parts.get(METHOD)
        known[figure] = {source: error for source, error in parts.items() if not _is_unknown(error)}
        largest = max(map(max_magnitude, known[figure].values()), default=0.0)
        if is_negligible(max_magnitude(figures[figure]), largest):
            continue
        unit = label_and_unit(figure)[1]
        share = estimate.tolerance if unit == "J" else ROUNDING  # works: beside what all loads would do over all ways
        negligible = max(errors.negligible.get(figure, 0.0), share * sizes.get(unit, 0.0))
        for source, error in known[figure].items():
            if is_large_error(figures[figure], error, unit) and not max_magnitude(error) <= negligible:
                large.setdefault(figure, source)
    keys["large_errors"] = dict(large)
    keys["errors_by_source"] = {figure: parts for figure, parts in known.items() if parts}
    by_source = {
        source: {figure: parts[source] for figure, parts in known.items() if source in parts}
        for source in SOURCE_LABELS
    }
    keys["model_errors"] = {source: parts for source, parts in by_source.items() if parts}
    outputs = {name: (output, errors.outputs.get(name, ())) for name, output in estimate.of_outputs().items()}
    keys["wanted_errors"] = {name: _output_keys(*output, estimate.tolerance) for name, output in outputs.items()}
    keys["errors_unknown"] = ({METHOD: estimate.note} if estimate.note else {}) | dict(errors.notes)
    if estimate.horizon is not None:
        keys["horizon_s"] = estimate.horizon
    sentences = {name: _tolerance_sentence(name, *output, estimate) for name, output in outputs.items()}
    exceeded = {name: sentence for name, sentence in sentences.items() if sentence}
    flags = ()
    large = {figure: source for figure, source in large.items() if errors.integral_of.get(figure) not in large}
    if large:
        remedies = {METHOD: estimate.smaller} | dict(errors.mends)
        remedy = "; ".join(filter(None, (remedies.get(source) for source in dict.fromkeys(large.values()))))
        phrases = (
            _figure_phrase(figure, figures[figure], known[figure][source], source, errors.notes)
            for figure, source in large.items()
        )
        sentence = f"the error is over {100.0 * LARGE:g} % of the figure: {'; '.join(phrases)}"
        flags = (f"{sentence}; to reduce it: {remedy}" if remedy else sentence,)
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
    keys |= {"model_errors": {part.source: part.error for part in model}} if model else {}
    return keys if output.until is None else keys | {"error_up_to_horizon": output.until}


def _tolerance_sentence(name: str, output: OutputError, model: tuple[ModelError, ...], estimate: Estimate) -> str:
    """A sentence on the errors of an output that exceed the tolerance, as NaN does, and their remedies; "" for none."""
    tolerance, sentences = estimate.tolerance, []
    if output.error is not None and not output.error <= tolerance:
        when = _when(output, tolerance)
        location = f" ({when})" if when else ""
        if output.until:
            location += f", {output.until:.2g} up to {estimate.horizon:.6g} s"
        remedy = estimate.smaller if estimate.horizon is None else LATER
        sentences.append(
            f"{name}: the error of the method is {output.error:.2g} {output.norm}{location}, more than the requested "
            f"{tolerance:g}: {remedy}"
        )
    sentences += [
        f"{name}: the error by {SOURCE_LABELS.get(part.source, part.source)} is {part.error:.2g} {output.norm}, "
        f"more than the requested {tolerance:g}{': ' if part.mend else ''}{part.mend}"
        for part in model
        if not part.error <= tolerance
    ]
    return "; ".join(sentences)


def displayed_errors(result: Mapping[str, Any], figure: str, size: float) -> tuple[float | None, float | None]:
    """The error that limits the digits of a figure of this size in a table, and that printed behind ±; None for none.

    The latter is the method's, and not printed where that of the model is far greater, as it would suggest too high an
    accuracy; of a figure that is 0 within its greatest error it is that error.
    """
    method = greatest_error(result.get(f"{figure}_error"))
    models = (greatest_error(errors.get(figure)) for errors in result.get("model_errors", {}).values())
    known = [error for error in (method, *models) if error is not None]
    largest = max(known, default=None)
    if is_negligible(size, largest):
        return largest, largest
    return largest, None if method is None or largest > DOMINANT * method else method


def model_error_lines(result: Mapping[str, Any]) -> list[str]:
    """The errors of the model in a report, one line a source: its greatest over a figure."""
    lines = []
    for source, errors in result.get("model_errors", {}).items():
        sizes = {key: max_magnitude(result[key]) for key in errors if result.get(key) is not None}
        shares = {key: max_magnitude(errors[key]) / size for key, size in sizes.items() if size > 0.0}
        if not max(shares.values(), default=0.0) > LEAST_SHARE:
            continue
        figure = max(shares, key=shares.__getitem__)
        label, unit = label_and_unit(figure)
        label = label_in_result(label, result.get("errors_unknown", {}))
        size, share = f"{two_digits(max_magnitude(errors[figure]))} {unit}", shares[figure]
        lines.append(f"{SOURCE_LABELS[source]}: up to {f'{100.0 * share:.2g} %' if share < 1.0 else size} ({label})")
    return lines


def _is_unknown(error) -> bool:
    return error is None or (isinstance(error, list) and None in error)


def failed_status(failure: Mapping[str, Any]) -> str:
    """The status of a run that broke off, by what `run.failure.failure_keys` says of it."""
    return f"{FAILED}: {failure.get('failure_reason', 'broken off')}"


def is_large_error(value, error, unit: str) -> bool:
    """True for an error above a tenth of its figure, of the greatest of a list, and of the amplitude of a level."""
    allowed = 20.0 * math.log10(1.0 + LARGE) if unit == "dB" else LARGE * max_magnitude(value)
    return not max_magnitude(error) <= allowed


def unit_sizes(figures: Mapping[str, Any]) -> dict[str, float]:
    """The greatest size of a run's figures by unit, also by DERIVED_UNITS; 1 rad at least."""
    sizes = {"rad": 1.0}
    for key, value in figures.items():
        values = value if isinstance(value, list) else [value]
        if values and all(isinstance(number, (int, float)) and math.isfinite(number) for number in values):
            unit = label_and_unit(key)[1]
            sizes[unit] = max(sizes.get(unit, 0.0), max_magnitude(values))
    derived = {
        unit: math.prod(sizes[base] ** power for base, power in powers.items())
        for unit, powers in DERIVED_UNITS.items()
        if all(sizes.get(base) for base in powers)
    }
    return sizes | {unit: max(size, sizes.get(unit, 0.0)) for unit, size in derived.items()}


def max_magnitude(value) -> float:
    """The greatest magnitude of a number or of a list, 0 of an empty one; NaN where one is."""
    return float(np.abs(value).max(initial=0.0))


def _figure_phrase(figure: str, value, error, source: str, unknown: Mapping[str, str]) -> str:
    """A figure with a large error, and the main source of the error."""
    label, unit = label_and_unit(figure)
    label = label_in_result(label, unknown)
    greatest = max_magnitude(error)
    size = rounded_to_error(max_magnitude(value), greatest, 2)
    return f"{label} {size} ± {two_digits(greatest)}{with_unit(unit)}, mostly {SOURCE_LABELS.get(source, source)}"


def output_error_text(result: Mapping[str, Any]) -> str:
    """A row of `wanted_errors` whose error is known: by how much, what was requested, and where."""
    parts = [f"{two_digits(result['error'])} {result['norm']}, requested {result['tolerance']:g}", result["where"]]
    if before_horizon := result.get("error_up_to_horizon"):
        parts.append(f"{two_digits(before_horizon)} up to the horizon")
    return "; ".join(part for part in parts if part)


BLOCK_OUTPUTS = 50  # outputs at most in the blocks that figures are made of


class ReportBuilder:
    """Collects the figures, model errors and error estimate of a run from blocks of any length.

    A writer whose attribute `in_stretches` is False gives the same to the bit for many pieces at once, and gets them.
    """

    def __init__(self, figures: Figures, choice: Choice, model_errors: ModelErrors, estimate: Estimate | None = None):
        self.choice, self.outputs, self.missing = choice, 0, 0
        self._writers = figures, model_errors, estimate or Estimate(unknown=NO_SECOND_RUN)
        self._length, self._aligned = 0, BlockAligner(0)
        self._last_ns, self._following = 0, None

    def add(self, block: Block) -> None:
        """Take a block; outputs missing before it are counted."""
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
                    for part in split_block(piece, self._length):
                        writer.add(part)
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
        """The report so far; raises LogError without an output. After the `last` report no block may be added.

        `failure` describes what broke the run off, whose status is then failed.
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

    Of a recording without a scene, and of a log without the records that its figures need (of an earlier version),
    every channel of one number is reported, but for figures that its kind computes from records. Cost and failure are
    those of the log's own record, if it has one.
    """
    kind = KINDS[log.scene.kind] if log.scene else None
    needed = kind is not None and any(table.needed for table in kind.records(log.scene.parameters))
    if kind is None or (needed and not log.has_records):
        meanings = kind.meanings_of() if kind else ()
        figures, model = ChannelFigures(None, log.choice, log.channels, meanings), UnknownErrors(None, log.choice)
        estimate = Estimate(unknown=NO_SECOND_RUN)
    else:
        parameters = log.scene.parameters
        figures, model = kind.figures_of(parameters, log.choice), kind.model_errors(parameters, log.choice)
        estimate = estimate_of(kind, parameters, log.choice)
    if log.kept_rate:
        estimate = Estimate(unknown=THINNED)
    gathering = ReportBuilder(figures, log.choice, model, estimate)
    for block in log.blocks() if blocks is None else blocks:
        gathering.add(block)
    record = log.report or {}
    report = gathering.report(log.scene.name if log.scene else "", *_cost(record), failure=logged_failure(record))
    return report, 0 if log.kept_rate else gathering.missing


def _cost(record: dict) -> tuple[float, dict[str, int]]:
    """Seconds and counts of a run from the record in its log; NaN and none without one, as in a recording."""
    try:
        costs = {name: int(count) for name, count in record.get("costs", {}).items()}
        return float(record.get("compute_s", math.nan)), costs
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
        total = math.fsum(errors.values())
        if not 0.0 < size < math.inf or not total > LEAST_SHARE * size:
            continue
        label, unit, factor = readable_label(key, size)
        number, error = rounded_to_error(factor * size, factor * total), two_digits(factor * total)
        label = label_in_result(label, report.errors.get("errors_unknown", {}))
        text = f"{label}: {number} ± {error}{with_unit(unit)}"
        shares = {SOURCE_LABELS.get(source, source): part / size for source, part in errors.items() if part > 0.0}
        rows.append((text, shares))
    return rows[:MOST_ROWS]


def plot(stream, path) -> Path:
    """Draw a run, which is simulated for it, or a log as a PNG; returns its path. Raises BearingTwinError."""
    picture = picture_of(stream)
    for block in stream.blocks():
        picture.add(block)
    return picture.write(path)
