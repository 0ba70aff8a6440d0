"""Model errors of a sphere on a beam, by the other theory of beams; its second run, of fewer modes and steps."""

import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.contact.elasticity import approaches_of_loads
from bearing_twin.contact.laws import HERTZIAN
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.validity import spot_radius
from bearing_twin.kinds.beam.figures import FIGURES, OF_BEAM
from bearing_twin.kinds.beam.impact import BeamImpact
from bearing_twin.kinds.beam.models import (
    impact_by_both_theories,
    impact_speed,
    modes_for,
    steps_for,
    theory_of,
    trial,
)
from bearing_twin.kinds.beam.motion import WatchedPoints
from bearing_twin.kinds.beam.parameters import EULER
from bearing_twin.kinds.error_estimates import COARSER, LAW, SMALLER, ModelErrors, is_checked
from bearing_twin.kinds.impact.doubt import ImpactComparison

INSTANTS = 400  # of a contact, at which forces are compared


def figures_of(parameters, found: BeamImpact) -> dict[str, float]:
    """The figures of contacts and sphere."""
    leaving = float(found.pieces.motions[-1, 1])
    return {
        "peak_force_n": found.peak_force,
        "contact_duration_s": found.contact_time,
        "greatest_approach_m": float(approaches_of_loads(found.sphere.coefficient, HERTZIAN, found.peak_force)),
        "contact_count": len(found.contacts),
        "restitution": -leaving / impact_speed(parameters.blow),
        "sphere_velocity_after_m_s": leaving,
        "impulse_ns": math.fsum(one.impulse for one in found.contacts),
    }


def _history_apart(found: BeamImpact, exact: BeamImpact) -> float:
    """By how much forces of two motions differ in contacts of the second, over its greatest; 0 without a contact."""
    times = [np.linspace(one.start, one.start + one.duration, INSTANTS) for one in exact.contacts]
    apart = [np.abs(found.force_at(part) - exact.force_at(part)).max() for part in times]
    return float(max(apart, default=0.0)) / exact.peak_force if exact.peak_force else 0.0


class BeamComparison(ImpactComparison):
    """As of two bodies on a line."""

    def refined(self):
        """Fewer modes and steps; by modes where the first run is by another method."""
        parameters = self.parameters.resolve()
        if self.choice.stepper != "modes":
            return parameters, self.choice._replace(stepper="modes")
        modes, steps = modes_for(parameters), steps_for(parameters, self.choice.stepper)
        fewer = [max(1, math.floor(COARSER * one)) for one in (modes, steps)]
        solver = dataclasses.replace(parameters.solver, modes=fewer[0], steps=fewer[1])
        return dataclasses.replace(parameters, solver=solver), self.choice

    @property
    def smaller(self) -> str:
        if self.choice.stepper == "sinusoidal":
            return "set solver.stepper: modes, which solves for the force"
        if self.parameters.solver.modes or self.parameters.solver.steps:
            return "leave solver.modes and solver.steps out, or raise them"
        return SMALLER


@functools.lru_cache(maxsize=64)
def shear_error_of_forces(parameters) -> float:
    """What the force over time of a checked scene by Euler's beam is off Timoshenko's, over the greatest, roughly."""
    return _history_apart(*impact_by_both_theories(parameters))


@functools.lru_cache(maxsize=64)
def shear_error(parameters) -> dict[str, float]:
    """What figures of a checked scene by Euler's beam are off Timoshenko's, in their units, roughly.

    Those that follow from its whole motion: of the sphere; and of the beam where more than contacts is wanted and a
    second motion goes beside, for to look through it costs more than all contacts.
    """
    thrown = impact_by_both_theories(parameters)
    both = [figures_of(parameters, found) for found in thrown]
    keys = ["contact_count", "restitution", "sphere_velocity_after_m_s", "impulse_ns"]
    if parameters.wanted.outputs == "history" and is_checked(parameters):
        keys.extend(OF_BEAM)
        for figures, found in zip(both, thrown, strict=True):
            tops = WatchedPoints(parameters, found).greatest()
            figures |= {key: top.value for key, top in zip(OF_BEAM, tops, strict=True)}
    return {key: abs(both[0][key] - both[1][key]) for key in keys}


class BeamDoubt(ModelErrors):
    """Euler's beam against Timoshenko's."""

    outputs = ("peaks", "forces")

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Of Euler's beam against Timoshenko's; that of Timoshenko's is not known."""
        if theory_of(self.parameters) != EULER or not figures["contact_count"]:
            return {}
        tried = trial(self.parameters)
        by = {"peak_force_n": tried.of_peak, "contact_duration_s": tried.of_time}
        by["greatest_approach_m"] = 2.0 / 3.0 * tried.of_peak
        return {key: share * abs(figures[key]) for key, share in by.items()} | shear_error(self.parameters)

    def law_of(self, output: str) -> tuple[float, str]:
        """Of Euler's beam against Timoshenko's: of its peaks, and of forces over time those of later contacts, too."""
        if theory_of(self.parameters) != EULER:
            return 0.0, ""
        tried = trial(self.parameters)
        peaks = max(tried.of_peak, tried.of_time)
        off = peaks if output == "peaks" else max(peaks, shear_error_of_forces(self.parameters))
        return off, "beam.theory: timoshenko knows shear and rotary inertia"

    def left_out(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """The next term of the sphere's shape, (a / R)^2 of the load at an approach; peaks go with its power 2/5."""
        sphere, beam, peak = self.parameters.sphere, self.parameters.beam, figures["peak_force_n"]
        modulus = effective_modulus(sphere.material, beam.material)
        width = spot_radius(peak, sphere.radius, modulus)
        share = (width / min(sphere.radius, beam.height)) ** 2 / 2.5
        return {key: share * abs(figures[key]) for key in FIGURES[:3]}

    def notes(self) -> dict[str, str]:
        found = {"vibration": "waves in the sphere, and across the beam's width and height, are not computed"}
        if theory_of(self.parameters) != EULER:
            found[LAW] = "Timoshenko's beam holds for waves down to a height or two; its error is not known"
        elif trial(self.parameters).contacts > 1:
            found[LAW] = "what follows a second touch needs shear: by Euler's beam what comes of it is another motion"
        return found
