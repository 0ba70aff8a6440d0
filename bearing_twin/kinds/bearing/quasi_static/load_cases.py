"""Equilibria of a bearing under many loads, for many values of its scene's keys, at once."""

from dataclasses import dataclass

import numpy as np

from bearing_twin.base.report import in_lines
from bearing_twin.contact.friction import AUTO
from bearing_twin.kinds.bearing.controls import CONTROLS, OUTER
from bearing_twin.kinds.bearing.outputs import moduli
from bearing_twin.kinds.bearing.quasi_static.ball_equilibrium import (
    FOUND,
    contacts_in,
    limits_used,
    solved_from_nothing,
)
from bearing_twin.kinds.bearing.quasi_static.equilibrium import azimuths_of, outer_controls, setting_of

AT_ONCE = 1000  # cases solved in one go: their arrays stay in the cache
SHARES = slice(33, 35)  # of the gyroscopic moment, among a setting's numbers
ASK = "`bearing_twin bearing` tells the greatest load in this direction"
REASONS = (  # by what the core says, and then by what of an equilibrium is beyond its limit
    "",
    "no ball touches both rings, so that nothing holds the ring; load it, or take less clearance",
    f"no balance is found: the load pushes the ring through the balls, or no contact carries it; {ASK}",
    "stopped",
    f"a contact is squeezed by more than 2 % of the ball's diameter; {ASK}",
    f"a contact angle is beyond what is modelled: the load tilts contacts out of the grooves; {ASK}",
)
SQUEEZED, LEANS = 4, 5


@dataclass(frozen=True, repr=False)
class Equilibria:
    """A ball bearing in equilibrium under loads of shape `...`; where it is not `converged`, numbers are NaN.

    Attributes
    ----------
    displacement : ndarray (..., 5)
        Of the inner ring: x, y, z [m], tilts about x and y [rad], in `bearing_link`: z along the axis.
    ball_azimuth : ndarray (..., N)
        Places of the balls about the axis [rad], from +x towards +y.
    ball_load, contact_angle : ndarray (..., N, 2)
        Normal load [N] and contact angle [rad] on the inner and the outer raceway; an angle is > 0 where the inner ring
        is pushed along +z, and counts where there is a load.
    stiffness : ndarray (..., 5, 5)
        Derivatives of the loads [N, N m] by the coordinates [m, rad], balls at their places.
    converged : ndarray (...) of bool
        Whether there is an equilibrium within the limits of the model.
    reason : ndarray (...) of str
        Why there is none; empty where there is one.
    """

    displacement: np.ndarray
    ball_azimuth: np.ndarray
    ball_load: np.ndarray
    contact_angle: np.ndarray
    stiffness: np.ndarray
    converged: np.ndarray
    reason: np.ndarray

    def __repr__(self) -> str:
        rows = {
            "displacement x, y, z [m]": self.displacement[..., :3],
            "tilts about x and y [rad]": self.displacement[..., 3:],
            "greatest ball load [N]": self.ball_load.max(axis=(-2, -1)),
            "stiffness along x, y, z [N/m]": np.diagonal(self.stiffness, axis1=-2, axis2=-1)[..., :3],
        }
        title = f"{self.converged.size} equilibria, {int(self.converged.sum())} of them found"
        return in_lines(title, {name: value.ravel().tolist() for name, value in rows.items()})


def azimuths_on(loads: np.ndarray) -> np.ndarray:
    """Azimuths [rad] (C,) of the loads (C, 5) across the axis: of the force, else of the moment, else 0."""
    force, moment = (np.arctan2(loads[:, i + 1], loads[:, i]) for i in (0, 3))
    return np.where(loads[:, :2].any(1), force, np.where(loads[:, 3:].any(1), moment, 0.0))


def solved_cases(scenes, laws, which, loads, tilting: bool, first) -> Equilibria:
    """Equilibria (C, ...) of the parameters `scenes[which]` under `loads` (C, 5), ball 0 at the azimuths `first` (C,).

    Tilts are free where `tilting`, else as the drive of each scene holds them.
    """
    settings = [setting_of(one, law, one.drive.speed) for one, law in zip(scenes, laws, strict=True)]
    seats = np.array([one.numbers() for one in settings])[:, None]
    held = np.array([(0.0, 0.0, 0.0, *one.drive.tilt) for one in scenes])
    e_star = np.array([moduli(one.materials) for one in scenes])
    auto = np.array([one.model.control == AUTO and bool(one.drive.speed) for one in scenes])
    radii = np.array([one.ball_radius for one in settings])[:, None]
    free = np.array([True] * 3 + [tilting] * 2)
    azimuths = azimuths_of(scenes[0].geometry.balls, first[:, None])
    parts = []
    for begin in range(0, len(loads), AT_ONCE):
        part = slice(begin, begin + AT_ONCE)
        of, given = which[part], (free, np.where(free, loads[part], 0.0), np.where(free, 0.0, held[which[part]]))
        numbers, balls = seats[of], (azimuths.shape[1],)
        found = solved_from_nothing(numbers, balls, azimuths[part], *given)
        again = auto[of] & (found.status == FOUND) & outer_controls(e_star[of], contacts_in(found.contacts))
        if again.any():
            numbers[again, :, SHARES] = CONTROLS[OUTER]
            better = solved_from_nothing(
                numbers[again], balls, azimuths[part][again], free, *(g[again] for g in given[1:])
            )
            for one, other in zip(found, better, strict=True):
                one[again] = other
        contacts = contacts_in(found.contacts)
        used = limits_used(radii[of], contacts.load, contacts.approach, contacts.angle)
        squeeze, angle = (one.max(-1) for one in used)
        status = found.status.copy()
        status[(status == FOUND) & (np.maximum(squeeze, angle) > 1.0)] = SQUEEZED
        status[(status == SQUEEZED) & (angle > squeeze)] = LEANS
        numbers = found.coordinates, contacts.load.copy(), contacts.angle.copy(), found.stiffness
        for one in numbers:
            one[status != FOUND] = np.nan
        parts.append((*numbers, status))
    displacement, load, angle, stiffness, status = (np.concatenate(one) for one in zip(*parts, strict=True))
    reason = np.array(REASONS, object)[status]
    return Equilibria(displacement, azimuths, load, angle, stiffness, status == FOUND, reason)
