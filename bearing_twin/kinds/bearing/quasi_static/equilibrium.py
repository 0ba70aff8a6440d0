"""The inner ring in equilibrium on its balls: five coordinates (x, y, z, theta_x, theta_y), each held or free.

A ball sees the coordinates as its `opening`; forces and moments come back through its derivatives. The free coordinates
are found by Newton's method with the condensed stiffness of the balls, guarded by a bracketed search along the step for
the place where the step does no more work (without speed the energy is nearly convex).
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.compiled import inlined, kernel, template
from bearing_twin.contact.ellipse import elliptic_b_d
from bearing_twin.contact.materials import effective_modulus
from bearing_twin.contact.names import AUTO, POINT
from bearing_twin.kinds.bearing.clearance import operating_geometry
from bearing_twin.kinds.bearing.controls import CONTROLS, OUTER, SHARED
from bearing_twin.kinds.bearing.outputs import ellipses
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, rubbing_by
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import (
    PLACES,
    Contacts,
    Setting,
    ball_in_balance,
    contacts_at,
    limits_used,
    opening_of,
    push_of,
    slopes_of,
)
from bearing_twin.kinds.bearing.rings import (
    COORDINATES as NAMES,
)
from bearing_twin.kinds.bearing.rings import (
    FREE_RING,
    INNER_LAND,
    dimension_of,
    free_coordinates,
    moving_centre,
)
from bearing_twin.kinds.bearing.start import bearing_of

COORDINATES = 5
MOST_STEPS, MOST_TRIALS, MOST_LOOKS = 80, 40, 300  # what is found takes 226 evaluations of all balls at most, most 50
EXACT = 1e-11  # of the loads: what is left of the balance
ENOUGH = 1e-10  # of the loads: as above, where no step improves any more
ROUNDING = 4e-15  # of the opening: what the place of a ball is known to
SOFT = 1e-9  # of the greatest stiffness: what is softer counts as not held
FOUND, NOTHING_CARRIES, TOO_MUCH = range(3)
LONGEST = 0.2  # of the ball diameter: no coordinate of the ring goes further
STAGES = 12  # a load that is not found at once is approached in so many parts
COARSE, HALVINGS, UNFOUND = 8.0, 14, 4  # for the greatest load: steps down, halvings, as how many a slow one counts
CARRIES, HEAVY = 1e-6, 1e6  # share of a load, of HEAVY [N] at most, below which the greatest load is none


class Support(NamedTuple):
    """What holds the inner ring: of x, y, z, theta_x, theta_y which are `free`, their loads, and where others are held.

    `loads` [N, N m] (5,) act on the ring, `held` [m, rad] (5,) are coordinates; each counts where it applies.
    """

    free: tuple
    loads: tuple
    held: tuple


class Equilibrium(NamedTuple):
    """A bearing in balance: ring `coordinates` (5,), external `loads` (5,), `stiffness` (5, 5) of loads by coordinates.

    `azimuths` [rad] (N,), `places` (N, 2) of the balls, `contacts`; `left` [N] is missing of the ring's balance;
    `control` names the raceway control of the balls.
    """

    coordinates: np.ndarray
    loads: np.ndarray
    stiffness: np.ndarray
    azimuths: np.ndarray
    places: np.ndarray
    contacts: Contacts
    left: float
    control: str


@kernel
def _solved(matrix, right, free, scales, step):
    """The Newton step of the free coordinates by elimination; False where something does not hold the ring.

    Rows and columns are scaled by `scales` [1 or m] and taken by the greatest pivot on the diagonal, as the matrix is
    nearly symmetric and has no negative direction; a soft pivot is lifted: what nothing holds stays where it is.
    """
    n = 0
    index = np.empty(COORDINATES, np.int64)
    for i in range(COORDINATES):
        step[i] = 0.0
        if free[i]:
            index[n] = i
            n += 1
    a = np.empty((COORDINATES, COORDINATES + 1))
    greatest = 0.0
    for i in range(n):
        for j in range(n):
            a[i, j] = matrix[index[i], index[j]] / (scales[index[i]] * scales[index[j]])
        a[i, n] = right[index[i]] / scales[index[i]]
        greatest = max(greatest, abs(a[i, i]))
    if greatest == 0.0:
        return False
    held = True
    for i in range(n):
        best = i
        for r in range(i + 1, n):
            if a[r, r] > a[best, best]:
                best = r
        if best != i:
            index[i], index[best] = index[best], index[i]
            for j in range(n + 1):
                a[i, j], a[best, j] = a[best, j], a[i, j]
            for r in range(n):
                a[r, i], a[r, best] = a[r, best], a[r, i]
        if a[i, i] < SOFT * greatest:
            held = False
            a[i, i] = greatest
        for r in range(i + 1, n):
            factor = a[r, i] / a[i, i]
            for j in range(i, n + 1):
                a[r, j] -= factor * a[i, j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            a[i, n] -= a[i, j] * a[j, n]
        a[i, n] /= a[i, i]
        step[index[i]] = a[i, n] / scales[index[i]]
    return held


@kernel
def _missing(wanted, load, free, scales, left):
    """What is missing of the wanted loads of the free coordinates into `left`; its size [N]."""
    size = 0.0
    for i in range(COORDINATES):
        left[i] = wanted[i] - load[i] if free[i] else 0.0
        size = max(size, abs(left[i]) / scales[i])
    return size


@kernel
def _work(step, left):
    """Work of the missing loads along a step: positive while going on lowers the energy."""
    total = 0.0
    for i in range(COORDINATES):
        total += step[i] * left[i]
    return total


@kernel
def moved_along(q, step, factor, out):
    """Coordinates a part of a step further, into `out`."""
    for i in range(COORDINATES):
        out[i] = q[i] + factor * step[i]


@kernel
def _size(q, scales):
    """The greatest coordinate as a displacement [m]."""
    greatest = 0.0
    for i in range(COORDINATES):
        greatest = max(greatest, abs(q[i]) * scales[i])
    return greatest


@kernel
def _stiffest(stiffness, scales):
    """The greatest stiffness against a displacement [N/m]."""
    greatest = 0.0
    for i in range(COORDINATES):
        greatest = max(greatest, abs(stiffness[i, i]) / (scales[i] * scales[i]))
    return greatest


@template
def coordinates_in_balance(loads_at, system, scales, rounding, free, wanted, longest, q, load, stiffness):
    """Moves the free coordinates to where `wanted` (5,) loads them; (status, what is left [N], scale of the loads [N]).

    `loads_at(system, q, load, stiffness)` fills `load` (5,) [N, N m] that holds the coordinates at `q` (5,) and its
    derivative (5, 5), and gives the loads' scale. `q` is the start and the answer, `free` (5,) tells which coordinates
    are. `scales` (5,) [1 or m] make displacements of tilts, `rounding` [m] is what a place is known to. No coordinate
    goes further than `longest` [m] from the middle.
    """
    step, left, trial = np.empty(COORDINATES), np.empty(COORDINATES), np.empty(COORDINATES)
    scale = loads_at(system, q, load, stiffness)
    size = _missing(wanted, load, free, scales, left)
    asked = 0.0
    for i in range(COORDINATES):
        asked = max(asked, abs(wanted[i]) / scales[i] if free[i] else 0.0)
    cap, looks = 0.05 * longest, 0
    for _ in range(MOST_STEPS):
        if size <= EXACT * max(asked, 1e-3 * scale) or size <= rounding * _stiffest(stiffness, scales):
            break
        held = _solved(stiffness, left, free, scales, step)
        length = _size(step, scales)
        if _work(step, left) <= 0.0 or length == 0.0:
            # nothing resists: along what is missing
            for i in range(COORDINATES):
                step[i] = left[i] / (scales[i] * scales[i]) / size * cap
            held, length = False, cap
        if length > cap:
            for i in range(COORDINATES):
                step[i] *= cap / length
        begin = _work(step, left)
        before, factor, low, high = size, 1.0, 0.0, math.inf
        for _ in range(MOST_TRIALS):
            looks += 1
            moved_along(q, step, factor, trial)
            if _size(trial, scales) > longest:
                return TOO_MUCH, size, scale
            scale = loads_at(system, trial, load, stiffness)
            size = _missing(wanted, load, free, scales, left)
            work = _work(step, left)
            if size < 0.7 * before or abs(work) <= 0.3 * begin:
                break
            if work > 0.0:
                low = factor
                if held:
                    break
            else:
                high = factor
            factor = 2.0 * factor if high == math.inf else 0.5 * (low + high)
        stalled = size >= before
        for i in range(COORDINATES):
            q[i] = trial[i]
        if looks >= MOST_LOOKS or (stalled and size <= ENOUGH * max(asked, 1e-3 * scale)):
            break
    carried = abs(load[0]) + abs(load[1]) + abs(load[2]) + abs(load[3]) + abs(load[4])
    if size > max(1e-9 * max(asked, 1e-3 * scale), rounding * _stiffest(stiffness, scales)):
        return TOO_MUCH, size, scale
    any_free = free[0] or free[1] or free[2] or free[3] or free[4]
    if any_free and carried == 0.0 and stiffness[0, 0] == 0.0 and stiffness[2, 2] == 0.0:
        return NOTHING_CARRIES, size, scale
    return FOUND, size, scale


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


@inlined
def at_speed(setting, speed):
    """The numbers of the balance with the ring turning at `speed` [rad/s]."""
    return Setting(
        setting.inner,
        setting.outer,
        setting.ball_radius,
        setting.ball_mass,
        setting.pitch_diameter,
        setting.arm,
        setting.lever,
        speed,
        setting.share_inner,
        setting.share_outer,
        setting.unseen,
    )


@kernel
def place_balls(setting, gravity, azimuth, directions, weight):
    """Cosines and sines of evenly spaced balls, and the weights on them (radial, axial)."""
    balls = len(directions)
    for k in range(balls):
        angle = azimuth + 2.0 * math.pi * k / balls
        directions[k, 0], directions[k, 1] = math.cos(angle), math.sin(angle)
        weight[k, 0] = setting.ball_mass * (gravity[0] * directions[k, 0] + gravity[1] * directions[k, 1])
        weight[k, 1] = setting.ball_mass * gravity[2]


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


def setting_of(parameters, law: str, speed: float, arm: str = "groove") -> Setting:
    """The numbers of the equilibrium for a scene, `shared` where `model.control` is left to the criterion.

    `arm` of a tilt: "groove", to the inner groove's centre, the true geometry; or "pitch", to the pitch circle, as
    commercial programs have it.
    """
    bearing = bearing_of(rubbing_by(parameters, POINT), law)  # equilibria hold no friction
    lever, reach = bearing.inner.groove_radius, bearing.inner.locus_radius
    if arm == "pitch":
        lever, reach = bearing.ball_radius, 0.5 * parameters.geometry.pitch_diameter
    pitch = parameters.geometry.pitch_diameter
    sizes = bearing.ball_radius, bearing.ball_mass, pitch, reach, lever, float(speed)
    return Setting(bearing.inner, bearing.outer, *sizes, *CONTROLS[parameters.model.control], 0.0)


def support_of(parameters) -> Support:
    """What the scene itself says: its loads, and where its drive holds the rest."""
    ring, drive = parameters.rings.inner, parameters.drive
    return Support(free_coordinates(parameters), (*ring.load, *ring.moment), (*drive.offset, *drive.tilt))


def weighed_support(parameters, loads=None) -> Support:
    """`support_of`, with `loads` (5,) [N, N m] in place of the scene's where given, and with the weights on the ring.

    Those are its own, where it has mass, and that of a cage that rests on its land.
    """
    found, ring, cage = support_of(parameters), parameters.rings.inner, parameters.cage
    acting, gravity = np.array(found.loads if loads is None else loads, float), np.array(parameters.gravity, float)
    if dimension_of(parameters) == FREE_RING:
        acting[:3] += ring.mass * gravity
        if moving_centre(parameters) and cage.guidance == INNER_LAND:
            acting[:2] += cage.mass * gravity[:2]
    return found._replace(loads=tuple(np.where(found.free, acting, 0.0).tolist()))


def load_line(support: Support) -> float:
    """Azimuth [rad] of what pushes the ring sideways: load, else displacement, else tilting, else 0."""
    for values in (support.loads, support.held):
        for x, y in (values[:2], values[3:]):
            if x or y:
                return math.atan2(y, x)
    return 0.0


def azimuths_of(balls: int, first: float) -> np.ndarray:
    """Azimuths [rad] (N,) of balls evenly spaced from `first` on."""
    return first + 2.0 * math.pi * np.arange(balls) / balls


def weights_of(parameters, setting: Setting, azimuths: np.ndarray) -> np.ndarray:
    """Weights [N] of balls at these azimuths (N,), radial and axial, (N, 2)."""
    x, y, z = parameters.gravity
    radial = x * np.cos(azimuths) + y * np.sin(azimuths)
    return setting.ball_mass * np.stack([radial, np.full(len(azimuths), z)], axis=1)


class EquilibriumSolver:
    """Equilibria of one bearing; what it found last is where it looks first."""

    body = "the ring"
    remedy = "load it, or hold it by a displacement or by less clearance"

    def __init__(self, setting: Setting, azimuths: np.ndarray, weights: np.ndarray | None = None):
        balls = len(azimuths)
        self.setting, self.azimuths = setting, azimuths
        self.directions = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
        self.weights = np.zeros((balls, 2)) if weights is None else weights
        self.longest = LONGEST * 2.0 * setting.ball_radius
        self.scales = np.array([1.0, 1.0, 1.0, setting.arm, setting.arm])
        self.q, self.load, self.stiffness = np.zeros(5), np.zeros(5), np.zeros((5, 5))
        self.place = np.full((balls, PLACES), np.nan)

    def _cold(self, support: Support, share: float) -> tuple[int, float]:
        """From nothing: along the load, then by Newton's method, `share` of loads and held coordinates."""
        free = np.array(support.free, np.bool_)
        wanted = share * np.where(free, support.loads, 0.0)
        self.q[:] = share * np.where(free, 0.0, support.held)
        self.place[:] = np.nan
        if not free.any():
            return self._held()
        self._begin(free, wanted)
        return self._newton(free, wanted)

    def _begin(self, free, wanted) -> None:
        first_ring(self.setting, self.directions, free, wanted, self.scales, self.longest, self.q)

    def _held(self):
        ring_loads(self.setting, self.directions, self.q, self.place, self.weights, self.load, self.stiffness)
        return FOUND, 0.0

    def _newton(self, free, wanted):
        numbers = self.q, free, wanted, self.place, self.weights, self.longest, self.load, self.stiffness
        status, left, _ = ring_in_balance(self.setting, self.directions, *numbers)
        return status, left

    def _stepwise(self, support: Support, share: float) -> tuple[int, float]:
        """As `_cold`, each part of the load beginning where the one before ended."""
        free = np.array(support.free, np.bool_)
        status, left = self._cold(support, share / STAGES)
        for stage in range(2, STAGES + 1):
            if status != FOUND:
                return status, left
            part = share * stage / STAGES
            self.q[~free] = part * np.array(support.held)[~free]
            status, left = self._newton(free, part * np.where(free, support.loads, 0.0))
        return status, left

    def _legal(self) -> tuple[float, float]:
        """Greatest squeeze and greatest contact angle, each over its limit."""
        contacts = contacts_at(self.setting, self.directions, self.q, self.place)
        squeeze, angle = limits_used(self.setting, contacts.load, contacts.approach, contacts.angle)
        return float(squeeze.max()), float(angle.max())

    def _tried(self, support: Support, share: float) -> tuple[int, float, bool]:
        """(status, what is left, whether the answer is legal) with `share` of loads and held coordinates."""
        status, left = self._cold(support, share)
        if status not in (FOUND, NOTHING_CARRIES):
            status, left = self._stepwise(support, share)
        return status, left, status == FOUND and max(self._legal()) <= 1.0

    def settle(self, support: Support) -> float:
        """Puts `q`, `load` and `stiffness` where all is in balance; what is left of it [N].

        Raises SceneError with the greatest load, or with the support that is missing.
        """
        status, left, legal = self._tried(support, 1.0)
        if status == NOTHING_CARRIES:
            raise SceneError(self._nothing_carries(support))
        if not legal:
            raise SceneError(self._refusal(support, status))
        return left

    def solve(self, support: Support) -> Equilibrium:
        """The equilibrium; raises SceneError as `settle` does."""
        left = self.settle(support)
        contacts = contacts_at(self.setting, self.directions, self.q, self.place)
        arrays = self.q.copy(), self.load.copy(), self.stiffness.copy(), self.azimuths, self.place[:, :2].copy()
        return Equilibrium(*arrays, contacts, left, control_named(self.setting))

    @property
    def speed(self) -> float:
        """At which the inner ring turns [rad/s]."""
        return self.setting.speed

    def _at_rest(self) -> "EquilibriumSolver":
        return EquilibriumSolver(self.setting._replace(speed=0.0), self.azimuths, self.weights)

    def _beyond_angle(self) -> str:
        """That a contact angle of the equilibrium found last is beyond what is modelled; "" where none is."""
        squeeze, angle = self._legal()
        if not angle > max(1.0, squeeze):
            return ""
        greatest = math.degrees(GREATEST_ANGLE)
        return f"leans a contact to {angle * greatest:.3g} degrees, beyond the {greatest:.3g} degrees that are modelled"

    def _too_fast(self, support: Support, beyond: str) -> str:
        """That the speed alone is too much for a load that is carried at rest, "" where it is not."""
        speed = self.speed
        if not (speed and self._at_rest()._tried(support, 1.0)[2]):
            return ""
        why = f"{beyond}, as the balls are thrown outwards" if beyond else "throws the balls outwards too far"
        what = f"{_what_acts(support)} is carried at rest; a speed of {speed:g} rad/s {why}"
        return f"{what}; lower the speed, or load the bearing more along its axis"

    def _greatest(self, support: Support) -> tuple[float, tuple[float, float]]:
        """The greatest legal share of loads and held coordinates, 0 where there is none, and how near its limits it is.

        It is looked for among ever smaller ones, then between the last two.
        """
        free = np.array(support.free, np.bool_)
        heaviest = np.abs(np.where(free, support.loads, 0.0) / self.scales).max()
        furthest = np.abs(np.where(free, 0.0, support.held) * self.scales).max()
        least = CARRIES / max(1.0, heaviest / HEAVY, furthest / self.longest)
        low, high, ratios = 0.0, 1.0, (0.0, 0.0)
        share, halvings = 1.0 / COARSE, 0
        while halvings < HALVINGS and high > least:
            status, _, legal = self._tried(support, share)
            # too little to touch anything is no reason against a greater load
            if legal or status == NOTHING_CARRIES:
                low = share
                ratios = self._legal() if legal else ratios
            else:
                high = share
            halvings += (1 if status in (FOUND, NOTHING_CARRIES) else UNFOUND) if low > 0.0 else 0
            share = 0.5 * (low + high) if low else high / COARSE
        return low, ratios

    def _nothing_carries(self, support: Support) -> str:
        free = ", ".join(name for name, one in zip(NAMES, support.free, strict=True) if one)
        return f"no ball touches both rings, so that nothing holds {self.body} along {free}; {self.remedy}"

    def _refusal(self, support: Support, status: int) -> str:
        """Why there is no legal equilibrium, with the greatest share of loads and held coordinates there is.

        That a load is carried at rest is said first, for the greatest at such a speed takes long and tells less.
        """
        if sentence := self._too_fast(support, self._beyond_angle() if status == FOUND else ""):
            return sentence
        low, ratios = self._greatest(support)
        what = _what_acts(support)
        if low == 0.0:
            return f"{what} finds no contact that carries it; hold {self.body} in this direction, or turn the load"
        how = f"pushes {self.body} through the balls: a contact is squeezed by at most 2 % of the ball's diameter"
        if ratios[1] > ratios[0]:
            how = f"tilts the contacts out of the grooves, beyond {math.degrees(GREATEST_ANGLE):.3g} degrees"
        return f"{what} {how}; the greatest in this direction is {_what_acts(support, low)}"


