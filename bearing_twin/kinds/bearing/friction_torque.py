"""Friction torque of a lubricated bearing in equilibrium, contact by contact, and estimates of catalogues."""

import math
from typing import NamedTuple

import numpy as np

from bearing_twin.base.errors import SceneError
from bearing_twin.contact.elasticity import ellipse, elliptic_e
from bearing_twin.kinds.bearing.geometry import moduli
from bearing_twin.kinds.bearing.lubricant import (
    GREASE,
    LEAST_FILM,
    boundary_dimensions,
    film_lubricant,
    film_numbers,
    films,
    inlet_factors,
    is_lubricated,
    lubricant_sentence,
    viscosity_of,
)
from bearing_twin.kinds.bearing.ratings import GREASE as GREASED
from bearing_twin.kinds.bearing.ratings import OIL_BATH, palmgren_torque

# SKF, Rolling bearings (2018): R_1, R_2, S_1, S_2 of deep groove series; R_1, R_2, R_3, S_1, S_2 of angular series 72
DEEP_GROOVE = {
    "60": (4.1e-7, 1.7, 3.73e-3, 14.6),
    "62": (3.9e-7, 1.7, 3.23e-3, 36.5),
    "63": (3.7e-7, 1.7, 2.84e-3, 92.8),
}
BE, AC = (4.33e-7, 2.02, 2.44e-12, 1.82e-2, 0.71), (3.58e-7, 3.64, 3.55e-12, 1.14e-2, 1.55)
STEEP_ANGLE = math.radians(32.5)  # between the angles of AC and BE, 25 and 40 degrees
UNKNOWN_SERIES = "SKF's factors are known of series 60, 62, 63 and 72: give geometry.designation"
TORQUE_NOTE = (
    "The torque is the sum over all contacts of rolling resistance of the films, hysteresis and slip. SKF's formula "
    "was fitted to whole bearings: compare the sum alone. Palmgren's formula neglects the starvation of films and is "
    "too high at light loads. Seals are in none of the three."
)


class FrictionTorque(NamedTuple):
    """Parts of the friction torque [N m]; thickness [m] and Lambda of the thinnest film of a loaded contact."""

    film: float
    hysteresis: float
    slip: float
    thickness: float
    ratio: float


class ContactLosses(NamedTuple):
    """Power [W] (..., N, 2, 3) of film, hysteresis and slip, thickness [m] and Lambda (..., N, 2); 0 where undriven."""

    power: np.ndarray
    thickness: np.ndarray
    ratio: np.ndarray


def contact_losses(parameters, contacts, speed) -> ContactLosses:
    """Losses by films, hysteresis and slip in each contact of equilibria, the ring turning at `speed` (...,) [rad/s].

    2 F u of a film, moments of hysteresis and differential slip times the roll of the ball, u/r, and 3/8 mu Q a E of a
    patch times its spin, E the complete elliptic integral of the second kind (where a ball both rolls and spins the sum
    is an upper bound). Balls without contact to the inner ring, which nothing drives, and bearings at rest have none.
    """
    radius, speed = 0.5 * parameters.geometry.ball_diameter, np.asarray(speed, float)[..., None]
    driven = (contacts.load.min(axis=-1) > 0.0) & (speed != 0.0)
    lubricant, shape = film_lubricant(parameters), contacts.load.shape
    losses = ContactLosses(np.zeros((*shape, 3)), np.zeros(shape), np.zeros(shape))
    orbit, roll, pitch = (values[driven] for values in (contacts.orbit, contacts.roll, contacts.pitch))
    inner = np.broadcast_to(speed, driven.shape)[driven]
    for side, modulus in enumerate(moduli(parameters.materials)):
        load, angle, small, large = (values[..., side][driven] for values in (
            contacts.load, contacts.angle, contacts.curvature_small, contacts.curvature_large
        ))  # fmt: skip
        cosine, sine = np.cos(angle), np.sin(angle)
        rolling = np.abs(roll * cosine + pitch * sine)  # of the ball about its axis of rolling
        ring = (inner if side == 0 else 0.0) - orbit
        spin = np.abs(pitch * cosine - (roll + ring) * sine)
        numbers = film_numbers(lubricant, small, large, modulus, radius)
        thickness, ratio, resistance, hysteresis, slip, friction = films(lubricant, numbers, load, radius * rolling).T
        major, minor, _ = ellipse(small, large, modulus, load)
        spin_moment = 0.375 * friction * load * major * elliptic_e(minor / major)
        parts = 2.0 * radius * resistance * rolling, hysteresis * rolling, slip * rolling + spin_moment * spin
        losses.power[..., side, :][driven] = np.stack(parts, axis=-1)
        losses.thickness[..., side][driven], losses.ratio[..., side][driven] = thickness, ratio
    return losses


def contact_torque(parameters, contacts) -> FrictionTorque | None:
    """The torque that films, hysteresis and slip of an equilibrium's contacts put on the inner ring; None at rest."""
    losses, speed = contact_losses(parameters, contacts, parameters.drive.speed), abs(parameters.drive.speed)
    driven = losses.thickness > 0.0
    if not driven.any():
        return None
    least = np.argmin(np.where(driven, losses.thickness, math.inf))
    thinnest = float(losses.thickness.flat[least]), float(losses.ratio.flat[least])
    return FrictionTorque(*(losses.power.sum(axis=(0, 1)) / speed).tolist(), *thinnest)


