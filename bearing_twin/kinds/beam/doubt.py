"""What the figures of a sphere on a beam are worth: by more modes and steps, and by the other theory of beams."""

import functools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bearing_twin.contact.elastic import HERTZIAN, approaches_of_loads
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.validity import spot_radius
from bearing_twin.kinds.beam.derived import touch_speed
from bearing_twin.kinds.beam.figures import FIGURES, OF_BEAM, WATCH
from bearing_twin.kinds.beam.impact import BeamImpact
from bearing_twin.kinds.beam.parameters import EULER
from bearing_twin.kinds.beam.theory import theory_of, thrown_by_both, trial
from bearing_twin.kinds.beam.watched import Top, WatchedPoints
from bearing_twin.kinds.doubt import LAW, METHOD
from bearing_twin.kinds.impact.doubt import INSTANTS, relative
from bearing_twin.kinds.second_run import SecondRunDoubt, difference, is_watched, row_of

FINER = 1.5  # modes and steps of the companion over those of the run
ORDERS = {(True, True): 4.0, (True, False): 2.5, (False, True): 3.0, (False, False): 1.0}
"""By tail in the contact or not, and Euler's beam or not: the power of the modes that errors fall by, at least."""
LEFT = {of: FINER**-order for of, order in ORDERS.items()}
"""Of the same: what of the run's error the companion still has (`tests/test_impact_doubt.py`)."""


def force_at(found: BeamImpact, times: np.ndarray) -> np.ndarray:
    """The contact force [N] at increasing times [s], 0 beyond what is known."""
    piece = np.clip(np.searchsorted(found.starts[:-1], times, side="right") - 1, 0, len(found.lengths) - 1)
    share = (times - found.starts[piece]) / found.lengths[piece]
    force = (found.forces[piece] * share[:, None] ** np.arange(found.forces.shape[1])).sum(axis=1)
    return np.where(times <= found.end, np.maximum(force, 0.0), 0.0)


def figures_of(parameters, found: BeamImpact) -> dict[str, float]:
    """The figures of contacts and sphere."""
    leaving = float(found.motions[-1, 1])
    return {
        "peak_force_n": found.peak_force,
        "contact_duration_s": found.contact_time,
        "greatest_approach_m": float(approaches_of_loads(found.sphere.coefficient, HERTZIAN, found.peak_force)),
        "contact_count": len(found.contacts),
        "restitution": -leaving / touch_speed(parameters.blow),
        "sphere_velocity_after_m_s": leaving,
        "impulse_ns": math.fsum(one.impulse for one in found.contacts),
    }


def _over_difference(parameters, found: BeamImpact) -> float:
    """The error of a motion over its difference from a companion: what that has of the error is added."""
    tail, bends = parameters.solver.static_tail == "contact", math.isinf(found.beam.shear_rigidity)
    return 1.0 / (1.0 - LEFT[tail, bends])


def _history_apart(found: BeamImpact, exact: BeamImpact) -> float:
    """By how much forces of two motions differ in contacts of the second, over its greatest; 0 without a contact."""
    times = [np.linspace(one.start, one.start + one.duration, INSTANTS) for one in exact.contacts]
    apart = [np.abs(force_at(found, part) - force_at(exact, part)).max() for part in times]
    return float(max(apart, default=0.0)) / exact.peak_force if exact.peak_force else 0.0


def wanted_errors(parameters, found: BeamImpact, finer: BeamImpact) -> dict[str, float]:
    """The errors of outputs that may be wanted, each in its norm, by a motion that is FINER."""
    own, exact = figures_of(parameters, found), figures_of(parameters, finer)
    peaks = max(relative(own[key], exact[key]) for key in ("peak_force_n", "contact_duration_s"))
    history = _history_apart(found, finer) if finer.peak_force else peaks
    scale = _over_difference(parameters, found)
    return {"peaks": scale * peaks, "forces": scale * history}


