"""What the figures of a run are worth: errors by source, and what was promised of the outputs wanted.

A kind's row names a `Doubt`, which sees the same blocks as the figures; a kind without one knows no error, and says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from bearing_twin.units import two_digits

if TYPE_CHECKING:
    from bearing_twin.report import Choice
    from bearing_twin.sample import Block

HERTZ_MENDS = "contact.normal: hertz is exact at no more cost"
METHOD, LAW, FRICTION_MODEL, LEFT_OUT = "method", "law", "friction_model", "left_out"
"""Sources of errors: the integration method, by a companion with a tighter tolerance, a bound or a closed form; the
elastic law, against exact Hertz at the geometry met; the friction model, against friction over the whole spot; what the
model leaves out, one sentence each, with a number where one can be computed."""


LARGE = 0.1  # of a figure: a greater error is marked, and is outside what a model is for
CHAOTIC = 1e3  # an error that grows so many times, beyond what is wanted, is the motion's own
LATER = (
    "beyond the run's horizon errors grow by the motion itself; a tenth of wanted.tolerance moves that instant on, and "
    "no tolerance mends what follows"
)


def horizon(grown: float, since: str, kept: float) -> str:
    """The note on a run whose errors have grown so many times since then, and were as wanted up to `kept` [s]."""
    return (
        f"errors have grown {two_digits(grown)} times since {since}: beyond {kept:.4g} s the motion depends on what "
        "nobody can give exactly, and only statistics of many runs hold"
    )


class Promise(NamedTuple):
    """One output wanted: its greatest `error` in the norm `norm`, against the `tolerance` asked for.

    `error` is None where none is known. `where` says in which body and when, `mend` what would make it smaller.
    `before` is the error up to the run's horizon, if it has one. `may` is what the error may be by the spread of such
    estimates, where that is known.
    """

    output: str
    norm: str
    error: float | None
    tolerance: float
    where: str
    mend: str
    before: float | None = None
    may: float | None = None

    @property
    def broken(self) -> bool:
        """Whether the error is known and may exceed what was asked; a NaN does."""
        most = self.error if self.may is None else self.may
        return most is not None and not most <= self.tolerance


class Dearest(NamedTuple):
    """Where a companion took most: `steps` of balls in one `place`, of so many `balls`.

    `least` are the steps of a ball that it takes in a run of whatever length.
    """

    steps: int
    place: str
    balls: int
    least: int


@dataclass(frozen=True)
class Errors:
    """Errors of a run: `figures[key][source]` in the unit and shape of that figure, the `promises`, and `notes`.

    Errors are greatest absolute ones. A source that is missing is not known for that figure; one without effect is 0.
    `notes` maps sources, and rows of what is left out, to a sentence; `mends` sources to what
    makes their errors smaller; `dearest` is where most was spent to find them. Up to `horizon` [s] the motion is known,
    if errors grow by themselves. `told_by` maps figures to those of which they are the sum over time: where both are
    doubtful, flags name the latter. `spared`: errors up to which flags do not name a figure, in its unit.
    """

    figures: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    promises: tuple[Promise, ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)
    mends: Mapping[str, str] = field(default_factory=dict)
    dearest: Dearest | None = None
    horizon: float | None = None
    told_by: Mapping[str, str] = field(default_factory=dict)
    spared: Mapping[str, float] = field(default_factory=dict)


class Doubt(Protocol):
    """Estimates the errors of a run's figures from its blocks and their records, so that a log gives the same.

    `errorless`, if it has that, are figures that have none: the scene's own, closed forms, what checks the numbers, and
    those of which a note tells. All others without an error are named as not known.
    """

    def add(self, block: Block) -> None:
        """Takes a block in, in the same pieces as the figures."""

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """The errors of these figures so far."""


class NothingKnown:
    """The doubt of a kind that estimates no error."""

    in_stretches = False

    def __init__(self, parameters, choice: Choice):
        pass

    def add(self, block: Block) -> None:
        """Takes nothing in."""

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """None, which is said."""
        return Errors(notes={METHOD: "this kind of scene estimates no errors: those of its figures are not known"})
