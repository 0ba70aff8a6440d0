"""The inner ring in balance: five coordinates (x, y, z, theta_x, theta_y), each held or free under its load.

A ball at azimuth psi sees the opening A_r = A_0 + x cos(psi) + y sin(psi) and
A_z = z + R (theta_x sin(psi) - theta_y cos(psi)), with the arm R of `Setting`; forces and moments come back through the
same numbers. Without speed the energy is convex in the coordinates, so the free ones are found by Newton's method with
the condensed stiffness, guarded by a bracketed search along the step for the place where the step does no more work.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.quasi_static.ball_balance import ball_in_balance
from bearing_twin.kinds.bearing.quasi_static.forces import push_of
from bearing_twin.kinds.bearing.quasi_static.newton import COORDINATES, ROUNDING, coordinates_in_balance, moved_along

PLACES = 8  # numbers kept of a ball's balance


@inlined
def _load_ball(setting, cosine, sine, q, place, weight, k):
    """Balance of ball k, begun where its place of last time leads to with the opening of now."""
    opening_r = (setting.inner.locus_radius - setting.outer.locus_radius) + q[0] * cosine + q[1] * sine
    opening_z = q[2] + setting.arm * (q[3] * sine - q[4] * cosine)
    by_r, by_z = opening_r - place[k, 2], opening_z - place[k, 3]
    place[k, 2], place[k, 3] = opening_r, opening_z
    begin_r = place[k, 0] + place[k, 4] * by_r + place[k, 5] * by_z
    begin_z = place[k, 1] + place[k, 6] * by_r + place[k, 7] * by_z
    place_r, place_z, here = ball_in_balance(
        setting, opening_r, opening_z, begin_r, begin_z, weight[k, 0], weight[k, 1]
    )
    place[k, 0], place[k, 1] = place_r, place_z
    return here


@inlined
def _add_row(stiffness, i, share, by_radial, by_axial, cosine, sine, arm):
    """Adds a ball's part to row i: `share` of a load whose derivatives by the opening are given."""
    radial, axial = share * by_radial, share * by_axial
    stiffness[i, 0] += radial * cosine
    stiffness[i, 1] += radial * sine
    stiffness[i, 2] += axial
    stiffness[i, 3] += axial * arm * sine
    stiffness[i, 4] -= axial * arm * cosine


@kernel
def ring_loads(setting, azimuths, q, place, weight, load, stiffness):
    """External load (5,) [N, N m] that holds the ring at `q` (5,), and its derivative (5, 5); returns the loads' scale.

    `azimuths` (N, 2) holds cos and sin of the balls, `weight` (N, 2) the forces on them (radial, axial). `place`
    (N, PLACES) is where their balances begin (NaN: cold) and end, with the opening there and d(place)/d(opening).
    Condensed: d(force) = (F_o - F_p G_p^-1 G_o) d(opening).
    """
    load[:] = 0.0
    stiffness[:] = 0.0
    arm, scale = setting.arm, 0.0
    for k in range(len(azimuths)):
        cosine, sine = azimuths[k, 0], azimuths[k, 1]
        here = _load_ball(setting, cosine, sine, q, place, weight, k)
        moment = arm * here.force[1] + here.friction_moment
        load[0] += cosine * here.force[0]
        load[1] += sine * here.force[0]
        load[2] += here.force[1]
        load[3] += sine * moment
        load[4] -= cosine * moment
        scale += here.scale
        a, b, c, d = here.left_p
        determinant = a * d - b * c
        if determinant == 0.0:
            place[k, 4:] = 0.0
            continue
        o, p = here.left_o, here.force_p
        inverse = 1.0 / determinant
        # d(place)/d(opening) = -G_p^-1 G_o
        rr, rz = (b * o[2] - d * o[0]) * inverse, (b * o[3] - d * o[1]) * inverse
        zr, zz = (c * o[0] - a * o[2]) * inverse, (c * o[1] - a * o[3]) * inverse
        place[k, 4], place[k, 5], place[k, 6], place[k, 7] = rr, rz, zr, zz
        f_rr = here.force_o[0] + p[0] * rr + p[1] * zr
        f_rz = here.force_o[1] + p[0] * rz + p[1] * zz
        f_zr = here.force_o[2] + p[2] * rr + p[3] * zr
        f_zz = here.force_o[3] + p[2] * rz + p[3] * zz
        m = here.friction_moment_p
        m_r = arm * f_zr + here.friction_moment_o[0] + m[0] * rr + m[1] * zr
        m_z = arm * f_zz + here.friction_moment_o[1] + m[0] * rz + m[1] * zz
        _add_row(stiffness, 0, cosine, f_rr, f_rz, cosine, sine, arm)
        _add_row(stiffness, 1, sine, f_rr, f_rz, cosine, sine, arm)
        _add_row(stiffness, 2, 1.0, f_zr, f_zz, cosine, sine, arm)
        _add_row(stiffness, 3, sine, m_r, m_z, cosine, sine, arm)
        _add_row(stiffness, 4, -cosine, m_r, m_z, cosine, sine, arm)
    return scale