def skf_torque(parameters, static: float, force) -> float | None:
    """Friction torque [N m] of an open bearing by SKF (Rolling bearings, 2018); None for series not in the tables.

    M = phi_ish phi_rs G_rr (nu n)^0.6 + G_sl mu_sl [N mm; mm, N, 1/min, mm^2/s]; the forms of radial and of combined
    load do not meet at no axial load.

    Parameters
    ----------
    parameters : BearingScene
        Of a scene with a lubricant.
    static : float
        Basic static rating C_0 [N].
    force : sequence of float, (3,)
        Force [N] on the inner ring, z along the axis.
    """
    geometry, lubricant = parameters.geometry, parameters.lubricant
    pitch, turns = 0.5e3 * sum(boundary_dimensions(geometry)), abs(parameters.drive.speed) * 30.0 / math.pi
    viscosity = viscosity_of(lubricant, parameters.temperature)
    radial, axial = math.hypot(force[0], force[1]), abs(force[2])
    name, viscosity_speed = geometry.designation, 1e6 * viscosity * turns
    if name[:2] == "72" and geometry.contact_angle:
        r1, r2, r3, s1, s2 = BE if geometry.contact_angle > STEEP_ANGLE else AC
        pressed = radial + r3 * pitch**4 * turns**2
        rolling = r1 * pitch**1.97 * (pressed + r2 * axial) ** 0.54
        sliding = s1 * pitch**0.26 * (pressed ** (4.0 / 3.0) + s2 * axial ** (4.0 / 3.0))
    elif name[:2] in DEEP_GROOVE:
        r1, r2, s1, s2 = DEEP_GROOVE[name[:2]]
        rolling, sliding = r1 * pitch**1.96 * radial**0.54, s1 * pitch**-0.26 * radial ** (5.0 / 3.0)
        if axial > 1e-9 * radial:
            sine = math.sin(math.radians(24.6) * (axial / static) ** 0.24)
            rolling = r1 * pitch**1.96 * (radial + r2 * axial / sine) ** 0.54
            sliding = s1 * pitch**-0.145 * (radial**5 + s2 * pitch**1.5 * axial**4 / sine) ** (1.0 / 3.0)
    else:
        return None
    heating, starvation = inlet_factors(geometry, viscosity)
    inlet = 1.0 / (1.0 + heating * turns**1.28)
    if lubricant.kind == GREASE:
        inlet *= math.exp(-starvation * turns)
    boundary_share = math.exp(-2.6e-8 * viscosity_speed**1.4 * pitch)
    friction = boundary_share * lubricant.boundary_friction + (1.0 - boundary_share) * lubricant.film_friction
    return 1e-3 * (inlet * rolling * viscosity_speed**0.6 + sliding * friction)


def catalogue_torque(parameters, static: float, force, speed: float) -> float | None:
    """`palmgren_torque` with the lubricant of a scene, and its defaults without one."""
    if not is_lubricated(parameters):
        return palmgren_torque(parameters.geometry, static, force, speed)
    lubricant = parameters.lubricant
    viscosity = viscosity_of(lubricant, parameters.temperature)
    lubrication = GREASED if lubricant.kind == GREASE else OIL_BATH
    return palmgren_torque(parameters.geometry, static, force, speed, viscosity, lubrication)


def torque_answer(parameters, contacts, static: float, force) -> dict:
    """Friction in the results of an equilibrium: torque by parts, estimates, loss, film; {} without lubricant.

    Raises SceneError where the thinnest film is below LEAST_FILM of the roughness.
    """
    if not is_lubricated(parameters):
        return {}
    torque = contact_torque(parameters, contacts)
    if torque is None:
        return {"friction_torque_nm": None, "friction_loss_w": None, "film_m": None, "lambda": None}
    if torque.ratio < LEAST_FILM:
        raise SceneError(
            f"the thinnest film is {torque.ratio:.2g} of surface.roughness, and no formula of films holds below "
            f"{LEAST_FILM:g}; lower the load or temperature, raise the speed or the viscosity, or leave lubricant out"
        )
    speed = parameters.drive.speed
    total, skf = torque.film + torque.hysteresis + torque.slip, skf_torque(parameters, static, force)
    palmgren = catalogue_torque(parameters, static, force, speed)
    unknown = "" if skf is not None else f" {UNKNOWN_SERIES}."
    parts = {"film": torque.film, "hysteresis": torque.hysteresis, "slip": torque.slip, "total": total}
    return {
        "drive_torque_nm": total,
        "not_computed": {},
        "friction_torque_nm": {**parts, "skf": skf, "palmgren": palmgren},
        "friction_loss_w": total * abs(speed),
        "film_m": torque.thickness,
        "lambda": torque.ratio,
        "friction_note": f"{lubricant_sentence(parameters)} {TORQUE_NOTE}{unknown}",
    }
