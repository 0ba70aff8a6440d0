"""The numbers of a scene by key path, such as `geometry.radial_clearance` or `drive.offset[1]`: what may be uncertain.

A path is split into words; a whole number is the place in a tuple or a list. Values are put into the plain data of a
scene (one realisation, read and checked like any scene) or into its dataclass (arrays, for closed forms).
"""

import dataclasses
import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy import stats
from scipy.special import ndtr, ndtri

from bearing_twin.base.errors import StudyError
from bearing_twin.base.parameters import Parameter, describe, echo, element_at, legal_hint, read_number
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
)


@functools.cache
def numeric_keys(kind: str) -> dict[str, Parameter]:
    """Every number of a kind of scene by its key path; tuples and lists give one key a place."""
    return _numbers_of(KINDS[kind].parameters)


def _numbers_of(cls: type) -> dict[str, Parameter]:
    found = {}
    for row in describe(cls):
        if row.type in ("number", "integer"):
            found[row.key] = row
        elif row.type.endswith(" numbers"):
            found |= {f"{row.key}[{place}]": row for place in range(len(row.default))}
        elif row.type == "list":
            element, most = element_at(cls, row.key.split("."))
            inner = _numbers_of(element)
            found |= {f"{row.key}.{place}.{key}": inner[key] for place in range(most) for key in inner}
    return found


def quantities_of(kind: str) -> dict[str, Quantity]:
    """Every quantity of a kind of scene."""
    return KINDS[kind].quantities_of()


def quantity_of(kind: str, name) -> Quantity:
    """The row of a quantity; raises StudyError with the nearest legal name."""
    known = quantities_of(kind)
    if name not in known:
        raise StudyError(f"{echo(name)} is no quantity of a scene of kind {kind}; {legal_hint(name, known)}")
    return known[name]


def first_name(key):
    """A key by its first name, as `wanted.tolerance` for `solver.tolerance`, also before further words."""
    for other, first in ALIASES.items() if isinstance(key, str) else ():
        if key == other or key.startswith(f"{other}."):
            return first + key.removeprefix(other)
    return key


def checked_key(kind: str, key) -> str:
    """The first name of the key, if it is a number of that kind of scene; raises StudyError with the nearest one."""
    known, first = numeric_keys(kind), first_name(key)
    if isinstance(first, str) and first in known:
        return first
    ends = [one for one in known if first in one.rpartition(".")[2].split("_")]
    hint = f"did you mean {' or '.join(ends[:3])}?" if ends else legal_hint(key, known)
    raise StudyError(f"{echo(key)} is no number of a scene of kind {kind}; {hint}")


def words_of(key: str) -> tuple[str | int, ...]:
    """`drive.offset[1]` as ("drive", "offset", 1), `defects.0.spall.length` as ("defects", 0, "spall", "length")."""
    words = key.replace("[", ".").replace("]", "").split(".")
    return tuple(int(word) if word.isdigit() else word for word in words)


def put(mapping: dict, key: str, value) -> dict:
    """A copy of a scene's plain data, shared but for the changed path, with the value at that key.

    Raises StudyError for a place beyond the end of a list.
    """
    try:
        return _put(mapping, words_of(key), value)
    except IndexError:
        raise StudyError(f"{key} is beyond the end of the scene's list, counted from 0; give the scene more") from None


def placed(scene: dict, targets, values) -> dict:
    """A scene's plain data with one value for each group of keys."""
    for keys, value in zip(targets, values, strict=True):
        for key in keys:
            scene = put(scene, key, float(value))
    return scene


def replaced(parameters, key: str, value):
    """A scene's dataclass with the value (a number or an array) at that key; nothing is checked."""
    return _replaced(parameters, words_of(key), value)


def value_at(mapping, key: str):
    """The value in a scene's plain data at that key."""
    for word in words_of(key):
        mapping = mapping[word]
    return mapping


def _put(holder, words, value):
    if not words:
        return value
    changed = holder.copy()
    changed[words[0]] = _put(holder[words[0]], words[1:], value)
    return changed


def _replaced(holder, words, value):
    if not words:
        return value
    if isinstance(holder, tuple):
        place = words[0]
        return (*holder[:place], _replaced(holder[place], words[1:], value), *holder[place + 1 :])
    return dataclasses.replace(holder, **{words[0]: _replaced(getattr(holder, words[0]), words[1:], value)})


