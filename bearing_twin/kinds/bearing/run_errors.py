"""The model errors of a bearing run (law, half-spaces, friction model), and how its second run is made and compared."""

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block
from bearing_twin.base.units import LUBRICATED
from bearing_twin.contact.elasticity import axis_ratio, elliptic_b_d
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bearing.equilibrium import centrifugal_ratio, equilibrium_error, scene_equilibrium
from bearing_twin.kinds.bearing.figures import STRETCH
from bearing_twin.kinds.bearing.lubricant import lubricated
from bearing_twin.kinds.bearing.model_error import (
    SIDES,
    ContactError,
    EquilibriumErrors,
    by_load,
    errors_of_run,
    half_space_error,
    law_error,
    rule_error,
)
from bearing_twin.kinds.bearing.models import mend_of_method
from bearing_twin.kinds.bearing.outputs import has_films
from bearing_twin.kinds.bearing.parameters import LEAST_TOLERANCE, LOADS, BearingScene, as_chosen
from bearing_twin.kinds.bearing.rings import (
    PRESCRIBED,
    QUASI_STATIC,
    TORQUE,
    dimension_of,
    free_coordinates,
    moving_centre,
    shaft_inertia,
)
from bearing_twin.kinds.bearing.step_control import FIXED_STEP
from bearing_twin.kinds.error_estimates import (
    FRICTION_MODEL,
    HERTZ_MENDS,
    LAW,
    LEFT_OUT,
    Comparison,
    Errors,
    ModelError,
    with_tolerance,
)

NOT_MODELLED: dict[str, tuple[Callable[[Any], bool], str]] = {
    "film": (
        lambda parameters: not has_films(parameters),
        "no oil film: its thickness, its rolling resistance and what oil takes along are not computed",
    ),
    LUBRICATED: (
        has_films,
        "films are steady ones, at the temperature given: churning, seals and fresh grease are not computed, and a "
        "measured torque may differ by half",
    ),
    "vibration": (
        lambda parameters: dimension_of(parameters) != QUASI_STATIC,
        "balls and rings are rigid outside their contacts: energy that goes into their vibration is not computed",
    ),
    "cage": (
        lambda parameters: parameters.cage.kind == "none",
        "no cage: its friction and its pushes on the balls are not computed; cage.kind: pockets has them",
    ),
    "cage_guidance": (
        lambda parameters: parameters.cage.kind != "none" and not moving_centre(parameters),
        "the cage stays centred: what guides it, and its friction there, are not computed; cage.guidance has them",
    ),
    "cage_tilt": (
        moving_centre,
        "the cage moves in its plane alone: its tilt, and what it does along the axis, are not computed",
    ),
    "whirl": (
        lambda parameters: (
            dimension_of(parameters) == QUASI_STATIC
            and any(free_coordinates(parameters))
            and not parameters.rings.inner.mass
            and parameters.contact.friction_coefficient > 0.0
        ),
        "whether the ring stays in its equilibrium: friction along the grooves can make it whirl, which is computed "
        "where rings.inner.mass is given",
    ),
    "shear": (
        lambda parameters: dimension_of(parameters) != QUASI_STATIC,
        "no tangential elasticity: friction answers to slip alone, smoothed by contact.friction_regularisation, so "
        "that creep in rolling is what the smoothing gives",
    ),
}
"""Parts of real bearings that are not modelled: the condition, and a sentence on its effect."""

EQUILIBRIA = (  # what is known of a run from them
    "equilibria are solved to rounding; the error of loads is what balls that move differ by; friction is none"
)
LEAST_LOAD = 0.01  # of the greatest load: the friction limit of one that carries less is no scale
TILTING = "ring_moment_nm", "misalignment_rad"
SUMS = {"drive_work_j": "drive_torque_nm", "dissipated_j": "drive_torque_nm"}  # over the angle that the ring turns
STANDS = 1e-12  # rad/s: a ring that turns no faster stands, and work over its angle says nothing of a torque
THEORY = "cage_speed_theory_rad_s", "roll_rate_theory_rad_s"
OUT_OF_PLANE = "ring_moment_nm", *(f"contact_angle_{side}_rad" for side in SIDES)  # all 0: the motion is a plane one


