"""The mesh of half a disc of radius 1 about the origin, x >= 0, cut by the line on which it flies, and its elements.

They are quadrilaterals of order 1 to 4: Lagrange polynomials on Gauss-Lobatto nodes. Order 1 is the bilinear one,
higher orders are spectral elements. With mass lumped at the Gauss-Lobatto nodes no further approximation is made in the
mass of an undistorted element (Y. Maday, A. T. Patera, 1989).

A quarter is three blocks: a core and two blocks between it and the rim. With N divisions a block has N/2 intervals of
nodes each way, so that the half disc has 1.5 N^2 of them whatever the order; elements of order p take p intervals each
way. Geometry is interpolated at the same nodes as displacement.
"""

import functools
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy import sparse
from scipy.interpolate import KroghInterpolator
from scipy.special import wrightomega

from bearing_twin.core import simd_lanes
from bearing_twin.kinds.soft_discs.derived import capped_ratio
from bearing_twin.kinds.soft_discs.parameters import DiscMesh, SoftDiscsScene

ORDERS = (1, 2, 3, 4)
CORE, CORNER = 0.55, 0.43  # of the radius: half the width of the core on the axes, and its corner
RIM_POINTS = 4  # contact points of an edge, times its nodes: where contact ends the pressure has a kink
NEAR = 1e-9  # nodes nearer than this are one


@dataclass(frozen=True, eq=False)
class Mesh:
    """Half a disc of radius, thickness and density 1.

    Place `across` the line of flight, `height` above the lowest point and `mass` of the nodes (n,), where the last node
    is a dummy that collects forces of lanes without an element.
    Blocks are of as many elements as the core computes side by side: `nodes` (blocks, nodes of an element, lanes) by
    their numbers; `inverses` of the Jacobian, reference coordinates by place (blocks, points, 2, 2, lanes); `weights`
    (blocks, points, lanes). There are two sets of Gauss points, `full` squared for the part with the shear modulus,
    then `reduced` squared for Lame's first parameter; `values` and `slopes` of the Lagrange polynomials along a
    direction (full + reduced, order + 1) are at both.
    `rim_nodes` (edges, nodes of an edge) of the lower half of the rim, from the bottom up, `rim_shapes` (rim points,
    nodes), `rim_weights` (edges, rim points), `rim_coordinates` of the nodes along an edge; `on_axis` numbers of the
    nodes on x = 0, `outline` of those on the rim from the bottom to the top; `elements` (e, nodes of an element).
    """

    order: int
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
    rim_coordinates: np.ndarray
    on_axis: np.ndarray
    outline: np.ndarray
    elements: np.ndarray


