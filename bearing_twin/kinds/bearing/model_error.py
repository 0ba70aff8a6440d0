"""Model errors of bearings in equilibrium and of runs, and the second run of a run and its comparison.

Errors of the elastic law, of the half-space and of a tilt in first order change the loads of contacts at the same
approach, as raceways do that are higher or lower under the balls. The response of balls and ring is another
equilibrium, with slightly higher raceways, whose change is scaled up.
"""

import contextlib
import copy
import functools
import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Block
from bearing_twin.base.units import LUBRICATED
from bearing_twin.contact.elasticity import axis_ratio, elliptic_b_d
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.validity import FELT, gap_error
from bearing_twin.kinds.bearing.equilibrium import (
    FOUND,
    Equilibrium,
    EquilibriumSolver,
    Support,
    azimuths_of,
    controlled_equilibrium,
    ellipses_of,
    equilibrium_error,
    load_line,
    scene_equilibrium,
    solver_under_gravity,
    support_with_weight,
)
from bearing_twin.kinds.bearing.equilibrium_motion import NEGLIGIBLE
from bearing_twin.kinds.bearing.integrate import FIXED_STEP
from bearing_twin.kinds.bearing.lubricant import is_lubricated
from bearing_twin.kinds.bearing.models import law_error, mend_of_method, rule_error
from bearing_twin.kinds.bearing.parameters import LEAST_TOLERANCE, BearingScene, with_chosen_friction
from bearing_twin.kinds.bearing.rings import (
    LOADS,
    PRESCRIBED,
    QUASI_STATIC,
    TORQUE,
    dimension_of,
    free_coordinates,
    moving_centre,
    scenes_by_speed,
    shaft_inertia,
)
from bearing_twin.kinds.bearing.system import Loading
from bearing_twin.kinds.error_estimates import (
    FRICTION_MODEL,
    HERTZ_MENDS,
    LAW,
    NOT_MODELLED,
    Comparison,
    Errors,
    ModelError,
    with_tolerance,
)

SIDES = ("inner", "outer")
HALF_SPACE, TILT = "half_space", "first_order_tilt"
SMALL = 1e-3  # of the greatest approach: heights with which responses are found
REPRESENTATIVE = 0.1  # of the greatest load: an equilibrium whose greatest differs by less represents a run
ROUNDING = 1e-9  # of the greatest change: less is rounding
LOAD_FIGURES = "normal_load", "greatest_normal_load"  # figures of contacts' loads
ELLIPSES = ("semi_major", "m"), ("semi_minor", "m"), ("peak_pressure", "pa")
RING = ("ring_displacement_m", "misalignment_rad"), ("ring_force_n", "ring_moment_nm")


def half_space_error(parameters, semi_major):
    """Relative errors of loads with these semi-axes (N, 2) [m], since Hertz takes bodies for parabolic half-spaces."""
    geometry = parameters.geometry
    grooves = geometry.ball_diameter * np.array([geometry.inner_conformity, geometry.outer_conformity])
    return FELT * gap_error(np.asarray(semi_major), 0.5 * geometry.ball_diameter, grooves)


class Response(NamedTuple):
    """First-order changes: of contact `loads` [N] and `angles` [rad] (N, 2), ring `coordinates` and `ring_loads` (5,).

    `ring_loads` [N, N m] are those from outside; only those of held coordinates change.
    """

    loads: np.ndarray
    angles: np.ndarray
    coordinates: np.ndarray
    ring_loads: np.ndarray


def response_to(
    solver: EquilibriumSolver, support: Support, equilibrium: Equilibrium, heights, loads=(0.0,) * 5, held=(0.0,) * 5
) -> Response:
    """The response of an equilibrium to raceways that are higher under the balls by `heights` (N, 2) [m].

    `loads` (5,) [N, N m] are added to those that hold the ring in place, `held` (5,) to its held coordinates. NaN where
    there is no equilibrium.
    """
    loads, held, stiffness = np.asarray(loads), np.asarray(held), np.diagonal(equilibrium.stiffness)
    shift = held + np.divide(loads, stiffness, out=np.zeros(5), where=stiffness > 0.0)
    size = max(float(np.abs(heights).max()), float(np.abs(shift * solver.scales).max()))
    if size == 0.0:
        return Response(np.zeros_like(heights), np.zeros_like(heights), np.zeros(5), np.zeros(5))
    step, displaced = SMALL * float(equilibrium.contacts.approach.max()) / size, copy.copy(solver)
    displaced.heights = step * heights + solver.heights
    perturbed = displaced.balance(
        support._replace(loads=np.array(support.loads) - step * loads, held=np.array(support.held) + step * held)
    )
    changes = Response(
        perturbed.contacts.load - equilibrium.contacts.load,
        np.where(equilibrium.contacts.load > 0.0, perturbed.contacts.angle - equilibrium.contacts.angle, 0.0),
        perturbed.coordinates - equilibrium.coordinates,
        np.where(support.free, 0.0, perturbed.loads - equilibrium.loads + step * loads),
    )
    return Response(
        *(change / step if perturbed.status == FOUND else np.full_like(change, math.nan) for change in changes)
    )


