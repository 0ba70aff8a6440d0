"""The figures of soft discs, a function of outputs and records alone."""

import dataclasses
from typing import Any

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.base.units import key_suffix
from bearing_twin.kinds.bodies.model_errors import ImpactComparison
from bearing_twin.kinds.contract import adds_up
from bearing_twin.kinds.error_estimates import LAW, ModelErrors
from bearing_twin.kinds.soft_discs import MEANINGS
from bearing_twin.kinds.soft_discs.derived import FEWEST, GREATEST_RATIO, bodies_of, predicted_error, wall_speed
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

SOFT = 3.0**-0.5  # stretch at which St. Venant-Kirchhoff has no stiffness left in compression
SMALL = 0.05  # strain up to which small strains are a model
FEW_BOUNCES = 0.9  # restitution below which vibration takes more than paper 3's discs ever lose
BALANCE = 1e-9  # of the peak force

IMPACT = Table(
    "impact",
    (
        Channel("time", "s", (), "last contact"),
        Channel("peak_force", "N", (), "greatest contact force over all steps"),
        Channel("peak_time", "s", (), "when, since the first touch"),
        Channel("contact_duration", "s", (), "from first touch to last contact, gaps included"),
        Channel("impulse", "N s", (), "of the contact force"),
        Channel("restitution", "1", (), "velocity of the centre of mass away over that before"),
        Channel("greatest_penetration", "m", (), "depth of the rim below the wall"),
        Channel("energy_gained", "J", (), "by the method alone, greatest by magnitude"),
        Channel("least_stretch", "1", (), "least principal stretch in the plane, anywhere and ever"),
        Channel(
            "force_balance", "N", (), "greatest difference of the force and the integral of density * acceleration"
        ),
        Channel("touches", "1", (), "how often the disc touched the wall"),
        Channel("ended", "1", (), "1 where the disc left the wall for good"),
    ),
    "the impact, once it is over",
)
TABLES = (IMPACT,)


class SoftDiscFigures:
    """Gathers the record of the impact and how far the outputs reach."""

    def __init__(self, parameters: SoftDiscsScene, choice: Choice):
        self.parameters = parameters
        self._brought, self._until = 0.0, 0.0
        self._known: dict[str, float] = {}

    def add(self, block: Block) -> None:
        if not self._brought:
            self._brought = float(block.values["kinetic_energy"][0])
        for row in block.records.get("impact", ()):
            self._known = dict(zip((column.name for column in IMPACT.columns), map(float, row), strict=True))
        self._until = 1e-9 * float(block.time_ns[-1])

    def figures(self) -> dict[str, Any]:
        """Numbers by SI-suffixed keys; none of the impact before it is over."""
        known = self._known
        figures = {f"{column.name}{key_suffix(column.unit)}": known.get(column.name) for column in IMPACT.columns}
        figures["energy_closure"] = known["energy_gained"] / self._brought if known else None
        figures["force_balance"] = known["force_balance"] / known["peak_force"] if known.get("peak_force") else None
        figures["touches"] = int(known["touches"]) if known else None
        figures["wall_speed_m_s"] = wall_speed(self.parameters)
        return {key: figures[key] for key in MEANINGS}

    def flags(self) -> list[str]:
        """Warnings of what in this impact lies outside the theory or is uncertain, one sentence each."""
        parameters, known, flags = self.parameters, self._known, []
        if any(body.disc.material.poisson_ratio > GREATEST_RATIO for body in bodies_of(parameters).values()):
            flags.append(f"Poisson's ratio is capped at {GREATEST_RATIO} in Lame's first parameter")
        if not known:
            return flags
        stretch, touches = known["least_stretch"], int(known["touches"])
        if parameters.formulation == "stvk" and stretch < SOFT:
            flags.append(f"a stretch of {stretch:.3g} is below 0.577: St. Venant-Kirchhoff has no stiffness left there")
        if parameters.formulation == "linear" and stretch < 1.0 - SMALL:
            flags.append(f"a stretch of {stretch:.3g} is far from 1, which the theory of small strains excludes")
        if known["restitution"] < FEW_BOUNCES:
            flags.append(
                f"a restitution of {known['restitution']:.3g} is low: much energy remains as vibration of the disc"
            )
        if touches > 1:
            flags.append(f"the disc touched the wall {touches} times: contact chatters, or the disc comes back")
        if self._until < known["contact_duration"] * (1.0 - 1e-9):
            flags.append(
                f"the outputs end at {self._until:.4g} s, before the contact does at {known['contact_duration']:.4g} s"
            )
        return flags

    def status(self) -> str:
        if not self._known:
            return "done"
        if not self._known["ended"]:
            return f"failed: the disc has not {'left' if self._known['touches'] else 'touched'} the wall"
        figures = self.figures()
        if not adds_up(figures["energy_closure"], self.parameters):
            return "failed: energy"
        return "done" if figures["force_balance"] <= BALANCE else "failed: momentum"


def second_divisions(divisions: int, order: int) -> int:
    """Divisions of the second mesh: at most half where elements of that order can have so few, else twice as many."""
    step = 2 * order
    half = divisions // 2 // step * step
    return half if half >= max(step, FEWEST) else 2 * divisions


class SoftDiscComparison(ImpactComparison):
    """The force over time by its root mean square, or its peak and the contact time."""

    exact = (*ImpactComparison.exact, "force_balance", "wall_speed_m_s", "nodes", "elements")

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        if parameters.wanted.outputs != "peaks":
            self.outputs = {"forces": "root mean square over the contact, relative to that of the force"}
        self._squares = np.zeros(2)

    @property
    def coarser(self) -> float:
        """By the order of convergence of the elements."""
        order, stiff = self.parameters.mesh.order, self.parameters.contact.stiffness_ratio
        first, second = (scene.mesh.divisions for scene in (self.parameters.resolve(), self.refined()[0]))
        return max(predicted_error(order, second, stiff) / predicted_error(order, first, stiff), 1.0)

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

    def differences(self, first: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """None at single outputs: squares of force and difference are summed for `events`."""
        force = first["normal_load"]
        squares = [float(np.square(values).sum()) for values in (force - second["normal_load"], force)]
        self._squares = self._squares + squares
        return {}

    def events(self, first, second) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of the force so far, or of its peak."""
        if "forces" not in self.outputs:
            return super().events(first, second)
        return {"forces": (np.zeros(1), *np.sqrt(self._squares)[:, None])}


class SoftDiscModelErrors(ModelErrors):
    """Errors of the model of soft discs."""

    def notes(self) -> dict[str, str]:
        return {
            "penalty": "contact is a bed of springs, whose depth stands in greatest_penetration_m: a harder one, "
            "contact.stiffness_ratio, is nearer to a rigid wall",
            "viscosity": "the material loses nothing: rubber does",
            LAW: "the material's law is the scene's formulation: others differ in force by up to about the greatest "
            "strain, 1 - least_stretch, which is in no error",
        }
