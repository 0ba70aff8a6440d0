"""The figures of impacts, written once for spheres, discs and beams: a function of outputs and records alone."""

import math
from typing import Any

import numpy as np

from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.kinds.figures import adds_up

CONTACT = Table(
    "contact",
    (
        Channel("time", "s", (), "end of the contact"),
        Channel("start", "s", (), "begin of the contact"),
        Channel("duration", "s", (), "of the contact"),
        Channel("peak_force", "N", (), "greatest contact force"),
        Channel("impulse", "N s", (), "of the contact force"),
        Channel("greatest_approach", "m", (), "greatest mutual approach"),
        Channel("leaving_speed", "m/s", (), "relative speed away at its end"),
        Channel("energy_gained", "J", (), "by the numerical method"),
    ),
    "a contact that has ended",
)
MEANINGS = {
    "peak_force_n": "contact force, greatest over all contacts that have ended",
    "contact_duration_s": "time in contact, sum over all contacts that have ended",
    "contacts": "the contacts that have ended, one by one: begin, duration, greatest force, impulse of the force",
    "greatest_approach_m": "mutual approach, greatest over all contacts that have ended",
    "restitution": "relative speed away over that before, after the last contact that has ended",
    "energy_closure": "energy gained (+) or lost (-) by the numerical method over the initial energy, whole motion",
    "impulse_ns": "of the contact force, sum over all contacts that have ended",
    "impact_speed_m_s": "relative speed at the first touch",
}
FIGURES = ("peak_force_n", "contact_duration_s", "greatest_approach_m", "restitution", "impulse_ns")
START, DURATION, PEAK_FORCE, IMPULSE, DEEPEST, LEAVING, GAINED = range(1, 8)


def tables(parameters) -> tuple[Table, ...]:
    """Tables of the records of two bodies."""
    return (CONTACT,)


def contact_rows(contacts, deepest, leaving: float, gained: float) -> np.ndarray:
    """Rows (n, columns) of CONTACT; the last one carries the speed away and the energy gained in all [J]."""
    rows = np.zeros((len(contacts), len(CONTACT.columns)))
    for row, contact, depth in zip(rows, contacts, deepest, strict=True):
        end = contact.start + contact.duration
        row[:] = end, contact.start, contact.duration, contact.peak_force, contact.impulse, depth, 0.0, 0.0
    if len(rows):
        rows[-1, LEAVING], rows[-1, GAINED] = leaving, gained
    return rows


class ImpactFigures:
    """Gathers the records of an impact and its first and last output; `speed` [m/s] is that of the first touch."""

    def __init__(self, parameters, choice, speed: float):
        self.parameters, self.choice, self.speed = parameters, choice, speed
        self.until, self.initial_energy = 0.0, None
        self.last: dict[str, np.ndarray] = {}
        self._rows: list[np.ndarray] = []

    def add(self, block: Block) -> None:
        if self.initial_energy is None:
            self.initial_energy = float(block.values["kinetic_energy"][0])
        self._rows.append(block.records.get("contact", np.empty((0, len(CONTACT.columns)))))
        self.last = {name: values[-1] for name, values in block.values.items() if values.ndim == 1}
        self.until = 1e-9 * float(block.time_ns[-1])

    @property
    def contacts(self) -> np.ndarray:
        """The contacts so far, rows of CONTACT."""
        return np.concatenate(self._rows) if self._rows else np.empty((0, len(CONTACT.columns)))

    @property
    def peak_force(self) -> float:
        """Greatest contact force [N]."""
        return float(self.contacts[:, PEAK_FORCE].max(initial=0.0))

    @property
    def greatest_approach(self) -> float:
        """Greatest mutual approach [m]."""
        return float(self.contacts[:, DEEPEST].max(initial=0.0))

    @property
    def restitution(self) -> float | None:
        """Relative speed away over relative speed before; None before the first contact has ended."""
        return float(self.contacts[-1, LEAVING]) / self.speed if len(self.contacts) else None

    @property
    def energy_closure(self) -> float:
        """Energy gained (+) or lost (-) by the numerical method, as a share of the initial energy."""
        gained = math.fsum(self.contacts[:, GAINED])
        return gained / self.initial_energy if self.initial_energy else 0.0

    def figures(self) -> dict[str, Any]:
        """Numbers by SI-suffixed keys, over all contacts that have ended."""
        contacts = self.contacts
        return {
            "peak_force_n": self.peak_force,
            "contact_duration_s": sum(map(float, contacts[:, DURATION])),
            "contacts": [
                {
                    "start_s": float(row[START]),
                    "duration_s": float(row[DURATION]),
                    "peak_force_n": float(row[PEAK_FORCE]),
                    "impulse_ns": float(row[IMPULSE]),
                }
                for row in contacts
            ],
            "greatest_approach_m": self.greatest_approach,
            "restitution": self.restitution,
            "energy_closure": self.energy_closure,
            "impulse_ns": math.fsum(contacts[:, IMPULSE]),
            "impact_speed_m_s": self.speed,
        }

    def flags(self) -> list[str]:
        """True if the outputs hold the whole contact."""
        last = max((float(row[START] + row[DURATION]) for row in self.contacts), default=0.0)
        if self.until < last:
            return [f"the outputs end at {self.until:.4g} s, before the contact does at {last:.4g} s"]
        return []

    def status(self) -> str:
        return "done" if adds_up(self.energy_closure, self.parameters) else "failed: energy"


class PairFigures(ImpactFigures):
    """The figures of two bodies on a line.

    `doubts(parameters, peak force, contact time)` gives warnings of conditions outside the theory.
    """

    def __init__(self, doubts, parameters, choice):
        super().__init__(parameters, choice, parameters.motion.speed)
        self._doubts = doubts

    def flags(self) -> list[str]:
        """Warnings: conditions outside the theory, and outputs that end before the contact."""
        if not len(self.contacts):
            return []
        duration = float(self.contacts[:, DURATION].min())
        return self._doubts(self.parameters, self.peak_force, duration) + super().flags()
