"""The friction models of `friction.FRICTIONS` in use: their points, and forces by the core."""

import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.friction import FORMULAS, FRICTIONS, NO_RULE, Rule
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function

_friction = Function("core_friction", None, (REALS, REALS, INTEGER, REALS, REAL, REALS_OUT))


class Rubbing(NamedTuple):
    """Friction on the slipping body, along the ellipse's axes [N], and about the patch's normal [N m]."""

    force_major: float
    force_minor: float
    torque: float


@functools.cache
def points(count: int, spokes: int) -> np.ndarray:
    """Points (count * spokes, 3) of a quadrature over the unit disc: x, y and share of the pressure.

    Rings by Gauss in t, rho = sin(t): both the pressure's edge, 3/2 sqrt(1 - rho^2), and the kink at the centre of a
    spinning patch are smooth in it.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count) if count else (np.empty(0), np.empty(0))
    angle = 0.25 * math.pi * (nodes + 1.0)
    shares = weights * np.cos(angle) ** 2 * np.sin(angle)
    shares = np.repeat(shares / shares.sum() / max(spokes, 1), spokes)
    turns = np.tile(2.0 * math.pi * (np.arange(spokes) + 0.5) / max(spokes, 1), count)
    radii = np.repeat(np.sin(angle), spokes)
    return np.column_stack([radii * np.cos(turns), radii * np.sin(turns), shares])


class Patch(NamedTuple):
    """A friction model in use as the core reads it: the numbers (5,) of PatchFriction, and its points (n, 3)."""

    numbers: np.ndarray
    points: np.ndarray

    def friction(
        self, normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, regularisation: float
    ) -> Rubbing:
        """Friction for slip [m/s] along the patch's axes and spin [rad/s] about its normal; arrays broadcast.

        -mu p u/sqrt(u^2 + v_s^2) over Hertz's pressure p, u = v + spin x r, v_s = `regularisation` [m/s].
        """
        motion = np.broadcast_arrays(normal_load, semi_major, semi_minor, slip_major, slip_minor, spin)
        rows = np.ascontiguousarray(np.stack(motion, axis=-1), float)
        found = np.empty((*motion[0].shape, 3))
        _friction(*self, motion[0].size, rows, float(regularisation), found)
        return Rubbing(*(one[()] for one in np.moveaxis(found, -1, 0)))


def patch_of(formula: str, coefficient: float, rule: Rule = NO_RULE) -> Patch:
    """A model by its formula, the coefficient of friction, and the rule of its points if it is a sum over such."""
    placed = points(rule.rings, rule.spokes)
    numbers = [FORMULAS.index(formula), coefficient, rule.easy, rule.hard, len(placed)]
    return Patch(np.array(numbers, float), placed)


def patch_by(name: str, coefficient: float) -> Patch:
    """The friction model of that name with this coefficient of friction."""
    return patch_of(FRICTIONS[name].formula, coefficient, FRICTIONS[name].rule)
