"""One ball between two grooves in equilibrium (Jones 1960; Harris, Rolling Bearing Analysis), with all derivatives.

**Opening.** The ring's centre lies at d = x cos(psi) + y sin(psi) outwards and s = y cos(psi) - x sin(psi) ahead of a
ball at the azimuth psi, which meets it beside the middle: its groove, a circle round the ring's own axis, has gone back
by s^2/(2 r) there, r = d_m/2. Of a tilt theta, b = theta_x sin(psi) - theta_y cos(psi) acts in the ball's plane and
l = theta_x cos(psi) + theta_y sin(psi) across it. The inner groove's centre against the outer one's is, tilts being of
first order,

    A_r = A_0 + d - s^2/(2 r),   A_z = z + R b - s l.

**Balance.** The meridian plane of the ball has axes (radial, axial); `place` is the ball's centre against the outer
groove's. Both contacts pull the ball towards its groove's centre: Q_i along n_i = (opening - place)/|.|, and -Q_o along
n_o = place/|.|. With t = (-n_z, n_r), and the gyroscopic moment M_g carried by friction in the shares lambda,

    0 = Q_i n_i - Q_o n_o + F_c e_r + weight + (M_g / D) (lambda_i t_i - lambda_o t_o).

**Raceway control** says what the shares (lambda_i, lambda_o) and the pitch beta of the ball's axis are: `outer` has
(0, 2) and tan(beta) = sin(a_o)/(cos(a_o) + gamma), gamma = D/d_m; `inner` (2, 0) and sin(a_i)/(cos(a_i) - gamma);
`shared` (1, 1) and the pitch of outer control.
"""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elastic import elastic
from bearing_twin.kinds.bearing.forces.along_groove import coefficient_along, slope_along
from bearing_twin.kinds.bearing.forces.equations import Raceway
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, GREATEST_SQUEEZE
from bearing_twin.shapes.surfaces import groove_curvatures

TINY = 1e-300  # keeps a direction defined where its length is zero
LEVEL = 0.5  # cosine of an angle beyond which no contact is legal
ACROSS = math.sqrt(1.0 - LEVEL * LEVEL)
IDLE = 1e-3  # of the greatest load: below it the angle of a contact has no limit
PLACES = 8  # numbers kept of a ball's equilibrium: place, opening, d(place)/d(opening)
MOST_STEPS, MOST_HALVINGS, MOST_BISECTIONS = 40, 6, 40
EXACT = 1e-12  # of the loads: what is left of a ball's balance
NEAR = 1e-9  # of the loads: what is left of a balance whose last step is taken without another evaluation
ENOUGH = 1e-9  # of the loads: as above, where rounding lets no step improve any more
SMALLEST_STEP = 4e-17  # of the groove's radius: a step below it changes nothing any more


class Setting(NamedTuple):
    """The numbers of the balance (SI): grooves, ball, `arm` of a tilt, speed [rad/s], shares of the gyroscopic moment.

    `arm` [m] turns a tilt into axial displacement and an axial force into a moment; `lever` [m] is the arm of the
    friction that carries the gyroscopic moment, about the point at the end of `arm`. A ball's last step may leave
    `unseen` of the loads, for which stiffness is to the root of that; 0 where it is to be exact.
    """

    inner: Raceway
    outer: Raceway
    ball_radius: float
    ball_mass: float
    pitch_diameter: float
    arm: float
    lever: float
    speed: float
    share_inner: float
    share_outer: float
    unseen: float


class Push(NamedTuple):
    """One contact: approach [m], load [N], direction, distance of the centres [m], and derivatives of its force.

    `stiffness` is d(load)/d(approach), `turning` the derivative of the load along t.
    """

    approach: float
    load: float
    n_r: float
    n_z: float
    distance: float
    stiffness: float
    turning: float


class Speeds(NamedTuple):
    """Centrifugal load [N] and gyroscopic moment over D [N], and their derivatives by both contact angles [N/rad]."""

    centrifugal: float
    centrifugal_by_outer: float
    centrifugal_by_inner: float
    gyroscopic: float
    gyroscopic_by_outer: float
    gyroscopic_by_inner: float


class Opening(NamedTuple):
    """The inner groove's centre against the outer one's [m], and `outwards` d, `aside` s [m], `along` b, `across` l.

    `side` is s/r.
    """

    radial: float
    axial: float
    outwards: float
    aside: float
    along: float
    across: float
    side: float


