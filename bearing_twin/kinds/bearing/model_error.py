"""Model errors of contacts and equilibria: elastic law, half-spaces, tilts of first order, friction at a point.

A contact that is too stiff by a share of its load pushes its ball and the ring, which move until they are in balance
again: the balance differentiated by that share.
"""

import contextlib
import functools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.elasticity import coefficient_of, hertz_coefficient
from bearing_twin.contact.friction import FRICTIONS
from bearing_twin.contact.laws import LAWS
from bearing_twin.kinds.bearing.equilibrium import (
    Equilibrium,
    EquilibriumSolver,
    Support,
    azimuths_of,
    ball_balances,
    controlled,
    ellipses_of,
    load_line,
    setting_of,
    weighed_solver,
    weighed_support,
)
from bearing_twin.kinds.bearing.geometry import nominal_curvatures
from bearing_twin.kinds.bearing.rings import PRESCRIBED, dimension_of, with_speeds
from bearing_twin.kinds.bearing.system import Loading

SIDES = ("inner", "outer")


def law_error(parameters, law: str, curvature_small, curvature_large, load) -> np.ndarray | None:
    """Relative error of each contact's load (N, 2) against exact Hertz at these curvatures [1/m]; above 0: too stiff.

    0 where there is no load; None for a law that is measured, of whose error nothing is known.
    """
    if law not in LAWS or LAWS[law].measured:
        return None
    found = np.zeros_like(load)
    for side, nominal in enumerate(nominal_curvatures(parameters.geometry)):
        frozen = hertz_coefficient(*nominal, 1.0)
        pairs = zip(curvature_small[:, side].tolist(), curvature_large[:, side].tolist(), strict=True)
        for ball, (at, bears) in enumerate(zip(pairs, (load[:, side] > 0.0).tolist(), strict=True)):
            if bears:
                found[ball, side] = _error_at(law, frozen, *at)
    return found


@functools.lru_cache(maxsize=1024)
def _error_at(law: str, frozen: float, curvature_small: float, curvature_large: float) -> float:
    """Kept, as figures and errors of a run ask for the same contacts."""
    at = curvature_small, curvature_large
    return coefficient_of(law, *at, 1.0, frozen) / hertz_coefficient(*at, 1.0) - 1.0


def half_space_error(parameters, semi_major):
    """Relative errors of loads where ellipses of these semi-axes [m] lie on bodies that Hertz takes for half-spaces.

    The square of semi-axis over ball radius: the next term of the shape of a sphere against its parabola.
    """
    return (np.asarray(semi_major) / (0.5 * parameters.geometry.ball_diameter)) ** 2


def ellipse_errors(figures: Mapping[str, Any], share: np.ndarray) -> dict[str, list[float]]:
    """Errors of ellipses and pressures of contacts whose loads have these relative errors (N, 2): of its cube root."""
    return {
        f"{key}_{side}{unit}": [float(share[ball, place]) * value / 3.0 for ball, value in enumerate(values)]
        for key, unit in (("semi_major", "_m"), ("semi_minor", "_m"), ("peak_pressure", "_pa"))
        for place, side in enumerate(SIDES)
        for values in [figures[f"{key}_{side}{unit}"]]
    }


SMOOTHING = 2.5  # tuned: power by which the error of a sum over points falls as spin at the rim becomes slow


def rule_error(contact, ratio: float, rim: float) -> float:
    """Greatest error of friction over contact patches, over its limit, and over the torque of pure spin.

    Parameters
    ----------
    contact
        The section `contact` of a scene.
    ratio : float
        b/a of the contact ellipse; errors are those found for 0.1 and above.
    rim : float
        Speed by spin [m/s] at the ends of the ellipse: what is slow against the regularisation is smooth, and n points
        round a ring resolve it. Within a factor of 3 of `bearing_twin chart friction` where the error is above 1e-4.
    """
    model = FRICTIONS[contact.friction]
    share = rim / contact.friction_regularisation
    return model.error / (1.0 + (model.rule.spokes / share) ** SMOOTHING) if share > 0.0 else 0.0


LOOSE = 1e-12  # of the stiffest direction: a direction that nothing holds is not moved
ALIKE = 0.1  # of the greatest load: an equilibrium whose greatest is nearer than this stands for a run
NOTHING = 1e-9  # of the greatest change: less is rounding
LOADS_OF = "normal_load", "greatest_normal_load"  # figures of contacts' loads


