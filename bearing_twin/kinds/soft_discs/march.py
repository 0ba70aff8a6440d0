"""Half a disc against a rigid wall, or two of them, by explicit central differences, compiled.

Lengths are in radii, stresses in Young's moduli and densities in that of the disc, so that times are in r sqrt(rho/E).

    M a = -integral of P grad N dA + contact,   v(n + 1/2) = v(n - 1/2) + h a(n),   u(n + 1) = u(n) + h v(n + 1/2)

The wall is y = 0. A point of the rim at a depth d below it is pressed up by k d^m per undeformed length. Of two discs
each has a frame of its own, y away from the other (`rims`).

Kinetic energy is v(n - 1/2) M v(n + 1/2) / 2: with it the energy of a linear body is constant to round-off, whatever
the step, which stability sets and no error estimate. All numbers of the history are those of the whole disc; energies,
stretch and det F those of both.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.soft_discs.elasticity import LINEAR, shear_part, volume_part
from bearing_twin.kinds.soft_discs.lanes import (
    ENERGY,
    FOUND_SIZE,
    GRADIENT_SIZE,
    GROUP,
    GROUP_SIZE,
    LANES,
    LEAST_DET,
    LEAST_STRAIN,
    XX,
    XY,
    YX,
    YY,
    get,
    increase,
    of_group,
    of_row,
    put,
)
from bearing_twin.kinds.soft_discs.rims import press_together

COLUMNS = (
    "force", "position", "velocity", "kinetic", "elastic", "contact", "depth", "least_stretch", "least_det", "balance",
    "other_position", "other_velocity",
)  # fmt: skip
"""What a row of the history holds: `balance` is the force less the integral of rho a dA, round-off alone."""


class DiscBody(NamedTuple):
    """What stays: arrays of the mesh, law and plane, shear modulus, Lame's first parameter, k and m of the contact."""

    across: np.ndarray
    height: np.ndarray
    mass: np.ndarray
    nodes: np.ndarray
    gradients: np.ndarray
    weights: np.ndarray
    full: int
    rim_nodes: np.ndarray
    rim_shapes: np.ndarray
    rim_weights: np.ndarray
    rim_places: np.ndarray
    on_axis: np.ndarray
    law: int
    plane_stress: bool
    mu: float
    lame: float
    stiffness: float
    exponent: float


class DiscState(NamedTuple):
    """What moves: displacement (2, n), velocity (2, n) half a step before; `load` (2, n) is room for forces."""

    displacement: np.ndarray
    velocity: np.ndarray
    load: np.ndarray