def companion_row(parameters, found: BeamImpact, finer: BeamImpact | None, tops: Sequence[Top]) -> np.ndarray:
    """The record of a motion that is FINER (None: there is none) beside a run's.

    `tops` are the run's greatest deflection and stress, or none.
    """
    if finer is None:
        return WATCH.no_row()
    own, exact = figures_of(parameters, found), figures_of(parameters, finer)
    scale = _over_difference(parameters, found)
    errors = {key: difference(own[key], exact[key]) * (1.0 if key == "contact_count" else scale) for key in own}
    errors |= dict.fromkeys(OF_BEAM, math.nan)
    watch = WatchedPoints(parameters, finer) if tops else None
    for column, (key, top) in enumerate(zip(OF_BEAM, tops, strict=False)):
        errors[key] = scale * difference(top.value, watch.top_near(column, top.point, top.times))
    last = found.contacts[-1].start + found.contacts[-1].duration if found.contacts else 0.0
    return row_of(WATCH, last, True, len(finer.lengths), wanted_errors(parameters, found, finer), errors)


@functools.lru_cache(maxsize=64)
def shear_makes_of_forces(parameters) -> float:
    """What the force over time of a checked scene by Euler's beam is off Timoshenko's, over the greatest, roughly."""
    return _history_apart(*thrown_by_both(parameters))


@functools.lru_cache(maxsize=64)
def shear_makes(parameters) -> dict[str, float]:
    """What figures of a checked scene by Euler's beam are off Timoshenko's, in their units, roughly.

    Those that follow from its whole motion: of the sphere; and of the beam where more than contacts is wanted and a
    second motion goes beside, for to look through it costs more than all contacts.
    """
    thrown = thrown_by_both(parameters)
    both = [figures_of(parameters, found) for found in thrown]
    keys = ["contact_count", "restitution", "sphere_velocity_after_m_s", "impulse_ns"]
    if parameters.wanted.outputs == "history" and is_watched(parameters):
        keys.extend(OF_BEAM)
        for figures, found in zip(both, thrown, strict=True):
            tops = WatchedPoints(parameters, found).greatest()
            figures |= {key: top.value for key, top in zip(OF_BEAM, tops, strict=True)}
    return {key: abs(both[0][key] - both[1][key]) for key in keys}


class BeamDoubt(SecondRunDoubt):
    """By a second motion; Euler's beam against Timoshenko's."""

    watch = WATCH
    errorless = (*SecondRunDoubt.errorless, "highest_mode", "gravity_m_s2")

    @property
    def mend(self) -> str:
        if self.choice.stepper == "sinusoidal":
            return "set solver.stepper: modes, which solves for the force"
        if self.parameters.solver.modes or self.parameters.solver.steps:
            return "leave solver.modes and solver.steps out, or raise them"
        return "set a tenth of wanted.tolerance"

    def law(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Of Euler's beam against Timoshenko's; that of Timoshenko's is not known."""
        if theory_of(self.parameters) != EULER or not figures["contact_count"]:
            return {}
        tried = trial(self.parameters)
        by = {"peak_force_n": tried.of_peak, "contact_duration_s": tried.of_time}
        by["greatest_approach_m"] = 2.0 / 3.0 * tried.of_peak
        return {key: share * abs(figures[key]) for key, share in by.items()} | shear_makes(self.parameters)

    def law_of(self, output: str) -> tuple[float, str]:
        """Of Euler's beam against Timoshenko's: of its peaks, and of forces over time those of later contacts, too."""
        if theory_of(self.parameters) != EULER:
            return 0.0, ""
        tried = trial(self.parameters)
        peaks = max(tried.of_peak, tried.of_time)
        off = peaks if output == "peaks" else max(peaks, shear_makes_of_forces(self.parameters))
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
        if self.row is None and is_watched(self.parameters):
            found[METHOD] = "no second computation has been compared: its modes and steps would not fit the memory"
        if theory_of(self.parameters) != EULER:
            found[LAW] = "Timoshenko's beam holds for waves down to a height or two; its error is not known"
        elif trial(self.parameters).contacts > 1:
            found[LAW] = "what follows a second touch needs shear: by Euler's beam what comes of it is another motion"
        return found
