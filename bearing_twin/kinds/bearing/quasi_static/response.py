"""How a bearing in balance answers contacts that are stiffer than their law says: what a law's error makes of it."""

from typing import NamedTuple

import numpy as np

from bearing_twin.kinds.bearing.quasi_static.ball_balance import balance_at
from bearing_twin.kinds.bearing.quasi_static.opening import opening_of, slopes_of
from bearing_twin.kinds.bearing.quasi_static.statics import Equilibrium, EquilibriumSolver, Support

LOOSE = 1e-12  # of the stiffest direction: a direction that nothing holds is not moved


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
    """What contacts that bear these shares (N, 2) more than their law gives do while the ring is held."""
    load, angle = found.contacts.load, found.contacts.angle
    normal = _normals(angle)
    pushes = (shares * load)[..., None] * normal
    seen = [opening_of(solver.setting, *one, found.coordinates) for one in solver.directions]
    opened = np.array([_slopes(solver, k, opening) for k, opening in enumerate(seen)])  # (N, 2, 5)
    moved, follows, ring = np.zeros((len(load), 2)), np.zeros((len(load), 2, 2)), np.zeros(5)
    for k in range(len(load)):
        here = balance_at(solver.setting, seen[k].radial, seen[k].axial, *found.places[k], *solver.weights[k])
        inverse = np.linalg.pinv(np.reshape(here.left_p, (2, 2)))
        moved[k] = -inverse @ (pushes[k, 0] - pushes[k, 1])
        follows[k] = -inverse @ np.reshape(here.left_o, (2, 2))
        force = pushes[k, 0] + np.reshape(here.force_p, (2, 2)) @ moved[k]
        ring += opened[k].T @ force
        turned = np.array(here.friction_moment_p) @ moved[k]
        ring[3:] += turned * np.array([solver.directions[k, 1], -solver.directions[k, 0]])
    return Pushed(solver, found, shares * load, ring, moved, follows, opened)


def _normals(angle: np.ndarray) -> np.ndarray:
    """Unit vectors (N, 2 raceways, 2), radial and axial, at these contact angles (N, 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _raceways(solver: EquilibriumSolver):
    return solver.setting.inner, solver.setting.outer


def _slopes(solver: EquilibriumSolver, k: int, opening) -> np.ndarray:
    """Derivatives (2, 5) of ball k's opening, radial and axial, by the ring's coordinates."""
    radial, axial = slopes_of(solver.setting, *solver.directions[k], opening)
    return np.array([[*radial, 0.0, 0.0, 0.0], [*axial[:2], 1.0, *axial[2:]]])
