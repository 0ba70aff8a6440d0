"""Settled motion of balls that leave a raceway on their way: balls are moved until a turn is as the one before.

A ball without load has the axis and the angle with which it left the loaded zone, and takes them along to where it
enters that again. Sums of waves do not follow it there (`settled`), so that balls in one even cage are moved by their
equations of motion, with a ring that is held, or so light that it is in balance all the way: it moves as balls pass,
and friction resists that, too. Some ten turns of the cage are enough where balls come back as they went: what one
brings along is lost on its way through the loaded zone.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.names import POINT
from bearing_twin.errors import BearingTwinError, SceneError, Stopped
from bearing_twin.kinds.bearing.controls import SHARED
from bearing_twin.kinds.bearing.drive import SPEED, Change
from bearing_twin.kinds.bearing.parameters import rubbing_by
from bearing_twin.kinds.bearing.quasi_static.statics import azimuths_of, setting_of
from bearing_twin.kinds.bearing.quasi_static.surroundings import TAKEN
from bearing_twin.kinds.bearing.rings import (
    CENTRED,
    EVEN,
    FREE,
    FREE_RING,
    PRESCRIBED,
    InnerRing,
    Rings,
    RingSupport,
)
from bearing_twin.kinds.contract import late
from bearing_twin.report import Choice

STEPPER = "rodas4"
OUTPUTS = 64  # of every ball in a spacing, and one more a turn, so that no two balls are seen at one azimuth
LOOKS = 4096  # azimuths at which the motion is kept, or a few less: as many for every ball
TURNS = 25  # of the cage at most; 5 to 15 are enough
SAME = 5e-4  # of the greatest angle: what may differ from the turn before; less counts as balls bear less
TOLERANCE = 1e-5  # that steps are made by
BEARS = 2e-2  # of the greatest load
# Of all balls' masses: the mass of a ring that follows its loads, so little that it is in balance all the way. Of its
# critical damping: what its support damps.
RING_MASS, RING_DAMPING = 4.0, 0.02
RING = "inner_ring_offset", "inner_ring_tilt", "inner_ring_velocity", "inner_ring_tilt_rate"  # channels

_bearing_motion = late("bearing_twin.kinds.bearing.motion:BearingMotion")


class March(NamedTuple):
    """As `settled.Turn`, from balls that were moved: `motion` (M, 8) is place, its rates, spin and orbit speed.

    `loads` (M, 2) [N] are those of the contacts. `rings` (M/Z, 10) is where the ring is, and how fast it moves, while a
    ball goes to where the next of Z balls began, one row of a ring that is held. `given` is the speed [rad/s] and the
    `Support` under which all this is so. `table` is that of `turn_table`, `off` what equilibria with it are off the
    balls that were moved, over the greatest load; both None before they are found. `taken` is as of `settled.Turn`.
    """

    motion: np.ndarray
    loads: np.ndarray
    rings: np.ndarray
    given: tuple
    orbit: float
    why: str = ""
    ring: np.ndarray | None = None
    table: np.ndarray | None = None
    off: float | None = None
    taken: int = 0

    @property
    def ring_speed(self) -> float:
        """How fast the ring's centre moves as balls pass [m/s], root of the mean square."""
        return math.sqrt(float((self.rings[:, 5:8] ** 2).sum(axis=1).mean()))

    @property
    def looks(self) -> int:
        """The azimuths of its table: those at which it was kept."""
        return len(self.motion)

    def standing(self, _) -> np.ndarray:
        """How the ring stands and moves while a ball passes, rows (K, 10)."""
        return self.rings

    def inertia(self, _mass, _heavy, pushed_on: np.ndarray, _azimuths) -> np.ndarray:
        """That of a ball, radial and axial (K, 2) [N]: what resists all that pushes it (K, 3) [N]."""
        return -pushed_on[:, [0, 2]]

    def whole(self, azimuths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places, their rates [m/s] and spins (K, 7), and orbit speeds (K,), at these azimuths [rad] (K,)."""
        found = _at(azimuths, azimuths_of(len(self.motion), 0.0), self.motion)
        return found[:, :7], found[:, 7]


def _at(wanted, azimuths, rows, period: float = 2.0 * math.pi) -> np.ndarray:
    """Rows (K, ...) at wanted azimuths [rad], straight between those given at others."""
    columns = (np.interp(wanted, azimuths, column, period=period) for column in rows.T)
    return np.stack(list(columns), axis=1)


def marched(parameters, setting, support, found) -> March | None:
    """The motion that repeats itself under a ring held and loaded as `support` says, or its last turn and why not.

    Of balls with their weight, from the equilibrium `found` with axes of rolling. None where they cannot be moved.
    Raises Stopped.
    """
    if support.free not in FREE.values():
        return None
    balls = parameters.geometry.balls
    scene, a_ball, before = _moved(parameters, setting, support, found), LOOKS // balls, None
    azimuths, outputs = azimuths_of(a_ball * balls, 0.0), OUTPUTS * balls + 1
    why, moving = "no turn of the cage is as the one before", None
    try:
        moving = _bearing_motion(scene, Choice(_law_of(scene, setting), STEPPER, math.nan, "", ()))
        orbit = float(moving.first_outputs().cage_speed[0])
        for _ in range(TURNS):
            turn = 2.0 * math.pi / abs(orbit)
            out = moving.advance(np.linspace(0.0, turn, outputs + 1)[1:], turn)
            orbit = float(out.cage_speed.mean())
            angles = _angles(out, azimuths)
            if before is not None and np.abs(angles - before).max() <= SAME * np.abs(angles).max():
                why = ""
                break
            before = angles
    except Stopped:
        raise
    except BearingTwinError:
        return None
    finally:
        TAKEN.evaluations += moving.costs()["ball_rates"] if moving else 0
    rings = np.concatenate([getattr(out, name) for name in RING], axis=1)
    rings = _at(azimuths[:a_ball], out.orbit_angle[:, 0], rings, 2.0 * math.pi / balls)
    rings = rings if any(support.free) else rings[:1]
    seen = out.orbit_angle.ravel(), np.hstack([_rows(setting, out), out.normal_load.reshape(-1, 2)])
    motion, loads = np.split(_at(azimuths, *seen), [8], axis=1)
    return March(motion, loads, rings, (setting.speed, support), orbit, why)


def _law_of(scene, setting) -> str:
    """The law by which these are the numbers of the balance; raises SceneError where none is."""
    for name, law in LAWS.items():
        if law.fits == "point" and setting_of(scene, name, setting.speed)[:2] == setting[:2]:
            return name
    raise SceneError("no law of contacts gives these loads")


def _angles(out, azimuths) -> np.ndarray:
    """Contact angles over the azimuth, less where balls bear less than BEARS of the greatest load."""
    load, angle = out.normal_load.reshape(-1, 2), out.contact_angle.reshape(-1, 2)
    counts = np.minimum(load.min(axis=1) / (BEARS * load.max()), 1.0)
    return _at(azimuths, out.orbit_angle.ravel(), angle * counts[:, None])


def _rows(setting, out) -> np.ndarray:
    """Place, its rates, spin and orbit speed (K, 8) of all balls at all outputs."""
    x, y, z = out.position.reshape(-1, 3).T
    distance = np.hypot(x, y)
    cosine, sine = x / distance, y / distance

    def turned(vector):
        one, two, three = vector.reshape(-1, 3).T
        return cosine * one + sine * two, cosine * two - sine * one, three

    radial, along, axial = turned(out.velocity)
    place = distance - setting.outer.locus_radius, z
    return np.stack([*place, radial, axial, *turned(out.angular_velocity), along / distance], axis=1)


def _moved(parameters, setting, support, found):
    """The scene of balls in one even cage, the ring turning evenly, held and loaded as `support` says."""
    held, loads = (np.where(support.free, *one) for one in ((0.0, support.held), (support.loads, 0.0)))
    mass = RING_MASS * parameters.geometry.balls * setting.ball_mass
    masses = np.array([mass] * 3 + [mass * setting.arm**2] * 2)
    damping = RING_DAMPING * 2.0 * np.sqrt(np.abs(np.diag(found.stiffness)) * masses)
    loads[:3] -= mass * np.array(parameters.gravity) * support.free[:3]
    drive = replace(
        parameters.drive, kind=SPEED, speed=float(setting.speed), change=Change(),
        offset=tuple(held[:3].tolist()), tilt=tuple(held[3:].tolist()),
    )  # fmt: skip
    word = next(word for word, free in FREE.items() if free == support.free)
    inner = InnerRing(
        load=tuple(loads[:3].tolist()), moment=tuple(loads[3:].tolist()), free=word,
        mass=mass, inertia=(float(masses[3]), 0.0),
        support=RingSupport(damping=tuple(damping[:3].tolist()), tilt_damping=float(damping[3:].max())),
    )  # fmt: skip
    free = any(support.free)
    return replace(
        rubbing_by(parameters, POINT),
        drive=drive,
        rings=Rings(inner if free else InnerRing()),
        model=replace(parameters.model, dimension=FREE_RING if free else PRESCRIBED, control=SHARED),
        cage=replace(parameters.cage, kind=EVEN, guidance=CENTRED),
        initial=replace(parameters.initial, motion="rolling"),
        wanted=replace(parameters.wanted, tolerance=TOLERANCE),
    )
