"""The static answer of a bearing: from a scene and what loads or holds its inner ring to displacements and loads."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.names import POINT
from bearing_twin.errors import SceneError
from bearing_twin.kinds.bearing.clearance import operating_geometry
from bearing_twin.kinds.bearing.parameters import GREATEST_ANGLE, rubbing_by
from bearing_twin.kinds.bearing.quasi_static.contacts import Contacts, contacts_at, limits_used
from bearing_twin.kinds.bearing.quasi_static.forces import Setting
from bearing_twin.kinds.bearing.quasi_static.newton import FOUND, NOTHING_CARRIES, SOFT
from bearing_twin.kinds.bearing.quasi_static.ring_balance import PLACES, first_ring, ring_in_balance, ring_loads
from bearing_twin.kinds.bearing.quasi_static.shares import CONTROLS, control_of
from bearing_twin.kinds.bearing.rings import (
    COORDINATES,
    FREE_RING,
    INNER_LAND,
    dimension_of,
    free_coordinates,
    moving_centre,
)
from bearing_twin.kinds.bearing.start import bearing_of

ARMS = ("groove", "pitch")
"""Arm of a tilt: to the inner groove's centre, the true geometry; or to the pitch circle, as commercial programs do."""
LONGEST = 0.2  # of the ball diameter: no coordinate of the ring goes further
STAGES = 12  # a load that is not found at once is approached in so many parts
COARSE, HALVINGS, UNFOUND = 8.0, 14, 4  # for the greatest load: steps down, halvings, as how many a slow one counts
CARRIES, HEAVY = 1e-6, 1e6  # share of a load, of HEAVY [N] at most, below which the greatest load is none
UNITS = ("N", "N", "N", "N m", "N m")


class Support(NamedTuple):
    """What holds the inner ring: of x, y, z, theta_x, theta_y which are `free`, their loads, and where others are held.

    `loads` [N, N m] (5,) act on the ring, `held` [m, rad] (5,) are coordinates; each counts where it applies.
    """

    free: tuple
    loads: tuple
    held: tuple


class Equilibrium(NamedTuple):
    """A bearing in balance: ring `coordinates` (5,), external `loads` (5,), `stiffness` (5, 5) of loads by coordinates.

    `azimuths` [rad] (N,), `places` (N, 2) of the balls, `contacts`; `left` [N] is missing of the ring's balance.
    Relative errors: `settled` of loads and angles, NaN in rolling, `apart` of loads if balls never repeat themselves.
    """

    coordinates: np.ndarray
    loads: np.ndarray
    stiffness: np.ndarray
    azimuths: np.ndarray
    places: np.ndarray
    contacts: Contacts
    left: float
    settled: float = math.nan
    apart: float = 0.0


def setting_of(parameters, law: str, speed: float, arm: str = "groove", control: str = "") -> Setting:
    """The numbers of the balance for a scene; `control` is a name of CONTROLS, "" for the scene's own."""
    bearing = bearing_of(rubbing_by(parameters, POINT), law)  # equilibria hold no friction
    lever, reach = bearing.inner.groove_radius, bearing.inner.locus_radius
    if arm == "pitch":
        lever, reach = bearing.ball_radius, 0.5 * parameters.geometry.pitch_diameter
    pitch = parameters.geometry.pitch_diameter
    sizes = bearing.ball_radius, bearing.ball_mass, pitch, reach, lever, float(speed)
    return Setting(bearing.inner, bearing.outer, *sizes, *CONTROLS[control or control_of(parameters)], 0.0)


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
            raise SceneError(self._refusal(support))
        return left

    def solve(self, support: Support) -> Equilibrium:
        """The equilibrium; raises SceneError as `settle` does."""
        left = self.settle(support)
        contacts = contacts_at(self.setting, self.directions, self.q, self.place)
        arrays = self.q.copy(), self.load.copy(), self.stiffness.copy(), self.azimuths, self.place[:, :2].copy()
        return Equilibrium(*arrays, contacts, left)

    @property
    def speed(self) -> float:
        """At which the inner ring turns [rad/s]."""
        return self.setting.speed

    def _at_rest(self) -> "EquilibriumSolver":
        return EquilibriumSolver(self.setting._replace(speed=0.0), self.azimuths, self.weights)

    def _too_fast(self, support: Support) -> str:
        """That the speed alone is too much for a load that is carried at rest, "" where it is not."""
        speed = self.speed
        if not (speed and self._at_rest()._tried(support, 1.0)[2]):
            return ""
        return (
            f"{_what_acts(support)} is carried at rest, but not at {speed:g} rad/s, which throws the balls outwards; "
            "lower the speed, or load the bearing more along its axis"
        )

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
        free = ", ".join(name for name, one in zip(COORDINATES, support.free, strict=True) if one)
        return f"no ball touches both rings, so that nothing holds {self.body} along {free}; {self.remedy}"

    def _refusal(self, support: Support) -> str:
        """Why there is no legal equilibrium, with the greatest share of loads and held coordinates there is.

        That a load is carried at rest is said first, for the greatest at such a speed takes long and tells less.
        """
        if sentence := self._too_fast(support):
            return sentence
        low, ratios = self._greatest(support)
        what = _what_acts(support)
        if low == 0.0:
            return f"{what} finds no contact that carries it; hold {self.body} in this direction, or turn the load"
        how = f"pushes {self.body} through the balls: a contact bears no more than 2 % of the ball's diameter"
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
        for i, (name, one) in enumerate(zip(COORDINATES, support.free, strict=True))
        if one and scaled[i, i] <= SOFT * greatest
    ]


def solver_of(parameters, law, ball_angle=0.0, arm="groove", control="") -> EquilibriumSolver:
    """The solver of a scene without gravity, ball 0 at `ball_angle` [rad]; see `setting_of`."""
    setting = setting_of(parameters, law, parameters.drive.speed, arm, control)
    return EquilibriumSolver(setting, azimuths_of(operating_geometry(parameters).balls, ball_angle))