def _what_acts(support: Support, share: float = 1.0) -> str:
    """The loads and held coordinates in words."""
    rows = [
        (f"{words} of {_vector(values[part], share)} {unit}")
        for words, unit, values, part, used in (
            ("a load", "N", support.loads, slice(0, 3), support.free[:3]),
            ("a moment", "N m", support.loads, slice(3, 5), support.free[3:]),
            ("a displacement", "m", support.held, slice(0, 3), [not one for one in support.free[:3]]),
            ("a misalignment", "rad", support.held, slice(3, 5), [not one for one in support.free[3:]]),
        )
        if any(value and one for value, one in zip(values[part], used, strict=True))
    ]
    return " with ".join(rows) or "no load"


def _vector(values, share) -> str:
    return "(" + ", ".join(f"{share * value:.4g}" for value in values) + ")"


def weighed_solver(parameters, setting: Setting, azimuths: np.ndarray) -> EquilibriumSolver:
    """The solver for balls at these azimuths [rad] (N,) that the scene's gravity pulls at."""
    return EquilibriumSolver(setting, azimuths, weights_of(parameters, setting, azimuths))


def loose_directions(found: Equilibrium, support: Support, scales) -> list[str]:
    """The free coordinates that nothing holds at an equilibrium: their stiffness is rounding, or below 0."""
    scaled = found.stiffness / np.outer(scales, scales)
    greatest = np.abs(scaled).max()
    return [
        name
        for i, (name, one) in enumerate(zip(NAMES, support.free, strict=True))
        if one and scaled[i, i] <= SOFT * greatest
    ]


