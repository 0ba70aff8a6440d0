"""The numbers of a scene by key path, such as `geometry.radial_clearance` or `drive.offset[1]`: these may be uncertain.

A whole number in a path is an index of a tuple or a list. Values are put into the plain data of a scene (one
realisation, read and checked like any scene) or into its dataclass (arrays, for closed forms).
"""

import dataclasses
import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy import stats
from scipy.special import ndtr, ndtri

from bearing_twin.base.errors import StudyError, echo, legal_hint
from bearing_twin.base.parameters import Parameter, describe, element_at, read_number
from bearing_twin.base.units import NO_LIMITS, Limits
from bearing_twin.kinds import KINDS
from bearing_twin.kinds.contract import Quantity
from bearing_twin.kinds.sections import ALIASES
from bearing_twin.uq.distributions import (
    DISTRIBUTIONS,
    LIMITS,
    LISTS,
    SCIPY,
    DiscreteValues,
    greatest_entropy,
    of_scipy,
    require,
)


@functools.cache
def numeric_keys(kind: str) -> dict[str, Parameter]:
    """Every number of a kind of scene by its key path; tuples and lists have one key an index."""
    return _numbers_of(KINDS[kind].parameters)


def _numbers_of(cls: type) -> dict[str, Parameter]:
    numbers = {}
    for row in describe(cls):
        if row.type in ("number", "integer"):
            numbers[row.key] = row
        elif row.type.endswith(" numbers"):
            numbers |= {f"{row.key}[{index}]": row for index in range(len(row.default))}
        elif row.type == "list":
            element, greatest_length = element_at(cls, row.key.split("."))
            inner = _numbers_of(element)
            numbers |= {f"{row.key}.{index}.{key}": inner[key] for index in range(greatest_length) for key in inner}
    return numbers


def quantities_of(kind: str) -> dict[str, Quantity]:
    """Every quantity of a kind of scene."""
    return KINDS[kind].quantities_of()


def quantity_of(kind: str, name) -> Quantity:
    """The row of a quantity; raises StudyError with the nearest legal name."""
    known = quantities_of(kind)
    if name not in known:
        raise StudyError(f"{echo(name)} is no quantity of a scene of kind {kind}; {legal_hint(name, known)}")
    return known[name]


def present_name(key):
    """A key by its present name, as `wanted.tolerance` for `solver.tolerance`, also before further words."""
    for former, present in ALIASES.items() if isinstance(key, str) else ():
        if key == former or key.startswith(f"{former}."):
            return present + key.removeprefix(former)
    return key


def checked_key(kind: str, key) -> str:
    """The present name of the key of a number of that kind of scene; raises StudyError with the nearest one."""
    known, name = numeric_keys(kind), present_name(key)
    if isinstance(name, str) and name in known:
        return name
    similar = [legal for legal in known if name in legal.rpartition(".")[2].split("_")]
    hint = f"did you mean {' or '.join(similar[:3])}?" if similar else legal_hint(key, known)
    raise StudyError(f"{echo(key)} is no number of a scene of kind {kind}; {hint}")


def path_of(key: str) -> tuple[str | int, ...]:
    """`drive.offset[1]` as ("drive", "offset", 1), `defects.0.spall.length` as ("defects", 0, "spall", "length")."""
    path = key.replace("[", ".").replace("]", "").split(".")
    return tuple(int(step) if step.isdigit() else step for step in path)


def put(scene, key: str, value):
    """A copy of a scene's plain data or of its dataclass, shared but for the changed path, with the value at that key.

    The value may be an array; nothing is checked. Raises StudyError for an index beyond the end of a list.
    """
    try:
        return _put(scene, path_of(key), value)
    except IndexError:
        raise StudyError(f"{key} is beyond the end of the scene's list, counted from 0; give the scene more") from None


def _put(holder, path, value):
    if not path:
        return value
    step, further = path[0], path[1:]
    if dataclasses.is_dataclass(holder):
        return dataclasses.replace(holder, **{step: _put(getattr(holder, step), further, value)})
    changed = list(holder) if isinstance(holder, tuple) else holder.copy()
    changed[step] = _put(holder[step], further, value)
    return tuple(changed) if isinstance(holder, tuple) else changed