# Uncertain inputs: any numeric value of a scene as a distribution, by its parameters or by what is known of it.
#
# In a study an input is a number (certain), `{distribution: gamma, mean: .., std: ..}` with a name of DISTRIBUTIONS
# and one of its forms, or `{know: {positive: true, mean: .., mean_log: ..}}`, see `knowledge`. All values are SI.

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
    def whole(self) -> bool:
        """True where every value is a whole number."""
        values = getattr(self.distribution, "values", None)
        return not self.has_density if values is None else bool(np.all(values == np.round(values)))

    def outside(self, low: float, high: float) -> float:
        """Probability of a value below `low` or above `high`."""
        return float(self.distribution.cdf(low) + self.distribution.sf(high))

    def _inside(self, x):
        """Without the rounding by which SciPy's location and scale may step over a bound."""
        return np.clip(x, self.low, self.high) if "low" in self.parameters or "high" in self.parameters else x

    def _end(self, word: str, place: int) -> float:
        found = self.distribution.support()[place]
        return float(found if self.distribution_name.startswith(SCIPY) else self.parameters.get(word, found))

    def describe(self) -> str:
        """One sentence: name, parameters, mean and deviation, and whether greatest entropy chose the distribution."""
        if self.distribution_name == "fixed":
            return f"{self.key}: fixed at {self.mean:g}"
        words = ", ".join(
            f"{len(value)} {name}" if name in LISTS else f"{name} {value:g}" for name, value in self.parameters.items()
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
            build = DISTRIBUTIONS[name].build if name in DISTRIBUTIONS else partial(of_scipy, name.removeprefix(SCIPY))
            one = Input(key, name, parameters, build(**parameters), stated)
            if name.startswith(SCIPY) and not np.isfinite([one.mean, one.std]).all():
                raise StudyError(f"{name} with these parameters has no finite mean and deviation; give another one")
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
        raise StudyError(f"{echo(rest[0])} does not go with know; the distribution follows from what is known alone")
    if not isinstance(mapping["know"], Mapping):
        raise StudyError(f"know must hold keys and values, not {echo(mapping['know'])}")
    known = mapping["know"].items()
    return greatest_entropy({name: one if name == "positive" else _number(name, one, NO_LIMITS) for name, one in known})


def _from_parameters(mapping):
    if "distribution" not in mapping:
        raise StudyError(
            f"give distribution: with its parameters, or know: with facts; {legal_hint('', DISTRIBUTIONS)}"
        )
    name = mapping["distribution"]
    given = {word: value for word, value in mapping.items() if word != "distribution"}
    if isinstance(name, str) and name.startswith(SCIPY):
        return name, {str(word): _number(word, value, NO_LIMITS) for word, value in given.items()}
    if not isinstance(name, str) or name not in DISTRIBUTIONS:
        raise StudyError(f"{echo(name)} is no distribution; {legal_hint(name, DISTRIBUTIONS)}")
    row = DISTRIBUTIONS[name]
    wrong = [word for word in given if word not in row.parameters]
    if wrong:
        raise StudyError(f"{echo(wrong[0])} is no parameter of {name}; {legal_hint(wrong[0], row.parameters)}")
    if not any(set(form) == set(given) for form in row.forms):
        forms = " or ".join(", ".join(form) for form in row.forms)
        raise StudyError(f"{name} takes {forms}, not {', '.join(given) or 'nothing'}")
    return name, {
        word: _numbers(word, value) if word in LISTS else _number(word, value, LIMITS.get(word, NO_LIMITS))
        for word, value in given.items()
    }


def _number(name, given, limits):
    value, problem = read_number(given, "", limits)
    if problem:
        raise StudyError(f"{name} = {echo(given)} {problem}")
    return value


def _numbers(name, given):
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise StudyError(f"{name} = {echo(given)} must be a list of numbers")
    values = tuple(_number(name, float(one) if isinstance(one, np.generic) else one, NO_LIMITS) for one in given)
    if not values:
        raise StudyError(f"{name} must hold one number at least")
    return values


class Joint:
    """Several inputs together: independent, or bound by a Gaussian copula.

    `correlation` holds (key, key, rho), the rest being 0: the correlation of the normal scores z = Phi^-1(F(x)) of two
    inputs. Their rank correlation is (6/pi) asin(rho/2), their plain correlation depends on the distributions. Raises
    StudyError unless the matrix is positive definite.
    """

    def __init__(self, inputs: Iterable[Input], correlation: Iterable[tuple[str, str, float]] = ()):
        self.inputs = tuple(inputs)
        self.keys = tuple(one.key for one in self.inputs)
        matrix = _correlation_matrix(self.keys, correlation)
        self._root = _cholesky(matrix) if np.any(matrix != np.eye(self.dimension)) else None

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
        if self._root is not None:
            unit = np.clip(ndtr(ndtri(unit) @ self._root.T), LEAST_UNIT, GREATEST_UNIT)
        columns = [one.ppf(unit[:, index]) for index, one in enumerate(self.inputs)]
        return np.stack(columns, axis=1) if columns else np.empty(unit.shape)


def _correlation_matrix(keys, pairs):
    matrix, given_already = np.eye(len(keys)), set()
    for one, other, given in pairs:
        if one == other:
            raise StudyError(f"a correlation is between two different inputs, not {echo(one)} and itself")
        for key in (one, other):
            if key not in keys:
                raise StudyError(f"correlation: {echo(key)} is no input; {legal_hint(key, keys)}")
        value, problem = read_number(given, "", Limits(above=-1.0, below=1.0))
        if problem:
            raise StudyError(f"correlation of {one} and {other} = {echo(given)} {problem}")
        if {one, other} in given_already:
            raise StudyError(f"the correlation of {one} and {other} is given twice; keep one of them")
        given_already.add(frozenset((one, other)))
        places = keys.index(one), keys.index(other)
        matrix[places] = matrix[places[::-1]] = value
    return matrix


def _cholesky(matrix):
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < 1e-12:
        raise StudyError(
            f"the correlation is not positive definite (least eigenvalue {least:.3g}): "
            "no inputs can be correlated like that; bring the values nearer to 0"
        )
    return np.linalg.cholesky(matrix)
