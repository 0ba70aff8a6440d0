"""Model errors of soft discs, and their second run: on a coarser mesh."""

import dataclasses
import math

import numpy as np

from bearing_twin.base.sample import Block
from bearing_twin.kinds.error_estimates import COARSER, LAW, ModelErrors
from bearing_twin.kinds.impact.doubt import ImpactComparison


def second_divisions(divisions: int, order: int) -> int:
    """Divisions of the second mesh: coarser where there is one, else finer: of the fewest a run takes no time."""
    step = 2 * order
    coarser = math.floor(COARSER * divisions / step) * step
    return coarser if coarser >= max(step, 4) else divisions + step


class SoftDiscComparison(ImpactComparison):
    """The force over time by its root mean square, or its peak and the contact time."""

    exact = (*ImpactComparison.exact, "force_balance", "wall_speed_m_s", "nodes", "elements")

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        if parameters.wanted.outputs != "peaks":
            self.outputs = {"forces": "root mean square over the contact, over that of the force"}
        self._squares = np.zeros(2)

    def refined(self):
        """On another mesh."""
        parameters = self.parameters.resolve()
        divisions = second_divisions(parameters.mesh.divisions, parameters.mesh.order)
        mesh = dataclasses.replace(parameters.mesh, divisions=divisions)
        return dataclasses.replace(parameters, mesh=mesh), self.choice

    @property
    def smaller(self) -> str:
        mesh = self.parameters.mesh
        return f"set mesh.divisions above {mesh.divisions}" if mesh.divisions else "set a third of wanted.tolerance"

    def differences(self, own: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """None at single outputs: squares of force and difference are summed for `events`."""
        force = own["normal_load"]
        squares = [float(np.square(one).sum()) for one in (force - second["normal_load"], force)]
        self._squares = self._squares + squares
        return {}

    def events(self, own, second) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of the force so far, or of its peak."""
        if "forces" not in self.outputs:
            return super().events(own, second)
        return {"forces": (np.zeros(1), *np.sqrt(self._squares)[:, None])}


class SoftDiscDoubt(ModelErrors):
    """What the model of soft discs leaves out."""

    def notes(self) -> dict[str, str]:
        return {
            "penalty": "contact is a bed of springs, whose depth stands in greatest_penetration_m: a harder one, "
            "contact.stiffness_ratio, is nearer to a rigid wall",
            "viscosity": "the material loses nothing: rubber does",
            LAW: "the material's law is the scene's formulation: others differ in force by up to about the greatest "
            "strain, 1 - least_stretch, which is in no error",
        }
