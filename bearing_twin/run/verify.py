"""A log against a fresh simulation of the scene that is stored in it."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from bearing_twin.base.errors import LogError
from bearing_twin.base.report import CutShort
from bearing_twin.base.sample import Block
from bearing_twin.base.units import UNITS, with_unit
from bearing_twin.kinds.error_estimates import SECOND_RUN
from bearing_twin.run.simulation import Simulation


@dataclass(frozen=True)
class Verification:
    """Deviations of a log from a fresh simulation of the scene stored in it.

    `deviations` are of channels, in those of `units`, and of tables of records, over all of their columns; infinite for
    those that are `recounted`: the new run has more records, or fewer.
    """

    samples: int
    deviations: dict[str, float]
    missing: int = 0  # outputs between those of the log
    lacks: tuple[str, ...] = ()  # records of the new run, of which the log has no topic
    cut_short: CutShort | None = None  # where the log ends before its scene does
    units: Mapping[str, str] = field(default_factory=dict)
    recounted: tuple[str, ...] = ()

    @property
    def greatest(self) -> float:
        """The greatest absolute deviation of any channel, in that channel's unit."""
        return max(self.deviations.values(), default=0.0)

    def as_dict(self) -> dict:
        """For `--json`."""
        result = {"samples": self.samples, "greatest_deviation": self.greatest, "deviations": self.deviations}
        result |= {"records_not_as_many": list(self.recounted)} if self.recounted else {}
        result |= {"outputs_missing": self.missing} if self.missing else {}
        result |= self.cut_short.as_dict() if self.cut_short else {}
        return result | ({"records_missing": list(self.lacks)} if self.lacks else {})

    def differences(self) -> dict[str, str]:
        """The deviations by channel or table, as texts in SI units."""
        sizes = {name: self._size(name) for name, size in self.deviations.items() if size}
        return sizes | dict.fromkeys(self.recounted, "more or fewer records than in a new run")

    def _size(self, name: str) -> str:
        unit = self.units.get(name, "")
        return f"{self.deviations[name]:.3g}{with_unit(UNITS[unit].shown if unit in UNITS else unit)}"

    def _sentence(self) -> str:
        """Sentence on a deviation and its possible cause; "" where there is none."""
        deviating = {name: size for name, size in self.deviations.items() if size and name not in self.recounted}
        parts = []
        if deviating:
            worst = max(deviating, key=deviating.__getitem__)
            subject = worst.replace("_", " ") if worst in self.units else f"records of {worst}, SI"
            parts.append(f"deviates by up to {self._size(worst)} ({subject}) from a new run")
        if self.recounted:
            parts.append(f"has more or fewer records of {', '.join(self.recounted)} than a new run")
        cause = "as it does where speed or load were commanded: the scene in it knows nothing of that"
        return f"the log {' and '.join(parts)}, {cause}" if parts else ""

    def warnings(self) -> list[str]:
        """Reasons why the log is not the whole run of its scene, one sentence each."""
        sentences = [self._sentence()] if self._sentence() else []
        if self.missing:
            sentences.append(f"{self.missing} outputs are missing in the log, and nothing is known of them")
        if self.cut_short:
            sentences.append(self.cut_short.sentence())
        if self.lacks:
            sentences.append(f"the log has no records, as of {', '.join(self.lacks)}: outputs alone were compared")
        return sentences


Progress = Callable[[float], None]


