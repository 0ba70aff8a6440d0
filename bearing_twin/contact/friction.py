"""Friction in the contact plane, at a point or over an elliptic patch that slides and spins: one row a model.

On a patch with Hertz's pressure each point slides with v + omega x r, so spin weakens the friction force and sliding
weakens the spin friction moment (Contensou, Erismann). The usual closed forms have the right limits and miss a third of
the force or most of the torque in between; `bearing_twin chart friction` shows all against
`reference.patch_friction_exact`. The formulas are the core's (`core/contact/friction.hpp`).

A quadrature sums friction over points of the unit disc with their shares of the pressure. Where a patch's rim is slow
by its spin against sqrt(slip^2 + regularisation^2), friction is nearly a polynomial of the place, and twelve points are
as exact as those of a `Rule`. Between its `easy` and `hard` both are blended smoothly, so that steps see no jump.

To add a model, write its formula in the core and give it a row in `_ROWS`. `patch_by` gives one that computes.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function

if TYPE_CHECKING:  # imported where it computes: lists and help begin sooner without it
    import numpy as np

COARSE_ERROR, MEDIUM_ERROR, FINE_ERROR = 0.08, 0.025, 0.009  # tuned: greatest errors of the rules of points
PADE1_ERROR, PADE2_ERROR = 0.95, 0.8  # tuned: the same of the closed forms
"""Greatest errors for b/a >= 0.1 without smoothing, whatever the motion: of mu N for the force, of pure spin's
3/8 a mu N E for the torque (`bearing_twin chart friction`). Of a quadrature where the pole of the motion lies on one of
its rings; of the closed forms where sliding and spin are alike."""

FORMULAS = ("point", "quadrature", "pade1", "pade2")
"""Formulas of the rows: FrictionModel of the core."""

AUTO, POINT = "auto", "point"  # of contact.friction: to be chosen, and without a patch


class Rule(NamedTuple):
    """A rule of points: so many rings and spokes, and where it takes over from twelve points.

    `easy` and `hard` are of the rim's speed by spin, squared, over slip^2 + regularisation^2: up to `easy` twelve
    points are used, with errors of 8e-7 of mu N, 4e-9 and 1e-11, from `hard` on all.
    """

    rings: int
    spokes: int
    easy: float
    hard: float


NO_RULE = Rule(0, 0, 0.0, 1.0)  # of models that are no sums over points
COARSE = Rule(6, 16, 0.16, 0.25)  # tuned: errors of the friction table
MEDIUM = Rule(12, 32, 0.04, 0.0625)  # tuned: the same
FINE = Rule(24, 96, 0.0064, 0.01)  # tuned: the same


@dataclass(frozen=True)
class FrictionModel:
    """One friction model.

    `needs` "ellipse": the patch and its spin matter. `error`: the greatest for b/a >= 0.1, of mu N for the force or of
    pure spin's torque. `rule`: of a model that is a sum over points.
    """

    name: str
    help: str
    needs: tuple[str, ...]
    formula: str
    error: float = 0.0
    rule: Rule = NO_RULE

    @property
    def over_patch(self) -> bool:
        """True if the patch and its spin matter."""
        return "ellipse" in self.needs


_ROWS = (
    FrictionModel(
        name=POINT,
        help="by the slip at the contact point; spin meets no resistance",
        needs=(),
        formula="point",
    ),
    FrictionModel(
        name="spot",
        help="over the patch that slides and spins, by 6 x 16 points, or 12 where spin is slow against the slip",
        needs=("ellipse",),
        formula="quadrature",
        error=COARSE_ERROR,
        rule=COARSE,
    ),
    FrictionModel(
        name="spot_medium",
        help="the same by 12 x 32 points, 4 times as many, or 12 where it is slower still",
        needs=("ellipse",),
        formula="quadrature",
        error=MEDIUM_ERROR,
        rule=MEDIUM,
    ),
    FrictionModel(
        name="spot_fine",
        help="the same by 24 x 96 points, 24 times as many, or 12 where it is slower still",
        needs=("ellipse",),
        formula="quadrature",
        error=FINE_ERROR,
        rule=FINE,
    ),
    FrictionModel(
        name="pade1",
        help="over the patch in closed form by quotients of first degree (Zhuravlev): rough where sliding meets spin",
        needs=("ellipse",),
        formula="pade1",
        error=PADE1_ERROR,
    ),
    FrictionModel(
        name="pade2",
        help="the same by quotients of second degree (Kireenkov)",
        needs=("ellipse",),
        formula="pade2",
        error=PADE2_ERROR,
    ),
)
FRICTIONS = {row.name: row for row in _ROWS}
"""Every friction model by name, in order."""


PATCH_NAMES = {"patch": "spot", "patch_medium": "spot_medium", "patch_fine": "spot_fine"}
"""Words in which a scene may ask for friction over the contact patch, too."""


def friction_names() -> tuple[str, ...]:
    """Names of the friction models."""
    return tuple(FRICTIONS)


def roughness(friction: FrictionModel) -> list[str]:
    """A warning of a model that is further off than the quadrature of scenes, or none."""
    if friction.error <= COARSE_ERROR:
        return []
    return [
        f"the friction {friction.name} has an error of up to {100.0 * friction.error:.2g} % where sliding and spin are "
        "alike; that of patch is smaller"
    ]


_friction = Function("core_friction", None, (REALS, REALS, INTEGER, REALS, REAL, REALS_OUT))


class FrictionLoads(NamedTuple):
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
    import numpy as np

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
    ) -> FrictionLoads:
        """Friction for slip [m/s] along the patch's axes and spin [rad/s] about its normal; arrays broadcast.

        -mu p u/sqrt(u^2 + v_s^2) over Hertz's pressure p, u = v + spin x r, v_s = `regularisation` [m/s].
        """
        import numpy as np

        motion = np.broadcast_arrays(normal_load, semi_major, semi_minor, slip_major, slip_minor, spin)
        rows = np.ascontiguousarray(np.stack(motion, axis=-1), float)
        loads = np.empty((*motion[0].shape, 3))
        _friction(*self, motion[0].size, rows, float(regularisation), loads)
        return FrictionLoads(*(component[()] for component in np.moveaxis(loads, -1, 0)))


def patch_of(formula: str, coefficient: float, rule: Rule = NO_RULE) -> Patch:
    """A model by its formula, the coefficient of friction, and the rule of its points if it is a sum over such."""
    import numpy as np

    placed = points(rule.rings, rule.spokes)
    numbers = [FORMULAS.index(formula), coefficient, rule.easy, rule.hard, len(placed)]
    return Patch(np.array(numbers, float), placed)


def patch_by(name: str, coefficient: float) -> Patch:
    """The friction model of that name with this coefficient of friction."""
    return patch_of(FRICTIONS[name].formula, coefficient, FRICTIONS[name].rule)