@kernel
def inner_forces(body, displacement, load):
    """Takes the forces of elasticity off `load` (2, n).

    Returns (energy, least det F, least stretch) of half the disc.
    """
    size = body.nodes.shape[1]
    groups = -(-size // GROUP)
    moved, given = np.zeros(groups * GROUP_SIZE), np.empty(groups * GROUP_SIZE)
    f, found = np.empty(GRADIENT_SIZE), np.full(FOUND_SIZE, np.inf)
    of_row(found, ENERGY)[:] = 0.0
    for block in range(body.nodes.shape[0]):
        for a in range(size):
            for k in range(LANES):
                node = body.nodes[block, a, k]
                put(moved, 2 * a, k, displacement[0, node])
                put(moved, 2 * a + 1, k, displacement[1, node])
        given[:] = 0.0
        for q in range(body.weights.shape[1]):
            gradients, weights = body.gradients[block, q], body.weights[block, q]
            _gather(gradients, moved, f, groups)
            if q < body.full:
                shear_part(body.law, body.plane_stress, body.mu, body.lame, f, weights, found)
            else:
                volume_part(body.law, body.plane_stress, body.lame, f, weights, found)
            _spread(gradients, f, given, groups)
        for k in range(LANES):
            for a in range(size):
                node = body.nodes[block, a, k]
                load[0, node] -= get(given, 2 * a, k)
                load[1, node] -= get(given, 2 * a + 1, k)
    square = 1.0 + 2.0 * of_row(found, LEAST_STRAIN).min()
    return of_row(found, ENERGY).sum(), of_row(found, LEAST_DET).min(), math.sqrt(max(square, 0.0))


@inlined
def _gather(gradients, moved, f, groups):
    """Puts the gradient of the displacement at one point in `f`, GROUP nodes at a time."""
    f[:] = 0.0
    for group in range(groups):
        g, u = of_group(gradients, group), of_group(moved, group)
        for k in range(LANES):
            xx, xy, yx, yy = get(f, XX, k), get(f, XY, k), get(f, YX, k), get(f, YY, k)
            # Written out for GROUP nodes: a loop here keeps the loop over lanes from becoming vector instructions.
            x, y, along, across = get(u, 0, k), get(u, 1, k), get(g, 0, k), get(g, 1, k)
            xx += x * along
            xy += x * across
            yx += y * along
            yy += y * across
            x, y, along, across = get(u, 2, k), get(u, 3, k), get(g, 2, k), get(g, 3, k)
            xx += x * along
            xy += x * across
            yx += y * along
            yy += y * across
            x, y, along, across = get(u, 4, k), get(u, 5, k), get(g, 4, k), get(g, 5, k)
            xx += x * along
            xy += x * across
            yx += y * along
            yy += y * across
            x, y, along, across = get(u, 6, k), get(u, 7, k), get(g, 6, k), get(g, 7, k)
            xx += x * along
            xy += x * across
            yx += y * along
            yy += y * across
            put(f, XX, k, xx)
            put(f, XY, k, xy)
            put(f, YX, k, yx)
            put(f, YY, k, yy)


@inlined
def _spread(gradients, f, given, groups):
    """Adds the weighted stress in `f` times the gradients at one point to the forces of the elements' nodes."""
    for group in range(groups):
        g, s = of_group(gradients, group), of_group(given, group)
        for k in range(LANES):
            xx, xy, yx, yy = get(f, XX, k), get(f, XY, k), get(f, YX, k), get(f, YY, k)
            along, across = get(g, 0, k), get(g, 1, k)
            increase(s, 0, k, xx * along + xy * across)
            increase(s, 1, k, yx * along + yy * across)
            along, across = get(g, 2, k), get(g, 3, k)
            increase(s, 2, k, xx * along + xy * across)
            increase(s, 3, k, yx * along + yy * across)
            along, across = get(g, 4, k), get(g, 5, k)
            increase(s, 4, k, xx * along + xy * across)
            increase(s, 5, k, yx * along + yy * across)
            along, across = get(g, 6, k), get(g, 7, k)
            increase(s, 6, k, xx * along + xy * across)
            increase(s, 7, k, yx * along + yy * across)


@kernel
def press(body, displacement, load):
    """Adds the pressure of the wall to `load` (2, n); returns (force, energy, greatest depth) of the half disc."""
    force, energy, deepest = 0.0, 0.0, 0.0
    power = body.exponent
    for edge in range(body.rim_nodes.shape[0]):
        for point in range(body.rim_shapes.shape[0]):
            height = 0.0
            for a in range(body.rim_nodes.shape[1]):
                node = body.rim_nodes[edge, a]
                height += body.rim_shapes[point, a] * (body.height[node] + displacement[1, node])
            if height < 0.0:
                pressure = body.stiffness * (-height if power == 1.0 else (-height) ** power)
                pushed = pressure * body.rim_weights[edge, point]
                force += pushed
                energy -= pushed * height / (power + 1.0)
                deepest = max(deepest, -height)
                for a in range(body.rim_nodes.shape[1]):
                    load[1, body.rim_nodes[edge, a]] += pushed * body.rim_shapes[point, a]
    return force, energy, deepest


@kernel
def _advance(body, state, step):
    """One step by the forces in `state.load`.

    Returns (twice the kinetic energy, momentum, sum of forces, moment of mass) of the half disc, along y.
    """
    displacement, velocity, load = state
    kinetic, momentum, gained, moment = 0.0, 0.0, 0.0, 0.0
    for place in range(body.on_axis.shape[0]):
        load[0, body.on_axis[place]] = 0.0
    for node in range(body.mass.shape[0] - 1):  # the last node is none
        mass = body.mass[node]
        before_x, before_y = velocity[0, node], velocity[1, node]
        after_x = before_x + step * load[0, node] / mass
        after_y = before_y + step * load[1, node] / mass
        velocity[0, node], velocity[1, node] = after_x, after_y
        kinetic += mass * (before_x * after_x + before_y * after_y)
        momentum += 0.5 * mass * (before_y + after_y)
        gained += load[1, node]
        moment += mass * (body.height[node] + displacement[1, node])
        displacement[0, node] += step * after_x
        displacement[1, node] += step * after_y
    return kinetic, momentum, gained, moment


@kernel
def march(bodies, states, paired, step, history, frames, every, first):
    """Fills the rows of `history` (rows, COLUMNS), the first of them at step number `first`.

    `bodies` and `states` are two; without `paired` the second is not looked at, and a wall takes its place. `frames`
    (f, discs, 2, n) takes the displacements of the discs at every step divisible by `every`. Returns how many rows are
    filled: fewer than there are where det F <= 0 in the last of them and the law has no answer to that.
    """
    body, other, state, moved = bodies[0], bodies[1], states[0], states[1]
    whole, others = body.mass[:-1].sum(), other.mass[:-1].sum()
    for row in range(history.shape[0]):
        if (first + row) % every == 0 and (first + row) // every < frames.shape[0]:
            frames[(first + row) // every, 0] = state.displacement
            if paired:
                frames[(first + row) // every, 1] = moved.displacement
        state.load[:] = 0.0
        elastic, det, stretch = inner_forces(body, state.displacement, state.load)
        line = history[row]
        if paired:
            moved.load[:] = 0.0
            more, other_det, other_stretch = inner_forces(other, moved.displacement, moved.load)
            elastic, det, stretch = elastic + more, min(det, other_det), min(stretch, other_stretch)
            force, pressed, deepest = press_together(
                body, state.displacement, state.load, other, moved.displacement, moved.load
            )
            back = press_together(other, moved.displacement, moved.load, body, state.displacement, state.load)
            force, pressed, deepest = force + back[0], pressed + back[1], max(deepest, back[2])
            kinetic, momentum, gained, moment = _advance(other, moved, step)
            line[3], line[9], line[10], line[11] = kinetic, force - gained, moment / others, momentum / others
        else:
            force, pressed, deepest = press(body, state.displacement, state.load)
        kinetic, momentum, gained, moment = _advance(body, state, step)
        line[0], line[1], line[2] = 2.0 * force, moment / whole, momentum / whole
        line[3] += kinetic
        line[4], line[5], line[6], line[7], line[8] = 2.0 * elastic, 2.0 * pressed, deepest, stretch, det
        line[9] = 2.0 * max(abs(line[9]), abs(force - gained))
        if not det > 0.0 and body.law != LINEAR:
            return row + 1
    return history.shape[0]


@kernel
def stiff_part(body, shape, load):
    """Puts the forces that a small displacement `shape` (2, n) meets in `load`, the whole rim being on the wall.

    The body must be linear; of the exponent m = 1 the stiffness is k, of others that at a depth of one radius.
    """
    load[:] = 0.0
    inner_forces(body, shape, load)
    for edge in range(body.rim_nodes.shape[0]):
        for point in range(body.rim_shapes.shape[0]):
            for axis in range(2):
                moved = 0.0
                for a in range(body.rim_nodes.shape[1]):
                    moved += body.rim_shapes[point, a] * shape[axis, body.rim_nodes[edge, a]]
                pushed = body.stiffness * body.rim_weights[edge, point] * moved
                for a in range(body.rim_nodes.shape[1]):
                    load[axis, body.rim_nodes[edge, a]] -= pushed * body.rim_shapes[point, a]
