"""The contact of two half discs, compiled: rims that pass through each other are pressed apart.

Each disc has a frame of its own, y away from the other. They overlap by g = -(y + y'(x)) where their rims pass the same
x, and the energy is the mean of the integrals of k g^(m+1)/(m+1) over both undeformed rims. Forces are its derivatives,
so that energy is kept, and opposite to each other whatever the meshes. Of equal discs that is the contact with a wall.
Breaks: where a rim is no graph over x any more, far beyond the contact.
"""

import numpy as np

from bearing_twin.compiled import inlined, kernel

ROOT_STEPS = 60  # at most, for the place on an edge: halving alone takes as many
NEAR = 0.01  # radii: rims may dip below their nodes by less


@kernel
def press_together(body, displacement, load, other, moved, given):
    """Adds what the points of the rim of `body` give to `load` and, of `other`, to `given`; as `press`, g for depth."""
    force, energy, deepest = 0.0, 0.0, 0.0
    power, last = body.exponent, other.rim_nodes.shape[0] - 1
    size = other.rim_nodes.shape[1]
    shapes, slopes = np.empty(size), np.empty(size)
    beside = 0
    lowest = np.inf
    for edge in range(last + 1):
        for a in range(size):
            node = other.rim_nodes[edge, a]
            lowest = min(lowest, other.height[node] + moved[1, node])
    for edge in range(body.rim_nodes.shape[0]):
        for point in range(body.rim_shapes.shape[0]):
            x, y = 0.0, 0.0
            for a in range(body.rim_nodes.shape[1]):
                node, shape = body.rim_nodes[edge, a], body.rim_shapes[point, a]
                x += shape * (body.across[node] + displacement[0, node])
                y += shape * (body.height[node] + displacement[1, node])
            if y + lowest > NEAR:
                continue
            while beside < last and _end(other, moved, beside) < x:
                beside += 1
            while beside > 0 and _end(other, moved, beside - 1) > x:
                beside -= 1
            if _end(other, moved, beside) < x:
                continue
            height, slope = _height_at(other, moved, beside, x, shapes, slopes)
            depth = -(y + height)
            if depth > 0.0:
                pressure = body.stiffness * (depth if power == 1.0 else depth**power)
                pushed = 0.5 * pressure * body.rim_weights[edge, point]
                force += pushed
                energy += pushed * depth / (power + 1.0)
                deepest = max(deepest, depth)
                for a in range(body.rim_nodes.shape[1]):
                    node, share = body.rim_nodes[edge, a], pushed * body.rim_shapes[point, a]
                    load[0, node] += share * slope
                    load[1, node] += share
                for a in range(size):
                    node, share = other.rim_nodes[beside, a], pushed * shapes[a]
                    given[0, node] -= share * slope
                    given[1, node] += share
    return force, energy, deepest


@inlined
def _end(body, displacement, edge):
    """Where an edge of the rim ends, along the wall."""
    node = body.rim_nodes[edge, body.rim_nodes.shape[1] - 1]
    return body.across[node] + displacement[0, node]


@inlined
def _height_at(body, displacement, edge, x, shapes, slopes):
    """Height and slope dy/dx of the rim where it passes x on that edge; fills its shape functions there."""
    size = body.rim_nodes.shape[1]
    low, high, place = -1.0, 1.0, 0.0
    along, height, steep, rise = 0.0, 0.0, 1.0, 0.0
    for _ in range(ROOT_STEPS):
        _lagrange(body.rim_places, place, shapes, slopes)
        along, height, steep, rise = 0.0, 0.0, 0.0, 0.0
        for a in range(size):
            node = body.rim_nodes[edge, a]
            across, up = body.across[node] + displacement[0, node], body.height[node] + displacement[1, node]
            along += shapes[a] * across
            height += shapes[a] * up
            steep += slopes[a] * across
            rise += slopes[a] * up
        off = along - x
        if off > 0.0:
            high = place
        else:
            low = place
        change = off / steep if steep > 0.0 else 2.0
        if abs(change) < 1e-14:
            break
        place -= change
        if not low <= place <= high:
            place = 0.5 * (low + high)
    return height, rise / steep


@inlined
def _lagrange(nodes, place, shapes, slopes):
    """Fills values and slopes of the Lagrange polynomials on `nodes` at one place."""
    for a in range(nodes.shape[0]):
        value, slope = 1.0, 0.0
        for b in range(nodes.shape[0]):
            if b != a:
                scale = 1.0 / (nodes[a] - nodes[b])
                slope = (slope * (place - nodes[b]) + value) * scale
                value *= (place - nodes[b]) * scale
        shapes[a], slopes[a] = value, slope
