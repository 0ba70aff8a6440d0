"""Defects of a bearing's surfaces, waviness and spalls of raceways and of the first ball; their numbers for the core.

A ball bridges a spall: while its contact point is at x from the middle, |x| < L/2, it stands on the nearer edge, and
its centre is lower by r - sqrt(r^2 - e^2), e = L/2 - |x|, times 1 - r/R on the outer raceway and 1 + r/R on the inner
one, at most by the depth; in the middle it strikes the other edge, and the slope jumps. The contact is no point: what
it meets is the mean over its semi-minor axis, weighted by its load, which does not reach beyond the middle. The core
adds the heights to approaches (`core/bearing/surface_heights.hpp`). To read a scene needs no arrays.
"""
# ruff: noqa: RUF009 - section() declares a field; nothing is shared between instances

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from bearing_twin.base.errors import SceneError, echo
from bearing_twin.base.parameters import choice, quantity, read, section
from bearing_twin.core import INTEGER, REAL, REALS, REALS_OUT, Function
from bearing_twin.kinds.bearing.geometry import moduli, nominal_curvatures, operating_geometry

if TYPE_CHECKING:
    import numpy as np

SURFACES = ("inner", "outer", "ball")
MOST_DEFECTS = 16  # in one bearing
LONGEST_SHARE = 1.0 / 6.0  # of a surface's circumference, of a spall
WIDEST_SPALL = 2.0 * math.sin(math.radians(60.0))  # of the groove's radius: as wide as contacts go
HIGHEST_WAVE = 0.002  # of the ball's diameter, of a wave: a tenth of the greatest approach


@dataclass(frozen=True)
class Spall:
    """A pit along the path of the contacts, whose edges a ball bridges."""

    place: float = quantity(
        0.0, "rad", "of its middle, from +x; on the inner ring it turns with the ring, from there on at the start"
    )
    length: float = quantity(0.0, "m", "along rolling", at_least=0.0)
    width: float = quantity(0.0, "m", "across rolling; 0 = as wide as the contact", at_least=0.0)
    depth: float = quantity(1e-3, "m", "deeper than the ball drops changes nothing", above=0.0)


@dataclass(frozen=True)
class Defect:
    """One defect: `waviness` (order, amplitude [m], phase [rad]) or a spall."""

    on: str = choice("outer", SURFACES, "inner, outer: a raceway; ball: the first ball, on its great circle across z")
    waviness: tuple[float, float, float] = quantity(
        (0.0, 0.0, 0.0),
        "1, m, rad",
        "order, amplitude, phase: adds to approaches the cosine of order angle + phase, times the amplitude",
    )
    spall: Spall = section(Spall)

    def radius(self, geometry) -> float:
        """Radius [m] of the circle on which contacts run over it."""
        ball, pitch = 0.5 * geometry.ball_diameter, 0.5 * geometry.pitch_diameter
        return {"inner": pitch - ball, "outer": pitch + ball, "ball": ball}[self.on]


def defect_list():
    """The field of a scene: a list of mappings, as `{on: outer, spall: {place: 4.7, length: 1e-3}}`."""
    columns = (("on", "word"), ("waviness", "order, m, rad"), ("spall", "place, length, width, depth"))
    help = "of raceways and of the first ball, waviness or a spall each: heights that add to approaches"
    return dataclasses.field(
        default=(),
        metadata={
            "columns": columns, "help": help, "read": read_defects, "kind": "list", "element": Defect,
            "most": MOST_DEFECTS,
        },
    )  # fmt: skip


def read_defects(rows, _columns) -> tuple[tuple, str]:
    """(defects, "") of the list, or ((), the end of a sentence about the first problem)."""
    legal = "must be a list of {on: inner | outer | ball} with waviness or spall each"
    if not isinstance(rows, (list, tuple)) or len(rows) > MOST_DEFECTS:
        return (), f" = {echo(rows)} {legal}, {MOST_DEFECTS} at most"
    defects = []
    for index, row in enumerate(rows):
        if not isinstance(row, Mapping) or "on" not in row:
            return (), f"[{index}] = {echo(row)} {legal}"
        defect, problems = read(Defect, row)
        if problems:
            return (), f"[{index}].{problems[0]}"
        if (defect.waviness[0] != 0.0) == (defect.spall.length > 0.0):
            return (), f"[{index}] = {echo(row)} {legal}: waviness of an order above 0, or a spall with a length"
        defects.append(defect)
    return tuple(defects), ""


