"""The second run of a scene: how each kind makes it finer, and which of its outputs are compared."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from bearing_twin.base.report import Choice

if TYPE_CHECKING:
    import numpy as np

    from bearing_twin.base.sample import Block

SECOND_RUN, NO_CHECK = "second_run", "none"
TOLERANCE = 0.1  # of the second run over that of the run (`python bench/second_run.py --factor 5` tries another)
COARSER = 0.8
"""Divisions, modes and steps of the second run of a mesh or a series over those of the run: 0.5 to 0.6 of its work.

Errors of a mesh fall as divisions^-1.5 to -2.8, those of a series as the power -1 to -6 of modes and steps."""
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
    given = parameters.wanted.tolerance if math.isnan(choice.setting) else choice.setting
    share = TOLERANCE if TOLERANCE * given >= least * (1.0 - 1e-9) else 1.0 / TOLERANCE
    wanted = dataclasses.replace(parameters.wanted, tolerance=share * parameters.wanted.tolerance)
    return dataclasses.replace(parameters, wanted=wanted), choice._replace(setting=share * choice.setting)


def finer_setting(own: float, least: float, most: float = math.inf) -> float:
    """Tolerance of a step of the second run: `TOLERANCE` of its own, `most` at most; larger where that is too little.

    Above `most` something else than the tolerance sets the steps.
    """
    finer = min(TOLERANCE * own, most)
    return finer if finer >= least * (1.0 - 1e-9) else own / TOLERANCE


class Comparison:
    """The requested outputs of a run beside those of its second run; a kind fills in one of the two methods.

    `outputs` maps names to the norm of their error; the figures `exact` have no error of the method. `smaller` says
    what reduces that. Without a `choice` it knows its outputs alone.
    """

    exact: tuple[str, ...] = ("energy_closure",)
    grows = True  # errors may grow by the motion itself, which then has a horizon

    def __init__(self, parameters, choice: Choice | None):
        self.parameters, self.choice = parameters, choice
        self.outputs: Mapping[str, str] = {}

    @property
    def smaller(self) -> str:
        return SMALLER

    def differences(self, own: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """By name: absolute differences (n,) at the outputs of two blocks, and the sizes (n,) they are relative to.

        The error so far is the greatest difference over the greatest size.
        """
        return {}

    def events(self, own, second) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """The same of what the figures of both runs gathered, such as contacts: times [s], differences, sizes."""
        return {}
