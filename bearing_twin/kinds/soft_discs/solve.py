"""A soft disc on a wall or on another disc, solved by the compiled core (`core/soft_discs/`) and read off.

Lengths are in radii, stresses in Young's moduli and densities in that of the disc, so that times are in r sqrt(rho/E).
Steps go on until the disc has left.
"""

import ctypes
import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from bearing_twin.base.errors import IntegrationError
from bearing_twin.core import INTEGER, REAL, REALS_OUT, Function
from bearing_twin.kinds.soft_discs.derived import (
    bodies_of,
    capped_ratio,
    contact_time,
    of_other,
    time_unit,
    wall_speed,
    wave_speed,
)
from bearing_twin.kinds.soft_discs.mesh import Mesh, half_disc, lobatto
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

PIECE = 50_000  # nodes times steps between looks at whether all is over: 5 ms, after which Ctrl-C is heard
GONE = 0.2  # of the time so far: out of contact for so long the disc does not come back
LONGEST = 6.0  # estimates of the contact time, after which a disc that has not left is given up
FEWEST_PIECE = 50
GREATEST_FRAMES = 601
BOUND = 1e-3  # relative tolerance of the eigenvalues in the bound, added to it

COLUMNS = (
    "force", "position", "velocity", "kinetic", "elastic", "contact", "depth", "least_stretch", "least_det", "balance",
    "other_position", "other_velocity",
)  # fmt: skip
"""What a row of the history holds: `balance` is the force less the integral of rho a dA, round-off alone."""

STVK, NEO_HOOKEAN, NEO_HOOKEAN_PLANE_STRESS, LINEAR = range(4)  # `Law` of core/soft_discs/elasticity.hpp
FORMULATIONS = {"stvk": STVK, "neo_hookean": NEO_HOOKEAN, "linear": LINEAR}
_COUNTS = "nodes", "blocks", "side", "full", "reduced", "edges", "rim_points", "axis_nodes"
_ARRAYS = (
    "across", "height", "mass", "nodes", "values", "slopes", "inverses", "weights", "rim_nodes", "rim_shapes",
    "rim_weights", "rim_places", "on_axis",
)  # fmt: skip
_REALS = "mu", "lame", "stiffness", "exponent"


class _HalfDisc(ctypes.Structure):
    """`HalfDisc` of core/soft_discs/half_disc.hpp."""

    _fields_ = (
        *((f"number_of_{name}", ctypes.c_int64) for name in _COUNTS),
        ("law", ctypes.c_int64),
        *((name, ctypes.c_void_p) for name in _ARRAYS),
        *((name, ctypes.c_double) for name in _REALS),
    )


class DiscBody(NamedTuple):
    """Half a disc: arrays of the mesh, law, shear modulus, Lame's first parameter, k and m of the contact."""

    across: np.ndarray
    height: np.ndarray
    mass: np.ndarray
    nodes: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    inverses: np.ndarray
    weights: np.ndarray
    full: int
    reduced: int
    rim_nodes: np.ndarray
    rim_shapes: np.ndarray
    rim_weights: np.ndarray
    rim_places: np.ndarray
    on_axis: np.ndarray
    law: int
    mu: float
    lame: float
    stiffness: float
    exponent: float

    def handed_over(self) -> _HalfDisc:
        """What the core reads; the arrays must live as long."""
        edges, side = self.rim_nodes.shape
        counts = len(self.mass), len(self.nodes), side, self.full, self.reduced, edges, len(self.rim_shapes)
        arrays = (getattr(self, name).ctypes.data for name in _ARRAYS)
        return _HalfDisc(*counts, len(self.on_axis), self.law, *arrays, *(getattr(self, name) for name in _REALS))


_BODY = ctypes.POINTER(_HalfDisc)
_march = Function(
    "core_soft_discs_march",
    INTEGER,
    (_BODY, REALS_OUT, _BODY, REALS_OUT, REAL, INTEGER, REALS_OUT, INTEGER, REALS_OUT, INTEGER, INTEGER),
)
_elastic = Function("core_soft_discs_elastic", None, (_BODY, REALS_OUT, REALS_OUT, REALS_OUT))
_stiffness = Function("core_soft_discs_stiffness", None, (_BODY, REALS_OUT, REALS_OUT))