def defect_problems(defects: tuple[Defect, ...], geometry) -> list[str]:
    """Problems of defects that a bearing of this geometry cannot have, one sentence each."""
    problems = []
    for index, defect in enumerate(defects):
        spall, (order, amplitude, _) = defect.spall, defect.waviness
        conformity = geometry.inner_conformity if defect.on == "inner" else geometry.outer_conformity
        longest = LONGEST_SHARE * 2.0 * math.pi * defect.radius(geometry)
        widest, highest = WIDEST_SPALL * conformity * geometry.ball_diameter, HIGHEST_WAVE * geometry.ball_diameter
        rows = (
            (
                spall.length > longest,
                "spall.length",
                spall.length,
                f"at most a sixth of the way round, {longest:.4g} m",
            ),
            (spall.width > widest, "spall.width", spall.width, f"at most as wide as the groove, {widest:.4g} m"),
            (order != round(order) or order < 0.0, "waviness[0]", order, "a whole number of waves, above 0"),
            (
                abs(amplitude) > highest,
                "waviness[1]",
                amplitude,
                f"at most {highest:.3g} m, as a contact bears no more",
            ),
        )
        problems += [
            f"defects[{index}].{key} = {value:g} must be {legal}" for wrong, key, value, legal in rows if wrong
        ]
    return problems


PIECES = 128  # TABLE_PIECES of the core
LEAST_LOAD = 1.0  # N: contacts have at least the size of this load, since loads may grow

_heights = Function("core_surface_heights", None, (REALS, INTEGER, REALS, REAL, REALS_OUT))


def defect_numbers(parameters, load: float) -> "np.ndarray":
    """The numbers of `SurfaceDefects`; contacts have the size they have under this `load` [N].

    Raises SceneError for waves shorter than a contact.
    """
    import numpy as np

    from bearing_twin.contact.elasticity import ellipse

    geometry = operating_geometry(parameters)
    curvatures = np.array(nominal_curvatures(geometry))[None]
    loads, e_star = np.full((1, 2), max(load, LEAST_LOAD)), np.array(moduli(parameters.materials))
    axes = ellipse(curvatures[..., 0], curvatures[..., 1], e_star, loads)[:2]
    numbers = [float(len(parameters.defects))]
    for index, defect in enumerate(parameters.defects):
        side = 0 if defect.on == "inner" else 1
        across, along = (float(axis[0, side]) for axis in axes)
        numbers += _row_of_numbers(index, defect, geometry, across, along)
    return np.array(numbers)


def _row_of_numbers(index: int, defect: Defect, geometry, across: float, along: float) -> list[float]:
    import numpy as np

    radius, spall, (order, amplitude, phase) = defect.radius(geometry), defect.spall, defect.waviness
    if order * along > math.pi * radius:
        raise SceneError(
            f"defects[{index}].waviness[0] = {order:g} makes waves shorter than the contact, "
            f"which is {2.0 * along:.3g} m long; at most {math.floor(math.pi * radius / along)} waves"
        )
    half, width = 0.5 * spall.length + along, 0.5 * spall.width or across
    head = SURFACES.index(defect.on), order, amplitude, phase, spall.place, radius, half, width, across, along
    table = np.zeros((PIECES + 1, 2)) if order else _table(defect, geometry, half, along)
    return [*map(float, head), *table.ravel().tolist()]


def _table(defect: Defect, geometry, half: float, along: float) -> "np.ndarray":
    """Drops and their slopes per piece (pieces + 1, 2), from the middle of a spall to the end of its influence."""
    import numpy as np
    from scipy.interpolate import CubicSpline

    x = np.linspace(0.0, half, PIECES + 1)
    share, weight = np.polynomial.legendre.leggauss(64)
    reach = (x * along / (x**12 + along**12) ** (1.0 / 12.0))[:, None]  # the lesser of both, smoothly
    ball, pitch = 0.5 * geometry.ball_diameter, 0.5 * geometry.pitch_diameter
    curvature_factor = 1.0 + ball / (pitch - ball) if defect.on == "inner" else 1.0 - ball / (pitch + ball)
    edge = np.clip(0.5 * defect.spall.length - np.abs(x[:, None] + reach * share), 0.0, ball)
    drops = np.minimum((ball - np.sqrt(ball**2 - edge**2)) * curvature_factor, defect.spall.depth)
    means = drops @ (weight * 0.75 * (1.0 - share**2))
    spline = CubicSpline(x, means, bc_type=("not-a-knot", (1, 0.0)))
    return np.stack([means, spline(x, 1) * (x[1] - x[0])], axis=1)


def heights_under(numbers: "np.ndarray", azimuths: "np.ndarray", ring_angle: float = 0.0) -> "np.ndarray":
    """Heights (N, 2) [m] of the inner and the outer raceway under balls at these azimuths [rad] (N,)."""
    import numpy as np

    heights = np.empty((len(azimuths), 2))
    _heights(numbers, len(azimuths), np.ascontiguousarray(azimuths), ring_angle, heights)
    return heights
