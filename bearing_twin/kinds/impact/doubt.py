"""What the figures of two spheres and of two discs are worth: by the differential equation, far more exactly."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bearing_twin.contact.elasticity import sphere_coefficient
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.validity import spot_radius
from bearing_twin.contact.waves import bar_speed, restitution_lost_between_spheres
from bearing_twin.kinds.doubt import HERTZ_MENDS, LAW
from bearing_twin.kinds.impact.collision import Collision, collide
from bearing_twin.kinds.impact.derived import contact_time_by
from bearing_twin.kinds.impact.figures import FIGURES, OUTPUTS, WATCH
from bearing_twin.kinds.impact.methods import FIXED_STEP
from bearing_twin.kinds.impact.models import off_elements
from bearing_twin.kinds.impact.spring import spring_loads
from bearing_twin.kinds.second_run import SecondRunDoubt, difference, row_of

FINER, COARSEST, FINEST = 1e-2, 1e-9, 1e-13  # tolerance of the second solution over the first one's; at most, at least
ROUNDED = 1e-11  # relative error of a closed form
INSTANTS = 400  # of a contact, at which forces are compared


def relative(value: float, finer: float) -> float:
    """By what share a value is off; infinite where nothing should be."""
    return abs(value - finer) / abs(finer) if finer else (math.inf if value else 0.0)


def companion_row(end, spring, reduced_mass, speed, expected, tolerance, contact, deepest, restitution, history):
    """The record of a second solution, beside the first one's contact, greatest approach, restitution and history.

    `end` [s] of the contact is the record's time.
    """
    finer = max(min(FINER * tolerance, COARSEST), FINEST)
    found: Collision = collide(spring, reduced_mass, speed, "dop853", finer, 0.0, expected)
    exact = found.contact
    times = np.linspace(0.0, exact.duration, INSTANTS)
    forces = []
    for one, last in ((history, contact.duration), (found.history, exact.duration)):
        motion = (np.ascontiguousarray(part, float) for part in one(np.minimum(times, last)))
        forces.append(spring_loads(spring, *motion))
    peaks = max(relative(contact.peak_force, exact.peak_force), relative(contact.duration, exact.duration))
    wanted = {"peaks": peaks, "forces": float(np.abs(np.subtract(*forces)).max()) / exact.peak_force}
    pairs = (
        (contact.peak_force, exact.peak_force),
        (contact.duration, exact.duration),
        (deepest, found.greatest_approach),
        (restitution, found.leaving_speed / speed),
        (contact.impulse, exact.impulse),
    )
    errors = {key: difference(*pair) for key, pair in zip(FIGURES, pairs, strict=True)}
    return row_of(WATCH, end, True, found.steps, wanted, errors)


def row_of_exact(end: float, contact, deepest: float, restitution: float) -> np.ndarray:
    """The record of a closed form, which is exact but for rounding."""
    values = contact.peak_force, contact.duration, deepest, restitution, contact.impulse
    errors = {key: ROUNDED * abs(value) for key, value in zip(FIGURES, values, strict=True)}
    return row_of(WATCH, end, True, 0, dict.fromkeys(OUTPUTS, ROUNDED), errors)


class PairDoubt(SecondRunDoubt):
    """By a second solution."""

    watch = WATCH

    @property
    def mend(self) -> str:
        if self.choice.stepper in FIXED_STEP:
            return "halve solver.step, or set solver.stepper: dop853"
        return "set solver.stepper: dop853, or a tenth of wanted.tolerance"

    def scaled(self, figures: Mapping[str, Any], share: float) -> dict[str, float]:
        """Errors of figures that go with the load's coefficient, by this share."""
        return {key: share * abs(figures[key]) for key in FIGURES[:3] if figures.get(key)}


class SphereDoubt(PairDoubt):
    """The law against Hertz; bodies that are no half-spaces and waves in them are left out."""

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
        """The next term of a sphere's shape, (a / R)^2 of the load, and what vibration takes."""
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
        found = {"spin": "spheres meet head-on: friction and spin are not computed"}
        if LAWS[self.choice.law].measured:
            found[LAW] = f"the law {self.choice.law} is given by the scene; nothing is known of its error"
        return found


class DiscDoubt(PairDoubt):
    """The law against plane-strain elasticity, which thick discs follow."""

    @property
    def _beside(self) -> float:
        """By what share the contact time differs from Johnson's."""
        parameters, law = self.parameters, self.choice.law
        return relative(contact_time_by(parameters, law), contact_time_by(parameters, "johnson"))

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """By contact times: a longer contact is softer by as much, and deeper."""
        return self.scaled(figures, off_elements(self.parameters)[0] + self._beside)

    def law_of(self, output: str) -> tuple[float, str]:
        """What a better law of line contact would mend; what is left no law of line contact does without."""
        return self._beside, "contact.normal: johnson costs no more"

    def notes(self) -> dict[str, str]:
        return {
            LAW: f"laws of line contact are {100.0 * off_elements(self.parameters)[0]:.2g} % off finite elasticity at "
            "this speed and thickness, whatever the tolerance: that stands beside figures, and does not "
            "make a run doubtful; kind: soft_discs has no such law",
            "vibration": "discs are rigid outside their contact: what goes into waves is not computed",
        }
