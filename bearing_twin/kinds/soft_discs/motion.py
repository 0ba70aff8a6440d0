"""A soft disc on a rigid wall, or on another disc, as a run: channels at any instant, and what the impact was.

Two equal discs are each other's mirror image: the plane between them is a wall without friction, to which each comes at
half the relative speed; positions, velocities and energies are those of one disc. Of two unequal ones both are meshed,
energies are those of both; heights are above the place of first touch in the frame of the common centre of mass.
"""

import ctypes
import dataclasses
import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from bearing_twin.base.errors import IntegrationError
from bearing_twin.base.report import Choice
from bearing_twin.base.sample import Channel
from bearing_twin.core import INTEGER, REAL, REALS_OUT, Function
from bearing_twin.kinds.bodies.impact import Impact, ImpactMotion
from bearing_twin.kinds.soft_discs.derived import (
    bodies_of,
    capped_ratio,
    contact_time,
    nodes_of,
    resolve,
    seen_from_other,
    time_unit,
    wall_speed,
    wave_speed,
)
from bearing_twin.kinds.soft_discs.figures import IMPACT
from bearing_twin.kinds.soft_discs.mesh import Mesh, half_disc
from bearing_twin.kinds.soft_discs.parameters import DiscMesh, SoftDiscsScene

PIECE = 50_000  # nodes times steps between looks at whether all is over: 5 ms, after which Ctrl-C is heard
GONE = 0.2  # of the time so far: out of contact for so long the disc does not come back
LONGEST = 6.0  # estimates of the contact time, after which a disc that has not left is given up
FEWEST_PIECE = 50
GREATEST_FRAMES = 601
BOUND = 1e-3  # relative tolerance of the eigenvalues in the bound, added to it

COLUMNS = {
    "normal_load": "N", "position": "m", "velocity": "m/s", "kinetic_energy": "J", "elastic_energy": "J",
    "contact_energy": "J", "penetration": "m", "least_stretch": "1", "least_det": "1", "balance": "N",
    "other_position": "m", "other_velocity": "m/s",
}  # fmt: skip
"""Columns of the history and their units; `balance` is the force less the integral of rho a dA, round-off alone.

Those that are channels have their names."""

STVK, NEO_HOOKEAN, NEO_HOOKEAN_PLANE_STRESS, LINEAR = range(4)  # `Law` of core/soft_discs/soft_discs.cpp
FORMULATIONS = {"stvk": STVK, "neo_hookean": NEO_HOOKEAN, "linear": LINEAR}
_COUNTS = "nodes", "blocks", "side", "full", "reduced", "edges", "rim_points", "axis_nodes"
_ARRAYS = (
    "across", "height", "mass", "nodes", "values", "slopes", "inverses", "weights", "rim_nodes", "rim_shapes",
    "rim_weights", "rim_coordinates", "on_axis",
)  # fmt: skip
_REALS = "mu", "lame", "stiffness", "exponent"  # of a DiscBody, in its order


class _HalfDisc(ctypes.Structure):
    """`HalfDisc` of core/soft_discs/soft_discs.cpp."""

    _fields_ = (
        *((f"number_of_{name}", ctypes.c_int64) for name in _COUNTS),
        ("law", ctypes.c_int64),
        *((name, ctypes.c_void_p) for name in _ARRAYS),
        *((name, ctypes.c_double) for name in _REALS),
    )