def heights_of(solver: EquilibriumSolver, equilibrium: Equilibrium, shares: np.ndarray) -> np.ndarray:
    """Heights of raceways (N, 2) [m] by which loads of contacts grow by these shares (N, 2)."""
    contacts = equilibrium.contacts
    return np.where(contacts.load > 0.0, shares * contacts.approach / solver.setting.inner.law.power, 0.0)


def response_of(solver: EquilibriumSolver, support: Support, equilibrium: Equilibrium, shares: np.ndarray) -> Response:
    """The response to contacts that carry these shares (N, 2) more than by their law at the same approach.

    External loads stay: a share common to all contacts only moves the ring.
    """
    return response_to(solver, support, equilibrium, heights_of(solver, equilibrium, shares))


def response_to_tilt(solver: EquilibriumSolver, support: Support, equilibrium: Equilibrium) -> Response | None:
    """Response to the exact circle of the inner groove's centres, in first order; None of a ring without tilt.

    A tilt of first order keeps the circle's radius R. For a ball at an azimuth where the tilt lifts the circle by R b,
    the exact circle is nearer to the axis by R b^2/2: the approach is less by the cosine of the contact angle times
    that, and the lever of the contact's load changes.
    """
    arm, tilt, load = solver.setting.arm, equilibrium.coordinates[3:], equilibrium.contacts.load
    if arm * np.abs(tilt).max() <= NEGLIGIBLE * np.abs(equilibrium.coordinates[:3]).max():
        return None
    levers = np.stack(
        [np.sin(equilibrium.azimuths), -np.cos(equilibrium.azimuths)], axis=1
    )  # tilt in each ball's plane, by theta
    lifted, cosine = levers @ tilt, np.cos(equilibrium.contacts.angle[:, 0])
    heights, loads = np.zeros_like(load), np.zeros(5)
    heights[:, 0] = -0.5 * arm * lifted**2 * cosine
    loads[3:] = -arm * (load[:, 0] * cosine * lifted) @ levers
    return response_to(solver, support, equilibrium, heights, loads)


class EquilibriumErrors(NamedTuple):
    """Model errors of an equilibrium with this `greatest` contact load [N]: responses by source.

    There is none to a law of unknown error, nor to the tilt of a ring without tilt. `retained` is the part of the
    greatest contact's error that its load retains: a share common to all contacts only moves a free ring.
    """

    greatest: float
    responses: dict[str, Response]
    retained: dict[str, float]


def errors_at(
    parameters, law: str, solver: EquilibriumSolver, support: Support, equilibrium: Equilibrium
) -> EquilibriumErrors:
    """The model errors of an equilibrium of `solver`."""
    contacts, responses, retained = equilibrium.contacts, {}, {}
    for source, shares in (
        (LAW, law_error(parameters, law, contacts.curvature_small, contacts.curvature_large, contacts.load)),
        (HALF_SPACE, half_space_error(parameters, ellipses_of(parameters, contacts)[0])),
    ):
        if shares is not None:
            responses[source] = response_of(solver, support, equilibrium, shares)
            unloaded = float(np.abs(shares * contacts.load).max())
            retained[source] = float(np.abs(responses[source].loads).max()) / unloaded if unloaded > 0.0 else 1.0
    tilted = response_to_tilt(solver, support, equilibrium)
    return EquilibriumErrors(float(contacts.load.max()), responses | ({TILT: tilted} if tilted else {}), retained)


