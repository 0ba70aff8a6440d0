"""Polynomial chaos: a smooth quantity of one to four inputs as a polynomial in independent germs.

D. Xiu and G. E. Karniadakis, The Wiener-Askey polynomial chaos, SIAM J. Sci. Comput. 24 (2002). Uniform and truncated
exponential inputs take a uniform germ and Legendre polynomials, all others their normal score and Hermite polynomials;
with a copula all germs are normal. Coefficients are projections by the tensor Gauss rule of degree + 1 points a germ,
kept up to a total degree; mean, deviation and Sobol indices are read off them. The error is measured on points that
had no part in the fit. It falls exponentially with the degree for smooth quantities; kinks and jumps spoil that, and
the measured error says so.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import hermite_e, legendre
from scipy.special import ndtr, ndtri

from bearing_twin.errors import StudyError
from bearing_twin.uq.inputs import Joint
from bearing_twin.uq.sampling import UnitPoints

MOST_INPUTS = 4
GREATEST_DEGREE = 12
MOST_RUNS = 5000
VALIDATION = 128
UNIFORM_GERMS = ("uniform", "truncated_exponential")


@dataclass(frozen=True)
class Chaos:
    """An expansion: `degrees` (terms, inputs) of its polynomials, `coefficients` (terms,) in the unit of the quantity.

    `error` is the root mean square of its error on fresh random points over the deviation of the quantity there;
    `runs` counts all evaluations, these included.
    """

    joint: Joint
    degree: int
    degrees: np.ndarray
    coefficients: np.ndarray
    error: float
    runs: int

    @property
    def mean(self) -> float:
        return float(self.coefficients[0])

    @property
    def std(self) -> float:
        return float(np.sqrt(np.sum(self.coefficients[1:] ** 2)))

    @property
    def first(self):
        """First-order Sobol indices (inputs,): the share of the variance that an input explains alone."""
        used = self.degrees > 0
        return np.array([self._share(used[:, one] & (used.sum(axis=1) == 1)) for one in range(used.shape[1])])

    @property
    def total(self):
        """Total Sobol indices (inputs,): the share of the variance in which an input takes part."""
        return np.array([self._share(column > 0) for column in self.degrees.T])

    def predict(self, unit):
        """The quantity (n,) by the expansion at points (n, inputs) of the unit cube."""
        return _basis(_kinds(self.joint), self.degrees, _germs(self.joint, unit)) @ self.coefficients

    def _share(self, terms):
        if not self.joint.independent:
            raise StudyError("Sobol indices are for independent inputs; leave the correlation out")
        variance = np.sum(self.coefficients[1:] ** 2)
        return float(np.sum(self.coefficients[terms] ** 2) / variance) if variance > 0.0 else 0.0


def expand(joint: Joint, function, degree=None, tolerance=1e-4, seed=0) -> Chaos:
    """The expansion of a quantity; `function` takes values (n, d) of the inputs in SI and returns (n,).

    With `degree` None it is raised until the error is below `tolerance` or the next would take more than MOST_RUNS
    runs; then `error` tells what was reached. Raises StudyError for no or more than four uncertain inputs, empirical
    inputs, or a quantity that is not finite where it is needed.
    """
    kinds = _kinds(joint)
    points = UnitPoints("random", joint.dimension, seed, VALIDATION)
    fresh = points.chunk(0, VALIDATION)
    truth = _run(joint, function, fresh)
    runs = VALIDATION
    for one in [degree] if degree is not None else range(1, GREATEST_DEGREE + 1):
        degrees = _degrees(kinds, one)
        nodes, weights = _gauss(kinds, one + 1)
        values = _run(joint, function, _unit(kinds, nodes))
        runs += len(values)
        coefficients = _basis(kinds, degrees, nodes).T @ (weights * values)
        found = Chaos(joint, one, degrees, coefficients, 0.0, runs)
        spread = float(np.std(truth))
        miss = float(np.sqrt(np.mean((found.predict(fresh) - truth) ** 2)))
        error = miss / spread if spread > 0.0 else miss
        found = Chaos(joint, one, degrees, coefficients, error, runs)
        if error < tolerance or (one + 2) ** sum(kind != "none" for kind in kinds) + runs > MOST_RUNS:
            break
    return found


def _kinds(joint):
    """legendre, hermite or none (a fixed input) for every input."""
    wrong = [one.key for one in joint.inputs if one.distribution_name == "empirical"]
    if wrong:
        raise StudyError(f"{wrong[0]} is empirical: polynomial chaos needs a density; choose the method ensemble")
    kinds = []
    for one in joint.inputs:
        uniform = one.distribution_name in UNIFORM_GERMS and joint.independent
        kinds.append("none" if one.distribution_name == "fixed" else "legendre" if uniform else "hermite")
    uncertain = sum(kind != "none" for kind in kinds)
    if not 1 <= uncertain <= MOST_INPUTS:
        raise StudyError(
            f"polynomial chaos takes 1 to {MOST_INPUTS} uncertain inputs, not {uncertain}; choose the method ensemble"
        )
    return tuple(kinds)


def _degrees(kinds, degree):
    """All degrees (terms, inputs) with a sum up to `degree`, the constant first; 0 for fixed inputs."""
    ranges = [range(degree + 1) if kind != "none" else range(1) for kind in kinds]
    every = [one for one in itertools.product(*ranges) if sum(one) <= degree]
    return np.array(sorted(every, key=lambda one: (sum(one), one)))


def _gauss(kinds, count):
    """Nodes (n, inputs) in the germs and weights (n,), whose sum is 1, of the tensor Gauss rule."""
    rules = []
    for kind in kinds:
        if kind == "none":
            rules.append((np.zeros(1), np.ones(1)))
        else:
            node, weight = legendre.leggauss(count) if kind == "legendre" else hermite_e.hermegauss(count)
            rules.append((node, weight / weight.sum()))
    nodes = np.stack([one.ravel() for one in np.meshgrid(*(node for node, _ in rules), indexing="ij")], axis=1)
    weights = np.prod(np.meshgrid(*(weight for _, weight in rules), indexing="ij"), axis=0).ravel()
    return nodes, weights


def _basis(kinds, degrees, germs):
    """Polynomials (n, terms), orthonormal in the germs: He_k/sqrt(k!), P_k sqrt(2k + 1)."""
    greatest = int(degrees.max())
    orders = np.arange(greatest + 1)
    product = np.ones((len(germs), len(degrees)))
    for index, kind in enumerate(kinds):
        if kind == "legendre":
            table = legendre.legvander(germs[:, index], greatest) * np.sqrt(2.0 * orders + 1.0)
        elif kind == "hermite":
            factorials = np.array([math.factorial(order) for order in orders], float)
            table = hermite_e.hermevander(germs[:, index], greatest) / np.sqrt(factorials)
        else:
            continue
        product *= table[:, degrees[:, index]]
    return product


def _germs(joint, unit):
    """Germs (n, inputs) of points of the unit cube; `_unit` is the way back."""
    unit = np.asarray(unit, float)
    return np.stack([_germ(kind, unit[:, index]) for index, kind in enumerate(_kinds(joint))], axis=1)


def _germ(kind, unit):
    if kind == "none":
        return np.zeros_like(unit)
    return 2.0 * unit - 1.0 if kind == "legendre" else ndtri(unit)


def _unit(kinds, germs):
    columns = [0.5 * (germs[:, i] + 1.0) if kind != "hermite" else ndtr(germs[:, i]) for i, kind in enumerate(kinds)]
    return np.stack(columns, axis=1)


def _run(joint, function, unit):
    values = joint.values(unit)
    result = np.asarray(function(values), float)
    if not np.isfinite(result).all():
        where = values[~np.isfinite(result)][0]
        at = ", ".join(f"{key} = {value:g}" for key, value in zip(joint.keys, where, strict=True))
        raise StudyError(f"the quantity is not finite at {at}: choose the method ensemble, or narrow the inputs")
    return result
