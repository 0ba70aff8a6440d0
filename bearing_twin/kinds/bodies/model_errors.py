"""Model errors of bodies that collide, and their second runs."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.base.sample import Block
from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.hertz_impact import (
    bar_speed,
    restitution_lost_between_spheres,
    restitution_lost_on_half_space,
)
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bodies import motion
from bearing_twin.kinds.bodies.derived import (
    disc_impact_time,
    hunt_crossley_damping,
    line_contact_error,
    mass_of,
    patch_of,
)
from bearing_twin.kinds.bodies.figures import FIGURES, BouncingFigures
from bearing_twin.kinds.bodies.impact import SETTING
from bearing_twin.kinds.bodies.parameters import FIXED_STEP, TwoBodiesScene, TwoSpheresScene
from bearing_twin.kinds.error_estimates import (
    FRICTION_MODEL,
    LAW,
    Comparison,
    ModelErrors,
    finer_setting,
)

COARSEST, FINEST = 1e-9, 1e-13  # of the tolerance of a step of a second run of an impact, at most and at least
SHALLOW = 1.5  # power of a load that is no law's


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
            self.outputs["forces"] = "relative to the greatest"

    def refined(self):
        """By the equation of motion; None of elastic spheres in closed form."""
        parameters, choice = self.parameters, self.choice
        spheres = choice.stepper == "closed_form" and isinstance(parameters, TwoSpheresScene)
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

    def differences(self, first: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Of the force."""
        force = first["normal_load"]
        return {"forces": (np.abs(force - second["normal_load"]), force)} if "forces" in self.outputs else {}

    def events(self, first, second) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of peak force and contact time."""
        figures, exact = first.figures(), second.figures()
        difference = max(relative(figures[key], exact[key]) for key in ("peak_force_n", "contact_duration_s"))
        return {"peaks": (np.zeros(1), np.array([difference]), np.ones(1))}


class ContactComparison(Comparison):
    """Peak load and impulse of contacts in their order, over the greatest; one that a run lacks counts whole."""

    exact = (*Comparison.exact, "contacts", "greatest_energy_gain", "quaternion_drift", "tracking_error_m")

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self.outputs = {"contacts": "in peak load or impulse, relative to the greatest"}

    def refined(self):
        """Of order 8 whatever the first is."""
        setting = finer_setting(motion.setting_of(self.parameters, self.choice), *motion.limits_of(self.parameters))
        return self.parameters, self.choice._replace(stepper="dop853", setting=setting)

    def events(self, first, second) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of all contacts so far."""
        columns = [run.contacts() for run in (first, second)]
        rows = [np.array([run["start"], run["peak_load"], np.nan_to_num(run["impulse"])]) for run in columns]
        common, unpaired = paired(*rows)
        times = np.concatenate([common[0, 0], *(contacts[0] for contacts in unpaired)])
        difference = np.hstack([np.abs(common[0, 1:] - common[1, 1:]), *(contacts[1:] for contacts in unpaired)])
        greatest = np.maximum(*(figures[1:].max(axis=1, initial=0.0) for figures in rows))
        difference = (difference / np.where(greatest > 0.0, greatest, 1.0)[:, None]).max(axis=0)
        order = np.argsort(times, kind="stable")
        return {"contacts": (times[order], difference[order], np.ones(len(order)))}


