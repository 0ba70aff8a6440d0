"""Model errors of bearings in equilibrium and of runs, and how the second run of a run is made and compared.

Contacts whose law is wrong, bodies that are no half-spaces and a ring whose tilt is one of first order carry other
loads at the same approach, as if the raceways stood higher or lower under the balls: what balls and ring do then is one
more equilibrium, with raceways that are higher by a little, whose change is scaled up.
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
    setting_of,
    solver_under_gravity,
    support_with_weight,
)
from bearing_twin.kinds.bearing.equilibrium_motion import NEGLIGIBLE
from bearing_twin.kinds.bearing.integrate import FIXED_STEP
from bearing_twin.kinds.bearing.lubricant import is_lubricated
from bearing_twin.kinds.bearing.models import law_error, mend_of_method, rule_error
from bearing_twin.kinds.bearing.parameters import LEAST_TOLERANCE, LOADS, BearingScene, with_chosen_friction
from bearing_twin.kinds.bearing.rings import (
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
ALIKE = 0.1  # of the greatest load: an equilibrium whose greatest is nearer than this stands for a run
NOTHING = 1e-9  # of the greatest change: less is rounding
LOADS_OF = "normal_load", "greatest_normal_load"  # figures of contacts' loads
ELLIPSES = ("semi_major", "m"), ("semi_minor", "m"), ("peak_pressure", "pa")
RING = ("ring_displacement_m", "misalignment_rad"), ("ring_force_n", "ring_moment_nm")


def half_space_error(parameters, semi_major):
    """Relative errors of loads whose ellipses have these semi-axes (N, 2) [m], as Hertz takes bodies for parabolas."""
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
    solver: EquilibriumSolver, support: Support, found: Equilibrium, heights, loads=(0.0,) * 5, held=(0.0,) * 5
) -> Response:
    """The response of an equilibrium `found` to raceways that are higher under the balls by `heights` (N, 2) [m].

    The ring needs `loads` (5,) [N, N m] more from outside to stay where it is, and is held further on by `held` (5,).
    NaN where there is no equilibrium.
    """
    loads, held, own = np.asarray(loads), np.asarray(held), np.diagonal(found.stiffness)
    moved = held + np.divide(loads, own, out=np.zeros(5), where=own > 0.0)
    size = max(float(np.abs(heights).max()), float(np.abs(moved * solver.scales).max()))
    if size == 0.0:
        return Response(np.zeros_like(heights), np.zeros_like(heights), np.zeros(5), np.zeros(5))
    step, other = SMALL * float(found.contacts.approach.max()) / size, copy.copy(solver)
    other.heights = step * heights + solver.heights
    now = other.balance(
        support._replace(loads=np.array(support.loads) - step * loads, held=np.array(support.held) + step * held)
    )
    changes = Response(
        now.contacts.load - found.contacts.load,
        np.where(found.contacts.load > 0.0, now.contacts.angle - found.contacts.angle, 0.0),
        now.coordinates - found.coordinates,
        np.where(support.free, 0.0, now.loads - found.loads + step * loads),
    )
    return Response(*(one / step if now.status == FOUND else np.full_like(one, math.nan) for one in changes))


def heights_of(solver: EquilibriumSolver, found: Equilibrium, shares: np.ndarray) -> np.ndarray:
    """Heights of raceways (N, 2) [m] that make contacts bear these shares (N, 2) more."""
    contacts = found.contacts
    return np.where(contacts.load > 0.0, shares * contacts.approach / solver.setting.inner.law.power, 0.0)


def response_of(solver: EquilibriumSolver, support: Support, found: Equilibrium, shares: np.ndarray) -> Response:
    """The response where each contact bears these shares (N, 2) more than its law gives at the same approach.

    Loads that are given stay given: what all contacts share only moves the ring.
    """
    return response_to(solver, support, found, heights_of(solver, found, shares))


def response_to_tilt(solver: EquilibriumSolver, support: Support, found: Equilibrium) -> Response | None:
    """Response to the true circle of the inner groove's centres, in first order; None of a ring that is not tilted.

    A tilt of first order keeps the circle's radius R. Seen by a ball at an azimuth where the tilt lifts its point of
    the circle by R b, the true circle is nearer to the axis by R b^2/2: a true contact is pressed less by the cosine of
    its angle times that, and the moment of what presses it has no such lever.
    """
    arm, tilt, load = solver.setting.arm, found.coordinates[3:], found.contacts.load
    if arm * np.abs(tilt).max() <= NEGLIGIBLE * np.abs(found.coordinates[:3]).max():
        return None
    levers = np.stack([np.sin(found.azimuths), -np.cos(found.azimuths)], axis=1)  # tilt in each ball's plane, by theta
    lifted, cosine = levers @ tilt, np.cos(found.contacts.angle[:, 0])
    heights, loads = np.zeros_like(load), np.zeros(5)
    heights[:, 0] = -0.5 * arm * lifted**2 * cosine
    loads[3:] = -arm * (load[:, 0] * cosine * lifted) @ levers
    return response_to(solver, support, found, heights, loads)


class EquilibriumErrors(NamedTuple):
    """Model errors of an equilibrium with this `greatest` contact load [N]: responses by source.

    There is none to a law of whose error nothing is known, nor to the tilt of a ring that is not tilted. `kept` is the
    part of the greatest contact's error that its load keeps: what all share only moves a free ring.
    """

    greatest: float
    responses: dict[str, Response]
    kept: dict[str, float]


def errors_at(
    parameters, law: str, solver: EquilibriumSolver, support: Support, found: Equilibrium
) -> EquilibriumErrors:
    """The model errors of an equilibrium `found` by `solver`."""
    contacts, responses, kept = found.contacts, {}, {}
    for source, shares in (
        (LAW, law_error(parameters, law, contacts.curvature_small, contacts.curvature_large, contacts.load)),
        (HALF_SPACE, half_space_error(parameters, ellipses_of(parameters, contacts)[0])),
    ):
        if shares is not None:
            responses[source] = response_of(solver, support, found, shares)
            wrong = float(np.abs(shares * contacts.load).max())
            kept[source] = float(np.abs(responses[source].loads).max()) / wrong if wrong > 0.0 else 1.0
    tilted = response_to_tilt(solver, support, found)
    return EquilibriumErrors(float(contacts.load.max()), responses | ({TILT: tilted} if tilted else {}), kept)


def errors_of_run(parameters, law: str) -> list[EquilibriumErrors]:
    """Errors under the loads and speeds at begin and end of a run, with a ball on the load line.

    Nothing of a ring that is held upright, or of a load that nothing carries; one where both loads are the same.
    """
    if dimension_of(parameters) == PRESCRIBED and not any(parameters.drive.tilt):
        return []
    loading, found = Loading(parameters.rings.inner), []
    loads = dict.fromkeys(tuple(loading.at(time)[0].tolist()) for time in (0.0, float(parameters.run.duration)))
    for one in scenes_by_speed(parameters):
        setting = setting_of(one, law, one.drive.speed)
        for load in loads:
            support = support_with_weight(one, load)
            solver = solver_under_gravity(one, setting, azimuths_of(one.geometry.balls, load_line(support)))
            with contextlib.suppress(SceneError):
                found.append(errors_at(one, law, solver, support, controlled_equilibrium(one, solver, support)))
    return found


def model_errors(parameters, law: str, solver: EquilibriumSolver, support: Support, found: Equilibrium) -> dict:
    """Errors of an equilibrium by source, in SI units: of loads and angles the greatest of all contacts."""
    return {
        source: {
            "normal_load_n": float(np.abs(one.loads).max()),
            "contact_angle_rad": float(np.abs(one.angles).max()),
            **_of_ring(one.coordinates, one.ring_loads),
        }
        for source, one in errors_at(parameters, law, solver, support, found).responses.items()
    }


def _of_ring(coordinates, loads) -> dict[str, list[float]]:
    """Errors of the ring's figures, without those that are rounding beside the others."""
    found = {}
    for names, changes in zip(RING, (np.abs(coordinates), np.abs(loads)), strict=True):
        for key, part in zip(names, np.split(changes, [3]), strict=True):
            found[key] = np.where(part > NOTHING * part.max(), part, 0.0).tolist()
    return found