def with_inputs(scene: dict, targets, values) -> dict:
    """A scene's plain data with one value for each group of keys."""
    for keys, value in zip(targets, values, strict=True):
        for key in keys:
            scene = put(scene, key, float(value))
    return scene


def value_at(scene, key: str):
    """The value in a scene's plain data at that key."""
    for step in path_of(key):
        scene = scene[step]
    return scene


# Uncertain inputs: any numeric value of a scene as a distribution, by its parameters or by what is known of it.
#
# In a study an input is a number (certain), `{distribution: gamma, mean: .., std: ..}` with a name of DISTRIBUTIONS
# and one of its forms, or `{know: {positive: true, mean: .., mean_log: ..}}`, see `greatest_entropy`. Values are SI.

LEAST_UNIT, GREATEST_UNIT = 2.0**-54, 1.0 - 2.0**-53  # limits of unit coordinates


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
        return self._end("low", 0)

    @property
    def high(self) -> float:
        """Upper end of the support, inf where there is none."""
        return self._end("high", 1)

    @property
    def has_density(self) -> bool:
        discrete = isinstance(getattr(self.distribution, "dist", None), stats.rv_discrete)
        return not (discrete or isinstance(self.distribution, DiscreteValues))

    @property
    def is_whole(self) -> bool:
        """True where every value is a whole number."""
        values = getattr(self.distribution, "values", None)
        return not self.has_density if values is None else bool(np.all(values == np.round(values)))

    def outside(self, low: float, high: float) -> float:
        """Probability of a value below `low` or above `high`."""
        return float(self.distribution.cdf(low) + self.distribution.sf(high))

    def _inside(self, x):
        """x clipped to the bounds, which the rounding of SciPy's location and scale may exceed."""
        return np.clip(x, self.low, self.high) if "low" in self.parameters or "high" in self.parameters else x

    def _end(self, name: str, index: int) -> float:
        end = self.distribution.support()[index]
        return float(end if self.distribution_name.startswith(SCIPY) else self.parameters.get(name, end))

    def describe(self) -> str:
        """One sentence: name, parameters, mean and deviation, and whether greatest entropy chose the distribution."""
        if self.distribution_name == "fixed":
            return f"{self.key}: fixed at {self.mean:g}"
        parameters = ", ".join(
            f"{len(value)} {name}" if name in LISTS else f"{name} {value:g}" for name, value in self.parameters.items()
        )
        name = self.distribution_name.replace("_", " ")
        why = " (greatest entropy for what is known)" if self.stated == "knowledge" else ""
        return f"{self.key}: {name} with {parameters}; mean {self.mean:g}, deviation {self.std:g}{why}"


def read_input(key: str, mapping) -> Input:
    """The input at `key` of a scene from its specification in a study: a number, a named distribution or knowledge.

    Raises StudyError: one sentence that names the key, what is wrong and what is legal.
    """
    if not isinstance(mapping, Mapping):
        mapping = {"distribution": "fixed", "value": mapping}
    try:
        stated = "knowledge" if "know" in mapping else "parameters"
        name, parameters = _from_knowledge(mapping) if stated == "knowledge" else _from_parameters(mapping)
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            build = DISTRIBUTIONS[name].build if name in DISTRIBUTIONS else partial(of_scipy, name.removeprefix(SCIPY))
            source = Input(key, name, parameters, build(**parameters), stated)
            if not np.isfinite([source.mean, source.std]).all():
                reason = f"{name} with these parameters has no finite mean and deviation; give another one"
                require(not name.startswith(SCIPY), reason)
                raise FloatingPointError
        return source
    except (StudyError, ValueError) as error:
        raise StudyError(f"input {key}: {error}") from None
    except ArithmeticError:
        raise StudyError(f"input {key}: numbers too far apart to compute with; give others") from None


def _from_knowledge(mapping):
    for key in mapping:
        require(key == "know", f"{echo(key)} does not go with know; the distribution follows from what is known alone")
    facts = mapping["know"]
    require(isinstance(facts, Mapping), f"know must hold keys and values, not {echo(facts)}")
    return greatest_entropy({name: fact if name == "positive" else _number(name, fact) for name, fact in facts.items()})