@dataclass(frozen=True, eq=False)
class Solved:
    """The motion of one disc or two in SI: `history` (steps, COLUMNS) at multiples of `step` [s].

    `frames` (f, discs, 2, n) are displacements [m] of the half disc, and of the half of the other, at multiples of
    `frame_step` [s]. Heights are above the wall; of two discs above the place of first touch, each away from the
    other. `ended` tells that the disc has left for good.
    """

    step: float
    history: np.ndarray
    frame_step: float
    frames: np.ndarray
    mesh: Mesh
    ended: bool

    def column(self, name: str) -> np.ndarray:
        """One column of the history."""
        return self.history[:, COLUMNS.index(name)]

    def at(self, name: str, times: np.ndarray) -> np.ndarray:
        """One column at times [s], by straight lines between steps."""
        return np.interp(times, self.step * np.arange(len(self.history)), self.column(name))

    def shape_at(self, radius: float, times: np.ndarray, which: int = 0) -> np.ndarray:
        """Places (t, n, 2) [m] of the nodes of disc 0 or 1 at times [s], x from the line of flight, y as a height."""
        place = np.clip(np.asarray(times) / self.frame_step, 0.0, len(self.frames) - 1.0)
        low = np.minimum(place.astype(int), max(len(self.frames) - 2, 0))
        share = (place - low)[:, None, None]
        high = np.minimum(low + 1, len(self.frames) - 1)
        moved = (1.0 - share) * self.frames[low, which] + share * self.frames[high, which]
        rest = radius * np.stack([self.mesh.x[:-1], self.mesh.y[:-1] + 1.0])
        return np.moveaxis(rest + moved[:, :, :-1], 1, 2)


def bodies_in_units(parameters: SoftDiscsScene) -> tuple[DiscBody, DiscBody]:
    """The disc and what it meets, a wall being a copy of it; lengths in its radii, stresses in its Young's moduli."""
    penalty = parameters.contact
    if parameters.against != "other_disc":
        body = body_of(parameters, penalty.stiffness_ratio)
        return body, body
    other, power = of_other(parameters), penalty.exponent
    size, stiff, dense = (one / another for one, another in zip(_scales(other), _scales(parameters), strict=True))
    # Two penalties one behind the other: their depths sum up to the overlap.
    both = penalty.stiffness_ratio / (1.0 + (size**power / stiff) ** (1.0 / power)) ** power
    body = body_of(parameters, both)
    scaled = body_of(other, both)
    return body, scaled._replace(
        across=size * scaled.across, height=size * scaled.height, mass=dense * size**2 * scaled.mass,
        inverses=scaled.inverses / size, weights=size**2 * scaled.weights, rim_weights=size * scaled.rim_weights,
        mu=stiff * scaled.mu, lame=stiff * scaled.lame,
    )  # fmt: skip


def _scales(parameters):
    material = parameters.disc.material
    return parameters.disc.radius, material.young_modulus, material.density


def body_of(parameters: SoftDiscsScene, stiffness: float) -> DiscBody:
    """The disc without units: lengths in radii, stresses in Young's moduli."""
    mesh = half_disc(parameters.mesh.divisions, parameters.mesh.order, parameters.mesh.integration)
    ratio, law = capped_ratio(parameters), FORMULATIONS[parameters.formulation]
    mu, lame = 0.5 / (1.0 + ratio), ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio))
    plane_stress = parameters.plane == "stress"
    if plane_stress and law != NEO_HOOKEAN:
        lame = 2.0 * lame * mu / (lame + 2.0 * mu)
    if plane_stress and law == NEO_HOOKEAN:
        law = NEO_HOOKEAN_PLANE_STRESS
    return _body(mesh, law, mu, lame, stiffness, parameters.contact.exponent)


def _body(mesh, law, mu, lame, stiffness, exponent) -> DiscBody:
    return DiscBody(
        mesh.x, mesh.y + 1.0, mesh.mass, mesh.nodes, mesh.values, mesh.slopes, mesh.inverses, mesh.weights, mesh.full,
        mesh.reduced,
        mesh.rim_nodes, mesh.rim_shapes, mesh.rim_weights, lobatto(mesh.order)[0], mesh.on_axis,
        law, mu, lame, stiffness, exponent,
    )  # fmt: skip


