"""Errors of the figures of a run by source: of the model, from its blocks, and of the method, by a second run.

A kind's row names its `ModelErrors`, which see the same blocks as the figures, and its `Comparison`, which makes the
second run finer and compares the requested outputs; a kind without them knows no error, and says so.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import numpy as np

    from bearing_twin.base.report import Choice
    from bearing_twin.base.sample import Block

HERTZ_MENDS = "contact.normal: hertz is exact at no more cost"
METHOD, LAW, BEAM_THEORY, FRICTION_MODEL, NOT_MODELLED = "method", "law", "beam_theory", "friction_model", "left_out"
"""Sources of errors: the integration method, by a second run; the elastic law, against exact Hertz at the geometry met;
the beam theory, against Timoshenko's; the friction model, against friction over the whole contact patch; what is not
modelled, one sentence each, with a number where one can be computed."""
LARGE = 0.1  # of a figure: a greater error is marked, and is outside what a model is for
LATER = (
    "after the run's horizon the motion itself amplifies every error; a tenth of wanted.tolerance delays the horizon, "
    "and no tolerance removes it"
)


class ModelError(NamedTuple):
    """The error of a requested output by a `source` in the model, in the output's norm, and what would reduce it."""

    source: str
    error: float
    mend: str = ""


@dataclass(frozen=True)
class Errors:
    """Errors of the model in a run: `figures[key][source]` in the unit and shape of that figure.

    `outputs` are the errors of requested outputs. Errors are greatest absolute ones. A source that is missing is not
    known for that figure; one without effect is 0. `notes` maps sources, and rows of what is not modelled, to a
    sentence; `mends` sources to what makes their errors smaller. `integral_of` maps figures to those of which they are
    the sum over time: where both have large errors, flags name the latter. `negligible`: errors up to which flags do
    not name a figure, in its unit.
    """

    figures: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    outputs: Mapping[str, tuple[ModelError, ...]] = field(default_factory=dict)
    notes: Mapping[str, str] = field(default_factory=dict)
    mends: Mapping[str, str] = field(default_factory=dict)
    integral_of: Mapping[str, str] = field(default_factory=dict)
    negligible: Mapping[str, float] = field(default_factory=dict)


class ModelErrors:
    """The model errors of a kind, from the blocks of a run, so that a log gives the same.

    A kind gives those it has: by its law, its friction model, and what it does not model.
    """

    in_stretches = False  # blocks may hold many outputs
    outputs: tuple[str, ...] = ()
    law_source = LAW
    law_mend = HERTZ_MENDS  # what would reduce the error of the law

    def __init__(self, parameters, choice: Choice):
        self.parameters, self.choice = parameters, choice

    def add(self, block: Block) -> None:
        """Add a block, the same as to the figures."""

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of the elastic law, or what `law_source` names, by figure."""
        return {}

    def law_of(self, output: str) -> float:
        """Error of the elastic law in a requested output, in its norm."""
        return 0.0

    def friction(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of the friction model by figure."""
        return {}

    def not_modelled(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of what the model leaves out by figure."""
        return {}

    def notes(self) -> dict[str, str]:
        """Sentences on errors that are not computed, by source and by effect that is not modelled."""
        return {}

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """The model errors of these figures so far."""
        by_figure: dict[str, dict[str, Any]] = {}
        by_source = {self.law_source: self.law(figures), FRICTION_MODEL: self.friction(figures)}
        by_source[NOT_MODELLED] = self.not_modelled(figures)
        for source, errors in by_source.items():
            for key, error in errors.items():
                by_figure.setdefault(key, {})[source] = error
        outputs = {name: (ModelError(self.law_source, self.law_of(name), self.law_mend),) for name in self.outputs}
        return Errors(by_figure, outputs=outputs, notes=self.notes(), mends={self.law_source: self.law_mend})


class UnknownErrors(ModelErrors):
    """The model errors of a kind that estimates none, which is said."""

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        return Errors(notes={METHOD: "this kind of scene estimates no errors: those of its figures are not known"})


# The second run

SECOND_RUN, NO_CHECK = "second_run", "none"
TOLERANCE = 0.1  # of the second run over that of the run (`python bench/second_run.py --factor 5` tries another)
SMALLER = "set a tenth of wanted.tolerance"


def is_checked(parameters) -> bool:
    """True if a scene specifies a second run."""
    return getattr(getattr(parameters, "solver", None), "check", NO_CHECK) == SECOND_RUN


def unchecked(parameters):
    """The same parameters without a second run."""
    if not is_checked(parameters):
        return parameters
    return dataclasses.replace(parameters, solver=dataclasses.replace(parameters.solver, check=NO_CHECK))


def with_tolerance(parameters, choice: Choice, least: float) -> tuple[Any, Choice]:
    """Parameters and choice of a second run whose tolerance is `TOLERANCE` of the run's.

    At the `least` tolerance of a kind it is larger by the same factor: the second run is then the coarser one.
    """
    tolerance_used = parameters.wanted.tolerance if math.isnan(choice.setting) else choice.setting
    share = TOLERANCE if TOLERANCE * tolerance_used >= least * (1.0 - 1e-9) else 1.0 / TOLERANCE
    wanted = dataclasses.replace(parameters.wanted, tolerance=share * parameters.wanted.tolerance)
    return dataclasses.replace(parameters, wanted=wanted), choice._replace(setting=share * choice.setting)


def finer_setting(first: float, least: float, most: float = math.inf) -> float:
    """Tolerance of a step of the second run: `TOLERANCE` of its own, `most` at most; larger where that is too little.

    Above `most` something else than the tolerance sets the steps.
    """
    finer = min(TOLERANCE * first, most)
    return finer if finer >= least * (1.0 - 1e-9) else first / TOLERANCE


class Comparison:
    """The second run of a scene, and the requested outputs of both; a kind gives `differences` or `events`.

    `outputs` maps names to the norm of their error; the figures `exact` have no error of the method. `smaller` says
    what reduces that. Without a `choice` it knows its outputs alone.
    """

    exact: tuple[str, ...] = ("energy_closure",)
    grows = True  # errors may grow by the motion itself, which then has a horizon
    coarser = 1.0
    """Error of the second run over that of the run where its mesh or series is coarser, by their order, else 1.

    The difference is then that of the second run; over this it is the run's (Richardson)."""

    def __init__(self, parameters, choice: Choice | None):
        self.parameters, self.choice = parameters, choice
        self.outputs: Mapping[str, str] = {}

    def refined(self) -> tuple[Any, Choice] | None:
        """Parameters and choice of the second run; None where there is nothing to refine."""
        return None

    @property
    def smaller(self) -> str:
        return SMALLER

    def differences(self, first: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """By name: absolute differences (n,) at the outputs of two blocks, and the sizes (n,) they are relative to.

        The error so far is the greatest difference over the greatest size.
        """
        return {}

    def events(self, first, second) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """The same of what the figures of both runs gathered, such as contacts: times [s], differences, sizes."""
        return {}