@inlined
def opening_of(setting, cosine, sine, q):
    """The `Opening` of a ball at the azimuth of that cosine and sine, the ring at `q` (5,) [m, rad]."""
    outwards, aside = q[0] * cosine + q[1] * sine, q[1] * cosine - q[0] * sine
    along, across = q[3] * sine - q[4] * cosine, q[3] * cosine + q[4] * sine
    side = 2.0 / setting.pitch_diameter * aside
    radial = (setting.inner.locus_radius - setting.outer.locus_radius) + outwards - 0.5 * side * aside
    axial = q[2] + setting.arm * along - aside * across
    return Opening(radial, axial, outwards, aside, along, across, side)


@inlined
def slopes_of(setting, cosine, sine, opening):
    """Derivatives of the opening, radial (x, y) and axial (x, y, theta_x, theta_y); by z they are 0 and 1."""
    side, across, aside = opening.side, opening.across, opening.aside
    radial = (cosine + side * sine, sine - side * cosine)
    axial = (across * sine, -across * cosine, setting.arm * sine - aside * cosine, -setting.arm * cosine - aside * sine)
    return radial, axial


@inlined
def push_of(setting, raceway, v_r, v_z):
    """The contact where `v` [m] points from the ball's centre to the inner groove's, or from the outer one's to it."""
    distance = math.sqrt(v_r * v_r + v_z * v_z + TINY)
    n_r, n_z = v_r / distance, v_z / distance
    approach = distance + setting.ball_radius - raceway.groove_radius
    if approach <= 0.0:
        return Push(approach, 0.0, n_r, n_z, distance, 0.0, 0.0)
    coefficient = coefficient_along(raceway.terms, n_r)
    answer = elastic(coefficient, raceway.law.power, approach)
    by_radial = slope_along(raceway.terms, n_r) * answer.load / coefficient
    return Push(approach, answer.load, n_r, n_z, distance, answer.stiffness, -by_radial * n_z / distance)


@inlined
def gradient_of(push):
    """The 2 x 2 derivative of the force load * n by the vector between the centres, rows first."""
    n_r, n_z, across = push.n_r, push.n_z, push.load / push.distance
    t_r, t_z = -n_z, n_r
    return (
        push.stiffness * n_r * n_r + push.turning * n_r * t_r + across * t_r * t_r,
        push.stiffness * n_r * n_z + push.turning * n_r * t_z + across * t_r * t_z,
        push.stiffness * n_z * n_r + push.turning * n_z * t_r + across * t_z * t_r,
        push.stiffness * n_z * n_z + push.turning * n_z * t_z + across * t_z * t_z,
    )


@inlined
def orbit_and_roll(setting, inner, outer):
    """Orbit speed [rad/s], roll speed times the sine and times the cosine of its axis's pitch [rad/s].

    Harris, Rolling Bearing Analysis (speeds and inertial loads of balls), inner ring turning.
    """
    gamma = 2.0 * setting.ball_radius / setting.pitch_diameter
    if setting.share_inner > setting.share_outer:
        pitch = inner.n_z / (inner.n_r - gamma)
    else:
        pitch = outer.n_z / (outer.n_r + gamma)
    p_o = (outer.n_r + pitch * outer.n_z) / (1.0 + gamma * outer.n_r)
    p_i = (inner.n_r + pitch * inner.n_z) / (1.0 - gamma * inner.n_r)
    roll = setting.speed / ((p_o + p_i) * gamma)
    return setting.speed * p_o / (p_o + p_i), roll * pitch, roll


@inlined
def level_load(setting):
    """The centrifugal load [N] at contact angle zero, where the orbit speed is (1 - gamma)/2 of the ring's."""
    orbit = 0.5 * setting.speed * (1.0 - 2.0 * setting.ball_radius / setting.pitch_diameter)
    return 0.5 * setting.ball_mass * setting.pitch_diameter * orbit * orbit


@inlined
def _turned_back(push):
    """Cosine and sine of a contact angle a, beyond 60 degrees those of 120 - |a| degrees, at least 0; and the slope."""
    if push.n_r >= LEVEL:
        return push.n_r, push.n_z, 1.0
    if push.n_r <= -LEVEL:
        return 1.0, 0.0, 0.0
    cosine = ACROSS * abs(push.n_z) - LEVEL * push.n_r
    return cosine, math.copysign(ACROSS * push.n_r + LEVEL * abs(push.n_z), push.n_z), -1.0


