"""What the figures of a run are worth: errors by source, and what was promised of the outputs wanted.

A kind's row names a `Doubt`, which sees the same blocks as the figures; a kind without one knows no error, and says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

if TYPE_CHECKING:
    from bearing_twin.base.report import Choice
    from bearing_twin.base.sample import Block

HERTZ_MENDS = "contact.normal: hertz is exact at no more cost"
METHOD, LAW, FRICTION_MODEL, LEFT_OUT = "method", "law", "friction_model", "left_out"
"""Sources of errors: the integration method, by a companion with a tighter tolerance, a bound or a closed form; the
elastic law, against exact Hertz at the geometry met; the friction model, against friction over the whole spot; what the
model leaves out, one sentence each, with a number where one can be computed."""


LARGE = 0.1  # of a figure: a greater error is marked, and is outside what a model is for
LATER = (
    "beyond the run's horizon errors grow by the motion itself; a tenth of wanted.tolerance moves that instant on, and "
    "no tolerance mends what follows"
)


class ModelError(NamedTuple):
    """The error of a requested output by a `source` in the model, in the output's norm, and what would reduce it."""

    source: str
    error: float
    mend: str = ""


class Promise(NamedTuple):
    """A requested output: its greatest `error` by the method in the norm `norm`, against the `tolerance`.

    `error` is None where none is known. `where` says when it was greatest, `mend` what would make it smaller. `before`
    is the error up to the run's horizon, if it has one. `model` are the errors of the model.
    """

    output: str
    norm: str
    error: float | None
    tolerance: float
    where: str
    mend: str
    before: float | None = None
    model: tuple[ModelError, ...] = ()

    @property
    def exceeded(self) -> bool:
        """True if the error of the method is known and exceeds the tolerance; a NaN does."""
        return self.error is not None and not self.error <= self.tolerance

    @property
    def broken(self) -> bool:
        """True if any error that is known exceeds the tolerance."""
        return self.exceeded or any(not one.error <= self.tolerance for one in self.model)


@dataclass(frozen=True)
class Errors:
    """Errors of a run: `figures[key][source]` in the unit and shape of that figure, the `promises`, and `notes`.

    `outputs` are the errors of requested outputs. Errors are greatest absolute ones. A source that is missing is not
    known for that figure; one without effect is 0. `notes` maps sources, and rows of what is left out, to a sentence;
    `mends` sources to what makes their errors smaller. Up to `horizon` [s] the motion is known, if errors grow by
    themselves. `told_by` maps figures to those of which they are the sum over time: where both are doubtful, flags name
    the latter. `spared`: errors up to which flags do not name a figure, in its unit.
    """

    figures: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    promises: tuple[Promise, ...] = ()
    outputs: Mapping[str, tuple[ModelError, ...]] = field(default_factory=dict)
    notes: Mapping[str, str] = field(default_factory=dict)
    mends: Mapping[str, str] = field(default_factory=dict)
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


class ModelDoubt:
    """The model errors of a kind, by its law, its friction model and what it leaves out; a kind gives those it has."""

    in_stretches = False
    outputs: tuple[str, ...] = ()

    def __init__(self, parameters, choice: Choice):
        self.parameters, self.choice = parameters, choice

    def add(self, block: Block) -> None:
        """Takes a block in."""

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of the elastic law by figure."""
        return {}

    def law_of(self, output: str) -> tuple[float, str]:
        """Error of the elastic law in a requested output, in its norm, and what would reduce it."""
        return 0.0, ""

    def friction(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of the friction model by figure."""
        return {}

    def left_out(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of what the model leaves out by figure."""
        return {}

    def notes(self) -> dict[str, str]:
        """Sentences on what is not in the errors, by source and by what is left out."""
        return {}

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """The model errors of these figures."""
        found: dict[str, dict[str, Any]] = {}
        by_source = {LAW: self.law(figures), FRICTION_MODEL: self.friction(figures), LEFT_OUT: self.left_out(figures)}
        for source, errors in by_source.items():
            for key, error in errors.items():
                found.setdefault(key, {})[source] = error
        outputs = {name: (ModelError(LAW, *self.law_of(name)),) for name in self.outputs}
        return Errors(found, outputs=outputs, notes=self.notes(), mends={LAW: HERTZ_MENDS})


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
