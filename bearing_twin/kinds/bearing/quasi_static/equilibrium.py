"""The inner ring in equilibrium on its balls: five coordinates (x, y, z, theta_x, theta_y), each held or free.

`core/bearing/equilibrium.hpp` finds it; here are its numbers from a scene, which raceway controls the balls, and why
there is no equilibrium.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.ellipse import ellipse as spots_at
from bearing_twin.contact.ellipse import elliptic_e
from bearing_twin.contact.friction import AUTO, POINT
from bearing_twin.kinds.bearing.clearance import operating_geometry
from bearing_twin.kinds.bearing.controls import CONTROLS, OUTER, SHARED
from bearing_twin.kinds.bearing.outputs import moduli
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, rubbing_by
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import (
    FOUND,
    NOTHING_CARRIES,
    SMOOTH,
    Contacts,
    Setting,
    contacts_in,
    limits_used,
    solved_from_nothing,
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
from bearing_twin.kinds.bearing.surface_defects import defect_numbers, heights_under

SOFT = 1e-9  # of the greatest stiffness: what is softer counts as not held
LONGEST = 0.2  # of the ball diameter: no coordinate of the ring goes further
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


class EquilibriumSolver:
    """Equilibria of one bearing with balls at these azimuths [rad] (N,), pulled at by `gravity` [m/s^2] (3,).

    `rough` are the parameters of a scene with defects, whose contacts are those of smooth raceways; None without any.
    """

    body = "the ring"
    rough, heights = None, SMOOTH
    remedy = "load it, or hold it by a displacement or by less clearance"

    def __init__(self, setting: Setting, azimuths: np.ndarray, gravity=(0.0, 0.0, 0.0), rough=None):
        self.rough = rough
        self.setting, self.azimuths, self.gravity = setting, np.array(azimuths, float), gravity
        self.balls = (len(azimuths),)
        self.longest = LONGEST * 2.0 * setting.ball_radius
        self.scales = np.array([1.0, 1.0, 1.0, setting.arm, setting.arm])

    def seats(self) -> np.ndarray:
        """The numbers of the rings (rings, SEAT) for the core."""
        return self.setting.numbers(self.gravity)[None]

    def legal(self) -> tuple[float, float]:
        """Greatest squeeze and greatest contact angle of what was found last, each over its limit."""
        contacts = contacts_in(self.contacts)
        squeeze, angle = limits_used(self.setting.ball_radius, contacts.load, contacts.approach, contacts.angle)
        return float(squeeze.max()), float(angle.max())

    def _tried(self, support: Support, share: float) -> tuple[int, float, bool]:
        """(status, what is left, whether the answer is legal) with `share` of loads and held coordinates."""
        free = np.array(support.free, np.bool_)
        wanted, held = (share * np.where(which, values, 0.0)[None] for which, values in (
            (free, support.loads), (~free, support.held)
        ))  # fmt: skip
        found = solved_from_nothing(self.seats(), self.balls, self.azimuths, free, wanted, held, self.heights)
        self.q, self.load, self.stiffness, self.place, self.contacts, left, status = (one[0] for one in found)
        return int(status), float(left), bool(status == FOUND) and max(self.legal()) <= 1.0

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
        if self.rough:
            load = float(contacts_in(self.contacts).load.max())
            numbers = defect_numbers(self.rough, moduli(self.rough.materials), load)
            self.heights = heights_under(numbers, self.azimuths)
            left = self.settle(support)
        found = self.q, self.load, self.stiffness, self.azimuths, self.place[:, :2], contacts_in(self.contacts)
        return Equilibrium(*found, left, control_named(self.setting))

    @property
    def speed(self) -> float:
        """At which the inner ring turns [rad/s]."""
        return self.setting.speed

    def _at_rest(self) -> "EquilibriumSolver":
        return EquilibriumSolver(self.setting._replace(speed=0.0), self.azimuths, self.gravity)

    def _beyond_angle(self) -> str:
        """That a contact angle of the equilibrium found last is beyond what is modelled; "" where none is."""
        squeeze, angle = self.legal()
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
                ratios = self.legal() if legal else ratios
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
    return EquilibriumSolver(setting, azimuths, tuple(parameters.gravity), parameters if parameters.defects else None)


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
    azimuths, rough = (
        azimuths_of(operating_geometry(parameters).balls, ball_angle),
        parameters if parameters.defects else None,
    )
    return EquilibriumSolver(setting, azimuths, rough=rough)


def spots_of(parameters, contacts: Contacts) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Semi-axes [m] across and along a groove, and peak pressure [Pa], each (N, 2)."""
    given = contacts.curvature_small, contacts.curvature_large, np.array(moduli(parameters.materials)), contacts.load
    return tuple(spots_at(*given))


def outer_controls(moduli: np.ndarray, contacts: Contacts) -> np.ndarray:
    """Harris' criterion of outer raceway control, Q_o a_o E_o cos(a_i - a_o) > Q_i a_i E_i, for the ball loaded most.

    a is the semi-major axis, E the complete elliptic integral of the second kind of the contact ellipse (Harris,
    Rolling Bearing Analysis, chapter on ball speeds: on the raceway that resists spin more the ball does not spin).
    `moduli` ([...,] 2) are E* of the raceways [Pa], `contacts` (..., N, 2).
    """
    ball = contacts.load[..., 0].argmax(-1)[..., None, None]
    rows = contacts.curvature_small, contacts.curvature_large, contacts.load, contacts.angle
    small, large, load, angle = (np.take_along_axis(one, ball, axis=-2)[..., 0, :] for one in rows)
    spots = spots_at(small, large, moduli, load)
    ratio = np.divide(spots.semi_minor, spots.semi_major, out=np.ones_like(load), where=load > 0.0)
    holds = load * spots.semi_major * elliptic_e(ratio)
    held_outside = holds[..., 1] * np.cos(angle[..., 0] - angle[..., 1]) > holds[..., 0]
    return held_outside & (load.min(-1) > 0.0)


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
    auto = parameters.model.control == AUTO and solver.speed
    if auto and outer_controls(np.array(moduli(parameters.materials)), found.contacts):
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
