"""Closed forms of an ellipsoid on a plane: instants of bounces, what a stiffer law does to them, rocking at rest."""

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from bearing_twin.contact.damping import steady_restitution
from bearing_twin.reference.impact import contact_time


def contact_delay(coefficient_ratio, duration):
    """By how much [s] each contact of `duration` [s] ends later when the law's coefficient is `coefficient_ratio` times.

    Contact time goes as c^(-2/5) (paper 3, eqs. 1, 2): for paper 1's volumetric law on a sphere 0.9953^(-2/5) - 1 =
    0.19 % of it, a bounce. Without loss nothing else differs: speeds, and so flights, stay the same.
    """
    return duration * (np.asarray(coefficient_ratio) ** -0.4 - 1.0)


def steady_contact_time(coefficient: float, mass: float, speed: float, ratio: float) -> float:
    """Contact time [s] with `steady_damped_load` at a damping ratio in [0, 1): the linear oscillator's, in real time.

    With s = (2/sqrt 5) h^(5/4) and d theta = k h^(1/4) dt, k^2 = 5c/(4m):  s'' + 2 z s' + s = 0. The load ends where
    s + 2 z s' = 0; the bodies then part freely at the speed e v until h = 0.
    """
    if ratio == 0.0:
        return float(contact_time(coefficient, mass, speed))
    k, damped = math.sqrt(1.25 * coefficient / mass), math.sqrt(1.0 - ratio * ratio)
    scale = 0.5 * math.sqrt(5.0) * speed / (k * damped)

    def height(theta):  # h^(5/4)
        return 0.5 * math.sqrt(5.0) * scale * math.exp(-ratio * theta) * math.sin(damped * theta)

    def pull(theta):
        return (1.0 - 2.0 * ratio * ratio) * math.sin(damped * theta) + 2.0 * ratio * damped * math.cos(damped * theta)

    end = brentq(pull, 0.25 * math.pi / damped, math.pi / damped, xtol=1e-15)
    # theta = x^(5/4) takes the root out of dt = d theta / (k h^(1/4)) at the touch
    loaded, _ = quad(lambda x: 1.25 * x**0.25 / (k * height(x**1.25) ** 0.2), 0.0, end**0.8, epsrel=1e-12)
    return loaded + height(end) ** 0.8 / (steady_restitution(ratio) * speed)


def impact_instants(count: int, fall: float, gravity: float, coefficient: float, mass: float, viscosity: float):
    """Instants [s] (count,) of the touches of a body that falls `fall` [m] and bounces with `steady_damped_load`.

    `viscosity` [N s/m^1.25] is the law's d: its ratio d/sqrt(5 m c), and with it the restitution e, change with the
    coefficient c. Flights last 2 e v/g; gravity within a contact is left out (of order g tau/v).
    """
    ratio = viscosity / math.sqrt(5.0 * mass * coefficient)
    e, speed = steady_restitution(ratio), math.sqrt(2.0 * gravity * fall)
    instants = [speed / gravity]
    while len(instants) < count:
        instants.append(instants[-1] + steady_contact_time(coefficient, mass, speed, ratio) + 2.0 * e * speed / gravity)
        speed *= e
    return np.array(instants)


def rocking_rate(semi_axes, gravity: float, rolling: bool) -> float:
    """Angular frequency [rad/s] of small rocking about x of an ellipsoid that rests on the end of its z axis.

    The height of the centre is c + (b^2 - c^2)/(2 c) angle^2. Without friction the centre stays over one point and only
    the moment of inertia m (b^2 + c^2)/5 resists; `rolling` without slip adds m c^2. Imaginary (a top) for b < c: NaN.
    """
    _, b, c = semi_axes
    restoring = gravity * (b * b - c * c) / c
    if restoring <= 0.0:
        return math.nan
    return math.sqrt(restoring / ((b * b + c * c) / 5.0 + (c * c if rolling else 0.0)))
