"""The figures of a sphere on a beam, a function of outputs and records alone."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block, Channel, Table
from bearing_twin.contact.validity import patch_radius
from bearing_twin.kinds.beam.motion import (
    MODE_ORDERS,
    MOST_MODES,
    STEP_ORDER,
    euler_errors,
    euler_errors_of_beam,
    impact_speed,
    modes_for,
    sphere_of,
    steps_for,
    theory_of,
)
from bearing_twin.kinds.beam.parameters import EULER, SphereOnBeamScene
from bearing_twin.kinds.bodies.figures import CONTACT, DURATION, IMPULSE, ImpactFigures, contact_warnings
from bearing_twin.kinds.bodies.figures import MEANINGS as IMPACT_MEANINGS
from bearing_twin.kinds.bodies.model_errors import ImpactComparison
from bearing_twin.kinds.error_estimates import BEAM_THEORY, SMALLER, TOLERANCE, ModelErrors, is_checked

MEANINGS = IMPACT_MEANINGS | {
    "restitution": "speed of the sphere away from the beam over its speed before, at the end",
    "sphere_velocity_after_m_s": "of the sphere along its motion before the impact, at the end",
    "contact_count": "contacts that have ended",
    "peak_deflection_m": "of the beam, greatest by magnitude of all points, whole motion; none for peaks alone",
    "peak_stress_pa": "bending stress, greatest by magnitude of all points, whole motion; none for peaks alone",
    "highest_mode": "of the beam in the sum, the same for the whole motion",
    "gravity_m_s2": "on the sphere after the first touch, as the scene gives it",
}

LARGE_DEFLECTION = 0.02  # of the span

EXTREMES = Table(
    "extremes",
    (
        Channel("time", "s", (), "end of the last contact: what follows is free motion"),
        Channel("peak_deflection", "m", (), "greatest by magnitude, of all points and the whole motion"),
        Channel("peak_stress", "Pa", (), "greatest bending stress by magnitude, likewise"),
        Channel("energy_gained", "J", (), "by the numbers alone"),
        Channel("known_until", "s", (), "to where the motion is solved"),
        Channel("gone", "1", (), "1 where no further contact can follow"),
        Channel("highest_mode", "1", (), "of the beam in the sum"),
    ),
    "what is greatest in the whole motion",
)


OF_BEAM = ("peak_deflection_m", "peak_stress_pa")
FIGURES = (
    *("peak_force_n", "contact_duration_s", "greatest_approach_m", "contact_count", "restitution"),
    *("sphere_velocity_after_m_s", "impulse_ns", *OF_BEAM),
)


TABLES = CONTACT, EXTREMES


class BeamFigures(ImpactFigures):
    """The figures of a sphere on a beam."""

    def __init__(self, parameters: SphereOnBeamScene, choice: Choice):
        super().__init__(parameters, choice)
        self._extremes: dict[str, float] = {}

    @staticmethod
    def speed_of(parameters) -> float:
        return impact_speed(parameters.blow)

    def add(self, block: Block) -> None:
        super().add(block)
        for row in block.records.get("extremes", ()):
            names = (column.name for column in EXTREMES.columns)
            known = zip(names, map(float, row), strict=False)  # an earlier version has fewer
            self._extremes = {name: value for name, value in known if not math.isnan(value)}

    @property
    def restitution(self) -> float | None:
        """Speed of the sphere away from the beam at the end over its speed before; negative: it follows the beam."""
        return -float(self.last["sphere_velocity"]) / self.speed if self.last else None

    @property
    def energy_gained(self) -> float:
        return self._extremes.get("energy_gained", 0.0)

    def figures(self) -> dict[str, Any]:
        """Figures of an impact, and deflection and stress of the beam."""
        return {
            **super().figures(),
            "sphere_velocity_after_m_s": float(self.last["sphere_velocity"]) if self.last else None,
            "contact_count": len(self.contacts),
            "peak_deflection_m": self._extremes.get("peak_deflection"),
            "peak_stress_pa": self._extremes.get("peak_stress"),
            "highest_mode": int(self._extremes.get("highest_mode", modes_for(self.parameters))),
            "gravity_m_s2": self.parameters.blow.gravity,
        }

    def flags(self) -> list[str]:
        """Warnings of an impact outside the limits of the theory, one sentence each."""
        peak, (sphere, beam) = self.peak_force, self.parameters.bodies
        half_width = patch_radius(peak, sphere.radius, self.parameters.modulus)
        pressure = 1.5 * peak / (math.pi * half_width**2) if peak > 0.0 else 0.0
        size, body = min((sphere.radius, "radius"), (beam.height, "height"))
        shortest = float(self.contacts[:, DURATION].min(initial=math.inf))
        found = contact_warnings((sphere, beam), pressure, shortest, [(half_width, size, body)])
        return [*found, *self._beam_flags(), *super().flags()]

    def _beam_flags(self) -> list[str]:
        beam, extremes = self.parameters.beam, self._extremes
        stress, deflection = extremes.get("peak_stress", 0.0), extremes.get("peak_deflection", 0.0)
        flags = []
        if 0.0 < beam.material.yield_strength < stress:
            flags.append(f"bending stress {stress:.3g} Pa is beyond the beam's strength: the elastic result is formal")
        if len(self.contacts) and theory_of(self.parameters) == EULER:
            found = euler_errors(self.parameters).warnings(self.parameters.wanted.tolerance, len(self.contacts))
            flags += [f"{'; '.join(found)}: give beam.theory: timoshenko"] if found else []
        if deflection > LARGE_DEFLECTION * beam.span:
            flags.append(f"a deflection of {deflection:.3g} m is large for a span of {beam.span:g} m")
        sphere, total = sphere_of(self.parameters), float(np.sum(self.contacts[:, IMPULSE]))
        most = 2.0 * sphere.mass * self.speed
        if sphere.gravity == 0.0 and total > most * (1.0 + 1e-9):
            flags.append(f"the impulse of {total:.4g} N s exceeds 2 m v = {most:.4g} N s: the numbers are wrong")
        if extremes and not extremes["gone"]:
            flags.append(
                f"the sphere was not surely gone at {extremes['known_until']:.4g} s: further contacts are possible; "
                "lengthen run.duration"
            )
        return flags


class BeamComparison(ImpactComparison):
    """Comparison of two runs of a sphere on a beam, as of two bodies on a line."""

    @property
    def coarser(self) -> float:
        """Ten where a tenth of the error takes more modes than there may be: the second run then has fewer."""
        beyond = self.choice.stepper == "modes" and self._modes_and_steps(TOLERANCE)[0] > MOST_MODES
        return 1.0 / TOLERANCE if beyond else 1.0

    def _modes_and_steps(self, share: float) -> tuple[int, int]:
        """Those of a run with this share of the error."""
        parameters = self.parameters.resolve()
        order = MODE_ORDERS[theory_of(parameters), parameters.solver.static_tail]
        modes = math.ceil(modes_for(parameters) * share ** (-1.0 / order)) | 1
        return modes, math.ceil(steps_for(parameters, "modes") * share ** (-1.0 / STEP_ORDER))

    def refined(self):
        """As many modes and steps as a tenth of the error takes; by modes where the first run is by another method."""
        parameters = self.parameters.resolve()
        if self.choice.stepper != "modes":
            return parameters, self.choice._replace(stepper="modes")
        modes, steps = self._modes_and_steps(self.coarser if self.coarser > 1.0 else TOLERANCE)
        solver = dataclasses.replace(parameters.solver, modes=modes, steps=steps)
        return dataclasses.replace(parameters, solver=solver), self.choice

    @property
    def smaller(self) -> str:
        if self.choice.stepper == "sinusoidal":
            return "set solver.stepper: modes, which solves for the force"
        if self.parameters.solver.modes or self.parameters.solver.steps:
            return "leave solver.modes and solver.steps out, or raise them"
        return SMALLER


class BeamModelErrors(ModelErrors):
    """Euler's beam against Timoshenko's."""

    outputs = ("peaks", "forces")
    law_source, law_mend = BEAM_THEORY, "beam.theory: timoshenko knows shear and rotary inertia"

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Of Euler's beam against Timoshenko's; that of Timoshenko's is not known."""
        if theory_of(self.parameters) != EULER or not figures["contact_count"]:
            return {}
        found = dict(euler_errors(self.parameters).figures)
        if self.parameters.wanted.outputs == "history" and is_checked(self.parameters):
            found |= zip(OF_BEAM, euler_errors_of_beam(self.parameters), strict=True)
        return found

    def law_of(self, output: str) -> float:
        """Of Euler's beam against Timoshenko's: of its peaks, and of forces over time those of later contacts, too."""
        if theory_of(self.parameters) != EULER:
            return 0.0
        found = euler_errors(self.parameters)
        peaks = max(found.peak, found.time)
        return peaks if output == "peaks" else max(peaks, found.forces)

    def not_modelled(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """The next term of the sphere's shape, (a / R)^2 of the load at an approach; peaks go with its power 2/5."""
        sphere, beam, peak = self.parameters.sphere, self.parameters.beam, figures["peak_force_n"]
        width = patch_radius(peak, sphere.radius, self.parameters.modulus)
        share = (width / min(sphere.radius, beam.height)) ** 2 / 2.5
        return {key: share * abs(figures[key]) for key in FIGURES[:3]}

    def notes(self) -> dict[str, str]:
        found = {"vibration": "waves in the sphere, and across the beam's width and height, are not computed"}
        if theory_of(self.parameters) != EULER:
            found[BEAM_THEORY] = "Timoshenko's beam holds for waves down to a height or two; its error is not known"
        elif euler_errors(self.parameters).contacts > 1:
            found[BEAM_THEORY] = (
                "what follows a second touch needs shear: by Euler's beam what comes of it is another motion"
            )
        return found
