"""Half a disc against a rigid wall, by explicit central differences, compiled.

Lengths are in radii, stresses in Young's moduli and densities in that of the disc, so that times are in r sqrt(rho/E).

    M a = -integral of P grad N dA + contact,   v(n + 1/2) = v(n - 1/2) + h a(n),   u(n + 1) = u(n) + h v(n + 1/2)

The wall is y = 0. A point of the rim at a depth d below it is pressed up by k d^m per undeformed length. Kinetic energy
is v(n - 1/2) M v(n + 1/2) / 2: with it the energy of a linear body is constant to round-off, whatever the step. All
numbers of the history are those of the whole disc.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.soft_discs.elasticity import LINEAR, shear_part, volume_part
from bearing_twin.kinds.soft_discs.mesh import GROUP, LANES

COLUMNS = (
    "force", "position", "velocity", "kinetic", "elastic", "contact", "depth", "least_stretch", "least_det", "balance",
)  # fmt: skip
"""What a row of the history holds: `balance` is the force less the integral of rho a dA, round-off alone."""


class Body(NamedTuple):
    """What stays: arrays of the mesh, law and plane, shear modulus, Lame's first parameter, k and m of the contact."""

    height: np.ndarray
    mass: np.ndarray
    nodes: np.ndarray
    gradients: np.ndarray
    weights: np.ndarray
    full: int
    rim_nodes: np.ndarray
    rim_shapes: np.ndarray
    rim_weights: np.ndarray
    on_axis: np.ndarray
    law: int
    plane_stress: bool
    mu: float
    lame: float
    stiffness: float
    exponent: float


class State(NamedTuple):
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
    moved, given = np.zeros(2 * GROUP * LANES * groups), np.empty(2 * GROUP * LANES * groups)
    f, found = np.empty(4 * LANES), np.zeros(3 * LANES)
    found[LANES:] = np.inf
    for block in range(body.nodes.shape[0]):
        for a in range(size):
            for k in range(LANES):
                node = body.nodes[block, a, k]
                moved[2 * a * LANES + k], moved[(2 * a + 1) * LANES + k] = displacement[0, node], displacement[1, node]
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
                load[0, node] -= given[2 * a * LANES + k]
                load[1, node] -= given[(2 * a + 1) * LANES + k]
    square = 1.0 + 2.0 * found[2 * LANES :].min()
    return found[:LANES].sum(), found[LANES : 2 * LANES].min(), math.sqrt(max(square, 0.0))


@inlined
def _gather(gradients, moved, f, groups):
    """Puts the gradient of the displacement at one point in `f`, GROUP nodes at a time."""
    f[:] = 0.0
    for group in range(groups):
        g = gradients[group * 2 * GROUP * LANES : (group + 1) * 2 * GROUP * LANES]
        u = moved[group * 2 * GROUP * LANES : (group + 1) * 2 * GROUP * LANES]
        for k in range(LANES):
            xx, xy, yx, yy = f[0 * LANES + k], f[1 * LANES + k], f[2 * LANES + k], f[3 * LANES + k]
            # Written out for GROUP nodes: a loop here keeps the loop over lanes from becoming vector instructions.
            xx += u[0 * LANES + k] * g[0 * LANES + k]
            xy += u[0 * LANES + k] * g[1 * LANES + k]
            yx += u[1 * LANES + k] * g[0 * LANES + k]
            yy += u[1 * LANES + k] * g[1 * LANES + k]
            xx += u[2 * LANES + k] * g[2 * LANES + k]
            xy += u[2 * LANES + k] * g[3 * LANES + k]
            yx += u[3 * LANES + k] * g[2 * LANES + k]
            yy += u[3 * LANES + k] * g[3 * LANES + k]
            xx += u[4 * LANES + k] * g[4 * LANES + k]
            xy += u[4 * LANES + k] * g[5 * LANES + k]
            yx += u[5 * LANES + k] * g[4 * LANES + k]
            yy += u[5 * LANES + k] * g[5 * LANES + k]
            xx += u[6 * LANES + k] * g[6 * LANES + k]
            xy += u[6 * LANES + k] * g[7 * LANES + k]
            yx += u[7 * LANES + k] * g[6 * LANES + k]
            yy += u[7 * LANES + k] * g[7 * LANES + k]
            f[0 * LANES + k], f[1 * LANES + k], f[2 * LANES + k], f[3 * LANES + k] = xx, xy, yx, yy


