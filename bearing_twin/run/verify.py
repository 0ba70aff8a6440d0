"""A log against a fresh simulation of the scene that is stored in it."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from bearing_twin.base.errors import LogError
from bearing_twin.base.report import CutShort
from bearing_twin.base.sample import Block
from bearing_twin.base.units import UNITS, with_unit
from bearing_twin.run.second_run import SECOND_RUN
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
        found = {"samples": self.samples, "greatest_deviation": self.greatest, "deviations": self.deviations}
        found |= {"records_not_as_many": list(self.recounted)} if self.recounted else {}
        found |= {"outputs_missing": self.missing} if self.missing else {}
        found |= self.cut_short.as_dict() if self.cut_short else {}
        return found | ({"records_missing": list(self.lacks)} if self.lacks else {})

    def differences(self) -> dict[str, str]:
        """What deviates, in SI units."""
        found = {name: self._size(name) for name, size in self.deviations.items() if size}
        return found | dict.fromkeys(self.recounted, "more or fewer records than in a new run")

    def _size(self, name: str) -> str:
        unit = self.units.get(name, "")
        return f"{self.deviations[name]:.3g}{with_unit(UNITS[unit].shown if unit in UNITS else unit)}"

    def _sentence(self) -> str:
        """Sentence on a deviation and its possible cause; "" where there is none."""
        off = {name: size for name, size in self.deviations.items() if size and name not in self.recounted}
        parts = []
        if off:
            worst = max(off, key=off.__getitem__)
            place = worst.replace("_", " ") if worst in self.units else f"records of {worst}, SI"
            parts.append(f"deviates by up to {self._size(worst)} ({place}) from a new run")
        if self.recounted:
            parts.append(f"has more or fewer records of {', '.join(self.recounted)} than a new run")
        why = "as it does where speed or load were commanded: the scene in it knows nothing of that"
        return f"the log {' and '.join(parts)}, {why}" if parts else ""

    def warnings(self) -> list[str]:
        """Reasons why the log is not the whole run of its scene, one sentence each."""
        found = [self._sentence()] if self._sentence() else []
        if self.missing:
            found.append(f"{self.missing} outputs are missing in the log, and nothing is known of them")
        if self.cut_short:
            found.append(self.cut_short.sentence())
        if self.lacks:
            found.append(f"the log has no records, as of {', '.join(self.lacks)}: outputs alone were compared")
        return found


Progress = Callable[[float], None]


def verify(log, progress: Progress | None = None) -> Verification:
    """Simulates the scene stored in a log again and compares every output; raises LogError where that cannot be done.

    Commands given while the log was made are read off the inner ring's recorded speed and rejected: such a log is
    not the scene's own run. A log of an earlier version may hold fewer channels, or no records; what it has is
    compared, and so are those outputs alone that a log holds which begins late, or was read with
    `allow_gaps`: the others are simulated without comparing. `progress` takes the time [s] reached.
    """
    if log.scene is None:
        raise LogError(
            "this log holds no scene, so it cannot be simulated again; verify a log written by `simulate --out`"
        )
    simulation = Simulation(log.scene)
    names, units = [channel.name for channel in log.channels], {one.name: one.unit for one in simulation.channels}
    if not set(names) <= {channel.name for channel in simulation.channels}:
        raise LogError("this log was written by another version: its channels differ; simulate the scene again")
    deviations, samples, missing, made, recounted, seen = dict.fromkeys(names, 0.0), 0, 0, set(), set(), set()
    for block in log.blocks():
        if block.first_sequence <= simulation.sequence:
            raise LogError(
                f"the run in this log starts again: output {block.first_sequence} follows {simulation.sequence}; "
                "verify one of its runs, as read_log(path, run=1) gives it"
            )
        apart = block.first_sequence - simulation.sequence - 1
        missing += apart if samples and not log.kept_rate else 0
        again = _again(simulation, block, progress)
        if block.first_sequence != again.first_sequence or not np.array_equal(block.time_ns, again.time_ns):
            raise LogError(
                f"outputs of this log from number {block.first_sequence} on stand at other times than its scene's"
            )
        for name in names:
            difference = np.abs(block.values[name] - again.values[name])
            deviations[name] = max(deviations[name], float(difference.max()))
        seen.update(block.records)
        made.update(name for name, rows in again.records.items() if len(rows))
        for name, rows in (again.records if log.has_records else {}).items():  # earlier versions wrote none
            if name == SECOND_RUN and (
                name not in seen or getattr(log, "begins", 0)
            ):  # nor did they, or its second run began later
                continue
            found = block.records.get(name, np.empty((0, rows.shape[1])))
            rows = rows[:, : found.shape[1]]  # earlier versions wrote fewer columns
            if apart and not log.kept_rate:  # records of outputs that the log lacks may be missing, too
                rows = rows[max(len(rows) - len(found), 0) :]
            if len(found) > len(rows):  # a recording may end before the outputs that its last records went ahead of
                found = found[np.rint(1e9 * found[:, 0]) <= block.time_ns[-1]]
            same = found.shape == rows.shape
            difference = float(np.abs(found - rows).max(initial=0.0)) if same else np.inf
            deviations[name] = max(deviations.get(name, 0.0), difference)
            recounted.update(() if same else (name,))
        samples += len(block)
        if progress:
            progress(1e-9 * block.time_ns[-1])
    lacks = () if log.has_records else tuple(sorted(made))
    return Verification(samples, deviations, missing, lacks, log.cut_short, units, tuple(sorted(recounted)))


def _again(simulation: Simulation, block: Block, progress: Progress | None) -> Block:
    """The outputs of `block` from the simulation, with the records since its last ones.

    Those before it that the log does not hold are passed over.
    """
    parts, last = [], block.first_sequence - 1
    while simulation.sequence < last:
        parts.append(simulation.advance(min(simulation.chunk_outputs, last - simulation.sequence)).records)
        if progress:
            progress(1e-9 * simulation.time_ns)
    again = simulation.advance(len(block))
    parts.append(again.records)
    names = dict.fromkeys(name for records in parts for name in records)
    records = {name: np.concatenate([one[name] for one in parts if name in one]) for name in names}
    return dataclasses.replace(again, records=records)