def elastic_forces(body: DiscBody, displacement: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces (2, n) of elasticity at the nodes; energy, least det F and least stretch (3,) of half the disc."""
    load, found = np.zeros_like(displacement), np.empty(3)
    _elastic(body.handed_over(), displacement, load, found)
    return load, found


def stable_step(parameters: SoftDiscsScene) -> float:
    """A bound from below on the greatest stable step of the undeformed disc, in r sqrt(rho/E), penalty included.

    The greatest eigenvalue of a sum of stiffnesses is at most the sum of theirs (Weyl), so that those of shear, volume
    and penalty are found once for a mesh. Of two discs the lesser; a penalty between them counts twice for each.
    """
    mesh, radius, density = parameters.mesh, parameters.disc.radius, parameters.disc.material.density
    shear, volume, penalty = _greatest_eigenvalues(mesh.divisions, mesh.order, mesh.integration)
    steps = []
    for body, one in zip(bodies_in_units(parameters), bodies_of(parameters).values(), strict=False):
        size, dense = one.disc.radius / radius, one.disc.material.density / density
        stiffness = body.stiffness * (2.0 if parameters.against == "other_disc" else 1.0)
        if body.exponent > 1.0:
            # The depth that stops a plane wave, twice for what comes after it.
            pressure = wall_speed(one) / wave_speed(parameters) * math.sqrt((body.lame + 2.0 * body.mu) * dense)
            depth = min(1.0, 2.0 * (pressure / stiffness) ** (1.0 / body.exponent))
            stiffness *= body.exponent * depth ** (body.exponent - 1.0)
        inner = (body.mu * shear + body.lame * volume) / size**2
        steps.append(2.0 / math.sqrt((inner + stiffness * penalty / size) / dense))
    return min(steps)


@functools.lru_cache(maxsize=8)
def _greatest_eigenvalues(divisions, order, integration) -> tuple[float, float, float]:
    """Of mass^-1 stiffness: with mu = 1 alone, with lambda = 1 alone, with k = 1 alone."""
    mesh = half_disc(divisions, order, integration)
    parts = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    return tuple(_greatest_eigenvalue(_body(mesh, LINEAR, *part, 1.0)) for part in parts)


def _greatest_eigenvalue(body) -> float:
    size = len(body.mass)
    root, load, disc = np.sqrt(body.mass), np.zeros((2, size)), body.handed_over()

    def operate(vector):
        _stiffness(disc, vector.reshape(2, size) / root, load)
        load[:, -1] = 0.0
        return -(load / root).ravel()

    start = np.random.default_rng(1).standard_normal(2 * size)
    found = eigsh(
        LinearOperator((2 * size, 2 * size), operate, dtype=float), k=1, which="LA", tol=BOUND, v0=start,
        return_eigenvectors=False,
    )  # fmt: skip
    return float(found[0]) * (1.0 + BOUND)


def solve(parameters: SoftDiscsScene, frames: int = GREATEST_FRAMES) -> Solved:
    """Moves the disc of resolved parameters until it has left the wall and the run is over; about `frames` shapes.

    Raises IntegrationError where an element turns inside out (reason "collapsed") or a number is no longer finite.
    """
    bodies, unit, radius = bodies_in_units(parameters), time_unit(parameters), parameters.disc.radius
    step, paired = parameters.solver.step_share * stable_step(parameters), parameters.against == "other_disc"
    size = len(bodies[0].mass)
    states = np.zeros((2, 3, 2, size))  # of both discs: displacement, velocity, room for forces
    for state, one in zip(states, bodies_of(parameters).values(), strict=False):
        state[1, 1, :-1] = -wall_speed(one) / wave_speed(parameters)
    disc, other = (body.handed_over() for body in bodies)
    least = parameters.run.duration / unit
    most = max(LONGEST * contact_time(parameters) / unit, least)
    every = max(1, math.ceil(least / step / max(frames - 1, 1)))
    kept = np.zeros((math.ceil(least / step / every) + 1, 1 + paired, 2, size))
    pieces, done, last, over, ended = [], 0, -1, False, False
    while not over:
        rows = np.zeros((max(PIECE // size, FEWEST_PIECE), len(COLUMNS)))
        filled = _march(
            *(disc, states[0], other if paired else None, states[1], step, len(rows), rows, len(kept), kept),
            *(every, done),
        )
        rows = rows[:filled]
        touching = np.flatnonzero(rows[:, 0] > 0.0)
        last = done + touching[-1] if len(touching) else last
        _refuse_collapse(parameters, rows, done, step * unit)
        pieces.append(rows)
        done += filled
        ended = last >= 0 and done - last > GONE * last + 1.0
        over = (ended and step * done > least) or step * done > most
    history = np.concatenate(pieces)
    _give_units(history, parameters)
    shapes = kept[: min(len(kept), (done - 1) // every + 1)]
    shapes *= radius
    return Solved(
        step * unit, history, every * step * unit, shapes,
        half_disc(parameters.mesh.divisions, parameters.mesh.order, parameters.mesh.integration), ended,
    )  # fmt: skip


def _refuse_collapse(parameters, rows, done, step):
    det = rows[-1, COLUMNS.index("least_det")]
    seconds = step * (done + len(rows) - 1)
    if not np.isfinite(rows[-1]).all():
        raise IntegrationError(
            "the disc's numbers are not finite; lower solver.step_share", "not finite", seconds, "disc"
        )
    if det <= 0.0 and parameters.formulation != "linear":
        raise IntegrationError(
            f"the disc collapses at {seconds:.4g} s: an element turns inside out; lower motion.first_velocity, raise "
            "disc.material.young_modulus, or take formulation: neo_hookean, which stiffens in compression",
            "collapsed",
            seconds,
            "disc",
        )


def _give_units(history, parameters):
    """Multiplies the columns of a history without units, in place."""
    disc, speed = parameters.disc, wave_speed(parameters)
    force = disc.material.young_modulus * disc.radius * disc.thickness
    units = {
        "force": force, "balance": force, "depth": disc.radius,
        **dict.fromkeys(("position", "other_position"), disc.radius),
        **dict.fromkeys(("velocity", "other_velocity"), speed),
        **dict.fromkeys(("kinetic", "elastic", "contact"), force * disc.radius),
    }  # fmt: skip
    for column, name in enumerate(COLUMNS):
        history[:, column] *= units.get(name, 1.0)