class DiscBody(NamedTuple):
    """Half a disc: its mesh, law, shear modulus, Lame's first parameter, k and m of the contact."""

    mesh: Mesh
    law: int
    mu: float
    lame: float
    stiffness: float
    exponent: float

    def as_structure(self) -> _HalfDisc:
        """Numbers and arrays that the core reads; the arrays must live as long."""
        mesh = self.mesh
        edges, side = mesh.rim_nodes.shape
        counts = len(mesh.mass), len(mesh.nodes), side, mesh.full, mesh.reduced, edges, len(mesh.rim_shapes)
        arrays = (getattr(mesh, name).ctypes.data for name in _ARRAYS)
        return _HalfDisc(*counts, len(mesh.on_axis), self.law, *arrays, *self[2:])


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
    other. `ended` is true if the disc has left for good.
    """

    step: float
    history: np.ndarray
    frame_step: float
    frames: np.ndarray
    mesh: Mesh
    ended: bool

    def column(self, name: str) -> np.ndarray:
        """One column of the history."""
        return self.history[:, [*COLUMNS].index(name)]

    def column_at(self, name: str, times: np.ndarray) -> np.ndarray:
        """One column at times [s], by straight lines between steps."""
        return np.interp(times, self.step * np.arange(len(self.history)), self.column(name))

    def shape_at(self, radius: float, disc: int, times: np.ndarray) -> np.ndarray:
        """Places (t, n, 2) [m] of the nodes of disc 0 or 1 at times [s], x from the line of flight, y as a height."""
        frame = np.clip(np.asarray(times) / self.frame_step, 0.0, len(self.frames) - 1.0)
        low = np.minimum(frame.astype(int), max(len(self.frames) - 2, 0))
        fraction = (frame - low)[:, None, None]
        high = np.minimum(low + 1, len(self.frames) - 1)
        displacement = (1.0 - fraction) * self.frames[low, disc] + fraction * self.frames[high, disc]
        nodes = radius * np.stack([self.mesh.across[:-1], self.mesh.height[:-1]])
        return np.moveaxis(nodes + displacement[:, :, :-1], 1, 2)


def bodies_in_units(parameters: SoftDiscsScene) -> tuple[DiscBody, DiscBody]:
    """The disc and what it meets, a wall being a copy of it; lengths in its radii, stresses in its Young's moduli."""
    penalty = parameters.contact
    if parameters.against != "other_disc":
        body = body_of(parameters, penalty.stiffness_ratio)
        return body, body
    second, power = seen_from_other(parameters), penalty.exponent
    size, stiff, dense = (
        first / reference for first, reference in zip(_scales(second), _scales(parameters), strict=True)
    )
    # Two penalties one behind the other: their depths sum up to the overlap.
    stiffness_ratio = penalty.stiffness_ratio / (1.0 + (size**power / stiff) ** (1.0 / power)) ** power
    body, scaled = body_of(parameters, stiffness_ratio), body_of(second, stiffness_ratio)
    mesh = scaled.mesh
    mesh = dataclasses.replace(
        mesh, across=size * mesh.across, height=size * mesh.height, mass=dense * size**2 * mesh.mass,
        inverses=mesh.inverses / size, weights=size**2 * mesh.weights, rim_weights=size * mesh.rim_weights,
    )  # fmt: skip
    return body, scaled._replace(mesh=mesh, mu=stiff * scaled.mu, lame=stiff * scaled.lame)


def _scales(parameters):
    material = parameters.disc.material
    return parameters.disc.radius, material.young_modulus, material.density


def body_of(parameters: SoftDiscsScene, stiffness: float) -> DiscBody:
    """The disc without units: lengths in radii, stresses in Young's moduli."""
    ratio, law = capped_ratio(parameters), FORMULATIONS[parameters.formulation]
    mu, lame = 0.5 / (1.0 + ratio), ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio))
    plane_stress = parameters.plane == "stress"
    if plane_stress and law != NEO_HOOKEAN:
        lame = 2.0 * lame * mu / (lame + 2.0 * mu)
    if plane_stress and law == NEO_HOOKEAN:
        law = NEO_HOOKEAN_PLANE_STRESS
    return DiscBody(half_disc(parameters.mesh), law, mu, lame, stiffness, parameters.contact.exponent)


