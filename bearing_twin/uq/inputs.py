"""Uncertain inputs: any numeric value of a scene as a distribution, by its parameters or by what is known of it.

In a study an input is a number (no doubt), `{distribution: gamma, mean: .., std: ..}` with a name of DISTRIBUTIONS and
one of its forms, or `{know: {positive: true, mean: .., mean_log: ..}}`, see `knowledge`. All values are SI.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.special import ndtr, ndtri

from bearing_twin.errors import StudyError
from bearing_twin.parameters import echo, read_number, unknown
from bearing_twin.units import NO_LIMITS, Limits
from bearing_twin.uq.distributions import DISTRIBUTIONS, LIMITS, EmpiricalValues
from bearing_twin.uq.knowledge import greatest_entropy
from bearing_twin.uq.tabulated import quantiles

LEAST_UNIT, GREATEST_UNIT = 2.0**-54, 1.0 - 2.0**-53  # inside which unit coordinates are kept


@dataclass(frozen=True)
class Input:
    """One uncertain value of a scene: `key` = where in the scene, and its distribution; values in SI.

    `ppf`, `cdf` and `pdf` take numbers or arrays. `pdf` of fixed and empirical inputs raises StatisticError.
    """

    key: str
    distribution_name: str
    parameters: Mapping
    distribution: object = field(compare=False, repr=False)
    stated: str = "parameters"

    def ppf(self, u):
        """Quantile at probability u in (0, 1)."""
        return self._inside(self.distribution.ppf(u))

    def sampled(self, u):
        """Quantiles (n,) at probabilities (n,) in (0, 1), from a table where it is quicker: to `tabulated.MOST`."""
        return self._inside((self._table or self.distribution.ppf)(u))

    @cached_property
    def _table(self):
        return quantiles(self.distribution_name, self.distribution)

    def isf(self, u):
        """Quantile at probability 1 - u, with all digits for small u."""
        return self._inside(self.distribution.isf(u))

    def at_score(self, z):
        """Quantile at the normal score z, that is at probability Phi(z), with all digits on both tails to |z| = 37."""
        z = np.asarray(z, float)
        return np.piecewise(ndtr(-np.abs(z)), [z < 0.0], [self.ppf, self.isf])

    def cdf(self, x):
        """Probability of a value not above x."""
        return self.distribution.cdf(x)

    def pdf(self, x):
        """Probability density at x [1/unit of x]."""
        return self.distribution.pdf(x)

    @property
    def mean(self) -> float:
        return float(self.distribution.mean())

    @property
    def std(self) -> float:
        return float(self.distribution.std())

    @property
    def low(self) -> float:
        """Lower end of the support, -inf where there is none."""
        return float(self.parameters.get("low", self.distribution.support()[0]))

    @property
    def high(self) -> float:
        """Upper end of the support, inf where there is none."""
        return float(self.parameters.get("high", self.distribution.support()[1]))

    @property
    def has_density(self) -> bool:
        return not isinstance(self.distribution, EmpiricalValues)

    def _inside(self, x):
        """Without the rounding by which SciPy's location and scale may step over a bound."""
        return np.clip(x, self.low, self.high) if "low" in self.parameters or "high" in self.parameters else x

    def describe(self) -> str:
        """One sentence: name, parameters, mean and deviation, and whether greatest entropy chose the distribution."""
        if self.distribution_name == "fixed":
            return f"{self.key}: fixed at {self.mean:g}"
        told = {name: value for name, value in self.parameters.items() if name != "values"}
        words = (
            ", ".join(f"{name} {value:g}" for name, value in told.items()) or f"{len(self.distribution.values)} values"
        )
        name = self.distribution_name.replace("_", " ")
        why = " (greatest entropy for what is known)" if self.stated == "knowledge" else ""
        return f"{self.key}: {name} with {words}; mean {self.mean:g}, deviation {self.std:g}{why}"


def read_input(key: str, mapping) -> Input:
    """The input at `key` of a scene from what a study says of it: a number, a named distribution or knowledge.

    Raises StudyError: one sentence that names the key, what is wrong and what is legal.
    """
    if not isinstance(mapping, Mapping):
        mapping = {"distribution": "fixed", "value": mapping}
    try:
        stated = "knowledge" if "know" in mapping else "parameters"
        name, parameters = _from_knowledge(mapping) if stated == "knowledge" else _from_parameters(mapping)
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            one = Input(key, name, parameters, DISTRIBUTIONS[name].build(**parameters), stated)
            if not np.isfinite([one.mean, one.std]).all():
                raise FloatingPointError
        return one
    except (StudyError, ValueError) as error:
        raise StudyError(f"input {key}: {error}") from None
    except ArithmeticError:
        raise StudyError(f"input {key}: numbers too far apart to compute with; give others") from None


def _from_knowledge(mapping):
    rest = [word for word in mapping if word != "know"]
    if rest:
        raise ValueError(f"{echo(rest[0])} does not go with know; the distribution follows from what is known alone")
    if not isinstance(mapping["know"], Mapping):
        raise ValueError(f"know must hold keys and values, not {echo(mapping['know'])}")
    known = mapping["know"].items()
    return greatest_entropy({name: one if name == "positive" else _number(name, one, NO_LIMITS) for name, one in known})


