"""Friction in the contact plane, at a point or over an elliptic spot that slides and spins: one table, one row a model.

On a spot with Hertz's pressure each point slides with v + omega x r, so spin weakens the friction force and sliding
weakens the drilling torque (Contensou, Erismann). The usual closed forms have the right limits and miss a third of the
force or most of the torque in between; `bearing_twin chart friction` shows all against `reference.spot`.

To add a model, write its function and give it a row in `_ROWS`; `friction_of` is the one entry to all.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.dispatch import chosen
from bearing_twin.contact.ellipse import elliptic_b_d
from bearing_twin.contact.spot_rules import NO_RULE, POINTS, RULES, Rule, blended_over_spot
from bearing_twin.numerics.rotation import root_and_inverse

COARSE_ERROR, MEDIUM_ERROR, FINE_ERROR = 0.08, 0.025, 0.009  # tuned: greatest errors of the rules of points
PADE1_ERROR, PADE2_ERROR = 0.95, 0.8  # tuned: the same of the closed forms
"""Greatest errors for b/a >= 0.1 without smoothing, whatever the motion: of mu N for the force, of pure spin's
3/8 a mu N E for the torque (`bearing_twin chart friction`). Of a quadrature where the pole of the motion lies on one of
its rings; of the closed forms where sliding and spin are alike."""

POINT, QUADRATURE, PADE1, PADE2 = range(4)  # FrictionModel of core/contact/patch_friction.hpp
_COARSE, _MEDIUM, _FINE = (tuple(RULES[name]) for name in ("coarse", "medium", "fine"))


class Rubbing(NamedTuple):
    """Friction on the slipping body, along the ellipse's axes [N], and about the spot's normal [N m]."""

    force_major: float
    force_minor: float
    torque: float


@inlined
def friction_factor(normal_load, slip_x, slip_y, slip_z, coefficient, regularisation):
    """f [N s/m] of the regularised Coulomb friction force -f * slip on the slipping body.

    f = mu N / sqrt(|slip|^2 + regularisation^2): the force grows linearly with slip, reaches 71 % of mu N at
    slip = `regularisation` [m/s], and mu N far above it. Smooth everywhere; true sticking creeps.
    """
    square = slip_x * slip_x + slip_y * slip_y + slip_z * slip_z + regularisation * regularisation
    return coefficient * normal_load * root_and_inverse(square)[1]


@inlined
def point_friction(normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation):
    """Friction by the slip at the contact point alone; the spot's size and its spin do not matter."""
    factor = friction_factor(normal_load, slip_major, slip_minor, 0.0, coefficient, regularisation)
    return Rubbing(-factor * slip_major, -factor * slip_minor, 0.0)


@inlined
def _by_rule(rule, normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation):
    """Friction over the ellipse by a rule of points, for slip [m/s] at its centre and spin [rad/s] about its normal.

    -mu p u/sqrt(u^2 + v_s^2) summed over Hertz's pressure p, u = v + spin x r, v_s = `regularisation` [m/s], which
    for spin = 0 is `friction_factor`.
    """
    motion = slip_major, slip_minor, spin
    along, across, moment = blended_over_spot(*rule, semi_major, semi_minor, *motion, regularisation)
    limit = -coefficient * normal_load
    return Rubbing(limit * along, limit * across, limit * moment)


@kernel
def spot_friction(normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation):
    """Friction over the ellipse by 96 points at most, and by 12 where as exact; COARSE_ERROR says how far off at worst.

    For slip [m/s] along its axes and spin [rad/s] about its normal; `regularisation` [m/s].
    """
    motion = slip_major, slip_minor, spin
    return _by_rule(_COARSE, normal_load, semi_major, semi_minor, *motion, coefficient, regularisation)


@kernel
def spot_friction_medium(
    normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation
):
    """As `spot_friction` by 384 points at most; MEDIUM_ERROR says how far off at worst."""
    motion = slip_major, slip_minor, spin
    return _by_rule(_MEDIUM, normal_load, semi_major, semi_minor, *motion, coefficient, regularisation)


@kernel
def spot_friction_fine(normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation):
    """As `spot_friction` by 2304 points at most; FINE_ERROR says how far off at worst."""
    motion = slip_major, slip_minor, spin
    return _by_rule(_FINE, normal_load, semi_major, semi_minor, *motion, coefficient, regularisation)


@inlined
def _limits(semi_major, semi_minor, slip_major, slip_minor):
    """What closed forms share: b/a, B, D, pure spin's torque over a, share of slip along a, its <r^2> over a^2."""
    ratio = semi_minor / semi_major if semi_major > 0.0 else 1.0  # no spot, no limits: whatever is finite
    b, d = elliptic_b_d(ratio)
    share = slip_major * slip_major / max(slip_major * slip_major + slip_minor * slip_minor, 1e-300)
    return ratio, b, d, 0.375 * (b + ratio * ratio * d), share, 0.2 * (share + ratio * ratio * (1.0 - share))


@kernel
def spot_friction_pade1(normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation):
    """As `spot_friction` in closed form by quotients of first degree (Zhuravlev 1998, for circles).

    Force mu N v/(v + a omega/g) and torque mu N a/(1/M + v/(e a omega)), right to first order where either motion
    vanishes: g = 3/2 D(m) along the major axis and 3/2 B(m) along the minor, M = 3/8 E(m), e = <r^2>/a^2 along the
    slip. In between 34 % of mu N off on a circle, 40 % and nearly all of the torque on a raceway's ellipse.
    """
    _, b, d, pure, _, width = _limits(semi_major, semi_minor, slip_major, slip_minor)
    turning = max(abs(spin) * semi_major, 1e-300)
    speed = math.sqrt(slip_major * slip_major + slip_minor * slip_minor + regularisation * regularisation)
    limit = -coefficient * normal_load
    return Rubbing(
        limit * slip_major / (speed + turning / (1.5 * d)),
        limit * slip_minor / (speed + turning / (1.5 * b)),
        limit * semi_major * math.copysign(turning / (turning / pure + speed / width), spin),
    )