class BearingComparison(Comparison):
    """Loads over the greatest load; friction over its limit, unless loads alone are requested or there is none."""

    exact = (*Comparison.exact, *THEORY, "catalogue_drive_torque_nm")

    def __init__(self, parameters: BearingScene, choice: Choice | None):
        super().__init__(parameters, choice)
        self.outputs = {"loads": "over the greatest load"}
        if parameters.wanted.outputs != LOADS and parameters.contact.friction_coefficient:
            self.outputs["friction"] = "over mu N of a contact, or mu N R of a ball"
        self._greatest = 0.0

    def refined(self):
        """Half of a fixed step, or a fraction of the tolerance; None of equilibria."""
        choice = self.choice
        if choice.stepper == QUASI_STATIC:
            return None
        if choice.stepper in FIXED_STEP:
            return self.parameters, choice._replace(finer=2.0 * choice.finer)
        return with_tolerance(self.parameters, choice, LEAST_TOLERANCE)

    @property
    def smaller(self) -> str:
        return mend_of_method(self.parameters, self.choice)

    def differences(self, own: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Of loads; of friction over mu N, N being LEAST_LOAD of the greatest load so far at least."""
        load, exact = own["normal_load"], second["normal_load"]
        sizes = load.max(axis=(1, 2))
        found = {"loads": (np.abs(load - exact).max(axis=(1, 2)), sizes)}
        greatest = np.maximum.accumulate(np.append(self._greatest, sizes))[1:]
        self._greatest = float(greatest[-1])
        if "friction" in self.outputs:
            least = np.where(greatest > 0.0, LEAST_LOAD * greatest, math.inf)[:, None]
            forces = _lengths(own["friction_force"] - second["friction_force"])
            torques = _lengths(own["raceway_torque"] - second["raceway_torque"])
            radius = 0.5 * self.parameters.geometry.ball_diameter
            apart = np.maximum(
                (forces / np.maximum(exact, least[:, :, None])).max(axis=2),
                torques / radius / np.maximum(exact.sum(axis=2), least),
            )
            coefficient = self.parameters.contact.friction_coefficient
            found["friction"] = apart.max(axis=1) / coefficient, np.ones(len(sizes))
        return found


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (..., 3)."""
    return np.sqrt(np.square(vectors).sum(axis=-1))


class BearingErrors:
    """Gathers what the model errors of a run follow from, in memory that does not grow with the run."""

    in_stretches = False  # blocks may hold many

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters, self.choice = as_chosen(parameters, choice), choice
        balls = parameters.geometry.balls
        self.outputs = 0
        self.load = np.zeros((balls, 2))
        self.curvatures = np.ones((2, balls, 2))
        self.spin = np.zeros((balls, 2))  # greatest under load
        self.friction_work = np.zeros((balls, 2))  # sums of load^(4/3) times spin

    def add(self, block: Block) -> None:
        """Takes a block in."""
        load = np.ascontiguousarray(block.values["normal_load"])
        begins = np.array([0, *range(STRETCH - block.first_sequence % STRETCH, len(block), STRETCH)])
        self.outputs += len(block)
        spin = np.where(load > 0.0, np.abs(block.values["spin_rate"]), 0.0)
        self.spin = np.maximum(self.spin, spin.max(axis=0))
        work = np.add.reduceat(load * np.cbrt(load) * spin, begins, axis=0)
        for stretch in work:  # one after the other: sums are the same to the bit however outputs are cut
            self.friction_work += stretch
        better = load.max(axis=0) > self.load
        at = load.argmax(axis=0)[better], *np.nonzero(better)
        if better.any():
            self.load[better] = load[at]
            for kept, name in zip(self.curvatures, ("curvature_small", "curvature_large"), strict=True):
                kept[better] = block.values[name][at]

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """The model errors of these figures so far."""
        law = law_error(self.parameters, self.choice.law, *self.curvatures, self.load)
        law, found = None if law is None else np.abs(law), {}
        width = np.array([half_space_error(self.parameters, figures[f"semi_major_{side}_m"]) for side in SIDES]).T
        left_out, nearest = self._by_load(figures, width, LEFT_OUT), self._nearest()
        for key, error in (nearest.of_tilt(figures, self.load) if nearest else {}).items():
            left_out[key] = np.add(left_out[key], error).tolist() if key in left_out else error
        for source, errors in (
            (LAW, {} if law is None else self._by_load(figures, law, LAW)),
            (LEFT_OUT, left_out | self._caged(figures)),
            (FRICTION_MODEL, self._friction(figures)),
        ):
            for key, error in errors.items():
                found.setdefault(key, {})[source] = error
        if not any(map(any, (figures[key] for key in OUT_OF_PLANE))):
            found |= {key: {source: [0.0, 0.0] for source in found[key]} for key in TILTING if key in found}
        mends = {LAW: HERTZ_MENDS}
        if self.choice.stepper == QUASI_STATIC:
            mends[FRICTION_MODEL] = self._smaller_steps
        elif not FRICTIONS[self.parameters.contact.friction].over_spot:
            mends[FRICTION_MODEL] = "set contact.friction: spot, which computes the drilling that a point does not hold"
        wanted = self.parameters.wanted.tolerance * float(self.load.max())
        # What is left for the ring is a difference of loads, which err by as much as is wanted.
        negligible = {"ring_force_n": wanted, "ring_moment_nm": 0.5 * self.parameters.geometry.pitch_diameter * wanted}
        outputs = self._of_outputs(law)
        return Errors(found, outputs=outputs, notes=self._notes(), mends=mends, integral_of=SUMS, negligible=negligible)

    def _caged(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Greatest changes by a cage: speeds of balls that none spaces, to those of rolling."""
        if self.parameters.cage.kind != "none" or self.choice.stepper == QUASI_STATIC:
            return {}
        names = (key for key in ("cage_speed_rad_s", "roll_rate_rad_s") if figures.get(key) is not None)
        return {key: abs(figures[key] - figures[key.replace("_rad_s", "_theory_rad_s")]) for key in names}

    @functools.cached_property
    def _equilibria(self) -> list[EquilibriumErrors]:
        return errors_of_run(self.parameters, self.choice.law)

    def _nearest(self) -> EquilibriumErrors | None:
        """The equilibrium whose greatest load is nearest to the run's; None where there is none."""
        return min(self._equilibria, key=lambda one: abs(one.greatest - float(self.load.max())), default=None)

    def _contact_error(self, source: str) -> ContactError | None:
        """Effect of an error of contacts on the nearest equilibrium; None where none stands for the run."""
        nearest = self._nearest()
        if nearest is None or not nearest.stands_for(float(self.load.max())):
            return None
        return nearest.law if source == LAW else nearest.half_space

    def _by_load(self, figures: Mapping[str, Any], share: np.ndarray, source: str) -> dict[str, Any]:
        """Errors of figures where contacts have these relative errors (N, 2) of their load at the same approach."""
        given = dimension_of(self.parameters) != PRESCRIBED  # the ring's loads, else its place
        return by_load(self.parameters.geometry, figures, self.load, share, self._contact_error(source), given)

    def _friction(self, figures: Mapping[str, Any]) -> dict[str, Any]:
        """Errors of the friction model: at a point it has no spin; over a contact patch it is wrong by its quadrature.

        A patch under pure spin resists with 3/8 mu N a E at most, E the complete elliptic integral of its eccentricity;
        with less where its rim is no faster than friction is smoothed over.
        """
        if self.choice.stepper == QUASI_STATIC or not self.outputs:
            return {}
        contact, drive, lubricant = self.parameters.contact, self.parameters.drive, self.parameters.lubricant
        over_patch, coefficient = FRICTIONS[contact.friction].over_spot, contact.friction_coefficient
        if lubricated(self.parameters):  # at most
            coefficient = max(lubricant.boundary_friction, lubricant.film_friction)
        most, power = np.zeros(len(self.load)), 0.0
        for side, ball in np.argwhere(self.load.T > 0.0):
            load, major = self.load[ball, side], figures[f"semi_major_{SIDES[side]}_m"][ball]
            ratio = axis_ratio(*(float(one[ball, side]) for one in self.curvatures))
            b, d = elliptic_b_d(ratio)
            greatest = 0.375 * coefficient * load * major * (b + ratio * ratio * d)
            rim = self.spin[ball, side] * major
            error = rule_error(contact, ratio, rim) if over_patch else 1.0
            most[ball] += greatest * (error if over_patch else rim / math.hypot(rim, contact.friction_regularisation))
            power += greatest * (self.friction_work[ball, side] / self.outputs) / load ** (4.0 / 3.0) * error
        seconds = max(self.outputs - 1, 0) / self.parameters.run.output_rate
        speed = abs(figures["inner_ring_speed_at_end_rad_s"])
        found = {
            "dissipated_j": power * seconds,
            "drive_work_j": power * seconds,
            "friction_torque_nm": most.tolist(),
        }
        if speed <= STANDS:
            return found
        if drive.kind != TORQUE:
            return found | {"drive_torque_nm": power / speed}
        faster = power / speed * seconds / shaft_inertia(self.parameters)
        work = abs(figures["drive_torque_nm"]) * faster * seconds
        return found | {"inner_ring_speed_at_end_rad_s": faster, "drive_torque_nm": 0.0, "drive_work_j": work}

    def _of_outputs(self, law: np.ndarray | None) -> dict[str, tuple[ModelError, ...]]:
        """Model errors of the requested outputs: of the law, and of equilibria where balls move."""
        greatest, error = float(self.load.max()), self._contact_error(LAW)
        off = 0.0 if law is None or not greatest else float((law * self.load).max(initial=0.0)) / greatest
        of_loads = [ModelError(LAW, off if error is None else off * error.kept, HERTZ_MENDS)]
        if self.choice.stepper != QUASI_STATIC:
            return {"loads": tuple(of_loads)}
        ratio = centrifugal_ratio(scene_equilibrium(self.parameters, self.choice.law).contacts)
        of_loads.append(ModelError(LEFT_OUT, equilibrium_error(ratio), self._smaller_steps))
        return {"loads": tuple(of_loads)}

    @functools.cached_property
    def _smaller_steps(self) -> str:
        return mend_of_method(self.parameters, self.choice)

    def _notes(self) -> dict[str, str]:
        """Sentences on errors that are not known, by source and by what is not modelled."""
        notes = {LEFT_OUT: EQUILIBRIA} if self.choice.stepper == QUASI_STATIC else {}
        if self.choice.law in LAWS and LAWS[self.choice.law].measured:
            notes[LAW] = f"the law {self.choice.law} is given by the scene; nothing is known of its error"
        model, beyond = FRICTIONS[self.parameters.contact.friction], "not what the motion makes of it, as in roll rates"
        if not model.over_spot:
            notes[FRICTION_MODEL] = (
                "contact.friction: point holds no drilling: errors hold the torque and the loss that the spots' spin "
                f"would add, {beyond}; contact.friction: spot computes it"
            )
        elif self.choice.stepper != QUASI_STATIC:
            notes[FRICTION_MODEL] = f"errors hold torque and loss that contact.friction: {model.name} errs by, {beyond}"
        return notes | {name: words for name, (lacks, words) in NOT_MODELLED.items() if lacks(self.parameters)}
