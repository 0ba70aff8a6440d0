"""One ball between two grooves in balance: its loads, its speeds, and how what it does to the ring answers the ring.

The meridian plane of the ball has axes (radial, axial). The place of the inner groove's centre against the outer one is
the `opening`, the ball's centre against the outer groove's centre is `place`. Both contacts pull the ball towards its
groove's centre: Q_i along n_i = (opening - place)/|.|, and -Q_o along n_o = place/|.|. With t = (-n_z, n_r), and the
gyroscopic moment M_g carried by friction in the shares lambda (Harris, Rolling Bearing Analysis; Jones 1960),

    0 = Q_i n_i - Q_o n_o + F_c e_r + weight + (M_g / D) (lambda_i t_i - lambda_o t_o).

All derivatives are exact.
"""

import math
from typing import NamedTuple

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.quasi_static.forces import TINY, gradient_of, level_load, push_of, speeds_of

MOST_STEPS, MOST_HALVINGS, MOST_BISECTIONS = 40, 6, 40
EXACT = 1e-12  # of the loads: what is left of a ball's balance
NEAR = 1e-9  # of the loads: what is left of a balance whose last step is taken without a look at it
ENOUGH = 1e-9  # of the loads: as above, where rounding lets no step improve any more
SMALLEST_STEP = 4e-17  # of the groove's radius: a step below it changes nothing any more


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