def paired(*rows: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Contacts of two motions in their order (2, columns, n), and those left alone of each (columns, more).

    Of the motion with more, those of the least load, the second row, are left alone.
    """
    count, common, unpaired = min(row.shape[1] for row in rows), [], []
    for row in rows:
        least = np.argsort(row[1], kind="stable")[: row.shape[1] - count]
        common.append(np.delete(row, least, axis=1))
        unpaired.append(row[:, least])
    return np.array(common), unpaired


class PairErrors(ModelErrors):
    """The model errors of two bodies on a line."""

    outputs = ("peaks", "forces")

    def scaled(self, figures: Mapping[str, Any], share: float) -> dict[str, float]:
        """Errors of figures that go with the load's coefficient, by this share."""
        return {key: share * abs(figures[key]) for key in FIGURES[:3] if figures.get(key)}


class SphereErrors(PairErrors):
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

    def law_of(self, output: str) -> float:
        """Error of the law, as large as that of the peaks."""
        return self._share

    def not_modelled(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """The next term of a sphere's shape, (a / R)^2 of the load, and the energy lost to vibration."""
        first, second = self.parameters.first, self.parameters.second
        if not figures["peak_force_n"]:
            return {}
        _, width, _ = patch_of(self.parameters, figures["peak_force_n"])
        errors = self.scaled(figures, (width / min(first.radius, second.radius)) ** 2 / 2.5)
        waves = min(bar_speed(body.material.young_modulus, body.material.density) for body in (first, second))
        lost = restitution_lost_between_spheres(self.parameters.motion.speed, waves)
        impulse = figures["impulse_ns"] * lost / (1.0 + figures["restitution"])
        return errors | {"restitution": lost, "impulse_ns": impulse}

    def notes(self) -> dict[str, str]:
        notes = {"spin": "central impact: friction and spin are not modelled"}
        if LAWS[self.choice.law].measured:
            notes[LAW] = f"the law {self.choice.law} is given by the scene; its error is not known"
        return notes


class DiscErrors(PairErrors):
    """The law against plane-strain elasticity, which thick discs follow."""

    @property
    def _law_difference(self) -> float:
        """Relative difference of the contact time from Johnson's."""
        return relative(*(disc_impact_time(self.parameters, law) for law in (self.choice.law, "johnson")))

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """By contact times: a longer contact is softer by as much, and deeper."""
        return self.scaled(figures, line_contact_error(self.parameters)[0] + self._law_difference)

    def law_of(self, output: str) -> float:
        """Error that another law of line contact removes; the rest is common to all of them."""
        return self._law_difference

    @property
    def law_mend(self) -> str:
        if self.choice.law == "johnson":
            return "kind: soft_discs computes discs by finite elasticity"
        return "contact.normal: johnson costs no more"

    def notes(self) -> dict[str, str]:
        error = 100.0 * line_contact_error(self.parameters)[0]
        return {
            LAW: f"laws of line contact differ from finite elasticity by {error:.2g} % at this speed and "
            "thickness, whatever the tolerance; the error is reported with the figures and "
            "does not change the status; kind: soft_discs has no such law",
            "vibration": "discs are rigid outside their contact: waves are not modelled",
        }


class BouncingErrors(ModelErrors):
    """The law against exact Hertz where each contact was hardest."""

    outputs = ("contacts",)

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self._contacts, self._pair = BouncingFigures(parameters, choice), isinstance(parameters, TwoBodiesScene)

    def add(self, block: Block) -> None:
        self._contacts.add(block)

    @property
    def _unknown(self) -> bool:
        """True where the error of the law is not known."""
        return self.choice.law not in LAWS or LAWS[self.choice.law].measured

    @property
    def _law_error(self) -> float:
        """The greatest relative error of a load's coefficient in a contact that has ended."""
        return 0.0 if self._unknown else float(np.abs(self._contacts.contacts()["law_error"]).max(initial=0.0))

    @property
    def _share(self) -> float:
        """Of the coefficient's error in loads, times and depths of a bounce: its energy goes with c x^(n+1)."""
        power = LAWS[self.choice.law].power if self.choice.law in LAWS else SHALLOW
        return self._law_error / (power + 1.0)

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of the law by figure: a bounce is harder and shorter where the coefficient is greater."""
        errors = {key: self._share * abs(figures[key]) for key in FIGURES[:3] if figures.get(key) is not None}
        pressure = (self._law_error + self._share) * abs(figures["peak_pressure_pa"]) / 3.0
        return errors | {"peak_pressure_pa": pressure}

    def law_of(self, output: str) -> float:
        """Peak loads go with this share of the coefficient's error."""
        return self._share

    def friction(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Error of friction over the contact patch, as a share of its effect; not known at a point.

        On a plane friction alone changes what is along it and about its normal.
        """
        model = FRICTIONS[self.parameters.contact.friction]
        if not model.over_patch:
            return {}
        lost, along = model.error * abs(figures["dissipated_friction_j"]), ()
        if not self._pair:
            along = "velocity_change_x_m_s", "velocity_change_y_m_s", "angular_momentum_change_vertical_nms"
        changed = {key: model.error * abs(figures[key]) for key in along}
        return {"dissipated_friction_j": lost, "energy_end_j": lost} | changed

    def not_modelled(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Restitution lost to waves in the plane in the first bounce, as of a sphere; of two bodies the energy balance.

        Loads between two bodies act at their opposing points. Where curvatures change as bodies turn, the elastic
        energy has a moment as well, which is missing: the energy balance misses as much.
        """
        if self._pair:
            imbalance = max(abs(figures["energy_closure"]), abs(figures["greatest_energy_gain"]))
            keys = *FIGURES[:3], "energy_end_j"
            return {key: imbalance * abs(figures[key]) for key in keys if figures.get(key) is not None}
        first = next(iter(figures["contacts"]), None)
        if first is None or not first["impulse_ns"] or first["restitution"] is None:
            return {}
        body = self.parameters.body
        speed = first["impulse_ns"] / mass_of(body) / (1.0 + first["restitution"])
        waves = bar_speed(body.material.young_modulus, body.material.density)
        return {"restitution": restitution_lost_on_half_space(speed, waves)}

    def notes(self) -> dict[str, str]:
        contact, notes = self.parameters.contact, {}
        if self._unknown:
            notes[LAW] = f"the error of the law {self.choice.law} is not known"
        if contact.friction_coefficient and not FRICTIONS[contact.friction].over_patch:
            notes[FRICTION_MODEL] = (
                "contact.friction: point has no friction of spin about the normal; set "
                "contact.friction: patch, which computes it"
            )
        return notes | {"vibration": "bodies are rigid outside their contact: waves are not modelled"}
