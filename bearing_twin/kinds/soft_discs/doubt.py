"""What the figures of soft discs are worth: by a second mesh, whose coarseness against the run's is known."""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from bearing_twin.errors import IntegrationError
from bearing_twin.kinds.doubt import LAW, METHOD
from bearing_twin.kinds.impact.doubt import relative
from bearing_twin.kinds.second_run import SecondRunDoubt, difference, is_watched, row_of
from bearing_twin.kinds.soft_discs.derived import ERRORS, nodes_of, predicted_error
from bearing_twin.kinds.soft_discs.figures import FIGURES, WATCH
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene
from bearing_twin.kinds.soft_discs.solve import Solved, solve

COARSER = 2.0 / 3.0  # of the divisions, at most: 30 % of the work
SMOOTH = ("peak_force_n", "contact_duration_s", "least_stretch")  # figures that converge as the force does
SLOW, SLOW_RATE = 2.0, 1.5
"""Times the difference of both meshes by ERRORS: where they differ by more, as in discs that are pressed far, errors
fall more slowly, by about this power of the divisions (`bearing_twin chart bodies`, soft_discs_fast)."""
INSTANTS = 1000  # at which forces are compared


def second_divisions(divisions: int, order: int) -> int:
    """Divisions of the second mesh: coarser where there is one, else finer: of the fewest a run takes no time."""
    step = 2 * order
    coarser = math.floor(COARSER * divisions / step) * step
    return coarser if coarser >= max(step, 4) else divisions + step


def share_of_difference(divisions: int, other: int, rate: float) -> float:
    """The run's error over the difference of both, where errors fall as divisions^-rate."""
    return 1.0 / abs((divisions / other) ** rate - 1.0)


def companion_row(parameters: SoftDiscsScene, found: Solved, figures: Mapping[str, float], figures_of) -> np.ndarray:
    """The record (n, columns) of a run on another mesh beside this one's; none where that breaks off.

    `figures_of(solved)` gives FIGURES of a run; `figures` are those of this one.
    """
    own, order = parameters.mesh.divisions, parameters.mesh.order
    divisions = second_divisions(own, order)
    mesh = dataclasses.replace(parameters.mesh, divisions=divisions)
    try:
        other = solve(dataclasses.replace(parameters, mesh=mesh), 2)
    except IntegrationError:
        return WATCH.no_row()
    exact = figures_of(other)
    times = np.linspace(0.0, max(figures["contact_duration_s"], exact["contact_duration_s"]), INSTANTS)
    force = found.at("force", times)
    apart, size = (math.sqrt(float(np.mean(np.square(one)))) for one in (force - other.at("force", times), force))
    expected = abs(predicted_error(order, own) - predicted_error(order, divisions))
    slow = relative(size + apart, size) > SLOW * expected
    rate = min(SLOW_RATE, ERRORS[order][1]) if slow else ERRORS[order][1]
    scale, rough = (share_of_difference(own, divisions, one) for one in (rate, 1.0))
    peaks = max(relative(exact[key], figures[key]) for key in ("peak_force_n", "contact_duration_s"))
    wanted = {"peaks": scale * peaks, "forces": scale * relative(size + apart, size)}
    errors = {key: difference(figures[key], exact[key]) * (scale if key in SMOOTH else rough) for key in FIGURES}
    errors["touches"] = difference(figures["touches"], exact["touches"])
    # A flat peak: what is off by a share of its height is off by the root of that share in time.
    flat = figures["contact_duration_s"] * math.sqrt(wanted["forces"]) / math.pi
    errors["peak_time_s"] = max(errors["peak_time_s"], flat)
    errors["peak_force_n"] = max(errors["peak_force_n"], wanted["forces"] * figures["peak_force_n"])
    steps = len(other.history) * nodes_of(divisions) // nodes_of(parameters.mesh.divisions)
    return row_of(WATCH, figures["contact_duration_s"], True, steps, wanted, errors)


class SoftDiscDoubt(SecondRunDoubt):
    """By a second mesh."""

    watch = WATCH
    errorless = (*SecondRunDoubt.errorless, "force_balance", "wall_speed_m_s", "nodes", "elements")

    def promised(self) -> tuple[str, ...]:
        """The force over time, or its peak alone."""
        return ("peaks" if self.parameters.wanted.outputs == "peaks" else "forces",)

    @property
    def mend(self) -> str:
        """What makes the mesh's error smaller."""
        mesh = self.parameters.mesh
        return f"set mesh.divisions above {mesh.divisions}" if mesh.divisions else "set a third of wanted.tolerance"

    def notes(self) -> dict[str, str]:
        found = {
            "penalty": "contact is a bed of springs, whose depth stands in greatest_penetration_m: a harder one, "
            "contact.stiffness_ratio, is nearer to a rigid wall",
            "viscosity": "the material loses nothing: rubber does",
            LAW: "the material's law is the scene's formulation: others differ in force by up to about the greatest "
            "strain, 1 - least_stretch, which is in no error",
        }
        if self.row is None and is_watched(self.parameters):
            found[METHOD] = "a run on the second mesh broke off, so the mesh's error is not known"
        return found