@inlined
def speeds_of(setting, inner, outer):
    """Centrifugal load F_c = m d_m omega_m^2 / 2 and M_g / D, M_g = J omega_R omega_m sin(beta), J = m D^2/10.

    Beyond 60 degrees, where only a ball that carries next to nothing has its centre, they go back to those of level
    contacts, without a jump, at which a ball would find no balance.
    """
    if setting.speed == 0.0:
        return Speeds(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    gamma = 2.0 * setting.ball_radius / setting.pitch_diameter
    c_o, s_o, by_o = _turned_back(outer)
    c_i, s_i, by_i = _turned_back(inner)
    square = setting.ball_mass * setting.pitch_diameter * setting.speed * setting.speed
    lean_o, lean_i, pitch_by_o, pitch_by_i = c_o + gamma, c_i - gamma, 0.0, 0.0
    if setting.share_inner > setting.share_outer:
        pitch, pitch_by_i = s_i / lean_i, by_i * (1.0 - gamma * c_i) / (lean_i * lean_i)
    else:
        pitch, pitch_by_o = s_o / lean_o, by_o * (1.0 + gamma * c_o) / (lean_o * lean_o)
    over_o, over_i = 1.0 / (1.0 + gamma * c_o), 1.0 / (1.0 - gamma * c_i)
    p_o, p_i = (c_o + pitch * s_o) * over_o, (c_i + pitch * s_i) * over_i
    p_o_by_o = (pitch_by_o * s_o + by_o * (-s_o + pitch * c_o + p_o * gamma * s_o)) * over_o
    p_i_by_i = (pitch_by_i * s_i + by_i * (-s_i + pitch * c_i - p_i * gamma * s_i)) * over_i
    p_o_by_i, p_i_by_o = pitch_by_i * s_o * over_o, pitch_by_o * s_i * over_i
    whole = 1.0 / (p_o + p_i)
    share, roll = p_o * whole, pitch * whole
    share_by_o = (p_o_by_o * p_i - p_o * p_i_by_o) * whole * whole
    share_by_i = (p_o_by_i * p_i - p_o * p_i_by_i) * whole * whole
    roll_by_o = (pitch_by_o - roll * (p_o_by_o + p_i_by_o)) * whole
    roll_by_i = (pitch_by_i - roll * (p_o_by_i + p_i_by_i)) * whole
    return Speeds(
        0.5 * square * share * share,
        square * share * share_by_o,
        square * share * share_by_i,
        0.1 * square * roll * share,
        0.1 * square * (roll_by_o * share + roll * share_by_o),
        0.1 * square * (roll_by_i * share + roll * share_by_i),
    )


class Balance(NamedTuple):
    """What is left of a ball's balance [N], its derivatives, and what the ring must bring up for this ball.

    `force` (radial, axial) [N] and `moment` [N m] act on the ring from outside to hold it against the ball.
    `_p` are derivatives by the ball's place, `_o` by the opening.
    """

    left_r: float
    left_z: float
    left_p: tuple
    left_o: tuple
    force: tuple
    force_p: tuple
    force_o: tuple
    friction_moment: float
    friction_moment_p: tuple
    friction_moment_o: tuple
    scale: float


@inlined
def _pushes(setting, opening_r, opening_z, place_r, place_z):
    inner = push_of(setting, setting.inner, opening_r - place_r, opening_z - place_z)
    return inner, push_of(setting, setting.outer, place_r, place_z)


@inlined
def _left(setting, inner, outer, speeds, weight_r, weight_z):
    """What is left of the balance [N] (radial, axial)."""
    touching = 1.0 if inner.load > 0.0 else 0.0
    gyro_i = touching * setting.share_inner * speeds.gyroscopic
    gyro_o = touching * setting.share_outer * speeds.gyroscopic
    return (
        inner.load * inner.n_r - outer.load * outer.n_r + speeds.centrifugal + weight_r
        - gyro_i * inner.n_z + gyro_o * outer.n_z,
        inner.load * inner.n_z - outer.load * outer.n_z + weight_z + gyro_i * inner.n_r - gyro_o * outer.n_r,
    )  # fmt: skip


@kernel
def balance_at(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z):
    """The balance of a ball at `place` and all its derivatives; `weight` [N] acts on the ball."""
    inner, outer = _pushes(setting, opening_r, opening_z, place_r, place_z)
    speeds = speeds_of(setting, inner, outer)
    left_r, left_z = _left(setting, inner, outer, speeds, weight_r, weight_z)
    g_i, g_o = gradient_of(inner), gradient_of(outer)
    touching = 1.0 if inner.load > 0.0 else 0.0
    share_i, share_o = touching * setting.share_inner, touching * setting.share_outer
    gyro, by_i, by_o = speeds.gyroscopic, speeds.gyroscopic_by_inner, speeds.gyroscopic_by_outer
    # angles by vectors: d(alpha) = (t / distance) . dv
    ti_r, ti_z, to_r, to_z = -inner.n_z, inner.n_r, -outer.n_z, outer.n_r
    ai_r, ai_z = ti_r / inner.distance, ti_z / inner.distance
    ao_r, ao_z = to_r / outer.distance, to_z / outer.distance
    # derivatives of the inner contact's whole force by the inner vector, and by the outer angle
    fi_r, fi_z = share_i * (by_i * ti_r - gyro * inner.n_r), share_i * (by_i * ti_z - gyro * inner.n_z)
    f_i = (g_i[0] + fi_r * ai_r, g_i[1] + fi_r * ai_z, g_i[2] + fi_z * ai_r, g_i[3] + fi_z * ai_z)
    fo_r, fo_z = share_i * by_o * ti_r, share_i * by_o * ti_z
    # the rest of the balance by both angles
    ri_r, ri_z = speeds.centrifugal_by_inner - share_o * by_i * to_r, -share_o * by_i * to_z
    ro_r = speeds.centrifugal_by_outer - share_o * (by_o * to_r - gyro * outer.n_r)
    ro_z = -share_o * (by_o * to_z - gyro * outer.n_z)
    left_o = (f_i[0] + ri_r * ai_r, f_i[1] + ri_r * ai_z, f_i[2] + ri_z * ai_r, f_i[3] + ri_z * ai_z)
    left_p = (
        -left_o[0] - g_o[0] + (fo_r + ro_r) * ao_r,
        -left_o[1] - g_o[1] + (fo_r + ro_r) * ao_z,
        -left_o[2] - g_o[2] + (fo_z + ro_z) * ao_r,
        -left_o[3] - g_o[3] + (fo_z + ro_z) * ao_z,
    )
    lever = -setting.lever * share_i
    return Balance(
        left_r,
        left_z,
        left_p,
        left_o,
        (inner.load * inner.n_r + share_i * gyro * ti_r, inner.load * inner.n_z + share_i * gyro * ti_z),
        (-f_i[0] + fo_r * ao_r, -f_i[1] + fo_r * ao_z, -f_i[2] + fo_z * ao_r, -f_i[3] + fo_z * ao_z),
        f_i,
        lever * gyro,
        (lever * (by_o * ao_r - by_i * ai_r), lever * (by_o * ao_z - by_i * ai_z)),
        (lever * by_i * ai_r, lever * by_i * ai_z),
        inner.load + outer.load + speeds.centrifugal,
    )


@kernel
def _at(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z):
    """What is left of the balance alone."""
    inner, outer = _pushes(setting, opening_r, opening_z, place_r, place_z)
    return _left(setting, inner, outer, speeds_of(setting, inner, outer), weight_r, weight_z)


@kernel
def _resting(setting, raceway, along_r, along_z):
    """The vector between the centres of a ball that rests on one raceway alone, pressed along by this force [N]."""
    load = math.sqrt(along_r * along_r + along_z * along_z + TINY)
    n_r, n_z = along_r / load, along_z / load
    reach = raceway.groove_radius - setting.ball_radius
    deep = reach + 1e-6
    still = push_of(setting, raceway, n_r * deep, n_z * deep)
    power = raceway.law.power
    coefficient = still.load / 1e-6**power
    length = reach + (load / coefficient) ** (1.0 / power)
    return n_r * length, n_z * length


@kernel
def first_place(setting, opening_r, opening_z, weight_r, weight_z):
    """Where to begin a ball's balance: the place, and whether it is the answer already (at most one raceway carries).

    The energy of both contacts is convex in the place, so a ball that rests on one raceway clear of the other is there.
    """
    reach_i = setting.inner.groove_radius - setting.ball_radius
    reach_o = setting.outer.groove_radius - setting.ball_radius
    distance = math.sqrt(opening_r * opening_r + opening_z * opening_z + TINY)
    squeeze = distance - reach_i - reach_o
    share = (reach_o + 0.5 * squeeze) / distance
    place_r, place_z = share * opening_r, share * opening_z
    force_r = level_load(setting) + weight_r
    if squeeze > 0.0:
        return place_r, place_z, False
    if force_r == 0.0 and weight_z == 0.0:
        return place_r, place_z, True
    out_r, out_z = _resting(setting, setting.outer, force_r, weight_z)
    gap_r, gap_z = opening_r - out_r, opening_z - out_z
    if gap_r * gap_r + gap_z * gap_z <= reach_i * reach_i:
        return out_r, out_z, True
    in_r, in_z = _resting(setting, setting.inner, -force_r, -weight_z)
    low_r, low_z = opening_r - in_r, opening_z - in_z
    if low_r * low_r + low_z * low_z <= reach_o * reach_o:
        return low_r, low_z, True
    return out_r, out_z, False


@kernel
def _bracketed(setting, opening_r, opening_z, weight_r, weight_z):
    """A ball's place by nested bisection: the radial balance falls with the radial place, what is left axially too.

    Both follow from the energy being convex; it holds as long as speeds change little with the angles.
    """
    wide = (
        math.sqrt(opening_r * opening_r + opening_z * opening_z)
        + setting.inner.groove_radius
        + setting.outer.groove_radius
    )
    low_z, high_z = -wide, wide
    place_r = 0.0
    for _ in range(MOST_BISECTIONS):
        place_z = 0.5 * (low_z + high_z)
        low_r, high_r = -wide, wide
        for _ in range(MOST_BISECTIONS):
            place_r = 0.5 * (low_r + high_r)
            if _at(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z)[0] > 0.0:
                low_r = place_r
            else:
                high_r = place_r
        if _at(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z)[1] > 0.0:
            low_z = place_z
        else:
            high_z = place_z
    return place_r, 0.5 * (low_z + high_z)


@inlined
def _moved(here, step_r, step_z):
    """The balance a Newton step further, to first order: what is left then is the square of what was left before."""
    force_p, moment_p = here.force_p, here.friction_moment_p
    return Balance(
        0.0,
        0.0,
        here.left_p,
        here.left_o,
        (
            here.force[0] + force_p[0] * step_r + force_p[1] * step_z,
            here.force[1] + force_p[2] * step_r + force_p[3] * step_z,
        ),
        here.force_p,
        here.force_o,
        here.friction_moment + moment_p[0] * step_r + moment_p[1] * step_z,
        here.friction_moment_p,
        here.friction_moment_o,
        here.scale,
    )


@kernel
def _newton(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z):
    """(place, height, balance, whether it is in balance) by damped Newton steps from this place."""
    here = balance_at(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z)
    smallest = SMALLEST_STEP * setting.outer.groove_radius
    for _ in range(MOST_STEPS):
        size = abs(here.left_r) + abs(here.left_z)
        if size <= EXACT * here.scale:
            return place_r, place_z, here, True
        a, b, c, d = here.left_p
        determinant = a * d - b * c
        if not abs(determinant) > 1e-14 * (abs(a * d) + abs(b * c)):
            return place_r, place_z, here, False
        step_r = (b * here.left_z - d * here.left_r) / determinant
        step_z = (c * here.left_r - a * here.left_z) / determinant
        if abs(step_r) + abs(step_z) <= smallest:
            return place_r, place_z, here, True
        # A step leaves about what was off, squared, over a contact's load, and the ring bears no more than that load.
        carried = abs(here.force[0]) + abs(here.force[1])
        if size <= NEAR * here.scale or size * size <= setting.unseen * here.scale * carried:
            return place_r + step_r, place_z + step_z, _moved(here, step_r, step_z), True
        factor, better = 1.0, False
        for _ in range(MOST_HALVINGS):
            near_r, near_z = place_r + factor * step_r, place_z + factor * step_z
            near = balance_at(setting, opening_r, opening_z, near_r, near_z, weight_r, weight_z)
            better = abs(near.left_r) + abs(near.left_z) < size
            if better or size <= ENOUGH * here.scale:
                break
            factor *= 0.35
        if not better:
            return place_r, place_z, here, size <= ENOUGH * here.scale
        place_r, place_z, here = near_r, near_z, near
    return place_r, place_z, here, False


@kernel
def ball_in_balance(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z):
    """(place_r, place_z, `Balance`) of a ball; `place` is where to begin, NaN for a cold start.

    Newton's method, then nested bisection; what is left of the balance is in the answer.
    """
    alone = False
    if math.isnan(place_r):
        place_r, place_z, alone = first_place(setting, opening_r, opening_z, weight_r, weight_z)
    place_r, place_z, here, done = _newton(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z)
    if not done and not alone:
        place_r, place_z, alone = first_place(setting, opening_r, opening_z, weight_r, weight_z)
        if not alone:
            place_r, place_z = _bracketed(setting, opening_r, opening_z, weight_r, weight_z)
        place_r, place_z, here, _ = _newton(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z)
    return place_r, place_z, here


class Contacts(NamedTuple):
    """Arrays (N, 2), inner and outer; `friction` [N] is along t.

    A ball's row (N,): `orbit` [rad/s], `roll` [rad/s] along the axis and `pitch` [rad/s] along the radius, both of the
    ball against its orbit; `centrifugal` [N]. Angles count where there is no load too.
    """

    approach: np.ndarray
    load: np.ndarray
    angle: np.ndarray
    friction: np.ndarray
    curvature_small: np.ndarray
    curvature_large: np.ndarray
    orbit: np.ndarray
    roll: np.ndarray
    pitch: np.ndarray
    centrifugal: np.ndarray


def empty_contacts(*shape: int) -> Contacts:
    """Room for the contacts of balls in arrays of this shape, the last that of the balls."""
    sides = *shape, 2
    return Contacts(*(np.zeros(sides) for _ in range(6)), *(np.zeros(shape) for _ in range(4)))


@inlined
def curvatures_at(setting, raceway, side, n_r):
    """Curvatures (small, large) of the gap [1/m] where the normal's radial part is `n_r`; `side` -1 inner, 1 outer."""
    return groove_curvatures(setting.ball_radius, raceway.locus_radius, raceway.groove_radius, side * n_r)


@kernel
def write_contacts(setting, azimuths, q, place, out):
    """Fills `out` (`Contacts`) with the balls at their places, the ring at `q`."""
    for k in range(len(azimuths)):
        opening = opening_of(setting, azimuths[k, 0], azimuths[k, 1], q)
        inner = push_of(setting, setting.inner, opening.radial - place[k, 0], opening.axial - place[k, 1])
        outer = push_of(setting, setting.outer, place[k, 0], place[k, 1])
        speeds = speeds_of(setting, inner, outer)
        gyroscopic = speeds.gyroscopic if inner.load > 0.0 else 0.0
        out.friction[k, 0] = setting.share_inner * gyroscopic
        out.friction[k, 1] = -setting.share_outer * gyroscopic
        out.centrifugal[k] = speeds.centrifugal
        for side in range(2):
            push = inner if side == 0 else outer
            raceway = setting.inner if side == 0 else setting.outer
            out.approach[k, side] = push.approach
            out.load[k, side] = push.load
            out.angle[k, side] = math.atan2(push.n_z, push.n_r)
            small, large = curvatures_at(setting, raceway, 2.0 * side - 1.0, push.n_r)
            out.curvature_small[k, side], out.curvature_large[k, side] = small, large
        gamma = 2.0 * setting.ball_radius / setting.pitch_diameter
        if inner.load > 0.0 and inner.n_r >= LEVEL and outer.n_r >= LEVEL:
            out.orbit[k], out.pitch[k], out.roll[k] = orbit_and_roll(setting, inner, outer)
        else:
            out.orbit[k], out.pitch[k] = 0.5 * setting.speed * (1.0 - gamma), 0.0
            out.roll[k] = 0.5 * setting.speed * (1.0 - gamma * gamma) / gamma


@kernel
def shared(contacts, values):
    """What balls in one cage share of `values` (N,), such as orbit speeds: the mean by load on the inner ring."""
    weight, total = 0.0, 0.0
    for k in range(len(values)):
        weight += contacts.load[k, 0]
        total += contacts.load[k, 0] * values[k]
    return total / weight if weight > 0.0 else values.mean()


def contacts_at(setting, directions: np.ndarray, q: np.ndarray, place: np.ndarray) -> Contacts:
    """The contacts of balls at these places, the ring at `q` (5,)."""
    contacts = empty_contacts(len(directions))
    write_contacts(setting, directions, q, place, contacts)
    return contacts


def limits_used(setting, load, approach, angle) -> tuple[np.ndarray, np.ndarray]:
    """Squeeze and greatest contact angle of each ball, each over its limit, from arrays (..., N, 2) of both raceways.

    The angle of a contact that bears less than IDLE of the greatest load does not count: no edge of a groove feels it.
    """
    squeeze = np.where((load > 0.0).all(-1), approach.sum(-1), 0.0)
    greatest = np.where(load > IDLE * load.max(axis=(-2, -1), keepdims=True), np.abs(angle), 0.0).max(-1)
    return squeeze / (GREATEST_SQUEEZE * 2.0 * setting.ball_radius), greatest / GREATEST_ANGLE