def _from_parameters(mapping):
    if "distribution" not in mapping:
        raise ValueError(f"say distribution: with its parameters, or know: with facts; {unknown('', DISTRIBUTIONS)}")
    name = mapping["distribution"]
    if not isinstance(name, str) or name not in DISTRIBUTIONS:
        raise ValueError(f"{echo(name)} is no distribution; {unknown(name, DISTRIBUTIONS)}")
    row = DISTRIBUTIONS[name]
    given = {word: value for word, value in mapping.items() if word != "distribution"}
    wrong = [word for word in given if word not in row.parameters]
    if wrong:
        raise ValueError(f"{echo(wrong[0])} is no parameter of {name}; {unknown(wrong[0], row.parameters)}")
    if not any(set(form) == set(given) for form in row.forms):
        forms = " or ".join(", ".join(form) for form in row.forms)
        raise ValueError(f"{name} takes {forms}, not {', '.join(given) or 'nothing'}")
    if "values" in given:
        return name, {"values": _numbers("values", given["values"])}
    return name, {word: _number(word, value, LIMITS.get(word, NO_LIMITS)) for word, value in given.items()}


def _number(name, given, limits):
    value, problem = read_number(given, "", limits)
    if problem:
        raise ValueError(f"{name} = {echo(given)} {problem}")
    return value


def _numbers(name, given):
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise ValueError(f"{name} = {echo(given)} must be a list of numbers")
    values = tuple(_number(name, float(one) if isinstance(one, np.generic) else one, NO_LIMITS) for one in given)
    if not values:
        raise ValueError(f"{name} must hold one number at least")
    return values


class Joint:
    """Several inputs together: independent, or bound by a Gaussian copula.

    `correlation` is a (d, d) matrix in the order of the inputs, or a mapping (key, key) -> rho with the rest 0. It is
    the correlation of the normal scores z = Phi^-1(F(x)) of the inputs; the rank correlation of two inputs is
    (6/pi) asin(rho/2), their plain correlation depends on the distributions. Raises StudyError unless the matrix is
    symmetric with ones on the diagonal and positive definite.
    """

    def __init__(self, inputs: Iterable[Input], correlation=None):
        self.inputs = tuple(inputs)
        self.keys = tuple(one.key for one in self.inputs)
        twice = {key for key in self.keys if self.keys.count(key) > 1}
        if twice:
            raise StudyError(f"input {min(twice)} is given twice")
        self.correlation = _correlation_matrix(self.keys, correlation)
        self._root = None
        if np.any(self.correlation != np.eye(self.dimension)):
            self._root = _cholesky(self.correlation)

    @property
    def dimension(self) -> int:
        return len(self.inputs)

    @property
    def independent(self) -> bool:
        return self._root is None

    def values(self, unit):
        """Values (n, d) of the inputs [SI] at points (n, d) of the unit cube; independent coordinates in.

        With a copula the coordinates are normal scores that the Cholesky factor mixes, so the first input takes its
        own coordinate, the second the first two, and so on.
        """
        unit = np.asarray(unit, float)
        if unit.ndim != 2 or unit.shape[1] != self.dimension:
            raise ValueError(f"unit points of shape (n, {self.dimension}) are needed, not {unit.shape}")
        if self._root is not None:
            unit = np.clip(ndtr(ndtri(unit) @ self._root.T), LEAST_UNIT, GREATEST_UNIT)
        columns = [one.sampled(unit[:, index]) for index, one in enumerate(self.inputs)]
        return np.stack(columns, axis=1) if columns else np.empty(unit.shape)


def _correlation_matrix(keys, correlation):
    size = len(keys)
    if correlation is None:
        return np.eye(size)
    if not isinstance(correlation, Mapping):
        matrix = np.asarray(correlation, float)
        if matrix.shape != (size, size) or np.any(matrix != matrix.T) or np.any(np.diag(matrix) != 1.0):
            raise StudyError(f"the correlation must be a symmetric {size} by {size} matrix with ones on its diagonal")
        return matrix
    matrix = np.eye(size)
    for pair, given in correlation.items():
        if not isinstance(pair, tuple) or len(pair) != 2 or pair[0] == pair[1]:
            raise StudyError(f"a correlation is between two different inputs, not {echo(pair)}")
        for key in pair:
            if key not in keys:
                raise StudyError(f"correlation: {echo(key)} is no input; {unknown(key, keys)}")
        value, problem = read_number(given, "", Limits(above=-1.0, below=1.0))
        if problem:
            raise StudyError(f"correlation of {pair[0]} and {pair[1]} = {echo(given)} {problem}")
        one, other = keys.index(pair[0]), keys.index(pair[1])
        matrix[one, other] = matrix[other, one] = value
    return matrix


def _cholesky(matrix):
    if not np.isfinite(matrix).all():
        raise StudyError("the correlation must be finite")
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < 1e-12:
        raise StudyError(
            f"the correlation is not positive definite (least eigenvalue {least:.3g}): "
            "no inputs can be correlated like that; bring the values nearer to 0"
        )
    return np.linalg.cholesky(matrix)