def _of_balls(pattern: str, values: np.ndarray) -> dict[str, list[float]]:
    """Figures of both raceways, lists with one value a ball, from an array (N, 2)."""
    return {pattern.format(side): values[:, place].tolist() for place, side in enumerate(SIDES)}


def _both(figures: Mapping[str, Any], pattern: str) -> np.ndarray:
    """The figures of both raceways as an array (N, 2), the reverse of `_of_balls`."""
    return np.array([figures[pattern.format(side)] for side in SIDES]).T


def _of_ellipses(figures: Mapping[str, Any], share: np.ndarray) -> dict[str, list[float]]:
    """Errors of ellipses and pressures of contacts whose loads have these relative errors (N, 2): of its cube root."""
    found = {}
    for key, unit in ELLIPSES:
        found |= _of_balls(f"{key}_{{}}_{unit}", share * _both(figures, f"{key}_{{}}_{unit}") / 3.0)
    return found


MISSING_PHYSICS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "film": (
        lambda parameters: not is_lubricated(parameters),
        "no oil film: its thickness, its rolling resistance and what oil takes along are not computed",
    ),
    LUBRICATED: (
        is_lubricated,
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
STRETCH = 50  # outputs, by their numbers, that are summed before they are added to those before
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
            self.outputs["friction"] = "over the friction limit (mu N of a contact, mu N R of a ball)"
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
                (forces / np.maximum(exact, least[:, :, None])).max(axis=(1, 2)),
                (torques / radius / np.maximum(exact[:, :, 0] + exact[:, :, 1], least)).max(axis=1),
            )
            found["friction"] = apart / self.parameters.contact.friction_coefficient, np.ones(len(sizes))
        return found


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.sqrt(x * x + y * y + z * z)  # a sum along an axis of three takes four times as long


