"""Model errors of two spheres and of two discs, and their second run: by the differential equation."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.base.sample import Block
from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.hertz_impact import bar_speed, restitution_lost_between_spheres
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.validity import spot_radius
from bearing_twin.kinds.error_estimates import HERTZ_MENDS, LAW, Comparison, ModelErrors, finer_setting
from bearing_twin.kinds.impact.derived import contact_time_by, hunt_crossley_damping
from bearing_twin.kinds.impact.figures import FIGURES
from bearing_twin.kinds.impact.impact import SETTING
from bearing_twin.kinds.impact.models import line_contact_error
from bearing_twin.kinds.impact.parameters import FIXED_STEP

COARSEST, FINEST = 1e-9, 1e-13  # of the tolerance of a step of a second run, at most and at least


def relative(value: float, finer: float) -> float:
    """Relative error of a value; infinite where the finer one is zero."""
    return abs(value - finer) / abs(finer) if finer else (math.inf if value else 0.0)


class ImpactComparison(Comparison):
    """Peak force and contact time by their shares; the force at all outputs over the greatest."""

    grows = False
    exact = (*Comparison.exact, "contacts", "impact_speed_m_s", "highest_mode", "gravity_m_s2")

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self.outputs = {"peaks": "of peak force or contact time"}
        if parameters.wanted.outputs != "peaks":
            self.outputs["forces"] = "over the greatest"

    def refined(self):
        """By the equation of motion; None of elastic spheres in closed form."""
        parameters, choice = self.parameters, self.choice
        spheres = choice.stepper == "closed_form" and hasattr(parameters, "first")
        if spheres and hunt_crossley_damping(parameters.contact, parameters.motion.speed) == 0.0:
            return None
        setting = finer_setting(SETTING * parameters.wanted.tolerance, FINEST, COARSEST)
        wanted = dataclasses.replace(parameters.wanted, tolerance=setting / SETTING)
        return dataclasses.replace(parameters, wanted=wanted), choice._replace(stepper="dop853")

    @property
    def smaller(self) -> str:
        if self.choice.stepper in FIXED_STEP:
            return "halve solver.step, or set solver.stepper: dop853"
        return "set solver.stepper: dop853, or a tenth of wanted.tolerance"

    def differences(self, own: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Of the force."""
        force = own["normal_load"]
        return {"forces": (np.abs(force - second["normal_load"]), force)} if "forces" in self.outputs else {}

    def events(self, own, second) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of peak force and contact time."""
        figures, exact = own.figures(), second.figures()
        apart = max(relative(figures[key], exact[key]) for key in ("peak_force_n", "contact_duration_s"))
        return {"peaks": (np.zeros(1), np.array([apart]), np.ones(1))}


class PairDoubt(ModelErrors):
    """The model errors of two bodies on a line."""

    outputs = ("peaks", "forces")

    def scaled(self, figures: Mapping[str, Any], share: float) -> dict[str, float]:
        """Errors of figures that go with the load's coefficient, by this share."""
        return {key: share * abs(figures[key]) for key in FIGURES[:3] if figures.get(key)}


class SphereDoubt(PairDoubt):
    """The law against Hertz's; the half-space approximation and waves are not modelled."""

    @property
    def _share(self) -> float:
        """Relative error of peaks: x^(n + 1) goes with the energy over the coefficient."""
        law = self.choice.law
        if LAWS[law].measured:
            return 0.0
        exact = float(sphere_coefficient("hertz", 1.0, 1.0))
        return abs(float(sphere_coefficient(law, 1.0, 1.0)) / exact - 1.0) / (LAWS[law].power + 1.0)

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """By the law's coefficient."""
        return {} if LAWS[self.choice.law].measured else self.scaled(figures, self._share)

    def law_of(self, output: str) -> tuple[float, str]:
        """As much as of its peaks."""
        return self._share, HERTZ_MENDS

    def left_out(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """The next term of a sphere's shape, (a / R)^2 of the load, and the energy lost to vibration."""
        first, second = self.parameters.first, self.parameters.second
        if not figures["peak_force_n"]:
            return {}
        radius = first.radius * second.radius / (first.radius + second.radius)
        modulus = effective_modulus(first.material, second.material)
        width = spot_radius(figures["peak_force_n"], radius, modulus)
        found = self.scaled(figures, (width / min(first.radius, second.radius)) ** 2 / 2.5)
        waves = min(bar_speed(one.material.young_modulus, one.material.density) for one in (first, second))
        lost = restitution_lost_between_spheres(self.parameters.motion.speed, waves)
        impulse = figures["impulse_ns"] * lost / (1.0 + figures["restitution"])
        return found | {"restitution": lost, "impulse_ns": impulse}

    def notes(self) -> dict[str, str]:
        found = {"spin": "central impact: friction and spin are not modelled"}
        if LAWS[self.choice.law].measured:
            found[LAW] = f"the law {self.choice.law} is given by the scene; its error is not known"
        return found


class DiscDoubt(PairDoubt):
    """The law against plane-strain elasticity, which thick discs follow."""

    @property
    def _law_difference(self) -> float:
        """Relative difference of the contact time from Johnson's."""
        parameters, law = self.parameters, self.choice.law
        return relative(contact_time_by(parameters, law), contact_time_by(parameters, "johnson"))

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """By contact times: a longer contact is softer by as much, and deeper."""
        return self.scaled(figures, line_contact_error(self.parameters)[0] + self._law_difference)

    def law_of(self, output: str) -> tuple[float, str]:
        """Error that another law of line contact removes; the rest is common to all of them."""
        return self._law_difference, "contact.normal: johnson costs no more"

    def notes(self) -> dict[str, str]:
        error = 100.0 * line_contact_error(self.parameters)[0]
        return {
            LAW: f"laws of line contact differ from finite elasticity by {error:.2g} % at this speed and "
            "thickness, whatever the tolerance; the error is reported with the figures and "
            "does not change the status; kind: soft_discs has no such law",
            "vibration": "discs are rigid outside their contact: waves are not modelled",
        }