def elastic_forces(body: DiscBody, displacement: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces (2, n) of elasticity at the nodes; energy, least det F and least stretch (3,) of half the disc."""
    load, extremes = np.zeros_like(displacement), np.empty(3)
    _elastic(body.as_structure(), displacement, load, extremes)
    return load, extremes


def stable_step(parameters: SoftDiscsScene) -> float:
    """A bound from below on the greatest stable step of the undeformed disc, in r sqrt(rho/E), penalty included.

    The greatest eigenvalue of a sum of stiffnesses is at most the sum of theirs (Weyl), so that those of shear, volume
    and penalty are found once for a mesh. Of two discs the lesser; a penalty between them counts twice for each.
    """
    radius, density = parameters.disc.radius, parameters.disc.material.density
    shear, volume, penalty = _greatest_eigenvalues(parameters.mesh)
    steps = []
    for body, scene in zip(bodies_in_units(parameters), bodies_of(parameters).values(), strict=False):
        size, dense = scene.disc.radius / radius, scene.disc.material.density / density
        stiffness = body.stiffness * (2.0 if parameters.against == "other_disc" else 1.0)
        if body.exponent > 1.0:
            # The depth that stops a plane wave, twice for what comes after it.
            pressure = wall_speed(scene) / wave_speed(parameters) * math.sqrt((body.lame + 2.0 * body.mu) * dense)
            depth = min(1.0, 2.0 * (pressure / stiffness) ** (1.0 / body.exponent))
            stiffness *= body.exponent * depth ** (body.exponent - 1.0)
        inner = (body.mu * shear + body.lame * volume) / size**2
        steps.append(2.0 / math.sqrt((inner + stiffness * penalty / size) / dense))
    return min(steps)


@functools.lru_cache(maxsize=8)
def _greatest_eigenvalues(mesh: DiscMesh) -> tuple[float, float, float]:
    """Of mass^-1 stiffness: with mu = 1 alone, with lambda = 1 alone, with k = 1 alone."""
    parts = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    return tuple(_greatest_eigenvalue(DiscBody(half_disc(mesh), LINEAR, *part, 1.0)) for part in parts)


def _greatest_eigenvalue(body) -> float:
    size = len(body.mesh.mass)
    root, load, disc = np.sqrt(body.mesh.mass), np.zeros((2, size)), body.as_structure()

    def operate(vector):
        _stiffness(disc, vector.reshape(2, size) / root, load)
        load[:, -1] = 0.0
        return -(load / root).ravel()

    start = np.random.default_rng(1).standard_normal(2 * size)
    eigenvalues = eigsh(
        LinearOperator((2 * size, 2 * size), operate, dtype=float), k=1, which="LA", tol=BOUND, v0=start,
        return_eigenvectors=False,
    )  # fmt: skip
    return float(eigenvalues[0]) * (1.0 + BOUND)


def solve(parameters: SoftDiscsScene, frames: int = GREATEST_FRAMES) -> Solved:
    """Moves the disc of resolved parameters until it has left the wall and the run is over; about `frames` shapes.

    Raises IntegrationError where an element turns inside out (reason "collapsed") or a number is no longer finite.
    """
    bodies, unit, radius = bodies_in_units(parameters), time_unit(parameters), parameters.disc.radius
    step, paired = parameters.solver.step_share * stable_step(parameters), parameters.against == "other_disc"
    size = len(bodies[0].mesh.mass)
    states = np.zeros((2, 3, 2, size))  # of both discs: displacement, velocity, room for forces
    for state, scene in zip(states, bodies_of(parameters).values(), strict=False):
        state[1, 1, :-1] = -wall_speed(scene) / wave_speed(parameters)
    disc, second = (body.as_structure() for body in bodies)
    least = parameters.run.duration / unit
    longest = max(LONGEST * contact_time(parameters) / unit, least)
    every = max(1, math.ceil(least / step / max(frames - 1, 1)))
    displacements = np.zeros((math.ceil(least / step / every) + 1, 1 + paired, 2, size))
    pieces, done, last, is_over, ended = [], 0, -1, False, False
    while not is_over:
        rows = np.zeros((max(PIECE // size, FEWEST_PIECE), len(COLUMNS)))
        filled = _march(
            *(
                disc,
                states[0],
                second if paired else None,
                states[1],
                step,
                len(rows),
                rows,
                len(displacements),
                displacements,
            ),
            *(every, done),
        )
        rows = rows[:filled]
        touching = np.flatnonzero(rows[:, 0] > 0.0)
        last = done + touching[-1] if len(touching) else last
        _refuse_collapse(parameters, rows, done, step * unit)
        pieces.append(rows)
        done += filled
        ended = last >= 0 and done - last > GONE * last + 1.0
        is_over = (ended and step * done > least) or step * done > longest
    history = np.concatenate(pieces)
    _give_units(history, parameters)
    shapes = displacements[: min(len(displacements), (done - 1) // every + 1)]
    shapes *= radius
    return Solved(step * unit, history, every * step * unit, shapes, half_disc(parameters.mesh), ended)


def _refuse_collapse(parameters, rows, done, step):
    det = rows[-1, [*COLUMNS].index("least_det")]
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
    disc = parameters.disc
    force = disc.material.young_modulus * disc.radius * disc.thickness
    units = {"N": force, "m": disc.radius, "m/s": wave_speed(parameters), "J": force * disc.radius, "1": 1.0}
    history *= [units[unit] for unit in COLUMNS.values()]


NODES = ("node", "in_plane")  # axes of a shape
STORED = "kinetic_energy", "elastic_energy", "contact_energy"


def channels(parameters: SoftDiscsScene) -> tuple[Channel, ...]:
    """Channels of a sample."""
    nodes = nodes_of(resolve(parameters).mesh.divisions)
    return (
        Channel("normal_load", "N", (), "contact force on the whole disc, away from the wall"),
        Channel("position", "m", (), "height of the centre of mass above the wall or the place of first touch"),
        Channel("velocity", "m/s", (), "of the centre of mass, away from the wall"),
        Channel("penetration", "m", (), "greatest depth of the rim below the wall"),
        Channel("least_stretch", "1", (), "least principal stretch in the plane of the discs"),
        Channel(
            "kinetic_energy",
            "J",
            (),
            "of the whole disc or both, product of the velocities half a step before and after",
        ),
        Channel("elastic_energy", "J", (), "strain energy of the whole disc or both"),
        Channel("contact_energy", "J", (), "stored in the penalty of the contact"),
        Channel(
            "shape", "m", (nodes, 2), "nodes of the half disc x >= 0: x from the line of flight, y off the wall", NODES
        ),
        *(
            (
                Channel(
                    "other_position", "m", (), "depth of the other's centre of mass below the place of first touch"
                ),
                Channel("other_velocity", "m/s", (), "of the other's centre of mass, away from the disc"),
                Channel("other_shape", "m", (nodes, 2), "nodes of the other's half, y away from the disc", NODES),
            )
            if parameters.against == "other_disc"
            else ()
        ),
    )


def solved_impact(parameters: SoftDiscsScene, law: str = "", stepper: str = "") -> Impact:
    """The impact; raises IntegrationError where the disc collapses."""
    parameters = resolve(parameters)
    outputs = round(parameters.run.duration * parameters.run.output_rate) + 1
    solved = solve(parameters, min(outputs, GREATEST_FRAMES))
    impact = impact_of(solved, wall_speed(parameters))
    records = {IMPACT.name: np.array([[impact[column.name] for column in IMPACT.columns]], float)}
    is_pair = parameters.against == "other_disc"
    shapes = {"shape": (parameters.disc.radius, 0), "other_shape": (parameters.other.radius, 1)}

    def outputs_at(times):
        return tuple(
            solved.shape_at(*shapes[channel.name], times)
            if channel.name in shapes
            else solved.column_at(channel.name, times)
            for channel in channels(parameters)
        )

    costs = {
        "steps": len(solved.history),
        "nodes": (1 + is_pair) * (len(solved.mesh.mass) - 1),
        "elements": (1 + is_pair) * len(solved.mesh.elements),
    }
    return Impact(outputs_at, parameters.run, records, costs)


def duration_and_touches(solved: Solved) -> tuple[float, int]:
    """From first touch to last contact [s], gaps included, and how often the disc touched the wall.

    The force of the last steps is drawn on by a straight line to where it is zero, at most one step.
    """
    force = solved.column("normal_load")
    inside = force > 0.0
    touching = np.flatnonzero(inside)
    if not len(touching):
        return 0.0, 0
    last = touching[-1]
    fall = force[last - 1] - force[last] if last else 0.0
    beyond = min(1.0, force[last] / fall) if fall > 0.0 else 1.0
    touches = int(np.sum(inside[1:] & ~inside[:-1]) + inside[0])
    return float((last + beyond) * solved.step), touches


def impact_of(solved: Solved, speed: float) -> dict[str, float]:
    """The columns of IMPACT by name, of a disc that came at this speed [m/s]."""
    force, (duration, touches) = solved.column("normal_load"), duration_and_touches(solved)
    peak, total = int(np.argmax(force)), sum(solved.column(name) for name in STORED)
    return {
        "time": duration,
        "peak_force": float(force[peak]),
        "peak_time": peak * solved.step,
        "contact_duration": duration,
        "impulse": float(force.sum()) * solved.step,
        "restitution": float(solved.column("velocity")[-1]) / speed,
        "greatest_penetration": float(solved.column("penetration").max()),
        "energy_gained": float(total[int(np.argmax(np.abs(total - total[0])))] - total[0]),
        "least_stretch": float(solved.column("least_stretch").min()),
        "force_balance": float(np.abs(solved.column("balance")).max()),
        "touches": touches,
        "ended": solved.ended,
    }


def motion(parameters: SoftDiscsScene, choice: Choice) -> ImpactMotion:
    """The impact as a run."""
    return ImpactMotion(solved_impact, parameters, choice)