def errors_of_run(parameters, law: str) -> list[EquilibriumErrors]:
    """Errors under the loads and speeds at begin and end of a run, with a ball on the load line.

    None for a held ring without tilt, or a load that nothing carries; one if both loads are the same.
    """
    if dimension_of(parameters) == PRESCRIBED and not any(parameters.drive.tilt):
        return []
    loading, errors = Loading(parameters.rings.inner), []
    loads = dict.fromkeys(tuple(loading.at(time)[0].tolist()) for time in (0.0, float(parameters.run.duration)))
    for scene in scenes_by_speed(parameters):
        for load in loads:
            support = support_with_weight(scene, load)
            azimuths = azimuths_of(scene.geometry.balls, load_line(support))
            solver = solver_under_gravity(scene, law, scene.drive.speed, azimuths)
            with contextlib.suppress(SceneError):
                errors.append(errors_at(scene, law, solver, support, controlled_equilibrium(scene, solver, support)))
    return errors


def model_errors(parameters, law: str, solver: EquilibriumSolver, support: Support, equilibrium: Equilibrium) -> dict:
    """Errors of an equilibrium by source, in SI units: of loads and angles the greatest of all contacts."""
    return {
        source: {
            "normal_load_n": float(np.abs(response.loads).max()),
            "contact_angle_rad": float(np.abs(response.angles).max()),
            **_ring_errors(response.coordinates, response.ring_loads),
        }
        for source, response in errors_at(parameters, law, solver, support, equilibrium).responses.items()
    }


def _ring_errors(coordinates, loads) -> dict[str, list[float]]:
    """Errors of the ring's figures, 0 where they are rounding."""
    errors = {}
    for names, changes in zip(RING, (np.abs(coordinates), np.abs(loads)), strict=True):
        for key, part in zip(names, np.split(changes, [3]), strict=True):
            errors[key] = np.where(part > ROUNDING * part.max(), part, 0.0).tolist()
    return errors


def _figures_of_pair(pattern: str, values: np.ndarray) -> dict[str, list[float]]:
    """Figures of both raceways, lists with one value a ball, from an array (N, 2)."""
    return {pattern.format(side): values[:, column].tolist() for column, side in enumerate(SIDES)}


def _pair(figures: Mapping[str, Any], pattern: str) -> np.ndarray:
    """The figures of both raceways as an array (N, 2), the reverse of `_figures_of_pair`."""
    return np.array([figures[pattern.format(side)] for side in SIDES]).T


def _ellipse_errors(figures: Mapping[str, Any], share: np.ndarray) -> dict[str, list[float]]:
    """Errors of ellipses and pressures, which follow cube roots of loads with these relative errors (N, 2)."""
    errors = {}
    for key, unit in ELLIPSES:
        errors |= _figures_of_pair(f"{key}_{{}}_{unit}", share * _pair(figures, f"{key}_{{}}_{unit}") / 3.0)
    return errors


MISSING_PHYSICS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "film": (
        lambda parameters: not is_lubricated(parameters),
        "no oil film: its thickness, its rolling resistance and the drag of the oil are not computed",
    ),
    LUBRICATED: (
        is_lubricated,
        "films are steady, at the specified temperature: churning, seals and fresh grease are not computed, and a "
        "measured torque may differ by half",
    ),
    "vibration": (
        lambda parameters: dimension_of(parameters) != QUASI_STATIC,
        "balls and rings are rigid outside their contacts: energy that goes into their vibration is not computed",
    ),
    "cage": (
        lambda parameters: parameters.cage.kind == "none",
        "no cage: its friction and its forces on the balls are not computed; cage.kind: pockets computes them",
    ),
    "cage_guidance": (
        lambda parameters: parameters.cage.kind != "none" and not moving_centre(parameters),
        "the cage stays centred: its guidance and the friction there are not computed; cage.guidance computes them",
    ),
    "cage_tilt": (
        moving_centre,
        "the cage moves in its plane alone: its tilt and its axial motion are not computed",
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
        "no tangential elasticity: friction depends on slip alone, smoothed by contact.friction_regularisation, which "
        "determines the creep of rolling",
    ),
}
"""Parts of real bearings that are not modelled: the condition, and a sentence on its effect."""

EQUILIBRIA = (  # note on their errors
    "equilibria are exact to rounding; the error of loads is the difference of moving balls; friction is not computed"
)
LEAST_LOAD = 0.01  # of the greatest load: smaller loads have the friction limit of this one
STRETCH = 50  # outputs that are summed before they are added to the previous sum
TILTING = "ring_moment_nm", "misalignment_rad"
INTEGRALS = {"drive_work_j": "drive_torque_nm", "dissipated_j": "drive_torque_nm"}  # over the angle that the ring turns
NO_ROTATION = 1e-12  # rad/s: a slower ring is at rest, and work over its angle is no torque
THEORY = "cage_speed_theory_rad_s", "roll_rate_theory_rad_s"
OUT_OF_PLANE = "ring_moment_nm", *(f"contact_angle_{side}_rad" for side in SIDES)  # all 0 in plane motion


