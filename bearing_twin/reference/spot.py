"""Friction over an elliptic Hertz spot that slides and spins, without smoothing, to many digits.

Coulomb's law on a body in plane motion: the slip at every point is spin x (r - pole), so its direction is the same
along each ray from the pole (the instantaneous centre of rotation). In polar coordinates about the pole, the spot
scaled to a unit disc, what is left of the integrals over Hertz's pressure is smooth.
"""

import math

import numpy as np

from bearing_twin.contact.patch_friction import Rubbing

ALONG_RAY = np.polynomial.legendre.leggauss(40)
ACROSS_RAYS = np.polynomial.legendre.leggauss(400)


def spot_friction_exact(
    normal_load, semi_major, semi_minor, slip_major, slip_minor, spin, coefficient, rays: int = 4000
) -> Rubbing:
    """Friction over the patch (`contact.patch_friction`) in the limit of no smoothing; `spin` [rad/s] must not be zero.

    Relative error below 1e-9 for b/a >= 0.03 with the pole anywhere: twice and four times the rays change less.
    """
    axes = np.array([semi_major, semi_minor])
    pole = np.array([-slip_minor, slip_major]) / (spin * axes)
    distance = math.hypot(*pole)
    if distance < 1.0:
        angle = 2.0 * math.pi * (np.arange(rays) + 0.5) / rays
        weight = np.full(rays, 2.0 * math.pi / rays)
    else:
        # Rays that meet the disc, spread so that the tangent ones at both ends do no harm.
        nodes, shares = ACROSS_RAYS
        turn = 0.5 * math.pi * nodes
        opening = np.arcsin(np.sin(turn) / distance)
        angle = math.atan2(pole[1], pole[0]) + math.pi + opening
        weight = 0.5 * math.pi * shares * np.cos(turn) / (distance * np.cos(opening))
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)

    # Along a ray: the pressure is sqrt(half^2 - (rho - middle)^2), rho = middle + half sin(t).
    middle = -ray @ pole
    half = np.sqrt(np.maximum(1.0 - (pole @ pole - middle**2), 0.0))
    start = np.arcsin(np.clip(-middle / np.maximum(half, 1e-300), -1.0, 1.0))
    nodes, shares = ALONG_RAY
    t = start[:, None] + 0.5 * (nodes + 1.0) * (0.5 * math.pi - start[:, None])
    rho = middle[:, None] + half[:, None] * np.sin(t)
    share = 0.5 * shares * (0.5 * math.pi - start[:, None]) * (half[:, None] * np.cos(t)) ** 2
    first, second = (share * rho).sum(axis=1) * weight, (share * rho**2).sum(axis=1) * weight

    along = ray * axes
    length = np.hypot(*along.T)
    direction = math.copysign(1.0, spin) * np.stack([-along[:, 1], along[:, 0]], axis=1) / length[:, None]
    x, y = pole * axes
    moment = (x * direction[:, 1] - y * direction[:, 0]) @ first + math.copysign(1.0, spin) * length @ second
    limit = -coefficient * normal_load * 1.5 / math.pi
    force = limit * direction.T @ first
    return Rubbing(float(force[0]), float(force[1]), float(limit * moment))