def verify(log, progress: Progress | None = None) -> Verification:
    """Simulate the scene stored in a log again and compare every output; raises LogError where that is impossible.

    A run under commands is not that of its scene, and deviates. Of a log of an earlier version, with fewer channels or
    no records, and of one that begins late or was read with `allow_gaps`, what it holds is compared; other outputs are
    simulated without comparison. `progress` takes the time [s] reached.
    """
    if log.scene is None:
        raise LogError(
            "this log holds no scene, so it cannot be simulated again; verify a log written by `simulate --out`"
        )
    simulation = Simulation(log.scene)
    names, units = [channel.name for channel in log.channels], {c.name: c.unit for c in simulation.channels}
    if not set(names) <= set(units):
        raise LogError("this log was written by another version: its channels differ; simulate the scene again")
    deviations, samples, missing, recounted = dict.fromkeys(names, 0.0), 0, 0, set()
    logged_tables, fresh_tables = set(), set()
    for block in log.blocks():
        if block.first_sequence <= simulation.sequence:
            raise LogError(
                f"the run in this log starts again: output {block.first_sequence} follows {simulation.sequence}; "
                "verify one of its runs, as read_log(path, run=1) gives it"
            )
        gap = 0 if log.kept_rate else block.first_sequence - simulation.sequence - 1
        missing += gap if samples else 0
        fresh = _fresh_block(simulation, block, progress)
        if block.first_sequence != fresh.first_sequence or not np.array_equal(block.time_ns, fresh.time_ns):
            raise LogError(
                f"outputs of this log from number {block.first_sequence} on stand at other times than its scene's"
            )
        for name in names:
            deviations[name] = max(deviations[name], _deviation(block.values[name], fresh.values[name]))
        logged_tables.update(block.records)
        fresh_tables.update(name for name, rows in fresh.records.items() if len(rows))
        for name, rows in (fresh.records if log.has_records else {}).items():  # earlier versions wrote none
            if name == SECOND_RUN and (name not in logged_tables or getattr(log, "begins", 0)):
                continue  # written by later versions alone, or begun later
            deviation = _record_deviation(name, rows, block, gap)
            if deviation is None:
                recounted.add(name)
                deviation = np.inf
            deviations[name] = max(deviations.get(name, 0.0), deviation)
        samples += len(block)
        if progress:
            progress(1e-9 * block.time_ns[-1])
    lacks = () if log.has_records else tuple(sorted(fresh_tables))
    return Verification(samples, deviations, missing, lacks, log.cut_short, units, tuple(sorted(recounted)))


def _deviation(logged: np.ndarray, fresh: np.ndarray) -> float:
    """The greatest difference of two arrays; inf where one of them alone is NaN."""
    difference = np.abs(logged - fresh)
    difference[np.isnan(logged) & np.isnan(fresh)] = 0.0
    return float(np.nan_to_num(difference, nan=np.inf, posinf=np.inf).max(initial=0.0))


def _record_deviation(name: str, rows: np.ndarray, block: Block, gap: int) -> float | None:
    """The greatest deviation of the records of a table in a block from the fresh `rows`; None where more or fewer."""
    logged = block.records.get(name, np.empty((0, rows.shape[1])))
    rows = rows[:, : logged.shape[1]]  # earlier versions wrote fewer columns
    if gap:  # records of outputs that the log lacks may be missing, too
        rows = rows[max(len(rows) - len(logged), 0) :]
    if len(logged) > len(rows):  # a recording may end before the outputs that its last records preceded
        logged = logged[np.rint(1e9 * logged[:, 0]) <= block.time_ns[-1]]
    return _deviation(logged, rows) if logged.shape == rows.shape else None


def _fresh_block(simulation: Simulation, block: Block, progress: Progress | None) -> Block:
    """The outputs of `block` from the simulation, with all records since the last block.

    Outputs before it that the log lacks are simulated and dropped.
    """
    parts, last = [], block.first_sequence - 1
    while simulation.sequence < last:
        parts.append(simulation.advance(min(simulation.chunk_outputs, last - simulation.sequence)).records)
        if progress:
            progress(1e-9 * simulation.time_ns)
    fresh = simulation.advance(len(block))
    parts.append(fresh.records)
    names = dict.fromkeys(name for records in parts for name in records)
    records = {name: np.concatenate([recorded[name] for recorded in parts if name in recorded]) for name in names}
    return dataclasses.replace(fresh, records=records)
