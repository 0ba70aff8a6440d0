"""What the figures of a bearing in balance are worth: errors of its law and of half-spaces, as the balance takes them.

An equilibrium is solved to rounding, so these are the errors there are of what its model holds. Of what it leaves out,
friction across the grooves has a number, in contact angles, what settled axes of spin do has one, in loads, and so has
a tilt of first order.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.materials import effective_modulus
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.drive import with_speeds
from bearing_twin.kinds.bearing.forces.drilling import SIDES
from bearing_twin.kinds.bearing.law_error import half_space_error, law_error
from bearing_twin.kinds.bearing.loading import Loading
from bearing_twin.kinds.bearing.outputs import ellipses
from bearing_twin.kinds.bearing.quasi_static.axes import left_by_rolling
from bearing_twin.kinds.bearing.quasi_static.in_motion import as_in_run
from bearing_twin.kinds.bearing.quasi_static.moving_balls import angle_errors
from bearing_twin.kinds.bearing.quasi_static.response import Response, response_of
from bearing_twin.kinds.bearing.quasi_static.statics import (
    Equilibrium,
    EquilibriumSolver,
    Support,
    azimuths_of,
    load_line,
    setting_of,
    weighed_solver,
    weighed_support,
)
from bearing_twin.kinds.bearing.quasi_static.tilt_response import response_to_tilt
from bearing_twin.kinds.bearing.ratings import Lives, lives_of, ratings_of
from bearing_twin.kinds.bearing.rings import FREE_RING, QUASI_STATIC, dimension_of
from bearing_twin.kinds.doubt import LAW

ALIKE = 0.1  # of the greatest load: an equilibrium whose greatest is nearer than this stands for a run
NOTHING = 1e-9  # of the greatest change: less is rounding
LOADS_OF = "normal_load", "greatest_normal_load"  # figures of contacts' loads
SPOTS = ("semi_major", "semi_minor", "peak_pressure")  # what `spots_of` gives


class Worth(NamedTuple):
    """One source of errors at an equilibrium: the `shares` (N, 2) that contacts are off by, and the `response`.

    `kept` is the part of the greatest contact's error that its load keeps: what all share only moves a free ring.
    """

    shares: np.ndarray
    response: Response
    kept: float


class SceneWorth(NamedTuple):
    """The equilibrium of a scene: its `greatest` contact load [N], what its law is off by, and half-spaces are.

    `angles` (N, 2) [rad] is how far contact angles are off those of moving balls, of a run (2,) at the greatest load.
    `axes` is what settled axes of spin change; None where nothing is known of that. `tilt` is what a true circle
    changes where the ring is tilted; None elsewhere.
    """

    greatest: float
    law: Worth | None
    half_space: Worth
    angles: np.ndarray
    axes: Response | None
    tilt: Response | None

    def of(self, source: str, greatest: float) -> Worth | None:
        """The law's worth or the half-spaces'; None for a run whose greatest load [N] is another."""
        return (self.law if source == LAW else self.half_space) if self.alike(greatest) else None

    def alike(self, greatest: float) -> bool:
        """Whether it stands for a run with this greatest contact load [N]."""
        return abs(self.greatest - greatest) <= ALIKE * greatest

    def by_friction(self, balls: int) -> dict[str, list[float]]:
        """Errors of figures of a run, by their names: how far contact angles are off those of moving balls."""
        return {f"contact_angle_{side}_rad": [float(self.angles[i])] * balls for i, side in enumerate(SIDES)}

    def by_axes(self, balls: int) -> dict[str, list[float]]:
        """Errors of figures of a run, by their names: what settled axes of spin change at most."""
        return _of_figures(self.axes, balls)

    def by_tilt(self, balls: int) -> dict[str, list[float]]:
        """Errors of figures of a run, by their names: what a tilt of first order is off at most."""
        return _of_figures(self.tilt, balls)


def _of_figures(response: Response | None, balls: int) -> dict[str, list[float]]:
    """Errors of figures of a run, by their names, of so many balls that all come to where a response is greatest."""
    if response is None:
        return {}
    loads, _, moved, ring = (np.abs(one) for one in response)
    moved, ring = _settled(moved).tolist(), _settled(ring).tolist()
    return {
        **{f"{key}_{side}_n": [float(loads[:, i].max())] * balls for key in LOADS_OF for i, side in enumerate(SIDES)},
        "ring_displacement_m": moved[:3],
        "misalignment_rad": moved[3:],
        "ring_force_n": ring[:3],
        "ring_moment_nm": ring[3:],
    }


class Off(NamedTuple):
    """How far figures may be off: `columns` (N, 2) of contacts by name, the ring (5,), its loads (5,) and stiffness.

    `rolling` is the part of the greatest load that is due to axes of spin as in rolling.
    """

    columns: dict[str, np.ndarray]
    coordinates: np.ndarray
    ring_loads: np.ndarray
    stiffness: np.ndarray
    lives: Lives
    rolling: float


def spots_of(parameters, contacts):
    """Semi-axes [m] along and across a groove, and peak pressure [Pa], each (N, 2)."""
    materials = parameters.materials
    moduli = tuple(effective_modulus(materials.ball, ring) for ring in (materials.inner_ring, materials.outer_ring))
    return ellipses(moduli, contacts.curvature_small, contacts.curvature_large, contacts.load)


def _worth(solver: EquilibriumSolver, support: Support, found: Equilibrium, shares: np.ndarray) -> Worth:
    response, off = response_of(solver, support, found, shares), float(np.abs(shares * found.contacts.load).max())
    return Worth(shares, response, float(np.abs(response.loads).max()) / off if off > 0.0 else 1.0)


def _worths(parameters, law: str, solver: EquilibriumSolver, support: Support, found: Equilibrium, spots) -> SceneWorth:
    contacts = found.contacts
    shares = law_error(parameters, law, contacts.curvature_small, contacts.curvature_large, contacts.load)
    wide = half_space_error(parameters, spots[0])
    given = solver, support, found
    return SceneWorth(
        float(contacts.load.max()),
        None if shares is None else _worth(*given, shares),
        _worth(*given, wide),
        angle_errors(parameters, solver, found),
        _by_axes(parameters, solver, support, found),
        response_to_tilt(solver, support, found),
    )


def _by_axes(parameters, solver: EquilibriumSolver, support: Support, found: Equilibrium) -> Response | None:
    """What axes of spin change once they have settled, or where they have, what loads are off at most."""
    if math.isnan(found.settled):
        left = left_by_rolling(parameters, solver, support, found)
        return left and left._replace(loads=np.maximum(np.abs(left.loads), found.apart * found.contacts.load.max()))
    load = found.contacts.load
    off = np.full(load.shape, found.settled * load.max())
    ring = np.where(support.free, 0.0, found.settled * np.abs(found.loads))
    return Response(off, np.zeros(load.shape), np.zeros(5), ring)


def worths_of_run(parameters, law: str) -> list[SceneWorth]:
    """As the scene loads and turns the ring where its run begins and ends, and holds it, a ball on the load line.

    Nothing where the ring moves as prescribed, or of a load that nothing carries; one where both loads are the same.
    """
    if dimension_of(parameters) not in (QUASI_STATIC, FREE_RING):
        return []
    loading = Loading(parameters.rings.inner)
    loads = dict.fromkeys(tuple(loading.at(time)[0].tolist()) for time in (0.0, float(parameters.run.duration)))
    found = (_worth_under(one, law, load) for one in with_speeds(parameters) for load in loads)
    return [one for one in found if one is not None]


def _worth_under(parameters, law: str, load: tuple[float, ...]) -> SceneWorth | None:
    support = weighed_support(parameters, load)
    setting = setting_of(parameters, law, parameters.drive.speed)
    azimuths = azimuths_of(parameters.geometry.balls, load_line(support))
    solver = weighed_solver(parameters, setting, azimuths)
    try:
        found = as_in_run(parameters, law, solver, support)
    except SceneError:
        return None
    worth = _worths(parameters, law, solver, support, found, spots_of(parameters, found.contacts))
    return worth._replace(angles=worth.angles[found.contacts.load[:, 0].argmax()])


def errors_of(parameters, law: str, solver: EquilibriumSolver, support: Support, found: Equilibrium, spots) -> Off:
    """Greatest errors of an equilibrium with these `spots` (`spots_of`), sources added up."""
    contacts, worth = found.contacts, _worths(parameters, law, solver, support, found, spots)
    worths = [one for one in (worth.law, worth.half_space) if one is not None]
    shares = np.sum([np.abs(one.shares) for one in worths], axis=0)
    responses = zip(*(one.response for one in worths), strict=True)
    parts = [np.sum(np.abs(one), axis=0) for one in responses]
    if worth.axes is not None:
        settling = worth.axes._replace(angles=np.zeros_like(contacts.angle))  # which `worth.angles` holds
        parts = [one + np.abs(more) for one, more in zip(parts, settling, strict=True)]
    if worth.tilt is not None:
        parts = [one + np.abs(more) for one, more in zip(parts, worth.tilt, strict=True)]
    loads, angles, coordinates, ring = parts
    coordinates, ring = _settled(coordinates), _settled(ring)
    off = np.divide(loads, contacts.load, out=np.zeros_like(loads), where=contacts.load > 0.0)
    # A spot goes with the cube root of load and modulus.
    sizes = {name: (shares + off) / 3.0 * one for name, one in zip(SPOTS, spots, strict=True)}
    ratings, force = ratings_of(parameters), -found.loads[:3]
    lives = lives_of(parameters, ratings, force, *contacts.load.T)
    worse = lives_of(parameters, ratings, force + np.sign(force) * ring[:3], *(contacts.load + loads).T)
    shorter = (well - badly if math.isfinite(well) else 0.0 for well, badly in zip(lives, worse, strict=True))
    stiffness = float(shares.max()) * np.abs(found.stiffness)
    angles += np.where(contacts.load > 0.0, worth.angles, 0.0)
    columns = {"normal_load": loads, "contact_angle": angles, **sizes}
    rolling = 0.0
    if worth.axes is not None and math.isnan(found.settled):
        rolling = float(worth.axes.loads.max()) / worth.greatest
    return Off(columns, coordinates, ring, stiffness, Lives(*shorter), rolling)


def _settled(changes: np.ndarray) -> np.ndarray:
    """Displacements or forces (3), tilts or moments (2), without those that are rounding beside the others."""
    parts = changes[:3], changes[3:]
    return np.concatenate([np.where(one > NOTHING * one.max(), one, 0.0) for one in parts])
