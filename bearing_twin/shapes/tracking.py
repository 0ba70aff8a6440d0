"""The opposing points of two implicit surfaces: found by Newton's method, or followed by their differential equations.

Paper 1, section 2. The eight unknowns are the point P_A on body A, P_B on body B (fixed axes), and the multipliers
lambda and mu of

    grad g_A(P_A) = lambda grad g_B(P_B),   P_A - P_B = mu grad g_B(P_B),   g_A(P_A) = 0,   g_B(P_B) = 0       (1)

with gradients outward, so lambda < 0 where the surfaces face each other; mu > 0 is a gap, mu < 0 contact. The system
has many more roots (far sides, saddles of the distance); `contact_of` recognises and refuses them.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.compiled import kernel
from bearing_twin.shapes.implicit import Surface, level

LAMBDA, MU = 6, 7
CIRCULAR = 1e-9  # (Q - P)/(Q + P) below which the direction of the ellipse is noise
FOUND, FAR_SIDE, SADDLE, NO_ELLIPSE = range(4)
REFUSALS = {
    FAR_SIDE: "lies on a far side: the surfaces do not face each other there",
    SADDLE: "is a saddle of the distance, not its least value",
    NO_ELLIPSE: "is no contact in an ellipse: the surfaces conform, cross or are flat there",
}


class Body(NamedTuple):
    """A surface in motion: position [m] (3,), rotation (3, 3) from body to fixed axes, velocity, angular velocity."""

    surface: Surface
    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


class Opposition(NamedTuple):
    """Where two bodies face each other: points [m], normal outward of A, approach [m] > 0 in contact, the gap's form.

    The gap is z = P x^2 + Q y^2 (paper 1, eq. 6), P = `curvature_small` <= Q [1/m], x along `major_axis` (3,);
    `circular` says that P = Q and the axis is arbitrary.
    """

    point_a: np.ndarray
    point_b: np.ndarray
    normal: np.ndarray
    approach: float
    curvature_small: float
    curvature_large: float
    major_axis: np.ndarray
    circular: bool


def body(surface: Surface, position=(0, 0, 0), rotation=None, velocity=(0, 0, 0), spin=(0, 0, 0)) -> Body:
    """A `Body` from plain sequences; without a rotation its axes are the fixed ones."""
    turn = np.eye(3) if rotation is None else rotation
    return Body(surface, *(np.array(one, dtype=float) for one in (position, turn, velocity, spin)))


@kernel
def level_at(one, point, gradient, hesse):
    """g = f(T^T (r - r_0)) [m] of a body at a point in fixed axes; writes its gradient and Hesse matrix there."""
    value = level(one.surface, one.rotation.T @ (point - one.position), gradient, hesse)
    gradient[:] = one.rotation @ gradient
    hesse[:] = one.rotation @ hesse @ one.rotation.T
    return value


@kernel
def equations(a, b, unknowns, residual, jacobian):
    """Residual (8,) of the equations (1) and its derivative (8, 8) by the unknowns."""
    gradient_a, gradient_b, hesse_a, hesse_b = np.empty(3), np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    point_a, point_b = unknowns[:3].copy(), unknowns[3:6].copy()
    factor, share = unknowns[LAMBDA], unknowns[MU]
    residual[6] = level_at(a, point_a, gradient_a, hesse_a)
    residual[7] = level_at(b, point_b, gradient_b, hesse_b)
    residual[:3] = gradient_a - factor * gradient_b
    residual[3:6] = point_a - point_b - share * gradient_b
    jacobian[:] = 0.0
    jacobian[:3, :3] = hesse_a
    jacobian[:3, 3:6] = -factor * hesse_b
    jacobian[:3, LAMBDA] = -gradient_b
    jacobian[3:6, 3:6] = -share * hesse_b
    for i in range(3):
        jacobian[3 + i, i] = 1.0
        jacobian[3 + i, 3 + i] -= 1.0
    jacobian[3:6, MU] = -gradient_b
    jacobian[6, :3] = gradient_a
    jacobian[7, 3:6] = gradient_b


@kernel
def projected(a, b, unknowns):
    """One Newton step on equations (1): what a step of the differential form is followed by."""
    residual, jacobian = np.empty(8), np.empty((8, 8))
    equations(a, b, unknowns, residual, jacobian)
    return unknowns - np.linalg.solve(jacobian, residual)


@kernel
def opposing_rates(a, b, unknowns):
    """Time derivative (8,) of the unknowns, from paper 1, eqs. (2)-(3), for the bodies' velocities and spins.

    Equations (3) are (1) differentiated: with v_P the velocity of the body's material at P, the surface carries its
    gradient along as d(grad g)/dt = omega x grad g + Hess g (u_P - v_P).
    """
    residual, jacobian = np.empty(8), np.empty((8, 8))
    equations(a, b, unknowns, residual, jacobian)
    gradient_a, gradient_b, hesse_a, hesse_b = np.empty(3), np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    point_a, point_b = unknowns[:3].copy(), unknowns[3:6].copy()
    level_at(a, point_a, gradient_a, hesse_a)
    level_at(b, point_b, gradient_b, hesse_b)
    material_a = a.velocity + np.cross(a.spin, point_a - a.position)
    material_b = b.velocity + np.cross(b.spin, point_b - b.position)
    carried_a = np.cross(a.spin, gradient_a) - hesse_a @ material_a
    carried_b = np.cross(b.spin, gradient_b) - hesse_b @ material_b
    right = np.empty(8)
    right[:3] = unknowns[LAMBDA] * carried_b - carried_a
    right[3:6] = unknowns[MU] * carried_b
    right[6] = gradient_a @ material_a
    right[7] = gradient_b @ material_b
    return np.linalg.solve(jacobian, right)


@kernel
def frame_spin(a, unknowns, rates):
    """Angular velocity [rad/s] (3,) of the contact frame whose third axis is A's normal: Omega = gamma x d(gamma)/dt.

    Paper 1, section 2: the frame does not turn about its normal; d(alpha)/dt = Omega x alpha carries its first axis.
    """
    gradient, hesse = np.empty(3), np.empty((3, 3))
    point = unknowns[:3].copy()
    level_at(a, point, gradient, hesse)
    material = a.velocity + np.cross(a.spin, point - a.position)
    change = np.cross(a.spin, gradient) + hesse @ (rates[:3] - material)
    length = math.sqrt(gradient @ gradient)
    normal = gradient / length
    return np.cross(normal, (change - (normal @ change) * normal) / length)


@kernel
def tangent_axes(normal):
    """Two unit vectors as rows (2, 3) that complete the unit vector `normal` to a right-handed frame."""
    axes = np.zeros((2, 3))
    least = np.argmin(np.abs(normal))
    axes[0, least] = 1.0
    axes[0] -= normal[least] * normal
    axes[0] /= math.sqrt(axes[0] @ axes[0])
    axes[1] = np.cross(normal, axes[0])
    return axes


@kernel
def second_form(one, point, axes):
    """Curvature tensor (2, 2) [1/m] of a body's surface in tangent axes (2, 3), positive where the body bulges.

    Of the two fundamental forms the first is the unit matrix in orthonormal axes, the second Hess g/|grad g|; the
    surface is z = -(k_xx x^2 + 2 k_xy x y + k_yy y^2)/2 along its outward normal (paper 1, eq. 4).
    """
    gradient, hesse = np.empty(3), np.empty((3, 3))
    level_at(one, point, gradient, hesse)
    return axes @ hesse @ axes.T / math.sqrt(gradient @ gradient)


@kernel
def classify(form_a, form_b, distance, factor):
    """FOUND, or what is wrong with a root of (1): curvature tensors (2, 2), distance -approach [m], and lambda.

    A contact's gap has the form (K_A + K_B)/2, eqs. (4)-(5), which must be positive definite. Followed out from
    touching to `distance`, the root stays the same kind of stationary point of the distance as long as
    det(K_A + K_B + s K_A K_B) keeps its sign: one change makes it a saddle, two a far side.
    """
    if not factor < 0.0:
        return FAR_SIDE
    total = form_a + form_b
    determinant = total[0, 0] * total[1, 1] - total[0, 1] * total[1, 0]
    trace = total[0, 0] + total[1, 1]
    if not (determinant > 1e-12 * trace * trace and trace > 0.0):
        return NO_ELLIPSE
    product = form_a @ form_b
    mixed = total[1, 1] * product[0, 0] + total[0, 0] * product[1, 1]
    mixed -= total[0, 1] * (product[1, 0] + product[0, 1])
    square = product[0, 0] * product[1, 1] - product[0, 1] * product[1, 0]
    # determinant + mixed s + square s^2, as a function of t = s/distance in (0, 1]
    linear, quadratic = mixed * distance / determinant, square * distance * distance / determinant
    root = math.sqrt(max(linear * linear - 4.0 * quadratic, 0.0))
    crossings = 0
    for sign in (-1.0, 1.0):
        inverse = 0.5 * (-linear + sign * root)  # 1/t of a zero
        if inverse >= 1.0:
            crossings += 1
    if crossings == 0:
        return FOUND
    return SADDLE if crossings == 1 else FAR_SIDE


def contact_of(a: Body, b: Body, unknowns: np.ndarray) -> Opposition:
    """What a root of (1) is: points, normal, approach, gap curvatures (eqs. 4-6); raises SceneError at a wrong one."""
    gradient_a, gradient_b, hesse = np.empty(3), np.empty(3), np.empty((3, 3))
    point_a, point_b = unknowns[:3].copy(), unknowns[3:6].copy()
    level_at(a, point_a, gradient_a, hesse)
    level_at(b, point_b, gradient_b, hesse)
    normal = gradient_a / np.linalg.norm(gradient_a)
    axes = tangent_axes(normal)
    form_a, form_b = second_form(a, point_a, axes), second_form(b, point_b, axes)
    approach = -float(unknowns[MU] * np.linalg.norm(gradient_b))
    kind = classify(form_a, form_b, -approach, unknowns[LAMBDA])
    if kind != FOUND:
        raise SceneError(f"the pair of points found {REFUSALS[kind]}; start nearer to the contact")
    gap = 0.5 * (form_a + form_b)
    (small, large), directions = np.linalg.eigh(gap)
    circular = bool(large - small <= CIRCULAR * (large + small))
    major = axes[0] if circular else directions[:, 0] @ axes
    return Opposition(point_a, point_b, normal, approach, float(small), float(large), major, circular)


def find_opposing(a: Body, b: Body, near, iterations: int = 60) -> np.ndarray:
    """The unknowns (8,) of equations (1) by damped Newton steps from a point [m] (3,) `near` the expected contact.

    Which root it is `contact_of` says. Raises SceneError where the steps come to no end.
    """
    unknowns = _start(a, b, np.array(near, dtype=float))
    residual, jacobian = np.empty(8), np.empty((8, 8))
    equations(a, b, unknowns, residual, jacobian)
    length = max(np.linalg.norm(unknowns[:3] - a.position), np.linalg.norm(unknowns[:3] - unknowns[3:6]))
    length = max(length, np.linalg.norm(unknowns[3:6] - b.position))
    weight = np.array([length] * 3 + [1.0] * 5)
    last = math.inf
    for _ in range(iterations):
        try:
            step = np.linalg.solve(jacobian, residual)
        except np.linalg.LinAlgError:
            break
        size, before, share = np.linalg.norm(step[:6]), np.linalg.norm(weight * residual), 1.0
        while True:
            trial = unknowns - share * step
            equations(a, b, trial, residual, jacobian)
            after = np.linalg.norm(weight * residual)
            if after < before or share < 1e-3:
                break
            share *= 0.5
        if not np.all(np.isfinite(trial)):
            break
        unknowns = trial
        if size <= 1e-10 * length and (size >= last or size <= 1e-15 * length):  # down to rounding
            return unknowns
        last = size
    raise SceneError("no pair of opposing points was found from there; start nearer to the contact")


def _start(a, b, near):
    """Both surfaces' points next to `near`, with the multipliers that go with them."""
    points, gradients = [], []
    gradient, hesse = np.empty(3), np.empty((3, 3))
    for one in (a, b):
        point = near.copy()
        for _ in range(20):
            value = level_at(one, point, gradient, hesse)
            square = gradient @ gradient
            if not square > 0.0:
                raise SceneError("the start lies where a body's surface has no normal; start nearer to the contact")
            point = point - value / square * gradient
        level_at(one, point, gradient, hesse)
        points.append(point)
        gradients.append(gradient.copy())
    norms = [np.linalg.norm(one) for one in gradients]
    share = (points[0] - points[1]) @ gradients[1] / norms[1] ** 2
    return np.array([*points[0], *points[1], -norms[0] / norms[1], share])