class BearingComparison(Comparison):
    """Loads over the greatest load; friction over its limit, unless loads alone are requested or there is none."""

    exact = (*Comparison.exact, *THEORY, "catalogue_drive_torque_nm")

    def __init__(self, parameters: BearingScene, choice: Choice | None):
        super().__init__(parameters, choice)
        self.outputs = {"loads": "relative to the greatest load"}
        if parameters.wanted.outputs != LOADS and parameters.contact.friction_coefficient:
            self.outputs["friction"] = "relative to the friction limit (mu N of a contact, mu N R of a ball)"
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

    def differences(self, first: Block, second: Block) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Of loads; of friction over mu N, N being LEAST_LOAD of the greatest load so far at least."""
        load, exact = first["normal_load"], second["normal_load"]
        sizes = load.max(axis=(1, 2))
        differences = {"loads": (np.abs(load - exact).max(axis=(1, 2)), sizes)}
        greatest = np.maximum.accumulate(np.append(self._greatest, sizes))[1:]
        self._greatest = float(greatest[-1])
        if "friction" in self.outputs:
            least = np.where(greatest > 0.0, LEAST_LOAD * greatest, math.inf)[:, None]
            forces = _lengths(first["friction_force"] - second["friction_force"])
            torques = _lengths(first["raceway_torque"] - second["raceway_torque"])
            radius = 0.5 * self.parameters.geometry.ball_diameter
            difference = np.maximum(
                (forces / np.maximum(exact, least[:, :, None])).max(axis=(1, 2)),
                (torques / radius / np.maximum(exact[:, :, 0] + exact[:, :, 1], least)).max(axis=1),
            )
            differences["friction"] = difference / self.parameters.contact.friction_coefficient, np.ones(len(sizes))
        return differences


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.sqrt(x * x + y * y + z * z)  # four times faster than a sum along an axis of three


class BearingErrors:
    """Collects the quantities that determine model errors of a run, in memory that does not grow with the run."""

    in_stretches = False  # blocks may hold many

    def __init__(self, parameters: BearingScene, choice: Choice):
        self.parameters, self.choice = with_chosen_friction(parameters, choice), choice
        balls = parameters.geometry.balls
        self.outputs = 0
        self.load = np.zeros((balls, 2))
        self.curvatures = np.ones((2, balls, 2))
        self.spin = np.zeros((balls, 2))  # greatest under load
        self.friction_work = np.zeros((balls, 2))  # sums of load^(4/3) times spin

    def add(self, block: Block) -> None:
        """Add a block."""
        load = np.ascontiguousarray(block.values["normal_load"])
        begins = np.array([0, *range(STRETCH - block.first_sequence % STRETCH, len(block), STRETCH)])
        self.outputs += len(block)
        spin = np.where(load > 0.0, np.abs(block.values["spin_rate"]), 0.0)
        self.spin = np.maximum(self.spin, spin.max(axis=0))
        work = np.add.reduceat(load * np.cbrt(load) * spin, begins, axis=0)
        for stretch in work:  # in this order, so that sums are bit-identical for all chunks
            self.friction_work += stretch
        greater = load.max(axis=0) > self.load
        there = load.argmax(axis=0)[greater], *np.nonzero(greater)
        if greater.any():
            self.load[greater] = load[there]
            for curvature, name in zip(self.curvatures, ("curvature_small", "curvature_large"), strict=True):
                curvature[greater] = block.values[name][there]

    def errors(self, figures: Mapping[str, Any]) -> Errors:
        """The model errors of these figures so far."""
        greatest, by_figure = float(self.load.max()), {}
        nearest = min(self._equilibria, key=lambda equilibrium: abs(equilibrium.greatest - greatest), default=None)
        is_near = nearest is not None and abs(nearest.greatest - greatest) <= REPRESENTATIVE * greatest
        representative = nearest if is_near else None
        law = law_error(self.parameters, self.choice.law, *self.curvatures, self.load)
        width = half_space_error(self.parameters, _pair(figures, "semi_major_{}_m"))
        not_modelled = self._contact_errors(figures, width, representative, HALF_SPACE)
        tilted = self._tilt_errors(figures, nearest.responses[TILT]) if nearest and TILT in nearest.responses else {}
        for key, error in tilted.items():
            not_modelled[key] = np.add(not_modelled[key], error).tolist() if key in not_modelled else error
        of_law = {} if law is None else self._contact_errors(figures, np.abs(law), representative, LAW)
        for source, errors in (
            (LAW, of_law),
            (NOT_MODELLED, not_modelled | self._cage_errors(figures)),
            (FRICTION_MODEL, self._friction_errors(figures)),
        ):
            for key, error in errors.items():
                by_figure.setdefault(key, {})[source] = error
        if not any(map(any, (figures[key] for key in OUT_OF_PLANE))):
            by_figure |= {key: {source: [0.0, 0.0] for source in by_figure[key]} for key in TILTING if key in by_figure}
        mends = {LAW: HERTZ_MENDS}
        if self.choice.stepper == QUASI_STATIC:
            mends[FRICTION_MODEL] = self._smaller_steps
        elif not FRICTIONS[self.parameters.contact.friction].over_patch:
            mends[FRICTION_MODEL] = "set contact.friction: patch, which computes the friction of spin"
        # What is left for the ring is a difference of loads, each with an error of the tolerance.
        tolerance = self.parameters.wanted.tolerance
        least, torque = tolerance * greatest, tolerance * (figures.get("catalogue_drive_torque_nm") or 0.0)
        negligible = {"ring_force_n": least, "ring_moment_nm": 0.5 * self.parameters.geometry.pitch_diameter * least}
        negligible |= {"ring_force_range_n": least, "drive_torque_nm": torque, "friction_torque_nm": torque}
        law_share = 0.0 if law is None or not greatest else float(np.abs(law * self.load).max()) / greatest
        of_loads = [
            ModelError(LAW, law_share * (nearest.retained.get(LAW, 1.0) if representative else 1.0), HERTZ_MENDS)
        ]
        if self.choice.stepper == QUASI_STATIC:
            contacts = scene_equilibrium(self.parameters, self.choice.law).contacts
            of_loads.append(ModelError(NOT_MODELLED, equilibrium_error(contacts), self._smaller_steps))
        outputs = {"loads": tuple(of_loads)}
        return Errors(
            by_figure, outputs=outputs, notes=self._notes(), mends=mends, integral_of=INTEGRALS, negligible=negligible
        )

    def _contact_errors(
        self, figures: Mapping[str, Any], share: np.ndarray, error: EquilibriumErrors | None, source: str
    ) -> dict[str, Any]:
        """Errors of figures where contacts have these relative errors (N, 2) of their load at the same approach.

        `error` is the equilibrium that represents the run. A share common to all contacts scales the force on a held
        ring, and only moves one under a given load; differences between contacts need not cancel.
        """
        retained, errors = share if error is None else error.retained[source] * share, {}
        for key in LOAD_FIGURES:
            errors |= _figures_of_pair(f"{key}_{{}}_n", retained * np.abs(_pair(figures, f"{key}_{{}}_n")))
        if error is not None:
            shift, ring = error.responses[source][2:]
        else:
            shift, ring = np.zeros(5), np.zeros(5)
            greatest, touching = float(share.max(initial=0.0)), self.load[:, 0] > 0.0
            if dimension_of(self.parameters) != PRESCRIBED:
                for part, key in ((slice(3), "ring_displacement_m"), (slice(3, 5), "misalignment_rad")):
                    shift[part] = 2.0 / 3.0 * greatest * math.hypot(*figures.get(key, ()))
            else:
                uneven = float(np.ptp(share[touching, 0])) if touching.any() else 0.0
                uneven *= math.fsum(map(abs, figures["normal_load_inner_n"]))
                arm = 0.5 * self.parameters.geometry.pitch_diameter
                ring[:3] = greatest * max(map(abs, figures["ring_force_n"])) + uneven
                ring[3:] = greatest * max(map(abs, figures["ring_moment_nm"])) + arm * uneven
        return errors | _ellipse_errors(figures, share) | _ring_errors(shift, ring)

    def _tilt_errors(self, figures: Mapping[str, Any], tilt: Response) -> dict[str, Any]:
        """Greatest errors of figures by the tilt in first order."""
        added, angles = (np.broadcast_to(np.abs(change).max(axis=0), self.load.shape) for change in tilt[:2])
        share = np.divide(added, self.load, out=np.zeros_like(self.load), where=self.load > 0.0)
        errors = _figures_of_pair("contact_angle_{}_rad", angles) | _ellipse_errors(figures, np.minimum(share, 1.0))
        for key in LOAD_FIGURES:
            errors |= _figures_of_pair(f"{key}_{{}}_n", added)
        return errors | _ring_errors(*tilt[2:])

    def _cage_errors(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Greatest changes by a missing cage: of speeds of balls to those of rolling."""
        if self.parameters.cage.kind != "none" or self.choice.stepper == QUASI_STATIC:
            return {}
        names = (key for key in ("cage_speed_rad_s", "roll_rate_rad_s") if figures.get(key) is not None)
        return {key: abs(figures[key] - figures[key.replace("_rad_s", "_theory_rad_s")]) for key in names}

    @functools.cached_property
    def _equilibria(self) -> list[EquilibriumErrors]:
        return errors_of_run(self.parameters, self.choice.law)

    def _friction_errors(self, figures: Mapping[str, Any]) -> dict[str, Any]:
        """Errors of the friction model: at a point the missing spin, over a contact patch those of its quadrature.

        A patch under pure spin resists with 3/8 mu N a E at most, E the complete elliptic integral of its eccentricity;
        with less where its rim is slower than the regularisation speed.
        """
        if self.choice.stepper == QUASI_STATIC or not self.outputs:
            return {}
        contact, drive, lubricant = self.parameters.contact, self.parameters.drive, self.parameters.lubricant
        over_patch, coefficient = FRICTIONS[contact.friction].over_patch, contact.friction_coefficient
        if is_lubricated(self.parameters):  # an upper bound
            coefficient = max(lubricant.boundary_friction, lubricant.film_friction)
        torques, power = np.zeros(len(self.load)), 0.0
        for side, ball in np.argwhere(self.load.T > 0.0):
            load, major = self.load[ball, side], figures[f"semi_major_{SIDES[side]}_m"][ball]
            ratio = axis_ratio(*(float(curvature[ball, side]) for curvature in self.curvatures))
            b, d = elliptic_b_d(ratio)
            greatest = 0.375 * coefficient * load * major * (b + ratio * ratio * d)
            rim = self.spin[ball, side] * major
            error = rule_error(contact, ratio, rim) if over_patch else 1.0
            torques[ball] += greatest * (
                error if over_patch else rim / math.hypot(rim, contact.friction_regularisation)
            )
            power += greatest * (self.friction_work[ball, side] / self.outputs) / load ** (4.0 / 3.0) * error
        seconds = max(self.outputs - 1, 0) / self.parameters.run.output_rate
        speed = abs(figures["inner_ring_speed_at_end_rad_s"])
        errors = {
            "dissipated_j": power * seconds,
            "drive_work_j": power * seconds,
            "friction_torque_nm": torques.tolist(),
        }
        if speed <= NO_ROTATION:
            return errors
        if drive.kind != TORQUE:
            return errors | {"drive_torque_nm": power / speed}
        faster = power / speed * seconds / shaft_inertia(self.parameters)
        work = abs(figures["drive_torque_nm"]) * faster * seconds
        return errors | {"inner_ring_speed_at_end_rad_s": faster, "drive_torque_nm": 0.0, "drive_work_j": work}

    @functools.cached_property
    def _smaller_steps(self) -> str:
        return mend_of_method(self.parameters, self.choice)

    def _notes(self) -> dict[str, str]:
        """Sentences on unknown errors, by source and by parts that are not modelled."""
        notes = {NOT_MODELLED: EQUILIBRIA} if self.choice.stepper == QUASI_STATIC else {}
        if self.choice.law in LAWS and LAWS[self.choice.law].measured:
            notes[LAW] = f"the law {self.choice.law} is given by the scene; nothing is known of its error"
        model, limits = FRICTIONS[self.parameters.contact.friction], "not their effect on the motion, as on roll rates"
        if not model.over_patch:
            notes[FRICTION_MODEL] = (
                "contact.friction: point has no friction of spin: errors are the torque and loss that it would add, "
                f"{limits}; contact.friction: patch computes it"
            )
        elif self.choice.stepper != QUASI_STATIC:
            notes[FRICTION_MODEL] = f"errors are those of torque and loss by contact.friction: {model.name}, {limits}"
        return notes | {name: sentence for name, (lacks, sentence) in MISSING_PHYSICS.items() if lacks(self.parameters)}