@inlined
def _quotient(x, end, slope, bend):
    """end x (x + c)/(x (x + c) + bend): end (1 - bend/x^2) far out, slope x near zero."""
    shifted = x * (x + slope * bend / end)
    return end * shifted / (shifted + bend)


@kernel
def spot_friction_pade2(normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation):
    """The same by quotients of second degree (Kireenkov 2008), right to second order where one motion vanishes.

    In between 22 % of mu N off on a circle, 76 % on a raceway's ellipse. Needs a regularisation or a slip above zero.
    """
    ratio, b, d, pure, share, width = _limits(semi_major, semi_minor, slip_major, slip_minor)
    speed = math.sqrt(slip_major * slip_major + slip_minor * slip_minor + regularisation * regularisation)
    x = speed / max(abs(spin) * semi_major, 1e-9 * speed)
    along, across = _quotient(x, 1.0, 1.5 * d, 0.1), _quotient(x, 1.0, 1.5 * b, 0.1 * ratio * ratio)
    torque = _quotient(1.0 / x, pure, width, 0.75 * (share * d + (1.0 - share) * b) / pure)
    limit = -coefficient * normal_load
    return Rubbing(
        limit * along * slip_major / speed,
        limit * across * slip_minor / speed,
        limit * semi_major * math.copysign(torque, spin),
    )


@dataclass(frozen=True)
class FrictionModel:
    """One friction model; `name`, `help` and `needs` are written as literals, by keyword (`contact.names`).

    `rubbing` takes what `spot_friction` takes. `needs` "ellipse" says that the spot and its spin matter. `error`: how
    far off at worst for b/a >= 0.1, of mu N for the force or of pure spin's torque. `rule`: of a model that is a sum
    over points, which a bearing does side by side.
    """

    name: str
    help: str
    needs: tuple[str, ...]
    number_in_core: int
    rubbing: Callable
    error: float = 0.0
    rule: Rule = NO_RULE

    @property
    def over_spot(self) -> bool:
        """True if the spot and its spin matter."""
        return "ellipse" in self.needs


_ROWS = (
    FrictionModel(
        name="point",
        help="by the slip at the contact point; spin meets no resistance",
        needs=(),
        number_in_core=POINT,
        rubbing=point_friction,
    ),
    FrictionModel(
        name="spot",
        help="over the spot that slides and spins, by 6 x 16 points, or 12 where its rim is slow by its spin",
        needs=("ellipse",),
        number_in_core=QUADRATURE,
        rubbing=spot_friction,
        error=COARSE_ERROR,
        rule=RULES["coarse"],
    ),
    FrictionModel(
        name="spot_medium",
        help="the same by 12 x 32 points, 4 times as many, or 12 where its rim is slower still",
        needs=("ellipse",),
        number_in_core=QUADRATURE,
        rubbing=spot_friction_medium,
        error=MEDIUM_ERROR,
        rule=RULES["medium"],
    ),
    FrictionModel(
        name="spot_fine",
        help="the same by 24 x 96 points, 24 times as many, or 12 where its rim is slower still",
        needs=("ellipse",),
        number_in_core=QUADRATURE,
        rubbing=spot_friction_fine,
        error=FINE_ERROR,
        rule=RULES["fine"],
    ),
    FrictionModel(
        name="pade1",
        help="over the spot in closed form by quotients of first degree (Zhuravlev): rough where sliding meets spin",
        needs=("ellipse",),
        number_in_core=PADE1,
        rubbing=spot_friction_pade1,
        error=PADE1_ERROR,
    ),
    FrictionModel(
        name="pade2",
        help="the same by quotients of second degree (Kireenkov)",
        needs=("ellipse",),
        number_in_core=PADE2,
        rubbing=spot_friction_pade2,
        error=PADE2_ERROR,
    ),
)
FRICTIONS = {row.name: row for row in _ROWS}
"""Every friction model by name, in order; kernels know one by its place."""

_rubbing = chosen([row.rubbing for row in _ROWS])


def roughness(friction: FrictionModel) -> list[str]:
    """A warning of a model that is further off than the quadrature of scenes, or none."""
    if friction.error <= COARSE_ERROR:
        return []
    return [
        f"the friction {friction.name} is up to {100.0 * friction.error:.2g} % off where sliding and spin are alike; "
        "spot is closer"
    ]


def friction_number(name: str) -> int:
    """The place of a friction model in the table, which `friction_of` chooses by."""
    return list(FRICTIONS).index(name)


def patch_numbers(name: str, coefficient: float) -> tuple[np.ndarray, np.ndarray]:
    """The numbers (5,) of a model with this coefficient of friction as the core reads them, and its points (n, 3)."""
    row = FRICTIONS[name]
    points = np.ascontiguousarray(POINTS[row.rule.first : row.rule.end])
    return np.array([row.number_in_core, coefficient, row.rule.easy, row.rule.hard, len(points)], float), points


@kernel
def friction_of(number, normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation):
    """Friction by the model of that number, for slip [m/s] along the spot's axes and spin [rad/s] about its normal."""
    return _rubbing(
        number, normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, regularisation
    )
