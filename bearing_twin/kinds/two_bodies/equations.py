"""The equations of two bodies on each other: paper 1, sections 2 to 4, for any two implicit surfaces.

    m dv/dt = F + m g,   dL/dt = r x F + T n,   dq/dt = omega q / 2        of each body that is free

The opposing points and the curvatures of the gap follow paper 1, eqs. (1)-(6): in closed form, by Newton's method from
the last step's end, or as eight states by the differential equations (2)-(3), put right after each step. The load acts
along A's outward normal n at the height of the interface that the compliances give; by the law `overlap` at the centre
of the overlap's volume. What a load does by turning bodies whose curvatures change is left out: it makes or loses about
a ten-thousandth of a bounce's energy (`ellipsoid_on_plane` has it).
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import kernel
from bearing_twin.contact.differential import Shape
from bearing_twin.contact.elastic import Elastic, elastic
from bearing_twin.contact.elasticity import (
    carries,
    coefficient_at,
    state_begun,
    state_finished,
    state_moved,
)
from bearing_twin.contact.ellipse import Ellipse, ellipse
from bearing_twin.contact.friction import friction_of
from bearing_twin.kinds.ellipsoid.equations import pulling_load
from bearing_twin.kinds.two_bodies.pair import (
    CARRIED,
    COLUMNS,
    DIFFERENTIAL,
    FLAT,
    GROSS_WORK,
    HELD_WORK,
    LOAD_IMPULSE,
    MOMENTUM,
    QUATERNION,
    RUB_IMPULSE,
    RUBBED,
    SECOND,
    UNKNOWNS,
    VELOCITY,
    VISCOUS,
    approach_of,
    body_at,
    track,
)
from bearing_twin.numerics.rotation import quaternion_product
from bearing_twin.shapes.lens import lens
from bearing_twin.shapes.tracking import (
    FOUND,
    LAMBDA,
    MU,
    NO_ELLIPSE,
    classify,
    level_at,
    opposing_rates,
    second_form,
    tangent_axes,
)


class PairTouch(NamedTuple):
    """The contact of one state: forces on A at `point`, in fixed axes; `kind` as of `tracking.classify`.

    `held` [N] is the load, below zero where the bodies would have to pull, or are apart.
    `approach_rate` and `slip` are A's velocity against B there, along A's outward `normal` and across it.
    """

    kind: int
    approach: float
    approach_rate: float
    normal_load: float
    elastic_load: float
    elastic_energy: float
    coefficient: float
    effective_mass: float
    curvature_small: float
    curvature_large: float
    semi_major: float
    semi_minor: float
    pressure: float
    point: np.ndarray
    normal: np.ndarray
    major_axis: np.ndarray
    slip: np.ndarray
    friction: np.ndarray
    drilling: float
    spin_rate: float
    held: float


@kernel
def _carried(law, carried, ratio):
    """The states that a law carries where P/Q is `ratio`; `carried` (4,) are the last step's, 0 first for none."""
    if not carries(law):
        return Shape(0.0, 0.0, 0.0)
    if carried[0] == 0.0:
        return state_begun(law, ratio, 1.0)
    return state_moved(law, Shape(carried[1], carried[2], carried[3]), ratio - carried[0])


@kernel
def carry_on(law, carried, ratio):
    """Ends a step of what the law carries."""
    shape = state_finished(law, _carried(law, carried, ratio), ratio)
    carried[0], carried[1], carried[2], carried[3] = ratio, shape.parameter, shape.first_kind, shape.second_kind


@kernel
def _mobility(rigid, body, arm, normal):
    """What a unit blow along the normal at `arm` gives the body there: 1/m + (r x n) I^-1 (r x n)."""
    lever = body.rotation.T @ np.cross(arm, normal)
    total = rigid.inverse_mass
    for i in range(3):
        total += lever[i] * lever[i] * rigid.inverse_inertia[i]
    return total


class _Spot(NamedTuple):
    """What presses: the answer of the law, half-widths and pressure, and where the load's centre is in the axes."""

    kind: int
    spring: Elastic
    semi_major: float
    semi_minor: float
    pressure: float
    aside_x: float
    aside_y: float


