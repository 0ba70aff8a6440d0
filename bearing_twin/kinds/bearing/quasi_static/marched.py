"""Settled motion of balls that leave a raceway on their way: balls are moved until a turn is as the one before.

A ball without load has the axis and the angle with which it left the loaded zone, and takes them along to where it
enters that again. Sums of waves do not follow it there (`settled`), so that balls in one even cage are moved round a
ring that is held, by their equations of motion. Some ten turns of the cage are enough: what a ball brings along is
lost on its way through the loaded zone.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bearing_twin.contact.laws import LAWS
from bearing_twin.contact.names import POINT
from bearing_twin.errors import BearingTwinError, Stopped
from bearing_twin.kinds.bearing.drive import SPEED, Change
from bearing_twin.kinds.bearing.parameters import rubbing_by
from bearing_twin.kinds.bearing.quasi_static.statics import azimuths_of, setting_of
from bearing_twin.kinds.bearing.rings import EVEN, PRESCRIBED, Rings
from bearing_twin.kinds.contract import late
from bearing_twin.report import Choice

STEPPER = "rodas4"
OUTPUTS = 64  # of every ball in a spacing, and one more a turn, so that no two balls are seen at one azimuth
LOOKS = 4096  # azimuths at which the motion is kept
TURNS = 60  # of the cage at most; 5 to 15 are enough
SAME = 1e-4  # of the greatest angle: what may differ from the turn before, of balls that bear BEARS
TOLERANCE = 1e-5  # that steps are made by
BEARS = 2e-2  # of the greatest load
KINEMATIC = 3  # turns in which a ball has the orbit speed

_bearing_motion = late("bearing_twin.kinds.bearing.motion:BearingMotion")


class March(NamedTuple):
    """As `settled.Turn`, from balls that were moved: `motion` (M, 8) is place, its rates, spin and orbit speed."""

    motion: np.ndarray
    orbit: float
    why: str = ""
    ring: np.ndarray | None = None

    def whole(self, azimuths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places, their rates [m/s] and spins (K, 7), and orbit speeds (K,), at these azimuths [rad] (K,)."""
        found = _at(azimuths, azimuths_of(len(self.motion), 0.0), self.motion)
        return found[:, :7], found[:, 7]

    def quicker(self, times: float) -> "March":
        """As if the ring turned so many times as fast."""
        motion = self.motion.copy()
        motion[:, 2:] *= times
        return self._replace(motion=motion, orbit=self.orbit * times)


def _at(wanted, azimuths, rows) -> np.ndarray:
    """Rows (K, ...) at wanted azimuths [rad], straight between those given at others."""
    columns = (np.interp(wanted, azimuths, column, period=2.0 * math.pi) for column in rows.T)
    return np.stack(list(columns), axis=1)


def marched(parameters, setting, coordinates):
    """The motion that repeats itself, the ring held at `coordinates` (5,), or None where none does.

    Of balls with their weight. Raises Stopped.
    """
    scene = _held(parameters, setting.speed, coordinates)
    law = next(name for name in LAWS if _is_of(scene, name, setting))
    azimuths, outputs = azimuths_of(LOOKS, 0.0), OUTPUTS * scene.geometry.balls + 1
    try:
        motion, before = _bearing_motion(scene, Choice(law, STEPPER, math.nan, "", ())), None
        orbit = float(np.mean(motion.first_outputs().cage_speed))
        for _ in range(TURNS):
            turn = 2.0 * math.pi / abs(orbit)
            out = motion.advance(np.linspace(0.0, turn, outputs + 1)[1:], turn)
            orbit = float(out.cage_speed.mean())
            angles = _angles(out, azimuths)
            if before is not None and np.abs(angles - before).max() <= SAME * np.abs(angles).max():
                return March(_at(azimuths, out.orbit_angle.ravel(), _rows(setting, out)), orbit)
            before = angles
    except Stopped:
        raise
    except BearingTwinError:
        return None
    return None


def _is_of(scene, law, setting) -> bool:
    try:
        found = setting_of(scene, law, setting.speed)
    except (BearingTwinError, KeyError, TypeError, ValueError):
        return False
    return found.inner == setting.inner and found.outer == setting.outer


def _angles(out, azimuths) -> np.ndarray:
    """Contact angles over the azimuth, 0 where balls bear next to nothing."""
    load, angle = out.normal_load.reshape(-1, 2), out.contact_angle.reshape(-1, 2)
    bears = load.min(axis=1) > BEARS * load.max()
    return _at(azimuths, out.orbit_angle.ravel(), angle * bears[:, None])


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


def _held(parameters, speed: float, coordinates):
    """The scene of balls in one even cage, the ring turning evenly and held at `coordinates` (5,)."""
    drive = replace(
        parameters.drive, kind=SPEED, speed=float(speed), change=Change(),
        offset=tuple(map(float, coordinates[:3])), tilt=tuple(map(float, coordinates[3:])),
    )  # fmt: skip
    return replace(
        rubbing_by(parameters, POINT),
        drive=drive,
        rings=Rings(),
        model=replace(parameters.model, dimension=PRESCRIBED, control="shared"),
        cage=replace(parameters.cage, kind=EVEN, guidance="centred"),
        initial=replace(parameters.initial, motion="rolling"),
        wanted=replace(parameters.wanted, tolerance=TOLERANCE),
    )
