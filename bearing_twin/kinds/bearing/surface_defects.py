"""Numbers of the defects of a scene for the core (`core/bearing/surface_heights.hpp`): waves, tables of spalls.

A ball bridges a spall: while its contact point is at x from the middle, |x| < L/2, it stands on the nearer edge, and
its centre is lower by r - sqrt(r^2 - e^2), e = L/2 - |x|, times 1 - r/R on the outer raceway and 1 + r/R on the inner
one, at most by the depth; in the middle it strikes the other edge, and the slope jumps. The contact is no point: what
it meets is the mean over its semi-minor axis, weighted by its load, which does not reach beyond the middle.
"""

import math

import numpy as np
from scipy.interpolate import CubicSpline

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.ellipse import ellipse
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.defects import SURFACES, Defect
from bearing_twin.kinds.bearing.geometry import nominal_curvatures, operating_geometry
from bearing_twin.kinds.bearing.system import approaches

PIECES = 128  # TABLE_PIECES of the core
SMOOTH_NUMBERS = np.zeros(1)
LEAST_LOAD = 1.0  # N: contacts of less are taken as this one, for loads to come

_heights = Function("core_surface_heights", None, (REALS, INTEGER, REALS, REAL, REALS_OUT))


def ball_defects(parameters) -> bool:
    """True where the first ball has a defect."""
    return any(one.on == "ball" for one in parameters.defects)


def start_load(bearing, state: np.ndarray) -> float:
    """Greatest load [N] of a contact in a state (N, COLUMNS)."""
    depth, law = max(max(approaches(bearing, row)) for row in state), bearing.outer.law
    return law.given * max(depth, 0.0) ** law.power


def defect_numbers(parameters, moduli, load: float) -> np.ndarray:
    """The numbers of `SurfaceDefects`; contacts have the size they have under this `load` [N].

    `moduli` are E* [Pa] on the inner and the outer raceway. Raises SceneError for waves shorter than a contact.
    """
    geometry = operating_geometry(parameters)
    curvatures = np.array(nominal_curvatures(geometry))[None]
    spots = ellipse(curvatures[..., 0], curvatures[..., 1], np.array(moduli), np.full((1, 2), max(load, LEAST_LOAD)))
    numbers = [float(len(parameters.defects))]
    for number, one in enumerate(parameters.defects):
        side = 0 if one.on == "inner" else 1
        numbers += _numbers_of(number, one, geometry, *(float(axis[0, side]) for axis in spots[:2]))
    return np.array(numbers)


def _numbers_of(number: int, defect: Defect, geometry, across: float, along: float) -> list[float]:
    radius, spall, (order, amplitude, phase) = defect.radius(geometry), defect.spall, defect.waviness
    if order * along > math.pi * radius:
        raise SceneError(
            f"defects[{number}].waviness[0] = {order:g} makes waves shorter than the contact, "
            f"which is {2.0 * along:.3g} m long; at most {math.floor(math.pi * radius / along)} waves"
        )
    half, width = 0.5 * spall.length + along, 0.5 * spall.width or across
    head = SURFACES.index(defect.on), order, amplitude, phase, spall.place, radius, half, width, across, along
    table = np.zeros((PIECES + 1, 2)) if order else _table(defect, geometry, half, along)
    return [*map(float, head), *table.ravel().tolist()]


def drop(defect: Defect, geometry, x: np.ndarray) -> np.ndarray:
    """How much lower [m] a rigid ball's centre is with its contact point at `x` [m] from the middle of a spall."""
    ball, pitch = 0.5 * geometry.ball_diameter, 0.5 * geometry.pitch_diameter
    bent = 1.0 + ball / (pitch - ball) if defect.on == "inner" else 1.0 - ball / (pitch + ball)
    edge = np.clip(0.5 * defect.spall.length - np.abs(x), 0.0, ball)
    return np.minimum((ball - np.sqrt(ball**2 - edge**2)) * bent, defect.spall.depth)


def _table(defect: Defect, geometry, half: float, along: float) -> np.ndarray:
    """Drops and their slopes (pieces + 1, 2), the latter a piece, from the middle to where nothing drops any more."""
    x = np.linspace(0.0, half, PIECES + 1)
    share, weight = np.polynomial.legendre.leggauss(64)
    reach = (x * along / (x**4 + along**4) ** 0.25)[:, None]  # the lesser of both, smoothly
    means = drop(defect, geometry, x[:, None] + reach * share) @ (weight * 0.75 * (1.0 - share**2))
    spline = CubicSpline(x, means, bc_type=("not-a-knot", (1, 0.0)))
    return np.stack([means, spline(x, 1) * (x[1] - x[0])], axis=1)


def heights_under(numbers: np.ndarray, azimuths: np.ndarray, ring_angle: float = 0.0) -> np.ndarray:
    """Heights (N, 2) [m] of the inner and the outer raceway under balls at these azimuths [rad] (N,)."""
    found = np.empty((len(azimuths), 2))
    _heights(numbers, len(azimuths), np.ascontiguousarray(azimuths), ring_angle, found)
    return found
