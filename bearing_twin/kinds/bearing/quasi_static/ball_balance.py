"""One ball between two grooves in balance: its loads, its speeds, and how what it does to the ring answers the ring.

The meridian plane of the ball has axes (radial, axial). The place of the inner groove's centre against the outer one is
the `opening`, the ball's centre against the outer groove's centre is `place`. Both contacts pull the ball towards its
groove's centre: Q_i along n_i = (opening - place)/|.|, and -Q_o along n_o = place/|.|. With t = (-n_z, n_r), and the
gyroscopic moment M_g carried by friction in the shares lambda (Harris, Rolling Bearing Analysis; Jones 1960),

    0 = Q_i n_i - Q_o n_o + F_c e_r + weight + (M_g / D) (lambda_i t_i - lambda_o t_o).

All derivatives are exact for laws that are evaluated in lanes (`contact.slope`).
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.contact.elastic import elastic
from bearing_twin.contact.slope import coefficient_and_slope
from bearing_twin.kinds.bearing.equations import Raceway

TINY = 1e-300  # keeps a direction defined where its length is zero
MOST_STEPS, MOST_HALVINGS, MOST_BISECTIONS = 40, 6, 70
EXACT = 1e-12  # of the loads: what is left of a ball's balance
LEVEL = 0.5  # cosine of an angle beyond which no contact is legal
ENOUGH = 1e-9  # of the loads: as above, where rounding lets no step improve any more
SMALLEST_STEP = 4e-17  # of the groove's radius: a step below it changes nothing any more


class Setting(NamedTuple):
    """The numbers of the balance (SI): grooves, ball, `arm` of a tilt, speed [rad/s], shares of the gyroscopic moment.

    `arm` [m] turns a tilt into axial displacement and an axial force into a moment; `lever` [m] is the arm of the
    friction that carries the gyroscopic moment, about the point at the end of `arm`.
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
def push_of(setting, raceway, side, v_r, v_z):
    """The contact where `v` [m] points from the ball's centre to the groove's (inner, side -1) or back (outer, +1)."""
    distance = math.sqrt(v_r * v_r + v_z * v_z + TINY)
    n_r, n_z = v_r / distance, v_z / distance
    approach = distance + setting.ball_radius - raceway.groove_radius
    if approach <= 0.0:
        return Push(approach, 0.0, n_r, n_z, distance, 0.0, 0.0)
    # as `surfaces.ball_in_groove`
    ball = 1.0 / setting.ball_radius
    bottom = raceway.locus_radius + side * raceway.groove_radius * n_r
    small, large = 0.5 * (ball - 1.0 / raceway.groove_radius), 0.5 * (ball - side * n_r / bottom)
    coefficient, slope = coefficient_and_slope(raceway.law, small, large)
    answer = elastic(coefficient, raceway.law.power, approach)
    by_radial = -0.5 * side * raceway.locus_radius / (bottom * bottom) * slope * answer.load / coefficient
    return Push(approach, answer.load, n_r, n_z, distance, answer.stiffness, -by_radial * n_z / distance)


@inlined
def _gradient(push):
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

    Harris, Rolling Bearing Analysis (speeds and inertial loads of balls): inner ring turning, pitch of the ball's axis
    by tan(beta) = sin(alpha_o)/(cos(alpha_o) + gamma), gamma = D/d_m.
    """
    gamma = 2.0 * setting.ball_radius / setting.pitch_diameter
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
def speeds_of(setting, inner, outer):
    """Centrifugal load F_c = m d_m omega_m^2 / 2 and M_g / D, M_g = J omega_R omega_m sin(beta), J = m D^2/10.

    Beyond 60 degrees, where only a ball off a raceway has its centre, as at contact angle zero.
    """
    if setting.speed == 0.0:
        return Speeds(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    diameter = 2.0 * setting.ball_radius
    gamma = diameter / setting.pitch_diameter
    c_o, s_o, c_i, s_i = outer.n_r, outer.n_z, inner.n_r, inner.n_z
    centrifugal = 0.5 * setting.ball_mass * setting.pitch_diameter * setting.speed * setting.speed
    if c_o < LEVEL or c_i < LEVEL:
        return Speeds(level_load(setting), 0.0, 0.0, 0.0, 0.0, 0.0)
    b_o, b_i, lean = 1.0 + gamma * c_o, 1.0 - gamma * c_i, c_o + gamma
    pitch = s_o / lean
    pitch_by = b_o / (lean * lean)
    a_o, a_i = c_o + pitch * s_o, c_i + pitch * s_i
    p_o, p_i = a_o / b_o, a_i / b_i
    p_o_by = (-s_o + pitch_by * s_o + pitch * c_o + p_o * gamma * s_o) / b_o
    p_i_by_outer = pitch_by * s_i / b_i
    p_i_by_inner = (-s_i + pitch * c_i - p_i * gamma * s_i) / b_i
    total = p_o + p_i
    share = p_o / total
    share_by_outer = (p_o_by * p_i - p_o * p_i_by_outer) / (total * total)
    share_by_inner = -p_o * p_i_by_inner / (total * total)
    gyroscopic = 0.1 * setting.ball_mass * diameter * setting.speed * setting.speed / gamma
    roll = pitch / total
    roll_by_outer = (pitch_by - roll * (p_o_by + p_i_by_outer)) / total
    roll_by_inner = -roll * p_i_by_inner / total
    return Speeds(
        centrifugal * share * share,
        2.0 * centrifugal * share * share_by_outer,
        2.0 * centrifugal * share * share_by_inner,
        gyroscopic * roll * share,
        gyroscopic * (roll_by_outer * share + roll * share_by_outer),
        gyroscopic * (roll_by_inner * share + roll * share_by_inner),
    )


@inlined
def _pushes(setting, opening_r, opening_z, place_r, place_z):
    inner = push_of(setting, setting.inner, -1.0, opening_r - place_r, opening_z - place_z)
    return inner, push_of(setting, setting.outer, 1.0, place_r, place_z)


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
    g_i, g_o = _gradient(inner), _gradient(outer)
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
def _resting(setting, raceway, side, along_r, along_z):
    """The vector between the centres of a ball that rests on one raceway alone, pressed along by this force [N]."""
    load = math.sqrt(along_r * along_r + along_z * along_z + TINY)
    n_r, n_z = along_r / load, along_z / load
    reach = raceway.groove_radius - setting.ball_radius
    deep = reach + 1e-6
    still = push_of(setting, raceway, side, n_r * deep, n_z * deep)
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
    out_r, out_z = _resting(setting, setting.outer, 1.0, force_r, weight_z)
    gap_r, gap_z = opening_r - out_r, opening_z - out_z
    if gap_r * gap_r + gap_z * gap_z <= reach_i * reach_i:
        return out_r, out_z, True
    in_r, in_z = _resting(setting, setting.inner, -1.0, -force_r, -weight_z)
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


@kernel
def _newton(setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z):
    """(place, balance, whether it is in balance) by damped Newton steps from this place."""
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
    if not (place_r == place_r):
        place_r, place_z, alone = first_place(setting, opening_r, opening_z, weight_r, weight_z)
    place_r, place_z, here, done = _newton(
        setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z
    )
    if not done and not alone:
        place_r, place_z, alone = first_place(setting, opening_r, opening_z, weight_r, weight_z)
        if not alone:
            place_r, place_z = _bracketed(setting, opening_r, opening_z, weight_r, weight_z)
        place_r, place_z, here, _ = _newton(
            setting, opening_r, opening_z, place_r, place_z, weight_r, weight_z
        )
    return place_r, place_z, here
