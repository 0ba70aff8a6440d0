"""Motion with contacts that begin and end: common to an ellipsoid on a plane and two bodies.

Each has a module with its functions of the core: `advance`, made by `advancing`, and the entries of its clock, beside
TIME, STEP and WRITTEN, and of its record. Their counts are COUNTED.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import IntegrationError, Stopped
from bearing_twin.base.stopping import SIGNALLED
from bearing_twin.contact.damping import damping_for_restitution, steady_ratio
from bearing_twin.contact.materials import Material, compliance
from bearing_twin.core import FLAG, INTEGER, INTEGERS_OUT, REAL, REALS, REALS_OUT, Function
from bearing_twin.numerics.statuses import FULL, OK, STOPPED, WORDS

FLOOR = 1e-4  # of the shortest contact: lift-offs and touches shorter than that are passed
RECORDS = 256  # completed in one call of the core
TIME, STEP, WRITTEN = 0, 1, 4
"""Of the clock: seconds, the next step, outputs written."""

COUNTED = ("steps", "rejections", "evaluations", "touches")
COUNTS = len(COUNTED)
PROPORTIONAL, STEADY, STEADY_RATIO = range(3)  # DampingLaw of core/contact/damping.hpp
FINEST, COARSEST = 1e-12, 1e-10
"""The least tolerance of a step, and the greatest at which the tolerance, and not the contact's own time, sets it."""


class CoreBodies(NamedTuple):
    """Bodies as the core takes them: their `numbers`, and the `points` of their friction's quadrature."""

    numbers: np.ndarray
    points: np.ndarray


def advancing(name: str) -> Function:
    """A function of the core that moves bodies on from a clock until an instant [s], and returns a status.

    Its arguments: bodies, plan, state, clock, record, state at the start of the last step, the instant; number and
    times [s] of outputs, the flag that stops it, their states; room for records of contacts that have ended, their
    number; counts.
    """
    moving = REALS, REALS, REALS, REALS_OUT, REALS_OUT, REALS_OUT, REALS_OUT, REAL
    return Function(
        name, INTEGER, (*moving, INTEGER, REALS, FLAG, REALS_OUT, INTEGER, REALS_OUT, INTEGERS_OUT, INTEGERS_OUT)
    )


def giving_outputs(name: str) -> Function:
    """A function of the core that writes the channels of states: bodies; number, states; width, rows."""
    return Function(name, None, (REALS, REALS, INTEGER, REALS, INTEGER, REALS_OUT))


def contact_numbers(contact, first: Material, second: Material) -> dict[str, Any]:
    """The numbers of the equations of motion from the section `contact`, by name.

    `sink` is the first body's share of the compliance [1], `damping` the numbers of the core's Damping.
    """
    damping = [PROPORTIONAL, contact.damping, contact.relaxation_time]
    if contact.restitution < 1.0 and contact.damping_law == "steady":
        damping = [STEADY_RATIO, steady_ratio(contact.restitution), 0.0]
    elif contact.viscosity > 0.0:
        damping = [STEADY, contact.viscosity, 0.0]
    elif contact.restitution < 1.0:
        damping[1] = damping_for_restitution(contact.restitution, contact.restitution_speed)
    return {
        "sink": compliance(first) / (compliance(first) + compliance(second)),
        "damping": damping,
        "friction": float(contact.friction_coefficient),
        "regularisation": float(contact.friction_regularisation),
    }


class BouncingMotion:
    """Bodies in motion: `advance` integrates one chunk and returns its outputs; the records are their contacts.

    A kind gives `core`, the module described above, `start()` with the first state, `outputs(states)` and
    `contacts(records)`, the rows of contacts that have ended; the names of the `bodies`, of which the first fails
    against the other; `failures` are sentences by status, `words` their reasons.
    """

    core: Any
    bodies: tuple[str, str]
    words: Mapping[int, str] = WORDS

    def __init__(self, body, plan, failures: Mapping[int, str]):
        self.body, self.plan, self.failures, self.stop = body, plan, failures, SIGNALLED
        self.reset()

    def reset(self) -> None:
        core = self.core
        self.state, self.clock = self.start(), np.zeros(core.CLOCK)
        self.clock[STEP] = math.inf
        self.record, self.counts = np.zeros(core.RECORD), np.zeros(COUNTS, np.int64)
        self._ended: list[np.ndarray] = []  # contacts since records were taken
        self._touched = -math.inf  # begin [s] of the last touch recorded
        self._last = np.zeros_like(self.state)  # the state at the start of the last step
        self._now = 0.0
        self.keep()

    def _arrays(self) -> tuple[np.ndarray, ...]:
        """All that steps change."""
        return self.state, self.clock, self.record, self.counts, self._last

    def keep(self) -> None:
        """Keeps what `take_back` needs."""
        rest = {"_ended": list(self._ended), "_touched": self._touched, "_now": self._now}
        self._before = [values.copy() for values in self._arrays()], rest

    def take_back(self) -> None:
        """Back to the last `keep`, as before the last `advance`."""
        arrays, rest = self._before
        for values, before in zip(self._arrays(), arrays, strict=True):
            values[...] = before
        vars(self).update(rest | {"_ended": list(rest["_ended"])})

    def first_outputs(self):
        """The outputs at the present instant."""
        return self.outputs(self.state[None].copy())

    def advance(self, times: np.ndarray, duration: float):
        """Integrates `duration` [s] and returns the outputs at `times` [s] from now; raises IntegrationError."""
        self.keep()
        due, until = np.ascontiguousarray(self._now + np.asarray(times, float)), self._now + duration
        states, finished = np.empty((len(due), len(self.state))), np.empty((RECORDS, self.core.RECORD))
        status, completed = FULL, np.zeros(1, np.int64)
        self.clock[WRITTEN] = 0.0
        while status == FULL:
            status = self.core.advance(
                *(*self.body, self.plan, self.state, self.clock, self.record, self._last, until),
                *(len(due), due, self.stop, states, RECORDS, finished, completed, self.counts),
            )
            self._ended.extend(finished[: completed[0]].copy())
        if status == STOPPED:
            raise Stopped(f"the computation was stopped at {self.clock[TIME]:.9g} s")
        if status != OK:
            raise self.failure(status)
        self._now = until
        return self.outputs(states)

    def failure(self, status: int) -> IntegrationError:
        """The error of a motion that cannot go on: when, why, and what to do."""
        seconds, (body, other) = float(self.clock[TIME]), self.bodies
        return IntegrationError(f"at {seconds:.9g} s {self.failures[status]}", self.words[status], seconds, body, other)

    def take_records(self) -> dict[str, np.ndarray]:
        """Begins and ends of contacts since the last call."""
        rows = [*self._ended, self.record] if self.clock[self.core.IN_CONTACT] else self._ended
        began = [row[self.core.BEGAN] for row in rows if row[self.core.BEGAN] > self._touched]
        ended = self.contacts(np.array(self._ended).reshape(-1, self.core.RECORD))
        self._ended = []
        self._touched = max(began, default=self._touched)
        return {"touch": np.array(began).reshape(-1, 1), "contact": ended}

    def costs(self) -> dict[str, int]:
        """Steps, rejected steps, evaluations of the rates, and the number of contacts."""
        return dict(zip(COUNTED, self.counts.tolist(), strict=False))