@kernel
def _gap_form(form_a, form_b, normal, axes):
    """P >= 0 and Q [1/m] of the gap from the curvature tensors (eqs. 5 and 6); turns the first of the axes along P."""
    xx, yy = 0.5 * (form_a[0, 0] + form_b[0, 0]), 0.5 * (form_a[1, 1] + form_b[1, 1])
    xy = 0.5 * (form_a[0, 1] + form_b[0, 1])
    mean, half = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    angle = 0.5 * math.atan2(-xy, 0.5 * (yy - xx)) if half > 0.0 else 0.0
    first = math.cos(angle) * axes[0] + math.sin(angle) * axes[1]
    axes[0], axes[1] = first, np.cross(normal, first)
    return max(mean - half, 0.0), mean + half


@kernel
def _spot_of_law(pair, kind, approach, small, large, carried):
    """The spot by a law that knows ellipses; its ellipse is that of the load, see `_under_load`."""
    if kind == FOUND and not small > FLAT * large:
        kind = NO_ELLIPSE
    if kind != FOUND:
        return _Spot(kind, Elastic(0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0)
    coefficient = coefficient_at(pair.law, small, large, _carried(pair.law, carried, small / large))
    spring = elastic(coefficient, pair.law.power, approach)
    return _Spot(kind, spring, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def _spot_of_lens(pair, a, b, middle, axes, normal, approach, kind):
    """The spot of the true overlap; the axes are exchanged where its second half-width is the longer one."""
    spring = Elastic(
        4.0 / 3.0 * pair.law.modulus * math.sqrt(pair.size), 0.0, 0.0, 0.0
    )  # a scale while nothing presses
    if approach <= 0.0 or kind != FOUND:
        return _Spot(kind, spring, 0.0, 0.0, 0.0, 0.0, 0.0)
    found = lens(a, b, middle, axes, normal, approach, pair.size, pair.law.modulus)
    if not found.found:
        return _Spot(NO_ELLIPSE, spring, 0.0, 0.0, 0.0, 0.0, 0.0)
    spring = Elastic(found.load / approach**1.5, found.load, 1.5 * found.load / approach, found.energy)
    x, y, root = found.half_width_x, found.half_width_y, math.sqrt(0.5)
    pressure, aside_x, aside_y = 3.0 * found.load / found.area, found.centre_x, found.centre_y
    if y > x:
        axes[0], axes[1] = axes[1].copy(), -axes[0].copy()
        x, y, aside_x, aside_y = y, x, aside_y, -aside_x
    return _Spot(kind, spring, root * x, root * y, pressure, aside_x, aside_y)


@kernel
def _under_load(pair, spot, load, small, large):
    """Half-widths [m] and pressure [Pa] under the whole load, elastic and viscous, as in all other kinds."""
    if pair.over_lens:
        return Ellipse(spot.semi_major, spot.semi_minor, spot.pressure * load / spot.spring.load)
    return ellipse(small, large, pair.law.modulus, load)


@kernel
def touch_of(pair, a, b, unknowns, carried):
    """The contact of two bodies with these opposing points, loaded or not."""
    gradient, other, hesse = np.empty(3), np.empty(3), np.empty((3, 3))
    point_a, point_b = unknowns[:3].copy(), unknowns[3:6].copy()
    level_at(a, point_a, gradient, hesse)
    level_at(b, point_b, other, hesse)
    normal = gradient / math.sqrt(gradient @ gradient)
    approach = -unknowns[MU] * math.sqrt(other @ other)
    axes = tangent_axes(normal)
    form_a, form_b = second_form(a, point_a, axes), second_form(b, point_b, axes)
    kind = classify(form_a, form_b, -approach, unknowns[LAMBDA])
    small, large = _gap_form(form_a, form_b, normal, axes)
    if pair.over_lens:
        if kind == NO_ELLIPSE and large >= 0.0 and unknowns[LAMBDA] < 0.0:
            kind = FOUND
        spot = _spot_of_lens(pair, a, b, 0.5 * (point_a + point_b), axes, normal, approach, kind)
    else:
        spot = _spot_of_law(pair, kind, approach, small, large, carried)
    spring = spot.spring
    point = point_a + pair.sink * (point_b - point_a) + spot.aside_x * axes[0] + spot.aside_y * axes[1]

    arm_a, arm_b = point - a.position, point - b.position
    relative = a.velocity + np.cross(a.spin, arm_a) - b.velocity - np.cross(b.spin, arm_b)
    rate = relative @ normal
    slip = relative - rate * normal
    effective_mass = 1.0 / (_mobility(pair.a, a, arm_a, normal) + _mobility(pair.b, b, arm_b, normal))
    load, drilling, spin_rate = 0.0, 0.0, (a.spin - b.spin) @ normal
    held = -spring.coefficient * abs(approach) ** 1.5
    friction, under = np.zeros(3), Ellipse(0.0, 0.0, 0.0)
    if spring.load > 0.0:
        held = pulling_load(pair, spring, effective_mass, approach, rate)
        load = max(held, 0.0)
        if load > 0.0:
            under = _under_load(pair, spot, load, small, large)
        if load > 0.0 and pair.friction > 0.0:
            rubbed = friction_of(
                pair.rubbing, load, under.semi_major, under.semi_minor, slip @ axes[0], slip @ axes[1], spin_rate,
                pair.friction, pair.regularisation,
            )  # fmt: skip
            friction[:] = rubbed.force_major * axes[0] + rubbed.force_minor * axes[1]
            drilling = rubbed.torque
    return PairTouch(
        spot.kind, approach, rate, load, spring.load, spring.energy, spring.coefficient, effective_mass, small, large,
        under.semi_major, under.semi_minor, under.peak_pressure, point, normal, axes[0].copy(), slip, friction,
        drilling, spin_rate, held,
    )  # fmt: skip


@kernel
def _fly(rigid, gravity, body, state, first, out):
    """Rates of a body that nothing presses."""
    turn = quaternion_product(
        (body.spin[0], body.spin[1], body.spin[2], 0.0),
        (state[first + 3], state[first + 4], state[first + 5], state[first + 6]),
    )
    for i in range(3):
        out[first + i] = body.velocity[i]
        if rigid.inverse_mass > 0.0:
            out[first + VELOCITY + i] = gravity[i]
    for i in range(4):
        out[first + QUATERNION + i] = 0.5 * turn[i]


@kernel
def pair_rates(pair, state, loaded, out):
    """Time derivative (COLUMNS,) of the state; without `loaded` the bodies do not press. Returns the touch's kind."""
    out[:] = 0.0
    a, b = body_at(pair.a, state, 0), body_at(pair.b, state, SECOND)
    _fly(pair.a, pair.gravity, a, state, 0, out)
    _fly(pair.b, pair.gravity, b, state, SECOND, out)
    unknowns = state[UNKNOWNS : UNKNOWNS + 8].copy()
    if pair.tracking == DIFFERENTIAL:
        out[UNKNOWNS : UNKNOWNS + 8] = opposing_rates(a, b, unknowns)
    if not loaded:
        return FOUND
    track(pair, a, b, unknowns)
    if approach_of(b, unknowns) <= 0.0:
        return FOUND
    touch = touch_of(pair, a, b, unknowns, state[CARRIED:COLUMNS])
    force = touch.friction - touch.normal_load * touch.normal
    drill = touch.drilling * touch.normal
    held = 0.0
    for side in range(2):
        rigid, body, sign = (pair.a, a, 1.0) if side == 0 else (pair.b, b, -1.0)
        first = side * SECOND
        arm = touch.point - body.position
        moment = np.cross(arm, force) + drill
        if rigid.inverse_mass > 0.0:
            for i in range(3):
                out[first + VELOCITY + i] += sign * force[i] * rigid.inverse_mass
                out[first + MOMENTUM + i] = sign * moment[i]
        else:
            held += sign * (force @ body.velocity + moment @ body.spin)
    out[VISCOUS] = (touch.normal_load - touch.elastic_load) * touch.approach_rate
    out[RUBBED] = -(touch.friction @ touch.slip + touch.drilling * touch.spin_rate)
    out[HELD_WORK], out[GROSS_WORK] = held, abs(held)
    out[LOAD_IMPULSE] = touch.normal_load
    for i in range(3):
        out[RUB_IMPULSE + i] = touch.friction[i]
    return touch.kind
