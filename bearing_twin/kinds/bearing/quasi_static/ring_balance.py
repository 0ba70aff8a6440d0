"""The inner ring in balance: five coordinates (x, y, z, theta_x, theta_y), each held or free under its load.

A ball sees them as its `opening`; forces and moments come back through its derivatives. Without speed the energy is
nearly convex in the coordinates, so the free ones are found by Newton's method with the condensed stiffness, guarded by
a bracketed search along the step for the place where the step does no more work.
"""

import math

import numpy as np

from bearing_twin.compiled import inlined, kernel
from bearing_twin.kinds.bearing.quasi_static.ball_balance import ball_in_balance
from bearing_twin.kinds.bearing.quasi_static.forces import push_of
from bearing_twin.kinds.bearing.quasi_static.newton import COORDINATES, ROUNDING, coordinates_in_balance, moved_along
from bearing_twin.kinds.bearing.quasi_static.opening import opening_of, slopes_of

PLACES = 8  # numbers kept of a ball's balance


@inlined
def _load_ball(setting, opening, place, weight, k):
    """Balance of ball k, begun where its place of last time leads to with the opening of now."""
    by_r, by_z = opening.radial - place[k, 2], opening.axial - place[k, 3]
    place[k, 2], place[k, 3] = opening.radial, opening.axial
    begin_r = place[k, 0] + place[k, 4] * by_r + place[k, 5] * by_z
    begin_z = place[k, 1] + place[k, 6] * by_r + place[k, 7] * by_z
    place_r, place_z, here = ball_in_balance(
        setting, opening.radial, opening.axial, begin_r, begin_z, weight[k, 0], weight[k, 1]
    )
    place[k, 0], place[k, 1] = place_r, place_z
    return here


@inlined
def _add_row(stiffness, i, one, by_one, two, by_two):
    """Adds to row i two loads in these shares, whose derivatives by each coordinate are given."""
    # written out: a tuple that a loop reaches into is kept in memory
    stiffness[i, 0] += one * by_one[0] + two * by_two[0]
    stiffness[i, 1] += one * by_one[1] + two * by_two[1]
    stiffness[i, 2] += one * by_one[2] + two * by_two[2]
    stiffness[i, 3] += one * by_one[3] + two * by_two[3]
    stiffness[i, 4] += one * by_one[4] + two * by_two[4]


@inlined
def _by_coordinates(radial, axial, by_radial, by_axial):
    """Derivatives by the five coordinates of what has these by the opening, whose own are given (`slopes_of`)."""
    return (
        by_radial * radial[0] + by_axial * axial[0],
        by_radial * radial[1] + by_axial * axial[1],
        by_axial,
        by_axial * axial[2],
        by_axial * axial[3],
    )


@inlined
def _add_turning(stiffness, radial, axial):
    """Adds what forces on the ring do as the opening's slopes change with the coordinates.

    `radial` [N/m] and `axial` [N] are sums of forces, over r the former, times sin^2, sin cos and cos^2 of the azimuth.
    """
    stiffness[0, 0] -= radial[0]
    stiffness[0, 1] += radial[1]
    stiffness[1, 0] += radial[1]
    stiffness[1, 1] -= radial[2]
    stiffness[0, 3] += axial[1]
    stiffness[3, 0] += axial[1]
    stiffness[0, 4] += axial[0]
    stiffness[4, 0] += axial[0]
    stiffness[1, 3] -= axial[2]
    stiffness[3, 1] -= axial[2]
    stiffness[1, 4] -= axial[1]
    stiffness[4, 1] -= axial[1]


@kernel
def ring_loads(setting, azimuths, q, place, weight, load, stiffness):
    """External load (5,) [N, N m] that holds the ring at `q` (5,), and its derivative (5, 5); returns the loads' scale.

    `azimuths` (N, 2) holds cos and sin of the balls, `weight` (N, 2) the forces on them (radial, axial). `place`
    (N, PLACES) is where their balances begin (NaN: cold) and end, with the opening there and d(place)/d(opening).
    Condensed: d(force) = (F_o - F_p G_p^-1 G_o) d(opening).
    """
    load[:] = 0.0
    stiffness[:] = 0.0
    scale, near = 0.0, 2.0 / setting.pitch_diameter
    r_ss = r_sc = r_cc = z_ss = z_sc = z_cc = 0.0
    for k in range(len(azimuths)):
        cosine, sine = azimuths[k, 0], azimuths[k, 1]
        opening = opening_of(setting, cosine, sine, q)
        here = _load_ball(setting, opening, place, weight, k)
        radial, axial = slopes_of(setting, cosine, sine, opening)
        load[0] += radial[0] * here.force[0] + axial[0] * here.force[1]
        load[1] += radial[1] * here.force[0] + axial[1] * here.force[1]
        load[2] += here.force[1]
        load[3] += axial[2] * here.force[1] + sine * here.friction_moment
        load[4] += axial[3] * here.force[1] - cosine * here.friction_moment
        scale += here.scale
        force_r, force_z = here.force
        ss, sc, cc = sine * sine, sine * cosine, cosine * cosine
        r_ss, r_sc, r_cc = r_ss + force_r * ss, r_sc + force_r * sc, r_cc + force_r * cc
        z_ss, z_sc, z_cc = z_ss + force_z * ss, z_sc + force_z * sc, z_cc + force_z * cc
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
        m_r = here.friction_moment_o[0] + m[0] * rr + m[1] * zr
        m_z = here.friction_moment_o[1] + m[0] * rz + m[1] * zz
        by_radial = _by_coordinates(radial, axial, f_rr, f_rz)
        by_axial = _by_coordinates(radial, axial, f_zr, f_zz)
        by_moment = _by_coordinates(radial, axial, m_r, m_z)
        _add_row(stiffness, 0, radial[0], by_radial, axial[0], by_axial)
        _add_row(stiffness, 1, radial[1], by_radial, axial[1], by_axial)
        _add_row(stiffness, 2, 1.0, by_axial, 0.0, by_axial)
        _add_row(stiffness, 3, axial[2], by_axial, sine, by_moment)
        _add_row(stiffness, 4, axial[3], by_axial, -cosine, by_moment)
    _add_turning(stiffness, (near * r_ss, near * r_sc, near * r_cc), (z_ss, z_sc, z_cc))
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
    reach_i = setting.inner.groove_radius - setting.ball_radius
    reach_o = setting.outer.groove_radius - setting.ball_radius
    deep, power = 1e-6, setting.inner.law.power
    # two springs in line, softest where each alone has half the approach
    one = push_of(setting, setting.inner, reach_i + deep, 0.0).load / deep**power
    two = push_of(setting, setting.outer, reach_o + deep, 0.0).load / deep**power
    spring = (one ** (-1.0 / power) + two ** (-1.0 / power)) ** -power
    low, high, at, moved = 0.0, longest, 0.0, np.empty(COORDINATES)
    for _ in range(24):
        at = 0.5 * (low + high)
        moved_along(q, step, at, moved)
        total = 0.0
        for k in range(len(azimuths)):
            cosine, sine = azimuths[k, 0], azimuths[k, 1]
            along_r = step[0] * cosine + step[1] * sine
            along_z = step[2] + setting.arm * (step[3] * sine - step[4] * cosine)
            opening = opening_of(setting, cosine, sine, moved)
            distance = math.sqrt(opening.radial * opening.radial + opening.axial * opening.axial)
            squeeze = distance - reach_i - reach_o
            if squeeze > 0.0:
                total += spring * squeeze**power * (opening.radial * along_r + opening.axial * along_z) / distance
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