class BearingErrors:
    """Gathers what the model errors of a run follow from, in memory that does not grow with the run."""

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
        greatest, found = float(self.load.max()), {}
        nearest = min(self._equilibria, key=lambda one: abs(one.greatest - greatest), default=None)
        alike = nearest is not None and abs(nearest.greatest - greatest) <= ALIKE * greatest
        law = law_error(self.parameters, self.choice.law, *self.curvatures, self.load)
        width = half_space_error(self.parameters, _both(figures, "semi_major_{}_m"))
        not_modelled = self._of_contacts(figures, width, nearest if alike else None, HALF_SPACE)
        tilted = self._tilted(figures, nearest.responses[TILT]) if nearest and TILT in nearest.responses else {}
        for key, error in tilted.items():
            not_modelled[key] = np.add(not_modelled[key], error).tolist() if key in not_modelled else error
        of_law = {} if law is None else self._of_contacts(figures, np.abs(law), nearest if alike else None, LAW)
        for source, errors in (
            (LAW, of_law),
            (NOT_MODELLED, not_modelled | self._caged(figures)),
            (FRICTION_MODEL, self._friction(figures)),
        ):
            for key, error in errors.items():
                found.setdefault(key, {})[source] = error
        if not any(map(any, (figures[key] for key in OUT_OF_PLANE))):
            found |= {key: {source: [0.0, 0.0] for source in found[key]} for key in TILTING if key in found}
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
        off = 0.0 if law is None or not greatest else float(np.abs(law * self.load).max()) / greatest
        of_loads = [ModelError(LAW, off * (nearest.kept.get(LAW, 1.0) if alike else 1.0), HERTZ_MENDS)]
        if self.choice.stepper == QUASI_STATIC:
            contacts = scene_equilibrium(self.parameters, self.choice.law).contacts
            of_loads.append(ModelError(NOT_MODELLED, equilibrium_error(contacts), self._smaller_steps))
        outputs = {"loads": tuple(of_loads)}
        return Errors(found, outputs=outputs, notes=self._notes(), mends=mends, integral_of=SUMS, negligible=negligible)

    def _of_contacts(
        self, figures: Mapping[str, Any], share: np.ndarray, error: EquilibriumErrors | None, source: str
    ) -> dict[str, Any]:
        """Errors of figures where contacts have these relative errors (N, 2) of their load at the same approach.

        `error` is the equilibrium that stands for the run. What all contacts share scales their sum on a ring that is
        held, and only moves one whose load is given; what they do not share need not cancel.
        """
        kept, found = share if error is None else error.kept[source] * share, {}
        for key in LOADS_OF:
            found |= _of_balls(f"{key}_{{}}_n", kept * np.abs(_both(figures, f"{key}_{{}}_n")))
        if error is not None:
            moved, ring = error.responses[source][2:]
        else:
            moved, ring = np.zeros(5), np.zeros(5)
            greatest, touching = float(share.max(initial=0.0)), self.load[:, 0] > 0.0
            if dimension_of(self.parameters) != PRESCRIBED:
                for part, key in ((slice(3), "ring_displacement_m"), (slice(3, 5), "misalignment_rad")):
                    moved[part] = 2.0 / 3.0 * greatest * math.hypot(*figures.get(key, ()))
            else:
                uneven = float(np.ptp(share[touching, 0])) if touching.any() else 0.0
                uneven *= math.fsum(map(abs, figures["normal_load_inner_n"]))
                arm = 0.5 * self.parameters.geometry.pitch_diameter
                ring[:3] = greatest * max(map(abs, figures["ring_force_n"])) + uneven
                ring[3:] = greatest * max(map(abs, figures["ring_moment_nm"])) + arm * uneven
        return found | _of_ellipses(figures, share) | _of_ring(moved, ring)

    def _tilted(self, figures: Mapping[str, Any], tilt: Response) -> dict[str, Any]:
        """Greatest errors of figures by a tilt of first order."""
        more, turned = (np.broadcast_to(np.abs(one).max(axis=0), self.load.shape) for one in tilt[:2])
        share = np.divide(more, self.load, out=np.zeros_like(self.load), where=self.load > 0.0)
        found = _of_balls("contact_angle_{}_rad", turned) | _of_ellipses(figures, np.minimum(share, 1.0))
        for key in LOADS_OF:
            found |= _of_balls(f"{key}_{{}}_n", more)
        return found | _of_ring(*tilt[2:])

    def _caged(self, figures: Mapping[str, Any]) -> dict[str, float]:
        """Greatest changes by a cage: speeds of balls that none spaces, to those of rolling."""
        if self.parameters.cage.kind != "none" or self.choice.stepper == QUASI_STATIC:
            return {}
        names = (key for key in ("cage_speed_rad_s", "roll_rate_rad_s") if figures.get(key) is not None)
        return {key: abs(figures[key] - figures[key.replace("_rad_s", "_theory_rad_s")]) for key in names}

    @functools.cached_property
    def _equilibria(self) -> list[EquilibriumErrors]:
        return errors_of_run(self.parameters, self.choice.law)

    def _friction(self, figures: Mapping[str, Any]) -> dict[str, Any]:
        """Errors of the friction model: at a point it has no spin; over a contact patch it is wrong by its quadrature.

        A patch under pure spin resists with 3/8 mu N a E at most, E the complete elliptic integral of its eccentricity;
        with less where its rim is no faster than friction is smoothed over.
        """
        if self.choice.stepper == QUASI_STATIC or not self.outputs:
            return {}
        contact, drive, lubricant = self.parameters.contact, self.parameters.drive, self.parameters.lubricant
        over_patch, coefficient = FRICTIONS[contact.friction].over_patch, contact.friction_coefficient
        if is_lubricated(self.parameters):  # at most
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

    @functools.cached_property
    def _smaller_steps(self) -> str:
        return mend_of_method(self.parameters, self.choice)

    def _notes(self) -> dict[str, str]:
        """Sentences on errors that are not known, by source and by what is not modelled."""
        notes = {NOT_MODELLED: EQUILIBRIA} if self.choice.stepper == QUASI_STATIC else {}
        if self.choice.law in LAWS and LAWS[self.choice.law].measured:
            notes[LAW] = f"the law {self.choice.law} is given by the scene; nothing is known of its error"
        model, beyond = FRICTIONS[self.parameters.contact.friction], "not their effect on the motion, as on roll rates"
        if not model.over_patch:
            notes[FRICTION_MODEL] = (
                "contact.friction: point has no friction of spin: errors are the torque and loss that it would add, "
                f"{beyond}; contact.friction: patch computes it"
            )
        elif self.choice.stepper != QUASI_STATIC:
            notes[FRICTION_MODEL] = f"errors are those of torque and loss by contact.friction: {model.name}, {beyond}"
        return notes | {name: words for name, (lacks, words) in MISSING_PHYSICS.items() if lacks(self.parameters)}