@functools.lru_cache(maxsize=4)
def half_disc(mesh: DiscMesh) -> Mesh:
    """The mesh with so many divisions N, a multiple of twice the order."""
    divisions, order, integration = mesh.divisions, mesh.order, mesh.integration
    points, elements, edges = _numbered(divisions // (2 * order), order)
    full, reduced = order + 1, order if integration == "selective" else order + 1
    corners = points[elements]
    arrays = zip(*(_at_points(corners, order, points_along) for points_along in (full, reduced)), strict=True)
    inverses, weights = (_in_lanes(np.concatenate(part, axis=1)) for part in arrays)
    polynomials = (lagrange(lobatto(order)[0], gauss(points)[0]) for points in (full, reduced))
    values, slopes = (np.concatenate(arrays) for arrays in zip(*polynomials, strict=True))
    mass = np.zeros(len(points) + 1)
    np.add.at(mass, elements, _lumped(corners, order))
    mass[-1] = 1.0
    outline = np.unique(edges)
    outline = outline[np.argsort(points[outline, 1])]
    edges = edges[points[edges, 1].max(axis=1) < NEAR]
    edges = np.where((points[edges[:, 0], 0] > points[edges[:, -1], 0])[:, None], edges[:, ::-1], edges)
    edges = edges[np.argsort(points[edges[:, 0], 0])]
    shapes, rim_weights = _rim(points, edges, order)
    on_axis = np.flatnonzero(points[:, 0] < NEAR)
    across, height = np.append(points[:, 0], 0.0), np.append(points[:, 1], 0.0) + 1.0
    across[on_axis] = 0.0
    return Mesh(
        order, across, height, mass,
        _in_lanes(elements, fill=len(points)), values, slopes, inverses, weights,
        full, reduced, edges, shapes, rim_weights, lobatto(order)[0], on_axis, outline, elements,
    )  # fmt: skip


def _numbered(count, order):
    """Nodes (n, 2), elements (e, nodes) and edges of the rim (edges, nodes), `count` elements along a block."""
    inside = 0.5 * (lobatto(order)[0] + 1.0)
    along = np.append((np.arange(count)[:, None] + inside[:-1]).ravel(), count) / count
    s, t = np.meshgrid(along, along, indexing="ij")  # (first, second) direction of a block
    middle, right, corner, top = np.zeros(2), np.array([CORE, 0.0]), np.array([CORNER, CORNER]), np.array([0.0, CORE])
    core = _line(s, _line(t, middle, top), _line(t, right, corner))
    outer = [
        _line(s, _line(t, *inner), _arc(angle + t)) for inner, angle in (((right, corner), 0.0), ((corner, top), 1.0))
    ]
    upper = np.stack([core, *outer])
    # The mirror image turns the sense of rotation, so its directions change places.
    blocks = np.concatenate([upper, np.swapaxes(upper, 1, 2) * (1.0, -1.0)])
    rounded = np.rint(blocks.reshape(-1, 2) / NEAR).astype(np.int64)
    _, first, number = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    numbers, side = number.reshape(blocks.shape[:3]), order + 1
    elements = sliding_window_view(numbers, (side, side), axis=(1, 2))[:, ::order, ::order]
    rims = np.concatenate([numbers[1:3, -1], numbers[4:, :, -1]])
    edges = sliding_window_view(rims, side, axis=1)[:, ::order]
    elements = np.swapaxes(elements, -1, -2).reshape(-1, side * side)
    return blocks.reshape(-1, 2)[first], elements, edges.reshape(-1, side)


def _line(share, start, end):
    """Places (..., 2) at shares (...) of the way between two."""
    return (1.0 - share[..., None]) * start + share[..., None] * end


def _arc(eighths):
    """Places (..., 2) on the rim, by eighths of a turn from the x axis."""
    return np.stack([np.cos(0.25 * np.pi * eighths), np.sin(0.25 * np.pi * eighths)], axis=-1)


def _jacobians(corners, slopes):
    """Derivatives (e, q, 2, 2) of place by reference coordinates, and their determinants."""
    jacobian = np.einsum("ena,qnb->eqab", corners, slopes)
    return jacobian, np.linalg.det(jacobian)


def _at_points(corners, order, points):
    """Inverses of the Jacobian (e, q, 2, 2) and weights (e, q) at points^2 Gauss points."""
    coordinates, weights = gauss(points)
    jacobian, determinant = _jacobians(corners, slopes_on_square(order, coordinates))
    return np.linalg.inv(jacobian), np.outer(weights, weights).ravel() * determinant


def _lumped(corners, order):
    """Mass (e, n) by Gauss-Lobatto quadrature, whose points are the nodes."""
    nodes, weights = lobatto(order)
    return np.outer(weights, weights).ravel() * _jacobians(corners, slopes_on_square(order, nodes))[1]


def _rim(points, edges, order):
    """Shape functions (c, n) along an edge and weights (edges, c), undeformed lengths."""
    coordinates, weights = gauss(RIM_POINTS * (order + 1))
    values, slopes = lagrange(lobatto(order)[0], coordinates)
    tangents = np.einsum("ena,cn->eca", points[edges], slopes)
    return values, weights * np.linalg.norm(tangents, axis=2)


def _in_lanes(array, fill=0):
    """(e, ...) as (blocks, ..., lanes); what is missing is `fill`."""
    lanes = simd_lanes()
    missing = -len(array) % lanes
    padded = np.concatenate([array, np.full((missing, *array.shape[1:]), fill, array.dtype)])
    return np.ascontiguousarray(np.moveaxis(padded.reshape(-1, lanes, *array.shape[1:]), 1, -1))


def lobatto(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Lobatto nodes (order + 1,) on [-1, 1] and their weights; exact to degree 2 order - 1."""
    legendre = np.polynomial.legendre.Legendre.basis(order)
    nodes = np.concatenate([[-1.0], np.sort(np.real(legendre.deriv().roots())), [1.0]])
    return nodes, 2.0 / (order * (order + 1) * legendre(nodes) ** 2)


def gauss(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points (points,) on [-1, 1] and their weights; exact to degree 2 points - 1."""
    return np.polynomial.legendre.leggauss(points)


def lagrange(nodes: np.ndarray, coordinates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes (places, nodes) of the Lagrange polynomials on `nodes` at `places`."""
    basis = KroghInterpolator(nodes, np.eye(len(nodes)))
    return basis(coordinates), basis.derivative(coordinates)


def slopes_on_square(order: int, coordinates: np.ndarray) -> np.ndarray:
    """Gradients (q, n, 2) of the shape functions by reference coordinates at all pairs of `places` (k,) on [-1, 1].

    Nodes and points count along the first direction fastest.
    """
    values, slopes = lagrange(lobatto(order)[0], coordinates)
    along = np.einsum("jb,ia->jiba", values, slopes)
    across = np.einsum("jb,ia->jiba", slopes, values)
    return np.stack([along, across], axis=-1).reshape(len(coordinates) ** 2, -1, 2)


LEAST_SHARE = 1e-6  # of lambda over mu: less changes the thickness by nothing


def energy_density(parameters: SoftDiscsScene, gradient: np.ndarray) -> np.ndarray:
    """Strain energy per undeformed volume [J/m^3] of deformation gradients (..., 2, 2) by the scene's formulation."""
    material, ratio = parameters.disc.material, capped_ratio(parameters)
    mu = 0.5 * material.young_modulus / (1.0 + ratio)
    lame = material.young_modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio))
    stress = parameters.plane == "stress"
    if parameters.formulation == "neo_hookean":
        trace, log_volume = np.sum(gradient**2, axis=(-2, -1)), np.log(np.maximum(np.linalg.det(gradient), 1e-12))
        log_thickness = _thickening(mu, lame, log_volume) if stress else np.zeros_like(log_volume)
        log_volume = log_volume + log_thickness
        return 0.5 * mu * (trace + np.exp(2.0 * log_thickness) - 3.0 - 2.0 * log_volume) + 0.5 * lame * log_volume**2
    if stress:
        lame = 2.0 * lame * mu / (lame + 2.0 * mu)
    identity = np.eye(2)
    if parameters.formulation == "stvk":
        strain = 0.5 * (np.swapaxes(gradient, -1, -2) @ gradient - identity)
    else:
        strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2)) - identity
    return mu * np.sum(strain**2, axis=(-2, -1)) + 0.5 * lame * np.trace(strain, axis1=-2, axis2=-1) ** 2


