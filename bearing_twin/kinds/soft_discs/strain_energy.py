"""Strain energy of a deformed disc over its mesh, for whoever looks at it: independent of the compiled core."""

import numpy as np
from scipy import sparse

from bearing_twin.kinds.soft_discs.derived import capped_ratio
from bearing_twin.kinds.soft_discs.mesh import Mesh, lobatto, slopes_on_square
from bearing_twin.kinds.soft_discs.parameters import SoftDiscsScene

HALVINGS = 60  # of the bracket around the stretch through the thickness


def energy_density(parameters: SoftDiscsScene, gradient: np.ndarray) -> np.ndarray:
    """Strain energy per undeformed volume [J/m^3] of deformation gradients (..., 2, 2) by the scene's formulation."""
    material, ratio = parameters.disc.material, capped_ratio(parameters)
    mu = 0.5 * material.young_modulus / (1.0 + ratio)
    lame = material.young_modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio))
    stress = parameters.plane == "stress"
    if parameters.formulation == "neo_hookean":
        trace, grown = np.sum(gradient**2, axis=(-2, -1)), np.log(np.maximum(np.linalg.det(gradient), 1e-12))
        thick = _thickening(mu, lame, grown) if stress else np.zeros_like(grown)
        grown = grown + thick
        return 0.5 * mu * (trace + np.exp(2.0 * thick) - 3.0 - 2.0 * grown) + 0.5 * lame * grown**2
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
    by_place = slopes_on_square(mesh.order, lobatto(mesh.order)[0])
    rest = parameters.disc.radius * np.stack([mesh.x[:-1], mesh.y[:-1]], axis=1)
    before = np.linalg.inv(np.einsum("ena,qnb->eqab", rest[mesh.elements], by_place))
    after = np.einsum("...ena,qnb->...eqab", shape[..., mesh.elements, :], by_place, optimize=True)
    density = energy_density(parameters, after @ before)
    numbers = mesh.elements.ravel()
    joined = sparse.csr_array(
        (np.ones(len(numbers)), (numbers, np.arange(len(numbers)))), (shape.shape[-2], len(numbers))
    )
    count = np.bincount(numbers, minlength=shape.shape[-2])
    total = joined @ density.reshape(-1, len(numbers)).T
    return (total / count[:, None]).T.reshape(shape.shape[:-1])


def _thickening(mu, lame, grown):
    """Logarithm of the stretch through the thickness at which no stress acts there, by halving."""
    low, high = np.full_like(grown, -10.0), np.full_like(grown, 10.0)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        above = mu * (np.exp(2.0 * middle) - 1.0) + lame * (middle + grown) > 0.0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)


def triangles_of(mesh: Mesh) -> np.ndarray:
    """Two triangles (t, 3) for each cell between neighbouring nodes of an element."""
    size = mesh.order + 1
    grid = mesh.elements.reshape(-1, size, size)
    a, b, c, d = grid[:, :-1, :-1], grid[:, :-1, 1:], grid[:, 1:, 1:], grid[:, 1:, :-1]
    return np.concatenate([np.stack([one.ravel() for one in three], axis=1) for three in ((a, b, c), (a, c, d))])


def edges_of(mesh: Mesh) -> list[np.ndarray]:
    """Nodes (e, order + 1) along each of the four sides of every element."""
    size = mesh.order + 1
    grid = mesh.elements.reshape(-1, size, size)
    return [grid[:, 0], grid[:, -1], grid[:, :, 0], grid[:, :, -1]]