@inlined
def _spread(gradients, f, given, groups):
    """Adds the weighted stress in `f` times the gradients at one point to the forces of the elements' nodes."""
    for group in range(groups):
        g = gradients[group * 2 * GROUP * LANES : (group + 1) * 2 * GROUP * LANES]
        s = given[group * 2 * GROUP * LANES : (group + 1) * 2 * GROUP * LANES]
        for k in range(LANES):
            xx, xy, yx, yy = f[0 * LANES + k], f[1 * LANES + k], f[2 * LANES + k], f[3 * LANES + k]
            s[0 * LANES + k] += xx * g[0 * LANES + k] + xy * g[1 * LANES + k]
            s[1 * LANES + k] += yx * g[0 * LANES + k] + yy * g[1 * LANES + k]
            s[2 * LANES + k] += xx * g[2 * LANES + k] + xy * g[3 * LANES + k]
            s[3 * LANES + k] += yx * g[2 * LANES + k] + yy * g[3 * LANES + k]
            s[4 * LANES + k] += xx * g[4 * LANES + k] + xy * g[5 * LANES + k]
            s[5 * LANES + k] += yx * g[4 * LANES + k] + yy * g[5 * LANES + k]
            s[6 * LANES + k] += xx * g[6 * LANES + k] + xy * g[7 * LANES + k]
            s[7 * LANES + k] += yx * g[6 * LANES + k] + yy * g[7 * LANES + k]


@kernel
def press(body, displacement, load):
    """Adds the pressure of the wall to `load` (2, n); returns (force, energy in the contact, greatest depth), halves."""
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
def march(body, state, step, history, frames, every, first):
    """Fills the rows of `history` (rows, COLUMNS), the first of them at step number `first`.

    `frames` (f, 2, n) takes the displacement at every step divisible by `every`. Returns how many rows are filled:
    fewer than there are where det F <= 0 in the last of them and the law has no answer to that.
    """
    displacement, velocity, load = state
    mass = body.mass
    last = mass.shape[0] - 1  # the node that is none
    whole = mass[:last].sum()
    for row in range(history.shape[0]):
        if (first + row) % every == 0 and (first + row) // every < frames.shape[0]:
            frames[(first + row) // every] = displacement
        load[:] = 0.0
        elastic, det, stretch = inner_forces(body, displacement, load)
        force, pressed, deepest = press(body, displacement, load)
        for place in range(body.on_axis.shape[0]):
            load[0, body.on_axis[place]] = 0.0
        kinetic, momentum, moment, gained = 0.0, 0.0, 0.0, 0.0
        for node in range(last):
            before_x, before_y = velocity[0, node], velocity[1, node]
            after_x = before_x + step * load[0, node] / mass[node]
            after_y = before_y + step * load[1, node] / mass[node]
            velocity[0, node], velocity[1, node] = after_x, after_y
            kinetic += mass[node] * (before_x * after_x + before_y * after_y)
            momentum += 0.5 * mass[node] * (before_y + after_y)
            gained += load[1, node]
            moment += mass[node] * (body.height[node] + displacement[1, node])
            displacement[0, node] += step * after_x
            displacement[1, node] += step * after_y
        line = history[row]
        line[0], line[1], line[2] = 2.0 * force, moment / whole, momentum / whole
        line[3], line[4], line[5] = kinetic, 2.0 * elastic, 2.0 * pressed
        line[6], line[7], line[8], line[9] = deepest, stretch, det, 2.0 * (force - gained)
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