def density_at_nodes(parameters: SoftDiscsScene, mesh: Mesh, shape: np.ndarray) -> np.ndarray:
    """Energy density [J/m^3] at every node (..., n) of places `shape` (..., n, 2) [m]: mean of the elements there."""
    slopes = slopes_on_square(mesh.order, lobatto(mesh.order)[0])
    undeformed = parameters.disc.radius * np.stack([mesh.across[:-1], mesh.height[:-1]], axis=1)
    to_reference = np.linalg.inv(np.einsum("ena,qnb->eqab", undeformed[mesh.elements], slopes))
    jacobian = np.einsum("...ena,qnb->...eqab", shape[..., mesh.elements, :], slopes, optimize=True)
    density = energy_density(parameters, jacobian @ to_reference)
    numbers = mesh.elements.ravel()
    joined = sparse.csr_array(
        (np.ones(len(numbers)), (numbers, np.arange(len(numbers)))), (shape.shape[-2], len(numbers))
    )
    count = np.bincount(numbers, minlength=shape.shape[-2])
    total = joined @ density.reshape(-1, len(numbers)).T
    return (total / count[:, None]).T.reshape(shape.shape[:-1])


def _thickening(mu, lame, log_area):
    """Logarithm g of the stretch through the thickness without stress there: mu (e^2g - 1) + lambda (g + grown) = 0."""
    ratio = max(lame / mu, LEAST_SHARE)
    argument = 2.0 / ratio - 2.0 * log_area
    return 0.5 * (argument - wrightomega(argument - np.log(0.5 * ratio)))


def triangles_of(mesh: Mesh) -> np.ndarray:
    """Two triangles (t, 3) for each cell between neighbouring nodes of an element."""
    size = mesh.order + 1
    grid = mesh.elements.reshape(-1, size, size)
    a, b, c, d = grid[:, :-1, :-1], grid[:, :-1, 1:], grid[:, 1:, 1:], grid[:, 1:, :-1]
    return np.concatenate(
        [np.stack([corner.ravel() for corner in corners], axis=1) for corners in ((a, b, c), (a, c, d))]
    )


def edges_of(mesh: Mesh) -> list[np.ndarray]:
    """Nodes (e, order + 1) along each of the four sides of every element."""
    size = mesh.order + 1
    grid = mesh.elements.reshape(-1, size, size)
    return [grid[:, 0], grid[:, -1], grid[:, :, 0], grid[:, :, -1]]