@kernel
def first_ring(setting, azimuths, free, wanted, scales, longest, q):
    """Moves the free coordinates of `q` along their loads until two springs a ball, in line, would carry them.

    At most `longest` [m]. The start of Newton's method where nothing better is known.
    """
    size = 0.0
    step = np.zeros(COORDINATES)
    for i in range(COORDINATES):
        if free[i]:
            step[i] = wanted[i] / (scales[i] * scales[i])
            size += (wanted[i] / scales[i]) ** 2
    size = math.sqrt(size)
    if size == 0.0:
        return
    for i in range(COORDINATES):
        step[i] /= size
    middle = setting.inner.locus_radius - setting.outer.locus_radius
    reach_i = setting.inner.groove_radius - setting.ball_radius
    reach_o = setting.outer.groove_radius - setting.ball_radius
    deep, power = 1e-6, setting.inner.law.power
    # two springs in line, softest where each alone has half the approach
    one = push_of(setting, setting.inner, -1.0, reach_i + deep, 0.0).load / deep**power
    two = push_of(setting, setting.outer, 1.0, reach_o + deep, 0.0).load / deep**power
    spring = (one ** (-1.0 / power) + two ** (-1.0 / power)) ** -power
    low, high, at = 0.0, longest, 0.0
    for _ in range(24):
        at = 0.5 * (low + high)
        total = 0.0
        for k in range(len(azimuths)):
            cosine, sine = azimuths[k, 0], azimuths[k, 1]
            along_r = step[0] * cosine + step[1] * sine
            along_z = step[2] + setting.arm * (step[3] * sine - step[4] * cosine)
            opening_r = middle + q[0] * cosine + q[1] * sine + at * along_r
            opening_z = q[2] + setting.arm * (q[3] * sine - q[4] * cosine) + at * along_z
            distance = math.sqrt(opening_r * opening_r + opening_z * opening_z)
            squeeze = distance - reach_i - reach_o
            if squeeze > 0.0:
                total += spring * squeeze**power * (opening_r * along_r + opening_z * along_z) / distance
        if total < size:
            low = at
        else:
            high = at
    moved_along(q, step, at, q)


@inlined
def _of_ring(ring, q, load, stiffness):
    setting, azimuths, place, weight = ring
    return ring_loads(setting, azimuths, q, place, weight, load, stiffness)


@kernel
def ring_in_balance(setting, azimuths, q, free, wanted, place, weight, longest, load, stiffness):
    """Moves the free coordinates of the ring to where `wanted` (5,) loads them; (status, what is left [N], scale [N]).

    `q` (5,) is the start and the answer, `free` (5,) tells which coordinates are; `load` and `stiffness` are those of
    the answer (`ring_loads`). No coordinate goes further than `longest` [m] from the middle.
    """
    scales = np.array([1.0, 1.0, 1.0, setting.arm, setting.arm])
    rounding = ROUNDING * (setting.inner.locus_radius - setting.outer.locus_radius)
    ring = (setting, azimuths, place, weight)
    return coordinates_in_balance(_of_ring, ring, scales, rounding, free, wanted, longest, q, load, stiffness)