def _from_parameters(mapping):
    require(
        "distribution" in mapping,
        f"give distribution: with its parameters, or know: with facts; {legal_hint('', DISTRIBUTIONS)}",
    )
    name = mapping["distribution"]
    parameters = {key: value for key, value in mapping.items() if key != "distribution"}
    if isinstance(name, str) and name.startswith(SCIPY):
        return name, {str(key): _number(key, value) for key, value in parameters.items()}
    if not isinstance(name, str) or name not in DISTRIBUTIONS:
        raise StudyError(f"{echo(name)} is no distribution; {legal_hint(name, DISTRIBUTIONS)}")
    row = DISTRIBUTIONS[name]
    for key in parameters:
        require(key in row.parameters, f"{echo(key)} is no parameter of {name}; {legal_hint(key, row.parameters)}")
    forms = " or ".join(", ".join(form) for form in row.forms)
    require(
        any(set(form) == set(parameters) for form in row.forms),
        f"{name} takes {forms}, not {', '.join(parameters) or 'nothing'}",
    )
    return name, {
        key: _numbers(key, value) if key in LISTS else _number(key, value, LIMITS.get(key, NO_LIMITS))
        for key, value in parameters.items()
    }


def _number(name, value, limits=NO_LIMITS):
    number, problem = read_number(value, "", limits)
    require(not problem, f"{name} = {echo(value)} {problem}")
    return number


def _numbers(name, values):
    require(
        isinstance(values, Iterable) and not isinstance(values, str),
        f"{name} = {echo(values)} must be a list of numbers",
    )
    numbers = tuple(_number(name, float(value) if isinstance(value, np.generic) else value) for value in values)
    require(numbers, f"{name} must hold one number at least")
    return numbers


class Joint:
    """Several inputs together: independent, or bound by a Gaussian copula.

    `correlation` holds (key, key, rho), the rest being 0: the correlation of the normal scores z = Phi^-1(F(x)) of two
    inputs. Their rank correlation is (6/pi) asin(rho/2), their plain correlation depends on the distributions. Raises
    StudyError unless the matrix is positive definite.
    """

    def __init__(self, inputs: Iterable[Input], correlation: Iterable[tuple[str, str, float]] = ()):
        self.inputs = tuple(inputs)
        self.keys = tuple(source.key for source in self.inputs)
        matrix = _correlation_matrix(self.keys, correlation)
        self._cholesky_factor = _cholesky(matrix) if np.any(matrix != np.eye(self.dimension)) else None

    @property
    def dimension(self) -> int:
        return len(self.inputs)

    @property
    def independent(self) -> bool:
        return self._cholesky_factor is None

    @property
    def uncertain(self) -> list[int]:
        """The indices of the inputs that take more than one value."""
        return [index for index, source in enumerate(self.inputs) if source.low < source.high]

    def values(self, unit):
        """Values (n, d) of the inputs [SI] at points (n, d) of the unit cube; independent coordinates in.

        With a copula the coordinates are normal scores that the Cholesky factor mixes, so the first input takes its
        coordinate, the second the first two, and so on.
        """
        if self._cholesky_factor is not None:
            unit = np.clip(ndtr(ndtri(unit) @ self._cholesky_factor.T), LEAST_UNIT, GREATEST_UNIT)
        columns = [source.ppf(unit[:, index]) for index, source in enumerate(self.inputs)]
        return np.stack(columns, axis=1) if columns else np.empty(unit.shape)


def _correlation_matrix(keys, correlation):
    matrix, pairs = np.eye(len(keys)), set()
    for first, second, value in correlation:
        require(first != second, f"a correlation is between two different inputs, not {echo(first)} and itself")
        for key in (first, second):
            require(key in keys, f"correlation: {echo(key)} is no input; {legal_hint(key, keys)}")
        pair = frozenset((first, second))
        rho = _number(f"correlation of {first} and {second}", value, Limits(above=-1.0, below=1.0))
        require(pair not in pairs, f"the correlation of {first} and {second} is given twice; keep one of them")
        pairs.add(pair)
        row, column = keys.index(first), keys.index(second)
        matrix[row, column] = matrix[column, row] = rho
    return matrix


def _cholesky(matrix):
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < 1e-12:
        raise StudyError(
            f"the correlation is not positive definite (least eigenvalue {least:.3g}): "
            "no inputs can be correlated like that; bring the values nearer to 0"
        )
    return np.linalg.cholesky(matrix)
