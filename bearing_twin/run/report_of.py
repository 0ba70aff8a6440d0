"""The report on a log: the figures that the run itself printed, from the outputs in the log alone."""

import math
from collections.abc import Iterable

from bearing_twin.base.report import Report
from bearing_twin.base.sample import Block
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.doubt import NothingKnown
from bearing_twin.kinds.plain_figures import PlainFigures
from bearing_twin.run.failure import told_in
from bearing_twin.run.gathering import Gathering
from bearing_twin.run.second_run import NoEstimate, estimate_of


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
        figures, doubt = PlainFigures(None, log.choice, log.channels, taken), NothingKnown(None, log.choice)
        estimate = NoEstimate()
    else:
        made_of = log.scene.parameters, log.choice
        figures, doubt, estimate = kind.figures_of(*made_of), kind.doubt(*made_of), estimate_of(kind, *made_of)
        if log.kept_rate:
            estimate = NoEstimate("the log is thinned: its figures are of the outputs kept, whose error is not known")
    gathering = Gathering(figures, log.choice, doubt, estimate)
    for block in log.blocks() if blocks is None else blocks:
        gathering.add(block)
    said = log.report or {}
    report = gathering.report(log.scene.name if log.scene else "", *_cost(said), failure=told_in(said))
    return report, 0 if log.kept_rate else gathering.missing


def _cost(said: dict) -> tuple[float, dict[str, int]]:
    """Seconds and counts of a run as its log says them; NaN and none where it does not, as in a recording."""
    try:
        costs = {name: int(count) for name, count in said.get("costs", {}).items()}
        return float(said.get("compute_s", math.nan)), costs
    except (TypeError, ValueError, AttributeError, OverflowError):
        return math.nan, {}