class Response(NamedTuple):
    """First-order changes: of contact `loads` [N] and `angles` [rad] (N, 2), ring `coordinates` and `ring_loads` (5,).

    `ring_loads` [N, N m] are those from outside; only those of held coordinates change.
    """

    loads: np.ndarray
    angles: np.ndarray
    coordinates: np.ndarray
    ring_loads: np.ndarray


class Pushed(NamedTuple):
    """First-order changes with the ring held: of its outside `loads` (5,), of contact `pushes` and balls' places.

    `moved` (N, 2) are those of the balls, `follows` (N, 2, 2) and `opened` (N, 2, 5) what they do when the ring moves.
    """

    solver: EquilibriumSolver
    found: Equilibrium
    pushes: np.ndarray
    loads: np.ndarray
    moved: np.ndarray
    follows: np.ndarray
    opened: np.ndarray

    def contacts(self, coordinates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Changes of contact loads [N] and angles [rad] (N, 2) once the ring has moved by these coordinates (5,)."""
        solver, (load, angle) = self.solver, (self.found.contacts.load, self.found.contacts.angle)
        opening = self.opened @ coordinates
        moved = self.moved + np.einsum("kij,kj->ki", self.follows, opening)
        nearer = np.stack([opening - moved, moved], axis=1)  # changes of the vectors between centres
        normal = _normals(angle)
        across = np.stack([-normal[..., 1], normal[..., 0]], axis=-1)
        distance = np.array([[one.groove_radius - solver.setting.ball_radius for one in _raceways(solver)]])
        power = np.array([[one.law.power for one in _raceways(solver)]])
        approach = self.found.contacts.approach
        per_metre = np.divide(power * load, approach, out=np.zeros_like(load), where=load > 0.0)
        return (
            self.pushes + per_metre * np.einsum("ksi,ksi->ks", normal, nearer),
            np.where(load > 0.0, np.einsum("ksi,ksi->ks", across, nearer) / (distance + approach), 0.0),
        )


def response_of(solver: EquilibriumSolver, support: Support, found: Equilibrium, shares: np.ndarray) -> Response:
    """The response where each contact bears these shares (N, 2) more than its law gives at the same approach.

    The balance of every ball and of the ring, differentiated by the shares: balls move, then the ring does where it is
    free, and balls follow. Loads that are given thus stay given: what all contacts share only moves the ring.
    """
    pushed = pushed_by(solver, found, shares)
    coordinates, ring_loads = followed(solver, support, found, pushed.loads)
    return Response(*pushed.contacts(coordinates), coordinates, ring_loads)


def followed(
    solver: EquilibriumSolver, support: Support, found: Equilibrium, loads: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Changes of the ring's coordinates and outside loads (5,) where it would take `loads` (5,) more to stay put."""
    free = np.array(support.free, np.bool_)
    coordinates = np.zeros(5)
    size = np.outer(solver.scales, solver.scales)[np.ix_(free, free)]
    held = np.linalg.pinv(found.stiffness[np.ix_(free, free)] / size, rcond=LOOSE)
    coordinates[free] = -(held @ (loads[free] / solver.scales[free])) / solver.scales[free]
    return coordinates, np.where(free, 0.0, loads + found.stiffness @ coordinates)


def pushed_by(solver: EquilibriumSolver, found: Equilibrium, shares: np.ndarray) -> Pushed:
    """Effect of contacts that carry these shares (N, 2) more than by their law while the ring is held."""
    load, angle = found.contacts.load, found.contacts.angle
    pushes = (shares * load)[..., None] * _normals(angle)
    by_ball, opened = ball_balances(solver.seats(), found.azimuths, found.coordinates, found.places)
    left, force, moment = by_ball[:, :2], by_ball[:, 2:4, 0], by_ball[:, 4, 0]
    inverse = np.linalg.pinv(left[:, :, 0])
    moved = -np.einsum("kij,kj->ki", inverse, pushes[:, 0] - pushes[:, 1])
    follows = -inverse @ left[:, :, 1]
    ring = np.einsum("kic,ki->c", opened, pushes[:, 0] + np.einsum("kij,kj->ki", force, moved))
    ring[3:] += (moment * moved).sum(1) @ _levers(found.azimuths)
    return Pushed(solver, found, shares * load, ring, moved, follows, opened)


def _levers(azimuths) -> np.ndarray:
    """Derivatives (N, 2) of the tilt in each ball's plane by theta_x and theta_y."""
    return np.stack([np.sin(azimuths), -np.cos(azimuths)], axis=1)


def _normals(angle: np.ndarray) -> np.ndarray:
    """Unit vectors (N, 2 raceways, 2), radial and axial, at these contact angles (N, 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _raceways(solver: EquilibriumSolver):
    return solver.setting.inner, solver.setting.outer


def response_to_tilt(solver: EquilibriumSolver, support: Support, found: Equilibrium) -> Response | None:
    """Response to the true circle of the inner groove's centres, in first order; None of a ring that is not tilted.

    A tilt of first order keeps the circle's radius R. Seen by a ball at an azimuth where the tilt lifts its point of
    the circle by R b, the true circle is nearer to the axis by R b^2/2: a true contact is pressed less by the cosine of
    its angle times that, and the moment of what presses it has no such lever.
    """
    setting, contacts, tilt = solver.setting, found.contacts, found.coordinates[3:]
    if not tilt.any():
        return None
    lever = _levers(found.azimuths)
    lifted = lever @ tilt
    cosine = np.cos(contacts.angle[:, 0])
    load, approach = contacts.load, contacts.approach
    power = np.array([setting.inner.law.power, setting.outer.law.power])
    yields = np.divide(approach, power * load, out=np.zeros_like(load), where=load > 0.0).sum(axis=1)  # m/N
    less = -0.5 * setting.arm * lifted**2 * cosine
    off = np.divide(less, yields, out=np.zeros_like(less), where=yields > 0.0)
    shares = np.divide(off[:, None], load, out=np.zeros_like(load), where=load > 0.0)
    pressed = response_of(solver, support, found, shares)
    loads = np.zeros(5)
    loads[3:] = -setting.arm * (load[:, 0] * cosine * lifted) @ lever
    moved, ring = followed(solver, support, found, loads)
    more, angles = pushed_by(solver, found, np.zeros_like(load)).contacts(moved)
    return Response(
        pressed.loads + more, pressed.angles + angles, pressed.coordinates + moved, pressed.ring_loads + ring
    )


class ContactError(NamedTuple):
    """Effect of contacts that are too stiff on an equilibrium: the `response` of balls and ring.

    `kept` is the part of the greatest contact's error that its load keeps: what all share only moves a free ring.
    """

    response: Response
    kept: float


class EquilibriumErrors(NamedTuple):
    """Model errors of an equilibrium with this `greatest` contact load [N]: of law, half-spaces and tilts.

    `law` is None for a law of whose error nothing is known, `tilt` of a ring that is not tilted.
    """

    greatest: float
    law: ContactError | None
    half_space: ContactError
    tilt: Response | None

    def stands_for(self, greatest: float) -> bool:
        """True if it stands for a run with this greatest contact load [N]."""
        return abs(self.greatest - greatest) <= ALIKE * greatest

    def of_tilt(self, figures: Mapping[str, Any], load: np.ndarray) -> dict[str, Any]:
        """Errors of figures of a run with these greatest loads (N, 2) [N] by a tilt of first order, at most."""
        if self.tilt is None:
            return {}
        more, turned = (np.broadcast_to(np.abs(one).max(axis=0), load.shape) for one in self.tilt[:2])
        share = np.divide(more, load, out=np.zeros_like(load), where=load > 0.0)
        columns = dict.fromkeys((f"{key}_{{}}_n" for key in LOADS_OF), more) | {"contact_angle_{}_rad": turned}
        of_balls = {
            key.format(side): values[:, i].tolist() for key, values in columns.items() for i, side in enumerate(SIDES)
        }
        return of_balls | ellipse_errors(figures, np.minimum(share, 1.0)) | _of_ring(self.tilt)


def _contact_error(solver: EquilibriumSolver, support: Support, found: Equilibrium, shares: np.ndarray) -> ContactError:
    response, off = response_of(solver, support, found, shares), float(np.abs(shares * found.contacts.load).max())
    return ContactError(response, float(np.abs(response.loads).max()) / off if off > 0.0 else 1.0)


def errors_at(
    parameters, law: str, solver: EquilibriumSolver, support: Support, found: Equilibrium
) -> EquilibriumErrors:
    """The model errors of an equilibrium `found` by `solver`."""
    contacts, given = found.contacts, (solver, support, found)
    shares = law_error(parameters, law, contacts.curvature_small, contacts.curvature_large, contacts.load)
    wide = half_space_error(parameters, ellipses_of(parameters, contacts)[0])
    of_law = None if shares is None else _contact_error(*given, shares)
    return EquilibriumErrors(float(contacts.load.max()), of_law, _contact_error(*given, wide), response_to_tilt(*given))


def errors_of_run(parameters, law: str) -> list[EquilibriumErrors]:
    """As the scene loads and turns the ring where its run begins and ends, and holds it, a ball on the load line.

    Nothing of a ring that is held upright, or of a load that nothing carries; one where both loads are the same.
    """
    if dimension_of(parameters) == PRESCRIBED and not any(parameters.drive.tilt):
        return []
    loading, found = Loading(parameters.rings.inner), []
    loads = dict.fromkeys(tuple(loading.at(time)[0].tolist()) for time in (0.0, float(parameters.run.duration)))
    for one in with_speeds(parameters):
        setting = setting_of(one, law, one.drive.speed)
        for load in loads:
            support = weighed_support(one, load)
            solver = weighed_solver(one, setting, azimuths_of(one.geometry.balls, load_line(support)))
            with contextlib.suppress(SceneError):
                found.append(errors_at(one, law, solver, support, controlled(one, solver, support)))
    return found


def model_errors(
    parameters, law: str, solver: EquilibriumSolver, support: Support, found: Equilibrium
) -> dict[str, dict]:
    """Errors of an equilibrium by source, in SI units: of loads and angles the greatest of all contacts."""
    errors = errors_at(parameters, law, solver, support, found)
    responses = {
        "law": errors.law and errors.law.response,
        "half_space": errors.half_space.response,
        "first_order_tilt": errors.tilt,
    }
    return {
        source: {
            "normal_load_n": float(np.abs(one.loads).max()),
            "contact_angle_rad": float(np.abs(one.angles).max()),
            **_of_ring(one),
        }
        for source, one in responses.items()
        if one is not None
    }


def _of_ring(response: Response) -> dict[str, list[float]]:
    """Errors of the ring's figures, without those that are rounding beside the others."""
    keys = ("ring_displacement_m", "misalignment_rad"), ("ring_force_n", "ring_moment_nm")
    found = {}
    for names, changes in zip(keys, response[2:], strict=True):
        for key, part in zip(names, (np.abs(changes[:3]), np.abs(changes[3:])), strict=True):
            found[key] = np.where(part > NOTHING * part.max(), part, 0.0).tolist()
    return found


def by_load(
    geometry, figures: Mapping[str, Any], load, share, error: ContactError | None, given: bool
) -> dict[str, Any]:
    """Errors of figures where contacts have these relative errors (N, 2) of their load at the same approach.

    `load` (N, 2) [N] is their greatest, `error` that of the equilibrium that stands for the run. What all contacts
    share scales their sum on a ring that is held, and only moves one whose load is `given`; what they do not share need
    not cancel.
    """
    greatest = float(share.max(initial=0.0))
    uneven = float(np.ptp(share[load[:, 0] > 0.0, 0])) if load[:, 0].any() else 0.0
    pitch = 0.5 * geometry.pitch_diameter
    carried = math.fsum(abs(one) for one in figures["normal_load_inner_n"])
    kept = share if error is None else error.kept * share
    found = {
        f"{key}_{side}_n": [float(kept[ball, place]) * abs(value) for ball, value in enumerate(values)]
        for key in LOADS_OF
        for place, side in enumerate(SIDES)
        for values in [figures[f"{key}_{side}_n"]]
    }
    if error is not None:
        moved, ring = (np.abs(one) for one in error.response[2:])
    else:
        moved, ring = np.zeros(5), np.zeros(5)
        for part, key, arm in ((slice(3), "ring_force_n", 1.0), (slice(3, 5), "ring_moment_nm", pitch)):
            ring[part] = 0.0 if given else greatest * max(map(abs, figures[key])) + arm * uneven * carried
        for part, key in ((slice(3), "ring_displacement_m"), (slice(3, 5), "misalignment_rad")):
            moved[part] = 2.0 / 3.0 * greatest * math.hypot(*figures.get(key, ())) if given else 0.0
    return {
        **found,
        **ellipse_errors(figures, share),
        "ring_force_n": ring[:3].tolist(),
        "ring_moment_nm": ring[3:].tolist(),
        "ring_displacement_m": moved[:3].tolist(),
        "misalignment_rad": moved[3:].tolist(),
    }
