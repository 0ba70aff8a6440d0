"""A law in use: what kernels are handed, and the functions made from the table `laws.LAWS` that they call.

A kernel knows a law by its row's place among those of point contacts; `chosen` is the only branch on it.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel, plain
from bearing_twin.contact import differential
from bearing_twin.contact.differential import Shape
from bearing_twin.contact.dispatch import chosen
from bearing_twin.contact.laws import LAWS, Place

STENCIL = 1e-4  # tuned: of the shape, for the slope of a law's coefficient: off by its square
NO_SHAPE = Shape(0.0, 0.0, 0.0)


_POINT = [row for row in LAWS.values() if row.fits == "point"]
_STATES = [row.state or differential.NOTHING for row in _POINT]
_coefficient = chosen([row.coefficient for row in _POINT])
_begin = chosen([state.begin for state in _STATES])
_rates = chosen([state.rates for state in _STATES])
_finish = chosen([state.finish for state in _STATES])


class Elasticity(NamedTuple):
    """A law of a point contact in use, as few numbers as kernels can do with: each costs time at every call.

    `number` is its place in the table, `modulus` E* [Pa], `given` the number that constant, linear and measured laws
    are given.
    """

    number: int
    power: float
    modulus: float
    given: float

    def numbers(self) -> tuple[float, ...]:
        """The same as the core reads it."""
        return _POINT[self.number].number_in_core, self.power, self.modulus, self.given


def elasticity(name: str, modulus: float, given: float) -> Elasticity:
    """The law of that name for a point contact; `given` as in `Elasticity`."""
    row = LAWS[name]
    return Elasticity(_POINT.index(row), row.power, float(modulus), float(given))


def carrier_of(law: Elasticity) -> differential.Carrier | None:
    """What a law does with states it carries; None where it carries none."""
    return _POINT[law.number].state


_FOLLOWS = np.array([row.follows for row in _POINT])
_CARRIES = np.array([row.state is not None for row in _POINT])


@plain
@inlined
def follows(law):
    """True if a law's coefficient follows the curvatures."""
    return _FOLLOWS[law.number]


@plain
@inlined
def carries(law):
    """True if a law carries states."""
    return _CARRIES[law.number]


@kernel
def coefficient_at(law, curvature_small, curvature_large, shape):
    """c [N/m^power] of a law (`Elasticity`) where the gap has these curvatures and the states carried are `shape`."""
    return _coefficient(law.number, Place(curvature_small, curvature_large, law.modulus, law.given, shape))


@plain
@kernel
def fresh_coefficient(law, curvature_small, curvature_large):
    """c [N/m^power] of a law (`Elasticity`), its states, if any, solved afresh."""
    return coefficient_at(law, curvature_small, curvature_large, state_begun(law, curvature_small, curvature_large))


def coefficient_of(name: str, curvature_small, curvature_large, modulus, given=0.0) -> float:
    """c [N/m^power] of the law of that name, its states, if any, solved afresh."""
    return fresh_coefficient(elasticity(name, modulus, given), curvature_small, curvature_large)


def sphere_coefficient(name: str, modulus, radius, given=0.0):
    """c [N/m^power] of a law between spheres of radius [m] R1 R2/(R1 + R2); arrays broadcast."""
    row = LAWS[name]
    if not row.follows:
        return given
    circle = coefficient_of(name, 0.5, 0.5, 1.0) if row.circle is None else row.circle
    return circle * modulus * np.sqrt(radius)


@kernel
def state_begun(law, curvature_small, curvature_large):
    """The states that a law carries, at a new contact; zeros where it carries none."""
    return _begin(law.number, curvature_small, curvature_large)


@kernel
def state_rates(law, shape, ratio_rate):
    """Rates of the states when P/Q changes at `ratio_rate` [1/s]."""
    return _rates(law.number, shape, ratio_rate)


@kernel
def state_finished(law, shape, ratio):
    """The states at the end of a step, where P/Q is `ratio`: put right, if the law does so."""
    return _finish(law.number, shape, ratio)


@inlined
def _of_shape(law, shape):
    """Coefficient for sqrt(PQ) = 1/m, E* = 1 Pa and (P + Q)/2 = `shape`/m: even in ln(Q/P), hence smooth."""
    root = shape + math.sqrt(max(shape * shape - 1.0, 0.0))
    return _coefficient(law.number, Place(1.0 / root, root, 1.0, 1.0, NO_SHAPE))


@kernel
def log_slope(law, low, carried_shape, coefficient):
    """d ln(c)/d(shape) of a law at constant sqrt(PQ), at a `surfaces.LowestPoint`; by differences without a state."""
    if carries(law):
        return differential.log_slope(carried_shape, low.curvature_small, low.shape_excess, law.modulus, coefficient)
    if not follows(law):
        return 0.0
    step = STENCIL * low.shape
    if low.shape - step < 1.0:
        here = _of_shape(law, low.shape)
        ahead, beyond = _of_shape(law, low.shape + step), _of_shape(law, low.shape + 2.0 * step)
        return (4.0 * ahead - 3.0 * here - beyond) / (2.0 * step * here)
    below, above = _of_shape(law, low.shape - step), _of_shape(law, low.shape + step)
    return (above - below) / (step * (above + below))