def solver_of(parameters, law, ball_angle=0.0, arm="groove") -> EquilibriumSolver:
    """The solver of a scene without gravity, ball 0 at `ball_angle` [rad]; see `setting_of`."""
    setting = setting_of(parameters, law, parameters.drive.speed, arm)
    return EquilibriumSolver(setting, azimuths_of(operating_geometry(parameters).balls, ball_angle))


def spots_of(parameters, contacts: Contacts) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Semi-axes [m] across and along a groove, and peak pressure [Pa], each (N, 2)."""
    materials = parameters.materials
    moduli = tuple(effective_modulus(materials.ball, ring) for ring in (materials.inner_ring, materials.outer_ring))
    return ellipses(moduli, contacts.curvature_small, contacts.curvature_large, contacts.load)


def outer_control(parameters, contacts: Contacts) -> bool:
    """Harris' criterion of outer raceway control, Q_o a_o E_o cos(a_i - a_o) > Q_i a_i E_i, for the ball loaded most.

    a is the semi-major axis, E the complete elliptic integral of the second kind of the contact ellipse (Harris,
    Rolling Bearing Analysis, chapter on ball speeds: on the raceway that resists spin more the ball does not spin).
    """
    ball = int(contacts.load[:, 0].argmax())
    if contacts.load[ball].min() <= 0.0:
        return False
    major, minor, _ = spots_of(parameters, contacts)
    holds = []
    for side in range(2):
        ratio = float(minor[ball, side] / major[ball, side])
        b, d = elliptic_b_d(ratio)
        holds.append(contacts.load[ball, side] * major[ball, side] * (b + ratio * ratio * d))
    return bool(holds[1] * math.cos(contacts.angle[ball, 0] - contacts.angle[ball, 1]) > holds[0])


def control_named(setting: Setting) -> str:
    """The name of the raceway control with these shares of the gyroscopic moment; "none" where no raceway takes any."""
    shares = setting.share_inner, setting.share_outer
    return next((name for name, its in CONTROLS.items() if its == shares and name != AUTO), "none")


def controlled(parameters, solver: EquilibriumSolver, support: Support) -> Equilibrium:
    """The equilibrium with the raceway control that `model.control` names, `auto` by Harris' criterion.

    With `auto` balls are first taken as `shared`; where the criterion then says so the outer raceway controls them, and
    else it stays so (Harris: both raceways carry the moment). `solver` keeps the control. Raises SceneError.
    """
    found = solver.solve(support)
    if parameters.model.control == AUTO and solver.speed and outer_control(parameters, found.contacts):
        inner, outer = CONTROLS[OUTER]
        solver.setting = solver.setting._replace(share_inner=inner, share_outer=outer)
        found = solver.solve(support)
    return found


def control_reason(parameters, found: Equilibrium) -> str:
    """Why the balls of an equilibrium have their raceway control, in words."""
    if parameters.model.control != AUTO:
        return "as the scene asks"
    if found.control == SHARED:
        return "both raceways carry the gyroscopic moment, as the criterion of Harris for outer control is not met"
    return "by the criterion of Harris, as the outer raceway resists spin more"


@functools.lru_cache(4)
def scene_equilibrium(parameters, law: str) -> Equilibrium:
    """`controlled`, as the scene loads its ring or holds it; raises SceneError."""
    return controlled(parameters, solver_of(parameters, law), support_of(parameters))
