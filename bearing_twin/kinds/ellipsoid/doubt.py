"""Model errors of an ellipsoid on a plane, and of two bodies; how their second runs are compared."""

import heapq
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from bearing_twin.base.sample import Block
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.hertz_impact import bar_speed, restitution_lost_on_half_space
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bouncing import COARSEST, FINEST
from bearing_twin.kinds.ellipsoid.derived import ellipsoid_mass
from bearing_twin.kinds.ellipsoid.figures import EllipsoidFigures
from bearing_twin.kinds.ellipsoid.motion import setting_of
from bearing_twin.kinds.error_estimates import (
    FRICTION_MODEL,
    HERTZ_MENDS,
    LAW,
    Comparison,
    ModelErrors,
    finer_setting,
)


def paired(own: list, true: list, size: Callable) -> list[tuple]:
    """Contacts of two motions in their order; of the motion with more, the least by `size` stand beside none."""
    fewer = min(len(own), len(true))
    least = [
        set(heapq.nsmallest(len(some) - fewer, range(len(some)), key=lambda k: size(some[k]))) for some in (own, true)
    ]
    kept = [[one for k, one in enumerate(some) if k not in left] for some, left in zip((own, true), least, strict=True)]
    return [*zip(*kept, strict=True), *((own[k], None) for k in least[0]), *((None, true[k]) for k in least[1])]


class ContactComparison(Comparison):
    """Peak load and impulse of contacts in their order, over the greatest; one that a run lacks counts whole."""

    exact = (*Comparison.exact, "contacts", "greatest_energy_gain", "quaternion_drift", "tracking_error_m")

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self.outputs = {"contacts": "in peak load or impulse, over the greatest"}

    def refined(self):
        """Of order 8 whatever the first is."""
        setting = finer_setting(setting_of(self.parameters, self.choice), FINEST, COARSEST)
        return self.parameters, self.choice._replace(stepper="dop853", setting=setting)

    def events(self, own, second) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of all contacts so far."""
        both = paired(own.bounces(), second.bounces(), lambda one: one.peak_load)
        both.sort(key=lambda pair: (pair[0] or pair[1]).start)
        times, apart = np.array([(one or other).start for one, other in both]), np.zeros(len(both))
        for size in (lambda one: one.peak_load if one else 0.0, lambda one: (one.impulse or 0.0) if one else 0.0):
            sizes = np.array([[size(one), size(other)] for one, other in both]).reshape(-1, 2)
            most = sizes.max(initial=0.0)
            if most > 0.0:
                apart = np.maximum(apart, np.abs(sizes[:, 0] - sizes[:, 1]) / most)
        return {"contacts": (times, apart, np.ones(len(both)))}


class EllipsoidDoubt(ModelErrors):
    """The law against exact Hertz where each contact was hardest."""

    outputs = ("contacts",)
    figures_type = EllipsoidFigures
    shallow = 1.5  # power of a load that is no law's
    frictional = ("velocity_change_x_m_s", "velocity_change_y_m_s", "angular_momentum_change_vertical_nms")
    """Figures that friction alone changes: on a plane, all along it and about its normal."""

    def __init__(self, parameters, choice):
        super().__init__(parameters, choice)
        self._contacts = self.figures_type(parameters, choice)

    def add(self, block: Block) -> None:
        super().add(block)
        self._contacts.add(block)

    @property
    def _law_error(self) -> float:
        """The greatest relative error of a load's coefficient in a contact that has ended."""
        if self.choice.law not in LAWS or LAWS[self.choice.law].measured:
            return 0.0
        return max((abs(one.law_error) for one in self._contacts.bounces()), default=0.0)

    @property
    def _share(self) -> float:
        """Of the coefficient's error in loads, times and depths of a bounce: its energy goes with c x^(n+1)."""
        power = LAWS[self.choice.law].power if self.choice.law in LAWS else self.shallow
        return self._law_error / (power + 1.0)

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Errors of the law by figure: a bounce is harder and shorter where the coefficient is greater."""
        of_bounce = ("peak_force_n", "contact_duration_s", "greatest_approach_m")
        found = {key: self._share * abs(figures[key]) for key in of_bounce if figures.get(key) is not None}
        pressure = (self._law_error + self._share) * abs(figures["peak_pressure_pa"]) / 3.0
        return found | {"peak_pressure_pa": pressure}

    def law_of(self, output: str) -> tuple[float, str]:
        """Peak loads go with this share of the coefficient's error."""
        return self._share, HERTZ_MENDS

    def friction(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Error of friction over the contact patch, as a share of its effect; not known at a point."""
        model = FRICTIONS[self.parameters.contact.friction]
        if not model.over_spot:
            return {}
        lost = model.error * abs(figures["dissipated_friction_j"])
        changed = {key: model.error * abs(figures[key]) for key in self.frictional}
        return {"dissipated_friction_j": lost, "energy_end_j": lost} | changed

    def left_out(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Restitution lost to waves in the plane in the first bounce, as of a sphere."""
        first = next(iter(self._contacts.bounces()), None)
        if first is None or not first.impulse or first.restitution is None:
            return {}
        body = self.parameters.body
        speed = first.impulse / ellipsoid_mass(body) / (1.0 + first.restitution)
        waves = bar_speed(body.material.young_modulus, body.material.density)
        return {"restitution": restitution_lost_on_half_space(speed, waves)}

    def notes(self) -> dict[str, str]:
        contact, found = self.parameters.contact, {}
        if self.choice.law not in LAWS or LAWS[self.choice.law].measured:
            found[LAW] = f"the error of the law {self.choice.law} is not known"
        if contact.friction_coefficient and not FRICTIONS[contact.friction].over_spot:
            found[FRICTION_MODEL] = (
                "contact.friction: point holds no drilling: spin about the normal meets no resistance; set "
                "contact.friction: spot, which computes it"
            )
        return found | {"vibration": "bodies are rigid outside their contact: waves are not modelled"}
