"""Two bodies as numbers and as a state, and how their opposing points are kept up with it (paper 1, eqs. 1-3)."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.contact.elasticity import Elasticity
from bearing_twin.numerics.rotation import rows_of_state
from bearing_twin.shapes.implicit import Surface
from bearing_twin.shapes.opposing import nearest_pair
from bearing_twin.shapes.tracking import MU, Body, equations, level_at, projected

SECOND, BODY = 13, 13
POSITION, QUATERNION, VELOCITY, MOMENTUM = 0, 3, 7, 10
"""Columns of a body's part of the state; the second body's begin at SECOND. A held body's momentum is its spin."""

VISCOUS, RUBBED, HELD_WORK, GROSS_WORK, LOAD_IMPULSE, RUB_IMPULSE, UNKNOWNS, CARRIED = 26, 27, 28, 29, 30, 31, 34, 42
MOVING, COLUMNS = 42, 46
"""Energies [J], impulses [N s], the unknowns of `tracking.equations`, and what a law carries: P/Q and three states."""

CLOSED, ALGEBRAIC, DIFFERENTIAL = range(3)
NEWTON = 25  # steps at most from the last step's opposing points
FLAT = 1e-9  # P/Q below which the gap has no ellipse that a law could take


class Rigid(NamedTuple):
    """One body: surface, mass (0 where it is held), its inverse, principal moments of inertia, their inverses."""

    surface: Surface
    mass: float
    inverse_mass: float
    inertia: tuple[float, float, float]
    inverse_inertia: tuple[float, float, float]
    reach: float


class Pair(NamedTuple):
    """The numbers of the equations; SI. The viscous terms and friction as in `ellipsoid.equations.Ellipsoid`.

    `sink` is A's share of the compliance, `size` [m] about the least radius, `over_lens` whether the law is `overlap`.
    """

    a: Rigid
    b: Rigid
    gravity: tuple[float, float, float]
    sink: float
    size: float
    tracking: int
    over_lens: bool
    law: Elasticity
    damping: float
    relaxation_time: float
    damping_ratio: float
    viscosity: float
    friction: float
    regularisation: float
    rubbing: int
    over_spot: bool


@kernel
def body_at(rigid, state, first):
    """The body (`tracking.Body`) in the state's columns from `first` on; the quaternion is taken at unit length."""
    turn = np.array(rows_of_state(state, first + QUATERNION))
    own = turn.T @ state[first + MOMENTUM : first + MOMENTUM + 3]
    for i in range(3):
        own[i] /= rigid.inertia[i]
    place, velocity = state[first : first + 3].copy(), state[first + VELOCITY : first + VELOCITY + 3].copy()
    return Body(rigid.surface, place, turn, velocity, turn @ own)


@kernel
def settled(a, b, unknowns):
    """Newton's method on equations (1) from opposing points nearby; False where it comes to no end."""
    size = 1e-3 + abs(unknowns[0]) + abs(unknowns[1]) + abs(unknowns[2])
    for _ in range(NEWTON):
        change = projected(a, b, unknowns) - unknowns
        unknowns += change
        if not np.all(np.isfinite(unknowns)):
            return False
        if math.sqrt(change[:6] @ change[:6]) < 1e-13 * size:
            return True
    return False


@kernel
def track(pair, a, b, unknowns):
    """Brings the unknowns (8,) up to the bodies' place as the pair's tracking says; differential ones are taken."""
    if pair.tracking == CLOSED:
        nearest_pair(a, b, unknowns)
    elif pair.tracking == ALGEBRAIC:
        settled(a, b, unknowns)


@kernel
def residual_of(a, b, unknowns):
    """How far [m] the unknowns are from meeting equations (1)."""
    residual, jacobian = np.empty(8), np.empty((8, 8))
    equations(a, b, unknowns, residual, jacobian)
    return math.sqrt(residual[3:] @ residual[3:])


@kernel
def approach_of(b, unknowns):
    """Approach [m] of opposing points."""
    gradient, hesse = np.empty(3), np.empty((3, 3))
    level_at(b, unknowns[3:6].copy(), gradient, hesse)
    return -unknowns[MU] * math.sqrt(gradient @ gradient)
